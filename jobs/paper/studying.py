# SPDX-License-Identifier: GPL-3.0-or-later
"""The command jobs/paper/studies: where the two groups of the paper's plate come from, what makes its cracks fork, and whether both settle
with the mesh."""
from __future__ import annotations

import argparse
import json
import math
import re
import resource
import subprocess
import sys
import tomllib
import zlib
from pathlib import Path
from typing import Any, Iterable, Sequence

import crackle
import numpy as np
from crackle.files import ENSEMBLE_KIND, results
from crackle_launch import environment
from crackle_report.sample_files import SampleFiles
from crackle_report.writing import write_light_figure
from matplotlib import pyplot

import laws
from crackle_readme import put_block
from crackle_runs import RunError, command, run, with_keys
from fast import leaders_speed
from problems import projected_branching
from study_pages import MOMENTS, POINTS, STUDIES, Found, Known, page, shown
from study_points import MESHES, PAPER, Point

RECORD = PAPER / "studies.json"
"""The findings at each point, so that tables and pictures need no sample."""
DPI = 130


# Findings at a point

def mean_and_deviation(values: Iterable[float]) -> list[float]:
    """And the number, of those that are there; rounded for the record."""
    there = np.array([value for value in values if math.isfinite(value)])
    return [*(float(f"{value:.5g}") for value in (there.mean(), there.std(ddof=1) if len(there) > 1 else 0.0)), len(there)] if len(there) else []


def rough_fringes(ensemble: crackle.Ensemble, point: Point) -> list[list[float]]:
    """Roughness of the fringes' order at MOMENTS, of each sample."""
    places = tuple(1e-3 * z for z in point.notches)
    files, found = SampleFiles(ensemble.folder), []
    for number in ensemble.done:
        frames, crack = files.frames(number), files.crack(number)
        seen = laws.fringes(frames, [int(np.abs(1e6 * frames.time - moment).argmin()) for moment in MOMENTS])
        found.append([laws.roughness(picture.order, laws.away_from(crack, places, 1e-3 * point.depth)) for picture in seen])
    return found


def findings(ensemble: crackle.Ensemble, point: Point) -> Found:
    rows, branches = ensemble.samples.loc[ensemble.done], [projected_branching(ensemble[number]).length for number in ensemble.done]
    with results(ensemble.folder / "ensemble.h5", ENSEMBLE_KIND) as root:
        leader = root["statistics/leader"]
        path = [[float(f"{mean:.6g}"), float(f"{deviation:.4g}"), int(number)] if number else []
                for mean, deviation, number in zip(*(leader[name][0] for name in ("z_mean", "z_std", "reached")))]
        commit = str(root.attrs["git_commit"])[:7]
    found = {"commit": commit, "samples": len(rows), "failed": int((ensemble.samples.status == "failed").sum()),
             "two cracks": int((rows.pattern == "two cracks").sum()), "forks": sum(len(lengths) > 0 for lengths in branches),
             "long forks in space": int((rows.long_bifurcations > 0).sum()), "leading path": path,
             **{name: mean_and_deviation(rows[column]) for name, column in (
                 ("onset", "onset_force"), ("largest speed over c_R", "crack_speed_ratio"), ("energy per area", "effective_toughness"))},
             "leader's speed": mean_and_deviation(leaders_speed(ensemble))}
    if point in MESHES:
        found["roughness"] = [mean_and_deviation(column) for column in zip(*rough_fringes(ensemble, point))]
    return found


def meaning(text: str) -> dict[str, Any]:
    """The values of an input but for how many samples and frames there are."""
    found = tomllib.loads(text)
    return found | {"ensemble": {**found["ensemble"], "samples": None}, "output": {**found.get("output", {}), "frames": None}}


def checksum(point: Point) -> int:
    return zlib.crc32(json.dumps(meaning(point.text), sort_keys=True).encode())


def stored() -> Known:
    record = json.loads(RECORD.read_text()) if RECORD.is_file() else {}
    return {point: record[point.name] for point in POINTS.values() if point.name in record}


def store(known: Known) -> None:
    """A line for each point."""
    RECORD.write_text("{\n" + ",\n".join(f'"{point.name}": {json.dumps(known[point])}' for point in POINTS.values() if point in known) + "\n}\n")


# The command

def is_enough(point: Point, found: Found | None, n_samples: int) -> bool:
    return found is not None and found["input"] == checksum(point) and found["samples"] + found["failed"] >= n_samples


def has_frames(ensemble: crackle.Ensemble) -> bool:
    return bool(tomllib.loads(ensemble.input).get("output", {}).get("frames", 0))


def kept_elsewhere(point: Point, folders: Iterable[Path], n_samples: int) -> crackle.Ensemble | None:
    """The ensemble that has the point's input, and so many samples."""
    return next((ensemble for ensemble in map(crackle.open, folders)
                 if meaning(ensemble.input) == meaning(point.text) and (ensemble.samples.status.isin(["done", "failed"])).sum() >= n_samples
                 and has_frames(ensemble) >= (point in MESHES)), None)


