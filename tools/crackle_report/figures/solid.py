# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies that are no plates, seen along the three axes: where they broke, and how the crack surface grew."""
from __future__ import annotations

from typing import Optional

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from .. import style
from ..choosing import samples_in_detail
from ..drawing import Sheet, facet_colours, time_bar, time_colours
from ..options import Options
from ..results import Ensemble
from .picture import Picture, Section
from .places import answer

VIEWS = ((1, 2, "along x"), (0, 2, "along y"), (0, 1, "along z"))  # what is to the right, what is up
ROOM, MARGIN = 2.6, 0.05  # a panel's width at most [inch]; round the body, as a share of its size
KEY_ROOM = 2.0  # beside the panels [inch]


def places(ensemble: Ensemble, _: Options) -> Optional[Section]:
    found = ensemble.places
    if not found:
        return None
    figure, panels = _panels(ensemble, next(iter(found)), right=KEY_ROOM)
    lengths = ensemble.plate.lengths
    for (across, up, _title), axes in zip(VIEWS, panels):
        for name, marker, colour, label in (("largest", "x", style.NOTCH_COLOURS[0], "middle of the largest crack"),
                                            ("first", "o", style.NOTCH_COLOURS[1], "first break")):
            points = lengths.of(np.array([getattr(place, name) for place in found.values()]))
            axes.plot(points[:, across], points[:, up], marker, color=colour, markersize=4, linestyle="none", label=label, alpha=0.8)
    panels[-1].legend(loc="upper left", bbox_to_anchor=(1.02, 1.0))
    return Section(
        "Where it broke", "The first tetrahedron that broke in each sample, and the middle of its largest crack, with the edges of the "
        "body. Cracks are followed in plates only, so this body has no paths, patterns or speeds.", answer(ensemble, found),
        [Picture("places", "First breaks and largest cracks of all samples, seen along the three axes", figure)])


def section(ensemble: Ensemble, options: Options) -> Optional[Section]:
    pictures = []
    for number in options.samples or samples_in_detail(ensemble):
        crack = ensemble.files.crack(number)
        if crack is None or not crack.time.size:
            continue
        colours = time_colours(crack.last_opening, ensemble.times)
        rgb = facet_colours(ensemble.times.of(crack.time), colours)
        corner = ensemble.plate.lengths.of(crack.corner)
        figure, panels = _panels(ensemble, number, top=0.75)
        for (across, up, _title), axes in zip(VIEWS, panels):
            hidden = 3 - across - up
            order = np.argsort(corner[..., hidden].mean(axis=1) * (-1 if hidden == 1 else 1))  # the nearest last
            axes.add_collection(PolyCollection(corner[order][..., [across, up]], facecolors=rgb[order], edgecolors="face", linewidths=0.2,
                                               rasterized=True, zorder=2))
        time_bar(figure, colours, 0.6, 2.0, ensemble.times)
        width, height = figure.get_size_inches()
        figure.text(2.9 / width, 1 - 0.22 / height, f"sample {number}", fontweight="bold", fontsize=9)
        pictures.append(Picture(f"crack-{number:04d}", f"Crack surface of sample {number}, seen along the three axes", figure))
    if not pictures:
        return None
    return Section("Body and crack", "The opened facets of the samples shown in detail, seen along the three axes and coloured by the time "
                   "at which they opened; grey ones were open before the last dynamic phase.", pictures=pictures)


def _panels(ensemble: Ensemble, number: int, top: float = 0.35, right: float = 0.15) -> tuple[Sheet, list[Axes]]:
    """Three views of the body and its edges at one scale. @param number of the sample whose mesh fills it"""
    lengths = ensemble.plate.lengths
    edge, mesh = lengths.of(ensemble.plate.edge), ensemble.files.mesh(number)
    surface = lengths.of(mesh.nodes)[mesh.surface]
    low, high = edge.min(axis=(0, 1)), edge.max(axis=(0, 1))
    around = MARGIN * (high - low).max()
    low, high = low - around, high + around
    size = high - low
    scale = min(ROOM / size[[0, 1]].max(), 5.0 / size[[1, 2]].max())
    figure = Sheet((scale * size[[0, 1]].max(), scale * size[[1, 2]].max()), 1, len(VIEWS), (0.6, right, top, 0.5), (0.55, 0.0), 5.2)
    panels = []
    for k, (across, up, title) in enumerate(VIEWS):
        axes = figure.panel(0, k)
        axes.add_collection(PolyCollection(surface[..., [across, up]], facecolors=style.BODY, edgecolors=style.BODY, linewidths=0.3,
                                           rasterized=True, zorder=0))
        axes.add_collection(LineCollection(edge[..., [across, up]], colors=style.OUTLINE, linewidths=0.5, zorder=1))
        axes.set(xlim=(low[across], high[across]), ylim=(low[up], high[up]), aspect="equal",
                 xlabel=lengths.label("xyz"[across]), ylabel=lengths.label("xyz"[up]))
        axes.set_title(title, pad=4)
        panels.append(axes)
    return figure, panels
