"""How far the brute-force column fixes the other two: `python spread.py ROW [SECONDS [SEED]]`.

Draws the best view of each start of `calibrate.py` by all variants, at full resolution, and prints a Markdown table.
"""

from __future__ import annotations

import sys
from pathlib import Path

from calibrate import GOOD, Found, printed_column, search

from archsim.config import load_walkthrough
from archsim.run.shadow_volumes import method_of, prepare_light
from archsim.run.walkthrough import resources_of
from archsim.scene.scene import load_scene
from archsim.shadow_volumes.comparison import VARIANTS, Traffic, draw

HERE = Path(__file__).resolve().parent


def main() -> None:
    row, *numbers = sys.argv[1:]
    seconds = float(numbers[0]) if numbers else 120.0
    found = {each.start: each for each in search(row, seconds, int(numbers[1]) if len(numbers) > 1 else 0)}
    print(f"printed: {printed_column(row)}")
    print("| misfit | BF pixels [M] | BF : DB pixels | BF : H pixels | BF : DB bytes | BF : H bytes | view |")
    print("|---|---|---|---|---|---|---|")
    for view in found.values():
        if view.misfit < 2 * GOOD:
            print(_line(view, *_drawn(row, view)), flush=True)


def _drawn(row: str, view: Found) -> list[Traffic]:
    """What the variants move in a view."""
    config = load_walkthrough(HERE / f"{row}.yaml", view.overrides)
    method = method_of(config.shadow_volumes, resources_of(config.shadow_volumes))
    seen = prepare_light(load_scene(config.scene), config.shadow_volumes.light, method)
    return [draw(seen, variant, method.resources).traffic for variant in VARIANTS]


def _line(view: Found, brute: Traffic, bounded: Traffic, hierarchical: Traffic) -> str:
    others = (bounded, hierarchical)
    ratios = [
        *(brute.processed / max(other.processed, 1) for other in others),
        *(brute.total / max(other.total, 1) for other in others),
    ]
    numbers = " | ".join(f"{ratio:.2f}" for ratio in ratios)
    return f"| {view.misfit:.3f} | {brute.processed / 1e6:.2f} | {numbers} | {' '.join(view.overrides)} |"


if __name__ == "__main__":
    main()
