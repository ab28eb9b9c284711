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
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

LOGGERS = Path(__file__).resolve().parents[1] / "loggers/logger_files.py"
ROWS = 200
MEMORY, SECONDS = 2**31, 20  # bytes on top of what Python has, and seconds of computing, for one file
OF_LOGGERS = {
    "rosbag1": "bz2.bag", "rosbag2": "ros2.db3", "mcap": "zstd.mcap", "ulog": "px4.ulg", "dataflash": "ardu.bin",
    "dataflash_text": "ardu.log", "excel": "book.xlsx", "tdms": "labview.tdms", "uff": "binary.uff",
    "wav": "sound.wav", "feather": "zstd.feather", "mdf": "packed.mf4", "lvm": "labview.lvm",
    "miniseed": "steim.mseed", "sqlite": "table.db",
}  # fmt: skip
# Formats whose records follow one another without a count or an end: one that is cut between two of them looks whole.
NO_END = ("text", "mat4", "mat5", "dataflash", "dataflash_text", "ulog", "lvm", "miniseed", "uff")


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
    """Write the head of an EBML file and elements of the recorder that hold nothing."""
    path.write_bytes(b"\x1a\x45\xdf\xa3\x8b\x42\x82\x84mide\x42\x87\x81\x02" + b"\xec\x84abcd" * 40)


HERE: dict[str, tuple[str, Callable[[Path], None]]] = {
    "text": ("a.csv", text), "cards": ("a.cards", cards), "parquet": ("a.parquet", parquet),
    "mat5": ("a.mat", matlab("5")), "mat4": ("a.mat", matlab("4")), "hdf5": ("a.h5", hdf5), "npy": ("a.npy", npy),
    "npz": ("a.npz", npz), "ide": ("a.ide", ide),
}  # fmt: skip
REFUSED = ("cards", "ide")  # readers whose file here holds no recording
NAMES = (*HERE, *OF_LOGGERS)


def written(reader: str, folder: Path) -> Path:
    """Return the file of a reader."""
    if reader in HERE:
        name, write = HERE[reader]
        write(folder / name)
        return folder / name
    said = importlib.util.spec_from_file_location("logger_files", LOGGERS)
    assert said is not None
    assert said.loader is not None
    module = sys.modules.get("logger_files") or importlib.util.module_from_spec(said)
    if "logger_files" not in sys.modules:
        sys.modules["logger_files"] = module
        said.loader.exec_module(module)
    path = folder / OF_LOGGERS[reader]
    module.WRITERS[path.name](path)
    return path


@dataclass(frozen=True)
class Tried:
    """A file that was changed: how, and what came of it, in a word; what is wrong with that, or nothing."""

    how: str
    outcome: str
    wrong: str = ""


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


def cases(whole: bytes, seed: int, mutations: int, cuts: int) -> Iterator[tuple[str, bytes]]:
    """Yield files with places changed, and files cut off."""
    choice = random.Random(seed)
    for i in range(mutations):
        yield f"change {i}", changed(whole, choice)
    for i in range(cuts):
        at = choice.randrange(len(whole))
        yield f"cut {i} at byte {at} of {len(whole)}", whole[:at]


def attempt(reader: str, seed: int = 1, mutations: int = 20, cuts: int = 10) -> list[Tried]:
    """Return what comes of the changed files of a reader, each read in a process of its own with limits."""
    found = []
    with tempfile.TemporaryDirectory(prefix="hostile-") as name:
        path = written(reader, Path(name))
        whole = path.read_bytes()
        sizes = _read(path)
        assert sizes[0] == "read" or reader in REFUSED, (reader, sizes)
        for how, data in cases(whole, seed, mutations, cuts):
            path.write_bytes(data)
            found.append(_judged(how, reader, _in_a_process(path), sizes))
    return found


def _read(path: Path) -> tuple[str, int, int, Counter[str]]:
    """Return what reading gives: a word, rows, columns, remarks by code."""
    from inertialcal.core.errors import InertialcalError
    from inertialcal.files import apart, read

    try:
        with mock.patch.object(apart, "is_possible", return_value=False):  # this process is one of its own
            try:
                found = read(path)
            except InertialcalError as error:
                if not error.problems[0].choices:
                    raise
                found = read(path, topics=error.problems[0].choices[:1])
    except InertialcalError as error:
        problem = error.problems[0]
        return f"refused: {problem.code}", 0, 0, Counter([problem.what])
    return "read", len(found), len(found.channels), Counter(one.code for one in found.remarks)


def _in_a_process(path: Path) -> tuple[str, int, int, Counter[str]]:
    """Return what reading gives in a copy of this process; a word for how that ended where it gave nothing."""
    out, into = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(out)
            with open("/proc/self/statm", encoding="ascii") as stream:
                own = int(stream.read().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (own + MEMORY, own + MEMORY))
            resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            signal.alarm(4 * SECONDS)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
            try:
                said = _text(_read(path))
            except BaseException as error:
                said = _text((f"traceback: {type(error).__name__}: {error}"[:300], 0, 0, Counter()))
            os.write(into, said.encode()[:60_000])
        finally:
            os._exit(0)
    os.close(into)
    with os.fdopen(out, "rb") as stream:
        answer = stream.read().decode()
    _, status = os.waitpid(child, 0)
    if status or not answer:
        return f"killed by {signal.Signals(os.WTERMSIG(status)).name}" if status else "no answer", 0, 0, Counter()
    return _parsed(answer)


def _text(found: tuple[str, int, int, Counter[str]]) -> str:
    return json.dumps([*found[:3], dict(found[3])])


def _parsed(text: str) -> tuple[str, int, int, Counter[str]]:
    word, rows, columns, said = json.loads(text)
    return word, rows, columns, Counter(said)


def _judged(
    how: str, reader: str, found: tuple[str, int, int, Counter[str]], whole: tuple[str, int, int, Counter[str]]
) -> Tried:
    """Return whether that is an outcome that a user can live with."""
    word, rows, columns, said = found
    if word.startswith("refused"):
        return Tried(how, word, "" if all(said) else "a refusal without words")
    if word != "read":
        return Tried(how, word, word if "SIGSEGV" not in word and "SIGABRT" not in word else "")
    lost = rows < whole[1] or columns < whole[2]
    silent = lost and how.startswith("cut") and not said - whole[3] and reader not in NO_END
    outcome = "remarked" if said - whole[3] else "less" if lost else "unchanged"
    why = f"{rows} of {whole[1]} rows, {columns} of {whole[2]} columns, and no word of it"
    return Tried(how, outcome, why if silent else "")
