"""A small file for every reader, and what happens to it: places changed, and the end cut off.

``python tests/files/hostile/fuzz.py`` (``make fuzz``) tries many.
"""

from __future__ import annotations

import importlib.util
import json
import os
import random
import resource
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest import mock

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from inertialcal.core.recording import Recording

LOGGERS = Path(__file__).resolve().parents[1] / "loggers"
ROWS = 200
MEMORY, SECONDS = 2**31, 20  # bytes on top of what Python has, and seconds of computing, for one file
OF_LOGGERS = {
    "rosbag1": "bz2.bag", "rosbag2": "ros2.db3", "mcap": "zstd.mcap", "ulog": "px4.ulg", "dataflash": "ardu.bin",
    "dataflash_text": "ardu.log", "excel": "book.xlsx", "tdms": "labview.tdms", "uff": "binary.uff",
    "wav": "sound.wav", "feather": "zstd.feather", "mdf": "packed.mf4", "lvm": "labview.lvm",
    "miniseed": "steim.mseed", "sqlite": "table.db", "json_lines": "lines.jsonl",
}  # fmt: skip
# Formats whose records follow one another without a count or an end: one that is cut between two of them looks whole.
NO_END = ("text", "mat4", "mat5", "dataflash", "dataflash_text", "ulog", "lvm", "miniseed", "uff", "json_lines")
SHORT_TEXT = 20  # rows of a text that do not show with how many digits its last number was to be written
# What a file, as it is written here, holds against a changed byte; where there is nothing, values may change.
CHECKED = {
    "rosbag1": "bzip2's sum over each chunk", "mcap": "a sum over each chunk, and over the data",
    "npz": "a sum over each array", "excel": "a sum over each sheet", "miniseed": "a sum over each record",
}  # fmt: skip


def _columns() -> dict[str, Any]:
    rng = np.random.default_rng(3)
    return {"t_s": np.arange(ROWS) / 100.0} | {f"gyro_{axis}": rng.normal(size=ROWS) for axis in "xyz"}


def text(path: Path) -> None:
    """Write text."""
    table = np.column_stack(list(_columns().values()))
    np.savetxt(path, table, "%.6f", ",", header="t_s,gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]", comments="")


def cards(path: Path) -> None:
    """Write what is no deck of cards: a deck of the programme has tests of its own."""
    path.write_text("      1.000     2.000\n" * 20)


def parquet(path: Path) -> None:
    """Write a table of pyarrow."""
    import pyarrow as pa
    from pyarrow import parquet as files

    files.write_table(pa.table(_columns()), path)


def matlab(form: str) -> Callable[[Path], None]:
    """Return a writer of MATLAB 4 or 5."""

    def write(path: Path) -> None:
        from scipy.io import savemat

        savemat(path, _columns(), format=form)

    return write


def hdf5(path: Path) -> None:
    """Write data sets."""
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in _columns().items():
            file.create_dataset(name, data=values)


def npy(path: Path) -> None:
    """Write a matrix."""
    with path.open("wb") as stream:
        np.save(stream, np.column_stack(list(_columns().values())))


def npz(path: Path) -> None:
    """Write arrays of their names."""
    with path.open("wb") as stream:
        np.savez(stream, **_columns())


def ide(path: Path) -> None:
    """Write a recording of a recorder."""
    endaq = _of_loggers("endaq_files")
    counts = [np.rint(1e3 * values).astype(np.int64) for name, values in _columns().items() if name != "t_s"]
    columns = [endaq.Subchannel(name, "Rotation", "dps", 1e-3, one) for name, one in zip("XYZ", counts, strict=True)]
    endaq.write_endaq(path, [endaq.Group("Gyroscope", 100.0, columns)], 1_750_145_400)


HERE: dict[str, tuple[str, Callable[[Path], None]]] = {
    "text": ("a.csv", text), "cards": ("a.cards", cards), "parquet": ("a.parquet", parquet),
    "mat5": ("a.mat", matlab("5")), "mat4": ("a.mat", matlab("4")), "hdf5": ("a.h5", hdf5), "npy": ("a.npy", npy),
    "npz": ("a.npz", npz), "ide": ("a.ide", ide),
}  # fmt: skip
REFUSED = ("cards",)  # readers whose file here holds no recording
NAMES = (*HERE, *OF_LOGGERS)


