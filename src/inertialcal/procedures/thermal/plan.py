"""What a thermal test is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ...core.estimate import Array
from ...core.influence import Influence, Standards
from ...core.remarks import Remark

AXES = ("x", "y", "z")  # of the body
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


@dataclass(frozen=True, eq=False)
class Sweep:
    """One recording of a unit at rest while its temperature changed.

    Parameters
    ----------
    name, run, place : str
        Of the recording; its power-up, empty where not given; its file, for messages.
    time : ndarray, shape (n,), or None
        Since power-up [s]; None where no time is known.
    temperature : mapping of str to ndarray, shape (n,)
        Of each axis' sensor [degC].
    outputs : mapping of str to ndarray, shape (n,)
        Reading of each axis [rad/s] or [m/s^2]; NaN where missing.
    references : mapping of str to mapping of str to ndarray, shape (n,)
        Name of a reference voltage -> axis -> its volts [V].
    pressure : ndarray, shape (n,), or None
        [Pa]
    """

    name: str
    run: str
    place: str
    time: Array | None
    temperature: Mapping[str, Array]
    outputs: Mapping[str, Array]
    references: Mapping[str, Mapping[str, Array]] = field(default_factory=dict[str, Mapping[str, Array]])
    pressure: Array | None = None

    def __len__(self) -> int:
        return len(next(iter(self.outputs.values()))) if self.outputs else 0


@dataclass(frozen=True, eq=False)
class Readings:
    """Recordings of one unit.

    Parameters
    ----------
    sweeps : tuple of Sweep
        Those of a run in order of time.
    unit : {"rad/s", "m/s^2"}
        Of the readings.
    remarks : tuple of Remark
        What reading them brought up.
    """

    sweeps: tuple[Sweep, ...]
    unit: str = "rad/s"
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one) for one in self.sweeps)

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes that were read, in order."""
        return tuple(axis for axis in AXES if any(axis in one.outputs for one in self.sweeps))

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the runs, in the order of their first recording."""
        return tuple(dict.fromkeys(one.run for one in self.sweeps))

    @property
    def runs(self) -> int:
        """Number of runs that can be told apart; 0 where none is given."""
        return len([label for label in self.labels if label])

    @property
    def where(self) -> str:
        """Place of the first recording, for messages."""
        return self.sweeps[0].place if self.sweeps else ""


def span_of(readings: Readings, axis: str) -> tuple[float, float]:
    """Return the lowest and highest temperature of an axis' sensor [degC]; NaN where there is none."""
    values = [one.temperature[axis] for one in readings.sweeps if axis in one.temperature]
    found = [one[np.isfinite(one)] for one in values]
    every = np.concatenate(found) if found else np.zeros(0)
    return (float(every.min()), float(every.max())) if len(every) else (np.nan, np.nan)
