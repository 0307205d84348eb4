"""A run: one workload on one scene, played on one machine."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from archsim.config.machine import MachineConfig
from archsim.config.scene import SceneConfig
from archsim.config.section import Finding, Name, Section, report
from archsim.config.workload import WorkloadConfig


class RunConfig(Section):
    """Everything that a run depends on."""

    name: Name  # what the run is called; names its folder
    scene: SceneConfig  # what is drawn
    workload: WorkloadConfig  # what is computed
    machine: MachineConfig  # what it is computed on
    # reference: SimPy, to be believed; compiled: the same, fast
    model: Literal["reference", "compiled"] = "compiled"
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0  # of whatever is drawn at random; so far nothing is

    @model_validator(mode="after")
    def _check(self) -> RunConfig:
        num_lights = len(self.scene.lights)
        if self.workload.light >= num_lights:
            lights = "one light" if num_lights == 1 else f"{num_lights} lights"
            what = f"must be below {num_lights}, not {self.workload.light}: the scene has {lights}"
            report([Finding(("workload", "light"), what)])
        return self
