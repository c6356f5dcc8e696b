#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes grain-map.png, as a tomogram cut into material numbers would be: 1 in grains, 0 in between; cells of 0.05 mm, rows along z.

./grains.py [seed]
"""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image

CELL, WIDTH, LENGTH = 0.05, 16.0, 16.0  # [mm]
RADII, GAP, SHARE = (0.6, 1.4), 0.5, 0.35  # of grains [mm], least distance between two [mm], share of the area
LEFT, SLOT = 4.0, 0.6  # y [mm] up to which there is a notch, and its half of the height that stays free


def grains(seed: int) -> np.ndarray:
    """Rounded polygons that do not touch, placed at random: n_z x n_y."""
    draws = np.random.default_rng(seed)
    y, z = np.meshgrid(np.arange(CELL / 2, WIDTH, CELL), np.arange(CELL / 2, LENGTH, CELL))
    taken = np.zeros(y.shape, np.uint8)
    distance = np.where((y < LEFT + SLOT) & (np.abs(z - LENGTH / 2) < SLOT), 0.0, np.inf)  # to the nearest grain
    while taken.mean() < SHARE:
        radius, middle = draws.uniform(*RADII), draws.uniform((0, 0), (WIDTH, LENGTH))
        lobes = draws.uniform(0, 0.15, 3), draws.uniform(0, 2 * np.pi, 3)
        angle = np.arctan2(z - middle[1], y - middle[0])
        edge = radius * (1 + sum(size * np.cos(k * angle + phase) for k, (size, phase) in enumerate(zip(*lobes), start=2)))
        beyond = np.hypot(y - middle[0], z - middle[1]) - edge
        if (distance[beyond < 0] > GAP).all():
            taken[beyond < 0] = 1
            distance = np.minimum(distance, np.maximum(beyond, 0))
    return taken


if __name__ == "__main__":
    picture = Image.fromarray(grains(int(sys.argv[1]) if len(sys.argv) > 1 else 1), mode="P")
    picture.putpalette([233, 236, 239, 180, 140, 60])
    picture.save(Path(__file__).with_name("grain-map.png"), optimize=True)
