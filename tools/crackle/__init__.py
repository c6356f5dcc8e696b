# SPDX-License-Identifier: GPL-3.0-or-later
"""The results of `crackle run` in Python: tables of pandas, labelled arrays of xarray, and pictures in one line.

    import crackle

    plates = crackle.open("out/demo")
    plates.samples["onset_force"].describe()      # one row for each sample
    plates.paths.position.mean("sample")          # crack positions: sample x notch x section
    plates.histories.governing_load               # load over time: sample x moment
    plates[3].frames.displacement                 # one sample: frame x node x component
    plates[3].frames.stress.sel(time=60e-6, method="nearest")
    plates.plot.load().figure.savefig("load.png")

All values are in SI units; `attrs["units"]` and `attrs["meaning"]` of each array, and `samples.attrs["units"]`, say which.
Works on an ensemble that is still running, too. What cannot be read raises crackle.ResultsError.
"""
from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any


def _with_advice(error: ModuleNotFoundError) -> ModuleNotFoundError:
    """Says what to install where a package of others is missing."""
    if not error.name or error.name.startswith(__name__):
        return error
    source = Path(__file__).resolve().parents[1]
    what = f"'{source}'" if (source / "pyproject.toml").is_file() else error.name
    return ModuleNotFoundError(f"crackle needs the Python package {error.name}, which {sys.executable} does not have; install it with "
                               f"'{sys.executable}' -m pip install {what}", name=error.name)


try:
    from .files import ResultsError
except ModuleNotFoundError as missing:
    raise _with_advice(missing) from None

if TYPE_CHECKING:
    from .comparison import compare
    from .ensemble import Ensemble, open
    from .plots import plot_mesh
    from .sample import Sample

__all__ = ["Ensemble", "ResultsError", "Sample", "compare", "open", "plot_mesh"]
__version__ = "2.0.0"
_PLACES = {"Ensemble": "ensemble", "compare": "comparison", "open": "ensemble", "plot_mesh": "plots", "Sample": "sample"}


def __getattr__(name: str) -> Any:
    """The report opens its files here too, and does without pandas and xarray, which take long to load."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        return getattr(importlib.import_module(f".{_PLACES[name]}", __name__), name)
    except ModuleNotFoundError as missing:
        raise _with_advice(missing) from None


def __dir__() -> list[str]:
    return [*globals(), *__all__]
