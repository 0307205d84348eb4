"""Search walkthroughs whose brute-force column comes near table 1's: `python calibrate.py ROW [SECONDS [SEED]]`.

Only the triangle count and the brute-force column of `printed.yaml` are aimed at; what depth bounds and the
hierarchical algorithm make of a walkthrough is never looked at. A walkthrough is an arc of the eye around what it looks
at and, where the paper's light moves, an arc of the light (ARCS). The knights' goes nearly all the way round, the light
the other way, so that light and view meet at every angle. In the power plant someone walks straight ahead: plant.py has
the rules, which the walkthrough of table 1 is too old to keep. Eyes are where people's would be: among the knights as
high as theirs and at least three units from their middle, in the amphitheater within the outermost step, as high above
the step or floor below as of someone who sits or stands, and on the whole way an arm's length from columns and actors.
The amphitheater's light is where a lamp would be: above the stage, over the heads. The three units were chosen knowing
table 1's depth bounds, the arm's length knowing its hierarchical column; see README.md.

What SPACE names is drawn at random, FIRST times anywhere, then in ever smaller surroundings of the best so far; when
nothing better is found any more, or it is good enough, the search begins anew. What counts is the average over some of
the frames, drawn at less than full resolution, and of the power plant a quarter of the casters, and scaled by what the
row's present walkthrough moves as it is. Walkthroughs with less than LEAST_SHADOW of what shows in shadow, or more than
MOST_SHADOW, do not count: the light must not be inside a caster. The power plant's never is, and all may be in shadow
there. Prints each better one as overrides.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import plant
import yaml

from archsim.config import WalkthroughConfig, load_walkthrough
from archsim.raster.eye_view import eye_view
from archsim.run.shadow_volumes import method_of
from archsim.run.walkthrough import resources_of, scene_at
from archsim.scene.generators import make_mesh
from archsim.scene.generators.amphitheater import COLUMN_RADIUS, Parameters, actor_places, column_feet
from archsim.scene.mesh import Mesh
from archsim.scene.scene import Scene, load_scene
from archsim.shadow_volumes.casters import Grouping, find_casters
from archsim.shadow_volumes.comparison import BRUTE_FORCE, draw, prepare
from archsim.shadow_volumes.volumes import num_drawn

HERE = Path(__file__).resolve().parent
MB = 2**20
LEAST_SHADOW, MOST_SHADOW = 0.05, 0.7
GOOD = 0.005  # misfit
FIRST = 20  # walkthroughs drawn anywhere, before the best of them is gone on from
PATIENCE = 50  # walkthroughs without a better one, then
HOPELESS = 6  # times the least misfit: a walkthrough whose first frames are worse is not finished
FRAMES_OF_SCALE = 2
ARMS_LENGTH = 0.5  # of an eye from what stands in the amphitheater
STRIDES = 10  # from keyframe to keyframe, at which that is looked at


class Steps(NamedTuple):
    """Those of amphitheater.yaml: a half circle, y > 0, around its stage."""

    rows: int = 8
    depth: float = 1.2
    height: float = 0.7


class Arcs(NamedTuple):
    """What is the same in all walkthroughs of a row."""

    eye_sweep: float | None  # degrees; None: searched
    light_sweep: float  # degrees
    eye_middle: tuple[float, float] = (0.0, 0.0)  # of the eye's arc, which looks there
    light_middle: tuple[float, float] = (0.0, 0.0)
    parameters: tuple[tuple[str, float], ...] = ()  # of the mesh's generator: how much they grow on the way
    keyframes: int = 12
    steps: Steps | None = None  # what the eye is above


class Draft(NamedTuple):
    """How walkthroughs are drawn in the search."""

    frames: int = 5
    resolution: str = "[320,256]"
    every: int = 1  # caster that casts a shadow
    most_shadow: float = MOST_SHADOW

    @property
    def overrides(self) -> list[str]:
        return [f"frames={self.frames}", f"scene.resolution={self.resolution}"]


ARCS = {
    "simple": Arcs(None, 360.0, light_middle=(50.0, -80.0)),
    "knights": Arcs(330.0, -150.0, parameters=(("pose", 22.0),)),
    "amphitheater": Arcs(None, 0.0, parameters=(("pose", 22.0),), steps=Steps()),
}
DRAFTS = {
    "powerplant": Draft(frames=4, every=4, most_shadow=1.0),
    "amphitheater": Draft(frames=8, resolution="[640,512]"),
}
SPACE = {  # lowest and highest value of what is searched; angles in degrees, the light's distance along the ground
    "simple": {
        "eye_distance": (150.0, 450.0),
        "eye_sweep": (10.0, 120.0),
        "eye_height": (-60.0, 90.0),
        "target_height": (-40.0, 40.0),
        "light_distance": (5.0, 40.0),
    },
    "knights": {
        "eye_distance": (3.0, 16.0),  # 2 ... before depth bounds were compared
        "eye_height": (1.5, 2.0),
        "target_height": (-1.5, 2.5),
        "fovy": (35.0, 65.0),
        "light_distance": (4.0, 15.0),
        "light_height": (20.0, 80.0),
        "range": (60.0, 200.0),
        "mesh.radius": (4.0, 12.0),
        "mesh.ground_half_size": (15.0, 60.0),
    },
    "powerplant": plant.SPACE,
    "amphitheater": {
        "eye_share": (0.1, 0.95),  # of the way from the middle of the stage to the outermost step
        "eye_azimuth": (-180.0, 180.0),
        "eye_sweep": (60.0, 160.0),
        "eye_height": (1.2, 1.9),  # above what is below
        "target_height": (0.0, 6.0),
        "fovy": (35.0, 75.0),
        "light_share": (0.0, 1.0),  # of the stage's radius
        "light_azimuth": (-180.0, 180.0),
        "light_height": (2.5, 8.0),
        "mesh.stage_radius": (6.0, 20.0),
        "mesh.column_height": (3.0, 12.0),
    },
}


class Quantities(NamedTuple):
    """What is aimed at: averages of frames."""

    triangles: float
    stencil: float  # MB
    depth: float
    lighting: float


class Found(NamedTuple):
    """A walkthrough that is better than those before it."""

    start: int  # how many times the search has begun anew
    misfit: float  # sum of squared logarithms of ours over the printed
    quantities: Quantities
    overrides: list[str]


def main() -> None:
    row, *numbers = sys.argv[1:]
    seconds = float(numbers[0]) if numbers else 120.0
    for found in search(row, seconds, int(numbers[1]) if len(numbers) > 1 else 0):
        pairs = zip(found.quantities, printed_column(row), strict=True)
        print(f"{found.start} {found.misfit:.4f}", " ".join(f"{ours:.4g}/{paper:g}" for ours, paper in pairs))
        print("  ", " ".join(f"--set '{each}'" for each in found.overrides), flush=True)


def search(row: str, seconds: float, seed: int) -> Iterator[Found]:
    """Each walkthrough that is better than all since the search began anew."""
    space, draft, aim = SPACE[row], DRAFTS.get(row, Draft()), np.array(printed_column(row))
    low, high = np.array(list(space.values())).T
    scale, random = _scale(row, draft), np.random.default_rng(seed)
    start, least, best, stale, tried = 0, np.inf, None, 0, 0
    deadline = time.perf_counter() + seconds
    while time.perf_counter() < deadline:
        if least < GOOD or (tried > FIRST and stale > PATIENCE):
            start, least, best, stale, tried = start + 1, np.inf, None, 0, 0
        place = random.uniform(low, high)
        if best is not None and tried >= FIRST and random.uniform() < 0.9:
            step = random.normal(0, 0.2 * 0.95**stale + 0.01, len(low)) * (high - low)
            place = np.clip(best + step * (random.uniform(size=len(low)) < 0.5), low, high)
        overrides = _overrides(row, dict(zip(space, place, strict=True)))
        config = load_walkthrough(HERE / f"{row}.yaml", [*overrides, *draft.overrides])
        if not _keeps_rules(row, config):
            continue
        tried, stale = tried + 1, stale + 1
        drawn = []
        for frame in frames(config, draft.every):
            drawn.append(frame)
            quantities = Quantities(*(np.mean(drawn, axis=0)[:-1] * scale))
            misfit = float(np.square(np.log((np.array(quantities) + 1e-9) / aim)).sum())
            if misfit > HOPELESS * least:
                break
        shadow = np.mean(drawn, axis=0)[-1]
        if misfit < least and LEAST_SHADOW <= shadow <= draft.most_shadow and len(drawn) == config.frames:
            best, least, stale = place, misfit, 0
            yield Found(start, misfit, quantities, overrides)


def _overrides(row: str, values: Mapping[str, float]) -> list[str]:
    if row in ARCS:
        return overrides_of(values, ARCS[row])
    scene: Any = load_walkthrough(HERE / f"{row}.yaml").scene
    return plant.overrides_of(values, scene.mesh.parameters)


def _keeps_rules(row: str, config: WalkthroughConfig) -> bool:
    """Whether eyes are where people's would be, as far as that isn't drawn so."""
    if row == "powerplant":
        scene: Any = config.scene
        mesh = scene.mesh
        parameters = tuple(mesh.parameters.items())
        return plant.keeps_rules(config, _meshes(mesh.generator, mesh.seed, parameters, Grouping.PARTS, 1)[0])
    return not ARCS[row].steps or clearance(config) >= ARMS_LENGTH


def _scale(row: str, draft: Draft) -> np.ndarray:
    """Quantities of some frames of the row's present walkthrough over those of their drafts."""
    few = f"frames={FRAMES_OF_SCALE}"
    whole, _ = brute_force(load_walkthrough(HERE / f"{row}.yaml", [few]))
    drafted, _ = brute_force(load_walkthrough(HERE / f"{row}.yaml", [*draft.overrides, few]), draft.every)
    return np.array(whole) / np.array(drafted)


