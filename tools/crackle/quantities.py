# SPDX-License-Identifier: GPL-3.0-or-later
"""Quantities with their units, read by UDUNITS, the library by which the program reads them."""
from __future__ import annotations

import ctypes
import ctypes.util
import functools
import math
import re

UTF8 = 2  # ut_encoding
# Products, quotients and small powers of names; UDUNITS takes far more, which can only be mistakes.
_UNIT = re.compile(r"(?:1 ?/ ?)?(?=[^)./* ])(?:(?:[^\x01-@\[-`{-\x7f]|\))(?:\^?[-+]?[0-9]{1,2})?|[ ./*(])+")
_SIGNS = str.maketrans({"−": "-", "·": " ", "⋅": " ", "\u00a0": " ", "\u2009": " ", "\u202f": " ", "μ": "µ"})
_NUMBER = re.compile(r"[-]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?|inf(?:inity)?|nan)", re.IGNORECASE)


class QuantityError(ValueError):
    """A text is no quantity of the wanted dimension: `reason` is "no number", "no unit", "unknown unit", "wrong dimension" or
    "not finite", `unit` what stands after the number."""

    def __init__(self, reason: str, unit: str = "") -> None:
        super().__init__(reason)
        self.reason, self.unit = reason, unit


@functools.cache
def _library() -> tuple[ctypes.CDLL, ctypes.c_void_p]:
    try:
        found = ctypes.CDLL(ctypes.util.find_library("udunits2") or "libudunits2.so.0")
    except OSError:
        raise ModuleNotFoundError("crackle needs the library UDUNITS (Debian: libudunits2-0)", name="udunits2") from None
    pointer, text, number = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_double
    for name, result, arguments in (("ut_read_xml", pointer, [text]), ("ut_parse", pointer, [pointer, text, ctypes.c_int]),
                                    ("ut_are_convertible", ctypes.c_int, [pointer, pointer]), ("ut_free", None, [pointer]),
                                    ("ut_get_converter", pointer, [pointer, pointer]), ("cv_free", None, [pointer]),
                                    ("cv_convert_double", number, [pointer, number]), ("ut_set_error_message_handler", pointer, [pointer])):
        getattr(found, name).restype, getattr(found, name).argtypes = result, arguments
    found.ut_set_error_message_handler(ctypes.cast(found.ut_ignore, pointer))
    return found, found.ut_read_xml(None)


@functools.lru_cache(maxsize=1000)
def factor(unit: str, si_unit: str) -> float:
    """SI value of one `unit`. Raises QuantityError."""
    library, system = _library()
    source = library.ut_parse(system, unit.encode(), UTF8) if len(unit) <= 80 and _UNIT.fullmatch(unit) else None
    if not source:
        raise QuantityError("unknown unit", unit)
    wanted = library.ut_parse(system, si_unit.encode(), UTF8)
    converter = library.ut_get_converter(source, wanted) if library.ut_are_convertible(source, wanted) else None
    library.ut_free(source)
    library.ut_free(wanted)
    if not converter:
        raise QuantityError("wrong dimension", unit)
    zero, one, two = (library.cv_convert_double(converter, float(value)) for value in (0, 1, 2))
    library.cv_free(converter)
    # UDUNITS converts reciprocals, logarithms and offsets, too; only a factor changes a unit.
    if zero != 0 or not abs(two - 2 * one) <= 1e-12 * one:
        raise QuantityError("wrong dimension", unit)
    return one


def read(text: str, si_unit: str) -> float:
    """The value of a text such as "12.5 mm" [si_unit]. Raises QuantityError."""
    plain = text.translate(_SIGNS).strip(" \t")
    plain = plain[1:] if plain.startswith("+") and not plain.startswith("+-") else plain
    number = _NUMBER.match(plain)
    if not number:
        raise QuantityError("no number")
    unit = plain[number.end():].strip(" \t")
    value = float(number[0])
    if not math.isfinite(value):
        raise QuantityError("not finite", unit)
    if not unit:
        raise QuantityError("no unit")
    value *= factor(unit, si_unit)
    if not math.isfinite(value):
        raise QuantityError("not finite", unit)
    return value
