"""The opcode table."""

from pathlib import Path

from archsim.isa import opcodes
from archsim.isa.opcodes import LAST_ARITHMETIC, MNEMONICS, Opcode, Shape

JOHNSON = {"LD", "ST", "LOCK", "UNLK", "SHL", "SHR", "EMIT"}


def test_table_is_vp2_and_the_seven_additions():
    assert len(Opcode) == 39 + 7
    assert set(Opcode.__members__) > JOHNSON


def test_suffix_c_exists_for_what_writes_values():
    without = {op.name for op in Opcode if f"{op.name}C" not in MNEMONICS}
    assert without == {"BRA", "CAL", "RET", "LD", "ST", "LOCK", "UNLK", "EMIT"}


def test_a_name_that_ends_in_c_is_not_taken_for_a_suffix():
    assert MNEMONICS["RCC"] == (Opcode.RCC, False)
    assert MNEMONICS["RCCC"] == (Opcode.RCC, True)
    assert MNEMONICS["FRC"] == (Opcode.FRC, False)


def test_arithmetic_comes_first():
    beyond = {op.name for op in Opcode if op > LAST_ARITHMETIC}
    assert beyond == {"BRA", "CAL", "RET", "LD", "ST", "LOCK", "UNLK", "EMIT"}


def test_scalars_and_writers():
    assert Opcode.RCP.is_scalar
    assert not Opcode.MOV.is_scalar
    assert Opcode.LD.writes
    assert not Opcode.ST.writes
    assert all(
        len(op.reads) == op.shape.value.count("vec") for op in Opcode if op.shape in opcodes.VALUE_SHAPES[2:]
    )
    assert Opcode.MAD.shape is Shape.VECTOR_VECTOR_VECTOR


def test_readme_holds_the_table():
    readme = Path(opcodes.__file__).with_name("README.md").read_text(encoding="utf-8")
    assert opcodes.table() in readme
