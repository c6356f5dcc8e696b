# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a sample, with what the pictures need of it."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np

EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
FACES = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))


def gradients(corner: np.ndarray) -> np.ndarray:
    """Of the shape functions of tetrahedra with these corners, m x 4 x 3."""
    inverse = np.linalg.inv(corner[:, 1:] - corner[:, :1]).transpose(0, 2, 1)
    return np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)


def field_gradient(corner: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Of the linear field with these values at the corners of tetrahedra, both m x 4 x 3: derivative along i of component j,
    m x 3 x 3."""
    x, u = corner.astype(float), values.astype(float)
    # Row i of the edges times the gradient is the difference of u along edge i.
    return np.linalg.solve(x[:, 1:] - x[:, :1], u[:, 1:] - u[:, :1])


@dataclass(frozen=True)
class Regions:
    """The parts of a body that are not of its first material, in a plane across x [m]."""

    polygons: list[np.ndarray]  # k x 2 (y, z) each, which cover them
    borders: np.ndarray  # n x 2 ends x 2 (y, z): where two materials meet


@dataclass(frozen=True)
class Mesh:
    nodes: np.ndarray  # n x 3 [m]
    tetrahedra: np.ndarray  # m x 4
    strength_factor: Optional[np.ndarray] = None  # m, by which the variation multiplies the strength
    youngs_modulus: Optional[np.ndarray] = None  # m [Pa], where it differs
    material: Optional[np.ndarray] = None  # m, numbers, where there are several

    def volumes(self) -> np.ndarray:
        """Of the tetrahedra, m [m^3]."""
        corner = self.nodes[self.tetrahedra]
        return np.abs(np.linalg.det(corner[:, 1:] - corner[:, :1])) / 6

    @property
    def surface(self) -> np.ndarray:
        """The nodes of the triangles that bound the body, n x 3."""
        faces = np.sort(self.tetrahedra[:, FACES].reshape(-1, 3), axis=1)
        found, count = np.unique(faces, axis=0, return_counts=True)
        return found[count == 1]

    def cut(self, axis: int, position: float) -> tuple[list[np.ndarray], np.ndarray]:
        """The polygons in which the plane `axis` = `position` [m] cuts the tetrahedra, each k x 2 in the other
        two axes, and the tetrahedra's numbers."""
        height = self.nodes[:, axis] - position
        above = height[self.tetrahedra] > 0
        cut = np.flatnonzero(above.any(axis=1) & ~above.all(axis=1))
        others = [i for i in range(3) if i != axis]
        polygons = []
        for number in cut:
            points = []
            for a, b in EDGES:
                i, j = self.tetrahedra[number, [a, b]]
                if (height[i] > 0) != (height[j] > 0):
                    share = height[i] / (height[i] - height[j])
                    points.append(self.nodes[i, others] + share * (self.nodes[j, others] - self.nodes[i, others]))
            polygon = np.array(points)
            offset = polygon - polygon.mean(axis=0)
            polygons.append(polygon[np.argsort(np.arctan2(offset[:, 1], offset[:, 0]))])
        return polygons, cut

    def regions(self, x: float) -> Optional[Regions]:
        """Cut at this place in the thickness [m]; None of a body of one material."""
        if self.material is None or not np.ptp(self.material):
            return None
        others = Mesh(self.nodes, self.tetrahedra[self.material > 0])
        return Regions(others.cut(0, x)[0], self._borders(x))

    def _borders(self, x: float) -> np.ndarray:
        """The lines in which the faces between two materials cut a plane across x."""
        faces = np.sort(self.tetrahedra[:, FACES].reshape(-1, 3), axis=1)
        material = np.repeat(self.material, len(FACES))
        order = np.lexsort(faces.T)
        faces, material = faces[order], material[order]
        # A face of two tetrahedra is there twice.
        between = (faces[1:] == faces[:-1]).all(axis=1) & (material[1:] != material[:-1])
        corner = self.nodes[faces[1:][between]]
        height = corner[:, :, 0] - x
        above = height > 0
        cut = above.any(axis=1) & ~above.all(axis=1)
        corner, height, above = corner[cut], height[cut], above[cut]
        # Two edges are cut: those of the corner that is alone on its side.
        alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), above.argmin(axis=1))
        row = np.arange(len(alone))
        ends = []
        for step in (1, 2):
            other = (alone + step) % 3
            share = height[row, alone] / (height[row, alone] - height[row, other])
            ends.append(corner[row, alone, 1:] + share[:, None] * (corner[row, other, 1:] - corner[row, alone, 1:]))
        return np.stack(ends, axis=1)
