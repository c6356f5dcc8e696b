# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures in one line: each method draws into `axes`, or into a new figure, and returns the axes.

Units fit the values; axes that are given keep the unit which their label names.
"""
from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Iterable, Optional

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from . import units
from .files import naming, open_hdf5
from .units import MM, NEWTON, US, Unit

if TYPE_CHECKING:
    from .ensemble import Ensemble


class Plots:
    """`ensemble.plot.load()` and so on."""

    def __init__(self, ensemble: "Ensemble") -> None:
        self._ensemble = ensemble

    def histogram(self, result: str, bins: int | str = "auto", axes: Optional[Axes] = None) -> Axes:
        """How a result, a column of `samples`, is distributed."""
        table = self._ensemble.samples
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
        """The crack lines of samples (all that are done) in the plane of the plate."""
        axes = _axes(axes)
        lines = [line for number in self._chosen(samples) for line in self._ensemble[number].crack_lines]
        lengths = _unit(axes.get_xlabel(), [line[["y", "z"]].abs().max().max() for line in lines], MM)
        for line in lines:
            axes.plot(lengths.of(line["y"]), lengths.of(line["z"]), color=f"C{line.attrs['notch']}", linewidth=0.8, alpha=0.6)
        axes.set_aspect("equal")
        axes.set_xlabel(lengths.label("y"))
        axes.set_ylabel(lengths.label("z"))
        return axes

    def load(self, samples: Optional[Iterable[int]] = None, over: str = "displacement", axes: Optional[Axes] = None) -> Axes:
        """Load over the displacement where it acts, or with over = "time" over the time of the load's programs."""
        if over not in ("displacement", "time"):
            raise ValueError(f"over = {over!r}: give \"displacement\" or \"time\"")
        axes = _axes(axes)
        name, usual, least = ("governing_displacement", MM, 1e-3) if over == "displacement" else ("time", units.named("s"), 1e-4)
        histories = {number: self._ensemble[number].history for number in self._chosen(samples)}
        loads = _unit(axes.get_ylabel(), [_largest(history["governing_load"]) for history in histories.values()], NEWTON)
        unit = _unit(axes.get_xlabel(), [_largest(history[name]) for history in histories.values()], usual, least)
        for number, history in histories.items():
            axes.plot(unit.of(history[name]), loads.of(history["governing_load"]), linewidth=0.9, label=f"sample {number}")
        axes.set_xlabel(unit.label(over))
        axes.set_ylabel(loads.label("load"))
        return axes

    def crack_length(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """Length of the cracks over the time since the last dynamic phase began."""
        return self._over_time("crack_length", MM, samples, axes)

    def tip_speed(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """Speed of the crack tips over the time since the last dynamic phase began, with the Rayleigh speed."""
        axes = self._over_time("tip_speed", Unit("m/s", 1), samples, axes)
        for number in self._ensemble.done[:1]:
            axes.axhline(self._ensemble[number].history.attrs["rayleigh_speed"], color="C3", linewidth=0.8)
        return axes

    def _chosen(self, samples: Optional[Iterable[int]]) -> list[int]:
        return list(samples) if samples is not None else self._ensemble.done

    def _over_time(self, name: str, usual: Unit, samples: Optional[Iterable[int]], axes: Optional[Axes]) -> Axes:
        axes = _axes(axes)
        phases = {number: _last_phase(self._ensemble[number].history) for number in self._chosen(samples)}
        times = _unit(axes.get_xlabel(), [_largest(last["phase_time"]) for last in phases.values()], US)
        unit = _unit(axes.get_ylabel(), [_largest(last[name]) for last in phases.values()], usual)
        for number, last in phases.items():
            for notch in range(last.sizes["notch"]):
                axes.plot(times.of(last["phase_time"]), unit.of(last[name].isel(notch=notch)), color=f"C{notch}", linewidth=0.9,
                          label=f"sample {number}, start {notch}")
        axes.set_xlabel(times.label("time since onset"))
        axes.set_ylabel(unit.label(name.replace("_", " ")))
        return axes


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


def _unit(label: str, values: Any, usual: Unit, least: float = 0.1) -> Unit:
    """Of an axis with this label, empty when it is new."""
    return units.of_label(label) or units.fitting(values, usual, least)


def _largest(values: xr.DataArray) -> float:
    return float(np.nan_to_num(np.abs(values.values)).max(initial=0.0))


def _last_phase(history: xr.Dataset) -> xr.Dataset:
    return history.isel(moment=np.flatnonzero((history["phase"] == history["phase"].max()) & (history["phase"] > 0)))


def _axes(axes: Optional[Axes]) -> Axes:
    return axes if axes is not None else plt.subplots(layout="constrained")[1]
