"""The workload kinds that a run can have."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from archsim.config import RunConfig

if TYPE_CHECKING:
    from archsim.run.rendering import Kind

_MODULES = {
    "izb": "izb",
    "izb_drawn": "izb",
    "shadow_volumes": "shadow_volumes",
    "shadow_volume_kernels": "shadow_volume_kernels",
    "shadow_maps": "shadow_maps",
}


def kind_of(config: RunConfig) -> Kind:
    """The kind of the run's workload. Loads only what that kind needs: the models are heavy."""
    kind: Kind = import_module(f"archsim.run.{_MODULES[config.workload.kind]}").KIND
    return kind
