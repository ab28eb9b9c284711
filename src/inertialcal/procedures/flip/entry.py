"""What a campaign says of a flip's recordings: columns of reduced means, positions of the head."""

from __future__ import annotations

import re

from pydantic import Field, field_validator

from ...core.quantities import Angle, Unit
from ...core.schema_words import Strict, Text


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
