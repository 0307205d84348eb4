"""How far the frames of a walkthrough lie apart: `python spread.py ROW [FOLDER]`.

Prints a Markdown table: of what table 1 prints about depth bounds and the hierarchical algorithm the mean, and the
least, quartiles and greatest of the frames; then the pixels of each frame, and what share of all they are. Frames are
kept in FOLDER, and not drawn again when they are there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from archsim.config import load_walkthrough
from archsim.run.frames import Frame
from archsim.run.walkthrough import drawn_frames
from archsim.shadow_volumes.comparison import BRUTE_FORCE, DEPTH_BOUNDS, HIERARCHICAL, Traffic

HERE = Path(__file__).resolve().parent
MB = 2**20
QUANTITIES: dict[str, Callable[[Traffic], float]] = {
    "stencil, shadow pass [MB]": lambda traffic: traffic.stencil_shadow / MB,
    "depth [MB]": lambda traffic: traffic.depth_shadow / MB,
    "stencil, lighting pass [MB]": lambda traffic: traffic.stencil_lighting / MB,
    "PSV [MB]": lambda traffic: traffic.psv / MB,
    "delay stream [MB]": lambda traffic: traffic.delay_stream / MB,
    "total [MB]": lambda traffic: traffic.total / MB,
    "pixels [million]": lambda traffic: traffic.processed / 1e6,
}
VARIANTS = {"BF": BRUTE_FORCE, "DB": DEPTH_BOUNDS, "H": HIERARCHICAL}


def main() -> None:
    row, *folder = sys.argv[1:]
    config = load_walkthrough(HERE / f"{row}.yaml")
    frames = drawn_frames(config, folder=Path(folder[0]) if folder else None)
    print("| quantity | mean | least | quarter | half | three quarters | greatest |")
    print("|---|---|---|---|---|---|---|")
    for what, of in QUANTITIES.items():
        for column, variant in VARIANTS.items():
            numbers = _each(frames, of, variant)
            if numbers.any():
                print(_line(f"{what} {column}", numbers))
    for what in ("pixels [million]", "total [MB]"):
        brute = _each(frames, QUANTITIES[what], BRUTE_FORCE)
        for column in ("DB", "H"):
            other = np.maximum(_each(frames, QUANTITIES[what], VARIANTS[column]), 1e-9)
            print(_line(f"BF : {column} {what.split()[0]}", brute / other, brute.mean() / other.mean()))
    _print_each_frame(frames)


def _print_each_frame(frames: list[Frame]) -> None:
    """Pixels, frame by frame."""
    numbers = np.array([_each(frames, QUANTITIES["pixels [million]"], each) for each in VARIANTS.values()])
    print(f"\n| frame | {' | '.join(f'{column}, share of all' for column in VARIANTS)} | BF : H |")
    print("|---|---|---|---|---|")
    for index, own in enumerate(numbers.T):
        cells = [
            f"{number:.3g}, {100 * number / of:.1f} %"
            for number, of in zip(own, numbers.sum(axis=1), strict=True)
        ]
        print(f"| {index} | {' | '.join(cells)} | {own[0] / max(own[2], 1e-9):.3g} |")


def _each(frames: list[Frame], of: Callable[[Traffic], float], variant: str) -> np.ndarray:
    """float64 [num_frames]."""
    return np.array([of(frame.traffic[variant]) for frame in frames])


def _line(what: str, numbers: np.ndarray, mean: float | None = None) -> str:
    """Of a ratio, the mean is that of what it is the ratio of."""
    shown = [numbers.mean() if mean is None else mean, *np.quantile(numbers, [0, 0.25, 0.5, 0.75, 1])]
    return f"| {what} | {' | '.join(f'{number:.3g}' for number in shown)} |"


if __name__ == "__main__":
    main()
