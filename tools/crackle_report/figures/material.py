# SPDX-License-Identifier: GPL-3.0-or-later
"""How the strength varies from place to place."""
from __future__ import annotations

from typing import Optional

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from .. import style
from ..choosing import samples_in_detail
from ..drawing import draw_plate, near_notches, whole_length
from ..mesh import Mesh
from ..options import Options
from ..plate import Plate
from ..results import Ensemble
from .picture import Picture, Section

RANGE = (0.01, 0.99)  # of the tetrahedra, which the colours span


def section(ensemble: Ensemble, options: Options) -> Optional[Section]:
    """None for a homogeneous material."""
    for number in (*options.samples, *samples_in_detail(ensemble)) if ensemble.done.size else ():
        mesh = ensemble.files.mesh(number)
        if mesh is not None and mesh.strength_factor is not None:
            return Section(
                "Material",
                "Strength of each tetrahedron relative to the input's value, as given by [fracture.variation]: cut at "
                "mid-thickness, and distribution over the volume. Each sample has its own field.",
                answer=f"Sample {number}: {_in_words(mesh)}.",
                pictures=[_strength(mesh, ensemble.plate, f"sample {number}")])
    return None


def _strength(mesh: Mesh, plate: Plate, title: str) -> Picture:
    """The strength's factor in the mid-plane, whole and round the notches, and over the volume."""
    factor, volume = mesh.strength_factor, mesh.volumes()
    low, high = np.quantile(factor, RANGE)
    polygons, numbers = mesh.cut(0, plate.size[0] / 2)
    figure = Figure(figsize=(style.PAGE_WIDTH, 4.6), layout="constrained")
    whole, near, distribution = figure.subplots(1, 3, width_ratios=(1, 3, 2.2))
    for axes, z_range in ((whole, whole_length(plate)), (near, near_notches(plate))):
        draw_plate(axes, plate, z_range)
        collection = PolyCollection([plate.lengths.of(polygon) for polygon in polygons], array=factor[numbers],
                                    cmap="viridis", clim=(low, high), linewidths=0, rasterized=True)
        axes.add_collection(collection, autolim=False)
        axes.set_xlabel(plate.lengths.label("y"))
    whole.set_ylabel(plate.lengths.label("z"))
    whole.set_title("whole body")
    near.set_title(title)
    figure.colorbar(collection, ax=[whole, near], shrink=0.6, label="strength over the input's")
    distribution.hist(factor, 60, weights=100 * volume / volume.sum(), color=style.NOTCH_COLOURS[0])
    distribution.axvline(float(np.average(factor, weights=volume)), color="black", linewidth=0.9, linestyle="--", label="mean")
    distribution.set(xlabel="strength over the input's", ylabel="share of the volume [%]")
    distribution.legend(loc="upper right")
    return Picture("strength", "Strength of the tetrahedra over the input's strength, cut at mid-thickness, and its "
                               "distribution over the volume", figure)


def _in_words(mesh: Mesh) -> str:
    factor, volume = mesh.strength_factor, mesh.volumes()
    mean = np.average(factor, weights=volume)
    deviation = np.sqrt(np.average((factor - mean) ** 2, weights=volume))
    return (f"mean over the volume {mean:.3g}, coefficient of variation {deviation / mean:.3g}, "
            f"least {factor.min():.3g}, greatest {factor.max():.3g}")
