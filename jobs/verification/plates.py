# SPDX-License-Identifier: GPL-3.0-or-later
"""The verification cases of plates that are no boxes; used like cases.py."""
from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Sequence

import numpy as np
from crackle import Ensemble, Sample

from crackle_report.photoelasticity import Grid, Optics, make_fringes
from crackle_report.stress import element_stress
from crackle_runs import JOBS, run, with_keys
from figures import MILLIMETRE, Figure, mean, output_of
from problems import DISK_ARC, DISK_RADIUS, DISK_THICKNESS, PLATEN, PROBLEMS, onset_loads

GALLERY = JOBS.parent / "gallery"


def _point(y: float, z: float) -> str:
    return f'["{y:.4f} mm", "{z:.4f} mm"]'


INCLINATIONS = (0, 15, 30, 45, 60)  # of the slot to the normal of the load [degrees]
SLOT, MIDDLE = 6, np.array([20, 30])  # half length and middle of the slot [mm]
TIP_SPACING = 0.25  # of the points at the slot's tips [mm]
KINK_RANGE = (0.5, 2)  # from the slot's tip, in which a crack's direction is measured [mm]


def kinks(folder: Path, program: Path) -> list[Figure]:
    """Directions in which cracks leave the tips of an inclined slot, and of a level one under the loads of an inclined one."""
    at = ", ".join(map(str, INCLINATIONS))
    inclined = [run(inclined_slot(degrees), folder / f"inclined-slot-{degrees}", program) for degrees in INCLINATIONS]
    level = [run(level_slot(degrees), folder / f"level-slot-{degrees}", program) for degrees in INCLINATIONS]
    expected = ", ".join(f"{kink(degrees):.1f}" for degrees in INCLINATIONS) + "°"
    with_stress = ", ".join(f"{kink_at_one_spacing(degrees):.1f}" for degrees in INCLINATIONS[1:])
    where = f"mean angle of cracks to the slot, {KINK_RANGE[0]} to {KINK_RANGE[1]} mm from its tip"
    return [Figure(f"Inclined slot under tension: {where}", f"inclined by {at}°; {len(inclined[0])} samples each", _kinks(inclined, INCLINATIONS),
                   f"{expected}, Erdogan and Sih 1963; with the stress along the slot, from {INCLINATIONS[1]}° on, {with_stress}°"),
            Figure("The same K at a level slot, without stress along it",
                   f"K_II / K_I = tan of {at}°; {len(level[0])} samples each", _kinks(level, [0] * len(level)), expected)]


def _kinks(ensembles: list[Ensemble], slopes: Sequence[float]) -> str:
    """Mean and 95 % interval of each [degrees]; `slopes` of the slots."""
    texts = []
    for ensemble, slope in zip(ensembles, slopes):
        found = [angle for sample in ensemble for angle in kink_angles(sample, slope)]
        texts.append(f"{np.mean(found):.1f} ± {1.96 * np.std(found, ddof=1) / math.sqrt(len(found)):.1f}")
    return ", ".join(texts) + "°"


def inclined_slot(degrees: float) -> str:
    """The input of a slot at an angle to the normal of the load."""
    slope = math.radians(degrees)
    half = SLOT * np.array([math.cos(slope), math.sin(slope)])
    keys = {"specimen.notch.from": _point(*(MIDDLE - half)), "specimen.notch.to": _point(*(MIDDLE + half))}
    return with_keys((JOBS / "inclined-slot.toml").read_text(), keys)


def level_slot(degrees: float) -> str:
    """The input of a slot at no angle, with K as the one at an angle has them, and no stress along it."""
    head, tail = inclined_slot(0).split("[[boundary]]", 1)
    slope = math.radians(degrees)
    return head + _stress_without_t(10 * math.cos(slope) ** 2, 10 * math.sin(slope) * math.cos(slope)) + "[time]" + tail.split("[time]")[1]


def _stress_without_t(normal: float, shear: float) -> str:
    """Boundary conditions: sigma_yy = sigma_zz and sigma_yz at all edges, growing with time [MPa/s]."""
    text = ""
    for face, y, z in (("z-max", shear, normal), ("z-min", -shear, -normal), ("y-max", normal, shear), ("y-min", -normal, -shear)):
        text += (f'[[boundary]]\non = "{face}"\ntraction = ["0 MPa", "0 MPa", "0 MPa"]\n'
                 f'rate = ["0 MPa/s", "{y:.6f} MPa/s", "{z:.6f} MPa/s"]\n')
    # Reactions vanish: the loads are balanced.
    return text + ('[[boundary]]\non = "z-min"\nregion = { y = ["0 mm", "1 mm"] }\nfix = ["x", "y", "z"]\n'
                   '[[boundary]]\non = "z-min"\nregion = { y = ["39 mm", "40 mm"] }\nfix = ["z"]\n')


