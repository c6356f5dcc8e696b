#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes solid.obj: a round test bar with conical shoulders and a blind bore, its faces in groups; lengths in mm, axis along z.

./solid.py [number of sides]
"""
from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

PROFILE = ((0.0, 5.0), (6.0, 5.0), (9.0, 3.0), (21.0, 3.0), (24.0, 5.0), (30.0, 5.0))  # z, radius of each ring
BORE, TOP = 1.2, 27.0  # radius of a blind hole along the axis from above, z of its bottom


def rings(n: int) -> tuple[list[np.ndarray], list[tuple[str, list[int]]]]:
    """Points, and polygons with their groups, outward."""
    turn = 2 * np.pi * (np.arange(n) + 0.5) / n
    points: list[np.ndarray] = []
    first = {}
    for name, z, radius in [*((k, z, r) for k, (z, r) in enumerate(PROFILE)), ("mouth", PROFILE[-1][0], BORE), ("bottom", TOP, BORE)]:
        first[name] = len(points)
        points += [np.array((radius * np.cos(angle), radius * np.sin(angle), z)) for angle in turn]
    polygons: list[tuple[str, list[int]]] = []

    def band(group: str, lower: int, upper: int, inward: bool = False) -> None:
        for i in range(n):
            k = (i + 1) % n
            quadrilateral = [lower + i, lower + k, upper + k, upper + i]
            polygons.append((group, quadrilateral[::-1] if inward else quadrilateral))

    groups = ("lower-grip", "shoulder", "gauge", "shoulder", "upper-grip")
    for k, group in enumerate(groups):
        band(group, first[k], first[k + 1])
    band("bore", first["bottom"], first["mouth"], inward=True)
    band("upper-end", first[len(PROFILE) - 1], first["mouth"])
    polygons.append(("lower-end", [first[0] + i for i in range(n)][::-1]))
    polygons.append(("bore", [first["bottom"] + i for i in range(n)]))
    return points, polygons


def text(n: int) -> str:
    points, polygons = rings(n)
    lines = ["# by solid.py", *(f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in points)]
    for group, corners in polygons:
        lines += [f"g {group}", "f " + " ".join(str(corner + 1) for corner in corners)]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name("solid.obj").write_text(text(int(sys.argv[1]) if len(sys.argv) > 1 else 24), encoding="ascii")
