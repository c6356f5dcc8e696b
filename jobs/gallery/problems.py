# SPDX-License-Identifier: GPL-3.0-or-later
"""The problems of the gallery that have numbers to be held against: their inputs, and what is found."""
from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Iterator, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from crackle import Ensemble, Sample
from crackle_report.style import MILLIMETRE
from crackle_runs import ROOT, median_range, with_keys


@dataclass(frozen=True)
class Figure:
    quantity: str
    find: Callable[[Ensemble], str]
    reference: Callable[[Ensemble], str]


def files_beside(text: str) -> list[Path]:
    """Those in jobs/gallery that an input names: a raster, or a solid."""
    return [ROOT / "jobs" / "gallery" / file for file in re.findall(r'(?m)^(?:file|solid) = "(.*)"$', text)]


def always(text: str) -> Callable[[Ensemble], str]:
    return lambda _: text


@dataclass(frozen=True)
class Problem:
    source: str  # its input, in jobs
    figures: tuple[Figure, ...]
    keys: dict[str, str | None] = field(default_factory=dict)  # changes of the input
    coarse: dict[str, str | None] = field(default_factory=dict)  # further ones that make it a matter of seconds
    added: str = ""  # tables at the end of its input
    size: float = 1  # factor on all lengths, but those of reference volumes
    experiments: str = ""  # a file in jobs/experiments, which is held against the samples
    picture: str = ""  # of the report with these experiments, instead of one of the cracks

    @property
    def file(self) -> Path:
        return ROOT / "jobs" / self.source

    def input_text(self, coarse: bool = False) -> str:
        text = with_keys(self.file.read_text(), {**self.keys, **(self.coarse if coarse else {})}) + self.added
        return re.sub(r'([\d.]+)( mm(?:/s)?")', lambda length: f"{float(length[1]) * self.size:g}{length[2]}", text) if self.size != 1 else text

    @property
    def experiments_file(self) -> Path:
        return ROOT / "jobs" / "experiments" / self.experiments


def _mean(values: Sequence[float], form: str = ".2f", unit: str = "") -> str:
    """With the 95 % interval of the mean, Student's."""
    from scipy import stats  # not needed for a run
    half_width = stats.t.ppf(0.975, len(values) - 1) * stats.sem(values) if len(values) > 1 else math.nan
    return f"{np.mean(values):{form}}{unit} ± {half_width:{form}}{unit}"


def _branched(ensemble: Ensemble) -> str:
    points = ensemble.samples.bifurcations_projected
    return f"{(points > 0).sum()} of {len(points)}"


def projected_branching(sample: Sample) -> pd.DataFrame:
    """Those that show in the projection on the plate's plane."""
    return sample.forks[sample.forks["in_projection"] == 1]


LONG_BRANCH = 2 * MILLIMETRE


def _branching_angle(ensemble: Ensemble) -> str:
    """Between the branches of each sample's first branching point along the strip, of those with long branches."""
    found = [points[points.length >= LONG_BRANCH] for points in map(projected_branching, ensemble)]
    return median_range((math.degrees(points.angle[points.y.idxmin()]) if len(points) else None for points in found), ".0f", "°")


def _branching_time(ensemble: Ensemble) -> str:
    """When the branching point with the longest branch comes."""
    found = map(projected_branching, ensemble)
    return median_range((1e6 * points.time[points.length.idxmax()] if len(points) else None for points in found), ".0f", " µs")


def _passing_time(place: float) -> Callable[[Ensemble], str]:
    """When the first facet beyond this y [m] opened."""
    def times(ensemble: Ensemble) -> Iterator[float]:
        for surface in (sample.crack_surface for sample in ensemble):
            yield 1e6 * surface.time.values[surface.corners.values[:, :, 1].mean(axis=1) > place].min(initial=math.inf)
    return lambda ensemble: median_range((time if time < math.inf else None for time in times(ensemble)), ".0f", " µs")


def _range_of(result: str, form: str, unit: str = "") -> Callable[[Ensemble], str]:
    return lambda ensemble: median_range(ensemble.samples[result], form, unit)


