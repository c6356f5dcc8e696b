#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""An example of the Python package: `PYTHONPATH=tools jobs/figures.py out/demo` draws four pictures of an ensemble into figures.png."""
import sys

import crackle
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

plates = crackle.open(sys.argv[1])
print(plates.samples[["onset_force", "peak_load", "work_of_fracture", "crack_speed_max"]].describe())
print(plates.paths.arrival_time.median("sample"))

figure, ((load, length), (speed, cracks)) = plt.subplots(2, 2, figsize=(9, 7), layout="constrained")
plates.plot.load(axes=load)
plates.plot.crack_length(axes=length)
plates.plot.tip_speed(axes=speed)
plates.plot.cracks(axes=cracks)
figure.savefig("figures.png", dpi=150)
