# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's pictures."""
from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import PathPatch

import measured
from crackle import Ensemble, Sample
from crackle.units import US, Unit
from crackle_report import style
from crackle_report.drawing import draw_facets, draw_plate, draw_regions, draw_rings, outline_path, time_colours, whole_length, window
from crackle_report.plate import Plate
from crackle_report.fields import CrackSurface
from crackle_report.writing import write_light_figure
from problems import DEPTH, MODULUS, TOUGHNESS, drawn, exponents, handbook_load, onset_loads, projected_branching


def breaking_loads(ensemble: Ensemble) -> np.ndarray:
    """The largest of each sample, or where dynamics started from rest that at the first break [N]."""
    samples = ensemble.samples
    return np.where(np.isfinite(samples.onset_force), samples.peak_load, samples.first_break_load)


QUASI_STATIC = ("quenched-alumina",)  # whose cracks grow with the load
BRANCHED = ("paper-plate", "pmma-strip", "glass-plate")  # of which branching points are counted

style.apply()
DPI = 130
MS = Unit("ms", 1e-3)
SLOW = 0.1  # s after the onset: a dynamic phase is over, and what opens later does so while the load grows
COLOURED = 0.99  # of a sample's facets; some late ones would make all others dark


def draw(name: str, picture: Path, ensemble: Ensemble) -> None:
    """The picture of a body of the gallery."""
    if name == "uncertain-strip":
        draw_exponents(picture, ensemble)
    elif name == "slotted-hole":
        draw_measured(picture, ensemble, measured.PROBLEMS[name].experiments_file)
    else:
        draw_cracks(picture, ensemble, name in BRANCHED, name in QUASI_STATIC)


def draw_cracks(picture: Path, ensemble: Ensemble, rings: bool = False, quasi_static: bool = False) -> None:
    """The mesh of the first sample on the side x = 0, and the cracks of the first samples; of a long body the part that breaks.

    @param rings: round the branching points in the projection
    @param quasi_static: colours tell the time of the load at which cracks opened, not that since the onset
    """
    samples = [ensemble[i] for i in ensemble.done[:5]]
    plate = samples[0].plate
    mesh = samples[0].mesh
    z_range = _shown_length(plate, samples[:3])
    width = np.ptp(plate.outline[:, 0]) / style.MILLIMETRE
    wide = (z_range[1] - z_range[0]) / width < 0.7
    shown = samples if wide else samples[:3]
    size = (style.PAGE_WIDTH, 1.8 + 2 * 3.0 * (z_range[1] - z_range[0]) / width) if wide else (2.4 * (1 + len(shown)), min(4.2, 1.4 + 1.9 * (z_range[1] - z_range[0]) / width))
    figure, panels = pyplot.subplots(*((2, 3) if wide else (1, 1 + len(shown))), figsize=size, layout="constrained",
                                     squeeze=False)
    for panel in panels.ravel():
        draw_plate(panel, plate, z_range)
        panel.tick_params(labelsize=8)
        panel.set_xlabel("y [mm]", fontsize=8)
    for panel in panels[:, 0]:
        panel.set_ylabel("z [mm]", fontsize=8)
    first, *others = panels.ravel()
    hidden = _time_bar(figure, first, time_colours(0))  # keeps the panel level with the others
    hidden.ax.set_axis_off()
    hidden.solids.set_visible(False)
    first.triplot(*mesh["nodes"][:, 1:].T / style.MILLIMETRE, mesh["boundary"][mesh["boundary_surface"] == 0], color=style.OUTLINE, linewidth=0.12)
    first.set_title(f"mesh, {len(mesh['tetrahedra']):,} tetrahedra", fontsize=9)
    for panel, sample, load in zip(others, shown, breaking_loads(ensemble)):
        surface = sample.crack_surface
        time, times = (_load_time(sample), MS) if quasi_static else (np.where(surface.time < SLOW, surface.time, -1), US)
        fast = time[time >= 0]
        colours = time_colours(float(np.quantile(fast, COLOURED)) if len(fast) else 0, times)
        if sample.regions is not None:
            draw_regions(panel, sample.regions, plate.lengths)
        if len(time):
            undrawn = np.zeros(len(time), int)
            facets = CrackSurface(surface.corners.values, time, notch=undrawn, tetrahedron=undrawn, phase_end=np.inf)
            draw_facets(panel, facets, colours, times=times)
        if rings:
            draw_rings(panel, projected_branching(sample)[["y", "z"]].to_numpy())
        _time_bar(figure, panel, colours, times)
        panel.set_title(f"sample {sample.number}" + (f": {load:.0f} N" if load > 0 else ""), fontsize=9)
    for panel in others[len(shown):]:
        panel.remove()
    write_light_figure(figure, picture, DPI)
    pyplot.close(figure)


