# SPDX-License-Identifier: GPL-3.0-or-later
"""A box of tetrahedra."""
from __future__ import annotations

import numpy as np


def box_mesh(size: tuple[float, float, float], cells: tuple[int, int, int], disturbance: float = 0.0):
    """A box cut into cuboids of six tetrahedra each, its inner nodes moved at random: nodes, tetrahedra."""
    random = np.random.Generator(np.random.PCG64(5))
    axes = [np.arange(n + 1) for n in cells]
    index = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    step = np.array(size) / cells
    inside = (index > 0) & (index < np.array(cells))
    nodes = step * (index + disturbance * random.uniform(-1, 1, index.shape) * inside)
    strides = np.array([(cells[1] + 1) * (cells[2] + 1), cells[2] + 1, 1])
    origin = (np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 3)
              @ strides)
    tetrahedra = []
    for path in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
        corner = [np.zeros(3, int)]
        for axis in path:
            corner.append(corner[-1] + np.eye(3, dtype=int)[axis])
        tetrahedra.append(origin[:, None] + np.array([c @ strides for c in corner]))
    tetrahedra = np.concatenate(tetrahedra)
    edges = nodes[tetrahedra[:, 1:]] - nodes[tetrahedra[:, :1]]
    volume = np.abs(np.linalg.det(edges)).sum() / 6
    assert abs(volume / np.prod(size) - 1) < 1e-12, "the disturbance turns tetrahedra inside out"
    return nodes, tetrahedra
