# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies in space: strength of bars with random flaws, a cube from Gmsh beside the built-in box, a sphere on a block, a disk
between platens, a struck plate, fragments of a bar."""
from __future__ import annotations

import math
import subprocess
from pathlib import Path

import crackle
import numpy as np

from crackle_runs import ROOT, RunError, run, with_keys
from figures import MILLIMETRE, Figure, mean
from problems import disk_reference

# Bars with flaws across them, whose radii have a tail of a power, as the flaws of a ceramic do.
BARS, EXPONENT = 200, 4  # Weibull's modulus is twice the exponent
SMALLEST, LARGEST = 1.5, 3.5  # radii [mm]
WIDTH, LENGTH, MARGIN = 20, 50, 5  # of the bar, and what flaws' middles keep from its faces [mm]
FLAWS = 4  # in each bar
FLAW_SPACINGS = (1.0,)  # [mm]
MODULUS, POISSON, TOUGHNESS = 32e9, 0.2, 10  # [Pa], -, [J/m^2]
CERAMIC = """[material]
youngs_modulus = "32 GPa"
poisson_ratio = 0.2
density = "2450 kg/m^3"
[fracture]
toughness = "10 J/m^2"
"""
BAR = """[ensemble]
samples = {samples}
seed = 5
[specimen]
size = ["{width} mm", "{width} mm", "{length} mm"]
[mesh]
spacing = "{spacing} mm"
{ceramic}[[random.flaws]]
number = {flaws}
size = {{ distribution = "empirical", values = [{radii}] }}
direction = [0, 0, 1]
region = {{ x = [{across}], y = [{across}], z = [{along}] }}
[[boundary]]
on = "x-min"
fix = ["x"]
[[boundary]]
on = "y-min"
fix = ["y"]
[[boundary]]
on = "z-min"
fix = ["z"]
[[boundary]]
on = "z-max"
traction = ["0 MPa", "0 MPa", "1 MPa"]
rate = ["0 MPa/s", "0 MPa/s", "1 MPa/s"]
[time]
duration = "60 us"
after_separation = "1 fs"
integrator = "verlet"
[sections]
y = ["10 mm"]
[output]
frames = 0
"""


def radii(share: np.ndarray) -> np.ndarray:
    """Radius that this share of the flaws exceeds [m]: Pareto's law, truncated."""
    rest = (SMALLEST / LARGEST) ** EXPONENT
    return SMALLEST * MILLIMETRE * (rest + share * (1 - rest)) ** (-1 / EXPONENT)


def griffith(radius: np.ndarray) -> np.ndarray:
    """Stress at which a disk across the load grows (Sneddon 1946) [Pa]."""
    return math.sqrt(TOUGHNESS * MODULUS / (1 - POISSON ** 2)) / 2 * np.sqrt(np.pi / radius)


def flawed_bar(spacing: float) -> str:
    values = radii(np.linspace(1, 0, 61)) / MILLIMETRE
    return BAR.format(ceramic=CERAMIC, samples=BARS, width=WIDTH, length=LENGTH, spacing=spacing, flaws=FLAWS,
                      radii=", ".join(f'"{value:.6g} mm"' for value in values),
                      across=f'"{MARGIN} mm", "{WIDTH - MARGIN} mm"', along=f'"{MARGIN} mm", "{LENGTH - MARGIN} mm"')


def strengths(share: np.ndarray) -> np.ndarray:
    """Stress at which this share of the bars has broken, by their largest flaw alone [Pa]."""
    return griffith(radii(1 - (1 - share) ** (1 / FLAWS)))


def largest_flaw(sample: crackle.Sample) -> float:
    with sample.open() as file:
        return file["pre_cracks/flaws/radius"][:].max()


