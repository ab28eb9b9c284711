"""Settings of a turned-mass calibration and of its plan, and the influences on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

MASS, RADIUS, HEIGHT = "turned_mass.mass", "turned_mass.radius", "turned_mass.height"
SATELLITE, ORBIT, CONSTANT = "satellite.mass", "orbit.rate", "source_mass.gravitational_constant"
# Influences on the scale factor, and what each changes.
INFLUENCES = {
    MASS: "scale factor in inverse proportion",
    RADIUS: "scale factor by twice its part, and the recoil arm",
    HEIGHT: "scale factor by 3/2 of the square of the height over the radius",
    CONSTANT: "scale factor in inverse proportion",
    SATELLITE: "recoil arm, where it is stated and not found from the runs",
    ORBIT: "recoil of each run by its rate of turn",
}
InputAxis = Literal["radial", "along_track"]


@dataclass(frozen=True)
class HighG:
    """Scale factor of the same instrument by another test."""

    scale_factor: float = setting("Scale factor.", unit="count/s/(m/s^2)", example="10.21 count/s/ug")
    u: float = setting(
        "Standard uncertainty of it.", 0.0, difference="count/s/(m/s^2)", example="0.1 count/s/ug"
    )  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """Settings of the campaign and of its reduction."""

    mass: float | None = setting(
        "Turned mass, arm and all that turns with it included.", None, unit="kg", example="4 kg", above=0.0
    )
    radius: float | None = setting(
        "From the axis of rotation to the middle of the mass.", None, unit="m", example="0.2 m", above=0.0
    )
    axis: str = fact("Input axis.", "sensor", "x")
    nominal: float | None = fact("Scale factor of the data sheet [count/s/(m/s^2)].", "sensor", None)
    altitude: float | None = setting(
        "Of the circular orbit over the mean earth.", None, unit="m", example="560 km", above=0.0
    )
    orbit_period: float | None = setting(
        "Of the orbit, in place of its altitude.", None, unit="s", example="5740 s", above=0.0
    )
    satellite: float | None = setting(
        "Mass of the satellite without the turned mass, to check the recoil arm, or to take it as stated.", None,
        unit="kg", example="1000 kg",
    )  # fmt: skip
    recoil: Literal["found", "stated"] = setting(
        "Recoil arm: found from runs at several rates of turn, or that of the masses as they are stated.", "found"
    )
    input_axis: InputAxis = setting("Where the input axis points; the satellite keeps it there.", "radial")
    alignment: float = setting(
        "Standard uncertainty of the direction of the input axis, in the plane of the orbit and out of it.", 0.035,
        difference="rad", example="2 deg", above=0.0, most=0.35,
    )  # fmt: skip
    orbit_lines: int = setting(
        "Multiples of the orbital rate that are fitted in each run as a disturbance.", 2, least=0, most=6, example="2"
    )
    high_g: HighG | None = setting(
        "Scale factor to compare the result with.", None, example='{ scale_factor = "10.21 count/s/ug" }'
    )
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])

    @property
    def turned(self) -> tuple[float, float]:
        """Mass [kg] and its distance [m].

        Raises
        ------
        PlanError
            ``missing_key`` if one is not given.
        """
        if self.mass is None or self.radius is None:
            from ...core.errors import PlanError  # noqa: PLC0415 - numpy starts slowly

            what = f"{'mass' if self.mass is None else 'radius'} of the turned mass missing"
            do = "Give both, mass and radius"
            raise PlanError(what, why="its attraction follows from them", do=do, code="missing_key")
        return self.mass, self.radius


@dataclass(frozen=True)
class SaidTurn:
    """Settings of the noun beyond plan and recording."""

    schedule: str | None = setting(
        "CSV file with the programme: run, start, stop, rate, angle; a file named as a run is that run, another one"
        " all of them.",
        None, example="schedule.csv",
    )  # fmt: skip
    gate: str | None = setting("Time over which pulses are counted.", None, example="100 s")
    begin: str | None = setting(
        "Start of the programme on the clock of the file: UTC, or elapsed time; by default its first run starts with"
        " the first sample.", None, example="2026-03-01T00:00:00Z",
    )  # fmt: skip
    stamp: Literal["start", "middle", "end"] = setting("Part of its gate that a time stamp marks.", "middle")


@dataclass(frozen=True)
class PlannedTurns:
    """A programme before it is run."""

    mass: float = setting("Turned mass.", 4.0, unit="kg", example="4 kg", above=0.0)
    radius: float = setting("Distance of the mass.", 0.2, unit="m", example="0.2 m", above=0.0)
    satellite: float = setting("Mass of the satellite.", 1000.0, unit="kg", example="1000 kg", above=0.0)
    altitude: float = setting("Of the circular orbit.", 560e3, unit="m", example="560 km", above=0.0)
    input_axis: InputAxis = setting("Where the input axis points.", "radial")
    scale_factor: float = setting(
        "Nominal scale factor.", 10.21e6 / 9.80665, unit="count/s/(m/s^2)", example="10.21 count/s/ug", above=0.0
    )
    gate: float = setting("Time over which pulses are counted.", 100.0, unit="s", example="100 s", above=0.0)
    noise: float = setting(
        "White noise of the rate that is counted over one gate.", 3e-3, difference="count/s", example="0.003 count/s",
        above=0.0,
    )  # fmt: skip
    walk: float = setting(
        "Random walk of the rate, standard deviation of its step from gate to gate.", 0.0, difference="count/s",
        example="0.0003 count/s", least=0.0,
    )  # fmt: skip
    periods: list[str] = setting(
        "Time of a turn, with its sense: + that of the orbit, - against it, none for both; 1 h and 2 h if not given.",
        lambda: ["1 h", "2 h"], example="+1 h",
    )  # fmt: skip
    hours: float = setting("Length of each run.", 86400.0, unit="s", example="24 h", above=0.0)
    repeats: int = setting("How often each run is made.", 1, least=1, most=100, example="2")
    wanted: float | None = setting(
        "Relative standard uncertainty of the scale factor that is wanted.", None, unit="1", example="1 %", above=0.0
    )
    u_mass: float = setting("Standard uncertainty of the mass.", 1e-3, difference="kg", example="1 g", least=0.0)
    u_radius: float = setting("Standard uncertainty of the radius.", 1e-4, difference="m", example="0.1 mm", least=0.0)
    trials: int = setting(
        "Simulated tests by which the forecast is checked; 0 for none.", 40, least=0, most=2000, example="40"
    )
    schedule: str | None = setting("Write the programme as CSV into this file.", None, example="schedule.csv")
