"""What the arithmetic opcodes compute, on float32 and in IEEE order: no fused or reordered operations.

Sources and results are tuples of four float32 (x, y, z, w). Transcendental functions are computed in double
precision and rounded once. NaN propagates, also through MIN, MAX and the set-on opcodes.
"""

import math

import numpy as np

from archsim.isa.opcodes import Opcode
from archsim.isa.program import EQUAL, GREATER, LESS, UNORDERED
from archsim.jit import inlined

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_LARGEST_RECIPROCAL, _SMALLEST_RECIPROCAL = np.float32(2.0**64), np.float32(2.0**-64)
_LOWEST_ADDRESS, _HIGHEST_ADDRESS = np.float32(-512.0), np.float32(511.0)
_HIGHEST_INTEGER = np.float32(2**24 - 1)
_LIT_POWER = 128.0


@inlined
def flag_of(value):
    """The condition code that a written value sets."""
    if value > _ZERO:
        return GREATER
    if value < _ZERO:
        return LESS
    return EQUAL if value == _ZERO else UNORDERED


@inlined
def one_source(op, a):
    """MOV, ABS, FLR, FRC, SSG of one component."""
    if op == Opcode.ABS:
        return np.float32(abs(a))
    if op == Opcode.FLR:
        return np.float32(np.floor(a))
    if op == Opcode.FRC:
        return np.float32(a - np.float32(np.floor(a)))
    if op == Opcode.SSG:
        return _sign(a)
    return a


@inlined
def _sign(a):
    if a > _ZERO:
        return _ONE
    if a < _ZERO:
        return -_ONE
    return _ZERO if a == _ZERO else a


@inlined
def two_sources(op, a, b):
    """ADD ... STR of one component."""
    if op == Opcode.ADD:
        return np.float32(a + b)
    if op == Opcode.MUL:
        return np.float32(a * b)
    if op == Opcode.SUB:
        return np.float32(a - b)
    if op == Opcode.SFL:
        return _ZERO
    if op == Opcode.STR:
        return _ONE
    if op == Opcode.SHL or op == Opcode.SHR:
        return _shift(op, a, b)
    if a != a:
        return a
    return b if b != b else _ordered(op, a, b)


@inlined
def _ordered(op, a, b):
    """MIN, MAX and the set-on opcodes of two numbers that are not NaN."""
    if op == Opcode.MIN:
        return a if a < b else b
    if op == Opcode.MAX:
        return a if a > b else b
    if op == Opcode.SEQ:
        return _truth(a == b)
    if op == Opcode.SNE:
        return _truth(a != b)
    if op == Opcode.SGE:
        return _truth(a >= b)
    if op == Opcode.SGT:
        return _truth(a > b)
    if op == Opcode.SLE:
        return _truth(a <= b)
    return _truth(a < b)


@inlined
def _truth(condition):
    return _ONE if condition else _ZERO


@inlined
def _shift(op, a, b):
    """Logical shift of 24-bit integers held in floats: truncated and clamped to 0 ... 2^24 - 1, NaN stays."""
    if a != a:
        return a
    if b != b:
        return b
    value, count = _integer(a), _integer(b)
    if count > 23:
        return _ZERO
    shifted = value >> count if op == Opcode.SHR else (value << count) & 0xFFFFFF
    return np.float32(shifted)


@inlined
def _integer(a):
    return np.int64(min(max(a, _ZERO), _HIGHEST_INTEGER))


@inlined
def multiply_add(a, b, c):
    """MAD of one component."""
    return np.float32(np.float32(a * b) + c)


@inlined
def dot(op, a, b):
    """DP3, DP4, DPH: products added from left to right."""
    total = np.float32(np.float32(a[0] * b[0]) + np.float32(a[1] * b[1]))
    total = np.float32(total + np.float32(a[2] * b[2]))
    if op == Opcode.DP4:
        total = np.float32(total + np.float32(a[3] * b[3]))
    if op == Opcode.DPH:
        total = np.float32(total + b[3])
    return total


@inlined
def distance(a, b):
    """DST."""
    return _ONE, np.float32(a[1] * b[1]), a[2], b[3]


@inlined
def light(a):
    """LIT: ambient, diffuse and specular factors; 0 to the power 0 is 1."""
    diffuse = _ZERO if a[0] < _ZERO else a[0]
    base = _ZERO if a[1] < _ZERO else a[1]
    power = min(max(np.float64(a[3]), -_LIT_POWER), _LIT_POWER) if a[3] == a[3] else np.float64(a[3])
    specular = np.float32(np.power(np.float64(base), power)) if a[0] > _ZERO else _ZERO
    return _ONE, diffuse, specular, _ONE


@inlined
def function(op, a):
    """COS, EX2, LG2, RCC, RCP, RSQ, SIN of a scalar."""
    if op == Opcode.RCP:
        return np.float32(_ONE / a)
    if op == Opcode.RSQ:
        return np.float32(1.0 / np.sqrt(np.float64(a)))
    if op == Opcode.RCC:
        return _clamped(np.float32(_ONE / a))
    if op == Opcode.EX2:
        return np.float32(np.exp2(np.float64(a)))
    if op == Opcode.LG2:
        return np.float32(np.log2(np.float64(a)))
    if op == Opcode.COS:
        return np.float32(np.cos(np.float64(a)))
    return np.float32(np.sin(np.float64(a)))


@inlined
def _clamped(a):
    if a != a:
        return a
    size = min(max(np.float32(abs(a)), _SMALLEST_RECIPROCAL), _LARGEST_RECIPROCAL)
    return np.float32(np.copysign(size, a))


@inlined
def exponential(a):
    """EXP."""
    whole = np.float32(np.floor(a))
    power = np.float32(np.exp2(np.float64(a)))
    return np.float32(np.exp2(np.float64(whole))), np.float32(a - whole), power, _ONE


@inlined
def logarithm(a):
    """LOG: exponent, mantissa, logarithm; (-inf, 1, -inf, 1) of 0 and (inf, 1, inf, 1) of infinity."""
    size = np.float64(abs(a))
    whole = np.float32(np.log2(size))
    if size != size or size == 0.0 or size == np.inf:
        return whole, np.float32(whole if size != size else 1.0), whole, _ONE
    mantissa, exponent = math.frexp(size)
    return np.float32(exponent - 1), np.float32(mantissa * 2.0), whole, _ONE


@inlined
def address(op, a):
    """ARL, ARR of one component; NaN gives 0."""
    if a != a:
        return _ZERO
    whole = np.float32(np.floor(a)) if op == Opcode.ARL else np.float32(np.rint(a))
    return min(max(whole, _LOWEST_ADDRESS), _HIGHEST_ADDRESS)


@inlined
def address_sum(a):
    """ARA."""
    left = min(max(np.float32(a[0] + a[2]), _LOWEST_ADDRESS), _HIGHEST_ADDRESS)
    right = min(max(np.float32(a[1] + a[3]), _LOWEST_ADDRESS), _HIGHEST_ADDRESS)
    return left, right, left, right
