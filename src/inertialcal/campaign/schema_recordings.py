"""[recordings] of campaign.toml: reduced tables, recordings of channels, and how the unit was moved meanwhile."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from ..core.quantities import Angle, Duration, Unit
from ..core.schema_words import Axis, Name, Strict, Text
from ..core.times import read_instant
from ..procedures.flip.entry import Means, Position
from ..procedures.mass_attraction.entry import Lines, MovedMass
from ..procedures.positions.entry import Orientation
from ..procedures.positions.orientations.text import FACES
from ..procedures.rate_table.entry import Rows, Schedule
from ..procedures.sine.entry import KnownDrive


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


ChannelName = Annotated[
    str,
    Field(
        pattern=r"^(applied|pressure|tilt|reference|temperature|temperature_reference|gain"
        r"|((reference|temperature|temperature_reference|validity|gain)_)?[xyz])$"
    ),
]
Step = Literal["bias", "scale_factor", "misalignment"]  # of a ground model


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
    drive: KnownDrive | None = None
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
        keys = ("clock", "frame", "schedule", "positions", "mass", "drive", "orientations", "sections", "turn", "axis",
                "run", "applied")  # fmt: skip
        extra = [name for name in keys if getattr(self, name) is not None]
        if self.channels is None and extra:
            raise ValueError(f"{', '.join(extra)}: only with channels; a reduced table names its columns")
        if FACES in (self.orientations or ()) and self.orientations != [FACES]:
            raise ValueError(f'orientations: "{FACES}" stands alone, for all positions')
        return self
