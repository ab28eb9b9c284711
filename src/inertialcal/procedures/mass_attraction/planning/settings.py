"""Settings of ``plan mass-attraction``, in groups: schema of its file, options, arguments and manual. Free of numpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ....core.constants import GRAVITATIONAL_CONSTANT, STANDARD_GRAVITY
from ....core.settings import setting

G, G_UNIT = GRAVITATIONAL_CONSTANT.value, "m^3/s^2/kg"
HOUR = 3600.0
Moved = Literal["along", "across"]
Starts = Literal["alike", "alternating", "quarters"]


@dataclass(frozen=True)
class Cubes:
    """Cubes of one size."""

    count: int = setting("Number of cubes.", least=1, example="100")
    edge: float = setting("Edge of each cube.", unit="m", above=0.0, example="10.2 cm")


@dataclass(frozen=True)
class Body:
    """The source mass: a stack of cubes behind a plane."""

    stand_off: float = setting(
        "Distance from the proof mass to the nearest face at position zero.", unit="m", above=0.0, example="7.6 cm"
    )
    cube: float | None = setting("Edge of the cubes.", None, unit="m", above=0.0, example="5.08 cm")
    count: int | None = setting("Number of cubes; default: as many as `mass` allows.", None, least=1, example="900")
    mass: float | None = setting("Largest mass of the whole body.", None, unit="kg", above=0.0, example="1338 kg")
    cubes: list[Cubes] | None = setting(
        "Cubes of several sizes, instead of `cube` and `count`.", None,
        example='[{ count = 100, edge = "10.2 cm" }, { count = 100, edge = "5.1 cm" }]',
    )  # fmt: skip
    density: float = setting(
        "Density of the material; lead by default.", 11_340.0, unit="kg/m^3", above=0.0, example="11340 kg/m^3"
    )
    grid: list[int] | None = setting(
        "Cells of the grid: across, across and along the input axis; default: large enough.", None,
        example="[20, 20, 10]",
    )  # fmt: skip
    optimise: Literal["attraction", "change"] = setting(
        "Shape with the largest attraction at position zero, or the largest change over the stroke.", "attraction"
    )
    stated: float | None = setting(
        "Attraction that a document states, to compare with the bound.", None, unit="m/s^2", above=0.0, example="74 ng"
    )


@dataclass(frozen=True)
class Motion:
    """How the body moves. Without `rig`, `stroke` and `travel` only the body is planned."""

    direction: Moved = setting("Across the input axis, past the sensor; or along it, away from the sensor.", "across")
    rig: list[float] | None = setting(
        "Range of the stage; default: as far as stroke or travel need.", None, unit="m", example='["0 cm", "60 cm"]'
    )
    stroke: list[float] | None = setting("Ends of the drive.", None, unit="m", example='["12.7 cm", "43.2 cm"]')
    travel: float | None = setting(
        "Length of the stroke, instead of `stroke`: the best window of this length; default: the whole rig.", None,
        unit="m", above=0.0, example="30.5 cm",
    )  # fmt: skip


@dataclass(frozen=True)
class Timing:
    """Dwells of the test."""

    drive: Literal["sine", "square", "abab"] = setting("Order of the dwells.", "sine")
    dwell: float = setting("Length of a dwell.", 100.0, unit="s", above=0.0, example="100 s")
    move: float = setting("Pause between two dwells, while the body moves.", 20.0, unit="s", least=0.0, example="20 s")
    length: float = setting(
        "Length of a run.", 24.0 * HOUR, unit="s", above=0.0, most=1e5 * HOUR, example="24 h"
    )  # fmt: skip
    runs: int = setting("Number of runs.", 1, least=1, most=1000, example="4")
    starts: Starts = setting(
        "Phase at which the drives of the runs start: all alike, by turns half a cycle apart, or at the four quarters.",
        "alike",
    )
    target: float | None = setting(
        "Relative standard uncertainty of the scale factor to reach.", None, unit="1", above=0.0, example="1 %"
    )


@dataclass(frozen=True)
class Instrument:
    """The accelerometer, and the tilt meter next to it."""

    case: float = setting(
        "Distance from the proof mass to the outside of the case.", 0.0, unit="m", least=0.0, example="3 cm"
    )
    first_pool: list[float] | None = setting(
        "Middle of the first mercury surface of the tilt meter: x along the input axis toward the body, y, z up.", None,
        unit="m", example='["0 cm", "-50 cm", "-10 cm"]',
    )  # fmt: skip
    second_pool: list[float] | None = setting(
        "Middle of the second surface. The schedule then holds the tilt, positive where the second stands higher.",
        None, unit="m", example='["0 cm", "50 cm", "-10 cm"]',
    )  # fmt: skip


@dataclass(frozen=True)
class ProofCylinder:
    """Proof mass: a cylinder along the input axis. Without this group it is a point."""

    length: float = setting("Length.", unit="m", above=0.0, example="2.915 cm")
    radius: float = setting("Outer radius.", unit="m", above=0.0, example="1.37 cm")
    inner_radius: float = setting("Inner radius; 0 for a solid cylinder.", 0.0, unit="m", least=0.0, example="1.268 cm")


def _coefficient(help: str, unit: str, example: str) -> Any:
    """Return a setting of a noise coefficient that some accelerometer may have."""
    return setting(help, None, unit=unit, above=1e-20, most=1e3, example=example)


@dataclass(frozen=True)
class Noise:
    """Noise of the accelerometer: coefficients, or a file that holds them."""

    quantization: float | None = _coefficient("Quantization noise.", "m/s", "1e-6 m/s")
    velocity_random_walk: float | None = _coefficient("White noise.", "m/s^2/sqrt(Hz)", "55 ng/sqrt(Hz)")
    bias_instability: float | None = _coefficient("Flicker noise.", "m/s^2", "1 ng")
    acceleration_random_walk: float | None = _coefficient("Random walk of the bias.", "m/s^2/sqrt(s)", "0.1 ng/sqrt(s)")
    acceleration_ramp: float | None = _coefficient("Linear drift.", "m/s^3", "0.1 ug/h")
    file: Path | None = setting(
        "Output of `allan --json`, or results.json of a run, instead of coefficients.", None, example="noise.json"
    )
    axis: str | None = setting("Axis to take from the file, if it has several.", None, example="x")


@dataclass(frozen=True)
class RepeatingDrift:
    """A drift that repeats in every run: size, and time constant or period."""

    size: float = setting("Largest change of the drift.", unit="m/s^2", above=0.0, example="20 ug")
    time: float | None = setting("Time constant from the start of each run.", None, unit="s", above=0.0, example="1 h")
    period: float | None = setting(
        "Period, instead of `time`: of a thermostat that is switched on with each run.", None, unit="s", above=0.0,
        example="20 min",
    )  # fmt: skip


@dataclass(frozen=True)
class Uncertainty:
    """Standard uncertainties of the body. Anything not given counts as exact."""

    density: float | None = setting("Density, the same error in all cubes.", None, unit="1", least=0.0, example="0.3 %")
    piece_density: float | None = setting("Density of each cube.", None, unit="1", least=0.0, example="0.5 %")
    position: float | None = setting(
        "Position of the body relative to the proof mass, in each direction, the same at both ends.", None, unit="m",
        least=0.0, example="0.5 mm",
    )  # fmt: skip
    stop: float | None = setting("Each end along the travel.", None, unit="m", least=0.0, example="1 mm")
    piece_place: float | None = setting(
        "Position of each cube in the body, in each direction.", None, unit="m", least=0.0, example="0.5 mm"
    )
    angle: float | None = setting("Each angle of the body.", None, unit="rad", least=0.0, example="2 mrad")


@dataclass(frozen=True)
class Constants:
    """Constants: today's, or those of a document that is checked."""

    gravitational_constant: float = setting(
        "Gravitational constant; CODATA 2022 with its uncertainty by default.", G, unit=G_UNIT, least=0.9 * G,
        most=1.1 * G, example="6.67e-8 cm^3/s^2/gram",
    )  # fmt: skip
    gravity: float = setting(
        "Acceleration that one g stands for in this file and in the results.",
        STANDARD_GRAVITY.value, unit="m/s^2", least=9.7, most=9.9, example="981 cm/s^2",
    )  # fmt: skip

    @property
    def u_gravitational_constant(self) -> float:
        """Relative; a document's constant counts as exact."""
        return GRAVITATIONAL_CONSTANT.u / G if self.gravitational_constant == G else 0.0

    @property
    def ng(self) -> float:
        """One nano-g [m/s^2]."""
        return 1e-9 * self.gravity

    @property
    def notes(self) -> dict[str, str]:
        """Lines for the head of a schedule file."""
        return {
            "gravitational constant": f"{self.gravitational_constant!r} {G_UNIT}",
            "gravity": f"{self.gravity!r} m/s^2",
        }