def srawley(share: float) -> float:
    """K B √W / F of a compact tension specimen whose crack is this share of the width W: Srawley, 1976."""
    polynomial = np.polyval([-5.6, 14.72, -13.32, 4.64, 0.886], share)
    return float((2 + share) / (1 - share) ** 1.5 * polynomial)


def _compact_tension(ensemble: Ensemble) -> str:
    """K at the onset over that which the toughness takes in plane stress."""
    width, slot, thickness = 40 * MILLIMETRE, 20 * MILLIMETRE, 4 * MILLIMETRE
    toughness = _value(ensemble, "fracture", "toughness") * _value(ensemble, "material", "youngs_modulus") * 1e6
    return _mean(onset_loads(ensemble) / (thickness * math.sqrt(width)) * srawley(slot / width) / math.sqrt(toughness))


def _value(ensemble: Ensemble, table: str, name: str) -> float:
    """A number of the input, without its unit."""
    return float(str(tomllib.loads(ensemble.input)[table][name]).split()[0])


def onset_loads(ensemble: Ensemble) -> np.ndarray:
    return ensemble.samples.onset_force.to_numpy()


DISK_RADIUS, DISK_THICKNESS = 25 * MILLIMETRE, 5 * MILLIMETRE
PLATEN = 0.4 * MILLIMETRE  # height of the arc that it holds
DISK_ARC = math.acos(1 - PLATEN / DISK_RADIUS)  # half of that


def disk_loads(ensemble: Ensemble) -> np.ndarray:
    """Load at the onset over strength × π D t / 2, by which the standard takes the strength from the load."""
    return onset_loads(ensemble) / (1e6 * _value(ensemble, "fracture", "strength") * math.pi * DISK_RADIUS * DISK_THICKNESS)


def disk_reference(arc: float = DISK_ARC) -> float:
    """The same for a load on arcs instead of points, with the tension in the middle by Hondros, 1959.

    @param arc: half of each, as an angle"""
    return math.sin(arc) / (math.sin(2 * arc) - arc)


BAR_HEIGHT, BAR_WIDTH, BAR_SPAN, BAR_ARM = 3 * MILLIMETRE, 4 * MILLIMETRE, 40 * MILLIMETRE, 10 * MILLIMETRE
BAR_ROLLERS = (2, 3)  # conditions that push


def bar_stiffness(modulus: float, poisson_ratio: float) -> float:
    """Load over the way of the upper rollers in four-point bending, by Timoshenko's beam [N/m]."""
    bending = BAR_ARM**2 * (3 * BAR_SPAN - 4 * BAR_ARM) / (12 * modulus * BAR_WIDTH * BAR_HEIGHT**3 / 12)
    shear = BAR_ARM / (2 * 5 / 6 * modulus / (2 * (1 + poisson_ratio)) * BAR_WIDTH * BAR_HEIGHT)
    return 1 / (bending + shear)


def _bar_stiffness(ensemble: Ensemble) -> str:
    """Before anything breaks, over the beam's."""
    beam = bar_stiffness(_value(ensemble, "material", "youngs_modulus") * 1e9, _value(ensemble, "material", "poisson_ratio"))
    pushed = [sample.history.isel(moment=1, condition=list(BAR_ROLLERS), component=1) for sample in ensemble]
    return _mean([float(one.reaction.sum() / one.displacement.mean()) / beam for one in pushed])


def disk_widening(load: float, modulus: float, poisson_ratio: float) -> float:
    """By how much the width of a disk between two point loads grows in plane stress, exactly [m]."""
    return load / (modulus * DISK_THICKNESS) * (4 / math.pi - 1 + poisson_ratio)


