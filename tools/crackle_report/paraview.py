# SPDX-License-Identifier: GPL-3.0-or-later
"""The command crackle-paraview: a sample's fields and cracks as files for ParaView."""
from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Optional

import numpy as np
from crackle.files import ResultsError

from . import vtkhdf
from .choosing import samples_in_detail
from .mesh import field_gradient
from .reading import read_ensemble
from .sample_files import SampleFiles
from .fields import CrackSurface, Frames, Tool
from .stress import frame_stress
from .tool_surface import tool_surface
from .writing import write_whole


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="crackle-paraview",
        description="Writes a sample as VTKHDF files, which ParaView (5.10 or newer) and VTK (9.1 or newer) open: for each "
                    "of the sample's frames frame-0000.vtkhdf, ..., the fields, and crack-0000.vtkhdf, ..., the crack surface "
                    "as far as it has opened, which moves with the body, and tools-0000.vtkhdf, ..., the tools, where there are any; "
                    "frame.hdf.series and the like, which ParaView opens as one file each, with their times; crack.vtkhdf, the whole crack; and view.py, "
                    "which opens all of it in ParaView (paraview --script=view.py) or draws it (pvpython view.py PICTURE).")
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="output folder of crackle run")
    parser.add_argument("--sample", type=int, metavar="N", help="number of the sample (default: a typical one, as in the report)")
    parser.add_argument("--program", type=Path, metavar="FILE",
                        help="the program crackle, which is asked for that one (default: as crackle-report finds it)")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR",
                        help="folder for the files (default: FOLDER/paraview/NNNN)")
    arguments = parser.parse_args()
    try:
        number = arguments.sample if arguments.sample is not None else _typical(arguments.folder, arguments.program)
        output = arguments.output or arguments.folder / "paraview" / f"{number:04d}"
        n_files = write_sample(arguments.folder, number, output)
    except (ResultsError, OSError) as error:
        print(f"crackle-paraview: {error}", file=sys.stderr)
        return 1
    print(("" if arguments.sample is not None else f"sample {number}, a typical one: ") + f"{n_files} files in {output}")
    return 0


def _check(folder: Path) -> None:
    """Raises ResultsError when a folder is not that of an ensemble."""
    if not folder.is_dir():
        raise ResultsError(f"there is no folder '{folder}'")
    if (folder / "sweep.toml").is_file():
        raise ResultsError(f"'{folder}' holds a sweep; give the folder of one of its cases, such as {folder / 'case-0'}")


def _typical(folder: Path, program: Optional[Path]) -> int:
    _check(folder)
    chosen = samples_in_detail(read_ensemble(folder, program))
    if not chosen:
        raise ResultsError(f"'{folder}': no sample is done")
    return chosen[0]


def write_sample(folder: Path, number: int, output: Path) -> int:
    """Writes the files; returns how many. Raises ResultsError when the sample is not done."""
    _check(folder)
    files = SampleFiles(folder)
    crack, frames = files.crack(number), files.frames(number)
    if crack is None or frames is None:
        raise ResultsError(f"'{folder}': sample {number} is not done")
    contents = {"crack.vtkhdf": _crack(crack, np.ones(len(crack.time), bool))}
    of_frame = {"frame": lambda k: _frame(frames, k),
                "crack": lambda k: _crack(crack, crack.time <= frames.time[k], frames, k)}
    if tools := files.tools(number):
        of_frame["tools"] = lambda k: _tools(tools, frames, k)
    contents["view.py"] = (Path(__file__).parent / "paraview_view.py").read_bytes()
    for kind, content in of_frame.items():
        contents |= {f"{kind}-{k:04d}.vtkhdf": content(k) for k in range(frames.time.size)}
        # ParaView before 5.12 knows .hdf only; what it finds inside may have any name.
        contents[f"{kind}.hdf.series"] = _series(kind, frames.time)
    output.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        write_whole(output / name, content)
    return len(contents)


