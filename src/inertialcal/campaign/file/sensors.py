"""[sensors] of campaign.toml: triads, the chain from counts to their unit, models made on the ground."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from ...core.schema.quantities import Axis, Duration, Frequency, PerAxis, Strict, Text, UnitOrNone, Voltage
from ...core.units import kind

RAW = ("count", "voltage")


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
    misalignment: dict[Pair, Polynomial] = Field(default={})
    reference_temperature: PerAxis = "0 degC"
    temperature_range: list[str] | None = Field(default=None, min_length=2, max_length=2)
    source: Text = ""


OF_OUTPUT = ("reference", "zero", "thermometer", "validity_minimum", "lsb", "counts", "gate")  # not of kind "none"


class Chain(Strict):
    """chain = {...}: from counts or volts to the unit of the sensor."""

    kind: Literal["none", "adc", "output", "pulse_rate"]
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
        if self.kind == "adc" and self.lsb is None:
            raise ValueError('kind = "adc" needs lsb')
        if self.kind == "output" and self.scale_factor is None:
            raise ValueError('kind = "output" needs scale_factor')
        bare = self.kind == "none" and self.ground is None and self.model is None
        idle = [name for name in OF_OUTPUT if getattr(self, name) is not None] if bare else []
        idle += [
            name for name in ("lsb", "counts", "gate") if self.kind == "output" and getattr(self, name) is not None
        ]
        if idle or (bare and self.gain != 1.0):
            have = ", ".join(idle) or "gain"
            ways = '"adc" for readings in counts' + ('; "output" for volts' if self.kind == "none" else "")
            raise ValueError(f'kind = "{self.kind}" does not use {have}: set kind = {ways}')
        if self.kind == "pulse_rate" and self.gate is None:
            raise ValueError('kind = "pulse_rate" needs gate')
        if self.ground is not None and self.model is not None:
            raise ValueError("ground and model: give one of them, both are a model of the head")
        if self.counts is not None and self.counts[0] >= self.counts[1]:
            raise ValueError(f"counts = {list(self.counts)}: the first must be the smaller")
        return self


class Sensor(Strict):
    """[sensors.NAME]: a triad, or part of one."""

    kind: Literal["gyro", "accelerometer", "other"]
    axes: list[Axis] = Field(min_length=1, max_length=3)
    unit: UnitOrNone = ""
    range: list[str] | None = Field(default=None, min_length=2, max_length=2)
    cut_off: Frequency | None = None
    mounting: list[list[float]] | None = None
    chain: Chain = Chain(kind="none")

    @model_validator(mode="after")
    def _fits(self) -> Sensor:
        if len(set(self.axes)) != len(self.axes):
            raise ValueError(f"axes = {self.axes}: an axis appears twice")
        if self.mounting is not None and not _is_rotation_or_mirror(self.mounting):
            raise ValueError("mounting: needs three rows of three numbers, orthonormal: sensor from body")
        if self.cut_off is not None and self.cut_off <= 0.0:
            raise ValueError("cut_off: needs a frequency above 0 Hz")
        if self.kind == "other" and self.chain.kind != "none":
            raise ValueError('kind = "other": readings stay in the unit of the file, without a chain')
        wanted = {"gyro": "angular_rate", "accelerometer": "acceleration"}.get(self.kind)
        if wanted and not self.unit:
            raise ValueError(f"unit is missing: {wanted.replace('_', ' ')}")
        raw = kind(self.unit) in RAW and self.chain.kind == "none"  # output of a sensor whose scale is to be found
        if wanted and kind(self.unit) != wanted and not raw:
            raise ValueError(f"unit = {self.unit!r} is no unit of {wanted.replace('_', ' ')}")
        return self


def _is_rotation_or_mirror(rows: list[list[float]]) -> bool:
    if len(rows) != 3 or any(len(row) != 3 for row in rows):
        return False
    products = [sum(a * b for a, b in zip(one, other, strict=True)) for one in rows for other in rows]
    return all(abs(product - (i % 4 == 0)) < 1e-6 for i, product in enumerate(products))
