"""Settings of an alignment at rest: the site, how far was turned, what is known of the sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

# Influences that an alignment is subject to, and what each would change.
INFLUENCES = {
    "sensor.misalignment": "roll, pitch, heading: axes of both triads are slightly off their nominal directions",
    "sensor.scale_factor": "roll and pitch of a tilted unit; heading by the angle of a turn that the gyro measured",
    "turn.angle": "heading: each position is slightly off its stated angle",
    "fixture.mounting": "roll, pitch, heading: the case is slightly turned against the triads",
    "site.latitude": "bias about the vertical",
    "gravity.value": "how far the specific force differs from gravity",
}


@dataclass(frozen=True)
class Plan:
    """How positions follow each other, and what is known before."""

    latitude: float | None = fact("Geodetic latitude [rad].", "site", None)
    gravity: float | None = fact("Local gravity [m/s^2]; None: that of the place.", "site", None)
    height: float = fact("Height above the ellipsoid [m].", "site", 0.0)
    turns: str | None = setting(
        "By how much the heading grew from each position to the next, clockwise seen from above: one angle for all, or "
        "a list; where not given, as the gyro measured it in one recording.", None, example="180 deg",
    )  # fmt: skip
    body: Literal["auto", "z_down", "z_up"] = setting(
        "Which way z of the unit points when it lies level, with x forward: down (y to the right) or up (y to the "
        "left); auto: as it lies.", "auto",
    )  # fmt: skip
    gyro_bias_u: float | None = setting(
        "Standard uncertainty of the bias of each gyro about what was taken off, or 0: for one position. Where it is "
        "not given, what the readings themselves differ from the rate of the earth tells it.", None, unit="rad/s",
        example="0.01 deg/h", above=0.0,
    )  # fmt: skip
    accelerometer_bias_u: float | None = setting(
        "Standard uncertainty of the bias of each accelerometer about what was taken off, or 0.", None, unit="m/s^2",
        example="50 ug", above=0.0,
    )  # fmt: skip
    deflection_u: float | None = setting(
        "Standard uncertainty of the plumb line against the normal of the ellipsoid, north and east; where given, roll "
        "and pitch are those against the ellipsoid.", None, unit="rad", example="5 arcsec", above=0.0, most=0.01,
    )  # fmt: skip
    shortest: float = setting("Shortest rest that is a position.", 30.0, unit="s", example="60 s", least=5.0)
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])
