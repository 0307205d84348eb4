"""Machines: names, sizes, clocks and timing that do not fit together, each at its place."""

from __future__ import annotations

import pytest

from archsim.config import load_machine
from archsim.config.components import CacheConfig, CoreConfig, DramConfig, UnitConfig

C = "components."


def test_the_paper_s_machine_has_the_numbers_of_its_tables():
    machine = load_machine("machines/johnson2004.yaml")
    assert machine.clocks == {"core": 1_200_000_000, "memory": 700_000_000}
    cores = machine.all_of(CoreConfig)
    assert [(core.count, core.threads) for core in cores.values()] == [(1, 8), (4, 8)]
    table_2 = {
        name: (cache.size, cache.ways, cache.line, cache.hit_cycles, cache.num_sets)
        for name, cache in machine.all_of(CacheConfig).items()
    }
    l1 = (16 * 1024, 8, 64, 1, 32)
    assert table_2 == {"cpu_l1": l1, "fragment_l1": l1, "l2": (256 * 1024, 8, 128, 6, 256)}
    [dram] = machine.all_of(DramConfig).values()
    assert dram.channels * dram.channel_width * 8 == 256
    assert machine.find("locks", DramConfig) is None
    assert machine.feeder("fragments") is machine.find("rasterizer", UnitConfig)
    assert machine.feeder("l2") is None


@pytest.mark.parametrize(
    ("bits", "message"),
    [
        ("{block: 12 B, size: 1 KiB}", "block: must be a power of two, not 12 B"),
        ("{block: 16 B, size: 40 B}", "size: must be a whole number of blocks of 16 B"),
        ("{block: 16 B, size: 16 B, start: 8 B}", "start: must be a whole number of blocks of 16 B"),
        ("{block: 16 B, size: 16 B, at_start: unclear}", "at_start: must be clear or unknown, not 'unclear'"),
        ("{block: 1 B, size: 1 GiB}", "size: holds more than 16777216 blocks of 1 B"),
        ("{block: 16 B}", "missing key 'components.l2.clear_bits.size'"),
    ],
)
def test_clear_bits_that_do_not_fit_are_said(problems, bits, message):
    [problem] = problems(load_machine, "machines/tiny.yaml", [f"{C}l2.clear_bits={bits}"])
    assert message in problem