def kink(mixing: float) -> float:
    """Erdogan and Sih's direction where K_II / K_I = tan `mixing` [degrees]."""
    return largest_hoop_stress(math.cos(math.radians(mixing)), math.sin(math.radians(mixing)))


def kink_at_one_spacing(inclination: float) -> float:
    """Direction of the largest hoop stress at one spacing from an inclined slot under tension [degrees]."""
    slope = math.radians(inclination)
    # Over sigma sqrt(pi a), K is cos(slope) times (cos, sin); the stress along the slot is -cos(2 slope) sigma.
    t = -math.cos(2 * slope) * math.sqrt(2 * TIP_SPACING / SLOT)
    return largest_hoop_stress(math.cos(slope) ** 2, math.sin(slope) * math.cos(slope), t)


def largest_hoop_stress(k1: float, k2: float, t: float = 0) -> float:
    """Direction to the crack of the largest hoop stress at a distance r from its tip [degrees].

    @param t: the stress along the crack (T) times sqrt(2 pi r), in the units of K; Erdogan and Sih (1963) have none,
        Smith, Ayatollahi and Pavier (2001) take r for a property of the material
    """
    angle = np.radians(np.linspace(-120, 120, 240_001))
    hoop = np.cos(angle / 2) * (k1 * np.cos(angle / 2) ** 2 - 1.5 * k2 * np.sin(angle)) + t * np.sin(angle) ** 2
    return float(np.degrees(angle[hoop.argmax()]))


def kink_angles(sample: Sample, inclination: float) -> list[float]:
    """Angles of the cracks at both tips to the slot, positive as the slot's inclination [degrees]."""
    slope = math.radians(inclination)
    surface = sample.crack_surface
    place, time, area = surface.corners.values.mean(axis=1)[:, 1:] / MILLIMETRE, surface.time.values, surface.area.values
    angles = []
    for side in (1, -1):
        out = side * np.array([math.cos(slope), math.sin(slope)])
        ahead = place - (MIDDLE + SLOT * out)
        distance = np.hypot(*ahead.T)
        near = distance < KINK_RANGE[1]
        # Later ones are branches, and what breaks behind the front.
        leaves = time[~near & (distance < 2 * KINK_RANGE[1])].min(initial=math.inf)
        here = near & (distance > KINK_RANGE[0]) & (time <= leaves)
        if here.any() and distance[here].max() > 0.9 * KINK_RANGE[1]:
            along, across = ahead[here] @ out, ahead[here] @ np.array([-out[1], out[0]])
            weight = area[here]
            along, across = (v - np.average(v, weights=weight) for v in (along, across))
            # The axis along which the facets lie.
            moment = np.array([[np.sum(weight * a * b) for b in (along, across)] for a in (along, across)])
            axis = np.linalg.eigh(moment)[1][:, -1]
            mean = np.average(ahead[here], axis=0, weights=weight) @ np.array([out, [-out[1], out[0]]]).T
            axis *= np.sign(axis @ mean)
            angles.append(math.degrees(math.atan2(axis[1], axis[0])))
    return angles


OFFSETS = (0.6, 0.7, 0.75, 0.775, 0.8, 0.825, 0.85, 0.9)  # of the notch from the middle, over half of the span
HALF_SPAN, BEAM_MIDDLE = 101.6, 114.3  # of offset-notch.toml [mm]


def offset_notch(folder: Path, program: Path) -> list[Figure]:
    """Where a beam under impact breaks, from its notch or from its middle."""
    case = "Beam with an offset notch under impact, John and Shah 1990"
    shares = []
    for offset in OFFSETS:
        samples = run(beam(offset), folder / f"offset-notch-{offset}", program)
        # Rows: the notch, then the free surface; sections at 0.4 and 0.66 of the depth.
        notch, middle = np.isfinite(samples.paths.position.values[:, :2, 1]).sum(axis=0)
        shares.append((offset, notch, middle, len(samples)))
    from_notch = [offset for offset, notch, middle, n in shares if notch == n and middle == 0]
    from_middle = [offset for offset, notch, middle, n in shares if middle == n and notch == 0]
    at = ", ".join(f"{offset:g}" for offset in OFFSETS)
    return [Figure(case, f"samples that break from the notch, at {at} of half of the span from the middle",
                   ", ".join(f"{notch}/{n}" for _, notch, _, n in shares), "all, then none"),
            Figure(case, "from mid-span", ", ".join(f"{middle}/{n}" for _, _, middle, n in shares), "none, then all"),
            Figure(case, "offset of the transition", f"{max(from_notch, default=math.nan):g} to {min(from_middle, default=math.nan):g}",
                   "0.77")]


