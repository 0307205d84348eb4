"""Provenance of a run: what made it, on what, from what. All that may differ between two equal runs is in here."""

from __future__ import annotations

import hashlib
import platform
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import archsim
from archsim.jit import code_digest

_PACKAGES = (
    "numpy",
    "numba",
    "llvmlite",
    "simpy",
    "pydantic",
    "PyYAML",
    "trimesh",
    "pandas",
    "matplotlib",
    "jinja2",
)


def make_manifest(
    config_yaml: str, seed: int, scene_digest: str, command: Sequence[str], wall_seconds: float
) -> dict[str, Any]:
    """The tree of a run's `manifest.json`."""
    return {
        **common_manifest(command, wall_seconds),
        "config_digest": hashlib.sha256(config_yaml.encode()).hexdigest(),
        "scene_digest": scene_digest,
        "seed": seed,
    }


def common_manifest(command: Sequence[str], wall_seconds: float) -> dict[str, Any]:
    """What is known of every piece of work, whatever it worked on."""
    return {
        "archsim": archsim.__version__,
        "code_digest": code_digest(),
        "command": list(command),
        "wall_seconds": round(wall_seconds, 3),
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "packages": {name: _version(name) for name in _PACKAGES},
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
