# SPDX-License-Identifier: GPL-3.0-or-later
"""The verification cases: each computes its samples and gives figures beside their references."""
from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from crackle_runs import JOBS, ROOT, Sample, front_speed, median_range, run, with_keys
from figures import MICROSECOND, MILLIMETRE, Figure, mean, output_of


@dataclass(frozen=True)
class GlassPlate:
    """What a crack did in the glass plate; times in microseconds, None for what did not happen."""

    start: float | None  # the crack has grown by 1 mm
    branching: float | None
    arrival: float | None  # 1 mm before the far edge
    speed: float  # largest, over Rayleigh's
    energy: float  # released energy per traced area [J/m^2]
    sample: Sample


def _glass_plates(text: str, folder: Path, program: Path) -> list[GlassPlate]:
    plates = []
    for sample in run(text, folder, program):
        y, z = sample.facet_corners[:, :, 1].mean(axis=1), sample.facet_corners[:, :, 2].mean(axis=1)

        def passing(place: float) -> float | None:
            time = sample.passing_time(place * MILLIMETRE)
            return None if time is None else time / MICROSECOND

        branching = _branching(y, z, sample.facet_time)
        plates.append(GlassPlate(passing(51), branching / MICROSECOND if branching else None, passing(99),
                                 float(sample.summary["crack_speed_ratio"]),
                                 float(sample.summary["effective_toughness"]), sample))
    return plates


def glass_plate(folder: Path, program: Path) -> list[Figure]:
    plates = _glass_plates((JOBS / "glass-plate.toml").read_text(), folder / "glass-plate", program)
    case = f"Glass plate, Borden et al. 2012; median (range) of {len(plates)} samples"
    short = [int(plate.sample.summary["bifurcations"]) for plate in plates]
    return [
        Figure(case, "the crack has grown by 1 mm", median_range([p.start for p in plates], ".0f", " µs"), "about 10 µs"),
        Figure(case, "branching for good", median_range([p.branching for p in plates], ".0f", " µs"), "about 33 µs"),
        Figure(case, "branchings, short arms included", median_range(short, ".0f"), "1"),
        Figure(case, "arrival at the far edge", median_range([p.arrival for p in plates], ".0f", " µs"), "about 75 µs"),
        Figure(case, "largest speed / c_R (2125 m/s)", median_range([p.speed for p in plates], ".2f"), "below 0.6"),
        Figure(case, "energy of broken tetrahedra per traced area", median_range([p.energy for p in plates], ".2f", " J/m²"),
               "some 2 J/m², 0.7 of 3"),
    ]


def _branching(y: np.ndarray, z: np.ndarray, time: np.ndarray) -> float | None:
    """When the crack parts for good: from there on facets are over 2 mm apart across the plate.

    That is when the second of the two branches opens its first millimetre.
    """
    width = 1 * MILLIMETRE
    edges = np.arange(50 * MILLIMETRE, 100 * MILLIMETRE, width)
    parted = []
    for low in edges:
        here = np.sort(z[(y >= low) & (y < low + width)])
        gaps = np.diff(here)
        parted.append(here.size > 3 and gaps.size > 0 and gaps.max() > 2 * MILLIMETRE)
    # The first of five neighbouring bins that all are parted.
    for i in range(len(edges) - 4):
        if all(parted[i:i + 5]):
            inside = (y >= edges[i]) & (y < edges[i] + width)
            middle = (z[inside].min() + z[inside].max()) / 2
            lower, upper = inside & (z < middle), inside & (z >= middle)
            return float(max(time[lower].min(), time[upper].min()))
    return None


TRAVELS = (0.030, 0.035, 0.038, 0.040, 0.045, 0.050)  # of each long edge of the PMMA strip [mm]
STRIP_SPACINGS = (0.25, 0.17)  # [mm]


@dataclass(frozen=True)
class StripCrack:
    """What a crack did in the PMMA strip."""

    ran: bool  # through more than half of the strip
    forks: int  # in the projection
    angle: float  # between the arms of the first fork [degrees]; NaN where there is none
    speed_there: float  # over Rayleigh's, on the way to it
    largest_speed: float  # the same, of all the way


