"""Replayed traces: without time as Dinero IV counts, with time the same misses, whatever the model."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from archsim.config import load_machine
from archsim.errors import ArchsimError
from archsim.machine.build import group_machine
from archsim.run.progress import silent
from archsim.run.replay import level_named, replay_without_time
from archsim.run.replay_dram import dram_part, replay_on_dram
from archsim.run.replay_timed import Play, replay_with_time
from archsim.trace.accesses import ACCESS, Kind

TINY = load_machine("machines/tiny.yaml")
BUILDER, SHADER = group_machine(TINY, "builder"), group_machine(TINY, "shader")
PAPER = group_machine(load_machine("machines/johnson2004.yaml"), "fragment_processors")


def trace(*chunks):
    """A trace of (address, bytes, requester, kind) rows that can be read again."""
    arrays = [np.array([(0, *row) for row in rows], ACCESS) for rows in chunks]
    return lambda: iter([array.copy() for array in arrays])


def values(replay):
    assert replay.ok, [check for check in replay.checks if not check.ok]
    return {statistic.name: statistic.value for statistic in replay.statistics}


def timed(reopen, machine=BUILDER, level=0, model="compiled", outstanding=1):
    return values(replay_with_time("t", reopen, machine, level, Play(model, outstanding, silent)))


def functional(reopen, machine=BUILDER, level=0, flush=False):
    return values(replay_without_time("t", reopen, machine, level, flush))


R, W, F = Kind.READ, Kind.WRITE, Kind.FETCH
STREAM = trace([(0, 4, 0, R), (4, 4, 0, W), (128, 4, 0, F)], [(28, 8, 0, R), (0, 4, 0, R)])


def test_what_is_counted_without_time():
    """L1: 4 sets of 2 ways of 32 bytes; L2: lines of 64 bytes. The access at 28 touches two lines."""
    found = functional(STREAM)

    assert found["trace.accesses"] == 5
    assert (found["trace.reads"], found["trace.writes"], found["trace.fetches"]) == (3, 1, 1)
    assert found["builder_l1.accesses"] == found["l1.accesses"] == 6
    assert found["l1.misses"] == 3  # lines 0, 128 and 32
    assert found["l1.write_misses"] == 0
    assert found["l1.writebacks"] == 0
    assert (found["l2.accesses"], found["l2.misses"]) == (3, 2)
    assert (found["dram.requests"], found["dram.writes"]) == (2, 0)


def test_a_flush_writes_dirty_lines_down():
    found = functional(STREAM, flush=True)

    assert (found["l1.writebacks"], found["l2.writebacks"], found["dram.writes"]) == (1, 1, 1)
    assert found["l2.accesses"] == 4


def test_a_replay_may_begin_further_down():
    level = level_named(BUILDER, "l2")
    for found in (functional(STREAM, level=level), timed(STREAM, level=level)):
        assert (found["l2.accesses"], found["l2.misses"]) == (5, 2)
        assert "builder_l1.accesses" not in found


def test_levels_answer_to_both_names():
    assert level_named(BUILDER, "builder_l1") == level_named(BUILDER, "l1") == 0
    assert level_named(PAPER, "l2") == 4
    with pytest.raises(ArchsimError, match="the machine has no level 'l3'; there are: builder_l1, l2, l1"):
        level_named(BUILDER, "l3")


@pytest.mark.parametrize("model", ["reference", "compiled"])
def test_one_requester_waits_for_every_answer(model):
    """tiny: an L1 hit is there after 1 cycle, an L2 hit after 1 + 4 cycles: ../../machine/README.md."""
    one = trace([(0, 4, 0, R)])
    hits = trace([(0, 4, 0, R)] * 11)

    first, all_ = timed(one, model=model), timed(hits, model=model)

    assert all_["replay.cycles"] == first["replay.cycles"] + 10
    assert first["replay.cycles"] == 20  # two lookups 1 + 4, ACT 4, second burst 4, RD 3, last beat 3.5
    assert all_["l1.hits"] == 10
    assert first["dram.bytes"] == 64
    assert first["dram.gigabytes_per_second"] == pytest.approx(64 / 20)  # cycles of 1 ns
    assert first["dram.peak_gigabytes_per_second"] == 8


def test_more_may_be_under_way():
    apart = trace([(256 * i, 4, 0, R) for i in range(64)])

    one, two = timed(apart), timed(apart, outstanding=2)

    assert two["replay.cycles"] < one["replay.cycles"]
    assert two["l1.misses"] == one["l1.misses"] == 64


def test_requesters_are_threads():
    """Two cores with private caches: what one has, the other has not."""
    rows = [(0, 4, 0, R), (0, 4, 8, R), (0, 4, 0, R), (0, 4, 1, R)]
    found = timed(trace(rows), machine=PAPER)

    assert found["fragment_l1.accesses"] == 4
    assert found["l2.reads"] == 2
    with pytest.raises(ArchsimError, match="requesters up to 32; the cores have 4 x 8 threads"):
        timed(trace([(0, 4, 32, R)]), machine=PAPER)
    with pytest.raises(ArchsimError, match="requesters up to 8, and 'fragment_l1' is private"):
        functional(trace(rows), machine=PAPER)
    assert timed(trace(rows), machine=PAPER, level=4)["l2.accesses"] == 4


def test_an_empty_trace_is_all_zeros():
    empty = lambda: iter([])  # noqa: E731
    assert functional(empty)["l1.accesses"] == timed(empty)["l1.accesses"] == 0


rows = st.lists(
    st.tuples(st.integers(0, 2000), st.sampled_from([1, 4, 8]), st.just(0), st.sampled_from(Kind)),
    max_size=60,
)


@settings(max_examples=60, deadline=None)
@given(first=rows, second=rows)
def test_misses_with_time_are_those_without(first, second):
    """Accesses shorter than a line, one at a time: time changes nothing that Dinero counts."""
    reopen = trace(*[chunk for chunk in (first, second) if chunk])
    without, with_time = functional(reopen), timed(reopen)

    for name in ("l1.accesses", "l1.misses", "l1.writebacks", "l2.accesses", "l2.misses", "l2.writebacks"):
        assert with_time[name] == without[name], name
    assert with_time["dram.requests"] == without["dram.requests"]


@settings(max_examples=10, deadline=None)
@given(rows=rows, outstanding=st.integers(1, 3))
def test_both_models_replay_alike(rows, outstanding):
    reopen = trace(rows) if rows else trace()
    assert timed(reopen, outstanding=outstanding) == timed(reopen, model="reference", outstanding=outstanding)


def at_cycles(*rows, machine=BUILDER, level=0, model="compiled", flush=False):
    """Rows of (cycle, address, bytes, requester, kind)."""
    array = np.array(list(rows), ACCESS)
    how = Play(model, 1, silent, at_cycles=True, flush=flush)
    return values(replay_with_time("t", lambda: iter([array.copy()]), machine, level, how))


@pytest.mark.parametrize("model", ["reference", "compiled"])
def test_accesses_are_made_at_their_cycles_whatever_was_answered(model):
    """A line of tiny's DRAM takes 20 cycles; two are under way together, so they take less than twice that."""
    one = at_cycles((100, 0, 4, 0, R), model=model)
    two = at_cycles((100, 0, 4, 0, R), (101, 1024, 4, 0, R), model=model)
    written = at_cycles((100, 0, 4, 0, W), model=model)

    assert one["replay.cycles"] == 120
    assert 120 < two["replay.cycles"] < 140
    assert written["replay.cycles"] == 120
    assert one["l1.reads"] == 1
    assert written["l1.writes"] == 1


