# SPDX-License-Identifier: GPL-3.0-or-later
"""Photographs of fringes beside the samples' fringes at the same times: the quantity "pictures" of a match."""
from __future__ import annotations

import hashlib
import io
import time
import zipfile
from dataclasses import dataclass, replace
from typing import Any, Callable, Optional, Sequence

import numpy as np
from crackle.files import ResultsError
from crackle.text import count, quantity
from PIL import Image
from scipy.ndimage import gaussian_filter, map_coordinates

from .mesh import Mesh
from .options import Options
from .photoelasticity import NO_FRINGES, Fringes, Grid, Optics, make_series
from .plate import Plate
from .fields import Frames
from .results import Ensemble
from .stress import frame_stress
from .writing import write_whole

PIXELS_PER_SPACING, MOST_PIXELS, FEWEST_ACROSS = 3, 20_000, 8  # of the pictures that are compared
N_NEAREST = 5
SAVE_EVERY = 20.0  # [s]
ROUNDING = 1e-9


@dataclass(frozen=True)
class Photograph:
    """A picture of an experiment, placed in the body."""

    grey: np.ndarray  # rows from the top, between 0 and 1
    time: float  # since the crack began to run [s]
    light_field: bool
    reversed: bool  # colours
    corner: np.ndarray  # y, z of the upper left corner [m]
    steps: np.ndarray  # 2 x 2: y, z of a step of one pixel downwards, and of one to the right

    @classmethod
    def of(cls, found: dict[str, Any]) -> "Photograph":
        """From a member of "pictures" in the JSON document of `crackle match`. Raises ResultsError."""
        try:
            with Image.open(found["file"]) as image:
                grey = np.asarray(image if image.mode.startswith("I") else image.convert("L"), float)
        except (OSError, Image.DecompressionBombError) as error:
            raise ResultsError(f"cannot read '{found['file']}': {error}") from error
        return cls(grey / max(grey.max(), 1.0), found["time"], found["light_field"], found["reversed"], np.array(found["corner"]),
                   np.array([found["down"], found["right"]]))

    @property
    def pixel(self) -> float:
        """Its size [m]."""
        return float(np.linalg.norm(self.steps[1]))

    @property
    def ends(self) -> np.ndarray:
        """The least and the greatest y, z in it."""
        height, width = self.grey.shape
        corners = self.corner + np.array([(0, 0), (height, 0), (0, width), (height, width)]) @ self.steps
        return np.array([corners.min(axis=0), corners.max(axis=0)])

    def on(self, grid: Grid) -> np.ndarray:
        """Its grey values at the grid's pixels; NaN outside of it."""
        places = np.stack(np.meshgrid(grid.y, grid.z), axis=-1) - self.corner
        smooth = gaussian_filter(self.grey, max(0.0, grid.pixel / self.pixel - 1) / 2)
        return map_coordinates(smooth, np.moveaxis(places @ np.linalg.inv(self.steps), -1, 0) - 0.5, order=1, cval=np.nan)


def photographs_of(experiment: dict[str, Any]) -> list[Photograph]:
    """Those of an experiment in the document of `crackle match`, in order of time."""
    return sorted(map(Photograph.of, experiment["observed"]["pictures"]), key=lambda photograph: photograph.time)


def leave_out_damaged(document: dict[str, Any]) -> list[str]:
    """Takes photographs that cannot be read out of a document of `crackle match`; returns why."""
    damage = []
    for observed in (experiment["observed"] for experiment in document["experiments"]):
        readable = []
        for found in observed["pictures"]:
            try:
                Photograph.of(found)
                readable.append(found)
            except ResultsError as error:
                damage.append(str(error))
        observed["pictures"] = readable
    return damage


def window(photographs: Sequence[Photograph], plate: Plate, beyond: float = 0.0) -> tuple[tuple[float, float], tuple[float, float]]:
    """The part of the body that they show, with so much around it: ranges of y and of z [m]. Raises ResultsError when it is nothing."""
    ends = np.array([photograph.ends for photograph in photographs])
    body = np.array([plate.ends(1), plate.ends(2)]).T + np.array([[-beyond], [beyond]])
    low, high = np.maximum(ends[:, 0].min(axis=0), body[0]), np.minimum(ends[:, 1].max(axis=0), body[1])
    if (low >= high).any():
        y, z = ((f"{1e3 * low:.4g} to {1e3 * high:.4g} mm") for low, high in zip(ends[:, 0].min(axis=0), ends[:, 1].max(axis=0)))
        raise ResultsError(f"pictures that show y = {y}, z = {z} show nothing of the body; set their scale and origin")
    return (float(low[0]), float(high[0])), (float(low[1]), float(high[1]))


