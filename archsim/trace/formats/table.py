"""Our own format, which loses nothing: comma-separated values under the header `cycle,address,kind,bytes,requester`.

    cycle,address,kind,bytes,requester
    120,0x1000,read,16,0
    121,0x1040,write,16,1

Columns may stand in any order; `address` and `kind` (read, write, fetch) must be there. Missing ones: cycle 0, bytes 1,
requester 0. Numbers are decimal, or hexadecimal with 0x.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from archsim.errors import Location, did_you_mean, fail
from archsim.jit import inlined
from archsim.trace.accesses import Kind
from archsim.trace.formats.print import letters, put_decimal, put_hexadecimal, put_word
from archsim.trace.formats.scan import (
    COMMA,
    NEWLINE,
    Problem,
    fill,
    integer,
    key_of,
    rest,
    skip_blanks,
    word_at,
)

LINE = "fields as the header says, e.g. 120,0x1000,read,16,0"
HEADER = "cycle,address,kind,bytes,requester"


class Column(IntEnum):
    """What a field of a line is, in the order in which lines are written."""

    CYCLE = 0
    ADDRESS = 1
    KIND = 2
    BYTES = 3
    REQUESTER = 4


_READ, _WRITE, _FETCH = key_of("read"), key_of("write"), key_of("fetch")
_PUT_READ, _PUT_WRITE, _PUT_FETCH = letters(",read,"), letters(",write,"), letters(",fetch,")
_HEXADECIMAL = letters(",0x")
_MOST_BYTES, _MOST_REQUESTERS = (1 << 31) - 1, 1 << 15


def columns_of(header: str, where: Location) -> np.ndarray:
    """Column of each field of a line under the header. ArchsimError if it names a wrong set of columns."""
    names = [name.strip() for name in header.split(",")]
    known = [column.name.lower() for column in Column]
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known) or f"the columns are {HEADER}"
            raise fail(f"no column is named '{name[:40]}'", where, hint)
    for name in known:
        if names.count(name) > 1:
            raise fail(f"column '{name}' stands there twice", where)
    for name in ("address", "kind"):
        if name not in names:
            raise fail(f"column '{name}' is missing", where, f"the columns are {HEADER}")
    return np.array([known.index(name) for name in names], np.int64)


@inlined
def scan_line(text, at, access, columns):
    """The access on the line at this place, whose fields are these columns."""
    fill(access, Kind.READ, 0, 1)
    for i in range(len(columns)):
        at = skip_blanks(text, at)
        value, end = _field(text, at, columns[i])
        if value < 0:
            return value, at
        _set(access, columns[i], value)
        if i + 1 < len(columns):
            at = skip_blanks(text, end)
            if text[at] != COMMA:
                return np.int64(Problem.MISSING if text[at] == NEWLINE else Problem.REST), at
            end = at + 1
        at = end
    return rest(text, at)


@inlined
def _field(text, at, column):
    """Value of the field at this place, or a Problem, and the place behind."""
    if column == Column.KIND:
        word, end = word_at(text, at)
        return _kind_of(word), end
    value, end = integer(text, at)
    if column == Column.BYTES and value == 0:
        return np.int64(Problem.NO_SIZE), end
    if column == Column.BYTES and value > _MOST_BYTES:
        return np.int64(Problem.TOO_LARGE), end
    if column == Column.REQUESTER and value >= _MOST_REQUESTERS:
        return np.int64(Problem.TOO_LARGE), end
    return value, end


@inlined
def _kind_of(word):
    """Kind of the word, or a Problem."""
    if word == _READ:
        return np.int64(Kind.READ)
    if word == _WRITE:
        return np.int64(Kind.WRITE)
    if word == _FETCH:
        return np.int64(Kind.FETCH)
    return np.int64(Problem.UNKNOWN_KIND)


@inlined
def _set(access, column, value):
    """The field's value becomes the access's."""
    if column == Column.CYCLE:
        access["cycle"] = value
    elif column == Column.ADDRESS:
        access["address"] = value
    elif column == Column.KIND:
        access["kind"] = value
    elif column == Column.BYTES:
        access["bytes"] = value
    else:
        access["requester"] = value


@inlined
def put_line(text, at, access):
    """cycle,address,kind,bytes,requester"""
    at = put_decimal(text, at, access["cycle"])
    at = put_word(text, at, _HEXADECIMAL)
    at = put_hexadecimal(text, at, access["address"])
    if access["kind"] == Kind.WRITE:
        at = put_word(text, at, _PUT_WRITE)
    else:
        at = put_word(text, at, _PUT_FETCH if access["kind"] == Kind.FETCH else _PUT_READ)
    at = put_decimal(text, at, access["bytes"])
    text[at] = COMMA
    at = put_decimal(text, at + 1, access["requester"])
    text[at] = NEWLINE
    return at + 1
