# SPDX-License-Identifier: GPL-3.0-or-later
"""The cracks of every sample projected on the YZ plane, a small panel each, as in the paper's Figure 3."""
from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PathCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.path import Path

from .. import style
from ..drawing import draw_plate, window
from ..results import DONE, FAILED, CrackSurface, Ensemble
from .picture import Picture, Section

PANELS_PER_SHEET = 60
N_SHADES = 200


def section(ensemble: Ensemble) -> Section:
    numbers = range(len(ensemble.samples))
    cracks = {i: ensemble.load_crack(i) for i in numbers if ensemble.samples.status[i] == DONE}
    cracks = {i: crack for i, crack in cracks.items() if crack is not None and crack.time.size}
    latest = max((float(crack.time.max()) for crack in cracks.values()), default=0.0)
    colours = Normalize(0.0, latest / style.MICROSECOND if latest > 0 else 1.0)
    z_range = window(ensemble.plate, (crack.corner[:, :, 2] for crack in cracks.values()))

    result = Section(
        "Crack paths",
        "The opened dual facets of every sample, projected on the YZ plane and coloured by the time they "
        "opened, counted from the onset of the last dynamic phase. Grey facets opened before it.")
    n_sheets = math.ceil(len(numbers) / PANELS_PER_SHEET)
    for first in range(0, len(numbers), PANELS_PER_SHEET):
        sheet = numbers[first:first + PANELS_PER_SHEET]
        name = "crack-paths" if n_sheets == 1 else f"crack-paths-{sheet[0]:04d}-{sheet[-1]:04d}"
        result.pictures.append(Picture(
            name, f"Crack paths of samples {sheet[0]} to {sheet[-1]} on the YZ plane",
            _sheet(ensemble, sheet, cracks, colours, z_range)))
    return result


def _sheet(ensemble: Ensemble, numbers: range, cracks: dict[int, CrackSurface], colours: Normalize,
           z_range: tuple[float, float]) -> Figure:
    n_columns = _columns(len(ensemble.samples))
    n_rows = math.ceil(len(numbers) / n_columns)
    left, right, top, bottom, gap_x, gap_y = 0.55, 0.1, 0.75, 0.5, 0.12, 0.34
    panel_width = min((style.PAGE_WIDTH - left - right - (n_columns - 1) * gap_x) / n_columns, 3.2)
    proportion = (z_range[1] - z_range[0]) / (1.08 * ensemble.plate.size[1] / style.MILLIMETRE)
    panel_height = min(panel_width * proportion, 4.0)
    height = top + bottom + n_rows * panel_height + (n_rows - 1) * gap_y

    figure = Figure(figsize=(style.PAGE_WIDTH, height))
    for k, number in enumerate(numbers):
        row, column = divmod(k, n_columns)
        axes = figure.add_axes((
            (left + column * (panel_width + gap_x)) / style.PAGE_WIDTH,
            1 - (top + (row + 1) * panel_height + row * gap_y) / height,
            panel_width / style.PAGE_WIDTH, panel_height / height))
        _panel(axes, ensemble, number, cracks.get(number), colours, z_range)
        _title(axes, ensemble, number, small=n_columns > 6)
        axes.tick_params(labelleft=column == 0, labelbottom=k + n_columns >= len(numbers))
        if column == 0:
            axes.set_ylabel("z [mm]")
        if k + n_columns >= len(numbers):
            axes.set_xlabel("y [mm]")

    bar = figure.add_axes((left / style.PAGE_WIDTH, 1 - 0.2 / height, 3.2 / style.PAGE_WIDTH, 0.1 / height))
    figure.colorbar(ScalarMappable(colours, style.TIME_COLOURS), cax=bar, orientation="horizontal")
    bar.set_xlabel("time since onset [µs]", labelpad=1)
    if any((crack.time < 0).any() for crack in cracks.values()):
        figure.legend(handles=[Patch(color=style.BEFORE_ONSET, label="opened before the onset")],
                      loc="upper left", bbox_to_anchor=((left + 3.4) / style.PAGE_WIDTH, 1 - 0.1 / height))
    return figure


def _columns(n_samples: int) -> int:
    """Few samples get large panels; rows as equal as can be."""
    most = next(columns for limit, columns in ((8, 4), (30, 6), (math.inf, 10)) if n_samples <= limit)
    return math.ceil(n_samples / math.ceil(n_samples / most)) if n_samples <= 30 else most


def _title(axes: Axes, ensemble: Ensemble, number: int, small: bool) -> None:
    """The sample's number and, when it is done, its pattern."""
    axes.set_title(str(number), loc="left", fontweight="bold", fontsize=7 if small else 8, pad=2)
    if ensemble.samples.status[number] == DONE:
        pattern = int(ensemble.samples.pattern[number])
        axes.set_title(style.pattern_name(pattern, short=small), loc="right", fontsize=5.5 if small else 7, pad=2)


def _panel(axes: Axes, ensemble: Ensemble, number: int, crack: CrackSurface | None, colours: Normalize,
           z_range: tuple[float, float]) -> None:
    samples = ensemble.samples
    done = samples.status[number] == DONE
    draw_plate(axes, ensemble.plate, z_range, faint=not done)
    if not done:
        label = "failed" if samples.status[number] == FAILED else "pending"
        axes.text(0.5, 0.5, label, transform=axes.transAxes, ha="center", va="center", color=style.MUTED,
                  fontweight="bold" if label == "failed" else "normal")
    if crack is None:
        return

    _facets(axes, crack, colours)


def _facets(axes: Axes, crack: CrackSurface, colours: Normalize) -> None:
    """The facets as one path for each shade: many facets are drawn fast, and with little memory."""
    corner = crack.corner[:, :, 1:].astype(float) / style.MILLIMETRE
    # All turn the same way round, so that facets over each other do not cut holes into their path.
    diagonals = corner[:, 2:] - corner[:, :2]
    clockwise = diagonals[:, 0, 0] * diagonals[:, 1, 1] < diagonals[:, 0, 1] * diagonals[:, 1, 0]
    corner[clockwise] = corner[clockwise, ::-1]

    time = crack.time / style.MICROSECOND
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
