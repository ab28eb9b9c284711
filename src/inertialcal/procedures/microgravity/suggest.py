"""What looks like a record of the environment in orbit: the command to type next, a draft of the tests."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ...core.recording import Recording
from ...files import read
from ...files.info.motion import accelerometers
from ...files.info.survey import Survey
from ..archived import Entry, Made, in_orbit, is_turned
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion, channel_tables, sensor_table

REQUIREMENT = {"quantity": "vibratory_rms", "limit": "100 ug"}


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``microgravity`` of a head in orbit; where it was turned, that comes after the flip."""
    return Suggestion(("microgravity",), Strength.SURE) if in_orbit(recording) else None


def in_archive(path: Path) -> Made | None:
    """Return the entry of an archive record in whose readings the head does not turn."""
    recording = read(path)
    return None if is_turned(recording) else (entry_of(recording), ())


def claims(file: FolderFile) -> Claim | None:
    """Claim a recording of a head in orbit."""
    recording = file.recording
    if recording is None or not in_orbit(recording):
        return None
    return Claim(Strength.POSSIBLE, lambda: (entry_of(recording), ()))


def entry_of(recording: Recording) -> Entry:
    """Return the entry of a recording, in the axes of its readings."""
    entry: Entry = {"clock": {"column": recording.time_column}} if recording.time_column else {}
    return entry | {"channels": channel_tables(dict(sorted(accelerometers(recording).items())))}


def draft(contents: Mapping[str, object]) -> Draft:
    """Return the head, its recordings and a test each, by file."""
    units: list[str] = []
    recordings: dict[str, object] = {}
    tests: list[object] = []
    for number, (file, entry) in enumerate(contents.items(), 1):
        assert isinstance(entry, dict)  # noqa: S101 - as claimed
        units += [one["unit"] for one in entry["channels"].values()]
        recordings[f"record{number}"] = {"sensor": "head", "file": file, **entry}
        tests.append({"id": f"environment{number}", "procedure": "microgravity", "recordings": [f"record{number}"]})
    return Draft({"head": sensor_table("accelerometer", units)}, recordings, tests, REQUIREMENT)