def written(reader: str, folder: Path) -> Path:
    """Return the file of a reader."""
    if reader in HERE:
        name, write = HERE[reader]
        write(folder / name)
        return folder / name
    path = folder / OF_LOGGERS[reader]
    _of_loggers("logger_files").WRITERS[path.name](path)
    return path


def _of_loggers(name: str) -> Any:
    """Return a module of the tests of loggers, which may not be on the path."""
    if name not in sys.modules:
        said = importlib.util.spec_from_file_location(name, LOGGERS / f"{name}.py")
        assert said is not None
        assert said.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(said)
        said.loader.exec_module(sys.modules[name])
    return sys.modules[name]


@dataclass(frozen=True)
class Tried:
    """A file that was changed: how, and what came of it, in a word; what is wrong with that, or nothing."""

    how: str
    outcome: str
    wrong: str = ""


@dataclass(frozen=True)
class Outcome:
    """What reading gives: a word, rows, columns, remarks by code, and values that are not those of the whole file."""

    word: str
    rows: int = 0
    columns: int = 0
    remarks: Counter[str] = field(default_factory=Counter)
    differing: int = 0
    where: str = ""  # The first of those values


def changed(whole: bytes, choice: random.Random) -> bytes:
    """Return a file with a few places changed: bytes of chance, a stretch out, a stretch twice, noughts."""
    data = bytearray(whole)
    for _ in range(choice.randint(1, 4)):
        at, size = choice.randrange(len(data)), choice.randint(1, 16)
        match choice.randrange(5):
            case 0:
                data[at : at + 1] = bytes([choice.randrange(256)])
            case 1:
                del data[at : at + size]
            case 2:
                data[at:at] = data[at : at + size]
            case 3:
                data[at : at + size] = bytes(len(data[at : at + size]))
            case _:
                data[at : at + 4] = choice.choice((b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\0\x80"))
        if not data:
            return b"\0"
    return bytes(data)


def cases(whole: bytes, seed: int, mutations: int, cuts: int, flips: int) -> Iterator[tuple[str, bytes]]:
    """Yield files with places changed, files cut off, and files with one bit that is not as it was."""
    choice = random.Random(seed)
    for i in range(mutations):
        yield f"change {i}", changed(whole, choice)
    for i in range(cuts):
        at = choice.randrange(len(whole))
        yield f"cut {i} at byte {at} of {len(whole)}", whole[:at]
    for i in range(flips):
        at, bit = choice.randrange(len(whole)), choice.randrange(8)
        yield f"flip {i} of bit {bit} of byte {at} of {len(whole)}", flipped(whole, at, bit)


def flipped(whole: bytes, at: int, bit: int) -> bytes:
    """Return a file with one bit that is not as it was."""
    return whole[:at] + bytes([whole[at] ^ 1 << bit]) + whole[at + 1 :]


def attempt(reader: str, seed: int = 1, mutations: int = 20, cuts: int = 10, flips: int = 10) -> list[Tried]:
    """Return what comes of the changed files of a reader, each read in a process of its own with limits."""
    found = []
    with tempfile.TemporaryDirectory(prefix="hostile-") as name:
        path = written(reader, Path(name))
        content = path.read_bytes()
        if reader in REFUSED:
            whole = None
            assert _tried(path, None).word.startswith("refused")  # and its library is loaded, before the processes
        else:
            whole = _read(path)
        sizes = _outcome(whole, whole)
        for how, data in cases(content, seed, mutations, cuts, flips):
            path.write_bytes(data)
            outcome = _in_a_process(path, whole)
            if outcome.word.startswith("killed"):  # as a user reads it, a library works in a process of its own
                outcome = _in_a_process(path, whole, apart_too=True)
            found.append(_judged(how, reader, outcome, sizes))
    return found


def _read(path: Path, apart_too: bool = False) -> Recording:
    """Return what a file holds: of several sets of columns, the first; Raises InertialcalError."""
    from inertialcal.core.errors import InertialcalError
    from inertialcal.files import apart, read

    with mock.patch.object(apart, "is_possible", return_value=apart_too):  # this process is one of its own
        try:
            return read(path)
        except InertialcalError as error:
            if not error.problems[0].choices:
                raise
            return read(path, topics=error.problems[0].choices[:1])


def _outcome(found: Recording | None, whole: Recording | None) -> Outcome:
    """Return what a recording is beside that of the whole file."""
    if found is None or whole is None:
        return Outcome("refused" if found is None else "read", columns=0 if found is None else len(found.channels))
    columns = _columns_of(whole)
    differing, where = 0, ""
    for name, values in _columns_of(found).items():
        there = columns.get(name)
        n = 0 if there is None else min(len(there), len(values))
        same = np.array([], dtype=bool) if there is None else _same(values[:n], there[:n])
        wrong = np.append(np.flatnonzero(~same), np.arange(n, len(values)))
        differing += len(wrong)
        if len(wrong) and not where:
            reads = f"{name} at row {wrong[0] + 1} is {values[wrong[0]]}"
            where = f"{reads}, was {there[wrong[0]]}" if there is not None and wrong[0] < len(there) else reads
    remarks = Counter(one.code for one in found.remarks)
    return Outcome("read", len(found), len(found.channels), remarks, differing, where)


def _columns_of(recording: Recording) -> dict[str, NDArray[Any]]:
    time = {} if recording.time_ns is None else {"time [ns]": np.asarray(recording.time_ns)}
    return time | {one.name: np.asarray(one.data) for one in recording.channels}


def _same(values: NDArray[Any], there: NDArray[Any]) -> NDArray[np.bool_]:
    """Return which values are equal; NaN is equal to NaN."""
    if "O" in (values.dtype.kind, there.dtype.kind):  # text
        return np.array([str(a) == str(b) for a, b in zip(values, there, strict=True)], dtype=bool)
    missing = [np.isnan(one) if one.dtype.kind in "fc" else np.zeros(one.shape, dtype=bool) for one in (values, there)]
    same: NDArray[np.bool_] = (values == there) | (missing[0] & missing[1])
    return same


def _in_a_process(path: Path, whole: Recording | None, apart_too: bool = False) -> Outcome:
    """Return what reading gives in a copy of this process; a word for how that ended where it gave nothing."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(out)
            _limit()
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            os.write(into, json.dumps(vars(_tried(path, whole, apart_too))).encode()[:60_000])
        finally:
            os._exit(0)
    os.close(into)
    with os.fdopen(out, "rb") as stream:
        answer = stream.read().decode()
    _, status = os.waitpid(child, 0)
    if status or not answer:
        return Outcome(f"killed by {signal.Signals(os.WTERMSIG(status)).name}" if status else "no answer")
    said = json.loads(answer)
    return Outcome(**said | {"remarks": Counter(said["remarks"])})


def _limit() -> None:
    """Limit memory and time of this process."""
    with open("/proc/self/statm", encoding="ascii") as stream:
        own = int(stream.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (own + MEMORY, own + MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.alarm(4 * SECONDS)


def _tried(path: Path, whole: Recording | None, apart_too: bool = False) -> Outcome:
    from inertialcal.core.errors import InertialcalError

    try:
        return _outcome(_read(path, apart_too), whole)
    except InertialcalError as error:
        problem = error.problems[0]
        return Outcome(f"refused: {problem.code}", remarks=Counter([problem.what]))
    except BaseException as error:
        return Outcome(f"traceback: {type(error).__name__}: {error}"[:300])


def _judged(how: str, reader: str, found: Outcome, whole: Outcome) -> Tried:
    """Return whether that is an outcome that a user can live with."""
    if found.word.startswith("refused"):
        return Tried(how, found.word, "" if all(found.remarks) else "a refusal without words")
    if found.word != "read":
        return Tried(how, found.word, found.word)
    lost = found.rows < whole.rows or found.columns < whole.columns
    new = found.remarks - whole.remarks
    outcome = "remarked" if new else "other values" if found.differing else "less" if lost else "unchanged"
    sizes = f"{found.rows} of {whole.rows} rows, {found.columns} of {whole.columns} columns"
    why = f"{sizes}, {found.differing} values are not those of the file ({found.where})" if found.differing else sizes
    if how.startswith("cut"):
        one_short = reader == "text" and found.rows < SHORT_TEXT and found.differing == 1
        wrong = bool(found.differing and not one_short) or (lost and not new and reader not in NO_END)
    else:
        wrong = not new and bool(found.differing or lost) and reader in CHECKED
    return Tried(how, outcome, why if wrong else "")