def nearest_frames(frames: Frames, photographs: Sequence[Photograph]) -> list[int]:
    """The frame nearest in time to each photograph; frames count from the onset."""
    return [int(np.abs(frames.time - photograph.time).argmin()) for photograph in photographs]


def latest(frames: Frames) -> float:
    """Until when photographs have a frame as near as between frames [s]."""
    return float(frames.time[-1] + (frames.time[-1] - frames.time[-2]) / 2 if frames.time.size > 1 else frames.time[-1])


def fringes_at(frames: Frames, chosen: Sequence[int], grid: Grid, optics: Optics) -> list[Fringes]:
    """The fringes of a sample at these frames, of which some may be the same."""
    corner = frames.nodes[frames.tetrahedra][:, :, 1:]
    margin = np.array([[grid.y[0], grid.z[0]], [grid.y[-1], grid.z[-1]]]) + grid.pixel * np.array([[-1], [1]])
    near = ((corner.max(axis=1) > margin[0]) & (corner.min(axis=1) < margin[1])).all(axis=1)
    needed = sorted(set(chosen))
    optics = replace(optics, stress_optic=np.broadcast_to(optics.stress_optic, len(near))[near])
    series = make_series(frames.nodes, frames.tetrahedra[near], [frame_stress(frames, k)[near] for k in needed], grid, optics)
    return [series[needed.index(k)] for k in chosen]


def add_pictures(document: dict[str, Any], ensemble: Ensemble, options: Options = Options(),
                 progress: Callable[[str], None] = lambda text: None) -> None:
    """Adds "pictures" to "by" of each experiment with pictures, in the form of the other quantities; a warning where no fringes can
    be made, or photographs are later than all frames.

    The distance of two pictures is one minus the correlation of their grey values, smoothed over a spacing of the mesh, so that
    brightness and contrast do not count; that of an experiment and a sample is the mean over the experiment's pictures. Fringes
    that have been made are kept in the folder "report" of the ensemble, where there is one. Raises ResultsError.

    @param document of `crackle match --json`
    """
    comparisons = [_Comparison(experiment, ensemble, options) for experiment in document["experiments"]
                   if experiment["observed"]["pictures"]]
    numbers = [loads["sample"] for loads in document["samples"]["loads"]] if comparisons else []
    if any(frames is not None and options.optics(frames) is None for frames in map(ensemble.files.frames, numbers[:1])):
        document["warnings"].append("photographs are not compared with fringes: " + NO_FRINGES)
        return
    saved = time.monotonic()
    for k, number in enumerate(numbers):
        frames = None
        for comparison in comparisons:
            if not comparison.has(number):
                frames = frames or ensemble.files.frames(number)
                comparison.add(number, frames)
        if frames is not None:
            progress(f"fringes of {k + 1} of {len(numbers)} samples")
        if time.monotonic() > saved + SAVE_EVERY or k + 1 == len(numbers):
            for comparison in comparisons:
                comparison.save()
            saved = time.monotonic()
    for comparison in comparisons:
        comparison.experiment["by"]["pictures"] = comparison.result(numbers)
        document["warnings"] += comparison.warnings(numbers)


