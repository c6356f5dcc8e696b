# SPDX-License-Identifier: GPL-3.0-or-later
"""What several pictures draw: the plate, a window on its cracked part, cracks."""
from __future__ import annotations

from typing import Any, Iterable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PathCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from . import style
from .plate import Plate
from .results import CrackSurface, Forks

MARGIN = 3.0  # round notches and cracks [mm]
SURROUNDINGS = 4.0  # of the notches alone [mm]
N_SHADES = 200


def window(plate: Plate, z_values: Iterable[np.ndarray]) -> tuple[float, float]:
    """The range of z that shows all notches and all given z [m], in mm."""
    ends = plate.slot_ends
    for values in z_values:
        values = values[np.isfinite(values)]
        if values.size:
            ends += [float(values.min()), float(values.max())]
    bottom, top = plate.ends(2)
    if not ends:
        ends = [bottom, top]
    low, high = min(ends) / style.MILLIMETRE - MARGIN, max(ends) / style.MILLIMETRE + MARGIN
    lowest, highest = whole_length(plate)
    return max(low, lowest), min(high, highest)


def draw_plate(axes: Axes, plate: Plate, z_range: tuple[float, float], faint: bool = False) -> None:
    """The body with its slots, at true proportions; axes in mm."""
    left, right = (end / style.MILLIMETRE for end in plate.ends(1))
    closed = [np.vstack([polygon, polygon[:1]]) / style.MILLIMETRE for polygon in plate.polygons]
    path = Path.make_compound_path(*(Path(polygon, closed=True) for polygon in closed))
    axes.add_patch(PathPatch(path, zorder=0, facecolor="none" if faint else style.BODY,
                             edgecolor=style.MUTED if faint else style.OUTLINE,
                             linewidth=0.6, linestyle="--" if faint else "-"))
    axes.set_xlim(left - 0.04 * (right - left), right + 0.04 * (right - left))
    axes.set_ylim(*z_range)
    axes.set_aspect("equal")
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(length=2, pad=1.5)


def whole_length(plate: Plate) -> tuple[float, float]:
    """The range of z that shows the whole body [mm]."""
    bottom, top = (end / style.MILLIMETRE for end in plate.ends(2))
    return bottom - 1.0, top + 1.0


def near_notches(plate: Plate) -> tuple[float, float]:
    """Their surroundings along z [mm]; the whole body where there are none."""
    ends = [z / style.MILLIMETRE for z in plate.slot_ends]
    bottom, top = whole_length(plate)
    if not ends:
        return bottom, top
    return max(min(ends) - SURROUNDINGS, bottom), min(max(ends) + SURROUNDINGS, top)


def time_colours(latest: float) -> Normalize:
    """Colours for times from onset to the latest one [s]; for times in us."""
    return Normalize(0.0, latest / style.MICROSECOND if latest > 0 else 1.0)


def time_bar(figure: Figure, colours: Normalize, left: float, length: float) -> None:
    """The key to the colours of times, at the top of a figure; place and length in inches."""
    width, height = figure.get_size_inches()
    bar = figure.add_axes((left / width, 1 - 0.2 / height, length / width, 0.1 / height))
    figure.colorbar(ScalarMappable(colours, style.TIME_COLOURS), cax=bar, orientation="horizontal")
    bar.set_xlabel("time since onset [µs]", labelpad=1)


def draw_grid(axes: Axes) -> None:
    """Ticks and lines of a graph."""
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]))
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.grid(color=style.BODY, linewidth=0.6)
    axes.set_axisbelow(True)


def draw_facets(axes: Axes, crack: CrackSurface, colours: Normalize, until: float = np.inf) -> None:
    """The facets opened until a time [s], projected on the YZ plane and coloured by time [us].

    One path for each shade: many facets are drawn fast, and with little memory.
    """
    opened = crack.time <= until
    corner = crack.corner[opened, :, 1:].astype(float) / style.MILLIMETRE
    # All turn the same way round, so that facets over each other do not cut holes into their path.
    diagonals = corner[:, 2:] - corner[:, :2]
    clockwise = diagonals[:, 0, 0] * diagonals[:, 1, 1] < diagonals[:, 0, 1] * diagonals[:, 1, 0]
    corner[clockwise] = corner[clockwise, ::-1]

    time = crack.time[opened] / style.MICROSECOND
    shade = np.where(time < 0, -1, np.clip((colours(time) * N_SHADES).astype(int), 0, N_SHADES - 1))
    paths, shades = [], []
    # Late facets first, so that the earliest ones, the path itself, stay on top.
    for value in np.unique(shade)[::-1]:
        vertices = corner[shade == value][:, [0, 1, 2, 3, 0]]
        codes = np.tile((Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY), len(vertices))
        paths.append(Path(vertices.reshape(-1, 2), codes))
        shades.append(style.BEFORE_ONSET if value < 0 else style.TIME_COLOURS((value + 0.5) / N_SHADES))
    axes.add_collection(PathCollection(paths, facecolors=shades, edgecolors=shades, linewidths=0.3,
                                       rasterized=True), autolim=False)


def draw_forks(axes: Axes, forks: Forks) -> None:
    """A ring round each fork: whole where the projection shows it, dotted where only a window through the thickness does."""
    for kind in (True, False):
        draw_fork_rings(axes, forks.position[forks.in_projection == kind], kind)


def draw_fork_rings(axes: Axes, position: np.ndarray, in_projection: bool = True) -> None:
    """A ring round each of these places (n x 2: y, z [m])."""
    for y, z in position / style.MILLIMETRE:
        axes.scatter([y], [z], s=80, zorder=5, **_ring(in_projection))


def fork_handles(axes: Axes, several: Iterable[Forks]) -> list[Artist]:
    """For a legend, of the kinds of rings that draw_forks draws."""
    found = {bool(in_projection) for forks in several for in_projection in forks.in_projection}
    return [axes.scatter([], [], s=40, label="fork" if kind else "fork that the projection hides", **_ring(kind))
            for kind in (True, False) if kind in found]


def _ring(in_projection: bool) -> dict[str, Any]:
    return {"facecolors": "none", "edgecolors": style.FORK, "linewidths": 1.0, "linestyles": "-" if in_projection else ":"}
