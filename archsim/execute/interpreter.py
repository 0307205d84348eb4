"""Runs kernels on real data and records what they do: the functional half of a simulation.

Tasks run one after another, in order. Loads, stores, locks and emits become records; everything else is a
one-cycle instruction and is only counted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from archsim.errors import ArchsimError, Location, Problem, fail
from archsim.execute.memory import WORD_BYTES, Window, window_problems
from archsim.execute.operations import branch, compute, finish, prepare
from archsim.execute.recorded import record
from archsim.execute.state import (
    EMITTED,
    EXECUTED,
    PC,
    RECORDS,
    TASK,
    TOTAL,
    Job,
    Log,
    State,
    Status,
    begin,
    new_log,
    new_state,
    with_room,
)
from archsim.isa.encoding import CONDITIONAL, FLAGS, OP, PREPARE, SETS_FLAGS
from archsim.isa.opcodes import LAST_ARITHMETIC, Opcode
from archsim.isa.program import NUM_ATTRIBUTES, NUM_CONSTANTS, Program
from archsim.jit import compiled
from archsim.trace.records import Tasks

_FINISH = CONDITIONAL | SETS_FLAGS
_LONGEST = 2**31 - 1  # instructions of one task; a record counts them in 32 bits


class Executed(NamedTuple):
    """What the tasks did, besides changing memory. Task i emitted items emitted_starts[i] ... [i + 1] - 1."""

    tasks: Tasks
    emitted_address: np.ndarray  # int64 [num_emitted] first operand of EMIT, truncated
    emitted_value: np.ndarray  # float32 [num_emitted] second operand
    emitted_starts: np.ndarray  # int64 [num_tasks + 1]
    num_instructions: int  # executed by all tasks


def execute(
    program: Program,
    attributes: np.ndarray,
    constants: np.ndarray,
    windows: tuple[Window, Window],
    memory: np.ndarray,
    max_instructions: int = 2**24,
) -> Executed:
    """Run the program once per task; memory is updated in place.

    attributes float32 [num_tasks, num_attributes <= 16, 4], constants float32 [256, 4], memory float32
    [num_words]. All registers are 0 and all condition codes EQ when a task starts. Raises ArchsimError, naming
    kernel, task and line, when a task executes more than max_instructions, misuses a lock or leaves the memory.
    """
    problems = window_problems(windows) + _array_problems(attributes, constants, memory)
    if not problems and attributes.shape[1] < program.num_attributes:
        what = f"reads v[{program.num_attributes - 1}], but {attributes.shape[1]} attributes are given"
        problems = [Problem(None, f"kernel {program.name} {what}")]
    if not 0 < max_instructions <= _LONGEST:
        problems.append(Problem(None, f"max_instructions is {max_instructions}, not 1 ... {_LONGEST}"))
    if problems:
        raise ArchsimError(problems)

    flat = np.require(attributes, requirements=["C", "W"]).reshape(len(attributes), 4 * attributes.shape[1])
    job = Job(program.code, flat, memory, np.array(windows, np.int64), program.entry, max_instructions)
    state, log = new_state(program, constants), new_log(len(attributes))
    status = Status.FULL
    while status == Status.FULL:
        log = with_room(log, state, len(attributes))
        with np.errstate(all="ignore"):  # only matters where numba is switched off
            status = Status(_run(job, state, log))
    if status != Status.ENDED:
        raise _error(program, status, state, job)
    return _result(state, log)


def _array_problems(attributes: np.ndarray, constants: np.ndarray, memory: np.ndarray) -> list[Problem]:
    """What is wrong with the arrays that `execute` was given."""
    width = f"[num_tasks, at most {NUM_ATTRIBUTES}, 4]"
    fits = attributes.ndim == 3 and attributes.shape[1] <= NUM_ATTRIBUTES and attributes.shape[2] == 4
    rules = [
        (fits, f"attributes have the shape {attributes.shape}, not {width}"),
        (constants.shape == (NUM_CONSTANTS, 4), f"constants have the shape {constants.shape}, not (256, 4)"),
        (memory.ndim == 1, f"memory has {memory.ndim} dimensions, not 1"),
        (memory.flags.c_contiguous and memory.flags.writeable, "memory is not contiguous and writable"),
    ]
    arrays = {"attributes": attributes, "constants": constants, "memory": memory}
    rules += [
        (array.dtype == np.float32, f"{name}: {array.dtype}, not float32") for name, array in arrays.items()
    ]
    return [Problem(None, what) for right, what in rules if not right]


def _result(state: State, log: Log) -> Executed:
    num_records, num_emitted = int(state.counters[RECORDS]), int(state.counters[EMITTED])
    tasks = Tasks(log.starts, log.records[:num_records])
    address, value = log.address[:num_emitted], log.value[:num_emitted]
    return Executed(tasks, address, value, log.emitted_starts, int(state.counters[TOTAL]))


def _error(program: Program, status: Status, state: State, job: Job) -> ArchsimError:
    task, pc = int(state.counters[TASK]), int(state.counters[PC])
    held = ", ".join(str(number) for number in np.flatnonzero(state.held))
    what = {
        Status.RUNAWAY: f"executes more than {job.max_instructions} instructions",
        Status.OUTSIDE: f"leaves the memory of {WORD_BYTES * len(job.memory)} bytes",
        Status.HELD_ALREADY: f"takes a lock that it holds already (it holds {held})",
        Status.NOT_HELD: f"gives back a lock that it does not hold (it holds {held or 'none'})",
        Status.LEFT_HELD: f"ends without giving back lock {held}",
    }[status]
    where: Location | None = None
    if program.where:
        where = program.where[min(pc, program.num_instructions - 1)]
    return fail(f"kernel {program.name}, task {task}: {what}", where)


@compiled
def _run(job, state, log):
    """Run tasks until all have ended, or something stops one; returns a Status."""
    num_tasks = job.attributes.shape[0]
    while state.counters[TASK] < num_tasks:
        task = state.counters[TASK]
        if state.counters[EXECUTED] == 0:
            begin(job, state, task)
        status = _run_task(job, state, log)
        if status != Status.ENDED:
            return np.int64(status)
        log.starts[task + 1] = state.counters[RECORDS]
        log.emitted_starts[task + 1] = state.counters[EMITTED]
        state.counters[TASK] = task + 1
    return np.int64(Status.ENDED)


@compiled
def _run_task(job, state, log):
    """Run the current task from where it stands; returns a Status."""
    registers, flags, counters = state.registers, state.flags, state.counters
    pc, executed = counters[PC], counters[EXECUTED]
    end = np.int64(job.code.shape[0] - 1)
    status = np.int64(Status.RUNNING)
    while status == Status.RUNNING:
        op = job.code[pc, OP]
        if job.code[pc, FLAGS] & PREPARE:
            prepare(registers, job.code, pc)
        if op <= LAST_ARITHMETIC:
            compute(op, registers, job.code, pc)
            if job.code[pc, FLAGS] & _FINISH:
                finish(registers, flags, job.code, pc)
            pc += 1
            executed += 1
        elif op <= Opcode.RET:
            pc = branch(op, job.code, pc, end, flags, state.stack)
            executed += 1
            if executed > job.max_instructions:
                status = np.int64(Status.RUNAWAY)
        else:
            status = record(op, job, state, log, pc, executed)
            if status == Status.RUNNING:
                pc += 1
                executed += 1
    counters[PC] = pc
    counters[EXECUTED] = executed
    if status == Status.ENDED:
        counters[TOTAL] += executed
        counters[EXECUTED] = 0
    return status
