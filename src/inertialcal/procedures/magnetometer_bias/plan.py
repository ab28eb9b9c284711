"""Settings of a test of a gyro against a magnetometer in orbit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

# Influences that the test is subject to, and what each would change.
INFLUENCES = {
    "sensor.scale_factor": "bias: what the gyro reads too much of the turn of the body passes for bias",
    "sensor.misalignment": "bias: so does what it reads of turns about the other axes",
    "magnetometer.mounting": "bias: so does an angle between the two triads",
    "earth_field.uniform": "biases of gyro and magnetometer: an error of the field that is the same all along",
}


@dataclass(frozen=True)
class Orbit:
    """What a caller says of a file."""

    magnetometer: str | None = setting(
        "Columns of the magnetometer, x, y, z; those that are named so if not given.", None, example="bx,by,bz"
    )
    tle: str | None = setting(
        "File of two-line elements of the orbit, in place of columns of the position.", None, example="npsat1.tle"
    )
    satellite: str | None = setting(
        "Name or catalogue number of the satellite, where that file has several.", None, example="44332"
    )


@dataclass(frozen=True)
class Plan:
    """How a record is cut, and what is estimated beside the bias."""

    arc: float = setting(
        "Length of the arcs that the record is cut into: each has its own attitude.", 300.0, unit="s", example="300 s",
        least=20.0,
    )  # fmt: skip
    magnetometer_model: Literal["bias", "scale_factor"] = setting(
        "What is estimated of the magnetometer with the bias of the gyro: its bias, or its scale factors as well.",
        "bias",
    )
    epoch: str | None = setting(
        "Date of the first sample, UTC, where the file has none: the field of the earth changes. With its time of day"
        " where the orbit is from two-line elements.", None, example="2026-03-01",
    )  # fmt: skip
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])


@dataclass(frozen=True)
class PlannedOrbits:
    """What is known of sensors and orbit before a record is made, and what it has to give."""

    noise: str = setting("White noise of the gyro.", example="0.2 deg/sqrt(h)")
    wanted: Mapping[str, str] = setting(
        "Standard uncertainty wanted of the bias, or of magnetometer_bias, of each axis.", dict[str, str],
        example='bias="0.001 deg/s"',
    )  # fmt: skip
    available: float | None = setting("Time that there is.", None, unit="s", example="6 h", above=0.0)
    field_noise: float = setting(
        "Noise of one reading of one axis of the magnetometer.", 50e-9, difference="T", example="50 nT", above=0.0
    )
    field_error: float = setting(
        "By how much the field differs from its model, another from arc to arc: crust, currents.", 20e-9,
        difference="T", example="20 nT", least=0.0,
    )  # fmt: skip
    instability: str | None = setting("Bias instability of the gyro.", None, example="5 deg/h")
    walk: str | None = setting("Random walk of the bias of the gyro.", None, example="5 deg/h/sqrt(h)")
    altitude: float = setting("Of the circular orbit.", 560e3, unit="m", example="560 km", least=150e3, most=4e7)
    inclination: float = setting("Of the orbit.", 0.4, unit="rad", example="24 deg", least=0.0, most=3.15)
    date: str = setting("Of the record: the field of the earth changes.", "2026-03-01", example="2026-03-01")
    motion: Literal["tumbling", "nadir"] = setting(
        "How the body turns: tumbling slowly about all axes, or once an orbit, pointing down.", "tumbling"
    )
    turn_rate: float = setting("Spin of a tumbling body.", 0.005, unit="rad/s", example="0.3 deg/s", above=0.0)
    interval: float | None = setting(
        "From sample to sample, of both sensors; the longest that is enough if not given.", None, unit="s",
        example="1 s", above=0.0,
    )  # fmt: skip
    arc: float = setting("Length of the arcs, as the test has it.", 300.0, unit="s", example="300 s", least=20.0)
    magnetometer_model: Literal["bias", "scale_factor"] = setting(
        "What is estimated of the magnetometer, as the test has it.", "bias"
    )
    most_orbits: int = setting("Orbits at most.", 5, least=1, most=100, example="5")
    u_scale: float = setting("Relative standard uncertainty of the gyro's scale factors.", 0.0, unit="1",
                             example="0.2 %", least=0.0)  # fmt: skip
    u_misalignment: float = setting("Standard uncertainty of its misalignment.", 0.0, unit="rad", example="1 mrad",
                                    least=0.0)  # fmt: skip
    u_mounting: float = setting("Standard uncertainty of the angle between the triads.", 0.0, unit="rad",
                                example="2 mrad", least=0.0)  # fmt: skip
    u_field: float = setting("Standard uncertainty of the field that is the same all along.", 0.0, difference="T",
                             example="20 nT", least=0.0)  # fmt: skip
    simulate: int = setting(
        "Simulated tests by which the forecast is checked; 0 for none.", 20, least=0, most=2000, example="40"
    )
    schedule: str | None = setting("Write the programme as CSV into this file.", None, example="schedule.csv")
