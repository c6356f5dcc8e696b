# SPDX-License-Identifier: GPL-3.0-or-later
"""The problems of the gallery that have numbers to be held against: their inputs, and what is found."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import numpy as np

from crackle_report.style import MILLIMETRE
from crackle_runs import ROOT, Sample, mean_interval, median_range, with_keys


@dataclass(frozen=True)
class Figure:
    quantity: str
    find: Callable[[list[Sample]], str]
    reference: Callable[[list[Sample]], str]


def _always(text: str) -> Callable[[list[Sample]], str]:
    return lambda samples: text


@dataclass(frozen=True)
class Problem:
    source: str  # its input, in jobs
    figures: tuple[Figure, ...]
    keys: dict[str, str | None] = field(default_factory=dict)  # changes of the input
    coarse: dict[str, str | None] = field(default_factory=dict)  # further ones that make it a matter of seconds

    @property
    def file(self) -> Path:
        return ROOT / "jobs" / self.source

    def input_text(self, coarse: bool = False) -> str:
        return with_keys(self.file.read_text(), {**self.keys, **(self.coarse if coarse else {})})


def _mean(values: list[float]) -> str:
    """With the 95 % interval of the mean."""
    middle, half_width = mean_interval(np.array(values))
    return f"{middle:.2f} ± {half_width:.2f}"


def _branched(samples: list[Sample]) -> str:
    count = sum(sample.projected_branching.size > 0 for sample in samples)
    return f"{count} of {len(samples)}"


LONG_BRANCH = 2 * MILLIMETRE


def _branching_angle(samples: list[Sample]) -> str:
    """Between the branches of each sample's first branching point along the strip, of those with long branches."""
    def angle(sample: Sample) -> float | None:
        seen = sample.projected_branching
        seen = seen[sample.forks["length"][seen] >= LONG_BRANCH]
        if not seen.size:
            return None
        return math.degrees(sample.forks["angle"][seen[np.argmin(sample.forks["position"][seen, 0])]])

    return median_range([angle(sample) for sample in samples], ".0f", "°")


def _branching_time(samples: list[Sample]) -> str:
    """When the branching point with the longest branch comes."""
    def time(sample: Sample) -> float | None:
        seen = sample.projected_branching
        return 1e6 * sample.forks["time"][seen[np.argmax(sample.forks["length"][seen])]] if seen.size else None

    return median_range([time(sample) for sample in samples], ".0f", " µs")


def _passing_time(place: float) -> Callable[[list[Sample]], str]:
    """When the crack has come to this y [m]."""
    def find(samples: list[Sample]) -> str:
        times = [sample.passing_time(place) for sample in samples]
        return median_range([None if time is None else 1e6 * time for time in times], ".0f", " µs")
    return find


def srawley(share: float) -> float:
    """K B √W / F of a compact tension specimen whose crack is this share of the width W: Srawley, 1976."""
    polynomial = np.polyval([-5.6, 14.72, -13.32, 4.64, 0.886], share)
    return float((2 + share) / (1 - share) ** 1.5 * polynomial)


def _compact_tension(samples: list[Sample]) -> str:
    """K at the onset over that which the toughness takes in plane stress."""
    width, slot, thickness = 40 * MILLIMETRE, 20 * MILLIMETRE, 4 * MILLIMETRE
    ratios = []
    for sample in samples:
        toughness = _value(sample, "fracture", "toughness") * _value(sample, "material", "youngs_modulus") * 1e6
        k = float(sample.summary["onset_force"]) / (thickness * math.sqrt(width)) * srawley(slot / width)
        ratios.append(k / math.sqrt(toughness))
    return _mean(ratios)


def _value(sample: Sample, table: str, name: str) -> float:
    return float(str(sample.parameters[table][name]).split()[0])


DISK_RADIUS, DISK_THICKNESS = 25 * MILLIMETRE, 5 * MILLIMETRE
PLATEN = 0.4 * MILLIMETRE  # height of the arc that it holds
DISK_ARC = math.acos(1 - PLATEN / DISK_RADIUS)  # half of that


