"""campaign.toml: what may stand in it, and in which unit it is read.

All quantities are text "number unit" and are SI here. Unknown keys are refused: a misspelt key would be a
setting that silently does nothing.
"""

from __future__ import annotations

import math
import re
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from ..core.influence import Influence
from ..core.times import read_instant
from ..core.units import kind, parse_quantity
from .quantities import Acceleration, Angle, Duration, Length, Unit, Voltage

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=64)]
Text = Annotated[str, Field(max_length=2000)]
Axis = Literal["x", "y", "z"]
PerAxis = str | dict[Axis, str]  # one quantity for all axes, or one each

LARGEST = 1e9  # uncertainty of a standard, SI: beyond it a digit or a unit is wrong

# Influences that may stand under [standards.NAME], with the unit that they are read into.
STANDARDS: dict[str, dict[str, str]] = {
    "rate_table": {"rate": "1", "mounting": "rad"},
    "turn": {"angle": "rad", "axis": "rad"},
    "converter": {"reference": "1", "zero": "m/s^2"},
    "sensor": {"scale_factor": "1", "hysteresis": "rad/s"},
    "thermometer": {"temperature": "degC"},
    "site": {"latitude": "rad"},
    "source_mass": {"density": "1", "placing": "1", "gravitational_constant": "1"},
    "tilt_meter": {"mercury": "rad"},
    "pad": {"tilt": "rad"},
    "gravity": {"value": "m/s^2"},
    "fixture": {"orientation": "rad", "mounting": "rad"},
    "clock": {"rate": "1"},
}


