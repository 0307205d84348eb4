"""One instruction on the register file: operands, arithmetic, conditional results, branches.

`code[pc]` is the instruction's row (archsim/isa/encoding.py), `registers` the flat register file, `flags` the
condition code register, one of GREATER, EQUAL, LESS, UNORDERED a component.
"""

import numpy as np

from archsim.isa import semantics
from archsim.isa.encoding import (
    ABSOLUTE,
    CHANGE,
    CONDITIONAL,
    CONSTANT,
    HOME,
    INDEX,
    LOOK,
    MASK,
    NEGATE,
    NUM_SLOTS,
    ORIGIN,
    READ,
    RESULT,
    RULE,
    SETS_FLAGS,
    STAGED,
    TARGET,
    WRITE,
)
from archsim.isa.encoding import FLAGS as ROW_FLAGS
from archsim.isa.opcodes import Opcode
from archsim.isa.program import CALL_STACK
from archsim.jit import compiled, inlined

_A, _B, _C = READ, READ + 4, READ + 8


@compiled
def prepare(registers, code, pc):
    """Stage the sources that have a sign, an absolute value or an address register."""
    for k in range(3):
        if code[pc, CHANGE + k] == 0:
            continue
        for component in range(4):
            slot = np.int64(code[pc, ORIGIN + 4 * k + component])
            if code[pc, INDEX + k] >= 0:
                slot += 4 * np.int64(registers[code[pc, INDEX + k]])
                value = registers[slot] if CONSTANT <= slot < NUM_SLOTS else np.float32(0.0)
            else:
                value = registers[slot]
            if code[pc, CHANGE + k] & ABSOLUTE:
                value = np.float32(abs(value))
            registers[STAGED + 4 * k + component] = -value if code[pc, CHANGE + k] & NEGATE else value


@inlined
def _fetch(registers, code, pc, at):
    """The four components of the source whose slots start at field `at`."""
    return (
        registers[np.uint32(code[pc, at])],
        registers[np.uint32(code[pc, at + 1])],
        registers[np.uint32(code[pc, at + 2])],
        registers[np.uint32(code[pc, at + 3])],
    )


@inlined
def _put(registers, code, pc, x, y, z, w):
    registers[np.uint32(code[pc, WRITE])] = x
    registers[np.uint32(code[pc, WRITE + 1])] = y
    registers[np.uint32(code[pc, WRITE + 2])] = z
    registers[np.uint32(code[pc, WRITE + 3])] = w


@inlined
def _one(op, registers, code, pc):
    x, y, z, w = _fetch(registers, code, pc, _A)
    f = semantics.one_source
    _put(registers, code, pc, f(op, x), f(op, y), f(op, z), f(op, w))


@inlined
def _two(op, registers, code, pc):
    a, b = _fetch(registers, code, pc, _A), _fetch(registers, code, pc, _B)
    f = semantics.two_sources
    _put(registers, code, pc, f(op, a[0], b[0]), f(op, a[1], b[1]), f(op, a[2], b[2]), f(op, a[3], b[3]))


@inlined
def _multiply_add(registers, code, pc):
    a, b = _fetch(registers, code, pc, _A), _fetch(registers, code, pc, _B)
    c = _fetch(registers, code, pc, _C)
    x, y = semantics.multiply_add(a[0], b[0], c[0]), semantics.multiply_add(a[1], b[1], c[1])
    z, w = semantics.multiply_add(a[2], b[2], c[2]), semantics.multiply_add(a[3], b[3], c[3])
    _put(registers, code, pc, x, y, z, w)


@inlined
def _replicate(registers, code, pc, value):
    _put(registers, code, pc, value, value, value, value)


@inlined
def _dot(op, registers, code, pc):
    a, b = _fetch(registers, code, pc, _A), _fetch(registers, code, pc, _B)
    _replicate(registers, code, pc, semantics.dot(op, a, b))


