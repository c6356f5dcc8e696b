# SPDX-License-Identifier: GPL-3.0-or-later
"""Experiments: a TOML file, and the CSV files and pictures that it names."""
from __future__ import annotations

import difflib
import math
import re
import textwrap
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Callable, Iterator, Optional

import numpy as np
from scipy import stats

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib  # type: ignore[no-redef]

from . import quantities
from .files import ResultsError

MOST_ERRORS = 10  # of a CSV file; the rest is probably of the same kind
MOST_BYTES = 1 << 27  # of a CSV file
MOST_TEXT = 1 << 17  # of the TOML file
SLOPE_RANGE = (0.1, 0.5)  # of the peak load, in which a curve counts as straight


class ExperimentsError(ResultsError):
    """Errors in an experiments file; `messages` has one for each, which names file, line, key and what is accepted."""

    def __init__(self, messages: list[str]) -> None:
        super().__init__("\n".join(messages))
        self.messages = messages


@dataclass
class Picture:
    """A picture of the crack or of fringes, whose axes are the experiment's y to the right and z upwards."""
    file: Path = Path()
    width: int = 0  # pixels
    height: int = 0
    time: float = 0.0  # since the crack began to run [s]
    scale: float = 0.0  # m per pixel
    origin: np.ndarray = field(default_factory=lambda: np.zeros(2))  # of the experiment's axes: pixels from left and top
    corner: np.ndarray = field(default_factory=lambda: np.zeros(2))  # place of the upper left corner in the body [m]
    right: np.ndarray = field(default_factory=lambda: np.zeros(2))  # steps from pixel to pixel [m]
    down: np.ndarray = field(default_factory=lambda: np.zeros(2))
    light_field: bool = False
    reversed: bool = False  # colours


@dataclass
class Experiment:
    """One experiment; all parts are optional. Places are in the body's axes (y, z), all values in SI units."""
    name: str = ""
    lines: list[np.ndarray] = field(default_factory=list)  # arms of the crack: n x 2 [m]; the first is compared
    path_error: float = 0.0  # standard deviation of the points as read [m]
    path_error_length: float = 0.0  # correlation length of that error along the path [m]
    arrested: bool = False  # the crack ends where its path ends
    onset_load: Optional[float] = None  # [N]
    peak_load: Optional[float] = None  # [N]; of a run-out the largest that was borne
    run_out: bool = False  # it did not break
    load_error: float = 0.0  # standard deviation [N]
    tip_times: np.ndarray = field(default_factory=lambda: np.zeros(0))  # [s]
    tip_places: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))  # [m]
    time_error: float = 0.0  # standard deviation [s]
    pictures: list[Picture] = field(default_factory=list)
    curve: Optional[tuple[np.ndarray, np.ndarray]] = None  # displacement [m] and load [N]
    stiffness: Optional[float] = None  # of the specimen, from the curve's initial slope [N/m]
    stiffness_error: float = 0.0  # standard deviation [N/m]


@dataclass
class _Draft:
    """What an [[experiment]] says, before the files are read that it names."""
    experiment: Experiment = field(default_factory=Experiment)
    origin: np.ndarray = field(default_factory=lambda: np.zeros(2))
    angle: float = 0.0
    mirror: str = "none"
    scale: float = 0.0  # of a pixel [m]
    pixel_origin: np.ndarray = field(default_factory=lambda: np.zeros(2))
    load_per_strength: float = 0.0
    machine_compliance: Optional[float] = None
    path: str = ""
    tips: str = ""
    curve: str = ""
    loads: str = ""

    def in_body(self, points: Any) -> np.ndarray:
        """Places in the experiment's axes (n x 2), in those of the body."""
        y, z = (np.asarray(points, float) * (-1 if self.mirror == "y" else 1, -1 if self.mirror == "z" else 1)).T
        c, s = math.cos(self.angle), math.sin(self.angle)
        return np.stack([self.origin[0] + c * y - s * z, self.origin[1] + s * y + c * z], axis=-1)


# Keys.

@dataclass(frozen=True)
class Dimension:
    name: str
    unit: str
    example: str


LENGTH, TIME = Dimension("a length", "m", "1.0 mm"), Dimension("a time", "s", "5 ns")
FORCE, STRESS = Dimension("a force", "N", "135 N"), Dimension("a stress", "Pa", "35 MPa")
COMPLIANCE = Dimension("a compliance", "m/N", "0.2 um/N")
AREA, ANGLE = Dimension("an area", "m^2", "2.5 mm^2"), Dimension("an angle", "radian", "30 degree")
PLACE = 'two lengths, y and z, such as ["12.25 mm", "70 mm"]'
PIXELS = "two numbers of pixels, from the left and from the top, such as [120, 480]"
NAME = 'a text of 1 to 60 characters without "/" or control characters, such as "plate 3"'
PICTURE = "the name of a PNG or JPEG file"


