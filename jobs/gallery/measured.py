# SPDX-License-Identifier: GPL-3.0-or-later
"""The problems of the gallery that are held against experiments."""
from __future__ import annotations

import math
from typing import Any, Callable

import numpy as np

from crackle import Ensemble, weibull
from crackle_report.style import MILLIMETRE
from problems import BAR_ARM, BAR_HEIGHT, BAR_WIDTH, Figure, Problem, always

MEASURED, RANDOM = "semicircular-bend.toml", """
[[random]]
key = "material.poisson_ratio"
distribution = "uniform"
lower = 0.33
upper = 0.43
[[random]]                    # the load and both supports are moved as they are
key = ["boundary[2].region.y[0]", "boundary[2].region.y[1]", "boundary[3].region.y[0]", "boundary[3].region.y[1]"]
distribution = "uniform"
lower = "46.5 mm"
upper = "50.5 mm"
[[random]]
key = ["boundary[0].region.y[0]", "boundary[0].region.y[1]"]
distribution = "uniform"
lower = "25.5 mm"
upper = "29.5 mm"
[[random]]
key = ["boundary[1].region.y[0]", "boundary[1].region.y[1]"]
distribution = "uniform"
lower = "68.5 mm"
upper = "72.5 mm"
"""
MIDDLE, HALF_WIDTH = 50 * MILLIMETRE, {"load": 1.5 * MILLIMETRE, "support": 1 * MILLIMETRE}
DRAWN = {"Poisson's ratio": ("material.poisson_ratio", 0, 1),  # its key, and what is taken off before it is divided
         "place of the load": ("boundary[2].region.y[0]", MIDDLE - HALF_WIDTH["load"], MILLIMETRE),
         "place of the left support": ("boundary[0].region.y[0]", MIDDLE - HALF_WIDTH["support"], MILLIMETRE),
         "place of the right support": ("boundary[1].region.y[0]", MIDDLE - HALF_WIDTH["support"], MILLIMETRE)}


def measured(problem: str) -> Problem:
    return PROBLEMS[problem]


def _path_figures(problem: str) -> tuple[Figure, ...]:
    """What the match says about the one path of the experiments."""
    def of_row(form: Callable[[Any], str]) -> Callable[[Ensemble], str]:
        return lambda ensemble: form(ensemble.match(measured(problem).experiments_file).experiments.xs("path", level=1).iloc[0])
    return (Figure("p of the measured path among the samples", of_row(lambda row: f"{row.p_value:.3f}"), always("above 0.05")),
            Figure("its offset from their mean, along the path", of_row(lambda row: f"{row.offset / MILLIMETRE:.2f} mm"),
                   of_row(lambda row: f"0, with a standard deviation of {row.standard_deviation / MILLIMETRE:.2f} mm")))


def _places(origin: float) -> Callable[[Ensemble], str]:
    """Where the cracks are on average at the sections."""
    def find(ensemble: Ensemble) -> str:
        y = (np.nanmean(ensemble.paths.position.values[:, 0], axis=0) - origin) / MILLIMETRE
        return ", ".join(f"{one:.1f}" for one in y) + " mm"
    return find


def _posterior(name: str) -> Callable[[Ensemble], str]:
    def find(ensemble: Ensemble) -> str:
        key, origin, unit = DRAWN[name]
        row = ensemble.calibrate(measured("semicircular-bend-calibrated").experiments_file).inputs.loc[key]
        mean, low, high = ((row[f"posterior_{end}"] - origin) / unit for end in ("mean", "lower", "upper"))
        return f"{mean:.3g} ({low:.3g} to {high:.3g})" + (" mm" if unit != 1 else "")
    return find


def _explained(ensemble: Ensemble) -> str:
    checks = ensemble.calibrate(measured("semicircular-bend-calibrated").experiments_file).document["checks"]
    return f"{checks['distance']['p_value']:.2f}"


def _strengths(ensemble: Ensemble, size: float = 1) -> weibull.Weibull:
    """Weibull's distribution of the samples' strengths in bending [MPa]."""
    loads = ensemble.samples.peak_load.to_numpy()
    found = weibull.fit(loads[np.isfinite(loads)] * 3 * BAR_ARM / (BAR_WIDTH * BAR_HEIGHT ** 2) / size ** 2 * 1e-6, np.array([0.5]))
    assert found is not None
    return found