def _series(kind: str, times: np.ndarray) -> bytes:
    """The list of the files of a kind with their times [s], in ParaView's form."""
    files = [{"name": f"{kind}-{k:04d}.vtkhdf", "time": float(time)} for k, time in enumerate(times)]
    return (json.dumps({"file-series-version": "1.0", "files": files}, indent=1) + "\n").encode()


def _crack(crack: CrackSurface, opened: np.ndarray, frames: Optional[Frames] = None, k: int = 0) -> bytes:
    """Opened dual facets; points are not shared, so that each facet keeps its own time. With frames they have the
    displacement at frame k, which is that of the tetrahedron they lie in: halfway between both sides of the crack.
    """
    corner, time = crack.corner[opened].astype(float), crack.time[opened]
    n_facets = len(time)
    displacement = {}
    if frames is not None:
        nodes = frames.tetrahedra[crack.tetrahedron[opened]]
        displacement["displacement"] = _interpolated(frames.nodes[nodes], frames.displacement[k][nodes],
                                                     corner).reshape(-1, 3).astype("f4")
    last = float(frames.time[k]) if frames is not None else float(time.max(initial=0.0))
    return vtkhdf.grid(corner.reshape(-1, 3), np.arange(4 * n_facets).reshape(-1, 4), vtkhdf.QUADRILATERAL, last,
                       displacement, {"time": time, "notch": crack.notch[opened].astype("i4")})


def _tools(tools: list[Tool], frames: Frames, k: int) -> bytes:
    """The surfaces of all tools at the start, with their displacement; quadrilaterals with the number of their tool."""
    time, extent = float(frames.time[k]), (frames.nodes.min(axis=0), frames.nodes.max(axis=0))
    points, cells = zip(*(tool_surface(tool, *extent) for tool in tools))
    first = np.cumsum([0, *map(len, points)])
    displacement = [tool.moved(own, time) - own for tool, own in zip(tools, points)]
    number = np.repeat(np.arange(len(tools), dtype="i4"), [len(own) for own in cells])
    return vtkhdf.grid(np.concatenate(points), np.concatenate([own + start for own, start in zip(cells, first)]), vtkhdf.QUADRILATERAL, time,
                       {"displacement": np.concatenate(displacement).astype("f4")}, {"tool": number})


def _interpolated(corner: np.ndarray, values: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Linear in each of n tetrahedra with these corners and values there, n x 4 x 3, at its m points, n x m x 3."""
    gradient = field_gradient(corner, values)
    return values[:, :1] + (points - corner[:, :1]) @ gradient


def _frame(frames: Frames, k: int) -> bytes:
    """Nodes with displacement, velocity and fragment at the end; tetrahedra with their stress in VTK's order xx yy zz xy yz xz, the share of
    their stiffness that softening has left them, 0 where broken, their fragment, -1 where their nodes belong to several or are dust, and their material and Young's modulus where these differ.
    """
    stress = frame_stress(frames, k)
    broken = np.zeros(len(frames.tetrahedra), "u1")
    broken[frames.broken[k]] = 1
    stiffness = np.where(broken == 1, 0, frames.stiffness[k])
    material = {"material": frames.material, "youngs_modulus": frames.youngs_modulus.astype("f4")}
    differing = {name: values for name, values in material.items() if np.ptp(values) > 0}
    tensor = stress[:, (0, 5, 4, 5, 1, 3, 4, 3, 2)].reshape(-1, 3, 3)
    of_nodes = {"fragment": frames.fragment} if frames.fragment.size else {}
    if frames.fragment.size:
        of_corners = frames.fragment[frames.tetrahedra]
        differing["fragment"] = np.where((of_corners == of_corners[:, :1]).all(axis=1), of_corners[:, 0], -1)
    return vtkhdf.grid(frames.nodes, frames.tetrahedra, vtkhdf.TETRAHEDRON, float(frames.time[k]),
                       {"displacement": frames.displacement[k], "velocity": frames.velocity[k], **of_nodes},
                       {"stress": stress[:, (0, 1, 2, 5, 3, 4)].astype("f4"), "broken": broken,
                        "stiffness": stiffness.astype("f4"),
                        "principal_stress": np.linalg.eigvalsh(tensor)[:, 2].astype("f4"), **differing})