def _strip_crack(sample: Sample, tip: float, width: float) -> StripCrack:
    y = sample.facet_corners[:, :, 1].mean(axis=1)
    ran = y.size > 0 and float(y.max()) > (tip + width) / 2
    seen = sample.projected_forks
    angle = speed = math.nan
    if seen.size:
        first = seen[np.argmin(sample.forks["position"][seen, 0])]
        angle = math.degrees(sample.forks["angle"][first])
        speed = front_speed(y, sample.facet_time, float(sample.forks["position"][first, 0])) * sample.summary["crack_speed_ratio"] / sample.summary["crack_speed_max"]
    return StripCrack(ran, seen.size, angle, speed, float(sample.summary["crack_speed_ratio"]))


def threshold(load: np.ndarray, forked: np.ndarray) -> str:
    """Load at which half of the samples fork, by logistic regression, and its 95 % interval by profile likelihood."""
    if forked.all() or not forked.any():
        return f"{'all' if forked.all() else 'none'} fork from {load.min():.3f} to {load.max():.3f} mm"
    extent = load.max() - load.min()
    grid = np.linspace(load.min() - 3 * extent, load.max() + 3 * extent, 2801)
    widths = np.geomspace(1e-3, 3, 250) * extent
    x = (load[:, None, None] - grid[None, :, None]) / widths[None, None, :]
    likelihood = -np.where(forked[:, None, None], np.logaddexp(0, -x), np.logaddexp(0, x)).sum(axis=0)
    profile = likelihood.max(axis=1)
    inside = grid[profile > profile.max() - 1.92]  # half of the 95 % quantile of chi squared with one degree of freedom
    best = grid[profile > profile.max() - 1e-6]  # a plateau where the shares jump from none to all
    low = f"{inside[0]:.4f}" if inside[0] > grid[0] else f"less than {grid[0]:.4f}"
    high = f"{inside[-1]:.4f}" if inside[-1] < grid[-1] else f"more than {grid[-1]:.4f}"
    return f"{best.mean():.4f} mm ({low} to {high})"


def _strip_folder(folder: Path, spacing: float, travel: float) -> Path:
    return folder / f"pmma-strip-{spacing}-{travel:.3f}"


def pmma_strip(folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "pmma-strip.toml").read_text()
    figures = []
    for spacing in STRIP_SPACINGS:
        cracks: dict[float, list[StripCrack]] = {}
        case = f"Prestrained strip of PMMA, Bleyer et al. 2017, spacing {spacing} mm"
        for travel in TRAVELS:
            keys = {"mesh.spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{spacing} mm"'}
            assert "0.040 mm" in text
            setting = with_keys(text, keys).replace("0.040 mm", f"{travel:.3f} mm")
            samples = run(setting, _strip_folder(folder, spacing, travel), program)
            cracks[travel] = [_strip_crack(sample, 4 * MILLIMETRE, 32 * MILLIMETRE) for sample in samples]
        ran = [(travel, crack) for travel, some in cracks.items() for crack in some if crack.ran]
        forked = np.array([crack.forks > 0 for _, crack in ran])
        shares = ", ".join(f"{sum(c.ran and c.forks > 0 for c in some)}/{sum(c.ran for c in some)}"
                           for some in cracks.values())
        loads = ", ".join(f"{travel:.3f}" for travel in TRAVELS)
        first = [crack for _, crack in ran if crack.forks > 0]
        figures += [
            Figure(case, f"samples with forks of those that crack, each edge moved by {loads} mm", shares,
                   "none up to 0.038 mm, all from 0.040 mm on"),
            Figure(case, "edge displacement at which half of them fork (95 % interval)", threshold(np.array([travel for travel, _ in ran]), forked),
                   "0.038 to 0.040 mm"),
            Figure(case, "speed / c_R on the 2 mm before the first fork", median_range([c.speed_there for c in first], ".2f"),
                   "0.55, Katzav et al. 2007"),
            Figure(case, "angle between its arms", median_range([c.angle for c in first], ".0f", "°"), "some 30°"),
            Figure(case, "largest speed / c_R, with forks", median_range([c.largest_speed for c in first], ".2f"), "0.6 to 0.7"),
        ]
    return figures


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
                              f"K over the handbook's, spacing {spacing} mm at the tip", mean(ratios, ".3f"), "1"))
    return figures


