"""Figures 6 and 7 as elements of the report."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Drawing
from matplotlib.image import imsave

from archsim.report import figures
from archsim.reproduce.lloyd2007.aliasing import Fitted, error_image, grid_image
from archsim.reproduce.lloyd2007.compression import MAPS, RESOLUTIONS
from archsim.reproduce.reproduction import Picture as Figure
from archsim.shadowmap.picture import Picture

PLOTTED = {
    "lloyd": (figures.VERMILLION, "o"),
    "anchor": (figures.BLUE, "s"),
    "ddpcm": (figures.SKY, "^"),
    "ddpcm 2": (figures.YELLOW, "^"),
    "plane": (figures.GREEN, "D"),
    "hasselgren": (figures.ORANGE, "v"),
    "hasselgren 2": (figures.PURPLE, "v"),
    "depth offset": (figures.GREY, "x"),
}  # colour and marker of each codec; some lines lie on each other


def all_pictures(
    measured: Mapping[str, Any], picture: Picture, families: Mapping[str, Fitted]
) -> tuple[Figure, ...]:
    """Figure 6, then figure 7."""
    return (compression_figure(measured), error_figure(picture, families))


@figures.STYLED
def compression_figure(measured: Mapping[str, Any]) -> Figure:
    """Average compression over the scenes, for linear and logarithmic rasterization."""
    drawing = Drawing(figsize=(11.4, 4.0), layout="constrained")
    panels = drawing.subplots(1, len(MAPS), sharey=True)
    for axes, rasterization in zip(panels, MAPS, strict=True):
        for codec, (colour, marker) in PLOTTED.items():
            each = [
                [buffers[rasterization, size].ratio(codec) for size in RESOLUTIONS]
                for buffers in measured.values()
            ]
            means = np.mean(each, axis=0)
            axes.plot(RESOLUTIONS, means, marker=marker, markersize=5, color=colour, label=codec)
        axes.set_xscale("log", base=2)
        axes.set_xticks(RESOLUTIONS, [str(size) for size in RESOLUTIONS])
        axes.set(title=f"{rasterization} rasterization", xlabel="rows and columns of the map")
    panels[0].set_ylabel("compression [: 1]")
    drawing.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=8, frameon=False)
    caption = "Figure 6: compression of touched tiles, averaged over the three scenes."
    return Figure(caption, figures.as_svg(drawing, "compression"))


def error_figure(picture: Picture, families: Mapping[str, Fitted]) -> Figure:
    """Grid lines above, errors below, a column for each family."""
    columns = []
    for family, fitted in families.items():
        images = [_image(grid_image(picture, fitted.errors)), _image(error_image(picture, fitted.errors))]
        columns.append(f"<div><b>{family}</b><br>{'<br>'.join(images)}</div>")
    caption = (
        "Figure 7: above, a line for every 5th texel; below, m: green 1, yellow 3, red 10 pixels and more, black where "
        "maps meet. All families have 512 x 512 texels."
    )
    return Figure(caption, f'<div class="side">{"".join(columns)}</div>')


def _image(pixels: np.ndarray) -> str:
    stream = io.BytesIO()
    imsave(stream, pixels, format="png", metadata={"Software": ""})
    data = base64.b64encode(stream.getvalue()).decode()
    return f'<img width="280" alt="" src="data:image/png;base64,{data}">'
