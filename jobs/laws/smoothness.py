# SPDX-License-Identifier: GPL-3.0-or-later
"""Fringe pictures of a running crack with immediate release and with softening: same bodies, toughness and load."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from crackle_readme import put_block
from crackle_report.photoelasticity import Grid, make_series
from crackle_report.reading import SampleFiles
from crackle_report.stress import frame_stresses
from crackle_runs import ROOT, markdown, with_keys
from paper_study.fringes import roughness, side_by_side

SAMPLES = 4
LOAD = 75  # [N]; with both laws cracks run away below it from a slot as thin as a spacing
WINDOW = ((5.0e-3, 12.0e-3), (21.5e-3, 28.5e-3))  # y and z of the pictures [m]
PIXEL = 0.05e-3  # [m]
MARGIN = 0.4e-3  # round the crack, which is left out [m]


@dataclass(frozen=True)
class Run:
    title: str
    keys: dict[str, str] = field(default_factory=dict)

    def input_text(self) -> str:
        text = (ROOT / "jobs" / "laws" / "slot.toml").read_text()
        text = text.replace('force = ["0 N", "0 N", "0 N"]', f'force = ["0 N", "0 N", "{LOAD} N"]')
        text = text.replace('rate = ["0 N/s", "0 N/s", "1 N/s"]\n', "")
        return with_keys(text, {
            "ensemble.samples": str(SAMPLES), "specimen.notch.height": '"0.12 mm"', "mesh.notch_spacing": '"0.12 mm"',
            "mesh.region.spacing": '"0.12 mm"', "mesh.region.y": '["5.2 mm", "10 mm"]',
            "mesh.region.z": '["24 mm", "26 mm"]', "fracture.toughness": '"150 J/m^2"', "time.start": '"equilibrium"',
            "time.duration": '"14 us"', "output.frames": "8", **self.keys})


RUNS = {"fringes-immediate": Run("immediate", {"fracture.strength": None}),
        "fringes-softening": Run("softening, 10 teeth", {"fracture.release": '"softening"'}),
        "fringes-softening-60": Run("softening, 60 teeth", {"fracture.release": '"softening"', "fracture.teeth": "60"})}


def _orders(files: SampleFiles, sample: int) -> list[np.ndarray]:
    """Pictures of the fringe order; NaN near all that breaks in the end."""
    frames = files.frames(sample)
    grid = Grid.over(*WINDOW, PIXEL)
    pictures = make_series(frames.nodes, frames.tetrahedra, frame_stresses(frames), grid)
    broken = frames.nodes[frames.tetrahedra[frames.broken[-1]]].mean(axis=1)
    z, y = np.meshgrid(grid.z, grid.y, indexing="ij")
    hidden = np.zeros(grid.shape, bool)
    for place in broken:
        hidden |= (np.abs(y - place[1]) < MARGIN) & (np.abs(z - place[2]) < MARGIN)
    return [np.where(hidden, np.nan, one.order) for one in pictures]


def measure(results: Path) -> np.ndarray:
    """Roughness of the fringe order before and after cracking, over the mean order before; SAMPLES x 2."""
    files = SampleFiles(results)
    found = []
    for sample in range(SAMPLES):
        orders = _orders(files, sample)
        scale = float(np.nanmean(orders[0]))
        found.append((roughness(orders[0], scale), roughness(orders[-1], scale)))
    return np.array(found)


def table(found: dict[str, np.ndarray]) -> str:
    """@param found by measure(), for each title; the first one is what the others are compared with"""
    first = next(iter(found.values()))[:, 1].mean()
    lines = []
    for title, values in found.items():
        before, after = (f"{column.mean():.4f} ± {column.std(ddof=1):.4f}" for column in values.T)
        lines.append([title, str(len(values)), before, after, f"{values[:, 1].mean() / first:.2f}"])
    return markdown(["law", "samples", "roughness before", "roughness after cracking", "over immediate release"], lines)


def draw(folder: Path, picture: Path) -> None:
    """Dark-field pictures of sample 0 at three times, law by law."""
    bodies = [(one.title, SampleFiles(folder / name / "out").frames(0)) for name, one in RUNS.items()]
    times = tuple(np.linspace(0, bodies[0][1].time[-1], 3))
    side_by_side(bodies, times, Grid.over(*WINDOW, PIXEL)).savefig(picture, dpi=80)


def keep(folder: Path, kept: Path) -> None:
    """Puts table and picture there when all runs are."""
    if all((folder / name / "done").is_file() for name in RUNS):
        put_block("laws-fringes", table({one.title: measure(folder / name / "out") for name, one in RUNS.items()}))
        draw(folder, kept / "fringes.png")
