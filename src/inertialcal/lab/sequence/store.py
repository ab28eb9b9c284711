"""Records of steps on the disk, and read again: only what reads back as it came counts.

A record is a Parquet file. When all steps are PASS, those of a recording become the file that the campaign names, and
the as-run schedule beside it: what was set, from when to when.
"""

from __future__ import annotations

import csv
import io
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...core.errors import DataError, InertialcalError, InstrumentError, StoreError
from ...core.recording import Recording
from ...files import read
from ...files.text.headers import bare_name
from ...files.write.atomic import atomic_write
from ...files.write.recording import write
from ..acquisition.seal import sha256
from .as_run import time_text
from .campaign_entries import columns_of, wanted_of
from .steps import SequenceStep

CAMPAIGN, RECORDS = "campaign", "records"


@dataclass(frozen=True)
class Stored:
    """A record that was read again."""

    file: str  # From the folder of the sequence
    sha256: str


def store(folder: Path, name: str, recording: Recording) -> Stored:
    """Write a record, read it again and compare.

    Raises
    ------
    StoreError
        ``not_written``.
    InstrumentError
        ``not_read_again`` if it does not read back as it came.
    """
    path = folder / RECORDS / f"{name}.parquet"
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise StoreError(f"cannot be made: {error.strerror}", str(path.parent), code="not_written") from None
    write(path, recording)
    return Stored(f"{RECORDS}/{path.name}", _compare(path, recording))


def _compare(path: Path, recording: Recording) -> str:
    """Return the SHA-256 of the file that was read again and is as it came."""
    try:
        digest = sha256(path)
        again = read(path)
        unchanged = sha256(path) == digest
    except InertialcalError as error:
        raise InstrumentError(f"{path.name}: {error.problems[0].what}", code="not_read_again") from None
    stamps = again.stamps
    told = recording.stamps
    same = stamps is not None and told is not None and np.array_equal(stamps, told)
    by_name = {name: one.data for one in again.channels for name in (bare_name(one.name), one.name)}
    for one in recording.channels:
        there = by_name.get(one.name)  # the head of a CSV has its unit too
        same &= there is not None and np.array_equal(there, one.data, equal_nan=one.data.dtype.kind == "f")
    if not same or not unchanged:
        raise InstrumentError(f"{path.name} does not read back as it came", code="not_read_again")
    return digest


def is_there(folder: Path, file: str, digest: str) -> bool:
    """Return whether a record is there as it was stored."""
    path = folder / file
    try:
        return path.is_file() and sha256(path) == digest
    except StoreError:
        return False


# ---- the campaign ----


def build_campaign(campaign: Path, folder: Path, steps: Sequence[SequenceStep], records: Mapping[int, Stored]) -> Path:
    """Make the campaign of a sequence that is PASS: its recordings, and the schedule of each as it was run.

    Parameters
    ----------
    campaign : path
        That was prepared.
    folder : path
        Of the sequence.
    steps : sequence of SequenceStep
        All.
    records : mapping of int to Stored
        Step -> its record.

    Raises
    ------
    StoreError
        ``damaged_file`` if a record is no longer as it was stored.
    InertialcalError
        What cannot be read or written.
    """
    target = folder / CAMPAIGN
    shutil.copytree(campaign, target, dirs_exist_ok=True)
    wanted, columns = wanted_of(campaign), columns_of(steps)
    values: dict[str, float] = {}
    parts: dict[str, list[tuple[Recording, dict[str, str]]]] = {}
    for step in steps:
        values |= {columns[name, quantity]: value for name, quantity, value in step.values}
        if step.record is not None:
            own = _as_stored(folder, records[step.number], step.name)
            cells = {name: repr(value) for name, value in values.items()} | dict(step.kept)
            parts.setdefault(step.recording, []).append((own, cells))
    for name, of_steps in parts.items():
        path = target / wanted[name].file
        path.parent.mkdir(parents=True, exist_ok=True)
        whole = _joined([one for one, _ in of_steps], str(path))
        write(path, whole)
        _compare(path, whole)
        schedule = wanted[name].schedule
        if schedule:
            _write_schedule(target / schedule["file"], of_steps)
    return target


def _as_stored(folder: Path, record: Stored, name: str) -> Recording:
    """Return the record of a step, which was PASS, if it still is as it was then."""
    if not is_there(folder, record.file, record.sha256):
        why = f"step {name} was PASS with it, and its SHA-256 is no longer the same"
        do = "Resume the sequence: that record is made anew"
        raise StoreError("the record was changed or removed", str(folder / record.file), why, do, "damaged_file")
    return read(folder / record.file)


def _joined(parts: Sequence[Recording], place: str) -> Recording:
    """Return records one after another; a channel that one of them lacks is left out of all."""
    names = [name for name in parts[0].names if all(name in one.names for one in parts)]
    times = np.concatenate([one.stamps for one in parts if one.stamps is not None])
    if np.any(np.diff(times) < 0):
        what, why = "the records of its steps overlap in time", "the clock of the instrument went back"
        raise DataError(what, place, why, "Give them recordings of their own", "overlap")
    channels = tuple(
        replace(parts[0].channel(name), data=np.concatenate([one.channel(name).data for one in parts]))
        for name in names
    )
    return Recording(channels, times, epoch=parts[0].epoch)


def _write_schedule(path: Path, own: Sequence[tuple[Recording, Mapping[str, str]]]) -> None:
    """Write from when to when what was set, and what is kept.

    From half an interval before the first sample of each record to half of one after its last.
    """
    names = sorted({name for _, values in own for name in values})
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["start", "stop", *names])
    for recording, values in own:
        stamps = recording.stamps
        assert stamps is not None  # noqa: S101 - it was stored with them
        half = int(np.median(np.diff(stamps))) // 2 if len(stamps) > 1 else 0
        utc = recording.epoch == "utc"
        ends = [time_text(int(one), utc) for one in (stamps[0] - half, stamps[-1] + half)]
        rows.writerow([*ends, *(values.get(name, "") for name in names)])
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as aside:
        aside.write_text(text.getvalue(), encoding="utf-8", newline="\n")
