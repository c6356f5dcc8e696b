# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of each study, as changes of jobs/paper.toml or of an input beside it, in jobs/paper.

Runs with the paper's seed, body and mesh section have the same bodies: two settings can be compared sample by sample. What
changes the mesh changes the base distribution of mother points too, and bases differ; so such settings are computed on
several bases, and the base is the unit of comparison.
"""
from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from crackle_runs import ROOT, with_keys

FAST = {"time.integrator": '"verlet"', "time.step": '"auto"', "output.frames": "2"}
"""A time integration at a sixth of the cost; the study `convergence` compares it with the campaign's."""


UNTURNED = {**FAST, "mesh.turn": '"none"'}
"""The same, with every sample's mesh as the base distribution lies."""


@dataclass(frozen=True)
class Run:
    name: str
    label: str
    samples: int
    keys: dict[str, str] = field(default_factory=dict)
    depth: float | None = None  # of both notches [mm]; else the input's
    distance: float | None = None  # of their mid-planes along the plate [mm]; else the input's
    rate: float | None = None  # of the load [N/s]; else the input's
    reference: str = "fast"  # the run that differs in nothing but this run's point
    source: str = "paper/clock-from-zero"  # the input in jobs/ that is changed
    load: float | None = None  # at time 0 [N]; else the input's
    thickness: float | None = None  # of the plate [mm], loads in proportion; else the input's
    tables: str = ""  # further ones

    @property
    def source_file(self) -> Path:
        return ROOT / "jobs" / f"{self.source}.toml"

    def input_text(self) -> str:
        text = with_keys(self.source_file.read_text(), {"ensemble.samples": str(self.samples), **self.keys})
        if self.depth is not None:
            text = re.sub(r"(?m)^depth = .*$", f'depth = "{self.depth:g} mm"', text)
        if self.distance is not None:
            places = iter((70 - self.distance / 2, 70 + self.distance / 2))
            text = re.sub(r"(?m)^at = .*$", lambda _: f'at = "{next(places):g} mm"', text)
        rate, load = self.rate, self.load
        if self.thickness is not None:
            size = tomllib.loads(text)["specimen"]["size"]
            share = self.thickness / float(size[0].split()[0])
            text = with_keys(text, {"specimen.size": f'["{self.thickness:g} mm", "{size[1]}", "{size[2]}"]'})
            pull = tomllib.loads(text)["boundary"][1]
            rate, load = (share * float(pull[key][2].split()[0]) for key in ("rate", "force"))
        if rate is not None:
            text = re.sub(r"(?m)^rate = .*$", f'rate = ["0 N/s", "0 N/s", "{rate:g} N/s"]', text)
        if load is not None:
            text = re.sub(r"(?m)^force = .*$", f'force = ["0 N", "0 N", "{load:g} N"]', text)
        return text + self.tables


TARGET_LOAD = 380.9  # [N]: the paper's t0 = 76.179191 s at 5 N/s
DISTANCE = 5.0  # of the notches [mm], as in clock-from-zero.toml
DEPTHS_AT_DISTANCE = {3.0: (5.6,), 4.0: (5.6,), 5.0: (4.0, 5.0, 5.2, 5.4, 5.6, 5.8), 7.0: (5.2,),
                      10.0: (2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0), 15.0: (5.2,), 20.0: (5.2,)}  # [mm]
PERTURBATION = 0.2  # in jobs/paper.toml
PERTURBATIONS = (0.001, 0.05, 0.1, PERTURBATION, 0.3)
PAPER_LOAD = 516.0  # [N]: the paper's t0 at 5 N/s, from 135 N on
RATES = {1e6: (1.2, 16), 3e6: (1.3, 24), 1e7: (1.5, 24)}  # [N/s]: duration, in times that the load takes to PAPER_LOAD; samples
SEEDS = range(1, 13)
PER_BASE = 10  # samples
MESH_SEEDS = range(1, 9)  # bases that other meshes are compared on
PER_MESH_BASE = 4

AUTO = {"time.step": '"auto"'}  # with the paper's integrator
AUTO_VERLET = {**AUTO, "time.integrator": '"verlet"'}
CAMPAIGN = Run("campaign", "seed 2026, 5 ns", 200, source="paper")
IMMEDIATE = Run("steps-verlet", "seed 2026, `auto`, `verlet`", 48, AUTO_VERLET, reference="campaign", source="paper")
OWN = Run("own", "`base = \"own\"`", 200, {**AUTO, "mesh.base": '"own"'}, reference="campaign", source="paper")
SECOND_BASE = Run("campaign-2012", "seed 2012, `auto`", 200, {**AUTO, "ensemble.seed": "2012"}, reference="campaign", source="paper")
FIRST_BASE = Run("base-2012", "2012", 200, UNTURNED)
FROM_ZERO = Run("clock-from-zero", "5 ns, `bilateral4`", 200, reference="clock-from-zero")
FAST_FROM_ZERO = Run("fast", "`auto` (47 ns), `verlet`", 100, FAST, reference="clock-from-zero")


