# SPDX-License-Identifier: GPL-3.0-or-later
"""An ensemble's folder."""
from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Iterator, Optional

import h5py
import numpy as np
import pandas as pd
import xarray as xr

from . import labelled
from .files import ENSEMBLE_KIND, SAMPLE_KIND, ResultsError, is_there, open_results, results, sample_files, text_of
from .plots import Plots
from .sample import Sample

if TYPE_CHECKING:
    from .calibration import Calibration
    from .matching import Match
    from .sensitivities import Sensitivities

STATUS = pd.CategoricalDtype(["pending", "done", "failed"])
WITHOUT_PLATE = ("bifurcations", "long_bifurcations", "bifurcations_projected", "kinks")  # counts that a solid does not have


def open(folder: str | Path) -> "Ensemble":
    """The results in an output folder of `crackle run` or `crackle sample`.

    Raises crackle.ResultsError where there are none.
    """
    return Ensemble(Path(folder))


class Ensemble:
    """The samples of an ensemble, by number: `ensemble[3]`, `len(ensemble)`, `for sample in ensemble`.

    A run that is under way is seen as it was when it was opened; open it again for what has come since.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if not folder.is_dir():
            raise ResultsError(f"there is no folder '{folder}'")
        self._files = sample_files(folder)
        self._results = folder / "ensemble.h5"
        self._has_results = is_there(self._results)
        if self._has_results:
            open_results(self._results, ENSEMBLE_KIND).close()
        elif not self._files:
            raise ResultsError(_why_empty(folder))
        self.plot = Plots(self)

    def __repr__(self) -> str:
        count = self.samples["status"].value_counts()
        return f"<crackle.Ensemble '{self.folder}': {count['done']} of {len(self.samples)} samples done, {count['failed']} failed>"

    def __len__(self) -> int:
        return len(self.samples)

    def __getitem__(self, number: int) -> Sample:
        """A sample that has ended. Raises KeyError for any other number."""
        if self._has_results and number not in self.samples.index:
            raise KeyError(f"there is no sample {number!r}; the ensemble has samples 0 to {len(self.samples) - 1}")
        if number not in self._files:
            raise KeyError(f"sample {number} has not ended; those that have: {', '.join(map(str, self._files)) or 'none'}")
        return Sample(self._files[number])

    def __iter__(self) -> Iterator[Sample]:
        """The samples that have ended, in order."""
        return (Sample(file) for file in self._files.values())

    @property
    def done(self) -> list[int]:
        """Numbers of the samples that are done."""
        return [int(i) for i in self.samples.index[self.samples["status"] == "done"]]

    @cached_property
    def input(self) -> str:
        """The input file's text."""
        file, kind = self._any_file()
        with results(file, kind) as root:
            return text_of(root.attrs["input"])

    @cached_property
    def samples(self) -> pd.DataFrame:
        """One row for each sample: its status, its results in SI units (`.attrs["units"]`, `.attrs["meaning"]` by column; words
        for numbers that stand for them), such as "crack_area_in: glass" in several materials, the values of its random inputs by
        key, wall time, and the reason why it failed."""
        rows = self._rows
        columns: dict[str, pd.Series] = {}
        units, meaning = {}, {}
        for name, found in (entry for column in rows.data_vars.values() for entry in labelled.by_part(column).items()):
            if found.dims != ("sample",):
                continue
            values = pd.Series(found.values, index=rows["sample"].values)
            words = dict(entry.split(" ", 1) for entry in found.attrs.get("categories", "").split(", ") if " " in entry)
            if name == "status":
                values = values.map(dict(enumerate(STATUS.categories))).astype(STATUS)
            elif words:
                values = values.map(lambda number, words=words: words.get(str(int(number)), "")).astype("category")
            elif name in WITHOUT_PLATE and (values < 0).any():
                values = values.where(values >= 0)
            columns[str(name)] = values
            units[str(name)], meaning[str(name)] = found.attrs.get("units", ""), found.attrs.get("meaning", "")
        table = pd.DataFrame(columns)
        table.index.name = "sample"
        table.attrs = {"units": units, "meaning": meaning}
        return table

    @cached_property
    def paths(self) -> xr.Dataset:
        """Where and when the cracks cross the sections: sample x notch x section, NaN where they did not arrive."""
        rows = self._rows
        table = rows[[name for name, found in rows.data_vars.items() if found.dims == ("sample", "notch", "section")]]
        with results(*self._any_file()) as root:
            if "crack_path" in root:
                sections = labelled.group(root["crack_path"], ("section", "section_axis"))
                table = table.assign_coords(section=sections["section"], section_axis=sections["section_axis"])
        return table

    @cached_property
    def plane_traces(self) -> pd.DataFrame:
        """Those of all samples that are done, as Sample.plane_traces, with the number of the `sample`."""
        return pd.concat([self[i].plane_traces.assign(sample=i) for i in self._some_done()], ignore_index=True)

    @cached_property
    def fragments(self) -> pd.DataFrame:
        """Those of all samples that are done, as Sample.fragments, with the number of the `sample` and of the `fragment` in it."""
        return pd.concat([self[i].fragments.assign(sample=i).reset_index() for i in self._some_done()], ignore_index=True)

    @cached_property
    def histories(self) -> xr.Dataset:
        """The histories of all samples that are done: sample x moment and further dimensions, as Sample.history. Samples with
        fewer moments or cracks than others end in NaN."""
        padded = [self[i].history.reset_coords() for i in self._some_done()]
        for dimension in ("moment", "crack"):
            longest = max(history.sizes.get(dimension, 0) for history in padded)
            padded = [history.pad({dimension: (0, longest - n)}) if (n := history.sizes.get(dimension, longest)) < longest else history
                      for history in padded]
        together = _together([self._with_constants(one).expand_dims(sample=[number]) for number, one in zip(self.done, padded)])
        return together.set_coords(["time", "phase", "phase_time"])

    def match(self, experiments: str | Path, pictures: bool = False, program: str | Path | None = None) -> "Match":
        """Experiments (a TOML file) beside the samples, as `crackle match` has it: tables `experiments`, `ways` and `together`, `warnings`,
        `plot_path(name)`, the `document` and, by print(), the text.

        @param pictures: compare photographs with the samples' fringes, too, which takes a while
        @param program: the program crackle; by default as crackle-report finds it
        Raises crackle.ResultsError, for wrong experiments with a line for each error.
        """
        from .matching import match
        found = match(self.folder, Path(experiments), Path(program) if program else None)
        if pictures:
            from crackle_report import photographs, reading
            photographs.add_pictures(found.document, reading.read_ensemble(self.folder, program))
        return found

    def calibrate(self, experiments: str | Path, discrepancy: bool = False, between_specimens: Optional[bool] = None,
                  program: str | Path | None = None) -> "Calibration":
        """The random inputs given experiments (a TOML file): `.inputs` has a row for each with its prior and posterior [SI], `.draws` weighted draws from the
        posterior; `print()` shows what `crackle calibrate` does, `.document` what it does with --json, and `.plot()` draws prior and posterior.

        @param discrepancy: allow for a model that is off by an unknown amount in each quantity
        @param between_specimens: allow for specimens that differ by more than meshes and reading do; None: from two experiments on
        Raises crackle.ResultsError, also where there are no random inputs.
        """
        from .calibration import calibrate
        return calibrate(self.folder, experiments, discrepancy, between_specimens, program)

    def sensitivities(self, program: str | Path | None = None) -> "Sensitivities":
        """Effects of the random inputs and of the mesh on results: tables, `print()` and `.plot()`. Raises crackle.ResultsError."""
        from .sensitivities import sensitivities
        return sensitivities(self.folder, program)

    @staticmethod
    def _with_constants(history: xr.Dataset) -> xr.Dataset:
        """What is the same in all samples as coordinates, which are kept once."""
        return history.set_coords([name for name in ("condition_on", "condition_kind", "probe_at") if name in history])

    def _some_done(self) -> list[int]:
        """Numbers of the samples that are done. Raises ResultsError where none is."""
        if not self.done:
            raise ResultsError(f"'{self.folder}': no sample is done")
        return self.done

    def _any_file(self) -> tuple[Path, str]:
        if self._has_results:
            return self._results, ENSEMBLE_KIND
        return next(iter(self._files.values())), SAMPLE_KIND

    @cached_property
    def _rows(self) -> xr.Dataset:
        if not self._has_results:
            return self._rows_of_samples(list(self._files))
        with results(self._results, ENSEMBLE_KIND) as root:
            rows = self._rows_of_ensemble(root)
            n_needed = root["statistics"].attrs.get("n_needed") if "statistics" in root else None
        # When the ensemble has stopped early, what else there is does not belong to it.
        later = self._ended_since(rows) if n_needed in (None, rows.sizes["sample"]) else []
        if not later:
            return rows
        return _together([rows.drop_sel(sample=[i for i in later if i in rows["sample"]]), self._rows_of_samples(later)]).sortby("sample")

    def _ended_since(self, rows: xr.Dataset) -> list[int]:
        """Samples that have ended after ensemble.h5 was written."""
        status = dict(zip(rows["sample"].values.tolist(), rows["status"].values.tolist()))
        later = []
        for number, file in self._files.items():
            known = STATUS.categories[status.get(number, 0)]
            if known == "failed":
                with results(file, SAMPLE_KIND) as root:
                    known = "pending" if int(root.attrs["status"]) != status[number] else known
            if known == "pending":
                later.append(number)
        return later

    def _rows_of_ensemble(self, root: h5py.File) -> xr.Dataset:
        tables = labelled.group(root["samples"], labelled.in_order(root["samples"])).merge(labelled.group(root["timing"]))
        if "inputs" in root["samples"]:
            tables = tables.merge(labelled.group(root["samples/inputs"]))
        n = root["samples/status"].shape[0]
        shape = root["crack_path/position"].shape
        # `z` repeats the sections across y, and may have fewer.
        paths = {name: xr.DataArray(dataset[...], dims=("sample", "notch", "section"), attrs=labelled.array(dataset).attrs)
                 for name, dataset in labelled.datasets(root["crack_path"]).items() if dataset.shape == shape and name != "section_line"}
        # Files of older versions do not name their dimensions.
        renamed = {name: "sample" for name in tables.dims if str(name).startswith("dimension_")}
        return tables.rename(renamed).assign(paths).assign_coords(sample=np.arange(n))

    def _rows_of_samples(self, numbers: list[int]) -> xr.Dataset:
        """Of samples that have ended, whether or not the run has written its results; of failed ones most is missing."""
        rows = []
        for number in numbers:
            with results(self._files[number], SAMPLE_KIND) as root:
                summary = labelled.group(root["summary"], labelled.in_order(root["summary"]))
                if "inputs" in root["summary"]:
                    summary = summary.merge(labelled.group(root["summary/inputs"]))
                summary = summary.assign(status=int(root.attrs["status"]), error=text_of(root.attrs["error"]),
                                         wall_time=root["timing/wall_time"][()])
            rows.append(summary.expand_dims(sample=[number]))
        return _together(rows)


def _why_empty(folder: Path) -> str:
    if (folder / "sweep.toml").is_file():
        cases = sorted(case.name for case in folder.glob("case-*"))
        return f"'{folder}' holds a sweep; open one of its cases" + (f": {', '.join(cases)}" if cases else "")
    if (folder / "input.toml").is_file():
        return f"'{folder}' holds no results yet: no sample has ended"
    return f"'{folder}' holds no results: neither ensemble.h5 nor samples"


def _together(rows: list[xr.Dataset]) -> xr.Dataset:
    """One table of all samples; NaN where one lacks what another has."""
    columns = {name: column for table in reversed(rows) for name, column in table.data_vars.items()}
    whole = [table.assign({name: xr.full_like(column.isel(sample=[0] * table.sizes["sample"]), np.nan, dtype=float)
                           .assign_coords(sample=table["sample"]) for name, column in columns.items() if name not in table})
             for table in rows]
    return xr.concat(whole, "sample", data_vars="all", combine_attrs="override", fill_value=np.nan)
