# SPDX-License-Identifier: GPL-3.0-or-later
"""Fast cracks on several meshes: their speeds, energies and branches under the law, beside another one."""
from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Callable

import crackle
import numpy as np

from crackle_runs import JOBS, ROOT, run, with_keys
from figures import MILLIMETRE, Comparison, Figure, Quantity, each, result
from problems import LONG_BRANCH, projected_branching

OWN = {"fracture.nucleation": '"own-stress"', "fracture.release_speed": None}
IMMEDIATE = OWN | {"fracture.release_time": '"0 s"'}
STEP = 0.5 * MILLIMETRE  # between places at which the front's arrival counts


def released_in(time: str) -> dict[str, str | None]:
    """The law before: own stress at the start, and on any spacing the same time of release."""
    return OWN | {"fracture.release_time": f'"{time}"', "fracture.impulse": '"1e-8 MPa^2 s"'}


def starts_elsewhere(sample: crackle.Sample) -> np.ndarray:
    """Of each facet whether its crack started elsewhere than at the slot."""
    with sample.open() as root:
        return root["crack_surface/cracks/notch"][...][root["crack_surface/crack"][...]] < 0


def arrivals(sample: crackle.Sample, places: np.ndarray) -> np.ndarray:
    """When the slot's crack had the first facet at each y or beyond it [s]; NaN if it had none."""
    surface, own = sample.crack_surface, ~starts_elsewhere(sample)
    y, time = surface.corners.values[own, :, 1].mean(axis=1), surface.time.values[own]
    return np.array([time[y >= place].min() if (y >= place).any() else math.nan for place in places])


def arrival(sample: crackle.Sample, place: float) -> float:
    return float(arrivals(sample, np.array([place]))[0])


def rayleigh(sample: crackle.Sample) -> float:
    return sample.summary.crack_speed_max / sample.summary.crack_speed_ratio


def front_speed(low: float, high: float) -> Callable[[crackle.Sample], float]:
    """Slope of the foremost facet's arrival between two y [mm], over Rayleigh's speed; NaN where it does not get there."""
    places = np.arange(low * MILLIMETRE, high * MILLIMETRE + STEP / 2, STEP)

    def speed(sample: crackle.Sample) -> float:
        times = arrivals(sample, places)
        return float(np.polyfit(times, places, 1)[0]) / rayleigh(sample) if np.isfinite(times).all() else math.nan
    return speed


# The prestrained strip of PMMA: Bleyer et al. 2017

TIP, HEIGHT, TOUGHNESS = 4, 16, 300  # [mm, J/m^2]
SPACINGS = (0.35, 0.25, 0.17)  # [mm]
TRAVELS = {0.030: 396, 0.040: 704, 0.050: 1100}  # of each long edge [mm], and what is stored [J/m^2]
WAY = front_speed(10, 27)
FRONT_WINDOW = 2 * MILLIMETRE  # along a crack, over which its speed where it branches is measured


def strip(spacing: float, travel: float, keys: dict[str, str | None] | None = None) -> str:
    text = (JOBS / "pmma-strip.toml").read_text()
    assert text.count('0.040 mm"') == 2
    keys = {"mesh.spacing": f'"{spacing} mm"', "specimen.notch.height": f'"{spacing} mm"'} | (keys or {})
    return with_keys(text.replace('0.040 mm"', f'{travel} mm"'), keys)


def of_those_that_run(value: Callable[[crackle.Sample], float]) -> Callable[[crackle.Ensemble], list[float]]:
    return each(lambda sample: float(value(sample)) if math.isfinite(WAY(sample)) else math.nan)


def at_first_branching(value: Callable[[crackle.Sample, object], float]) -> Callable[[crackle.Ensemble], list[float]]:
    """Of the sample and its first branching point along the strip."""
    def of(sample: crackle.Sample) -> float:
        seen = projected_branching(sample)
        return value(sample, seen.loc[seen.y.idxmin()]) if len(seen) else math.nan
    return each(of)


