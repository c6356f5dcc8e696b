# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what samples/NNNN.h5 hold."""
from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Callable, Optional

import h5py
import numpy as np
from crackle.files import DONE, SAMPLE_KIND, ResultsError, results, sample_files, text_of

from .fields import BranchingPoints, CrackLine, CrackSurface, Energy, FragmentHistory, Frames, History, Places, Tool
from .mesh import Mesh, Regions
from .plate import Plate
from .stress import ALL_EDGES, CROSSED_EDGES


class SampleFiles:
    """The whole sample files of a folder; what is asked of a sample without file, or that failed, is not there."""

    def __init__(self, folder: Path) -> None:
        self.files = sample_files(folder)
        self._regions: dict[int, Optional[Regions]] = {}
        self.damage: dict[int, str] = {}  # why samples were left out

    def leave_out_damaged(self) -> None:
        """From now on these are samples without files."""
        for sample in list(self.files):
            try:
                self.crack(sample)
            except ResultsError as error:
                self.damage[sample] = str(error)
                del self.files[sample]

    def crack(self, sample: int) -> Optional[CrackSurface]:
        return self._read(sample, _read_crack)

    def places(self, sample: int) -> Optional[Places]:
        """None also of samples in which nothing broke."""
        return self._read(sample, _read_places)

    def lines(self, sample: int) -> list[CrackLine]:
        return self._read(sample, _read_lines) or []

    def branching(self, sample: int) -> Optional[BranchingPoints]:
        return self._read(sample, _members_of(BranchingPoints, "forks"))

    def mesh(self, sample: int) -> Optional[Mesh]:
        return self._read(sample, read_mesh)

    def regions(self, sample: int) -> Optional[Regions]:
        """The parts of other materials than the first, at mid-thickness; None also of a body of one material."""
        if sample not in self._regions:
            self._regions[sample] = self._read(sample, read_regions)
        return self._regions[sample]

    def plate(self, sample: int) -> Optional[Plate]:
        """The body, with the sample's own flaws."""
        return self._read(sample, lambda root: Plate.of(root["specimen"]) if "outline" in root.get("specimen", ()) else None)

    def energy(self, sample: int) -> Optional[Energy]:
        return self._read(sample, _members_of(Energy, "energy"))

    def fragment_history(self, sample: int) -> Optional[FragmentHistory]:
        return self._read(sample, _members_of(FragmentHistory, "fragments/history"))

    def history(self, sample: int) -> Optional[History]:
        return self._read(sample, _read_history)

    def tools(self, sample: int) -> list[Tool]:
        return self._read(sample, _read_tools) or []

    def frames(self, sample: int) -> Optional[Frames]:
        return self._read(sample, read_frames)

    def _read(self, sample: int, read: Callable[[h5py.File], Any]) -> Any:
        """Raises ResultsError for a file that is no sample's, is damaged or lacks something."""
        if sample not in self.files:
            return None
        with results(self.files[sample], SAMPLE_KIND) as root:
            return read(root) if root.attrs["status"] == DONE else None


def _read_crack(root: h5py.File) -> CrackSurface:
    group, in_motion = root["crack_surface"], root["energy/time"]
    corners, notch_of_crack = group["corners"][...], np.append(group["cracks/notch"][...], -1)
    if not np.isfinite(corners).all():
        raise RuntimeError("corners of its crack are not numbers")
    return CrackSurface(corners.astype(np.float32), group["time"][...],
                        notch_of_crack[group["crack"][...]], group["tetrahedron"][...], float(in_motion[-1]) if in_motion.size else np.inf)