def _disk_widening(ensemble: Ensemble) -> str:
    """Before anything breaks, over the exact one."""
    elastic = _value(ensemble, "material", "youngs_modulus") * 1e9, _value(ensemble, "material", "poisson_ratio")

    def ratio(history: xr.Dataset) -> float:
        ends = history.probe_displacement.sel(component="y")
        exact = disk_widening(-float(history.reaction.isel(condition=1).sel(component="z")), *elastic)
        return float(ends.sel(probe="right") - ends.sel(probe="left")) / exact
    return _mean([ratio(sample.history.isel(moment=1)) for sample in ensemble])


ROD_RADIUS, ROD_GAUGE = 2.5 * MILLIMETRE, (7 * MILLIMETRE, 24 * MILLIMETRE)


def spiral_angles(ensemble: Ensemble) -> list[float]:
    """The angle of each crack in the outer part of a bar along z to the bar's cross-section, where it rises clockwise [degrees]: by the
    mean square of the facets' normals, weighted by area."""
    def angle(sample: Sample) -> float:
        corners, area = sample.crack_surface.corners.values, sample.crack_surface.area.values
        middle = corners.mean(axis=1)
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        radius = np.hypot(middle[:, 0], middle[:, 1])
        outer = (radius > 0.7 * ROD_RADIUS) & (middle[:, 2] > ROD_GAUGE[0]) & (middle[:, 2] < ROD_GAUGE[1])
        round_axis = (normal[:, 1] * middle[:, 0] - normal[:, 0] * middle[:, 1]) / radius
        found = np.stack([round_axis, normal[:, 2]])[:, outer]
        principal = np.linalg.eigh(area[outer] * found @ found.T)[1][:, -1]
        return math.degrees(math.atan2(principal[0] * np.sign(principal[1]), abs(principal[1])))
    return [angle(sample) for sample in ensemble]


STRIP_WIDTH, STRIP_THICKNESS = 20 * MILLIMETRE, 1 * MILLIMETRE
TOUGHNESS, MODULUS, DEPTH = "fracture.toughness", "material.youngs_modulus", "specimen.notch[0].depth"


def drawn(ensemble: Ensemble, key: str) -> np.ndarray:
    """The values of a random input."""
    return ensemble.samples[key].to_numpy()


def notch_factor(share: float) -> float:
    """K / (σ √(π a)) of an edge crack that is this share of the width: Brown and Srawley, 1966."""
    return float(np.polyval([30.39, -21.72, 10.55, -0.231, 1.12], share))


def handbook_load(toughness: float, modulus: float, depth: float) -> float:
    """At which a crack in place of the strip's notch has K = √(E G) [N]; plane stress."""
    stress = math.sqrt(modulus * toughness / (math.pi * depth)) / notch_factor(depth / STRIP_WIDTH)
    return stress * STRIP_WIDTH * STRIP_THICKNESS


def _handbook_loads(ensemble: Ensemble) -> np.ndarray:
    return np.array([handbook_load(*values) for values in zip(*(drawn(ensemble, key) for key in (TOUGHNESS, MODULUS, DEPTH)))])


