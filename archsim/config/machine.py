"""The machine section: clocks, components by name, which cores do what; and the checks between components."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Annotated, TypeVar

from pydantic import Field, model_validator

from archsim.config.components import (
    INTERLEAVED,
    CacheConfig,
    ComponentConfig,
    CoreConfig,
    DramConfig,
    FifoConfig,
    IdealDramConfig,
    LocksConfig,
    UnitConfig,
)
from archsim.config.section import ComponentName, Finding, Name, Section, report
from archsim.config.stages import DelayStreamConfig, PoolConfig, StageConfig
from archsim.config.tiles import EvaluatorConfig, TileCacheConfig
from archsim.config.wiring import wiring_findings
from archsim.errors import did_you_mean
from archsim.units import Frequency, clock_periods, format_bytes

MAX_PERIOD_TICKS = 10**6

Kind = TypeVar(
    "Kind",
    CoreConfig,
    CacheConfig,
    UnitConfig,
    StageConfig,
    FifoConfig,
    DelayStreamConfig,
    PoolConfig,
    EvaluatorConfig,
    TileCacheConfig,
    LocksConfig,
    DramConfig,
    IdealDramConfig,
)


class RolesConfig(Section):
    """The group of cores that runs each phase of irregular shadow mapping, and the stages of shadow volumes."""

    izb_build: str  # the cores that build the grid of lists
    izb_raster: str  # the cores that test triangles against samples
    hsv_stages: str | None = (
        None  # the cores that run both stages of hierarchical shadow volumes; null: none do
    )


class MachineConfig(Section):
    """A graph of components; they refer to each other, and to clocks, by name."""

    name: Name  # what the machine is called
    clocks: Annotated[
        dict[ComponentName, Frequency], Field(min_length=1)
    ]  # frequencies by name; all are used
    components: dict[ComponentName, ComponentConfig]  # components by name
    roles: RolesConfig | None = None  # which cores run which phase; null: it is a pipeline without cores

    def all_of(self, kind: type[Kind]) -> dict[str, Kind]:
        """The components of one kind by name."""
        return {name: each for name, each in self.components.items() if isinstance(each, kind)}

    def find(self, name: str, kind: type[Kind]) -> Kind | None:
        """The component of that name if it is of that kind."""
        component = self.components.get(name)
        return component if isinstance(component, kind) else None

    def key_of(self, *kinds: str) -> str:
        """Dotted path, in a run, of the first component of one of these kinds: what a problem is about."""
        names = [name for name, each in self.components.items() if each.kind in kinds]
        return ".".join(["machine.components", *names[:1]])

    @property
    def sources(self) -> dict[str, UnitConfig]:
        """The units that make the cores' tasks."""
        return self.all_of(UnitConfig)

    @property
    def caches(self) -> dict[str, CacheConfig]:
        return self.all_of(CacheConfig)

    def caches_below(self, name: str) -> list[str]:
        """Names of the caches from one downwards, each once; none if it is no cache."""
        path: list[str] = []
        while name in self.caches and name not in path:
            path.append(name)
            name = self.caches[name].next
        return path

    def feeder(self, fifo: str) -> UnitConfig | None:
        """The unit whose output is the fifo of that name."""
        return next((unit for unit in self.all_of(UnitConfig).values() if unit.output == fifo), None)

    @model_validator(mode="after")
    def _check(self) -> MachineConfig:
        checks = (
            _names,
            _circles,
            _sectors,
            _core_clocks,
            _dram_clocks,
            _private_caches,
            _requests,
            _feeders,
            _ticks,
            _roles,
            wiring_findings,
        )
        found = [finding for check in checks for finding in check(self)]
        report(found or list(_unused(self)))
        return self


def _names(machine: MachineConfig) -> Iterator[Finding]:
    """Names of clocks and components that do not exist or are of the wrong kind."""
    if INTERLEAVED in machine.components:
        yield Finding(("components", INTERLEAVED), "is a word that `tasks` understands; choose another name")
    for name, component in machine.components.items():
        path = ("components", name)
        for key, kinds in _REFERENCES.get(component.kind, {}).items():
            named = getattr(component, key, None)
            if not isinstance(named, tuple):
                yield from _reference(machine, (*path, key), named, kinds)
                continue
            for place, each in enumerate(named):
                yield from _reference(machine, (*path, key, place), each, kinds)
        clock = getattr(component, "clock", None)
        if clock is not None and clock not in machine.clocks:
            yield Finding((*path, "clock"), f"no clock is named '{clock}'", _near(clock, machine.clocks))
    for role, name in machine.roles or ():
        yield from _reference(machine, ("roles", role), name, ("core",))


