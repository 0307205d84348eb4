"""`base: PATH` in any mapping, and `--set dotted.path=value`: from the files that people write to one tree.

A mapping's keys are merged over those of its base: mappings merge key by key, lists and scalars replace. A
mapping that names a base of its own starts afresh: nothing of what it is merged over remains.
"""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from archsim import resources
from archsim.config.document import MAX_NODES, Node, parse, read_document
from archsim.errors import ArchsimError, Location, Problem, fail

MAX_BASES = 8  # files that inherit from each other in a row


def load_tree(path: str | Path, overrides: Iterable[str], sections: Sequence[str] = ()) -> Node:
    """The tree of a file with all bases merged in and all overrides applied.

    `sections` are the keys of the outermost mapping where a plain string is short for `{base: string}`.
    Raises ArchsimError with the problems of all files; overrides stop at the first.
    """
    found = find_file(str(path), Path.cwd())
    if found is None:
        raise ArchsimError(_missing_file(str(path), Path.cwd(), None))

    resolver = _Resolver()
    tree = resolver.load(found, (), sections)
    if resolver.problems:
        raise ArchsimError(resolver.problems)
    for override in overrides:
        tree = resolver.override(tree, override, sections)
    return tree


def find_file(text: str, folder: Path) -> Path | None:
    """The file a path names, seen from a folder or else from the packaged configurations."""
    candidates = (folder / Path(text).expanduser(), resources.root() / "configs" / text)
    return next((path for path in candidates if is_file(path)), None)


def similar_file(text: str, folder: Path) -> str | None:
    """A hint with the file that may have been meant by a path that leads nowhere."""
    wanted = Path(text).expanduser()
    configs = resources.root() / "configs"
    known = [wanted.parent / name for name in _names((folder / wanted).parent)]
    if wanted.suffix in (".yaml", ".yml", ""):
        known += [path.relative_to(configs) for path in sorted(configs.glob("*/*.yaml"))]

    known = [path for path in known if path != wanted]
    near = difflib.get_close_matches(wanted.stem, {path.stem for path in known}, n=1)
    fitting = [path for path in known if path.stem in near]
    same_folder = [path for path in fitting if path.parent == wanted.parent]
    return f"did you mean '{(same_folder or fitting)[0]}'?" if fitting else None


class _Resolver:
    """Follows bases; collects what is wrong with them and counts values so that it always ends soon."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self.documents: dict[Path, Node] = {}
        self.num_nodes = 0

    def load(self, path: Path, chain: tuple[Path, ...], sections: Sequence[str]) -> Node:
        """The tree of a whole file. `chain` lists the files that led here."""
        if path not in self.documents:
            self.documents[path] = read_document(path, _shown(path))
        tree = self.documents[path]
        if isinstance(tree.value, dict):
            written = {key: _expand(node) if key in sections else node for key, node in tree.value.items()}
            tree = replace(tree, value=written)
        return self.resolve(tree, (*chain, path.resolve()), sections)

    def resolve(self, node: Node, chain: tuple[Path, ...], sections: Sequence[str] = ()) -> Node:
        """The node with the bases of all mappings in it merged in; its own base's file has the `sections`."""
        self.num_nodes += 1
        if self.num_nodes > MAX_NODES:
            raise fail(f"more than {MAX_NODES} values, bases included", node.where)
        if isinstance(node.value, list):
            return replace(node, value=[self.resolve(item, chain) for item in node.value])
        if not isinstance(node.value, dict):
            return node

        written = {key: self.resolve(child, chain) for key, child in node.value.items() if key != "base"}
        over = replace(node, value=written)
        if "base" not in node.value:
            return over
        base = self.load_base(node.value["base"], chain, sections)
        return replace(_merge(base, over) if base else over, fresh=True)

    def load_base(self, base: Node, chain: tuple[Path, ...], sections: Sequence[str]) -> Node | None:
        """The tree of the file that `base` names, or None after noting what is wrong."""
        try:
            tree = self.load(_base_file(base, chain), chain, sections)
            if not isinstance(tree.value, dict):
                raise fail(f"'{base.value}' holds no keys, so it can't be a base", base.where)
            return tree
        except ArchsimError as error:
            self.problems += error.problems
            return None

    def override(self, tree: Node, text: str, sections: Sequence[str]) -> Node:
        """The tree with the value of `dotted.path=value` put in its place."""
        where = Location(f"--set {text}")
        dotted, equals, written = text.partition("=")
        keys = dotted.strip().split(".")
        if not equals or not all(keys):
            raise fail("an override is written dotted.path=value", where)
        if not written.strip():
            raise fail("no value after '='", where, "write null for nothing")

        value = parse(written, lambda mark: where, Path.cwd())
        if len(keys) == 1 and keys[0] in sections:
            value = _expand(value)
        value = self.resolve(value, chain=())
        if self.problems:
            raise ArchsimError(self.problems)
        return put(tree, keys, replace(value, key=where))


def _base_file(base: Node, chain: tuple[Path, ...]) -> Path:
    """The file that `base` names. Raises ArchsimError where there is none, or where it led here."""
    if not isinstance(base.value, str):
        raise fail("base must be the path of a file", base.where)
    path = find_file(base.value, base.folder)
    if path is None:
        raise ArchsimError(_missing_file(base.value, base.folder, base.where))
    if path.resolve() in chain:
        circle = [*chain[chain.index(path.resolve()) :], path]
        raise fail(f"bases in a circle: {' -> '.join(file.name for file in circle)}", base.where)
    if len(chain) > MAX_BASES:
        raise fail(f"more than {MAX_BASES} bases in a row", base.where)
    return path


def _expand(node: Node) -> Node:
    """`PATH` as `{base: PATH}`."""
    return replace(node, value={"base": replace(node, key=None)}) if isinstance(node.value, str) else node


def _merge(base: Node, over: Node) -> Node:
    """`over` merged over `base`, in the order of `base`."""
    if over.fresh or not (isinstance(base.value, dict) and isinstance(over.value, dict)):
        return over
    merged = dict(base.value)
    for key, node in over.value.items():
        merged[key] = _merge(merged[key], node) if key in merged else node
    return replace(over, value=merged)


def put(node: Node, keys: list[str], value: Node) -> Node:
    """The node with the value at the end of a path of keys and indices; makes the mappings on the way."""
    if not keys:
        return value
    key, *rest = keys
    if isinstance(node.value, list):
        items = list(node.value)
        if not (key.isascii() and key.isdigit() and len(key) < 10 and int(key) < len(items)):
            raise fail(f"'{key}' is not an index of a list of {len(items)}; they count from 0", value.where)
        items[int(key)] = put(items[int(key)], rest, value)
        return replace(node, value=items)

    children = dict(node.value) if isinstance(node.value, dict) else {}
    empty = Node({}, value.where, value.where, value.folder)
    children[key] = put(children.get(key, empty), rest, value)
    return replace(node, value=children)


def _missing_file(text: str, folder: Path, where: Location | None) -> Problem:
    if (folder / Path(text).expanduser()).is_dir():
        return Problem(where, f"a folder, not a file: '{text}'")
    return Problem(where, f"no such file: '{text}'", similar_file(text, folder))


def is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _names(folder: Path) -> list[str]:
    try:
        return sorted(os.listdir(folder))[:1000]
    except (OSError, ValueError):
        return []


def _shown(path: Path) -> str:
    """The path as errors print it: from the current folder where it lies inside."""
    absolute = Path(os.path.normpath(path.absolute()))
    return str(absolute.relative_to(Path.cwd())) if absolute.is_relative_to(Path.cwd()) else str(absolute)
