#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What whole samples cost with the settings that people use, beside the force evaluations in them.

    sample_times.py INPUT JSON N

Adds to the figures in JSON, which benchmark_time_loop wrote, those of the first N samples of INPUT with `verlet` and
with `bilateral4`, both with step = "auto", and of one sample with `bilateral4` and steps of 5 ns; and prints all
figures that have a target.
"""
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import h5py  # noqa: E402
from crackle_launch import environment  # noqa: E402

SETTINGS = {"verlet_auto": ("verlet", "auto"), "bilateral4_auto": ("bilateral4", "auto"),
            "bilateral4_5ns": ("bilateral4", "5 ns")}
TARGETS = {  # key: what it is, target, whether less is better
    "force_varied_over_force": ("force, stiffness that varies, over one modulus", 1.3, True),
    "static_first_over_force": ("first static solve, over a force evaluation", 700, True),
    "static_update_over_force": ("static solve after a break, over a force evaluation", 200, True),
    "loop_verlet_auto_over_force": ("time loop of verlet, auto, over the force's rate", 0.45, False),
    "loop_bilateral4_auto_over_force": ("time loop of bilateral4, auto, over the force's rate", 0.7, False),
    "loop_bilateral4_5ns_over_force": ("time loop of bilateral4, 5 ns, over the force's rate", 0.85, False),
    "sample_verlet_auto_seconds": ("sample, verlet, auto [s]", 7, True),
    "sample_bilateral4_auto_seconds": ("sample, bilateral4, auto [s]", 12, True),
    "sample_bilateral4_5ns_seconds": ("sample, bilateral4, 5 ns [s]", 60, True),
    "base_points_seconds": ("base points [s]", 0.6, True),
    "ratio_to_petsc_sbaij": ("force, mixed, over PETSc's SBAIJ", 13, False),
}


def setting(text: str, integrator: str, step: str) -> str:
    """The input with another integrator and step."""
    text = re.sub(r'^integrator = ".*"', f'integrator = "{integrator}"', text, flags=re.MULTILINE)
    return re.sub(r'^step = ".*"', f'step = "{step}"', text, flags=re.MULTILINE)


def run(text: str, n_samples: int, force_seconds: float) -> tuple[float, float]:
    """Medians over samples: seconds of one, and the share of its dynamic phases that force evaluations alone take."""
    seconds, shares = [], []
    with tempfile.TemporaryDirectory(prefix="crackle-benchmark-") as name:
        folder = pathlib.Path(name)
        (folder / "input.toml").write_text(text, encoding="utf-8")
        for sample in range(n_samples):
            subprocess.run([ROOT / "build-benchmark" / "bin" / "crackle", "sample", folder / "input.toml", "--sample",
                            str(sample), "-o", folder / "out"], check=True, env=environment(), stdout=subprocess.DEVNULL)
            with h5py.File(folder / "out" / "samples" / f"{sample:04}.h5") as file:
                timing = file["timing"]
                seconds.append(timing["wall_time"][()])
                shares.append(file["counts/force_evaluations"][()] * force_seconds / timing["dynamic"][()])
    return statistics.median(seconds), statistics.median(shares)


def main() -> None:
    source, target, n_samples = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), int(sys.argv[3])
    figures = json.loads(target.read_text(encoding="utf-8"))
    for name, (integrator, step) in SETTINGS.items():
        n = min(n_samples, 1) if step == "5 ns" else n_samples
        if n == 0:
            continue
        seconds, share = run(setting(source.read_text(encoding="utf-8"), integrator, step), n,
                             figures["force_seconds"])
        figures[f"sample_{name}_seconds"] = seconds
        figures[f"loop_{name}_over_force"] = share
    target.write_text(json.dumps(figures, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    print(f"\n| {'what':<56} | {'measured':>8} | {'target':>16} |")
    print(f"|{'-' * 58}|{'-' * 9}:|{'-' * 17}:|")
    for key, (what, goal, less) in TARGETS.items():
        if key not in figures:
            continue
        figure = f"{figures[key]:.0f}" if figures[key] >= 100 else f"{figures[key]:.3g}"
        print(f"| {what:<56} | {figure:>8} | {'at most' if less else 'at least':>8} {goal:>7} |")


if __name__ == "__main__":
    main()
