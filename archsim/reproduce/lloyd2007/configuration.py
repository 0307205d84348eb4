"""Who set the values of the machine and of the views that the experiment uses."""

from __future__ import annotations

from collections.abc import Iterator

from archsim import resources
from archsim.config import load_machine_with_origins
from archsim.config.explain import Origin, file_origins, origins
from archsim.reproduce.lloyd2007.designs import DESIGNS
from archsim.reproduce.lloyd2007.pipeline import CODECS
from archsim.reproduce.lloyd2007.views import ID


def configuration() -> dict[str, list[Origin]]:
    """Title -> values; tables 9, 10 and 13 are of the machine."""
    return {
        "the machine": origins(load_machine_with_origins(resources.config("machines", ID))),
        "what tables 9, 10 and 13 change of the machine": list(_changes()),
        "scenes, camera paths and lights": file_origins(resources.experiment(ID) / "views.yaml"),
    }


def _changes() -> Iterator[Origin]:
    for codec in CODECS:
        yield Origin("components.z_cache.codec", codec, f"tables 9 and 13, {codec}")
    for design, values in DESIGNS.items():
        for key, value in values.items():
            yield Origin(f"components.evaluator.{key}", str(value), f"table 10, {design}")
