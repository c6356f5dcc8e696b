# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of crackle-report."""
from __future__ import annotations

import argparse
import io
import sys
from dataclasses import replace
from pathlib import Path
from typing import Optional

from crackle.program import ResultsError, statistics_of

from . import page, style, sweep
from .figures import OF_SOLIDS, SECTIONS
from .figures.picture import Picture
from .options import Options
from .photoelasticity import STRESS_OPTIC, WAVELENGTH
from .photographs import add_pictures, leave_out_damaged
from .reading import read_ensemble
from .results import Ensemble
from .writing import write_whole


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="crackle-report",
        description="Draws the pictures of an ensemble into FOLDER/report (PNG and SVG) and writes "
                    "FOLDER/report.html, one file that needs no network. Works on unfinished ensembles too.")
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="output folder of crackle run; of a sweep its results are drawn over the swept values")
    parser.add_argument("--cases", action="store_true", help="of a sweep, write the report of each case, too")
    _add_options(parser)
    arguments = parser.parse_args()
    try:
        options = _options(arguments)
        if sweep.is_sweep(arguments.folder):
            report = _of_sweep(arguments, options)
        else:
            if arguments.compared:
                from crackle.comparison import compare  # with pandas
                options = replace(options, comparison=compare(arguments.folder, *arguments.compared, program=arguments.program).document)
            report = make_report(arguments.folder, options, arguments.program)
    except (ResultsError, OSError) as error:
        print(f"crackle-report: {error}", file=sys.stderr)
        return 1
    print(f"report: {report}")
    return 0


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--program", type=Path, metavar="FILE",
                        help="the program crackle (default: the environment variable CRACKLE, build/bin/crackle, or the one on "
                        "the PATH)")
    parser.add_argument("--compare", type=Path, action="append", default=[], metavar="OTHER", dest="compared",
                        help="also compare with this ensemble, as crackle compare does; may be given several times")
    parser.add_argument("--experiments", type=Path, metavar="FILE",
                        help="also show these experiments (TOML) beside the samples, as crackle match and crackle calibrate do")
    detail = parser.add_argument_group("samples in detail")
    detail.add_argument("--sample", type=int, action="append", default=[], metavar="N", dest="samples",
                        help="show this sample's fringes, crack growth and energy; may be given several times (default: a "
                             "typical sample of each main pattern)")
    detail.add_argument("--times", type=_times, default=(), metavar="T,T,...",
                        help="times after the onset [us], such as 0,30,50,70; the nearest frames are shown")
    detail.add_argument("--no-animation", action="store_true", help="leave the animations out")
    optics = parser.add_argument_group("photo-elastic pictures")
    optics.add_argument("--no-fringes", action="store_true", help="leave these pictures out, as for an opaque material")
    optics.add_argument("--field", choices=("dark", "light"), default="dark")
    optics.add_argument("--reverse", action="store_true", help="reverse the colours")
    optics.add_argument("--form", choices=("product", "integrated"), default="product",
                        help="product of the Jones matrices along each ray, or stress integrated along it")
    optics.add_argument("--stress-optic", type=_coefficients, default=(), metavar="C[,C...]",
                        help="stress-optic coefficient of the material, or of each material in the order of the input [1/Pa] (default: "
                             f"{STRESS_OPTIC:g}, typical of epoxy, for materials of less than 10 GPa; stiffer ones show no fringes)")
    optics.add_argument("--wavelength", type=float, default=1e9 * WAVELENGTH, metavar="NM",
                        help="wavelength of the light [nm] (default: %(default)g)")


