"""YAML text -> a tree of values that remembers where every key and value is written.

The scalars are those of YAML 1.2 (`1e9` is a number, `yes` is text). Anchors and aliases work; tags, merge
keys and several documents in one file do not. Files come from anywhere, so size and depth are limited.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import yaml

from archsim.errors import ArchsimError, Location, Problem, fail

MAX_BYTES = 256 * 1024  # of one file
MAX_NODES = 20_000  # of one document, aliases followed
MAX_DEPTH = 24  # mappings and lists inside each other
_MAX_DIGITS = 100

Scalar = str | int | float | bool | None

_TAG = "tag:yaml.org,2002:"
_CORE_SCHEMA = [
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]+", list("-+0123456789")),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", list("-+.0123456789")),
    ("float", r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", list("-+.")),
]


@dataclass(frozen=True, slots=True)
class Node:
    """A value, where it is written, and what relative paths in it start from."""

    value: Scalar | dict[str, Node] | list[Node]
    where: Location
    key: Location | None = None  # where the key in front of the value is written
    folder: Path = Path()
    fresh: bool = False  # replaces what it is merged over: it names a base of its own

    @property
    def place(self) -> Location:
        """Where a person looks for this value first: at its key."""
        return self.key or self.where

    def plain(self) -> object:
        """The value without its places."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value


def read_document(path: Path, shown: str) -> Node:
    """The tree of a YAML file, called `shown` in errors. Raises ArchsimError with all problems found."""
    where = Location(shown)
    try:
        if not path.is_file():
            raise fail("a folder or device, not a file" if path.exists() else "no such file", where)
        with path.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        raise fail(f"can't be read: {getattr(error, 'strerror', None) or error}", where) from None
    if len(raw) > MAX_BYTES:
        raise fail(f"larger than {MAX_BYTES // 1024} KiB, too large for a configuration", where)

    text = _decode(raw, shown)
    node = parse(text, lambda mark: Location(shown, mark.line + 1, mark.column + 1), path.resolve().parent)
    if node.value is None:
        raise fail("the file is empty", where)
    return node


def parse(text: str, locate: Callable[[yaml.Mark], Location], folder: Path) -> Node:
    """The tree of a YAML text. `locate` turns positions into Locations, `folder` goes to the nodes."""
    try:
        composer = _Composer(text)
        root = composer.get_single_node()
    except yaml.reader.ReaderError as error:
        what = f"the character U+{ord(text[error.position]):04X} is not allowed"
        raise fail(what, locate(_mark(text, error.position))) from None
    except (ValueError, OverflowError) as error:  # from escapes that are not characters
        raise fail(f"not valid YAML: {error}", locate(_mark(text, 0))) from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark or _mark(text, 0)
        raise fail(_in_plain_words(error), locate(mark)) from None
    if root is None:
        return Node(None, locate(_mark(text, 0)), None, folder)

    builder = _Builder(locate, folder)
    tree = builder.build(root, 0)
    if builder.problems:
        raise ArchsimError(builder.problems)
    return tree


def dump(data: object) -> str:
    """YAML text that `parse` reads back to the same data; lists of scalars stand on one line."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, width=110, allow_unicode=True)


def _resolvers() -> dict[str, list[tuple[str, re.Pattern[str]]]]:
    """PyYAML's table of first character -> (tag, pattern of the whole scalar)."""
    table: dict[str, list[tuple[str, re.Pattern[str]]]] = {}
    for name, pattern, first_characters in _CORE_SCHEMA:
        for character in first_characters:
            table.setdefault(character, []).append((_TAG + name, re.compile(f"^(?:{pattern})$")))
    return table


class _Composer(yaml.SafeLoader):
    """PyYAML's composer with YAML 1.2 scalars and a limit on depth."""

    yaml_implicit_resolvers = _resolvers()
    depth = 0

    def compose_node(self, parent, index):
        if self.depth > MAX_DEPTH:
            mark = self.peek_event().start_mark
            raise yaml.MarkedYAMLError(problem=f"more than {MAX_DEPTH} levels deep", problem_mark=mark)
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node


class _Dumper(yaml.SafeDumper):
    """PyYAML's writer with YAML 1.2 scalars: quotes what `parse` would not read as text."""

    yaml_implicit_resolvers = _resolvers()

    def represent_list(self, data):
        scalars = not any(isinstance(item, dict | list | tuple) for item in data)
        return self.represent_sequence(_TAG + "seq", data, flow_style=scalars)

    def ignore_aliases(self, data):
        return True


_Dumper.add_representer(list, _Dumper.represent_list)
_Dumper.add_representer(tuple, _Dumper.represent_list)


