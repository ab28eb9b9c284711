"""Settings of a test of the acceleration environment in orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

SCALE = "sensor.scale_factor"
# Influences that the test is subject to, and what each would change.
INFLUENCES = {SCALE: "levels in proportion, all bands alike; and the slow acceleration"}
BAND, RATIO, VIBRATORY = "octave_band_rms", "octave_band_rms_ratio", "vibratory_rms"
SLOW, MAGNITUDE, PERPENDICULAR = (
    "quasi_steady_acceleration", "quasi_steady_magnitude", "quasi_steady_perpendicular",
)  # fmt: skip
INTERVAL_MEAN, ORBITAL, PERIOD = "interval_mean", "orbital_amplitude", "orbital_period"
RSS = "rss"  # what stands in place of an axis: root sum of squares over the axes
REQUIRED = 100.0  # over which the requirement of the station takes the root mean square [s]


@dataclass(frozen=True)
class Plan:
    """How records are cut, and what is taken off."""

    block: float = setting(
        "Length of the spectra, and of the means of the slow acceleration. A shorter one is taken, and said, where no"
        " stretch without a gap is that long.", REQUIRED, unit="s", example="100 s", least=0.1, most=1e5,
    )  # fmt: skip
    interval: float = setting(
        "Length of the intervals of which least, largest, mean and root mean square are shown.", 10.0, unit="s",
        example="10 s", above=0.0, most=1e5,
    )  # fmt: skip
    trim: float = setting(
        "Share of the samples of a block left out at each end before the mean of the slow acceleration.", 0.1,
        example="0.1", least=0.0, most=0.45,
    )  # fmt: skip
    bias_x: float | None = setting("Bias of x, as a flip found it: taken off.", None, unit="m/s^2", example="12.3 ug")
    bias_y: float | None = setting("The same of y.", None, unit="m/s^2", example="-4.1 ug")
    bias_z: float | None = setting("The same of z.", None, unit="m/s^2", example="0.7 ug")
    bias_u: float | None = setting(
        "Standard uncertainty of each of these biases.", None, unit="m/s^2", example="0.2 ug", least=0.0
    )
    roll: float | None = setting(
        "Roll of the axes of the readings in those of the station, as the header of the record has it: the slow"
        " acceleration is then told in axes of the station.", None, unit="rad", example="0 deg",
    )  # fmt: skip
    pitch: float | None = setting("Pitch, likewise.", None, unit="rad", example="30 deg")
    yaw: float | None = setting("Yaw, likewise.", None, unit="rad", example="-90 deg")
    orbit: float | None = setting(
        "Period of the orbit, for the part of the slow acceleration that follows it. Where not given, it is looked for"
        " in records of three orbits or more.", None, unit="s", example="92.6 min", above=0.0,
    )  # fmt: skip
    own_noise: float | None = setting(
        "Density of the sensor's own noise, as a test on the ground found it: what it gives in each band is shown.",
        None, unit="m/s^2/sqrt(Hz)", example="0.1 ug/sqrt(Hz)", above=0.0,
    )  # fmt: skip
    cut_off: float | None = setting(
        "Of the low pass that the readings went through, where neither record nor sensor says it.", None, unit="Hz",
        example="6 Hz", above=0.0,
    )  # fmt: skip
    magnitude: Literal["largest", "mean"] = setting(
        "Which size of the slow acceleration is told: that of its largest block, or of its mean over the record.",
        "largest",
    )
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])

    @property
    def bias(self) -> dict[str, float] | None:
        """Stated bias by axis [m/s^2]; None where none is stated."""
        given = {"x": self.bias_x, "y": self.bias_y, "z": self.bias_z}
        found = {axis: value for axis, value in given.items() if value is not None}
        return found or None

    @property
    def attitude(self) -> tuple[float, float, float] | None:
        """Roll, pitch and yaw [rad]; None where none is stated."""
        if self.roll is None and self.pitch is None and self.yaw is None:
            return None
        return (self.roll or 0.0, self.pitch or 0.0, self.yaw or 0.0)


@dataclass(frozen=True)
class OfFile:
    """What the command is told of a file."""

    curve: str | None = setting(
        "File with the requirement: frequency and root mean square of a third of an octave, as CSV.", None,
        example="iss_curve.csv",
    )  # fmt: skip
    slow_limit: str | None = setting(
        "Largest slow acceleration; without it there is no verdict on it.", None, example="1 ug"
    )
    perpendicular_limit: str | None = setting(
        "Largest part of it across its mean; without it there is no verdict on it.", None, example="0.2 ug"
    )
