# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads at which cracks start where there is none, by strength with toughness; used like cases.py."""
from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from crackle_runs import JOBS, run, with_keys
from figures import MILLIMETRE, Figure, mean
from plates import GALLERY, semicircular_notches
from problems import BAR_ARM, BAR_HEIGHT, BAR_SPAN

STRENGTH, RATIOS, SPACINGS = 400e6, (0.2, 0.38), (0.6, 0.4, 0.3)  # [Pa], Poisson's, [mm]
BAR_WIDTH = 2 * MILLIMETRE  # half of the gallery's
HOWLAND = 3.14  # largest stress over that far away, hole of a fifth of the width
CERAMIC = {"material.youngs_modulus": '"380 GPa"', "material.density": '"3900 kg/m^3"', "fracture.strength": '"400 MPa"',
           "fracture.toughness": '"42 J/m^2"', "fracture.release_time": '"0 s"', "fracture.length": None, "mesh.base": '"own"', "ensemble.samples": "8",
           "time.duration": '"1 us"', "time.after_separation": '"1 fs"'}
MODULUS, SCALE, BARS = 10, 580e6, 60  # of Weibull's law for 1 mm^3 [Pa], and samples


def bar(spacing: float, keys: dict[str, str | None]) -> str:
    """The gallery's bar in bending, of one strength."""
    head, tail = (GALLERY / "bend-bar.toml").read_text().split("[fracture.variation]")
    keys = CERAMIC | {"specimen.size": '["2 mm", "3 mm", "45 mm"]', "mesh.spacing": '"0.8 mm"', "mesh.region.spacing": f'"{spacing} mm"'} | keys
    return with_keys(head + tail[tail.index("[[boundary]]"):], keys)


def bar_stress(load: float | np.ndarray) -> float | np.ndarray:
    """Largest stress of a beam between the upper rollers [Pa]."""
    return 3 * load * BAR_ARM / (BAR_WIDTH * BAR_HEIGHT ** 2)


def holed(spacing: float, keys: dict[str, str | None]) -> str:
    """The gallery's plate with a hole of a fifth of the width, fine where the stress is largest."""
    regions = [f'[[mesh.region]]\ny = ["{low} mm", "{low + 2} mm"]\nz = ["24 mm", "26 mm"]\nspacing = "{spacing} mm"\n' for low in (6.5, 11.5)]
    head, tail = (GALLERY / "plate-with-hole.toml").read_text().split("[[mesh.region]]")
    text = head + "".join(regions) + tail[tail.index("[material]"):]
    return with_keys(text, CERAMIC | {"specimen.size": '["1 mm", "20 mm", "50 mm"]', "specimen.hole.radius": '"2 mm"'} | keys)


def notched(spacing: float, keys: dict[str, str | None]) -> str:
    """The bar with semicircular notches of blunt-notch.toml."""
    return with_keys((JOBS / "blunt-notch.toml").read_text().replace('"0.15 mm"', f'"{spacing} mm"'), CERAMIC | keys)


# Input, and largest stress from the load.
BODIES = {"bent bar of 3 mm": (bar, bar_stress),
          "hole of 4 in 20 mm": (holed, lambda load: HOWLAND * load / 20e-6),
          "semicircular notches of 2 in 20 mm": (notched, lambda load: semicircular_notches(0.2) * load / 20e-6)}


def smooth_surfaces(folder: Path, program: Path) -> list[Figure]:
    """The load at the first break over that at which the exact stress reaches the strength."""
    case = f"Load at the first break over that of the exact stress; ν = {' and '.join(map(str, RATIOS))}, {', '.join(map(str, SPACINGS))} mm"
    return [Figure(case, name,
                   "; ".join(", ".join(_first_breaks(name, spacing, nu, folder, program) for spacing in SPACINGS) for nu in RATIOS), "1")
            for name in BODIES]


def _first_breaks(name: str, spacing: float, nu: float, folder: Path, program: Path) -> str:
    text, stress = BODIES[name]
    samples = run(text(spacing, {"material.poisson_ratio": str(nu)}), folder / f"start-{name.split()[0]}-{spacing}-{nu}", program)
    return mean(stress(samples.samples.first_break_load.to_numpy()) / STRENGTH, ".2f")


def effective_volume() -> float:
    """Under uniform tension as likely to break as the bar in bending [m^3]."""
    span = BAR_SPAN - 2 * BAR_ARM + 2 * BAR_ARM / (MODULUS + 1)
    return BAR_WIDTH * BAR_HEIGHT / 2 * span / (MODULUS + 1)


def weibull_bars(folder: Path, program: Path) -> list[Figure]:
    """Weibull's modulus and scale of the loads at fracture of bars in bending, by maximum likelihood."""
    from scipy.stats import weibull_min  # not needed for a run
    expected = SCALE * (1e-9 / effective_volume()) ** (1 / MODULUS)
    moduli, scales = [], []
    for spacing in SPACINGS[:2]:
        text = bar(spacing, {"fracture.strength": f'"{SCALE * 1e-6} MPa"', "ensemble.samples": str(BARS)})
        text += f'[fracture.variation]\ndistribution = "weibull"\nmodulus = {MODULUS}\nreference_volume = "1 mm^3"\n'
        loads = run(text, folder / f"weibull-bars-{spacing}", program).samples.peak_load.to_numpy()
        modulus, _, scale = weibull_min.fit(bar_stress(loads), floc=0)
        error = 1.96 / math.sqrt(len(loads))  # of the estimates: 0.78 of the modulus, 1.05 / modulus of the scale
        moduli.append(f"{modulus:.1f} ± {0.78 * error * modulus:.1f}")
        scales.append(f"{scale / expected:.3f} ± {1.05 * error / modulus * scale / expected:.3f}")
    case = f"{BARS} bars with a Weibull strength in four-point bending, {' and '.join(map(str, SPACINGS[:2]))} mm; 95 % intervals"
    return [Figure(case, "modulus", ", ".join(moduli), f"{MODULUS}"),
            Figure(case, "scale over that of the effective volume", ", ".join(scales), "1")]
