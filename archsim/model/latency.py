"""Latencies in classes that grow with them: exact below 8 cycles, then four classes to each power of two."""

from __future__ import annotations

from archsim.jit import bit_length

NUM_CLASSES = 128  # the last one holds all that is longer


def class_of(cycles: int) -> int:
    """Number of the class of a latency; also compiled."""
    octave = bit_length(cycles >> 3)
    return min(4 * octave + (cycles >> octave), NUM_CLASSES - 1)


def shortest(number: int) -> int:
    """The shortest latency of a class, in cycles."""
    octave = max(0, number // 4 - 1)
    return (number - 4 * octave) << octave
