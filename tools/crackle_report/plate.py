# SPDX-License-Identifier: GPL-3.0-or-later
"""The notched plate in the YZ plane."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Notch:
    """A slot through the whole thickness, cut into one of the faces y-min, y-max, z-min and z-max [m]."""

    face: str
    at: float
    depth: float
    height: float


@dataclass(frozen=True)
class MeshRegion:
    """A box in which the mesh is fine: its extents along x, y and z, and the spacing in it [m]."""

    box: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    spacing: float


@dataclass(frozen=True)
class Plate:
    """The specimen: a box (x = thickness, y = width, z = length) with slots [m]."""

    size: tuple[float, float, float]
    notches: tuple[Notch, ...]

    def tip(self, notch: int) -> tuple[float, float]:
        """Middle of a slot's bottom, (y, z)."""
        slot = self.notches[notch]
        return self._in_plane(slot.face, slot.at, slot.depth)

    def slot_range(self, notch: int) -> tuple[float, float]:
        """Lowest and highest z of a slot."""
        slot = self.notches[notch]
        ends = [self._in_plane(slot.face, slot.at + side * slot.height / 2, depth)[1]
                for side in (-1, 1) for depth in (0.0, slot.depth)]
        return min(ends), max(ends)

    def outline(self) -> np.ndarray:
        """The closed polygon of the plate with its slots, n x 2 (y, z)."""
        points = []
        # Counter-clockwise; on the last two faces the coordinate along the face falls.
        for face, along, falling in (("z-min", 1, False), ("y-max", 2, False),
                                     ("z-max", 1, True), ("y-min", 2, True)):
            walk = [(0.0, 0.0)]
            for slot in sorted((n for n in self.notches if n.face == face), key=lambda n: n.at):
                low, high = slot.at - slot.height / 2, slot.at + slot.height / 2
                walk += [(low, 0.0), (low, slot.depth), (high, slot.depth), (high, 0.0)]
            walk.append((self.size[along], 0.0))
            points += [self._in_plane(face, at, depth) for at, depth in (reversed(walk) if falling else walk)]
        return np.array(points)

    def _in_plane(self, face: str, at: float, depth: float) -> tuple[float, float]:
        """(y, z) of the point at `depth` below `face`, at the coordinate `at` along it."""
        _, width, length = self.size
        return {"y-min": (depth, at), "y-max": (width - depth, at),
                "z-min": (at, depth), "z-max": (at, length - depth)}[face]
