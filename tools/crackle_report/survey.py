# SPDX-License-Identifier: GPL-3.0-or-later
"""The command crackle-survey: quality, bias and time of many meshes of one input."""
from __future__ import annotations

import argparse
import csv
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Iterable

import h5py
import numpy as np
from crackle.files import ResultsError
from crackle.program import find_program

from .mesh import EDGES, gradients

COLUMNS = ("sample", "conforms", "tetrahedra", "worst_quality", "quality_1_percent", "median_quality", "smallest_angle_rad",
           "largest_angle_rad", "redrawn_points", "rounds", "share_x", "share_y", "share_z", "bias_2", "bias_4", "mesh_s")
ISOTROPIC = np.eye(3) / 3
ISOTROPIC_4 = sum(np.einsum(f"{pairs}->ijkl", np.eye(3), np.eye(3)) for pairs in ("ij,kl", "ik,jl", "il,jk")) / 15


class Orientation:
    """Moments of the normals n of candidate crack facets, weighted by area: their area [m^2], and means of n n and n n n n."""

    def __init__(self, area: float, second: np.ndarray, fourth: np.ndarray):
        self.area, self.second, self.fourth = area, second, fourth

    @classmethod
    def of(cls, corner: np.ndarray) -> Orientation:
        """Of the dual facets of tetrahedra with these corners, m x 4 x 3."""
        volume = np.abs(np.linalg.det(corner[:, 1:] - corner[:, :1])) / 6
        gradient = volume[:, None, None] * gradients(corner) / 4
        facet = np.concatenate([gradient[:, b] - gradient[:, a] for a, b in EDGES])
        area = np.linalg.norm(facet, axis=1)
        facet, area = facet[area > 0], area[area > 0]
        normal = facet / area[:, None]
        pairs = (normal[:, :, None] * normal[:, None, :]).reshape(-1, 9)
        total = area.sum() or np.nan
        return cls(area.sum(), (area @ pairs / total).reshape(3, 3), ((pairs.T * area) @ pairs / total).reshape(3, 3, 3, 3))

    @classmethod
    def mean(cls, several: Iterable[Orientation]) -> Orientation:
        return cls(*(np.mean([getattr(one, name) for one in several], axis=0) for name in ("area", "second", "fourth")))

    def bias(self, order: int) -> float:
        """Distance of a moment from the isotropic one, over the latter: 0 for no preferred direction."""
        found, isotropic = (self.second, ISOTROPIC) if order == 2 else (self.fourth, ISOTROPIC_4)
        return float(np.linalg.norm(found - isotropic) / np.linalg.norm(isotropic))


def _angles(corner: np.ndarray) -> np.ndarray:
    """Dihedral angles of tetrahedra [rad], 6 x m."""
    found = []
    for i, j in EDGES:
        k, l = (m for m in range(4) if m not in (i, j))
        p, q = (np.cross(corner[:, j] - corner[:, i], corner[:, m] - corner[:, i]) for m in (k, l))
        found.append(np.arctan2(np.linalg.norm(np.cross(p, q), axis=1), np.einsum("ij,ij->i", p, q)))
    return np.array(found)


