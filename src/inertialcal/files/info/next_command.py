"""The next command to type, of those that the tool has."""

from __future__ import annotations

import re
import shlex
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...core.units import factor, kind
from .hints import Hint

PLACEHOLDER = "UNIT"  # for the user to fill in
REDUCED = re.compile(r"(?:\b|_)(?:(?<!sample[_ ])rate|applied|reading)(?:_|\b)", re.IGNORECASE)
CAMPAIGN = "campaign.toml"
REDUCED_ROWS = 10_000  # a longer table is no table of dwells
AXIS_COLUMNS = {"axis", "channel", "sensor"}
POSITION_COLUMNS = {"position", "orientation", "attitude", "turned"}
FREE_FALL = 0.1  # [g]: on the ground a triad reads 1 g in all
ARCHIVED = "pad"  # triaxial heads in orbit
GRAVITY = 0.5  # least that an axis feels of it, in any position of a triad [g]
SHORT = 1_000  # samples below which a noise analysis says little
SWING = 10.0  # change of the temperature that nobody makes by accident [K]


def next_command(
    recording: Recording, hints: Sequence[Hint], remarks: Sequence[Remark], commands: Collection[str]
) -> str | None:
    """Return the command that leads on, or None where there is none.

    Parameters
    ----------
    recording : Recording
        As read.
    hints : sequence of Hint
        At units that nobody said.
    remarks : sequence of Remark
        Of the survey.
    commands : collection of str
        Words that the tool knows: only these are suggested.
    """
    if all(channel.quantity == "index" for channel in recording.channels):
        return None
    path = shlex.quote(recording.source.path)
    if is_reduced_table(recording):
        alone = "rate-table" in commands and not _in_campaign(recording)
        return f"inertialcal rate-table {path}" if alone else _campaign(recording, commands)
    alone = not _in_campaign(recording)
    if alone and "flip" in commands and _is_of_flip(recording, remarks):
        return f"inertialcal flip {path}"
    options = _missing_options(recording, hints, remarks)
    if options and alone:
        return f"inertialcal info {path} {' '.join(options)}" if "info" in commands else None
    if not options and alone and "thermal" in commands and _is_over_temperature(recording):
        return f"inertialcal thermal {path}"
    word = None if options else _test_of(recording, remarks, commands)  # a campaign says its units itself
    return _campaign(recording, commands) if word is None else f"inertialcal {word} {path}"


def _test_of(recording: Recording, remarks: Sequence[Remark], commands: Collection[str]) -> str | None:
    """Return the test that a recording with units and time looks made for."""
    moving = any(remark.code == "not_at_rest" for remark in remarks)
    turned = any(REDUCED.search(channel.name) for channel in recording.channels) and any(
        channel.axis and channel.quantity == "gyro" for channel in recording.channels
    )  # counts need the chain of a campaign file
    wanted = ["allan", "psd"] if len(recording) >= SHORT else []
    if moving:
        wanted = ["rate-table"] if turned else ["positions"] if _is_laid(recording) else []
    return next((word for word in wanted if word in commands), None)


def _is_over_temperature(recording: Recording) -> bool:
    """Whether sensors with a unit were read while their temperature was made to change."""
    warm = [one for one in recording.channels if one.unit is not None and kind(one.unit) == "temperature"]
    read = [one for one in recording.channels if one.axis and one.quantity in ("gyro", "acc") and one.unit]
    return any(float(np.ptp(one.data)) > SWING for one in warm) and any(one.unit != "count" for one in read)


def is_reduced_table(recording: Recording) -> bool:
    """Whether a file looks like reduced readings, a row a dwell, by the names of its columns."""
    named = any(REDUCED.search(channel.name) for channel in recording.channels)
    return named and recording.sample_interval is None and len(recording) <= REDUCED_ROWS


def _is_of_flip(recording: Recording, remarks: Sequence[Remark]) -> bool:
    """Whether a file looks like one of a head in orbit: an archive record, means of a flip, or a triad in free fall."""
    archived = recording.source.reader == ARCHIVED
    return archived or _is_of_means(recording, remarks) or _floats(recording)


def _is_of_means(recording: Recording, remarks: Sequence[Remark]) -> bool:
    """Whether a file looks like means of a flip, by its columns: axes, positions, and an acceleration."""
    names = {one.subject.lower() for one in remarks if one.code == "text_column"}
    means = any(one.unit is not None and kind(one.unit) == "acceleration" for one in recording.channels)
    return means and bool(names & AXIS_COLUMNS) and bool(names & POSITION_COLUMNS)


def _floats(recording: Recording) -> bool:
    """Whether this is a triad of accelerometers, and nothing of gyros, that feels next to nothing of gravity."""
    if recording.time_ns is None or any(one.quantity == "gyro" for one in recording.channels):
        return False
    sizes = [abs(float(np.median(one.data))) * factor(one.unit or "", "g") for one in _triad(recording)]
    return len(sizes) == 3 and max(sizes) < FREE_FALL


def _is_laid(recording: Recording) -> bool:
    """Whether a triad of accelerometers feels gravity, and no campaign file is there."""
    sizes = [float(np.max(np.abs(one.data))) * factor(one.unit or "", "g") for one in _triad(recording)]
    return not _in_campaign(recording) and len(sizes) == 3 and max(sizes) > GRAVITY


def _triad(recording: Recording) -> list[Channel]:
    """Return the accelerometers x, y, z whose unit is known."""
    named = (one for one in recording.channels if one.axis in ("x", "y", "z") and one.unit)
    return [one for one in named if kind(one.unit or "") == "acceleration"]


def _missing_options(recording: Recording, hints: Sequence[Hint], remarks: Sequence[Remark]) -> list[str]:
    """Options of ``info`` that would say what the file does not."""
    options = [f"--unit {shlex.quote(f'{hint.target}={hint.unit or PLACEHOLDER}')}" for hint in hints]
    unknown = [remark for remark in remarks if remark.code == "time_unit_unknown"]
    clocks = [c.name for c in recording.channels if c.quantity == "time" and c.unit is None]
    if unknown and clocks:
        options.append(f"--unit {shlex.quote(f'{clocks[0]}={PLACEHOLDER}')}")
    elif recording.sample_interval is None:
        options.append("--sample-rate HZ")
    return options


def _campaign(recording: Recording, commands: Collection[str]) -> str | None:
    """Return what to do with the folder: its campaign file is to be written once, then to be run."""
    word = "run" if _in_campaign(recording) else "init"
    folder = _campaign_folder(recording) or Path(recording.source.path).parent
    return f"inertialcal {word} {shlex.quote(str(folder))}" if word in commands else None


def _in_campaign(recording: Recording) -> bool:
    return _campaign_folder(recording) is not None


def _campaign_folder(recording: Recording) -> Path | None:
    """Return the folder of the campaign that a file lies in, beside campaign.toml or one folder below."""
    path = Path(recording.source.path)
    return next((one for one in [path, *list(path.parents)[:2]] if (one / CAMPAIGN).is_file()), None)