# The kinds that a key of a component may name.
_REFERENCES: dict[str, dict[str, tuple[str, ...]]] = {
    "core": {"memory": ("cache",), "locks": ("locks",), "tasks": ("fifo",)},
    "cache": {"next": ("cache", "dram", "ideal_dram")},
    "unit": {
        "output": ("fifo",),
        "inputs": ("fifo", "delay_stream"),
        "outputs": ("fifo", "delay_stream"),
        "pools": ("pool",),
        "parts": ("evaluator", "tile_cache"),
        "memory": ("cache", "dram", "ideal_dram"),
    },
    "delay_stream": {"memory": ("dram", "ideal_dram")},
}


def _reference(
    machine: MachineConfig, path: tuple[str | int, ...], name: str | None, kinds: tuple[str, ...]
) -> Iterator[Finding]:
    if name is None or (path[-1] == "tasks" and name == INTERLEAVED):
        return
    fitting = [other for other, each in machine.components.items() if each.kind in kinds]
    if path[-1] == "tasks":
        fitting.append(INTERLEAVED)
    wanted = " or ".join(kinds)
    found = machine.components.get(name)
    if found is None:
        yield Finding(path, f"no {wanted} is named '{name}'", _near(name, fitting))
    elif found.kind not in kinds:
        yield Finding(path, f"must name a {wanted}; '{name}' is a {found.kind}", _near(name, fitting))


def _near(word: str, choices: Iterable[str]) -> str:
    known = list(choices)
    return did_you_mean(word, known) or (f"there are: {', '.join(known)}" if known else "there is none")


def _circles(machine: MachineConfig) -> Iterator[Finding]:
    """Caches that lead back to themselves, once for each circle."""
    seen: set[str] = set()
    for name in machine.all_of(CacheConfig):
        path = machine.caches_below(name)
        last = machine.components[path[-1]]
        if isinstance(last, CacheConfig) and last.next == name and name not in seen:
            seen.update(path)
            yield Finding(("components", name, "next"), f"caches in a circle: {' -> '.join([*path, name])}")


def _sectors(machine: MachineConfig) -> Iterator[Finding]:
    """Sectors that are no whole number of the DRAM's bursts."""
    for name, cache in machine.all_of(CacheConfig).items():
        dram = machine.find(cache.next, DramConfig)
        if dram is None or cache.sector is None:
            continue
        if cache.sector % dram.burst_bytes:
            burst = format_bytes(dram.burst_bytes)
            what = f"must be a whole number of bursts of '{cache.next}', {burst} each"
            yield Finding(("components", name, "sector"), what)


def _unused(machine: MachineConfig) -> Iterator[Finding]:
    """Components that take no part, as no role and no stage leads to them, and clocks that nothing runs on."""
    used: set[str] = set()
    found = {name for _, name in machine.roles or () if name is not None} | _wired(machine)
    while found:
        used |= found
        found = {other for name in found for other in _neighbours(machine, name)} - used
    for name, component in machine.components.items():
        if name not in used:
            why = _IDLE.get(component.kind, "nothing that is used refers to it")
            yield Finding(("components", name), f"takes no part: {why}")
    ticking = {getattr(component, "clock", None) for component in machine.components.values()}
    for name in machine.clocks:
        if name not in ticking:
            yield Finding(("clocks", name), "takes no part: no component runs on this clock")


_IDLE = {"core": "no role names it"}


def _wired(machine: MachineConfig) -> set[str]:
    """The stages of a pipeline: those between others, or its only one."""
    stages = machine.all_of(StageConfig)
    alone = len(stages) == 1 and machine.roles is None
    return {name for name, each in stages.items() if alone or each.inputs or each.outputs}


def _neighbours(machine: MachineConfig, name: str) -> Iterator[str]:
    """Components that one refers to, and the units that feed it."""
    component = machine.components.get(name)
    if component is None:
        return
    for key in _REFERENCES.get(component.kind, {}):
        named = getattr(component, key, None)
        yield from named if isinstance(named, tuple) else (str(named),)
    if isinstance(component, FifoConfig):
        yield from (unit for unit, each in machine.all_of(UnitConfig).items() if each.output == name)


