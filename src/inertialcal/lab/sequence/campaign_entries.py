"""Which recordings a campaign names: what a sequence has to make."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ...core.errors import InertialcalError, PlanError, Problem
from ...files.write.recording import writer_for
from .steps import SequenceStep

CAMPAIGN_FILE = "campaign.toml"


@dataclass(frozen=True)
class Wanted:
    """A recording that the campaign names."""

    file: str
    schedule: Mapping[str, str]  # What it says of its schedule; empty: none

    @property
    def columns(self) -> list[str]:
        """Columns that its schedule needs, beside those of time."""
        return [self.schedule[name] for name in ("angle", "dwell", "flip") if name in self.schedule] or [
            self.schedule.get("rate", "rate")
        ]


def wanted_of(campaign: Path) -> dict[str, Wanted]:
    """Return the recordings of a campaign by name.

    Raises
    ------
    PlanError
        ``missing_file``, ``not_toml``.
    """
    path = campaign / CAMPAIGN_FILE
    try:
        document: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        entries = dict(document.get("recordings", {}))
        return {
            name: Wanted(str(one["file"]), dict(one.get("schedule", one.get("dwells", {}))))
            for name, one in entries.items()
        }
    except OSError:
        do = "Name the folder of a campaign, beside LAB.toml"
        raise PlanError("no campaign here", str(path), do=do, code="missing_file") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise PlanError(f"not TOML: {error}", str(path), code="not_toml") from None
    except (KeyError, TypeError, ValueError):
        raise PlanError("a recording without its file", str(path), code="wrong_value") from None


def columns_of(steps: Sequence[SequenceStep]) -> dict[tuple[str, str], str]:
    """Return the column of a schedule for each instrument and quantity that is set.

    It is called as the quantity; with the instrument before it where several instruments have that quantity.
    """
    targets = {(name, quantity) for step in steps for name, quantity, _ in step.values}
    several = Counter(quantity for _, quantity in targets)
    return {one: one[1] if several[one[1]] == 1 else ".".join(one) for one in sorted(targets)}


def campaign_problems(campaign: Path, steps: Sequence[SequenceStep], where: str) -> list[Problem]:
    """Return in what the recordings of a sequence and of a campaign differ."""
    try:
        wanted = wanted_of(campaign)
    except PlanError as error:
        return [replace(one, where=one.where or where) for one in error.problems]
    made = {one.recording for one in steps if one.record is not None}
    columns = sorted({*columns_of(steps).values(), *(name for one in steps for name, _ in one.kept)})
    found, files = [], {wanted[name].file for name in made & wanted.keys()}  # two recordings may be of one file
    for name in sorted(wanted.keys() - made):
        if wanted[name].file not in files and not (campaign / wanted[name].file).is_file():
            what = f"no step records {name}, which the campaign needs"
            do = f'Give a step recording = "{name}"'
            found.append(Problem(what, where, do=do, code="missing_key"))
    for name in sorted(made - wanted.keys()):
        do = "Name it in campaign.toml, or correct recording"
        found.append(Problem(f"the campaign has no recording {name}", where, do=do, code="unknown_name"))
    for name in sorted(made & wanted.keys()):
        file = Path(wanted[name].file)
        inside = not file.is_absolute() and ".." not in file.parts
        if not inside:
            found.append(Problem(f"recordings.{name}: {file} lies outside the campaign", where, code="wrong_value"))
        for column in wanted[name].columns if wanted[name].schedule else ():
            if column not in columns:
                what = f"recordings.{name}: its schedule will have no column {column}"
                do = f"Say in campaign.toml which it is, of {', '.join(columns) or 'what is set: nothing is'}"
                found.append(Problem(what, where, do=do, code="unknown_name"))
        try:
            writer_for(file)
        except InertialcalError as error:
            found += [replace(one, where=where) for one in error.problems]
    return found
