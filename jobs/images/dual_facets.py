#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws dual-facets.png: a tetrahedron and its six dual facets."""
from itertools import combinations
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.12, 0.0], [0.62, 0.85, 0.25], [0.38, 0.45, 0.98]])
NAMES = "abcd"

figure = plt.figure(figsize=(4.4, 3.6))
axes = figure.add_axes((-0.2, -0.16, 1.4, 1.4), projection="3d", proj_type="ortho", computed_zorder=False)
centre = CORNERS.mean(axis=0)
for first, second in combinations(range(4), 2):
    middle = CORNERS[[first, second]].mean(axis=0)
    third, fourth = (corner for corner in range(4) if corner not in (first, second))
    facet = [middle, CORNERS[[first, second, third]].mean(axis=0), centre, CORNERS[[first, second, fourth]].mean(axis=0)]
    chosen = (first, second) == (0, 1)
    axes.add_collection3d(Poly3DCollection([facet], facecolor="#d95f0e" if chosen else "#9ecae1", alpha=0.85 if chosen else 0.45,
                                           edgecolor="#3b6a8f", linewidth=0.8, zorder=3 if chosen else 2))
    axes.plot(*CORNERS[[first, second]].T, color="black", linewidth=1.2, linestyle=":" if (first, second) == (0, 2) else "-", zorder=4)
    if chosen:
        area = sum(np.cross(facet[i] - facet[0], facet[i + 1] - facet[0]) for i in (1, 2)) / 2
        area *= np.sign(area @ (CORNERS[second] - CORNERS[first]))
        place = np.mean(facet, axis=0)
        axes.quiver(*place, *(2.2 * area), color="#d95f0e", linewidth=1.8, arrow_length_ratio=0.25, zorder=6)
        axes.text(*(place + 2.5 * area), r"$\mathbf{S}^{ab}$", color="#d95f0e", fontsize=13, zorder=7)
for name, corner in zip(NAMES, CORNERS):
    axes.text(*(corner + 0.09 * (corner - centre) / np.linalg.norm(corner - centre)), f"${name}$", fontsize=14, ha="center", va="center")
axes.view_init(elev=18, azim=-78)
axes.set_axis_off()
axes.set_box_aspect((1, 1, 0.95))
figure.savefig(Path(__file__).with_name("dual-facets.png"), dpi=130)
