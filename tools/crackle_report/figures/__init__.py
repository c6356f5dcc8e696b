# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures. Each module draws one kind from an ensemble; SECTIONS is their order in the report of a plate."""
from __future__ import annotations

from typing import Callable, Optional

from ..options import Options
from ..results import Ensemble
from . import comparison, convergence, crack_paths, crossings, energy, experiments, fragments, growth, histories, material, places, sensitivity, shares, solid, surface
from .picture import Section

SECTIONS: tuple[Callable[[Ensemble, Options], Optional[Section]], ...] = (
    crack_paths.typical,
    experiments.section,
    places.section,
    crossings.section,
    shares.section,
    sensitivity.section,
    comparison.section,
    convergence.section,
    growth.section,
    surface.section,
    histories.section,
    material.section,
    energy.section,
    fragments.section,
    crack_paths.every,
)

OF_SOLIDS = (solid.places, sensitivity.section, comparison.section, convergence.section, solid.section, surface.section, histories.section,
             energy.section, fragments.section)
"""Those of bodies that are no plates."""
