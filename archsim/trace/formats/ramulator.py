"""Ramulator's memory traces: `0xADDRESS R|W` of version 1 ([R1]), `LD|ST ADDRESS` of version 2's LoadStoreTrace ([R2]).

    0x12345680 R    read; the address is hexadecimal with or without 0x, as [R1] reads it
    LD 0x12345680   read; the address is hexadecimal with 0x and decimal without, as [R2] reads it

A line says by its first word which of the two it is. There is no size: an access is 1 byte, which lies in one request.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import inlined
from archsim.trace.accesses import Kind
from archsim.trace.formats.print import letters, put_hexadecimal, put_word
from archsim.trace.formats.scan import (
    NEWLINE,
    Problem,
    fill,
    hexadecimal,
    integer,
    key_of,
    rest,
    skip_blanks,
    word_at,
)

LINE = "0xADDRESS R|W or LD|ST ADDRESS"

_R, _W, _LD, _ST = key_of("R"), key_of("W"), key_of("LD"), key_of("ST")
_HEXADECIMAL, _READ, _WRITE = letters("0x"), letters(" R\n"), letters(" W\n")
_LOAD, _STORE = letters("LD 0x"), letters("ST 0x")


@inlined
def scan_line(text, at, access):
    """The access on the line at this place."""
    first, end = word_at(text, at)
    if first in (_LD, _ST):
        return _scan_load_store(text, skip_blanks(text, end), access, first == _ST)

    address, end = hexadecimal(text, at)
    if address < 0:
        return address, at
    at = skip_blanks(text, end)
    what, end = word_at(text, at)
    if what != _R and what != _W:
        return np.int64(Problem.MISSING if text[at] == NEWLINE else Problem.UNKNOWN_KIND), at
    fill(access, Kind.WRITE if what == _W else Kind.READ, address, 1)
    return rest(text, end)


@inlined
def _scan_load_store(text, at, access, is_store):
    """The access whose address is at this place."""
    address, end = integer(text, at)
    if address < 0:
        return address, at
    fill(access, Kind.WRITE if is_store else Kind.READ, address, 1)
    return rest(text, end)


@inlined
def put_line(text, at, access):
    """0xADDRESS R|W"""
    at = put_word(text, at, _HEXADECIMAL)
    at = put_hexadecimal(text, at, access["address"])
    return put_word(text, at, _WRITE if access["kind"] == Kind.WRITE else _READ)


@inlined
def put_load_store(text, at, access):
    """LD|ST 0xADDRESS"""
    at = put_word(text, at, _STORE if access["kind"] == Kind.WRITE else _LOAD)
    at = put_hexadecimal(text, at, access["address"])
    text[at] = NEWLINE
    return at + 1
