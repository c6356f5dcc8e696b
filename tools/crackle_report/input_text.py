# SPDX-License-Identifier: GPL-3.0-or-later
"""What the report needs from the ensemble's input text: the plate and the sections.

The program reads the units with UDUNITS; for lengths the names and prefixes below are enough, so that the
report can be made where the program is not installed.
"""
from __future__ import annotations

import re
import tomllib
from typing import Any, Optional

from .plate import MeshRegion, Notch, Plate

_METRES = {"m": 1.0, "meter": 1.0, "meters": 1.0, "metre": 1.0, "metres": 1.0,
           "inch": 0.0254, "inches": 0.0254, "in": 0.0254, "foot": 0.3048, "feet": 0.3048, "ft": 0.3048,
           "micron": 1e-6, "microns": 1e-6}
_PREFIXES = {"": 1.0, "k": 1e3, "d": 1e-1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "µ": 1e-6, "μ": 1e-6, "n": 1e-9,
             "kilo": 1e3, "deci": 1e-1, "centi": 1e-2, "milli": 1e-3, "micro": 1e-6, "nano": 1e-9}
_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*\*?\s*([A-Za-zµμ]+)\s*")


def length(text: str) -> float:
    """A length in metres from its text, "24.5 mm".

    Raises ValueError when it is none, or in a unit that is not known here.
    """
    match = _LENGTH.fullmatch(text)
    if match:
        number, unit = match.groups()
        for name, metres in _METRES.items():
            prefix = unit.removesuffix(name)
            if prefix != unit and prefix in _PREFIXES:
                return float(number) * _PREFIXES[prefix] * metres
    raise ValueError(f"'{text}' is no length in a unit that the report knows (m, mm, um, inch, ...)")


def plate(document: dict[str, Any]) -> Plate:
    """The specimen of a parsed input file."""
    specimen = document["specimen"]
    notches = tuple(Notch(n["face"], length(n["at"]), length(n["depth"]), length(n["height"]))
                    for n in specimen.get("notch", []))
    size = tuple(length(edge) for edge in specimen["size"])
    return Plate((size[0], size[1], size[2]), notches)


def mesh_regions(document: dict[str, Any]) -> list[MeshRegion]:
    """The boxes in which the mesh is fine, in the order of their numbers, clipped to the body."""
    size = plate(document).size

    def interval(region: dict[str, Any], axis: int) -> tuple[float, float]:
        low, high = (length(end) for end in region.get("xyz"[axis], ("0 m", f"{size[axis]!r} m")))
        return max(low, 0.0), min(high, size[axis])

    return [MeshRegion((interval(r, 0), interval(r, 1), interval(r, 2)), length(r["spacing"]))
            for r in document["mesh"].get("region", [])]


def sections(document: dict[str, Any]) -> list[tuple[int, float]]:
    """Axis (1 y, 2 z) and position [m] of the cross-sections, in the order of their numbers."""
    given = document.get("sections", {})
    return [(axis, length(text)) for axis, name in ((1, "y"), (2, "z")) for text in given.get(name, [])]


def has_contact(document: dict[str, Any]) -> bool:
    """Whether opened facets carry compression when they close again."""
    return document.get("fracture", {}).get("contact", "none") != "none"


def stop_half_width(document: dict[str, Any]) -> Optional[float]:
    """Half width [m] at which the ensemble may stop, where [ensemble.stop] gives one."""
    stop = document["ensemble"].get("stop")
    return length(stop["half_width"]) if stop else None


def parse(text: str) -> dict[str, Any]:
    return tomllib.loads(text)
