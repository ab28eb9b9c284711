"""What ``info`` does: the survey of a file, with the command to type next."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...core.errors import InertialcalError, Problem
from ...core.estimate import Array
from ...core.recording import Recording
from ...core.remarks import Remark
from ...core.settings import settings_of
from ...core.units import kind
from ...files.info.channel_survey import Hint
from ...files.info.motion import accelerometers, gyros
from ...files.info.survey import Survey, survey_recording
from ...files.info.table_columns import guess_channels
from ...files.own import around
from ...procedures import procedure_names, procedure_of
from ...procedures.given import READING, Said
from ...procedures.suggestions import Strength, Suggestion
from ..calls.given import read_as_said

# Of the data sheet, for the user to fill in; no nominal value is invented.
CHAIN = {
    "count": '--lsb "NUMBER V" --reference "NUMBER V" --scale-factor "NUMBER V/(UNIT)"',
    "V": '--reference "NUMBER V" --scale-factor "NUMBER V/(UNIT)"',
}
PLACEHOLDER = "UNIT"  # for the user to fill in


def info(
    path: str | Path | Recording | Array,
    *,
    columns: Mapping[str, str] | None = None,
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
    topics: Sequence[str] | None = None,
) -> Survey:
    """Return what a file holds.

    Parameters
    ----------
    path, units, sample_rate, time_column, start, stop, mission_start, frame, decimal, skip, dates, topics
        As ``files.read`` takes them.
    columns : mapping of str to str, optional
        Column by what it is, ``{"x": "wx", "temperature": "probe"}``: those alone are shown.
    commands : collection of str
        Words that the tool knows: only these are suggested as next.

    Raises
    ------
    DataError, UsageError
        As ``files.read``.
    """
    given: dict[str, Any] = {
        "columns": columns or {}, "units": units or {}, "sample_rate": sample_rate, "time_column": time_column,
        "start": start, "stop": stop, "mission_start": mission_start, "frame": frame, "decimal": decimal,
        "skip": skip, "dates": dates, "topics": list(topics or ()),
    }  # fmt: skip
    return _survey(path, Said(**given), commands)


def _survey(path: str | Path | Recording | Array, said: Said, commands: Collection[str]) -> Survey:
    recording = read_as_said(path, said)
    found = survey_recording(recording)
    return replace(found, next=next_command(recording, found, commands, _said(said)))


def surveys(path: Path, said: Said, commands: Collection[str]) -> tuple[list[Survey], list[Problem]]:
    """Return what a file holds, and what cannot be read of it: each of its recordings, where it has several.

    Where topics are named, they are one recording.
    """
    try:
        return [_survey(path, said, commands)], []
    except InertialcalError as error:
        choices = error.problems[0].choices
        if said.topics or not choices:
            return [], list(error.problems)
    found, problems = list[Survey](), list[Problem]()
    for name in choices:
        try:
            one = _survey(path, replace(said, topics=[name]), commands)
        except InertialcalError as error:
            problems += error.problems
            continue
        found.append(replace(one, source=replace(one.source, format=f"{one.source.format}, {name}")))
    return found, problems


def _said(said: Said) -> tuple[str, ...]:
    """Return what was said of a file as options, to be said again to the next command."""
    found = list[str]()
    for one in settings_of(Said):
        value = getattr(said, one.name)
        if one.name not in READING or value is None:
            continue
        texts = [key if key == text else f"{key}={text}" for key, text in value.items()] if one.pairs else \
            value if one.many else [value]  # fmt: skip
        found += [f"--{one.option} {shlex.quote(str(text))}" for text in texts]
    return tuple(found)


def next_command(
    recording: Recording, survey: Survey, commands: Collection[str], said: Sequence[str] = ()
) -> str | None:
    """Return the next command to type, of those that the tool has; None where there is none.

    ``said`` are the options that the file was read with.
    """
    if not recording.source.path or all(channel.quantity == "index" for channel in recording.channels):
        return None
    source = Path(recording.source.path)
    about = around(source)
    whole = f"inertialcal init {shlex.quote(str(source.parent))}" if about is None else about.do
    folder = whole if whole.split()[1] in commands else None
    every = suggestions(recording, survey)
    found = [(name, one) for name, one in every if about is None or one.in_campaign]
    path = " ".join([shlex.quote(recording.source.path), *said])
    raw = () if about is not None else _raw(recording, survey)
    sure = [(name, one) for name, one in found if one.strength >= Strength.SURE]
    if (words := _first(sure, path, commands, raw)) is not None:
        return words
    hints = [hint for hint in survey.hints if not (hint.unit == "count" and _through_chain(found))]
    options = _missing_options(recording, hints, survey.remarks)
    if any(one.complete for _, one in every):
        return folder
    if options and about is None:
        return f"inertialcal info {path} {' '.join(options)}" if "info" in commands else None
    if about is None and not found and any(remark.code == "nameless_columns" for remark in survey.remarks):
        return None  # the remark says what to type
    words = None if options else _first(found, path, commands, raw)  # a campaign says its units itself
    unclear = about is None and not every and accelerometers(recording) and not gyros(recording)
    return words or (None if unclear else folder)  # they move as in no test that shows by itself: nor for `init`


def suggestions(recording: Recording, survey: Survey) -> list[tuple[str, Suggestion]]:
    """Return the procedures that a file looks made for, the strongest first: what `info` and `init` go by."""
    made = [(name, procedure_of(name).suggests(recording, survey)) for name in procedure_names()]
    return sorted(((name, one) for name, one in made if one is not None), key=lambda pair: -pair[1].strength)


def _through_chain(found: Sequence[tuple[str, Suggestion]]) -> bool:
    """Whether the first procedure takes counts and volts through a chain only."""
    inputs = procedure_of(found[0][0]).inputs if found else None
    return inputs is not None and not (inputs.bare or inputs.raw or inputs.pulses)


def _raw(recording: Recording, survey: Survey) -> tuple[str, ...]:
    """Return which of count and V the sensors of a recording are in, as far as units and numbers tell."""
    named = guess_channels(recording.channels)
    readings = [one for one in recording.channels if one.name in named.readings]
    read = [one for one in recording.channels if one.axis and one.quantity in ("gyro", "acc")] or readings
    counted = {hint.target for hint in survey.hints if hint.unit == "count"}
    kinds = {kind(one.unit) if one.unit else "count" if counted & {one.quantity, one.name} else "" for one in read}
    return tuple(unit for word, unit in (("count", "count"), ("voltage", "V")) if word in kinds)


def _first(
    found: Sequence[tuple[str, Suggestion]], path: str, commands: Collection[str], raw: Sequence[str]
) -> str | None:
    """Return the first command whose noun the tool has, with what readings in counts or volts need."""
    for name, one in found:
        for word in one.commands:
            if word in commands:
                chain = CHAIN[raw[0]] if raw and _through_chain([(name, one)]) else ""
                return " ".join(part for part in ("inertialcal", word, path, one.options, chain) if part)
    return None


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
