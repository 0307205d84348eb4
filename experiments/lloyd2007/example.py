"""Lloyd et al. 2007 from Python: a logarithmic and a linear shadow map of one view, drawn on the tile pipeline.

Run: python experiments/lloyd2007/example.py [TEXELS]      (default: 128 columns and rows, seconds)
"""

from __future__ import annotations

import sys

import pandas as pd

import archsim


def main(texels: int) -> None:
    maps = {
        "logarithmic": {"workload.texels": [texels, texels]},
        "linear": {
            "workload.texels": [texels, texels],
            "workload.maps": "fp_lispsm",
            "workload.rasterization": "linear",
        },
    }
    runs = {name: archsim.simulate("lograster_tiny", changes) for name, changes in maps.items()}
    names = list(runs["logarithmic"].result.summary)
    table = pd.DataFrame({name: pd.Series(run.result.summary) for name, run in runs.items()})
    print(table.loc[names].to_string())


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:2] or ("128",)))
