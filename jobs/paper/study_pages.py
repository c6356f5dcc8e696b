# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables and pictures of the paper's studies."""
from __future__ import annotations

import math
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from typing import Any, Callable, Iterable, Sequence

import numpy as np
from crackle_report import style
from crackle_runs import markdown
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator
from scipy import stats

from shares import CONFIDENCE, share_in_percent, share_text
from study_points import AT_ONCE, BASE, BY_SPEED, DEEPER, DEPTHS, DISTANCES, MESHES, SHARP, Point
from threshold import threshold

MOMENTS = (0, 40)  # at which fringes are compared, since the onset [µs]
TICKS = (1, 1.5, 2, 3, 4)  # of the surplus
PAPERS_FORKS = (4, 8)  # of the samples that it shows
ENOUGH = 3  # points for a share to be fitted
HALF = (10**6, 2 * 10**6)  # so many that the share has no error of its own

Found = dict[str, Any]
"""What was found at a point: counts of samples; [mean, standard deviation, number] of other results, in SI units."""
Known = dict[Point, Found]


# Tables

def share(found: Found, name: str) -> tuple[float, float, float]:
    """Share of the samples and its interval [%]."""
    return share_in_percent(found[name], found["samples"])


def share_of(name: str) -> Callable[[Point, Found], str]:
    return lambda _, found: share_text(found[name], found["samples"])


def spread(name: str, form: str, unit: str = "") -> Callable[[Point, Found], str]:
    return lambda _, found: f"{found[name][0]:{form}} ± {found[name][1]:{form}}{unit}" if found.get(name) else "–"


def surplus(found: Found) -> float:
    return (found["onset"][0] / found["sharp load"]) ** 2


def path_text(_: Point, found: Found) -> str:
    return ", ".join(f"{1e3 * place[0]:.1f} ± {1e3 * place[1]:.1f}" if place else "–" for place in found["leading path"][::2]) + " mm"


def roughness_text(_: Point, found: Found) -> str:
    start, later = found["roughness"]
    return f"{later[0] / start[0]:.1f}" if start and later else "–"


PLATE = {"apart": lambda point, _: f"{point.distance:g} mm", "deep": lambda point, _: f"{point.depth:g} mm"}
TOUGHNESS = {"toughness": lambda point, _: f"{point.toughness:g} J/m²"}
RELEASE = {"release": lambda point, _: "immediate" if point.release == "immediate" else "780 m/s"}
SPACING = {"spacing": lambda point, _: f"{point.spacing:g} mm"}
ONSET = {"samples": lambda _, found: str(found["samples"]), "onset": spread("onset", ".0f", " N"), "surplus": lambda _, found: f"{surplus(found):.2f}"}
TWO = {"two cracks": share_of("two cracks")}
FORKS = {"forks, branches from 2 mm": share_of("long forks in space"), "seen through the plate": share_of("forks")}
SPEED = {"largest speed / c_R": spread("largest speed over c_R", ".2f")}
SETTLING = {"leading path, y = 7, 12.25, 17.5 mm": path_text, "leader's speed": spread("leader's speed", ".0f", " m/s"),
            "roughness of the fringes at t₀ + 40 µs over that at t₀": roughness_text}


def found_at(known: Known, points: Iterable[Point], name: str, of: Callable[[Point], float], seen: tuple[int, int], form: str) -> str:
    """At which value of the points a share of the samples is as `seen`; the share grows with the surplus."""
    there = [point for point in points if point in known]
    values, counts, numbers = zip(*((of(point), known[point][name], known[point]["samples"]) for point in there))
    if counts == numbers:
        return f"less than {min(values):{form}}"
    if not any(counts):
        return f"more than {max(values):{form}}"
    value, (low, high) = threshold(values, counts, numbers, seen)
    return f"{value:{form}} ({low:{form}} to {high:{form}})"