def printed_column(row: str) -> Quantities:
    text = yaml.safe_load((HERE / "printed.yaml").read_text(encoding="utf-8"))
    table = text["table1"]
    rows = ("stencil_shadow_MB", "z_shadow_MB", "stencil_lighting_MB")
    return Quantities(
        text["scenes"][row]["sv_triangles_per_frame"], *(table[name][row]["BF"] for name in rows)
    )


def overrides_of(values: Mapping[str, float], arcs: Arcs) -> list[str]:
    """The searched values as overrides of a walkthrough."""
    changed = {
        "scene.camera.target": f"[{arcs.eye_middle[0]}, {arcs.eye_middle[1]}, {values['target_height']:.2f}]",
        "keyframes": f"[{', '.join(keyframes(values, arcs))}]",
    }
    changed |= {
        f"scene.mesh.parameters.{key[5:]}": f"{values[key]:.3f}" for key in values if key[:5] == "mesh."
    }
    if "fovy" in values:
        changed["scene.camera.fovy_degrees"] = f"{values['fovy']:.2f}"
    if "range" in values:
        changed["shadow_volumes.range"] = f"{values['range']:.2f}"
    return [f"{key}={value}" for key, value in changed.items()]


def keyframes(values: Mapping[str, float], arcs: Arcs) -> list[str]:
    """One keyframe after the other, in YAML."""
    sweep = values["eye_sweep"] if arcs.eye_sweep is None else arcs.eye_sweep
    distance, light_distance = _distances(values, arcs.steps)
    lines = []
    for time_ in np.linspace(0.0, 1.0, arcs.keyframes):
        turn = values.get("eye_azimuth", -90.0) + (time_ - 0.5) * sweep
        below = step_below(distance - values["mesh.stage_radius"], turn, arcs.steps) if arcs.steps else 0.0
        eye = _polar(distance, turn, below + values["eye_height"], arcs.eye_middle)
        light = _polar(
            light_distance,
            values.get("light_azimuth", 0.0) + time_ * arcs.light_sweep,
            values.get("light_height", 50.0),
            arcs.light_middle,
        )
        parts = [f"eye: {eye}", f"light: {light}"]
        grown = ", ".join(f"{name}: {time_ * by:.2f}" for name, by in arcs.parameters)
        lines.append(f"{{{', '.join(parts)}{f', parameters: {{{grown}}}' if grown else ''}}}")
    return lines


