# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures. Each module draws one kind from an ensemble; SECTIONS is their order in the report."""
from __future__ import annotations

from typing import Callable

from ..results import Ensemble
from . import convergence, crack_paths, crossings
from .picture import Section

SECTIONS: tuple[Callable[[Ensemble], Section], ...] = (
    crack_paths.section,
    crossings.section,
    convergence.section,
)
