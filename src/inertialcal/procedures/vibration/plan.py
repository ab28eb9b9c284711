"""Settings of a random vibration: the plan of a run, what the command asks of a file, what a planned run is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

CONTROLS = ("control", "control_2", "control_3", "control_4")  # channels that the table was controlled by
CONTROL = "control"  # what stands in place of an axis: the control channels together
CONTROL_SCALE, SENSOR_SCALE = "control_accelerometer.scale_factor", "sensor.scale_factor"

# Influences that a run is subject to, and what each would change.
INFLUENCES = {
    CONTROL_SCALE: "levels of the control channels in proportion, all lines alike",
    SENSOR_SCALE: "levels of the sensor's own axes in proportion",
}
DEVIATION = "spectral_density_deviation"
FEWEST_LINES = 4  # that are judged
LEVEL, LEVEL_DEVIATION, RATE_LEVEL = "acceleration_rms", "acceleration_rms_deviation", "angular_rate_rms"
DURATION, KURTOSIS = "duration_at_level", "kurtosis"


@dataclass(frozen=True)
class Plan:
    """How a run is set against its profile."""

    resolution: float | None = setting(
        "From line to line of the spectrum; a line has 1.5 times this bandwidth. Where not given, a quarter of the "
        "profile's lowest frequency.",
        None, unit="Hz", above=0, example="5 Hz",
    )  # fmt: skip
    octave: int | None = setting("Judge bands of 1/N octave in place of lines.", None, least=1, most=48, example="6")
    average: Literal["mean", "maximum"] = setting("Of several control channels, which density is controlled.", "mean")
    level: float = setting("Of this run against the profile.", 0.0, unit="dB", example="-3 dB")
    duration: float | None = setting(
        "Time at full level that was asked for: a shorter run is named.", None, unit="s", above=0, example="60 s"
    )
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])


@dataclass(frozen=True)
class OfFile:
    """What the command is told of a file."""

    profile: str | None = setting("File with the profile: nodes as CSV or TOML.", None, example="workmanship.csv")
    control: list[str] = setting(
        "Column of a control accelerometer; up to four. The sensor itself where none is given.",
        list[str], example="control_1",
    )  # fmt: skip
    response: list[str] = setting(
        "Column of a response; by default the axes of the sensor that are no control.", list[str], example="acc_x"
    )
    tolerance: str | None = setting(
        "Largest deviation from the profile at any line; without it there is no verdict on lines.", None,
        example="3 dB",
    )  # fmt: skip
    overall: str | None = setting(
        "Largest deviation of the overall level; without it there is no verdict on it.", None, example="10 %"
    )


@dataclass(frozen=True)
class PlannedRun:
    """What is known of a run before it is made."""

    profile: str | None = setting("File with the profile: nodes as CSV or TOML.", None, example="workmanship.csv")
    tolerance: float = setting("Largest deviation from the profile at any line.", 3.0, unit="dB", above=0,
                               example="3 dB")  # fmt: skip
    overall: float | None = setting("Largest deviation of the overall level.", None, unit="1", above=0, example="10 %")
    control_error: float = setting(
        "Largest deviation of the true spectrum that the controller leaves.", 1.0, unit="dB", least=0, example="1 dB"
    )
    channels: int = setting("Control channels that are averaged, whose noise is not one.", 1, least=1, most=4,
                            example="1")  # fmt: skip
    u: float = setting("Standard uncertainty of the scale factor of the control accelerometers.", 0.0, unit="1",
                       least=0, example="1 %")  # fmt: skip
    power: float = setting("Chance of a PASS that is wanted, of a run with that error.", 0.9, above=0.0, most=0.999,
                           example="0.9")  # fmt: skip
    resolution: float | None = setting("From line to line; several are compared where not given.", None, unit="Hz",
                                       above=0, example="5 Hz")  # fmt: skip
    duration: float | None = setting("Time at full level; what is needed where not given.", None, unit="s", above=0,
                                     example="60 s")  # fmt: skip
