"""The interpreter: operands, conditions, control flow, memory, locks, records, errors."""

import numpy as np
import pytest

from archsim.errors import ArchsimError
from archsim.execute.interpreter import Executed, execute
from archsim.execute.memory import Window, new_memory
from archsim.isa.assembler import assemble, load_kernel
from archsim.trace import records
from archsim.trace.records import Op

F = np.float32
B0, B1 = Window(0, 256), Window(256, 256)
FLAGS_OF_C1 = (-1.0, 0.0, 1.0, np.nan)


def run(body: str, num_tasks: int = 1, memory: np.ndarray | None = None, **limits: int) -> Executed:
    """Run with v[0] = (task, 10, 20, 30), c[0] = (0, 1, 2, 3), c[1] = (-1, 0, 1, NaN), c[2] = 5 ... 8."""
    attributes = np.zeros((num_tasks, 1, 4), F)
    attributes[:, 0] = [0, 10, 20, 30]
    attributes[:, 0, 0] = np.arange(num_tasks)
    constants = np.zeros((256, 4), F)
    constants[:3] = [[0, 1, 2, 3], FLAGS_OF_C1, [5, 6, 7, 8]]
    memory = new_memory(512) if memory is None else memory
    program = assemble(f"!!VP2.0\n{body}\nEND", "test.s")
    return execute(program, attributes, constants, (B0, B1), memory, **limits)


def result(body: str) -> list[float]:
    """The four components of R0 after the body."""
    memory = new_memory(512)
    run(f"{body}\nST [B0 | c[0].x], R0;", memory=memory)
    return memory[:4].tolist()


def emitted(body: str) -> list[int]:
    return run(body).emitted_address.tolist()


def test_swizzle_sign_and_absolute_value():
    assert result("MOV R0, v[0].wzyx;") == [30, 20, 10, 0]
    assert result("MOV R0, -c[2].y;") == [-6] * 4
    assert result("MOV R1, -c[2]; MOV R0, |R1|;") == [5, 6, 7, 8]
    assert result("MOV R0, -|c[2].wzyx|;") == [-8, -7, -6, -5]
    assert result("ADD R0, -v[0], -c[2];") == [-5, -16, -27, -38]
    assert result("MAD R0, -c[2].x, |-c[2]|, -v[0];") == [-25, -40, -55, -70]


def test_result_may_overwrite_its_source():
    assert result("MOV R0, c[2]; MOV R0, R0.wxyz;") == [8, 5, 6, 7]


def test_write_mask_leaves_the_rest():
    assert result("MOV R0, c[2]; MOV R0.yw, v[0];") == [5, 10, 7, 30]
    assert result("MOV R0, c[2]; RCP R0.z, v[0].y;") == [5, 6, F(0.1), 8]


@pytest.mark.parametrize(
    ("rule", "holds"),  # for the condition codes LT, EQ, GT, UN
    [
        ("EQ", [0, 1, 0, 0]),
        ("GE", [0, 1, 1, 0]),
        ("GT", [0, 0, 1, 0]),
        ("LE", [1, 1, 0, 0]),
        ("LT", [1, 0, 0, 0]),
        ("NE", [1, 0, 1, 1]),
        ("TR", [1, 1, 1, 1]),
        ("FL", [0, 0, 0, 0]),
    ],
)
def test_rules(rule, holds):
    assert result(f"MOVC CC, c[1]; MOV R0 ({rule}), c[0].y;") == holds
    assert result(f"MOVC CC, c[1]; MOV R0 ({rule}.wzyx), c[0].y;") == holds[::-1]
    for component, taken in zip("xyzw", holds, strict=True):
        body = f"MOVC CC, c[1]; BRA over ({rule}.{component}); MOV R0, c[2]; over:"
        assert result(body) == ([0] * 4 if taken else [5, 6, 7, 8])


def test_branch_is_taken_when_any_component_satisfies_the_rule():
    body = "MOVC CC, c[1]; BRA over (LT.{}); MOV R0, c[2]; over:"
    assert result(body.format("yzwx")) == [0] * 4
    assert result(body.format("yzwy")) == [5, 6, 7, 8]


def test_condition_codes_start_equal_and_minus_zero_is_equal():
    assert result("MOV R0 (EQ), c[0].y;") == [1] * 4
    assert result("MOVC CC, c[1]; MOVC CC, -c[0].x; MOV R0 (EQ), c[0].y;") == [1] * 4


