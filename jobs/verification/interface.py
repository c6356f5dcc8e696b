# SPDX-License-Identifier: GPL-3.0-or-later
"""A crack at an interface, at a right angle: it is deflected along the interface, or goes on through it."""
from __future__ import annotations

import tomllib
from pathlib import Path

import crackle
import numpy as np

from crackle_runs import JOBS, run, with_keys
from figures import MILLIMETRE, Figure

RATIOS = (0.16, 0.18, 0.20, 0.23, 0.26, 0.30, 1.00)  # of the interface's toughness to the material's
SPACINGS = {0.2: 8, 0.13: 4}  # at the tip [mm], and the number of samples
PLACE = 6 * MILLIMETRE, 8 * MILLIMETRE  # y and z of the notch's tip, which lies on the interface
WAY, BAND = 1 * MILLIMETRE, 0.5 * MILLIMETRE  # along either, by which a crack counts as gone there, and how far it may be from the interface


def is_deflected(sample: crackle.Sample) -> bool:
    """True if tetrahedra break along the interface before any breaks beyond it."""
    mesh, broken = sample.mesh, sample.breaks["tetrahedron"].to_numpy()
    beyond, aside = (mesh["nodes"][mesh["tetrahedra"][broken], 1:].mean(axis=1) - PLACE).T
    along = np.flatnonzero((np.abs(beyond) < BAND) & (np.abs(aside) > WAY))
    through = np.flatnonzero(beyond > WAY)
    return len(along) > 0 and (len(through) == 0 or along[0] < through[0])


def interface(folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "interface.toml").read_text()
    toughness = float(tomllib.loads(text)["fracture"]["toughness"].split()[0])
    shares = []
    for spacing, n_samples in SPACINGS.items():
        keys = {"ensemble.samples": str(n_samples), "mesh.region.spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{spacing} mm"'}
        shares.append(", ".join(f"{sum(map(is_deflected, samples))}/{len(samples)}" for samples in (
            run(with_keys(text, {**keys, "interface.toughness": f'"{ratio * toughness:g} J/m^2"'}),
                folder / f"interface-{spacing}-{ratio}", program) for ratio in RATIOS)))
    return [Figure(f"Crack across an interface of equal materials, spacings {', '.join(map(str, SPACINGS))} mm",
                   f"share that breaks 1 mm along it before 1 mm beyond it, toughness {', '.join(f'{ratio:.2f}' for ratio in RATIOS)} of the material's",
                   "; ".join(shares), "all below 0.26, none above, He and Hutchinson 1989, to one side")]