@inlined
def compute(op, registers, code, pc):
    """Any arithmetic opcode. The first cases are the frequent ones, each compiled for its opcode alone."""
    if op == Opcode.MAD:
        _multiply_add(registers, code, pc)
    elif op == Opcode.MUL:
        _two(Opcode.MUL, registers, code, pc)
    elif op == Opcode.ADD:
        _two(Opcode.ADD, registers, code, pc)
    elif op == Opcode.MOV:
        _one(Opcode.MOV, registers, code, pc)
    elif op == Opcode.FLR:
        _one(Opcode.FLR, registers, code, pc)
    elif op == Opcode.FRC:
        _one(Opcode.FRC, registers, code, pc)
    elif op == Opcode.RCP:
        _replicate(registers, code, pc, semantics.function(Opcode.RCP, registers[np.uint32(code[pc, _A])]))
    elif op == Opcode.DPH:
        _dot(Opcode.DPH, registers, code, pc)
    elif op == Opcode.DP4:
        _dot(Opcode.DP4, registers, code, pc)
    else:
        _compute_rare(op, registers, code, pc)


@compiled
def _compute_rare(op, registers, code, pc):
    """The other arithmetic opcodes."""
    a, b = _fetch(registers, code, pc, _A), _fetch(registers, code, pc, _B)
    if op <= Opcode.SSG:
        _one(op, registers, code, pc)
    elif op <= Opcode.STR or op == Opcode.SHL or op == Opcode.SHR:
        _two(op, registers, code, pc)
    elif op <= Opcode.DPH:
        _dot(op, registers, code, pc)
    elif op == Opcode.DST:
        _put(registers, code, pc, *semantics.distance(a, b))
    elif op == Opcode.LIT:
        _put(registers, code, pc, *semantics.light(a))
    elif op == Opcode.EXP:
        _put(registers, code, pc, *semantics.exponential(a[0]))
    elif op == Opcode.LOG:
        _put(registers, code, pc, *semantics.logarithm(a[0]))
    elif op <= Opcode.SIN:
        _replicate(registers, code, pc, semantics.function(op, a[0]))
    elif op == Opcode.ARA:
        _put(registers, code, pc, *semantics.address_sum(a))
    else:
        f = semantics.address
        _put(registers, code, pc, f(op, a[0]), f(op, a[1]), f(op, a[2]), f(op, a[3]))


@inlined
def finish(registers, flags, code, pc):
    """Write a conditional result, update the condition codes of the components that were written."""
    conditional = code[pc, ROW_FLAGS] & CONDITIONAL
    written = np.int64(code[pc, MASK])
    if conditional:
        written &= _satisfied(flags, code, pc)

    for component in range(4):
        if written >> component & 1:
            home = code[pc, HOME] + component
            if conditional:
                registers[home] = registers[RESULT + component]
            if code[pc, ROW_FLAGS] & SETS_FLAGS:
                flags[component] = semantics.flag_of(registers[home])


@inlined
def _satisfied(flags, code, pc):
    """Bit i is set when the condition holds for component i."""
    bits = np.int64(0)
    for component in range(4):
        if flags[code[pc, LOOK + component]] & code[pc, RULE]:
            bits |= 1 << component
    return bits


@inlined
def branch(op, code, pc, end, flags, stack):
    """The next instruction after BRA, CAL or RET; `end` when the program is over. stack[-1] is its depth."""
    seen = flags[code[pc, LOOK]] | flags[code[pc, LOOK + 1]]
    seen |= flags[code[pc, LOOK + 2]] | flags[code[pc, LOOK + 3]]
    if seen & code[pc, RULE] == 0:
        return pc + 1
    if op == Opcode.BRA:
        return np.int64(code[pc, TARGET])

    depth = stack[CALL_STACK]
    if op == Opcode.CAL:
        if depth == CALL_STACK:
            return end
        stack[depth] = pc + 1
        stack[CALL_STACK] = depth + 1
        return np.int64(code[pc, TARGET])
    if depth == 0:
        return end
    stack[CALL_STACK] = depth - 1
    return stack[depth - 1]