def beam(offset: float) -> str:
    """The input with the notch at `offset` of half of the span from the middle."""
    z = BEAM_MIDDLE - offset * HALF_SPAN
    keys = {"specimen.notch.from": _point(0, z), "specimen.notch.to": _point(19, z), "ensemble.samples": "8"}
    return with_keys((GALLERY / "offset-notch.toml").read_text(), keys)


BLUNT_LAWS = {"averaged over 0.3 mm": {}, "averaged over 0.6 mm": {"fracture.length": '"0.6 mm"'},
              "softening with E G / strength² = 0.6 mm": {"fracture.length": None, "fracture.toughness": '"223 J/m^2"',
                                                      "fracture.release": '"softening"'}}


def blunt_notch(folder: Path, program: Path) -> list[Figure]:
    """The load at which a bar with semicircular notches fails, beside strength over stress concentration."""
    text = (JOBS / "blunt-notch.toml").read_text()
    expected = 35e6 * 20e-6 / semicircular_notches(0.2)
    found = [mean(onset_loads(run(with_keys(text, keys), folder / f"blunt-notch-{law.split()[0]}-{law.split()[-2]}", program)) / expected, ".3f")
             for law, keys in BLUNT_LAWS.items()]
    return [Figure("Bar with semicircular notches of 2 mm in a width of 20 mm",
                   f"load at failure over that at which the root reaches the strength; {', '.join(BLUNT_LAWS)}", ", ".join(found), "1")]


def semicircular_notches(depth: float) -> float:
    """Largest stress over the one far away, in tension, where two opposite notches take the share `depth` of the width.

    Ling 1968, in the form of Peterson's handbook.
    """
    return (3.065 - 3.472 * depth + 1.009 * depth ** 2 + 0.405 * depth ** 3) / (1 - depth)


PRESSURE = 20e6  # on the arcs of disk.toml, which are those of the gallery's platens [Pa]


def diameter_fringes(text: str, folder: Path, program: Path) -> np.ndarray:
    """Fringe order over Hondros' at places on the middle 60 % of the loaded diameter of each sample, before it breaks."""
    z = DISK_RADIUS * np.linspace(0.4, 1.6, 61)
    ratio = []
    for sample in run(text, folder, program):
        nodes, tetrahedra, boundary = (sample.mesh[name] for name in ("nodes", "tetrahedra", "boundary"))
        stress = element_stress(nodes, tetrahedra, sample.frames.displacement[0].values, 15e9, 0.2)
        order = make_fringes(nodes, tetrahedra, stress, Grid(np.array([DISK_RADIUS]), z)).order[:, 0]
        # The program presses on the triangles whose centroids are in the region.
        corner = nodes[boundary]
        area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2] / 2
        load = PRESSURE * area[corner[:, :, 2].mean(axis=1) > 2 * DISK_RADIUS - PLATEN].sum()
        ratio.append(order / (Optics().order_per_stress_length * DISK_THICKNESS * hondros(load, z / DISK_RADIUS - 1)))
    return np.array(ratio)


def disk(folder: Path, program: Path) -> list[Figure]:
    """A disk under diametral load: its fringes before it breaks, its strength, and where it splits."""
    ratio = diameter_fringes((JOBS / "disk.toml").read_text(), folder / "disk-elastic", program)
    case = "Disk under diametral load"
    samples = run(PROBLEMS["brazilian-disk"].input_text(), folder / "disk", program)
    split = np.concatenate([_first_on_the_diameter(sample) for sample in samples])
    return [Figure(case, "fringe order on the middle 60 % of the loaded diameter over Hondros', mean and each place of each sample",
                   f"{np.mean(ratio):.3f} ± {np.std(ratio):.3f}", "1"),
            Figure(case, f"distance from the diameter of the first {FIRST} facets that open there, rms, over the radius",
                   f"{np.sqrt(np.mean((split - DISK_RADIUS) ** 2)) / DISK_RADIUS:.3f}", "0")]


FIRST = 200  # facets, of some 1000 of the split; what breaks later are the halves


def _first_on_the_diameter(sample: Sample) -> np.ndarray:
    """y of the first facets that open on the middle 60 % of the disk's height [m]."""
    place = sample.crack_surface.corners.values.mean(axis=1)
    middle = np.flatnonzero(np.abs(place[:, 2] / DISK_RADIUS - 1) < 0.6)
    return place[middle[np.argsort(sample.crack_surface.time.values[middle], kind="stable")[:FIRST]], 1]


