# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of crackle-report."""
from __future__ import annotations

import argparse
import io
import os
import sys
from pathlib import Path

from . import page, reading, style
from .figures import SECTIONS
from .figures.picture import Picture


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="crackle-report",
        description="Draws the pictures of an ensemble into FOLDER/report (PNG and SVG) and writes "
                    "FOLDER/report.html, one file that needs no network. Works on unfinished ensembles too.")
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="output folder of crackle run")
    arguments = parser.parse_args()
    try:
        report = make_report(arguments.folder)
    except (reading.ResultsError, OSError) as error:
        print(f"crackle-report: {error}", file=sys.stderr)
        return 1
    print(f"report: {report}")
    return 0


def make_report(folder: Path) -> Path:
    """Writes the pictures and the page; returns the page's path."""
    style.apply()
    ensemble = reading.read_ensemble(folder)
    pictures_folder = folder / "report"
    pictures_folder.mkdir(exist_ok=True)
    sections = []
    for make_section in SECTIONS:
        section = make_section(ensemble)
        sections.append((section, [_save(picture, pictures_folder) for picture in section.pictures]))
    report = folder / "report.html"
    _write_whole(report, page.render(ensemble, sections).encode("utf-8"))
    return report


def _save(picture: Picture, folder: Path) -> bytes:
    """Writes a picture as PNG and SVG; returns the PNG."""
    png, svg = io.BytesIO(), io.BytesIO()
    # Without dates and versions in the files the same results give the same bytes.
    picture.figure.savefig(png, format="png", metadata={"Software": None})
    picture.figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
    _write_whole(folder / f"{picture.name}.png", png.getvalue())
    _write_whole(folder / f"{picture.name}.svg", svg.getvalue())
    return png.getvalue()


def _write_whole(file: Path, content: bytes) -> None:
    """Replaces a file in one step, so that a reader never sees half of it."""
    partial = file.with_name(file.name + ".partial")
    partial.write_bytes(content)
    os.replace(partial, file)
