# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways that cracks take: into a hole, through it or past it, and groups of paths with nothing between them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Sequence

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from .observations import SeenPaths, Start, hole_at
from .path_frame import Gaps, left_of, length_of, resampled

N_FINE = 400  # points of a path at which it is asked whether they are in a hole
FEW = 10  # paths; groups of fewer are parted only by a gap WIDE times their own width
WIDE = 4
MOST_PARTS = 6
NO_CRACK = "no crack from there"


@dataclass
class Ways:
    """`of_experiments` and `of_samples`: the number of the way that each took. The groups are those of all together, so that they
    do not depend on which are experiments."""
    names: list[str]
    of_experiments: list[int]
    of_samples: np.ndarray
    to_samples: np.ndarray  # distances of experiments, then of all samples, from each sample; NaN without a crack

    def members(self, way: int) -> list[int]:
        """Indices of the samples that took it."""
        return [int(i) for i in np.flatnonzero(self.of_samples == way)]

    def count(self, way: int) -> int:
        return int((self.of_samples == way).sum())

    def p_value(self, experiment: int, within: float = 1.0) -> float:
        """The share of the samples and this experiment that are on ways which fewer of them take or, on its own way, are as unusual. Of those that are
        alone on their ways, the ones that lie as far from the others are.

        @param within: p-value among those of its own way
        """
        way = self.of_experiments[experiment]
        sizes = np.bincount(np.append(self.of_samples, way), minlength=len(self.names))
        others = np.delete(sizes, way)
        n_as_unusual = others[others <= sizes[way]].sum() + round(within * sizes[way])
        if sizes[way] == 1:
            of_samples, own = self.to_samples[len(self.of_experiments):].copy(), self.to_samples[experiment]
            np.fill_diagonal(of_samples, np.nan)
            is_as_far = np.isnan(own) | (np.nansum(of_samples, axis=1) + own >= np.nansum(own) * (1 - 1e-9))  # in sum; without a crack more than all
            n_as_unusual = 1 + np.sum((sizes[self.of_samples] == 1) & is_as_far)
        return float(n_as_unusual / sizes.sum())


def ways_of(seen: SeenPaths, starts: Sequence[Start], gaps: Gaps) -> Ways:
    n = len(seen.curves)
    # Of experiments and samples alike, as read, and not drawn out: an end near a hole is not in it.
    there = [i for i, curve in enumerate(seen.read) if curve is not None]
    curves = seen.curves + [seen.read[i] for i in there]
    bare = seen.lines + [seen.arms[i].points for i in there]
    joined = seen.holes + [seen.arms[i].holes for i in there]
    numbers = [s for s, start in enumerate(starts) if start.is_hole]
    holes = [starts[s] for s in numbers]
    passed = np.array([[f"through {starts[s].name}" if s in through else _passage(line, s, starts) for s in numbers]
                       for line, through in zip(bare, joined)], object).reshape(len(bare), len(holes))
    for k, hole in enumerate(holes):  # what lies beyond the picture's edge is not known of an experiment, so of none
        at_edge = [passed[i, k] for i, window in enumerate(seen.windows) if not window.arrested]
        if None in at_edge:
            passed[:, k] = ""
        elif f"into {hole.name}" in at_edge:
            passed[passed[:, k] == f"through {hole.name}", k] = f"into {hole.name}"
    signatures = [", ".join(word for word in row if word) for row in np.where(passed == None, "", passed)]  # noqa: E711
    for i, row in enumerate(passed):
        signatures[i] = ", ".join(filter(None, [signatures[i], *(f"short of {hole.name}" for hole, word in zip(holes, row) if word is None)]))
    apart = gaps.between(curves).max(axis=2)
    apart = np.minimum(apart, apart.T)  # how far the shorter one gets from the longer at most
    groups = [np.flatnonzero(np.array(signatures) == name) for name in dict.fromkeys(signatures)]
    heights = np.concatenate([_linkage(apart, group)[:, 2] for group in groups if len(group) > 1] or [np.zeros(1)])
    names, number = [], np.zeros(len(curves), int)
    for group in groups:
        parts = _parted(apart, group, float(np.median(heights)))
        for part in parts:
            number[part] = len(names)
            end = 1e3 * np.mean([bare[i][-1] for i in part], axis=0)
            where = f"to ({end[0]:.3g} mm, {end[1]:.3g} mm)" if len(parts) > 1 else ""
            names.append(" ".join(filter(None, [signatures[group[0]], where])) or ("past no hole" if holes else "one way"))
    of_samples = np.full(len(seen.arms), len(names))
    of_samples[there] = number[n:]
    if len(there) < len(seen.arms):
        names.append(NO_CRACK)
    to_samples = np.full((n + len(seen.arms), len(seen.arms)), np.nan)
    to_samples[np.ix_([*range(n), *(n + i for i in there)], there)] = apart[:, n:]
    return Ways(names, [int(way) for way in number[:n]], of_samples, to_samples)


