# SPDX-License-Identifier: GPL-3.0-or-later
"""The verification cases: each computes its samples and gives figures beside their references."""
from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from crackle.files import ENSEMBLE_KIND, results

from crackle_runs import JOBS, ROOT, run, with_keys
from figures import MILLIMETRE, Figure, mean, output_of

def notched_strip(folder: Path, program: Path) -> list[Figure]:
    text = (JOBS / "notched-strip.toml").read_text()
    stress, half_width, thickness, modulus, nu = 1e6, 20e-3, 1e-3, 3300e6, 0.3
    depths = (7.5e-3, 8.5e-3)
    lengths = np.linspace(*depths, 201)
    k = stress * np.sqrt(np.pi * lengths / np.cos(np.pi * lengths / (2 * half_width)))
    expected = thickness * np.trapz(k ** 2, lengths) * (1 - nu ** 2) / modulus
    spacings, found = (0.5, 0.25, 0.125), []
    for spacing in spacings:
        energies = []
        for depth in depths:
            keys = {"mesh.notch_spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{2 * spacing} mm"',
                    "specimen.notch.depth": f'"{depth / MILLIMETRE} mm"', "ensemble.samples": "4"}
            samples = run(with_keys(text, keys), folder / f"notched-strip-{spacing}-{depth / MILLIMETRE}", program)
            energies.append([float(sample.energy.strain[-1]) for sample in samples])
        found.append(mean([math.sqrt((longer - shorter) / expected) for shorter, longer in zip(*energies)], ".3f"))
    return [Figure("Centre-notched strip, K from the energies of two depths",
                   f"K over the handbook's, spacings {', '.join(map(str, spacings))} mm at the tip", ", ".join(found), "1")]


TOUGHNESS = 30  # of slow growth [J/m^2]


def slow_growth(folder: Path, program: Path) -> list[Figure]:
    """A strip opened like a wedge, less and less ahead of the crack: it grows with the load, in equilibria."""
    text = re.sub(r"(?s)\[\[mesh\.region\]\].*?\n\n", "", (JOBS / "griffith-strip.toml").read_text())
    head, _ = text.split('[[boundary]]\non = "z-min"')
    tail = "[time]" + text.split("[time]")[1]
    wedge = 'factor = { along = "y", table = [["16 mm", 1], ["36 mm", 0.3]] }'
    loads = "".join(f'[[boundary]]\non = "{face}"\nfix = ["x", "y"]\n'
                    f'[[boundary]]\non = "{face}"\ndisplacement = ["free", "free", "{sign}0.0005 mm"]\n'
                    f'history = [["0 s", 0], ["11 s", 11]]\n{wedge}\n' for face, sign in (("z-min", "-"), ("z-max", "")))
    keys = {"specimen.size": '["2 mm", "36 mm", "12 mm"]', "specimen.notch.at": '"6 mm"', "specimen.notch.depth": '"20 mm"',
            "mesh.spacing": '"1 mm"', "ensemble.samples": "3", "time.arrest": '"1 fs"', "sections.y": '["22 mm", "26 mm", "30 mm"]', "output.frames": "0"}
    samples = run(with_keys(head + loads + tail, keys), folder / "slow-growth", program)
    broken, lost = ([float(sample.energy[part][-1] / sample.summary.traced_area / TOUGHNESS) for sample in samples]
                    for part in ("released", "dissipated"))
    case = "Strip with toughness, opened like a wedge, all breaks quasi-static"
    return [Figure(case, "energy of broken tetrahedra over toughness times traced area", mean(broken, ".2f"), "0.7 to 0.8"),
            Figure(case, "energy lost before the next equilibrium, likewise", mean(lost, ".2f"), "the rest"),
            Figure(case, "both", mean([a + b for a, b in zip(broken, lost)], ".2f"), "1")]


BREAK = ["tetrahedron", "load_time", "phase_time"]
ENGINES = {"double": {"time.precision": '"double"'}, "mixed": {}, "petsc": {"time.engine": '"petsc"'}}


def engines(folder: Path, program: Path) -> list[Figure]:
    """The demo's plate by the fixed-point engine and by PETSc's matrix."""
    text = with_keys((ROOT / "jobs" / "demo.toml").read_text(), {"ensemble.samples": "16"})
    return compare_engines(text, folder, program)


def compare_engines(text: str, folder: Path, program: Path) -> list[Figure]:
    """The samples of an input by PETSc, against those by the fixed-point engine in both precisions."""
    found, paths = {}, {}
    for name, keys in ENGINES.items():
        found[name] = run(with_keys(text, keys), folder / f"engines-{name}", program)
        with results(found[name].folder / "ensemble.h5", ENSEMBLE_KIND) as root:
            paths[name] = root["statistics/z_mean"][:], root["statistics/z_half_width"][:]
    petsc, by = found.pop("petsc"), " and by ".join(f"`{name}`" for name in found)
    equal = [sum(a.breaks[BREAK].equals(b.breaks[BREAK]) for a, b in zip(petsc, other, strict=True)) for other in found.values()]
    counts = {"all breaks equal": equal}
    for title, key in (("load at the onset equal to the last bit", "onset_force"), ("pattern equal", "pattern")):
        pairs = [(petsc.samples[key], other.samples[key]) for other in found.values()]
        counts[title] = [((a == b) | (a.isna() & b.isna())).sum() for a, b in pairs]
    case = f"`engine = \"petsc\"` against fixed-point numbers, by {by}, {len(petsc)} samples"
    (mean, half_width), differences = paths["petsc"], []
    for name in found:
        difference = np.abs(mean - paths[name][0]) / half_width
        differences.append(f"{np.nanmax(difference):.2g}" if np.isfinite(difference).any() else "no path")
    return [*(Figure(case, title, ", ".join(f"{n} of {len(petsc)}" for n in of_engines), "all") for title, of_engines in counts.items()),
            Figure(case, "largest difference of a mean crack position, over its half width", ", ".join(differences), "below 1")]


def test_programs() -> list[Figure]:
    """Figures that the test programs print."""
    waves = output_of("verification.waves")
    lamb = output_of("verification.lamb")
    calculix = output_of("verification.calculix")
    figures = []
    orders = [re.search(rf"{name} wave: from ([\d.]+ to [\d.]+ mm) order ([\d.]+)", waves) for name in "PS"]
    figures.append(Figure("Plane P and S waves of 24 mm", f"order of convergence in space, {orders[0][1]}", ", ".join(order[2] for order in orders), "2"))
    spacings, found = zip(*re.findall(r"spacing ([\d.]+) mm: .* ([\d.]+) %, largest [\d.]+ %", lamb))
    figures.append(Figure("Lamb's problem, closed form of Pekeris and Mooney", f"rms difference of the surface's motion, spacings {', '.join(spacings)} mm",
                          ", ".join(found) + " %", "0"))
    match = re.search(r"displacement within ([\d.e+-]+) of", calculix)
    figures.append(Figure("Growing load on a notched plate, CalculiX on the same mesh",
                          "largest difference of the corner's displacement",
                          f"{100 * float(match.group(1)):.2f} %" if match else "not found", "at most 1 %"))
    return figures
