"""The checks between the components of a pipeline: who emits, who takes, who asks which memory."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from archsim.config.dram import DramConfig, IdealDramConfig
from archsim.config.section import Finding
from archsim.config.stages import DelayStreamConfig, StageConfig
from archsim.config.tiles import EvaluatorConfig
from archsim.units import format_bytes

if TYPE_CHECKING:
    from archsim.config.machine import MachineConfig

Path = tuple[str | int, ...]


def wiring_findings(machine: MachineConfig) -> Iterator[Finding]:
    """What is wrong between the units of a pipeline and what they are wired to."""
    stages = machine.all_of(StageConfig)
    if not stages:
        return
    yield from _channel_findings(machine, stages)
    yield from _clock_findings(machine, stages)
    yield from _memory_findings(machine, stages)
    yield from _part_findings(machine, stages)
    if all(stage.inputs for stage in stages.values()):
        yield Finding(("components",), "a pipeline needs a source: a unit without inputs")


def _channel_findings(machine: MachineConfig, stages: dict[str, StageConfig]) -> Iterator[Finding]:
    """Fifos and delay streams that are not between one unit and one other."""
    fed_to_cores = {unit.output for unit in machine.sources.values()}
    for name, component in machine.components.items():
        if component.kind not in ("fifo", "delay_stream") or name in fed_to_cores:
            continue
        for key, verb in (("outputs", "emit into it"), ("inputs", "take from it")):
            users = [unit for unit, stage in stages.items() for other in getattr(stage, key) if other == name]
            if len(users) != 1:
                count = ", ".join(users) if users else "none does"
                yield Finding(("components", name), f"exactly one unit must {verb}; {count}")


def _clock_findings(machine: MachineConfig, stages: dict[str, StageConfig]) -> Iterator[Finding]:
    """Units and caches on another clock than the first unit."""
    first, clock = next((name, stage.clock) for name, stage in stages.items())
    for name, stage in stages.items():
        if stage.clock != clock:
            what = f"must be '{clock}', the clock of '{first}': all units of a pipeline share one"
            yield Finding(("components", name, "clock"), what)
        for cache in machine.caches_below(stage.memory or ""):
            if machine.caches[cache].clock != clock:
                yield Finding(("components", cache, "clock"), f"must be '{clock}', the clock of '{name}'")


def _memory_findings(machine: MachineConfig, stages: dict[str, StageConfig]) -> Iterator[Finding]:
    """Units and delay streams whose requests or rings do not fit the memory, and more than one DRAM."""
    drams: dict[str, DramConfig | IdealDramConfig] = {
        **machine.all_of(DramConfig),
        **machine.all_of(IdealDramConfig),
    }
    if len(drams) != 1:
        yield Finding(("components",), f"a pipeline has one DRAM; there are {len(drams)}")
        return
    ((place, dram),) = drams.items()
    for name, stage in stages.items():
        path: Path = ("components", name, "line")
        if (stage.line is None) == (stage.memory in drams):
            what = "must be given" if stage.line is None else "must be left out"
            yield Finding(path, f"{what}: it goes with the DRAM as memory")
        elif stage.line is not None:
            yield from _line_findings(path, stage.line, dram)
    for name, stream in machine.all_of(DelayStreamConfig).items():
        yield from _line_findings(("components", name, "line"), stream.line, dram)
        if stream.address + stream.size > dram.capacity_bytes:
            what = f"the ring ends at {format_bytes(stream.address + stream.size)}, beyond '{place}'"
            hint = f"'{place}' holds {format_bytes(dram.capacity_bytes)}"
            yield Finding(("components", name, "address"), what, hint)


def _part_findings(machine: MachineConfig, stages: dict[str, StageConfig]) -> Iterator[Finding]:
    """Evaluators with a table that no unit could read."""
    for name, evaluator in machine.all_of(EvaluatorConfig).items():
        users = [stage for stage in stages.values() if name in stage.parts]
        if evaluator.has_table and users and all(stage.memory is None for stage in users):
            what = f"'{evaluator.design}' is in memory, and no unit with this part has a memory"
            yield Finding(("components", name, "design"), what)


def _line_findings(path: Path, line: int, dram: DramConfig | IdealDramConfig) -> Iterator[Finding]:
    if isinstance(dram, DramConfig):
        if line % dram.burst_bytes:
            yield Finding(path, f"must be a whole number of bursts, {format_bytes(dram.burst_bytes)} each")
        if dram.row_bytes % line:
            yield Finding(path, f"must divide the rows of the DRAM, {format_bytes(dram.row_bytes)}")