@dataclass(frozen=True)
class Key:
    """`read(source)` returns a value or None, having reported why; `store(target, value)` keeps it."""
    name: str
    accepted: str
    help: str
    read: Callable[["_Source"], Any]
    store: Callable[[Any, Any], None]
    unset: str = ""  # what it means not to give it; empty: it is required
    unless: str = ""  # the key that may stand instead of a required one


class _Number(float):
    """A number with its text in the file."""
    text = ""


def _number(text: str) -> _Number:
    value = _Number(text)
    value.text = text
    return value


def shortened(text: str, most: int = 60) -> str:
    """One line of printable text."""
    line = "".join(" " if c in "\n\t" else c if c.isprintable() else "?" for c in text)
    return line if len(line.encode()) <= most else line.encode()[:most].decode(errors="ignore") + "..."


class _Source:
    """A value with its key, for messages."""

    def __init__(self, value: Any, key: str, findings: "_Findings") -> None:
        self.value, self.key, self.findings = value, key, findings

    def report(self, message: str) -> None:
        self.findings.report(self.key, message)

    @property
    def text(self) -> str:
        if isinstance(self.value, str):
            return f'"{shortened(self.value)}"'
        return str(self.value).lower() if isinstance(self.value, bool) else getattr(self.value, "text", str(self.value))

    @property
    def given(self) -> str:
        kinds = ((bool, "a boolean"), ((int, float), "a plain number"), (str, "a string"), (list, "an array"), (dict, "a table"))
        kind = next((name for types, name in kinds if isinstance(self.value, types)), "a date")
        return f"this is {kind}" if isinstance(self.value, (list, dict)) else f"{self.text} is {kind}"

    def quantity(self, dimension: Dimension, lower: float, upper: float, accepted: str, is_open: bool = False) -> Optional[float]:
        if isinstance(self.value, (int, float)) and not isinstance(self.value, bool):
            return self.report(f"{self.text} is a plain number without a unit; give {dimension.name} with its unit, in quotes, such as "
                               f'"{dimension.example}"')
        advice = f'; give {dimension.name} such as "{dimension.example}"'
        if not isinstance(self.value, str):
            return self.report(self.given + advice)
        try:
            value = quantities.read(self.value, dimension.unit)
        except quantities.QuantityError as error:
            return self.report({"no number": f"{self.text} is not a number with a unit{advice}", "no unit": f"{self.text} has no unit{advice}",
                                "unknown unit": f'{self.text} has the unknown unit "{shortened(error.unit)}"{advice}',
                                "wrong dimension": f"{self.text} does not have the dimension of {dimension.name}{advice}",
                                "not finite": f"{self.text} is not a finite number; give {accepted}"}[error.reason])
        if not (lower < value <= upper if is_open else lower <= value <= upper):
            return self.report(f"{self.text} is out of range; give {accepted}")
        return value

    def number(self, lower: float, upper: float) -> Optional[float]:
        accepted = f"a number from {lower:.10g} to {upper:.10g}"
        if not isinstance(self.value, (int, float)) or isinstance(self.value, bool):
            return self.report(f"{self.given}; give {accepted}, without quotes")
        if not math.isfinite(self.value):
            return self.report(f"{self.text} is not a finite number; give {accepted}")
        return float(self.value) if lower <= self.value <= upper else self.report(f"{self.text} is out of range; give {accepted}")

    def word(self, accepted: str) -> Optional[str]:
        if not isinstance(self.value, str) or not self.value:
            return self.report(f"{'the string is empty' if self.value == '' else self.given}; give {accepted}")
        return self.value

    def name(self) -> Optional[str]:
        name = self.word(NAME)
        if name is None:
            return None
        if len(name.encode()) > 60:
            return self.report(f"has {len(name.encode())} characters; give {NAME}")
        if any(ord(c) < 32 or ord(c) == 127 for c in name) or "/" in name or name in (".", ".."):
            return self.report(f"{self.text} cannot be used; give {NAME}")
        return name

    def choice(self, words: tuple[str, ...]) -> Optional[str]:
        accepted = " or ".join([", ".join(f'"{word}"' for word in words[:-1]), f'"{words[-1]}"'])
        if not isinstance(self.value, str):
            return self.report(f"{self.given}; give {accepted}")
        return self.value if self.value in words else self.report(f"{self.text} is not known; give {accepted}")

    def flag(self) -> Optional[bool]:
        return self.value if isinstance(self.value, bool) else self.report(f"{self.given}; give true or false, without quotes")

    def pair(self, form: str, read: Callable[["_Source"], Optional[float]]) -> Optional[np.ndarray]:
        if not isinstance(self.value, list):
            return self.report(f"{self.given}; give {form}")
        if len(self.value) != 2:
            n = len(self.value)
            return self.report(f"the array has {n} element{'' if n == 1 else 's'}; give {form}")
        both = [read(_Source(value, f"{self.key}[{i}]", self.findings)) for i, value in enumerate(self.value)]
        return None if None in both else np.array(both, float)


