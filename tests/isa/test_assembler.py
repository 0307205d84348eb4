"""Text to program, and every message of the assembler."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from archsim.errors import ArchsimError
from archsim.isa.assembler import assemble, load_kernel
from archsim.isa.lexer import HEADER
from archsim.isa.opcodes import MNEMONICS, Opcode
from archsim.isa.program import ALWAYS, Condition, Destination, Instruction, Program, Source


def program(body: str) -> Program:
    return assemble(f"{HEADER}\n{body}\nEND\n", "k.s")


def only(body: str) -> Instruction:
    (instruction,) = program(body).instructions
    return instruction


def complaints(text: str) -> list[str]:
    with pytest.raises(ArchsimError) as caught:
        assemble(text, "k.s")
    return str(caught.value).split("\n")


def complaint(body: str) -> str:
    (line,) = complaints(f"{HEADER}\n{body}\nEND")
    return line


@pytest.mark.parametrize(("name", "count"), [("izb_build", 40), ("izb_raster", 14)])
def test_kernels_have_the_papers_size(name, count):
    kernel = load_kernel(name)
    assert kernel.name == name
    assert kernel.num_instructions == count
    assert 1 < kernel.live_registers <= 8


def test_instruction_with_everything():
    text = "MADC R3.xz (GT.wzyx), -|c[A1.z - 7].w|, +R2.yxwz, -c[A1.z-7];"
    assert only(text) == Instruction(
        Opcode.MAD,
        (
            Source("c", -7, "wwww", negate=True, absolute=True, address=(1, "z")),
            Source("R", 2, "yxwz"),
            Source("c", -7, negate=True, address=(1, "z")),
        ),
        Destination("R", 3, "xz"),
        Condition("GT", "wzyx"),
        sets_flags=True,
    )


def test_sign_inside_the_absolute_value_changes_nothing():
    assert only("MOV R0, -|-R1|;") == only("MOV R0, -|R1|;")
    assert only("RCP R0, |-R1.x|;") == only("RCP R0, |R1.x|;")


def test_true_condition_is_no_condition():
    assert only("MOV R0 (TR.x), R1;").condition == ALWAYS


def test_names_of_registers():
    assert only("MOV o[TEX3].x, v[NRML];") == Instruction(
        Opcode.MOV, (Source("v", 2),), Destination("o", 10, "x")
    )
    assert only("MOVC CC, v[15];").destination == Destination("CC")
    assert only("ARA A1.yw, A0;").sources == (Source("A", 0),)


def test_memory_operands():
    load = only("LD R1.xw, [B1 | R2.z];")
    assert (load.base, load.destination, load.sources) == (
        1,
        Destination("R", 1, "xw"),
        (Source("R", 2, "zzzz"),),
    )
    store = only("ST [B0 | -c[A0.x].y].w, R3.wzyx;")
    assert (store.base, store.mask) == (0, "w")
    assert store.sources[1] == Source("R", 3, "wzyx")


def test_branches_go_to_labels_forwards_and_backwards():
    code = program("top: BRA end (NE.x); CAL sub; main: BRA top; sub: RET (LE); end:")
    assert code.labels == {"top": 0, "main": 2, "sub": 3, "end": 4}
    assert [i.target for i in code.instructions] == [4, 3, 0, -1]
    assert code.entry == 2


def test_program_starts_at_its_first_instruction_without_main():
    assert program("MOV R0, R1; a: RET;").entry == 0


def test_one_register_may_be_read_twice():
    assert program("MAD R0, c[3], c[3].x, v[1]; MUL R0, v[1], v[1].x;").num_instructions == 2


def test_option_and_comments():
    text = f"# first\n{HEADER} # second\nOPTION NV_position_invariant;\nMOV R0, # in between\n R1; END # last"
    assert assemble(text).num_instructions == 1


def test_attributes_read():
    assert program("MOV R0, v[6]; MOV R1, v[2];").num_attributes == 7
    assert program("MOV R0, R1;").num_attributes == 0


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("MOW R0, R1;", "k.s:2:1: instruction 'MOW' does not exist; did you mean 'MOV'?"),
        ("BRAC x;", "k.s:2:1: instruction 'BRAC' does not exist; did you mean 'BRA'?"),
        ("MOV R16, R1;", "k.s:2:5: register R16 does not exist: R0 ... R15"),
        ("MOV R0, R99;", "k.s:2:9: register R99 does not exist: R0 ... R15"),
        ("ARL A2.x, R1;", "k.s:2:5: register A2 does not exist: A0 ... A1"),
        ("LD R0, [B2 | R1.x];", "k.s:2:9: register B2 does not exist: B0 ... B1"),
        ("MOV R0, c[256];", "k.s:2:11: parameter register number 256 is not in 0 ... 255"),
        ("MOV R0, c[A0.x + 256];", "k.s:2:16: parameter register number 256 is not in -256 ... 255"),
        ("MOV R0, c[A0.x - 257];", "k.s:2:16: parameter register number -257 is not in -256 ... 255"),
        ("MOV R0, c[A0.q];", "k.s:2:14: component '.q' is none of x, y, z, w"),
        ("MOV R0, v[16];", "k.s:2:11: attribute register v[16] does not exist"),
        ("MOV R0, v[NORML];", "k.s:2:11: attribute register v[NORML] does not exist; did you mean 'NRML'?"),
        ("MOV o[HPOZ], R1;", "k.s:2:7: result register o[HPOZ] does not exist; did you mean 'HPOS'?"),
        ("MOV R0, o[HPOS];", "k.s:2:9: o[] registers cannot be read"),
        ("MOV c[1], R0;", "k.s:2:5: c[] registers cannot be written"),
        (
            "ADD R0, c[1], c[2];",
            "k.s:2:1: one instruction reads 2 parameter registers c[], but it can read only one",
        ),
        (
            "ADD R0, c[1], c[A0.x + 1];",
            "k.s:2:1: one instruction reads 2 parameter registers c[], but it can read only one",
        ),
        (
            "MAD R0, v[1], v[2], v[3];",
            "k.s:2:1: one instruction reads 3 attribute registers v[], but it can read only one",
        ),
        ("MOV R0, R1.xy;", "k.s:2:12: swizzle '.xy' is not one or four of x, y, z, w"),
        ("MOV R0, R1.xyzq;", "k.s:2:12: swizzle '.xyzq' is not one or four of x, y, z, w"),
        ("MOV R0.yx, R1;", "k.s:2:8: write mask '.yx' is not some of x, y, z, w in that order"),
        ("RCP R0, R1;", "k.s:2:9: a scalar operand needs one component, such as .x"),
        ("RCP R0, R1.xxxx;", "k.s:2:9: a scalar operand needs one component, such as .x"),
        ("LOCK R1;", "k.s:2:6: a scalar operand needs one component, such as .x"),
        (
            "LD R0.xyz, [B0 | R1.x];",
            "k.s:2:4: LD and ST move 1, 2 or 4 words, so the mask has 1, 2 or 4 components",
        ),
        (
            "ST [B0 | R1.x].yzw, R0;",
            "k.s:2:4: LD and ST move 1, 2 or 4 words, so the mask has 1, 2 or 4 components",
        ),
        ("top: BRA tap;", "k.s:2:10: label 'tap' does not exist; did you mean 'top'?"),
        ("a: RET; a: RET;", "k.s:2:9: label 'a' is there already"),
        ("7: RET;", "k.s:2:1: '7' is not a label: letters, digits, underscores"),
        ("RET (XX);", "k.s:2:6: condition 'XX' is none of EQ, GE, GT, LE, LT, NE, TR, FL"),
        ("MOV R0, R1 R2;", "k.s:2:12: expected ';' after MOV, found 'R2'"),
        ("MOV R0;", "k.s:2:7: expected ',' before the next operand, found ';'"),
        ("MOV R0, |R1;", "k.s:2:12: expected '|' to close the absolute value, found ';'"),
        ("OPTION ARB_fog;", "k.s:2:8: option ARB_fog does not exist"),
        ("MOV R0, @R1;", "k.s:2:9: '@' means nothing here"),
        (";", "k.s:2:1: expected an instruction, found ';'"),
    ],
)
def test_message(body, message):
    assert complaint(body) == message


def test_all_problems_come_at_once_and_in_order():
    text = "MOW R0, R1;\nMOV R1, R2\nMOV R16, R1;\n  RCP R0, R1;\nBRA away;\n"
    assert [line.split(": ")[0] for line in complaints(text)] == [
        "k.s:1:1",  # header
        "k.s:1:1",
        "k.s:3:1",  # the ; missing on line 2
        "k.s:3:5",
        "k.s:4:11",
        "k.s:5:5",
        "k.s:6:1",  # END
    ]


def test_nothing_may_follow_end():
    assert complaints(f"{HEADER} END\nMOV") == ["k.s:2:1: 'MOV' stands after END"]


def test_program_size_is_limited():
    assert program("RET;" * 256).num_instructions == 256
    assert complaint("RET;" * 257).startswith("k.s:2:1025: a program has at most 256 instructions")


def test_unknown_kernel_gets_a_hint():
    with pytest.raises(ArchsimError, match=r"izb_biuld.s; did you mean 'izb_build'\?"):
        load_kernel("izb_biuld")


def test_kernel_from_a_path(tmp_path):
    path = tmp_path / "mine.s"
    path.write_text(f"{HEADER} RET; END", encoding="utf-8")
    assert load_kernel(path).name == "mine"
    path.write_bytes(b"\xff")
    with pytest.raises(ArchsimError, match="is not UTF-8"):
        load_kernel(path)


WORDS = [*MNEMONICS, "R0", "R15", "R16", "A0", "A1", "B0", "B1", "v", "c", "o", "CC", "END", "OPTION", "HPOS"]
WORDS += ["x", "y", "xy", "xyzw", "wzyx", "EQ", "LT", "TR", "a", "b", "main"]
SIGNS = [*"[](){},;:|+-.", "!!VP2.0", "0", "255", "999999999999", "\n", " ", "#", "\x00", "é", "²"]


@given(st.lists(st.sampled_from(WORDS + SIGNS), max_size=40), st.booleans())
def test_any_tokens_assemble_or_are_refused(tokens, framed):
    text = " ".join(tokens)
    check_never_crashes(f"{HEADER}\n{text}\nEND" if framed else text)


@given(st.text(max_size=60))
def test_any_text_assembles_or_is_refused(text):
    check_never_crashes(text)


def check_never_crashes(text):
    try:
        assert isinstance(assemble(text), Program)
    except ArchsimError as error:
        assert error.problems  # noqa: PT017  (what matters is that nothing else is raised)
