# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs of small plates whose samples take a tenth of a second each, and their ensembles."""
from __future__ import annotations

from pathlib import Path

import command_lines

NOTCH = """[[specimen.notch]]
face = "y-min"
at = "15 mm"
depth = "3 mm"
height = "1 mm"
"""
INPUT = """[ensemble]
samples = {samples}
seed = 5
{ensemble}[specimen]
size = ["2 mm", "12 mm", "30 mm"]
{notch}[mesh]
base = "shared"
spacing = "2 mm"
notch_spacing = "1 mm"
growth = 0.2
[material]
youngs_modulus = "3300 MPa"
poisson_ratio = 0.3
density = "1180 kg/m^3"
[fracture]
strength = "{strength}"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "{force}"]
rate = ["0 N/s", "0 N/s", "{rate}"]
[time]
duration = "20 us"
after_separation = "2 us"
{time}[sections]
y = ["5 mm", "8 mm"]
[output]
frames = 3
"""
DEFAULTS = {"samples": 3, "ensemble": "", "notch": NOTCH, "strength": "35 MPa", "force": "0 N", "rate": "5 N/s", "time": ""}
RANDOM = """[[random]]
key = "material.youngs_modulus"
distribution = "uniform"
lower = "2000 MPa"
upper = "9000 MPa"
"""


def small_input(end: str = "", **keys: object) -> str:
    """@param keys other values of DEFAULTS
    @param end of the text"""
    return INPUT.format(**{**DEFAULTS, **keys}) + end


def run(program: Path, text: str, folder: Path, *options: str, may_fail: bool = False) -> Path:
    """Computes the input's ensemble into a folder, which is returned; some samples may fail where it is said so."""
    source = folder.with_name(folder.name + ".toml")
    source.write_text(text)
    done = command_lines.crackle(program, "run", source, "-o", folder, *options)
    if done.returncode != (2 if may_fail else 0):
        raise RuntimeError(f"crackle run ended with status {done.returncode}: {done.stderr}")
    return folder