def _read_places(root: h5py.File) -> Optional[Places]:
    breaks, surface = root["breaks"], root["crack_surface"]
    tetrahedron, loading, phase = (breaks[name][...] for name in ("tetrahedron", "load_time", "phase_time"))
    if tetrahedron.size == 0:
        return None
    first = np.lexsort((phase, loading))[0]
    middle = root["mesh/nodes"][...][root["mesh/tetrahedra"][int(tetrahedron[first])]].mean(axis=0)
    time = float(loading[first] + phase[first])
    areas = surface["cracks/area"][...]
    if areas.size == 0:
        return Places(middle, time, np.full(3, np.nan), 0.0, np.nan)
    largest = int(areas.argmax())
    facets = surface["crack"][...] == largest
    centre = np.average(surface["corners"][...][facets].mean(axis=1), axis=0, weights=surface["area"][...][facets])
    return Places(middle, time, centre, float(areas[largest]), float(surface["time"][...][facets].min()))


def read_mesh(root: h5py.File) -> Mesh:
    """Of a sample's file."""
    group = root["mesh"]
    return Mesh(group["nodes"][...], group["tetrahedra"][...],
                **{name: group[name][...] for name in ("strength_factor", "youngs_modulus", "material") if name in group})


def read_regions(root: h5py.File) -> Optional[Regions]:
    """Of a sample's file, as SampleFiles.regions."""
    if "material" not in root["mesh"]:
        return None
    return read_mesh(root).regions(float(root["specimen/size"][0]) / 2)


def _read_lines(root: h5py.File) -> list[CrackLine]:
    group = root["crack_lines"]
    position, table = group["position"][...], group["lines"]
    return [CrackLine(int(notch), parent >= 0, position[first:first + count]) for notch, parent, first, count in
            zip(*(table[name][...] for name in ("notch", "parent", "first", "count")))]


def _members_of(kind: type, name: str) -> Callable[[h5py.File], Any]:
    """Reads a group whose datasets, and attributes of one number, are the members of this class; None where there is no such group."""
    def read(root: h5py.File) -> Any:
        if name not in root:
            return None
        group = root[name]
        return kind(**{member: group[member][...] if member in group else float(group.attrs[member]) for member in kind.__dataclass_fields__})
    return read


def _read_history(root: h5py.File) -> Optional[History]:
    if "history" not in root:
        return None
    group = root["history"]
    found = {name: group[name][...] for name in History.__dataclass_fields__ if name in group}
    rayleigh = float(group.attrs["rayleigh_speed"])
    found.setdefault("tip_speed_ratio", found["tip_speed"] / rayleigh)  # version 5 of the format has none
    return History(**found, rayleigh_speed=rayleigh)


def _read_tools(root: h5py.File) -> list[Tool]:
    if "tools" not in root or "history/tools" not in root:
        return []
    phase = root["history/phase"][...]
    last = (phase == phase.max(initial=0)) & (phase > 0)
    if not last.any():
        return []
    time = root["history/phase_time"][...][last]
    return [Tool(text_of(group.attrs["shape"]), np.array(group.attrs.get("axis", np.zeros(3))), float(group.attrs["radius"]),
                 np.atleast_1d(group.attrs.get("size", np.empty(0))), time, root["history/tools"][name]["position"][...][last],
                 np.array(group.attrs["at"]), float(group.attrs["rounding"]),
                 root["history/tools"][name]["orientation"][...][last] if "orientation" in root["history/tools"][name] else None)
            for name, group in root["tools"].items()]


def read_frames(root: h5py.File) -> Frames:
    """Of a sample's file."""
    group = root["frames"]
    broken, cut = root["breaks/tetrahedron"][...], root["breaks/cut"][...]
    n_broken, release_time = group["broken"][...], _of_tetrahedra(root, "release_time", 0)
    pre_cracks = root.get("pre_cracks")  # broken before the others
    opened, parted = ((pre_cracks[name][...] if pre_cracks else np.empty(0, int)) for name in ("tetrahedron", "cut"))
    return Frames(root["mesh/nodes"][...], root["mesh/tetrahedra"][...], group["time"][...],
                  group["displacement"][...], group["velocity"][...], [np.append(opened, broken[:n]) for n in n_broken],
                  [np.append(parted, cut[:n]) for n in n_broken],
                  [np.append(_crossed_edges(root, parted), _released_edges(root, n)) for n in n_broken],
                  [np.append(np.zeros(len(opened)), _remaining(root, n, time, release_time)) for n, time in zip(n_broken, group["time"][...])],
                  [_stiffness(root, time) for time in group["time"][...]],
                  _has_contact(tomllib.loads(text_of(root.attrs["input"]))),
                  _of_tetrahedra(root, "youngs_modulus"), _of_tetrahedra(root, "poisson_ratio"),
                  root["mesh/material"][...] if "material" in root["mesh"] else np.zeros(len(root["mesh/tetrahedra"]), "u1"),
                  root["fragments/of_node"][...] if "fragments" in root else np.empty(0, "i4"),
                  root["mesh/initial_strain"][...] if "initial_strain" in root["mesh"] else np.zeros((len(root["mesh/tetrahedra"]), 6)))