def speed_before(sample: crackle.Sample, point: object) -> float:
    """Slope of a line through the facets on the way to a branching point, over Rayleigh's speed; NaN where it is at the notch."""
    y, time = sample.crack_surface.corners.values[:, :, 1].mean(axis=1), sample.crack_surface.time.values
    here = (y > point.y - FRONT_WINDOW) & (y <= point.y)
    has_run = point.y - FRONT_WINDOW > TIP * MILLIMETRE and here.sum() > 10
    slope = np.polyfit(y[here], time[here], 1)[0] if has_run else math.nan
    return 1 / slope / rayleigh(sample) if slope > 0 else math.nan


MEAN_SPEED = Quantity("mean speed / c_R, y = 10 to 27 mm", each(WAY), ".3f")
LARGEST = Quantity("largest speed / c_R", result("crack_speed_ratio"), ".2f")
ENERGY = Quantity("energy of broken tetrahedra per traced area", of_those_that_run(lambda sample: sample.summary.effective_toughness), ".0f", unit=" J/m²")
BRANCHES = (Quantity("branching points with branches of 2 mm", of_those_that_run(lambda sample: (projected_branching(sample).length >= LONG_BRANCH).sum()), ".1f"),
            Quantity("all branching points", of_those_that_run(lambda sample: len(projected_branching(sample))), ".1f", "more on finer meshes"))
FIRST = (Quantity("speed / c_R on the 2 mm before the first one", at_first_branching(speed_before), ".2f", "0.55, Katzav et al. 2007"),
         Quantity("angle between its branches", at_first_branching(lambda _, point: math.degrees(point.angle)), ".0f", "some 30°", "°"))

strips = {f"strip-{stored}": Comparison(
    f"Strip of PMMA, {stored} J/m² stored, spacings {', '.join(map(str, SPACINGS))} mm; before: release in 0.2 µs", f"strip-{stored}",
    {f"{spacing}": strip(spacing, travel) for spacing in SPACINGS}, (MEAN_SPEED, LARGEST, ENERGY, *BRANCHES, *(FIRST if stored == 704 else ())), 8,
    released_in("0.2 us")) for travel, stored in TRAVELS.items()}

graded_strip = Comparison(
    "The same, 704 J/m², spacing 0.2 mm up to y = 16 mm, 0.4 mm beyond; before: release in 0.125 µs", "strip-graded",
    {"0.2": with_keys(strip(0.2, 0.040) + '[[mesh.region]]\ny = ["0 mm", "16 mm"]\nspacing = "0.2 mm"\n',
                      {"mesh.spacing": '"0.4 mm"', "mesh.growth": "1"})},
    (Quantity("speed / c_R, y = 7 to 15 mm", each(front_speed(7, 15)), ".3f"), Quantity("y = 18 to 27 mm", each(front_speed(18, 27)), ".3f")), 8,
    released_in("0.125 us"))

slow_strip = Comparison(
    "The same, three times its toughness stored, release speed 300 m/s, spacing 0.25 mm; before: immediate release", "strip-slow",
    {"0.25": strip(0.25, 0.0452, {"fracture.release_speed": '"300 m/s"', "time.duration": '"130 us"'})},
    (Quantity(MEAN_SPEED.title, MEAN_SPEED.of, ".3f", "0.2 to 0.4, Scheibert et al. 2010"), ENERGY), 8, IMMEDIATE)


# What cracks take

RELEASE_SPEEDS = {200: (704, 1100), 400: (704, 1100), 635: (539, 704, 1100), 1000: (539, 704, 899)}  # [m/s]: stored [J/m^2]


def steady(spacing: float, speed: float, stored: float) -> str:
    return strip(spacing, round(0.040 * math.sqrt(stored / 704), 4), {"fracture.release_speed": f'"{speed} m/s"', "ensemble.samples": "3", "time.duration": '"150 us"',
                                                                      "time.after_separation": '"1 fs"'})


