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


@dataclass(frozen=True)
class PlannedRamps:
    """What is known of sensor and chamber before a thermal test, and what it has to give."""

    noise: str = setting(
        "White noise of the sensor, which also says whether it is a gyro or an accelerometer.",
        example="0.2 deg/sqrt(h)",
    )  # fmt: skip
    coldest: float = setting("Lowest temperature of the range.", unit="degC", example="-30 degC")
    hottest: float = setting("Highest temperature of the range.", unit="degC", example="65 degC")
    wanted: Mapping[str, str] = setting(
        "Standard uncertainty wanted anywhere in the range: of the bias, or of its change from the reference"
        " temperature, bias_over_temperature.",
        dict[str, str], example='bias_over_temperature="0.001 deg/s"',
    )  # fmt: skip
    available: float | None = setting("Time that there is, in all.", None, unit="s", example="72 h", above=0.0)
    instability: str | None = setting("Bias instability.", None, example="5 deg/h")
    walk: str | None = setting("Random walk of the bias.", None, example="5 deg/h/sqrt(h)")
    turn_on: str | None = setting("Scatter of the bias from power-up to power-up.", None, example="0.005 deg/s")
    turn_on_slope: str | None = setting(
        "Scatter of the temperature coefficient from power-up to power-up.", None, example="1e-5 deg/s/degC"
    )
    coefficient: str | None = setting(
        "Size of the temperature coefficient to expect, on which the thermometer acts.", None, example="3e-3 deg/s/degC"
    )
    order: int = setting("Order of the polynomial.", 3, least=1, most=LARGEST_ORDER, example="3")
    reference_temperature: float = setting("From which changes count.", 20.0, unit="degC", example="20 degC")
    room: float = setting("Temperature at which a run starts and ends.", 23.0, unit="degC", example="23 degC")
    ramp: float = setting("Fastest ramp of the chamber.", 1.5 / 60.0, difference="degC/s", example="1.5 K/min",
                          above=0.0)  # fmt: skip
    slowest: float = setting("Slowest ramp that is looked at.", 0.2 / 60.0, difference="degC/s", example="0.2 K/min",
                             above=0.0)  # fmt: skip
    soak: float = setting("At each end, until the unit is as warm as the chamber.", 900.0, unit="s", example="15 min",
                          least=0.0)  # fmt: skip
    warm_up: float = setting("At the first temperature after power-up; it is left out.", 900.0, unit="s",
                             example="15 min", least=0.0)  # fmt: skip
    power_up: float = setting("Off, from run to run.", 1800.0, unit="s", example="30 min", least=0.0)
    interval: float = setting(
        "From sample to sample, each the mean over it.", 10.0, unit="s", example="10 s", above=0.0
    )
    least_runs: int = setting("Runs (power-ups) at least.", 5, least=2, most=100, example="5")
    most_runs: int = setting("Runs (power-ups) at most.", 20, least=2, most=100, example="20")
    u_thermometer: float = setting(
        "Standard uncertainty of the thermometer.", 0.0, difference="degC", example="0.2 K", least=0.0
    )
    latitude: float | None = setting(
        "Geodetic latitude, for the rate of the earth along a level unit; unknown where not given.", None, unit="rad",
        example="36.6 deg", least=-1.5707963267948966, most=1.5707963267948966,
    )  # fmt: skip
    u_tilt: float = setting("Standard uncertainty of the unit's tilt.", 0.00175, unit="rad", example="0.1 deg",
                            least=0.0)  # fmt: skip
    simulate: int = setting(
        "Simulated tests by which the forecast is checked; 0 for none.", 20, least=0, most=2000, example="40"
    )
    schedule: str | None = setting("Write the programme as CSV into this file.", None, example="schedule.csv")
