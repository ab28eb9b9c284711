"""What a mass-attraction calibration is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ...core.influence import Influence, Standards

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
    """The moved mass, as far as its attraction can be judged by it.

    Parameters
    ----------
    mass : float
        [kg].
    density : float
        Of its material [kg/m^3].
    stand_off : float
        From the proof mass to the plane that the mass stays behind [m].
    """

    mass: float = field(metadata={"unit": "kg"})
    density: float = field(metadata={"unit": "kg/m^3"})
    stand_off: float = field(metadata={"unit": "m"})


@dataclass(frozen=True)
class HighG:
    """Scale factor from another test of the same instrument, at much larger input: a flip in gravity, a data sheet.

    Parameters
    ----------
    scale_factor : float
        [count/s/(m/s^2)].
    u : float
        Standard uncertainty of it [count/s/(m/s^2)].
    """

    scale_factor: float = field(metadata={"unit": "count/s/(m/s^2)"})
    u: float = field(default=0.0, metadata={"difference": "count/s/(m/s^2)"})


@dataclass(frozen=True)
class Plan:
    """How the campaign was made and how it is to be reduced.

    Parameters
    ----------
    axis : str
        Input axis; from the sensor.
    nominal : float or None
        Scale factor of the data sheet [count/s/(m/s^2)]; from the chain of the sensor.
    tilt : {"regressed", "known", "ignored"}
        What becomes of the tilt channel: its share in the readings is found from them, or is gravity times the tilt,
        or it is not used.
    tilt_sign : {1, -1}
        Whether a positive tilt is felt as a positive acceleration, where its share is known.
    mercury : float
        Amplitude by which the moved mass tilts the mercury of the meter, in phase with the attraction [rad].
    side_bands : int, optional
        Lines on each side of the drive that the noise is read from; 4 to 8, by the length of the run, if not said.
    floor : float
        A response below so many standard uncertainties is not told from noise.
    scatter : {"between_runs", "within_runs"}
        Where the uncertainty of several runs comes from: how they differ, or the noise beside the line of each.
    high_g : HighG, optional
        What the scale factor is compared with.
    source : SourceMass, optional
        By which the schedule is judged: no such mass attracts more than the best shape does.
    standards : mapping of Influence
        Uncertainties of the standards; from the campaign.
    """

    axis: str = field(default="x", metadata={"from": "sensor"})
    nominal: float | None = field(default=None, metadata={"from": "sensor"})
    tilt: Tilt = "regressed"
    tilt_sign: Literal[1, -1] = 1
    mercury: float = field(default=0.0, metadata={"difference": "rad"})
    side_bands: int | None = None
    floor: float = field(default=3.0, metadata={"above": 0.0})
    scatter: Scatter = "between_runs"
    high_g: HighG | None = None
    source: SourceMass | None = None
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})
