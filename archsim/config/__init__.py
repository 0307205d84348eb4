"""Configurations: YAML that people write -> frozen, checked sections."""

from archsim.config.load import (
    Loaded,
    LoadedRun,
    LoadedSweep,
    LoadedWalkthrough,
    load_any,
    load_machine,
    load_machine_with_origins,
    load_run,
    load_run_with_origins,
    load_scene,
    load_sweep,
    load_sweep_with_origins,
    load_walkthrough,
    load_walkthrough_with_origins,
    load_workload,
    resolved_yaml,
    run_path,
    sweep_of,
)
from archsim.config.machine import MachineConfig
from archsim.config.run import RunConfig
from archsim.config.scene import SceneConfig
from archsim.config.sweep import SweepConfig
from archsim.config.walkthrough import WalkthroughConfig
from archsim.config.workload import (
    DrawnIzbConfig,
    GridConfig,
    IzbConfig,
    ShadowMapsConfig,
    ShadowVolumesConfig,
    VolumeKernelsConfig,
    VolumesConfig,
    WorkloadConfig,
)

__all__ = [
    "DrawnIzbConfig",
    "GridConfig",
    "IzbConfig",
    "Loaded",
    "LoadedRun",
    "LoadedSweep",
    "LoadedWalkthrough",
    "MachineConfig",
    "RunConfig",
    "SceneConfig",
    "ShadowMapsConfig",
    "ShadowVolumesConfig",
    "SweepConfig",
    "VolumeKernelsConfig",
    "VolumesConfig",
    "WalkthroughConfig",
    "WorkloadConfig",
    "load_any",
    "load_machine",
    "load_machine_with_origins",
    "load_run",
    "load_run_with_origins",
    "load_scene",
    "load_sweep",
    "load_sweep_with_origins",
    "load_walkthrough",
    "load_walkthrough_with_origins",
    "load_workload",
    "resolved_yaml",
    "run_path",
    "sweep_of",
]
