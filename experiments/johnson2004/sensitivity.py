"""What the machine parameters that the paper does not print do to its tables.

Run: python experiments/johnson2004/sensitivity.py [ROW ...]      (default: all three rows)

The kernels are executed once for each row; the same work is then played on every variant of the machine.
"""

from __future__ import annotations

import sys

from archsim import resources
from archsim.config import load_run
from archsim.machine.build import phase_machine
from archsim.machine.play import play
from archsim.run.izb_work import record, replay

ROWS = ("doom_light0", "doom_light1", "knot_light0")


def l1_mshrs(number: int) -> list[str]:
    return [f"machine.components.{cache}.mshrs={number}" for cache in ("cpu_l1", "fragment_l1")]


VARIANTS = {
    "as configured": [],
    "1 MSHR in each L1": l1_mshrs(1),
    "2 MSHRs in each L1": l1_mshrs(2),
    "3 MSHRs in each L1": l1_mshrs(3),
    "8 MSHRs in each L1": l1_mshrs(8),
    "8 MSHRs in the L2": ["machine.components.l2.mshrs=8"],
    "FCFS instead of FR-FCFS": ["machine.components.dram.scheduler=fcfs"],
    "channels above lines": ["machine.components.dram.address_map=row:bank:channel:line:offset"],
    "no refresh": ["machine.components.dram.timing.n_refi=0"],
}


def main() -> None:
    print("| row | machine | build useful % | L2 miss | raster useful % | L2 miss |")
    print("|---|---|---|---|---|---|")
    for row in sys.argv[1:] or ROWS:
        path = resources.experiment("johnson2004") / f"{row}.yaml"
        (work,) = record(load_run(path))
        for name, overrides in VARIANTS.items():
            config = load_run(path, overrides)
            columns = []
            for role in ("izb_build", "izb_raster"):
                spec = phase_machine(config.machine, role).spec
                counters = play("compiled", spec, replay(work, role, spec))
                slots = counters.cycles * spec.core.num_cores
                miss = counters.cache_fetch_ticks[-1] / counters.cache_fetches[-1] / spec.core.period_ticks
                columns += [f"{100 * counters.useful.sum() / slots:.2f}", f"{miss:.1f}"]
            print(f"| {row} | {name} | " + " | ".join(columns) + " |", flush=True)


if __name__ == "__main__":
    main()
