#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Random tools at small bodies, half of them damaged: each input runs and, from rest, its energy account closes, or it is refused by lines with
exit status 1 and nothing is written, or its sample fails for a reason that lies in the input.

More of them: tests/cli/test_tools.py --program build/bin/crackle --number 1000 [--first N]
"""
from __future__ import annotations

import argparse
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests" / "cli")]

import command_lines  # noqa: E402
import crackle  # noqa: E402

TIMEOUT = 20  # of a command [s]
# Of the work, or of what the tools bring with them. The work between two equilibria is that of the mean force, and increments may be large.
ENERGY_ERROR = {"rest": 0.05, "equilibrium": 1, "quasi-static": 1}
SIZES = {"block": (4, 6, 8), "plate": (2, 8, 8), "disk": (2, 10, 10)}  # [mm]
BODY = {"block": 'size = ["4 mm", "6 mm", "8 mm"]', "plate": 'size = ["2 mm", "8 mm", "8 mm"]', "disk": 'thickness = "2 mm"\noutline = "circle"\nradius = "5 mm"'}
INPUT = """[ensemble]
samples = 1
seed = {seed}
[specimen]
{body}
[mesh]
spacing = "2 mm"
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.3
density = "1180 kg/m^3"
[fracture]
strength = "{strength} MPa"
{contact}{supports}[time]
start = "{start}"
duration = "{duration} us"
integrator = "{integrator}"
{tools}[sections]
z = ["5 mm"]
[output]
frames = 2
"""
UNBREAKABLE = 'strength = "5000 MPa"'
# Why the sample of a sound input may fail, as a force may push a tool off the body; and that of a damaged one.
FAILURES = (r"strains of \S+ are too small for the double number format", r'tool "\S+" is \S+ mm from the body\'s nearest node',
            'set time.start = "equilibrium" to start the dynamic phase at time 0', "no equilibrium at t = ", "static equilibrium: ")
DAMAGED_FAILURES = (r'tool "\S+" overlaps the body by',)
# What a damaged line becomes: by the key, or any.
DAMAGE = {
    "shape": ['"cone"', "3", '["box"]'],
    "at": ['["0 mm", "0 mm"]', '["nan mm", "0 mm", "0 mm"]', '"2 mm"', '["1 mm", "3 mm", "4 mm"]', '["1e9 m", "0 m", "0 m"]', '["1 s", "0 s", "0 s"]'],
    "axis": ["[0, 0, 0]", "[1, 0]", "[nan, 0, 1]", "[1e-300, 0, 0]", "[1e308, 1e308, 1e308]"],
    "radius": ['"0 mm"', '"-1 mm"', '"inf mm"', '"1e-9 mm"', '"1e6 m"', "2"],
    "size": ["[]", '["1 mm", "2 mm"]', '["0 mm", "1 mm", "1 mm"]', '["1e-9 mm", "1e-9 mm", "1e-9 mm"]', '"4 mm"'],
    "rounding": ['"-1 mm"', '"1 m"', '"0 mm"'],
    "mass": ['"0 g"', '"-1 g"', '"1e-12 g"', '"1e14 kg"', '"nan g"', '"3 mm"'],
    "velocity": ['["1e5 m/s", "0 m/s", "0 m/s"]', '["inf m/s", "0 m/s", "0 m/s"]', '["0 m/s"]', '["free", "0 m/s", "0 m/s"]', '["0 m", "0 m", "1 m"]'],
    "displacement": ['["0 mm", "0 mm", "1 km"]', '["nan mm", "0 mm", "0 mm"]', '["free", "free", "1 mm"]'],
    "force": ['["1e14 N", "0 N", "0 N"]', '["0 N", "0 N", "nan N"]', '["1 N"]'],
    "rate": ['["1e17 mm/s", "0 mm/s", "0 mm/s"]', '["0 N/s", "0 N/s", "1 N/s"]', "1"],
    "history": ["[]", '[["1 us", 1]]', '[["0 us", 1], ["0 us", 2]]', '[["0 us", nan]]', '[["0 us", 1e30], ["1 us", -1e30]]'],
    "free": ["[]", '["w"]', '["x", "x"]', '["turn x"]', '["z", "turn"]', '["x", "y", "z", "turn x", "turn y", "turn z"]'],
    "angular_velocity": ['["1 rad/s", "0 rad/s"]', '["1e12 rad/s", "0 rad/s", "0 rad/s"]', '["1e6 rad/s", "1e6 rad/s", "1e6 rad/s"]', '["nan rad/s", "0 rad/s", "0 rad/s"]', '["0 rad/s", "1 Hz", "0 rad/s"]'],
    "friction": ["-1", "11", "nan", '"0.3"'],
    "name": ['""', "3", '"a/b"', '"."', '"one"']}
NEW = ['weight = "3 g"', 'mass = "1 g"', 'velocity = ["0 m/s", "0 m/s", "1 m/s"]', 'displacement = ["0 mm", "0 mm", "-0.01 mm"]', 'force = ["0 N", "0 N", "-1 N"]',
       'radius = "1 mm"', "axis = [0, 0, 1]", 'size = ["1 mm"]', 'rounding = "0.1 mm"', 'free = ["z"]', 'free = ["x", "turn x"]', 'angular_velocity = ["0 rpm", "0 rpm", "3000 rpm"]', 'rate = ["0 mm/s", "0 mm/s", "1 mm/s"]', 'history = [["0 s", 0], ["1 s", 1]]']


def lengths(values: list[float], unit: str = "mm") -> str:
    return "[" + ", ".join(f'"{value:.6g} {unit}"' for value in values) + "]"


def tool(draw: random.Random, body: str, start: str, face: int, side: int, name: str) -> list[str]:
    """Lines of one that is sound, at a side of the body along an axis; it comes nearer, or stays."""
    size = SIZES[body]
    inward = [0.0, 0.0, 0.0]
    inward[face] = -side
    place = [0.5 * length for length in size]
    place[face] += 0.5 * side * size[face]
    shape = draw.choice(("plane", "cylinder", "sphere", "box"))
    half, lines = 0.0, [f'name = "{name}"', f'shape = "{shape}"']
    if shape == "plane":
        lines.append(f"axis = {inward}")
    elif shape == "box":
        edges = [draw.choice((0.5, 3, 20)) * draw.uniform(0.5, 1) for _ in range(3)]
        half = edges[face] / 2
        lines.append(f"size = {lengths(edges)}")
        if draw.random() < 0.5:
            lines.append(f'rounding = "{draw.uniform(0.01, 0.5) * min(edges):.4g} mm"')
    else:
        half = draw.choice((0.3, 2, 30)) * draw.uniform(0.5, 1)
        lines.append(f'radius = "{half:.6g} mm"')
        if shape == "cylinder":
            axis = [0.0, 0.0, 0.0]
            axis[draw.choice([a for a in range(3) if a != face])] = draw.choice((1, -1, 7))
            lines.append(f"axis = {axis}")
            if draw.random() < 0.5:
                lines.append(f'size = ["{draw.uniform(1, 20):.4g} mm"]')
    if shape != "plane" and body != "disk":
        place = [one + (0 if a == face else draw.uniform(-0.3, 0.3) * size[a]) for a, one in enumerate(place)]
    place[face] += side * (half * 1.000001 + draw.choice((0, 0, 0.01, 0.2)))  # the gap [mm]
    lines.append(f"at = {lengths(place)}")
    if draw.random() < 0.5:
        lines.append(f"friction = {draw.choice((0, 0.1, 0.5, 2))}")
    return lines + motion(draw, start, inward, shape in ("sphere", "box") or any(line.startswith("size") for line in lines))


def motion(draw: random.Random, start: str, inward: list[float], can_turn: bool) -> list[str]:
    def along(value: float, unit: str) -> str:
        return lengths([value * one for one in inward], unit)

    kind = draw.choice(("none", "mass", "mass", "velocity", "history", "displacement", "force")) if start == "rest" else draw.choice(("none", "displacement", "steps", "force", "velocity"))
    if kind == "mass":
        lines = [f'mass = "{draw.choice((1e-3, 0.1, 20)):g} g"', f'velocity = {along(draw.choice((0.1, 5, 50)), "m/s")}']
        if draw.random() < 0.3:
            lines.append(f'force = {along(draw.choice((1, 10)), "N")}')
        turns = can_turn and draw.random() < 0.6
        if turns or draw.random() < 0.5:
            along_axes = ["xyz"[a] for a in range(3) if inward[a] or draw.random() < 0.5]
            about = [axis for axis in "xyz" if draw.random() < 0.7] if turns else []
            spins = lengths([draw.choice((0, 1e2, 1e4)) * (axis in about) for axis in "xyz"], "rad/s")
            lines.append("free = [" + ", ".join(f'"{way}"' for way in along_axes + [f"turn {axis}" for axis in about]) + "]")
            if about and draw.random() < 0.5:
                lines.append(f"angular_velocity = {spins}")
        return lines
    if kind == "velocity":
        return [f'velocity = {along(draw.choice((0.1, 5, 20)) if start == "rest" else 1e-3, "m/s")}']
    if kind == "history":
        return [f'velocity = {along(draw.choice((1, 10)), "m/s")}', 'history = [["0 us", 0], ["2 us", 1], ["4 us", 1], ["5 us", -1], ["20 us", -1]]']
    if kind == "steps":
        return [f'displacement = {along(draw.choice((1e-3, 0.02)), "mm")}', 'history = [["0 s", 0], ["0.5 s", 0.5], ["1 s", 1]]']
    if kind == "displacement":
        return [f'displacement = {along(0, "mm")}', f'rate = {along(20e3 if start == "rest" else draw.choice((1e-3, 0.1)), "mm/s")}']
    if kind == "force" and start != "rest":
        return [f'force = {along(draw.choice((0.1, 1)), "N")}', f'rate = {along(draw.choice((1, 100)), "N/s")}']
    if kind == "force":
        return ['mass = "0.5 g"', f'force = {along(draw.choice((1, 200)), "N")}']
    return []


def damaged(draw: random.Random, lines: list[str]) -> list[str]:
    """With a line changed, dropped, doubled or added."""
    lines, way = list(lines), draw.choice(("change", "change", "change", "drop", "add"))
    at = draw.randrange(len(lines))
    key = lines[at].split(" = ")[0]
    if way == "change":
        lines[at] = f"{key} = {draw.choice(DAMAGE[key])}"
    elif way == "drop":
        lines.pop(at)
    else:
        new = draw.choice(NEW)
        lines = [line for line in lines if line.split(" = ")[0] != new.split(" = ")[0]] + [new]
    return lines


def make(number: int) -> tuple[str, bool]:
    """The input with this number, and whether it is sound."""
    draw = random.Random(number)
    body, start = draw.choice([*BODY]), draw.choice(("rest", "rest", "quasi-static", "equilibrium"))
    face, side, sound = draw.choice((1, 2) if body == "disk" else (0, 1, 2)), draw.choice((-1, 1)), number % 2 == 0
    tools = [tool(draw, body, start, face, side, "one")]
    held = start != "rest" or draw.random() < 0.5
    if draw.random() < 0.3 and body != "disk":
        tools.append(tool(draw, body, start, face, -side, "two"))
        held = start != "rest"
    if not sound:
        which = draw.randrange(len(tools))
        tools[which] = damaged(draw, tools[which])
    other = (face + 1) % 3
    on = "edge-0" if body == "disk" else f'{"xyz"[other]}-min'
    supports = f'[[boundary]]\non = "{on}"\nfix = ["x", "y", "z"]\n' + ('region = { z = ["0 mm", "3 mm"] }\n' if body == "disk" else "") if held else ""
    contact = f"[contact]\nfriction = {draw.choice((0, 0.4))}\n" if draw.random() < 0.5 else ""
    return INPUT.format(seed=number, body=BODY[body], strength=draw.choice((3, 35, 5000)), contact=contact, supports=supports, start=start,
                        duration=draw.choice((2, 10)), integrator=draw.choice(("verlet", "verlet", "bilateral4")),
                        tools="".join("[[tool]]\n" + "\n".join(one) + "\n" for one in tools)), sound


def energy_at_start(tool: dict, history: dict) -> float:
    """Of a tool that moves by forces, roughly [J]."""
    speed = np.linalg.norm(history["velocity"][0])
    if "angular_velocity" in history:
        speed = np.hypot(speed, np.linalg.norm(history["angular_velocity"][0]) * 0.6 * max(tool["radius"], 0.5 * np.linalg.norm(tool.get("size", 0))))
    return 0.5 * tool["mass"] * speed ** 2


def faults_of_run(text: str, folder: Path) -> list[str]:
    """Of an input that was accepted."""
    sample, faults = crackle.open(folder / "out")[0], []
    with sample.open() as root:
        # A light tool hits and leaves between two outputs: its energy is the scale, not the work that it has done in the end.
        thrown = sum(energy_at_start(tool.attrs, root["history/tools"][name]) for name, tool in root["tools"].items())
        if "energy" in root:
            rows = {name: values[...] for name, values in root["energy"].items()}
            imbalance = rows["external"] - rows["kinetic"] - rows["strain"] - rows["released"] - rows["dissipated"]
            if UNBREAKABLE in text and 'start = "rest"' not in text:
                imbalance = np.zeros(1)  # loads grow beyond all strains, in steps as large as they like
            # A tool that meets the body in the very last step has done the work of half a kick.
            error = np.abs(imbalance[:-1] if len(imbalance) > 2 else imbalance).max() / max(np.abs(rows["external"]).max(), thrown, 1e-12)
            faults = [f"energy error {error:.2g}"] * (not error <= ENERGY_ERROR[re.search('start = "(.*)"', text)[1]])
        found = {f"{name}/{what}": values[...] for name, tool in root["history/tools"].items() for what, values in tool.items()}
        found |= {f"energy/{name}": values[...] for name, values in root["energy"].items()} if "energy" in root else {}
        found["frames"] = root["frames/displacement"][...]
    return faults + [f"{name} is not finite" for name, values in found.items() if not np.isfinite(values).all()]


def faults_of_refusal(result: subprocess.CompletedProcess, folder: Path) -> list[str]:
    lines = result.stderr.splitlines()
    faults = [] if lines and all(re.match(r"tools\.toml:\d+: tool", line) for line in lines) else ["a line does not name file, line and tool"]
    faults += [f"{len(line)} characters in a line" for line in lines if len(line) > 500]
    return faults + ([f"files written: {left}"] if (left := sorted(path.name for path in folder.iterdir() if path.name != "tools.toml")) else [])


def try_one(program: Path, number: int) -> tuple[int, list[str], str]:
    """Exit status of `run`, what is wrong, and what it says."""
    text, sound = make(number)
    with tempfile.TemporaryDirectory(prefix="crackle-tools-") as name:
        folder = Path(name)
        (folder / "tools.toml").write_text(text)
        try:
            result = command_lines.crackle(program, "run", "tools.toml", "-o", "out", cwd=folder, errors="replace", timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            return -1, [f"takes more than {TIMEOUT} s"], ""
        if result.returncode == 0:
            return 0, faults_of_run(text, folder), result.stderr
        if result.returncode == 1:
            return 1, faults_of_refusal(result, folder) + ["is sound, but refused"] * sound, result.stderr
        known = FAILURES + DAMAGED_FAILURES * (not sound)
        is_known = result.returncode == 2 and any(re.search(f"failed: sample 0: .*{reason}", result.stdout + result.stderr) for reason in known)
        return result.returncode, [] if is_known else [f"exit status {result.returncode}"], result.stdout[-1000:] + result.stderr[-1000:]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, type=Path)
    parser.add_argument("--number", type=int, default=40, help="of inputs (default: 40)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (default: 0)")
    parser.add_argument("--show", type=int, metavar="N", help="print input N and end")
    options = parser.parse_args()
    if options.show is not None:
        print(make(options.show)[0], end="")
        return 0
    ended, n_faulty = {}, 0
    for number in range(options.first, options.first + options.number):
        status, faults, said = try_one(options.program, number)
        ended[status] = ended.get(status, 0) + 1
        n_faulty += bool(faults)
        for fault in faults:
            print(f"input {number}: {fault}\n{said}", flush=True)
    print(f"{options.number} inputs, by exit status: {dict(sorted(ended.items()))}; {n_faulty} with faults")
    return 1 if n_faulty else 0


if __name__ == "__main__":
    sys.exit(main())