def test_address_fields_start_at_the_lowest_bits():
    dram = load_machine("machines/johnson2004.yaml").find("dram", DramConfig)
    assert dram.address_fields(128) == {
        "offset": (0, 7),
        "channel": (7, 3),
        "line": (10, 4),
        "bank": (14, 2),
        "row": (16, 12),
    }


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (C + "builder.memory=bilder_l1", "no cache is named 'bilder_l1'; did you mean 'builder_l1'?"),
        (
            C + "builder.memory=dram",
            "must name a cache; 'dram' is a dram; there are: builder_l1, shader_l1, l2",
        ),
        (C + "builder.locks=lock", "no locks is named 'lock'; did you mean 'locks'?"),
        (C + "builder.clock=cor", "no clock is named 'cor'; did you mean 'core'?"),
        (C + "builder.tasks=interleave", "no fifo is named 'interleave'; did you mean 'interleaved'?"),
        (C + "l2.next=drum", "no cache or dram or ideal_dram is named 'drum'; did you mean 'dram'?"),
        (C + "l2.next=locks", "must name a cache or dram or ideal_dram; 'locks' is a locks; "),
        (C + "rasterizer.output=l2", "must name a fifo; 'l2' is a cache; there are: fragments"),
        ("roles.izb_build=locks", "must name a core; 'locks' is a locks; there are: builder, shader"),
        ("roles.izb_build=shader", "'shader' has no locks; the build phase needs them"),
        (C + "l2.next=l2", "caches in a circle: l2 -> l2"),
        (
            C + "l2.next=builder_l1",
            "'builder_l1' is private to a core, so it can't be the next level of a cache",
        ),
        (C + "l2.clock=memory", "must be 'core', the clock of 'builder', not 'memory'"),
        (
            C + "l2.sector=6 B",
            "must be a power of two and a line hold 1 to 32 of them, not 6 B",
        ),
        (C + "l2.sector=1 B", "must be a power of two and a line hold 1 to 32 of them, not 1 B"),
        (C + "l2.sector=128 B", "must be a power of two and a line hold 1 to 32 of them, not 128 B"),
        (C + "l2.sector=16 B", "must be a whole number of bursts of 'dram', 32 B each"),
        (C + "l2.replacement=lfu", "must be lru, fifo, tree_plru or random, not 'lfu'"),
        (
            C + "l2.write_policy=write_trough",
            "must be write_back or write_through, not 'write_trough'; did you mean 'write_through'?",
        ),
        (C + "l2.victim_order=none", "must be fetch_first or write_back_first, not 'none'"),
        (
            C + "l2.arbiter=round_robbin",
            "must be arrival, fixed_priority or round_robin, not 'round_robbin'; did you mean 'round_robin'?",
        ),
        (C + "l2.write_queue=-1", "must be at least 0, not -1"),
        (C + "l2.write_allocate=1", "must be true or false, not 1"),
        (C + "l2.line=8 B", "must be a power of two of at least 16 B (one access), not 8 B"),
        (C + "l2.line=48 B", "must be a power of two of at least 16 B (one access), not 48 B"),
        (
            C + "l2.size=1.5 KiB",
            "must be sets x ways x line with a power of two of sets: 1536 B is 12 times 2 ways of 64 B",
        ),
        (
            C + "l2.size=1000 B",
            "must be sets x ways x line with a power of two of sets: 1000 B is 7.8125 times 2 ways of 64 B",
        ),
        (C + "l2.size=0 B", "must be at least 1, not '0 B'"),
        (C + "dram.channels=3", "must be a power of two, not 3"),
        (C + "dram.banks=6", "must be a power of two, not 6"),
        (C + "dram.rows=1000", "must be a power of two, not 1000"),
        (C + "dram.rows=0", "must be at least 1, not 0"),
        (C + "dram.data_rate=1", "must be 2 or 4, not 1"),
        (
            C + "dram.address_map=row:bank:column:offset",
            "must hold row, bank, line, channel, offset once each, with ':' between, not 'row:bank:column:offset'",
        ),
        (
            C + "dram.address_map=row:bank:line:offset:channel",
            "must end with offset: a request stays in one row",
        ),
        (C + "dram.timing.n_rc=13", "must be at least n_ras + n_rp, 14"),
        (C + "dram.timing.n_refi=135", "must be at least 4 (n_rfc + n_rc), 136, or 0 for no refresh"),
        (C + "dram.timing.n_ras=3", "must be at least n_rcd_read, 4"),
        (C + "dram.timing.n_ccd=3", "must be at least the clocks of a burst's data, 4"),
        (
            "clocks.core=1.0000001 GHz",
            "no useful common divisor: a period would be 10000001 ticks, above 1000000; choose rounder frequencies",
        ),
        (
            C + "interleaved={kind: fifo, entries: 1}",
            "is a word that `tasks` understands; choose another name",
        ),
        (C + "builder.threads=0", "must be at least 1, not 0"),
        (C + "fragments.entries=-1", "must be at least 1, not -1"),
        (C + "l2.hit_cycles=0 cycles", "must be at least 1, not '0 cycles'"),
    ],
)
def test_what_does_not_fit_is_said(problems, override, message):
    found = problems(load_machine, "machines/tiny.yaml", [override])
    path = override.partition("=")[0]
    places = [line for line in found if f"{path}: {message}" in line or f" clocks: {message}" in line]
    assert places, found
    assert places[0].startswith(f"--set {override}: ") or override.startswith("clocks")


@pytest.mark.parametrize(
    "override",
    [
        C + "l2={base: l2.yaml, ways: 16}",  # one set
        C + "builder_l1.private=false",
        C + "dram.timing.n_refi=136",
        C + "dram.address_map=channel:row:bank:line:offset",
        "clocks.memory=700 MHz",
    ],
)
def test_what_fits_is_accepted(write, override):
    write(
        "l2.yaml",
        """\
        {kind: cache, size: 1 KiB, ways: 1, line: 64 B, hit_cycles: 4 cycles, mshrs: 4, targets: 4,
         ports: 1, next: dram, clock: core}
        """,
    )
    assert load_machine("machines/tiny.yaml", [override])


