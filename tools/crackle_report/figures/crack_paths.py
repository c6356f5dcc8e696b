# SPDX-License-Identifier: GPL-3.0-or-later
"""The cracks of every sample projected on the YZ plane, a small panel each, as in the paper's Figure 3."""
from __future__ import annotations

import math

import numpy as np
from crackle.files import DONE, FAILED, PENDING
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .. import style
from ..choosing import typical_samples
from ..drawing import Sheet, branching_handles, draw_branching, draw_facets, draw_plate, panel_size, time_bar, time_colours, window
from ..options import Options
from ..fields import CrackSurface
from ..results import Ensemble
from .picture import Picture, Section

PANELS_PER_SHEET = 60
N_TYPICAL = 8
TITLE_ROOM = {False: 1.15, True: 0.62}  # what a panel's title takes in large and in small letters [inch]
DIGIT = 5.8  # width of one in a title [point]
MOST_PANELS = 240  # a page with thousands is neither read nor quickly drawn

EXPLANATION = ("The opened dual facets, projected on the YZ plane and coloured by the time at which they opened, counted from the onset of "
               "the last dynamic phase; grey facets opened before it. Rings mark the branching points that count: solid where this projection "
               "shows them, dotted where only a window through the thickness does.")


def typical(ensemble: Ensemble, _: Options) -> Section:
    """Some samples that stand for all; of a small ensemble all of them."""
    if len(ensemble.samples) <= N_TYPICAL:
        return _section(ensemble, "Crack paths", EXPLANATION, [list(range(len(ensemble.samples)))])
    chosen = typical_samples(ensemble, N_TYPICAL)
    result = _section(
        ensemble, "Typical crack paths", "The most typical sample of each pattern, then those that differ most from "
        "the ones shown; each pattern has panels in proportion to its share. " + EXPLANATION, [chosen] if chosen else [])
    for picture in result.pictures:
        picture.name = "typical-paths"
    return result


def every(ensemble: Ensemble, _: Options) -> Section | None:
    """Every sample, or the first ones of many, on as many sheets as it takes; nothing where `typical` shows them all."""
    n_samples = len(ensemble.samples)
    if n_samples <= N_TYPICAL:
        return None
    numbers = list(range(n_samples))
    title, text = "Crack paths of all samples", EXPLANATION
    if n_samples > MOST_PANELS:
        numbers = np.flatnonzero(ensemble.samples.status != PENDING)[:MOST_PANELS].tolist()
        title = f"Crack paths of {len(numbers)} samples"
        text = f"The first samples computed, of {n_samples:,}. {EXPLANATION}"
    sheets = [numbers[first:first + PANELS_PER_SHEET] for first in range(0, len(numbers), PANELS_PER_SHEET)]
    return _section(ensemble, title, text, sheets)


def _section(ensemble: Ensemble, title: str, text: str, sheets: list[list[int]]) -> Section:
    result = Section(title, text + ensemble.tinted)
    cracks = {i: ensemble.files.crack(i) for sheet in sheets for i in sheet}
    cracks = {i: crack for i, crack in cracks.items() if crack is not None and crack.time.size}
    latest = max((crack.last_opening for crack in cracks.values()), default=0.0)
    colours = time_colours(latest, ensemble.times)
    z_range = window(ensemble.plate, (ensemble.shown_z(crack) for crack in cracks.values()))
    low, high = (end * ensemble.plate.lengths.size for end in z_range)
    if any(crack.corner[..., 2].min() < low or crack.corner[..., 2].max() > high for crack in cracks.values()):
        result.text += " What opened far from the cracks, as at supports, lies outside the panels."
    for sheet in sheets:
        name = "crack-paths" if len(sheets) == 1 else f"crack-paths-{sheet[0]:04d}-{sheet[-1]:04d}"
        result.pictures.append(Picture(
            name, f"Crack paths of samples {', '.join(map(str, sheet))} on the YZ plane",
            _sheet(ensemble, sheet, cracks, colours, z_range)))
    return result