def _quantity(name: str, dimension: Dimension, lower: float, upper: float, between: str, example: str, help: str, store: Any,
              is_open: bool = False, **how: str) -> Key:
    of = replace(dimension, example=example)
    accepted = f'{dimension.name} {between}, such as "{example}"'
    return Key(name, accepted, help, lambda source: source.quantity(of, lower, upper, accepted, is_open), store, **how)


def _place(name: str, help: str, store: Any, **how: str) -> Key:
    accepted = 'a length from -1 km to 1 km, such as "1.0 mm"'
    return Key(name, PLACE, help, lambda source: source.pair(PLACE, lambda one: one.quantity(LENGTH, -1e3, 1e3, accepted)), store, **how)


def _pixels(name: str, help: str, store: Any, **how: str) -> Key:
    return Key(name, PIXELS, help, lambda source: source.pair(PIXELS, lambda one: one.number(-1e6, 1e6)), store, **how)


def _flag(name: str, help: str, store: Any, unset: str) -> Key:
    return Key(name, "true", help, lambda source: source.flag(), store, unset=unset)


def _file(name: str, header: str, help: str, unset: str) -> Key:
    accepted = f'the name of a CSV file with the header {header}, such as "{name}.csv"'
    return Key(name, accepted, help, lambda source: source.word(accepted), _to(name), unset=unset)


def _to(name: str) -> Callable[[Any, Any], None]:
    return lambda target, value: setattr(target, name, value)


def _of(name: str) -> Callable[[_Draft, Any], None]:
    return lambda draft, value: setattr(draft.experiment, name, value)


def _measured(source: _Source) -> Optional[tuple[Path, int, int]]:
    name = source.word(PICTURE)
    if name is None:
        return None
    file = source.findings.folder / name
    try:
        return (file, *picture_size(file))
    except ValueError as error:
        return source.report(f"{shortened(str(file), 200)}: {error}; give {PICTURE}")


def _store_picture(picture: Picture, found: tuple[Path, int, int]) -> None:
    picture.file, picture.width, picture.height = found


def _time(store: Any) -> Key:
    return _quantity("time", TIME, 0, 1e3, "from 0 to 1000 s", "40 us", "since the crack began to run", store)


_FORCES = (FORCE, 0, 1e12, "from 0 to 1e+12 N")
_LOADS = (_file("loads", "peak_load_N, onset_load_N or strength_MPa, or other units; a column name names the rows, run_out has yes "
                "where a specimen did not break", "loads of many experiments, one in each row", "one experiment"),
          _quantity("load_error", *_FORCES, "135 N", "standard deviation of measured loads", _of("load_error"), unset="loads are exact"),
          _quantity("load_per_strength", AREA, 0, 1e6, "above 0 and up to 1000000 m^2", "2.5 mm^2",
                    "load over strength, where loads are given as strengths", _to("load_per_strength"), is_open=True,
                    unset="loads are given as forces"))
