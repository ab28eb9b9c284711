"""What looks like heads on one body: recordings beside the file of that body, each called as a head there.

A file of a body is TOML with a table ``[heads.NAME]`` for each head, in the folder of the recordings or the one above.
A gyro of the body is called ``gyro``.
"""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Mapping
from pathlib import Path

from ...core.recording import Channel, Recording
from ...files.info.motion import accelerometers, gyros
from ...files.info.survey import Survey
from ..archived import Entry
from ..suggestions import Claim, Draft, FolderFile, Strength, Suggestion, channel_tables, sensor_table
from .readings import LEAST

GYRO = "gyro"  # recording of it
LARGEST = 1_000_000  # of a file of a body [byte]
REQUIREMENT = {"quantity": "bias", "limit": "5 ug"}


def body_of(source: Path) -> tuple[Path, tuple[str, ...]] | None:
    """Return the file of the body that a recording is a head of, and all heads there; None where there is none."""
    above = source.parent.parent if source.parent.name else Path("..")
    for folder in (source.parent, above):
        for path in sorted(folder.glob("*.toml")):
            try:
                if path.stat().st_size > LARGEST:
                    continue
                heads = tomllib.loads(path.read_text(encoding="utf-8")).get("heads")
            except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
                continue  # it is no file of a body
            if isinstance(heads, dict) and source.stem in (*heads, GYRO) and len(heads) >= LEAST:
                return path, tuple(heads)
    return None


def suggests(recording: Recording, survey: Survey) -> Suggestion | None:
    """Return ``heads`` of all heads of the body whose recordings lie beside this one."""
    source = Path(recording.source.path)
    found = body_of(source) if _channels(recording) else None
    if found is None:
        return None
    body, heads = found
    beside = [source.with_name(f"{name}{source.suffix}") for name in (*heads, GYRO) if name != source.stem]
    others = [one for one in beside if one.is_file()]
    if sum(one.stem in heads for one in (source, *others)) < LEAST:
        return None
    return Suggestion(("heads",), Strength.NAMED, options=" ".join(
        [*(shlex.quote(str(one)) for one in others), "--body", shlex.quote(str(body))]))  # fmt: skip


def claims(file: FolderFile) -> Claim | None:
    """Claim a recording of a head of a body whose file lies in the folder."""
    recording = file.recording
    if recording is None or not _channels(recording):
        return None
    found = body_of(Path(recording.source.path))
    if found is None:
        return None
    below = found[0].parent != Path(recording.source.path).parent
    return Claim(Strength.NAMED, lambda: ((_entry(recording), found[0].name, below), ()))


def _channels(recording: Recording) -> dict[str, Channel]:
    """Return the axes of a head, or of the gyro, that a recording of this name is of."""
    if Path(recording.source.path).stem == GYRO:
        return gyros(recording)
    return accelerometers(recording)


def _entry(recording: Recording) -> Entry:
    entry: Entry = {"clock": {"column": recording.time_column}} if recording.time_column else {}
    return entry | {"channels": channel_tables(dict(sorted(_channels(recording).items())))}


def draft(contents: Mapping[str, object]) -> Draft:
    """Return heads, their recordings and one test of them all."""
    units: dict[str, list[str]] = {}
    recordings: dict[str, object] = {}
    for file, made in contents.items():
        assert isinstance(made, tuple)  # noqa: S101 - as claimed
        entry, body, below = made
        name, folder = Path(file).stem, Path(file).parent.parent if below else Path(file).parent
        sensor = "gyro" if name == GYRO else "heads"
        head = {} if name == GYRO else {"head": {"file": (folder / body).as_posix()}}
        units.setdefault(sensor, []).extend(one["unit"] for one in entry["channels"].values())
        recordings[name] = {"sensor": sensor, "file": file, **entry, **head}
    sensors = {name: sensor_table("gyro" if name == GYRO else "accelerometer", units[name])
               for name in sorted(units, reverse=True)}  # fmt: skip
    order = sorted(recordings, key=lambda name: name == GYRO)
    tests = [{"id": "bias", "procedure": "heads", "recordings": order}]
    return Draft(sensors, recordings, tests, REQUIREMENT)


def belong_together(contents: object) -> bool:
    """Return whether there are as many heads as a test needs, of one body."""
    assert isinstance(contents, (list, tuple))  # noqa: S101 - as claimed
    return len(contents) >= LEAST and len({one[1] for one in contents}) == 1