def test_lines_must_fit_bursts_and_rows_and_each_other(write, problems):
    write(
        "machine.yaml",
        """\
        base: machines/tiny.yaml
        components:
          builder_l1: {next: dram, line: 32 B}
          l2: {line: 64 B}
          dram: {burst_beats: 32, row_bytes: 32 B, timing: {n_ccd: 16, n_rtw: 17}}
        """,
    )
    assert problems(load_machine, "machine.yaml") == [
        "machine.yaml:3:34: components.builder_l1.line: must be a whole number of bursts of 'dram', 128 B each",
        "machine.yaml:4:14: components.l2.line: must be a whole number of bursts of 'dram', 128 B each",
        "machine.yaml:4:14: components.l2.line: must divide the rows of 'dram', 32 B",
        "machine.yaml:4:14: components.l2.line: must be that of 'builder_l1', 32 B: both use 'dram'",
    ]


@pytest.mark.parametrize(
    ("components", "count"),
    [
        ("rasterizer: {output: other}\n  other: {kind: fifo, entries: 1}", "none does"),
        ("second: {kind: unit, interval_cycles: 1, output: fragments}", "2 do: rasterizer, second"),
    ],
)
def test_exactly_one_unit_feeds_a_core_s_fifo(write, problems, components, count):
    write("machine.yaml", f"base: machines/tiny.yaml\ncomponents:\n  {components}\n")
    [problem] = problems(load_machine, "machine.yaml")
    assert problem.endswith(
        f"components.shader.tasks: exactly one unit must have the fifo 'fragments' as output; {count}"
    )


def test_wrong_names_and_wrong_graphs_are_told_together(problems):
    overrides = [C + "builder.memory=x", C + "l2.next=l2", "roles.izb_build=shader", "clocks.core=1234567891"]
    found = problems(load_machine, "machines/tiny.yaml", overrides)
    assert len(found) == 4


def test_problems_of_shared_values_are_at_the_shared_place(problems):
    shared, *others = problems(load_machine, "machines/tiny.yaml", [C + "l2.private=true"])
    place, _, what = shared.partition(": ")
    assert what.startswith("components.builder_l1.next: 'l2' is private to a core")
    assert others == [f"{place}: {what.replace('builder', 'shader')}"]


def test_a_circle_of_caches_is_told_once_and_a_mapping_at_its_key(write, problems):
    write(
        "machine.yaml",
        """\
        base: machines/tiny.yaml
        clocks:
          core: 1234567891 Hz
          memory: 1 GHz
        components:
          builder_l1: {private: false}
          l2: {line: 32 B, next: builder_l1}
        """,
    )
    circle, clocks = sorted(problems(load_machine, "machine.yaml"), key=lambda line: "clocks" in line)
    assert clocks.startswith("machine.yaml:2:1: clocks: no useful common divisor")
    assert circle.endswith("components.builder_l1.next: caches in a circle: builder_l1 -> l2 -> builder_l1")


def test_what_nothing_refers_to_is_told_at_its_place(write, problems):
    write(
        "machine.yaml",
        """\
        base: machines/tiny.yaml
        components:
          queue: {kind: fifo, entries: 2}
          feeder: {kind: unit, interval_cycles: 0, output: queue}
          builder: {memory: shader_l1}
        """,
    )
    found = problems(load_machine, "machine.yaml")
    what = "takes no part: nothing that is used refers to it"
    assert {line.rpartition("components.")[2] for line in found} == {
        f"{name}: {what}" for name in ("builder_l1", "queue", "feeder")
    }
    assert f"machine.yaml:3:3: components.queue: {what}" in found


CORE = "{kind: core, count: 1, threads: 2, clock: core, memory: shader_l1, locks: null, tasks: fragments}"
STAGE = "{kind: unit, clock: core, interval_cycles: 1, latency_cycles: 1, outputs: [], in_flight: 4}"


@pytest.mark.parametrize(
    ("machine", "component", "why"),
    [
        ("tiny", CORE, "no role names it"),
        ("tiny", STAGE, "nothing that is used refers to it"),
        ("tiny_pipeline", STAGE, "nothing that is used refers to it"),
    ],
)
def test_what_no_work_can_reach_is_told(problems, machine, component, why):
    [problem] = problems(load_machine, f"machines/{machine}.yaml", [f"{C}extra={component}"])
    assert problem.endswith(f"components.extra: takes no part: {why}")


def test_a_clock_that_nothing_runs_on_is_told(problems):
    assert problems(load_machine, "machines/tiny.yaml", ["clocks.memroy=3 GHz"]) == [
        "--set clocks.memroy=3 GHz: clocks.memroy: takes no part: no component runs on this clock"
    ]
    [problem] = problems(load_machine, "machines/tiny.yaml", [f"{C}dram.clock=core"])
    assert problem.endswith("clocks.memory: takes no part: no component runs on this clock")
