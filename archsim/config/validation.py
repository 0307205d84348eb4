"""A tree of values -> a section, with every problem in plain words at the place where it is written."""

from __future__ import annotations

import re
import types
from collections.abc import Callable, Iterable, Iterator
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, RootModel, ValidationError

from archsim.config.document import Node
from archsim.config.section import SHAPES, Finding, FindingsError
from archsim.errors import Location, Problem, did_you_mean

Model = TypeVar("Model", bound=BaseModel)
KeyPath = tuple[str | int, ...]


def validate(model: type[Model], tree: Node) -> tuple[Model | None, list[Problem]]:
    """The section that a tree describes, or None and all problems in the order of the text."""
    try:
        return model.model_validate(tree.plain()), []
    except ValidationError as error:
        problems = [problem for each in error.errors() for problem in _problems(model, tree, each)]
        return None, in_order(problems)


def node_at(tree: Node, path: KeyPath) -> tuple[Node, bool]:
    """The innermost node on a path of keys and indices, and whether that is the path's end."""
    node = tree
    for part in path:
        children = node.value
        if isinstance(children, dict) and part in children:
            node = children[str(part)]
        elif isinstance(children, list) and isinstance(part, int) and part < len(children):
            node = children[part]
        else:
            return node, False
    return node, True


def in_order(problems: Iterable[Problem]) -> list[Problem]:
    """The problems by file, line and column, each once."""
    return sorted(dict.fromkeys(problems), key=lambda problem: problem.where or Location(""))


def _problems(model: type[BaseModel], tree: Node, error: Any) -> Iterator[Problem]:
    """The problems in one of pydantic's errors."""
    kind, context = error["type"], error.get("ctx", {})
    path = _key_path(tree, error)
    node, _ = node_at(tree, path)

    if kind == "extra_forbidden":
        hint = did_you_mean(str(path[-1]), _known_keys(model, error["loc"]))
        yield Problem(node.place, f"unknown key '{_dotted(path)}'", hint)
    elif kind == "missing":
        yield _missing(node, path)
    elif kind == "union_tag_not_found":
        yield _unknown_kind(model, node, error["loc"], path)
    elif kind == "too_short" and len(error["input"]) >= context["min_length"]:
        pass  # pydantic counts the valid items; the others have problems of their own
    elif isinstance(context.get("error"), FindingsError):
        yield from (_problem_of(finding, tree, path) for finding in context["error"].findings)
    elif kind == "archsim":
        yield Problem(node.where, f"{_dotted(path)}: {context['what']}", context.get("hint"))
    else:
        what = _WORDS.get(kind, _unforeseen)(error)
        where = node.place if error["loc"][-1:] == ("[key]",) else node.where
        yield Problem(where, f"{_dotted(path)}: {what}", _hint(error))


def _problem_of(finding: Finding, tree: Node, path: KeyPath) -> Problem:
    """The problem in what the check of the section at a path has found."""
    full = (*path, *finding.path)
    node, _ = node_at(tree, full)
    where = node.place if isinstance(node.value, dict) else node.where
    return Problem(where, f"{_dotted(full)}: {finding.what}", finding.hint)


def _key_path(tree: Node, error: Any) -> KeyPath:
    """The keys and indices in pydantic's `loc`, which has tags like <CacheConfig> and [key] among them."""
    path: KeyPath = ()
    *before, last = error["loc"] or ("",)
    for part in before:
        if not str(part).startswith("<") or node_at(tree, (*path, part))[1]:
            path = (*path, part)
    if not error["loc"] or (last == "[key]" and error["type"] != "extra_forbidden"):
        return path
    is_tag = str(last).startswith("<") and error["type"] != "extra_forbidden"
    return path if is_tag and not node_at(tree, (*path, last))[1] else (*path, last)


def _dotted(path: KeyPath) -> str:
    parts = [str(part) if str(part).isprintable() else ascii(part) for part in path]
    return ".".join(part if len(part) <= 100 else part[:97] + "..." for part in parts) or "the file"


def _missing(node: Node, path: KeyPath) -> Problem:
    """The problem of a mapping or list that ends before the path does."""
    if isinstance(path[-1], int):
        return Problem(node.where, f"{_dotted(path[:-1])}: too short a list")
    return Problem(node.place, f"missing key '{_dotted(path)}'")


