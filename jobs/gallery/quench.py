#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints quenched-alumina.toml: half a slab that is quenched at y = 0, with one [[initial.stress]] for each of some times, with
the change of temperature then and a history that is 1 then and 0 at the times before and after.

./quench.py [difference of temperature to the water [K]] [heat transfer [W/(m^2 K)]]
"""
from __future__ import annotations

import sys

import numpy as np

EXPANSION, CONDUCTIVITY, HEAT, DENSITY = 7.5e-6, 31.0, 880.0, 3980.0  # of 99 % alumina [1/K, W/(m K), J/(kg K), kg/m^3]
HALF_WIDTH = 5e-3  # to the plane of symmetry [m]


def temperatures(times: np.ndarray, coordinates: np.ndarray, transfer: float) -> np.ndarray:
    """Share of the whole change of temperature, times x coordinates: heat conduction across the half width, with a
    coefficient of heat transfer [W/(m^2 K)] at y = 0 (series of Carslaw and Jaeger, 1959)."""
    biot, fourier = transfer * HALF_WIDTH / CONDUCTIVITY, CONDUCTIVITY / (HEAT * DENSITY) * times / HALF_WIDTH**2
    root = np.zeros(2000)  # of b tan b = Bi, one in each interval of pi
    lower, upper = np.pi * np.arange(root.size), np.pi * (np.arange(root.size) + 0.5)
    for _ in range(100):
        root = (lower + upper) / 2
        above = (root * np.sin(root) - biot * np.cos(root)) * (-1.0) ** np.arange(root.size) > 0
        upper, lower = np.where(above, root, upper), np.where(above, lower, root)
    weight = 4 * np.sin(root) / (2 * root + np.sin(2 * root))
    from_middle = 1 - coordinates / HALF_WIDTH
    return 1 - np.einsum("k,tk,yk->ty", weight, np.exp(-np.outer(fourier, root**2)), np.cos(np.outer(from_middle, root)))


def tables(change: float, transfer: float, times: np.ndarray) -> str:
    depth = np.concatenate([[0], np.geomspace(0.05e-3, HALF_WIDTH, 15)])
    text, at = "", np.concatenate([[0.0], times])
    for k, row in enumerate(temperatures(times, depth, transfer), start=1):
        kelvin = np.round(change * row, 2)
        cooled = np.count_nonzero(kelvin) + 1  # up to the first place that has not changed
        pairs = ", ".join(f'["{1e3 * y:.3g} mm", "{-one if one else 0:.4g} K"]' for y, one in zip(depth[:cooled], kelvin))
        history = [(at[k - 1], 0), (at[k], 1)] + ([(at[k + 1], 0)] if k + 1 < at.size else [])
        text += '\n[[initial.stress]]\nalong = "y"\nexpansion = "7.5e-6 1/K"\n'
        text += f"temperature = [{pairs}]\n"
        text += "history = [" + ", ".join(f'["{1e3 * t:.4g} ms", {f}]' for t, f in history) + "]\n"
    return text


HEAD = '''# Alumina, quenched from 300 C in water of 20 C at one long edge: half the width of a slab of 10 mm, as Jiang et al. (Acta Mater. 60
# (2012) 4540) quenched. The heat transfer is assumed. Written by quench.py.
[ensemble]
samples = 3
seed = 3

[specimen]
size = ["0.3 mm", "5 mm", "16 mm"]

[mesh]
spacing = "0.25 mm"
base = "own"

[material]
youngs_modulus = "370 GPa"
poisson_ratio = 0.3
density = "3980 kg/m^3"

[fracture]
toughness = "24.3 J/m^2"                 # with this spacing a strength of some 200 MPa
impulse = "1e-8 MPa^2 s"

[[boundary]]                             # the middle of the slab
on = "y-max"
fix = ["y"]
[[boundary]]
on = "z-min"
fix = ["z"]
[[boundary]]
on = "x-min"
fix = ["x"]

[time]
duration = "20 us"
arrest = "2 us"
integrator = "verlet"

[sections]
y = ["1 mm"]
'''

if __name__ == "__main__":
    change, transfer = map(float, sys.argv[1:] + ["280", "5e4"][len(sys.argv) - 1:])
    print(HEAD + tables(change, transfer, np.geomspace(1e-3, 0.15, 14)), end="")
