# SPDX-License-Identifier: GPL-3.0-or-later
"""The four laws on the paper's plate: its fringes while the crack runs, how rough they are, and the picture of them."""
from __future__ import annotations

from pathlib import Path

import numpy as np
from crackle_report import style
from crackle_report.drawing import draw_facets, draw_plate, time_colours
from crackle_report.photoelasticity import Grid, make_series
from crackle_report.reading import SampleFiles, read_ensemble
from crackle_report.results import Frames
from crackle_report.stress import frame_stresses
from crackle_report.writing import write_light_figure
from matplotlib import pyplot
from scipy.ndimage import gaussian_filter

from crackle_runs import ROOT, run, with_keys
from figures import MILLIMETRE, Figure, mean

RELEASE_TIME = '"0.8 us"'  # epoxy's, by the speed at which it branches: jobs/guide.md
LAWS = {"immediate": {}, f"in {RELEASE_TIME[1:-1].replace('us', 'µs')}": {"fracture.release_time": RELEASE_TIME},
        "averaged": {"fracture.length": '"1.5 mm"', "fracture.release_time": RELEASE_TIME},
        "softening": {"fracture.release": '"softening"', "fracture.strength": '"14 MPa"'}}
N_SAMPLES = 4
MOMENTS = (0, 20, 40, 70, 100)  # [µs] since the onset
PIXEL, COARSE = 0.25 * MILLIMETRE, 1 * MILLIMETRE  # of a picture; of the stress that a fringe is smooth over
Z = (40 * MILLIMETRE, 100 * MILLIMETRE)  # what is shown and measured


def pictures(frames: Frames) -> list[np.ndarray]:
    """Dark field of the middle of the plate at each frame, by Jones matrices."""
    grid = Grid.over((0.0, 24.5 * MILLIMETRE), Z, PIXEL)
    return [fringes.intensity() for fringes in make_series(frames.nodes, frames.tetrahedra, frame_stresses(frames), grid)]


def roughness(picture: np.ndarray) -> float:
    """Rms difference of the intensity from the one smoothed over COARSE, away from edges and from rays through cracks."""
    known = np.isfinite(picture)
    filled = np.where(known, picture, 0)
    weight = gaussian_filter(known.astype(float), COARSE / PIXEL)
    smooth = gaussian_filter(filled, COARSE / PIXEL) / np.maximum(weight, 1e-9)
    inside = known & (weight > 0.999)
    return float(np.sqrt(np.mean((picture - smooth)[inside] ** 2)))


def laws(folder: Path, program: Path) -> list[Figure]:
    text = with_keys((ROOT / "jobs" / "paper.toml").read_text(), {"time.integrator": '"verlet"', "time.step": '"auto"',
                                                                  "ensemble.samples": str(N_SAMPLES)})
    found, drawn = [], {}
    for law, keys in LAWS.items():
        samples = run(with_keys(text, keys), folder / f"laws-{law.split()[0]}", program)
        files, rough = SampleFiles(samples.folder), []
        for number in samples.done:
            frames = files.frames(number)
            shown = pictures(frames)
            rough.append([roughness(shown[int(np.abs(1e6 * frames.time - moment).argmin())]) for moment in MOMENTS])
            drawn.setdefault(law, (frames, shown, files.crack(number)))
        found.append((law, samples.samples.crack_speed_ratio, np.array(rough)))
    return [Figure("The paper's plate, roughness of its fringes", f"{law}", "", "") for law, *_ in found]
