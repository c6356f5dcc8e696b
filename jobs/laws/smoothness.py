# SPDX-License-Identifier: GPL-3.0-or-later
"""Fringe pictures of a running crack with immediate release and with softening: same bodies, toughness and load."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from crackle_report.photoelasticity import Grid, make_series
from crackle_report.reading import SampleFiles
from crackle_report.stress import frame_stresses
from crackle_runs import ROOT, markdown, run, with_keys
from paper_study.fringes import roughness

LAWS = {"immediate": {"fracture.strength": None},
        "softening": {"fracture.release": '"softening"'}}
SAMPLES = 4
LOAD = 75  # [N]; both run away below it from a slot as thin as a spacing
WINDOW = ((5.0e-3, 12.0e-3), (21.5e-3, 28.5e-3))  # y and z of the pictures [m]
PIXEL = 0.05e-3  # [m]
MARGIN = 0.4e-3  # round the crack, which is left out [m]


def input_text(law: str) -> str:
    text = (ROOT / "jobs" / "laws" / "slot.toml").read_text()
    text = text.replace('force = ["0 N", "0 N", "0 N"]', f'force = ["0 N", "0 N", "{LOAD} N"]')
    text = text.replace('rate = ["0 N/s", "0 N/s", "1 N/s"]\n', "")
    return with_keys(text, {
        "ensemble.samples": str(SAMPLES), "specimen.notch.height": '"0.12 mm"', "mesh.notch_spacing": '"0.12 mm"',
        "mesh.region.spacing": '"0.12 mm"', "mesh.region.y": '["5.2 mm", "10 mm"]', "mesh.region.z": '["24 mm", "26 mm"]',
        "fracture.toughness": '"150 J/m^2"', "time.start": '"equilibrium"', "time.duration": '"14 us"',
        "output.frames": "8", **LAWS[law]})


def compute(folder: Path, program: Path) -> None:
    for law in LAWS:
        run(input_text(law), folder / f"smoothness-{law}", program)


def _orders(files: SampleFiles, sample: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Times and pictures of the fringe order; NaN near all that breaks in the end."""
    frames = files.frames(sample)
    grid = Grid.over(*WINDOW, PIXEL)
    pictures = make_series(frames.nodes, frames.tetrahedra, frame_stresses(frames), grid)
    broken = frames.nodes[frames.tetrahedra[frames.broken[-1]]].mean(axis=1)
    z, y = np.meshgrid(grid.z, grid.y, indexing="ij")
    hidden = np.zeros(grid.shape, bool)
    for place in broken:
        hidden |= (np.abs(y - place[1]) < MARGIN) & (np.abs(z - place[2]) < MARGIN)
    return frames.time, [np.where(hidden, np.nan, one.order) for one in pictures]


def measure(folder: Path) -> dict[str, list[tuple[float, float]]]:
    """Roughness of the fringe order before and after cracking, over the mean order at the start, of each sample."""
    found = {}
    for law in LAWS:
        files = SampleFiles(folder / f"smoothness-{law}" / "out")
        for sample in range(SAMPLES):
            _, orders = _orders(files, sample)
            scale = float(np.nanmean(orders[0]))
            found.setdefault(law, []).append((roughness(orders[0], scale), roughness(orders[-1], scale)))
    return found


def table(found: dict[str, list[tuple[float, float]]]) -> str:
    def mean(values: list[float]) -> str:
        return f"{np.mean(values):.4f} ± {np.std(values, ddof=1):.4f}"

    return markdown(["law", "samples", "roughness before", "roughness after cracking"],
                    [[law, str(len(rows)), mean([one[0] for one in rows]), mean([one[1] for one in rows])]
                     for law, rows in found.items()])


def draw(folder: Path, picture: Path) -> None:
    """Dark-field pictures of sample 0 at three times, law by law."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(len(LAWS), 3, figsize=(7.5, 5.2), constrained_layout=True)
    for row, law in zip(axes, LAWS):
        frames = SampleFiles(folder / f"smoothness-{law}" / "out").frames(0)
        chosen = np.linspace(0, len(frames.time) - 1, 3).round().astype(int)
        stresses = frame_stresses(frames)
        pictures = make_series(frames.nodes, frames.tetrahedra, [stresses[k] for k in chosen], Grid.over(*WINDOW, PIXEL))
        for one, k, image in zip(row, chosen, pictures):
            one.imshow(image.intensity(), cmap="gray", origin="lower", extent=[1e3 * at for at in (*WINDOW[0], *WINDOW[1])])
            one.set_title(f"{law}, {1e6 * frames.time[k]:.0f} µs", fontsize=9)
    figure.supxlabel("y [mm]", fontsize=9)
    figure.supylabel("z [mm]", fontsize=9)
    figure.savefig(picture, dpi=110)
    plt.close(figure)
