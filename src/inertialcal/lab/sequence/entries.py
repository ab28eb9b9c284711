"""What LAB.toml says of a sequence: ``[sequence]``, its steps, or a schedule whose rows become steps."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic import Strict as Strictly

from ...core.schema.quantities import Duration, Name, Strict, Text

Texts = Annotated[tuple[Text, ...], Strictly(False), Field(max_length=64)]
LONGEST = 1e8  # [s]


class StableEntry(Strict):
    """What has to be steady, for how long, and how long that may take."""

    instrument: Text = ""  # whose rows are judged; that which is recorded if not given
    still: Texts = ()  # channels that have to be at rest
    channel: Text = ""  # channel that has to be held
    follows: Text = ""  # what was set, whose value it has to have: ``"table.rate"``
    at: Text = ""  # the value that it has to have, in place of follows
    within: Text = ""  # how far from its value it may be
    lasting: Annotated[Duration, Field(alias="for", ge=0.0, le=LONGEST)] = 10.0  # [s]
    limit: Annotated[Duration, Field(gt=0.0, le=LONGEST)] = 600.0  # [s]


class RecordEntry(Strict):
    """How long is recorded: so long, or until the mean is known well enough."""

    least: Annotated[Duration, Field(alias="for", gt=0.0, le=LONGEST)]  # [s]
    u: Text = ""  # standard uncertainty of the mean that is wanted
    channels: Texts = ()  # of these; needed with u
    limit: Annotated[Duration, Field(gt=0.0, le=LONGEST)] | None = None  # of the time with u [s]


class SequenceStepEntry(Strict):
    """A step."""

    name: Text = ""
    recording: Name | None = None  # of which its record is a part; by default its number
    prompt: Text = ""  # what the operator has to do first
    set: dict[Text, Text] = Field(default_factory=dict)
    hold: Annotated[Duration, Field(ge=0.0, le=LONGEST)] = 0.0  # after it is set [s]
    stable: StableEntry | None = None
    record: RecordEntry | None = None


class ScheduleEntry(Strict):
    """A table whose rows become steps, as ``plan`` writes them."""

    file: Text
    set: dict[Text, Text] = Field(default_factory=dict)  # what is set -> column
    name: Text = ""  # column of names
    recording: Text = ""  # column of recordings, or the one recording of all where there is no such column
    prompt: Text = ""  # column of prompts; or one prompt of all, in which {name} stands for the name of the step
    duration: Text = ""  # column; by default stop less start where there are such columns
    keep: Texts = ()  # columns that the schedule as it was run has too
    stable: StableEntry | None = None
    record: RecordEntry | None = None


class SequenceEntry(Strict):
    """All of it."""

    campaign: Text = ""  # folder with campaign.toml, beside LAB.toml; run when every step is PASS
    instrument: Text = ""  # whose rows are recorded; needed where several give rows
    tries: Annotated[int, Field(ge=1, le=100)] = 1  # of a step
    silence: Annotated[Duration, Field(gt=0.0, le=LONGEST)] = 60.0  # without a row, after which a step has failed [s]
    steps: Annotated[tuple[SequenceStepEntry, ...], Strictly(False), Field(max_length=100_000)] = ()
    schedule: ScheduleEntry | None = None