def flawed_bars(folder: Path, program: Path) -> list[Figure]:
    """Weibull's modulus and scale of the loads that bars hold, beside those of their largest flaws' distribution."""
    from scipy.stats import weibull_min  # not needed for a run
    expected, _, scale = weibull_min.fit(strengths((np.arange(20000) + 0.5) / 20000), floc=0)
    moduli, scales, each = [], [], []
    for spacing in FLAW_SPACINGS:
        bars = run(flawed_bar(spacing), folder / f"flawed-bars-{spacing}", program)
        held = bars.samples.peak_load[bars.done].to_numpy() / (WIDTH * MILLIMETRE) ** 2
        modulus, _, middle = weibull_min.fit(held, floc=0)
        error = 1.96 / math.sqrt(len(held))  # of the estimates: 0.78 of the modulus, 1.05 / modulus of the scale
        moduli.append(f"{modulus:.1f} ± {0.78 * error * modulus:.1f}")
        scales.append(f"{middle / scale:.3f} ± {1.05 * error / modulus * middle / scale:.3f}")
        largest = np.array([griffith(largest_flaw(bars[number])) for number in bars.done])
        each.append(mean(list(held / largest), ".2f"))
    case = f"{BARS} bars of four flaws each, {', '.join(map(str, FLAW_SPACINGS))} mm; 95 % intervals"
    return [Figure(case, "modulus", "; ".join(moduli), f"{expected:.1f}"),
            Figure(case, "scale over that of the flaws", "; ".join(scales), "1"),
            Figure(case, "strength of each over that of its largest flaw", "; ".join(each), "1, or less where flaws are near each other")]


