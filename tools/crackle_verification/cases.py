# SPDX-License-Identifier: GPL-3.0-or-later
"""The verification cases: each computes its samples and gives figures beside their references."""
from __future__ import annotations

import math
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .runs import JOBS, ROOT, RunError, Sample, read, run, with_keys

MILLIMETRE, MICROSECOND = 1e-3, 1e-6


@dataclass(frozen=True)
class Figure:
    case: str
    quantity: str
    found: str
    reference: str


def _mean(values: list[float], form: str) -> str:
    """Mean and standard deviation."""
    return f"{np.mean(values):{form}} ± {np.std(values, ddof=1):{form}}" if len(values) > 1 else f"{values[0]:{form}}"


def glass_plate(folder: Path, program: Path) -> list[Figure]:
    case = "Glass plate, Borden et al. 2012"
    sample, = run((JOBS / "glass-plate.toml").read_text(), folder / "glass-plate", program)
    y, z = sample.facet_corners[:, :, 1].mean(axis=1), sample.facet_corners[:, :, 2].mean(axis=1)
    time = sample.facet_time
    is_advance = y > 51 * MILLIMETRE
    branching = _branching(y, z, time)
    arrival = time[y > 99 * MILLIMETRE]
    return [
        Figure(case, "start of the crack", f"{time[is_advance].min() / MICROSECOND:.0f} µs", "about 10 µs"),
        Figure(case, "branchings, short arms included", f"{int(sample.summary['bifurcations'])}", "1"),
        Figure(case, "branching for good", "none" if branching is None else
               f"{branching[0] / MICROSECOND:.0f} µs, at y = {branching[1] / MILLIMETRE:.0f} mm", "about 33 µs"),
        Figure(case, "arrival at the far edge",
               f"{arrival.min() / MICROSECOND:.0f} µs" if arrival.size else "not within 90 µs", "about 75 µs"),
        Figure(case, "largest speed over Rayleigh's (2125 m/s)", f"{sample.summary['crack_speed_ratio']:.2f}",
               "below 0.6"),
        Figure(case, "released energy per traced area", f"{sample.summary['effective_toughness']:.2f} J/m²",
               "3 J/m²"),
    ]


def _branching(y: np.ndarray, z: np.ndarray, time: np.ndarray) -> tuple[float, float] | None:
    """When and where the crack parts for good: from there on facets are over 2 mm apart across the plate.

    The time is that at which the second of the two branches opens its first millimetre.
    """
    width = 1 * MILLIMETRE
    edges = np.arange(50 * MILLIMETRE, 100 * MILLIMETRE, width)
    parted = []
    for low in edges:
        here = np.sort(z[(y >= low) & (y < low + width)])
        gaps = np.diff(here)
        parted.append(here.size > 3 and gaps.size > 0 and gaps.max() > 2 * MILLIMETRE)
    # The first of five neighbouring bins that all are parted.
    for i in range(len(edges) - 5):
        if all(parted[i:i + 5]):
            inside = (y >= edges[i]) & (y < edges[i] + width)
            middle = (z[inside].min() + z[inside].max()) / 2
            lower, upper = inside & (z < middle), inside & (z >= middle)
            return max(time[lower].min(), time[upper].min()), float(edges[i])
    return None


def notched_strip(folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "notched-strip.toml").read_text()
    stress, half_width, thickness, modulus, nu = 1e6, 20e-3, 1e-3, 3300e6, 0.3
    depths = (7.5e-3, 8.5e-3)
    lengths = np.linspace(*depths, 201)
    k = stress * np.sqrt(np.pi * lengths / np.cos(np.pi * lengths / (2 * half_width)))
    expected = thickness * np.trapz(k ** 2, lengths) * (1 - nu ** 2) / modulus
    figures = []
    for spacing in (0.5, 0.25, 0.125):
        energies = []
        for depth in depths:
            keys = {"mesh.notch_spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{2 * spacing} mm"',
                    "specimen.notch.depth": f'"{depth / MILLIMETRE} mm"', "ensemble.samples": "4"}
            samples = run(with_keys(text, keys), folder / f"notched-strip-{spacing}-{depth / MILLIMETRE}", program)
            energies.append([float(sample.energy["strain"][-1]) for sample in samples])
        ratios = [math.sqrt((longer - shorter) / expected) for shorter, longer in zip(*energies)]
        figures.append(Figure("Centre-notched strip, K from the energies of two depths",
                              f"K over the handbook's, spacing {spacing} mm at the tip", _mean(ratios, ".3f"), "1"))
    return figures


