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
from dataclasses import dataclass, fields, replace
from functools import cached_property
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any, Callable, Iterable, Sequence

import crackle
import numpy as np
from crackle.files import ENSEMBLE_KIND, results
from crackle.inference import wilson
from crackle_launch import environment
from crackle_report import style
from crackle_report.sample_files import SampleFiles
from crackle_report.writing import write_light_figure
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from scipy import stats

import laws
from crackle_readme import put_block
from crackle_runs import RunError, command, markdown, run, with_keys
from fast import leaders_speed
from problems import projected_branching

PAPER = Path(__file__).resolve().parent
RECORD = PAPER / "studies.json"
"""The findings at each point, so that tables and pictures need no sample."""
CONFIDENCE = 0.95
WIDTH, LENGTH, THICKNESS = 24.5, 140, 5  # of the plate [mm]
BESIDE = 5  # of the notches, how far the fine mesh goes [mm]
SHARP, DEEPER = 0.2, 0.4  # height of the slots that stand for sharp cracks, and by how much their energies are compared [mm]
SHARP_LOAD = 500  # at which that is done [N]
MOMENTS = (0, 40)  # at which fringes are compared, since the onset [µs]
DPI = 130
TICKS = (1, 1.5, 2, 3, 4)  # of the surplus


@dataclass(frozen=True)
class Point:
    """A plate: that of round-slots.toml with other values."""

    distance: float = 6  # of the notches along z [mm]
    depth: float = 3.3  # [mm]
    toughness: float = 28  # [J/m^2]
    spacing: float = 0.6  # where cracks run [mm]; at the slots' ends there are three cells over their height on all meshes
    release: str = "by-speed"  # or immediate; with both, strength counts where no crack is near, for means around nodes

    @property
    def name(self) -> str:
        changed = [field.name for field in fields(self) if getattr(self, field.name) != field.default]
        return "-".join(getattr(self, name) if name == "release" else f"{name}-{getattr(self, name):g}" for name in changed) or "base"

    @property
    def notches(self) -> tuple[float, float]:
        """Their places along z [mm]."""
        return (LENGTH - self.distance) / 2, (LENGTH + self.distance) / 2

    @cached_property
    def text(self) -> str:
        """The input; with frames only where fringes are looked at."""
        text = (PAPER / "round-slots.toml").read_text()
        low, high = self.notches
        for old, new in (('"67 mm"', f'"{low:g} mm"'), ('"73 mm"', f'"{high:g} mm"'), ('"3.3 mm"', f'"{self.depth:g} mm"'),
                         ('"21.2 mm"', f'"{WIDTH - self.depth:g} mm"'), ('["62 mm", "78 mm"]', f'["{low - BESIDE:g} mm", "{high + BESIDE:g} mm"]')):
            if old not in text:
                raise RunError(f"round-slots.toml has no {old}, which the studies change")
            text = text.replace(old, new)
        keys = {"fracture.toughness": f'"{self.toughness:g} J/m^2"', "mesh.region.spacing": f'"{self.spacing:g} mm"'}
        if self.release == "immediate":
            keys |= {"fracture.release_speed": None, "fracture.release_time": '"0 s"'}
        if self != BASE:
            keys["output.frames"] = "8" if self in STUDIES["mesh"].points else "0"
        return with_keys(text, keys)

    def with_sharp_slots(self, depth: float) -> str:
        """The input of the body without breaks, with slots of this depth [mm] that are as sharp as the mesh, under SHARP_LOAD."""
        slots = "".join(f'[[specimen.notch]]\nface = "{face}"\nat = "{z:g} mm"\ndepth = "{depth:g} mm"\nheight = "{SHARP} mm"\n'
                        for face, z in zip(("y-min", "y-max"), self.notches))
        text = re.sub(r"(?s)\[\[specimen\.notch\]\].*(?=\n\[mesh\])", slots, self.text)
        text = re.sub(r"(?m)^force = .*\nrate = .*$", f'force = ["0 N", "0 N", "{SHARP_LOAD} N"]', text)
        return with_keys(text, {"ensemble.samples": "2", "mesh.notch_spacing": f'"{SHARP} mm"', "mesh.region.spacing": f'"{BASE.spacing} mm"',
                                "fracture.strength": '"100 GPa"', "fracture.toughness": None, "fracture.release_speed": None,
                                "fracture.release_time": None, "time.duration": '"0.1 us"', "output.frames": "0"})

    def sharp_load(self, folder: Path, program: Path) -> float:
        """Load at which the toughness is the energy release rate of sharp cracks as deep as the slots, by the energies of two depths [N]."""
        name = f"sharp-{self.distance:g}-{self.depth:g}"
        energies = [[sample.energy.strain[-1] for sample in run(self.with_sharp_slots(self.depth + change), folder / f"{name}{change:+g}", program)]
                    for change in (-DEEPER, DEEPER)]
        shallow, deep = np.mean(energies, axis=1)
        rate = (deep - shallow) / (2 * 2 * DEEPER * THICKNESS * 1e-6)  # of both cracks
        return SHARP_LOAD * math.sqrt(self.toughness / rate)


