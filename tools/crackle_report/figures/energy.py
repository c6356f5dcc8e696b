# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the energy goes while the cracks run, for the samples shown in detail."""
from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from crackle.units import MILLIJOULE, Unit, fitting

from .. import style
from ..choosing import samples_in_detail
from ..drawing import draw_grid
from ..options import Options
from ..fields import Energy
from ..results import Ensemble
from .picture import Picture, Section

# Name, colour and line of each share; "work" is the sum of all others.
LINES = (("external", "work of the load", "black", "-"), ("strain", "strain", "#0072b2", "-"),
         ("kinetic", "kinetic", "#d55e00", "--"), ("released", "released by breaking", "#009e73", "-."),
         ("dissipated", "dissipated", "#cc79a7", ":"))


def section(ensemble: Ensemble, options: Options) -> Section | None:
    histories = {i: ensemble.files.energy(i) for i in options.samples or samples_in_detail(ensemble)}
    histories = {i: energy for i, energy in histories.items() if energy is not None and energy.time.size > 1}
    if not histories:
        return None
    result = Section(
        "Energy",
        "The energy account of the samples shown in detail over the last dynamic phase. Work of the load = "
        "strain + kinetic + released + dissipated, each counted from the unloaded body. Dissipated energy is the kinetic "
        "energy left by arrested phases and static breaks, and the energy removed by damping and absorbing faces. A force that stays "
        "pulls the halves apart after the break, and its work goes on growing; the work of fracture in the table ends at separation.")
    result.pictures.append(Picture("energy", f"Energy over time of samples {', '.join(map(str, histories))}",
                                   _draw(histories, ensemble.times)))
    return result


def _draw(histories: dict[int, Energy], times: Unit) -> Figure:
    energies = fitting([energy.external.max() for energy in histories.values()], MILLIJOULE)
    n_columns = min(len(histories), 3)
    n_rows = -(-len(histories) // n_columns)
    height = 0.4 + 2.6 * n_rows
    figure = Figure(figsize=(style.PAGE_WIDTH, height), layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 1 - 0.3 / height))  # below the legend
    grid = figure.subplots(n_rows, n_columns, squeeze=False)
    for axes in grid.flat[len(histories):]:
        axes.set_visible(False)
    for axes, (number, energy) in zip(grid.flat, histories.items()):
        _panel(axes, energy, times, energies)
        axes.set_title(f"sample {number}", loc="left", fontweight="bold")
    for axes in grid[:, 0]:
        axes.set_ylabel(energies.label("energy"))
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="upper left", ncol=len(LINES))
    return figure


def _panel(axes: Axes, energy: Energy, times: Unit, energies: Unit) -> None:
    time = times.of(energy.time)
    for name, label, colour, line in LINES:
        axes.plot(time, energies.of(getattr(energy, name)), color=colour, linestyle=line, linewidth=1.2, label=label)
    axes.set_xlim(0, time[-1])
    axes.set_ylim(bottom=0)
    axes.set_xlabel(times.label("time since onset"))
    draw_grid(axes)