def dissipation(folder: Path, program: Path) -> list[Figure]:
    """Steady speeds in the strip at several release speeds, where a crack takes what is stored, and the constants of
    Gamma / G = 1 + a (v / v_r)^b / (1 - v / c_R)^c that fit them and those of the strips above, with standard errors."""
    from scipy.optimize import curve_fit  # not needed for a run
    runs = {speed: {stored: run(steady(0.35, speed, stored), folder / f"dissipation-{speed}-{stored}", program) for stored in energies}
            for speed, energies in RELEASE_SPEEDS.items()}
    others = [(1670, stored, run(text, place, program)) for stored, comparison in zip(TRAVELS.values(), strips.values()) for text, place in comparison.runs(folder)[:2]]
    others += [(300, 899, run(text, place, program)) for text, place in slow_strip.runs(folder)[:1]]
    points = []  # of each run, over its samples without branches
    for speed, stored, samples in [(speed, stored, samples) for speed, some in runs.items() for stored, samples in some.items()] + others:
        ways = [WAY(sample) for sample in samples if not len(projected_branching(sample))]
        if any(map(math.isfinite, ways)):
            points.append((np.nanmean(ways), speed / np.nanmedian([rayleigh(sample) for sample in samples]), stored / TOUGHNESS))
    v, release, ratio = np.array(points).T

    def law(at: tuple[np.ndarray, np.ndarray], scale: float, rise: float, limit: float) -> np.ndarray:
        return np.log(1 + scale * (at[0] / at[1]) ** rise / (1 - at[0]) ** limit)
    constants, covariance = curve_fit(law, (v, release), np.log(ratio), (2.26, 1.68, 1.05))
    off = np.exp(np.abs(law((v, release), *constants) - np.log(ratio))).max() - 1
    case = "Steady cracks in the strip, 0.35 mm"
    return [*(Figure(case, f"speed / c_R with a release speed of {speed} m/s, {', '.join(map(str, some))} J/m² stored",
                     "; ".join(Quantity("", each(WAY), ".2f").cell(each(WAY)(samples)) for samples in some.values()), "–") for speed, some in runs.items()),
            Figure(case, f"constants of Γ / G, standard errors; with those above {len(v)} runs without branches",
                   "; ".join(f"{value:.2f} ± {error:.2f}" for value, error in zip(constants, np.sqrt(np.diag(covariance))))
                   + f"; largest difference {100 * off:.0f} %", "2.26; 1.68; 1.05")]


# The paper's plate

def paper_plate(spacing: float) -> str:
    """With slots as sharp as the mesh can have, so that all meshes start from the same load."""
    text = (ROOT / "jobs" / "paper.toml").read_text().replace('height = "0.6 mm"', f'height = "{0.3 * spacing:g} mm"')
    return with_keys(text, {"mesh.spacing": f'"{spacing} mm"', "mesh.notch_spacing": f'"{0.3 * spacing:g} mm"', "time.integrator": '"verlet"',
                            "time.step": '"auto"', "fracture.release_time": None, "fracture.release_speed": '"781 m/s"', "fracture.impulse": None,
                            "output.frames": "0"})


def leaders_speed(ensemble: crackle.Ensemble) -> list[float]:
    """Of the leading crack between the first section and the last [m/s]; NaN where it does not cross all of them, or none leads."""
    y = [float(place.removesuffix(" mm")) * MILLIMETRE for place in tomllib.loads(ensemble.input)["sections"]["y"]]
    leaders = ensemble.samples.leading_notch[ensemble.done].to_numpy(int)
    times = ensemble.paths.arrival_time.values[ensemble.done, leaders]
    return [abs(float(np.polyfit(some, y, 1)[0])) if leader >= 0 and np.isfinite(some).all() else math.nan
            for leader, some in zip(leaders, times)]


