"""How far the brute-force column fixes the other two: `python others.py ROW [SECONDS [SEED]]`.

Draws the best walkthrough of each start of `calibrate.py` by all variants, at full resolution, and prints a Markdown
table.
"""

from __future__ import annotations

import sys
from pathlib import Path

from calibrate import GOOD, Found, printed_column, search

from archsim.config import load_walkthrough
from archsim.run.result import Result
from archsim.run.walkthrough import simulate_walkthrough

HERE = Path(__file__).resolve().parent
FRAMES = "frames=8"


def main() -> None:
    row, *numbers = sys.argv[1:]
    seconds = float(numbers[0]) if numbers else 120.0
    found = {each.start: each for each in search(row, seconds, int(numbers[1]) if len(numbers) > 1 else 0)}
    print(f"printed: {printed_column(row)}")
    print("| misfit | BF pixels [M] | BF : DB pixels | BF : H pixels | BF : DB bytes | BF : H bytes |")
    print("|---|---|---|---|---|---|")
    for walk in found.values():
        if walk.misfit < 8 * GOOD:
            config = load_walkthrough(HERE / f"{row}.yaml", [*walk.overrides, FRAMES])
            print(_line(walk, simulate_walkthrough(config)), flush=True)


def _line(walk: Found, result: Result) -> str:
    ratios = [
        result.value(f"brute_force.{what}") / max(result.value(f"{variant}.{what}"), 1)
        for what in ("processed", "total")
        for variant in ("depth_bounds", "hierarchical")
    ]
    pixels = result.value("brute_force.processed") / 1e6
    return f"| {walk.misfit:.3f} | {pixels:.2f} | {' | '.join(f'{ratio:.2f}' for ratio in ratios)} |"


if __name__ == "__main__":
    main()
