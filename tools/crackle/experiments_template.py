# SPDX-License-Identifier: GPL-3.0-or-later
"""The experiments file of `crackle init FILE --from-ensemble FOLDER`."""
from __future__ import annotations

import math

import numpy as np

from .experiments import explained_keys
from .observations import ObservedSamples


def _place(point: np.ndarray) -> str:
    return f"y = {1e3 * point[0]:.4g} mm, z = {1e3 * point[1]:.4g} mm"


def _body(samples: ObservedSamples) -> str:
    """Its bounds and crack starts, by which an experiment is placed in it."""
    lines = [f"# The body goes from {_place(samples.lower)} to {_place(samples.upper)}."]
    for start in samples.starts:
        if start.is_straight:
            lines.append(f"# Cracks start from {start.name} at {_place(start.tip)}.")
        elif not start.is_free_surface:
            lines.append(f"# Cracks start from the walls of {start.name}, from {_place(start.slot[0])} to {_place(start.slot[1])}.")
    if samples.document["sections"]:
        lines.append(f"# Sections: {'; '.join(samples.document['sections'])}.")
    return "\n".join(lines) + "\n"


def _loads(samples: ObservedSamples) -> str:
    lines = []
    # The onset is not what a test would record where the load was higher before.
    for name in ("peak_load",) if samples.document["headline_load"] == "peak_load" else ("onset_load", "peak_load"):
        loads = np.array([getattr(one, name) for one in samples.samples if not one.is_unbroken and not math.isnan(getattr(one, name))])
        if loads.size:
            lines.append(f'{name} = "{np.median(loads):.4g} N"    # made up: the median of {loads.size} samples, {loads.min():.4g} to {loads.max():.4g} N\n')
    return "".join(lines) or 'peak_load = "100 N"    # made up\n'


def template(samples: ObservedSamples, folder: str) -> str:
    """All keys explained, with values of this ensemble."""
    return f"""\
# Experiments for  crackle match {folder} THIS-FILE
# Lengths, loads and times are strings with their units. File names are relative to this file.
{_body(samples)}
# Nothing but loads? Then this line is enough, with a file of one column peak_load_N:
#loads = "loads.csv"

[[experiment]]
name = "specimen 1"
{_loads(samples)}{explained_keys(("name", "onset_load", "peak_load", "loads", "load_per_strength"))}
# Places of the crack's tip at some times, each in a table of its own:
#[[experiment.tip]]
#time = "40 us"
#at = ["12.25 mm", "70 mm"]

# Photographs, for the report:
#[[experiment.picture]]
#file = "frame-40.png"
#time = "40 us"
#scale = "0.05 mm"    # of a pixel
#origin = [120, 480]   # pixels from the left and the top to the experiment's origin
"""
