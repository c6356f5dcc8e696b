# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the cracks of all samples cross the sections, with their mean and its band."""
from __future__ import annotations

from collections import defaultdict

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .. import style
from ..drawing import Sheet, draw_plate, panel_size, window
from ..options import Options
from ..fields import CrackLine
from ..results import Ensemble, Ranks
from .picture import Picture, Section

TITLE_ROOM, LEGEND_ROOM = 2.6, 4.9  # what a panel's title and the key take [inch]


def section(ensemble: Ensemble, _: Options) -> Section | None:
    if not ensemble.n_notches:
        return None
    result = Section(
        "All cracks superimposed",
        "Through-thickness means of the leading and of the following cracks, with their branches; samples are mapped "
        "by the body's symmetry, if it has one, so that the leading cracks start at the same notch (numbered from 0, "
        "in the order of the input). Mean, interval and deviation at the cross-sections (dotted) are over the "
        "samples whose crack arrived there, or over each group of them where cracks take several paths; the numbers at "
        f"their ends count all that arrived.{ensemble.tinted}")
    if ensemble.sections and any(ensemble.rows_shown(group) for group in ("leader", "follower")):
        result.pictures.append(Picture("crossings", "Crack positions of all samples at the cross-sections",
                                       _draw(ensemble)))
    return result


