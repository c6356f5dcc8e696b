# SPDX-License-Identifier: GPL-3.0-or-later
"""Where bodies without notches broke."""
from __future__ import annotations

from typing import Optional

import numpy as np
from matplotlib.figure import Figure

from .. import style
from ..drawing import Sheet, draw_plate, panel_size, whole_length
from ..options import Options
from ..fields import Places
from ..results import Ensemble
from .picture import Picture, Section

KEY_ROOM = 1.9  # beside the body [inch]


def section(ensemble: Ensemble, _: Options) -> Optional[Section]:
    """None for bodies with notches, whose cracks are followed from there, and where nothing broke."""
    places = ensemble.places
    if ensemble.n_notches or not places:
        return None
    return Section(
        "Where it broke", "The first tetrahedron that broke in each sample, and the middle of its largest crack. Cracks are traced from notches, "
        "holes and outlines only, so this body has no paths, patterns or speeds.", answer(ensemble, places),
        [Picture("places", "First breaks and largest cracks of all samples", _draw(ensemble, places))])


def answer(ensemble: Ensemble, places: dict[int, Places]) -> str:
    first, largest = (np.array([getattr(place, name) for place in places.values()]) for name in ("first", "largest"))
    sentence = f"First breaks: {_range(ensemble, first)}."
    return sentence + (f" Largest cracks: {_range(ensemble, largest)}." if np.isfinite(largest).any() else "")


def _range(ensemble: Ensemble, points: np.ndarray) -> str:
    """Medians of y and z, of a solid also x, and between which values they lie."""
    lengths = ensemble.plate.lengths
    texts = []
    for axis, name in (*((0, "x"),) * ensemble.plate.is_solid, (1, "y"), (2, "z")):
        values = lengths.of(points[np.isfinite(points[:, axis]), axis])
        texts.append(f"{name} = {np.median(values):.2f} {lengths.name}" + (f" ({values.min():.2f} to {values.max():.2f})" if values.size > 1 else ""))
    return ", ".join(texts)


def _draw(ensemble: Ensemble, places: dict[int, Places]) -> Figure:
    plate, lengths = ensemble.plate, ensemble.plate.lengths
    z_range = whole_length(plate)
    figure = Sheet(panel_size(plate, z_range, 4.2, 5.0), 1, 1, (0.6, 0.15 + KEY_ROOM, 0.15, 0.5), (0.0, 0.0))
    axes = figure.panel(0, 0)
    draw_plate(axes, plate, z_range, regions=ensemble.regions)
    for name, marker, colour, label in (("largest", "x", style.NOTCH_COLOURS[0], "middle of the largest crack"),
                                        ("first", "o", style.NOTCH_COLOURS[1], "first break")):
        points = lengths.of(np.array([getattr(place, name) for place in places.values()]))
        axes.plot(points[:, 1], points[:, 2], marker, color=colour, markersize=4, linestyle="none", label=label, alpha=0.8)
    axes.set_xlabel(lengths.label("y"))
    axes.set_ylabel(lengths.label("z"))
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure
