"""A program: its instructions as people read them, and the code that the interpreter runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import Location
from archsim.isa.opcodes import COMPONENTS, Opcode

NUM_TEMPORARIES = 16
NUM_ATTRIBUTES = 16
NUM_CONSTANTS = 256
NUM_ADDRESSES = 2
NUM_BASES = 2
MAX_INSTRUCTIONS = 256
CALL_STACK = 4
NUM_LOCKS = 256

RESULTS = ["HPOS", "COL0", "COL1", "BFC0", "BFC1", "FOGC", "PSIZ"]
RESULTS += [f"TEX{k}" for k in range(8)] + [f"CLP{k}" for k in range(6)]
ATTRIBUTE_NAMES = {"OPOS": 0, "WGHT": 1, "NRML": 2, "COL0": 3, "COL1": 4, "FOGC": 5}
ATTRIBUTE_NAMES.update({f"TEX{k}": 8 + k for k in range(8)})

# A rule is the set of condition codes that satisfy it, as a bit mask of these.
GREATER, EQUAL, LESS, UNORDERED = 1, 2, 4, 8
RULES = {
    "EQ": EQUAL,
    "GE": GREATER | EQUAL,
    "GT": GREATER,
    "LE": LESS | EQUAL,
    "LT": LESS,
    "NE": GREATER | LESS | UNORDERED,
    "TR": GREATER | EQUAL | LESS | UNORDERED,
    "FL": 0,
}


class Source(NamedTuple):
    """A source operand: swizzle, then absolute value, then negation."""

    file: str  # "R", "v", "c" or "A"
    number: int  # of the register, or the offset k of c[A0.x + k]
    swizzle: str = COMPONENTS  # always four letters
    negate: bool = False
    absolute: bool = False
    address: tuple[int, str] | None = None  # (0, "x") of c[A0.x + k]

    @property
    def register(self) -> tuple[str, int, tuple[int, str] | None]:
        """What is read, whatever its swizzle and sign."""
        return (self.file, self.number, self.address)


class Destination(NamedTuple):
    """Where a result goes: "R", "A", "o" (number in RESULTS), "CC", or "B": memory by a base register."""

    file: str
    number: int = 0
    mask: str = COMPONENTS


class Condition(NamedTuple):
    """A rule and the components of the condition code it looks at."""

    rule: str = "TR"
    swizzle: str = COMPONENTS


ALWAYS = Condition()


class Instruction(NamedTuple):
    """One instruction, decoded."""

    opcode: Opcode
    sources: tuple[Source, ...] = ()
    destination: Destination | None = None
    condition: Condition = ALWAYS  # of the write, or of the branch
    sets_flags: bool = False
    target: int = -1  # instruction that BRA and CAL go to
    base: int = -1  # base register of LD and ST

    @property
    def mask(self) -> str:
        """Components written to the destination."""
        return self.destination.mask if self.destination else ""


class Program(NamedTuple):
    """An assembled program. Made by `assemble` and `load_kernel`."""

    name: str
    instructions: tuple[Instruction, ...]
    code: np.ndarray  # int32 [num_instructions + 1, encoding.WIDTH], read-only; the last row ends the program
    where: tuple[Location, ...]  # [num_instructions] where each instruction was written
    labels: dict[str, int]  # label to instruction; may be num_instructions
    live_registers: int  # most temporaries that are live at once

    @property
    def num_instructions(self) -> int:
        """Static count."""
        return len(self.instructions)

    @property
    def entry(self) -> int:
        """The instruction a task starts with."""
        return self.labels.get("main", 0)

    @property
    def num_attributes(self) -> int:
        """One more than the highest attribute register that is read."""
        read = [s.number + 1 for i in self.instructions for s in i.sources if s.file == "v"]
        return max(read, default=0)