def _ordered(values: Any) -> tuple[float, float, float, float]:
    """Minimum, 1 % quantile, median and maximum, all of them values that occur."""
    values = np.sort(np.asarray(values, dtype=float))
    return values[0], values[len(values) // 100], values[len(values) // 2], values[-1]


def measure(program: str, source: Path, sample: int, folder: Path, undisturbed: bool = False) -> dict[str, Any]:
    """The row of one mesh, with its nodes, orientation and displacements.

    @raise ResultsError: no mesh was made
    """
    file = folder / "mesh.vtkhdf"
    command = [program, "mesh", str(source), "--sample", str(sample), "-o", str(file), *(["--undisturbed"] if undisturbed else [])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ResultsError(done.stderr.strip().removeprefix("crackle: "))
    seed = re.search(r"(?m)^sample +\d+ of seed (\d+)$", done.stdout)[1]
    redrawn, rounds = re.search(r"(?m)^redrawn points +(\d+) .* in (\d+) rounds$", done.stdout).groups()
    seconds = re.search(r"(?m)^time +([\d.]+) s for the realization, ([\d.]+) s", done.stdout)
    with h5py.File(file) as root:
        mesh = root["VTKHDF"]
        corner = mesh["Points"][...][mesh["Connectivity"][...].reshape(-1, 4)]
        quality, refined = (mesh[f"CellData/{name}"][...] for name in ("quality", "refined"))
        moved = mesh["PointData/displacement"][...] if "displacement" in mesh["PointData"] else np.empty((0, 3))
        n_nodes = len(mesh["Points"])
    angles, orientation = _angles(corner), Orientation.of(corner[refined == 1])
    return {**dict(zip(COLUMNS, (sample, 1, len(corner), *_ordered(quality)[:3], angles.min(), angles.max(), int(redrawn),
                                 int(rounds), *np.diag(orientation.second), orientation.bias(2), orientation.bias(4), float(seconds[1])))),
            "seed": seed, "nodes": n_nodes, "base_s": float(seconds[2]), "orientation": orientation, "displacement": moved}


def _spread(values: Any, digits: int) -> str:
    least, _, median, greatest = _ordered(values)
    return f"min {least:.{digits}f}, median {median:.{digits}f}, max {greatest:.{digits}f}"


def _orientation(base: Orientation, rows: list[dict[str, Any]]) -> list[tuple[str, str]]:
    if not base.area > 0:
        return [("orientation", "the fine zone has no interior: it lies nowhere two spacings below the surface")]
    mean = Orientation.mean([row["orientation"] for row in rows])

    def over(name: str) -> str:
        values = [row[name] for row in rows]
        return f"{np.mean(values):.4f} +- {np.std(values, ddof=1) if len(values) > 1 else 0:.4f}"

    return [("candidate facets", f"{1e6 * mean.area:.0f} mm^2 in the interior of the fine zone; shares by direction of the normals:"),
            *((f"  share along {axis}", f"base {base.second[i, i]:.4f}, realizations {over(f'share_{axis}')}, isotropic {1 / 3:.4f}")
              for i, axis in enumerate("xyz")),
            *((f"  bias, {name} order", f"base {base.bias(order):.4f}, realizations {over(f'bias_{order}')}, at most "
               f"{max(row[f'bias_{order}'] for row in rows):.4f}, of their mean tensor {mean.bias(order):.4f}")
              for order, name in ((2, "2nd"), (4, "4th")))]


def _displacements(rows: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """Of the nodes from their mother points, over the amplitude, by the number of directions in which they move."""
    moved = np.concatenate([row["displacement"] for row in rows])
    of_kind = [moved[np.isfinite(moved).sum(axis=1) == number] for number in (1, 2, 3)]

    def numbers(values: Iterable[float], digits: int = 4) -> str:
        return ", ".join(f"{value:.{digits}f}" for value in values)

    table = []
    if len(interior := of_kind[2]):
        products = interior.T @ interior / len(interior)
        table = [("displacements", f"{len(interior)} in the interior, in amplitudes; for a uniform ball 0 and 0.2000 in every direction:"),
                 ("  mean", f"{numbers(interior.mean(axis=0), 5)} (x, y, z; by chance +- {np.sqrt(0.2 / len(interior)):.5f})"),
                 ("  covariance", f"{numbers(np.diag(products))} (xx, yy, zz); {numbers(products[[1, 0, 0], [2, 2, 1]])} (yz, xz, xy)")]
    for name, found, uniform in (("  in faces", of_kind[1], 0.25), ("  along edges", of_kind[0], 1 / 3)):
        if np.isfinite(found).any(axis=0).all() and len(found):
            table.append((name, f"mean {numbers(np.nanmean(found, axis=0))}; variance {numbers(np.nanmean(found**2, axis=0))}, "
                                f"uniform {uniform:.4f}"))
    return table


def table_of(base: dict[str, Any], rows: list[dict[str, Any]], n_failed: int) -> str:
    """The printed statistics of the meshes that conform."""
    def column(name: str) -> np.ndarray:
        return np.array([row[name] for row in rows], dtype=float)

    table = [("realizations", f"{len(rows) + n_failed} of seed {base['seed']}: {len(rows)} conform, {n_failed} failed"),
             ("nodes", f"{base['nodes']}, made in {base['base_s']:.1f} s")]
    if rows:
        share, rounds = 100 * column("redrawn_points") / column("nodes"), column("rounds")
        table += [("tetrahedra", _spread(column("tetrahedra"), 0)), ("worst quality", _spread(column("worst_quality"), 4)),
                  ("quality at 1 %", _spread(column("quality_1_percent"), 4)), ("median quality", _spread(column("median_quality"), 4)),
                  ("smallest angle", _spread(np.degrees(column("smallest_angle_rad")), 1) + " degrees (dihedral)"),
                  ("largest angle", _spread(np.degrees(column("largest_angle_rad")), 1) + " degrees"),
                  ("redrawn points", f"mean {share.mean():.3f} %, max {share.max():.3f} %"),
                  ("rounds", f"mean {rounds.mean():.1f}, max {rounds.max():.0f}"),
                  *_displacements(rows), *_orientation(base["orientation"], rows),
                  ("time per mesh", _spread(column("mesh_s"), 2) + " s, all checks included")]
    width = max(len(name) for name, _ in table)
    return "".join(f"{name:<{width}}  {text}\n" for name, text in table)


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="crackle-survey", epilog="Exit status: 0 done; 1 usage or input error; 2 some meshes failed.",
        description="Makes the meshes of an input's samples 0 to N - 1 with crackle mesh and prints statistics over them: "
                    "quality, displacements of the nodes, directions of the candidate crack facets, time. Keeps no mesh.")
    parser.add_argument("input", type=Path, metavar="INPUT", help="input file (TOML)")
    parser.add_argument("number", type=int, metavar="N", help="how many, at most ensemble.samples")
    parser.add_argument("--table", type=Path, metavar="FILE", help="also write a CSV file with one line for each mesh")
    parser.add_argument("--program", type=Path, metavar="FILE", help="the program crackle (default: as crackle-report finds it)")
    arguments = parser.parse_args()
    rows: list[dict[str, Any]] = []
    try:
        if arguments.number < 1:
            raise ResultsError("N must be at least 1")
        program = find_program(arguments.program)
        with tempfile.TemporaryDirectory(prefix="crackle-survey-") as folder:
            base = measure(program, arguments.input, 0, Path(folder), undisturbed=True)
            failed = []
            for sample in range(arguments.number):
                try:
                    rows.append(measure(program, arguments.input, sample, Path(folder)))
                except ResultsError as error:
                    print(f"crackle-survey: sample {sample}: {error}", file=sys.stderr)
                    failed.append(dict.fromkeys(COLUMNS, 0) | {"sample": sample})
        print(table_of(base, rows, len(failed)), end="")
        if arguments.table:
            with arguments.table.open("w", newline="") as file:
                writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore", lineterminator="\n")
                writer.writeheader()
                for row in sorted(rows + failed, key=lambda row: row["sample"]):
                    writer.writerow({name: f"{row[name]:.6f}" if isinstance(row[name], float) else row[name] for name in COLUMNS})
    except (ResultsError, OSError) as error:
        print(f"crackle-survey: {error}", file=sys.stderr)
        return 1
    return 2 if failed else 0
