# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the mother points and realizations of an input; tools/realization-campaign runs this."""
from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from . import style
from .figures import realizations
from .mesh import Mesh, read_mesh
from .writing import write_light_figure

SAMPLE = 0
PERTURBATION = 0.2  # of the meshes whose orientations are compared
N_SAMPLES = 10
LENGTH, SPACING, MARGIN = 10.0, 0.4, 0.8  # of the box that they fill, and from its surface inwards [mm]

# A cube without notches; what is not about the mesh is of no consequence.
BOX = f"""[ensemble]
samples = {N_SAMPLES}
[specimen]
size = ["{LENGTH} mm", "{LENGTH} mm", "{LENGTH} mm"]
[mesh]
spacing = "{SPACING} mm"
perturbation = {PERTURBATION}
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.38
density = "1180 kg/m^3"
[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[time]
duration = "1 us"
[sections]
y = ["5 mm"]
"""


def main() -> int:
    parser = argparse.ArgumentParser(prog="crackle_report.realizations", description=__doc__)
    parser.add_argument("folder", type=Path, help="for the meshes and pictures")
    parser.add_argument("--program", type=Path, required=True, help="crackle")
    parser.add_argument("--input", type=Path, required=True, help="input file of the plate")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    style.apply()
    make = Maker(arguments.program.resolve(), arguments.folder)

    text = arguments.input.read_text(encoding="utf-8")
    undisturbed, n_replaced = re.subn(r"(?m)^perturbation = .*$", "perturbation = 0", text)
    if n_replaced != 1:
        print(f"{arguments.input}: no line 'perturbation = ...'", file=sys.stderr)
        return 1
    pictures = [
        realizations.base_points(make("base", undisturbed, SAMPLE)),
        realizations.cut(make("realization", text, SAMPLE), SAMPLE),
        realizations.orientations({
            "cubic lattice": make.lattice("cubic", False),
            "body-centred lattice": make.lattice("body-centred", True),
            "blue noise of crackle": make.facets("blue-noise", BOX),
        }, PERTURBATION),
    ]
    for picture in pictures:
        file = arguments.folder / f"{picture.name}.png"
        write_light_figure(picture.figure, file)
        print(file)
    return 0


class Maker:
    """Makes meshes with the program."""

    def __init__(self, program: Path, folder: Path) -> None:
        self._program, self._folder = program, folder

    def __call__(self, name: str, text: str, sample: int) -> Mesh:
        """One realization of an input text."""
        setting, mesh = self._folder / f"{name}.toml", self._folder / f"{name}.vtkhdf"
        setting.write_text(text, encoding="utf-8")
        subprocess.run([self._program, "mesh", setting, "--sample", str(sample), "-o", mesh], check=True,
                       stdout=subprocess.DEVNULL)
        return read_mesh(mesh)

    def facets(self, name: str, text: str) -> np.ndarray:
        """The dual facets of many realizations of the box, away from its surface, n x 3."""
        kept = []
        for sample in range(N_SAMPLES):
            mesh = self(name, text, sample)
            centroid = mesh.nodes[mesh.tetrahedra].mean(axis=1) / style.MILLIMETRE
            inside = ((centroid > MARGIN) & (centroid < LENGTH - MARGIN)).all(axis=1)
            kept.append(mesh.dual_facets()[inside].reshape(-1, 3))
        return np.concatenate(kept)

    def lattice(self, name: str, body_centred: bool) -> np.ndarray:
        """As facets, from a lattice with about as many points as the blue noise has."""
        n = round(LENGTH / SPACING / (2 ** (1 / 3) if body_centred else 1))
        points = np.stack(np.meshgrid(*[np.arange(n + 1)] * 3), axis=-1).reshape(-1, 3).astype(float)
        if body_centred:
            points = np.concatenate([points, points[(points < n).all(axis=1)] + 0.5])
        np.savetxt(self._folder / f"{name}.txt", points * LENGTH / n, fmt="%.12g")
        # Without a bound on the quality the lattice is taken as it is.
        return self.facets(name, BOX.replace("[mesh]", f'[mesh]\npoints = "{name}.txt"\nmin_quality = 0'))


if __name__ == "__main__":
    sys.exit(main())
