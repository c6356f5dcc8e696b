# SPDX-License-Identifier: GPL-3.0-or-later
"""VTKHDF files, version 1.0, unstructured grids: what VTK from 9.1 and ParaView from 5.10 read."""
from __future__ import annotations

import io
from typing import Mapping

import h5py
import numpy as np

TETRAHEDRON, QUADRILATERAL = 10, 9  # VTK's cell types


def grid(points: np.ndarray, cells: np.ndarray, cell_type: int, time: float,
         point_data: Mapping[str, np.ndarray], cell_data: Mapping[str, np.ndarray]) -> bytes:
    """A grid of one kind of cells as a file's content.

    points: n x 3; cells: m x corners, numbers of points; fields have n or m rows. `time` is kept as VTK's
    TimeValue.
    """
    content = io.BytesIO()
    with h5py.File(content, "w") as root:
        group = root.create_group("VTKHDF")
        group.attrs["Version"] = np.array([1, 0], "i8")
        group.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", 16))
        for name, number in (("Points", len(points)), ("Cells", len(cells)), ("ConnectivityIds", cells.size)):
            group[f"NumberOf{name}"] = np.array([number], "i8")
        group["Points"] = points
        group["Connectivity"] = cells.astype("i8").ravel()
        group["Offsets"] = np.arange(len(cells) + 1, dtype="i8") * cells.shape[1]
        group["Types"] = np.full(len(cells), cell_type, "u1")
        for kind, fields in (("PointData", point_data), ("CellData", cell_data)):
            target = group.create_group(kind)
            for name, values in fields.items():
                target[name] = values
        group.create_group("FieldData")["TimeValue"] = np.array([time])
    return content.getvalue()
