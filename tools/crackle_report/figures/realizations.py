# SPDX-License-Identifier: GPL-3.0-or-later
"""Base points, one realization's cut, and where the candidate crack facets point."""
from __future__ import annotations

from typing import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from crackle.units import MM, Unit, fitting

from .. import style
from ..drawing import draw_plate, near_notches, whole_length
from ..mesh import Mesh
from ..plate import MeshRegion, Plate
from .picture import Picture

THICKNESS_OF_SECTION = 0.2  # of the body's
N_BINS = 48  # across the map of directions
QUALITY_LEVELS = np.linspace(0.2, 1.0, 9)
# Without viridis's dark end, in which the edges vanish.
SPACING_COLOURS = ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0.35, 1.0, 256)))
LARGEST_DENSITY = 5.0  # that is shown, and its reciprocal the smallest


def base_points(mesh: Mesh) -> Picture:
    """The base mother points near mid-thickness: the whole plate, and round the notches."""
    plate, lengths = mesh.plate, mesh.plate.lengths
    points, thickness = lengths.of(mesh.nodes), lengths.of(plate.size[0])
    low, high = (0.5 * thickness * (1 + side * THICKNESS_OF_SECTION) for side in (-1, 1))
    points = points[(points[:, 0] >= low) & (points[:, 0] <= high)]
    figure = Figure(figsize=(7.2, 4.9), layout="constrained")
    whole, near = figure.subplots(1, 2, width_ratios=(1, 3.6))
    for axes, z_range, size in ((whole, whole_length(plate), 0.15), (near, near_notches(plate), 2.2)):
        draw_plate(axes, plate, z_range)
        axes.scatter(points[:, 1], points[:, 2], s=size, color=style.NOTCH_COLOURS[0], linewidths=0)
        axes.set_xlabel(plate.lengths.label("y"))
    whole.set_ylabel(plate.lengths.label("z"))
    whole.set_title("whole plate")
    near.set_title(f"round the notches: {low:g} {lengths.name} ≤ x ≤ {high:g} {lengths.name}")
    return Picture("mother-points", "Base mother points of the plate: a section at mid-thickness", figure)


def cut(mesh: Mesh, sample: int) -> Picture:
    """The tetrahedra of a realization, cut at mid-thickness and coloured by their quality."""
    plate = mesh.plate
    middle = plate.size[0] / 2
    polygons, numbers = mesh.cut(0, middle)
    figure = Figure(figsize=(7.2, 4.5), layout="constrained")
    axes = figure.subplots()
    draw_plate(axes, plate, near_notches(plate))
    collection = PolyCollection([plate.lengths.of(polygon) for polygon in polygons],
                                array=mesh.quality[numbers], cmap="cividis",
                                norm=BoundaryNorm(QUALITY_LEVELS, 256), edgecolors=style.OUTLINE, linewidths=0.25)
    axes.add_collection(collection, autolim=False)
    axes.set_xlabel(plate.lengths.label("y"))
    axes.set_ylabel(plate.lengths.label("z"))
    axes.set_title(f"realization {sample}, cut at x = {plate.lengths.of(middle):g} {plate.lengths.name}")
    figure.colorbar(collection, ax=axes, shrink=0.6, label="mean-ratio quality of the tetrahedron")
    return Picture("realization-cut", "Tetrahedra of one realization, cut at mid-thickness round the notches",
                   figure)


