"""Dinero's traces: the traditional `din`, LABEL ADDRESS, and Dinero IV's extended `xdin`, LETTER ADDRESS SIZE ([D4]).

    0 1000          read of the word of 4 bytes at 0x1000; the rest of a line is a comment
    1 70f60888      write
    2 2cb5          instruction fetch, of the word at 0x2cb4: `din` knows words only
    3 1000          miscellaneous: like a read
    r 1000 10       read of 16 bytes; also w, i, m; numbers may begin with 0x

A line says by its first word which of the two it is. Copying back and invalidating (4, 5, c, v) is not replayed.
"""

from __future__ import annotations

import numpy as np

from archsim.jit import inlined
from archsim.trace.accesses import Kind
from archsim.trace.formats.print import letters, put_hexadecimal
from archsim.trace.formats.scan import NEWLINE, Problem, fill, hexadecimal, key_of, skip_blanks, word_at

LINE = "LABEL ADDRESS (0 read, 1 write, 2 instruction fetch, 3 other) or LETTER ADDRESS SIZE (r, w, i, m)"

_WORD_BYTES = 4
_MOST_BYTES = (1 << 16) - 1
_DIN_READ, _DIN_WRITE, _DIN_FETCH, _DIN_OTHER = key_of("0"), key_of("1"), key_of("2"), key_of("3")
_READ, _WRITE, _FETCH, _OTHER = key_of("r"), key_of("w"), key_of("i"), key_of("m")
_SMALL = key_of(" ")  # the bit that makes a letter small
_BLANK = ord(" ")
_LABELS, _LETTERS = letters("012"), letters("rwi")


@inlined
def scan_line(text, at, access):
    """The access on the line at this place."""
    label, end = word_at(text, at)
    kind = _kind_of(label | _SMALL)
    if kind < 0:
        return kind, at
    at = skip_blanks(text, end)
    address, end = hexadecimal(text, at)
    if address < 0:
        return address, at
    if label <= _DIN_OTHER:
        fill(access, kind, address & ~(_WORD_BYTES - 1), _WORD_BYTES)
        return np.int64(Problem.NONE), end

    at = skip_blanks(text, end)
    size, end = hexadecimal(text, at)
    if size == 0:
        size = np.int64(Problem.NO_SIZE)
    elif size > _MOST_BYTES:
        size = np.int64(Problem.TOO_LARGE)
    if size < 0:
        return size, at
    fill(access, kind, address, size)
    return np.int64(Problem.NONE), end


@inlined
def _kind_of(label):
    """Kind of the label, or a Problem."""
    if label in (_DIN_READ, _DIN_OTHER, _READ, _OTHER):
        return np.int64(Kind.READ)
    if label in (_DIN_WRITE, _WRITE):
        return np.int64(Kind.WRITE)
    if label in (_DIN_FETCH, _FETCH):
        return np.int64(Kind.FETCH)
    return np.int64(Problem.UNKNOWN_KIND)


@inlined
def put_din(text, at, access):
    """LABEL ADDRESS"""
    text[at] = _LABELS[access["kind"]]
    text[at + 1] = _BLANK
    at = put_hexadecimal(text, at + 2, access["address"])
    text[at] = NEWLINE
    return at + 1


@inlined
def put_xdin(text, at, access):
    """LETTER ADDRESS SIZE"""
    text[at] = _LETTERS[access["kind"]]
    text[at + 1] = _BLANK
    at = put_hexadecimal(text, at + 2, access["address"])
    text[at] = _BLANK
    at = put_hexadecimal(text, at + 1, access["bytes"])
    text[at] = NEWLINE
    return at + 1
