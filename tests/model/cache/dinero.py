"""The rules by which Dinero IV counts, written down literally: stacks of blocks, a stack of pending references."""

from __future__ import annotations

from collections import Counter

from archsim.model.cache.spec import CacheSpec, Replacement, WritePolicy


class Block:
    """A line: which sub-blocks are valid and which are dirty."""

    def __init__(self, address: int):
        self.address = address
        self.valid: set[int] = set()
        self.dirty: set[int] = set()


class Memory:
    """What lies below the last cache."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()

    def reference(self, is_write: bool, address: int, size: int) -> None:
        self.counts["writes" if is_write else "reads"] += 1

    def copy_back(self) -> None:
        pass


class Level:
    """One cache. A stack has the block on top that was used (LRU) or came (FIFO) last."""

    def __init__(self, spec: CacheSpec, below: Level | Memory):
        self.spec, self.below = spec, below
        self.stacks: list[list[Block]] = [[] for _ in range(spec.num_sets)]
        self.pending: list[tuple[Level | Memory, bool, int, int]] = []
        self.counts: Counter[str] = Counter()

    def reference(self, is_write: bool, address: int, size: int) -> None:
        base = address - address % self.spec.line_bytes
        end = base + self.spec.line_bytes
        if address + size > end:
            self.pending.append((self, is_write, end, address + size - end))
            size = end - address
        self._look_up(is_write, base, address, size)
        self._drain()

    def copy_back(self) -> None:
        """Dinero's last act: everything dirty goes down, level by level."""
        for stack in self.stacks:
            for block in stack:
                self._write_back(block)
        self._drain()
        self.below.copy_back()

    def _drain(self) -> None:
        while self.pending:
            whom, is_write, address, size = self.pending.pop()
            if whom is not self:
                self.counts["bytes_written" if is_write else "bytes_read"] += size
            whom.reference(is_write, address, size)

    def _look_up(self, is_write: bool, base: int, address: int, size: int) -> None:
        spec = self.spec
        touched = set(
            range((address - base) // spec.sector_bytes, (address + size - 1 - base) // spec.sector_bytes + 1)
        )
        stack = self.stacks[base // spec.line_bytes % spec.num_sets]
        block = next((each for each in stack if each.address == base), None)
        is_block_miss = block is None
        is_miss = block is None or not touched <= block.valid
        allocates = is_write and bool(spec.allocates_writes)

        self.counts["writes" if is_write else "reads"] += 1
        self.counts["write_misses" if is_write else "read_misses"] += is_miss
        writes_back = False
        if not is_write or not is_block_miss or allocates:
            block = self._replace(stack, block, base)
            block.valid |= touched
            writes_back = is_write and spec.write_policy == WritePolicy.WRITE_BACK
            if writes_back:
                block.dirty |= touched
            if is_block_miss and len(stack) > spec.num_ways:
                self._write_back(stack.pop())

        covered = len(touched) * spec.sector_bytes
        if is_write and not writes_back:
            self.counts["writethroughs"] += 1
            self.pending.append((self.below, True, address, size))
        if is_miss and (not is_write or (allocates and size != covered)):
            self.counts["fetches"] += 1
            self.pending.append((self.below, False, address - address % spec.sector_bytes, covered))

    def _replace(self, stack: list[Block], block: Block | None, base: int) -> Block:
        if block is None:
            stack.insert(0, Block(base))
        elif self.spec.replacement == Replacement.LRU:
            stack.remove(block)
            stack.insert(0, block)
        return stack[0] if block is None else block

    def _write_back(self, block: Block) -> None:
        for run in runs(block.dirty):
            self.counts["writebacks"] += 1
            address = block.address + run[0] * self.spec.sector_bytes
            self.pending.append((self.below, True, address, len(run) * self.spec.sector_bytes))
        block.dirty = set()


def runs(numbers: set[int]) -> list[list[int]]:
    """The numbers in ascending runs of neighbours."""
    found: list[list[int]] = []
    for number in sorted(numbers):
        if found and found[-1][-1] == number - 1:
            found[-1].append(number)
        else:
            found.append([number])
    return found


def replay(specs: list[CacheSpec], requests: list[tuple[int, int, bool]], flush: bool) -> list[Counter[str]]:
    """Counts of every level and of the memory, after (address, bytes, is_write) requests to the first level."""
    levels: list[Level | Memory] = [Memory()]
    for spec in reversed(specs):
        levels.insert(0, Level(spec, levels[0]))
    for address, size, is_write in requests:
        levels[0].reference(is_write, address, size)
    if flush:
        levels[0].copy_back()
    return [level.counts for level in levels]
