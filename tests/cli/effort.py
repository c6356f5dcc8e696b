# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a test does, as support/effort.h for C++."""
import os
from typing import TypeVar

T = TypeVar("T")


def repetitions(usual: T, full: T) -> T:
    """`full` under tools/check --full, which sets CRACKLE_FULL, else `usual`."""
    return full if "CRACKLE_FULL" in os.environ else usual
