"""Writing text, byte by byte and compiled: what the formats share. Every function returns the place behind."""

from __future__ import annotations

import numpy as np

from archsim.jit import inlined

_ZERO, _LOWER_A = ord("0"), ord("a")


def letters(word: str) -> np.ndarray:
    """A word as `put_word` wants it."""
    return np.frombuffer(word.encode("ascii"), np.uint8)


@inlined
def put_word(text, at, word):
    for i in range(len(word)):
        text[at + i] = word[i]
    return at + len(word)


@inlined
def put_hexadecimal(text, at, value):
    shift = 0
    while value >> shift > 15:
        shift += 4
    while shift >= 0:
        digit = (value >> shift) & 15
        text[at] = _ZERO + digit if digit < 10 else _LOWER_A + digit - 10
        at += 1
        shift -= 4
    return at


@inlined
def put_decimal(text, at, value):
    end, rest = at + 1, value // 10
    while rest > 0:
        end += 1
        rest //= 10
    for place in range(end - 1, at - 1, -1):
        text[place] = _ZERO + value % 10
        value //= 10
    return end
