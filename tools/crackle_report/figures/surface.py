# SPDX-License-Identifier: GPL-3.0-or-later
"""The crack surface in space, coloured by the time at which it opened."""
from __future__ import annotations

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from crackle.units import Unit
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from .. import style
from ..choosing import samples_in_detail
from ..drawing import facet_colours, time_bar, time_colours
from ..options import Options
from ..plate import Plate
from ..fields import CrackSurface
from ..results import Ensemble
from .picture import Picture, Section, View

AT_THICKNESS = np.array([1e-6, 0.5, 1 - 1e-6])  # where the borders of materials are drawn


def section(ensemble: Ensemble, options: Options) -> Section | None:
    result = Section(
        "Crack surfaces in space",
        "The opened facets of the samples shown in detail, coloured by the time at which they opened; grey ones were open "
        "before the last dynamic phase. Drag to rotate and scroll or pinch to zoom; the slider moves through time."
        + " Inner lines show where materials meet." * (ensemble.regions is not None))
    for number in options.samples or samples_in_detail(ensemble):
        crack = ensemble.files.crack(number)
        if crack is not None and crack.time.size:
            result.views.append(_view(ensemble, number, crack))
    return result if result.views else None


def _view(ensemble: Ensemble, number: int, crack: CrackSurface) -> View:
    lengths, times = ensemble.plate.lengths, ensemble.times
    order = np.argsort(crack.time, kind="stable")
    corner, time = lengths.of(crack.corner[order]), times.of(crack.time[order])
    colours = time_colours(crack.last_opening, times)
    rgb = facet_colours(time, colours)
    lines = np.concatenate([_edges(ensemble.plate), *_borders(ensemble, number)])
    return View(Picture(f"surface-{number:04d}", f"Crack surface of sample {number} in space", _still(number, corner, rgb, lines, colours, times, ensemble.plate.is_solid)),
                corner.astype("<f4").tobytes(), np.clip(time, 0, times.of(crack.last_opening)).astype("<f4").tobytes(),
                np.round(255 * rgb).astype(np.uint8).tobytes(), lines.astype("<f4").tobytes(), times.name)


def _edges(plate: Plate) -> np.ndarray:
    """Of the body: those of a solid; of a plate its outlines at both ends of the thickness, and the lines between their corners; n x 2 x 3, in
    its unit of lengths."""
    if plate.is_solid:
        return plate.lengths.of(plate.edge)
    lines = []
    for polygon in plate.polygons:
        after = np.roll(polygon, -1, axis=0)
        for x in (0.0, plate.size[0]):
            lines += [((x, *a), (x, *b)) for a, b in zip(polygon, after)]
        # Chords of a curve have no edge of their own.
        before = np.roll(polygon, 1, axis=0)
        turn = np.abs(np.cross(polygon - before, after - polygon)) / (
            np.linalg.norm(polygon - before, axis=1) * np.linalg.norm(after - polygon, axis=1))
        lines += [((0.0, *p), (plate.size[0], *p)) for p, sharp in zip(polygon, turn > 0.5) if sharp]
    return plate.lengths.of(np.array(lines))


def _borders(ensemble: Ensemble, number: int) -> list[np.ndarray]:
    """Where materials meet on both faces and at mid-thickness, in the form of the edges."""
    if ensemble.plate.is_solid or ensemble.files.regions(number) is None:
        return []
    mesh, places = ensemble.files.mesh(number), ensemble.plate.size[0] * AT_THICKNESS
    return [ensemble.plate.lengths.of(np.insert(mesh.regions(x).borders, 0, x, axis=2)) for x in places]


def _still(number: int, corner: np.ndarray, rgb: np.ndarray, lines: np.ndarray, colours: Normalize,
           times: Unit, is_whole: bool) -> Figure:
    figure = Figure(figsize=(style.PAGE_WIDTH * 0.72, 4.4))
    axes = figure.add_axes((0.0, 0.0, 1.0, 0.92), projection="3d")
    # y to the right, x towards who looks, z up.
    turned = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    axes.add_collection3d(Poly3DCollection(corner @ turned, facecolors=rgb, linewidths=0))
    low, high = (lines[..., 2].min(), lines[..., 2].max()) if is_whole else _window(corner, np.ptp(lines[..., 1]))
    shown = ((lines[..., 2] > low) & (lines[..., 2] < high)).any(axis=1) | is_whole
    axes.add_collection3d(Line3DCollection(np.clip(lines[shown], [-np.inf, -np.inf, low], [np.inf, np.inf, high]) @ turned,
                                           colors=style.OUTLINE, linewidths=0.5))
    ends = lines.reshape(-1, 3)
    size = [np.ptp(ends[:, 1]), np.ptp(ends[:, 0]), high - low]
    axes.set(xlim=(ends[:, 1].min(), ends[:, 1].max()), ylim=(-ends[:, 0].max(), -ends[:, 0].min()), zlim=(low, high))
    axes.set_box_aspect(size, zoom=0.95 if is_whole else 1.1)
    axes.view_init(elev=22, azim=-62)
    axes.set_axis_off()
    time_bar(figure, colours, 0.3, 2.0, times)
    figure.text(0.4, 0.95, f"sample {number}", fontweight="bold", fontsize=9)
    return figure


def _window(corner: np.ndarray, width: float) -> tuple[float, float]:
    """The range of z round the crack in a body of this width."""
    low, high = np.percentile(corner[..., 2], (1, 99))
    margin = 0.3 * (high - low) + 0.08 * width
    return float(low - margin), float(high + margin)
