"""What a key means: its comment in the section that declares it, its unit, range and default; all as a JSON Schema.

A field of a section is documented by the comment behind it, or by the comment lines above it; a `kind` by the
section's docstring. Nothing is written twice.
"""

from __future__ import annotations

import ast
import copy
import inspect
import io
import textwrap
import tokenize
from collections.abc import Iterator
from functools import cache
from typing import Any

from pydantic import BaseModel, RootModel

from archsim.config.load import SECTIONS, WALKTHROUGH_SECTIONS
from archsim.config.machine import MachineConfig
from archsim.config.run import RunConfig
from archsim.config.scene import SceneConfig
from archsim.config.sweep import SweepConfig
from archsim.config.walkthrough import WalkthroughConfig
from archsim.config.workload import WorkloadFile
from archsim.errors import did_you_mean, fail

PARTS: dict[str, type[BaseModel]] = {
    "run": RunConfig,
    "machine": MachineConfig,
    "scene": SceneConfig,
    "workload": WorkloadFile,
    "sweep": SweepConfig,
    "walkthrough": WalkthroughConfig,
}


def editor_schema(part: str) -> dict[str, Any]:
    """The JSON Schema of a file as people write it: `base` anywhere, what a base supplies left out."""
    if part not in PARTS:
        raise fail(f"no schema '{part}'", hint=did_you_mean(part, PARTS) or f"there are: {', '.join(PARTS)}")
    schema = copy.deepcopy(documented_schema(PARTS[part]))
    _loosen(schema)
    for name in {"run": SECTIONS, "walkthrough": WALKTHROUGH_SECTIONS}.get(part, ()):
        path = {"type": "string", "description": "Path of a file: short for {base: PATH}."}
        schema["properties"][name] = {"anyOf": [path, schema["properties"][name]]}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "$id": f"archsim-{part}"} | schema


@cache
def documented_schema(model: type[BaseModel]) -> dict[str, Any]:
    """pydantic's JSON Schema of a section with the meaning, unit and range of every key."""
    schema = model.model_json_schema()
    defs = schema.setdefault("$defs", {})
    for section in sections_below(model):
        target = schema if section is model else defs.get(section.__name__)
        if target is None:
            continue
        for name, text in field_comments(section).items():
            target["properties"][name]["description"] = text
            target["properties"][name] |= _limits(section, name)
    return schema


def sections_below(model: type[BaseModel]) -> list[type[BaseModel]]:
    """The section and all that can stand inside it."""
    found: list[type[BaseModel]] = []

    def visit(annotation: Any) -> None:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel) and annotation not in found:
            found.append(annotation)
            for field in annotation.model_fields.values():
                visit(field.annotation)
        for argument in getattr(annotation, "__args__", ()):
            visit(argument)

    visit(model)
    return found


@cache
def field_comments(section: type[BaseModel]) -> dict[str, str]:
    """Key -> its meaning, for the keys of a section that are documented."""
    meanings: dict[str, str] = {}
    for parent in reversed(section.__mro__):
        if issubclass(parent, BaseModel) and not issubclass(parent, RootModel) and parent is not BaseModel:
            meanings |= _comments(parent)
    if "kind" in section.model_fields:
        meanings["kind"] = inspect.cleandoc(section.__doc__ or "").split("\n")[0]
    return meanings


def _comments(section: type[BaseModel]) -> dict[str, str]:
    source = textwrap.dedent(inspect.getsource(section))
    (body,) = ast.parse(source).body
    assert isinstance(body, ast.ClassDef)
    comments = {
        token.start[0]: token.string.lstrip("# ").strip()
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    }
    own_lines = {
        number for number, line in enumerate(source.splitlines(), 1) if line.lstrip().startswith("#")
    }
    fields = [node for node in body.body if isinstance(node, ast.AnnAssign)]
    texts = {ast.unparse(node.target): " ".join(_beside(node, comments, own_lines)) for node in fields}
    return {name: text for name, text in texts.items() if text}


def _beside(node: ast.AnnAssign, comments: dict[int, str], own_lines: set[int]) -> Iterator[str]:
    """The comment lines directly above a field, then those behind it."""
    first = node.lineno
    while first - 1 in own_lines:
        first -= 1
    for line in range(first, (node.end_lineno or node.lineno) + 1):
        if line in comments:
            yield comments[line]


def _limits(section: type[BaseModel], name: str) -> dict[str, Any]:
    """Bounds that pydantic leaves out of the schema of quantities with units."""
    limits = {}
    for bound in section.model_fields[name].metadata:
        for key, word in (("ge", "minimum"), ("le", "maximum"), ("gt", "exclusiveMinimum")):
            if getattr(bound, key, None) is not None:
                limits[word] = getattr(bound, key)
    return limits


def _loosen(schema: Any) -> None:
    """Let every mapping take its keys from a base, and a component be told from any of its keys."""
    if isinstance(schema, list):
        for item in schema:
            _loosen(item)
    if not isinstance(schema, dict):
        return
    if "oneOf" in schema:
        schema["anyOf"] = schema.pop("oneOf")
        schema.pop("discriminator", None)
    for value in schema.values():
        _loosen(value)
    if schema.get("type") == "object" and "properties" in schema:
        schema.pop("required", None)
        schema["properties"]["base"] = {
            "type": "string",
            "description": "A file whose keys this mapping takes over.",
        }
