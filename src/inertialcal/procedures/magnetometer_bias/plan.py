"""Settings of a test of a gyro against a magnetometer in orbit."""

from __future__ import annotations

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
        "Date of the first sample, UTC, where the file has none: the field of the earth changes.", None,
        example="2026-03-01",
    )  # fmt: skip
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])
