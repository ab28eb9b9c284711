"""The next command to type, of those that the tool has."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Sequence
from pathlib import Path

from ...core.campaign_text import FILE
from ...core.recording import Recording
from ...core.remarks import Remark
from ...files.info.channel_survey import Hint
from ...files.info.survey import Survey
from ...procedures import procedure_names, procedure_of
from ...procedures.suggestions import Strength, Suggestion

PLACEHOLDER = "UNIT"  # for the user to fill in


def next_command(recording: Recording, survey: Survey, commands: Collection[str]) -> str | None:
    """Return the command that leads on, or None where there is none.

    Parameters
    ----------
    recording : Recording
        As read.
    survey : Survey
        Of it.
    commands : collection of str
        Words that the tool knows: only these are suggested.
    """
    if all(channel.quantity == "index" for channel in recording.channels):
        return None
    path = shlex.quote(recording.source.path)
    alone = not _in_campaign(recording)
    every = [one for name in procedure_names() if (one := procedure_of(name).suggests(recording, survey)) is not None]
    found = sorted((one for one in every if alone or one.in_campaign), key=lambda one: -one.strength)
    if (word := _first([one for one in found if one.strength == Strength.SURE], commands)) is not None:
        return f"inertialcal {word} {path}"
    options = _missing_options(recording, survey.hints, survey.remarks)
    if any(one.complete for one in every):
        return _campaign(recording, commands)
    if options and alone:
        return f"inertialcal info {path} {' '.join(options)}" if "info" in commands else None
    word = None if options else _first(found, commands)  # a campaign says its units itself
    return _campaign(recording, commands) if word is None else f"inertialcal {word} {path}"


def _first(suggestions: Sequence[Suggestion], commands: Collection[str]) -> str | None:
    """Return the first noun that the tool has."""
    return next((word for one in suggestions for word in one.commands if word in commands), None)


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
    return next((one for one in [path, *list(path.parents)[:2]] if (one / FILE).is_file()), None)
