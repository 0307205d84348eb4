"""The scene section: what is drawn, from where, and where the lights are."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, PlainValidator, Tag, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from archsim.config.section import Finding, Name, Section, Vector, report

MESH_SUFFIXES = (".npz", ".ply", ".obj", ".stl", ".glb")
MIN_ANGLE_SINE = 1e-6  # between the view direction and up

Degrees = Annotated[float, Field(ge=1, le=170, json_schema_extra={"unit": "degrees"})]
Extent = Annotated[int, Field(ge=1, le=8192, json_schema_extra={"unit": "pixels"})]
Seed = Annotated[int, Field(ge=0, le=2**32 - 1)]


def _number(value: Any) -> int | float:
    """A finite number that stays the kind of number that was written."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError("float_type", "must be a number")
    if not abs(value) <= 1e12:
        raise PydanticCustomError("archsim", "{what}", {"what": "must be a number between -1e12 and 1e12"})
    return value


Number = Annotated[int | float, PlainValidator(_number), WithJsonSchema({"type": "number"})]


class GeneratorConfig(Section):
    """A mesh that is computed: the generator's name, its seed, and parameters other than its usual ones."""

    generator: Literal[
        "amphitheater",
        "knights",
        "knot_and_spheres",
        "power_plant",
        "quad_and_triangle",
        "robots",
        "simple_occluder",
        "town",
    ]  # which generator
    seed: Seed = 0  # of all that it draws at random
    parameters: dict[str, Number] = Field(default_factory=dict)  # in place of its usual ones, by name


class CameraConfig(Section):
    """A perspective camera; lengths in world units, `fovy_degrees` is the full vertical angle."""

    eye: Vector  # where the camera is
    target: Vector  # the point in the middle of the picture
    up: Vector  # which way is up in the picture
    fovy_degrees: Degrees  # full vertical angle
    # what is nearer than this along the line of sight is not seen
    near: Annotated[float, Field(gt=0, le=1e9)]

    @model_validator(mode="after")
    def _check(self) -> CameraConfig:
        report(_check_axes(self.eye, self.target, self.up, "eye"))
        return self


class ViewConfig(Section):
    """A fixed square frustum of a light, whose eye is the light's position."""

    target: Vector  # the point in the middle of the view
    up: Vector  # which way is up in the view
    fovy_degrees: Degrees  # full angle


class LightConfig(Section):
    """A point light. Without a `view` its frustum is fitted tightly to the samples."""

    position: Vector  # where the light is
    view: ViewConfig | None = None  # a fixed view; null: fitted tightly to the samples

    @model_validator(mode="after")
    def _check(self) -> LightConfig:
        if self.view is not None:
            found = _check_axes(self.position, self.view.target, self.view.up, "position")
            report([each._replace(path=("view", *each.path)) for each in found])
        return self


def _mesh_tag(mesh: Any) -> str:
    return "<GeneratorConfig>" if isinstance(mesh, dict | GeneratorConfig) else "<text>"


MeshConfig = Annotated[
    Annotated[str, Tag("<text>")] | Annotated[GeneratorConfig, Tag("<GeneratorConfig>")],
    Discriminator(_mesh_tag),
]


class SceneConfig(Section):
    """A mesh (packaged name, path or generator), a camera, lights, the image's [width, height] in pixels."""

    name: Name  # what the scene is called
    mesh: MeshConfig  # a packaged mesh by name, the path of a file, or a generator
    camera: CameraConfig  # where the picture is taken from
    # point lights; a workload uses one of them
    lights: Annotated[tuple[LightConfig, ...], Field(strict=False, min_length=1, max_length=1000)]
    resolution: Annotated[tuple[Extent, Extent], Field(strict=False)]  # width and height of the picture


def _check_axes(eye: Vector, target: Vector, up: Vector, eye_name: str) -> list[Finding]:
    """What keeps an eye, a target and an up direction from spanning a view."""
    forward = _unit(tuple(b - a for a, b in zip(eye, target, strict=True)))
    upward = _unit(up)
    if forward is None:
        return [Finding(("target",), f"must not be the same point as {eye_name}")]
    if upward is None:
        return [Finding(("up",), "must not be zero")]

    cosine = sum(a * b for a, b in zip(forward, upward, strict=True))
    if 1 - cosine * cosine < MIN_ANGLE_SINE**2:
        return [Finding(("up",), "must not be parallel to the view direction")]
    return []


def _unit(vector: tuple[float, ...]) -> tuple[float, ...] | None:
    length = math.hypot(*vector)
    return tuple(component / length for component in vector) if length > 0 else None