def _draw(ensemble: Ensemble) -> Figure:
    panels = [(group, row) for group in ("leader", "follower") for row in ensemble.rows_shown(group)]
    lines = _mapped_lines(ensemble)
    z_range = window(ensemble.plate, [line.points[:, 1] for of_panel in lines.values() for line in of_panel])
    n_columns = min(len(panels), 3)
    n_rows = -(-len(panels) // n_columns)
    left, right, top, bottom, gap_x, gap_y = 0.6, 0.15, 0.75, 0.5, 0.5, 0.9
    room = (style.PAGE_WIDTH - left - right - (n_columns - 1) * gap_x) / n_columns
    panel_width, panel_height = panel_size(ensemble.plate, z_range, room, 6.0)
    gap_x = max(gap_x, min(room, TITLE_ROOM) - panel_width)
    figure = Sheet((panel_width, panel_height), n_rows, n_columns, (left, right, top, bottom), (gap_x, gap_y), LEGEND_ROOM)
    for number, panel in enumerate(panels):
        axes = figure.panel(*divmod(number, n_columns))
        draw_plate(axes, ensemble.plate, z_range, regions=ensemble.regions)
        axes.set_xlabel(ensemble.plate.lengths.label("y"))
        axes.set_ylabel(ensemble.plate.lengths.label("z"))
        _panel(axes, ensemble, *panel, lines[panel])
    figure.legend(handles=[
        Line2D([], [], color=style.MUTED, linewidth=0.7, alpha=0.6, label="a sample's crack"),
        Line2D([], [], color="black", linewidth=1.0, marker="o", markersize=2.5, label="mean"),
        Patch(color="black", alpha=0.2, linewidth=0,
              label=f"{100 * ensemble.confidence:g} % confidence interval of the mean"),
        Line2D([], [], color="black", linewidth=0.8, linestyle="--", label="± one standard deviation"),
    ], loc="upper left", ncol=4 if n_columns > 1 else 2, bbox_to_anchor=((left - 0.1) / figure.get_figwidth(), 1.0))
    return figure


def _mapped_lines(ensemble: Ensemble) -> dict[tuple[str, int], list[CrackLine]]:
    """The lines of each panel: group and row, in the frame of the leading crack."""
    lines = defaultdict(list)
    for i in ensemble.done:
        leading = int(ensemble.leading[i])
        for line in ensemble.files.lines(i) if leading >= 0 else []:
            symmetry = ensemble.symmetries[leading]
            for group in ("leader", "follower") if line.notch >= 0 else ():
                row = ensemble.ranks[group].row_of(symmetry.reference, symmetry.notch.index(line.notch))
                if row is not None:
                    points = symmetry.mapped(line.points, ensemble.plate)
                    lines[group, row].append(CrackLine(line.notch, line.is_branch, points))
    return lines


def _panel(axes: Axes, ensemble: Ensemble, group: str, row: int, lines: list[CrackLine]) -> None:
    colour = style.notch_colour(int(ensemble.ranks[group].notch[row]))
    statistics = ensemble.ranks[group]
    along = int(ensemble.plate.notch_axis[statistics.notch[row]])
    for axis in (1, 2):
        if along in (0, axis):  # 0: cracks run in any direction
            _sections(axes, ensemble, statistics, row, axis)
    _lines(axes, ensemble, statistics, row)
    axes.set_title(ensemble.rank_name(group, row), loc="left", fontweight="bold", color=colour, pad=14)

    alpha = float(np.clip(12 / max(len(lines), 1), 0.12, 0.7))
    for line in lines:
        points = ensemble.plate.lengths.of(line.points)
        axes.plot(points[:, 0], points[:, 1], color=colour, linewidth=0.5 if line.is_branch else 0.8, alpha=alpha,
                  zorder=2)


def _lines(axes: Axes, ensemble: Ensemble, statistics: Ranks, row: int) -> None:
    """The sections along lines, and the row's mean position on each with its interval and standard deviation."""
    lengths = ensemble.plate.lengths
    for k, section in enumerate(ensemble.sections):
        if section.ends is None:
            continue
        axes.plot(*lengths.of(section.ends).T, color=style.MUTED, linewidth=0.4, linestyle=":", zorder=1)
        for mean, std, half_width, reached in {tuple(float(values[k]) for values in group) for group in _groups(statistics, row)}:
            if not np.isfinite(mean):
                continue
            for extent, kind in ((half_width, {"linewidth": 3.0, "alpha": 0.2}), (std, {"linewidth": 0.8, "linestyle": "--"})):
                if np.isfinite(extent):
                    axes.plot(*lengths.of(section.places([mean - extent, mean + extent])).T, color="black", zorder=4,
                              **kind)
            place = lengths.of(section.places(mean))
            axes.plot(*place, color="black", marker="o", markersize=2.5, zorder=5)
            axes.annotate(f"{reached:.0f}", place, (3, 3), textcoords="offset points", fontsize=7, color=style.MUTED)


def _groups(statistics: Ranks, row: int) -> list[tuple[np.ndarray, ...]]:
    """Mean, standard deviation, half width of the interval and number of samples, of each path that the row's cracks take."""
    return list(zip(*(statistics.by_group(row, name) for name in ("z_mean", "z_std", "z_half_width", "reached"))))


def _sections(axes: Axes, ensemble: Ensemble, statistics: Ranks, row: int, axis: int) -> None:
    """The sections across an axis, and the mean path of the row's cracks there with its band."""
    is_y, lengths = axis == 1, ensemble.plate.lengths
    chosen = [k for k, section in enumerate(ensemble.sections) if section.axis == axis]
    at = lengths.of(np.array([ensemble.sections[k].position for k in chosen]))

    def plot(position: np.ndarray, **kind: object) -> None:
        axes.plot(*((at, position) if is_y else (position, at)), color="black", **kind)

    z_low, z_high = axes.get_ylim()
    for position, reached in zip(at, statistics.reached[row, chosen]):
        if not is_y and not z_low <= position <= z_high:
            continue
        (axes.axvline if is_y else axes.axhline)(position, color=style.MUTED, linewidth=0.4, linestyle=":", zorder=1)
        axes.text(*((position, 1.01) if is_y else (1.01, position)), str(reached),
                  transform=axes.get_xaxis_transform() if is_y else axes.get_yaxis_transform(),
                  ha="center" if is_y else "left", va="bottom" if is_y else "center", fontsize=7, color=style.MUTED,
                  clip_on=False)
    for group in _groups(statistics, row):
        mean, std, half_width = (lengths.of(values[chosen]) for values in group[:3])
        if not np.isfinite(mean).any():
            continue
        plot(mean, linewidth=1.0, marker="o", markersize=2.5, zorder=5)
        for side in (-1, 1):
            plot(mean + side * std, linewidth=0.8, linestyle="--", zorder=4)
        (axes.fill_between if is_y else axes.fill_betweenx)(at, mean - half_width, mean + half_width, color="black",
                                                            alpha=0.2, linewidth=0, zorder=4)
