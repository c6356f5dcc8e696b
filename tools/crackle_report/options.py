# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be chosen about a report."""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional

import numpy as np

from .photoelasticity import WAVELENGTH, Optics, coefficients
from .fields import Frames


@dataclass(frozen=True)
class Options:
    samples: tuple[int, ...] = ()  # shown in detail; none: a typical one of each main pattern
    times: tuple[float, ...] = ()  # of the pictures of these, since onset [s]; none: spread over the growth
    fringes: bool = True  # photo-elastic pictures of these
    stress_optic: tuple[float, ...] = ()  # coefficient of all materials or of each [1/Pa]; none: epoxy's is assumed
    wavelength: float = WAVELENGTH  # [m]
    light_field: bool = False
    reverse: bool = False  # colours, as prints of dark pictures often are
    product: bool = True  # of Jones matrices, or the integrated form
    animation: bool = True
    comparison: Optional[dict[str, Any]] = None  # what `crackle compare` says of it and other ensembles
    experiments: Optional[Path] = None  # TOML; what the program says of them is read from there:
    match: Optional[dict[str, Any]] = None  # `crackle match`
    calibration: Optional[dict[str, Any]] = None  # `crackle calibrate`; None where it says nothing
    no_calibration: str = ""  # why

    def optics(self, frames: Frames) -> Optional[Optics]:
        """Of a sample's tetrahedra; None where no fringes are wanted, or no coefficient is known.

        @raise ResultsError: coefficients of another number of materials are given
        """
        if not self.fringes:
            return None
        found = coefficients(self.stress_optic, frames.material, frames.youngs_modulus)
        return Optics(found, self.wavelength) if np.any(found) else None
