# SPDX-License-Identifier: GPL-3.0-or-later
"""The result files of the program: which there are, and their opening. Whatever reads them in Python opens them here."""
from __future__ import annotations

import contextlib
import functools
import os
import re
import stat
from pathlib import Path
from typing import Any, Iterator, Optional

# A folder on a network file system, or one that a run is writing to, may not be locked for reading.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

import h5py  # noqa: E402

from .checksum import BLOCK, START, checksum  # noqa: E402

ENSEMBLE_KIND, SAMPLE_KIND = "crackle ensemble", "crackle sample"
PENDING, DONE, FAILED = 0, 1, 2
SCHEMA_VERSIONS = range(4, 9)  # of the files that can be read, as in src/io/sample_file.h

MARK = b"\ncrackle FNV-1a "  # before the check sum, 16 hexadecimal digits at the end of a sample file
TRAILER = len(MARK) + 16

_sound: set[tuple[int, ...]] = set()  # files whose check sum has been found right, by _identity


class ResultsError(Exception):
    """There are no results, or a file of theirs cannot be read; the message names the folder or the file."""


def sample_files(folder: Path) -> dict[int, Path]:
    """The whole sample files in an ensemble's folder, by number. Raises ResultsError as check_regular."""
    # Files under way have other names.
    names = ((re.fullmatch(r"(\d{4,})\.h5", file.name), file) for file in (folder / "samples").glob("*.h5"))
    files = dict(sorted((int(match[1]), file) for match, file in names if match))
    for file in files.values():
        check_regular(file)
    return files


def is_there(file: Path) -> bool:
    """Whether there is such a regular file. Raises ResultsError as check_regular."""
    check_regular(file)
    return file.is_file()


def check_regular(file: Path) -> None:
    """Raises ResultsError for what is there but is no regular file: opening a pipe waits for whoever writes into it."""
    try:
        mode = os.stat(file).st_mode
    except OSError as error:
        if file.is_symlink():
            raise ResultsError(f"'{file}' is a broken link") from error
        if isinstance(error, FileNotFoundError):
            return
        raise ResultsError(f"cannot read '{file}': {error.strerror}") from error
    kinds = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a named pipe"), (stat.S_ISSOCK, "a socket"), (stat.S_ISREG, ""))
    kind = next((name for is_kind, name in kinds if is_kind(mode)), "a device")
    if kind:
        raise ResultsError(f"'{file}' is {kind}")


def check_folder(folder: Path) -> None:
    """Raises ResultsError when something in an ensemble's folder that is to be read is no regular file."""
    for name in ("input.toml", "ensemble.h5"):
        check_regular(folder / name)
    sample_files(folder)


def open_hdf5(file: Path) -> h5py.File:
    """Any HDF5 file, for reading. Raises ResultsError."""
    check_regular(file)
    try:
        return h5py.File(file, "r")
    except OSError as error:
        if error.errno:
            raise ResultsError(f"cannot read '{file}': {os.strerror(error.errno)}") from error
        if not h5py.is_hdf5(file):
            raise ResultsError(f"'{file}' is not an HDF5 file") from error
        raise ResultsError(f"cannot read '{file}', which may be damaged: {error}") from error


def open_results(file: Path, kind: str) -> h5py.File:
    """A result file of this kind, for reading; to be closed by the caller. Raises ResultsError when it is none, is damaged or of a
    version that is not known, and for a sample of another model than the first whole one in its folder."""
    check_regular(file)
    is_marked = _check_sum(file) if kind == SAMPLE_KIND and file.is_file() else True
    root = open_hdf5(file)
    try:
        with naming(file):
            found = text_of(root.attrs["kind"]) if "kind" in root.attrs else None
        if str(found) != kind:
            own = f"but a {found} file" if str(found) in (ENSEMBLE_KIND, SAMPLE_KIND) else "but of another program"
            raise ResultsError(f"'{file}' is not a {kind} file, {own}")
        if not is_marked:
            raise ResultsError(f"'{file}' is damaged or truncated: it has no checksum at its end")
        with naming(file):
            _check_version(file, kind, root)
    except ResultsError:
        root.close()
        raise
    return root


@contextlib.contextmanager
def results(file: Path, kind: str) -> Iterator[h5py.File]:
    """As open_results, closed at the end; what cannot be read in the meantime is a ResultsError, too."""
    with open_results(file, kind) as root, naming(file):
        yield root


@contextlib.contextmanager
def naming(file: Path) -> Iterator[None]:
    """Errors of reading become a ResultsError that names the file."""
    try:
        yield
    except KeyError as error:
        raise ResultsError(f"'{file}' is incomplete: {error.args[0]}") from error
    except (OSError, RuntimeError, UnicodeError) as error:
        raise ResultsError(f"cannot read '{file}', which may be damaged: {error}") from error


def text_of(value: Any) -> Any:
    """An attribute or element as h5py gives it; texts of fixed length come as bytes."""
    return value.decode("utf-8") if isinstance(value, bytes) else value


def _check_version(file: Path, kind: str, root: h5py.File) -> None:
    if (version := int(root.attrs["schema_version"])) not in SCHEMA_VERSIONS:
        raise ResultsError(f"'{file}' is of version {version} of the file format; versions {SCHEMA_VERSIONS[0]} to "
                           f"{SCHEMA_VERSIONS[-1]} can be read")
    if kind == SAMPLE_KIND and file.parent.name == "samples":
        model, others = _model_of(root), _model_of_samples(file.parent, file.parent.stat().st_mtime_ns)
        if others not in (None, model):
            raise ResultsError(f"'{file}' is of model {model}, of version {text_of(root.attrs['program_version'])} of the program; "
                               f"the other samples are of model {others}")


def _model_of(root: h5py.File) -> int:
    return int(root.attrs.get("model_version", 1))


@functools.lru_cache(maxsize=100)
def _model_of_samples(folder: Path, _changed: int) -> Optional[int]:
    """The model of the first whole sample file in a folder last changed at some time; runs never mix them."""
    for file in sample_files(folder.parent).values():
        with contextlib.suppress(ResultsError):
            if _check_sum(file):
                with open_hdf5(file) as root:
                    return _model_of(root)
    return None


def _check_sum(file: Path) -> bool:
    """Whether the file has a check sum at its end. Raises ResultsError for one that is not that of its content; files that have
    not changed since they were looked at are not read again."""
    try:
        with open(file, "rb") as stream:
            if (identity := _identity(stream.fileno())) in _sound:
                return True
            length = identity[2] - TRAILER
            stream.seek(max(0, length))
            end = stream.read()
            if length < 0 or not end.startswith(MARK):
                return False
            stream.seek(0)
            value = START
            for first in range(0, length, BLOCK):
                value = checksum(stream.read(min(BLOCK, length - first)), value)
    except OSError as error:
        raise ResultsError(f"cannot read '{file}': {error.strerror}") from error
    if end != MARK + f"{value:016x}".encode():
        raise ResultsError(f"'{file}' is damaged: its content does not match its checksum")
    _sound.add(identity)
    return True


def _identity(descriptor: int) -> tuple[int, ...]:
    found = os.fstat(descriptor)
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
