"""Every arithmetic opcode against NumPy in single precision, on all pairs of awkward numbers."""

import numpy as np
import pytest

from archsim.execute.interpreter import execute
from archsim.execute.memory import Window, new_memory
from archsim.isa.assembler import assemble
from archsim.isa.opcodes import VALUE_SHAPES, Opcode

F = np.float32
AWKWARD = [0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 1.5, 3.0, 7.25, -130.0, 600.0, 1e-40, -1e-40, 1e-20, 3e38, -3e38]
AWKWARD += [np.inf, -np.inf, np.nan, 16777215.0, 16777216.0, 23.0, 24.0, 2.0**70, -(2.0**-70), 0.99999994]


def inputs() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Three float32 [num_tasks, 4]: every pair of awkward numbers in x, others mixed into y, z, w; and random ones."""
    a, b = (grid.ravel() for grid in np.meshgrid(AWKWARD, AWKWARD))
    rng = np.random.default_rng(5)
    columns = []
    for values in (a, b, b[::-1]):
        rolled = [values] + [rng.permutation(values) for _ in range(3)]
        usual = rng.normal(0, 4, (500, 4))
        columns.append(np.concatenate([np.stack(rolled, 1), usual]).astype(F))
    return columns[0], columns[1], columns[2]


A, B, C = inputs()


def run(op: Opcode) -> np.ndarray:
    """Results of the opcode: float32 [num_tasks, 4]; address registers are read back through c[A0.x + 0 ...]."""
    texts = ["R1", "R2", "R3"][: len(op.reads)]
    if op.is_scalar:
        texts = ["R1.x"]
    numbers = np.zeros_like(A)
    numbers[:, 0] = np.arange(len(A))
    body = (
        f"MOV R1, v[0]; MOV R2, v[1]; MOV R3, v[2]; {op.name} R0, {', '.join(texts)}; ST [B0 | v[3].x], R0;"
    )
    memory = new_memory(1 << 16)
    program = assemble(f"!!VP2.0 {body} END")
    execute(program, np.stack([A, B, C, numbers], 1), np.zeros((256, 4), F), both(1 << 16), memory)
    return memory[: 4 * len(A)].reshape(-1, 4)


def both(size: int) -> tuple[Window, Window]:
    return Window(0, size), Window(0, size)


def same_where_not_nan(value, a, b):
    return np.where(np.isnan(a), a, np.where(np.isnan(b), b, value)).astype(F)


def rounded(function):
    """A scalar function of x in double precision, rounded, in all components."""
    return lambda a, b, c: np.repeat(function(a[:, :1].astype(np.float64)).astype(F), 4, axis=1)


def columns(*parts):
    return np.stack([np.broadcast_to(np.asarray(part, F), len(A)) for part in parts], 1)


def everywhere(value):
    return columns(value, value, value, value)


def dot(a, b, num_products):
    products = a * b
    total = products[:, 0] + products[:, 1]
    for k in range(2, num_products):
        total = total + products[:, k]
    return total


def light(a):
    power = np.clip(a[:, 3].astype(np.float64), -128, 128)
    base = np.where(a[:, 1] < 0, 0, a[:, 1]).astype(np.float64)
    specular = np.where(a[:, 0] > 0, np.power(base, power), 0)
    return columns(1, np.where(a[:, 0] < 0, F(0), a[:, 0]), specular, 1)


def clamped_reciprocal(a):
    reciprocal = F(1) / a
    size = np.clip(np.abs(reciprocal), F(2.0**-64), F(2.0**64))
    return everywhere(np.copysign(size, reciprocal)[:, 0])


def exponential(a):
    x = a[:, 0]
    return columns(np.exp2(np.floor(x).astype(np.float64)), x - np.floor(x), np.exp2(x.astype(np.float64)), 1)


def logarithm(a):
    x = np.abs(a[:, 0].astype(np.float64))
    mantissa, exponent = np.frexp(x)
    proper = np.isfinite(x) & (x > 0)
    log = np.log2(x)
    return columns(
        np.where(proper, exponent - 1, log),
        np.where(proper, 2 * mantissa, np.where(np.isnan(x), x, 1)),
        log,
        1,
    )


def shift(a, b, left):
    def integer(x):
        return np.clip(np.nan_to_num(x, nan=0.0), 0, 2**24 - 1).astype(np.int64)

    count = np.minimum(integer(b), 24)
    shifted = (integer(a) << count) & 0xFFFFFF if left else integer(a) >> count
    return same_where_not_nan(shifted, a, b)


ORACLE = {
    Opcode.MOV: lambda a, b, c: a,
    Opcode.ABS: lambda a, b, c: np.abs(a),
    Opcode.FLR: lambda a, b, c: np.floor(a),
    Opcode.FRC: lambda a, b, c: a - np.floor(a),
    Opcode.SSG: lambda a, b, c: np.sign(a) + F(0),
    Opcode.ADD: lambda a, b, c: a + b,
    Opcode.SUB: lambda a, b, c: a - b,
    Opcode.MUL: lambda a, b, c: a * b,
    Opcode.MIN: lambda a, b, c: same_where_not_nan(np.where(a < b, a, b), a, b),
    Opcode.MAX: lambda a, b, c: same_where_not_nan(np.where(a > b, a, b), a, b),
    Opcode.SEQ: lambda a, b, c: same_where_not_nan(a == b, a, b),
    Opcode.SFL: lambda a, b, c: np.zeros_like(a),
    Opcode.SGE: lambda a, b, c: same_where_not_nan(a >= b, a, b),
    Opcode.SGT: lambda a, b, c: same_where_not_nan(a > b, a, b),
    Opcode.SLE: lambda a, b, c: same_where_not_nan(a <= b, a, b),
    Opcode.SLT: lambda a, b, c: same_where_not_nan(a < b, a, b),
    Opcode.SNE: lambda a, b, c: same_where_not_nan(a != b, a, b),
    Opcode.STR: lambda a, b, c: np.ones_like(a),
    Opcode.MAD: lambda a, b, c: a * b + c,
    Opcode.DP3: lambda a, b, c: everywhere(dot(a, b, 3)),
    Opcode.DP4: lambda a, b, c: everywhere(dot(a, b, 4)),
    Opcode.DPH: lambda a, b, c: everywhere(dot(a, b, 3) + b[:, 3]),
    Opcode.DST: lambda a, b, c: columns(1, a[:, 1] * b[:, 1], a[:, 2], b[:, 3]),
    Opcode.LIT: lambda a, b, c: light(a),
    Opcode.COS: rounded(np.cos),
    Opcode.EX2: rounded(np.exp2),
    Opcode.EXP: lambda a, b, c: exponential(a),
    Opcode.LG2: rounded(np.log2),
    Opcode.LOG: lambda a, b, c: logarithm(a),
    Opcode.RCC: lambda a, b, c: clamped_reciprocal(a),
    Opcode.RCP: lambda a, b, c: everywhere((F(1) / a)[:, 0]),
    Opcode.RSQ: rounded(lambda x: 1 / np.sqrt(x)),
    Opcode.SIN: rounded(np.sin),
    Opcode.SHL: lambda a, b, c: shift(a, b, left=True),
    Opcode.SHR: lambda a, b, c: shift(a, b, left=False),
}
# NumPy and the C library may differ in the last bit of these
TRANSCENDENTAL = {
    Opcode.COS,
    Opcode.SIN,
    Opcode.EX2,
    Opcode.EXP,
    Opcode.LG2,
    Opcode.LOG,
    Opcode.LIT,
    Opcode.RSQ,
}


def test_oracle_knows_every_opcode_that_writes_values():
    assert set(ORACLE) == {op for op in Opcode if op.shape in VALUE_SHAPES}


@pytest.mark.parametrize("op", list(ORACLE))
def test_opcode(op):
    with np.errstate(all="ignore"):
        expected = ORACLE[op](A, B, C)
    assert expected.dtype == F
    if op in TRANSCENDENTAL:
        np.testing.assert_array_max_ulp(run(op), expected, maxulp=1)
    else:
        np.testing.assert_array_equal(run(op), expected)
        here = ~np.isnan(expected)
        np.testing.assert_array_equal(np.signbit(run(op))[here], np.signbit(expected)[here])


def through_address(instructions: str, x: float) -> float:
    """R0.x after the instructions, which find x in R1; c[k] holds k in its x, and c[1] = (1, 2, 3, 4)."""
    constants = np.zeros((256, 4), F)
    constants[:, 0] = np.arange(256)
    constants[1] = [1, 2, 3, 4]
    attributes = np.full((1, 1, 4), x, F)
    text = f"!!VP2.0 MOV R1, v[0]; {instructions} ST [B0 | c[0].x].x, R0; END"
    memory = new_memory(64)
    execute(assemble(text), attributes, constants, both(64), memory)
    return float(memory[0])


@pytest.mark.parametrize(
    ("x", "floor", "nearest"), [(2.5, 2, 2), (3.5, 3, 4), (2.75, 2, 3), (255.0, 255, 255), (np.nan, 0, 0)]
)
def test_address_register_rounds(x, floor, nearest):
    assert through_address("ARL A0.x, R1; MOV R0, c[A0.x];", x) == floor
    assert through_address("ARR A1.y, R1; MOV R0, c[A1.y];", x) == nearest


def test_address_register_clamps():
    assert through_address("ARL A0, R1; MOV R0, c[A0.x - 256];", 1e9) == 255  # 511 - 256
    assert through_address("ARL A0, R1; ARA A0, A0; ARA A0, A0; MOV R0, c[A0.x - 256];", 200.0) == 255
    both_ways = "ARL A0, -R1; ARL A1, R1; ARA A0.x, A0; MOV R0.x, c[A1.x - 256]; MOV R0.x, c[A0.x + 255];"
    assert through_address(both_ways, 511.0) == 0  # -512 + 255 is outside


def test_parameters_outside_are_zero():
    assert through_address("STR R0, R0, R0; ARL A0.x, R1; MOV R0, c[A0.x + 1];", 255.0) == 0
    assert through_address("STR R0, R0, R0; ARL A0.x, R1; MOV R0, c[A0.x];", -1.0) == 0
    assert through_address("STR R0, R0, R0; ARL A0.x, R1; MOV R0, c[A0.x + 1];", 254.0) == 255


def test_ara_adds_the_halves():
    sums = [f"MUL R1, R1, c[1]; ARL A0, R1; ARA A1, A0; MOV R0, c[A1.{letter}];" for letter in "xyzw"]
    assert [through_address(one, 10.0) for one in sums] == [10 + 30, 20 + 40, 10 + 30, 20 + 40]
