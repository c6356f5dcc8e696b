# SPDX-License-Identifier: GPL-3.0-or-later
"""Experiments beside the ensemble: photographs over fringes as in the paper's Figures 5 and 6, paths in their band, photographs
under cracks. The numbers are those of `crackle match`."""
from __future__ import annotations

from typing import Any, Optional, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from crackle.units import Unit

from .. import style, tables
from ..drawing import Sheet, draw_facets, draw_grid, draw_plate, time_bar, time_colours
from ..options import Options
from ..photoelasticity import Grid
from ..photographs import Photograph, fringes_at, nearest_frames, photographs_of, window
from ..results import Ensemble
from . import loads, posterior
from .picture import Picture, Section

MOST = 8  # experiments that are drawn
PANEL_ROOM, MOST_HEIGHT = 2.2, 3.4  # [inch]
PIXELS = 360  # at most, along a side of a panel
BEYOND = 0.04  # of the body's width, around it
N_OVERLAID = 3
EXPERIMENT, BAND = style.BRANCHING, style.NOTCH_COLOURS[0]

EXPLANATION = ("p is the share of the samples and the experiment that lie at least as far from the others, by one quantity, or jointly by those "
               "of crackle match, among those that took its way; it is not the probability that the model is right. Times are since the crack "
               "began to run.")
OF_PICTURES = ("Pictures are compared by the correlation of their grey values, smoothed over a spacing of the mesh; noise and other optics "
               "set a photograph apart from all samples, so that its p is small, but hardly change which sample is nearest.")


def section(ensemble: Ensemble, options: Options) -> Optional[Section]:
    """Nothing without experiments."""
    found = options.match
    if found is None:
        return None
    shown = found["experiments"][:MOST]
    words = [EXPLANATION] + [OF_PICTURES] * any("pictures" in experiment["by"] for experiment in found["experiments"])
    words += [warning[0].upper() + warning[1:] + "." for warning in found["warnings"]]
    if len(shown) < len(found["experiments"]):
        words.append(f"The first {MOST} of {len(found['experiments'])} experiments are drawn.")
    if options.calibration is None:
        words.append(f"No posterior of random inputs: {options.no_calibration}.")
    result = Section("Experiments", " ".join(words), tables.advice(found), table=tables.experiments(found))
    for k, experiment in enumerate(shown):
        if experiment["path"]:
            result.pictures.append(Picture(f"experiment-{k}-path", f"Path of {experiment['name']} and of the samples",
                                           _path(ensemble, experiment)))
        photographs = photographs_of(experiment)
        for number in _nearest(experiment) if photographs else ():
            figure = _growth(ensemble, experiment, photographs, number, options)
            if figure is not None:
                result.pictures.append(Picture(
                    f"experiment-{k}-growth-{number:04d}", f"Photographs of {experiment['name']} over sample {number} at the same times",
                    figure))
        if photographs:
            result.pictures.append(Picture(
                f"experiment-{k}-overlay", f"Photograph of {experiment['name']} under cracks of the nearest samples",
                _overlay(ensemble, experiment, photographs[-1])))
    result.pictures += [*loads.pictures(found), *posterior.pictures(options.calibration, ensemble.inputs)]
    return result


def _nearest(experiment: dict[str, Any]) -> list[int]:
    """The samples nearest by pictures, and by all that crackle match compares: two, or one. Those count that are not turned."""
    turned = experiment["path"]["turned"] if experiment["path"] else []
    lists = [experiment["by"].get("pictures", {}).get("nearest", []),
             [one for one in experiment["nearest"] if one["sample"] not in turned]]
    return list(dict.fromkeys(nearest[0]["sample"] for nearest in lists if nearest))