# A cube whose surface is a mesh of Gmsh, beside the built-in box.
CUBES = 48
CUBE_GEO = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 12, 12, 12};
Mesh.MeshSizeMax = 5;
"""
CUBE = """[ensemble]
samples = {samples}
seed = {seed}
[specimen]
{body}
[[specimen.crack]]
polygon = [{corners}]
[mesh]
spacing = "0.8 mm"
{ceramic}[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
displacement = ["0 mm", "0 mm", "0 mm"]
rate = ["0 mm/s", "0 mm/s", "0.001 mm/s"]
[time]
duration = "40 us"
after_separation = "1 fs"
integrator = "verlet"
[[sections.plane]]
point = ["6 mm", "6 mm", "6 mm"]
normal = [1, 0, 0]
[output]
frames = 0
"""


def cube(body: str, seed: int) -> str:
    corners = ", ".join(f'["{x} mm", "{y} mm", "6 mm"]' for x, y in ((0, 0), (12, 0), (12, 4), (0, 4)))
    return CUBE.format(ceramic=CERAMIC, samples=CUBES, seed=seed, body=body, corners=corners)


def cubes(folder: Path, program: Path) -> list[Figure]:
    """All results of samples that do not share a seed, each compared between the two bodies."""
    mesh = folder / "cube.msh"
    if not mesh.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "cube.geo").write_text(CUBE_GEO)
        try:
            subprocess.run(["gmsh", "-3", "cube.geo", "-o", mesh.name], cwd=folder, check=True, capture_output=True)
        except (OSError, subprocess.CalledProcessError) as error:
            raise RunError(f"Gmsh makes the cube: {error}; `tools/setup full` installs it") from None
    box = run(cube('size = ["12 mm", "12 mm", "12 mm"]', 1), folder / "cube-box", program)
    solid = run(cube('solid = "cube.msh"\nunit = "mm"', 2), folder / "cube-gmsh", program, beside=[mesh])
    compared = crackle.compare(box, solid, program=program)
    p = compared.results.p_adjusted.dropna()
    means = "; ".join(f"{values.mean():.1f} ± {values.std():.1f} N" for one in (box, solid) for values in [one.samples.peak_load[one.done]])
    return [Figure(f"Cube with an edge crack, {CUBES} samples each; built-in, from Gmsh's mesh", "load that it holds", means, "equal"),
            Figure("", f"smallest p of {len(p)} results, adjusted", f"{p.min():.2g}", "above 0.05")]


# A rigid sphere on a block, of which a quarter is meshed: Hertz's contact, pressed and dropped.
GLASS = 70e9 / (1 - 0.22 ** 2)  # plane strain modulus [Pa]
RADIUS, DEPTH, SPHERE, SPEED = 10 * MILLIMETRE, 0.03 * MILLIMETRE, 33e-3, 0.2  # [m], [m], mass of the whole [kg], [m/s]
BLOCK = """[ensemble]
samples = 1
[specimen]
size = ["24 mm", "24 mm", "24 mm"]
[mesh]
spacing = "3 mm"
growth = 0.12
[[mesh.region]]
x = ["0 mm", "1.2 mm"]
y = ["0 mm", "1.2 mm"]
z = ["22.8 mm", "24 mm"]
spacing = "{spacing} mm"
[material]
youngs_modulus = "70 GPa"
poisson_ratio = 0.22
density = "2500 kg/m^3"
[fracture]
strength = "100 GPa"
[[boundary]]
on = "x-min"
fix = ["x"]
[[boundary]]
on = "y-min"
fix = ["y"]
[[boundary]]
on = "z-min"
fix = ["z"]
[[tool]]
name = "sphere"
shape = "sphere"
at = ["0 mm", "0 mm", "34 mm"]
radius = "10 mm"
{tool}
[time]
{time}
[sections]
y = ["12 mm"]
[output]
frames = 0
"""


def sphere_history(text: str, folder: Path, program: Path) -> dict[str, np.ndarray]:
    """Of the sphere along z, the reaction that of the whole one; time [SI]."""
    with run(text, folder, program)[0].open() as file:
        sphere = file["history/tools/sphere"]
        found = {name: sphere[name][:, 2] for name in ("displacement", "velocity", "reaction")}
        return found | {"reaction": -4 * found["reaction"], "time": file["history/phase_time"][:]}


def pressed_over_hertz(spacing: float, folder: Path, program: Path) -> np.ndarray:
    """Force over Hertz's at the same approach, at four approaches."""
    history = ", ".join(f'["{share} s", {share}]' for share in (0, 0.25, 0.5, 0.75, 1))
    tool = f'displacement = ["0 mm", "0 mm", "-{DEPTH / MILLIMETRE} mm"]\nhistory = [{history}]'
    of = sphere_history(BLOCK.format(spacing=spacing, tool=tool, time='duration = "1 us"'), folder / f"hertz-{spacing}", program)
    return of["reaction"][1:] / (4 / 3 * GLASS * math.sqrt(RADIUS) * np.abs(of["displacement"][1:]) ** 1.5)


def hertz(folder: Path, program: Path) -> list[Figure]:
    spacings = (0.16, 0.12, 0.08)
    found = [", ".join(f"{ratio:.3f}" for ratio in pressed_over_hertz(spacing, folder, program)) for spacing in spacings]
    return [Figure("Sphere of 10 mm pressed into glass, contact radii of 0.27 to 0.55 mm",
                   f"force over Hertz's at the same approach, spacings {', '.join(map(str, spacings))} mm", "; ".join(found), "1")]


def bounce(folder: Path, program: Path) -> list[Figure]:
    tool = f'mass = "{SPHERE / 4 * 1e3} g"\nvelocity = ["0 m/s", "0 m/s", "-{SPEED} m/s"]\nfree = ["z"]'
    of = sphere_history(BLOCK.format(spacing=0.15, tool=tool, time='start = "rest"\nduration = "140 us"\nintegrator = "verlet"'), folder / "bounce", program)
    touching = of["time"][of["reaction"] > 0]
    exact = 2.87 * (SPHERE ** 2 / (RADIUS * GLASS ** 2 * SPEED)) ** 0.2
    largest = 4 / 3 * GLASS * math.sqrt(RADIUS) * (15 * SPHERE * SPEED ** 2 / (16 * math.sqrt(RADIUS) * GLASS)) ** 0.6
    return [Figure("The same dropped at 0.2 m/s, spacing 0.15 mm", "coefficient of restitution", f"{of['velocity'][-1] / SPEED:.4f}", "1"),
            Figure("", "time of contact", f"{1e6 * np.ptp(touching):.1f} µs", f"{1e6 * exact:.1f} µs"),
            Figure("", "largest force", f"{of['reaction'].max():.1f} N", f"{largest:.1f} N")]


# Where the sphere cracks the glass: its tension is largest at the rim of the contact, in a thin layer.
RINGS, RING_SPACINGS, RING_STRENGTH, NEXT = 4, (0.16, 0.12, 0.08), 200e6, 20  # samples, [mm], [Pa], breaks


def ring_start(sample: crackle.Sample) -> tuple[float, float, float]:
    """Radius of the first break, and mean of the first `NEXT`, over that of the contact; Hertz's largest tension at that load over the strength."""
    with sample.open() as file:
        onset = int(np.flatnonzero(file["history/phase"][:] > 0)[0])
        force = -4 * file["history/tools/sphere/reaction"][onset, 2]
        corners = file["mesh/nodes"][:][file["mesh/tetrahedra"][:][file["breaks/tetrahedron"][:NEXT]]]
    contact = (3 * force * RADIUS / (4 * GLASS)) ** (1 / 3)
    away = np.hypot(*corners.mean(axis=1)[:, :2].T) / contact
    return away[0], away.mean(), (1 - 2 * 0.22) * force / (2 * math.pi * contact ** 2) / RING_STRENGTH


def ring_crack(folder: Path, program: Path) -> list[Figure]:
    steps = ", ".join(f'["{k / 10} s", {k / 10}]' for k in range(11))
    tool = f'displacement = ["0 mm", "0 mm", "-0.1 mm"]\nhistory = [{steps}]'
    found = []
    for spacing in RING_SPACINGS:
        text = with_keys(BLOCK.format(spacing=spacing, tool=tool, time='duration = "0.2 us"'),
                         {"ensemble.samples": str(RINGS), "fracture.strength": f'"{RING_STRENGTH / 1e6} MPa"', "time.after_separation": '"1 fs"'})
        found.append([mean(one, ".2f") for one in zip(*map(ring_start, run(text, folder / f"ring-crack-{spacing}", program)))])
    first, following, tension = ("; ".join(one) for one in zip(*found))
    case = f"The same sphere until the glass breaks, strength alone, spacings {', '.join(map(str, RING_SPACINGS))} mm, {RINGS} samples each"
    return [Figure(case, "radius of the first break over that of the contact", first, "1, the largest tension; 1.0 to 1.4 in tests"),
            Figure("", f"mean of the first {NEXT} breaks, likewise", following, "the same"),
            Figure("", "Hertz's largest tension at that load over the strength", tension, "1 on fine meshes")]


# A disk between flat platens in plane strain: its tension in the middle (Hondros 1959), and the arc on which Hertz's contact loads it.
SANDSTONE, TENSION, DISK, SLICE = 15e9 / (1 - 0.2 ** 2), 10e6, 25 * MILLIMETRE, 2 * MILLIMETRE  # [Pa], strength [Pa], radius, thickness [m]
DISKS, ARC_SPACINGS = 4, (0.5, 0.3)  # samples, [mm] at the platens
PRESSED = """[ensemble]
samples = {samples}
seed = 3
[specimen]
thickness = "2 mm"
outline = "circle"
radius = "25 mm"
[mesh]
spacing = "1.5 mm"
growth = 0.2
[[mesh.region]]
y = ["22.5 mm", "27.5 mm"]
z = ["0 mm", "1 mm"]
spacing = "{spacing} mm"
[[mesh.region]]
y = ["22.5 mm", "27.5 mm"]
z = ["49 mm", "50 mm"]
spacing = "{spacing} mm"
[material]
youngs_modulus = "15 GPa"
poisson_ratio = 0.2
density = "2300 kg/m^3"
[fracture]
strength = "10 MPa"
toughness = "20 J/m^2"
[[boundary]]
on = "x-min"
fix = ["x"]
[[boundary]]
on = "x-max"
fix = ["x"]
[[tool]]
name = "lower"
shape = "plane"
at = ["0 mm", "0 mm", "0 mm"]
axis = [0, 0, 1]
friction = 0.3
[[tool]]
name = "upper"
shape = "plane"
at = ["0 mm", "0 mm", "50 mm"]
axis = [0, 0, -1]
friction = 0.3
displacement = ["0 mm", "0 mm", "0 mm"]
rate = ["0 mm/s", "0 mm/s", "-0.01 mm/s"]
[time]
duration = "1 us"
integrator = "verlet"
[sections]
z = ["15 mm", "25 mm", "35 mm"]
[output]
frames = 2
{probes}"""
MIDDLE = [(25 + y, 25 + z) for y, z in ((0, 0), (-1, 0), (1, 0), (0, -2), (0, 2))]  # y, z where the stress is measured [mm]


def pressed_disk(sample: crackle.Sample) -> tuple[float, float, np.ndarray]:
    """At the onset: the load [N], the tension in the middle over 2 P / (π D t), and half the arc that the lower platen touches: up to
    the outermost node that it does, and to the next [m]."""
    with sample.open() as file:
        onset = int(np.flatnonzero(file["history/phase"][:] > 0)[0])
        load = -float(file["history/tools/upper/reaction"][onset, 2])
        tension = np.mean([probe["stress"][onset, 1] for probe in file["history/probes"].values()])
        sunk = file["history/tools/lower/displacement"][onset, 2]
        nodes, moved = file["mesh/nodes"][:], file["frames/displacement"][0]
    away = np.abs(nodes[:, 1] - DISK)
    is_below = nodes[:, 2] < DISK - np.sqrt(np.maximum(DISK ** 2 - away ** 2, 0)) + 1e-3 * MILLIMETRE
    touches = is_below & (nodes[:, 2] + moved[:, 2] < sunk)
    return load, tension * math.pi * DISK * SLICE / load, np.array([away[touches].max(), away[is_below & ~touches].min()])


def platens(folder: Path, program: Path) -> list[Figure]:
    probes = "".join(f'[[output.probe]]\nname = "{k}"\nat = ["1 mm", "{y} mm", "{z} mm"]\n' for k, (y, z) in enumerate(MIDDLE))
    loads, tensions, arcs = [], [], []
    for spacing in ARC_SPACINGS:
        found = [pressed_disk(sample) for sample in run(PRESSED.format(samples=DISKS, spacing=spacing, probes=probes), folder / f"platens-{spacing}", program)]
        load, tension, arc = zip(*found)
        loads.append(mean([one / (math.pi * TENSION * DISK * SLICE) for one in load], ".3f"))
        tensions.append(mean(tension, ".3f"))
        arcs.append("{:.2f} to {:.2f} mm".format(*np.mean(arc, axis=0) / MILLIMETRE))
    half = math.sqrt(4 * np.mean(load) * DISK / (math.pi * SANDSTONE * SLICE))
    case = f"Disk of 50 mm pressed between flat platens, spacings {', '.join(map(str, ARC_SPACINGS))} mm at them, {DISKS} samples each"
    return [Figure(case, "load at the first break over strength × π D t / 2", "; ".join(loads), f"{disk_reference(half / DISK):.3f}, Hondros 1959"),
            Figure(case, "tension in the middle over 2 P / (π D t)", "; ".join(tensions), f"{1 / disk_reference(half / DISK):.3f}"),
            Figure(case, "half the arc of contact, from the last node that touches to the next", "; ".join(arcs), f"{half / MILLIMETRE:.2f} mm, Hertz")]


# Radial cracks of a struck plate, whose number doubles with four times the speed (Vandenberghe, Vermorel and Villermaux 2013).
STRUCK, SPEEDS, PLATE_SPACINGS = 8, (19.4, 38.9, 77.8), (0.4,)  # samples, [m/s], [mm]
RING, APART = (4.5 * MILLIMETRE, 6 * MILLIMETRE), math.radians(12)  # where cracks are counted; gap between two


def radial_cracks(sample: crackle.Sample) -> int:
    """Directions in which the plate has cracked through a ring, counted as one when close to each other."""
    places = sample.crack_surface.corners.values.mean(axis=1)[:, 1:] - 20 * MILLIMETRE
    radius, angle = np.hypot(*places.T), np.arctan2(*places.T)
    rings = [np.sort(angle[np.abs(radius - middle) < 0.4 * MILLIMETRE]) for middle in RING]
    groups = [np.split(one, np.flatnonzero(np.diff(one) > APART) + 1) for one in rings if len(one)]
    counts = [len(one) - (len(one) > 1 and one[0][0] + 2 * math.pi - one[-1][-1] <= APART) for one in groups]
    return min(counts) if len(counts) == len(RING) else 0


def stars(folder: Path, program: Path) -> list[Figure]:
    text, found = (ROOT / "jobs" / "gallery" / "star.toml").read_text(), []
    for spacing in PLATE_SPACINGS:
        numbers = []
        for speed in SPEEDS:
            keys = {"ensemble.samples": str(STRUCK), "tool.velocity": f'["-{speed} m/s", "0 m/s", "0 m/s"]', "mesh.region.spacing": f'"{spacing} mm"'}
            numbers.append(mean([radial_cracks(sample) for sample in run(with_keys(text, keys), folder / f"star-{spacing}-{speed}", program)], ".1f"))
        found.append(", ".join(numbers))
    case = f"PMMA, 1 mm, struck by a pellet of 4 mm at {', '.join(map(str, SPEEDS))} m/s, {STRUCK} samples each"
    return [Figure(case, f"radial cracks, spacings {', '.join(map(str, PLATE_SPACINGS))} mm", "; ".join(found), "4, –, 8; doubles with four times the speed")]


# Fragments of a bar that is drawn out at a uniform rate, as a ring that expands; lengths and rates over those of the material.
DRAWN, PIECES, SPREADS = 8, 20, (0.003, 0.02, 0.1)  # samples, fragments that are expected, coefficients of variation
RATES = {0.1: (0.16, 0.08), 1: (0.08, 0.04), 10: (0.04, 0.02)}  # spacings of each
DRAWN_MODULUS, DRAWN_DENSITY, DRAWN_STRENGTH, DRAWN_TOUGHNESS = 275e9, 2750, 300e6, 100  # [Pa], [kg/m^3], [Pa], [J/m^2]
DRAWN_LENGTH = DRAWN_MODULUS * DRAWN_TOUGHNESS / DRAWN_STRENGTH ** 2  # [m]
DRAWN_WAVE = math.sqrt(DRAWN_MODULUS / DRAWN_DENSITY)  # [m/s]
DRAWN_RATE = DRAWN_WAVE * DRAWN_STRENGTH / (DRAWN_MODULUS * DRAWN_LENGTH)  # [1/s]
DRAWN_BAR = """[ensemble]
samples = {samples}
seed = 1
[specimen]
size = ["{width} m", "{width} m", "{length} m"]
[mesh]
spacing = "{spacing} m"
[material]
youngs_modulus = "275 GPa"
poisson_ratio = 0.2
density = "2750 kg/m^3"
[fracture]
strength = "300 MPa"
toughness = "100 J/m^2"
release = "softening"
[fracture.variation]
of = "strength"
distribution = "lognormal"
coefficient_of_variation = {spread}
correlation_length = "{correlation} m"
[[load]]
velocity_gradient = [["0 1/s", "0 1/s", "0 1/s"], ["0 1/s", "0 1/s", "0 1/s"], ["0 1/s", "0 1/s", "{rate} 1/s"]]
center = ["0 m", "0 m", "{middle} m"]
[[boundary]]
on = "z-min"
velocity = ["free", "free", "-{speed} m/s"]
[[boundary]]
on = "z-max"
velocity = ["free", "free", "{speed} m/s"]
[time]
start = "rest"
duration = "{duration} s"
integrator = "verlet"
[sections]
y = ["{across} m"]
[output]
frames = 0
"""


def zhou(rate: float) -> float:
    """Mean length of fragments (Zhou, Molinari and Ramesh 2006)."""
    return 4.5 / (1 + 0.77 * rate ** 0.25 + 5.4 * rate ** 0.75)


def drawn_bar(rate: float, spread: float, spacing: float) -> str:
    length = PIECES * zhou(rate)
    lengths = {"width": 2 * spacing, "across": spacing, "length": length, "middle": length / 2, "spacing": spacing, "correlation": 0.1}
    return DRAWN_BAR.format(samples=DRAWN, spread=spread, rate=rate * DRAWN_RATE, speed=rate * DRAWN_RATE * length * DRAWN_LENGTH / 2,
                            duration=(1.3 / rate + 40 * zhou(rate)) * DRAWN_LENGTH / DRAWN_WAVE,
                            **{name: value * DRAWN_LENGTH for name, value in lengths.items()})


def drawn_bars(folder: Path, program: Path) -> list[Figure]:
    case = (f"Bar drawn out at {', '.join(map(str, RATES))} times c σ³ / (E² Γ), strength varied by {', '.join(f'{100 * one:g}' for one in SPREADS)} %, "
            f"{DRAWN} samples each")
    figures = []
    for rate, spacings in RATES.items():
        found = []
        for spread in SPREADS:
            runs = [run(drawn_bar(rate, spread, spacing), folder / f"drawn-bars-{rate}-{spread}-{spacing}", program) for spacing in spacings]
            # The ends are planes of symmetry.
            found.append(", ".join(mean([PIECES * zhou(rate) / (len(bar.fragments) - 1) for bar in bars], ".2f") for bars in runs))
        figures.append(Figure("" if figures else case, f"mean length of fragments over E Γ / σ² at {rate}, spacings {', '.join(map(str, spacings))} of it",
                              "; ".join(found), f"{zhou(rate):.2f}, Zhou, Molinari and Ramesh 2006; {24 ** (1 / 3) * rate ** (-2 / 3):.2f}, Grady 1982"))
    return figures


CASES = {"flawed-bars": flawed_bars, "cubes": cubes, "hertz": hertz, "bounce": bounce, "ring-crack": ring_crack, "platens": platens, "stars": stars, "drawn-bars": drawn_bars}
