"""Assembly text into a Program, or all of its errors at once.

The syntax is NV_vertex_program2's, without the rule that o[HPOS] must be written, and with memory elements
`[B0 | R1.x]` for LD and ST.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from archsim import resources
from archsim.errors import ArchsimError, Location, Problem, did_you_mean, fail
from archsim.isa import operands
from archsim.isa.cursor import Cursor
from archsim.isa.encoding import encode
from archsim.isa.lexer import HEADER, Token, tokenize
from archsim.isa.liveness import live_registers
from archsim.isa.opcodes import MNEMONICS, Opcode, Shape
from archsim.isa.program import MAX_INSTRUCTIONS, Destination, Instruction, Program, Source


class _Draft(NamedTuple):
    """A program that is being read."""

    cursor: Cursor
    instructions: list[Instruction]
    where: list[Location]
    labels: dict[str, int]
    targets: dict[int, Token]  # instruction to the label it names
    problems: list[Problem]


def load_kernel(kernel: str | Path) -> Program:
    """Assemble a packaged kernel by its name, or a file by its path (which ends in .s)."""
    path = Path(kernel)
    if path.suffix != ".s":
        path = resources.kernel(str(kernel))
    try:
        text = path.read_text(encoding="utf-8")
    except OSError:
        names = [file.stem for file in resources.kernel("x").parent.glob("*.s")]
        raise fail(f"cannot read kernel {path}", None, did_you_mean(path.stem, names)) from None
    except UnicodeDecodeError as error:
        raise fail(f"kernel {path} is not UTF-8 text: byte {error.start}") from None
    return assemble(text, str(path))


def assemble(text: str, file: str = "<text>") -> Program:
    """Assemble a program. Raises ArchsimError with every problem found, as file:line:column: what."""
    tokens, problems = tokenize(text, file)
    draft = _Draft(Cursor(tokens), [], [], {}, {}, problems)
    _header(draft)
    while _item(draft):
        pass
    instructions = _linked(draft)
    if draft.problems:
        raise ArchsimError(sorted(draft.problems, key=lambda problem: problem.where or Location(file)))
    return Program(
        name=Path(file).stem,
        instructions=instructions,
        code=encode(instructions),
        where=tuple(draft.where),
        labels=draft.labels,
        live_registers=live_registers(instructions),
    )


def _header(draft: _Draft) -> None:
    if not draft.cursor.accept(HEADER):
        draft.problems.append(Problem(draft.cursor.token.where, f"a program starts with {HEADER}"))


def _item(draft: _Draft) -> bool:
    """Read one label, option, instruction or the END; false after the last."""
    cursor, token = draft.cursor, draft.cursor.token
    if token.kind == "end":
        draft.problems.append(Problem(token.where, "END is missing"))
        return False
    if cursor.following.text == ":":
        _label(draft)
        return True
    if cursor.accept("END"):
        if cursor.token.kind != "end":
            draft.problems.append(Problem(cursor.token.where, f"{cursor.token} stands after END"))
        return False

    try:
        _statement(draft)
    except ArchsimError as error:
        draft.problems.extend(error.problems)
        cursor.skip_statement(token)
    return True


def _label(draft: _Draft) -> None:
    token = draft.cursor.take()
    draft.cursor.take()
    if token.kind != "word":
        draft.problems.append(Problem(token.where, f"{token} is not a label: letters, digits, underscores"))
    elif token.text in draft.labels:
        draft.problems.append(Problem(token.where, f"label '{token.text}' is there already"))
    else:
        draft.labels[token.text] = len(draft.instructions)


def _statement(draft: _Draft) -> None:
    """Read `OPTION name;` or one instruction."""
    cursor, token = draft.cursor, draft.cursor.word("an instruction")
    if token.text == "OPTION":
        name = cursor.word("the name of an option")
        if name.text != "NV_position_invariant":  # only concerns o[HPOS], which nothing reads
            cursor.wrong(f"option {name.text} does not exist", name, ("NV_position_invariant",))
        cursor.expect(";", "after the option")
        return
    if token.text not in MNEMONICS:
        cursor.wrong(f"instruction '{token.text}' does not exist", token, (*MNEMONICS, "OPTION", "END"))

    opcode, sets_flags = MNEMONICS[token.text]
    if opcode.shape is Shape.LABEL:
        draft.targets[len(draft.instructions)] = cursor.word("a label")
    instruction = _operands(cursor, opcode)._replace(sets_flags=sets_flags)
    if len(draft.instructions) == MAX_INSTRUCTIONS:
        draft.problems.append(Problem(token.where, f"a program has at most {MAX_INSTRUCTIONS} instructions"))
    draft.instructions.append(instruction)
    draft.where.append(token.where)
    draft.problems.extend(_too_many_registers(instruction, token))
    cursor.expect(";", f"after {token.text}")


def _operands(cursor: Cursor, opcode: Opcode) -> Instruction:
    """Read the operands that the opcode's shape asks for (a label has been read)."""
    match opcode.shape:
        case Shape.LABEL | Shape.RETURN:
            return Instruction(opcode, condition=operands.condition(cursor))
        case Shape.LOAD:
            return _load(cursor, opcode)
        case Shape.STORE:
            return _store(cursor, opcode)
        case Shape.LOCK:
            return Instruction(opcode, (operands.scalar(cursor),))
        case Shape.EMIT:
            address = operands.scalar(cursor)
            cursor.expect(",", "before the second operand")
            return Instruction(opcode, (address, operands.scalar(cursor)))
        case Shape.ADDRESS_VECTOR | Shape.ADDRESS_ADDRESS:
            number = operands.numbered(cursor, "A", "an address register (A0 or A1)")
            destination = Destination("A", number, operands.mask(cursor))
        case _:
            destination = operands.destination(cursor)
    condition = operands.condition(cursor)
    return Instruction(opcode, _sources(cursor, opcode), destination, condition)


