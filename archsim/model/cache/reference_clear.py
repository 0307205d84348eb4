"""Which blocks of memory are known to be cleared, to be believed."""

from __future__ import annotations

from archsim.model.cache.spec import ClearSpec


class ClearBits:
    """Which blocks of memory are known to be cleared."""

    def __init__(self, spec: ClearSpec):
        self.spec = spec
        self.blocks = set(range(spec.num_blocks)) if spec.is_clear_at_first else set()

    def are_set(self, address: int, num_bytes: int) -> bool:
        """Whether all these bytes are known to be cleared."""
        if self.spec.block_bytes == 0:
            return False
        offset = address - self.spec.first_address
        return set(range(offset // self.spec.block_bytes, self._end(offset + num_bytes))) <= self.blocks

    def set(self, address: int, num_bytes: int) -> tuple[int, int]:
        """The blocks that lie within these bytes are cleared; first and last address of them."""
        size, offset = self.spec.block_bytes, address - self.spec.first_address
        first = max(self._end(offset), 0)
        end = max(first, min((offset + num_bytes) // size, self.spec.num_blocks))
        self.blocks |= set(range(first, end))
        return self.spec.first_address + first * size, self.spec.first_address + end * size

    def reset(self, address: int, num_bytes: int) -> None:
        """These bytes are written."""
        if self.spec.block_bytes > 0:
            offset = address - self.spec.first_address
            self.blocks -= set(range(offset // self.spec.block_bytes, self._end(offset + num_bytes)))

    def _end(self, offset: int) -> int:
        """Number of the first block that begins at or after the offset."""
        return -(-offset // self.spec.block_bytes)
