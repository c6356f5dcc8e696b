# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of the campaign besides its rows: ensemble.h5 itself, pictures of its report, its fringes."""
from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from crackle_report.reading import read_ensemble
from crackle_report.writing import write_light_png
from crackle_runs import ROOT

from . import fringes
from .comparing import leading_notch
from .rows import Rows

REPORT = ROOT / "tools" / "crackle-report"
PICTURES = ("typical-paths", "crossings", "convergence", "shares")
N_FRINGES = 40  # samples whose pictures are looked at


def keep_pictures(results: Path, rows: Rows, folder: Path) -> None:
    """The report's pictures (few samples have no typical ones), and the growth of two typical samples, lighter.

    The sample with one crack comes before that with two.
    """
    subprocess.run([sys.executable, REPORT, results, "--no-animation"], check=True, stdout=subprocess.DEVNULL)
    growth = sorted((results / "report").glob("growth-*.png"), key=lambda file: file.stat().st_mtime)[-2:]
    found = {name: results / "report" / f"{name}.png" for name in PICTURES}
    names = {file: f"{name}.png" for name, file in found.items() if file.is_file()}
    pattern = dict(zip(rows.sample, rows.values["pattern"]))
    growth.sort(key=lambda file: (pattern[int(file.stem.removeprefix("growth-"))], file.name))
    names |= {file: f"growth-{number}.png" for number, file in enumerate(growth, 1)}
    for source, name in names.items():
        write_light_png(Image.open(source), folder / name)


def keep_ensemble(results: Path, folder: Path) -> None:
    """ensemble.h5, bit by bit, because it is sealed by a digest."""
    with tempfile.NamedTemporaryFile(dir=folder, delete=False) as part:
        part.write((results / "ensemble.h5").read_bytes())
    shutil.copymode(results / "ensemble.h5", part.name)
    Path(part.name).replace(folder / "ensemble.h5")


def keep_fringes(results: Path, rows: Rows, file: Path) -> None:
    """Looks at the pictures of the first samples, unless that was done since the ensemble last changed."""
    if file.is_file() and file.stat().st_mtime > (results / "ensemble.h5").stat().st_mtime:
        return
    turned = set(rows.sample[leading_notch(rows) == 1].tolist())
    series = fringes.look_through(read_ensemble(results), rows.sample[:N_FRINGES].tolist(), turned)
    fringes.write_csv(series, file)