def _core_clocks(machine: MachineConfig) -> Iterator[Finding]:
    """Caches on another clock than the cores above them."""
    for group, core in machine.all_of(CoreConfig).items():
        for name in machine.caches_below(core.memory):
            cache = machine.find(name, CacheConfig)
            if cache is not None and cache.clock != core.clock:
                what = f"must be '{core.clock}', the clock of '{group}', not '{cache.clock}'"
                yield Finding(("components", name, "clock"), what)


def _dram_clocks(machine: MachineConfig) -> Iterator[Finding]:
    """DRAMs on a clock that their timing, which is in clocks, is not meant for."""
    for name, dram in machine.all_of(DramConfig).items():
        frequency = machine.clocks.get(dram.clock)
        if dram.frequency is not None and frequency is not None and dram.frequency != frequency:
            what = f"'{dram.clock}' runs at {frequency:,} Hz, the timing is meant for {dram.frequency:,} Hz"
            hint = f"with other timing, set {name}.frequency too; null: no check"
            yield Finding(("components", name, "clock"), what, hint)


def _private_caches(machine: MachineConfig) -> Iterator[Finding]:
    """Private caches below other caches."""
    for name, cache in machine.all_of(CacheConfig).items():
        parent = machine.find(cache.next, CacheConfig)
        if parent is not None and parent.private:
            what = f"'{cache.next}' is private to a core, so it can't be the next level of a cache"
            yield Finding(("components", name, "next"), what)


def _requests(machine: MachineConfig) -> Iterator[Finding]:
    """Last caches whose lines do not fit their DRAM's bursts or rows, or differ."""
    first: dict[str, tuple[str, int]] = {}
    for name, cache in machine.all_of(CacheConfig).items():
        dram = machine.find(cache.next, DramConfig)
        if dram is None:
            continue
        path = ("components", name, "line")
        if cache.line % dram.burst_bytes:
            burst = format_bytes(dram.burst_bytes)
            yield Finding(path, f"must be a whole number of bursts of '{cache.next}', {burst} each")
        if dram.row_bytes % cache.line:
            row = format_bytes(dram.row_bytes)
            yield Finding(path, f"must divide the rows of '{cache.next}', {row}")
        other, line = first.setdefault(cache.next, (name, cache.line))
        if line != cache.line and machine.roles is not None:
            yield Finding(path, f"must be that of '{other}', {format_bytes(line)}: both use '{cache.next}'")


def _feeders(machine: MachineConfig) -> Iterator[Finding]:
    """Fifos that cores take tasks from and that not exactly one unit feeds."""
    units = machine.all_of(UnitConfig)
    for name, core in machine.all_of(CoreConfig).items():
        if machine.find(core.tasks, FifoConfig) is None:
            continue
        feeders = [unit for unit, each in units.items() if each.output == core.tasks]
        if len(feeders) != 1:
            count = f"{len(feeders)} do: {', '.join(feeders)}" if feeders else "none does"
            what = f"exactly one unit must have the fifo '{core.tasks}' as output; {count}"
            yield Finding(("components", name, "tasks"), what)


def _ticks(machine: MachineConfig) -> Iterator[Finding]:
    """Clocks whose common divisor is too small for time to be counted in it."""
    longest = max(clock_periods(machine.clocks).values())
    if longest > MAX_PERIOD_TICKS:
        what = f"no useful common divisor: a period would be {longest} ticks, above {MAX_PERIOD_TICKS}"
        yield Finding(("clocks",), what, "choose rounder frequencies")


def _roles(machine: MachineConfig) -> Iterator[Finding]:
    """Roles that nobody has, and cores that lack what their role needs."""
    if machine.roles is None:
        if machine.all_of(CoreConfig) or not machine.all_of(StageConfig):
            yield Finding((), "missing key 'roles': which cores run which phase")
        return
    builder = machine.find(machine.roles.izb_build, CoreConfig)
    if builder is not None and builder.locks is None:
        what = f"'{machine.roles.izb_build}' has no locks; the build phase needs them"
        yield Finding(("roles", "izb_build"), what)
    stages = machine.find(machine.roles.hsv_stages or "", CoreConfig)
    if stages is not None and stages.locks is None:
        what = f"'{machine.roles.hsv_stages}' has no locks; stages of shadow volumes need them"
        yield Finding(("roles", "hsv_stages"), what)
