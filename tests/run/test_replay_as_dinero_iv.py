"""A replay without time prints what the command `dineroIV` of Dinero IV, version 7, prints for the same trace."""

from functools import partial

import pytest

from archsim.config import load_machine
from archsim.machine.build import group_machine
from archsim.run.progress import silent
from archsim.run.replay import replay_without_time
from archsim.run.replay_timed import Play, replay_with_time
from archsim.trace.files import read_accesses
from archsim.trace.formats.languages import format_named

COUNTS = ("reads", "writes", "read_misses", "write_misses", "bytes_read", "bytes_written")
THROUGH = "components.builder_l1.write_policy=write_through"
CASES = {  # options: what differs from tiny, its counts of both levels, and misses before it flushes
    "-l1-usize 256 -l1-uassoc 2 -l1-ubsize 32 -l2-usize 1k -l2-uassoc 2 -l2-ubsize 64": (
        [],
        (1312, 688, 991, 520, 48352, 20096),
        (1511, 628, 496, 77, 36672, 19648),
        (1511, 573),
    ),
    "-l1-usize 256 -l1-uassoc 8 -l1-ubsize 32 -l1-urepl f -l1-uwback n -l1-uwalloc n -l2-usize 1k -l2-ubsize 64": (
        [
            *("components.builder_l1.ways=8", "components.builder_l1.replacement=fifo", THROUGH),
            *("components.builder_l1.write_allocate=false", "components.l2.ways=1"),
        ],
        (1312, 688, 992, 510, 31744, 2752),
        (992, 688, 347, 177, 33536, 19520),
        (1502, 524),
    ),
    "-l1-usize 256 -l1-ubsize 32 -l1-usbsize 16 -l2-usize 1k -l2-uassoc 16 -l2-ubsize 64 -l2-urepl f -l2-uwalloc n": (
        [
            *("components.builder_l1.ways=1", "components.builder_l1.sector=16 B", "components.l2.ways=16"),
            *("components.l2.replacement=fifo", "components.l2.write_allocate=false"),
        ],
        (1312, 688, 1094, 582, 26816, 10304),
        (1676, 628, 598, 59, 38272, 24608),
        (1676, 657),
    ),
}


@pytest.fixture
def reopen(tmp_path):
    """2,000 loads, stores and instruction fetches of words, the nearer to 0 the more often, as `din`."""
    draw, lines = 1, []
    for _ in range(2000):
        draw = (1103515245 * draw + 12345) % 2**31
        lines.append(f"{(draw >> 16) % 3} {4 * ((draw >> 10) % 24) * ((draw >> 20) % 24):x}\n")
    (tmp_path / "a.din").write_text("".join(lines))
    return partial(read_accesses, tmp_path / "a.din", format_named("dinero"))


@pytest.mark.parametrize("options", CASES)
def test_every_count_is_the_one_that_dinero_iv_prints(reopen, options):
    """Its options are those and `-informat d`; it ends with a flush, before which `-stat-interval 2000` prints, too."""
    changes, first, second, misses = CASES[options]
    machine = group_machine(load_machine("machines/tiny.yaml", changes), "builder")
    flushed, with_time = (
        {one.name: one.value for one in replayed.statistics}
        for replayed in (
            replay_without_time("", reopen, machine, 0, flush=True),
            replay_with_time("", reopen, machine, 0, Play("compiled", 1, silent)),
        )
    )

    assert tuple(flushed[f"l1.{name}"] for name in COUNTS) == first
    assert tuple(flushed[f"l2.{name}"] for name in COUNTS) == second
    assert (with_time["l1.misses"], with_time["l2.misses"]) == misses