class _Frame:
    """Panels that show the same part of the body."""

    def __init__(self, ensemble: Ensemble, photographs: Sequence[Photograph]) -> None:
        self._plate, self._lengths, self._regions = ensemble.plate, ensemble.plate.lengths, ensemble.regions
        self._window = window(photographs, self._plate, BEYOND * self._plate.size[1])
        self._grid = Grid.over(*self._window, np.ptp(self._window, axis=1).max() / PIXELS)
        self.body_grid = Grid.over(*window(photographs, self._plate), self._grid.pixel)

    def size(self, room: float, most_height: float) -> tuple[float, float]:
        proportion = np.ptp(self._window[1]) / np.ptp(self._window[0])
        width = min(room, most_height / proportion)
        return width, width * proportion

    def body(self, axes: Axes, faint: bool = False) -> None:
        draw_plate(axes, self._plate, tuple(map(self._lengths.of, self._window[1])), faint, None if faint else self._regions)
        axes.set_xlim(*map(self._lengths.of, self._window[0]))

    def photograph(self, axes: Axes, photograph: Photograph) -> None:
        self.body(axes, faint=True)
        axes.patches[-1].set(edgecolor=EXPERIMENT, linewidth=0.9, zorder=2)
        self._image(axes, photograph.on(self._grid), self._grid)

    def _image(self, axes: Axes, image: np.ndarray, grid: Grid) -> None:
        half = [(grid.y[1] - grid.y[0]) / 2, grid.pixel / 2]
        ends = [self._lengths.of(end) for centres, by in zip((grid.y, grid.z), half) for end in (centres[0] - by, centres[-1] + by)]
        axes.imshow(image, cmap="gray", norm=Normalize(0, 1), origin="lower", interpolation="nearest", zorder=-1, extent=ends)

    def fringes(self, axes: Axes, image: np.ndarray) -> None:
        self.body(axes, faint=True)
        self._image(axes, image, self.body_grid)

    def labels(self, axes: Axes, what: str, is_first: bool, is_last: bool) -> None:
        axes.tick_params(left=is_first, labelleft=is_first, bottom=is_last, labelbottom=is_last)
        if is_first:
            axes.set_ylabel(f"{what}\n{self._lengths.label('z')}")
        if is_last:
            axes.set_xlabel(self._lengths.label("y"))


def _growth(ensemble: Ensemble, experiment: dict[str, Any], photographs: list[Photograph], number: int,
            options: Options) -> Optional[Figure]:
    """Photographs above, fringes of a sample at the same times below, its cracks beneath; None where the sample has no frames."""
    frames, crack = ensemble.files.frames(number), ensemble.files.crack(number)
    if frames is None or crack is None or frames.time.size == 0:
        return None
    frame, times, n, optics = _Frame(ensemble, photographs), ensemble.times, len(photographs), options.optics(frames)
    left, right, top, bottom, gap = 0.75, 0.1, 0.85, 0.45, 0.12
    rows = ["photograph", "fringes", "cracks"] if optics else ["photograph", "cracks"]
    size = frame.size(min((style.PAGE_WIDTH - left - right - (n - 1) * gap) / n, PANEL_ROOM), MOST_HEIGHT)
    figure = Sheet(size, len(rows), n, (left, right, top, bottom), (max(gap, 0.85 - size[0]), 0.28), 6.4)
    colours = time_colours(crack.last_opening, times)
    chosen = nearest_frames(frames, photographs)
    made = fringes_at(frames, chosen, frame.body_grid, optics) if optics else []
    for k, photograph in enumerate(photographs):
        moment = float(frames.time[chosen[k]])
        for row, what in enumerate(rows):
            axes = figure.panel(row, k)
            if what == "photograph":
                frame.photograph(axes, photograph)
                axes.set_title(f"t = {times.of(photograph.time):.3g} {times.name}", pad=3)
            elif what == "fringes":
                frame.fringes(axes, made[k].intensity(photograph.light_field, options.product, photograph.reversed))
            else:
                frame.body(axes)
                draw_facets(axes, crack, colours, until=moment, lengths=ensemble.plate.lengths, times=times)
            if row == 1:
                axes.set_title(f"t₀ + {times.of(moment):.3g} {times.name}", pad=3)
            frame.labels(axes, what, k == 0, row == len(rows) - 1)
    time_bar(figure, colours, left, 2.0, times)
    width, height = figure.get_size_inches()
    figure.text((left + 2.3) / width, 1 - 0.24 / height, fontweight="bold", fontsize=9,
                s=f"{experiment['name']} above sample {number}, nearest by {_by(experiment, number)}")
    return figure


def _by(experiment: dict[str, Any], number: int) -> str:
    """The quantities by which a sample is the nearest one."""
    names = [name.replace("_", " ").replace("jointly", "all jointly") for name, by in experiment["by"].items()
             if by["nearest"] and by["nearest"][0]["sample"] == number]
    return ", ".join(names) or "all jointly of those that are not turned"


