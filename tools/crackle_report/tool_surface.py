# SPDX-License-Identifier: GPL-3.0-or-later
"""The surfaces of rigid tools as quadrilaterals."""
from __future__ import annotations

import numpy as np

from .fields import Tool, axes_around

AROUND, ARC = 48, 12  # quadrilaterals around an axis, and along a half or quarter circle


def tool_surface(tool: Tool, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of a tool at the start (n x 3) [m] and its quadrilaterals (m x 4).

    A plane and an endless cylinder reach beyond the body, whose coordinates lie between `low` and `high` [m].
    """
    reach = float(np.linalg.norm(high - low))
    middle = (low + high) / 2 - tool.at
    if tool.shape == "plane":
        first, second, normal = axes_around(tool.axis)
        foot = middle - middle @ normal * normal
        square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * reach / 2
        return tool.at + foot + square @ np.stack([first, second]), np.array([[0, 1, 2, 3]])
    if tool.shape == "box":
        points, quadrilaterals = _box(tool.size / 2, tool.rounding)
    elif tool.shape == "sphere":
        angle = np.linspace(0, np.pi, 2 * ARC + 1)
        points, quadrilaterals = _revolved(tool.radius * np.stack([np.sin(angle), -np.cos(angle)], axis=1), np.array([0.0, 0.0, 1.0]))
    else:
        points, quadrilaterals = _revolved(_profile(tool, reach), tool.axis)
        if not tool.size.size:
            axis = tool.axis / np.linalg.norm(tool.axis)
            points = points + middle @ axis * axis
    return tool.at + points, quadrilaterals


def _profile(tool: Tool, reach: float) -> np.ndarray:
    """Distance from the axis and place along it, from one end of a cylinder to the other; an endless one is open."""
    if not tool.size.size:
        return np.array([(tool.radius, -reach), (tool.radius, reach)])
    half, turn = tool.size[0] / 2, np.linspace(0, np.pi / 2, ARC + 1 if tool.rounding else 1)
    flat = np.array([tool.radius, half]) - tool.rounding
    corner = flat + tool.rounding * np.stack([np.cos(turn), np.sin(turn)], axis=1)  # from the side to the end
    upper = np.vstack([corner, (0, half)])
    return np.vstack([upper[::-1] * (1, -1), upper])


def _revolved(profile: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The profile turned around an axis; at the axis two corners of a quadrilateral are one point."""
    first, second, along = axes_around(axis)
    turn = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    around = np.outer(np.cos(turn), first) + np.outer(np.sin(turn), second)
    points = profile[:, :1, None] * around + profile[:, 1:, None] * along  # place in the profile x turn x 3
    i, j = np.meshgrid(np.arange(len(profile) - 1), np.arange(AROUND), indexing="ij")
    after = (j + 1) % AROUND
    corners = np.stack([i * AROUND + j, i * AROUND + after, (i + 1) * AROUND + after, (i + 1) * AROUND + j], axis=-1)
    return points.reshape(-1, 3), corners.reshape(-1, 4)


def _box(half: np.ndarray, rounding: float) -> tuple[np.ndarray, np.ndarray]:
    """A cube's grid blown up to a sphere of the rounding, whose octants are moved apart; no line of the grid is between two of them."""
    n = 2 * ARC + 1 if rounding else 1
    line = np.tan(np.linspace(-np.pi / 4, np.pi / 4, n + 1))
    a, b = np.meshgrid(line, line, indexing="ij")
    points, quadrilaterals = [], []
    for axis in range(3):
        for side in (-1, 1):
            way = np.empty((n + 1, n + 1, 3))
            way[..., axis], way[..., (axis + 1) % 3], way[..., (axis + 2) % 3] = side, side * a, b
            out = way / np.linalg.norm(way, axis=-1, keepdims=True)
            points.append((np.sign(way) * (half - rounding) + rounding * out).reshape(-1, 3))
            i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
            corners = np.stack([i * (n + 1) + j, (i + 1) * (n + 1) + j, (i + 1) * (n + 1) + j + 1, i * (n + 1) + j + 1], axis=-1)
            quadrilaterals.append(corners.reshape(-1, 4) + len(quadrilaterals) * (n + 1) ** 2)
    return np.concatenate(points), np.concatenate(quadrilaterals)