def spacing(mesh: Mesh) -> Picture:
    """The tetrahedra cut at mid-thickness, coloured by the spacing asked for: the whole plate, and the ligament."""
    plate, regions = mesh.plate, mesh.regions
    polygons, numbers = mesh.cut(0, plate.size[0] / 2)
    polygons = [plate.lengths.of(polygon) for polygon in polygons]
    spacings = fitting(mesh.spacing, MM, least=0.05, most=1e4)
    wanted = spacings.of(mesh.spacing[mesh.tetrahedra[numbers]].mean(axis=1))
    least, greatest = spacings.of(mesh.spacing.min()), spacings.of(mesh.spacing.max())
    norm = LogNorm(least, greatest if greatest > least else 1.1 * least)
    height = 9.0
    figure = Figure(figsize=(style.PAGE_WIDTH, height), layout="constrained")
    whole, near = figure.subplots(1, 2, width_ratios=(1, 3.2))
    for axes, z_range, width in ((whole, whole_length(plate), 0.08), (near, _ligament(plate, regions), 0.2)):
        draw_plate(axes, plate, z_range)
        shown = [i for i, polygon in enumerate(polygons)
                 if polygon[:, 1].max() >= z_range[0] and polygon[:, 1].min() <= z_range[1]]
        collection = PolyCollection([polygons[i] for i in shown], array=wanted[shown], cmap=SPACING_COLOURS, norm=norm,
                                    edgecolors=style.OUTLINE, linewidths=width, rasterized=True)
        axes.add_collection(collection, autolim=False)
        axes.set_xlabel(plate.lengths.label("y"))
        for number, region in enumerate(regions):
            (y, y_end), (z, z_end) = (plate.lengths.of(np.array(extent)) for extent in region.box[1:])
            axes.add_patch(Rectangle((y, z), y_end - y, z_end - z, fill=False, edgecolor=style.NOTCH_COLOURS[1],
                                     linewidth=1.2, zorder=3))
            if axes is near:
                _label_region(axes, number, spacings, region, int(np.count_nonzero(mesh.region == number)), (y, y_end), (z, z_end))
    whole.set_ylabel(plate.lengths.label("z"))
    whole.set_title("whole plate")
    near.set_title(f"ligament; {_grouped(len(mesh.nodes))} points, {_grouped(len(mesh.tetrahedra))} tetrahedra in all")
    bar = figure.colorbar(collection, ax=[whole, near], shrink=0.5, label=spacings.label("spacing asked for"))
    ticks = sorted({float(f"{value:.2g}") for value in np.geomspace(norm.vmin, norm.vmax, 5)})
    bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks], minor=False)
    bar.minorticks_off()
    return Picture("mesh", "Tetrahedra of one realization, cut at mid-thickness", figure)


def orientations(facets: dict[str, np.ndarray], perturbation: float) -> Picture:
    """Density of the candidates' area over the directions of their normals, one map for each mesh.

    `facets` has vector areas, n x 3, by the name of the mesh.
    """
    densities = {name: _density(areas) for name, areas in facets.items()}
    norm = LogNorm(1 / LARGEST_DENSITY, LARGEST_DENSITY)
    figure = Figure(figsize=(style.PAGE_WIDTH, 3.5), layout="constrained")
    grid = figure.subplots(1, len(facets), squeeze=False)[0]
    for axes, (name, density) in zip(grid, densities.items()):
        axes.imshow(density.T.clip(1 / LARGEST_DENSITY, LARGEST_DENSITY), origin="lower", extent=(-1, 1, -1, 1), cmap="PuOr_r", norm=norm,
                    interpolation="nearest")
        _draw_rim(axes)
        axes.set_title(f"{name}\nfourth-order bias {fourth_order_bias(facets[name]):.4f}")
    ticks = {1 / 5: "1/5", 1 / 3: "1/3", 1 / 2: "1/2", 1: "1", 2: "2", 3: "3", 5: "5"}
    bar = figure.colorbar(ScalarMappable(norm, "PuOr_r"), ax=grid, shrink=0.75, extend="both",
                          label="area of candidates over the isotropic one")
    bar.set_ticks(list(ticks), labels=list(ticks.values()), minor=False)
    bar.minorticks_off()
    figure.supxlabel(f"normals of the dual facets on the upper hemisphere, equal-area projection; disturbed by "
                     f"{perturbation:g} spacings", fontsize=8)
    return Picture("candidate-orientations",
                   "Distribution of the candidate facets' normals: lattices have preferred directions", figure)


