"""Settings of a test of positions: gravity, what is known of the sensor, and the standards behind it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.key import Kind
from ...core.settings import fact, setting

HIGHEST_ORDER = 3  # in temperature
# Influences that a test of positions is subject to, and what each would change.
INFLUENCES = {
    "gravity.value": "scale factors of the accelerometers in proportion, and g-sensitivity",
    "fixture.orientation": "cross-axis entries: each face and each axis turned about is slightly off, always alike",
    "fixture.repeatability": "cross-axis entries: each laying is slightly off that of its face",
    "fixture.mounting": "misalignments: all positions and turns share one tilt against the nominal axes",
    "turn.angle": "scale factors of the gyros: each turn is slightly off its nominal angle",
    "thermometer.temperature": "terms over temperature: all temperatures are off alike",
    "clock.rate": "scale factors of the gyros in proportion: time is part of an angle",
}


@dataclass(frozen=True)
class FileSettings:
    """Settings of the files of the noun ``positions``."""

    sections: Mapping[str, str] = setting(
        "Labelled parts of a recording: a JSON file or table of label, start and end; or the column of labels; of one "
        "of several recordings, FILE=PARTS. By default, the rests are found.", dict[str, str], example="parts.json",
    )  # fmt: skip
    orientations: str | None = setting(
        "Which axis points up in each position of a recording; faces for the nearest face; or a file. By default, "
        "unknown: gravity alone calibrates.", None, example="x+,x-,y+,y-,z+,z-",
    )  # fmt: skip
    turn: str | None = setting("Angle of each labelled turn; 360 deg by default.", None, example="-360 deg")


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced."""

    gravity: float | None = fact("Local gravity [m/s^2]; None: that of the place.", "site", None)
    latitude: float | None = fact("Geodetic latitude [rad].", "site", None)
    height: float = fact("Height above the ellipsoid [m].", "site", 0.0)
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
        "Ideal scale factor of each accelerometer, by axis [count or V/(m/s^2)]; None: 1 for readings in SI, else "
        "errors of the model refer to the estimated ones, rounded, and the result has none.", "sensor", None,
    )  # fmt: skip
    gyro_scale_factor: Mapping[str, float] | None = fact(
        "Ideal scale factor of each gyro, by axis [count or V/(rad/s)]; None: as of accelerometers.",
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
    prior_misalignment: float | None = setting(
        "Prior standard uncertainty of each misalignment of the accelerometers about 0, where no orientation is known; "
        "none by default.", None, unit="rad", example="0.02 rad", above=0.0, most=1.0,
    )  # fmt: skip
    prior_scale_factor: float | None = setting(
        "Prior standard uncertainty of each scale factor of the accelerometers about the ideal one; none by default.",
        None, unit="1", example="3 %", above=0.0, most=1.0,
    )  # fmt: skip
    prior_bias: float | None = setting(
        "Prior standard uncertainty of each bias of the accelerometers about 0; none by default.", None,
        unit="m/s^2", example="0.5 m/s^2", above=0.0, most=1e3,
    )  # fmt: skip
    temperature_order: int = setting(
        "Order in temperature of matrix and bias of the accelerometers; each recording is one temperature, with all "
        "positions. 0: the temperature is left aside.", 0, least=0, most=HIGHEST_ORDER, example="1",
    )  # fmt: skip
    reference_temperature: float = setting(
        "Powers are those of the temperature less this.", 20.0, unit="degC", example="20 degC"
    )
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])

    def states_scale(self, kind: Kind) -> bool:
        """Whether a nominal scale factor of such sensors was stated."""
        return (self.acc_scale_factor if kind == "accelerometer" else self.gyro_scale_factor) is not None

    @property
    def priors(self) -> Mapping[str, float]:
        """Stated prior standard uncertainties, by quantity [rad, 1, m/s^2]."""
        given = {
            "misalignment": self.prior_misalignment,
            "scale_factor_error": self.prior_scale_factor,
            "bias": self.prior_bias,
        }
        return {name: u for name, u in given.items() if u is not None}


LARGEST = 1000  # positions that anybody lays


@dataclass(frozen=True)
class Wanted:
    """What is known before a test of positions, and what it has to give."""

    scatter: float = setting(
        "Scatter of the mean reading of one position.", unit="m/s^2", example="0.1 mg", least=1e-12, most=10.0
    )
    target: Mapping[str, str] = setting(
        "Standard uncertainty wanted of a parameter or quantity: positions are added until it is met.",
        dict[str, str], example='scale_factor_error="100 ppm"',
    )  # fmt: skip
    have: Literal["none", "faces", "faces+edges", "cube"] = setting("Positions already taken.", "none")
    known: bool = setting("The direction of each position is known.", False)
    pose: float = setting(
        "Standard uncertainty of a known direction.", 0.0, unit="rad", example="0.5 deg", least=0.0, most=3.2
    )
    gravity: float = setting("Local gravity.", 9.80665, unit="m/s^2", example="9.81 m/s2", least=9.7, most=9.9)
    gravity_u: float = setting("Its standard uncertainty.", 0.0, unit="m/s^2", example="1 mGal", least=0.0, most=1.0)
    following: int = setting(
        "Instead of a target: how many positions to add, the best one each time.", 0, least=0, option="next"
    )
    goal: str = setting("What added positions are best for: determinant, trace, or a parameter.", "determinant")
    most: int = setting("Positions in all, at most.", 200, least=1, most=LARGEST)
    schedule: str | None = setting("Write the programme as CSV into this file.", None, example="schedule.csv")
