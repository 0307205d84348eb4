"""The operations that become records: LD, ST, LOCK, UNLK, EMIT, and the end of a task."""

import numpy as np

from archsim.execute.state import EMITTED, HELD, RECORDED, RECORDS, Status
from archsim.isa.encoding import BASE, HALT, READ, WORDS, WRITE
from archsim.isa.opcodes import Opcode
from archsim.isa.program import NUM_LOCKS
from archsim.jit import inlined
from archsim.trace.records import Op

NO_LOCK = NUM_LOCKS - 1  # the lock of numbers that are NaN, negative or too large
NO_ADDRESS = -1  # emitted for numbers that are NaN or too large

_LARGEST_INTEGER = np.float32(2.0**62)


@inlined
def record(op, job, state, log, pc, executed):
    """Do an operation that is recorded, or end the task; returns RUNNING if the next instruction follows."""
    counters, registers = state.counters, state.registers
    if counters[RECORDS] == len(log.records) or counters[EMITTED] == len(log.address):
        return np.int64(Status.FULL)
    if op == Opcode.LD or op == Opcode.ST:
        return _access(op, job, state, log, pc, executed)
    if op == HALT:
        return _halt(job, state, log, executed)

    value = registers[job.code[pc, READ]]
    if op == Opcode.EMIT:
        log.address[counters[EMITTED]] = _emitted_address(value)
        log.value[counters[EMITTED]] = registers[job.code[pc, READ + 4]]
        counters[EMITTED] += 1
        _write_record(counters, log, Op.EMIT, 0, 0, executed)
        return np.int64(Status.RUNNING)
    return _lock(op, state, log, _lock_number(value), executed)


@inlined
def _write_record(counters, log, op, address, num_bytes, executed):
    """Log an operation that is instruction number `executed` of its task."""
    entry = log.records[counters[RECORDS]]
    entry["address"] = address
    entry["compute"] = executed - counters[RECORDED]
    entry["bytes"] = num_bytes
    entry["op"] = np.int16(op)
    counters[RECORDS] += 1
    counters[RECORDED] = executed + 1


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
    state.counters[HELD] += 1 if taken else -1
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
    if state.counters[HELD] != 0:
        return np.int64(Status.LEFT_HELD)
    _write_record(state.counters, log, Op.END, 0, 0, executed)
    return np.int64(Status.ENDED)