def draw_measured(picture: Path, ensemble: Ensemble, experiments: Path) -> None:
    """A measured crack among those of all samples, the body lying on its side: the whole, and where they run."""
    samples = [ensemble[i] for i in ensemble.done]
    plate = samples[0].plate
    path = tomllib.loads(experiments.read_text())["experiment"][0]["path"]
    crack = pd.read_csv(experiments.parent / path, comment="#")
    around = [(crack[axis].min() - 3, crack[axis].max() + 3) for axis in ("z_mm", "y_mm")]
    figure, panels = pyplot.subplots(1, 2, figsize=(style.PAGE_WIDTH, 2.5), layout="constrained", width_ratios=(2, 3))
    lying_down = outline_path([polygon[:, ::-1] / style.MILLIMETRE for polygon in plate.polygons])
    for panel in panels:
        panel.add_patch(PathPatch(lying_down, facecolor=style.BODY, edgecolor=style.OUTLINE, linewidth=0.6))
        for sample in samples:
            for line in sample.crack_lines:
                before = line[line.time < 0]  # the onset is elsewhere: the plate parts behind the hole
                panel.plot(before.z / style.MILLIMETRE, before.y / style.MILLIMETRE, color=style.notch_colour(0), linewidth=0.8, alpha=0.35)
        panel.plot(crack.z_mm, crack.y_mm, color=style.BRANCHING, linewidth=2)
        panel.set_aspect("equal")
        panel.set_xlabel("z [mm]")
        panel.set_ylabel("y [mm]")
    (bottom, top), (left, right) = ((plate.outline[:, axis].min() / style.MILLIMETRE, plate.outline[:, axis].max() / style.MILLIMETRE) for axis in (0, 1))
    panels[0].set(xlim=(left - 14, right + 14), ylim=(bottom - 2, top + 2))
    for end, side in ((left, -1), (right, 1)):
        for y in np.linspace(bottom + 0.25 * (top - bottom), top - 0.25 * (top - bottom), 5):
            panels[0].annotate("", (end + side, y), (end + 12 * side, y), arrowprops={"arrowstyle": "-|>", "color": style.MUTED, "linewidth": 1})
    panels[1].set(xlim=around[0], ylim=around[1])
    panels[1].legend(handles=[Line2D([], [], color=style.BRANCHING, linewidth=2, label="measured"),
                              Line2D([], [], color=style.notch_colour(0), linewidth=1, label=f"{len(samples)} samples")], loc="lower left")
    write_light_figure(figure, picture, DPI)
    pyplot.close(figure)


def _load_time(sample: Sample) -> np.ndarray:
    """Time of the load at which the tetrahedron of each opened facet broke [s]."""
    at = sample.breaks.set_index("tetrahedron").load_time
    return at[~at.index.duplicated()].reindex(sample.crack_surface.tetrahedron.values).to_numpy()


def _time_bar(figure: Figure, panel: Axes, colours: Normalize, times: Unit = US) -> Colorbar:
    bar = figure.colorbar(ScalarMappable(colours, style.TIME_COLOURS), ax=panel, location="bottom", aspect=30, pad=0.02)
    bar.ax.tick_params(labelsize=8)
    bar.set_label(times.label("time"), fontsize=8)
    return bar


def _shown_length(plate: Plate, samples: list[Sample]) -> tuple[float, float]:
    """z of the whole body, or of one over four times as long as wide of what lies round its cracks [mm]."""
    if np.ptp(plate.outline[:, 1]) < 4 * np.ptp(plate.outline[:, 0]):
        return whole_length(plate)
    z = np.concatenate([sample.crack_surface.corners.values[:, :, 2].ravel() for sample in samples])
    return window(plate, [np.percentile(z, (2.5, 97.5))] if len(z) else [])


def draw_exponents(picture: Path, ensemble: Ensemble) -> None:
    """Load over toughness and over the notch's depth, each freed of what the other two random inputs do to it, and the handbook's loads."""
    load = onset_loads(ensemble)
    found, _ = exponents(ensemble, load)
    values = {key: drawn(ensemble, key) for key in (TOUGHNESS, MODULUS, DEPTH)}
    means = {key: float(one.mean()) for key, one in values.items()}
    figure, panels = pyplot.subplots(1, 2, figsize=(style.PAGE_WIDTH, 3.6), layout="constrained", sharey=True)
    for panel, shown, unit, name in zip(panels, (TOUGHNESS, DEPTH), (1.0, style.MILLIMETRE), ("toughness [J/m²]", "depth of the notch [mm]")):
        freed = load.copy()
        for key, power in zip((TOUGHNESS, MODULUS, DEPTH), found):
            if key != shown:
                freed *= (values[key] / means[key]) ** -power
        panel.plot(values[shown] / unit, freed, ".", color=style.notch_colour(0), label="samples; the other inputs at their means")
        line = np.linspace(values[shown].min(), values[shown].max(), 50)
        handbook = [handbook_load(*(at if key == shown else means[key] for key in (TOUGHNESS, MODULUS, DEPTH))) for at in line]
        panel.plot(line / unit, handbook, color="black", linewidth=1, label="handbook, for a sharp crack")
        panel.set_xlabel(name)
    panels[0].set_ylabel("load at the onset [N]")
    panels[0].set_ylim(bottom=0)
    panels[0].legend(fontsize=8, loc="lower right")
    write_light_figure(figure, picture, DPI)
    pyplot.close(figure)
