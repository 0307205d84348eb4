"""What the pages share: the templates and pictures as data URIs."""

from __future__ import annotations

import base64
from typing import Any

import jinja2
import numpy as np

from archsim.report.formats import number, percent, setting, words
from archsim.run.folder import png, shadow_colours

SHARP_COLUMNS = 1024  # of a picture, from which a browser need not blur its pixels


def render(template: str, **values: Any) -> str:
    """A page from its template. A name that the template uses and `values` lacks is an error."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("archsim.report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(number=number, percent=percent, setting=setting, words=words)
    return environment.get_template(template).render(**values)


def shadow_uri(shadow: np.ndarray) -> str:
    """The mask as a PNG inside the page."""
    return png_uri(shadow_colours(shadow))


def png_uri(colours: np.ndarray) -> str:
    """An image uint8 [height, width, 3] as a PNG inside the page; a small one with larger pixels, to keep it sharp."""
    times = max(1, SHARP_COLUMNS // max(colours.shape[1], 1))
    larger = colours.repeat(times, axis=0).repeat(times, axis=1)
    return "data:image/png;base64," + base64.b64encode(png(larger)).decode()


def shadow_caption(shadow: np.ndarray) -> str:
    """Size and share, e.g. `640 x 512 pixels, 31.4 % in shadow.`"""
    height, width = shadow.shape
    return f"{width} x {height} pixels, {100 * shadow.mean():.1f} % in shadow."