def exponents(ensemble: Ensemble, load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exponents of a load in toughness, modulus and depth, by least squares, and half of their 95 % intervals."""
    from scipy import stats  # not needed for a run
    design = np.column_stack([np.ones(len(load)), *(np.log(drawn(ensemble, key)) for key in (TOUGHNESS, MODULUS, DEPTH))])
    solution, *_ = np.linalg.lstsq(design, np.log(load), rcond=None)
    variance = float(((np.log(load) - design @ solution) ** 2).sum()) / (len(load) - 4)
    error = np.sqrt(variance * np.diag(np.linalg.inv(design.T @ design)))
    return solution[1:], stats.t.ppf(0.975, len(load) - 4) * error[1:]


def _exponent(place: int) -> Callable[[Ensemble], str]:
    def find(ensemble: Ensemble) -> str:
        found, half_width = exponents(ensemble, onset_loads(ensemble))
        return f"{found[place]:.2f} ± {half_width[place]:.2f}"
    return find


def _depth_reference(ensemble: Ensemble) -> str:
    """The handbook has no single exponent: the same least squares on its loads."""
    return f"{exponents(ensemble, _handbook_loads(ensemble))[0][2]:.2f}"


PROBLEMS = {
    "paper-plate": Problem("paper.toml", (Figure("samples with branching in the projection", _branched, always("4 of the paper's 8 typical samples, no share")),),
                           {"ensemble.samples": "8", "time.integrator": '"verlet"', "time.step": '"auto"'},
                           {"ensemble.samples": "2", "mesh.notch_spacing": '"0.6 mm"', "mesh.growth": "0.1", "mesh.spacing": '"2 mm"'}),
    "pmma-strip": Problem("verification/pmma-strip.toml", (
        Figure("samples with branching in the projection", _branched, always("all")),
        Figure("angle between the branches of the first branching point with branches of 2 mm", _branching_angle, always("some 30°"))),
        {}, {"ensemble.samples": "2"}),
    "glass-plate": Problem("verification/glass-plate.toml", (
        Figure("the crack has grown by 1 mm after", _passing_time(51 * MILLIMETRE), always("about 10 µs")),
        Figure("it branches after", _branching_time, always("about 33 µs")),
        Figure("it is 1 mm before the far edge after", _passing_time(99 * MILLIMETRE), always("about 75 µs")),
        Figure("branching points in the projection", _range_of("bifurcations_projected", ".0f"), always("1")),
        Figure("largest speed / c_R (2125 m/s)", _range_of("crack_speed_ratio", ".2f"), always("below 0.6")),
        Figure("energy of broken tetrahedra per traced area", _range_of("effective_toughness", ".2f", " J/m²"), always("2 while slow (of G = 3), more when fast"))),
        {"ensemble.samples": "4"},
        # With immediate release: released in time, a fast crack takes more than the toughness, and how much depends on the spacing.
        {"ensemble.samples": "1", "mesh.spacing": '"0.5 mm"', "fracture.release_speed": None, "fracture.release_time": '"0 s"'}),
    "compact-tension": Problem("gallery/compact-tension.toml", (
        Figure("K at the onset over that of the toughness", _compact_tension, always("1")),),
        {}, {"ensemble.samples": "2", "mesh.notch_spacing": '"1 mm"', "specimen.notch.height": '"1 mm"'}),
    "brazilian-disk": Problem("gallery/brazilian-disk.toml", (
        Figure("load at failure over strength × π D t / 2", lambda ensemble: _mean(disk_loads(ensemble)),
               always(f"{disk_reference():.2f} on these arcs; 1 at points")),),
        {}, {"ensemble.samples": "2", "mesh.spacing": '"2.5 mm"'}),
    "bend-bar": Problem("gallery/bend-bar.toml", (
        Figure("stiffness over that of Timoshenko's beam", _bar_stiffness, always("1")),),
        {}, {"ensemble.samples": "2", "mesh.spacing": '"0.6 mm"', "mesh.region.spacing": '"0.45 mm"', "time.duration": '"10 us"'}),
    "knife-edge-disk": Problem("gallery/knife-edge-disk.toml", (
        Figure("growth of the width over the exact one", _disk_widening, always("1")),),
        {}, {"ensemble.samples": "2", "mesh.spacing": '"2.5 mm"', "time.duration": '"10 us"'}),
    "twisted-rod": Problem("gallery/twisted-rod.toml", (
        Figure("angle of the crack to the cross-section", lambda ensemble: _mean(spiral_angles(ensemble), ".0f", "°"), always("45°")),),
        {}, {"mesh.spacing": '"0.8 mm"'}),
    "uncertain-strip": Problem("gallery/uncertain-strip.toml", (
        Figure("exponent of the notch's depth in the load", _exponent(2), _depth_reference),
        Figure("exponent of the toughness", _exponent(0), always("0.5")),
        Figure("exponent of the modulus", _exponent(1), always("0.5")),
        Figure("load over the handbook's", lambda ensemble: _mean(onset_loads(ensemble) / _handbook_loads(ensemble)), always("1"))),
        {}, {"ensemble.samples": "16", "time.duration": '"1 us"'}),
}