def _has_contact(parameters: dict) -> bool:
    return "contact" in parameters or parameters.get("fracture", {}).get("contact", "none") != "none"


def _of_tetrahedra(root: h5py.File, name: str, default: float | None = None) -> np.ndarray:
    """A property of each tetrahedron: /mesh has it where it differs, /frames the one value of all."""
    if name in root["mesh"]:
        return root["mesh"][name][...]
    return np.full(root["mesh/tetrahedra"].shape[0], float(root["frames"].attrs.get(name, default)))


def _remaining(root: h5py.File, n_broken: int, time: float, release_time: np.ndarray) -> np.ndarray:
    """The share of its stiffness that each of the first n_broken tetrahedra in /breaks has at a time since onset [s], to half a step."""
    if not release_time.any():
        return np.zeros(n_broken)
    number, loading, phase = (root["breaks"][name][:n_broken] for name in ("tetrahedron", "load_time", "phase_time"))
    falls_over = release_time[number]
    share = 1 - np.divide(time - phase, falls_over, out=np.ones(n_broken), where=falls_over > 0)
    return np.where(loading == root["summary/phase_start"][()], np.clip(share, 0, 1), 0)


def _stiffness(root: h5py.File, time: float) -> np.ndarray:
    """The share of its stiffness that softening has left to each tetrahedron at a time since onset [s]."""
    stiffness = np.ones(root["mesh/tetrahedra"].shape[0])
    if "softening" not in root:
        return stiffness
    teeth = root["softening"]
    loading, phase = (teeth[name][...] for name in ("load_time", "phase_time"))
    start = root["summary/phase_start"][()]
    fallen = (loading < start) | ((loading == start) & (phase <= time))
    # Those of a tetrahedron are in the order in which they fell.
    stiffness[teeth["tetrahedron"][...][fallen]] = teeth["share"][...][fallen]
    return stiffness


def _bridges(root: h5py.File) -> Optional[h5py.Group]:
    """None with release by elements."""
    return root.get("bridge_releases", root.get("ties"))  # the name in version 4 of the format


def _crossed_edges(root: h5py.File, cut: np.ndarray) -> np.ndarray:
    """The edges that tetrahedra lose by their cuts."""
    return np.full(len(cut), ALL_EDGES, np.uint8) if _bridges(root) is None else CROSSED_EDGES[cut]


def _released_edges(root: h5py.File, n_broken: int) -> np.ndarray:
    """Of the first n_broken tetrahedra in /breaks when no more were broken."""
    breaks, bridges = root["breaks"], _bridges(root)
    released = _crossed_edges(root, breaks["cut"][:n_broken])
    if n_broken == 0 or bridges is None:
        return released
    # Releases of bridges are in order of time, and each has the times of the break that caused it.
    loading, phase = (bridges[name][...] for name in ("load_time", "phase_time"))
    last_loading, last_phase = (breaks[name][n_broken - 1] for name in ("load_time", "phase_time"))
    n_bridges = np.count_nonzero((loading < last_loading) | ((loading == last_loading) & (phase <= last_phase)))
    broken = breaks["tetrahedron"][:n_broken]
    order = np.argsort(broken)
    place = order[np.searchsorted(broken, bridges["tetrahedron"][:n_bridges], sorter=order)]
    np.bitwise_or.at(released, place, bridges["edges"][:n_bridges])
    return released