BASE = Point()
TOUGHNESSES = (20, 28, 34, 40, 57, 72)  # [J/m^2]


# Findings at a point

def mean_and_deviation(values: Iterable[float]) -> list[float]:
    """And the number, of those that are there; rounded for the record."""
    there = np.array([value for value in values if math.isfinite(value)])
    return [*(float(f"{value:.5g}") for value in (there.mean(), there.std(ddof=1) if len(there) > 1 else 0.0)), len(there)] if len(there) else []


def rough_fringes(ensemble: crackle.Ensemble, depth: float) -> list[list[float]]:
    """Roughness of the fringes' order at MOMENTS, of each sample."""
    files, found = SampleFiles(ensemble.folder), []
    for number in ensemble.done:
        frames, crack = files.frames(number), files.crack(number)
        seen = laws.fringes(frames, [int(np.abs(1e6 * frames.time - moment).argmin()) for moment in MOMENTS])
        found.append([laws.roughness(picture.order, laws.away_from(crack, depth)) for picture in seen])
    return found


def findings(ensemble: crackle.Ensemble, point: Point) -> dict[str, Any]:
    """Counts of samples; [mean, standard deviation, number] of other results, in SI units."""
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
    if point in STUDIES["mesh"].points:
        found["roughness"] = [mean_and_deviation(column) for column in zip(*rough_fringes(ensemble, point.depth * 1e-3))]
    return found


def meaning(text: str) -> dict[str, Any]:
    """The values of an input but for how many samples and frames there are."""
    found = tomllib.loads(text)
    return found | {"ensemble": {**found["ensemble"], "samples": None}, "output": {**found.get("output", {}), "frames": None}}


def checksum(point: Point) -> int:
    return zlib.crc32(json.dumps(meaning(point.text), sort_keys=True).encode())


Known = dict[Point, dict[str, Any]]


def stored() -> Known:
    record = json.loads(RECORD.read_text()) if RECORD.is_file() else {}
    return {point: record[point.name] for point in POINTS.values() if point.name in record}


def store(known: Known) -> None:
    """A line for each point."""
    RECORD.write_text("{\n" + ",\n".join(f'"{point.name}": {json.dumps(known[point])}' for point in POINTS.values() if point in known) + "\n}\n")


# Tables

def share(found: dict[str, Any], name: str) -> tuple[float, float, float]:
    """Share of the samples and its interval [%]."""
    part = found[name] / found["samples"]
    interval = wilson(part, found["samples"], CONFIDENCE)
    return 100 * part, 100 * interval.lower, 100 * interval.upper


def share_text(name: str) -> Callable[[Point, dict[str, Any]], str]:
    return lambda _, found: "{:.0f} % ({:.0f} to {:.0f})".format(*share(found, name))


def spread(name: str, form: str, unit: str = "") -> Callable[[Point, dict[str, Any]], str]:
    return lambda _, found: f"{found[name][0]:{form}} ± {found[name][1]:{form}}{unit}" if found.get(name) else "–"


def surplus(found: dict[str, Any]) -> float:
    return (found["onset"][0] / found["sharp load"]) ** 2


def path_text(_: Point, found: dict[str, Any]) -> str:
    return ", ".join(f"{1e3 * place[0]:.1f} ± {1e3 * place[1]:.1f}" if place else "–" for place in found["leading path"][::2]) + " mm"


def roughness_text(_: Point, found: dict[str, Any]) -> str:
    start, later = found["roughness"]
    return f"{later[0] / start[0]:.1f}" if start and later else "–"


PLATE = {"apart": lambda point, _: f"{point.distance:g} mm", "deep": lambda point, _: f"{point.depth:g} mm"}
TOUGHNESS = {"toughness": lambda point, _: f"{point.toughness:g} J/m²"}
RELEASE = {"release": lambda point, _: "immediate" if point.release == "immediate" else "780 m/s"}
SPACING = {"spacing": lambda point, _: f"{point.spacing:g} mm"}
ONSET = {"samples": lambda _, found: str(found["samples"]), "onset": spread("onset", ".0f", " N"), "surplus": lambda _, found: f"{surplus(found):.2f}"}
TWO = {"two cracks": share_text("two cracks")}
FORKS = {"forks, branches from 2 mm": share_text("long forks in space"), "seen through the plate": share_text("forks")}
SPEED = {"largest speed / c_R": spread("largest speed over c_R", ".2f")}
SETTLING = {"leading path, y = 7, 12.25, 17.5 mm": path_text, "leader's speed": spread("leader's speed", ".0f", " m/s"),
            "roughness of the fringes at t₀ + 40 µs over that at t₀": roughness_text}


