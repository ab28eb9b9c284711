"""The as-run log: what was really done, a row each time that a step ended, on the disk before anything else is done.

A row that a kill cut off is left out when the log is read, and cut from the file before it is written on. The last row
of a step says how it stands.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal, get_args

from ...core.errors import StoreError
from ...core.times import instant_text
from ...files.write.atomic import BINARY, sync

FILE = "as_run.csv"
Status = Literal["PASS", "FAILED", "PAUSED", "REDONE"]
STATES: tuple[Status, ...] = get_args(Status)


@dataclass(frozen=True)
class AsRun:
    """How a step ended, once."""

    ended: str  # UTC
    step: int
    name: str
    recording: str
    attempt: int
    status: Status
    code: str = ""  # Why it is not PASS
    what: str = ""  # The same in words
    set: str = ""
    start: str = ""  # Of the record, on its clock
    stop: str = ""
    rows: int = 0
    u: str = ""  # Largest standard uncertainty of a mean that was asked for
    file: str = ""
    sha256: str = ""


HEAD = [one.name for one in fields(AsRun)]


class Log:
    """The log of a sequence.

    Parameters
    ----------
    folder : path
        Of the sequence.
    sha256 : str
        Of LAB.toml: a log belongs to one.

    Raises
    ------
    StoreError
        ``not_written``, ``other_sequence`` if it is the log of another LAB.toml, ``damaged_file``.
    """

    def __init__(self, folder: Path, sha256: str) -> None:
        self.path = folder / FILE
        self._first = f"# LAB.toml SHA-256 {sha256}"
        self.rows: list[AsRun] = []
        try:
            self._open()
        except OSError as error:
            raise self._not_written(error) from None

    def _open(self) -> None:
        found = self.path.read_bytes() if self.path.exists() else b""
        whole = found[: found.rfind(b"\n") + 1].decode("utf-8", "replace")
        lines = whole.split("\n")
        if len(lines) > 2:
            if lines[0] != self._first:
                why = "its steps may be other ones than those that are done"
                do = "Name another folder, or give LAB.toml back its text, which is in that folder"
                raise StoreError("LAB.toml is not that of this sequence", str(self.path), why, do, "other_sequence")
            self.rows = list(self._read(whole[len(lines[0]) + 1 :]))
        self._fd = os.open(self.path, os.O_RDWR | os.O_CREAT | BINARY, 0o644)
        os.truncate(self._fd, len(whole.encode()) if self.rows else 0)
        os.lseek(self._fd, 0, os.SEEK_END)
        if not self.rows:
            self._put(f"{self._first}\n{','.join(HEAD)}\n")
        sync(self.path.parent)

    def _read(self, text: str) -> Iterator[AsRun]:
        for number, row in enumerate(csv.DictReader(io.StringIO(text)), 3):
            try:
                status = STATES[STATES.index(row["status"])]
                yield AsRun(
                    row["ended"], int(row["step"]), row["name"], row["recording"], int(row["attempt"]), status,
                    row["code"], row["what"], row["set"], row["start"], row["stop"], int(row["rows"]), row["u"],
                    row["file"], row["sha256"],
                )  # fmt: skip
            except (ValueError, KeyError, TypeError):
                do = "Name another folder: what is done cannot be told"
                raise StoreError(
                    "not a row of a sequence", f"{self.path}:{number}", do=do, code="damaged_file"
                ) from None

    def add(self, row: AsRun) -> None:
        """Add a row; it is on the disk when this returns.

        Raises
        ------
        StoreError
            ``not_written``.
        """
        text = io.StringIO()
        values = [" ".join(str(getattr(row, name)).split()) for name in HEAD]
        csv.writer(text, lineterminator="\n").writerow(values)
        try:
            self._put(text.getvalue())
        except OSError as error:
            raise self._not_written(error) from None
        self.rows.append(row)

    def _put(self, text: str) -> None:
        rest = memoryview(text.encode())
        while rest:
            rest = rest[os.write(self._fd, rest) :]
        os.fsync(self._fd)

    def _not_written(self, error: OSError) -> StoreError:
        return StoreError(f"cannot be written: {error.strerror}", str(self.path), code="not_written")

    def close(self) -> None:
        """Close it."""
        os.close(self._fd)

    def last(self) -> dict[int, AsRun]:
        """Return the last row of each step."""
        return {row.step: row for row in self.rows}

    def attempts(self, step: int) -> int:
        """Return how often a step was tried."""
        return sum(row.step == step and row.status != "REDONE" for row in self.rows)


def time_text(time_ns: int, utc: bool) -> str:
    """Return a time on the clock of a record: UTC, or seconds."""
    return instant_text(time_ns) if utc else f"{time_ns // 10**9}.{time_ns % 10**9:09d}"
