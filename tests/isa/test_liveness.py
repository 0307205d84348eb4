"""Live registers of small programs, counted by hand."""

import pytest

from archsim.isa.assembler import assemble


@pytest.mark.parametrize(
    ("body", "count"),
    [
        ("", 0),
        ("MOV CC, c[0];", 0),
        ("MOV R0, c[0];", 1),  # a result nobody reads still needs its register
        ("MOV R0, c[0]; MOV R1, c[1]; EMIT R0.x, R1.x;", 2),
        ("MOV R0, c[0]; MOV R1, R0; EMIT R1.x, R1.x;", 1),  # R0 dies where R1 is born
        ("MOV R0.x, c[0]; MOV R1, c[1]; MOV R0.y, R1; EMIT R0.x, R0.y;", 2),  # the pieces of R0 overlap R1
        ("MOV R0.x, c[0]; MOV R0.y, c[1]; EMIT R0.x, R0.y;", 1),
        (
            "MOV R0, c[0]; MOV R1, c[0]; MOV R0 (EQ), R1; EMIT R0.x, R0.x;",
            2,
        ),  # a condition may keep the old R0
        ("MOV R0, c[0]; MOV R1, c[0]; MOV R0, R1; EMIT R0.x, R0.x;", 1),  # the first R0 is never read
        ("MOV R0, c[0]; MOV R1, c[0]; SGT R1, R0, R1; EMIT R1.x, R1.x;", 2),
        ("MOV R0, c[0]; MOV R1, c[0]; SFL R1, R0, R1; EMIT R1.x, R1.x;", 1),  # SFL reads nothing
        ("MOV R0, c[0]; MOV R1, c[1]; ST [B0 | R0.x], R1;", 2),
        ("MOV R0.x, c[0]; MOV R1, c[1]; LD R1, [B0 | R0.x]; EMIT R1.x, R1.x;", 2),
    ],
)
def test_straight_line(body, count):
    assert assemble(f"!!VP2.0 {body} END").live_registers == count


def test_a_loop_keeps_its_inputs_alive():
    body = "MOV R0, c[0]; MOV R1, c[1]; top: ADD R2, R0, R1; MOVC CC, R2; BRA top (LT.x);"
    assert assemble(f"!!VP2.0 {body} END").live_registers == 3
    body = "MOV R0, c[0]; MOV R1, c[1]; top: ADD R2, R0, R1; MOVC CC, R2;"
    assert assemble(f"!!VP2.0 {body} END").live_registers == 2


def test_a_return_goes_behind_every_call():
    body = "MOV R0, c[0]; CAL sub; EMIT R0.x, R0.x; RET; sub: MOV R1, c[1]; EMIT R1.x, R1.x;"
    assert assemble(f"!!VP2.0 {body} RET; END").live_registers == 2
    assert assemble(f"!!VP2.0 {body} END").live_registers == 1  # falls off the end: R0 is never read