def _on_bases(name: str, label: str, keys: dict[str, str], tables: str = "", source: str = "paper/clock-from-zero") -> list[Run]:
    """One setting on several bases; the runs have the label in common."""
    return [Run(f"{name}-base-{seed}", label, PER_MESH_BASE, {**FAST, **keys, "ensemble.seed": str(seed)}, tables=tables,
                source=source)
            for seed in MESH_SEEDS]


def _spacing(spacing: float, scaled: bool) -> list[Run]:
    """Another spacing at the notch tips [mm], with the paper's strength or with the one that keeps the toughness."""
    keys = {"mesh.notch_spacing": f'"{spacing:g} mm"'}
    name, label = f"spacing-{spacing:g}", f"{spacing:g} mm at the tips"
    if scaled:
        strength = 35 * math.sqrt(0.3 / spacing)  # toughness ~ strength^2 spacing
        keys["fracture.strength"] = f'"{strength:.2f} MPa"'
        name, label = f"{name}-scaled", f"{label}, σ₀ = {strength:.1f} MPa"
    return _on_bases(name, label, keys)


def _rate(rate: float, overload: float, samples: int) -> Run:
    # Long enough for the load to come to the notches and for the cracks to run through after it.
    duration = overload * PAPER_LOAD / rate * 1e6 + 250
    keys = {**FAST, "time.start": '"rest"', "time.duration": f'"{duration:.0f} us"'}
    exponent = math.floor(math.log10(rate) + 1e-9)
    factor = round(rate / 10 ** exponent)
    return Run(f"rate-{factor}e{exponent}", f"{factor}·10{'⁰¹²³⁴⁵⁶⁷⁸⁹'[int(exponent)]} N/s", samples, keys, rate=rate, load=0.0, source="paper")


STUDY_DISTANCE, STUDY_DEPTH = 7.0, 3.0  # of the notches in jobs/paper/study.toml [mm]


def _varied(name: str, label: str, keys: dict[str, str | None] | None = None, samples: int = 8, **more: object) -> Run:
    """A change of jobs/paper/study.toml; the samples are of the study's own seed."""
    return Run(f"branching-{name}", label, samples, {**FAST, "ensemble.seed": STUDY_SEED, **(keys or {})},
               **{"source": "paper/study", **more})


def _corridor(spacing: float) -> str:
    """The cracks' way at one spacing [mm]."""
    return f'\n[[mesh.region]]\nz = ["62 mm", "78 mm"]\nspacing = "{spacing:g} mm"\n'


VARIATION = """
[fracture.variation]
distribution = "weibull"
modulus = 10
correlation_length = "2 mm"
"""

STUDY_SEED = "1"
UNIFORM = {"mesh.growth": "0.1"}  # outside the corridor
STRENGTH = {"fracture.toughness": None, "fracture.strength": '"35 MPa"'}
EQUILIBRIUM = {"time.start": '"equilibrium"'}

