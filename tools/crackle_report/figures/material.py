# SPDX-License-Identifier: GPL-3.0-or-later
"""How strength and stiffness vary from place to place."""
from __future__ import annotations

from dataclasses import dataclass
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


@dataclass(frozen=True)
class Property:
    """What differs from tetrahedron to tetrahedron."""

    name: str
    label: str  # of an axis
    values: np.ndarray  # m


def properties(mesh: Mesh) -> list[Property]:
    found = []
    if mesh.strength_factor is not None:
        found.append(Property("strength", "strength over the input's", mesh.strength_factor))
    if mesh.youngs_modulus is not None:
        found.append(Property("stiffness", "Young's modulus [GPa]", 1e-9 * mesh.youngs_modulus))
    return found


def section(ensemble: Ensemble, options: Options) -> Optional[Section]:
    """None for a homogeneous material."""
    for number in (*options.samples, *samples_in_detail(ensemble)) if ensemble.done.size else ():
        mesh = ensemble.files.mesh(number)
        if mesh is not None and (found := properties(mesh)):
            return Section(
                "Material",
                "Strength by [fracture.variation] and Young's modulus of each tetrahedron: cut at mid-thickness, and "
                "distribution over the volume. Each sample has its own random fields.",
                answer=f"Sample {number}: {'; '.join(_in_words(mesh, one) for one in found)}.",
                pictures=[_field(mesh, one, ensemble.plate, f"sample {number}") for one in found])
    return None


def _field(mesh: Mesh, shown: Property, plate: Plate, title: str) -> Picture:
    """A property in the mid-plane, whole and round the notches, and over the volume."""
    values, volume = shown.values, mesh.volumes()
    low, high = np.quantile(values, RANGE)
    polygons, numbers = mesh.cut(0, plate.size[0] / 2)
    figure = Figure(figsize=(style.PAGE_WIDTH, 4.6), layout="constrained")
    whole, near, distribution = figure.subplots(1, 3, width_ratios=(1, 3, 2.2))
    for axes, z_range in ((whole, whole_length(plate)), (near, near_notches(plate))):
        draw_plate(axes, plate, z_range)
        collection = PolyCollection([plate.lengths.of(polygon) for polygon in polygons], array=values[numbers],
                                    cmap="viridis", clim=(low, high), linewidths=0, rasterized=True)
        axes.add_collection(collection, autolim=False)
        axes.set_xlabel(plate.lengths.label("y"))
    whole.set_ylabel(plate.lengths.label("z"))
    whole.set_title("whole body")
    near.set_title(title)
    figure.colorbar(collection, ax=[whole, near], shrink=0.6, label=shown.label)
    distribution.hist(values, 60, weights=100 * volume / volume.sum(), color=style.NOTCH_COLOURS[0])
    distribution.axvline(float(np.average(values, weights=volume)), color="black", linewidth=0.9, linestyle="--", label="mean")
    distribution.set(xlabel=shown.label, ylabel="share of the volume [%]")
    distribution.legend(loc="upper right")
    return Picture(shown.name, f"{shown.label[0].upper()}{shown.label[1:]} of the tetrahedra, cut at mid-thickness, and its "
                               "distribution over the volume", figure)


def _in_words(mesh: Mesh, shown: Property) -> str:
    values, volume = shown.values, mesh.volumes()
    mean = np.average(values, weights=volume)
    deviation = np.sqrt(np.average((values - mean) ** 2, weights=volume))
    return (f"{shown.label}: mean over the volume {mean:.3g}, coefficient of variation {deviation / mean:.3g}, "
            f"least {values.min():.3g}, greatest {values.max():.3g}")
