# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's pictures."""
from __future__ import annotations

from pathlib import Path
from typing import Callable

import h5py
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.cm import ScalarMappable  # noqa: E402
from matplotlib.colorbar import Colorbar  # noqa: E402
from matplotlib.colors import Normalize  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
import numpy as np  # noqa: E402

from crackle_report import style  # noqa: E402
from crackle_report.drawing import draw_facets, draw_plate, draw_rings, time_colours  # noqa: E402
from crackle_report.plate import Plate  # noqa: E402
from crackle_report.results import CrackSurface  # noqa: E402
from crackle_report.writing import write_light_figure  # noqa: E402
from crackle_runs import Sample  # noqa: E402
from problems import DEPTH, MODULUS, TOUGHNESS, drawn, exponents, handbook_load, onset_loads  # noqa: E402


def breaking_load(sample: Sample) -> float:
    """The largest, or where dynamics started from rest that at the first break [N]."""
    summary = sample.summary
    return float(summary["peak_load"] if np.isfinite(summary["onset_force"]) else summary["first_break_load"])


def _ring_pressure(load: float) -> str:
    """The load of a pressure is the sum of the forces' magnitudes along both axes, 4 r t p."""
    return f"{load / (4 * 11e-3 * 3e-3) / 1e6:.1f} MPa"


# What a title says of the load; strip and glass plate are under the same one in all samples.
LOADS: dict[str, Callable[[float], str]] = {
    "ring": _ring_pressure, "offset-notch": lambda load: f"first break at {load:.0f} N", "pmma-strip": lambda load: "", "glass-plate": lambda load: ""}

BRANCHED = ("paper-plate", "pmma-strip", "glass-plate")  # of which branching points are counted

style.apply()
DPI = 130
SLOW = 0.1  # s after the onset: a dynamic phase is over, and what opens later does so while the load grows
COLOURED = 0.99  # of a sample's facets; some late ones would make all others dark


def draw(name: str, picture: Path, results: Path, samples: list[Sample]) -> None:
    """The picture of a body of the gallery."""
    if name == "uncertain-strip":
        draw_exponents(picture, samples)
    else:
        draw_cracks(picture, results, samples, LOADS.get(name, lambda load: f"{load:.0f} N"), name in BRANCHED)


def draw_cracks(picture: Path, results: Path, samples: list[Sample], load_text: Callable[[float], str], rings: bool = False) -> None:
    """The mesh of the first sample on the side x = 0, and the cracks of the first samples; of a long body the part that breaks.

    @param rings: round the branching points in the projection
    """
    with h5py.File(sorted((results / "samples").glob("*.h5"))[0]) as root:
        plate = Plate.of({name: values[...] for name, values in root["specimen"].items()})
        triangles = root["mesh/boundary"][...][root["mesh/boundary_surface"][...] == 0]
        nodes = root["mesh/nodes"][:, 1:] / style.MILLIMETRE
        n_tetrahedra = len(root["mesh/tetrahedra"])
    z_range = _shown_length(plate, samples[:3])
    width = np.ptp(plate.outline[:, 0]) / style.MILLIMETRE
    wide = (z_range[1] - z_range[0]) / width < 0.7
    shown = samples[:5 if wide else 3]
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
    first.triplot(nodes[:, 0], nodes[:, 1], triangles, color=style.OUTLINE, linewidth=0.12)
    first.set_title(f"mesh, {n_tetrahedra:,} tetrahedra", fontsize=9)
    for number, (panel, sample) in enumerate(zip(others, shown)):
        time = np.where(sample.facet_time < SLOW, sample.facet_time, -1)
        fast = time[time >= 0]
        colours = time_colours(float(np.quantile(fast, COLOURED)) if len(fast) else 0)
        if len(time):
            draw_facets(panel, CrackSurface(sample.facet_corners, time, np.zeros(len(time), int)), colours)
        if rings:
            draw_rings(panel, sample.forks["position"][sample.projected_branching])
        _time_bar(figure, panel, colours)
        load = breaking_load(sample)
        text = load_text(load) if np.isfinite(load) and load else ""
        panel.set_title(f"sample {number}" + (f": {text}" if text else ""), fontsize=9)
    for panel in others[len(shown):]:
        panel.remove()
    write_light_figure(figure, picture, DPI)
    pyplot.close(figure)


def _time_bar(figure: Figure, panel: Axes, colours: Normalize) -> Colorbar:
    bar = figure.colorbar(ScalarMappable(colours, style.TIME_COLOURS), ax=panel, location="bottom", aspect=30, pad=0.02)
    bar.ax.tick_params(labelsize=8)
    bar.set_label("time [µs]", fontsize=8)
    return bar


def _shown_length(plate: Plate, samples: list[Sample]) -> tuple[float, float]:
    """z of the whole body, or of a body four times as long as wide of what lies round its cracks [mm]."""
    low, high = plate.outline.min(axis=0) / style.MILLIMETRE, plate.outline.max(axis=0) / style.MILLIMETRE
    margin = 0.03 * (high[1] - low[1])
    if high[1] - low[1] < 4 * (high[0] - low[0]):
        return low[1] - margin, high[1] + margin
    z = np.concatenate([sample.facet_corners[:, :, 2].ravel() for sample in samples]) / style.MILLIMETRE
    middle = np.median(z) if len(z) else (low[1] + high[1]) / 2
    width = high[0] - low[0]
    reach = np.percentile(np.abs(z - middle), 95) if len(z) else 0.0
    half = max(0.7 * width, reach + 0.3 * width)
    return middle - half, middle + half


def draw_exponents(picture: Path, samples: list[Sample]) -> None:
    """Load over toughness and over the notch's depth, each freed of what the other two random inputs do to it, and the handbook's loads."""
    load = onset_loads(samples)
    found, _ = exponents(samples, load)
    values = {key: drawn(samples, key) for key in (TOUGHNESS, MODULUS, DEPTH)}
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