TABLES: dict[str, tuple[Key, ...]] = {
    "": _LOADS,
    "experiment": (
        Key("name", NAME, "its name", lambda source: source.name(), _of("name"), unless="loads"),
        _file("path", "y_mm,z_mm", "the crack's path, from where it began; several arms, the compared one first, are separated by blank "
              "lines or told apart by a column arm; with scale in pixels, y_px,z_px, from left and top", "the path was not observed"),
        _quantity("path_error", LENGTH, 0, 1e3, "from 0 to 1 km", "0.2 mm", "standard deviation of the points as read", _of("path_error"),
                  unset="points are exact"),
        _quantity("path_error_length", LENGTH, 1e-9, 1e3, "from 1 nm to 1 km", "2 mm", "correlation length of that error along the path",
                  _of("path_error_length"), unset="the mean distance of the points"),
        _flag("arrested", "true if the crack ended where the path ends", _of("arrested"), "it runs on outside the picture, or through the body"),
        _quantity("scale", LENGTH, 1e-9, 1, "from 1 nm to 1 m", "0.05 mm", "length of one pixel of a path in pixels", _to("scale"),
                  unset="the path has units of length"),
        _pixels("pixel_origin", "where the experiment's origin is in these pixels", _to("pixel_origin"), unset="[0, 0]"),
        _place("origin", "where the origin of the files lies in the body", _to("origin"), unset="the same origin"),
        _quantity("angle", ANGLE, -2 * math.pi, 2 * math.pi, "from -360 degree to 360 degree", "30 degree",
                  "of the files' y axis in the body, from y towards z", _to("angle"), unset="0"),
        Key("mirror", '"none", "y" or "z"', "axis of the files that is reversed, before they are turned",
            lambda source: source.choice(("none", "y", "z")), _to("mirror"), unset='"none"'),
        _quantity("onset_load", *_FORCES, "134 N", "load at which the crack began to run", _of("onset_load"), unset="not measured"),
        _quantity("peak_load", *_FORCES, "135 N", "largest load", _of("peak_load"), unset="the largest load of curve, if that is given"),
        _flag("run_out", "true if the specimen bore peak_load without breaking", _of("run_out"), "it broke"),
        _LOADS[1],
        _file("curve", "displacement_mm,load_N", "load over displacement", "not measured"),
        _quantity("machine_compliance", COMPLIANCE, 0, 1, "from 0 to 1 m/N", "0.2 um/N", "of the machine, 0 where the displacement is the specimen's; "
                  "the initial slope of curve is then compared", _to("machine_compliance"), unset="the slope is not compared"),
        _LOADS[0], _LOADS[2],
        _file("tips", "time_us,y_mm,z_mm", "places of the crack's tip at times since it began to run", "not observed"),
        _quantity("time_error", TIME, 0, 1e3, "from 0 to 1000 s", "1 us", "standard deviation of the times", _of("time_error"),
                  unset="times are exact")),
    "experiment.tip": (_time(lambda tip, value: tip.update(time=value)),
                       _place("at", "place of the tip, in the axes of the files", lambda tip, value: tip.update(at=value))),
    "experiment.picture": (
        Key("file", PICTURE, "the picture", _measured, _store_picture), _time(_to("time")),
        _quantity("scale", LENGTH, 1e-9, 1, "from 1 nm to 1 m", "0.05 mm", "length of one pixel", _to("scale")),
        _pixels("origin", "where the experiment's origin is in the picture", _to("origin")),
        Key("field", '"light" or "dark"', "of the polariscope", lambda source: source.choice(("light", "dark")),
            lambda picture, value: setattr(picture, "light_field", value == "light"), unset='"dark"'),
        _flag("reversed", "true if the colours are reversed", _to("reversed"), "no"))}
LISTS = {"experiment", "experiment.tip", "experiment.picture"}


# Errors and their lines.

class _Findings:
    def __init__(self, file: Path, text: str = "") -> None:
        self.file, self.folder, self.lines = file, file.parent, _lines_of(text)
        self.found: list[tuple[int, str, str]] = []

    def report(self, key: str, message: str, line: Optional[int] = None) -> None:
        place = key
        while place and place not in self.lines:
            place = place[:max(place.rfind("."), place.rfind("["), 0)]
        self.found.append((line if line is not None else self.lines.get(place, 1), key, message))

    def faulty(self, key: str) -> bool:
        def is_inside(one: str, other: str) -> bool:
            return one == other or other == "" or one.startswith((other + ".", other + "["))
        return any(is_inside(key, found) or is_inside(found, key) for _, found, _ in self.found)

    def raise_if_any(self) -> None:
        if self.found:
            raise ExperimentsError([shortened(f"{self.file}:{line}: {key + ': ' if key else ''}{message}", 100_000)
                                    for line, key, message in sorted(self.found, key=lambda one: one[0])])


def _lines_of(text: str) -> dict[str, int]:
    """The line of each key and table, "experiment[0].path", as far as each has its own; comments and strings of several lines,
    which look like keys only on purpose, are not told apart."""
    lines: dict[str, int] = {}
    counts: dict[str, int] = {}
    table = ""
    for number, line in enumerate(text.split("\n"), 1):
        if header := re.match(r"\s*(\[\[?)\s*([\w.\-\"' ]+?)\s*\]", line):
            parts, table = header[2].replace(" ", "").split("."), ""
            for i, part in enumerate(parts):
                table = f"{table}.{part}" if table else part
                if header[1] == "[[" and i == len(parts) - 1:
                    counts[table] = counts.get(table, -1) + 1
                if table in counts:
                    lines.setdefault(table, number)
                    table = f"{table}[{counts[table]}]"
            lines.setdefault(table, number)
        elif key := re.match(r"\s*([\w\-\"']+(?:\s*\.\s*[\w\-\"']+)*)\s*=", line):
            path = table
            for part in re.sub(r"[\s\"']", "", key[1]).split("."):
                path = f"{path}.{part}" if path else part
                lines.setdefault(path, number)
    return lines


