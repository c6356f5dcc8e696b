# SPDX-License-Identifier: GPL-3.0-or-later
"""The verification cases: each computes its samples and gives figures beside their references."""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import crackle
import numpy as np
from crackle.files import ENSEMBLE_KIND, results

from crackle_runs import JOBS, ROOT, median_range, run, with_keys
from figures import MILLIMETRE, Figure, mean, output_of
from problems import projected_branching

TRAVELS = (0.030, 0.035, 0.038, 0.040, 0.045, 0.050)  # of each long edge of the PMMA strip [mm]
STRIP_SPACINGS = (0.25, 0.17)  # [mm]


@dataclass(frozen=True)
class StripCrack:
    """What a crack did in the PMMA strip."""

    ran: bool  # through more than half of the strip
    n_branching: int  # in the projection
    angle: float  # between the branches of the first branching point [degrees]; NaN where there is none
    speed_there: float  # over Rayleigh's, on the way to it
    largest_speed: float  # the same, of all the way


FRONT_WINDOW = 2e-3  # [m] along a crack, over which its speed where it branches is measured


def _strip_crack(sample: crackle.Sample, tip: float, width: float) -> StripCrack:
    y = sample.crack_surface.corners.values[:, :, 1].mean(axis=1)
    ran = y.size > 0 and float(y.max()) > (tip + width) / 2
    seen, summary = projected_branching(sample), sample.summary
    angle = speed = math.nan
    if len(seen):
        first = seen.loc[seen.y.idxmin()]
        angle = math.degrees(first.angle)
        here = (y > first.y - FRONT_WINDOW) & (y <= first.y)
        # Slope of a line through the facets that opened there.
        slope = np.polyfit(y[here], sample.crack_surface.time.values[here], 1)[0] if here.sum() > 10 else math.nan
        speed = summary.crack_speed_ratio / summary.crack_speed_max / slope if slope > 0 else math.nan
    return StripCrack(ran, len(seen), angle, speed, float(summary.crack_speed_ratio))


def threshold(load: np.ndarray, branched: np.ndarray) -> str:
    """Load at which half of the samples branch, by logistic regression, and its 95 % interval by profile likelihood."""
    if branched.all() or not branched.any():
        return f"{'all' if branched.all() else 'none'} branch from {load.min():.3f} to {load.max():.3f} mm"
    extent = load.max() - load.min()
    grid = np.linspace(load.min() - 3 * extent, load.max() + 3 * extent, 2801)
    widths = np.geomspace(1e-3, 3, 250) * extent
    x = (load[:, None, None] - grid[None, :, None]) / widths[None, None, :]
    likelihood = -np.where(branched[:, None, None], np.logaddexp(0, -x), np.logaddexp(0, x)).sum(axis=0)
    profile = likelihood.max(axis=1)
    inside = grid[profile > profile.max() - 1.92]  # half of the 95 % quantile of chi squared with one degree of freedom
    best = grid[profile > profile.max() - 1e-6]  # a plateau where the shares jump from none to all
    low = f"{inside[0]:.4f}" if inside[0] > grid[0] else f"less than {grid[0]:.4f}"
    high = f"{inside[-1]:.4f}" if inside[-1] < grid[-1] else f"more than {grid[-1]:.4f}"
    return f"{best.mean():.4f} mm ({low} to {high})"


