"""Readers that work in a process of their own: a library that crashes, swells or never returns takes nothing with it.

``apart(read)`` gives a function that reads as ``read`` does. It starts Python anew (`main`), limits the memory and the
computing time of that process, and receives the columns from its standard output: a line of JSON that says which, then
their bytes piece by piece, each below a line with its size, or with what is wrong. Long columns are held whole neither
there nor here.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict
from typing import IO, Any, NoReturn, cast

import numpy as np
from numpy.typing import NDArray

from ..core.batches import batches, is_long, is_stored
from ..core.errors import DataError, InertialcalError, Problem
from ..core.recording import ClockRate
from ..core.remarks import Remark
from .binary.arrays import AT_ONCE, received
from .budget import ENVIRONMENT, PROCESS, ceiling, claim
from .columns import Column, Content
from .source import FileBytes, Loaded, as_data_errors

Read = Callable[[Loaded, Sequence[str] | None], Content]
SECONDS, PER_SECOND = 10, 5e5  # of computing for any file, and bytes that one more must bring: libraries are in Python
AS_TEXT, AS_NUMBERS = "text", "rows"


class Pieces:
    """What a process of its own answers, as one stream of the bytes of all arrays."""

    def __init__(self, answer: IO[bytes]) -> None:
        self._answer, self._left = answer, 0

    def said(self) -> dict[str, Any]:
        """Return the content of the next line; Raises EOFError where none comes, DataError where it refuses."""
        line = self._answer.readline()
        if not line.endswith(b"\n"):
            raise EOFError
        try:
            content = json.loads(line)
        except ValueError:
            raise EOFError from None
        if not isinstance(content, dict):
            raise EOFError
        if "refused" in content:
            problems = [one | {"choices": tuple(one.get("choices", ()))} for one in content["refused"]]
            raise DataError([Problem(**one) for one in problems])
        return content

    def readinto(self, view: memoryview) -> int:
        """Fill the view as far as a piece goes."""
        if not self._left:
            self._left = int(self.said()["bytes"])
        got: int = self._answer.readinto(view[: self._left])  # type: ignore[attr-defined]
        self._left -= got
        return got


@contextmanager
def process_of(module: str, words: Sequence[str], loaded: Loaded) -> Iterator[tuple[Pieces, subprocess.Popen[bytes]]]:
    """Run a module in a process of its own, give it the bytes of a file that does not stay in place; yield its answer.

    Raises
    ------
    EOFError
        If the answer ends too early: `crashed` says why.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONSAFEPATH": "1"}
    environment |= {ENVIRONMENT: str(ceiling(loaded.on_disk)), "OPENBLAS_NUM_THREADS": "1", "PYTHONIOENCODING": "utf-8"}
    command = [sys.executable, "-m", module, *words]
    pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=nowhere, env=environment) as process:  # noqa: S603
        given, answer = cast("IO[bytes]", process.stdin), cast("IO[bytes]", process.stdout)
        try:
            with suppress(BrokenPipeError):
                given.write(b"" if isinstance(loaded.data, FileBytes) else loaded.data)
                given.close()
            yield Pieces(answer), process
        finally:
            process.kill()


def is_possible() -> bool:
    """Return whether Python can be started anew."""
    return bool(sys.executable) and not getattr(sys, "frozen", False)


def crashed(status: int, path: str, what: str, library: str) -> DataError:
    """Return the error for a process that came to no end."""
    slow = status == -getattr(signal, "SIGXCPU", 0)
    said = "it comes to no end" if slow else f"it stops the {library} library ({status})"
    return DataError(
        f"cannot be read as {what}: {said}",
        where=path,
        do="Copy it again from its source, or export it as text",
        code="damaged_file",
    )


def limit_memory(most: int, kind: str = "RLIMIT_AS") -> None:
    """Limit the memory of this process to that many bytes on top of what it has, where the system can.

    Parameters
    ----------
    most : int
        Bytes.
    kind : {"RLIMIT_AS", "RLIMIT_DATA"}
        What counts: all addresses, or those that hold no mapped file.
    """
    with suppress(ImportError, OSError, ValueError):
        import resource  # noqa: PLC0415 - not everywhere

        with open("/proc/self/statm", encoding="ascii") as stream:
            pages = stream.read().split()
        own = int(pages[0 if kind == "RLIMIT_AS" else 5]) * resource.getpagesize()
        resource.setrlimit(getattr(resource, kind), (own + most, resource.RLIM_INFINITY))