def fourth_order_bias(areas: np.ndarray) -> float:
    """Distance of the mean of n n n n from the isotropic one, over the size of that; as `crackle mesh`."""
    size = np.linalg.norm(areas, axis=1)
    normal = areas / size[:, None]
    pairs = np.einsum("ni,nj->nij", normal, normal).reshape(-1, 9)
    fourth = ((pairs * size[:, None]).T @ pairs / size.sum()).reshape(3, 3, 3, 3)
    delta = np.eye(3)
    isotropic = (np.einsum("ij,kl->ijkl", delta, delta) + np.einsum("ik,jl->ijkl", delta, delta)
                 + np.einsum("il,jk->ijkl", delta, delta)) / 15
    return float(np.linalg.norm(fourth - isotropic) / np.linalg.norm(isotropic))


def _grouped(number: int) -> str:
    return f"{number:,}".replace(",", "\u2009")


def _ligament(plate: Plate, regions: Sequence[MeshRegion]) -> tuple[float, float]:
    """The surroundings of the notches with the regions there, as far as a plate's width from the middle."""
    low, high = near_notches(plate)
    middle, width = (low + high) / 2, plate.lengths.of(plate.size[1])
    for region in regions:
        start, end = (plate.lengths.of(z) for z in region.box[2])
        if start < high and end > low:
            low, high = min(low, start - 0.04 * width), max(high, end + 0.04 * width)
    return max(low, middle - width), min(high, middle + width)


def _label_region(axes: Axes, number: int, spacings: Unit, region: MeshRegion, n_points: int, y: tuple[float, float],
                  z: tuple[float, float]) -> None:
    """Names a region in its upper left corner, or where that comes into view."""
    text = f"region {number}: {spacings.of(region.spacing):.3g} {spacings.name}, {_grouped(n_points)} points"
    low, high = axes.get_ylim()
    axes.text(y[0] + 0.01 * (axes.get_xlim()[1] - axes.get_xlim()[0]), np.clip(z[1], low, high) - 0.01 * (high - low), text,
              ha="left", va="top", fontsize=8, zorder=4, clip_on=True,
              bbox={"facecolor": "w", "alpha": 0.85, "edgecolor": style.NOTCH_COLOURS[1], "linewidth": 0.6,
                    "boxstyle": "round,pad=0.2"})


def _density(areas: np.ndarray) -> np.ndarray:
    """Area in equal bins of the Lambert projection of the hemisphere, over its mean; NaN outside."""
    size = np.linalg.norm(areas, axis=1)
    normal = areas / size[:, None]
    normal[normal[:, 2] < 0] *= -1
    scale = 1 / np.sqrt(1 + normal[:, 2])  # onto the disc of radius 1
    edges = np.linspace(-1, 1, N_BINS + 1)
    area, _, _ = np.histogram2d(normal[:, 0] * scale, normal[:, 1] * scale, bins=(edges, edges), weights=size)
    corner = np.hypot(*np.meshgrid(edges, edges, indexing="ij"))
    outermost = np.max([corner[:-1, :-1], corner[1:, :-1], corner[:-1, 1:], corner[1:, 1:]], axis=0)
    bin_area = (2 / N_BINS) ** 2
    # Bins that the rim cuts are left out: they hold less for another reason.
    return np.where(outermost <= 1, area / (size.sum() * bin_area / np.pi), np.nan)


def _draw_rim(axes: Axes) -> None:
    angle = np.linspace(0, 2 * np.pi, 200)
    axes.plot(np.cos(angle), np.sin(angle), color=style.OUTLINE, linewidth=0.6)
    for x, y, label in ((1.09, 0, "x"), (0, 1.09, "y"), (0.09, 0.09, "z")):
        axes.text(x, y, label, ha="center", va="center", path_effects=[withStroke(linewidth=2, foreground="w")])
    axes.plot([0], [0], marker="+", markersize=5, color=style.OUTLINE)
    axes.set_xlim(-1.18, 1.18)
    axes.set_ylim(-1.18, 1.18)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.axis("off")
