# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures in one line: each method draws into `axes`, or into a new figure, and returns the axes."""
from __future__ import annotations

from typing import TYPE_CHECKING, Iterable, Optional

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

if TYPE_CHECKING:
    from .ensemble import Ensemble

MILLIMETRE, MICROSECOND = 1e-3, 1e-6


class Plots:
    """`ensemble.plot.load()` and so on."""

    def __init__(self, ensemble: "Ensemble") -> None:
        self._ensemble = ensemble

    def histogram(self, result: str, bins: int | str = "auto", axes: Optional[Axes] = None) -> Axes:
        """How a result, a column of `samples`, is distributed."""
        table = self._ensemble.samples
        values = table.loc[self._ensemble.done, result].dropna()
        axes = _axes(axes)
        axes.hist(values, bins=bins)
        units = table.attrs["units"].get(result, "")
        axes.set_xlabel(f"{result.replace('_', ' ')}" + (f" [{units}]" if units not in ("", "1") else ""))
        axes.set_ylabel("samples")
        return axes

    def cracks(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """The crack lines of samples (all that are done) in the plane of the plate."""
        axes = _axes(axes)
        for number in samples if samples is not None else self._ensemble.done:
            for line in self._ensemble[number].crack_lines:
                axes.plot(line["y"] / MILLIMETRE, line["z"] / MILLIMETRE, color=f"C{line.attrs['notch']}", linewidth=0.8, alpha=0.6)
        axes.set_aspect("equal")
        axes.set_xlabel("y [mm]")
        axes.set_ylabel("z [mm]")
        return axes

    def load(self, samples: Optional[Iterable[int]] = None, over: str = "displacement", axes: Optional[Axes] = None) -> Axes:
        """Load over the displacement where it acts, or with over = "time" over the time of the load's programs."""
        if over not in ("displacement", "time"):
            raise ValueError(f"over = {over!r}: give \"displacement\" or \"time\"")
        axes = _axes(axes)
        for number in samples if samples is not None else self._ensemble.done:
            history = self._ensemble[number].history
            x = history["governing_displacement"] / MILLIMETRE if over == "displacement" else history["time"]
            axes.plot(x, history["governing_load"], linewidth=0.9, label=f"sample {number}")
        axes.set_xlabel("displacement [mm]" if over == "displacement" else "time [s]")
        axes.set_ylabel("load [N]")
        return axes

    def crack_length(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """Length of the cracks over the time since the last dynamic phase began."""
        return self._over_time("crack_length", "crack length [mm]", MILLIMETRE, samples, axes)

    def tip_speed(self, samples: Optional[Iterable[int]] = None, axes: Optional[Axes] = None) -> Axes:
        """Speed of the crack tips over the time since the last dynamic phase began, with the Rayleigh speed."""
        axes = self._over_time("tip_speed", "tip speed [m/s]", 1, samples, axes)
        for number in self._ensemble.done[:1]:
            axes.axhline(self._ensemble[number].history.attrs["rayleigh_speed"], color="C3", linewidth=0.8)
        return axes

    def _over_time(self, name: str, label: str, unit: float, samples: Optional[Iterable[int]], axes: Optional[Axes]) -> Axes:
        axes = _axes(axes)
        for number in samples if samples is not None else self._ensemble.done:
            history = self._ensemble[number].history
            last = history.isel(moment=np.flatnonzero((history["phase"] == history["phase"].max()) & (history["phase"] > 0)))
            for notch in range(last.sizes["notch"]):
                axes.plot(last["phase_time"] / MICROSECOND, last[name].isel(notch=notch) / unit, color=f"C{notch}", linewidth=0.9,
                          label=f"sample {number}, notch {notch}")
        axes.set_xlabel("time since onset [µs]")
        axes.set_ylabel(label)
        return axes


def _axes(axes: Optional[Axes]) -> Axes:
    return axes if axes is not None else plt.subplots(layout="constrained")[1]
