"""What a rate-table test is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

# Influences that a rate table test is subject to, and what each would change.
INFLUENCES = {
    "rate_table.rate": "scale factors and all matrix entries in proportion",
    "rate_table.mounting": "cross-axis entries: the turned axis deviates from the nominal one",
    "converter.reference": "scale factors in volts in proportion",
}


@dataclass(frozen=True)
class Attitude:
    """How the axis of the table stands on the ground."""

    tilt: float = setting(
        "Angle of the table axis from the vertical, positive towards azimuth.", unit="rad", example="0.1 deg"
    )
    u: float = setting("Standard uncertainty of the tilt.", 0.0, unit="rad", example="0.02 deg")
    azimuth: float | None = setting(
        "Direction of the tilt, from north towards east; unknown where not given.", None, unit="rad", example="30 deg"
    )
    u_azimuth: float = setting("Standard uncertainty of the azimuth.", 0.0, unit="rad", example="1 deg")


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced."""

    axis: str = setting("Axis that is turned, where the readings do not say it dwell by dwell.", "", example="x")
    zero_reference: bool = setting(
        "The reading at rest was subtracted from every reading: its bias is then that of the subtraction.", False
    )
    asymmetry: bool = setting("Fit one scale factor for each sense of rotation.", True)
    nonlinearity: Literal["auto", "always", "none"] = setting(
        "Second- and third-order terms in the line and the model: those that are seen, all that the rates allow, none.",
        "auto",
    )
    run_level: Literal["power_up", "recording"] = setting(
        "What the runs are: separate power-ups, or merely separate recordings.", "power_up"
    )
    scatter_ratio: float = setting(
        "A dwell whose scatter is this many times more, or less, than that of its neighbours is left out.",
        3.0, above=1.0, example="3",
    )  # fmt: skip
    neighbours: int = setting("How many dwells, nearest in rate, a scatter is compared with.", 8, above=1, example="8")
    rail_scatters: float = setting(
        "A dwell whose rate or reading is this many scatters or less from the end of the range is left out.",
        3.0, above=0.0, example="3",
    )  # fmt: skip
    agreement: float = setting(
        "Largest relative difference of a reading from the rate of the table that is a calibration matter, no mistake.",
        0.1, above=0.0, example="0.1",
    )  # fmt: skip
    missing: float = setting(
        "A dwell of a recording with a larger part of its samples missing, invalid or at the rail is left out.",
        0.1, above=0.0, example="0.1",
    )  # fmt: skip
    applied_tolerance: float = setting(
        "Wander of the applied channel that is no step, and no motion at rest; for an encoder.",
        0.0, unit="rad/s", example="0.01 deg/s",
    )  # fmt: skip
    attitude: Attitude | None = setting(
        "How the table stands; without it the earth rate along the axes is unknown.", None,
        example='{ tilt = "0.1 deg" }',
    )  # fmt: skip
    latitude: float | None = fact("Geodetic latitude [rad].", "site", None)
    input_range: tuple[float, float] | None = fact("Ends of the range [rad/s].", "sensor", None)
    scale_factor: Mapping[str, float] | None = fact("Ideal scale factor of each sensor [V/(rad/s)].", "sensor", None)
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])


@dataclass(frozen=True)
class Columns:
    """Which column of a file is what, where its name does not say it."""

    applied: str | None = setting("Column with the rate of the table.", None, example="rate_dps")
    schedule: str | None = setting(
        "Table of the dwells of a recording without that column: a row each, start, stop and rate [UNIT].", None,
        example="dwells.csv",
    )  # fmt: skip
    reading: Mapping[str, str] = setting("Column with the reading, or AXIS=COLUMN.", dict[str, str], example="x=x_dps")
    scatter: str | None = setting("Column with the scatter within the dwell.", None, example="std_dps")
    run: str | None = setting("Column with the power-up run.", None, example="run_id")
    group: str | None = setting("Column with the sample set.", None, example="set")