def test_only_written_components_set_condition_codes():
    assert result("MOVC CC.xz, c[2]; MOV R0 (GT), c[0].y;") == [1, 0, 1, 0]
    assert result("MOVC R1.xz, c[2]; MOV R0 (GT), c[0].y;") == [1, 0, 1, 0]
    # c[1] makes x negative and z positive; the second write happens in x only, and only it can set a flag
    assert result("MOVC CC.xz, c[1]; MOVC R1 (LT), c[2]; MOV R0 (GT), c[0].y;") == [1, 0, 1, 0]
    assert result("MOVC CC.xz, c[1]; MOVC R1 (LT), c[2]; MOV R0, R1;") == [5, 0, 0, 0]


def test_conditions_are_looked_up_before_they_change():
    body = "MOVC CC.x, -c[2]; MOVC R0 (LT.x), c[2]; "  # x becomes GT, but all four components see LT
    assert result(body) == [5, 6, 7, 8]


def test_without_suffix_condition_codes_stay():
    assert result("MOV R1, c[2]; MOV CC, c[2]; MOV R0 (EQ), c[0].y;") == [1] * 4


def test_address_registers_take_masks_and_conditions():
    assert result("ARL A0.y, c[0].y; MOV R0, c[A0.x + 1].z;") == [1] * 4
    assert result("ARL A0.y, c[0].y; MOV R0, c[A0.y + 1];") == [5, 6, 7, 8]
    assert result("ARL A0 (NE), c[0].y; MOV R0, c[A0.x + 1].z;") == [1] * 4
    assert result("ARLC A0, c[1].x; MOV R0 (LT), c[0].y;") == [1] * 4


def test_calls_nest_four_deep_and_the_fifth_ends_the_program():
    body = "main: CAL a; EMIT c[0].x, c[0].x; {}"
    subs = "a: CAL b; RET; b: CAL c; RET; c: CAL d; RET; d: {} RET; e: RET;"
    assert emitted(body.format("RET;") + subs.format("")) == [0]
    assert emitted(body.format("RET;") + subs.format("CAL e;")) == []


def test_call_stack_starts_empty():
    executed = run(
        "CAL sub; RET; sub: EMIT v[0].x, v[0].x;", num_tasks=6
    )  # falls off the end inside the call
    assert executed.emitted_address.tolist() == [0, 1, 2, 3, 4, 5]


def test_conditional_call_and_return():
    assert emitted("CAL sub (NE.x); EMIT c[0].y, c[0].x; RET; sub: EMIT c[0].z, c[0].x;") == [1]
    body = "CAL sub; EMIT c[0].y, c[0].x; RET; sub: RET (NE.x); EMIT c[0].z, c[0].x; RET;"
    assert emitted(body) == [2, 1]


def test_tasks_start_fresh_at_main_and_follow_one_another():
    body = """again: EMIT R0.x, v[0].w; RET;
    main:  BRA again (NE.x);
           ADDC R0, v[0], c[0].y;
           LD R1.x, [B0 | c[0].x]; ADD R1.x, R1.x, c[0].y; ST [B0 | c[0].x].x, R1;
           EMIT R1.x, R0.x; BRA again;"""
    executed = run(body, num_tasks=3)
    assert executed.emitted_address.tolist() == [1, 1, 2, 2, 3, 3]  # memory lives on, R0 starts anew
    assert executed.emitted_value.tolist() == [1, 30, 2, 30, 3, 30]
    assert executed.emitted_starts.tolist() == [0, 2, 4, 6]


def test_words_follow_the_mask():
    memory = new_memory(512)
    memory[:8] = np.arange(1, 9)
    body = "LD R0, [B0 | c[0].y]; LD R1.yw, [B0 | c[0].y]; LD R2.z, [B0 | c[0].y];"
    run(
        f"{body} ST [B1 | c[0].x], R0; ST [B1 | c[0].y], R1; ST [B1 | c[0].z], R2; ST [B1 | c[2].w].xz, v[0].wzyx;"
        " ST [B1 | v[0].z].w, -v[0];",
        memory=memory,
    )
    assert memory[64:76].tolist() == [5, 6, 7, 8, 0, 3, 0, 4, 0, 0, 2, 0]
    assert memory[64 + 16 : 64 + 18].tolist() == [30, 10]
    assert memory[64 + 20] == -30


@pytest.mark.parametrize(
    ("index", "words", "element"),
    [
        (0.0, 1, 0),
        (-0.0, 1, 0),
        (3.9, 1, 3),
        (62.0, 1, 62),
        (64.0, 1, 63),
        (31.0, 2, 31),
        (32.0, 2, 31),
        (15.99, 4, 15),
        (16.0, 4, 15),
        (1e30, 4, 15),
        (np.inf, 4, 15),
        (-np.inf, 2, 31),
        (-1e-40, 1, 63),
        (np.nan, 1, 63),
        (np.nan, 4, 15),
    ],
)
def test_guard_element(index, words, element):
    mask = {1: ".x", 2: ".xy", 4: ""}[words]
    attributes = np.full((1, 1, 4), index, F)
    text = f"!!VP2.0 ST [B1 | v[0].x]{mask}, c[0].x; LD R0{mask}, [B1 | v[0].x]; END"
    memory = new_memory(512)
    constants = np.full((256, 4), 7, F)
    executed = execute(assemble(text), attributes, constants, (B0, B1), memory)
    assert np.flatnonzero(memory).tolist() == list(range(64 + element * words, 64 + (element + 1) * words))
    assert executed.tasks.records["address"].tolist() == [256 + 4 * element * words] * 2 + [0]


