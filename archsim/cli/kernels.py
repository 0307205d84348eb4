"""`archsim asm` and `archsim disasm`."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from archsim.errors import Location, fail
from archsim.isa.assembler import load_kernel
from archsim.isa.disassembler import disassemble
from archsim.isa.program import Program


def list_program(file: str) -> None:
    """Print the listing: where each instruction is written, its number, its canonical text; then the counts."""
    program = _load(file)
    where = iter(enumerate(program.where))
    for line in disassemble(program).splitlines():
        if line.startswith(" "):
            number, place = next(where)
            print(f"{place.line:>5} {number:>4}  {line.rstrip()}")
        else:
            print(f"{'':>10}  {line}")
    print(_counts(program))


def print_canonical(file: str) -> None:
    """Print the program as text that assembles to the same program."""
    print(disassemble(_load(file)), end="")


def _load(file: str) -> Program:
    if Path(file).is_file() and Path(file).suffix != ".s":
        raise fail("the name of an assembly file ends in .s", Location(file))
    return load_kernel(file)


def _counts(program: Program) -> str:
    """Static counts, e.g. `40 instructions (6 MUL, ...), 6 live registers`."""
    opcodes = Counter(instruction.opcode.name for instruction in program.instructions)
    each = ", ".join(
        f"{count} {name}" for name, count in sorted(opcodes.items(), key=lambda item: (-item[1], item[0]))
    )
    return (
        f"{program.name}: {program.num_instructions} instructions ({each})\n"
        f"{program.name}: {program.live_registers} live registers"
    )