@dataclass(frozen=True)
class PlannedRates:
    """What is known of gyro and rate table before a test, and what it has to give."""

    noise: float = setting(
        "White noise of the rate (angle random walk).", unit="rad/s/sqrt(Hz)", example="0.2 deg/sqrt(h)", above=0.0
    )
    fastest: float = setting(
        "Fastest rate: of the range of the sensor or the table, the smaller.", unit="rad/s", example="100 deg/s",
        above=0.0,
    )  # fmt: skip
    wanted: Mapping[str, str] = setting(
        "Standard uncertainty wanted of bias, scale_factor_error, scale_factor_asymmetry or misalignment.",
        dict[str, str], example='scale_factor_error="200 ppm"',
    )  # fmt: skip
    available: float | None = setting("Time that there is, in all.", None, unit="s", example="8 h", above=0.0)
    instability: float = setting("Bias instability.", 0.0, unit="rad/s", example="5 deg/h", least=0.0)
    walk: float = setting("Random walk of the bias.", 0.0, unit="rad/s/sqrt(s)", example="5 deg/h/sqrt(h)", least=0.0)
    dwell_scatter: float = setting(
        "Scatter of a dwell that no length of it makes less.", 0.0, unit="rad/s", example="0.001 deg/s", least=0.0
    )
    turn_on: float = setting("Scatter of the bias from power-up to power-up.", 0.0, unit="rad/s",
                             example="0.005 deg/s", least=0.0)  # fmt: skip
    turn_on_scale: float = setting(
        "Scatter of the scale factor from power-up to power-up.", 0.0, unit="1", example="200 ppm", least=0.0
    )
    sizes: int = setting(
        "Sizes of rate, each in both senses, evenly up to the fastest; a curvature takes three.", 4, least=2, most=20,
        example="4",
    )  # fmt: skip
    acceleration: float = setting(
        "Of the table, from rate to rate.", 0.17453292519943295, unit="rad/s^2", example="10 deg/s^2", above=0.0
    )
    settle: float = setting("From the new rate to the first reading.", 5.0, unit="s", example="5 s", least=0.0)
    power_up: float = setting(
        "From power off to the first reading of the next run: off, on, warm-up.", 1200.0, unit="s", example="20 min",
        least=0.0,
    )  # fmt: skip
    mount: float = setting("To mount the unit about another axis.", 900.0, unit="s", example="15 min", least=0.0)
    least_runs: int = setting("Runs (power-ups) at least.", 5, least=2, most=100, example="5")
    most_runs: int = setting("Runs (power-ups) at most.", 20, least=2, most=100, example="20")
    longest_dwell: float = setting("Longest dwell.", 600.0, unit="s", example="10 min", above=1.0)
    u_rate: float = setting("Relative standard uncertainty of the rate of the table.", 0.0, unit="1", example="0.01 %",
                            least=0.0)  # fmt: skip
    u_mounting: float = setting(
        "Standard uncertainty of the axis that is turned about.", 0.0, unit="rad", example="0.05 deg", least=0.0
    )
    u_converter: float = setting(
        "Relative standard uncertainty of the reference of the converter.", 0.0, unit="1", example="0.01 %", least=0.0
    )
    latitude: float | None = setting(
        "Geodetic latitude, for the rate of the earth; unknown where not given.", None, unit="rad", example="36.6 deg",
        least=-1.5707963267948966, most=1.5707963267948966,
    )  # fmt: skip
    u_tilt: float = setting(
        "Standard uncertainty of the axis of the table against the vertical.", 0.00175, unit="rad", example="0.1 deg",
        least=0.0,
    )  # fmt: skip
    simulate: int = setting(
        "Simulated tests by which the forecast is checked; 0 for none.", 20, least=0, most=2000, example="40"
    )
    schedule: str | None = setting("Write the programme as CSV into this file.", None, example="schedule.csv")
