"""The whole simulator on its smallest inputs. Read this second."""

import numpy as np
import pytest

from archsim.execute.interpreter import execute
from archsim.execute.memory import Window, new_memory
from archsim.isa.assembler import assemble
from archsim.isa.opcodes import Opcode
from archsim.machine import compiled, reference
from archsim.machine.spec import MachineSpec
from archsim.model.cache.spec import DRAM_PARENT, CacheSpec
from archsim.model.core.spec import CoreSpec, TaskOrder
from archsim.model.dram.spec import AddressField, DramSpec, DramTiming, PagePolicy, Scheduler
from archsim.model.fifo.spec import FifoSpec
from archsim.model.locks.spec import LocksSpec
from archsim.model.unit.spec import UnitSpec
from archsim.trace.records import RECORD, Op, Tasks
from archsim.trace.stream import Work, whole

# A core with two threads, a cache of 4 lines, a DRAM of two banks. One tick is a core cycle and a memory clock.
TIMING = DramTiming(
    n_cl=5,
    n_wl=3,
    n_rcd_read=7,
    n_rcd_write=4,
    n_rp=6,
    n_ras=12,
    n_rc=18,
    n_rrd=2,
    n_rrd_l=2,
    n_faw=0,
    n_ccd=2,
    n_ccd_l=2,
    n_rtp=2,
    n_wr=4,
    n_wtr=3,
    n_wtr_l=3,
    n_rtw=6,
    n_rfc=20,
    n_refi=0,
)
TINY = MachineSpec(
    core=CoreSpec(num_cores=1, num_threads=2, period_ticks=1, task_order=TaskOrder.INTERLEAVED),
    core_cache=(0,),
    locks=LocksSpec(num_locks=1),
    source=UnitSpec(interval_cycles=0),
    fifo=FifoSpec(num_entries=1),
    caches=(
        CacheSpec(
            num_sets=2,
            num_ways=2,
            line_bytes=16,
            hit_cycles=3,
            num_mshrs=2,
            num_targets=2,
            num_ports=1,
            parent=DRAM_PARENT,
        ),
    ),
    dram=DramSpec(
        num_channels=1,
        num_banks=2,
        num_groups=1,
        period_ticks=1,
        burst_beats=4,
        clock_beats=2,
        beat_bytes=4,
        num_queue_entries=4,
        num_write_entries=0,
        write_high=0,
        write_low=0,
        scheduler=Scheduler.FR_FCFS,
        max_wait_clocks=100,
        page_policy=PagePolicy.OPEN,
        page_timeout_clocks=0,
        channel=AddressField(shift=4, bits=0),
        group=AddressField(shift=4, bits=0),
        line=AddressField(shift=4, bits=2),
        bank_hash=0,
        bank=AddressField(shift=6, bits=1),
        row=AddressField(shift=7, bits=4),
        timing=TIMING,
    ),
)

# (address, compute, bytes, op): issue `compute` one-cycle instructions, then `op`.
END = (0, 0, 0, Op.END)
LOAD_0 = (0, 0, 4, Op.LOAD)


def test_one_instruction_is_assembled():
    program = assemble("!!VP2.0\nADD R1.xy, R0, -c[3].w;\nEND")

    (instruction,) = program.instructions
    assert instruction.opcode is Opcode.ADD
    assert instruction.destination[:3] == ("R", 1, "xy")
    assert [(s.file, s.number, s.swizzle, s.negate) for s in instruction.sources] == [
        ("R", 0, "xyzw", False),
        ("c", 3, "wwww", True),
    ]


def test_one_kernel_runs_on_memory():
    """Three instructions: double the vector at address 0 and put it back; v[0].x is the index 0."""
    double = assemble("!!VP2.0\nLD R0, [B0 | v[0].x];\nADD R0, R0, R0;\nST [B0 | v[0].x], R0;\nEND")
    memory = new_memory(512)
    memory[:4] = [1, 2, 3, 4]
    zeros = np.zeros((1, 1, 4), np.float32), np.zeros((256, 4), np.float32)

    executed = execute(double, *zeros, (Window(0, 256), Window(256, 256)), memory)

    assert memory[:4].tolist() == [2, 4, 6, 8]
    assert executed.tasks.records.tolist() == [(0, 0, 16, Op.LOAD), (0, 1, 16, Op.STORE), (0, 0, 0, Op.END)]


def one_task(*records: tuple[int, int, int, int]) -> Work:
    return whole(Tasks(np.array([0, len(records)], np.int64), np.array(list(records), RECORD)))


@pytest.fixture(params=[reference.simulate, compiled.simulate], ids=["reference", "compiled"])
def simulate(request):
    return request.param


def test_five_instructions_take_five_cycles(simulate):
    assert simulate(TINY, one_task((0, 5, 0, Op.END))).cycles == 5


def test_one_cache_hit_takes_hit_cycles(simulate):
    miss = simulate(TINY, one_task(LOAD_0, END))
    miss_and_hit = simulate(TINY, one_task(LOAD_0, LOAD_0, END))

    assert miss_and_hit.cycles - miss.cycles == 3


def test_one_dram_read_of_a_closed_bank_takes_rcd_cl_and_its_burst(simulate):
    counters = simulate(TINY, one_task(LOAD_0, END))

    burst_clocks = 4 // 2
    assert counters.cache_fetch_ticks[0] == TIMING.n_rcd_read + TIMING.n_cl + burst_clocks
    assert counters.cycles == 3 + TIMING.n_rcd_read + TIMING.n_cl + burst_clocks


def test_both_models_count_the_same():
    """Loads, stores, a lock and an output item, on both threads."""
    lock, store = (0, 1, 0, Op.LOCK), (64, 2, 8, Op.STORE)
    load, emit, unlock = (160, 0, 4, Op.LOAD), (0, 4, 0, Op.EMIT), (0, 0, 0, Op.UNLOCK)
    task = [LOAD_0, lock, store, load, unlock, emit, END]
    tasks = Tasks(np.arange(4) * len(task), np.array(task * 3, RECORD))

    believed, used = reference.simulate(TINY, whole(tasks)), compiled.simulate(TINY, whole(tasks))

    assert believed.tasks.tolist() == [3]
    for name, left, right in zip(believed._fields, believed, used, strict=True):
        assert np.array_equal(left, right), name