def core_hours(point: Point, n_samples: int, program: Path, folder: Path) -> float:
    """Of so many samples, as the program estimates it."""
    source = folder / "check.toml"
    folder.mkdir(parents=True, exist_ok=True)
    source.write_text(with_keys(point.text, {"ensemble.samples": str(n_samples)}))
    done = subprocess.run([str(program), "check", str(source)], capture_output=True, text=True, env=environment(), check=False)
    found = re.search(r"(?m)^core-hours += ([\d.e+-]+) ", done.stdout)
    if found is None:
        raise RunError(f"{point.name}: {done.stderr.strip() or 'the program gives no core-hours'}")
    return float(found[1])


def chosen(names: Sequence[str], parser: argparse.ArgumentParser) -> list[Point]:
    """The points of studies, and points, of these names."""
    for name in names:
        if name not in STUDIES and name not in POINTS:
            parser.error(f"there is no study or point '{name}'; give some of {', '.join([*STUDIES, *POINTS])}")
    return [*dict.fromkeys(point for name in names for point in (STUDIES[name].points if name in STUDIES else (POINTS[name],)))]


def compute(points: Sequence[Point], known: Known, arguments: argparse.Namespace) -> None:
    """Those that have too few samples; what is found is stored after each."""
    missing = [point for point in points if not is_enough(point, known.get(point), arguments.samples)]
    elsewhere = {point: ensemble for point in missing if (ensemble := kept_elsewhere(point, arguments.ensembles, arguments.samples)) is not None}
    print(f"{len(points) - len(missing)} of {len(points)} points are stored, {len(elsewhere)} are in the ensembles given", flush=True)
    hours = {}
    for point in missing:
        if point not in elsewhere:
            hours[point] = core_hours(point, arguments.samples, arguments.program, arguments.output)
            print(f"{point.name}: {hours[point]:.2g} core-hours", flush=True)
    if hours:
        print(f"{sum(hours.values()):.3g} core-hours for {len(hours)} points of {arguments.samples} samples, less those that are there", flush=True)
    if arguments.estimate:
        return
    for k, point in enumerate(missing):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        ensemble = elsewhere.get(point) or run(with_keys(point.text, {"ensemble.samples": str(arguments.samples)}), arguments.output / point.name,
                                               arguments.program, may_fail=True, ranks=arguments.ranks)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if not ensemble.done:
            raise RunError(f"{point.name}: no sample is done; see {ensemble.folder}")
        sharp = point.sharp_load(arguments.output, arguments.program)
        known[point] = {"input": checksum(point), **findings(ensemble, point), "sharp load": float(f"{sharp:.5g}")}
        store(known)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        print(f"{point.name}: {len(ensemble.done)} samples, {seconds:.0f} processor seconds; {k + 1} of {len(missing)} points, "
              f"about {sum(hours.get(other, 0) for other in missing[k + 1:]):.2g} core-hours left", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(prog="studies", description="Breaks the plate of round-slots.toml with other notches, toughnesses, releases and "
                                     "meshes, and prints how often it has two cracks and forks. What was found is stored in jobs/paper/studies.json; "
                                     "points with enough samples are not computed again, and a run that was stopped continues.")
    parser.add_argument("names", nargs="*", metavar="NAME", default=[*STUDIES], help=f"of the studies {', '.join(STUDIES)} (all when none is given), or of points: "
                        f"{', '.join(POINTS)}")
    parser.add_argument("--samples", type=int, default=48, help="of each point (%(default)s)")
    parser.add_argument("--ranks", type=int, default=3, help="of mpirun: a master and workers (%(default)s)")
    parser.add_argument("--ensembles", type=Path, nargs="+", default=[], metavar="FOLDER", help="of `crackle run`: points whose input they have are taken from there, where the samples are enough")
    parser.add_argument("--estimate", action="store_true", help="print what it costs, and compute nothing")
    parser.add_argument("--stored", action="store_true", help="tables and pictures of what is stored; nothing is computed")
    parser.add_argument("--keep", action="store_true", help="put tables and pictures into jobs/paper; without it pictures are in the output folder")

    def study(arguments: argparse.Namespace) -> int:
        points, known = chosen(arguments.names, parser), stored()
        if arguments.samples < 1:
            parser.error("--samples must be 1 or more")
        if not arguments.stored:
            try:
                compute(points, known, arguments)
            except crackle.ResultsError as error:  # of a folder that was given
                raise RunError(str(error)) from None
        if arguments.estimate:
            return 0
        for point in (point for point, found in known.items() if not is_enough(point, found, 1)):
            print(f"{point.name} is stored for another input", file=sys.stderr)
        place = PAPER if arguments.keep else arguments.output
        place.mkdir(parents=True, exist_ok=True)
        for name, one in shown(known).items():
            write_light_figure(figure := one.draw(known), place / f"{name}.png", DPI)
            pyplot.close(figure)
            print(f"{one.title}: {place / f'{name}.png'}\n\n{one.table(known)}")
        if arguments.keep:
            put_block("studies", page(known))
        return 0

    return command(parser, "studies", study)


if __name__ == "__main__":
    sys.exit(main())
