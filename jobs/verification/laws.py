# SPDX-License-Identifier: GPL-3.0-or-later
"""The four laws on the paper's plate: its fringes while the crack runs, how rough they are, and the picture of them."""
from __future__ import annotations

from pathlib import Path

import numpy as np
from crackle_report import style
from crackle_report.drawing import draw_facets, time_colours
from crackle_report.photoelasticity import Fringes, Grid, make_series
from crackle_report.sample_files import SampleFiles
from crackle_report.fields import CrackSurface, Frames
from crackle_report.stress import frame_stresses
from crackle_report.writing import write_light_figure
from matplotlib import pyplot
from scipy.ndimage import distance_transform_edt, gaussian_filter

from crackle_runs import ROOT, run, with_keys
from figures import MILLIMETRE, Figure, mean

EPOXY = {"fracture.release_time": None, "fracture.release_speed": '"780 m/s"', "fracture.impulse": None}  # jobs/guide.md
LAWS = {"the law": EPOXY, "immediate": {}, "averaged": EPOXY | {"fracture.length": '"1.5 mm"'},
        "softening": {"fracture.release": '"softening"', "fracture.strength": '"14 MPa"'}}
N_SAMPLES = {"averaged": 2, "softening": 2}  # 4 with the other laws
REFERENCE = "at most 1.5 at 40 µs; 0.48, Suzuki et al. 2007"
MOMENTS = (0, 20, 40, 70, 100)  # [µs] since the onset
PIXEL, COARSE, AWAY = 0.25 * MILLIMETRE, 1 * MILLIMETRE, 3 * MILLIMETRE
WIDTH, Z = 24.5 * MILLIMETRE, (50 * MILLIMETRE, 90 * MILLIMETRE)  # of the plate, the pictures
DEPTH, PLACES = 2.5 * MILLIMETRE, (67 * MILLIMETRE, 73 * MILLIMETRE)  # of the notches; along z
GRID = Grid.over((0.0, WIDTH), Z, PIXEL)
PICTURE = ROOT / "jobs" / "images" / "laws.png"


def fringes(frames: Frames, moments: list[int]) -> list[Fringes]:
    """Fringes of the middle of the plate at some frames."""
    stresses = frame_stresses(frames)
    return make_series(frames.nodes, frames.tetrahedra, [stresses[k] for k in moments], GRID)


def away_from(crack: CrackSurface, places: tuple[float, float] = PLACES, depth: float = DEPTH) -> np.ndarray:
    """The pixels at a distance of AWAY or more from the crack's facets and from the notches of the two edges, at these z and so deep."""
    free = np.ones(GRID.shape, bool)
    y, z = (np.round((crack.corner.mean(axis=1)[:, axis] - origin[0]) / PIXEL).astype(int) for axis, origin in ((1, GRID.y), (2, GRID.z)))
    free[np.clip(z, 0, free.shape[0] - 1), np.clip(y, 0, free.shape[1] - 1)] = False
    for place, tip in zip(places, ((0.0, depth), (WIDTH - depth, WIDTH))):
        free[np.abs(GRID.z - place).argmin(), (GRID.y >= tip[0]) & (GRID.y <= tip[1])] = False
    return distance_transform_edt(free) * PIXEL >= AWAY


def roughness(order: np.ndarray, counted: np.ndarray) -> float:
    """Rms difference of a picture's fringe order from the one smoothed over COARSE, in the pixels counted."""
    known = np.isfinite(order)
    weight = gaussian_filter(known.astype(float), COARSE / PIXEL)
    smooth = gaussian_filter(np.where(known, order, 0), COARSE / PIXEL) / np.maximum(weight, 1e-9)
    return float(np.sqrt(np.mean((order - smooth)[counted & known & (weight > 0.999)] ** 2)))


def laws(folder: Path, program: Path) -> list[Figure]:
    """@return roughness over time with each law; the picture is PICTURE"""
    text = with_keys((ROOT / "jobs" / "paper.toml").read_text(), {"time.integrator": '"verlet"', "time.step": '"auto"', "ensemble.samples": "4"})
    case = f"The paper's plate: roughness of the fringes {', '.join(map(str, MOMENTS[1:]))} µs after the onset over that at it; speed / c_R"
    figures, shown = [], {}
    for law, keys in LAWS.items():
        samples = run(with_keys(text, keys | {"ensemble.samples": str(N_SAMPLES[law])} if law in N_SAMPLES else keys), folder / f"laws-{law.split()[-1]}", program)
        files, rough = SampleFiles(samples.folder), []
        for number in samples.done:
            frames, crack = files.frames(number), files.crack(number)
            seen = fringes(frames, [int(np.abs(1e6 * frames.time - moment).argmin()) for moment in MOMENTS])
            rough.append([roughness(picture.order, away_from(crack)) for picture in seen])
            if number == samples.done[0]:
                shown[law] = [picture.intensity() for picture in seen], crack
        over, speeds = np.mean(rough, axis=0), list(samples.samples.crack_speed_ratio)
        figures.append(Figure(case, law, f"{', '.join(f'{value / over[0]:.1f}' for value in over[1:])}; "
                              f"{mean(speeds, '.2f') if any(speed > 0 for speed in speeds) else 'no crack runs'}", REFERENCE if not figures else "the same"))
    draw(shown)
    return figures


def draw(shown: dict[str, tuple[list[np.ndarray], CrackSurface]]) -> None:
    """Fringes at each moment, and the crack, of one sample; a row for each law."""
    style.apply()
    figure, panels = pyplot.subplots(len(shown), len(MOMENTS) + 1, figsize=(style.PAGE_WIDTH, 2.3 * len(shown)), layout="constrained",
                                     sharex=True, sharey=True)
    extent = [0, WIDTH / MILLIMETRE, Z[0] / MILLIMETRE, Z[1] / MILLIMETRE]
    for row, (law, (seen, crack)) in zip(panels, shown.items()):
        for panel, picture, moment in zip(row, seen, MOMENTS):
            panel.imshow(picture, cmap="gray", vmin=0, vmax=1, origin="lower", extent=extent, interpolation="nearest")
            panel.set_title(f"t₀ + {moment} µs" if moment else "t₀", fontsize=9)
        draw_facets(row[-1], crack, time_colours(MOMENTS[-1] * 1e-6))
        row[-1].set_title("crack, to 100 µs", fontsize=9)
        row[-1].set_aspect("equal")
        row[0].set_ylabel(f"{law}\nz [mm]")
    for panel in panels[-1]:
        panel.set_xlabel("y [mm]")
    write_light_figure(figure, PICTURE, 130)
    pyplot.close(figure)