def _passage(line: np.ndarray, number: int, starts: Sequence[Start]) -> Optional[str]:
    """What a path does at a hole; None if it ends before."""
    hole, fine = starts[number], resampled(line, N_FINE)
    ends_there = hole_at(line[-1], starts) == number
    if ends_there or hole.holds(fine).any():
        return f"{'into' if ends_there else 'through'} {hole.name}"
    middle, along = hole.slot.mean(axis=0), line[-1] - line[0]
    share = float((middle - line[0]) @ along / max(along @ along, 1e-300))
    if share <= 0:
        return ""
    if share >= 1:
        return None
    beside, across = fine[np.linalg.norm(fine - middle, axis=1).argmin()] - middle, left_of(along)
    axis = int(np.abs(across).argmax())
    return f"past {hole.name} at {'larger' if (beside @ across) * across[axis] > 0 else 'smaller'} {'yz'[axis]}"


def _linkage(apart: np.ndarray, group: np.ndarray) -> np.ndarray:
    return linkage(squareform(apart[np.ix_(group, group)], checks=False), "single")


def _parted(apart: np.ndarray, group: np.ndarray, usual: float) -> list[np.ndarray]:
    """The most parts, between which the gaps are larger than each is wide, and clearly larger than paths are usually apart."""
    found = _linkage(apart, group) if len(group) > 1 else np.zeros((0, 4))
    for gap in found[::-1][:MOST_PARTS - 1][::-1, 2]:
        labels = fcluster(found, gap * (1 - 1e-12), "distance")
        parts = [group[labels == label] for label in np.unique(labels)]
        width = max(float(apart[np.ix_(part, part)].max()) for part in parts)
        factor = WIDE if max(map(len, parts)) < FEW else 1
        if gap > max(factor * width, WIDE * usual):
            return parts
    return [group]


def least_distance(seen: SeenPaths, experiment: int, gaps: Gaps) -> tuple[float, int]:
    """How far a path gets at most from that sample's from which it gets the least far [m], and the sample's index."""
    there = [i for i, curve in enumerate(seen.read) if curve is not None]
    apart = gaps.between([seen.curves[experiment], *(seen.read[i] for i in there)])[0, 1:].max(axis=1)
    return float(apart.min()), there[int(apart.argmin())]


def moved_onto(seen: SeenPaths, experiment: int, gaps: Gaps) -> Optional[np.ndarray]:
    """The shift by which a path that is far from all samples comes to lie among them, as if its origin had been forgotten; None if
    none does."""
    line = seen.lines[experiment]
    curves = [curve for curve in seen.read if curve is not None]
    begin = np.mean([curve[0] for curve in curves], axis=0)
    shift = begin - seen.curves[experiment][0]
    moved = gaps.between([line + shift, *curves])[0, 1:].mean(axis=1).min()
    return shift if moved < 0.05 * length_of(line) and np.linalg.norm(shift) > 5 * moved else None
