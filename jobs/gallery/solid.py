#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes round bars with their faces in groups, lengths in mm, axis along z: solid.obj, with conical shoulders and a blind bore,
and twisted-rod.obj, whose upper head is held at four quarters.

./solid.py [number of sides]
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Sequence

import numpy as np

PROFILE = ((0.0, 5.0), (6.0, 5.0), (9.0, 3.0), (21.0, 3.0), (24.0, 5.0), (30.0, 5.0))  # z, radius of each ring
BORE, TOP = 1.2, 27.0  # radius of a blind hole along the axis from above, z of its bottom
ROD = ((0.0, 4.5), (4.0, 4.5), (6.5, 2.5), (24.5, 2.5), (27.0, 4.5), (31.0, 4.5))  # likewise z and radius
Polygons = list[tuple[str, list[int]]]


def bands(n: int, profile: Sequence[tuple[float, float]], groups: Sequence[str]) -> tuple[list[np.ndarray], Polygons]:
    """Points of the rings of a profile, and the polygons between them with their groups, outward."""
    turn = 2 * np.pi * (np.arange(n) + 0.5) / n
    points = [np.array((radius * np.cos(angle), radius * np.sin(angle), z)) for z, radius in profile for angle in turn]
    return points, [(group, [k * n + i, k * n + (i + 1) % n, (k + 1) * n + (i + 1) % n, (k + 1) * n + i])
                    for k, group in enumerate(groups) for i in range(n)]


def bored(n: int) -> tuple[list[np.ndarray], Polygons]:
    """The bar of solid.obj."""
    groups = ("lower-grip", "shoulder", "gauge", "shoulder", "upper-grip", "upper-end", "bore")
    # From the rim of the upper end inward, down into the bore.
    points, polygons = bands(n, (*PROFILE, (PROFILE[-1][0], BORE), (TOP, BORE)), groups)
    polygons.append(("lower-end", list(range(n))[::-1]))
    polygons.append(("bore", list(range(len(points) - n, len(points)))))
    return points, polygons


def twisted(n: int) -> tuple[list[np.ndarray], Polygons]:
    """The bar of twisted-rod.obj: quarter-0 of the upper head faces x, the others follow counter-clockwise."""
    points, polygons = bands(n, ROD, ("lower-grip", "shoulder", "gauge", "shoulder", "quarter"))
    last = len(polygons) - n
    polygons[last:] = [(f"quarter-{(8 * (i + 1) + n) // (2 * n) % 4}", corners) for i, (_, corners) in enumerate(polygons[last:])]
    polygons.append(("lower-end", list(range(n))[::-1]))
    polygons.append(("upper-end", list(range(len(points) - n, len(points)))))
    return points, polygons


def text(points: list[np.ndarray], polygons: Polygons) -> str:
    lines = ["# by solid.py", *(f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in points)]
    for group, corners in polygons:
        lines += [f"g {group}", "f " + " ".join(str(corner + 1) for corner in corners)]
    return "\n".join(lines) + "\n"


FILES = {"solid.obj": bored, "twisted-rod.obj": twisted}

if __name__ == "__main__":
    for name, bar in FILES.items():
        Path(__file__).with_name(name).write_text(text(*bar(int(sys.argv[1]) if len(sys.argv) > 1 else 24)), encoding="ascii")
