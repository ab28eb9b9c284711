"""Files that say in their name that a mean is wanted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath

from inertialcal.core.recording import Recording
from inertialcal.procedures.suggestions import (
    Claim,
    Draft,
    FolderFile,
    Strength,
    Suggestion,
    channel_tables,
    recording_table,
    sensor_table,
)


def _named(recording: Recording) -> bool:
    return PurePath(recording.source.path).name[:5] == "mean_"


def suggests(recording: Recording) -> Suggestion | None:
    """Return the command for such a file."""
    return Suggestion(("mean-reading",), Strength.SURE) if _named(recording) else None


def claims(file: FolderFile) -> Claim | None:
    """Claim such a file."""
    recording = file.recording
    wanted = recording is not None and _named(recording)
    return Claim(Strength.SURE, lambda: (recording, ())) if wanted else None


def draft(contents: Mapping[str, object]) -> Draft:
    """Return sensor, recordings and one test."""
    recordings = {file: one for file, one in contents.items() if isinstance(one, Recording)}
    own = {file: {c.axis: c for c in one.channels if c.axis} for file, one in recordings.items()}
    units = [channel.unit for channels in own.values() for channel in channels.values()]
    entries = {PurePath(file).stem: recording_table("suite", file, one, channel_tables(own[file]))
               for file, one in recordings.items()}  # fmt: skip
    sensor = sensor_table("gyro", units) | {"axes": sorted({axis for channels in own.values() for axis in channels})}
    test = {"id": "mean", "procedure": "mean_reading", "recordings": list(entries)}
    return Draft({"suite": sensor}, entries, [test], {"quantity": "mean_reading", "limit": "0.1 deg/s"})
