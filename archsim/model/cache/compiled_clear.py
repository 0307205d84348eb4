"""Which blocks of memory are known to be cleared, compiled: the bits of all caches, one after the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from archsim.model.cache.spec import ClearSpec
from archsim.model.compiled import inlined_step, step

NO_CLEAR = -1  # `clear_shift` of a cache without clear bits


def fill_in(table: np.ndarray, specs: Sequence[ClearSpec]) -> None:
    """Write the clear bits' fields of CACHE_SPEC."""
    blocks = np.array([spec.num_blocks for spec in specs], np.int64)
    table["clear_shift"] = [spec.block_bytes.bit_length() - 1 for spec in specs]
    table["clear_start"] = [spec.first_address for spec in specs]
    table["num_blocks"] = blocks
    table["first_block"] = np.cumsum(blocks) - blocks


def new_bits(specs: Sequence[ClearSpec]) -> np.ndarray:
    """What is known before anything happens."""
    return np.repeat(
        np.array([spec.is_clear_at_first != 0 for spec in specs], np.bool_),
        np.array([spec.num_blocks for spec in specs], np.int64),
    )


@inlined_step
def is_clear(spec, bits, address, num_bytes):
    """Whether all these bytes are known to be cleared."""
    if spec["clear_shift"] == NO_CLEAR:
        return False
    return _all_set(spec, bits, address, num_bytes)


@step
def _all_set(spec, bits, address, num_bytes):
    first = (address - spec["clear_start"]) >> spec["clear_shift"]
    last = (address + num_bytes - 1 - spec["clear_start"]) >> spec["clear_shift"]
    if first < 0 or last >= spec["num_blocks"]:
        return False
    for block in range(first, last + 1):
        if not bits[spec["first_block"] + block]:
            return False
    return True


@step
def set_bits(spec, bits, address, num_bytes):
    """The blocks that lie within these bytes are cleared; first and last address of them."""
    shift, start = spec["clear_shift"], spec["clear_start"]
    first = max((address - start + (1 << shift) - 1) >> shift, 0)
    end = max(min((address + num_bytes - start) >> shift, spec["num_blocks"]), first)
    for block in range(first, end):
        bits[spec["first_block"] + block] = True
    return start + (first << shift), start + (end << shift)


@inlined_step
def reset(spec, bits, address, num_bytes):
    """These bytes are written."""
    if spec["clear_shift"] != NO_CLEAR:
        _reset(spec, bits, address, num_bytes)


@step
def _reset(spec, bits, address, num_bytes):
    first = (address - spec["clear_start"]) >> spec["clear_shift"]
    last = (address + num_bytes - 1 - spec["clear_start"]) >> spec["clear_shift"]
    for block in range(max(first, 0), min(last + 1, spec["num_blocks"])):
        bits[spec["first_block"] + block] = False
