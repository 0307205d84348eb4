"""Reading text, byte by byte and compiled: what the formats share.

A text is an array of bytes in which every line ends with a newline, so that no scan leaves it. Scans return a value
and the place behind it; a value below 0 is a Problem, and the place is where it is.

Every format has a function `scan_line` that fills an access from the line at a place and returns a Problem and the
place where it is, or the place behind what was read.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from archsim.jit import inlined

NEWLINE, COMMA = ord("\n"), ord(",")

_TAB, _RETURN, _SPACE = ord("\t"), ord("\r"), ord(" ")
_ZERO, _NINE, _LOWER_A, _LOWER_F, _LOWER_X = ord("0"), ord("9"), ord("a"), ord("f"), ord("x")
_LOWER_CASE = 0x20  # the bit that tells small letters from capital ones
_LONGEST_WORD = 8


class Problem(IntEnum):
    """What can be wrong with a line."""

    NONE = 0
    MISSING = -1
    NOT_HEXADECIMAL = -2
    NOT_DECIMAL = -3
    TOO_LARGE = -4
    UNKNOWN_KIND = -5
    NO_SIZE = -6
    REST = -7
    BACKWARDS = -8


MESSAGES = {
    Problem.MISSING: "the line ends too early",
    Problem.NOT_HEXADECIMAL: "not a number in hexadecimal digits",
    Problem.NOT_DECIMAL: "not a number",
    Problem.TOO_LARGE: "the number is too large",
    Problem.UNKNOWN_KIND: "not a kind of access",
    Problem.NO_SIZE: "an access has at least 1 byte",
    Problem.REST: "something follows that does not belong here",
    Problem.BACKWARDS: "the cycle lies before that of the line before",
}


def key_of(word: str) -> int:
    """The number by which `word_at` knows a word of up to 8 characters."""
    return int.from_bytes(word.encode("ascii"), "big")


@inlined
def is_blank(byte):
    return byte in (_SPACE, _TAB, _RETURN)


@inlined
def is_end(byte):
    """Whether a word ends before this byte."""
    return (byte <= _SPACE and (is_blank(byte) or byte == NEWLINE)) or byte == COMMA


@inlined
def skip_blanks(text, at):
    """The first place from `at` on that is not blank."""
    while is_blank(text[at]):
        at += 1
    return at


@inlined
def next_line(text, at):
    """The place behind the newline that ends the line of `at`."""
    while text[at] != NEWLINE:
        at += 1
    return at + 1


@inlined
def rest(text, at):
    """The Problem of a line that goes on where it should end."""
    at = skip_blanks(text, at)
    return np.int64(Problem.NONE if text[at] == NEWLINE else Problem.REST), at


@inlined
def fill(access, kind, address, num_bytes):
    """An access of requester 0 at a cycle that the format doesn't say."""
    access["cycle"] = 0
    access["address"] = address
    access["bytes"] = num_bytes
    access["requester"] = 0
    access["kind"] = kind


@inlined
def word_at(text, at):
    """`key_of` the word at this place, 0 if it is too long or there is none."""
    key, end = np.int64(0), at
    while not is_end(text[end]):
        key = key << 8 | np.int64(text[end])
        end += 1
    return (key if end - at <= _LONGEST_WORD else np.int64(0)), end


@inlined
def hexadecimal(text, at):
    """The number of up to 62 bits at this place; it may begin with 0x."""
    if is_end(text[at]):
        return np.int64(Problem.MISSING), at
    end = at
    if text[at] == _ZERO and (text[at + 1] | _LOWER_CASE) == _LOWER_X:
        end += 2
    value, first = np.int64(0), end
    while True:
        byte = text[end]
        digit = np.int64(byte) - _ZERO
        if digit < 0 or digit > 9:
            digit = np.int64(byte | _LOWER_CASE) - _LOWER_A + 10
            if digit < 10 or digit > 15:
                break
        if value >> 58 != 0:
            return np.int64(Problem.TOO_LARGE), at
        value = value << 4 | digit
        end += 1
    if end == first or not is_end(text[end]):
        return np.int64(Problem.NOT_HEXADECIMAL), at
    return value, end


@inlined
def decimal(text, at):
    """The decimal number of up to 62 bits at this place."""
    if is_end(text[at]):
        return np.int64(Problem.MISSING), at
    value, end = np.int64(0), at
    while _ZERO <= text[end] <= _NINE:
        if value >= 1 << 58:
            return np.int64(Problem.TOO_LARGE), at
        value = value * 10 + (np.int64(text[end]) - _ZERO)
        end += 1
    if end == at or not is_end(text[end]):
        return np.int64(Problem.NOT_DECIMAL), at
    return value, end


@inlined
def integer(text, at):
    """The number at this place: hexadecimal if it begins with 0x, else decimal."""
    if text[at] == _ZERO and (text[at + 1] | _LOWER_CASE) == _LOWER_X:
        return hexadecimal(text, at)
    return decimal(text, at)