def _report_unknown(table: dict, path: str, key: str, findings: _Findings) -> None:
    known = [one.name for one in TABLES[path]] + [name.split(".")[-1] for name in LISTS if name.rpartition(".")[0] == path]
    for name, value in table.items():
        its_path, its_key = (f"{path}.{name}" if path else name), (f"{key}.{name}" if key else name)
        if its_path in LISTS:
            if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
                findings.report(its_key, f"this is a list of tables; write [[{its_path}]], in double brackets")
                continue
            for i, one in enumerate(value):
                _report_unknown(one, its_path, f"{its_key}[{i}]", findings)
        elif name not in known:
            meant = next(iter(difflib.get_close_matches(name, known, 1, 0.5)), None)
            elsewhere = next((f"{other}.{name}" for other, keys in TABLES.items() if other and name in [one.name for one in keys]), None)
            is_table = isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict))
            findings.report(its_key, f"unknown {'table' if is_table else 'key'}; "
                            + (f"did you mean {meant or elsewhere}?" if meant or elsewhere else f"known here: {', '.join(known)}"))


def _read_table(path: str, table: dict, key: str, target: Any, findings: _Findings) -> Any:
    for one in TABLES[path]:
        name = f"{key}.{one.name}" if key else one.name
        if one.name in table:
            if (value := one.read(_Source(table[one.name], name, findings))) is not None:
                one.store(target, value)
        elif not one.unset and one.unless not in table:
            findings.report(name, f"the key is missing; give {one.accepted}")
    return target


def _tables(table: dict, name: str) -> Iterator[tuple[int, dict]]:
    given = table.get(name)
    return ((i, one) for i, one in enumerate(given if isinstance(given, list) else []) if isinstance(one, dict))


# CSV files.

class _Csv:
    def __init__(self, file: Path) -> None:
        self.header: list[str] = []
        self.rows: list[tuple[int, int, list[str]]] = []  # line, block of rows between blank lines, cells
        self.errors: list[str] = []
        try:
            self._read(file)
        except OSError as error:
            self.add("there is no such file" if isinstance(error, FileNotFoundError) else "cannot be read")

    def add(self, message: str, line: int = 0) -> None:
        if len(self.errors) < MOST_ERRORS:
            self.errors.append(f"line {line}: {message}" if line else message)

    def _read(self, file: Path) -> None:
        if (kind := other_kind(file)) or file.stat().st_size > MOST_BYTES:
            return self.add(f"is {kind}" if kind else f"is larger than {MOST_BYTES} bytes")
        separator, block, was_blank = ",", 0, False
        for number, data in enumerate(file.read_bytes().split(b"\n"), 1):
            line = data.decode("utf-8", errors="replace").removeprefix("\ufeff" if number == 1 else "")
            if b"\0" in data:
                return self.add("not text in UTF-8, but perhaps in UTF-16; save the file as CSV in UTF-8", number)
            if line.startswith("#"):
                continue
            if not line.strip(" \t\r,;"):
                was_blank = True
                continue
            if not self.header:
                separator = next((one for one in ";\t" if one in line), ",")
            cells = [re.sub(r'^"(.*)"$', r"\1", shortened(cell.strip(" \t\r"), 100_000)) for cell in line.split(separator)]
            if not self.header:
                self.header = cells
                for name in sorted({name for name in cells if name and cells.count(name) > 1}):
                    self.add(f'two columns are called "{shortened(name)}"; leave one of them out', number)
            elif len(cells) != len(self.header):
                n, heads = len(cells), len(self.header)
                self.add(f"has {n} value{'' if n == 1 else 's'} under {heads} heading{'' if heads == 1 else 's'}", number)
            else:
                block += was_blank and bool(self.rows)
                self.rows.append((number, block, cells))
            was_blank = False
        if not self.header:
            self.add("is empty")

    def column(self, name: str) -> Optional[list[str]]:
        return [cells[self.header.index(name)] for *_, cells in self.rows] if name in self.header else None

    def values(self, name: str, dimension: Dimension, pixels: bool = False) -> Optional[np.ndarray]:
        """The column `name`, or `name` with "_" and a unit, in SI units; None without it."""
        heading = next((one for one in self.header if one == name or one.startswith(name + "_")), None)
        if heading is None:
            return None
        unit = heading[len(name) + 1:]
        try:
            factor = 1.0 if pixels and unit == "px" else quantities.read("1 " + unit, dimension.unit)
        except quantities.QuantityError:
            more = "; of pixels (px) give scale, too" if unit == "px" else ""
            self.add(f'the heading "{shortened(heading)}" does not end in a unit of {dimension.name}; write such as '
                     f'"{name}_{dimension.example.split(" ", 1)[1]}"{more}')
            return np.zeros(len(self.rows))
        return np.array([self._number(cell, line) for (line, *_), cell in zip(self.rows, self.column(heading) or [])], float) * factor

    def _number(self, cell: str, line: int) -> float:
        if re.fullmatch(r"\+?-?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", cell) and math.isfinite(float(cell.removeprefix("+"))):
            return float(cell.removeprefix("+"))
        self.add(f'"{shortened(cell)}" is not a number; write such as 12.5{", with a decimal point" if "," in cell else ""}', line)
        return 0.0

    def needed(self, columns: tuple[tuple[str, Dimension], ...], example: str, n_rows: int, pixels: bool = False) -> list[np.ndarray]:
        """These columns; empty after an error."""
        found = []
        for name, dimension in columns:
            values = self.values(name, dimension, pixels)
            if values is None:
                self.add(f"has no column {name}; give a header such as {example}")
            found.append(values)
        if not self.errors and len(self.rows) < n_rows:
            self.add(f"has {len(self.rows)} row{'' if len(self.rows) == 1 else 's'}; give at least {n_rows}")
        return [] if self.errors else found

    def refuse_negative(self, values: np.ndarray, reason: str) -> None:
        for i in np.flatnonzero(values < 0):
            self.add(reason, self.rows[i][0])