def _sources(cursor: Cursor, opcode: Opcode) -> tuple[Source, ...]:
    sources = []
    for _ in opcode.reads:
        cursor.expect(",", "before the next operand")
        if opcode.shape is Shape.ADDRESS_ADDRESS:
            sources.append(Source("A", operands.numbered(cursor, "A", "an address register (A0 or A1)")))
        else:
            sources.append(operands.scalar(cursor) if opcode.is_scalar else operands.vector(cursor))
    return tuple(sources)


def _load(cursor: Cursor, opcode: Opcode) -> Instruction:
    token = cursor.token
    number = operands.numbered(cursor, "R", "a temporary register to load")
    destination = Destination("R", number, operands.mask(cursor))
    _check_words(cursor, destination.mask, token)
    cursor.expect(",", "before the memory element")
    base, index = operands.element(cursor)
    return Instruction(opcode, (index,), destination, base=base)


def _store(cursor: Cursor, opcode: Opcode) -> Instruction:
    token = cursor.token
    base, index = operands.element(cursor)
    destination = Destination("B", base, operands.mask(cursor))
    _check_words(cursor, destination.mask, token)
    cursor.expect(",", "before the value to store")
    return Instruction(opcode, (index, operands.vector(cursor)), destination, base=base)


def _check_words(cursor: Cursor, mask: str, token: Token) -> None:
    if len(mask) == 3:
        cursor.wrong("LD and ST move 1, 2 or 4 words, so the mask has 1, 2 or 4 components", token)


def _too_many_registers(instruction: Instruction, token: Token) -> list[Problem]:
    problems = []
    for file, kind in (("c", "parameter"), ("v", "attribute")):
        registers = {source.register for source in instruction.sources if source.file == file}
        if len(registers) > 1:
            what = (
                f"one instruction reads {len(registers)} {kind} registers {file}[], but it can read only one"
            )
            problems.append(Problem(token.where, what))
    return problems


def _linked(draft: _Draft) -> tuple[Instruction, ...]:
    """The instructions with their branch targets filled in."""
    instructions = list(draft.instructions)
    for at, token in draft.targets.items():
        if token.text not in draft.labels:
            hint = did_you_mean(token.text, draft.labels)
            draft.problems.append(Problem(token.where, f"label '{token.text}' does not exist", hint))
        elif at < len(instructions):
            instructions[at] = instructions[at]._replace(target=draft.labels[token.text])
    return tuple(instructions)