def forks_text(known: Known) -> str:
    """Where the fitted shares of forks pass a half, and that of the paper's pictures; nothing before enough points are known."""
    if any(sum(point in known for point in points) < ENOUGH for points in (BY_SPEED, AT_ONCE)):
        return ""
    halves = [found_at(known, points, "long forks in space", surplus_in(known), HALF, ".2f") for points in (BY_SPEED, AT_ONCE)]
    toughness = found_at(known, BY_SPEED, "forks", attrgetter("toughness"), PAPERS_FORKS, ".0f")
    return (f"By logistic regression over the logarithms, half of the samples have forks with branches from 2 mm at a surplus of {halves[0]} with release\n"
            f"by speed, of {halves[1]} with immediate release; forks are seen through the plate as often as in the paper's pictures,\n"
            f"{PAPERS_FORKS[0]} of {PAPERS_FORKS[1]}, at {toughness} J/m² with release by speed; the interval counts how few these pictures are.\n")


# Pictures

def draw_shares(axes: Axes, known: Known, points: Iterable[Point], name: str, of: Callable[[Point], float], **style_of: Any) -> None:
    """Shares with their intervals, over a value of the points."""
    there = sorted((point for point in points if point in known), key=of)
    if not there:
        return
    values, low, high = np.array([share(known[point], name) for point in there]).T
    axes.errorbar([of(point) for point in there], values, (values - low, high - values), **{"fmt": "o-", "ms": 4, "lw": 1, "capsize": 2} | style_of)
    axes.set_ylim(-3, 103)


def draw_means(axes: Axes, known: Known, points: Iterable[Point], values: Callable[[Found], list[float]], of: Callable[[Point], float],
               is_scatter: bool = False, **style_of: Any) -> None:
    """Means with Student's intervals, or with standard deviations."""
    there = sorted((point for point in points if point in known and values(known[point])), key=of)
    if not there:
        return
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
    def at(place: int) -> Callable[[Found], list[float]]:
        return lambda found: [1e3 * value for value in found["leading path"][place][:2]] + found["leading path"][place][2:]

    def rough(place: int) -> Callable[[Found], list[float]]:
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
    columns: dict[str, Callable[[Point, Found], str]]
    draw: Callable[[Known], Figure]
    title: str
    text: Callable[[Known], str] | None = None

    def table(self, known: Known) -> str:
        """And what follows from it."""
        text = self.text(known) if self.text else ""
        return text + ("\n" if text else "") + markdown(self.columns, [[cell(point, known[point]) for cell in self.columns.values()] for point in self.points if point in known])


STUDIES = {
    "two-cracks": Study(tuple(dict.fromkeys(DISTANCES + DEPTHS + BY_SPEED)), PLATE | TOUGHNESS | ONSET | TWO, draw_two_cracks, "One crack or two"),
    "forks": Study(BY_SPEED + AT_ONCE, RELEASE | TOUGHNESS | ONSET | FORKS | SPEED, draw_forks, "What makes cracks fork", forks_text),
    "mesh": Study(MESHES, SPACING | ONSET | TWO | FORKS | SPEED | SETTLING, draw_mesh, "Does it settle with the mesh"),
}
NOTE = f"""Surplus: (load at the onset / Griffith's load of sharp cracks as deep as the slots)²; that load from the strain energies of slots {SHARP:g} mm high
that are {DEEPER:g} mm shallower and deeper. With both releases the strength of 35 MPa counts alike: where no crack is near, for
means around nodes. Otherwise notches are {BASE.distance:g} mm apart and {BASE.depth:g} mm deep, the toughness is {BASE.toughness:g} J/m², the spacing {BASE.spacing:g} mm.
Forks seen through the plate: of any length, open squares. Brackets and bars: 95 % intervals; ±, and bars of paths: standard deviations.

"""
POINTS = {point.name: point for study in STUDIES.values() for point in study.points}


def shown(known: Known) -> dict[str, Study]:
    """The studies of which more than one point is known."""
    return {name: study for name, study in STUDIES.items() if sum(point in known for point in study.points) > 1}


def page(known: Known) -> str:
    """The part of the page: pictures and tables."""
    return NOTE + "\n".join(f"![{study.title}]({name}.png)\n\n{study.table(known)}" for name, study in shown(known).items())


