"""What a procedure makes of files that nobody has said anything of: the command to type next, a draft of its tests.

Several procedures may want a file: the strongest has it, and among equals the one that comes first in the registry.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING

from ..core.campaign_text import FILL_IN, Noted
from ..core.errors import InertialcalError
from ..core.key import AXES
from ..core.remarks import Remark

if TYPE_CHECKING:
    from ..core.recording import Channel, Recording
    from ..files.info.table_columns import Guess
    from ..files.text.table import Table


Tables = Mapping[str, object]
RELATIVE = "Uncertainties of the standards. Without them, results are relative to the fixture."


class Strength(IntEnum):
    """How clearly a file is made for a procedure."""

    RESERVE = 0  # only where no other can do with it
    POSSIBLE = 1  # as far as channels and motion tell
    LIKELY = 2  # its motion or temperature is made for it
    STEPPED = 3  # so is a channel that nobody moves otherwise
    SURE = 4  # its columns, or its format, say so
    NAMED = 5  # so does another file beside it, which names it


@dataclass(frozen=True)
class Suggestion:
    """The command to type next."""

    commands: tuple[str, ...]  # nouns; the first one that the tool has
    strength: Strength  # ``SURE``: whatever units and time the file leaves open
    complete: bool = False  # nothing needs to be said of its units and time
    in_campaign: bool = False  # also where the file lies in the folder of a campaign
    options: str = ""  # to be typed after the file


@dataclass(frozen=True)
class FolderFile:
    """A file of a folder that a campaign is begun for."""

    table: Table  # as read
    recording: Recording | None = None  # with time; None while it is looked at as a table only
    beside: tuple[Recording, ...] = ()  # other topics of the same file, recorded together with it

    @cached_property
    def columns(self) -> Guess:
        """Columns of rate and reading, as far as names tell."""
        from ..files.info.table_columns import guess  # noqa: PLC0415 - starts slowly

        return guess(self.table)

    @cached_property
    def at_rest(self) -> bool:
        """Whether its sensors stand still."""
        from ..files.info.motion import is_still  # noqa: PLC0415 - starts slowly

        return self.recording is not None and is_still(self.recording)


@dataclass(frozen=True)
class Claim:
    """A file that a procedure wants."""

    strength: Strength  # how clearly
    # what the procedure makes of it, and what there is to remark; called if it has the file
    take: Callable[[], tuple[object, Sequence[Remark]]]


@dataclass(frozen=True)
class Draft:
    """What a procedure adds to a first campaign.toml; values to be filled in are marked by `fill_in`.

    Parameters
    ----------
    sensors, recordings, standards, site : mapping
        Tables by name.
    tests : sequence
        A table each.
    requirement : mapping
        An example of a requirement; the file shows one, commented out.
    example : bool
        Whether its example goes before those of drafts that say no.
    """

    sensors: Tables
    recordings: Tables
    tests: Sequence[object]
    requirement: Tables
    standards: Tables = field(default_factory=dict)
    site: Tables = field(default_factory=dict)
    example: bool = True


@dataclass(frozen=True)
class Question:
    """What a first campaign.toml cannot be told by the files.

    Parameters
    ----------
    name, group : str
        Setting that it answers; group of sensors that it is of, where it differs between them.
    seen, ask : str
        What the files show; what is to be said.
    suggestion : str
        What Enter takes; empty where Enter leaves it open.
    wrong : callable
        What is wrong with an answer; empty where nothing is.
    """

    name: str
    seen: str
    ask: str
    suggestion: str = ""
    group: str = ""
    wrong: Callable[[str], str] = lambda text: ""


def one_of(words: Iterable[str]) -> Callable[[str], str]:
    """Return what is wrong with a word that is none of these."""
    known = tuple(words)
    return lambda text: "" if text in known else f"one of: {', '.join(known)}"


def quantity(unit: str, optional: bool = False, words: Sequence[str] = ()) -> Callable[[str], str]:
    """Return what is wrong with text that is no quantity in such a unit; optional: it may be empty."""

    def wrong(text: str) -> str:
        from ..core.units import parse_quantity  # noqa: PLC0415 - numpy starts slowly

        if text in words or (optional and not text):
            return ""
        try:
            parse_quantity(text).to(unit)
        except InertialcalError as error:
            return error.problems[0].what
        return ""

    return wrong


def unit_of(wanted: str) -> Callable[[str], str]:
    """Return what is wrong with text that is no unit of such a kind."""

    def wrong(text: str) -> str:
        from ..core.units import kind, normalise  # noqa: PLC0415 - numpy starts slowly

        try:
            found = kind(normalise(text))
        except InertialcalError as error:
            return error.problems[0].what
        return "" if found == wanted else f"is of {found}, need a unit of {wanted}".replace("_", " ")

    return wrong


def fill_in(value: object = "?") -> Noted:
    """Return a value that the user has to fill in or confirm."""
    return Noted(value, FILL_IN)


def sensor_table(kind: str, units: Sequence[str | None]) -> dict[str, object]:
    """Return the table of a triad, in the first of these units that is known."""
    unit = next((one for one in units if one), None)
    return {"kind": kind, "axes": list(AXES), "unit": unit or fill_in()}


def recording_table(sensor: str, file: str, recording: Recording, channels: Tables) -> dict[str, object]:
    """Return the table of a recording with these channels."""
    column = recording.time_column
    clock = {"clock": {"column": column}} if column else {}
    return {"sensor": sensor, "file": file, **clock, "channels": dict(channels)}


def channel_tables(channels: Mapping[str, Channel], sure: bool = True) -> dict[str, object]:
    """Return the entries of channels by axis; those without a unit are marked, and all of them if they are not sure."""
    entries = {axis: {"column": one.name, "unit": one.unit or "?"} for axis, one in channels.items()}
    return {axis: entry if sure and channels[axis].unit else fill_in(entry) for axis, entry in entries.items()}