def test_every_requester_asks_its_own_cache_at_its_cycles():
    rows = [(0, 0, 4, 0, R), (500, 0, 4, 8, R), (1000, 0, 4, 0, R), (1500, 0, 4, 1, R)]
    found = at_cycles(*rows, machine=PAPER)

    assert (found["fragment_l1.accesses"], found["fragment_l1.hits"], found["l2.reads"]) == (4, 2, 2)
    assert at_cycles(*rows, machine=PAPER, level=4)["l2.accesses"] == 4
    with pytest.raises(ArchsimError, match="requesters up to 32; the cores have 4 x 8 threads"):
        at_cycles((0, 0, 4, 32, R), machine=PAPER)


def test_a_pause_that_no_record_can_say_is_refused():
    with pytest.raises(ArchsimError, match="2147483648 cycles lie between two accesses"):
        at_cycles((2**31, 0, 4, 0, R))


@settings(max_examples=25, deadline=None)
@given(
    rows=st.lists(
        st.tuples(
            st.integers(0, 60), st.integers(0, 2000), st.sampled_from([1, 4, 8]), st.sampled_from(Kind)
        ),
        min_size=1,
        max_size=40,
    ),
    flush=st.booleans(),
)
def test_both_models_keep_to_the_cycles_alike(rows, flush):
    ends = np.cumsum([row[0] for row in rows]).tolist()
    accesses = [(end, *row[1:3], 0, row[3]) for end, row in zip(ends, rows, strict=True)]

    compiled = at_cycles(*accesses, flush=flush)

    assert compiled == at_cycles(*accesses, model="reference", flush=flush)
    assert compiled["replay.cycles"] >= ends[-1]


