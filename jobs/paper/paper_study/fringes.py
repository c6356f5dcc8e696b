# SPDX-License-Identifier: GPL-3.0-or-later
"""How alike the samples' fringe pictures are, and how much the breaking blurs them."""
from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Collection, Iterable, Sequence

import numpy as np
from matplotlib.figure import Figure

from crackle_report.photoelasticity import Grid, make_series
from crackle_report.results import Ensemble, Frames
from crackle_report.stress import frame_stress

from .rows import write_table

WINDOW = ((0.0, 0.0245), (0.055, 0.085))  # y and z of the pictures [m]
PIXEL = 0.1e-3  # [m]
SMOOTHING = 11  # pixels: some three spacings at the notch tips
TIP_MARGIN = 20  # pixels that are left out round a notch's tip


COLUMNS = ("time", "order", "roughness", "likeness")  # of FringeSeries, at each frame


@dataclass(frozen=True)
class FringeSeries:
    """Of one sample, at each frame."""

    sample: int
    time: np.ndarray  # since onset [s]
    order: np.ndarray  # mean fringe order
    roughness: np.ndarray  # of the fringe order, over the mean order at onset
    likeness: np.ndarray  # to the mean of the other samples' pictures at the same time


def smoothed(image: np.ndarray, size: int = SMOOTHING) -> np.ndarray:
    """Mean over a square of pixels; what has no value is left out."""
    present = np.isfinite(image)

    def sums(values: np.ndarray) -> np.ndarray:
        padded = np.pad(values, ((size // 2 + 1, size // 2), (size // 2 + 1, size // 2)))
        total = padded.cumsum(axis=0).cumsum(axis=1)
        return total[size:, size:] - total[:-size, size:] - total[size:, :-size] + total[:-size, :-size]

    count = sums(present.astype(float))
    return np.where(present, sums(np.where(present, image, 0)) / np.maximum(count, 1), np.nan)


def roughness(order: np.ndarray, scale: float) -> float:
    """Root mean square of what smoothing takes from the fringe order, over a scale."""
    return float(np.sqrt(np.nanmean((order - smoothed(order)) ** 2)) / scale)


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Correlation of two pictures' fringe orders, which a difference in load does not change."""
    both = np.isfinite(one) & np.isfinite(other)
    return float(np.corrcoef(one[both], other[both])[0, 1])


def near(y: np.ndarray, z: np.ndarray, grid: Grid, margin: int) -> np.ndarray:
    """The pixels no farther than a margin [pixels] along y and z from those of some points [m]."""
    marked = np.zeros(grid.shape)
    row, column = (np.round((at - pixels[0]) / PIXEL).astype(int) for at, pixels in ((z, grid.z), (y, grid.y)))
    inside = (row >= 0) & (row < grid.shape[0]) & (column >= 0) & (column < grid.shape[1])
    marked[row[inside], column[inside]] = 1
    return smoothed(marked, 2 * margin + 1) > 0.5 / (2 * margin + 1) ** 2


def orders(frames: Frames, tips: np.ndarray, chosen: Sequence[int] | None = None) -> list[np.ndarray]:
    """The fringe order at each chosen frame, or at all; NaN as near to tips and to all the cracks there will be as smoothing
    reaches, so that the same pixels are looked at in all frames.

    @param tips of the notches, n x (y, z) [m]
    """
    grid = Grid.over(*WINDOW, PIXEL)
    stresses = [frame_stress(frames, k) for k in (range(len(frames.time)) if chosen is None else chosen)]
    pictures = make_series(frames.nodes, frames.tetrahedra, stresses, grid)
    broken = frames.nodes[frames.tetrahedra[frames.broken[-1]]].mean(axis=1)
    hidden = near(broken[:, 1], broken[:, 2], grid, SMOOTHING) | near(tips[:, 0], tips[:, 1], grid, TIP_MARGIN)
    return [np.where(hidden, np.nan, picture.order) for picture in pictures]


def look_through(ensemble: Ensemble, samples: Iterable[int], turned: Collection[int]) -> list[FringeSeries]:
    """The fringe orders of the samples' frames, looked at; samples with fewer frames than others are left out.

    @param turned the samples whose picture is turned by 180 degrees first, so that in all the same notch leads
    """
    numbers, times, all_orders = [], [], []
    for number in samples:
        frames = ensemble.files.frames(number)
        if frames is None:
            continue
        step = -1 if number in turned else 1
        numbers.append(number)
        times.append(frames.time)
        all_orders.append(np.array([order[::step, ::step] for order in orders(frames, ensemble.plate.notch_tip)], np.float32))
    n_frames = max(map(len, times), default=0)
    whole = [i for i, time in enumerate(times) if len(time) == n_frames]
    numbers, times = [numbers[i] for i in whole], [times[i] for i in whole]
    pictures = np.array([all_orders[i] for i in whole])  # samples x frames x rows x columns
    present = np.isfinite(pictures)
    count, total = present.sum(axis=0), np.where(present, pictures, 0).sum(axis=0)
    result = []
    for i, number in enumerate(numbers):
        n_others = count - present[i]
        others = np.where(n_others > 0, (total - np.where(present[i], pictures[i], 0)) / np.maximum(n_others, 1), np.nan)
        mean = np.nanmean(pictures[i], axis=(1, 2), dtype=float)
        result.append(FringeSeries(number, times[i], mean, np.array([roughness(order, mean[0]) for order in pictures[i]]),
                                   np.array([likeness(*pair) for pair in zip(pictures[i], others)])))
    return result


def nearest(frames: Frames, times: Iterable[float]) -> list[int]:
    """The frames nearest to some times since the onset [s]."""
    return [int(np.abs(frames.time - time).argmin()) for time in times]


def side_by_side(bodies: list[tuple[str, Frames]], times: tuple[float, ...], grid: Grid) -> Figure:
    """Dark-field pictures of several samples, a row each, at some times since the onset [s]."""
    height = 0.75 + 2.5 * len(bodies) * len(grid.z) / len(grid.y) * 3 / len(times)
    figure = Figure(figsize=(7.5, height), layout="constrained")
    for row, (title, frames) in zip(figure.subplots(len(bodies), len(times), squeeze=False), bodies):
        chosen = nearest(frames, times)
        images = make_series(frames.nodes, frames.tetrahedra, [frame_stress(frames, k) for k in chosen], grid)
        for axes, k, image in zip(row, chosen, images):
            axes.imshow(image.intensity(), cmap="gray", origin="lower",
                        extent=[1e3 * at for at in (grid.y[0], grid.y[-1], grid.z[0], grid.z[-1])])
            axes.set_title(f"{title}, {1e6 * frames.time[k]:.0f} µs", fontsize=8)
    figure.supxlabel("y [mm]", fontsize=9)
    figure.supylabel("z [mm]", fontsize=9)
    return figure


def write_csv(series: list[FringeSeries], digest: str, file: Path) -> None:
    """@param digest of the samples' input"""
    write_table(["input", "sample", *COLUMNS], ([digest, one.sample, *(f"{value:.6g}" for value in row)] for one in series
                                                for row in zip(*(getattr(one, name) for name in COLUMNS))), file)


def contents(file: Path) -> tuple[str, list[int]]:
    """Digest of the input, and the samples."""
    with open(file, newline="") as stream:
        lines = list(csv.DictReader(stream))
    return lines[0].get("input", "") if lines else "", list(dict.fromkeys(int(line["sample"]) for line in lines))


def read_csv(file: Path) -> list[FringeSeries]:
    with open(file, newline="") as stream:
        lines = list(csv.DictReader(stream))
    result = []
    for sample in dict.fromkeys(line["sample"] for line in lines):
        columns = np.array([[float(line[name]) for name in COLUMNS]
                            for line in lines if line["sample"] == sample]).T
        result.append(FringeSeries(int(sample), *columns))
    return result
