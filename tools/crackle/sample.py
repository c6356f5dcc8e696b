# SPDX-License-Identifier: GPL-3.0-or-later
"""One sample of an ensemble."""
from __future__ import annotations

import contextlib
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Iterator, Optional

import h5py
import numpy as np
import pandas as pd
import xarray as xr

from . import labelled
from .files import DONE, SAMPLE_KIND, open_results, results, text_of
from .stresses import frame_stress

if TYPE_CHECKING:
    from crackle_report.mesh import Regions
    from crackle_report.plate import Plate


class Sample:
    """A sample that is done, or that failed with its reason in `error`.

    What is large is read when it is asked for the first time. Raises crackle.ResultsError for a file that is no
    sample's or is damaged, and AttributeError for what this sample does not have, as a failed one.
    """

    def __init__(self, file: Path) -> None:
        self.file = Path(file)
        with results(self.file, SAMPLE_KIND) as root:
            self.number = int(root.attrs["sample"])
            self.is_done = int(root.attrs["status"]) == DONE
            self.error = text_of(root.attrs["error"])
            self.input = text_of(root.attrs["input"])
            self._summary = {name: found.values[()] for group in (root["summary"], root["summary"].get("inputs", {}))
                             for member, dataset in labelled.datasets(group).items()
                             for name, found in labelled.by_part(labelled.array(dataset).rename(member)).items()}

    def __repr__(self) -> str:
        return f"<crackle.Sample {self.number} of '{self.file}'{'' if self.is_done else ', failed: ' + self.error}>"

    def open(self) -> h5py.File:
        """The file, for reading; to be closed by the caller (`with sample.open() as file:`)."""
        return open_results(self.file, SAMPLE_KIND)

    @cached_property
    def summary(self) -> pd.Series:
        """The sample's results that are one number each, in SI units, and the values of its random inputs by key."""
        return pd.Series({name: value for name, value in self._summary.items() if np.ndim(value) == 0}, name=self.number)

    @cached_property
    def history(self) -> xr.Dataset:
        """Moments of the whole sample: governing load and displacement, energies, cracks (moment x notch), load, reaction and
        displacement of each boundary condition (moment x condition x component), and what each probe shows, such as
        `probe_stress` (moment x probe x stress_component); `term_NAME` of other contributions to the motion; `each_crack_area`,
        `each_crack_reach` and `each_crack_speed` (moment x crack) of bodies that are not plates."""
        with self._need("history") as root:
            found = root["history"]
            parts = [labelled.group(found)]
            if "probes" in found:
                names = list(found["probes"])
                probes = [labelled.group(found["probes"][name], prefix="probe_") for name in names]
                parts.append(xr.concat(probes, pd.Index(names, name="probe"), data_vars="all", combine_attrs="override"))
            if "cracks" in found:
                parts.append(labelled.group(found["cracks"], prefix="each_crack_"))
            if "terms" in found:
                parts.append(labelled.group(found["terms"], prefix="term_"))
            history = xr.merge(parts, combine_attrs="override")
            history.attrs["rayleigh_speed"] = float(found.attrs["rayleigh_speed"])
        return history.set_coords(["time", "phase", "phase_time", "condition_on", "condition_kind"])

    @cached_property
    def energy(self) -> xr.Dataset:
        """The energy account of the last dynamic phase [J] over time since its start: energy.sel(time=60e-6, method="nearest")."""
        with self._need("energy") as root:
            return labelled.by_time(root["energy"])

    @cached_property
    def frames(self) -> xr.Dataset:
        """Displacement and velocity of all nodes: frame x node x component, with `time` since onset: frames.sel(time=60e-6,
        method="nearest"). `stress` of the tetrahedra: frame x tetrahedron x stress_component [Pa], of broken ones what they still
        carry; it is computed when it is asked for."""
        with self._need("frames") as root:
            frames = labelled.by_time(root["frames"])
            stress = frame_stress(self.file, frames["time"].dims[0], frames.sizes[frames["time"].dims[0]], len(root["mesh/tetrahedra"]))
        return frames.assign(stress=stress).assign_coords(stress_component=labelled.COMPONENTS["stress_component"])

    @cached_property
    def plate(self) -> "Plate":
        """The body in the YZ plane: its outline, and where cracks start."""
        from crackle_report.plate import Plate
        with results(self.file, SAMPLE_KIND) as root:
            return Plate.of(root["specimen"])

    @cached_property
    def regions(self) -> Optional["Regions"]:
        """The parts of other materials than the first, in the plane at mid-thickness; None of a body of one material."""
        from crackle_report.sample_files import read_regions
        with self._need("mesh") as root:
            return read_regions(root)

    @cached_property
    def mesh(self) -> dict[str, np.ndarray]:
        """`nodes` (n x 3) [m], `tetrahedra` (m x 4) and what else the group /mesh holds."""
        with self._need("mesh") as root:
            return {name: dataset[...] for name, dataset in labelled.datasets(root["mesh"]).items()}

    @cached_property
    def breaks(self) -> pd.DataFrame:
        """Broken tetrahedra in order; times in s, stress in Pa, energy in J."""
        with self._need("breaks") as root:
            return _columns(root["breaks"])

    @cached_property
    def crack_surface(self) -> xr.Dataset:
        """Opened dual facets, in order of breaking: corners (facet x corner x component), time since onset, area, the
        tetrahedron they lie in, and the notch at which their crack started (-1: at none)."""
        with self._need("crack_surface") as root:
            surface = labelled.group(root["crack_surface"])
            notch = np.append(root["crack_surface/cracks/notch"][...], -1)
        return surface.assign(notch=("facet", notch[surface["crack"].values]))

    @cached_property
    def fragments(self) -> pd.DataFrame:
        """The fragments at the end, the heaviest first: `mass` [kg] and `share` of the body's, `volume` [m^3], number of `nodes` and the
        `first_node`, centre of mass `x`, `y`, `z` where it is then [m], mean velocity `vx`, `vy`, `vz` [m/s], `kinetic` energy and
        `kinetic_of_mean` motion [J], extent `dx`, `dy`, `dz` in the unloaded body [m], whether `frozen`. Single nodes are dust:
        `.attrs["dust"]` has their number, mass, volume and kinetic energy."""
        with self._need("fragments") as root:
            found = root["fragments"]
            table = pd.DataFrame({name: dataset[...] for name, dataset in labelled.datasets(found).items()
                                  if dataset.ndim == 1 and name != "of_node"})
            for name, columns in (("center", ("x", "y", "z")), ("velocity", ("vx", "vy", "vz")), ("extent", ("dx", "dy", "dz"))):
                table = table.assign(**dict(zip(columns, found[name][...].T)))
            table = table.assign(frozen=table["frozen"].astype(bool))
            table.index.name = "fragment"
            table.attrs["dust"] = {name: dataset[()] for name, dataset in labelled.datasets(found["dust"]).items()}
        return table

    @cached_property
    def fragment_history(self) -> xr.Dataset:
        """Fragments over time since the start of the last dynamic phase: `number` without dust, `largest_mass`, `second_mass`, number of
        single nodes, `dust`, and `dust_mass`, what was `frozen`, with `frozen_mass` and `frozen_energy` [SI]."""
        with self._need("fragments") as root:
            return labelled.by_time(root["fragments/history"])

    @cached_property
    def plane_traces(self) -> pd.DataFrame:
        """The traces of cracks in the input's [[sections.plane]]: `plane` and `crack` (numbers), `notch` (its start), `length` [m], mean
        `x`, `y`, `z` [m] and `time` of arrival [s]."""
        with self._need("plane_traces") as root:
            group = root["plane_traces"]
            table = pd.DataFrame({name: group[name][...] for name in ("plane", "crack", "notch", "length", "time")})
            return table.assign(**dict(zip("xyz", group["position"][...].T)))

    @cached_property
    def crack_lines(self) -> list[pd.DataFrame]:
        """The cracks as lines in the plane of the plate: y, z, spread through the thickness and time of their points, with
        `notch` and `parent` (number of the line that a branch leaves, or -1) in `attrs`."""
        with self._need("crack_lines") as root:
            found, table = root["crack_lines"], root["crack_lines/lines"]
            points = pd.DataFrame({"y": found["position"][:, 0], "z": found["position"][:, 1], "spread": found["spread"][...],
                                   "time": found["time"][...]})
            lines = []
            for first, count, notch, parent in zip(*(table[name][...] for name in ("first", "count", "notch", "parent"))):
                line = points.iloc[first:first + count].reset_index(drop=True)
                line.attrs = {"notch": int(notch), "parent": int(parent)}
                lines.append(line)
        return lines

    @cached_property
    def forks(self) -> pd.DataFrame:
        """Where one crack becomes two; lengths in m, times in s, angles in rad."""
        with self._need("forks") as root:
            found = root["forks"]
            return _columns(found).assign(y=found["position"][:, 0], z=found["position"][:, 1])

    @contextlib.contextmanager
    def _need(self, name: str) -> Iterator[h5py.File]:
        """The file, which has this group."""
        with results(self.file, SAMPLE_KIND) as root:
            if name not in root:
                raise AttributeError(f"'{self.file}' has no {name.replace('_', ' ')}"
                                     + ("" if self.is_done else f": the sample failed ({self.error})"))
            yield root


def _columns(found: h5py.Group) -> pd.DataFrame:
    """The datasets of a group with one value for each row."""
    return pd.DataFrame({name: dataset[...] for name, dataset in labelled.datasets(found).items() if dataset.ndim == 1})
