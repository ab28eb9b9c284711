"""What a test of positions is told: gravity, what is known of the sensor, and the standards behind it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

# Influences that a test of positions is subject to, and what each would change.
INFLUENCES = {
    "gravity.value": "scale factors of the accelerometers in proportion, and g-sensitivity",
    "fixture.orientation": "cross-axis entries: each position is not quite the one that is named",
    "fixture.mounting": "misalignments: all positions and turns alike are turned against the axes that are named",
    "turn.angle": "scale factors of the gyros: each turn is not quite by the angle that is named",
    "clock.rate": "scale factors of the gyros in proportion: time is part of an angle",
}


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced."""

    gravity: float | None = setting(
        "Local gravity; where not given, normal gravity of latitude and height, else the standard value.",
        None, unit="m/s^2", example="9.81 m/s2",
    )  # fmt: skip
    latitude: float | None = fact("Geodetic latitude [rad].", "site", None)
    height: float = setting("Height above the ellipsoid.", 0.0, unit="m", example="300 m")
    g_sensitivity: bool | None = setting(
        "Estimate what the gyros read of specific force; where not given, where the positions carry it.", None
    )
    shortest: float | None = setting(
        "Shortest static interval; from the noise where not given.", None, unit="s", example="2 s"
    )
    outlier_risk: float = setting(
        "Probability that any position, or any rotation, of a set without outliers is called one.",
        0.01, above=0.0, example="0.01",
    )  # fmt: skip
    acc_scale_factor: Mapping[str, float] | None = fact(
        "Ideal scale factor of each accelerometer, by axis [unit of the readings/(m/s^2)]; None: 1 for readings in SI, "
        "else the estimated ones, rounded, which then are a definition.", "sensor", None,
    )  # fmt: skip
    gyro_scale_factor: Mapping[str, float] | None = fact(
        "Ideal scale factor of each gyro, by axis [unit of the readings/(rad/s)]; None: as of accelerometers.",
        "sensor", None,
    )  # fmt: skip
    acc_zero: Mapping[str, float] | None = setting(
        "Reading of each accelerometer that stands for no input, by axis, in the unit of the readings; 0 where not "
        "given.", None, example="{ x = 32768 }",
    )  # fmt: skip
    gyro_zero: Mapping[str, float] | None = setting(
        "Reading of each gyro that stands for no input, by axis, in the unit of the readings; 0 where not given.",
        None, example="{ x = 32768 }",
    )  # fmt: skip
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])
