# SPDX-License-Identifier: GPL-3.0-or-later
"""What one sample of a finer and thicker slotted plate takes with immediate release and with softening."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py

from crackle_readme import put_block
from crackle_runs import markdown, with_keys

import convergence

THICKNESS, SPACING = 2.4, 0.07  # [mm]
TOUGHNESS = {"fracture.strength": None, "fracture.toughness": '"150 J/m^2"'}


@dataclass(frozen=True)
class Run:
    title: str
    law: str
    keys: dict[str, str | None]

    def input_text(self) -> str:
        return with_keys(convergence.slot_text(self.law, SPACING),
                         {"ensemble.samples": "1", "specimen.size": f'["{THICKNESS:g} mm", "24.5 mm", "50 mm"]', **self.keys})


RUNS = {"cost-strength": Run("immediate, 35 MPa", "immediate", {}),
        "cost-toughness": Run("immediate, 150 J/m²", "immediate", TOUGHNESS),
        "cost-softening": Run("softening, 10 teeth", "softening", {})}


def table(folder: Path) -> str:
    """One line for each run that is in `folder`."""
    lines = []
    for name, one in RUNS.items():
        for file in sorted((folder / name / "out" / "samples").glob("*.h5")):
            with h5py.File(file) as root:
                counts, timing = root["counts"], root["timing"]
                lines.append([one.title, f"{len(root['mesh/tetrahedra']):,}", f"{counts['static_solves'][()]:,}",
                              f"{timing['quasi_static'][()]:.0f} s", f"{counts['steps'][()]:,}", f"{timing['dynamic'][()]:.0f} s"])
    return markdown(["law", "tetrahedra", "equilibria", "quasi-static part", "dynamic steps", "dynamic part"], lines)


def keep(folder: Path, _: Path) -> None:
    """Puts the table into the README, unless a run is missing."""
    text = table(folder)
    if text.count("\n") == 2 + len(RUNS):
        put_block("laws-cost", text)
