# SPDX-License-Identifier: GPL-3.0-or-later
"""The command crackle-paraview: a sample's fields and cracks as files for ParaView."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from . import vtkhdf
from .program import ResultsError
from .reading import SampleFiles
from .results import CrackSurface, Frames
from .stress import frame_stress
from .writing import write_whole


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="crackle-paraview",
        description="Writes a sample as VTKHDF files, which ParaView (5.10 or newer) and VTK (9.1 or newer) open: "
                    "crack.vtkhdf, the crack surface coloured by its time, and frame-0000.vtkhdf, ..., the fields "
                    "at the sample's frames. ParaView offers the frames as one series.")
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="output folder of crackle run")
    parser.add_argument("--sample", type=int, required=True, metavar="N", help="number of the sample")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR",
                        help="folder for the files (default: FOLDER/paraview/NNNN)")
    arguments = parser.parse_args()
    output = arguments.output or arguments.folder / "paraview" / f"{arguments.sample:04d}"
    try:
        n_files = write_sample(arguments.folder, arguments.sample, output)
    except (ResultsError, OSError) as error:
        print(f"crackle-paraview: {error}", file=sys.stderr)
        return 1
    print(f"{n_files} files in {output}")
    return 0


def write_sample(folder: Path, number: int, output: Path) -> int:
    """Writes the files; returns how many. Raises ResultsError when the sample is not done."""
    if not folder.is_dir():
        raise ResultsError(f"there is no folder '{folder}'")
    files = SampleFiles(folder)
    crack, frames = files.crack(number), files.frames(number)
    if crack is None or frames is None:
        raise ResultsError(f"'{folder}': sample {number} is not done")
    output.mkdir(parents=True, exist_ok=True)
    write_whole(output / "crack.vtkhdf", _crack(crack))
    for k in range(frames.time.size):
        write_whole(output / f"frame-{k:04d}.vtkhdf", _frame(frames, k))
    return 1 + frames.time.size


def _crack(crack: CrackSurface) -> bytes:
    """The opened dual facets; points are not shared, so that each facet keeps its own time."""
    n_facets = len(crack.time)
    return vtkhdf.grid(crack.corner.reshape(-1, 3).astype(float), np.arange(4 * n_facets).reshape(-1, 4),
                       vtkhdf.QUADRILATERAL, float(crack.time.max(initial=0.0)), {},
                       {"time": crack.time, "notch": crack.notch.astype("i4")})


def _frame(frames: Frames, k: int) -> bytes:
    """Nodes with displacement and velocity; tetrahedra with their stress in VTK's order xx yy zz xy yz xz, and the share of
    their stiffness that softening has left them, 0 where broken.
    """
    stress = frame_stress(frames, k)
    broken = np.zeros(len(frames.tetrahedra), "u1")
    broken[frames.broken[k]] = 1
    stiffness = np.where(broken == 1, 0, frames.stiffness[k])
    tensor = stress[:, (0, 5, 4, 5, 1, 3, 4, 3, 2)].reshape(-1, 3, 3)
    return vtkhdf.grid(frames.nodes, frames.tetrahedra, vtkhdf.TETRAHEDRON, float(frames.time[k]),
                       {"displacement": frames.displacement[k], "velocity": frames.velocity[k]},
                       {"stress": stress[:, (0, 1, 2, 5, 3, 4)].astype("f4"), "broken": broken,
                        "stiffness": stiffness.astype("f4"),
                        "principal_stress": np.linalg.eigvalsh(tensor)[:, 2].astype("f4")})
