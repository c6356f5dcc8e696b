# SPDX-License-Identifier: GPL-3.0-or-later
"""Kalthoff and Winkler's impact on a plate with a slot: when its crack starts, where it goes and how fast."""
from __future__ import annotations

import math
from pathlib import Path

import crackle
import numpy as np

from crackle_runs import JOBS, median_range, run, with_keys
from figures import MILLIMETRE, Figure

TIP = np.array([50, 25.75]) * MILLIMETRE
GROWN, NEAR, STRAY = 1 * MILLIMETRE, 12 * MILLIMETRE, 10 * MILLIMETRE
RELEASES = {"immediate release": '"0 s"', "release in 0.4 µs": '"0.4 us"'}  # PMMA's 0.15 µs at 0.25 mm, in proportion to spacing over Rayleigh's speed


def start_and_angle(sample: crackle.Sample) -> tuple[float, float]:
    """When the crack has grown by GROWN [µs], and the angle to the slot of the line from its tip through its facets within NEAR [degrees]."""
    place = sample.crack_surface.corners.values[:, :, 1:].mean(axis=1) - TIP
    distance = np.hypot(*place.T)
    grown = sample.crack_surface.time.values[(distance > GROWN) & (distance < NEAR)]
    near = place[(distance > GROWN) & (distance < NEAR)]
    return 1e6 * (float(grown.min()) if len(grown) else math.nan), math.degrees(math.atan2(*near.mean(axis=0)[::-1])) if len(near) else math.nan


def has_false_crack(sample: crackle.Sample) -> bool:
    """Whether a crack of more than STRAY started elsewhere than at the slot."""
    with sample.open() as root:
        cracks = root["crack_surface/cracks"]
        notch, crack = cracks["notch"][...], root["crack_surface/crack"][...]
    corners = sample.crack_surface.corners.values[:, :, 1:]
    return any(np.ptp(corners[crack == number].reshape(-1, 2), axis=0).max() > STRAY
               for number in np.flatnonzero(notch < 0) if (crack == number).any())


def kalthoff(folder: Path, program: Path) -> list[Figure]:
    references = {"the crack has grown by 1 mm after": "some 25 µs in computations", "angle to the slot over its first 12 mm": "70°, Kalthoff 2000",
                  "samples with a crack from elsewhere": "none"}
    found = []
    for release, time in RELEASES.items():
        text = with_keys((JOBS / "kalthoff.toml").read_text(), {"fracture.release_time": time})
        samples = run(text, folder / f"kalthoff-{release.replace(' ', '-')}", program)
        starts, angles = zip(*map(start_and_angle, samples))
        found.append((median_range(starts, ".0f", " µs"), median_range(angles, ".0f", "°"),
                      f"{sum(map(has_false_crack, samples))} of {len(samples)}"))
    case = f"Kalthoff and Winkler's impact, {' and '.join(RELEASES)}"
    return [Figure(case, quantity, "; ".join(both), reference) for (quantity, reference), both in zip(references.items(), zip(*found))]
