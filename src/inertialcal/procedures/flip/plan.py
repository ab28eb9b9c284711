"""Settings of a flip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.constants import STANDARD_GRAVITY
from ...core.influence import Influence, Standards
from ...core.key import AXES
from ...core.settings import fact, setting

Axis = Literal["x", "y", "z"]


# Influences on a flip, and what each would change.
INFLUENCES = {
    "turn.angle": "bias and ambient acceleration by half the other turned axis' ambient acceleration, times the angle",
    "turn.axis": "all results: ambient acceleration along the turn enters, and the control axis feels the others",
    "converter.zero": "bias in full: an offset of the electronics turns with the head as the bias does",
    "sensor.scale_factor": "bias and ambient acceleration in proportion, and the bias that was subtracted before",
}


@dataclass(frozen=True)
class Turned:
    """How the head was turned, as a caller says it of files."""

    positions: Mapping[str, str] = setting(
        "Angle of a position of a table of means.", dict[str, str], example='reverse="180 deg"', option="position"
    )
    windows: list[str] = setting(
        "When the head stood still, and its position then; found by the turns if not given.",
        list[str], example='"START..STOP=180 deg"', option="window",
    )  # fmt: skip
    angle: str = setting("Angle of the turns, where the windows are found.", "180 deg", example='"90 deg"')


@dataclass(frozen=True)
class Plan:
    """How the head was turned and how the readings are to be reduced."""

    axis: Axis = setting("Head axis of the turn; its own readings are the control.", "x")
    noise: Literal["slow", "pairs"] = setting(
        "Source of the uncertainty: white and slow noise and drift of the record, or the scatter of equally long "
        "and equally spaced quiet stretches elsewhere in the record.", "slow",
    )  # fmt: skip
    drift: Literal["none", "ambient", "bias", "temperature"] = setting(
        "Drift between the dwells of a flip, fitted to three dwells or more: ambient acceleration or "
        "bias in proportion to time, or bias in proportion to temperature.", "none",
    )  # fmt: skip
    block: float = setting(
        "Length of the block means that show the noise; longer in a long record with long windows, shorter in a record "
        "of less than 48 of them.",
        10.0, unit="s", example="10 s",
    )  # fmt: skip
    settle: float = setting(
        "Left out at the start of every window: settling of the turn and of the sensor's filters.",
        0.0, unit="s", example="20 s",
    )  # fmt: skip
    low_pass: float = setting(
        "Cut-off of the low-pass that is listed next to the mean.", 0.01, unit="Hz", example="0.01 Hz"
    )
    subset: float = setting("Length of the sub-means of the textbook's accuracy.", 6.0, unit="s", example="6 s")
    subsets: int = setting("Number of those sub-means.", 10, above=1, example="10")
    missing: float = setting(
        "A window is not read if a larger part of its samples is missing, invalid or at the rail.",
        0.1, above=0.0, example="0.1",
    )  # fmt: skip
    corrected: bool = setting(
        "The bias of a ground model was subtracted before: the remaining bias is model_bias_error.", False
    )
    raw_bias: float = setting(
        "Size of the bias that was subtracted before, on which the scale factor's uncertainty acts too; 0: the "
        "prediction of the ground model, where the readings come with it.", 0.0, unit="m/s^2", example="300 ug",
    )  # fmt: skip
    largest_ambient: float = setting(
        "Limit of ambient acceleration: more is a mistake in units or positions, not orbit.",
        0.1 * STANDARD_GRAVITY.value, unit="m/s^2", example="0.1 g",
    )  # fmt: skip
    largest_bias: float = setting(
        "Limit of the bias: more is a mistake in units or positions.",
        0.1 * STANDARD_GRAVITY.value, unit="m/s^2", example="0.1 g",
    )  # fmt: skip
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])

    @property
    def turned(self) -> tuple[str, str]:
        """The two axes across the turn, so that the first, the second and the turn's are right-handed."""
        at = AXES.index(self.axis)
        return AXES[(at + 1) % 3], AXES[(at + 2) % 3]


@dataclass(frozen=True)
class PlannedFlips:
    """What is known of head and orbit before flips, and what they have to give."""

    noise: float = setting(
        "White noise of the head.", unit="m/s^2/sqrt(Hz)", example="5 ug/sqrt(Hz)", above=0.0
    )  # fmt: skip
    wanted: Mapping[str, str] = setting(
        "Standard uncertainty wanted of bias or ambient_acceleration.", dict[str, str], example='bias="0.5 ug"'
    )
    available: float | None = setting("Time that there is, in all.", None, unit="s", example="4 h", above=0.0)
    instability: float = setting("Bias instability.", 0.0, unit="m/s^2", example="0.5 ug", least=0.0)
    walk: float = setting("Random walk of the bias.", 0.0, unit="m/s^2/sqrt(s)", example="0.01 ug/sqrt(s)", least=0.0)
    turn_on: float = setting(
        "Scatter of the bias from power-up to power-up; each flip is then a power-up of its own.", 0.0, unit="m/s^2",
        example="2 ug", least=0.0,
    )  # fmt: skip
    ambient: float = setting("Ambient acceleration across the turn to expect.", 0.0, unit="m/s^2", example="1 ug",
                             least=0.0)  # fmt: skip
    swing: float = setting("Amplitude of its swing with the orbit.", 0.0, unit="m/s^2", example="0.5 ug", least=0.0)
    orbit: float = setting("Time of an orbit.", 5460.0, unit="s", example="91 min", above=60.0)
    phase: Literal["any", "best"] = setting(
        "Where in the orbit flips are made: anywhere, or where the swing does least.", "any"
    )
    turn: float = setting("A turn takes, with the settling after it.", 60.0, unit="s", example="60 s", least=0.0)
    quiet: float = setting("Quiet record before and after each flip.", 600.0, unit="s", example="10 min", least=0.0)
    power_up: float = setting(
        "From flip to flip: rest, or off, on and warm-up.", 0.0, unit="s", example="1 h", least=0.0
    )
    positions: int | None = setting(
        "Dwells of a flip, at 0 and 180 deg by turns; 2, 3 and 4 are compared where not given.", None, least=2, most=20,
        example="3",
    )  # fmt: skip
    longest_dwell: float = setting("Longest dwell.", 1800.0, unit="s", example="30 min", above=20.0)
    least_flips: int = setting("Flips at least.", 1, least=1, most=200, example="5")
    most_flips: int = setting("Flips at most.", 20, least=1, most=200, example="20")
    u_angle: float = setting(
        "Standard uncertainty of the angle of a turn.", 0.0, unit="rad", example="0.2 deg", least=0.0
    )
    u_axis: float = setting(
        "Standard uncertainty of the axis of the turn.", 0.0, unit="rad", example="0.2 deg", least=0.0
    )
    u_zero: float = setting("Standard uncertainty of the zero of the electronics.", 0.0, unit="m/s^2",
                            example="0.1 ug", least=0.0)  # fmt: skip
    simulate: int = setting(
        "Simulated tests by which the forecast is checked; 0 for none.", 20, least=0, most=2000, example="40"
    )
    schedule: str | None = setting("Write the programme as CSV into this file.", None, example="schedule.csv")
