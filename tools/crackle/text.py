# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers and tables as the commands print them, and documents as JSON."""
from __future__ import annotations

import json
import math
from typing import Any, Optional, Sequence

GREATEST, LEAST = 1e6, 0.01  # of values in the usual unit of a column; beyond them it has a prefix
MOST_NAMED = 20  # samples in a sentence; more are counted
PREFIXES = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}


def aligned(rows: Sequence[Sequence[str]], n_left: int = 1, is_last_left: bool = False) -> str:
    """The first columns, and the last one if wanted, to the left and the others to the right."""
    width = [max(map(len, column)) for column in zip(*rows)]
    left = {*range(n_left), *([len(width) - 1] if is_last_left else [])}
    lines = ("  ".join(cell.ljust(w) if c in left else cell.rjust(w) for c, (cell, w) in enumerate(zip(row, width))) for row in rows)
    return "".join(line.rstrip(" ") + "\n" for line in lines)


def shown(value: float, form: str, factor: float = 1.0) -> str:
    found = format(factor * value, form)
    return "-" if math.isnan(value) else found.lstrip("-") if math.isfinite(value) and float(found) == 0 else found


def shown_range(lower: float, upper: float, form: str, factor: float = 1.0) -> str:
    return "-" if math.isnan(lower + upper) else f"{shown(lower, form, factor)} to {shown(upper, form, factor)}"


def percent(share: float) -> str:
    return "-" if math.isnan(share) else f"{100 * share:.0f} %"


def probability(p: Optional[float]) -> str:
    return "-" if p is None or math.isnan(p) else "< 0.001" if p < 0.001 else f"{p:.3f}"


def p_is(p: Optional[float]) -> str:
    """For sentences: "p = 0.020"."""
    return "p " + ("= " * (not probability(p).startswith("<"))) + probability(p)


def count(n: int, noun: str) -> str:
    return f"{n} {noun}{'' if n == 1 else 's'}"


def named(numbers: Sequence[int], what: str) -> str:
    return f"{len(numbers)} {what} ({', '.join(map(str, numbers[:MOST_NAMED]))}{', ...' if len(numbers) > MOST_NAMED else ''})"


def readable(name: str) -> str:
    return name.replace("_", " ")


def unit_for(usual: str, factor: float, si: str, largest: float) -> tuple[str, float]:
    """The usual unit of a column with its factor from SI, or one with a prefix that fits the largest value."""
    if si in ("", "1") or not _has_size(largest) or LEAST <= largest * factor < GREATEST:
        return usual, factor
    return _prefixed(si, largest)


def quantity(value: Optional[float], si: str, digits: int = 4, beside: Optional[float] = None) -> str:
    """Such as "78.2 N": a value with a prefix that fits it, or the largest of those that it is compared with; "-" for none."""
    if value is None or math.isnan(value):
        return "-"
    if si == "1":
        return f"{value:.2f}"
    if not si:
        return f"{value:.{digits}g}"
    size = abs(value if beside is None else beside)
    if si == "m" and (size == 0 or 1e-5 <= size < 1):
        unit, factor = "mm", 1e3
    elif not _has_size(size) or 0.1 <= size < min(1e4, 10**digits):  # no exponent is shown
        unit, factor = si, 1.0
    else:
        unit, factor = _prefixed(si, size)
    return f"{value * factor:.{digits if abs(value) * factor < 1e4 else 6}g} {unit}"


def _has_size(size: float) -> bool:
    return size > 0 and math.isfinite(size)


def _prefixed(si: str, size: float) -> tuple[str, float]:
    symbol = next((k for k, letter in enumerate(si) if not letter.isalpha()), len(si))
    power = int(si[symbol + 1]) if si[symbol:symbol + 1] == "^" and symbol + 1 < len(si) else 1
    best = ("", 1.0)
    for prefix, of_prefix in PREFIXES.items():
        if of_prefix > 1 and si[0] in "sm":  # ks and km are not in use
            break
        factor = of_prefix**-power
        if not best[0] or size * factor >= (0.01 if power > 1 else 1):  # prefixes of areas are a million apart
            best = (prefix + si, factor)
    return best


def json_text(document: Any, indent: int | None = 1) -> str:
    """With null for what is no finite number."""
    return json.dumps(plain(document), indent=indent, ensure_ascii=False) + "\n"


def plain(value: Any) -> Any:
    """As JSON has it: None for what is no finite number."""
    if isinstance(value, dict):
        return {str(name): plain(one) for name, one in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
