"""Imports point down, numba has one door, SimPy stays in the reference models, modules hold no mutable state."""

import ast
from pathlib import Path

import pytest

import archsim

PACKAGE = Path(archsim.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))
NAMES = [path.relative_to(PACKAGE).as_posix() for path in SOURCES]

# What may import what: a part imports itself and parts of lower layers, or others of its own layer.
LAYERS = [
    ["units", "jit", "errors", "resources"],
    ["lanes"],
    ["isa", "config", "observe"],
    ["shadow", "shadow_volumes", "raster", "lograster", "codec", "shadowmap", "scene", "execute", "trace"],
    ["model"],
    ["machine", "analysis"],
    ["run"],
    ["report", "sweep", "reproduce", "bench"],
    ["cli", "__main__", "api"],
]
LAYER_OF = {part: layer for layer, parts in enumerate(LAYERS) for part in parts}


def imports(path: Path) -> list[str]:
    """The modules that a file imports anywhere, functions included."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            found += [node.module] if node.module != "archsim" else [f"archsim.{a.name}" for a in node.names]
    return found


def part(path: Path) -> str:
    """The name under `archsim` that a file belongs to."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def importers(library: str) -> list[str]:
    return [
        name
        for name, path in zip(NAMES, SOURCES, strict=True)
        if any(module.split(".")[0] == library for module in imports(path))
    ]


@pytest.mark.parametrize("path", SOURCES, ids=NAMES)
def test_imports_point_down(path):
    if path == PACKAGE / "__init__.py":
        return  # the public names come from everywhere
    for module in imports(path):
        if module.startswith("archsim."):
            imported = module.split(".")[1]
            assert LAYER_OF[imported] <= LAYER_OF[part(path)], f"imports {module}"


def test_every_part_has_a_layer():
    assert {part(path) for path in SOURCES} - {"__init__"} <= set(LAYER_OF)


def test_numba_has_one_door():
    assert importers("numba") == ["jit.py"]


def test_simpy_stays_in_the_reference_models():
    assert {Path(name).name for name in importers("simpy")} == {"reference.py"}


@pytest.mark.parametrize("path", SOURCES, ids=NAMES)
def test_compiled_models_know_nothing_of_the_reference_models(path):
    if path.name == "compiled.py":
        assert not any(module.endswith(".reference") for module in imports(path))


@pytest.mark.parametrize("path", SOURCES, ids=NAMES)
def test_modules_hold_no_mutable_state(path):
    """No `global`, and no module-level list, dict or set under a name that is not a constant's."""
    tree = ast.parse(path.read_text())
    assert not [node for node in ast.walk(tree) if isinstance(node, ast.Global)]
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        if isinstance(getattr(node, "value", None), ast.List | ast.Dict | ast.Set):
            for name in (target.id for target in targets if isinstance(target, ast.Name)):
                assert name.isupper() or name == "__all__", name
