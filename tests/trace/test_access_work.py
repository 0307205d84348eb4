"""From accesses to tasks: pieces within lines, and who makes which access."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from archsim.trace.access_work import dealt_work, requesters_work, split
from archsim.trace.accesses import ACCESS, Kind
from archsim.trace.records import Op


def accesses(*rows):
    """Accesses of (address, bytes, requester, kind)."""
    return np.array([(0, *row) for row in rows], ACCESS)


def operations(work):
    """(op, address, bytes) of every task."""
    tasks = []
    for chunk in work.chunks:
        for first, last in zip(chunk.starts[:-1], chunk.starts[1:], strict=True):
            records = chunk.records[first:last]
            assert records["op"][-1] == Op.END
            assert not records["compute"].any()
            tasks.append([(r["op"], r["address"], r["bytes"]) for r in records[:-1]])
    assert len(tasks) == work.num_tasks
    return tasks


def test_an_access_is_split_at_every_line():
    pieces = split(accesses((30, 70, 3, Kind.WRITE), (64, 32, 0, Kind.READ), (96, 1, 0, Kind.READ)), 32)

    assert pieces[["address", "bytes"]].tolist() == [(30, 2), (32, 32), (64, 32), (96, 4), (64, 32), (96, 1)]
    assert pieces["requester"].tolist() == [3, 3, 3, 3, 0, 0]
    assert pieces["kind"].tolist() == [Kind.WRITE] * 4 + [Kind.READ] * 2


@given(
    rows=st.lists(
        st.tuples(st.integers(0, 500), st.integers(1, 300), st.just(0), st.sampled_from(Kind)), max_size=9
    ),
    line_bytes=st.sampled_from([1, 16, 64, 1024]),
)
def test_pieces_cover_the_bytes_once_in_order(rows, line_bytes):
    pieces = split(accesses(*rows), line_bytes)

    bytes_of = [byte for address, size, _, _ in rows for byte in range(address, address + size)]
    assert [byte for p in pieces for byte in range(p["address"], p["address"] + p["bytes"])] == bytes_of
    last = pieces["address"] + pieces["bytes"] - 1
    assert (pieces["address"] // line_bytes == last // line_bytes).all()


def test_dealt_work_is_a_task_for_each_piece():
    chunks = [accesses((0, 4, 0, Kind.READ), (30, 4, 0, Kind.WRITE)), accesses((64, 4, 0, Kind.FETCH))]

    assert operations(dealt_work(lambda: iter(chunks), 32)) == [
        [(Op.LOAD, 0, 4)],
        [(Op.STORE, 30, 2)],
        [(Op.STORE, 32, 2)],
        [(Op.LOAD, 64, 4)],
    ]


def test_requesters_have_a_task_in_every_chunk():
    chunks = [
        accesses((0, 4, 2, Kind.READ), (8, 4, 0, Kind.READ), (16, 4, 2, Kind.WRITE)),
        accesses((24, 4, 1, Kind.READ)),
    ]

    assert operations(requesters_work(lambda: iter(chunks), 32, 3)) == [
        [(Op.LOAD, 8, 4)],
        [],
        [(Op.LOAD, 0, 4), (Op.STORE, 16, 4)],
        [],
        [(Op.LOAD, 24, 4)],
        [],
    ]


def test_long_pieces_fit_into_records():
    work = dealt_work(lambda: iter([accesses((0, 1 << 16, 0, Kind.READ))]), 1 << 20)
    assert operations(work) == [[(Op.LOAD, 0, 32767)]]