def pmma_strip(folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "pmma-strip.toml").read_text()
    case = f"Prestrained strip of PMMA, Bleyer et al. 2017, spacings {' and '.join(map(str, STRIP_SPACINGS))} mm"
    loads = ", ".join(f"{travel:.3f}" for travel in TRAVELS)
    figures = {f"samples that branch of those that crack, each edge moved by {loads} mm": "none up to 0.038 mm, all from 0.040 mm on",
               "edge displacement at which half of them branch (95 % interval)": "0.038 to 0.040 mm",
               "speed / c_R on the 2 mm before the first branching point": "0.55, Katzav et al. 2007",
               "angle between its branches": "some 30°",
               "largest speed / c_R, with branching": "0.6 to 0.7"}
    found = []
    for spacing in STRIP_SPACINGS:
        cracks: dict[float, list[StripCrack]] = {}
        for travel in TRAVELS:
            keys = {"mesh.spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{spacing} mm"'}
            assert "0.040 mm" in text
            setting = with_keys(text, keys).replace("0.040 mm", f"{travel:.3f} mm")
            samples = run(setting, folder / f"pmma-strip-{spacing}-{travel:.3f}", program)
            cracks[travel] = [_strip_crack(sample, 4 * MILLIMETRE, 32 * MILLIMETRE) for sample in samples]
        ran = [(travel, crack) for travel, some in cracks.items() for crack in some if crack.ran]
        branched = np.array([crack.n_branching > 0 for _, crack in ran])
        first = [crack for _, crack in ran if crack.n_branching > 0]
        found.append((", ".join(f"{sum(c.ran and c.n_branching > 0 for c in some)}/{sum(c.ran for c in some)}" for some in cracks.values()),
                      threshold(np.array([travel for travel, _ in ran]), branched), median_range([c.speed_there for c in first], ".2f"),
                      median_range([c.angle for c in first], ".0f", "°"), median_range([c.largest_speed for c in first], ".2f")))
    return [Figure(case, quantity, "; ".join(of_spacings), reference) for (quantity, reference), of_spacings in zip(figures.items(), zip(*found))]


def notched_strip(folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "notched-strip.toml").read_text()
    stress, half_width, thickness, modulus, nu = 1e6, 20e-3, 1e-3, 3300e6, 0.3
    depths = (7.5e-3, 8.5e-3)
    lengths = np.linspace(*depths, 201)
    k = stress * np.sqrt(np.pi * lengths / np.cos(np.pi * lengths / (2 * half_width)))
    expected = thickness * np.trapz(k ** 2, lengths) * (1 - nu ** 2) / modulus
    spacings, found = (0.5, 0.25, 0.125), []
    for spacing in spacings:
        energies = []
        for depth in depths:
            keys = {"mesh.notch_spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{2 * spacing} mm"',
                    "specimen.notch.depth": f'"{depth / MILLIMETRE} mm"', "ensemble.samples": "4"}
            samples = run(with_keys(text, keys), folder / f"notched-strip-{spacing}-{depth / MILLIMETRE}", program)
            energies.append([float(sample.energy.strain[-1]) for sample in samples])
        found.append(mean([math.sqrt((longer - shorter) / expected) for shorter, longer in zip(*energies)], ".3f"))
    return [Figure("Centre-notched strip, K from the energies of two depths",
                   f"K over the handbook's, spacings {', '.join(map(str, spacings))} mm at the tip", ", ".join(found), "1")]


TOUGHNESS = 30  # of slow growth [J/m^2]


def slow_growth(folder: Path, program: Path) -> list[Figure]:
    """A strip opened like a wedge, less and less ahead of the crack: it grows with the load, in equilibria."""
    text = re.sub(r"(?s)\[\[mesh\.region\]\].*?\n\n", "", (JOBS / "griffith-strip.toml").read_text())
    head, _ = text.split('[[boundary]]\non = "z-min"')
    tail = "[time]" + text.split("[time]")[1]
    parts = [(0.0, 16.0)] + [(16 + 1.25 * i, 16 + 1.25 * (i + 1)) for i in range(16)]  # [mm]
    loads = "".join(f'[[boundary]]\non = "{face}"\nfix = ["x", "y"]\n' for face in ("z-min", "z-max"))
    for low, high in parts:
        travel = 5e-4 * min(1, 1 - 0.7 * ((low + high) / 2 - 16) / 20)
        region = f'{{ y = ["{low + (1e-3 if low else 0)} mm", "{high} mm"] }}'
        for face, sign in (("z-min", "-"), ("z-max", "")):
            loads += (f'[[boundary]]\non = "{face}"\nregion = {region}\n'
                      f'displacement = ["free", "free", "{sign}{travel:.7g} mm"]\nhistory = [["0 s", 0], ["11 s", 11]]\n')
    keys = {"specimen.size": '["2 mm", "36 mm", "12 mm"]', "specimen.notch.at": '"6 mm"', "specimen.notch.depth": '"20 mm"',
            "mesh.spacing": '"1 mm"', "ensemble.samples": "3", "time.arrest": '"1 fs"', "sections.y": '["22 mm", "26 mm", "30 mm"]', "output.frames": "0"}
    samples = run(with_keys(head + loads + tail, keys), folder / "slow-growth", program)
    broken, lost = ([float(sample.energy[part][-1] / sample.summary.traced_area / TOUGHNESS) for sample in samples]
                    for part in ("released", "dissipated"))
    case = "Strip with toughness, opened like a wedge, all breaks quasi-static"
    return [Figure(case, "energy of broken tetrahedra over toughness times traced area", mean(broken, ".2f"), "0.7 to 0.8"),
            Figure(case, "energy lost before the next equilibrium, likewise", mean(lost, ".2f"), "the rest"),
            Figure(case, "both", mean([a + b for a, b in zip(broken, lost)], ".2f"), "1")]


BREAK = ["tetrahedron", "load_time", "phase_time"]
ENGINES = {"double": {"time.precision": '"double"'}, "mixed": {}, "petsc": {"time.engine": '"petsc"'}}


def engines(folder: Path, program: Path) -> list[Figure]:
    """The demo's plate by the fixed-point engine and by PETSc's matrix."""
    text = with_keys((ROOT / "jobs" / "demo.toml").read_text(), {"ensemble.samples": "16"})
    return compare_engines(text, folder, program)


def compare_engines(text: str, folder: Path, program: Path) -> list[Figure]:
    """The samples of an input by PETSc, against those by the fixed-point engine in both precisions."""
    found, paths = {}, {}
    for name, keys in ENGINES.items():
        found[name] = run(with_keys(text, keys), folder / f"engines-{name}", program)
        with results(found[name].folder / "ensemble.h5", ENSEMBLE_KIND) as root:
            paths[name] = root["statistics/z_mean"][:], root["statistics/z_half_width"][:]
    petsc, by = found.pop("petsc"), " and by ".join(f"`{name}`" for name in found)
    equal = [sum(a.breaks[BREAK].equals(b.breaks[BREAK]) for a, b in zip(petsc, other, strict=True)) for other in found.values()]
    counts = {"all breaks equal": equal}
    for title, key in (("load at the onset equal to the last bit", "onset_force"), ("pattern equal", "pattern")):
        pairs = [(petsc.samples[key], other.samples[key]) for other in found.values()]
        counts[title] = [((a == b) | (a.isna() & b.isna())).sum() for a, b in pairs]
    case = f"`engine = \"petsc\"` against fixed-point numbers, by {by}, {len(petsc)} samples"
    (mean, half_width), differences = paths["petsc"], []
    for name in found:
        difference = np.abs(mean - paths[name][0]) / half_width
        differences.append(f"{np.nanmax(difference):.1e}" if np.isfinite(difference).any() else "no path")
    return [*(Figure(case, title, ", ".join(f"{n} of {len(petsc)}" for n in of_engines), "all") for title, of_engines in counts.items()),
            Figure(case, "largest difference of a mean crack position, over its half width", ", ".join(differences), "below 1")]


def test_programs() -> list[Figure]:
    """Figures that the test programs print."""
    waves = output_of("verification.waves")
    lamb = output_of("verification.lamb")
    calculix = output_of("verification.calculix")
    figures = []
    orders = [re.search(rf"{name} wave: from ([\d.]+ to [\d.]+ mm) order ([\d.]+)", waves) for name in "PS"]
    figures.append(Figure("Plane P and S waves of 24 mm", f"order of convergence in space, {orders[0][1]}", ", ".join(order[2] for order in orders), "2"))
    spacings, *found = zip(*re.findall(r"spacing ([\d.]+) mm: .* ([\d.]+) %, largest ([\d.]+) %", lamb))
    whats = f"rms difference of the surface's motion, spacings {', '.join(spacings)} mm", "largest difference, likewise"
    figures += [Figure("Lamb's problem, closed form of Pekeris and Mooney", what, ", ".join(of_spacings) + " %", "0")
                for what, of_spacings in zip(whats, found)]
    match = re.search(r"displacement within ([\d.e+-]+) of", calculix)
    figures.append(Figure("Growing load on a notched plate, CalculiX on the same mesh",
                          "largest difference of the corner's displacement",
                          f"{100 * float(match.group(1)):.2f} %" if match else "not found", "at most 1 %"))
    return figures
