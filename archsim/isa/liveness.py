"""How many temporaries a program holds at once: backward liveness over its control flow graph.

Liveness is kept per component, so a register that is filled in pieces is live from its first piece on; a
register counts when any component of it is live.
"""

from __future__ import annotations

from collections.abc import Sequence

from archsim.isa.opcodes import COMPONENTS, OWN, Opcode, Shape
from archsim.isa.program import NUM_TEMPORARIES, Instruction, Source


def live_registers(instructions: Sequence[Instruction]) -> int:
    """Most vec4 temporaries that are live at once, before or after any instruction; a result counts there."""
    followers = [_followers(instructions, at) for at in range(len(instructions))]
    reads = [_read(instruction) for instruction in instructions]
    kills = [_killed(instruction) for instruction in instructions]
    live = [0] * (len(instructions) + 1)  # bit 4 * register + component: live before the instruction

    changed = True
    while changed:
        changed = False
        for at in reversed(range(len(instructions))):
            before = reads[at] | (_union(live, followers[at]) & ~kills[at])
            changed |= before != live[at]
            live[at] = before

    after = [_union(live, followers[at]) | _written(instructions[at]) for at in range(len(instructions))]
    return max((_count(bits) for bits in live + after), default=0)


def _followers(instructions: Sequence[Instruction], at: int) -> list[int]:
    """Instructions that can come next. A return may go behind any call, or end the program."""
    instruction, end = instructions[at], len(instructions)
    conditional = instruction.condition.rule != "TR"
    if instruction.opcode.shape is Shape.LABEL:
        return [instruction.target] + [at + 1] * conditional
    if instruction.opcode is Opcode.RET:
        behind_calls = [k + 1 for k, other in enumerate(instructions) if other.opcode is Opcode.CAL]
        return behind_calls + [at + 1] * conditional + [end]
    return [at + 1]


def _union(live: list[int], places: list[int]) -> int:
    bits = 0
    for place in places:
        bits |= live[place]
    return bits


def _read(instruction: Instruction) -> int:
    """Components of temporaries that the instruction reads."""
    bits = 0
    for source, reads in zip(instruction.sources, instruction.opcode.reads, strict=True):
        bits |= _bits(source, instruction.mask if reads == OWN else reads)
    return bits


def _bits(source: Source, components: str) -> int:
    if source.file != "R":
        return 0
    bits = 0
    for component in components:
        letter = source.swizzle[COMPONENTS.index(component)]
        bits |= 1 << (4 * source.number + COMPONENTS.index(letter))
    return bits


def _written(instruction: Instruction) -> int:
    """Components of temporaries that the instruction writes, or may write."""
    destination = instruction.destination
    if destination is None or destination.file != "R":
        return 0
    return sum(1 << (4 * destination.number + COMPONENTS.index(letter)) for letter in destination.mask)


def _killed(instruction: Instruction) -> int:
    """Components that the instruction overwrites for certain."""
    return _written(instruction) if instruction.condition.rule == "TR" else 0


def _count(bits: int) -> int:
    return sum(1 for register in range(NUM_TEMPORARIES) if bits >> (4 * register) & 15)