def griffith_strip(folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "griffith-strip.toml").read_text()
    toughness, height, modulus, nu, rate = 30, 12e-3, 32e9, 0.2, 1e-6
    uniaxial = modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    travel = math.sqrt(2 * toughness * height / uniaxial)
    figures = []
    for spacing in (1.0, 0.75, 0.5):
        keys = {"mesh.spacing": f'"{spacing} mm"', "ensemble.samples": "4"}
        samples = run(with_keys(text, keys), folder / f"griffith-strip-{spacing}", program)
        loads = [float(sample.summary["onset_time"]) * rate / travel for sample in samples]
        energy = [float(sample.summary["effective_toughness"]) / toughness for sample in samples]
        case = "Strip with toughness, loaded slowly"
        figures.append(Figure(case, f"load at run-away over Griffith's, spacing {spacing} mm", _mean(loads, ".2f"), "1"))
        figures.append(Figure(case, f"released energy per traced area over the toughness, spacing {spacing} mm",
                              _mean(energy, ".2f"), "1"))
    return figures


def test_programs(build: Path) -> list[Figure]:
    """Figures that the test programs print."""
    waves = _output(build / "bin" / "test_waves")
    calculix = _output(build / "bin" / "test_calculix")
    figures = []
    for name in ("P", "S"):
        orders = re.findall(rf"{name} wave, .* order ([\d.]+)", waves)
        figures.append(Figure(f"Plane {name} wave", "order of convergence in space", ", ".join(orders), "2"))
    match = re.search(r"displacement within ([\d.e+-]+) of", calculix)
    figures.append(Figure("Growing load on a notched plate, CalculiX on the same mesh",
                          "largest difference of the corner's displacement",
                          f"{100 * float(match.group(1)):.2f} %" if match else "not found", "at most 1 %"))
    return figures


def _output(program: Path) -> str:
    if not program.is_file():
        raise RunError(f"there is no {program}; run tools/build ci first")
    done = subprocess.run([str(program)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RunError(f"{program.relative_to(ROOT)} failed:\n{done.stdout[-2000:]}")
    return done.stdout


def draw_crack(sample: Path, picture: Path) -> None:
    """The crack of a plate in its plane, coloured by the time at which it opened."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    found = read(sample)
    size = found.parameters["specimen"]["size"]
    figure, axes = pyplot.subplots(figsize=(9, 3.9), dpi=110)
    centre = found.facet_corners.mean(axis=1) / MILLIMETRE
    points = axes.scatter(centre[:, 1], centre[:, 2], c=found.facet_time / MICROSECOND, s=1.5, cmap="viridis")
    axes.set(xlim=(0, float(size[1].split()[0])), ylim=(0, float(size[2].split()[0])), xlabel="y [mm]", ylabel="z [mm]",
             aspect="equal")
    notch = found.parameters["specimen"]["notch"][0]
    axes.plot([0, float(notch["depth"].split()[0])], [float(notch["at"].split()[0])] * 2, color="black", linewidth=1)
    figure.colorbar(points, label="opened after [µs]", shrink=0.85)
    figure.savefig(picture, bbox_inches="tight", metadata={"Software": None})
    pyplot.close(figure)


def table(figures: list[Figure]) -> str:
    lines = ["| case | figure | found | reference |", "|---|---|---|---|"]
    previous = ""
    for figure in figures:
        lines.append(f"| {figure.case if figure.case != previous else ''} | {figure.quantity} | {figure.found} | "
                     f"{figure.reference} |")
        previous = figure.case
    return "\n".join(lines) + "\n"


__all__ = ["Figure", "Sample", "draw_crack", "glass_plate", "griffith_strip", "notched_strip", "table", "test_programs"]