# Pictures

def draw_shares(axes: Axes, known: Known, points: Iterable[Point], name: str, of: Callable[[Point], float], **style_of: Any) -> None:
    """Shares with their intervals, over a value of the points."""
    there = sorted((point for point in points if point in known), key=of)
    if not there:
        return
    values, low, high = np.array([share(known[point], name) for point in there]).T
    axes.errorbar([of(point) for point in there], values, (values - low, high - values), **{"fmt": "o-", "ms": 4, "lw": 1, "capsize": 2} | style_of)
    axes.set_ylim(-3, 103)


def draw_means(axes: Axes, known: Known, points: Iterable[Point], values: Callable[[dict[str, Any]], list[float]], of: Callable[[Point], float],
               is_scatter: bool = False, **style_of: Any) -> None:
    """Means with Student's intervals, or with standard deviations."""
    there = sorted((point for point in points if point in known and values(known[point])), key=of)
    found = [values(known[point]) for point in there]
    bars = [deviation if is_scatter else stats.t.ppf((1 + CONFIDENCE) / 2, n - 1) * deviation / math.sqrt(n) if n > 1 else math.nan
            for _, deviation, n in found]
    axes.errorbar([of(point) for point in there], [mean for mean, *_ in found], bars, **{"fmt": "o-", "ms": 4, "lw": 1, "capsize": 2} | style_of)


def panels(n: int) -> tuple[Figure, Sequence[Axes]]:
    style.apply()
    return pyplot.subplots(1, n, figsize=(style.PAGE_WIDTH, 2.9), layout="constrained")


def put_legend(axes: Axes) -> None:
    """Above the panel, where it hides no bar."""
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=3, columnspacing=1, handletextpad=0.4)


def surplus_in(known: Known) -> Callable[[Point], float]:
    return lambda point: surplus(known[point])


def beside(k: int) -> Callable[[Point], float]:
    """The spacing, of several kinds a little beside each other."""
    return lambda point: point.spacing + 0.015 * k


def draw_two_cracks(known: Known) -> Figure:
    """A panel for the distance of the notches, one for their depth, and one of all points over the surplus."""
    figure, (distance, depth, together) = panels(3)
    for axes, points, of, label, colour in ((distance, DISTANCES, attrgetter("distance"), "distance of the notches [mm]", style.notch_colour(0)),
                                            (depth, DEPTHS, attrgetter("depth"), "depth of the notches [mm]", style.notch_colour(1))):
        draw_shares(axes, known, points, "two cracks", of, color=colour)
        axes.set_xticks([of(point) for point in points])
        axes.set(xlabel=label, ylabel="two cracks [% of samples]")
    for k, (points, label) in enumerate(((DISTANCES, "distance"), (DEPTHS, "depth"), (BY_SPEED, "toughness"))):
        draw_shares(together, known, points, "two cracks", surplus_in(known), color=style.notch_colour(k), fmt="o", label=label)
    together.set(xlabel="surplus", ylabel="two cracks [% of samples]")
    put_legend(together)
    return figure


def draw_forks(known: Known) -> Figure:
    """Shares and speeds over the surplus, with both releases."""
    figure, (forks, speeds) = panels(2)
    for k, (points, label) in enumerate(((BY_SPEED, "release by speed"), (AT_ONCE, "immediate release"))):
        look = {"color": style.notch_colour(k), "label": label}
        draw_shares(forks, known, points, "long forks in space", surplus_in(known), **look)
        draw_shares(forks, known, points, "forks", surplus_in(known), color=look["color"], fmt="s:", mfc="none")
        draw_means(speeds, known, points, itemgetter("largest speed over c_R"), surplus_in(known), **look)
    for axes, label in ((forks, "samples with forks [%]"), (speeds, "largest speed / c_R")):
        axes.set(xlabel="surplus", ylabel=label, xscale="log")
        axes.set_xticks(TICKS, [f"{value:g}" for value in TICKS])
        axes.xaxis.set_minor_locator(NullLocator())
        put_legend(axes)
    return figure


