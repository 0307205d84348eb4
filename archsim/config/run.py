"""A run: one workload on one scene, played on one machine."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, model_validator

from archsim.config.machine import MachineConfig
from archsim.config.scene import SceneConfig
from archsim.config.section import Finding, Name, Section, report
from archsim.config.workload import (
    GridConfig,
    IzbConfig,
    ShadowMapsConfig,
    ShadowVolumesConfig,
    VolumeKernelsConfig,
    VolumesConfig,
    WorkloadConfig,
)
from archsim.units import Cycles


class StatisticsConfig(Section):
    """What a run tells besides the statistics of its phases."""

    # cycles of cores or units between two points of the series over time; null: no series
    interval_cycles: Annotated[Cycles, Field(ge=1, le=1_000_000_000)] | None = None


class RunConfig(Section):
    """Everything that a run depends on."""

    name: Name  # what the run is called; names its folder
    scene: SceneConfig | None = None  # what is drawn; null for workloads that are not of a scene
    workload: WorkloadConfig  # what is computed
    machine: MachineConfig  # what it is computed on
    # reference: SimPy, to be believed; compiled: the same, fast
    model: Literal["reference", "compiled"] = "compiled"
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0  # of whatever is drawn at random
    statistics: StatisticsConfig = StatisticsConfig()  # what is told besides totals

    @model_validator(mode="after")
    def _check(self) -> RunConfig:
        kind = self.workload.kind
        if self.scene is None and self.workload.needs_scene:
            report([Finding(("scene",), f"is missing: the workload '{kind}' needs one")])
        if self.scene is not None and not self.workload.needs_scene:
            report([Finding(("scene",), f"must be left out: the workload '{kind}' is not of a scene")])
        if self.scene is not None and isinstance(self.workload, IzbConfig | VolumesConfig | ShadowMapsConfig):
            found = self.workload.light_findings(len(self.scene.lights))
            report([each._replace(path=("workload", *each.path)) for each in found])
        if isinstance(self.workload, GridConfig) and self.machine.roles is None:
            what = f"missing key 'roles': the workload '{kind}' runs on cores, and this machine is a pipeline"
            report([Finding(("machine",), what)])
        if (
            isinstance(self.workload, ShadowVolumesConfig | ShadowMapsConfig)
            and self.machine.roles is not None
        ):
            what = f"the workload '{kind}' runs on a pipeline, and this machine has cores"
            report([Finding(("machine",), what)])
        if isinstance(self.workload, VolumeKernelsConfig):
            report(list(self._check_stages(self.workload.fixed_function)))
        if isinstance(self.workload, ShadowMapsConfig) and self.scene is not None:
            report(list(self.workload.far_findings(self.scene.camera.near)))
        return self

    def _check_stages(self, fixed_function: MachineConfig) -> Iterator[Finding]:
        """Machines that can't run the two stages, as programs or in fixed function."""
        if self.machine.roles is None or self.machine.roles.hsv_stages is None:
            what = "no cores have the role 'hsv_stages', which this workload needs"
            yield Finding(("machine",), what)
        if fixed_function.roles is not None:
            yield Finding(("workload", "fixed_function"), "must be a pipeline, and this machine has cores")
