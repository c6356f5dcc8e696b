# SPDX-License-Identifier: GPL-3.0-or-later
"""Datasets of a result file as labelled arrays: names of dimensions, units and meaning stand in the file itself."""
from __future__ import annotations

from typing import Iterable, Mapping

import h5py
import numpy as np
import xarray as xr

from .files import text_of

COMPONENTS = {"component": ["x", "y", "z"], "stress_component": ["xx", "yy", "zz", "yz", "xz", "xy"]}


def array(dataset: h5py.Dataset) -> xr.DataArray:
    """A dataset with the names of its dimensions and its attributes."""
    names = [dimension.label or f"dimension_{i}" for i, dimension in enumerate(dataset.dims)]
    values = dataset[...]
    if h5py.check_string_dtype(dataset.dtype):
        values = np.array([text_of(text) for text in values.ravel()], object).reshape(values.shape)
    attributes = {name: text_of(dataset.attrs[name]) for name in ("units", "meaning", "categories") if name in dataset.attrs}
    parts = {"part": text_of(dataset.attrs["parts"]).split("\n")} if "parts" in dataset.attrs else {}
    return xr.DataArray(values, dims=names, coords=parts, attrs=attributes)


def by_part(found: xr.DataArray) -> dict[str, xr.DataArray]:
    """What is known of each part of a body, by "NAME: PART"; else the array itself by its name."""
    if "part" not in found.dims:
        return {str(found.name): found}
    return {f"{found.name}: {part}": found.sel(part=part, drop=True) for part in found["part"].values}


def datasets(found: Mapping[str, h5py.HLObject]) -> dict[str, h5py.Dataset]:
    """Those of a group by name; groups in it are left out."""
    return {name: member for name, member in found.items() if isinstance(member, h5py.Dataset)}


def in_order(found: h5py.Group) -> list[str]:
    """Names of a group's datasets in the order of the program's tables, what has no place there at the end."""
    last = 1 << 30
    return sorted(datasets(found), key=lambda name: (int(found[name].attrs.get("column", last)), name))


def group(found: h5py.Group, names: Iterable[str] | None = None, prefix: str = "") -> xr.Dataset:
    """The datasets of a group, those of groups in it left out.

    @param names: which; all when None
    @param prefix: before the names of variables
    """
    there = datasets(found)
    result = xr.Dataset({prefix + name: array(there[name]) for name in (there if names is None else names) if name in there})
    for dimension, values in COMPONENTS.items():
        if result.sizes.get(dimension) == len(values):
            result = result.assign_coords({dimension: values})
    return result


def by_time(found: h5py.Group) -> xr.Dataset:
    """A group whose rows are moments, which can be selected by `time`."""
    return group(found).set_coords("time").set_xindex("time")
