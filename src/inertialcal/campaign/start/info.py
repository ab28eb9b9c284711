"""What ``info`` does: the survey of a file, with the command to type next."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path

from ...files import read
from ...files.info.survey import Survey, survey_recording
from .next_command import next_command


def info(
    path: str | Path,
    *,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    time_column: str | None = None,
    commands: Collection[str] = ("info",),
    start: object = None,
    stop: object = None,
    mission_start: object = None,
    frame: str | None = None,
) -> Survey:
    """Return what a file holds.

    Parameters
    ----------
    path, units, sample_rate, time_column, start, stop, mission_start, frame
        As ``files.read`` takes them.
    commands : collection of str
        Words that the tool knows: only these are suggested as next.

    Raises
    ------
    DataError, UsageError
        As ``files.read``.
    """
    recording = read(
        path, units=units, sample_rate=sample_rate, time_column=time_column, start=start, stop=stop,
        mission_start=mission_start, frame=frame,
    )  # fmt: skip
    found = survey_recording(recording)
    return replace(found, next=next_command(recording, found, commands))