def _modulus(ensemble: Ensemble) -> str:
    found = _strengths(ensemble)
    return f"{found.modulus:.1f} ({found.lower:.1f} to {found.upper:.1f})"


def _scale(size: float) -> Callable[[Ensemble], str]:
    def find(ensemble: Ensemble) -> str:
        found = _strengths(ensemble, size)
        half = 1.96 * 1.05 / found.modulus / math.sqrt(len(ensemble.done))  # of the logarithm, for many samples
        return f"{found.scale:.0f} MPa ({found.scale * math.exp(-half):.0f} to {found.scale * math.exp(half):.0f})"
    return find


def _together(ensemble: Ensemble) -> str:
    return f"{ensemble.match(measured('alumina-bars').experiments_file).document['set']['p_value']:.2f}"


MODULUS, STRENGTH, SMALL = 11.8, 856, 0.5  # of such bars, and the size of smaller ones
_ALUMINA = {"ensemble.samples": "60", "fracture.strength": '"1041 MPa"', "fracture.toughness": '"42 J/m^2"',
            "fracture.variation.modulus": f"{MODULUS}",
            "fracture.variation.correlation_length": None, "fracture.variation.reference_volume": '"1 mm^3"',
            "mesh.spacing": '"0.6 mm"', "mesh.region.spacing": '"0.4 mm"', "time.after_separation": '"0.1 us"'}
_FEW_BARS = {"ensemble.samples": "4", "mesh.spacing": '"1.2 mm"', "mesh.region.spacing": '"0.8 mm"'}
_FEW_PLATES = {"ensemble.samples": "4", "mesh.spacing": '"3 mm"', "mesh.notch_spacing": '"1.5 mm"', "mesh.region.spacing": '"2 mm"'}

PROBLEMS = {
    "slotted-hole": Problem("gallery/slotted-hole.toml", (
        Figure("y at z = 20, 30, 40, 50, 60 mm", _places(0), always("31.3, 31.2, 30.4, 28.0, 22.9 mm")),
        *_path_figures("slotted-hole")), {}, {"ensemble.samples": "4"}, experiments="slotted-hole.toml"),
    "semicircular-bend": Problem("gallery/semicircular-bend.toml", (
        Figure("from the middle at z = 15, 20, 25, 30, 35, 40 mm", _places(MIDDLE),
               always("6.2, 3.1, 1.3, 0.5, 0.1, −0.2 mm photographed; 6.3, 4.0, 2.6, 2.0, 1.5, 1.1 mm computed by its authors")),
        *_path_figures("semicircular-bend")), {}, _FEW_PLATES, experiments=MEASURED, picture="experiment-0-path"),
    "semicircular-bend-calibrated": Problem("gallery/semicircular-bend.toml", (
        *(Figure(name, _posterior(name), always(prior)) for name, prior in zip(DRAWN, (
            "0.33 to 0.43", "−2 to 2 mm, 0 as given", "−23.5 to −19.5 mm, −21.5 as given", "19.5 to 23.5 mm, 21.5 as given"))),
        Figure("p of the photographed path with any inputs", _explained, always("above 0.05"))),
        {"ensemble.samples": "64", "ensemble.seed": "31", "ensemble.plan": '"sobol"'}, _FEW_PLATES | {"ensemble.samples": "16"}, RANDOM,
        experiments=MEASURED, picture="posterior"),
    "alumina-bars": Problem("gallery/bend-bar.toml", (
        Figure("Weibull modulus of the strengths", _modulus, always(f"{MODULUS}")),
        Figure("their scale", _scale(1), always(f"{STRENGTH} MPa")),
        Figure("p of the 15 strengths", _together, always("above 0.05"))),
        _ALUMINA, _FEW_BARS, experiments="alumina-bars.toml", picture="experiments-peak-load"),
    "small-alumina-bars": Problem("gallery/bend-bar.toml", (
        Figure("scale for bars of half the size", _scale(SMALL), always(f"{STRENGTH * SMALL ** (-3 / MODULUS):.0f} MPa")),),
        _ALUMINA, _FEW_BARS, size=SMALL),
}
