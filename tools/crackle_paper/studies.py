# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of each study, as changes of jobs/paper.toml.

Runs with the paper's seed, body and mesh section have the same bodies: two settings can be compared sample by sample. What
changes the mesh changes the base distribution of mother points too, and bases differ; so such settings are computed on
several bases, and the base is the unit of comparison.
"""
from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from crackle_verification.runs import with_keys

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

    def input_text(self, paper: str) -> str:
        text = with_keys(paper, {"ensemble.samples": str(self.samples), **self.keys})
        if self.depth is not None:
            text = re.sub(r"(?m)^depth = .*$", f'depth = "{self.depth:g} mm"', text)
        if self.distance is not None:
            places = iter((70 - self.distance / 2, 70 + self.distance / 2))
            text = re.sub(r"(?m)^at = .*$", lambda _: f'at = "{next(places):g} mm"', text)
        if self.rate is not None:
            text = re.sub(r"(?m)^rate = .*$", f'rate = ["0 N/s", "0 N/s", "{self.rate:g} N/s"]', text)
        return text


TARGET_LOAD = 380.9  # [N]: the paper's t0 = 76.179191 s at 5 N/s
DISTANCE = 5.0  # of the notches [mm], as in jobs/paper.toml
DEPTHS_AT_DISTANCE = {3.0: (5.6,), 4.0: (5.6,), 5.0: (4.0, 5.0, 5.2, 5.4, 5.6, 5.8), 7.0: (5.2,),
                      10.0: (2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0), 15.0: (5.2,), 20.0: (5.2,)}  # [mm]
PERTURBATION = 0.2  # in jobs/paper.toml
PERTURBATIONS = (0.001, 0.01, 0.05, 0.1, 0.3)
RATES = {3e5: 1.2, 1e6: 1.5, 3e6: 1.5, 1e7: 1.5}  # [N/s]: duration, in times that the load takes to that of slow loading
SEEDS = range(1, 13)
PER_BASE = 10  # samples
MESH_SEEDS = range(1, 9)  # bases that other meshes are compared on
PER_MESH_BASE = 4

CAMPAIGN = Run("campaign", "5 ns, `bilateral4`", 200, reference="campaign")
FAST_CAMPAIGN = Run("fast", "`auto` (47 ns), `verlet`", 100, FAST, reference="campaign")


def _on_bases(name: str, label: str, keys: dict[str, str]) -> list[Run]:
    """One setting on several bases; the runs have the label in common."""
    return [Run(f"{name}-base-{seed}", label, PER_MESH_BASE, {**FAST, **keys, "ensemble.seed": str(seed)})
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


def _rate(rate: float, overload: float) -> Run:
    # Long enough for the load to come to the notches and for the cracks to run through after it.
    duration = overload * TARGET_LOAD / rate * 1e6 + 250
    keys = {**FAST, "time.start": '"rest"', "time.duration": f'"{duration:.0f} us"'}
    exponent = math.floor(math.log10(rate) + 1e-9)
    factor = round(rate / 10 ** exponent)
    return Run(f"rate-{factor}e{exponent}", f"{factor}·10^{exponent} N/s", 24 if rate < 1e6 else 40, keys, rate=rate)


STUDIES: dict[str, list[Run]] = {
    "notches": [Run(f"depth-{depth:g}-distance-{distance:g}", f"{depth:g} mm, {distance:g} mm",
                    42 if (depth, distance) == (5.6, 5) else 12, UNTURNED, depth, distance)
                for distance, depths in DEPTHS_AT_DISTANCE.items() for depth in depths],
    "bases": [Run("base-2012", "2012", 200, UNTURNED),
              *(Run(f"base-{seed}", f"{seed}", PER_BASE, {**UNTURNED, "ensemble.seed": str(seed)}) for seed in SEEDS)],
    "campaign": [CAMPAIGN],
    "convergence": [
        FAST_CAMPAIGN,
        Run("step-2.5ns", "2.5 ns, `bilateral4`", 12, {"time.step": '"2.5 ns"', "output.frames": "2"}, reference="campaign"),
        Run("bilateral4-auto", "`auto` (37 ns), `bilateral4`", 24, {"time.step": '"auto"', "output.frames": "2"},
            reference="campaign"),
        Run("verlet-5ns", "5 ns, `verlet`", 24, {"time.integrator": '"verlet"', "output.frames": "2"}, reference="campaign"),
        Run("memory-step", "5 ns, `verlet`, `memory = \"step\"`", 12,
            {"time.integrator": '"verlet"', "fracture.memory": '"step"', "output.frames": "2"}, reference="verlet-5ns"),
        Run("double", "`precision = \"double\"`", 20, {**FAST, "time.precision": '"double"'}),
        Run("facet", "`release = \"facet\"`", 24, {**FAST, "fracture.release": '"facet"'}),
        Run("duration", "200 µs", 12, {**FAST, "time.duration": '"200 us"'}),
    ],
    "spacing": [*(run for spacing in (0.4, 0.24) for scaled in (False, True) for run in _spacing(spacing, scaled)),
                *_on_bases("growth-0.1", "0.1 mm coarser per mm from the tips", {"mesh.growth": "0.1"})],
    "disturbance": [run for p in PERTURBATIONS
                    for run in _on_bases(f"perturbation-{p:g}", f"{p:g}", {"mesh.perturbation": f"{p:g}"})],
    "rate": [_rate(rate, overload) for rate, overload in RATES.items()],
}
