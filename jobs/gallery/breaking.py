# SPDX-License-Identifier: GPL-3.0-or-later
"""The command jobs/gallery/gallery: breaks the bodies of this folder and draws them."""
from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from typing import Sequence

import numpy as np
from PIL import Image

import pictures
from crackle import Ensemble
from crackle_readme import put_block
from crackle_report.writing import write_light_image
from crackle_runs import ROOT, command, markdown, run
from measured import PROBLEMS as MEASURED
from problems import PROBLEMS as COMPUTED, Problem, files_beside

PROBLEMS = COMPUTED | MEASURED

GALLERY = Path(__file__).resolve().parent
BODIES = ("plate-with-hole", "surface-flaw", "star", "crushed-disk", "projectile", "inclined-crack", "radial-cracks", "flaws", "blunt-notches", "ring", "solid", "offset-notch", "l-panel", "stiff-disc", "layered-plate", "grains",
          "quenched-alumina")


def rows(problem: Problem, ensemble: Ensemble) -> list[list[str]]:
    return [[figure.quantity, figure.find(ensemble), figure.reference(ensemble)] for figure in problem.figures]


def draw_report(name: str, folder: Path, picture: Path, program: Path, experiments: Sequence[str | Path] = ()) -> None:
    """A picture of the report: one that shows the experiments, or a crack in a solid."""
    subprocess.run([ROOT / "tools" / "crackle-report", folder, *experiments, "--no-animation", "--program", program], check=True)
    with Image.open(folder / "report" / f"{name}.png") as drawn:
        write_light_image(drawn, picture)


def main() -> int:
    names = [*PROBLEMS, *BODIES]
    parser = argparse.ArgumentParser(prog="gallery", description="Breaks the bodies of jobs/gallery on a master and two workers, and says what is "
                                     "found beside a reference where there is one. Finished runs are kept, a run that "
                                     "was stopped continues.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(names)}; all when none is given")
    parser.add_argument("--ranks", type=int, default=3, help="of mpirun: a master and workers (default: 3)")
    parser.add_argument("--coarse", action="store_true", help="the problems with fewer samples on coarser meshes: seconds "
                        "instead of minutes, and numbers that are only about right")
    parser.add_argument("--keep", action="store_true", help="put pictures and numbers into jobs/gallery")

    def gallery(arguments: argparse.Namespace) -> int:
        for name in arguments.names:
            if name not in names:
                parser.error(f"there is no problem '{name}'; give some of {', '.join(names)}")
        if arguments.keep and arguments.coarse:
            parser.error("--keep cannot be combined with --coarse")
        for name in arguments.names or names:
            folder = arguments.output / (f"{name}-coarse" if arguments.coarse else name)
            problem = PROBLEMS.get(name)
            text = problem.input_text(arguments.coarse) if problem else (GALLERY / f"{name}.toml").read_text()
            ensemble = run(text, folder, arguments.program, ranks=arguments.ranks, beside=files_beside(text))
            table = rows(problem, ensemble) if problem else []
            for quantity, found, reference in table:
                print(f"{name}: {quantity}: {found}; reference: {reference}", flush=True)
            print(f"{name}: {len(ensemble)} samples, {ensemble.samples.wall_time.mean():.2g} s each on one core", flush=True)
            if not problem:
                loads = pictures.breaking_loads(ensemble)  # NaN where nothing pulls, as in a quench
                load = f"{np.mean(loads):.4g} ± {np.std(loads, ddof=1):.2g} N, " if np.isfinite(loads).all() else ""
                print(f"{name}: {load}{', '.join(ensemble.samples.outcome.unique())}", flush=True)
            if arguments.keep:
                if problem and problem.picture:
                    draw_report(problem.picture, ensemble.folder, GALLERY / f"{name}.png", arguments.program, ("--experiments", problem.experiments_file))
                elif ensemble[ensemble.done[0]].plate.is_solid:
                    draw_report(f"crack-{ensemble.done[0]:04}", ensemble.folder, GALLERY / f"{name}.png", arguments.program)
                else:
                    pictures.draw(name, GALLERY / f"{name}.png", ensemble)
                if problem:
                    put_block(name, markdown(["", "found", "reference"], table))
        return 0

    return command(parser, "gallery", gallery)


if __name__ == "__main__":
    sys.exit(main())
