"""What the interpreter keeps: the processor, the job it is given, the log it writes."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from archsim.isa.encoding import ATTRIBUTE, CONSTANT, NUM_SLOTS, TEMPORARY
from archsim.isa.program import CALL_STACK, EQUAL, NUM_LOCKS, Program
from archsim.jit import compiled
from archsim.trace.records import RECORD

_SMALLEST_LOG = 4096  # entries


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


class Log(NamedTuple):
    """Where the run is written down."""

    records: np.ndarray  # RECORD [capacity]
    address: np.ndarray  # int64 [capacity of emits]
    value: np.ndarray  # float32 [capacity of emits]
    starts: np.ndarray  # int64 [num_tasks + 1] first record of each task
    emitted_starts: np.ndarray  # int64 [num_tasks + 1]


class State(NamedTuple):
    """The processor between two instructions."""

    registers: np.ndarray  # float32 [NUM_SLOTS]
    flags: np.ndarray  # int64 [4] condition code register
    stack: np.ndarray  # int64 [CALL_STACK + 1] return instructions, then how many there are
    held: np.ndarray  # bool [NUM_LOCKS]
    counters: np.ndarray  # int64 [NUM_COUNTERS]


# Counters of a run: current task and instruction; instructions of the task executed, and those of them that
# records cover; records and emits logged; locks held; instructions of all tasks that have ended.
TASK, PC, EXECUTED, RECORDED, RECORDS, EMITTED, HELD, TOTAL, NUM_COUNTERS = range(9)


class Job(NamedTuple):
    """What does not change during a run."""

    code: np.ndarray  # int32 [num_instructions + 1, WIDTH]
    attributes: np.ndarray  # float32 [num_tasks, num_attributes * 4]
    memory: np.ndarray  # float32 [num_words], written by ST
    windows: np.ndarray  # int64 [2, 2] base and size of B0 and B1, bytes
    entry: int
    max_instructions: int


def new_state(program: Program, constants: np.ndarray) -> State:
    """The processor before the first task, with its parameter registers loaded."""
    state = State(
        registers=np.zeros(NUM_SLOTS, np.float32),
        flags=np.full(4, EQUAL, np.int64),
        stack=np.zeros(CALL_STACK + 1, np.int64),
        held=np.zeros(NUM_LOCKS, np.bool_),
        counters=np.zeros(NUM_COUNTERS, np.int64),
    )
    state.registers[CONSTANT:] = constants.reshape(-1)
    state.counters[PC] = program.entry
    return state


def new_log(num_tasks: int) -> Log:
    """A log without room for records and emits."""
    starts = np.zeros(num_tasks + 1, np.int64)
    return Log(np.empty(0, RECORD), np.empty(0, np.int64), np.empty(0, np.float32), starts, starts.copy())


def with_room(log: Log, state: State, num_tasks: int) -> Log:
    """The log with room for what the remaining tasks will probably need, at least for one more entry."""
    share = (num_tasks + 1) / (int(state.counters[TASK]) + 1)
    num_emitted = int(state.counters[EMITTED])
    return log._replace(
        records=_grown(log.records, int(state.counters[RECORDS]), share),
        address=_grown(log.address, num_emitted, share),
        value=_grown(log.value, num_emitted, share),
    )


def _grown(array: np.ndarray, used: int, share: float) -> np.ndarray:
    """The array, or if it is full a copy that is long enough if the other tasks are like those until now."""
    if used < len(array):
        return array
    length = max(int(1.1 * used * share), 2 * used, _SMALLEST_LOG)
    larger = np.empty(length, array.dtype)
    larger.view(np.uint8)[: array.nbytes] = array.view(np.uint8)  # as bytes: fast for records, too
    return larger


@compiled
def begin(job, state, task):
    """Reset the processor and hand it the attributes of the task."""
    for slot in range(TEMPORARY, ATTRIBUTE):
        state.registers[slot] = 0.0
    for k in range(job.attributes.shape[1]):
        state.registers[ATTRIBUTE + k] = job.attributes[task, k]
    for component in range(4):
        state.flags[component] = EQUAL
    state.stack[CALL_STACK] = 0
    state.counters[PC] = job.entry
    state.counters[RECORDED] = 0
