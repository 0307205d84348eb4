"""archsim: a cycle-approximate simulator of graphics-hardware architectures.

`archsim.load`, `simulate`, `sweep`, `reproduce` and `report` do in Python what the commands do; see `archsim.api`.
"""

from __future__ import annotations

import importlib
import sys
import types
from typing import Any

__version__ = "0.1.0"
__all__ = ["load", "report", "reproduce", "simulate", "sweep"]


class _Verb(types.ModuleType):
    """A package of ours that has the name of a verb, such as `archsim.sweep`: calling it does the verb."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return getattr(importlib.import_module("archsim.api"), self.__name__.rpartition(".")[2])(
            *arguments, **options
        )


class _Package(types.ModuleType):
    """This package: its verbs are imported when they are first used, so that `import archsim` takes no time."""

    def __getattr__(self, name: str) -> Any:
        if name not in __all__:
            raise AttributeError(f"module 'archsim' has no attribute '{name}'")
        if name in ("load", "simulate"):
            return getattr(importlib.import_module("archsim.api"), name)
        return importlib.import_module(f"archsim.{name}")

    def __setattr__(self, name: str, value: Any) -> None:
        """Where the import system leaves the packages that it has loaded."""
        if name in __all__ and type(value) is types.ModuleType:
            value.__class__ = _Verb
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *__all__})


sys.modules[__name__].__class__ = _Package
