# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of each study, as changes of jobs/paper.toml.

Every run is an ensemble with the paper's seed, so that sample i of two runs with the same mesh section is the same
body, and two settings can be compared sample by sample.
"""
from __future__ import annotations

import re
from dataclasses import dataclass, field

from crackle_verification.runs import with_keys

FAST = {"time.integrator": '"verlet"', "time.step": '"auto"', "output.frames": "2"}
"""A time integration that gives the same statistics, see the study `convergence`, at a quarter of the cost."""


@dataclass(frozen=True)
class Run:
    name: str
    label: str
    samples: int
    keys: dict[str, str] = field(default_factory=dict)
    depth: float | None = None  # of both notches [mm]; else the input's
    distance: float | None = None  # of their mid-planes along the plate [mm]; else the input's

    def input_text(self, paper: str) -> str:
        text = with_keys(paper, {"ensemble.samples": str(self.samples), **self.keys})
        if self.depth is not None:
            text = re.sub(r"(?m)^depth = .*$", f'depth = "{self.depth:g} mm"', text)
        if self.distance is not None:
            places = iter((70 - self.distance / 2, 70 + self.distance / 2))
            text = re.sub(r"(?m)^at = .*$", lambda _: f'at = "{next(places):g} mm"', text)
        return text


DEPTHS = (3.5, 4.0, 4.5, 5.0, 6.0)  # [mm]
DISTANCE = 10.0  # [mm]

STUDIES: dict[str, list[Run]] = {
    "depth": [Run(f"depth-{depth:g}", f"depth {depth:g} mm", 12, FAST, depth=depth, distance=DISTANCE)
              for depth in DEPTHS],
}
