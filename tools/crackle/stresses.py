# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress in a sample's frames, which its file does not hold: it follows from the displacement."""
from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from xarray.backends import BackendArray
from xarray.core import indexing

from .files import SAMPLE_KIND, results

if TYPE_CHECKING:
    from crackle_report.fields import Frames


def frame_stress(file: Path, dimension: str, n_frames: int, n_tetrahedra: int) -> xr.Variable:
    """Frames x tetrahedra x components, as crackle-paraview has it; of each frame computed when it is asked for."""
    return xr.Variable((dimension, "tetrahedron", "stress_component"),
                       indexing.LazilyIndexedArray(_FrameStress(file, (n_frames, n_tetrahedra, 6))),
                       {"units": "Pa", "meaning": "stress of the tetrahedra; of broken ones what they still carry"})


class _FrameStress(BackendArray):
    dtype = np.dtype(float)

    def __init__(self, file: Path, shape: tuple[int, int, int]) -> None:
        self._file, self.shape = file, shape

    @cached_property
    def _frames(self) -> "Frames":
        from crackle_report.sample_files import read_frames
        with results(self._file, SAMPLE_KIND) as root:
            return read_frames(root)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> np.ndarray:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._computed)

    def _computed(self, key: tuple[int | slice, ...]) -> np.ndarray:
        from crackle_report import stress
        chosen, *others = key
        numbers = np.arange(self.shape[0])[chosen]
        table = np.array([stress.frame_stress(self._frames, int(k)) for k in np.atleast_1d(numbers)]).reshape(-1, *self.shape[1:])
        return (table if np.ndim(numbers) else table[0])[(slice(None),) * np.ndim(numbers) + tuple(others)]