def _distances(values: Mapping[str, float], steps: Steps | None) -> tuple[float, float]:
    """How far eye and light are from the middles of their arcs."""
    if steps is None:
        return values["eye_distance"], values["light_distance"]
    stage = values["mesh.stage_radius"]
    return values["eye_share"] * (stage + steps.rows * steps.depth), values["light_share"] * stage


def step_below(beyond: float, azimuth: float, steps: Steps) -> float:
    """How high the ground is, so far beyond the stage."""
    if beyond < 0 or np.sin(np.radians(azimuth)) < 0:
        return 0.0
    return (1 + int(beyond / steps.depth)) * steps.height


def clearance(config: WalkthroughConfig) -> float:
    """Least distance of the eye, all the way, from a column's surface and from the middle of where an actor stands."""
    scene: Any = config.scene
    parameters = Parameters(**scene.mesh.parameters)
    eyes = np.array([keyframe.eye for keyframe in config.keyframes])[:, :2]
    share = np.arange(STRIDES)[:, None, None] / STRIDES
    way = np.concatenate([((1 - share) * eyes[:-1] + share * eyes[1:]).reshape(-1, 2), eyes[-1:]])

    def distance(places: np.ndarray) -> float:
        return float(np.linalg.norm(way[:, None] - places[:, :2], axis=-1).min())

    from_columns = distance(column_feet(parameters)) - COLUMN_RADIUS * parameters.column_height
    return min(from_columns, distance(actor_places(parameters)))