def disk_loads(samples: list[Sample]) -> list[float]:
    """Load at the onset over strength × π D t / 2, by which the standard takes the strength from the load."""
    return [float(sample.summary["onset_force"]) / (1e6 * _value(sample, "fracture", "strength") * math.pi * DISK_RADIUS * DISK_THICKNESS)
            for sample in samples]


def disk_reference() -> float:
    """The same for a load on arcs instead of points, with the tension in the middle by Hondros, 1959."""
    return math.sin(DISK_ARC) / (math.sin(2 * DISK_ARC) - DISK_ARC)


BAR_HEIGHT, BAR_WIDTH, BAR_SPAN, BAR_ARM = 3 * MILLIMETRE, 4 * MILLIMETRE, 40 * MILLIMETRE, 10 * MILLIMETRE
BAR_ROLLERS = (2, 3)  # conditions that push


def bar_stiffness(modulus: float, poisson_ratio: float) -> float:
    """Load over the way of the upper rollers in four-point bending, by Timoshenko's beam [N/m]."""
    bending = BAR_ARM**2 * (3 * BAR_SPAN - 4 * BAR_ARM) / (12 * modulus * BAR_WIDTH * BAR_HEIGHT**3 / 12)
    shear = BAR_ARM / (2 * 5 / 6 * modulus / (2 * (1 + poisson_ratio)) * BAR_WIDTH * BAR_HEIGHT)
    return 1 / (bending + shear)


def _bar_stiffness(samples: list[Sample]) -> str:
    """Before anything breaks, over the beam's."""
    def ratio(sample: Sample) -> float:
        load = -sum(sample.history["reaction"][1, roller, 1] for roller in BAR_ROLLERS)
        way = -np.mean([sample.history["displacement"][1, roller, 1] for roller in BAR_ROLLERS])
        return load / way / bar_stiffness(_value(sample, "material", "youngs_modulus") * 1e9,
                                          float(sample.parameters["material"]["poisson_ratio"]))
    return _mean([ratio(sample) for sample in samples])


def disk_widening(load: float, modulus: float, poisson_ratio: float) -> float:
    """By how much the width of a disk between two point loads grows in plane stress, exactly [m]."""
    return load / (modulus * DISK_THICKNESS) * (4 / math.pi - 1 + poisson_ratio)


def _disk_widening(samples: list[Sample]) -> str:
    """Before anything breaks, over the exact one."""
    def ratio(sample: Sample) -> float:
        ends = [sample.history[f"probes/{end}/displacement"][1, 1] for end in ("left", "right")]
        exact = disk_widening(-sample.history["reaction"][1, 1, 2], _value(sample, "material", "youngs_modulus") * 1e9,
                              float(sample.parameters["material"]["poisson_ratio"]))
        return (ends[1] - ends[0]) / exact
    return _mean([ratio(sample) for sample in samples])


STRIP_WIDTH, STRIP_THICKNESS = 20 * MILLIMETRE, 1 * MILLIMETRE
TOUGHNESS, MODULUS, DEPTH = "fracture.toughness", "material.youngs_modulus", "specimen.notch[0].depth"


def drawn(samples: list[Sample], key: str) -> np.ndarray:
    """The values of a random input."""
    return np.array([sample.inputs[key] for sample in samples])


def notch_factor(share: float) -> float:
    """K / (σ √(π a)) of an edge crack that is this share of the width: Brown and Srawley, 1966."""
    return float(np.polyval([30.39, -21.72, 10.55, -0.231, 1.12], share))


def handbook_load(toughness: float, modulus: float, depth: float) -> float:
    """At which a crack in place of the strip's notch has K = √(E G) [N]; plane stress."""
    stress = math.sqrt(modulus * toughness / (math.pi * depth)) / notch_factor(depth / STRIP_WIDTH)
    return stress * STRIP_WIDTH * STRIP_THICKNESS


def _handbook_loads(samples: list[Sample]) -> np.ndarray:
    return np.array([handbook_load(*values) for values in zip(*(drawn(samples, key) for key in (TOUGHNESS, MODULUS, DEPTH)))])


def onset_loads(samples: list[Sample]) -> np.ndarray:
    return np.array([float(sample.summary["onset_force"]) for sample in samples])


