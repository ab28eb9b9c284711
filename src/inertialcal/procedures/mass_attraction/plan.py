"""What a mass-attraction calibration is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

# Influences that the scale factor is subject to, and what each would change.
APPLIED = ("source_mass.density", "source_mass.placing", "source_mass.gravitational_constant")
INFLUENCES = {
    **dict.fromkeys(APPLIED, "scale factor in inverse proportion to what is applied"),
    "tilt_meter.mercury": "scale factor by the tilt that is taken for one of the pad",
    "pad.tilt": "scale factor by gravity times the tilt in phase with the mass, where it is not taken off",
}
Tilt = Literal["regressed", "known", "ignored"]
Scatter = Literal["between_runs", "within_runs"]


@dataclass(frozen=True)
class SourceMass:
    """The moved mass, as far as its attraction can be judged by it."""

    mass: float = setting("Of all that is moved.", unit="kg", example="20 kg")
    density: float = setting("Of its material.", unit="kg/m^3", example="11340 kg/m^3")
    stand_off: float = setting(
        "Distance from the proof mass to the plane that the mass stays behind.", unit="m", example="0.1 m"
    )


@dataclass(frozen=True)
class HighG:
    """Scale factor from another test of the same instrument, at much larger input: a flip in gravity, a data sheet."""

    scale_factor: float = setting("At large input.", unit="count/s/(m/s^2)", example="1.2 count/s/ug")
    u: float = setting(
        "Standard uncertainty of the scale factor.", 0.0, difference="count/s/(m/s^2)", example="0.001 count/s/ug"
    )


@dataclass(frozen=True)
class Plan:
    """How the campaign was made and how it is to be reduced."""

    axis: str = fact("Input axis.", "sensor", "x")
    nominal: float | None = fact("Scale factor of the data sheet [count/s/(m/s^2)].", "sensor", None)
    tilt: Tilt = setting(
        "What becomes of the tilt channel: its share in the readings is found from them, or is gravity times the tilt, "
        "or it is not used.", "regressed",
    )  # fmt: skip
    tilt_sign: Literal[1, -1] = setting(
        "Whether a positive tilt is felt as a positive acceleration, where its share is known.", 1
    )
    mercury: float = setting(
        "Amplitude by which the moved mass tilts the mercury of the meter, in phase with the attraction.",
        0.0, difference="rad", example="1e-9 rad",
    )  # fmt: skip
    side_bands: int | None = setting(
        "Lines on each side of the drive that the noise is read from; 4 to 8, by the length of the run, where not "
        "given.", None, example="8",
    )  # fmt: skip
    floor: float = setting(
        "A response below so many standard uncertainties is not told from noise.", 3.0, above=0.0, example="3"
    )
    scatter: Scatter = setting(
        "Where the uncertainty of several runs comes from: how they differ, or the noise beside the line of each.",
        "between_runs",
    )
    high_g: HighG | None = setting(
        "Scale factor that the result is compared with.", None, example='{ scale_factor = "1.2 count/s/ug" }'
    )
    source: SourceMass | None = setting(
        "By which the schedule is judged: no such mass attracts more than the best shape does.", None,
        example='{ mass = "20 kg", density = "11340 kg/m^3", stand_off = "0.1 m" }',
    )  # fmt: skip
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])
