# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads at which cracks start where there is none, by strength with toughness."""
from __future__ import annotations

import math
from pathlib import Path
from typing import Callable

import crackle
import numpy as np

from crackle_runs import JOBS, ROOT, run, with_keys
from fast import IMMEDIATE
from figures import MILLIMETRE, Comparison, Figure, Quantity, result
from plates import GALLERY, semicircular_notches
from problems import BAR_ARM, BAR_HEIGHT, BAR_SPAN

STRENGTH, RATIOS, SPACINGS = 400e6, (0.2, 0.38), (0.6, 0.4, 0.3)  # [Pa], Poisson's, [mm]
BAR_WIDTH = 2 * MILLIMETRE  # half of the gallery's
HOWLAND = 3.14  # largest stress over that far away, hole of a fifth of the width
CERAMIC = {"material.youngs_modulus": '"380 GPa"', "material.density": '"3900 kg/m^3"', "fracture.strength": '"400 MPa"',
           "fracture.toughness": '"42 J/m^2"', "fracture.release_time": None, "fracture.impulse": None, "fracture.length": None,
           "mesh.base": '"own"', "time.duration": '"1 us"', "time.after_separation": '"1 fs"'}
MODULUS, SCALE = 10, 580e6  # of Weibull's law for 1 mm^3 [Pa]


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


def _over_exact(stress: Callable[[np.ndarray], np.ndarray]) -> Callable[[crackle.Ensemble], np.ndarray]:
    return lambda ensemble: stress(ensemble.samples.first_break_load[ensemble.done].to_numpy()) / STRENGTH


smooth_surfaces = {f"{name.split()[0]}-{nu}": Comparison(
    f"Load at the first break over that of the exact stress, {', '.join(map(str, SPACINGS))} mm; before: by own stress", f"start-{name.split()[0]}-{nu}",
    {f"{spacing}": text(spacing, {"material.poisson_ratio": str(nu)}) for spacing in SPACINGS},
    (Quantity(f"{name}, ν = {nu}", _over_exact(stress), ".3f", "1"),), 8, IMMEDIATE) for name, (text, stress) in BODIES.items() for nu in RATIOS}


def effective_volume() -> float:
    """Under uniform tension as likely to break as the bar in bending [m^3]."""
    span = BAR_SPAN - 2 * BAR_ARM + 2 * BAR_ARM / (MODULUS + 1)
    return BAR_WIDTH * BAR_HEIGHT / 2 * span / (MODULUS + 1)


BARS, BAR_SPACINGS = 60, (0.6, 0.4, 0.3)  # [mm]


def weibull_bars(folder: Path, program: Path) -> list[Figure]:
    """Weibull's modulus and scale of the loads at fracture of bars in bending, by maximum likelihood."""
    from scipy.stats import weibull_min  # not needed for a run
    expected = SCALE * (1e-9 / effective_volume()) ** (1 / MODULUS)
    moduli, scales = [], []
    for spacing in BAR_SPACINGS:
        text = bar(spacing, {"fracture.strength": f'"{SCALE * 1e-6} MPa"', "ensemble.samples": str(BARS)})
        text += f'[fracture.variation]\ndistribution = "weibull"\nmodulus = {MODULUS}\nreference_volume = "1 mm^3"\n'
        loads = run(text, folder / f"weibull-bars-{spacing}", program).samples.peak_load.to_numpy()
        modulus, _, scale = weibull_min.fit(bar_stress(loads), floc=0)
        error = 1.96 / math.sqrt(len(loads))  # of the estimates: 0.78 of the modulus, 1.05 / modulus of the scale
        moduli.append(f"{modulus:.1f} ± {0.78 * error * modulus:.1f}")
        scales.append(f"{scale / expected:.3f} ± {1.05 * error / modulus * scale / expected:.3f}")
    case = f"{BARS} bars with a Weibull strength in four-point bending, {', '.join(map(str, BAR_SPACINGS))} mm; 95 % intervals"
    return [Figure(case, "modulus", "; ".join(moduli), f"{MODULUS}"),
            Figure(case, "scale over that of the effective volume", "; ".join(scales), "1")]


# The paper's slot

TIPS = (0.2, 0.15, 0.1, 0.07)  # spacings at the slots' ends [mm]
CREAGER_PARIS = 660  # load of the plate of 5 mm at which they have the paper's strength at a round end [N]


def slotted(tip: float, end: str) -> str:
    """The paper's plate, 1 mm thick, with its strength and slots with this end."""
    slots = "".join(f'[[specimen.notch]]\nfrom = ["{outside} mm", "{at} mm"]\nto = ["{inside} mm", "{at} mm"]\nheight = "0.6 mm"\nend = "{end}"\n'
                    for outside, inside, at in ((0, 2.5, 67), (24.5, 22, 73)))
    head, tail = (ROOT / "jobs" / "thin-plate.toml").read_text().split("[[specimen.notch]]", 1)
    return with_keys(head + slots + tail[tail.index("[mesh]"):],
                     {"mesh.spacing": '"1 mm"', "mesh.notch_spacing": f'"{tip} mm"', "mesh.growth": "0.2", "fracture.strength": '"35 MPa"',
                      "fracture.toughness": '"57 J/m^2"', "time.duration": '"2 us"', "output.frames": "0"})


slots = {f"slot-{end}": Comparison(
    f"The paper's slot with a {end} end, 35 MPa and 57 J/m², {', '.join(map(str, TIPS))} mm there; before: by own stress", f"slot-{end}",
    {f"{tip}": slotted(tip, end) for tip in TIPS},
    (Quantity("load at the onset, for 5 mm of thickness", result("onset_force", 5), ".0f", reference, " N"),), 8, IMMEDIATE)
    for end, reference in (("round", f"{CREAGER_PARIS} N, Creager and Paris 1967"), ("square", "grows without bound"))}

# A bond

LENGTH = {"fracture.length": '"1.2 mm"'}
BOND_LAWS = {"means around nodes": {}, "own stress": {"fracture.nucleation": '"own-stress"'}, "averaged over 1.2 mm": LENGTH, "over 2.4 mm": {"fracture.length": '"2.4 mm"'},
             "softening": {"fracture.toughness": '"300 J/m^2"', "fracture.release": '"softening"'}}
bond = Comparison(f"Bond of 12 MPa; {', '.join(BOND_LAWS)}", "bond",
                  {law.replace(" ", "-"): with_keys((JOBS / "bond.toml").read_text(), keys) for law, keys in BOND_LAWS.items()},
                  (Quantity("load", result("onset_force"), ".1f", "48 N", " N"),), 4)

CASES = {**smooth_surfaces, "weibull-bars": weibull_bars, **slots, "bond": bond}