class _Builder:
    """Turns PyYAML's nodes into ours and collects what is wrong with them."""

    def __init__(self, locate: Callable[[yaml.Mark], Location], folder: Path):
        self.locate = locate
        self.folder = folder
        self.problems: list[Problem] = []
        self.num_nodes = 0

    def build(self, node: yaml.Node, depth: int, key: Location | None = None) -> Node:
        where = self.locate(node.start_mark)
        self.num_nodes += 1
        if self.num_nodes > MAX_NODES:
            raise fail(f"more than {MAX_NODES} values in one document", where)
        if depth > MAX_DEPTH:
            raise fail(f"more than {MAX_DEPTH} levels deep", where)

        if isinstance(node, yaml.CollectionNode) and node.tag not in (_TAG + "map", _TAG + "seq"):
            self.problems.append(Problem(where, f"the tag '{node.tag[:60]}' is not supported"))
        if isinstance(node, yaml.MappingNode):
            return Node(self._mapping(node, depth), where, key, self.folder)
        if isinstance(node, yaml.SequenceNode):
            items = [self.build(item, depth + 1) for item in node.value]
            return Node(items, where, key, self.folder)
        assert isinstance(node, yaml.ScalarNode)
        return Node(self._scalar(node, where), where, key, self.folder)

    def _mapping(self, node: yaml.MappingNode, depth: int) -> dict[str, Node]:
        found: dict[str, Node] = {}
        for key_node, value_node in node.value:
            where = self.locate(key_node.start_mark)
            key = key_node.value
            if key_node.tag != _TAG + "str":
                shown = f"'{key}'" if isinstance(key, str) else "a list or mapping"
                self.problems.append(Problem(where, f"a key must be text, not {shown}", _quote_hint(key)))
            elif key in found:
                first = found[key].place
                self.problems.append(Problem(where, f"the key '{key}' is written twice", f"first at {first}"))
            else:
                found[key] = self.build(value_node, depth + 1, where)
        return found

    def _scalar(self, node: yaml.ScalarNode, where: Location) -> Scalar:
        kind = node.tag.removeprefix(_TAG)
        text = node.value
        if kind in ("int", "float") and len(text) > _MAX_DIGITS:
            self.problems.append(Problem(where, f"a number of {len(text)} characters is too long"))
            return None
        if kind in ("null", "bool", "int", "float") and node.style is None and self._plain(kind, text):
            return _SCALARS[kind](text)
        if kind != "str":
            self.problems.append(Problem(where, f"the tag '{node.tag[:60]}' is not supported"))
        if any("\ud800" <= character <= "\udfff" for character in text):
            self.problems.append(Problem(where, "text with half a surrogate pair"))
        return text

    @staticmethod
    def _plain(kind: str, text: str) -> bool:
        """False where an explicit tag claims a kind that the text is not of (`!!int abc`)."""
        candidates = _Composer.yaml_implicit_resolvers.get(text[:1], [])
        return any(tag == _TAG + kind and pattern.match(text) for tag, pattern in candidates)


_SCALARS: dict[str, Callable[[str], Scalar]] = {
    "null": lambda text: None,
    "bool": lambda text: text.lower() == "true",
    "int": int,
    "float": lambda text: float(re.sub(r"\.(inf|nan)", r"\1", text.lower())),
}


def _quote_hint(key: object) -> str | None:
    return f'write "{key}" in quotes' if isinstance(key, str) and key else None


def _mark(text: str, position: int) -> yaml.Mark:
    """The mark of a position in the text."""
    line = text.count("\n", 0, position)
    column = position - (text.rfind("\n", 0, position) + 1)
    return yaml.Mark("", position, line, column, None, 0)


def _decode(raw: bytes, shown: str) -> str:
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = raw[: error.start].decode("utf-8", "replace")
        mark = _mark(before, len(before))
        where = Location(shown, mark.line + 1, mark.column + 1)
        raise fail(f"not UTF-8 text: byte 0x{raw[error.start]:02x}", where) from None


def _in_plain_words(error: yaml.MarkedYAMLError) -> str:
    """PyYAML's message, without its jargon where people meet it most."""
    problem = str(error.problem)
    if "'\\t'" in problem:
        return "a tab can't be used here; indent with spaces"
    if "mapping values are not allowed" in problem:
        return "a ':' is not allowed here; check the indentation, or quote the text"
    if "single document" in str(error.context):
        return "a second document starts here; write one file for each"
    if "levels deep" in problem:
        return problem
    problem = problem.replace("<", "").replace(">", "")
    return f"not valid YAML: {error.context + ': ' if error.context else ''}{problem}"
