# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the verification, beside their references, and the table of them."""
from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crackle_runs import ROOT, RunError, markdown

MILLIMETRE, MICROSECOND = 1e-3, 1e-6


@dataclass(frozen=True)
class Figure:
    case: str
    quantity: str
    found: str
    reference: str


def mean(values: list[float], form: str) -> str:
    """Mean and standard deviation."""
    return f"{np.mean(values):{form}} ± {np.std(values, ddof=1):{form}}" if len(values) > 1 else f"{values[0]:{form}}"


def output_of(program: Path) -> str:
    if not program.is_file():
        raise RunError(f"there is no {program}; run tools/build ci first")
    done = subprocess.run([str(program)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RunError(f"{program.relative_to(ROOT)} failed:\n{done.stdout[-2000:]}")
    return done.stdout


def table(figures: list[Figure]) -> str:
    previous = ["", *(figure.case for figure in figures)]
    return markdown(["case", "figure", "found", "reference"],
                    [[figure.case if figure.case != before else "", figure.quantity, figure.found, figure.reference]
                     for figure, before in zip(figures, previous)])