def hondros(load: float, place: np.ndarray) -> np.ndarray:
    """Difference of the principal stresses on the loaded diameter, at `place` times the radius from the middle [Pa].

    Hondros 1959, for the same radial pressure on two opposite arcs.
    """
    pressure = load / (2 * DISK_RADIUS * DISK_THICKNESS * math.sin(DISK_ARC))
    square = place ** 2
    return (4 * pressure / math.pi * (1 - square) * math.sin(2 * DISK_ARC)
            / (1 - 2 * square * math.cos(2 * DISK_ARC) + square ** 2))


CORNER, REAL_THICKNESS = 0.25, 0.1  # of the L-shaped panel, and of the one that was tested [m]
# Load of Winkler's series A over the deflection [mm, kN], read from his figure 7.12 by the group of C. Linder
# (github.com/PSAAPGroupLinder/lShapedPanelBenchmark).
WINKLER = ((0.1, 4.18), (0.3, 5.27), (0.4, 3.52), (0.5, 2.47))
WINKLER_PEAK = (0.208, 7.22)


def l_panel(folder: Path, program: Path) -> list[Figure]:
    """Load and crack of the L-shaped panel; the loads are those to which it rose before something gave way."""
    peaks, curves = [], []
    samples = run((GALLERY / "l-panel.toml").read_text(), folder / "l-panel", program)
    for sample in samples:
        thickness = 0.04
        history = sample.history
        time = history.time.values
        risen = (history.phase.values == 0) & (np.diff(time, prepend=0) > 0)
        deflection = time[risen] * 1e-3  # [mm]
        load = history.governing_load.values[risen] * 1e-3 * REAL_THICKNESS / thickness  # [kN]
        peaks.append((deflection[load.argmax()], load.max()))
        curves.append([float(np.interp(d, deflection, load)) for d, _ in WINKLER])
    rises = (samples.paths.position.values[:, 0, ::-1] - CORNER) / MILLIMETRE
    case = "L-shaped panel, Winkler 2001; loads of 100 mm"
    at = ", ".join(f"{d:g}" for d, _ in WINKLER)
    return [Figure(case, "largest load", mean([load for _, load in peaks], ".2f") + " kN", f"{WINKLER_PEAK[1]} kN"),
            Figure(case, "at a deflection of", mean([d for d, _ in peaks], ".2f") + " mm", f"{WINKLER_PEAK[0]} mm"),
            Figure(case, f"loads at deflections of {at} mm", ", ".join(f"{v:.1f}" for v in np.mean(curves, axis=0)) + " kN",
                   ", ".join(f"{v:.1f}" for _, v in WINKLER) + " kN"),
            Figure(case, "height of the crack above the corner, 50, 100 and 150 mm from it",
                   ", ".join(f"{np.mean(v):.0f} ± {np.std(v, ddof=1):.0f}" for v in np.transpose(rises)) + " mm",
                   "rises; published as a picture")]


def test_programs() -> list[Figure]:
    """Figures that the test programs of plates print."""
    hole, stress_intensity = output_of("verification.plates"), output_of("verification.plate_stress_intensity")
    spacings, errors = zip(*re.findall(r"spacing ([\d.]+) of the radius: .*?, ([+-][\d.]+) %", hole))
    order = math.log(float(errors[0]) / float(errors[-1])) / math.log(4)
    case = "Hole of a fifth of the width, Howland 1930"
    figures = [Figure(case, f"largest stress over 3.14 times that far away, spacings {', '.join(spacings)} of the radius",
                      ", ".join(f"{1 + float(error) / 100:.3f}" for error in errors), "1"),
               Figure(case, "order of convergence", f"{order:.2f}", "at least 1")]
    wheres, ratios = zip(*re.findall(r"compact tension, (.*?): K over Srawley's ([\d.]+)", stress_intensity))
    figures.append(Figure("Compact tension specimen, K from the energies of two slots; Srawley 1976",
                          f"K over Srawley's, spacings {', '.join(re.findall('[0-9.]+', ' '.join(wheres)))} mm at the tip, extrapolated to zero",
                          ", ".join(ratios), "1"))
    degrees, *k = zip(*re.findall(r"slot inclined by (\d+) degrees: K_I (\S+), K_II (\S+) of .*? plate (\S+), (\S+)", stress_intensity))
    k_texts = (f"K_I over σ √(π a), inclined by {', '.join(degrees)}°", ", a crack in an endless plate"), ("K_II, likewise", "")
    return figures + [Figure("Slot of a tenth of the width, by the interaction integral", quantity, ", ".join(k[i]), ", ".join(k[i + 2]) + whose)
                      for i, (quantity, whose) in enumerate(k_texts)]