def limit_time(seconds: int) -> None:
    """Limit the computing time of this process [s], where the system can."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # noqa: PLC0415 - not everywhere

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, resource.RLIM_INFINITY))


def apart(read: Read, what: str) -> Read:
    """Return a reader that works in a process of its own.

    Parameters
    ----------
    read : callable
        A function of a module.
    what : str
        What the file is meant to be: ``"a TDMS file"``.
    """

    def read_apart(loaded: Loaded, variables: Sequence[str] | None) -> Content:
        if not is_possible():
            return read_here(read, what, loaded, variables)
        in_place = isinstance(loaded.data, FileBytes)
        about = {"module": read.__module__, "function": read.__name__, "what": what, "path": loaded.path,
                 "packed": loaded.packed, "on_disk": loaded.on_disk, "size": 0 if in_place else len(loaded.data),
                 "variables": None if variables is None else list(variables)}  # fmt: skip
        with process_of(__name__, [json.dumps(about)], loaded) as (pieces, process):
            try:
                content = _received(pieces)
                pieces.said()
                if process.wait():
                    raise EOFError
                return content
            except EOFError:
                raise crashed(process.wait(), loaded.path, what, read.__module__.rpartition(".")[2]) from None

    return read_apart


def read_here(read: Read, what: str, loaded: Loaded, variables: Sequence[str] | None) -> Content:
    """Return what a reader gives in this process; whatever goes wrong is a DataError."""
    try:
        with as_data_errors(loaded.path, what):
            try:
                return _checked(read(loaded, variables))
            except MemoryError:
                most = ceiling(loaded.on_disk)
                claim(loaded.path, loaded.on_disk, most, f"the content of {what}", least=True)
                raise
    except Exception:
        raise
    except BaseException as error:  # a library in Rust panics
        if isinstance(error, KeyboardInterrupt | SystemExit | GeneratorExit):
            raise
        with as_data_errors(loaded.path, what):
            raise ValueError(str(error)) from None
        raise AssertionError from error  # not reached


def _checked(content: Content) -> Content:
    """Return a content whose columns are of one length."""
    if len({len(one.values) for one in content.columns}) > 1:
        raise ValueError("columns of different length")
    return content


def main() -> NoReturn:
    """Read a file in a process of its own: what is to be read is given as JSON, its bytes on standard input."""
    about = json.loads(sys.argv[1])
    path, on_disk, size = about["path"], about["on_disk"], about["size"]
    read: Read = getattr(importlib.import_module(about["module"]), about["function"])
    limit_memory(max(ceiling(on_disk) - PROCESS, 0), "RLIMIT_DATA")
    limit_time(SECONDS + int((on_disk + size) / PER_SECOND))
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # a library that prints

    def say(content: object) -> None:
        out.write(json.dumps(content).encode() + b"\n")

    try:
        data = sys.stdin.buffer.read(size) if size else cast("bytes", FileBytes(path))
        content = read_here(read, about["what"], Loaded(path, data, "", about["packed"], on_disk), about["variables"])
        say(_said(content))
        for values in _arrays(content):
            for first, stop in batches(values, size=max(AT_ONCE // values.dtype.itemsize, 1)):
                piece = np.ascontiguousarray(values[first:stop])
                say({"bytes": piece.nbytes})
                out.write(piece.view(np.uint8).data)
        say({})
    except InertialcalError as error:
        say({"refused": [asdict(one) for one in error.problems]})
    out.flush()
    os._exit(0)  # a library need not take apart what is damaged


def _said(content: Content) -> dict[str, Any]:
    """Return what is said of a content before its numbers."""
    columns = []
    for one in content.columns:
        is_text = one.values.dtype.kind == "O"
        columns.append({
            "name": one.name, "unit": one.unit, "named": one.named, "matrix": one.matrix, "axis": one.axis,
            "kind": None if is_text else one.values.dtype.str, "text": [str(v) for v in one.values] if is_text else [],
            "empty": len(one.empty), "not_a_number": len(one.not_a_number),
        })  # fmt: skip
    rows = content.rows
    return {
        "columns": columns, "length": len(content), "format": content.format, "sample_rate": content.sample_rate,
        "rows": [rows.start, rows.stop, rows.step] if isinstance(rows, range) else None if rows is None else AS_NUMBERS,
        "has_time": content.time_ns is not None, "cut_off": content.cut_off,
        "clock": None if content.clock is None else asdict(content.clock),
        "stored": any(is_stored(one.values) for one in content.columns),
        "remarks": [asdict(one) for one in content.remarks],
    }  # fmt: skip


def _arrays(content: Content) -> Iterator[NDArray[Any]]:
    """Yield the arrays of numbers of a content, in the order in which they are sent."""
    for one in content.columns:
        if one.values.dtype.kind != "O" and len(one.values):
            yield one.values.view(np.int64) if one.values.dtype.kind == "M" else one.values
        yield from (at for at in (one.empty, one.not_a_number) if len(at))
    if content.rows is not None and not isinstance(content.rows, range) and len(content.rows):
        yield content.rows
    if content.time_ns is not None and len(content.time_ns):
        yield content.time_ns


def _received(pieces: Pieces) -> Content:
    """Return the content that a process sends."""
    said = pieces.said()
    stream, n = cast("IO[bytes]", pieces), said["length"]
    size = sum(np.dtype(one["kind"]).itemsize for one in said["columns"] if one["kind"]) * n
    stored = True if said["stored"] or is_long(size) else None

    def take(kind: str, length: int) -> NDArray[Any]:
        return received(stream, np.dtype(kind), (length,), stored)

    columns = []
    for one in said["columns"]:
        values = np.array([*one["text"], None], dtype=object)[:-1] if one["kind"] is None else take(one["kind"], n)
        empty, not_a_number = take("<i8", one["empty"]), take("<i8", one["not_a_number"])
        columns.append(Column(one["name"], values, one["unit"], one["named"], one["matrix"], one["axis"],
                              empty, not_a_number))  # fmt: skip
    rows = take("<i8", n) if said["rows"] == AS_NUMBERS else None if said["rows"] is None else range(*said["rows"])
    time_ns = take("<i8", n) if said["has_time"] else None
    remarks = tuple(Remark(**one) for one in said["remarks"])
    clock = None if said["clock"] is None else ClockRate(**said["clock"])
    return Content(tuple(columns), said["format"], rows, said["sample_rate"], remarks, time_ns, said["cut_off"], clock)


if __name__ == "__main__":
    main()
