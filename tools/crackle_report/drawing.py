# SPDX-License-Identifier: GPL-3.0-or-later
"""What several pictures draw: the plate, a window on its cracked part, cracks."""
from __future__ import annotations

from typing import Any, Iterable, Optional, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon
from matplotlib.path import Path
from matplotlib.ticker import EngFormatter, MaxNLocator
from crackle.units import MM, US, Unit

from . import style
from .mesh import Regions
from .plate import Plate
from .fields import BranchingPoints, CrackSurface, Tool

# At most so much [m], or in small bodies so much of the width.
MARGIN = (3e-3, 0.12)  # round notches and cracks
SURROUNDINGS = (4e-3, 0.16)  # of the notches alone
BEYOND_ENDS = (1e-3, 0.04)
N_SHADES = 200


def window(plate: Plate, z_values: Iterable[np.ndarray]) -> tuple[float, float]:
    """The range of z that shows all notches and all given z [m], in the plate's unit of lengths."""
    ends = plate.slot_ends
    for values in z_values:
        values = values[np.isfinite(values)]
        if values.size:
            ends += [float(values.min()), float(values.max())]
    bottom, top = plate.ends(2)
    if not ends:
        ends = [bottom, top]
    return _within(plate, min(ends), max(ends), MARGIN)


def _within(plate: Plate, low: float, high: float, margin: tuple[float, float]) -> tuple[float, float]:
    """From low to high [m] with a margin, within the body and a little beyond its ends, in the plate's unit of lengths."""
    around = min(margin[0], margin[1] * plate.size[1])
    lowest, highest = whole_length(plate)
    return max(plate.lengths.of(low - around), lowest), min(plate.lengths.of(high + around), highest)


def outline_path(polygons: Sequence[np.ndarray]) -> Path:
    """The outer polygon and those of the holes as one path; first corners are not repeated."""
    return Path.make_compound_path(*(Path(np.vstack([polygon, polygon[:1]]), closed=True) for polygon in polygons))


def draw_plate(axes: Axes, plate: Plate, z_range: tuple[float, float], faint: bool = False, regions: Optional[Regions] = None) -> None:
    """The body with its slots and its parts of other materials, at true proportions; axes in the plate's unit of lengths."""
    left, right = (plate.lengths.of(end) for end in plate.ends(1))
    path = outline_path([plate.lengths.of(polygon) for polygon in plate.polygons])
    axes.add_patch(PathPatch(path, zorder=0, facecolor="none" if faint else style.BODY,
                             edgecolor=style.MUTED if faint else style.OUTLINE,
                             linewidth=0.6, linestyle="--" if faint else "-"))
    axes.add_collection(LineCollection([plate.lengths.of(border) for border in plate.pre_cracks], colors=style.OUTLINE,
                                       linewidths=1.2, zorder=0.5), autolim=False)
    if regions is not None:
        draw_regions(axes, regions, plate.lengths)
    axes.set_xlim(left - 0.04 * (right - left), right + 0.04 * (right - left))
    axes.set_ylim(*z_range)
    axes.set_aspect("equal")
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(length=2, pad=1.5)


def draw_regions(axes: Axes, regions: Regions, lengths: Unit = MM, above: float = 0) -> None:
    """Tints the parts of other materials, and draws where they meet.

    @param above what has a smaller zorder
    """
    axes.add_collection(PolyCollection([lengths.of(polygon) for polygon in regions.polygons], facecolors=style.OTHER_MATERIAL,
                                       edgecolors=style.OTHER_MATERIAL, linewidths=0.3, rasterized=True, zorder=above + 0.1), autolim=False)
    draw_borders(axes, regions, lengths, above)


def draw_borders(axes: Axes, regions: Regions, lengths: Unit = MM, above: float = 0) -> None:
    """Where materials meet, over what has a smaller zorder."""
    axes.add_collection(LineCollection(lengths.of(regions.borders), colors=style.MATERIAL_BORDER, linewidths=0.8, zorder=above + 0.2),
                        autolim=False)


def whole_length(plate: Plate) -> tuple[float, float]:
    """The range of z that shows the whole body, in the plate's unit of lengths."""
    bottom, top = plate.ends(2)
    beyond = min(BEYOND_ENDS[0], BEYOND_ENDS[1] * plate.size[1])
    return plate.lengths.of(bottom - beyond), plate.lengths.of(top + beyond)


def near_notches(plate: Plate) -> tuple[float, float]:
    """Their surroundings along z, in the plate's unit of lengths; the whole body where there are none."""
    ends = plate.slot_ends
    return _within(plate, min(ends), max(ends), SURROUNDINGS) if ends else whole_length(plate)


def panel_size(plate: Plate, z_range: tuple[float, float], room: float, most_height: float) -> tuple[float, float]:
    """Width and height of a picture of the body at true proportions, no wider than there is room for [inch]."""
    proportion = (z_range[1] - z_range[0]) / (1.08 * plate.lengths.of(plate.size[1]))
    width = min(room, most_height / proportion)
    return width, width * proportion


