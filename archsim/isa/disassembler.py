"""A program back into text that assembles to the same code."""

from __future__ import annotations

from archsim.isa.lexer import HEADER
from archsim.isa.opcodes import COMPONENTS, Opcode
from archsim.isa.program import RESULTS, Condition, Destination, Instruction, Program, Source


def disassemble(program: Program) -> str:
    """Text of the program, labels kept, one instruction a line."""
    labels: dict[int, list[str]] = {}
    for label, at in program.labels.items():
        labels.setdefault(at, []).append(label)
    lines = [HEADER]
    for at, instruction in enumerate(program.instructions):
        lines.extend(f"{label}:" for label in labels.get(at, []))
        target = labels[instruction.target][0] if instruction.target >= 0 else ""
        lines.append(f"        {_instruction(instruction, target)};")
    lines.extend(f"{label}:" for label in labels.get(program.num_instructions, []))
    return "\n".join([*lines, "END", ""])


def _instruction(instruction: Instruction, target: str) -> str:
    opcode = instruction.opcode
    operands = _operands(instruction, target)
    name = opcode.name + "C" * instruction.sets_flags
    return f"{name:5}{', '.join(operands)}".rstrip()


def _operands(instruction: Instruction, target: str) -> list[str]:
    opcode, sources = instruction.opcode, instruction.sources
    condition = _condition(instruction.condition)
    if opcode in (Opcode.BRA, Opcode.CAL, Opcode.RET):
        return [f"{target}{condition}".strip()]
    if opcode is Opcode.LD:
        return [_destination(instruction.destination), _element(instruction)]
    if opcode is Opcode.ST:
        return [_element(instruction) + _mask(instruction.mask), _source(sources[1], False)]
    texts = [_source(source, opcode.is_scalar) for source in sources]
    if instruction.destination is not None:
        texts.insert(0, _destination(instruction.destination) + condition)
    return texts


def _condition(condition: Condition) -> str:
    if condition.rule == "TR":
        return ""
    return f" ({condition.rule}{_swizzle(condition.swizzle)})"


def _destination(destination: Destination | None) -> str:
    assert destination is not None
    if destination.file == "CC":
        name = "CC"
    elif destination.file == "o":
        name = f"o[{RESULTS[destination.number]}]"
    else:
        name = f"{destination.file}{destination.number}"
    return name + _mask(destination.mask)


def _mask(mask: str) -> str:
    return "" if mask == COMPONENTS else f".{mask}"


def _element(instruction: Instruction) -> str:
    return f"[B{instruction.base} | {_source(instruction.sources[0], True)}]"


def _source(source: Source, scalar: bool) -> str:
    letters = f".{source.swizzle[0]}" if scalar else _swizzle(source.swizzle)
    text = _register(source) + letters
    if source.absolute:
        text = f"|{text}|"
    return "-" + text if source.negate else text


def _swizzle(swizzle: str) -> str:
    if swizzle == COMPONENTS:
        return ""
    return f".{swizzle[0]}" if len(set(swizzle)) == 1 else f".{swizzle}"


def _register(source: Source) -> str:
    if source.address is not None:
        register, component = source.address
        offset = f" {'-' if source.number < 0 else '+'} {abs(source.number)}" if source.number else ""
        return f"c[A{register}.{component}{offset}]"
    if source.file in ("v", "c"):
        return f"{source.file}[{source.number}]"
    return f"{source.file}{source.number}"
