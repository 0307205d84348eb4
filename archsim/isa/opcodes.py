"""The opcode table: one row an instruction, read by assembler, disassembler, encoder, interpreter and README.

The first 39 rows are NV_vertex_program2's (VP2); the last seven are what [Johnson04] sec. 6 adds to it.
"""

from __future__ import annotations

from enum import Enum, IntEnum

COMPONENTS = "xyzw"
OWN = "own"  # a component of the result reads the same component of the source


class Shape(Enum):
    """The operands an instruction is written with, in order."""

    VECTOR = "dst, vec"
    SCALAR = "dst, scalar"
    VECTOR_VECTOR = "dst, vec, vec"
    VECTOR_VECTOR_VECTOR = "dst, vec, vec, vec"
    ADDRESS_VECTOR = "addr, vec"
    ADDRESS_ADDRESS = "addr, addr"
    LABEL = "label (condition)"
    RETURN = "(condition)"
    LOAD = "R.mask, [base | scalar]"
    STORE = "[base | scalar].mask, vec"
    LOCK = "scalar"
    EMIT = "scalar, scalar"


VALUE_SHAPES = (Shape.VECTOR, Shape.SCALAR, Shape.VECTOR_VECTOR, Shape.VECTOR_VECTOR_VECTOR)
ADDRESS_SHAPES = (Shape.ADDRESS_VECTOR, Shape.ADDRESS_ADDRESS)