STUDIES: dict[str, list[Run]] = {
    "branching": [
        _varied("center", "7 mm apart, 3 mm deep, 72.5 J/m²", samples=16),
        _varied("weaker", "2.75 mm deep, 66 J/m²", {"fracture.toughness": '"66 J/m^2"'}, samples=16, depth=2.75,
                distance=STUDY_DISTANCE),
        _varied("chosen", "6 mm apart, 2.5 mm deep, 59.2 J/m²", {"fracture.toughness": '"59.2 J/m^2"'},
                samples=16, depth=2.5, distance=6.0),
        *(_varied(f"distance-{d:g}", f"{d:g} mm apart", depth=STUDY_DEPTH, distance=d) for d in (3.0, 5.0, 10.0, 15.0)),
        *(_varied(f"depth-{d:g}", f"{d:g} mm deep", depth=d, distance=STUDY_DISTANCE) for d in (2.5, 3.5)),
        _varied("own", "`base = \"own\"`", {"mesh.base": '"own"'}, samples=16),
        _varied("thin", "1 mm thick", thickness=1.0),
        _varied("thin-fine", "1 mm thick, 0.15 mm at the tips", {"mesh.notch_spacing": '"0.15 mm"'}, thickness=1.0),
        *(_varied(f"corridor-{h:g}", f"{h:g} mm all the way", UNIFORM, tables=_corridor(h)) for h in (0.7, 0.5, 0.4, 0.3)),
        _varied("from-zero", "clock from no load: 5.5 mm deep, 5 mm apart", depth=5.5, distance=5.0, load=0.0),
        *(_varied(f"overload-{d:g}", f"all start at 516 N: 5.5 mm deep, {d:g} mm apart", EQUILIBRIUM, depth=5.5, distance=d,
                  load=516.0) for d in (5.0, 10.0)),
        _varied("overload-strength", "the same, 5 mm apart, 35 MPa", {**EQUILIBRIUM, **STRENGTH}, depth=5.5, distance=5.0,
                load=516.0),
        _varied("strength", "35 MPa, 0.3 mm all the way", {**UNIFORM, **STRENGTH}, tables=_corridor(0.3)),
    ],
    "notches": [Run(f"depth-{depth:g}-distance-{distance:g}", f"{depth:g} mm, {distance:g} mm",
                    42 if (depth, distance) == (5.6, 5) else 12, UNTURNED, depth, distance)
                for distance, depths in DEPTHS_AT_DISTANCE.items() for depth in depths],
    "bases": [FIRST_BASE,
              *(Run(f"base-{seed}", f"{seed}", PER_BASE, {**UNTURNED, "ensemble.seed": str(seed)}) for seed in SEEDS)],
    "campaign": [CAMPAIGN],
    "own": [OWN],
    "second-base": [SECOND_BASE],
    # As in the campaign t0 is the paper's; the process zone is long enough for the campaign's mesh.
    "softening": [Run("softening", "softening, 14 MPa, 81 J/m²", 24,
                      {**AUTO_VERLET, "fracture.release": '"softening"', "fracture.strength": '"14 MPa"',
                       "fracture.toughness": '"81 J/m^2"'}, reference=IMMEDIATE.name, source="paper")],
    "strength": [Run("strength", "35 MPa", 48, {**AUTO, **STRENGTH}, reference="campaign", source="paper")],
    # The campaign's bodies with larger steps.
    "steps": [Run("steps-auto", "seed 2026, `auto`", 48, AUTO, reference="campaign", source="paper"),
              IMMEDIATE],
    "clock-from-zero": [FROM_ZERO],
    "convergence": [
        FAST_FROM_ZERO,
        Run("step-2.5ns", "2.5 ns, `bilateral4`", 12, {"time.step": '"2.5 ns"', "output.frames": "2"}, reference="clock-from-zero"),
        Run("bilateral4-auto", "`auto` (37 ns), `bilateral4`", 24, {"time.step": '"auto"', "output.frames": "2"},
            reference="clock-from-zero"),
        Run("verlet-5ns", "5 ns, `verlet`", 24, {"time.integrator": '"verlet"', "output.frames": "2"}, reference="clock-from-zero"),
        Run("memory-step", "5 ns, `verlet`, `memory = \"step\"`", 12,
            {"time.integrator": '"verlet"', "fracture.memory": '"step"', "output.frames": "2"}, reference="verlet-5ns"),
        Run("double", "`precision = \"double\"`", 20, {**FAST, "time.precision": '"double"'}),
        Run("facet", "`release = \"facet\"`", 24, {**FAST, "fracture.release": '"facet"'}),
        Run("duration", "200 µs", 12, {**FAST, "time.duration": '"200 us"'}),
    ],
    "spacing": [*(run for spacing in (0.4, 0.24) for scaled in (False, True) for run in _spacing(spacing, scaled)),
                *_on_bases("growth-0.1", "0.1 mm coarser per mm from the tips", {"mesh.growth": "0.1"})],
    "disturbance": [run for p in PERTURBATIONS
                    for run in _on_bases(f"perturbation-{p:g}", f"{p:g}", {"mesh.perturbation": f"{p:g}"}, source="paper")],
    "heterogeneity": [*_on_bases("strength-varies", "strength alone", {"mesh.perturbation": "0"}, VARIATION, "paper"),
                      *_on_bases("both-vary", "mesh and strength", {}, VARIATION, "paper")],
    "rate": [_rate(rate, overload, samples) for rate, (overload, samples) in RATES.items()],
}
STUDY_OF = {run.name: study for study, runs in STUDIES.items() for run in runs}