def other_kind(file: Path) -> str:
    """What a path is that is no regular file, "a folder"; empty for one. Raises OSError where there is nothing."""
    file.stat()
    return "" if file.is_file() else "a folder" if file.is_dir() else "not a regular file"


def _add_path(draft: _Draft, table: _Csv) -> None:
    columns = table.needed((("y", LENGTH), ("z", LENGTH)), "y_mm,z_mm", 2, pixels=draft.scale > 0)
    if not columns:
        return
    points = np.stack(columns, axis=1)
    if draft.scale > 0:  # from left and top
        points = draft.scale * (points - draft.pixel_origin) * (1, -1)
    points = draft.in_body(points)
    arms = table.column("arm") or [str(block + 1) for _, block, _ in table.rows]
    for arm in dict.fromkeys(arms):
        line = points[[name == arm for name in arms]]
        line = line[np.append(True, (np.diff(line, axis=0) != 0).any(axis=1))]
        if len(line) < 2:
            table.add(f"arm {arm} has a single point; give at least two of each")
        draft.experiment.lines.append(line)
    if not table.errors and draft.experiment.path_error_length == 0:
        line = draft.experiment.lines[0]
        draft.experiment.path_error_length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() / (len(line) - 1))


def _add_tips(draft: _Draft, table: _Csv) -> None:
    if columns := table.needed((("time", TIME), ("y", LENGTH), ("z", LENGTH)), "time_us,y_mm,z_mm", 1):
        table.refuse_negative(columns[0], "the time is below 0; times count from when the crack began to run")
        _add_tip(draft, columns[0], np.stack(columns[1:], axis=1))


def _add_tip(draft: _Draft, time: Any, at: Any) -> None:
    one = draft.experiment
    one.tip_times = np.append(one.tip_times, time)
    one.tip_places = np.vstack([one.tip_places, draft.in_body(at)])


def _add_curve(draft: _Draft, table: _Csv) -> None:
    if columns := table.needed((("displacement", LENGTH), ("load", FORCE)), "displacement_mm,load_N", 2):
        if columns[1].max() < 0:
            table.add("negative loads only; loads are positive in the machine's direction")
        draft.experiment.curve = (columns[0], columns[1])
        if draft.experiment.peak_load is None:
            draft.experiment.peak_load = float(columns[1].max())
        if draft.machine_compliance is not None:
            _add_stiffness(draft, table, *columns)


def _add_stiffness(draft: _Draft, table: _Csv, displacement: np.ndarray, load: np.ndarray) -> None:
    """By regression over SLOPE_RANGE of the peak load, on the way to it."""
    rising = slice(int(load.argmax()) + 1)
    low, high = (share * load.max() for share in SLOPE_RANGE)
    chosen = (load[rising] >= low) & (load[rising] <= high)
    if chosen.sum() < 3:
        return table.add(f"has fewer than three points from {100 * SLOPE_RANGE[0]:.0f} to {100 * SLOPE_RANGE[1]:.0f} % of the peak load, which machine_compliance needs")
    found = stats.linregress(load[rising][chosen], displacement[rising][chosen])
    compliance = found.slope - (draft.machine_compliance or 0.0)
    if not compliance > 0:
        return table.add("is stiffer than the machine by machine_compliance")
    draft.experiment.stiffness, draft.experiment.stiffness_error = 1 / compliance, float(found.stderr) / compliance ** 2