def test_a_flush_with_time_writes_down_what_is_dirty():
    """One line of the L1 is dirty; its L2 line, fetched by the write, becomes so and is written to the DRAM."""
    replay = replay_with_time("t", trace([(4, 4, 0, W)]), BUILDER, 0, Play("compiled", 1, silent, flush=True))
    found, plain = values(replay), timed(trace([(4, 4, 0, W)]))

    assert (found["l1.writebacks"], found["l2.writebacks"], found["dram.writes"]) == (1, 1, 1)
    assert (plain["l1.writebacks"], plain["dram.writes"]) == (0, 0)
    assert found["replay.cycles"] == plain["replay.cycles"] == 20
    assert found["dram.cycles"] > plain["dram.cycles"] == 20


def on_dram(*rows, machine=TINY, model="compiled"):
    """Rows of (cycle, address, kind)."""
    array = np.array([(cycle, address, 1, 0, kind) for cycle, address, kind in rows], ACCESS)
    part = dram_part(machine, None)
    return replay_on_dram("t", iter([array] if len(array) else []), part, model)


@pytest.mark.parametrize("model", ["reference", "compiled"])
def test_a_dram_alone_takes_requests_as_soon_as_its_queue_has_room(model):
    """tiny: lines of 64 bytes, 16 a row; ACT 0, RD 4 and 8, data from 7 to 15; the next lines' data follows."""
    found = on_dram(*[(0, 64 * line + 3, R) for line in range(8)], model=model)
    got = values(found)

    assert got["dram.requests"] == got["dram.reads"] == 8
    assert (got["dram.row_hits"], got["dram.row_misses"], got["dram.row_conflicts"]) == (4, 4, 0)
    assert got["dram.cycles"] == 4 + 3 + 8 * 8
    assert got["dram.gigabytes_per_second"] == pytest.approx(8 * 64 / 71)
    assert got["dram.peak_percent"] == pytest.approx(100 * 64 / 71)
    assert sum(bucket.reads for bucket in found.latency) == 8
    assert all(bucket.least <= bucket.most for bucket in found.latency)


def test_a_dram_alone_follows_the_cycles_of_the_trace():
    got = values(on_dram((0, 0, R), (1000, 64, R)))

    assert got["dram.cycles"] == 1000 + 3 + 8
    assert got["dram.longest_read_clocks"] == 15
    assert got["dram.median_read_clocks"] == 11
    assert got["dram.average_entry_clocks"] == 0


def test_addresses_beyond_the_memory_begin_again():
    capacity = dram_part(TINY, None).capacity_bytes
    assert values(on_dram((0, 0, R), (0, capacity, R)))["dram.row_conflicts"] == 0


def test_a_dram_without_requests():
    got = values(on_dram())
    assert got["dram.requests"] == got["dram.median_read_clocks"] == got["dram.gigabytes_per_second"] == 0


def test_an_unknown_dram_is_named():
    with pytest.raises(ArchsimError, match="which DRAM\\? The machine has no 'drum'; did you mean 'dram'"):
        dram_part(TINY, "drum")
