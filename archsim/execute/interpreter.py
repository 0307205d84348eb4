"""Runs kernels on real data and records what they do: the functional half of a simulation.

Tasks run one after another, in order. Loads, stores, locks and emits become records; everything else is a one-cycle
instruction and is only counted.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.errors import ArchsimError, Problem, fail
from archsim.execute.memory import WORD_BYTES, Window, window_problems
from archsim.execute.operations import branch, compute, finish, prepare
from archsim.isa.encoding import (
    ADDRESS,
    ATTRIBUTE,
    BASE,
    CONDITIONAL,
    CONSTANT,
    FLAGS,
    HALT,
    NUM_SLOTS,
    OP,
    PREPARE,
    READ,
    SETS_FLAGS,
    TEMPORARY,
    WORDS,
    WRITE,
)
from archsim.isa.opcodes import LAST_ARITHMETIC, Opcode
from archsim.isa.program import CALL_STACK, EQUAL, NUM_ATTRIBUTES, NUM_CONSTANTS, Program
from archsim.isa.semantics import inlined
from archsim.jit import njit
from archsim.trace.records import RECORD, Op, Tasks

NUM_LOCKS = 256
NO_LOCK = NUM_LOCKS - 1  # the lock of numbers that are NaN, negative or infinite
NO_ADDRESS = -1  # emitted for numbers that are NaN, or too large for an integer

_FINISH = CONDITIONAL | SETS_FLAGS
_LARGEST_INTEGER = np.float32(2.0**62)


class Executed(NamedTuple):
    """What the tasks did, besides changing memory. Task i emitted items emitted_starts[i] ... [i + 1] - 1."""

    tasks: Tasks
    emitted_address: np.ndarray  # int64 [num_emitted] first operand of EMIT, truncated
    emitted_value: np.ndarray  # float32 [num_emitted] second operand
    emitted_starts: np.ndarray  # int64 [num_tasks + 1]
    num_instructions: int  # executed by all tasks


class Status(IntEnum):
    """Why the compiled loop came back."""

    RUNNING = 0
    ENDED = 1
    FULL = 2  # the log must grow; nothing of the next instruction has been done
    RUNAWAY = 3
    OUTSIDE = 4
    HELD_ALREADY = 5
    NOT_HELD = 6
    LEFT_HELD = 7


class _Log(NamedTuple):
    """Where the run is written down."""

    records: np.ndarray  # RECORD [capacity]
    address: np.ndarray  # int64 [capacity of emits]
    value: np.ndarray  # float32 [capacity of emits]
    starts: np.ndarray  # int64 [num_tasks + 1] first record of each task
    emitted_starts: np.ndarray  # int64 [num_tasks + 1]


class _State(NamedTuple):
    """The processor between two instructions."""

    registers: np.ndarray  # float32 [NUM_SLOTS]
    flags: np.ndarray  # int64 [4] condition code register
    stack: np.ndarray  # int64 [CALL_STACK + 1] return instructions, then how many there are
    held: np.ndarray  # bool [NUM_LOCKS]
    counters: np.ndarray  # int64 [_NUM_COUNTERS]


# counters of a run
_TASK, _PC, _EXECUTED, _RECORDED, _RECORDS, _EMITTED, _TOTAL, _NUM_COUNTERS = range(8)
# _EXECUTED: instructions of this task; _RECORDED: those that are covered by records


class _Job(NamedTuple):
    """What does not change during a run."""

    code: np.ndarray  # int32 [num_instructions + 1, WIDTH]
    attributes: np.ndarray  # float32 [num_tasks, num_attributes * 4]
    memory: np.ndarray  # float32 [num_words], written by ST
    windows: np.ndarray  # int64 [2, 2] base and size of B0 and B1, bytes
    entry: int
    max_instructions: int


def execute(
    program: Program,
    attributes: np.ndarray,
    constants: np.ndarray,
    windows: tuple[Window, Window],
    memory: np.ndarray,
    max_instructions: int = 2**24,
) -> Executed:
    """Run the program once per task; memory is updated in place.

    attributes float32 [num_tasks, num_attributes <= 16, 4], constants float32 [256, 4], memory float32 [num_words].
    All registers are 0 and all condition codes EQ at the start of each task. Raises ArchsimError, naming kernel, task
    and line, when a task executes more than max_instructions, misuses a lock, or leaves the memory.
    """
    _check(program, attributes, constants, windows, memory)
    num_tasks = len(attributes)
    job = _Job(
        program.code,
        np.ascontiguousarray(attributes).reshape(num_tasks, -1),
        memory,
        np.array(windows, np.int64),
        program.entry,
        max_instructions,
    )
    state = _new_state(program, constants)
    log = _new_log(num_tasks)
    with np.errstate(all="ignore"):  # only matters where numba is switched off
        status = Status.FULL
        while status == Status.FULL:
            log = _with_room(log, state)
            status = Status(_run(job, state, log))
    if status != Status.ENDED:
        raise _error(program, status, state, job)
    return _result(state, log)


def _check(program, attributes, constants, windows, memory) -> None:
    problems = window_problems(windows)
    shapes = (
        (attributes.ndim == 3 and attributes.shape[1] <= NUM_ATTRIBUTES and attributes.shape[2] == 4, "attributes"),
        (constants.shape == (NUM_CONSTANTS, 4), "constants"),
        (memory.ndim == 1 and memory.flags.c_contiguous and memory.flags.writeable, "memory"),
    )
    problems += [Problem(None, f"the shape of {name} is wrong") for right, name in shapes if not right]
    arrays = {"attributes": attributes, "constants": constants, "memory": memory}
    for name, array in arrays.items():
        if array.dtype != np.float32:
            problems.append(Problem(None, f"{name} must be float32, not {array.dtype}"))
    if attributes.ndim == 3 and attributes.shape[1] < program.num_attributes:
        what = f"reads v[{program.num_attributes - 1}], but has {attributes.shape[1]} attributes"
        problems.append(Problem(None, f"kernel {program.name} {what}"))
    if problems:
        raise ArchsimError(problems)


def _new_state(program: Program, constants: np.ndarray) -> _State:
    state = _State(
        registers=np.zeros(NUM_SLOTS, np.float32),
        flags=np.full(4, EQUAL, np.int64),
        stack=np.zeros(CALL_STACK + 1, np.int64),
        held=np.zeros(NUM_LOCKS, np.bool_),
        counters=np.zeros(_NUM_COUNTERS, np.int64),
    )
    state.registers[CONSTANT:] = constants.reshape(-1)
    state.counters[_PC] = program.entry
    return state


def _new_log(num_tasks: int) -> _Log:
    starts = np.zeros(num_tasks + 1, np.int64)
    empty = np.empty(0, RECORD), np.empty(0, np.int64), np.empty(0, np.float32)
    return _Log(*empty, starts, starts.copy())


def _with_room(log: _Log, state: _State) -> _Log:
    """The log with at least one free place of each kind."""
    return log._replace(
        records=_grown(log.records, int(state.counters[_RECORDS]), 16 * len(log.starts)),
        address=_grown(log.address, int(state.counters[_EMITTED]), len(log.starts)),
        value=_grown(log.value, int(state.counters[_EMITTED]), len(log.starts)),
    )


def _grown(array: np.ndarray, used: int, at_least: int) -> np.ndarray:
    if used < len(array):
        return array
    larger = np.empty(max(2 * len(array), at_least), array.dtype)
    larger[:used] = array
    return larger


def _result(state: _State, log: _Log) -> Executed:
    num_records, num_emitted = int(state.counters[_RECORDS]), int(state.counters[_EMITTED])
    tasks = Tasks(log.starts, log.records[:num_records])
    address, value = log.address[:num_emitted], log.value[:num_emitted]
    return Executed(tasks, address, value, log.emitted_starts, int(state.counters[_TOTAL]))


def _error(program: Program, status: Status, state: _State, job: _Job) -> ArchsimError:
    task, pc = int(state.counters[_TASK]), int(state.counters[_PC])
    held = ", ".join(str(number) for number in np.flatnonzero(state.held))
    what = {
        Status.RUNAWAY: f"executes more than {job.max_instructions} instructions",
        Status.OUTSIDE: f"leaves the memory of {WORD_BYTES * len(job.memory)} bytes",
        Status.HELD_ALREADY: f"takes a lock that it holds already (it holds {held})",
        Status.NOT_HELD: f"gives back a lock that it does not hold (it holds {held or 'none'})",
        Status.LEFT_HELD: f"ends without giving back lock {held}",
    }[status]
    where = program.where[min(pc, program.num_instructions - 1)] if program.where else None
    return fail(f"kernel {program.name}, task {task}: {what}", where)


@njit(error_model="numpy", _nrt=False)
def _run(job, state, log):
    """Run tasks until all have ended, or something stops one; returns a Status."""
    num_tasks = job.attributes.shape[0]
    while state.counters[_TASK] < num_tasks:
        task = state.counters[_TASK]
        if state.counters[_EXECUTED] == 0:
            _begin(job, state, task)
        status = _run_task(job, state, log)
        if status != Status.ENDED:
            return np.int64(status)
        log.starts[task + 1] = state.counters[_RECORDS]
        log.emitted_starts[task + 1] = state.counters[_EMITTED]
        state.counters[_TASK] = task + 1
    return np.int64(Status.ENDED)


@njit(error_model="numpy", _nrt=False)
def _begin(job, state, task):
    """Reset the processor and hand it the attributes of the task."""
    for slot in range(TEMPORARY, ATTRIBUTE):
        state.registers[slot] = 0.0
    for k in range(job.attributes.shape[1]):
        state.registers[ATTRIBUTE + k] = job.attributes[task, k]
    for component in range(4):
        state.flags[component] = EQUAL
    state.stack[CALL_STACK] = 0
    state.counters[_PC] = job.entry
    state.counters[_RECORDED] = 0


@njit(error_model="numpy", _nrt=False)
def _run_task(job, state, log):
    """Run the current task from where it stands; returns a Status."""
    registers, flags, counters = state.registers, state.flags, state.counters
    pc, executed = counters[_PC], counters[_EXECUTED]
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
            status = _record(op, job, state, log, pc, executed)
            if status == Status.RUNNING:
                pc += 1
                executed += 1
    counters[_PC] = pc
    counters[_EXECUTED] = executed
    if status == Status.ENDED:
        counters[_TOTAL] += executed
        counters[_EXECUTED] = 0
    return status


@inlined
def _record(op, job, state, log, pc, executed):
    """Do an operation that is recorded, or end the task; returns RUNNING when the next instruction follows."""
    counters, registers = state.counters, state.registers
    if counters[_RECORDS] == len(log.records) or counters[_EMITTED] == len(log.address):
        return np.int64(Status.FULL)
    if op == Opcode.LD or op == Opcode.ST:
        return _access(op, job, state, log, pc, executed)
    if op == HALT:
        return _halt(job, state, log, executed)

    value = registers[job.code[pc, READ]]
    if op == Opcode.EMIT:
        log.address[counters[_EMITTED]] = _emitted_address(value)
        log.value[counters[_EMITTED]] = registers[job.code[pc, READ + 4]]
        counters[_EMITTED] += 1
        _write_record(counters, log, Op.EMIT, 0, 0, executed)
        return np.int64(Status.RUNNING)
    return _lock(op, state, log, _lock_number(value), executed)


@inlined
def _write_record(counters, log, op, address, num_bytes, executed):
    """Log an operation that is instruction number `executed` of its task."""
    record = log.records[counters[_RECORDS]]
    record["address"] = address
    record["compute"] = executed - counters[_RECORDED]
    record["bytes"] = num_bytes
    record["op"] = np.int16(op)
    counters[_RECORDS] += 1
    counters[_RECORDED] = executed + 1


@inlined
def _access(op, job, state, log, pc, executed):
    """LD or ST of 1, 2 or 4 words."""
    registers, num_words = state.registers, np.int64(job.code[pc, WORDS])
    address = _element_address(job, pc, registers[job.code[pc, READ]], num_words)
    first = address >> 2
    if first + num_words > len(job.memory):
        return np.int64(Status.OUTSIDE)

    if op == Opcode.LD:
        for k in range(num_words):
            registers[job.code[pc, WRITE + k]] = job.memory[first + k]
        _write_record(state.counters, log, Op.LOAD, address, 4 * num_words, executed)
    else:
        for k in range(num_words):
            job.memory[first + k] = registers[job.code[pc, READ + 4 + k]]
        _write_record(state.counters, log, Op.STORE, address, 4 * num_words, executed)
    return np.int64(Status.RUNNING)


@inlined
def _element_address(job, pc, index, num_words):
    """Byte address of an element, or of the guard element (memory.Window)."""
    window, element_bytes = job.code[pc, BASE], 4 * num_words
    base, size = job.windows[window, 0], job.windows[window, 1]
    num_elements = size >> (2 + (num_words >> 1))
    if index >= np.float32(0.0) and index < np.float32(num_elements):
        return base | np.int64(index) * element_bytes
    return base + size - element_bytes


@inlined
def _lock_number(value):
    if value >= np.float32(0.0) and value < _LARGEST_INTEGER:
        return np.int64(value) & (NUM_LOCKS - 1)
    return np.int64(NO_LOCK)


@inlined
def _emitted_address(value):
    return np.int64(value) if abs(value) < _LARGEST_INTEGER else np.int64(NO_ADDRESS)


@inlined
def _lock(op, state, log, number, executed):
    """LOCK or UNLK. Tasks run one by one, so a lock is never waited for, but misuse is found."""
    taken = op == Opcode.LOCK
    if state.held[number] == taken:
        return np.int64(Status.HELD_ALREADY) if taken else np.int64(Status.NOT_HELD)
    state.held[number] = taken
    if taken:
        _write_record(state.counters, log, Op.LOCK, number, 0, executed)
    else:
        _write_record(state.counters, log, Op.UNLOCK, number, 0, executed)
    return np.int64(Status.RUNNING)


@inlined
def _halt(job, state, log, executed):
    """Close the task's records."""
    if executed > job.max_instructions:
        return np.int64(Status.RUNAWAY)
    for number in range(NUM_LOCKS):
        if state.held[number]:
            return np.int64(Status.LEFT_HELD)
    _write_record(state.counters, log, Op.END, 0, 0, executed)
    return np.int64(Status.ENDED)