def _rows_of_loads(draft: _Draft, table: _Csv) -> list[Experiment]:
    peak, onset, strength = (table.values(*column) for column in (("peak_load", FORCE), ("onset_load", FORCE), ("strength", STRESS)))
    if strength is not None:
        if peak is not None:
            table.add("has both peak_load and strength; leave one of them out")
        elif draft.load_per_strength == 0:
            table.add("has strengths; give load_per_strength too, the load over the strength")
        peak = strength * draft.load_per_strength
    for loads in (peak, onset):
        if loads is not None:
            table.refuse_negative(loads, "negative load; loads are positive in the machine's direction")
    if peak is None and onset is None and not table.errors:
        table.add("has no column peak_load, onset_load or strength; give a header such as peak_load_N")
    if not table.rows:
        table.add("has no rows")
    answers = {"": False, "no": False, "false": False, "0": False, "yes": True, "true": True, "1": True}
    run_out = [answers.get(cell.lower()) for cell in table.column("run_out") or [""] * len(table.rows)]
    for i, answer in enumerate(run_out):
        if answer is None:
            table.add('run_out is neither "yes" nor "no"', table.rows[i][0])
    names = [shortened(name) for name in table.column("name") or [f"row {i + 1}" for i in range(len(table.rows))]]
    prefix = draft.experiment.name + " " if draft.experiment.name else ""
    return [] if table.errors else [
        replace(draft.experiment, name=prefix + name, peak_load=None if peak is None else float(peak[i]),
                onset_load=None if onset is None else float(onset[i]), run_out=bool(run_out[i])) for i, name in enumerate(names)]


def _read_csv(name: str, key: str, findings: _Findings, read: Callable[[_Csv], Any]) -> Any:
    table, result = _Csv(findings.folder / name), None
    if not table.errors:
        result = read(table)
    for error in table.errors:
        findings.report(key, f"{shortened(str(findings.folder / name), 200)}: {error}")
    return result


# The whole file.

def _check_companions(table: dict, key: str, findings: _Findings) -> None:
    """Keys that say something about another one, which is missing."""
    has_load, has_tip = bool({"onset_load", "peak_load", "loads", "curve"} & table.keys()), bool({"tip", "tips"} & table.keys())
    for name, has, wanted in (("path_error", "path" in table, "path"), ("path_error_length", "path_error" in table, "path_error"),
                              ("arrested", "path" in table, "path"), ("scale", "path" in table, "path"),
                              ("pixel_origin", "scale" in table, "scale"), ("load_error", has_load, "a load"),
                              ("machine_compliance", "curve" in table, "curve"), ("run_out", bool({"peak_load", "curve"} & table.keys()), "peak_load"),
                              ("load_per_strength", "loads" in table, "loads"), ("time_error", has_tip, "tip or tips")):
        if name in table and not has:
            findings.report(f"{key}.{name}", f"is for {wanted}; give that, or leave it out")
    for name in ("path", "onset_load", "peak_load", "tip", "tips", "curve", "picture", "run_out") if "loads" in table else ():
        if name in table:
            findings.report(f"{key}.{name}", "does not go with loads, each of which is an experiment; give it in an [[experiment]] of its own")
    if not {"path", "onset_load", "peak_load", "curve", "loads", "tips", "tip", "picture"} & table.keys() and not findings.faulty(key):
        findings.report(key, "nothing was observed in this experiment; give path, onset_load, peak_load, loads, curve, tips, "
                             "[[experiment.tip]] or [[experiment.picture]]")


def _read_experiment(table: dict, key: str, findings: _Findings) -> list[Experiment]:
    draft = _read_table("experiment", table, key, _Draft(), findings)
    one = draft.experiment
    tips = [_read_table("experiment.tip", given, f"{key}.tip[{i}]", {}, findings) for i, given in _tables(table, "tip")]
    one.pictures = [_read_table("experiment.picture", given, f"{key}.picture[{i}]", Picture(), findings)
                    for i, given in _tables(table, "picture")]
    _check_companions(table, key, findings)
    for picture in one.pictures:
        corners = picture.scale * (np.array([(0, 0), (1, 0), (0, 1)]) - picture.origin) * (1, -1)
        picture.corner, right, down = draft.in_body(corners)
        picture.right, picture.down = right - picture.corner, down - picture.corner
    for tip in tips:
        if tip.keys() >= {"time", "at"}:
            _add_tip(draft, tip["time"], tip["at"][None])
    for name, add in (("path", _add_path), ("tips", _add_tips), ("curve", _add_curve)):
        if file := getattr(draft, name):
            _read_csv(file, f"{key}.{name}", findings, lambda csv, add=add: add(draft, csv))
    if not draft.loads:
        return [one]
    return _read_csv(draft.loads, f"{key}.loads", findings, lambda csv: _rows_of_loads(draft, csv)) or []