def draw_mesh(known: Known) -> Figure:
    """Shares, the leading path, speed and fringes over the spacing."""
    def at(place: int) -> Callable[[dict[str, Any]], list[float]]:
        return lambda found: [1e3 * value for value in found["leading path"][place][:2]] + found["leading path"][place][2:]

    def rough(place: int) -> Callable[[dict[str, Any]], list[float]]:
        return lambda found: found["roughness"][place]

    figure, (shares, path, speed, fringes) = panels(4)
    for k, (name, label) in enumerate((("two cracks", "two cracks"), ("long forks in space", "forks from 2 mm"))):
        draw_shares(shares, known, MESHES, name, beside(k), color=style.notch_colour(k), label=label)
    for k, (place, label) in enumerate(((0, "y = 7"), (2, "12.25"), (4, "17.5 mm"))):
        draw_means(path, known, MESHES, at(place), beside(k), is_scatter=True, color=style.notch_colour(k), label=label)
    draw_means(speed, known, MESHES, itemgetter("leader's speed"), beside(0), color=style.notch_colour(0))
    for k, moment in enumerate(MOMENTS):
        draw_means(fringes, known, MESHES, rough(k), beside(k), color=style.notch_colour(k), label=f"t₀ + {moment} µs" if moment else "t₀")
    for axes, label in ((shares, "% of samples"), (path, "leading path z, scatter [mm]"), (speed, "leader's speed [m/s]"),
                        (fringes, "roughness of the fringes' order")):
        axes.set(xlabel="spacing [mm]", ylabel=label, xlim=(0, 1))
    for axes in (speed, fringes):
        axes.set_ylim(bottom=0)
    for axes in (shares, path, fringes):
        put_legend(axes)
    return figure


@dataclass(frozen=True)
class Study:
    points: tuple[Point, ...]
    columns: dict[str, Callable[[Point, dict[str, Any]], str]]
    draw: Callable[[Known], Figure]
    title: str

    def table(self, known: Known) -> str:
        return markdown(self.columns, [[cell(point, known[point]) for cell in self.columns.values()] for point in self.points if point in known])


DISTANCES = tuple(replace(BASE, distance=distance) for distance in (3, 6, 10, 15))
DEPTHS = tuple(replace(BASE, depth=depth) for depth in (2.5, 3.3, 4.5))
BY_SPEED = tuple(replace(BASE, toughness=toughness) for toughness in TOUGHNESSES)
AT_ONCE = tuple(replace(point, release="immediate") for point in BY_SPEED)
MESHES = tuple(replace(BASE, spacing=spacing) for spacing in (0.9, 0.6, 0.4, 0.3))
STUDIES = {
    "two-cracks": Study(tuple(dict.fromkeys(DISTANCES + DEPTHS + BY_SPEED)), PLATE | TOUGHNESS | ONSET | TWO, draw_two_cracks, "One crack or two"),
    "forks": Study(BY_SPEED + AT_ONCE, RELEASE | TOUGHNESS | ONSET | FORKS | SPEED, draw_forks, "What makes cracks fork"),
    "mesh": Study(MESHES, SPACING | ONSET | TWO | FORKS | SPEED | SETTLING, draw_mesh, "Does it settle with the mesh"),
}
NOTE = f"""Surplus: the square of the load at the onset over that at which sharp cracks as deep as the slots hold the toughness, by the energies of
slots {SHARP:g} mm high that are {DEEPER:g} mm shallower and deeper. With both releases the strength of 35 MPa counts alike: where no crack is near, for
means around nodes. Otherwise notches are {BASE.distance:g} mm apart and {BASE.depth:g} mm deep, the toughness is {BASE.toughness:g} J/m², the spacing {BASE.spacing:g} mm.
Forks seen through the plate: of any length, open squares. Brackets and bars: 95 % intervals; ±, and bars of paths: standard deviations.

"""
POINTS = {point.name: point for study in STUDIES.values() for point in study.points}


def shown(known: Known) -> dict[str, Study]:
    """The studies of which a point is known."""
    return {name: study for name, study in STUDIES.items() if any(point in known for point in study.points)}


def page(known: Known) -> str:
    """The part of the page: pictures and tables."""
    return NOTE + "\n".join(f"![{study.title}]({name}.png)\n\n{study.table(known)}" for name, study in shown(known).items())


# The command

def is_enough(point: Point, found: dict[str, Any] | None, n_samples: int) -> bool:
    return found is not None and found["input"] == checksum(point) and found["samples"] + found["failed"] >= n_samples


def has_frames(ensemble: crackle.Ensemble) -> bool:
    return bool(tomllib.loads(ensemble.input).get("output", {}).get("frames", 0))


def kept_elsewhere(point: Point, folders: Iterable[Path], n_samples: int) -> crackle.Ensemble | None:
    """The ensemble that has the point's input, and so many samples."""
    return next((ensemble for ensemble in map(crackle.open, folders)
                 if meaning(ensemble.input) == meaning(point.text) and (ensemble.samples.status.isin(["done", "failed"])).sum() >= n_samples
                 and has_frames(ensemble) >= (point in STUDIES["mesh"].points)), None)


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