class Strict(BaseModel):
    """Unknown keys are refused; nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


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


class Site(Strict):
    """[site]: where."""

    latitude: Angle | None = None
    height: Length | None = None
    gravity: Acceleration | None = None


class StandardEntry(Strict):
    """Uncertainty of a standard: one of ``u``, ``expanded`` with ``k``, or ``half_width``."""

    u: str | None = None
    expanded: str | None = None
    k: float | None = Field(default=None, gt=0)
    half_width: str | None = None
    dof: float | None = Field(default=None, gt=0)
    certificate: Text = ""

    @model_validator(mode="after")
    def _one_form(self) -> StandardEntry:
        given = [name for name in ("u", "expanded", "half_width") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"needs one of u, expanded (with k) or half_width; given: {', '.join(given) or 'none'}")
        if (self.expanded is None) != (self.k is None):
            raise ValueError("expanded and k go together: U = k u")
        return self

    def influence(self, unit: str) -> Influence:
        """Return the standard uncertainty in ``unit``.

        Raises
        ------
        DataError
            If the text is no quantity of that kind, or not positive.
        """
        text, divisor = (self.u, 1.0) if self.u is not None else (self.expanded, self.k or 1.0)
        if self.half_width is not None:
            text, divisor = self.half_width, math.sqrt(3.0)
        quantity = parse_quantity(text or "")
        u = quantity.to(unit, difference=True) / divisor
        if not 0.0 <= u <= LARGEST:
            raise ValueError(f"{text!r}: an uncertainty is positive and finite, and no larger than {LARGEST:g} {unit}")
        shape = "rectangular" if self.half_width is not None else "normal"
        dof = math.inf if self.dof is None else self.dof
        return Influence(u, unit, dof, shape, self.certificate, (quantity.value / divisor, quantity.unit))


class Thermometer(Strict):
    """thermometer = {...}: temperature from the voltage of its channel, T = (v - voltage) / slope + temperature."""

    slope: PerAxis
    voltage: PerAxis
    temperature: PerAxis


Polynomial = Annotated[list[str], Field(min_length=1, max_length=5)]  # in temperature, up to fourth order
Pair = Annotated[str, Field(pattern="^(xy|xz|yx|yz|zx|zy)$")]
GainText = Annotated[str, Field(pattern=r"^\d{1,9}(\.\d{1,9})?$")]


class AtGain(Strict):
    """ground.gains.GAIN: polynomials of each axis at one gain, and the zero of the electronics there."""

    bias: dict[Axis, Polynomial]
    scale_factor: dict[Axis, Polynomial] | None = None
    zero: PerAxis | None = None


class Ground(Strict):
    """chain.ground = {...}: a model of the head that was made on the ground."""

    gains: dict[GainText, AtGain] = Field(min_length=1)
    misalignment: dict[Pair, Polynomial] = {}
    reference_temperature: PerAxis = "0 degC"
    temperature_range: list[str] | None = Field(default=None, min_length=2, max_length=2)
    source: Text = ""


class Chain(Strict):
    """chain = {...}: from counts to the unit of the sensor."""

    kind: Literal["none", "adc", "pulse_rate"]
    lsb: Voltage | None = None
    counts: tuple[int, int] | None = None
    reference: Literal["channel"] | Voltage | None = None
    scale_factor: PerAxis | None = None
    gate: Duration | None = None
    gain: float | dict[Axis, float] = 1.0
    zero: PerAxis | None = None
    thermometer: Thermometer | None = None
    validity_minimum: Voltage | None = None
    ground: Ground | None = None
    model: Text | None = None
    order: Literal["jointly", "bias_first"] = "jointly"

    @field_validator("counts", mode="before")
    @classmethod
    def _pair(cls, given: object) -> object:
        return tuple(given) if isinstance(given, list) else given

    @model_validator(mode="after")
    def _complete(self) -> Chain:
        if self.kind == "adc" and (self.lsb is None or self.counts is None):
            raise ValueError('kind = "adc" needs lsb and counts')
        if self.kind == "pulse_rate" and self.gate is None:
            raise ValueError('kind = "pulse_rate" needs gate')
        if self.ground is not None and self.model is not None:
            raise ValueError("ground and model: give one of them, both are a model of the head")
        if self.counts is not None and self.counts[0] >= self.counts[1]:
            raise ValueError(f"counts = {list(self.counts)}: the first must be the smaller")
        return self


class Sensor(Strict):
    """[sensors.NAME]: a triad, or part of one."""

    kind: Literal["gyro", "accelerometer"]
    axes: list[Axis] = Field(min_length=1, max_length=3)
    unit: Unit
    range: list[str] | None = Field(default=None, min_length=2, max_length=2)
    mounting: list[list[float]] | None = None
    chain: Chain = Chain(kind="none")

    @model_validator(mode="after")
    def _fits(self) -> Sensor:
        if len(set(self.axes)) != len(self.axes):
            raise ValueError(f"axes = {self.axes}: an axis appears twice")
        if self.mounting is not None and not _is_rotation_or_mirror(self.mounting):
            raise ValueError("mounting: needs three rows of three numbers, orthonormal: sensor from body")
        wanted = "angular_rate" if self.kind == "gyro" else "acceleration"
        if kind(self.unit) != wanted:
            raise ValueError(f"unit = {self.unit!r} is no unit of {wanted.replace('_', ' ')}")
        return self


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
    half_widths: dict[Text, Text] = {}

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
    orientations: list[Text] | None = Field(default=None, min_length=1)
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
        return self


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
    source: Text = ""
    against: Name | None = None
    after: list[Name] = Field(default=[], max_length=1)
    plan: dict[str, Any] = {}

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


class Model(Strict):
    """[model]: which tests each kind of term comes from; without it, all tests with use = "fit"."""

    terms: dict[Literal["scale_factor", "misalignment", "bias", "asymmetry", "g_sensitivity"], list[Name]] = {}


class Requirement(Strict):
    """[[requirements]]: what is asked of which quantity, under which conditions."""

    id: Name
    text: Text = ""
    quantity: Name
    axis: Annotated[str, Field(pattern="^[xyz]{1,2}$")] | None = None
    of: Literal["expected", "dwell_mean", "reading"] = "dwell_mean"
    limit: str | None = None
    lower: str | None = None
    upper: str | None = None
    where: Text = ""
    zero_reference: bool | None = None
    condition: Text | None = None
    tests: list[Name] | None = Field(default=None, min_length=1)

    @model_validator(mode="after")
    def _limits(self) -> Requirement:
        if self.limit is not None and (self.lower is not None or self.upper is not None):
            raise ValueError("limit stands for both sides: give limit, or lower and upper")
        if self.limit is None and self.lower is None and self.upper is None:
            raise ValueError("needs limit, lower or upper")
        return self


def _is_rotation_or_mirror(rows: list[list[float]]) -> bool:
    if len(rows) != 3 or any(len(row) != 3 for row in rows):
        return False
    products = [sum(a * b for a, b in zip(one, other, strict=True)) for one in rows for other in rows]
    return all(abs(product - (i % 4 == 0)) < 1e-6 for i, product in enumerate(products))


class CampaignFile(Strict):
    """The whole campaign.toml."""

    schema_version: Literal[1] = Field(alias="schema")
    campaign: CampaignHead
    item: Item = Item()
    site: Site = Site()
    standards: dict[str, dict[str, StandardEntry]] = {}
    sensors: dict[Name, Sensor] = Field(min_length=1)
    recordings: dict[Name, RecordingEntry] = Field(min_length=1)
    tests: list[Test] = Field(min_length=1)
    model: Model = Model()
    requirements: list[Requirement] = []
