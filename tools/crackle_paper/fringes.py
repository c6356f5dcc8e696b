# SPDX-License-Identifier: GPL-3.0-or-later
"""How alike the samples' fringe pictures are, and how much the breaking blurs them."""
from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Collection, Iterable

import numpy as np

from crackle_report.photoelasticity import Grid, frame_stresses, make_series
from crackle_report.results import Ensemble

WINDOW = ((0.0, 0.0245), (0.055, 0.085))  # y and z of the pictures [m]
PIXEL = 0.1e-3  # [m]
SMOOTHING = 11  # pixels: some three spacings at the notch tips


@dataclass(frozen=True)
class FringeSeries:
    """Of one sample, at each frame."""

    sample: int
    time: np.ndarray  # since onset [s]
    roughness: np.ndarray  # of the fringe order, see roughness()
    likeness: np.ndarray  # to the reference sample's picture at the same time, see likeness()


def smoothed(image: np.ndarray, size: int = SMOOTHING) -> np.ndarray:
    """Mean over a square of pixels; what has no value is left out."""
    present = np.isfinite(image)

    def sums(values: np.ndarray) -> np.ndarray:
        padded = np.pad(values, ((size // 2 + 1, size // 2), (size // 2 + 1, size // 2)))
        total = padded.cumsum(axis=0).cumsum(axis=1)
        return total[size:, size:] - total[:-size, size:] - total[size:, :-size] + total[:-size, :-size]

    count = sums(present.astype(float))
    return np.where(present, sums(np.where(present, image, 0)) / np.maximum(count, 1), np.nan)


def roughness(order: np.ndarray) -> float:
    """Root mean square of what smoothing takes from the fringe order, over the mean order."""
    return float(np.sqrt(np.nanmean((order - smoothed(order)) ** 2)) / np.nanmean(order))


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of two pictures' fringe orders, which a difference in load does not change."""
    both = np.isfinite(one) & np.isfinite(other)
    return float(np.corrcoef(one[both], other[both])[0, 1])


def look_through(ensemble: Ensemble, reference: int, samples: Iterable[int], turned: Collection[int]) -> list[FringeSeries]:
    """The fringe orders of the samples' frames, looked at; samples without frames are left out.

    @param reference the sample that the others' likeness is to
    @param turned the samples whose picture is turned by 180 degrees first, so that in all the same notch leads
    """
    def orders(number: int) -> tuple[np.ndarray, list[np.ndarray]]:
        frames = ensemble.load_frames(number)
        if frames is None:
            return np.empty(0), []
        pictures = make_series(frames.nodes, frames.tetrahedra, frame_stresses(frames), Grid.over(*WINDOW, PIXEL))
        step = -1 if number in turned else 1
        return frames.time, [picture.order[::step, ::step] for picture in pictures]

    result: list[FringeSeries] = []
    _, others = orders(reference)
    for number in samples:
        time, mine = orders(number)
        n = min(len(others), len(mine))
        if n > 1:
            result.append(FringeSeries(number, time[:n], np.array([roughness(order) for order in mine[:n]]),
                                       np.array([likeness(mine[i], others[i]) for i in range(n)])))
    return result


def write_csv(series: list[FringeSeries], file: Path) -> None:
    with open(file, "w", newline="") as stream:
        out = csv.writer(stream, lineterminator="\n")
        out.writerow(["sample", "time", "roughness", "likeness"])
        for one in series:
            for row in zip(one.time, one.roughness, one.likeness):
                out.writerow([one.sample, *(f"{value:.6g}" for value in row)])


def read_csv(file: Path) -> list[FringeSeries]:
    with open(file, newline="") as stream:
        lines = list(csv.DictReader(stream))
    result = []
    for sample in dict.fromkeys(line["sample"] for line in lines):
        columns = np.array([[float(line[name]) for name in ("time", "roughness", "likeness")]
                            for line in lines if line["sample"] == sample]).T
        result.append(FringeSeries(int(sample), *columns))
    return result