def _polar(distance: float, azimuth: float, height: float, middle: tuple[float, float]) -> list[float]:
    x = middle[0] + distance * np.cos(np.radians(azimuth))
    y = middle[1] + distance * np.sin(np.radians(azimuth))
    return [round(float(number), 2) for number in (x, y, height)]


def brute_force(config: WalkthroughConfig, every: int = 1) -> tuple[Quantities, float]:
    """The printed quantities of an average frame, and the share of what shows that is in shadow."""
    *quantities, shadow = np.mean(list(frames(config, every)), axis=0).tolist()
    return Quantities(*quantities), shadow


def frames(config: WalkthroughConfig, every: int) -> Iterator[tuple[float, ...]]:
    """Quantities and shadow of each frame in which only every so many casters cast a shadow."""
    method = method_of(config.shadow_volumes, resources_of(config.shadow_volumes))
    for number in range(config.frames):
        section = scene_at(config, number / (config.frames - 1) if config.frames > 1 else 0.5)
        mesh, casting = _meshes(
            section.mesh.generator,
            section.mesh.seed,
            tuple(section.mesh.parameters.items()),
            method.extrusion.grouping,
            every,
        )
        scene = _scene(section)._replace(mesh=casting)
        seen = eye_view(mesh, scene.camera, scene.width, scene.height)
        view = prepare(scene, scene.lights[config.shadow_volumes.light].position, seen, method)
        drawn = draw(view, BRUTE_FORCE, method.resources)
        moved = (drawn.traffic.stencil_shadow, drawn.traffic.depth_shadow, drawn.traffic.stencil_lighting)
        triangles = float(num_drawn(view.seen.volumes))
        yield (
            triangles,
            *(each / MB for each in moved),
            float(drawn.shadow.sum() / max(int(view.shown.sum()), 1)),
        )


def _scene(section: Any) -> Scene:
    """The scene of a checked section, with any mesh."""
    empty = section.mesh.model_copy(update={"generator": "quad_and_triangle", "parameters": {}})
    return load_scene(section.model_copy(update={"mesh": empty}))


@lru_cache(maxsize=4)
def _meshes(
    generator: str, seed: int, parameters: tuple[tuple[str, float], ...], grouping: Grouping, every: int
) -> tuple[Mesh, Mesh]:
    """The mesh of a generator, which is the same in many frames, and every so many of its casters."""
    mesh = make_mesh(generator, seed, dict(parameters))
    casters = find_casters(mesh, grouping)
    casting = casters.caster % every == 0
    used, corners = np.unique(casters.triangles[casting], return_inverse=True)
    few = Mesh(
        casters.positions[used].astype(np.float32),
        corners.reshape(-1, 3).astype(np.int32),
        casters.caster[casting].astype(np.int32),
    )
    return mesh, few


if __name__ == "__main__":
    main()