def exponents(samples: list[Sample], load: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exponents of a load in toughness, modulus and depth, by least squares, and half of their 95 % intervals."""
    from scipy import stats  # not needed for a run
    design = np.column_stack([np.ones(len(load)), *(np.log(drawn(samples, key)) for key in (TOUGHNESS, MODULUS, DEPTH))])
    solution, *_ = np.linalg.lstsq(design, np.log(load), rcond=None)
    variance = float(((np.log(load) - design @ solution) ** 2).sum()) / (len(load) - 4)
    error = np.sqrt(variance * np.diag(np.linalg.inv(design.T @ design)))
    return solution[1:], stats.t.ppf(0.975, len(load) - 4) * error[1:]


def _exponent(place: int) -> Callable[[list[Sample]], str]:
    def find(samples: list[Sample]) -> str:
        found, half_width = exponents(samples, onset_loads(samples))
        return f"{found[place]:.2f} ± {half_width[place]:.2f}"
    return find


def _depth_reference(samples: list[Sample]) -> str:
    """The handbook has no single exponent: the same least squares on its loads."""
    return f"{exponents(samples, _handbook_loads(samples))[0][2]:.2f}"


PROBLEMS = {
    "paper-plate": Problem("paper.toml", (Figure("samples with branching in the projection", _branched, _always("4 of the paper's 8 typical samples, no share")),),
                           {"ensemble.samples": "8", "time.integrator": '"verlet"', "time.step": '"auto"'},
                           {"ensemble.samples": "2", "mesh.notch_spacing": '"0.6 mm"', "mesh.growth": "0.1", "mesh.spacing": '"2 mm"'}),
    "pmma-strip": Problem("verification/pmma-strip.toml", (
        Figure("samples with branching in the projection", _branched, _always("all")),
        Figure("angle between the branches of the first branching point with branches of 2 mm", _branching_angle, _always("some 30°"))),
        {}, {"ensemble.samples": "2"}),
    "glass-plate": Problem("verification/glass-plate.toml", (
        Figure("the crack has grown by 1 mm after", _passing_time(51 * MILLIMETRE), _always("about 10 µs")),
        Figure("it branches after", _branching_time, _always("about 33 µs")),
        Figure("it is 1 mm before the far edge after", _passing_time(99 * MILLIMETRE), _always("about 75 µs"))),
        {"ensemble.samples": "4"}, {"ensemble.samples": "1", "mesh.spacing": '"0.5 mm"'}),
    "compact-tension": Problem("gallery/compact-tension.toml", (
        Figure("K at the onset over that of the toughness", _compact_tension, _always("1")),),
        {}, {"ensemble.samples": "2", "mesh.notch_spacing": '"1 mm"', "specimen.notch.height": '"1 mm"'}),
    "brazilian-disk": Problem("gallery/brazilian-disk.toml", (
        Figure("load at failure over strength × π D t / 2", lambda samples: _mean(disk_loads(samples)),
               _always(f"{disk_reference():.2f} on these arcs; 1 at points")),),
        {}, {"ensemble.samples": "2", "mesh.spacing": '"2.5 mm"'}),
    "bend-bar": Problem("gallery/bend-bar.toml", (
        Figure("stiffness over that of Timoshenko's beam", _bar_stiffness, _always("1")),),
        {}, {"ensemble.samples": "2", "mesh.spacing": '"0.6 mm"', "mesh.region.spacing": '"0.45 mm"', "time.duration": '"10 us"'}),
    "knife-edge-disk": Problem("gallery/knife-edge-disk.toml", (
        Figure("growth of the width over the exact one", _disk_widening, _always("1")),),
        {}, {"ensemble.samples": "2", "mesh.spacing": '"2.5 mm"', "time.duration": '"10 us"'}),
    "uncertain-strip": Problem("gallery/uncertain-strip.toml", (
        Figure("exponent of the notch's depth in the load", _exponent(2), _depth_reference),
        Figure("exponent of the toughness", _exponent(0), _always("0.5")),
        Figure("exponent of the modulus", _exponent(1), _always("0.5")),
        Figure("load over the handbook's", lambda samples: _mean(list(onset_loads(samples) / _handbook_loads(samples))), _always("1"))),
        {}, {"ensemble.samples": "16", "time.duration": '"1 us"'}),
}