class Opcode(IntEnum):
    """NAME = number, shape, what it computes from its sources a, b, c, components read of each source."""

    shape: Shape
    computes: str
    reads: tuple[str, ...]

    def __new__(cls, number: int, shape: Shape, computes: str, *reads: str) -> Opcode:
        member = int.__new__(cls, number)
        member._value_ = number
        member.shape = shape
        member.computes = computes
        member.reads = reads
        return member

    MOV = 1, Shape.VECTOR, "a", OWN
    ABS = 2, Shape.VECTOR, "|a|", OWN
    FLR = 3, Shape.VECTOR, "floor(a)", OWN
    FRC = 4, Shape.VECTOR, "a - floor(a)", OWN
    SSG = 5, Shape.VECTOR, "-1, 0 or 1 by the sign of a", OWN
    ADD = 6, Shape.VECTOR_VECTOR, "a + b", OWN, OWN
    SUB = 7, Shape.VECTOR_VECTOR, "a - b", OWN, OWN
    MUL = 8, Shape.VECTOR_VECTOR, "a * b", OWN, OWN
    MIN = 9, Shape.VECTOR_VECTOR, "a < b ? a : b; NaN if either is", OWN, OWN
    MAX = 10, Shape.VECTOR_VECTOR, "a > b ? a : b; NaN if either is", OWN, OWN
    SEQ = 11, Shape.VECTOR_VECTOR, "a = b ? 1 : 0; NaN if either is", OWN, OWN
    SFL = 12, Shape.VECTOR_VECTOR, "0", "", ""
    SGE = 13, Shape.VECTOR_VECTOR, "a >= b ? 1 : 0; NaN if either is", OWN, OWN
    SGT = 14, Shape.VECTOR_VECTOR, "a > b ? 1 : 0; NaN if either is", OWN, OWN
    SLE = 15, Shape.VECTOR_VECTOR, "a <= b ? 1 : 0; NaN if either is", OWN, OWN
    SLT = 16, Shape.VECTOR_VECTOR, "a < b ? 1 : 0; NaN if either is", OWN, OWN
    SNE = 17, Shape.VECTOR_VECTOR, "a = b ? 0 : 1; NaN if either is", OWN, OWN
    STR = 18, Shape.VECTOR_VECTOR, "1", "", ""
    MAD = 19, Shape.VECTOR_VECTOR_VECTOR, "(a * b) + c, rounded twice", OWN, OWN, OWN
    DP3 = 20, Shape.VECTOR_VECTOR, "(a.x*b.x + a.y*b.y) + a.z*b.z", "xyz", "xyz"
    DP4 = 21, Shape.VECTOR_VECTOR, "((a.x*b.x + a.y*b.y) + a.z*b.z) + a.w*b.w", "xyzw", "xyzw"
    DPH = 22, Shape.VECTOR_VECTOR, "((a.x*b.x + a.y*b.y) + a.z*b.z) + b.w", "xyz", "xyzw"
    DST = 23, Shape.VECTOR_VECTOR, "(1, a.y*b.y, a.z, b.w)", "yz", "yw"
    LIT = 24, Shape.VECTOR, "(1, max(a.x, 0), a.x > 0 ? max(a.y, 0)^a.w : 0, 1), |a.w| at most 128", "xyw"
    COS = 25, Shape.SCALAR, "cos(a)", "x"
    EX2 = 26, Shape.SCALAR, "2^a", "x"
    EXP = 27, Shape.SCALAR, "(2^floor(a), a - floor(a), 2^a, 1)", "x"
    LG2 = 28, Shape.SCALAR, "log2(a)", "x"
    LOG = 29, Shape.SCALAR, "(e, m, log2|a|, 1) with |a| = m * 2^e and 1 <= m < 2", "x"
    RCC = 30, Shape.SCALAR, "1 / a, its magnitude clamped to [2^-64, 2^64]", "x"
    RCP = 31, Shape.SCALAR, "1 / a", "x"
    RSQ = 32, Shape.SCALAR, "1 / sqrt(a)", "x"
    SIN = 33, Shape.SCALAR, "sin(a)", "x"
    SHL = 34, Shape.VECTOR_VECTOR, "a << b on 24-bit integers held in floats", OWN, OWN
    SHR = 35, Shape.VECTOR_VECTOR, "a >> b on 24-bit integers held in floats", OWN, OWN
    ARL = 36, Shape.ADDRESS_VECTOR, "floor(a), clamped to -512 ... 511", OWN
    ARR = 37, Shape.ADDRESS_VECTOR, "a rounded half to even, clamped to -512 ... 511", OWN
    ARA = 38, Shape.ADDRESS_ADDRESS, "(a.x+a.z, a.y+a.w, a.x+a.z, a.y+a.w), clamped to -512 ... 511", "xyzw"
    BRA = 39, Shape.LABEL, "go on at the label"
    CAL = 40, Shape.LABEL, "push the next instruction, go on at the label; a full stack ends the program"
    RET = 41, Shape.RETURN, "pop and go on there; an empty stack ends the program"
    LD = 42, Shape.LOAD, "k-th component of the mask = k-th word of the element", "x"
    ST = 43, Shape.STORE, "k-th word of the element = k-th component of the mask", "x", OWN
    LOCK = 44, Shape.LOCK, "take lock number int(a) & 255", "x"
    UNLK = 45, Shape.LOCK, "give lock number int(a) & 255 back", "x"
    EMIT = 46, Shape.EMIT, "send (int(a), b) to the output", "x", "x"

    @property
    def is_scalar(self) -> bool:
        """Every source is a single component."""
        return self.shape in (Shape.SCALAR, Shape.LOCK, Shape.EMIT)

    @property
    def writes(self) -> bool:
        """It has a destination register."""
        return self.shape in (*VALUE_SHAPES, *ADDRESS_SHAPES, Shape.LOAD)

    @property
    def can_set_flags(self) -> bool:
        """It also exists with the suffix C, which updates the condition codes."""
        return self.shape in (*VALUE_SHAPES, *ADDRESS_SHAPES)


LAST_ARITHMETIC = Opcode.ARA  # all opcodes up to here only compute and write registers

MNEMONICS: dict[str, tuple[Opcode, bool]] = {op.name: (op, False) for op in Opcode}
MNEMONICS.update({f"{op.name}C": (op, True) for op in Opcode if op.can_set_flags})


def table() -> str:
    """The instruction set as a Markdown table, for the README."""
    lines = ["| opcode | operands | result |", "|---|---|---|"]
    for op in Opcode:
        suffix = "[C]" if op.can_set_flags else ""
        computes = op.computes.replace("|", "\\|")
        lines.append(f"| {op.name}{suffix} | {op.shape.value.replace('|', chr(92) + '|')} | {computes} |")
    return "\n".join(lines)
