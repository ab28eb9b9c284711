"""Settings of a mass-attraction calibration, and the influences on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import PER_ACCELERATION, fact, setting

# Influences on the scale factor, and what each changes.
APPLIED = ("source_mass.density", "source_mass.placing", "source_mass.gravitational_constant")
INFLUENCES = {
    **dict.fromkeys(APPLIED, "scale factor in inverse proportion to what is applied"),
    "tilt_meter.mercury": "scale factor by the tilt of the mercury that is taken for tilt of the pad",
    "pad.tilt": "scale factor by gravity times the tilt in phase with the mass, if it is not subtracted",
}
Tilt = Literal["regressed", "known", "ignored"]


@dataclass(frozen=True)
class SourceMass:
    """The moved mass, to check what the schedule applies."""

    mass: float = setting("Mass of all that moves.", unit="kg", example="20 kg")
    density: float = setting("Density of the material.", unit="kg/m^3", example="11340 kg/m^3")
    stand_off: float = setting(
        "Distance from the proof mass to the plane that the mass stays behind.", unit="m", example="0.1 m"
    )


@dataclass(frozen=True)
class HighG:
    """Scale factor of the same instrument at much larger input: from a flip in gravity, or a data sheet."""

    scale_factor: float = setting("Scale factor at large input.", unit=PER_ACCELERATION, example="1.2 count/s/ug")
    u: float = setting(
        "Standard uncertainty of the scale factor.", 0.0, difference=PER_ACCELERATION, example="0.001 count/s/ug"
    )


@dataclass(frozen=True)
class Plan:
    """Settings of the campaign and of its reduction."""

    axis: str = fact("Input axis.", "sensor", "x")
    output_unit: str = fact("Unit of what leaves the sensor: count/s, V, count; SI of readings of input.", "sensor",
                            "count/s")  # fmt: skip
    nominal: float | None = fact("Scale factor of the data sheet [output unit/(m/s^2)].", "sensor", None)
    tilt: Tilt = setting(
        "Use of the tilt channel: its share is fitted off the drive, is gravity times the tilt, or is not used.",
        "regressed",
    )
    tilt_sign: Literal[1, -1] = setting(
        "Sign of the acceleration that a positive tilt is felt as, for a known share.", 1
    )
    mercury: float = setting(
        "Amplitude by which the moved mass tilts the mercury of the meter, in phase with the attraction.",
        0.0, difference="rad", example="1e-9 rad",
    )  # fmt: skip
    floor: float = setting(
        "Smallest response that counts as a signal, in standard uncertainties.", 3.0, above=0.0, example="3"
    )
    high_g: HighG | None = setting(
        "Scale factor to compare the result with.", None, example='{ scale_factor = "1.2 count/s/ug" }'
    )
    source: SourceMass | None = setting(
        "Moved mass, to check the schedule: the best shape of this mass must attract as much.", None,
        example='{ mass = "20 kg", density = "11340 kg/m^3", stand_off = "0.1 m" }',
    )  # fmt: skip
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])

    @property
    def scale_unit(self) -> str:
        """Unit of the scale factor: of what leaves the sensor, an SI unit of input."""
        from ...core.units import divide  # noqa: PLC0415 - numpy starts slowly

        return divide(self.output_unit, "m/s^2")


@dataclass(frozen=True)
class SaidMass:
    """Settings of the noun beyond plan and recording."""

    schedule: list[str] | None = setting(
        "CSV file with the dwells of the mass: start, stop, position, applied; of several, the files given take one"
        " after the other.", None, example="schedule.csv",
    )  # fmt: skip
    gate: str | None = setting("Time over which pulses are counted.", None, example="100 s")
    null: list[str] | None = setting(
        "File among those given whose mass was at rest, by its path or name.", None, example="null1.csv"
    )
    begin: str | None = setting(
        "Start of the schedule on the clock of the file: UTC, or elapsed time; the first sample by default.", None,
        example="2010-04-28T20:00:00Z",
    )  # fmt: skip
    stamp: Literal["start", "middle", "end"] = setting("Part of its gate that a time stamp marks.", "middle")
