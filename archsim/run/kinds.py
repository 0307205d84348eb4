"""The workload kinds that a run can have, and what a sweep may do with each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from archsim.config import RunConfig
from archsim.run.result import Result

if TYPE_CHECKING:
    from archsim.run.listen import Listen


class Rendering(NamedTuple):
    """How a kind's picture and work are made once, kept, and played on many machines."""

    depends_on_machine: Callable[[RunConfig], dict[str, Any]]  # what the work takes from the machine
    render: Callable[[RunConfig], Any]
    save: Callable[[Any, Path], None]
    load: Callable[[Path], Any]
    replay: Callable[
        ..., Result
    ]  # of a RunConfig, what is kept, a Progress and, if somebody listens, `listen`


class Kind(NamedTuple):
    """One kind of workload."""

    simulate: Callable[..., Result]  # of a RunConfig, a Progress and, if somebody listens, `listen`
    rendering: Rendering | None  # None: every run renders anew


def kind_of(config: RunConfig) -> Kind:
    """The kind of the run's workload. Loads only what that kind needs: the models are heavy."""
    kinds: dict[str, Callable[[], Kind]] = {
        "izb": _izb,
        "izb_drawn": _izb,
        "shadow_volumes": _shadow_volumes,
        "shadow_volume_kernels": _shadow_volume_kernels,
        "shadow_maps": _shadow_maps,
    }
    return kinds[config.workload.kind]()


def _izb() -> Kind:
    izb, rendered = import_module("archsim.run.izb"), import_module("archsim.run.izb_rendered")
    rendering = Rendering(
        rendered.depends_on_machine,
        rendered.render,
        rendered.save,
        rendered.load,
        _over_time(izb.replay_izb),
    )
    return Kind(_over_time(izb.simulate_izb), rendering)


def _shadow_volumes() -> Kind:
    return Kind(_over_time(import_module("archsim.run.shadow_volumes").simulate_shadow_volumes), None)


def _shadow_volume_kernels() -> Kind:
    kernels = import_module("archsim.run.shadow_volume_kernels")
    return Kind(_over_time(kernels.simulate_shadow_volume_kernels), None)


def _shadow_maps() -> Kind:
    return Kind(_over_time(import_module("archsim.run.shadow_maps").simulate_shadow_maps), None)


def _over_time(play: Callable[..., Result]) -> Callable[..., Result]:
    """The same, whose result says how the phases went over time if the run is asked to tell that."""
    series, listening = import_module("archsim.run.series"), import_module("archsim.run.listen")

    def played(config: RunConfig, *more: Any, listen: Listen = listening.to_nothing) -> Result:
        result: Result = series.over_time(
            config.statistics.interval_cycles, listen, partial(play, config, *more)
        )
        return result

    return played
