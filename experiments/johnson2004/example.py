"""Johnson et al. 2004 from Python: one light view at reduced size, its tables' columns, and what its machine waits for.

Run: python experiments/johnson2004/example.py [WIDTH HEIGHT]      (default: 160 128, seconds)
"""

from __future__ import annotations

import sys
import tempfile

import archsim


def main(width: int, height: int) -> None:
    size = {"scene.resolution": [width, height]}
    run = archsim.simulate("izb_knot", size)
    frame = run.frame()
    for name in (
        "izb_build.cycles_per_point",
        "izb_build.useful_percent",
        "izb_raster.cycles_per_tri_sample",
    ):
        print(f"{name:36} {run[name]:8.2f} {frame.loc[name, 'unit']}")
    print(frame[frame.index.str.contains("izb_raster.stall")]["value"].round(2).to_string())

    threads = {
        "name": "threads of a fragment processor",
        "run": "runs/izb_knot.yaml",
        "set": size,
        "parameters": [{"grid": {"machine.components.fragment_processors.threads": [1, 2, 4, 8]}}],
        "metrics": ["izb_raster.cycles"],
    }
    with tempfile.TemporaryDirectory() as folder:
        print(archsim.sweep(threads, out=folder).points().to_string(index=False))


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:3] or ("160", "128")))