def _unknown_kind(model: type[BaseModel], node: Node, loc: KeyPath, path: KeyPath) -> Problem:
    """The problem of a component that can't be told from its `kind`."""
    if not isinstance(node.value, dict):
        return Problem(node.where, f"{_dotted(path)}: must be a mapping of keys, not {_shown(node.plain())}")
    if "kind" not in node.value:
        return Problem(node.place, f"missing key '{_dotted((*path, 'kind'))}'")
    kind = node.value["kind"]
    kinds = list(dict.fromkeys(name for section in _sections_at(model, loc) for name in _kinds(section)))
    hint = did_you_mean(str(kind.value), kinds) or f"kinds are {', '.join(kinds)}"
    return Problem(
        kind.where, f"{_dotted((*path, 'kind'))}: must be a known kind, not {_shown(kind.plain())}", hint
    )


def _kinds(section: type[BaseModel]) -> tuple[str, ...]:
    field = section.model_fields.get("kind")
    return get_args(field.annotation) if field else ()


def _known_keys(model: type[BaseModel], loc: KeyPath) -> list[str]:
    """The keys of the section that pydantic's `loc`, less its last part, leads to."""
    return [key for section in _sections_at(model, loc[:-1]) for key in section.model_fields]


def _sections_at(model: type[BaseModel], loc: KeyPath) -> list[type[BaseModel]]:
    """The sections that may stand at pydantic's `loc`."""
    root: Any = model.model_fields["root"].annotation if issubclass(model, RootModel) else model
    annotations: list[Any] = _alternatives(root)
    for part in loc:
        annotations = [each for annotation in annotations for each in _step(annotation, part)]
    return [each for each in annotations if isinstance(each, type) and issubclass(each, BaseModel)]


def _step(annotation: Any, part: str | int) -> list[Any]:
    """The types of what is under a key, index or tag of a value of this type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        field = annotation.model_fields.get(str(part))
        tag = [annotation] if part == f"<{annotation.__name__}>" else []
        return _alternatives(field.annotation) if field else tag
    if get_origin(annotation) is dict:
        return _alternatives(get_args(annotation)[1])
    if get_origin(annotation) is tuple:
        return _alternatives(get_args(annotation)[0])
    return []


def _alternatives(annotation: Any) -> list[Any]:
    """The types that a type stands for: without its annotations, and one by one if it is a union."""
    if get_origin(annotation) is Annotated:
        return _alternatives(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return [each for part in get_args(annotation) for each in _alternatives(part)]
    return [annotation]


def _hint(error: Any) -> str | None:
    if error["type"] != "literal_error":
        return None
    choices = re.findall(r"'([^']*)'", error["ctx"]["expected"])
    return did_you_mean(str(error["input"]), choices)


def _shown(value: object) -> str:
    """A value as a person wrote it, shortened."""
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return "a list"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    text = str(value)
    text = text if len(text) <= 40 else text[:37] + "..."
    return f"'{text}'" if isinstance(value, str) else text


def _short(limit: int | float) -> str:
    return f"{limit:g}" if isinstance(limit, float) else str(limit)


def _must_be(what: str) -> Callable[[Any], str]:
    return lambda error: f"must be {what}, not {_shown(error['input'])}"


def _limit(what: str, key: str) -> Callable[[Any], str]:
    return lambda error: f"must be {what} {_short(error['ctx'][key])}, not {_shown(error['input'])}"


def _pattern(error: Any) -> str:
    return f"must be {SHAPES[error['ctx']['pattern']]}, not {_shown(error['input'])}"


def _literal(error: Any) -> str:
    choices = error["ctx"]["expected"].replace("'", "")
    return f"must be {choices}, not {_shown(error['input'])}"


def _length(word: str, key: str) -> Callable[[Any], str]:
    return lambda error: f"must have at {word} {error['ctx'][key]} in it, not {len(error['input'])}"


def _unforeseen(error: Any) -> str:
    return str(error["msg"])


# What pydantic's error types mean, in the words of somebody who writes YAML.
_WORDS: dict[str, Callable[[Any], str]] = {
    "int_type": _must_be("a whole number"),
    "float_type": _must_be("a number"),
    "finite_number": _must_be("a finite number"),
    "bool_type": _must_be("true or false"),
    "string_type": _must_be("text"),
    "tuple_type": _must_be("a list"),
    "dict_type": _must_be("a mapping of keys"),
    "model_type": _must_be("a mapping of keys"),
    "greater_than": _limit("above", "gt"),
    "greater_than_equal": _limit("at least", "ge"),
    "less_than": _limit("below", "lt"),
    "less_than_equal": _limit("at most", "le"),
    "too_short": _length("least", "min_length"),
    "too_long": _length("most", "max_length"),
    "string_pattern_mismatch": _pattern,
    "literal_error": _literal,
}
