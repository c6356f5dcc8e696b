# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of the paper's studies: round-slots.toml with other notches, toughnesses, releases and meshes."""
from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from crackle_runs import RunError, run, with_keys

PAPER = Path(__file__).resolve().parent
WIDTH, LENGTH, THICKNESS = 24.5, 140, 5  # of the plate [mm]
BESIDE = 5  # of the notches, how far the fine mesh goes [mm]
SHARP, DEEPER = 0.2, 0.4  # height of the slots that stand for sharp cracks, and by how much their energies are compared [mm]
SHARP_LOAD = 500  # at which that is done [N]


@dataclass(frozen=True)
class Point:
    """A plate: that of round-slots.toml with other values."""

    distance: float = 6  # of the notches along z [mm]
    depth: float = 3.3  # [mm]
    toughness: float = 28  # [J/m^2]
    spacing: float = 0.6  # where cracks run [mm]; at the slots' ends there are three cells over their height on all meshes
    release: str = "by-speed"  # or immediate; with both, strength counts where no crack is near, for means around nodes

    @property
    def name(self) -> str:
        changed = [field.name for field in fields(self) if getattr(self, field.name) != field.default]
        return "-".join(getattr(self, name) if name == "release" else f"{name}-{getattr(self, name):g}" for name in changed) or "base"

    @property
    def notches(self) -> tuple[float, float]:
        """Their places along z [mm]."""
        return (LENGTH - self.distance) / 2, (LENGTH + self.distance) / 2

    @cached_property
    def text(self) -> str:
        """The input; with frames only where fringes are looked at."""
        text = (PAPER / "round-slots.toml").read_text()
        low, high = self.notches
        for old, new in (('"67 mm"', f'"{low:g} mm"'), ('"73 mm"', f'"{high:g} mm"'), ('"3.3 mm"', f'"{self.depth:g} mm"'),
                         ('"21.2 mm"', f'"{WIDTH - self.depth:g} mm"'), ('["62 mm", "78 mm"]', f'["{low - BESIDE:g} mm", "{high + BESIDE:g} mm"]')):
            if old not in text:
                raise RunError(f"round-slots.toml has no {old}, which the studies change")
            text = text.replace(old, new)
        keys = {"fracture.toughness": f'"{self.toughness:g} J/m^2"', "mesh.region.spacing": f'"{self.spacing:g} mm"'}
        if self.release == "immediate":
            keys |= {"fracture.release_speed": None, "fracture.release_time": '"0 s"'}
        if self != BASE:
            keys["output.frames"] = "8" if self in MESHES else "0"
        return with_keys(text, keys)

    def with_sharp_slots(self, depth: float) -> str:
        """The input of the body without breaks, with slots of this depth [mm] that are as sharp as the mesh, under SHARP_LOAD."""
        slots = "".join(f'[[specimen.notch]]\nface = "{face}"\nat = "{z:g} mm"\ndepth = "{depth:g} mm"\nheight = "{SHARP} mm"\n'
                        for face, z in zip(("y-min", "y-max"), self.notches))
        text = re.sub(r"(?s)\[\[specimen\.notch\]\].*(?=\n\[mesh\])", slots, self.text)
        text = re.sub(r"(?m)^force = .*\nrate = .*$", f'force = ["0 N", "0 N", "{SHARP_LOAD} N"]', text)
        return with_keys(text, {"ensemble.samples": "2", "mesh.notch_spacing": f'"{SHARP} mm"', "mesh.region.spacing": f'"{BASE.spacing} mm"',
                                "fracture.strength": '"100 GPa"', "fracture.toughness": None, "fracture.release_speed": None,
                                "fracture.release_time": None, "time.duration": '"0.1 us"', "output.frames": "0"})

    def sharp_load(self, folder: Path, program: Path) -> float:
        """Load at which the toughness is the energy release rate of sharp cracks as deep as the slots, by the energies of two depths [N]."""
        name = f"sharp-{self.distance:g}-{self.depth:g}"
        energies = [[sample.energy.strain[-1] for sample in run(self.with_sharp_slots(self.depth + change), folder / f"{name}{change:+g}", program)]
                    for change in (-DEEPER, DEEPER)]
        shallow, deep = np.mean(energies, axis=1)
        rate = (deep - shallow) / (2 * 2 * DEEPER * THICKNESS * 1e-6)  # of both cracks
        return SHARP_LOAD * math.sqrt(self.toughness / rate)


BASE = Point()
TOUGHNESSES = (20, 28, 34, 40, 57, 72)  # [J/m^2]
DISTANCES = tuple(replace(BASE, distance=distance) for distance in (3, 6, 10, 15))
DEPTHS = tuple(replace(BASE, depth=depth) for depth in (2.5, 3.3, 4.5))
BY_SPEED = tuple(replace(BASE, toughness=toughness) for toughness in TOUGHNESSES)
AT_ONCE = tuple(replace(point, release="immediate") for point in BY_SPEED)
MESHES = tuple(replace(BASE, spacing=spacing) for spacing in (0.9, 0.6, 0.4, 0.3))
