"""What recording a timeline costs: the reference model with and without a recorder, on the tiny machine.

Run: python experiments/benchmarks/timeline.py      (seconds)
"""

from __future__ import annotations

import time

from archsim.config import load_run
from archsim.machine import reference
from archsim.machine.build import phase_machine
from archsim.machine.timeline import Recorder
from archsim.run.izb_work import record, replay

REPETITIONS = 3


def main() -> None:
    config = load_run("runs/tiny.yaml", ["scene.resolution=[32, 24]"])
    (view,) = record(config)
    for phase in ("izb_build", "izb_raster"):
        spec = phase_machine(config.machine, phase).spec
        seconds = {False: [], True: []}
        for _ in range(REPETITIONS):
            for recorded, times in seconds.items():
                observe = Recorder(spec).attach if recorded else None
                started = time.process_time()
                reference.simulate(spec, replay(view, phase, spec), observe=observe)
                times.append(time.process_time() - started)
        plain, recording = min(seconds[False]), min(seconds[True])
        print(f"{phase}: {plain:.2f} s, recorded {recording:.2f} s: {recording / plain:.2f} times as long")


if __name__ == "__main__":
    main()
