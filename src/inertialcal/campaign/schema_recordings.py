"""[recordings] of campaign.toml: reduced tables, recordings of channels, and how the unit was moved meanwhile."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from ..core.times import read_instant
from .positions_words import FACES, LIKE, direction_of
from .quantities import Angle, Duration, Unit
from .schema_words import Axis, Name, Strict, Text

Columns = Text | dict[Axis, Text]


class Rows(Strict):
    """rows = {...}: which column of a reduced table is what; a row is a dwell."""

    applied: Text
    reading: Columns
    unit: Unit
    applied_unit: Unit | None = None
    scatter: Columns | None = None
    samples: Text | None = None
    axis: Text | None = None
    group: Text | None = None
    run: Text | None = None
    time: Text | None = None


class Means(Strict):
    """means = {...}: which column of a table of reduced means is what; a row is the mean of one axis in one dwell."""

    axis: Text
    position: Text
    mean: Text
    unit: Unit
    angles: dict[Text, Angle]
    flip: Text | None = None
    temperature: Text | None = None
    predicted: Text | None = None
    half_widths: dict[Text, Text] = Field(default={})

    @field_validator("half_widths")
    @classmethod
    def _probabilities(cls, given: dict[str, str]) -> dict[str, str]:
        for text in given:
            if not re.fullmatch(r"0?\.\d{1,9}", text):
                raise ValueError(f'half_widths: {text!r} is no probability: write it like "0.95"')
        return given


class Position(Strict):
    """An entry of ``positions``: when a head stood still, and how it was turned then."""

    start: str | int | float
    stop: str | int | float
    angle: Angle
    flip: Text = "1"


class Lines(Strict):
    """lines = {...}: which column of a table of reduced runs is what; a row is a run with a moved mass."""

    run: Text
    applied: Text
    applied_unit: Unit
    response: Text
    noise: Text
    unit: Unit
    beside: int = Field(default=8, gt=0)
    psd_response: Text | None = None
    psd_noise: Text | None = None
    scatter: Text | None = None
    moved: Text | None = None
    u_applied: str | None = None


class MovedMass(Strict):
    """mass = {...}: the schedule of the mass that is moved during a recording, and when it begins."""

    schedule: Text
    begin: str | int | float | None = None
    moved: bool = True


class Clock(Strict):
    """clock = {...}: which column is time, and which part of its averaging window a stamp means."""

    column: Text | None = None
    stamp: Literal["start", "middle", "end"] = "middle"
    interval: Duration | None = None
    averaging: Duration | None = None
    mission_start: str | None = None

    @field_validator("mission_start")
    @classmethod
    def _instant(cls, given: str | None) -> str | None:
        if given is not None:
            read_instant(given)
        return given


class ChannelEntry(Strict):
    """NAME = { column, unit } in ``channels``."""

    column: Text
    unit: Unit


class Schedule(Strict):
    """schedule = {...}: a table of the dwells of a recording, a row a dwell, on its clock."""

    file: Text
    start: Text = "start"
    stop: Text = "stop"
    rate: Text = "rate"
    unit: Unit


ChannelName = Annotated[
    str,
    Field(
        pattern=r"^(applied|pressure|tilt|reference|temperature|temperature_reference|gain"
        r"|((reference|temperature|temperature_reference|validity|gain)_)?[xyz])$"
    ),
]
Step = Literal["bias", "scale_factor", "misalignment"]  # of a ground model


def _orientation(text: str) -> str:
    if text != FACES and direction_of(text) is None:
        raise ValueError(f"{text!r} is no position; there are: {LIKE}; or {FACES} alone")
    return text


Orientation = Annotated[str, AfterValidator(_orientation)]


class RecordingEntry(Strict):
    """[recordings.NAME]: a reduced table (``rows``, ``means``, ``lines``) or a recording of channels (``channels``)."""

    sensor: Name
    file: Text
    rows: Rows | None = None
    means: Means | None = None
    lines: Lines | None = None
    channels: dict[ChannelName, ChannelEntry] | None = None
    clock: Clock | None = None
    frame: Literal["data", "sensor"] | None = None
    schedule: Schedule | None = None
    positions: list[Position] | None = Field(default=None, min_length=1)
    mass: MovedMass | None = None
    orientations: list[Orientation] | None = Field(default=None, min_length=1)
    sections: Text | None = None
    turn: Angle | None = None
    axis: Axis | None = None
    run: Text | None = None
    applied: list[Step] | None = None
    source: Text = ""

    @model_validator(mode="after")
    def _one_kind(self) -> RecordingEntry:
        if [self.rows, self.means, self.lines, self.channels].count(None) != 3:
            raise ValueError("needs rows, means or lines (a reduced table) or channels (a recording), one of them")
        keys = ("clock", "frame", "schedule", "positions", "mass", "orientations", "sections", "turn", "axis", "run",
                "applied")  # fmt: skip
        extra = [name for name in keys if getattr(self, name) is not None]
        if self.channels is None and extra:
            raise ValueError(f"{', '.join(extra)}: only with channels; a reduced table names its columns")
        if FACES in (self.orientations or ()) and self.orientations != [FACES]:
            raise ValueError(f'orientations: "{FACES}" stands alone, for all positions')
        return self
