# SPDX-License-Identifier: GPL-3.0-or-later
"""Units for people: files are in SI units, a column or an axis shows its values in a unit of their size."""
from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9, "p": 1e-12}
BASES = {"m": 1, "m^2": 2, "s": 1, "N": 1, "J": 1, "Pa": 1, "J/m^2": 1, "N/m": 1}  # and the power of the prefix
LARGEST = {"m": "", "m^2": "", "s": ""}  # prefix; nobody writes kilometres or kiloseconds here

MOST = 1e5  # values of a usual unit; from there on a larger one


@dataclass(frozen=True)
class Unit:
    name: str  # with its prefix; empty for pure numbers
    size: float  # in SI units

    def of(self, values: Any) -> Any:
        """Values in SI units in this unit."""
        return values / self.size

    def label(self, what: str) -> str:
        """For an axis."""
        return f"{what} [{self.name}]" if self.name else what


def _prefix_and_base(name: str) -> Optional[tuple[str, str]]:
    name = name.replace("²", "^2")
    for base in sorted(BASES, key=len, reverse=True):
        prefix = name.removesuffix(base).replace("u", "µ")
        if name.endswith(base) and prefix in PREFIXES:
            return prefix, base
    return None


def named(name: str) -> Optional[Unit]:
    """The unit of a name, such as "mm", "us" or "kJ/m^2"; None where it is not made of a prefix and one of BASES."""
    parts = _prefix_and_base(name)
    return Unit("".join(parts), PREFIXES[parts[0]] ** BASES[parts[1]]) if parts else None


def quantity_of(text: str) -> tuple[float, str]:
    """A number with the name of a unit or of one per second, such as "0.2 us" or "450 m/s", or a pure number: value and unit in SI,
    (450.0, "m/s").

    @raise ValueError: it is none
    """
    number, _, name = text.strip().partition(" ")
    if not name:
        return float(number), ""
    of_time = "/s" if name.endswith("/s") else ""
    parts = _prefix_and_base(name.strip().removesuffix("/s"))
    if parts is None:
        raise ValueError(f"'{text}' is not a number with a unit, such as '450 m/s' or '0.2 us'")
    return float(number) * PREFIXES[parts[0]] ** BASES[parts[1]], parts[1] + of_time


def value_of(text: str) -> float:
    """The value of quantity_of()."""
    return quantity_of(text)[0]


MM, MM2, US, NEWTON, MILLIJOULE = (Unit(name, size) for name, size in (("mm", 1e-3), ("mm^2", 1e-6), ("µs", 1e-6), ("N", 1.0), ("mJ", 1e-3)))


def fitting(values: Any, usual: Unit, least: float = 0.1, most: float = MOST) -> Unit:
    """The usual unit while the largest of these values [SI] is from `least` to `most` of it; otherwise the one with the prefix
    in which that value has one to three digits before the point."""
    sizes = np.abs(np.asarray(values, float))
    largest = sizes[np.isfinite(sizes)].max(initial=0.0)
    if largest == 0 or least <= largest / usual.size < most or named(usual.name) is None:
        return usual
    base = next(base for base in sorted(BASES, key=len, reverse=True) if usual.name.endswith(base))
    power = BASES[base]
    limit = PREFIXES[LARGEST.get(base, "G")]
    fit = [prefix for prefix, size in PREFIXES.items() if size <= limit and largest >= 0.9995 * size ** power]
    prefix = fit[0] if fit else "p"
    return Unit(prefix + base, PREFIXES[prefix] ** power)


def of_label(label: str) -> Optional[Unit]:
    """The unit that an axis' label names in brackets."""
    found = re.search(r"\[([^\]]+)\]$", label)
    return named(found[1]) if found else None
