# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures in one line: each method draws into `axes`, or into a new figure, and returns the axes.

Units fit the values; axes that are given keep the unit which their label names.
"""
from __future__ import annotations

import difflib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterable, Optional

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from . import units
from .curves import load_limits
from .files import naming, open_hdf5
from .units import MM, NEWTON, US, Unit

if TYPE_CHECKING:
    import pandas as pd
    from crackle_report.plate import Plate

MOST_NAMED = 10  # lines that have colours and names of their own


class Plots:
    """`ensemble.plot.load()` and so on."""

    def __init__(self, ensemble: Any) -> None:
        """@param ensemble: the Ensemble of which it is the `plot`"""
        self._ensemble = ensemble

    def histogram(self, result: str, bins: int | str = "auto", axes: Optional[Axes] = None) -> Axes:
        """How a result, a column of `samples`, is distributed. Raises KeyError with the names that there are."""
        table = self._ensemble.samples
        if result not in table:
            near = difflib.get_close_matches(str(result), table.columns, n=3, cutoff=0.5)
            raise KeyError(f"no result is named {result!r}; {'did you mean ' + ' or '.join(near) + '? ' if near else ''}"
                           f"There are {', '.join(table.columns)}")
        values = table.loc[self._ensemble.done, result].dropna()
        axes = _axes(axes)
        name = table.attrs["units"].get(result, "")
        unit = units.named(name)
        if unit is None:
            unit = Unit(name if name != "1" else "", 1)
        else:
            unit = _unit(axes.get_xlabel(), values, unit)
            values = unit.of(values)
        axes.hist(values, bins=bins)
        axes.set_xlabel(unit.label(result.replace("_", " ")))
        axes.set_ylabel("samples")
        return axes

    def cracks(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """The crack lines of samples (all that are done) in the plane of the plate, with the body's outline round them."""
        axes = _axes(axes)
        chosen = self._chosen(samples)
        lines = [line for number in chosen for line in self._ensemble[number].crack_lines]
        lengths = _unit(axes.get_xlabel(), [line[["y", "z"]].abs().max().max() for line in lines], MM)
        if chosen:
            plate, regions = self._ensemble[chosen[0]].plate, self._ensemble[chosen[0]].regions
            for polygon in plate.polygons:
                axes.plot(*lengths.of(np.vstack([polygon, polygon[:1]])).T, color="0.3", linewidth=0.8)
            for border in plate.pre_cracks:
                axes.plot(*lengths.of(border).T, color="0.3", linewidth=1.2)
            if regions is not None:
                axes.add_collection(LineCollection(lengths.of(regions.borders), colors="0.6", linewidths=0.8), autolim=False)
            _window(axes, plate, lines, lengths)
        for line in lines:
            notch = line.attrs["notch"]
            axes.plot(lengths.of(line["y"]), lengths.of(line["z"]), color=f"C{notch}", linewidth=0.8, alpha=0.6,
                      label=f"from {plate.name_of(notch)}" if notch >= 0 else None)
        axes.set_aspect("equal")
        axes.set_xlabel(lengths.label("y"))
        axes.set_ylabel(lengths.label("z"))
        return _with_legend(axes)

    def load(self, samples: Optional[Iterable[int]] = None, over: str = "displacement", axes: Optional[Axes] = None) -> Axes:
        """Load over the displacement where it acts, up to a little beyond the peaks, or with over = "time" over the time of the
        load's programs."""
        if over not in ("displacement", "time"):
            raise ValueError(f"over = {over!r}: give \"displacement\" or \"time\"")
        axes = _axes(axes)
        name, usual, least = ("governing_displacement", MM, 1e-3) if over == "displacement" else ("time", units.named("s"), 1e-4)
        histories = {number: self._ensemble[number].history for number in self._chosen(samples)}
        curves = {number: (history[name].values, history["governing_load"].values) for number, history in histories.items()}
        limits = load_limits((*curve, histories[number]["phase"].values) for number, curve in curves.items())
        loads = _unit(axes.get_ylabel(), limits[1], NEWTON)
        unit = _unit(axes.get_xlabel(), limits[0] if over == "displacement" else [_largest(x) for x, _ in curves.values()], usual, least)
        for k, (number, (x, load)) in enumerate(curves.items()):
            axes.plot(unit.of(x), loads.of(load), linewidth=0.9, **_of_sample(number, k, len(curves)))
        if over == "displacement":
            axes.set_xlim(*map(unit.of, limits[0]))
        axes.set_ylim(*map(loads.of, limits[1]))
        axes.set_xlabel(unit.label(over))
        axes.set_ylabel(loads.label("load"))
        return _with_legend(axes)

    def crack_length(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """Length of the cracks over the time since the last dynamic phase began, while they run."""
        return self._over_time("crack_length", MM, samples, axes)

    def tip_speed(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """Speed of the crack tips over the time since the last dynamic phase began, with the Rayleigh speed."""
        axes = _axes(axes)
        waves = {float(self._ensemble[number].history.attrs["rayleigh_speed"]) for number in self._chosen(samples)}
        if len(waves) == 1:  # of several materials each crack has its own
            axes.axhline(waves.pop(), color="0.3", linestyle="--", linewidth=0.8, label="Rayleigh speed")
        return self._over_time("tip_speed", Unit("m/s", 1), samples, axes)

    def _chosen(self, samples: Optional[Iterable[int]]) -> list[int]:
        return list(samples) if samples is not None else self._ensemble.done

    def _over_time(self, name: str, usual: Unit, samples: Optional[Iterable[int]], axes: Optional[Axes]) -> Axes:
        axes = _axes(axes)
        phases = {number: _last_phase(self._ensemble[number].history) for number in self._chosen(samples)}
        times = _unit(axes.get_xlabel(), [_largest(last["phase_time"]) for last in phases.values()], US)
        unit = _unit(axes.get_ylabel(), [_largest(last[name]) for last in phases.values()], usual)
        cracks = [(number, notch, last.isel(notch=notch)) for number, last in phases.items() for notch in range(last.sizes["notch"])]
        cracks = [crack for crack in cracks if crack[-1]["tip_speed"].notnull().any()]  # those that ran
        for k, (number, notch, last) in enumerate(cracks):
            start = self._ensemble[number].plate.name_of(notch)
            style = {"color": f"C{k}", "label": f"sample {number}, {start}"} if len(cracks) <= MOST_NAMED else {"color": f"C{notch}", "label": start}
            axes.plot(times.of(last["phase_time"]), unit.of(last[name]), linewidth=0.9, **style)
        ends = [float(last["phase_time"].where(last["tip_speed"].notnull()).max()) for *_, last in cracks]
        if ends and max(ends) > 0:
            axes.set_xlim(0, times.of(1.15 * max(ends)))
        axes.set_ylim(bottom=0)
        axes.set_xlabel(times.label("time since onset"))
        axes.set_ylabel(unit.label(name.replace("_", " ")))
        return _with_legend(axes)


def plot_mesh(file: str | Path, axes: Optional[Axes] = None) -> Axes:
    """The face x = 0 of a mesh that `crackle mesh` has written, coloured by the spacing that the input asks for, or where the
    material varies by the factor on the strength.

    Raises crackle.ResultsError when it is no such file.
    """
    with open_hdf5(Path(file)) as root, naming(Path(file)):
        mesh = root["VTKHDF"]
        nodes, corners = mesh["Points"][...], mesh["Connectivity"][...].reshape(-1, 4)
        on_face = nodes[corners, 0] == nodes[:, 0].min()
        with_triangle = np.flatnonzero(on_face.sum(axis=1) == 3)
        triangles = corners[with_triangle][on_face[with_triangle]].reshape(-1, 3)
        if "strength_factor" in mesh["CellData"]:
            name, shown = "strength over the input's", mesh["CellData/strength_factor"][...][with_triangle]
        else:
            name, shown = MM.label("spacing"), MM.of(mesh["PointData/spacing"][...])[triangles].mean(axis=1)
    axes = _axes(axes)
    picture = axes.tripcolor(*MM.of(nodes[:, 1:]).T, triangles, facecolors=shown, edgecolors="black", linewidth=0.1)
    axes.figure.colorbar(picture, ax=axes, label=name)
    axes.set(aspect="equal", xlabel=MM.label("y"), ylabel=MM.label("z"))
    return axes


def _of_sample(number: int, k: int, n: int) -> dict[str, Any]:
    """How the k-th of n samples is drawn; one among many is not told apart."""
    return {"color": f"C{k}", "label": f"sample {number}"} if n <= MOST_NAMED else {"color": "C0", "alpha": 0.5, "label": f"{n} samples"}


def _with_legend(axes: Axes) -> Axes:
    """Of what its lines are called, each name once."""
    named = {label: handle for handle, label in zip(*axes.get_legend_handles_labels())}
    if named:
        axes.legend(named.values(), named.keys(), fontsize="small")
    return axes


def _window(axes: Axes, plate: "Plate", lines: list[pd.DataFrame], lengths: Unit) -> None:
    """The body's width, and along it where the cracks are."""
    (left, right), (bottom, top) = plate.ends(1), plate.ends(2)
    z = np.concatenate([plate.slot_ends, *(line["z"] for line in lines)]) if lines else np.array([bottom, top])
    margin = 0.04 * (right - left)
    axes.set_xlim(lengths.of(left - margin), lengths.of(right + margin))
    axes.set_ylim(lengths.of(max(bottom, z.min() - 8 * margin) - margin), lengths.of(min(top, z.max() + 8 * margin) + margin))


def _unit(label: str, values: Any, usual: Unit, least: float = 0.1) -> Unit:
    """Of an axis with this label, empty when it is new."""
    return units.of_label(label) or units.fitting(values, usual, least)


def _largest(values: Any) -> float:
    return float(np.nan_to_num(np.abs(np.asarray(values))).max(initial=0.0))


def _last_phase(history: xr.Dataset) -> xr.Dataset:
    return history.isel(moment=np.flatnonzero((history["phase"] == history["phase"].max()) & (history["phase"] > 0)))


def _axes(axes: Optional[Axes]) -> Axes:
    return axes if axes is not None else plt.subplots(layout="constrained")[1]
