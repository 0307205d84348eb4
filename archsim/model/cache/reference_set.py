"""A set of ways and which of them gives up its line, to be believed."""

from __future__ import annotations

from collections.abc import Callable

from archsim.model.cache.replacement import random_way
from archsim.model.cache.spec import CacheSpec, Replacement
from archsim.model.waiting import Wait

Answer = Callable[[int], None]  # (tick): the data is here


class Fetch:
    """Sectors on their way. `arrival` is when the fetch reaches the next level."""

    def __init__(self, arrival: int, sectors: set[int], num_parts: int):
        self.arrival, self.sectors, self.parts_left = arrival, sectors, num_parts
        self.wait, self.parts = Wait(), [Wait() for _ in range(num_parts)]
        self.answered = (-1, -1)  # tick and number of the part that was answered last
        self.targets: list[Answer] = []


class Way:
    """The place of one line. `line` is the line's number, None when invalid."""

    def __init__(self) -> None:
        self.line: int | None = None
        self.present: set[int] = set()  # sectors
        self.coming: dict[int, Fetch] = {}  # by sector
        self.dirty: set[int] = set()
        self.last_use = 0
        self.first_use = 0

    def take(self, line: int | None) -> None:
        """The place now belongs to `line`, of which nothing is here, or to none."""
        self.line, self.present, self.dirty = line, set(), set()


class Set:
    """The ways that a line may be in. `use` is the number of the accepted request that uses one of them."""

    def __init__(self, spec: CacheSpec):
        self.spec = spec
        self.ways = [Way() for _ in range(spec.num_ways)]
        self.tree = Tree(spec.num_ways)

    def find(self, line: int) -> Way | None:
        return next((way for way in self.ways if way.line == line), None)

    def mark(self, way: Way, use: int) -> None:
        """The request uses the line in this way."""
        way.last_use = use
        self.tree.turn_away_from(self.ways.index(way))

    def victim(self, use: int) -> Way | None:
        """The way for a new line: the lowest-numbered invalid one, else by policy; None if all are on their way."""
        free = [way for way in self.ways if not way.coming]
        invalid = [way for way in free if way.line is None]
        if invalid or not free:
            return invalid[0] if invalid else None
        if self.spec.replacement == Replacement.LRU:
            return min(free, key=lambda way: way.last_use)
        if self.spec.replacement == Replacement.FIFO:
            return min(free, key=lambda way: way.first_use)

        if self.spec.replacement == Replacement.TREE_PLRU:
            wanted = self.tree.points_to()
        else:
            wanted = random_way(self.spec.seed, use, self.spec.num_ways)
        in_turn = self.ways[wanted:] + self.ways[:wanted]
        return next(way for way in in_turn if not way.coming)


class Tree:
    """Tree-PLRU of one set: at each node, whether the lower or the upper half of its ways is to be replaced."""

    def __init__(self, num_ways: int):
        self.num_ways = num_ways
        self.is_upper: dict[tuple[int, int], bool] = {}  # by the range of ways of the node

    def turn_away_from(self, way: int) -> None:
        """Every node above `way` points to the half that `way` is not in."""
        low, high = 0, self.num_ways
        while high - low > 1:
            middle = (low + high) // 2
            self.is_upper[low, high] = way < middle
            low, high = (low, middle) if way < middle else (middle, high)

    def points_to(self) -> int:
        low, high = 0, self.num_ways
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.is_upper.get((low, high), False) else (low, middle)
        return low
