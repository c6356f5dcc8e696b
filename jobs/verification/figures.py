# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of the verification, beside their references, and the table of them."""
from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass

import numpy as np

from crackle_runs import ROOT, RunError, markdown

MILLIMETRE = 1e-3


@dataclass(frozen=True)
class Figure:
    case: str
    quantity: str
    found: str
    reference: str


def mean(values: list[float], form: str) -> str:
    """Mean and standard deviation."""
    return f"{np.mean(values):{form}} ± {np.std(values, ddof=1):{form}}" if len(values) > 1 else f"{values[0]:{form}}"


def output_of(test: str) -> str:
    """What a test prints, by its name for CTest."""
    done = subprocess.run(["ctest", "--test-dir", str(ROOT / "build"), "-V", "--no-tests=error", "-R", rf"^{test}$"],
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise RunError(f"the test {test} failed; `CRACKLE_TESTS=ON tools/build` builds it:\n{done.stdout[-2000:]}{done.stderr}")
    return re.sub(r"(?m)^\d+: ", "", done.stdout)


def table(figures: list[Figure]) -> str:
    previous = ["", *(figure.case for figure in figures)]
    return markdown(["case", "figure", "found", "reference"],
                    [[figure.case if figure.case != before else "", figure.quantity, figure.found, figure.reference]
                     for figure, before in zip(figures, previous)])