plate = Comparison(
    "The paper's plate, spacings 1.5, 1.0, 0.7, 0.5 mm, epoxy's 781 m/s from the strip; before: release in 0.8 µs", "plate",
    {f"{spacing}": paper_plate(spacing) for spacing in (1.5, 1.0, 0.7, 0.5)},
    (Quantity("largest speed / c_R", result("crack_speed_ratio"), ".2f", "0.48, Suzuki et al. 2007"),
     Quantity("mean speed of the leading crack, y = 7 to 17.5 mm", leaders_speed, ".0f", "450 m/s where it bifurcates", " m/s"),
     Quantity("energy of broken tetrahedra per traced area", result("effective_toughness"), ".0f", unit=" J/m²"),
     Quantity("load at the onset", result("onset_force"), ".0f", "535 N for sharp cracks", " N")), 8, released_in("0.8 us"))


# A glass plate under a sudden traction: Borden et al. 2012

def branching_time(sample: crackle.Sample) -> float:
    """When the branching point with the longest branch comes [µs]."""
    points = projected_branching(sample)
    return 1e6 * points.time[points.length.idxmax()] if len(points) else math.nan


GLASS = (0.7, 0.5, 0.35)  # [mm]
glass_plate = Comparison(
    f"Glass plate under a sudden traction, spacings {', '.join(map(str, GLASS))} mm; before: release in 0.2 µs", "glass",
    {f"{spacing}": with_keys((JOBS / "glass-plate.toml").read_text(), {"mesh.spacing": f'"{spacing} mm"', "mesh.base": None}) for spacing in GLASS},
    (Quantity("it is 1 mm before the far edge after", each(lambda sample: 1e6 * arrival(sample, 99 * MILLIMETRE)), ".1f", "75 µs, Borden et al. 2012", " µs"),
     Quantity("it branches after", each(branching_time), ".0f", "33 µs", " µs"),
     Quantity("it has grown by 1 mm after", each(lambda sample: 1e6 * arrival(sample, 51 * MILLIMETRE)), ".1f", "10 µs", " µs"),
     Quantity("speed / c_R, y = 80 to 98 mm", each(front_speed(80, 98)), ".2f", "below 0.6"),
     Quantity("energy of broken tetrahedra per traced area", result("effective_toughness"), ".2f", unit=" J/m²")), 8, released_in("0.2 us"))


# Kalthoff and Winkler's impact

SLOT = np.array([50, 25.75]) * MILLIMETRE
GROWN, NEAR, FAR, STRAY = 1 * MILLIMETRE, 12 * MILLIMETRE, 40 * MILLIMETRE, 10 * MILLIMETRE


def start_and_angle(sample: crackle.Sample, within: float = NEAR) -> tuple[float, float]:
    """When the crack has grown by GROWN [µs], and the angle to the slot of the line from its tip through its facets within so much [degrees]."""
    place = sample.crack_surface.corners.values[:, :, 1:].mean(axis=1) - SLOT
    distance = np.hypot(*place.T)
    near = (distance > GROWN) & (distance < within)
    if not near.any():
        return math.nan, math.nan
    return 1e6 * float(sample.crack_surface.time.values[near].min()), math.degrees(math.atan2(*place[near].mean(axis=0)[::-1]))


def reach(sample: crackle.Sample) -> float:
    """How far from the slot's tip the crack gets [m]."""
    return float(np.hypot(*(sample.crack_surface.corners.values[:, :, 1:].mean(axis=1) - SLOT).T).max(initial=0))


def has_false_crack(sample: crackle.Sample) -> bool:
    """Whether a crack of more than STRAY started elsewhere than at the slot."""
    with sample.open() as root:
        crack = root["crack_surface/crack"][...]
    corners, is_stray = sample.crack_surface.corners.values[:, :, 1:], starts_elsewhere(sample)
    return any(np.ptp(corners[crack == number].reshape(-1, 2), axis=0).max() > STRAY for number in np.unique(crack[is_stray]))


