"""What ``info`` does: the survey of a file, with the command to type next."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ...core.campaign_text import FILE
from ...core.estimate import Array
from ...core.recording import Recording
from ...core.remarks import Remark
from ...files import read
from ...files.info.channel_survey import Hint
from ...files.info.survey import Survey, survey_recording
from ...procedures import procedure_names, procedure_of
from ...procedures.suggestions import Strength, Suggestion

PLACEHOLDER = "UNIT"  # for the user to fill in


def info(
    path: str | Path | Recording | Array,
    *,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    time_column: str | None = None,
    commands: Collection[str] = ("info",),
    start: object = None,
    stop: object = None,
    mission_start: object = None,
    frame: str | None = None,
    decimal: str | None = None,
    skip: int | None = None,
    dates: str | None = None,
) -> Survey:
    """Return what a file holds.

    Parameters
    ----------
    path, units, sample_rate, time_column, start, stop, mission_start, frame, decimal, skip, dates
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
        mission_start=mission_start, frame=frame, decimal=decimal, skip=skip, dates=dates,
    )  # fmt: skip
    found = survey_recording(recording)
    return replace(found, next=next_command(recording, found, commands))


def next_command(recording: Recording, survey: Survey, commands: Collection[str]) -> str | None:
    """Return the next command to type, of those that the tool has; None where there is none."""
    if not recording.source.path or all(channel.quantity == "index" for channel in recording.channels):
        return None
    source = Path(recording.source.path)
    home = next((one for one in [source, *list(source.parents)[:2]] if (one / FILE).is_file()), None)
    word = "init" if home is None else "run"
    folder = f"inertialcal {word} {shlex.quote(str(home or source.parent))}" if word in commands else None
    every = [one for name in procedure_names() if (one := procedure_of(name).suggests(recording, survey)) is not None]
    found = sorted((one for one in every if home is None or one.in_campaign), key=lambda one: -one.strength)
    path = shlex.quote(recording.source.path)
    if (words := _first([one for one in found if one.strength == Strength.SURE], path, commands)) is not None:
        return words
    options = _missing_options(recording, survey.hints, survey.remarks)
    if any(one.complete for one in every):
        return folder
    if options and home is None:
        return f"inertialcal info {path} {' '.join(options)}" if "info" in commands else None
    words = None if options else _first(found, path, commands)  # a campaign says its units itself
    return folder if words is None else words


def _first(suggestions: Sequence[Suggestion], path: str, commands: Collection[str]) -> str | None:
    """Return the first command whose noun the tool has."""
    return next(
        (f"inertialcal {word} {path} {one.options}".rstrip() for one in suggestions for word in one.commands
         if word in commands),
        None,
    )  # fmt: skip


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