def test_windows_say_where_their_guard_is():
    assert B1.num_elements(16) == 16
    assert B1.guard(16) == 512 - 16


def test_records_of_a_small_program():
    body = """MOV R0, v[0];
              ADD R0, R0, c[0].y;
              LOCK R0.x;
              LD R1.xy, [B1 | R0.x];
              ST [B0 | R0.x], R1;
              UNLK R0.x;
              EMIT R0.x, R1.x;
              MOV R2, R1;"""
    executed = run(body, num_tasks=2)
    expected = [
        (1, 2, 0, Op.LOCK),
        (256 + 8, 0, 8, Op.LOAD),
        (16, 0, 16, Op.STORE),
        (1, 0, 0, Op.UNLOCK),
        (0, 0, 0, Op.EMIT),
        (0, 1, 0, Op.END),
        (2, 2, 0, Op.LOCK),
        (256 + 16, 0, 8, Op.LOAD),
        (32, 0, 16, Op.STORE),
        (2, 0, 0, Op.UNLOCK),
        (0, 0, 0, Op.EMIT),
        (0, 1, 0, Op.END),
    ]
    assert executed.tasks.records.tolist() == expected
    assert executed.tasks.starts.tolist() == [0, 6, 12]
    assert executed.num_instructions == 16 == records.num_instructions(executed.tasks)


def test_branches_calls_and_returns_take_one_instruction_each():
    executed = run("CAL sub; BRA over; over: RET; sub: BRA over (NE.x); RET;")
    assert executed.tasks.records.tolist() == [(0, 5, 0, Op.END)]


def test_empty_program_and_no_tasks():
    assert run("").tasks.records.tolist() == [(0, 0, 0, Op.END)]
    assert run("RET;", num_tasks=0).tasks.starts.tolist() == [0]


def test_log_grows_without_repeating_anything():
    """Every task adds 1 to a word many times, so a task that is run again would show."""
    body = """top: LD R0.x, [B0 | c[0].x]; ADD R0.x, R0, c[0].y; ST [B0 | c[0].x].x, R0; EMIT R0.x, R0.x;
              ADD R1.x, R1, c[0].y; SUBC CC.x, R1, {}; BRA top (LT.x);"""
    memory = new_memory(512)
    executed = run(body.format("v[0].w"), num_tasks=200, memory=memory)
    assert memory[0] == 200 * 30
    assert executed.emitted_address.tolist() == list(range(1, 6001))
    assert len(executed.tasks.records) == 200 * (30 * 3 + 1)
    assert executed.num_instructions == 6000 * 7


@pytest.mark.parametrize(
    ("value", "number"),
    [(0.0, 0), (3.7, 3), (258.0, 2), (2.0**40, 0), (-1.0, 255), (np.nan, 255), (np.inf, 255)],
)
def test_lock_numbers(value, number):
    attributes = np.full((1, 1, 4), value, F)
    program = assemble("!!VP2.0 LOCK v[0].x; UNLK v[0].x; END")
    executed = execute(program, attributes, np.zeros((256, 4), F), (B0, B1), new_memory(512))
    assert executed.tasks.records["address"].tolist() == [number, number, 0]


@pytest.mark.parametrize(
    ("value", "address"), [(5.9, 5), (-5.9, -5), (2.0**40, 2**40), (np.nan, -1), (np.inf, -1), (3e38, -1)]
)
def test_emitted_addresses(value, address):
    attributes = np.full((1, 1, 4), value, F)
    program = assemble("!!VP2.0 EMIT v[0].x, -v[0].x; END")
    executed = execute(program, attributes, np.zeros((256, 4), F), (B0, B1), new_memory(512))
    assert executed.emitted_address.tolist() == [address]
    np.testing.assert_array_equal(executed.emitted_value, [F(-value)])


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "RET;\nmain: LOCK c[0].z;\nMOV R0, R1;",
            "test.s:4:1: kernel test, task 0: ends without giving back lock 2",
        ),
        (
            "LOCK c[0].z;\nLOCK c[0].z;",
            "test.s:3:1: kernel test, task 0: takes a lock that it holds already (it holds 2)",
        ),
        (
            "LOCK c[0].z; UNLK c[0].w;",
            "test.s:2:14: kernel test, task 0: gives back a lock that it does not hold (it holds 2)",
        ),
        (
            "UNLK c[0].w;",
            "test.s:2:1: kernel test, task 0: gives back a lock that it does not hold (it holds none)",
        ),
        ("top: BRA top;", "test.s:2:6: kernel test, task 0: executes more than 1000 instructions"),
    ],
)
def test_run_time_error(body, message):
    with pytest.raises(ArchsimError) as caught:
        run(body, max_instructions=1000)
    assert str(caught.value) == message


