"""What a trace holds, counted by hand."""

import numpy as np

from archsim.trace.accesses import ACCESS, Kind
from archsim.trace.summary import Summary, summarize


def test_a_trace_is_counted():
    first = np.array([(3, 0x100, 4, 0, Kind.READ), (5, 0x13E, 4, 7, Kind.WRITE)], ACCESS)
    second = np.array([(9, 0x100, 16, 7, Kind.FETCH)], ACCESS)

    assert summarize(iter([first, second])) == Summary(
        accesses=3,
        reads=1,
        writes=1,
        fetches=1,
        bytes=24,
        footprint_bytes=128,  # 0x100 and 0x140: the write crosses into it
        requesters=2,
        first_cycle=3,
        last_cycle=9,
        lowest_address=0x100,
        highest_address=0x141,
    )


def test_an_empty_trace_is_all_zeros():
    assert set(summarize(iter([]))) == {0}


def test_the_footprint_counts_each_block_once_whatever_the_chunks():
    chunks = [np.zeros(50, ACCESS) for _ in range(20)]
    for number, chunk in enumerate(chunks):
        chunk["address"] = (np.arange(50) + 25 * number) * 64
        chunk["bytes"] = 1
    assert summarize(iter(chunks)).footprint_bytes == (25 * 19 + 50) * 64
