"""What a thermal test is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

LARGEST_ORDER = 9  # of a polynomial that anybody can mean

# Influences that a thermal test is subject to, and what each would change.
INFLUENCES = {
    "thermometer.temperature": "bias by its own slope over temperature, all temperatures alike",
    "converter.reference": "bias in proportion",
    "sensor.hysteresis": "bias from one path only: half the difference between the paths",
}


@dataclass(frozen=True)
class Attitude:
    """How the body lies while its temperature changes: the axes of the body are those of ``physics.earth``'s table."""

    tilt: float = setting(
        "Angle of the body's z axis from the vertical, positive towards azimuth.", unit="rad", example="0.1 deg"
    )
    u: float = setting("Standard uncertainty of the tilt.", 0.0, unit="rad", example="0.02 deg")
    azimuth: float | None = setting(
        "Direction of the tilt, and of the body's x axis seen from above, from north towards east; unknown where not "
        "given.", None, unit="rad", example="30 deg",
    )  # fmt: skip
    u_azimuth: float = setting("Standard uncertainty of the azimuth.", 0.0, unit="rad", example="1 deg")


@dataclass(frozen=True)
class Thermometer:
    """Temperature channel of one sensor: ``v = voltage + slope (T - temperature)`` [V], [V/degC], [degC]."""

    slope: float
    voltage: float
    temperature: float


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced."""

    order: int | None = setting(
        "Of the polynomial; where not given, chosen on what is held out.",
        None,
        least=0,
        most=LARGEST_ORDER,
        example="3",
    )
    largest_order: int = setting("Largest order that comes into question.", 5, above=0, most=LARGEST_ORDER, example="5")
    reference_temperature: float = setting(
        "Powers are those of the temperature less this.", 20.0, unit="degC", example="20 degC"
    )
    at: list[float] | None = setting(
        "Further temperatures at which to report the bias.", None, unit="degC", example="-20 degC"
    )
    turn_over: float | None = setting(
        "After each turn of the temperature, and at the start, samples within this distance of it are left out; a "
        "tenth of the range where not given.", None, difference="degC", example="2 K",
    )  # fmt: skip
    bins: int = setting(
        "How many bins of temperature there are, each with the same weight.", 40, above=3, most=10_000, example="40"
    )
    least_range: float = setting(
        "A smaller range of temperature carries no polynomial.", 10.0, difference="degC", example="10 K"
    )
    warm_up: float | None = setting(
        "Time left out after each power-up; default: until the start-up transient is below `settled`.",
        None, unit="s", example="600 s",
    )  # fmt: skip
    settled: float | None = setting(
        "What may be left of the start-up; a tenth of the scatter of a sample where not given.",
        None, unit="reading", example="0.001 deg/s",
    )  # fmt: skip
    no_hysteresis: float | None = setting(
        "Gap between warming and cooling that counts as none; none is ever shown where not given.",
        None, unit="reading", example="0.001 deg/s",
    )  # fmt: skip
    run_level: Literal["power_up", "recording"] = setting(
        "What the runs are: separate power-ups, or merely separate recordings.", "power_up"
    )
    attitude: Attitude | None = setting(
        "How the body lies; without it the earth rate along its axes is unknown.", None,
        example='{ tilt = "0.1 deg" }',
    )  # fmt: skip
    latitude: float | None = fact("Geodetic latitude [rad].", "site", None)
    thermometers: Mapping[str, Thermometer] | None = fact(
        "Temperature channel of each sensor, by axis.", "sensor", None
    )
    unit: str = fact("Unit that the sensor is spoken of in, for texts; empty: that of the readings.", "sensor", "")
    scale_factor: Mapping[str, float] | None = fact("Ideal scale factor of each sensor [V/(rad/s)].", "sensor", None)
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])
