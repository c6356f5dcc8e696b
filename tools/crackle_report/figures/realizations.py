# SPDX-License-Identifier: GPL-3.0-or-later
"""One realization's cut."""
from __future__ import annotations

from typing import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from crackle.units import MM, Unit, fitting

from .. import style
from ..drawing import draw_plate, near_notches, whole_length
from ..mesh import Mesh
from ..plate import MeshRegion, Plate
from .picture import Picture

# Without viridis's dark end, in which the edges vanish.
SPACING_COLOURS = ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0.35, 1.0, 256)))


def spacing(mesh: Mesh) -> Picture:
    """The tetrahedra cut at mid-thickness, coloured by the requested spacing: the whole plate, and the ligament."""
    plate, regions = mesh.plate, mesh.regions
    polygons, numbers = mesh.cut(0, plate.size[0] / 2)
    polygons = [plate.lengths.of(polygon) for polygon in polygons]
    spacings = fitting(mesh.spacing, MM, least=0.05, most=1e4)
    wanted = spacings.of(mesh.spacing[mesh.tetrahedra[numbers]].mean(axis=1))
    least, greatest = spacings.of(mesh.spacing.min()), spacings.of(mesh.spacing.max())
    norm = LogNorm(least, greatest if greatest > least else 1.1 * least)
    height = 9.0
    figure = Figure(figsize=(style.PAGE_WIDTH, height), layout="constrained")
    whole, near = figure.subplots(1, 2, width_ratios=(1, 3.2))
    for axes, z_range, width in ((whole, whole_length(plate), 0.08), (near, _ligament(plate, regions), 0.2)):
        draw_plate(axes, plate, z_range)
        shown = [i for i, polygon in enumerate(polygons)
                 if polygon[:, 1].max() >= z_range[0] and polygon[:, 1].min() <= z_range[1]]
        collection = PolyCollection([polygons[i] for i in shown], array=wanted[shown], cmap=SPACING_COLOURS, norm=norm,
                                    edgecolors=style.OUTLINE, linewidths=width, rasterized=True)
        axes.add_collection(collection, autolim=False)
        axes.set_xlabel(plate.lengths.label("y"))
        for number, region in enumerate(regions):
            (y, y_end), (z, z_end) = (plate.lengths.of(np.array(extent)) for extent in region.box[1:])
            axes.add_patch(Rectangle((y, z), y_end - y, z_end - z, fill=False, edgecolor=style.NOTCH_COLOURS[1],
                                     linewidth=1.2, zorder=3))
            if axes is near:
                _label_region(axes, number, spacings, region, int(np.count_nonzero(mesh.region == number)), (y, y_end), (z, z_end))
    whole.set_ylabel(plate.lengths.label("z"))
    whole.set_title("whole plate")
    near.set_title(f"ligament; {_grouped(len(mesh.nodes))} points, {_grouped(len(mesh.tetrahedra))} tetrahedra in all")
    bar = figure.colorbar(collection, ax=[whole, near], shrink=0.5, label=spacings.label("requested spacing"))
    ticks = sorted({float(f"{value:.2g}") for value in np.geomspace(norm.vmin, norm.vmax, 5)})
    bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks], minor=False)
    bar.minorticks_off()
    return Picture("mesh", "Tetrahedra of one realization, cut at mid-thickness", figure)


def _grouped(number: int) -> str:
    return f"{number:,}".replace(",", "\u2009")


def _ligament(plate: Plate, regions: Sequence[MeshRegion]) -> tuple[float, float]:
    """The surroundings of the notches with the regions there, as far as a plate's width from the middle."""
    low, high = near_notches(plate)
    middle, width = (low + high) / 2, plate.lengths.of(plate.size[1])
    for region in regions:
        start, end = (plate.lengths.of(z) for z in region.box[2])
        if start < high and end > low:
            low, high = min(low, start - 0.04 * width), max(high, end + 0.04 * width)
    return max(low, middle - width), min(high, middle + width)


def _label_region(axes: Axes, number: int, spacings: Unit, region: MeshRegion, n_points: int, y: tuple[float, float],
                  z: tuple[float, float]) -> None:
    """Names a region in its upper left corner, or where that comes into view."""
    text = f"region {number}: {spacings.of(region.spacing):.3g} {spacings.name}, {_grouped(n_points)} points"
    low, high = axes.get_ylim()
    axes.text(y[0] + 0.01 * (axes.get_xlim()[1] - axes.get_xlim()[0]), np.clip(z[1], low, high) - 0.01 * (high - low), text,
              ha="left", va="top", fontsize=8, zorder=4, clip_on=True,
              bbox={"facecolor": "w", "alpha": 0.85, "edgecolor": style.NOTCH_COLOURS[1], "linewidth": 0.6,
                    "boxstyle": "round,pad=0.2"})
