# SPDX-License-Identifier: GPL-3.0-or-later
"""The six problems of the gallery that have a published number: their inputs, and what is found."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import numpy as np

from crackle_report.style import MILLIMETRE
from crackle_runs import ROOT, Sample, mean_interval, with_keys


@dataclass(frozen=True)
class Problem:
    source: str  # its input, in jobs
    quantity: str
    published: str
    find: Callable[[list[Sample]], str]  # the number beside the published one
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


def _forked(samples: list[Sample]) -> str:
    count = sum(sample.projected_forks.size > 0 for sample in samples)
    return f"{count} of {len(samples)}"


def _fork_angle(samples: list[Sample]) -> str:
    """Between the arms of each sample's first fork, along the strip."""
    angles = []
    for sample in samples:
        seen = sample.projected_forks
        if seen.size:
            first = seen[np.argmin(sample.forks["position"][seen, 0])]
            angles.append(math.degrees(sample.forks["angle"][first]))
    return f"{np.median(angles):.0f}° ({min(angles):.0f} to {max(angles):.0f}), {len(angles)} of {len(samples)}" if angles else "no fork"


def _branching_time(samples: list[Sample]) -> str:
    """When the fork with the longest arm comes."""
    times = []
    for sample in samples:
        seen = sample.projected_forks
        if seen.size:
            times.append(1e6 * sample.forks["time"][seen[np.argmax(sample.forks["length"][seen])]])
    return f"{np.median(times):.0f} µs ({min(times):.0f} to {max(times):.0f}), {len(times)} of {len(samples)}" if times else "no fork"


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


STRENGTH = 23.0  # of the disk [MPa]


def disk_loads(samples: list[Sample]) -> list[float]:
    """Load at the onset over strength × π D t / 2, by which the standard takes the strength from the load."""
    radius, thickness = 25 * MILLIMETRE, 5 * MILLIMETRE
    return [float(sample.summary["onset_force"]) / (1e6 * STRENGTH * math.pi * radius * thickness) for sample in samples]


def notch_factor(share: float) -> float:
    """K / (σ √(π a)) of an edge crack that is this share of the width: Gross and Srawley, 1964."""
    return float(np.polyval([30.39, -21.72, 10.55, -0.231, 1.12], share))


def depth_exponent() -> float:
    """d ln load / d ln depth of the strip at its mean depth, by the handbook."""
    step, share = 1e-4, 8 / 20
    return -0.5 - (math.log(notch_factor(share * (1 + step))) - math.log(notch_factor(share * (1 - step)))) / (2 * step)


def exponents(samples: list[Sample]) -> tuple[np.ndarray, np.ndarray]:
    """Exponents of the load at the onset in toughness, modulus and depth, by least squares, and their standard errors."""
    load = np.log([float(sample.summary["onset_force"]) for sample in samples])
    drawn = np.log([[sample.inputs[key] for key in ("fracture.toughness", "material.youngs_modulus", "specimen.notch[0].depth")]
                    for sample in samples])
    design = np.column_stack([np.ones(len(load)), drawn])
    solution, *_ = np.linalg.lstsq(design, load, rcond=None)
    variance = float(((load - design @ solution) ** 2).sum()) / (len(load) - 4)
    return solution[1:], np.sqrt(variance * np.diag(np.linalg.inv(design.T @ design)))[1:]


def _depth_exponent(samples: list[Sample]) -> str:
    from scipy import stats  # not needed for a run
    found, error = exponents(samples)
    return f"{found[2]:.2f} ± {stats.t.ppf(0.975, len(samples) - 4) * error[2]:.2f}"


PROBLEMS = {
    "paper-plate": Problem("paper.toml", "samples with a fork in the projection", "4 of the 8 shown", _forked,
                           {"ensemble.samples": "8", "time.integrator": '"verlet"', "time.step": '"auto"'},
                           {"ensemble.samples": "2", "mesh.notch_spacing": '"0.6 mm"', "mesh.growth": "0.1", "mesh.spacing": '"2 mm"'}),
    "pmma-strip": Problem("verification/pmma-strip.toml", "angle between the arms of the first fork", "some 30°", _fork_angle,
                          {}, {"ensemble.samples": "2"}),
    "glass-plate": Problem("verification/glass-plate.toml", "the crack branches after", "about 33 µs", _branching_time,
                           {"ensemble.samples": "4"}, {"ensemble.samples": "1", "mesh.spacing": '"0.5 mm"'}),
    "compact-tension": Problem("gallery/compact-tension.toml", "K at the onset over that of the toughness", "1", _compact_tension,
                               {}, {"ensemble.samples": "2", "mesh.notch_spacing": '"1 mm"'}),
    "brazilian-disk": Problem("gallery/brazilian-disk.toml", "load at failure over strength × π D t / 2", "1",
                              lambda samples: _mean(disk_loads(samples)),
                              {"fracture.toughness": None, "fracture.strength": f'"{STRENGTH:g} MPa"'},
                              {"ensemble.samples": "2", "mesh.spacing": '"2.5 mm"'}),
    "uncertain-strip": Problem("gallery/uncertain-strip.toml", "exponent of the notch's depth in the load", f"{depth_exponent():.2f}",
                               _depth_exponent, {}, {"ensemble.samples": "16", "time.duration": '"1 us"'}),
}
