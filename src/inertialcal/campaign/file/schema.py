"""campaign.toml: what may stand in it, and in which unit it is read.

All quantities are text "number unit" and are SI here. Sensors, recordings and standards have their own modules.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from ...core.schema.quantities import Acceleration, Angle, Length, Name, Pressure, Strict, Temperature, Text
from ...core.schema.standards import StandardEntry
from ...core.times import read_instant
from ...procedures.model_terms import TermKind
from .certificate import Certificate
from .decisions import Decision
from .recordings import RecordingEntry
from .sensors import Sensor


class CampaignHead(Strict):
    """[campaign]."""

    id: Name
    title: Text = ""
    source: Text = ""


class Item(Strict):
    """[item]: what is tested."""

    maker: Text = ""
    part: Text = ""
    serial: Text = ""
    owner: Text = ""
    lot: Text = ""

    def content(self) -> dict[str, str]:
        """Return what ``results.json`` holds of it; what is asked for by the archive alone only where it is stated."""
        found: dict[str, str] = self.model_dump()
        return {name: one for name, one in found.items() if one or name in ("maker", "part", "serial")}


class Site(Strict):
    """[site]: where."""

    latitude: Angle | None = None
    height: Length | None = None
    gravity: Acceleration | None = None


def site_text(site: Site) -> str:
    """Return what is stated of a site as a label; empty where nothing is."""
    given = {"latitude": (site.latitude, 180.0 / pi, "deg"), "height": (site.height, 1.0, "m"),
             "gravity": (site.gravity, 1.0, "m/s^2")}  # fmt: skip
    return ", ".join(f"{name} {x * scale:.12g} {unit}" for name, (x, scale, unit) in given.items() if x is not None)


Window = tuple[int, int]


class Test(Strict):
    """[[tests]]."""

    __test__ = False  # not a test class of pytest

    id: Name
    procedure: Name
    recordings: list[Name] = Field(min_length=1)
    use: Literal["fit", "hold_out", "report_only"] = "fit"
    groups: list[Text] | None = Field(default=None, min_length=1)
    windows: list[Window] | None = Field(default=None, min_length=1)
    condition: Text = ""
    mounting: Text = ""
    power_up: Text = ""
    day: Text = ""
    source: Text = ""
    against: Name | None = None
    after: list[Name] = Field(default=[])
    plan: dict[str, Any] = Field(default={})

    @field_validator("windows", mode="before")
    @classmethod
    def _instants(cls, given: object) -> object:
        if not isinstance(given, list):
            return given
        return [_window(pair) for pair in given]

    @model_validator(mode="after")
    def _apart(self) -> Test:
        windows = sorted(self.windows or [])
        for one, other in pairwise(windows):
            if other[0] < one[1]:
                raise ValueError("two windows overlap: a reading would count twice")
        return self


def _window(pair: object) -> Window:
    if not isinstance(pair, list) or len(pair) != 2:
        raise ValueError(f"window {pair!r}: needs a start and a stop")
    start, stop = read_instant(pair[0]), read_instant(pair[1])
    if stop <= start:
        raise ValueError(f"window {pair!r}: stop is not after start")
    return start, stop


Pressures = Annotated[list[Pressure], Field(min_length=2, max_length=2)]
Temperatures = Annotated[list[Temperature], Field(min_length=2, max_length=2)]


class Condition(Strict):
    """[conditions.NAME]: what the sensor is in, and the ranges that its model holds for."""

    text: Text = ""
    pressure: Pressures | None = None
    temperature: Temperatures | None = None

    @model_validator(mode="after")
    def _rise(self) -> Condition:
        for name, given in (("pressure", self.pressure), ("temperature", self.temperature)):
            if given is not None and not given[0] < given[1]:
                raise ValueError(f"{name}: the second value is not above the first")
        return self


Terms = dict[TermKind, list[Name]]


class Model(Strict):
    """[model]: which tests each kind of term comes from; without it, all tests with use = "fit" of its condition."""

    terms: Terms = Field(default={})  # In every condition
    by_condition: dict[Name, Terms] = Field(default={})  # In one: tests of other conditions may be named


class Requirement(Strict):
    """[[requirements]]: what is asked of which quantity, under which conditions."""

    id: Name
    text: Text = ""
    quantity: Name
    axis: Annotated[str, Field(pattern="^[xyz]{1,2}$")] | None = None
    of: Literal["expected", "dwell_mean", "reading", "change"] = "dwell_mean"
    limit: str | None = None
    lower: str | None = None
    upper: str | None = None
    where: Text = ""
    readings: Literal["as_read", "compensated"] = "as_read"
    condition: Text | None = None
    tests: list[Name] | None = Field(default=None, min_length=1)
    decision: Decision | None = None

    @model_validator(mode="after")
    def _limits(self) -> Requirement:
        if self.limit is not None and (self.lower is not None or self.upper is not None):
            raise ValueError("limit stands for both sides: give limit, or lower and upper")
        if self.of == "change" and (self.lower is not None or self.upper is not None):
            raise ValueError("of a change: give limit, the largest that does not matter, either way")
        if self.limit is None and self.lower is None and self.upper is None and self.of != "change":
            raise ValueError("needs limit, lower or upper")
        return self


class CampaignFile(Strict):
    """The whole campaign.toml."""

    schema_version: Literal[2] = Field(alias="schema")
    campaign: CampaignHead
    item: Item = Item()
    site: Site = Site()
    conditions: dict[Name, Condition] = Field(default={})
    standards: dict[str, dict[str, StandardEntry]] = Field(default={})
    sensors: dict[Name, Sensor] = Field(min_length=1)
    recordings: dict[Name, RecordingEntry] = Field(min_length=1)
    tests: list[Test] = Field(min_length=1)
    model: Model = Model()
    decision: Decision = Decision()
    requirements: list[Requirement] = Field(default=[])
    certificate: Certificate = Certificate()