class _Comparison:
    """The photographs of one experiment and the fringes of samples, on one grid."""

    def __init__(self, experiment: dict[str, Any], ensemble: Ensemble, options: Options) -> None:
        self.experiment, self._files, self._options = experiment, ensemble.files, options
        self._photographs = photographs_of(experiment)
        y_range, z_range = window(self._photographs, ensemble.plate)
        spacing = _spacing(next((mesh for number in ensemble.done if (mesh := ensemble.files.mesh(int(number)))), None), y_range, z_range)
        sizes = np.ptp([y_range, z_range], axis=1)
        pixel = min(max(spacing / PIXELS_PER_SPACING, np.sqrt(sizes.prod() / MOST_PIXELS)), sizes.min() / FEWEST_ACROSS)
        self._grid = Grid.over(y_range, z_range, pixel)
        self._sigma = spacing / 2 / self._grid.pixel
        self._images: dict[int, np.ndarray] = {}  # pictures x rows x columns of each sample, smoothed
        self._latest: dict[int, float] = {}  # likewise, as latest()
        asked = (self._grid.y.tolist(), self._grid.z.tolist(), spacing, options.stress_optic, options.wavelength, options.product,
                 [(p.time, p.light_field, p.reversed) for p in self._photographs])
        self._file = ensemble.folder / "report" / f"fringes-{hashlib.sha1(repr(asked).encode()).hexdigest()[:12]}.npz"
        self._is_new = False
        self._load()

    def has(self, number: int) -> bool:
        return number in self._images

    def add(self, number: int, frames: Optional[Frames]) -> None:
        """Makes the fringes of a sample; nothing where it has no frames."""
        optics = self._options.optics(frames) if frames is not None and frames.time.size else None
        if optics is None:
            return
        made = fringes_at(frames, nearest_frames(frames, self._photographs), self._grid, optics)
        self._images[number] = np.array([self._smooth(fringes.intensity(p.light_field, self._options.product, p.reversed))
                                         for p, fringes in zip(self._photographs, made)], np.float32)
        self._latest[number] = latest(frames)
        self._is_new = True

    def warnings(self, numbers: list[int]) -> list[str]:
        """Which photographs are later than the frames of samples."""
        latest_of = [self._latest[number] for number in numbers if number in self._latest]
        late = [(photograph.time, sum(photograph.time > one for one in latest_of)) for photograph in self._photographs]
        return [f"the photograph of {self.experiment['name']} at {quantity(time, 's', 3)} is later than the last frame of {n} of "
                f"{count(len(latest_of), 'sample')}: it is compared with that frame" for time, n in late if n]

    def result(self, numbers: list[int]) -> dict[str, Any]:
        """Rank p value, distances and the nearest ones of these samples."""
        used = [number for number in numbers if number in self._images]
        found = {"p_value": 1.0, "least_p_value": 1 / (len(used) + 1), "n_samples": len(used),
                 "left_out": [number for number in numbers if number not in self._images], "unit": "1",
                 "mean_distance": np.nan, "usual_distance": np.nan, "nearest": []}
        if not used:
            return found
        distance = np.mean([self._distances(k, used) for k in range(len(self._photographs))], axis=0)
        means = distance.sum(axis=1) / len(used)
        order = np.argsort(distance[0, 1:], kind="stable")[:N_NEAREST]
        return {**found, "p_value": float(np.mean(means >= means[0] - ROUNDING)), "mean_distance": float(means[0]),
                "usual_distance": float(np.median(means[1:])),
                "nearest": [{"sample": used[k], "distance": float(distance[0, k + 1])} for k in order]}

    def _distances(self, k: int, used: list[int]) -> np.ndarray:
        """Between all two of photograph k and the samples' fringes, the photograph first."""
        samples = np.array([self._images[number][k] for number in used], float)
        body = np.isfinite(samples).all(axis=0)
        photograph = self._smooth(np.where(body, self._photographs[k].on(self._grid), np.nan))
        seen = body & np.isfinite(photograph)
        values = np.array([photograph[seen], *samples[:, seen]])
        values -= values.mean(axis=1, keepdims=True)
        size = np.linalg.norm(values, axis=1, keepdims=True)
        values /= np.where(size > 0, size, 1)
        distance = 1 - values @ values.T
        np.fill_diagonal(distance, 0)
        return distance

    def _smooth(self, image: np.ndarray) -> np.ndarray:
        """Over a spacing, with nothing from outside of the body."""
        inside = np.isfinite(image)
        weight = gaussian_filter(inside.astype(float), self._sigma)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(inside, gaussian_filter(np.where(inside, image, 0.0), self._sigma) / weight, np.nan)

    def _identity(self, number: int) -> list[int]:
        found = self._files.files[number].stat()
        return [found.st_size, found.st_mtime_ns]

    def _load(self) -> None:
        try:
            with np.load(self._file) as kept:
                for number, identity, image, until in zip(*(kept[name] for name in ("sample", "identity", "image", "latest"))):
                    if number in self._files.files and self._identity(number) == identity.tolist():
                        self._images[int(number)], self._latest[int(number)] = image, float(until)
        except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile):
            pass  # there are none yet, or no usable ones

    def save(self) -> None:
        """Keeps the fringes, where there is a folder that can be written to."""
        if not self._is_new or not self._file.parent.is_dir():
            return
        content = io.BytesIO()
        np.savez(content, sample=list(self._images), identity=[self._identity(number) for number in self._images],
                 image=np.array(list(self._images.values())), latest=[self._latest[number] for number in self._images])
        try:
            write_whole(self._file, content.getvalue())
        except OSError:
            pass
        self._is_new = False


def _spacing(mesh: Optional[Mesh], y_range: tuple[float, float], z_range: tuple[float, float]) -> float:
    """Edge of a regular tetrahedron of the size in which half of the volume in the window is [m]. Raises ResultsError."""
    if mesh is None:
        raise ResultsError("pictures are compared with the fields in the sample files, and there are none")
    middle = mesh.nodes[mesh.tetrahedra][:, :, 1:].mean(axis=1)
    inside = ((middle > (y_range[0], z_range[0])) & (middle < (y_range[1], z_range[1]))).all(axis=1)
    volume = np.sort(mesh.volumes()[inside if inside.any() else slice(None)])
    return float((6 * np.sqrt(2) * volume[np.searchsorted(volume.cumsum(), volume.sum() / 2)]) ** (1 / 3))
