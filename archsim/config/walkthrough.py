"""A walk through a scene with shadow volumes: what moves, how the volumes are drawn, with which resources."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from archsim.config.scene import Number, SceneConfig
from archsim.config.section import Count, Finding, Name, Section, Vector, is_power_of_two, report
from archsim.config.workload import VolumesConfig
from archsim.units import Bytes

Size = Annotated[Bytes, Field(ge=1, le=2**40)]
ENTRY_BYTES = 2  # what a 2 x 2 block of tiles keeps in a PSV buffer


class PsvCacheConfig(Section):
    """The on-chip cache in front of the PSV buffers."""

    size: Size  # of all lines together
    line: Size  # a power of two
    ways: Count  # lines of a set

    @model_validator(mode="after")
    def _check(self) -> PsvCacheConfig:
        if not is_power_of_two(self.line) or self.line < ENTRY_BYTES:
            what = f"must be a power of two of at least {ENTRY_BYTES} bytes, not {self.line}"
            report([Finding(("line",), what)])
        if self.size % (self.line * self.ways):
            report([Finding(("size",), f"must be a multiple of line x ways, {self.line * self.ways}")])
        return self


class PipelinedVolumesConfig(VolumesConfig):
    """Shadow volumes, and what the hierarchical algorithm has to draw them with."""

    psv_buffers: Annotated[int, Field(ge=1, le=64)]  # volumes between Stage 1 and Stage 2, and one more
    psv_cache: PsvCacheConfig  # in front of them
    delay_stream: Size  # the ring buffer between the stages


class KeyframeConfig(Section):
    """Where camera and light are at one moment; what is left out stays as in the scene."""

    eye: Vector | None = None  # where the camera is
    target: Vector | None = None  # what it looks at
    light: Vector | None = None  # where the light is that the volumes are of
    parameters: dict[str, Number] = Field(default_factory=dict)  # of the mesh's generator


class WalkthroughConfig(Section):
    """Frames along a path through keyframes, evenly spaced in time."""

    name: Name  # what the walkthrough is called; names its folder
    scene: SceneConfig  # what is walked through
    shadow_volumes: PipelinedVolumesConfig  # how they are drawn
    frames: Annotated[int, Field(ge=1, le=10_000)]  # from the first keyframe to the last
    keyframes: Annotated[tuple[KeyframeConfig, ...], Field(strict=False, min_length=1)]  # evenly spaced
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0  # of whatever is drawn at random; so far nothing is

    @model_validator(mode="after")
    def _check(self) -> WalkthroughConfig:
        report([*self._check_light(), *self._check_keyframes()])
        return self

    def _check_light(self) -> list[Finding]:
        found = self.shadow_volumes.light_findings(len(self.scene.lights))
        return [each._replace(path=("shadow_volumes", *each.path)) for each in found]

    def _check_keyframes(self) -> list[Finding]:
        """What moves has to be said in every keyframe."""
        found = []
        first = self.keyframes[0]
        for number, key in enumerate(self.keyframes):
            for field in ("eye", "target", "light"):
                if (getattr(key, field) is None) != (getattr(first, field) is None):
                    found.append(
                        Finding(("keyframes", number), f"either all keyframes have '{field}' or none")
                    )
            if set(key.parameters) != set(first.parameters):
                found.append(Finding(("keyframes", number), "all keyframes must have the same parameters"))
            if key.parameters and isinstance(self.scene.mesh, str):
                what = "only a generated mesh has parameters"
                found.append(Finding(("keyframes", number, "parameters"), what))
        return found