def _parse(file: Path) -> tuple[dict, _Findings]:
    findings = _Findings(file)
    try:
        if kind := other_kind(file):
            raise ExperimentsError([f"{file}: is {kind}; give an experiments file in TOML"])
        data = file.read_bytes()
    except OSError as error:
        reason = "there is no such file" if isinstance(error, FileNotFoundError) else f"cannot be read: {error.strerror}"
        raise ExperimentsError([f"{file}: {reason}; give an experiments file in TOML"]) from None
    try:
        text = data.decode("utf-8-sig")
        if len(data) > MOST_TEXT:
            findings.report("", f"longer than {MOST_TEXT} bytes; give an experiments file in TOML", 1)
        else:
            findings = _Findings(file, text)
            return tomllib.loads(text, parse_float=_number), findings
    except UnicodeDecodeError as error:
        findings.report("", f"not valid UTF-8 (byte 0x{data[error.start]:02x}); give an experiments file in TOML",
                        data[:error.start].count(b"\n") + 1)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        place = re.search(r" \(at line (\d+), column \d+\)", str(error))
        line = int(place[1]) if place else text.count("\n") + (not text.endswith("\n"))
        source = text.split("\n")[line - 1].strip()
        message = str(error)[:place.start() if place else None].replace(" (at end of document)", "") or "nested too deep"
        unit = ' (a value with a unit must be in quotes, such as "1.0 mm")' if re.search(r"=\s*[-+\d.eE]+\s*[A-Za-zµ]", source) else ""
        findings.report("", f"syntax error: {message}, in: {shortened(source)}{unit}", line)
    findings.raise_if_any()
    raise AssertionError


def read_experiments(file: str | Path) -> list[Experiment]:
    """The experiments of a TOML file; one with `loads` becomes an experiment for each row of that file.

    Raises ExperimentsError with every error.
    """
    root, findings = _parse(Path(file))
    _report_unknown(root, "", "", findings)
    experiments: list[Experiment] = []
    top = _read_table("", root, "", _Draft(), findings)
    for name in ("load_error", "load_per_strength"):
        if name in root and not top.loads:
            findings.report(name, "is for loads; give that, or move it into its [[experiment]]")
    if top.loads:
        experiments += _read_csv(top.loads, "loads", findings, lambda csv: _rows_of_loads(top, csv)) or []
    for i, table in _tables(root, "experiment"):
        experiments += _read_experiment(table, f"experiment[{i}]", findings)
    if not experiments and not findings.found:
        findings.report("", 'there is no experiment; give [[experiment]], or loads = "loads.csv"')
    names = [one.name for one in experiments if one.name]
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        findings.report("experiment", f'two experiments are named "{name}"; give each its own name')
    findings.raise_if_any()
    return experiments


def picture_size(file: Path) -> tuple[int, int]:
    """Width and height of a PNG or JPEG file in pixels. Raises ValueError that says what it is instead."""
    from PIL import Image
    try:
        if kind := other_kind(file):
            raise ValueError(f"is {kind}")
        with Image.open(file, formats=("PNG", "JPEG")) as image:
            return image.size
    except FileNotFoundError:
        raise ValueError("there is no such file") from None
    except (OSError, Image.DecompressionBombError):
        raise ValueError("cannot be read as PNG or JPEG") from None


def explained_keys(skipped: tuple[str, ...]) -> str:
    """The keys of an [[experiment]] as comments, for a template."""
    lines = []
    for key in TABLES["experiment"]:
        if key.name not in skipped:
            example = re.search(r'such as (".*"|\[.*\])$', key.accepted)
            value = example[1] if example else key.unset if key.unset.startswith(('"', "[")) else "true" if key.accepted == "true" else '"y"'
            unset = f"; default: {key.unset}" if key.unset else ""
            lines.append("\n".join(textwrap.wrap(f"{key.help}: {key.accepted}{unset}", 98, initial_indent="# ", subsequent_indent="# ",
                                                 break_long_words=False)) + f"\n#{key.name} = {value}\n")
    return "".join(lines)
