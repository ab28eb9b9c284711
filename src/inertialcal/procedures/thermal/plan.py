"""What a thermal test is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ...core.influence import Influence, Standards

LARGEST_ORDER = 9  # of a polynomial that anybody can mean

# Influences that a thermal test is subject to, and what each would change.
INFLUENCES = {
    "thermometer.temperature": "bias by its own slope over temperature, all temperatures alike",
    "converter.reference": "bias in proportion",
    "sensor.hysteresis": "bias, where one path alone was seen: half of what the paths differ by",
}


@dataclass(frozen=True)
class Attitude:
    """How the body lies while its temperature changes: the axes of the body are those of ``physics.earth``'s table.

    Parameters
    ----------
    tilt : float
        Angle of the body's z axis from the vertical, positive towards ``azimuth`` [rad].
    u : float
        Standard uncertainty of it [rad].
    azimuth : float, optional
        Direction of the tilt, and of the body's x axis seen from above, from north towards east [rad]; unknown by
        default.
    u_azimuth : float
        Standard uncertainty of it [rad].
    """

    tilt: float = field(metadata={"unit": "rad"})
    u: float = field(default=0.0, metadata={"unit": "rad"})
    azimuth: float | None = field(default=None, metadata={"unit": "rad"})
    u_azimuth: float = field(default=0.0, metadata={"unit": "rad"})


@dataclass(frozen=True)
class Thermometer:
    """Temperature channel of one sensor: ``v = voltage + slope (T - temperature)`` [V], [V/degC], [degC]."""

    slope: float
    voltage: float
    temperature: float


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced.

    Parameters
    ----------
    order : int, optional
        Of the polynomial; absent: chosen on what is held out (module ``order``).
    largest_order : int
        That comes into question.
    reference_temperature : float
        Powers are those of the temperature less this [degC].
    at : list of float, optional
        Temperatures at which the bias is told too [degC].
    turn_over : float, optional
        After each turn of the temperature, and at the start, samples within this distance of it are left out [degC];
        absent: a tenth of the range.
    bins : int
        Of temperature, each with the same weight.
    least_range : float
        A smaller range of temperature carries no polynomial [degC].
    warm_up : float, optional
        Left out after each power-up [s]; absent: until what is left of the start-up is below ``settled``.
    settled : float, optional
        [rad/s], of an accelerometer [m/s^2]; absent: a tenth of the scatter of a sample.
    no_hysteresis : float, optional
        Gap between warming and cooling that counts as none [rad/s]; absent: none is ever shown.
    run_level : {"power_up", "recording"}
        What the runs are: separate power-ups, or merely separate recordings.
    attitude : Attitude, optional
        Of the body; without it the earth rate along its axes is unknown.
    latitude : float, optional
        Geodetic [rad]; from the campaign's site.
    thermometers : mapping of str to Thermometer, optional
        By axis; from the campaign's sensor.
    scale_factor : mapping of str to float, optional
        Ideal scale factor of each sensor [V/(rad/s)]; from the campaign's sensor.
    standards : mapping of Influence
        Uncertainties of the standards; from the campaign.
    """

    order: int | None = None
    largest_order: int = field(default=5, metadata={"above": 0})
    reference_temperature: float = field(default=20.0, metadata={"unit": "degC"})
    at: list[float] | None = field(default=None, metadata={"unit": "degC"})
    turn_over: float | None = field(default=None, metadata={"difference": "degC"})
    bins: int = field(default=40, metadata={"above": 3})
    least_range: float = field(default=10.0, metadata={"difference": "degC"})
    warm_up: float | None = field(default=None, metadata={"unit": "s"})
    settled: float | None = field(default=None, metadata={"unit": "rad/s"})
    no_hysteresis: float | None = field(default=None, metadata={"unit": "rad/s"})
    run_level: Literal["power_up", "recording"] = "power_up"
    attitude: Attitude | None = None
    latitude: float | None = field(default=None, metadata={"from": "site"})
    thermometers: Mapping[str, Thermometer] | None = field(default=None, metadata={"from": "sensor"})
    scale_factor: Mapping[str, float] | None = field(default=None, metadata={"from": "sensor"})
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})