START = Quantity("the crack has grown by 1 mm after", each(lambda sample: start_and_angle(sample)[0]), ".1f", "some 25 µs in computations", " µs")
ANGLE = Quantity("angle to the slot over its first 12 mm", each(lambda sample: start_and_angle(sample)[1]), ".0f", "70°, Kalthoff 2000", "°")
ELSEWHERE = Quantity("share with a crack from elsewhere", each(has_false_crack), ".2f", "0")
kalthoff = Comparison(
    "Kalthoff and Winkler's impact; before: release in 0.4 µs, without a strength", "kalthoff", {"2": with_keys((JOBS / "kalthoff.toml").read_text(), {"mesh.base": None})},
    (START, ANGLE, ELSEWHERE), 8, released_in("0.4 us") | {"fracture.strength": None})

# The same by projectiles. The end of an elastic one that is as stiff as the plate moves at half its speed v until its unloading wave
# arrives, after 2 L / c; a rigid one is slowed by the plate's waves, at first as exp(-c_d t / L).
BAR_WAVE, IMPACT = math.sqrt(190e9 / 8000), 33  # [m/s]


def projectile(length: int) -> dict[str, str]:
    """Keys of one that is so long [mm]."""
    time = round(2e3 * length / BAR_WAVE, 1)
    return {"tool.history": f'[["0 us", 1], ["{time} us", 1], ["{time + 0.5:.1f} us", -1], ["90 us", -1]]'}


def end_of_contact(sample: crackle.Sample) -> float:
    """When the projectile pushes last [µs]."""
    with sample.open() as root:
        push = root["history/tools/projectile/reaction"][:, 1]
        return 1e6 * float(root["history/phase_time"][:][push > 0].max())


rigid = {"tool.history": None, "tool.mass": f'"{8 * 0.4 * 2.5 * 10} g"', "tool.velocity": f'["0 m/s", "{IMPACT} m/s", "0 m/s"]', "tool.free": '["y"]'}
projectiles = Comparison(
    "The same by projectiles of 50 and 100 mm, and by a rigid one with the mass of 100 mm", "kalthoff-projectile",
    {label: with_keys((ROOT / "jobs" / "gallery" / "projectile.toml").read_text(), {"mesh.spacing": '"2 mm"', "output.frames": "0"} | keys)
     for label, keys in (("50", projectile(50)), ("100", projectile(100)), ("rigid", rigid))},
    (START, ANGLE, Quantity("angle over 40 mm", each(lambda sample: start_and_angle(sample, FAR)[1]), ".0f", "the same", "°"),
     Quantity("it gets", each(lambda sample: 1e3 * reach(sample)), ".0f", "through the plate, 79 mm", " mm"),
     Quantity("the projectile lets go after", each(end_of_contact), ".1f", "20.5, 41.0 µs (2 L / c); –", " µs"), ELSEWHERE), 8)


# Averaged stress in motion

GROWTH_IN = 10e-6  # [s]
averaged = Comparison(
    "Stress averaged over 1.5 mm in the paper's plate, 2 mm thick, 0.4 mm at the tips; before: release in 0.8 µs, impulse 1e-8 MPa² s", "averaged",
    {"0.4": with_keys(paper_plate(1.3333).replace("5 mm", "2 mm", 1), {"mesh.notch_spacing": '"0.4 mm"', "fracture.length": '"1.5 mm"'})},
    (Quantity("breaks within 10 µs of the onset", each(lambda sample: ((sample.breaks.phase_time >= 0) & (sample.breaks.phase_time < GROWTH_IN)).sum()), ".0f", "a crack that runs"),
     LARGEST, Quantity("all breaks", result("breaks"), ".0f", "–")), 4, released_in("0.8 us"))

CASES = {**strips, "strip-graded": graded_strip, "strip-slow": slow_strip, "dissipation": dissipation, "plate": plate, "glass": glass_plate,
         "kalthoff": kalthoff, "kalthoff-projectile": projectiles, "averaged": averaged}
