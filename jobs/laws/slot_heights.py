# SPDX-License-Identifier: GPL-3.0-or-later
"""Slots of several heights in plane strain, with softening and with averaged stress, beside two criteria for a start of cracks."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from crackle_readme import put_block
from crackle_runs import markdown, mean_interval, with_keys

import convergence
from plane_slot import Plate, coupled_load, cohesive_load

HEIGHTS = (0.1, 0.2, 0.3, 0.6, 1.2)  # [mm]
SPACINGS = {"softening": 0.1, "averaged": 0.15}  # [mm]
PLANE_STRAIN = "".join(f'[[boundary]]\non = "{face}"\nfix = ["x"]\n' for face in ("x-min", "x-max"))
# Of slot.toml and LAWS, in SI units.
THICKNESS = 0.6e-3
YOUNGS_MODULUS, POISSON_RATIO, STRENGTH, LENGTH = 3.3e9, 0.38, 35e6, 0.6e-3
# As src/fracture/README.md has it.
AVERAGED_TOUGHNESS = 3.05 * (1 + POISSON_RATIO) * (1 - 2 * POISSON_RATIO)**0.34 * STRENGTH**2 / YOUNGS_MODULUS * LENGTH
TOUGHNESS = {"softening": 150.0, "averaged": AVERAGED_TOUGHNESS}


@dataclass(frozen=True)
class Run:
    law: str
    height: float  # of the slot [mm]

    def input_text(self) -> str:
        margin = 0.4 + self.height / 2
        text = with_keys(convergence.slot_text(self.law, SPACINGS[self.law]),
                         {"ensemble.samples": "8", "specimen.notch.height": f'"{self.height:g} mm"',
                          "mesh.region.z": f'["{25 - margin:g} mm", "{25 + margin:g} mm"]', "time.duration": '"1 us"',
                          "time.arrest": '"0.5 us"', "sections.y": '["6 mm"]'})
        return text + "\n" + PLANE_STRAIN


RUNS = {f"slot-{law}-{height:g}": Run(law, height) for law in SPACINGS for height in HEIGHTS}


def plate(height: float) -> Plate:
    return Plate(24.5e-3, 50e-3, 5.5e-3, 1e-3 * height, YOUNGS_MODULUS, POISSON_RATIO)


def keep(folder: Path, kept: Path) -> None:
    """Puts the table into the README, unless a run is missing or has not ended."""
    if not all((folder / name / "done").is_file() for name in RUNS):
        return
    lines = []
    for name, one in RUNS.items():
        loads = []
        for file in sorted((folder / name / "out" / "samples").glob("*.h5")):
            with h5py.File(file) as root:
                loads.append(convergence.load_at_run_away(root))
        load, width = mean_interval(np.array(loads))
        corner = 0.5e-3 * one.height
        cohesive, coupled = (THICKNESS * criterion(plate(one.height), corner, STRENGTH, TOUGHNESS[one.law])
                             for criterion in (cohesive_load, coupled_load))
        lines.append([f"{one.law}, {SPACINGS[one.law]:g} mm", f"{one.height:g} mm", str(len(loads)), f"{load:.1f} ± {width:.1f}",
                      f"{cohesive:.1f}", f"{load / cohesive:.2f}", f"{coupled:.1f}", f"{load / coupled:.2f}"])
    put_block("laws-slots", markdown(["law, spacing", "slot's height", "samples", "load at the last break [N]",
                                      "cohesive zone [N]", "ratio", "coupled criterion [N]", "ratio"], lines))
