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

from . import fringes
from .comparing import leading_notch
from .rows import Rows

REPORT = Path(__file__).resolve().parent.parent / "crackle-report"
PICTURES = ("typical-paths", "crossings", "convergence", "shares")
N_FRINGES = 40  # samples whose pictures are looked at
WIDTH, COLOURS = 1280, 256  # of the pictures kept


def keep_pictures(results: Path, folder: Path) -> None:
    """The report's pictures, and the growth of its two typical samples, lighter."""
    subprocess.run([sys.executable, REPORT, results, "--no-animation"], check=True, stdout=subprocess.DEVNULL)
    growth = sorted((results / "report").glob("growth-*.png"), key=lambda file: file.stat().st_mtime)[-2:]
    names = {results / "report" / f"{name}.png": f"{name}.png" for name in PICTURES}
    names |= {file: f"growth-{number}.png" for number, file in enumerate(sorted(growth), 1)}
    for source, name in names.items():
        image = Image.open(source).convert("RGB")
        if image.width > WIDTH:
            image = image.resize((WIDTH, round(WIDTH * image.height / image.width)), Image.Resampling.LANCZOS)
        image.quantize(COLOURS, Image.Quantize.MAXCOVERAGE).save(folder / name, optimize=True)


def keep_ensemble(results: Path, folder: Path) -> None:
    """ensemble.h5, bit by bit, because it is sealed by a digest."""
    with tempfile.NamedTemporaryFile(dir=folder, delete=False) as part:
        part.write((results / "ensemble.h5").read_bytes())
    shutil.copymode(results / "ensemble.h5", part.name)
    Path(part.name).replace(folder / "ensemble.h5")


def keep_fringes(results: Path, rows: Rows, file: Path) -> list[fringes.FringeSeries]:
    """Looks at the pictures of the first samples; those that the file has already are not looked at again."""
    known = fringes.read_csv(file) if file.is_file() else []
    lead = dict(zip(rows.sample.tolist(), leading_notch(rows).tolist()))
    with_leader = [sample for sample in rows.sample.tolist() if lead[sample] >= 0]
    reference, *others = with_leader[:N_FRINGES + 1]
    done = {one.sample for one in known}
    turned = {sample for sample, notch in lead.items() if notch != lead[reference]}
    ensemble = read_ensemble(results)
    missing = [sample for sample in others if sample not in done]
    if missing:
        known += fringes.look_through(ensemble, reference, missing, turned)
        known.sort(key=lambda one: one.sample)
        fringes.write_csv(known, file)
    return known