def test_limit_is_exact():
    run("RET;", max_instructions=1)
    run("MOV R0, R1; MOV R0, R1;", max_instructions=2)
    with pytest.raises(ArchsimError, match="task 0: executes more than 2"):
        run("MOV R0, R1; MOV R0, R1; MOV R0, R1;", max_instructions=2)


def test_error_names_the_task():
    with pytest.raises(ArchsimError, match="kernel test, task 3: gives back"):
        run("SUBC CC.x, v[0], c[0].w; BRA wrong (EQ.x); RET; wrong: UNLK c[0].x;", num_tasks=5)


def test_address_outside_the_memory():
    with pytest.raises(
        ArchsimError, match=r"test\.s:2:1: kernel test, task 0: leaves the memory of 500 bytes"
    ):
        run("ST [B1 | -c[2].x], R0;", memory=np.zeros(125, F))
    run("ST [B1 | c[0].x], R0;", memory=np.zeros(125, F))


@pytest.mark.parametrize(
    ("windows", "message"),
    [
        ((Window(0, 48), B1), "window B0 has 48 bytes, not a power of two"),
        ((B0, Window(0, 8)), "window B1 has 8 bytes, not a power of two"),
        ((B0, Window(64, 256)), "window B1 starts at 64, not a multiple of its size 256"),
    ],
)
def test_windows_are_checked(windows, message):
    program = assemble("!!VP2.0 END")
    with pytest.raises(ArchsimError, match=message):
        execute(program, np.zeros((1, 1, 4), F), np.zeros((256, 4), F), windows, new_memory(512))


def test_arrays_are_checked_all_at_once():
    with pytest.raises(ArchsimError) as caught:
        execute(
            assemble("!!VP2.0 END"), np.zeros((1, 17, 4), F), np.zeros((255, 4), F), (B0, B1), np.zeros(8), 0
        )
    assert len(caught.value.problems) == 4  # attributes, constants, memory's type, limit
    with pytest.raises(ArchsimError, match=r"kernel <text> reads v\[3\], but 1 attributes are given"):
        execute(
            assemble("!!VP2.0 MOV R0, v[3]; END"),
            np.zeros((1, 1, 4), F),
            np.zeros((256, 4), F),
            (B0, B1),
            new_memory(8),
        )


def test_read_only_attributes_will_do():
    attributes = np.broadcast_to(F(3), (2, 1, 4))
    program = assemble("!!VP2.0 EMIT v[0].x, v[0].x; END")
    executed = execute(program, attributes, np.zeros((256, 4), F), (B0, B1), new_memory(512))
    assert executed.emitted_address.tolist() == [3, 3]


def test_build_kernel_prepends_to_a_list():
    """One tile of one pair: both samples land in cell (1, 0), the second one in front."""
    constants = np.zeros((256, 4), F)
    constants[0] = 1
    constants[1] = [0.25, 0, 0, 0]  # a pixel is a quarter of a cell
    constants[4] = 4  # a grid of 4 x 4 logical and physical cells, in tiles of 2 x 2
    constants[5], constants[6], constants[7] = 0.25, 2, 2
    constants[8], constants[9] = [2, 4, 2, 4], [2, 4, 2, 4]
    constants[132] = [1, 2, 2, 1]  # from the last pair to the next
    constants[254] = [1.25, 0.5, 1, 1]
    attributes = np.array([[[-1, 8, 9, 32], [0, 0, 0, 0]]], F)
    memory = new_memory(1024)
    memory[64:66] = [0.5, 0.25]  # depths, two words a pair
    execute(load_kernel("izb_build"), attributes, constants, (Window(0, 512), Window(512, 512)), memory)

    heads, nodes = memory[128:144], memory[128:256].reshape(-1, 4)
    assert np.flatnonzero(memory[:32]).tolist() == [1]  # stencil
    assert np.flatnonzero(heads).tolist() == [1]
    assert heads[1] == 9
    assert nodes[9].tolist() == [1.5, 0.5, 1, 8]
    assert nodes[8].tolist() == [1.25, 0.5, 1, 0]
