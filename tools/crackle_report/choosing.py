# SPDX-License-Identifier: GPL-3.0-or-later
"""Chooses the samples that stand for an ensemble."""
from __future__ import annotations

import numpy as np

from .results import Ensemble

MOST_COMPARED = 2000  # samples of a group, each with each other


def typical_samples(ensemble: Ensemble, n: int) -> list[int]:
    """At most n samples, grouped by pattern and by whether they branch in the projection, each group's most typical first.

    Every group gets a share of the places like its share of the samples, but at least one. Its first sample
    is the one nearest to all others of the group; each further one differs most from those already chosen.
    """
    groups = kinds(ensemble)
    order = sorted(groups, key=lambda key: (key[0] == 0, key))
    places = _share_out([len(groups[key]) for key in order], n)
    return [i for key, count in zip(order, places) for i in spread(ensemble, groups[key], count)]


def kinds(ensemble: Ensemble) -> dict[tuple[int, bool], list[int]]:
    """The done samples by pattern and by whether they branch in the projection."""
    groups: dict[tuple[int, bool], list[int]] = {}
    samples = ensemble.samples
    branching = samples.bifurcations_projected
    for i in ensemble.shown:
        groups.setdefault((int(samples.pattern[i]), bool(branching[i] > 0)), []).append(i)
    return groups


def samples_in_detail(ensemble: Ensemble) -> list[int]:
    """The most typical sample of each of the two main patterns, or of what there is instead.

    Of the samples with two cracks one that branches is preferred, so that branching is shown as well.
    """
    samples = ensemble.samples
    chosen, branching = [], samples.bifurcations_projected
    for pattern in (1, 2):
        group = [i for i in ensemble.shown if samples.pattern[i] == pattern]
        branched = [i for i in group if branching[i] > 0]
        if group:
            chosen += spread(ensemble, branched if pattern == 2 and branched else group, 1)
    return chosen or typical_samples(ensemble, 1)


def _share_out(sizes: list[int], n: int) -> list[int]:
    """Places in proportion to the sizes, at least one each while there are enough; the largest groups last."""
    places = [0] * len(sizes)
    for _ in range(min(n, sum(sizes))):
        need = [size / (count + 0.5) if count < size else 0.0 for size, count in zip(sizes, places)]
        without = [size if count == 0 else 0 for size, count in zip(sizes, places)]
        places[int(np.argmax(without if any(without) else need))] += 1
    return places


def spread(ensemble: Ensemble, group: list[int], count: int) -> list[int]:
    """Of a group the sample nearest to all others, then those that differ most from the ones before; of a very large one evenly
    spread samples are considered."""
    if not group:
        return []
    group = group[::-(-len(group) // MOST_COMPARED)]
    count = min(count, len(group))
    distance = _distances(ensemble.samples.position[group].reshape(len(group), -1), ensemble.plate.size[1])
    chosen: list[int] = []
    while len(chosen) < count:
        if chosen:
            nearest = distance[:, chosen].min(axis=1)
            nearest[chosen] = -1
            chosen.append(int(nearest.argmax()))
        else:
            chosen.append(int(distance.sum(axis=1).argmin()))
    return [group[i] for i in chosen]


def _distances(z: np.ndarray, width: float) -> np.ndarray:
    """Mean distance of paths at the sections; one that arrives where the other does not is a width away."""
    both = np.isfinite(z)[:, None] & np.isfinite(z)[None]
    one = np.isfinite(z)[:, None] != np.isfinite(z)[None]
    apart = np.where(both, np.abs(np.nan_to_num(z)[:, None] - np.nan_to_num(z)[None]), width * one)
    return apart.mean(axis=2) if z.shape[1] else np.zeros(both.shape[:2])
