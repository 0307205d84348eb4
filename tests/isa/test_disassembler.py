"""Programs to text and back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from archsim.isa.assembler import assemble, load_kernel
from archsim.isa.disassembler import disassemble
from archsim.isa.lexer import HEADER
from archsim.isa.opcodes import Opcode, Shape
from archsim.isa.program import RESULTS, RULES


def check_round_trip(program):
    again = assemble(disassemble(program))
    assert np.array_equal(again.code, program.code)
    assert again.instructions == program.instructions
    assert again.labels == program.labels


@pytest.mark.parametrize("name", ["izb_build", "izb_raster"])
def test_kernels_come_back(name):
    check_round_trip(load_kernel(name))


def test_text_is_what_a_person_writes():
    lines = [
        "main:",
        "MADC R1.x (GT.y), -|c[A0.x - 3].wzyx|, v[2].z, R4;",
        "ST   [B1 | R0.x].xy, R2;",
        "BRA  main;",
    ]
    program = assemble("\n".join([HEADER, *lines, "END"]))
    assert [line.strip() for line in disassemble(program).splitlines()] == [HEADER, *lines, "END"]


letters = st.sampled_from("xyzw")
masks = st.sampled_from(["", ".x", ".yw", ".zw", ".xyzw", ".w"])
swizzles = st.one_of(
    st.just(""),
    letters.map(lambda c: f".{c}"),
    st.text("xyzw", min_size=4, max_size=4).map(lambda s: f".{s}"),
)
conditions = st.one_of(
    st.just(""), st.tuples(st.sampled_from(sorted(RULES)), swizzles).map(lambda c: f" ({c[0]}{c[1]})")
)
temporaries = st.integers(0, 15).map(lambda n: f"R{n}")
relative = st.tuples(st.sampled_from("01"), letters, st.integers(-256, 255)).map(
    lambda r: f"c[A{r[0]}.{r[1]}{r[2]:+d}]"
)


@st.composite
def sources(draw, constant, attribute, scalar=False):
    register = draw(st.one_of(temporaries, st.just(constant), st.just(attribute)))
    part = "." + draw(letters) if scalar else draw(swizzles)
    text = draw(st.sampled_from(["", "+", "-"])) + register + part
    if draw(st.booleans()):
        text = draw(st.sampled_from(["", "+", "-"])) + f"|{text}|"
    return text


@st.composite
def instructions(draw):
    """Any valid instruction; labels are `top` and `end`."""
    opcode = draw(st.sampled_from(list(Opcode)))
    constant = draw(st.one_of(relative, st.integers(0, 255).map(lambda n: f"c[{n}]")))
    attribute = f"v[{draw(st.integers(0, 15))}]"
    scalar = sources(constant, attribute, scalar=True)
    vector = sources(constant, attribute)
    name = opcode.name + ("C" if opcode.can_set_flags and draw(st.booleans()) else "")
    if opcode.shape is Shape.LABEL:
        return f"{name} {draw(st.sampled_from(['top', 'end']))}{draw(conditions)};"
    if opcode.shape is Shape.RETURN:
        return f"{name}{draw(conditions)};"
    element = f"[B{draw(st.integers(0, 1))} | {draw(scalar)}]"
    if opcode is Opcode.LD:
        return f"LD {draw(temporaries)}{draw(masks)}, {element};"
    if opcode is Opcode.ST:
        return f"ST {element}{draw(masks)}, {draw(vector)};"
    reads = [draw(scalar if opcode.is_scalar else vector) for _ in opcode.reads]
    if not opcode.writes:
        return f"{name} {', '.join(reads)};"
    results = st.one_of(temporaries, st.just("CC"), st.sampled_from(RESULTS).map(lambda r: f"o[{r}]"))
    if opcode.shape in (Shape.ADDRESS_VECTOR, Shape.ADDRESS_ADDRESS):
        results = st.sampled_from(["A0", "A1"])
    if opcode is Opcode.ARA:
        reads = ["A1"]
    return f"{name} {draw(results)}{draw(masks)}{draw(conditions)}, {', '.join(reads)};"


@given(st.lists(instructions(), max_size=8))
def test_any_program_comes_back(lines):
    check_round_trip(assemble("\n".join([HEADER, "top:", *lines, "end:", "END"])))
