"""Who set the values of a sweep's points: the sweep where it sets them, else the run that they start from."""

from __future__ import annotations

import re
from collections.abc import Sequence

from archsim.config import LoadedSweep
from archsim.config.explain import Origin
from archsim.errors import Location
from archsim.sweep.expand import Parameters, flow

_IN_BLOCKS = r"parameters\.\d+\.(?:grid|zip|list\.\d+|random\.values)\.(.+)"
_FOR_ALL = r"set\.(.+)"  # what blocks set goes before it
_MOST_VALUES = 8  # of a parameter that are written out


def parameter_origins(sweep: LoadedSweep, points: Sequence[Parameters]) -> list[Origin]:
    """What the sweep sets: key, the values that points have, the first place in its file that sets it."""
    places = _places(sweep)
    keys = dict.fromkeys(key for point in points for key in point)
    return [Origin(key, _values(key, points), str(places[key])) for key in keys]


def _places(sweep: LoadedSweep) -> dict[str, Location]:
    places: dict[str, Location] = {}
    for pattern in (_IN_BLOCKS, _FOR_ALL):
        for path, place in sweep.origins.items():
            if found := re.fullmatch(pattern, path):
                places.setdefault(found[1], place)
    return places | ({"seed": sweep.origins["seeds"]} if "seeds" in sweep.origins else {})


def _values(key: str, points: Sequence[Parameters]) -> str:
    """The values of a parameter; of many the first and the last."""
    values = list(dict.fromkeys(flow(point[key]) for point in points if key in point))
    if len(values) <= _MOST_VALUES:
        return ", ".join(values)
    return f"{values[0]}, {values[1]} ... {values[-1]} ({len(values)} values)"
