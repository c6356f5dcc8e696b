# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of `crackle run` in Python: tables of pandas, labelled arrays of xarray, and pictures in one line.

    import crackle

    plates = crackle.open("out/demo")
    plates.samples["onset_force"].describe()      # one row for each sample
    plates.paths.position.mean("sample")          # crack positions: sample x notch x section
    plates.histories.governing_load               # load over time: sample x moment
    plates[3].frames.displacement                 # one sample: frame x node x component
    plates.plot.load().figure.savefig("load.png")

All values are in SI units; `attrs["units"]` and `attrs["meaning"]` of each array, and `samples.attrs["units"]`, say which.
Works on an ensemble that is still running, too. What cannot be read raises crackle.ResultsError.
"""
from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .files import ResultsError

if TYPE_CHECKING:
    from .ensemble import Ensemble, open
    from .plots import plot_mesh
    from .sample import Sample

__all__ = ["Ensemble", "ResultsError", "Sample", "open", "plot_mesh"]
__version__ = "1.1.0"
_PLACES = {"Ensemble": "ensemble", "open": "ensemble", "plot_mesh": "plots", "Sample": "sample"}


def __getattr__(name: str) -> Any:
    """The report opens its files here too, and does without pandas and xarray, which take long to load."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{_PLACES[name]}", __name__), name)


def __dir__() -> list[str]:
    return [*globals(), *__all__]
