"""The next command to type, of those that the tool has."""

from __future__ import annotations

import re
import shlex
from collections.abc import Collection, Sequence
from pathlib import Path

from ..core.recording import Recording
from ..core.remarks import Remark
from .hints import Hint

PLACEHOLDER = "UNIT"  # for the user to fill in
REDUCED = re.compile(r"(?:\b|_)(?:(?<!sample[_ ])rate|applied|reading)(?:_|\b)", re.IGNORECASE)
CAMPAIGN = "campaign.toml"
REDUCED_ROWS = 10_000  # a longer table is no table of dwells
ARCHIVED = "PAD"  # triaxial heads in orbit
SHORT = 1_000  # samples below which a noise analysis says little


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
    options = _missing_options(recording, hints, remarks)
    if options:
        return f"inertialcal info {path} {' '.join(options)}" if "info" in commands else None
    if recording.source.format.startswith(ARCHIVED):
        return f"inertialcal flip {path}" if "flip" in commands else None
    moving = any(remark.code == "not_at_rest" for remark in remarks)
    turned = any(REDUCED.search(channel.name) for channel in recording.channels) and any(
        channel.axis and channel.quantity == "gyro" for channel in recording.channels
    )  # counts need the chain of a campaign file
    wanted = ["rate-table"] if moving and turned else ["positions"] if moving else ["allan", "psd"]
    if not moving and len(recording) < SHORT:
        wanted = []
    word = next((word for word in wanted if word in commands), None)
    if word is not None:
        return f"inertialcal {word} {path}"
    return _campaign(recording, commands)


def is_reduced_table(recording: Recording) -> bool:
    """Whether a file looks like reduced readings, a row a dwell, by the names of its columns."""
    named = any(REDUCED.search(channel.name) for channel in recording.channels)
    return named and recording.sample_interval is None and len(recording) <= REDUCED_ROWS


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
    folder = Path(recording.source.path).parent
    return f"inertialcal {word} {shlex.quote(str(folder))}" if word in commands else None


def _in_campaign(recording: Recording) -> bool:
    return (Path(recording.source.path).parent / CAMPAIGN).is_file()