def _overlay(ensemble: Ensemble, experiment: dict[str, Any], photograph: Photograph) -> Figure:
    """A photograph, and over it the crack lines of the nearest samples and the path that was read off."""
    frame = _Frame(ensemble, [photograph])
    width, height = frame.size(0.62 * style.PAGE_WIDTH, 5.0)
    figure = Sheet((width, height), 1, 1, (0.75, 2.4, 0.35, 0.45), (0, 0), 5.2)
    axes, lengths = figure.panel(0, 0), ensemble.plate.lengths
    frame.photograph(axes, photograph)
    frame.labels(axes, "", True, True)
    by = experiment["by"].get("pictures") or next(iter(experiment["by"].values()), {"nearest": []})
    for k, nearest in enumerate(by["nearest"][:N_OVERLAID]):
        for j, line in enumerate(ensemble.files.lines(nearest["sample"])):
            axes.plot(*lengths.of(line.points.T), color=style.NOTCH_COLOURS[k + 3], linewidth=1.4,
                      label=f"sample {nearest['sample']}" if j == 0 else None)
    _draw_read_off(axes, experiment["observed"]["lines"], lengths, "path as read off")
    axes.set_title(f"{experiment['name']}, t = {ensemble.times.of(photograph.time):.3g} {ensemble.times.name}", pad=3, fontweight="bold")
    axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1))
    return figure


def _draw_read_off(axes: Axes, lines: Sequence[Sequence[Sequence[float]]], lengths: Unit, label: str) -> None:
    for k, line in enumerate(lines):
        axes.plot(*lengths.of(np.array(line).T), "--", color=EXPERIMENT, linewidth=1.4, label=label if k == 0 else None)


def _path(ensemble: Ensemble, experiment: dict[str, Any]) -> Figure:
    """The path in the plane of the body, and its offsets along the middle of the samples', with their band."""
    found, lengths = experiment["path"], ensemble.plate.lengths
    place, normal = np.array(found["place"]), np.array(found["normal"])
    offset, low, high = (np.array(found[name], float) for name in ("offset", "band_lower", "band_upper"))
    samples = np.array(found["sample_offsets"], float)
    arc_length = np.r_[0, np.hypot(*np.diff(place, axis=0).T).cumsum()]
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.6), layout="constrained")
    body, along = figure.subplots(1, 2)
    lines = experiment["observed"]["lines"]
    seen = np.concatenate([place[:, 1], *(np.array(line)[:, 1] for line in lines)])
    room = 0.25 * ensemble.plate.size[1]
    bottom, top = ensemble.plate.ends(2)
    draw_plate(body, ensemble.plate, (lengths.of(max(bottom, seen.min() - room)), lengths.of(min(top, seen.max() + room))),
               regions=ensemble.regions)

    def curve(of: np.ndarray) -> np.ndarray:
        return lengths.of(place + of[:, None] * normal).T

    shown = np.isfinite(low) & np.isfinite(high)
    for one in found["sample_lines"]:
        body.plot(*lengths.of(np.array(one)).T, color=style.BEFORE_ONSET, linewidth=0.5, alpha=0.6)
    for one in samples:
        along.plot(lengths.of(arc_length), lengths.of(one), color=style.BEFORE_ONSET, linewidth=0.5, alpha=0.6)
    body.fill(*np.hstack([curve(low)[:, shown], curve(high)[:, shown][:, ::-1]]), color=BAND, alpha=0.2, linewidth=0)
    along.fill_between(lengths.of(arc_length), lengths.of(low), lengths.of(high), color=BAND, alpha=0.2, linewidth=0,
                       label="band of the samples alone")
    body.plot(*lengths.of(np.array(lines[0])).T, color=EXPERIMENT, linewidth=1.6)  # the whole, also where it is not compared
    if lines[1:]:
        _draw_read_off(body, lines[1:], lengths, "other arms")
        body.legend(loc="best")
    along.plot(lengths.of(arc_length), lengths.of(offset), color=EXPERIMENT, linewidth=1.6, label=experiment["name"])
    along.plot([], [], color=style.BEFORE_ONSET, linewidth=0.8, label=f"{len(samples)} samples")
    body.set_xlabel(lengths.label("y"))
    body.set_ylabel(lengths.label("z"))
    along.set_xlabel(lengths.label("distance along the middle of the samples"))
    along.set_ylabel(lengths.label("offset"))
    draw_grid(along)
    along.legend(loc="best")
    return figure
