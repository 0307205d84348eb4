"""Address traces that archsim and its peers both play: seeded ones, and the requests of a real run."""

from __future__ import annotations

import numpy as np

from archsim.config import load_run
from archsim.run.export import export
from archsim.run.progress import silent
from archsim.trace.accesses import ACCESS, Kind

WORD_BYTES = 4
LINE_BYTES = 64  # of requests to a DRAM


def accesses(addresses: np.ndarray, num_bytes: int, is_write: np.ndarray | bool = False) -> np.ndarray:
    """ACCESS records of one requester, made as soon as they can be."""
    made = np.zeros(len(addresses), ACCESS)
    made["address"], made["bytes"] = addresses, num_bytes
    made["kind"] = np.where(is_write, int(Kind.WRITE), int(Kind.READ))
    return made


def scattered(count: int, span_bytes: int, seed: int) -> np.ndarray:
    """Words anywhere in a span, three in ten of them written."""
    draw = np.random.default_rng(seed)
    words = draw.integers(0, span_bytes // WORD_BYTES, count)
    return accesses(words * WORD_BYTES, WORD_BYTES, draw.random(count) < 0.3)


def strided(count: int, stride_bytes: int, span_bytes: int) -> np.ndarray:
    """Words a stride apart, round and round a span; every third is written."""
    number = np.arange(count)
    return accesses(number * stride_bytes % span_bytes, WORD_BYTES, number % 3 == 2)


def favoured(count: int, span_bytes: int, seed: int) -> np.ndarray:
    """Words of a span, the nearer to its beginning the more often; a quarter is written, some cross a line."""
    draw = np.random.default_rng(seed)
    words = (span_bytes // WORD_BYTES * draw.random(count) ** 4).astype(np.int64)
    places = words * WORD_BYTES + WORD_BYTES // 2 * (draw.random(count) < 0.05)
    return accesses(places, WORD_BYTES, draw.random(count) < 0.25)


def program(count: int, seed: int) -> np.ndarray:
    """Instruction fetches that go on or jump back, two in five accesses; the others load and store words."""
    draw = np.random.default_rng(seed)
    code = np.zeros(count, np.int64)
    jumps = np.flatnonzero(draw.random(count) < 0.05)
    code[jumps] = -draw.integers(1, 200, len(jumps))
    data = (1 << 20) + (1 << 14) * draw.random(count) ** 4 // WORD_BYTES * WORD_BYTES
    is_fetch = draw.random(count) < 0.4
    made = accesses(data.astype(np.int64), WORD_BYTES, draw.random(count) < 0.3)
    made["address"][is_fetch] = WORD_BYTES * (np.cumsum(code + 1)[is_fetch] % (1 << 12))
    made["kind"][is_fetch] = Kind.FETCH
    return made


def ragged(count: int, span_bytes: int, most_bytes: int, seed: int) -> np.ndarray:
    """Any number of bytes anywhere in a span, across one line or many; a third is written, a tenth fetched as code."""
    draw = np.random.default_rng(seed)
    made = accesses(draw.integers(0, span_bytes, count), 1, draw.random(count) < 0.35)
    made["bytes"] = draw.integers(1, most_bytes + 1, count)
    made["kind"][draw.random(count) < 0.1] = Kind.FETCH
    return made


def exported(run: str, level: str, overrides: list[str]) -> np.ndarray:
    """The requests of a run at a level of its machine, as `archsim trace export` writes them."""
    chunks: list[np.ndarray] = []

    def take(chunk: np.ndarray) -> None:
        chunks.append(chunk.copy())

    export(load_run(f"runs/{run}.yaml", overrides), level, None, take, silent)
    return np.concatenate(chunks)


def requests(
    addresses: np.ndarray, is_write: np.ndarray | bool = False, interval_clocks: int = 0
) -> np.ndarray:
    """ACCESS records of whole lines for a DRAM, one every `interval_clocks`."""
    made = accesses(addresses // LINE_BYTES * LINE_BYTES, LINE_BYTES, is_write)
    made["cycle"] = np.arange(len(made)) * interval_clocks
    return made


def distinct_lines(count: int, span_bytes: int, seed: int) -> np.ndarray:
    """Addresses of lines anywhere in a span, no line twice."""
    number = np.random.default_rng(seed).choice(span_bytes // LINE_BYTES, count, replace=False)
    return number.astype(np.int64) * LINE_BYTES


def as_lines(made: np.ndarray, is_hurried: bool) -> np.ndarray:
    """The same requests in whole lines; hurried: all of them made at once."""
    found = requests(made["address"], made["kind"] == Kind.WRITE)
    if not is_hurried:
        found["cycle"] = made["cycle"]
    return found


def unmerged(made: np.ndarray) -> np.ndarray:
    """The same requests for a peer that merges those of one address: each to a byte of its own of its line."""
    found = made.copy()
    found["address"] += np.arange(len(made)) % LINE_BYTES
    found["bytes"] = 1
    return found


def one_a_clock(made: np.ndarray) -> np.ndarray:
    """The same requests, no two made in the same clock."""
    found, number = made.copy(), np.arange(len(made))
    found["cycle"] = np.maximum.accumulate(made["cycle"] - number) + number
    return found
