"""What a rate-table test is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ...core.influence import Influence, Standards

# Influences that a rate table test is subject to, and what each would change.
INFLUENCES = {
    "rate_table.rate": "scale factors and all matrix entries in proportion",
    "rate_table.mounting": "cross-axis entries: the axis that turns is not quite the one that is named",
    "converter.reference": "scale factors in volts in proportion",
}


@dataclass(frozen=True)
class Attitude:
    """How the axis of the table stands on the ground.

    Parameters
    ----------
    tilt : float
        Angle of the table axis from the vertical, positive towards ``azimuth`` [rad].
    u : float
        Standard uncertainty of it [rad].
    azimuth : float, optional
        Direction of the tilt, from north towards east [rad]; unknown by default.
    u_azimuth : float
        Standard uncertainty of it [rad].
    """

    tilt: float = field(metadata={"unit": "rad"})
    u: float = field(default=0.0, metadata={"unit": "rad"})
    azimuth: float | None = field(default=None, metadata={"unit": "rad"})
    u_azimuth: float = field(default=0.0, metadata={"unit": "rad"})


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced.

    Parameters
    ----------
    axis : str
        Axis that is turned, where the readings do not say it dwell by dwell.
    zero_reference : bool
        The reading at rest was subtracted from every reading: its bias is then that of the subtraction.
    asymmetry : bool
        Fit a scale factor of its own for each sense of rotation.
    run_level : {"power_up", "recording"}
        What the runs are: separate power-ups, or merely separate recordings.
    scatter_ratio : float
        A dwell whose scatter is this many times more, or less, than that of its neighbours is left out.
    neighbours : int
        How many dwells, nearest in rate, a scatter is compared with.
    rail_scatters : float
        A dwell whose rate or reading is this many scatters or less from the end of the range is left out.
    agreement : float
        Largest relative difference of a reading from the rate of the table that is taken for a calibration
        matter and not for a mistake.
    missing : float
        A dwell of a recording with a larger part of its samples missing, invalid or at the rail is left out.
    applied_tolerance : float
        Wander of the ``applied`` channel that is no step, and no motion at rest [rad/s]; for an encoder.
    attitude : Attitude, optional
        Of the table; without it the earth rate along the axes is unknown.
    latitude : float, optional
        Geodetic [rad]; from the campaign's site.
    input_range : (float, float), optional
        Ends of the range [rad/s]; from the campaign's sensor.
    scale_factor : mapping of str to float, optional
        Ideal scale factor of each sensor [V/(rad/s)]; from the campaign's sensor.
    standards : mapping of Influence
        Uncertainties of the standards; from the campaign.
    """

    axis: str = ""
    zero_reference: bool = False
    asymmetry: bool = True
    run_level: Literal["power_up", "recording"] = "power_up"
    scatter_ratio: float = field(default=3.0, metadata={"above": 1.0})
    neighbours: int = field(default=8, metadata={"above": 1})
    rail_scatters: float = field(default=3.0, metadata={"above": 0.0})
    agreement: float = field(default=0.1, metadata={"above": 0.0})
    missing: float = field(default=0.1, metadata={"above": 0.0})
    applied_tolerance: float = field(default=0.0, metadata={"unit": "rad/s"})
    attitude: Attitude | None = None
    latitude: float | None = field(default=None, metadata={"from": "site"})
    input_range: tuple[float, float] | None = field(default=None, metadata={"from": "sensor"})
    scale_factor: Mapping[str, float] | None = field(default=None, metadata={"from": "sensor"})
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})