def _coefficients(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(value) for value in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of coefficients in 1/Pa, such as 5.5e-11 or 5.5e-11,2.7e-12") from None


def _times(text: str) -> tuple[float, ...]:
    try:
        return tuple(1e-6 * float(time) for time in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of times in us, such as 0,30,50") from None


def _options(arguments: argparse.Namespace) -> Options:
    return Options(samples=tuple(arguments.samples), times=arguments.times, fringes=not arguments.no_fringes,
                   stress_optic=arguments.stress_optic, wavelength=1e-9 * arguments.wavelength,
                   light_field=arguments.field == "light", reverse=arguments.reverse,
                   product=arguments.form == "product", animation=not arguments.no_animation,
                   experiments=arguments.experiments)


def _with_experiments(options: Options, ensemble: Ensemble, program: Optional[Path]) -> Options:
    """Adds what the program says of the experiments, and what their pictures do."""
    # With pandas and SciPy, which take long to load.
    from crackle import matching
    from crackle.calibration import calibrate

    match, calibration = matching.match(ensemble.folder, options.experiments, program).document, None
    ensemble.unreadable += leave_out_damaged(match)
    if options.fringes:
        add_pictures(match, ensemble, options, _tell)
        _tell("")
    reason = "the ensemble has no random inputs"
    if ensemble.inputs:
        try:
            calibration = calibrate(ensemble.folder, options.experiments, program=program).document
        except ResultsError as error:
            reason = str(error)
    return replace(options, match=match, calibration=calibration, no_calibration=reason)


def _tell(text: str) -> None:
    """Progress, each line over the one before on a terminal; elsewhere none."""
    if sys.stderr.isatty():
        print(f"\r{text}\x1b[K", end="", file=sys.stderr, flush=True)


def make_report(folder: Path, options: Options = Options(), program: Optional[Path] = None) -> Path:
    """Writes the pictures and the page; returns the page's path.

    Raises ResultsError when the folder holds no ensemble, or not the samples chosen.
    """
    style.apply()
    ensemble = read_ensemble(folder, program, skips_damaged=True)
    for number in options.samples:
        if number in ensemble.files.damage:
            raise ResultsError(ensemble.files.damage[number])
        if number not in ensemble.done:
            raise ResultsError(f"'{folder}': sample {number} is not done; done are "
                                       f"{', '.join(map(str, ensemble.done)) or 'none'}")
    pictures_folder = folder / "report"
    pictures_folder.mkdir(exist_ok=True)
    if options.experiments:
        options = _with_experiments(options, ensemble, program)
    sections = []
    for make_section in OF_SOLIDS if ensemble.plate.is_solid else SECTIONS:
        section = make_section(ensemble, options)
        if section is None:
            continue
        pictures = [*section.pictures, *(view.picture for view in section.views)]
        sections.append((section, [_save(picture, pictures_folder) for picture in pictures]))
        for film in section.animations:
            write_whole(pictures_folder / f"{film.name}.gif", film.gif)
    report = folder / "report.html"
    write_whole(report, page.render(ensemble, sections).encode("utf-8"))
    return report


def _of_sweep(arguments: argparse.Namespace, options: Options) -> Path:
    """Writes the report of a sweep, and those of its cases where they are wanted; returns its path. Raises ResultsError."""
    folder = arguments.folder
    if arguments.compared or arguments.experiments or arguments.samples:
        raise ResultsError(f"'{folder}' holds a sweep; --compare, --experiments and --sample take the folder of one of its cases, such as "
                           f"{folder / 'case-0'}")
    style.apply()
    document = statistics_of(folder, arguments.program)
    drawn = sweep.section(document)
    for case in sweep.case_folders(folder, document) if arguments.cases else ():
        make_report(case, options, arguments.program)
    pictures_folder = folder / "report"
    pictures_folder.mkdir(exist_ok=True)
    images = [_save(picture, pictures_folder) for picture in drawn.pictures]
    report = folder / "report.html"
    write_whole(report, sweep.render(folder, document, drawn, images).encode("utf-8"))
    return report


def _save(picture: Picture, folder: Path) -> bytes:
    """Writes a picture as PNG and SVG; returns the PNG."""
    png, svg = io.BytesIO(), io.BytesIO()
    # Without dates and versions in the files the same results give the same bytes.
    picture.figure.savefig(png, format="png", metadata={"Software": None})
    picture.figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": None})
    write_whole(folder / f"{picture.name}.png", png.getvalue())
    write_whole(folder / f"{picture.name}.svg", svg.getvalue())
    return png.getvalue()
