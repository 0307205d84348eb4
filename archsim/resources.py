"""Where the packaged kernels, configurations, experiments and meshes are, in a checkout and in a wheel."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent
_PACKAGED = _PACKAGE / "_packaged"


def root() -> Path:
    """The folder that holds `kernels/`, `configs/` and `experiments/`."""
    return _PACKAGED if _PACKAGED.is_dir() else _PACKAGE.parent


def kernel(name: str) -> Path:
    """Path of `kernels/NAME.s`."""
    return root() / "kernels" / f"{name}.s"


def config(kind: str, name: str) -> Path:
    """Path of `configs/KIND/NAME.yaml`."""
    return root() / "configs" / kind / f"{name}.yaml"


def mesh(name: str) -> Path:
    """Path of the packaged mesh NAME."""
    return root() / "configs" / "scenes" / "meshes" / f"{name}.npz"


def mesh_names() -> list[str]:
    """Names of all packaged meshes, sorted."""
    return sorted(path.stem for path in (root() / "configs" / "scenes" / "meshes").glob("*.npz"))


def experiment(paper: str) -> Path:
    """The folder `experiments/PAPER`."""
    return root() / "experiments" / paper