class Sheet(Figure):
    """Panels of one size in rows and columns, with room at the left, right, top and bottom and gaps between them [inch]."""

    def __init__(self, panel: tuple[float, float], n_rows: int, n_columns: int, room: tuple[float, float, float, float],
                 gaps: tuple[float, float], least_width: float = 0.0, **more: Any) -> None:
        self._panel, self._steps = panel, (panel[0] + gaps[0], panel[1] + gaps[1])
        self._left, right, self._top, bottom = room
        super().__init__(figsize=(max(self._left + right + n_columns * self._steps[0] - gaps[0], least_width),
                                  self._top + bottom + n_rows * self._steps[1] - gaps[1]), **more)

    def panel(self, row: int, column: int) -> Axes:
        (width, height), (panel_width, panel_height) = self.get_size_inches(), self._panel
        return self.add_axes(((self._left + column * self._steps[0]) / width,
                              1 - (self._top + panel_height + row * self._steps[1]) / height, panel_width / width, panel_height / height))


def time_colours(latest: float, times: Unit = US) -> Normalize:
    """Colours for times from onset to the latest one in motion [s]; for times in this unit."""
    return Normalize(0.0, times.of(latest) if latest > 0 else 1.0)


def facet_colours(time: np.ndarray, colours: Normalize) -> np.ndarray:
    """Red, green and blue of facets by their opening times, in the unit of the colours."""
    rgb = style.TIME_COLOURS(np.asarray(colours(time)))[:, :3]
    rgb[time < 0] = to_rgb(style.BEFORE_ONSET)
    rgb[time > colours.vmax] = to_rgb(style.AFTER_PHASE)
    return rgb


def time_bar(figure: Figure, colours: Normalize, left: float, length: float, times: Unit = US) -> None:
    """The key to the colours of times, at the top of a figure; place and length in inches."""
    width, height = figure.get_size_inches()
    bar = figure.add_axes((left / width, 1 - 0.2 / height, length / width, 0.1 / height))
    figure.colorbar(ScalarMappable(colours, style.TIME_COLOURS), cax=bar, orientation="horizontal")
    bar.set_xlabel(times.label("time since onset"), labelpad=1)


def draw_grid(axes: Axes) -> None:
    """Ticks and lines of a graph."""
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]))
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axes.grid(color=style.BODY, linewidth=0.6)
    axes.set_axisbelow(True)


def show_units(axis: Axis, units: str) -> None:
    """Few ticks, in units [SI] with a prefix; pure numbers as they are."""
    axis.set_major_locator(MaxNLocator(4))
    if units:
        axis.set_major_formatter(EngFormatter(units))


def draw_facets(axes: Axes, crack: CrackSurface, colours: Normalize, until: float = np.inf, lengths: Unit = MM, times: Unit = US) -> None:
    """The facets opened until a time [s], projected on the YZ plane and coloured by time, in these units.

    One path for each shade: many facets are drawn fast, and with little memory.
    """
    opened = crack.time <= until
    corner = lengths.of(crack.corner[opened, :, 1:].astype(float))
    # All turn the same way round, so that facets over each other do not cut holes into their path.
    diagonals = corner[:, 2:] - corner[:, :2]
    clockwise = diagonals[:, 0, 0] * diagonals[:, 1, 1] < diagonals[:, 0, 1] * diagonals[:, 1, 0]
    corner[clockwise] = corner[clockwise, ::-1]

    time = times.of(crack.time[opened])
    share = np.minimum(time / colours.vmax, 2.0)
    shade = np.clip((share * N_SHADES).astype(int), 0, N_SHADES - 1)
    shade[time < 0], shade[share > 1] = -1, N_SHADES
    paths, shades = [], []
    # Late facets first, so that the earliest ones, the path itself, stay on top.
    for value in np.unique(shade)[::-1]:
        vertices = corner[shade == value][:, [0, 1, 2, 3, 0]]
        codes = np.tile((Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY), len(vertices))
        paths.append(Path(vertices.reshape(-1, 2), codes))
        shades.append(facet_colours(np.array([(value + 0.5) / N_SHADES * colours.vmax]), colours)[0])
    axes.add_collection(PathCollection(paths, facecolors=shades, edgecolors=shades, linewidths=0.3,
                                       rasterized=True), autolim=False)


def draw_tools(axes: Axes, tools: Iterable[Tool], time: float, lengths: Unit = MM) -> None:
    """Where tools are at a time of the last dynamic phase [s], seen along the thickness."""
    for tool in tools:
        corners = tool.outline(time)
        if len(corners):
            axes.add_patch(Polygon(lengths.of(corners), fill=False, edgecolor=style.MUTED, linewidth=0.8, linestyle=(0, (3, 2)), zorder=6))


def draw_branching(axes: Axes, points: BranchingPoints, lengths: Unit = MM) -> None:
    """A ring round each branching point: whole where the projection shows it, dotted where only a window through the thickness does."""
    for kind in (True, False):
        draw_rings(axes, points.position[points.in_projection == kind], kind, lengths)


def draw_rings(axes: Axes, position: np.ndarray, in_projection: bool = True, lengths: Unit = MM) -> None:
    """A ring round each of these places (n x 2: y, z [m])."""
    for y, z in lengths.of(position):
        axes.scatter([y], [z], s=80, zorder=5, **_ring(in_projection))


def branching_handles(axes: Axes, several: Iterable[BranchingPoints]) -> list[Artist]:
    """For a legend, of the kinds of rings that draw_branching draws."""
    found = {bool(in_projection) for points in several for in_projection in points.in_projection}
    return [axes.scatter([], [], s=40, label="branching point" if kind else "branching point that the projection hides", **_ring(kind))
            for kind in (True, False) if kind in found]


def _ring(in_projection: bool) -> dict[str, Any]:
    return {"facecolors": "none", "edgecolors": style.BRANCHING, "linewidths": 1.0, "linestyles": "-" if in_projection else ":"}