TOUGHNESS, STRIP_HEIGHT = 30, 12e-3  # of slow growth [J/m^2, m]


def _griffith_travel() -> float:
    """At which a strip between rigid grips holds the toughness for each area ahead of the crack [m]."""
    modulus, nu = 32e9, 0.2
    uniaxial = modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    return math.sqrt(2 * TOUGHNESS * STRIP_HEIGHT / uniaxial)


def _wedge(y: float) -> float:
    """Share of the opening that the grips of the slow growth have at y [mm]."""
    return min(1, 1 - 0.7 * (y - 16) / 20)


def slow_growth(folder: Path, program: Path) -> list[Figure]:
    """A strip opened like a wedge, less and less ahead of the crack: it grows with the load, in equilibria."""
    text = re.sub(r"(?s)\[\[mesh\.region\]\].*?\n\n", "", (JOBS / "griffith-strip.toml").read_text())
    head, _ = text.split('[[boundary]]\non = "z-min"')
    tail = "[time]" + text.split("[time]")[1]
    parts = [(0.0, 16.0)] + [(16 + 1.25 * i, 16 + 1.25 * (i + 1)) for i in range(16)]  # [mm]
    loads = "".join(f'[[boundary]]\non = "{face}"\nfix = ["x", "y"]\n' for face in ("z-min", "z-max"))
    for low, high in parts:
        travel = 5e-4 * _wedge((low + high) / 2)
        region = f'{{ y = ["{low + (1e-3 if low else 0)} mm", "{high} mm"] }}'
        for face, sign in (("z-min", "-"), ("z-max", "")):
            loads += (f'[[boundary]]\non = "{face}"\nregion = {region}\n'
                      f'displacement = ["free", "free", "{sign}{travel:.7g} mm"]\nhistory = [["0 s", 0], ["11 s", 11]]\n')
    keys = {"specimen.size": '["2 mm", "36 mm", "12 mm"]', "specimen.notch.at": '"6 mm"', "specimen.notch.depth": '"20 mm"',
            "mesh.spacing": '"1 mm"', "ensemble.samples": "3", "time.arrest": '"1 fs"', "sections.y": '["22 mm", "26 mm", "30 mm"]', "output.frames": "0"}
    samples = run(with_keys(head + loads + tail, keys), folder / "slow-growth", program)
    broken, lost = ([float(sample.energy[part][-1]) / float(sample.summary["traced_area"]) / TOUGHNESS
                     for sample in samples] for part in ("released", "dissipated"))
    jumps = [jump for file in sorted((folder / "slow-growth" / "out" / "samples").glob("*.h5")) for jump in _jumps(file)]
    case = "Strip with toughness, opened like a wedge, all breaks quasi-static"
    return [Figure(case, "energy of broken tetrahedra over toughness times traced area", mean(broken, ".2f"), "0.7 to 0.8"),
            Figure(case, "energy lost before the next equilibrium, likewise", mean(lost, ".2f"), "the rest"),
            Figure(case, "both", mean([a + b for a, b in zip(broken, lost)], ".2f"), "1"),
            Figure(case, "energy release rate over toughness when the front jumps", mean([j[0] for j in jumps], ".2f"),
                   "1"),
            Figure(case, "the same when it stops", mean([j[1] for j in jumps], ".2f"), "below 1")]


def _jumps(file: Path) -> list[tuple[float, float]]:
    """Energy release rates over the toughness at the crack's front before and after it went on by over 1 mm at one load."""
    with h5py.File(file) as root:
        load_time = root["breaks/load_time"][:]
        nodes = root["mesh/tetrahedra"][:][root["breaks/tetrahedron"][:]]
        y = root["mesh/nodes"][:][nodes].mean(axis=1)[:, 1] / MILLIMETRE
    jumps, front = [], 20.0  # the notch's tip
    for time in np.unique(load_time):
        reached = max(front, float(np.sort(y[load_time <= time])[-5:].mean()))
        if reached > front + 1:
            jumps.append(tuple((time * 1e-6 * _wedge(place) / _griffith_travel()) ** 2 for place in (front, reached)))
        front = reached
    return jumps


ENGINES = {"double": {"time.precision": '"double"'}, "mixed": {}, "petsc": {"time.engine": '"petsc"'}}


