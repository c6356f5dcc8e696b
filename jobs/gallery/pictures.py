# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's pictures."""
from __future__ import annotations

from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
import numpy as np  # noqa: E402

from crackle_report import style  # noqa: E402
from crackle_report.drawing import draw_facets, draw_plate, time_colours  # noqa: E402
from crackle_report.plate import Plate  # noqa: E402
from crackle_report.results import CrackSurface  # noqa: E402
from crackle_report.writing import write_light_figure  # noqa: E402
from crackle_runs import Sample  # noqa: E402
from problems import MILLIMETRE, depth_exponent, exponents  # noqa: E402


def breaking_load(sample: Sample) -> float:
    """The largest, or where dynamics started from rest that at the first break [N]."""
    summary = sample.summary
    return float(summary["peak_load"] if np.isfinite(summary["onset_force"]) else summary["first_break_load"])


style.apply()
DPI = 100


def draw_cracks(picture: Path, results: Path, samples: list[Sample]) -> None:
    """The mesh of the first sample on the side x = 0, and the cracks of the first three; of a long body the part that breaks."""
    shown = samples[:3]
    with h5py.File(sorted((results / "samples").glob("*.h5"))[0]) as root:
        plate = Plate.of({name: values[...] for name, values in root["specimen"].items()})
        triangles = root["mesh/boundary"][...][root["mesh/boundary_surface"][...] == 0]
        nodes = root["mesh/nodes"][:, 1:] / style.MILLIMETRE
        n_tetrahedra = len(root["mesh/tetrahedra"])
    z_range = _shown_length(plate, shown)
    width = np.ptp(plate.outline[:, 0]) / style.MILLIMETRE
    wide = (z_range[1] - z_range[0]) / width < 0.7
    size = (8.8, 0.75 + 4.4 * (z_range[1] - z_range[0]) / width * 2) if wide else (2.2 * (1 + len(shown)), 3.2)
    figure, panels = pyplot.subplots(*((2, 2) if wide else (1, 1 + len(shown))), figsize=size, layout="constrained",
                                     squeeze=False)
    for panel in panels.ravel():
        draw_plate(panel, plate, z_range)
        panel.tick_params(labelsize=6)
        panel.set_xlabel("y [mm]", fontsize=6)
    for panel in panels[:, 0]:
        panel.set_ylabel("z [mm]", fontsize=6)
    first, *others = panels.ravel()
    first.triplot(nodes[:, 0], nodes[:, 1], triangles, color=style.OUTLINE, linewidth=0.15)
    first.set_title(f"mesh, {n_tetrahedra:,} tetrahedra", fontsize=7)
    for number, (panel, sample) in enumerate(zip(others, shown)):
        time = sample.facet_time
        if len(time):
            draw_facets(panel, CrackSurface(sample.facet_corners, time, np.zeros(len(time), int)), time_colours(float(time.max())))
        load = breaking_load(sample)
        panel.set_title(f"sample {number}" + (f": {load:.0f} N" if np.isfinite(load) and load else ""), fontsize=7)
    for panel in others[len(shown):]:
        panel.set_axis_off()
    write_light_figure(figure, picture, DPI)
    pyplot.close(figure)


def _shown_length(plate: Plate, samples: list[Sample]) -> tuple[float, float]:
    """z of the whole body, or of a body four times as long as wide of what lies a width round its cracks [mm]."""
    low, high = plate.outline.min(axis=0) / style.MILLIMETRE, plate.outline.max(axis=0) / style.MILLIMETRE
    margin = 0.03 * (high[1] - low[1])
    if high[1] - low[1] < 4 * (high[0] - low[0]):
        return low[1] - margin, high[1] + margin
    z = np.concatenate([sample.facet_corners[:, :, 2].ravel() for sample in samples]) / style.MILLIMETRE
    middle = np.median(z) if len(z) else (low[1] + high[1]) / 2
    half = 0.7 * (high[0] - low[0])
    return middle - half, middle + half


def draw_exponent(picture: Path, _: Path, samples: list[Sample]) -> None:
    """Load over the notch's depth, freed of what toughness and modulus do to it, with the handbook's slope."""
    load = np.array([breaking_load(sample) for sample in samples])
    depth = np.array([sample.inputs["specimen.notch[0].depth"] for sample in samples]) / MILLIMETRE
    found, _ = exponents(samples)
    freed = load.copy()
    for key, power in zip(("fracture.toughness", "material.youngs_modulus"), found):
        values = np.array([sample.inputs[key] for sample in samples])
        freed *= (values / values.mean()) ** -power
    figure, (first, second) = pyplot.subplots(1, 2, figsize=(8.8, 3.2), layout="constrained", sharey=True)
    first.plot([sample.inputs["fracture.toughness"] for sample in samples], load, ".", color=style.notch_colour(0))
    first.set_xlabel("toughness [J/m²]")
    first.set_ylabel("load at the onset [N]")
    line = np.linspace(depth.min(), depth.max(), 50)
    middle = np.exp(np.log(freed).mean() + depth_exponent() * (np.log(line) - np.log(depth).mean()))
    second.plot(depth, freed, ".", color=style.notch_colour(0), label="samples, at the mean toughness and modulus")
    second.plot(line, middle, color="black", linewidth=1, label=f"handbook's exponent, {depth_exponent():.2f}")
    second.set_xlabel("depth of the notch [mm]")
    second.legend(fontsize=7)
    write_light_figure(figure, picture, DPI)
    pyplot.close(figure)
