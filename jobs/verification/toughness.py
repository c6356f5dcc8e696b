# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads at which cracked bodies become unstable, over those that the toughness given predicts."""
from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from crackle import Sample

from crackle_runs import JOBS, markdown, run, with_keys
from figures import MILLIMETRE

TOUGHNESS, MODULUS = 30, 32e9  # of both inputs [J/m^2, Pa]
FINE = 'spacing = "0.75 mm"'  # where the crack runs
RATIOS = (0.0, 0.2, 0.38, 0.45)  # Poisson's
FEW = {"ensemble.samples": "4"}  # of the laws that take minutes
IMMEDIATE = {"fracture.release_time": '"0 s"'}
AVERAGED = IMMEDIATE | {"fracture.length": '"1.5 mm"', **FEW}
SOFTENING = IMMEDIATE | {"fracture.strength": '"22 MPa"', "fracture.release": '"softening"', **FEW}
LAWS = {"the law": {}, "immediate release": IMMEDIATE, "facet": IMMEDIATE | {"fracture.release": '"facet"'}, "averaged over 1.5 mm": AVERAGED,
        "softening, process zone 2 mm": SOFTENING}
SPACINGS = {law: (0.66, 0.5, 0.4) if keys is SOFTENING else (1.0, 0.75, 0.5) for law, keys in LAWS.items()}  # [mm]
STATES = ("plane strain", "plane stress")


def _stiffness(nu: float, state: str) -> float:
    """E' of a plane problem [Pa]."""
    return MODULUS / (1 - nu ** 2) if state == "plane strain" else MODULUS


def griffith(nu: float, state: str) -> float:
    """Time at which the strip of griffith-strip.toml holds the toughness for each area ahead of the crack [s].

    Exact for a long strip between grips that do not hinder its contraction; K = sigma sqrt(H / 2) of a stack of parallel cracks
    (Tada, Paris and Irwin's handbook) is the same.
    """
    height, rate = 36e-3, 1e-6
    return math.sqrt(2 * TOUGHNESS * height / _stiffness(nu, state)) / rate


def srawley(nu: float, state: str) -> float:
    """Time at which K of the bar of bent-bar.toml is that of the toughness [s]; Srawley 1976, within 0.5 % for any depth."""
    width, span, depth, thickness, rate = 40e-3, 160e-3, 12e-3, 2e-3, 1
    a = depth / width
    factor = 3 * math.sqrt(a) * (1.99 - a * (1 - a) * (2.15 - 3.93 * a + 2.7 * a * a)) / (2 * (1 + 2 * a) * (1 - a) ** 1.5)
    return math.sqrt(_stiffness(nu, state) * TOUGHNESS) * thickness * width ** 1.5 / (span * factor) / rate


@dataclass(frozen=True)
class Body:
    file: str
    predicted: object  # time at instability, of Poisson's ratio and state [s]
    crossed: float  # where a crack that has come so far is unstable, y [m]


BODIES = {"strip": Body("griffith-strip.toml", griffith, 42 * MILLIMETRE), "bar": Body("bent-bar.toml", srawley, 16 * MILLIMETRE)}


@dataclass(frozen=True)
class Row:
    body: str
    law: str
    state: str
    spacing: float  # where the crack runs [mm]

    def input_text(self, nu: float) -> str:
        keys = {"material.poisson_ratio": f"{nu}", **LAWS[self.law]}
        if self.state == "plane stress":
            keys["boundary.on"] = '"x-min"'  # both faces across the thickness were held
        text = (JOBS / BODIES[self.body].file).read_text()
        assert FINE in text
        return with_keys(text.replace(FINE, f'spacing = "{self.spacing} mm"'), keys)

    def name(self, nu: float) -> str:
        return f"toughness-{self.body}-{self.law.split(',')[0].replace(' ', '-')}-{self.state[6:]}-{self.spacing}-{nu}"


# The strip at all spacings, the bar and the other plane state at the middle one.
ROWS = [Row(body, law, state, spacing) for law in LAWS for body in BODIES for state in STATES for spacing in SPACINGS[law]
        if (body, state) == ("strip", "plane strain") or spacing == SPACINGS[law][1]]


def ratios(row: Row, nu: float, folder: Path, program: Path) -> list[float]:
    """Load at instability over the predicted one, of each sample that has not failed."""
    body = BODIES[row.body]
    samples = run(row.input_text(nu), folder / row.name(nu), program, may_fail=True)
    return [_time(sample, body.crossed) / body.predicted(nu, row.state) for sample in samples if sample.is_done]


def _time(sample: Sample, crossed: float) -> float:
    """Load time at which the crack got beyond this y, the last break's where it did not [s]."""
    mesh, times = sample.mesh, sample.breaks.load_time.to_numpy()
    is_beyond = mesh["nodes"][mesh["tetrahedra"][sample.breaks.tetrahedron], 1].mean(axis=1) > crossed
    return float(times[is_beyond].min() if is_beyond.any() else times.max())


def table(folder: Path, program: Path) -> str:
    """A table of the loads, mean and standard error."""
    lines, found = [], []
    for before, row in zip(["", *(row.law for row in ROWS)], ROWS):
        cells = [ratios(row, nu, folder, program) for nu in RATIOS]
        found += [statistics.mean(cell) for cell in cells]
        lines.append([row.law if row.law != before else "", f"{row.body}, {row.state}", f"{row.spacing:g} mm", *map(_cell, cells)])
    text = markdown(["law", "body", "spacing", *(f"ν = {nu:g}" for nu in RATIOS)], lines)
    return text + f"\nMean {np.mean(found):.3f}, {min(found):.3f} to {max(found):.3f}\n"


def _cell(values: list[float]) -> str:
    return f"{np.mean(values):.3f} ± {np.std(values, ddof=1) / math.sqrt(len(values)):.3f}"
