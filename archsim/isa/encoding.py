"""From an instruction to a row of numbers: every register becomes a slot of one flat float32 register file.

Swizzles and write masks so cost nothing at run time: a source is four slots to read, a destination four slots
to write, and masked components are written to UNUSED. What is rare is flagged and done apart: sources with a
sign, an absolute value or an address register are PREPAREd into the STAGED slots and read from there;
conditional results are computed into the RESULT slots and written from there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from archsim.isa.opcodes import COMPONENTS, Shape
from archsim.isa.program import (
    NUM_ADDRESSES,
    NUM_ATTRIBUTES,
    NUM_CONSTANTS,
    NUM_TEMPORARIES,
    RESULTS,
    RULES,
    Destination,
    Instruction,
    Source,
)

# Slots of the register file; a vec4 register takes four.
TEMPORARY = 0
ADDRESS = TEMPORARY + 4 * NUM_TEMPORARIES
ATTRIBUTE = ADDRESS + 4 * NUM_ADDRESSES
STAGED = ATTRIBUTE + 4 * NUM_ATTRIBUTES
RESULT = STAGED + 4 * 3
UNUSED = RESULT + 4
OUTPUT = UNUSED + 4
CONSTANT = OUTPUT + 4 * len(RESULTS)
NUM_SLOTS = CONSTANT + 4 * NUM_CONSTANTS

# Fields of a row.
OP = 0  # Opcode, or HALT
FLAGS = 1
WRITE = 2  # [4] slots written; by LD, in the order of the words
READ = 6  # [3, 4] slots read of each source; of ST's value, in the order of the words
MASK = 18  # bit i: component i is written
RULE = 19  # condition codes that satisfy the condition
LOOK = 20  # [4] components of the condition code that the condition looks at
HOME = 24  # first slot of the destination register
TARGET = 25  # instruction that BRA and CAL go to
BASE = 26  # base register of LD and ST
WORDS = 27  # words that LD and ST move
ORIGIN = 28  # [3, 4] slots that the STAGED values come from; of c[A0.x + k], those of c[k], unclamped
CHANGE = 40  # [3] STAGE | NEGATE | ABSOLUTE, or 0 where nothing needs staging
INDEX = 43  # [3] slot of the address register component that is added to ORIGIN, or -1
WIDTH = 48

HALT = 63  # the opcode of the row behind the last instruction, above all others

# Bits of FLAGS.
PREPARE = 1  # a source needs staging
CONDITIONAL = 2  # the write has a condition
SETS_FLAGS = 4  # the condition codes follow the result

# Bits of CHANGE.
STAGE = 1
NEGATE = 2
ABSOLUTE = 4

_FILES = {"R": TEMPORARY, "A": ADDRESS, "v": ATTRIBUTE, "c": CONSTANT, "o": OUTPUT}


def encode(instructions: Sequence[Instruction]) -> np.ndarray:
    """Code of a program: int32 [num_instructions + 1, WIDTH], closed by a HALT row."""
    code = np.zeros((len(instructions) + 1, WIDTH), np.int32)
    code[-1, OP] = HALT
    for row, instruction in zip(code, instructions, strict=False):
        _encode_one(row, instruction)
    code.setflags(write=False)
    return code


def _encode_one(row: np.ndarray, instruction: Instruction) -> None:
    row[OP] = instruction.opcode
    row[TARGET], row[BASE] = instruction.target, instruction.base
    row[RULE] = RULES[instruction.condition.rule]
    row[LOOK : LOOK + 4] = _components(instruction.condition.swizzle)
    row[WRITE : WRITE + 4] = UNUSED

    for k, source in enumerate(instruction.sources):
        slots = _encode_source(row, k, source)
        if instruction.opcode.shape is Shape.STORE and k == 1:
            slots = _in_word_order(slots, instruction.mask)
        row[READ + 4 * k : READ + 4 * k + 4] = slots
    if instruction.destination is not None:
        _encode_destination(row, instruction, instruction.destination)


def _components(letters: str) -> list[int]:
    return [COMPONENTS.index(letter) for letter in letters]


def _in_word_order(slots: list[int], mask: str) -> list[int]:
    chosen = [slots[component] for component in _components(mask)]
    return chosen + [UNUSED] * (4 - len(chosen))


def _encode_source(row: np.ndarray, k: int, source: Source) -> list[int]:
    """Fill the fields of source k; return the four slots the operation reads."""
    first = _FILES[source.file] + 4 * source.number
    slots = [first + component for component in _components(source.swizzle)]
    if not (source.negate or source.absolute or source.address):
        return slots

    row[FLAGS] |= PREPARE
    row[ORIGIN + 4 * k : ORIGIN + 4 * k + 4] = slots
    row[CHANGE + k] = STAGE | NEGATE * source.negate | ABSOLUTE * source.absolute
    row[INDEX + k] = -1
    if source.address:
        register, letter = source.address
        row[INDEX + k] = ADDRESS + 4 * register + COMPONENTS.index(letter)
    return [STAGED + 4 * k + component for component in range(4)]


def _encode_destination(row: np.ndarray, instruction: Instruction, destination: Destination) -> None:
    written = _components(destination.mask)
    row[MASK] = sum(1 << component for component in written)
    row[WORDS] = len(written)
    if destination.file == "B":
        return

    home = RESULT if destination.file == "CC" else _FILES[destination.file] + 4 * destination.number
    row[HOME] = home
    if instruction.opcode.shape is Shape.LOAD:
        row[WRITE : WRITE + 4] = _in_word_order([home + i for i in range(4)], destination.mask)
        return
    row[FLAGS] |= SETS_FLAGS * instruction.sets_flags
    if instruction.condition.rule != "TR":
        row[FLAGS] |= CONDITIONAL
        home = RESULT
    for component in written:
        row[WRITE + component] = home + component
