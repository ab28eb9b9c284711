"""What a test of positions is told: gravity, what is known of the sensor, and the standards behind it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...core.influence import Influence, Standards

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
    """How the test was made and how it is to be reduced.

    Parameters
    ----------
    gravity : float, optional
        Local gravity [m/s^2]; absent: normal gravity of latitude and height, else the standard value, with a remark.
    latitude : float, optional
        Geodetic [rad]; from the campaign's site.
    height : float
        Above the ellipsoid [m].
    g_sensitivity : bool, optional
        Estimate what the gyros read of specific force; absent: where the positions carry it.
    shortest : float, optional
        Shortest static interval [s]; absent: from the noise (module ``placements`` of the signals).
    outlier_risk : float
        Probability that any position, or any rotation, of a set without outliers is called one.
    acc_scale_factor, gyro_scale_factor : mapping of str to float, optional
        Ideal scale factor of each sensor, by axis [unit of the readings/(m/s^2)], [unit of the readings/(rad/s)];
        absent: 1 for readings in SI, else the estimated ones, rounded, which then are a definition.
    acc_zero, gyro_zero : mapping of str to float, optional
        Reading that stands for no input [unit of the readings]: 32768 of a 16-bit converter; absent: 0.
    standards : mapping of Influence
        Uncertainties of the standards; from the campaign.
    """

    gravity: float | None = field(default=None, metadata={"unit": "m/s^2"})
    latitude: float | None = field(default=None, metadata={"from": "site"})
    height: float = field(default=0.0, metadata={"unit": "m"})
    g_sensitivity: bool | None = None
    shortest: float | None = field(default=None, metadata={"unit": "s"})
    outlier_risk: float = field(default=0.01, metadata={"above": 0.0})
    acc_scale_factor: Mapping[str, float] | None = field(default=None, metadata={"from": "sensor"})
    gyro_scale_factor: Mapping[str, float] | None = field(default=None, metadata={"from": "sensor"})
    acc_zero: Mapping[str, float] | None = None
    gyro_zero: Mapping[str, float] | None = None
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})