def engines(folder: Path, program: Path) -> list[Figure]:
    """The demo's plate by the fixed-point engine and by PETSc's matrix."""
    text = with_keys((ROOT / "jobs" / "demo.toml").read_text(), {"ensemble.samples": "16"})
    return compare_engines(text, folder, program)


def compare_engines(text: str, folder: Path, program: Path) -> list[Figure]:
    """The samples of an input by PETSc, against those by the fixed-point engine in both precisions."""
    breaks, samples, paths = {}, {}, {}
    for name, keys in ENGINES.items():
        samples[name] = run(with_keys(text, keys), folder / f"engines-{name}", program)
        results = folder / f"engines-{name}" / "out"
        breaks[name] = [_breaks(file) for file in sorted((results / "samples").glob("*.h5"))]
        with h5py.File(results / "ensemble.h5") as root:
            paths[name] = root["statistics/z_mean"][:], root["statistics/z_half_width"][:]
    figures = []
    for name in ("double", "mixed"):
        case = f"`engine = \"petsc\"` against fixed-point numbers, `{name}`, {len(breaks[name])} samples"
        equal = [_equal_breaks(a, b) for a, b in zip(breaks["petsc"], breaks[name], strict=True)]
        parted = sorted(n for n in equal if n is not None)
        figures.append(Figure(case, "all breaks equal, in time and place",
                              f"{len(equal) - len(parted)} of {len(equal)}"
                              + (f"; the others up to break {', '.join(map(str, parted))}" if parted else ""), "all"))
        for title, key in (("load at the onset equal to the last bit", "onset_force"), ("pattern equal", "pattern")):
            n = sum(_same(a.summary[key], b.summary[key]) for a, b in zip(samples["petsc"], samples[name], strict=True))
            figures.append(Figure(case, title, f"{n} of {len(equal)}", "all"))
        (mean, half_width), (other, _) = paths["petsc"], paths[name]
        known = np.isfinite(mean) & np.isfinite(other) & np.isfinite(half_width)
        if known.any():
            figures.append(Figure(case, "largest difference of a mean crack position, over its half width",
                                  f"{np.max(np.abs(mean - other)[known] / half_width[known]):.1e}", "below 1"))
    return figures


def _same(a: float, b: float) -> bool:
    return bool(a == b or (np.isnan(a) and np.isnan(b)))


def _breaks(file: Path) -> np.ndarray:
    """Tetrahedron, load time and phase time of each break, in their order."""
    with h5py.File(file) as root:
        return np.stack([root[f"breaks/{name}"][:].astype(float) for name in ("tetrahedron", "load_time", "phase_time")], axis=1)


def _equal_breaks(a: np.ndarray, b: np.ndarray) -> int | None:
    """How many breaks are equal before the first that differs; None when all are."""
    n = min(len(a), len(b))
    different = np.flatnonzero((a[:n] != b[:n]).any(axis=1))
    if different.size:
        return int(different[0])
    return None if len(a) == len(b) else n


def test_programs() -> list[Figure]:
    """Figures that the test programs print."""
    waves = output_of("verification.waves")
    lamb = output_of("verification.lamb")
    calculix = output_of("verification.calculix")
    figures = []
    for name in ("P", "S"):
        order = re.search(rf"{name} wave: from ([\d.]+ to [\d.]+ mm) order ([\d.]+)", waves)
        figures.append(Figure(f"Plane {name} wave of 24 mm", f"order of convergence in space, {order.group(1)}",
                              order.group(2), "2"))
    for spacing, typical, worst in re.findall(r"spacing ([\d.]+) mm: .* ([\d.]+) %, largest ([\d.]+) %", lamb):
        figures.append(Figure("Lamb's problem, closed form of Pekeris and Mooney",
                              f"difference of the surface's motion, spacing {spacing} mm, rms and largest",
                              f"{typical} %, {worst} %", "0"))
    match = re.search(r"displacement within ([\d.e+-]+) of", calculix)
    figures.append(Figure("Growing load on a notched plate, CalculiX on the same mesh",
                          "largest difference of the corner's displacement",
                          f"{100 * float(match.group(1)):.2f} %" if match else "not found", "at most 1 %"))
    return figures
