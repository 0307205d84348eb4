"""DRAMsim3's traces: `0xADDRESS READ|WRITE CYCLE`, cycles of the memory clock in decimal ([DS3]).

DRAMsim2's words P_MEM_RD, P_MEM_WR, P_FETCH and BOFF are known too. There is no size: an access is 1 byte, which lies
in one request.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import inlined
from archsim.trace.accesses import Kind
from archsim.trace.formats.print import letters, put_decimal, put_hexadecimal, put_word
from archsim.trace.formats.scan import (
    NEWLINE,
    Problem,
    decimal,
    fill,
    hexadecimal,
    key_of,
    rest,
    skip_blanks,
    word_at,
)

LINE = "0xADDRESS READ|WRITE CYCLE"

_READ, _READ_SMALL, _READ_2, _FETCH_2 = key_of("READ"), key_of("read"), key_of("P_MEM_RD"), key_of("P_FETCH")
_WRITE, _WRITE_SMALL, _WRITE_2, _BOFF = key_of("WRITE"), key_of("write"), key_of("P_MEM_WR"), key_of("BOFF")
_HEXADECIMAL, _PUT_READ, _PUT_WRITE = letters("0x"), letters(" READ "), letters(" WRITE ")


@inlined
def scan_line(text, at, access):
    """The access on the line at this place."""
    address, end = hexadecimal(text, at)
    if address < 0:
        return address, at
    at = skip_blanks(text, end)
    word, end = word_at(text, at)
    kind = np.int64(Problem.MISSING) if text[at] == NEWLINE else _kind_of(word)
    if kind < 0:
        return kind, at
    at = skip_blanks(text, end)
    cycle, end = decimal(text, at)
    if cycle < 0:
        return cycle, at
    fill(access, kind, address, 1)
    access["cycle"] = cycle
    return rest(text, end)


@inlined
def _kind_of(word):
    """Kind of the word, or a Problem."""
    if word in (_READ, _READ_SMALL, _READ_2):
        return np.int64(Kind.READ)
    if word in (_WRITE, _WRITE_SMALL, _WRITE_2, _BOFF):
        return np.int64(Kind.WRITE)
    if word == _FETCH_2:
        return np.int64(Kind.FETCH)
    return np.int64(Problem.UNKNOWN_KIND)


@inlined
def put_line(text, at, access):
    """0xADDRESS READ|WRITE CYCLE"""
    at = put_word(text, at, _HEXADECIMAL)
    at = put_hexadecimal(text, at, access["address"])
    at = put_word(text, at, _PUT_WRITE if access["kind"] == Kind.WRITE else _PUT_READ)
    at = put_decimal(text, at, access["cycle"])
    text[at] = NEWLINE
    return at + 1
