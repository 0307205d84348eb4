"""Aila, Akenine-Möller 2004 from Python: one frame of the knights by two variants, and what limits the pipeline.

Run: python experiments/aila2004/example.py [WIDTH HEIGHT]      (default: 320 240, half a minute)
"""

from __future__ import annotations

import sys

import pandas as pd

import archsim


def main(width: int, height: int) -> None:
    size = {"scene.resolution": [width, height]}
    runs = {
        variant: archsim.simulate(f"hsv_knights_{variant}", size)
        for variant in ("brute_force", "hierarchical")
    }
    names = ["traffic.total", "traffic.processed", "shadow_volumes.cycles", "shadow_volumes.dram.bytes"]
    print(
        pd.DataFrame({variant: run.frame().loc[names, "value"] for variant, run in runs.items()}).to_string()
    )
    for name in ("traffic.total", "shadow_volumes.cycles"):
        print(
            f"{name}: {runs['brute_force'][name] / runs['hierarchical'][name]:.2f} times less hierarchically"
        )

    frame = runs["hierarchical"].frame()
    busy = frame[frame.index.str.endswith(".busy_percent")]["value"]
    print(busy.round(1).sort_values(ascending=False).head(5).to_string())


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3] or ("320", "240")))
