# SPDX-License-Identifier: GPL-3.0-or-later
"""The prestrained strip of PMMA: speed, branching, width and energy of its cracks, with immediate release and with release in time."""
from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

import crackle
import numpy as np
from crackle.units import value_of

from crackle_runs import JOBS, median_range, run, with_keys
from figures import MILLIMETRE, Figure, mean
from problems import projected_branching

TRAVELS = (0.030, 0.035, 0.038, 0.040, 0.045, 0.050)  # of each long edge [mm]
PUBLISHED = 0.040  # from which on the strip's cracks branch [mm]
SPACINGS = {0.35: 8, 0.25: 8, 0.17: 4}  # [mm], and the number of samples
RELEASES = {"immediate release": '"0 s"', "release in 0.2 µs": '"0.2 us"'}
TIP, WIDTH, HEIGHT = 4 * MILLIMETRE, 32 * MILLIMETRE, 16 * MILLIMETRE
FRONT_WINDOW = 2 * MILLIMETRE  # along a crack, over which its speed where it branches is measured
BAND_WINDOW = 1 * MILLIMETRE  # along a crack, over which the width of its band is measured
QUARTILES = (0.25, 0.75)


@dataclass(frozen=True)
class StripCrack:
    """The crack of a sample."""

    ran: bool  # through more than half of the strip
    n_branching: int  # in the projection
    angle: float  # between the branches of the first branching point [degrees]; NaN where there is none
    speed_there: float  # over Rayleigh's, on the way to it; NaN where it is at the notch
    largest_speed: float  # over Rayleigh's, of all the way
    band: float  # median over the crack's way of the height between its outermost facets [mm]
    energy: float  # of broken tetrahedra per traced area [J/m^2]


def crack_of(sample: crackle.Sample) -> StripCrack:
    y, z = np.moveaxis(sample.crack_surface.corners.values[:, :, 1:].mean(axis=1), 1, 0)
    ran = y.size > 0 and float(y.max()) > (TIP + WIDTH) / 2
    seen, summary = projected_branching(sample), sample.summary
    angle = speed = math.nan
    if len(seen):
        first = seen.loc[seen.y.idxmin()]
        angle = math.degrees(first.angle)
        here = (y > first.y - FRONT_WINDOW) & (y <= first.y)
        # Slope of a line through the facets that opened there.
        has_run = first.y - FRONT_WINDOW > TIP and here.sum() > 10
        slope = np.polyfit(y[here], sample.crack_surface.time.values[here], 1)[0] if has_run else math.nan
        speed = summary.crack_speed_ratio / summary.crack_speed_max / slope if slope > 0 else math.nan
    places = np.arange(TIP + 2 * BAND_WINDOW, WIDTH - TIP, BAND_WINDOW)
    heights = [np.ptp(z[inside]) for inside in ((y >= place) & (y < place + BAND_WINDOW) for place in places) if inside.sum() > 5]
    return StripCrack(ran, len(seen), angle, speed, float(summary.crack_speed_ratio),
                      float(np.median(heights)) / MILLIMETRE if heights else math.nan, float(summary.effective_toughness))


def stored_energy(text: str, travel: float) -> float:
    """Strain energy of the uncracked strip per unit area of its middle plane, between two long grips in plane stress [J/m^2]."""
    material = tomllib.loads(text)["material"]
    modulus, nu = value_of(material["youngs_modulus"]), material["poisson_ratio"]
    return modulus / (1 - nu**2) * (2 * travel * MILLIMETRE)**2 / (2 * HEIGHT)


def threshold(load: np.ndarray, branched: np.ndarray) -> str:
    """Load at which half of the samples branch, by logistic regression, and its 95 % interval by profile likelihood."""
    if branched.all() or not branched.any():
        return f"{'all' if branched.all() else 'none'} branch from {load.min():.3f} to {load.max():.3f} mm"
    extent = load.max() - load.min()
    grid = np.linspace(max(0.0, load.min() - 3 * extent), load.max() + 3 * extent, 2801)
    widths = np.geomspace(1e-3, 3, 250) * extent
    x = (load[:, None, None] - grid[None, :, None]) / widths[None, None, :]
    likelihood = -np.where(branched[:, None, None], np.logaddexp(0, -x), np.logaddexp(0, x)).sum(axis=0)
    profile = likelihood.max(axis=1)
    inside = grid[profile > profile.max() - 1.92]  # half of the 95 % quantile of chi squared with one degree of freedom
    best = grid[profile > profile.max() - 1e-6]  # a plateau where the shares jump from none to all
    high = f"{inside[-1]:.4f}" if inside[-1] < grid[-1] else f"more than {grid[-1]:.4f}"
    return f"{best.mean():.4f} mm ({f'{inside[0]:.4f} to' if inside[0] > grid[0] else 'up to'} {high})"


def figures_of(release: str, folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "pmma-strip.toml").read_text()
    assert "0.040 mm" in text
    references = {"edge displacement at which half of them branch (95 % interval)": "0.038 to 0.040 mm",
                  "speed / c_R on the 2 mm before the first branching point, quartiles": "0.55, Katzav et al. 2007",
                  "angle between its branches, quartiles": "some 30°",
                  f"median largest speed / c_R at {', '.join(f'{stored_energy(text, travel):.0f}' for travel in TRAVELS)} J/m² stored": "0.6 to 0.7 where it branches",
                  f"at {PUBLISHED:.3f} mm: branching points": "equal",
                  "width of the band of facets": "equal",
                  "energy of broken tetrahedra per traced area": "equal"}
    found = []
    for spacing, n_samples in SPACINGS.items():
        keys = {"mesh.spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{spacing} mm"', "ensemble.samples": str(n_samples),
                "fracture.release_time": RELEASES[release]}
        cracks = {travel: [crack_of(sample) for sample in run(with_keys(text, keys).replace("0.040 mm", f"{travel:.3f} mm"),
                                                              folder / f"pmma-strip-{release.replace(' ', '-')}-{spacing}-{travel:.3f}", program)]
                  for travel in TRAVELS}
        ran = [(travel, crack) for travel, some in cracks.items() for crack in some if crack.ran]
        first, there = [crack for _, crack in ran if crack.n_branching > 0], cracks[PUBLISHED]
        found.append((threshold(np.array([travel for travel, _ in ran]), np.array([crack.n_branching > 0 for _, crack in ran])),
                      median_range([c.speed_there for c in first], ".2f", shares=QUARTILES),
                      median_range([c.angle for c in first], ".0f", "°", QUARTILES),
                      ", ".join(f"{np.median([c.largest_speed for c in some if c.ran] or [math.nan]):.2f}" for some in cracks.values()),
                      mean([c.n_branching for c in there], ".1f"), mean([c.band for c in there], ".2f") + " mm",
                      mean([c.energy for c in there], ".0f") + " J/m²"))
    case = f"Strip of PMMA, {release}" + ("" if release != "immediate release" else f", spacings {', '.join(map(str, SPACINGS))} mm; Bleyer et al. 2017")
    return [Figure(case, quantity, "; ".join(of_spacings), reference) for (quantity, reference), of_spacings in zip(references.items(), zip(*found))]


def pmma_strip(folder: Path, program: Path) -> list[Figure]:
    return [figure for release in RELEASES for figure in figures_of(release, folder, program)]