@dataclass(frozen=True)
class Orbit:
    """A small mass in orbit and a gradiometer, instead of a body and its motion."""

    stand_off: float = setting(
        "From an accelerometer to the nearest point of the mass.", unit="m", above=0.0, example="10.2 cm"
    )
    mass: float = setting("Mass of the sphere.", 4.0, unit="kg", above=0.0, example="4 kg")
    density: float = setting(
        "Density of the sphere; lead by default.", 11_340.0, unit="kg/m^3", above=0.0, example="11340 kg/m^3"
    )
    gradient: float | None = setting(
        "Smallest gradient that the gradiometer resolves; default: 0.5 Eotvos.", None, unit="1/s^2", above=0.0,
        example="0.5 Eotvos",
    )  # fmt: skip
    acceleration: float | None = setting(
        "Smallest difference of its accelerometers, instead of `gradient`.", None, unit="m/s^2", above=0.0,
        example="1e-10 g",
    )  # fmt: skip
    baseline: float = setting("Distance between its accelerometers.", 2.0, unit="m", above=0.0, example="2 m")


@dataclass(frozen=True)
class Settings:
    """All groups."""

    body: Body | None = setting("Source mass: a stack of cubes behind a plane.", None)
    motion: Motion = setting("Motion of the body. Without rig, stroke and travel only the body is planned.", Motion)
    timing: Timing = setting("Dwells of the test.", Timing)
    instrument: Instrument = setting("Accelerometer, and the tilt meter next to it.", Instrument)
    proof_mass: ProofCylinder | None = setting("Cylinder along the input axis; a point without this group.", None)
    noise: Noise = setting("Noise of the accelerometer: coefficients, or a file.", Noise)
    drift: RepeatingDrift | None = setting(
        "A drift that repeats in every run: size, and time constant or period.", None
    )
    uncertainty: Uncertainty = setting("Standard uncertainties; anything not given counts as exact.", Uncertainty)
    constants: Constants = setting("Constants of a document; today's without this group.", Constants)
    orbit: Orbit | None = setting("Small mass and gradiometer in orbit, instead of all groups but constants.", None)


def ends_of(lengths: Sequence[float]) -> tuple[float, float]:
    """Return the two ends of a range, the smaller first."""
    return min(lengths), max(lengths)


def stage_of(motion: Motion) -> tuple[float, float] | None:
    """Return the range of the stage [m]: as given, or as far as stroke or travel need; None without a motion."""
    if motion.rig is not None:
        return ends_of(motion.rig)
    if motion.stroke is not None:
        return min(0.0, *motion.stroke), max(motion.stroke)
    return None if motion.travel is None else (0.0, 2.0 * motion.travel)


STARTER = (
    "body.cube", "body.count", "body.stand_off", "motion.rig", "motion.stroke", "timing.target",
    "noise.velocity_random_walk", "noise.bias_instability", "noise.acceleration_random_walk", "uncertainty.density",
    "uncertainty.position", "uncertainty.stop",
)  # fmt: skip
