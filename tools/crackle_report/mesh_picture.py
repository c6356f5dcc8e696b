# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of a realization, cut at mid-thickness, as a PNG; tools/crackle-mesh-picture runs this."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

from crackle.files import ResultsError

from . import style
from .figures.material import strength
from .figures.realizations import spacing
from .mesh import read_mesh
from .writing import write_light_figure


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="crackle-mesh-picture",
        description="Draws the tetrahedra of a realization that the plane at mid-thickness cuts, coloured by the spacing "
                    "that the input asks for, with the regions of the mesh and their numbers of points: the whole plate, "
                    "and the ligament. Where the material varies, also the strength of the tetrahedra, into NAME-strength.png.")
    parser.add_argument("mesh", type=Path, help="file that 'crackle mesh' has written")
    parser.add_argument("-o", "--output", type=Path, help="default: the mesh's name with .png")
    arguments = parser.parse_args()
    style.apply()
    file = arguments.output or arguments.mesh.with_suffix(".png")
    try:
        mesh = read_mesh(arguments.mesh)
        write_light_figure(spacing(mesh).figure, file)
        print(file)
        if mesh.strength_factor is not None:
            field = file.with_name(f"{file.stem}-strength{file.suffix}")
            write_light_figure(strength(mesh, mesh.plate, "round the notches").figure, field)
            print(field)
    except (ResultsError, OSError, ValueError, KeyError) as error:
        print(f"crackle-mesh-picture: {error}", file=sys.stderr)
        return 1
    return 0
