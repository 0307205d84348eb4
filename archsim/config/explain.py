"""Who set each value of a configuration; and one key of a run explained: its value here, and what it may be."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel

from archsim.config.documentation import documented_schema, field_comments
from archsim.config.load import Loaded, LoadedRun, load_plain
from archsim.errors import Location, did_you_mean, fail


class Explained(NamedTuple):
    """What is known of a key."""

    path: str
    value: str  # as people write it; the keys of a mapping
    meaning: str
    unit: str | None
    default: str
    where: Location | None  # where the value is written; None for a default
    accepted: str  # type, range or choices


class Origin(NamedTuple):
    """A value of a configuration and who set it."""

    key: str  # dotted path
    value: str
    place: str  # file:line:column, --set ..., the default


def origins(loaded: Loaded[Any]) -> list[Origin]:
    """Every value of a run, machine or walkthrough, in the order of the file."""
    values = flat(loaded.config.model_dump(mode="json"))
    return [Origin(key, _shown(value), str(loaded.origin(key) or "the default")) for key, value in values]


def file_origins(path: Path) -> list[Origin]:
    """Every value of a file that is of no kind that is checked."""
    content, places = load_plain(path)
    return [Origin(key, _shown(value), str(places[key])) for key, value in flat(content)]


def flat(tree: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """(dotted path, value) of every scalar and of every list of scalars in a tree."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from flat(value, f"{path}.{key}" if path else key)
    elif isinstance(tree, list) and any(isinstance(item, dict | list) for item in tree):
        for index, value in enumerate(tree):
            yield from flat(value, f"{path}.{index}")
    else:
        yield path, tree


class _Place(NamedTuple):
    """A value on the way down: its plain form, its section if it is one, and the schema of its key."""

    plain: Any
    section: Any
    schema: dict[str, Any]
    meaning: str


def explain(run: LoadedRun, path: str) -> Explained:
    """The key at a dotted path. ArchsimError if there is none."""
    config = run.config
    place = _Place(config.model_dump(), config, {"type": "object"}, "everything that a run depends on")
    walked: list[str] = []
    for part in path.split("."):
        place = _step(place, part, walked)
        walked.append(part)
    schema = place.schema
    return Explained(
        path,
        ", ".join(place.plain) if isinstance(place.plain, dict) else _shown(place.plain),
        place.meaning,
        schema.get("unit") or schema.get("prefixItems", [{}])[0].get("unit"),
        _shown(schema["default"]) if "default" in schema else "none: it must be given",
        run.origin(path),
        _accepted(schema),
    )


def _step(place: _Place, part: str, walked: list[str]) -> _Place:
    """One key or index further down."""
    keys = list(place.plain) if isinstance(place.plain, dict) else []
    if isinstance(place.plain, list | tuple):
        keys = [str(index) for index in range(len(place.plain))]
    if part not in keys:
        above = ".".join(walked)
        what = f"no key '{part}' in '{above}'" if above else f"no key '{part}'"
        raise fail(what, hint=did_you_mean(part, keys) or _there_are(keys))

    if isinstance(place.plain, list | tuple):
        index = int(part)
        items = place.schema.get("prefixItems")
        schema = items[index] if items else place.schema.get("items", {})
        return _Place(place.plain[index], place.section[index], schema, place.meaning)
    if isinstance(place.section, BaseModel):
        owner = type(place.section)
        schema = documented_schema(owner)["properties"][part]
        return _Place(
            place.plain[part], getattr(place.section, part), schema, field_comments(owner).get(part, "")
        )
    section = place.section[part]
    patterns = list(place.schema.get("patternProperties", {}).values())
    if isinstance(section, BaseModel):
        return _Place(place.plain[part], section, {"type": "object"}, _docstring(section))
    return _Place(place.plain[part], section, patterns[0] if patterns else {}, place.meaning)


def _docstring(section: BaseModel) -> str:
    return (type(section).__doc__ or "").split("\n")[0]


def _accepted(schema: dict[str, Any]) -> str:
    """Type, range and choices in words."""
    if "enum" in schema:
        return " or ".join(_shown(choice) for choice in schema["enum"])
    if "const" in schema:
        return _shown(schema["const"])
    if "prefixItems" in schema:
        return f"a list of {len(schema['prefixItems'])}, each {_accepted(schema['prefixItems'][0])}"
    if "anyOf" in schema:
        return " or ".join(dict.fromkeys(_accepted(choice) for choice in schema["anyOf"]))
    kind = schema.get("type", "object")
    word = _TYPES.get("number" if isinstance(kind, list) else kind, "a mapping")
    if schema.get("examples"):
        word = f"a quantity such as {schema['examples'][0]}"
    return word + _range(schema)


def _range(schema: dict[str, Any]) -> str:
    low, high = schema.get("minimum"), schema.get("maximum")
    above = schema.get("exclusiveMinimum")
    if low is None and high is None and above is None:
        return ""
    start = f" above {above:g}" if above is not None else f" from {_amount(low)}" if low is not None else ""
    return start + (f" to {_amount(high)}" if high is not None else "")


def _amount(number: float) -> str:
    return f"{number:,}" if isinstance(number, int) else f"{number:g}"


_TYPES = {
    "integer": "a whole number",
    "number": "a number",
    "string": "text",
    "boolean": "true or false",
    "array": "a list",
    "null": "null",
}


def _shown(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, list | tuple):
        return f"[{', '.join(_shown(item) for item in value)}]"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _there_are(keys: list[str]) -> str:
    return f"there are: {', '.join(keys)}" if keys else "it holds no keys"