def _sheet(ensemble: Ensemble, numbers: list[int], cracks: dict[int, CrackSurface], colours: Normalize,
           z_range: tuple[float, float]) -> Figure:
    n_columns = _columns(len(ensemble.samples) if len(numbers) > N_TYPICAL else len(numbers))
    left, right, top, bottom, gap_x, gap_y = 0.55, 0.1, 0.75, 0.5, 0.12, 0.34
    room = min((style.PAGE_WIDTH - left - right - (n_columns - 1) * gap_x) / n_columns, 3.2)
    panel_width, panel_height = panel_size(ensemble.plate, z_range, room, 4.0)
    small = n_columns > 6
    is_slender = panel_width < TITLE_ROOM[small] < room
    if is_slender:
        gap_x = TITLE_ROOM[small] - panel_width
        n_columns = min(len(numbers), int((style.PAGE_WIDTH - left - right) / TITLE_ROOM[small]))
    # As wide as a page, with few columns too.
    figure = Sheet((panel_width, panel_height), math.ceil(len(numbers) / n_columns), n_columns, (left, right, top, bottom), (gap_x, gap_y),
                   style.PAGE_WIDTH)
    for k, number in enumerate(numbers):
        row, column = divmod(k, n_columns)
        axes = figure.panel(row, column)
        _panel(axes, ensemble, number, cracks.get(number), colours, z_range)
        _title(axes, ensemble, number, small, in_a_row=is_slender)
        last = k + n_columns >= len(numbers)  # of its column
        axes.tick_params(left=column == 0, labelleft=column == 0, bottom=last, labelbottom=last)
        if column == 0:
            axes.set_ylabel(ensemble.plate.lengths.label("z"))
        if last:
            axes.set_xlabel(ensemble.plate.lengths.label("y"))

    time_bar(figure, colours, left, 3.2, ensemble.times)
    handles: list[Artist] = []
    if any((crack.time < 0).any() for crack in cracks.values()):
        handles.append(Patch(color=style.BEFORE_ONSET, label="opened before the onset"))
    if any((ensemble.times.of(crack.time) > colours.vmax).any() for crack in cracks.values()):
        handles.append(Patch(color=style.AFTER_PHASE, label="opened later, in slow loading"))
    handles += branching_handles(axes, [points for i in numbers if i in cracks and (points := ensemble.files.branching(i)) is not None])
    if handles:
        figure.legend(handles=handles, loc="upper left", bbox_to_anchor=((left + 3.4) / figure.get_figwidth(), 1 - 0.04 / figure.get_figheight()),
                      labelspacing=0.3)
    return figure


def _columns(n_samples: int) -> int:
    """Few samples get large panels; rows as equal as can be."""
    most = next(columns for limit, columns in ((8, 4), (30, 6), (math.inf, 10)) if n_samples <= limit)
    return math.ceil(n_samples / math.ceil(n_samples / most)) if n_samples <= 30 else most


def _title(axes: Axes, ensemble: Ensemble, number: int, small: bool, in_a_row: bool) -> None:
    """The sample's number and, when it is done and has notches, its pattern: at the panel's right end, or in a row with the number where the panel is
    narrower than both."""
    axes.set_title(str(number), loc="left", fontweight="bold", fontsize=7 if small else 8, pad=2)
    if ensemble.samples.status[number] == DONE and ensemble.n_notches:
        pattern = int(ensemble.samples.pattern[number])
        name, size = style.pattern_name(pattern, short=small), 5.5 if small else 7
        if in_a_row:
            axes.annotate(name, (0, 1), (4 + DIGIT * len(str(number)), 2), "axes fraction", "offset points", fontsize=size,
                          annotation_clip=False)
        else:
            axes.set_title(name, loc="right", fontsize=size, pad=2)


def _panel(axes: Axes, ensemble: Ensemble, number: int, crack: CrackSurface | None, colours: Normalize,
           z_range: tuple[float, float]) -> None:
    samples = ensemble.samples
    done = samples.status[number] == DONE
    draw_plate(axes, ensemble.files.plate(number) or ensemble.plate, z_range, faint=not done, regions=ensemble.files.regions(number))
    if not done:
        label = "failed" if samples.status[number] == FAILED else "pending"
        axes.text(0.5, 0.5, label, transform=axes.transAxes, ha="center", va="center", color=style.MUTED,
                  fontweight="bold" if label == "failed" else "normal")
    if crack is None:
        return

    draw_facets(axes, crack, colours, lengths=ensemble.plate.lengths, times=ensemble.times)
    points = ensemble.files.branching(number)
    if points is not None:
        draw_branching(axes, points, ensemble.plate.lengths)
