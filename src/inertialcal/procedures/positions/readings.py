"""What a test of positions works on: static intervals as mean readings, and the rotations between them.

Conventions: readings are outputs as they were recorded (counts with their zero, or SI). The body frame is that of
the positions where these are known (``direction``), else that of the accelerometers: x along the input axis of the x
sensor, y in the plane of those of x and y. ``direction`` is the specific force over gravity: at rest it points *up*,
away from the earth, in body axes; an accelerometer whose axis points up reads plus g. A rotation is positive by the
right-hand rule, of the body against space, about an axis of the body.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import Problem
from ...core.estimate import Array
from ...core.key import AXES, Kind, Origin
from ...core.recording import Times
from ...core.remarks import Remark
from ...core.unknowns import Unknowns
from ...physics.earth import normal_gravity
from .plan import Plan

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Triad:
    """Mean readings of three sensors x, y, z in m static intervals."""

    mean: Array  # shape (m, 3): [unit]
    scatter: Array  # shape (m, 3): standard deviation of a sample inside the interval [unit]
    n_effective: Array  # shape (m, 3): independent samples that the mean is worth
    unit: str  # ``"m/s^2"``, ``"rad/s"``, or the unit of the output, such as ``"count"``
    samples: Array | None = None  # shape (m,): samples of each interval

    @property
    def u(self) -> Array:
        """Standard uncertainty of the means by the scatter inside the intervals alone, shape (m, 3)."""
        return self.scatter / np.sqrt(self.n_effective)

    def take(self, which: NDArray[np.bool_] | Indices) -> Triad:
        """Return the triad in some of the intervals."""
        samples = None if self.samples is None else self.samples[which]
        return Triad(self.mean[which], self.scatter[which], self.n_effective[which], self.unit, samples)


@dataclass(frozen=True, eq=False)
class Rotation:
    """Samples of one rotation, the first and the last of them at rest."""

    seconds: Array  # shape (k,): since the first sample [s]
    gyro: Array  # shape (k, 3): [unit of the gyro readings]
    # shape (k, 3): [unit of the accelerometer readings]; for what the gyros read of specific force
    acc: Array | None = None
    before: int = -1  # Static interval before it, counted from 0; -1 where there is none
    after: int = -1  # Static interval after it
    axis: Array | None = None  # shape (3,): unit vector turned about, in body axes, where it is known
    angle: float | None = None  # Turned by [rad], where it is known; several turns count fully (two turns are 4 pi)
    where: str = ""  # Place, for messages
    missing: int = 0  # Samples of the longest gap in it
    assumed: bool = False  # Whether nobody stated the angle

    @property
    def known(self) -> bool:
        """Whether axis and angle are known."""
        return self.axis is not None and self.angle is not None


@dataclass(frozen=True, eq=False)
class Readings:
    """Static intervals in order of time, and the rotations."""

    acc: Triad  # Accelerometers
    gyro: Triad | None = None  # Gyros, in the same intervals
    rotations: tuple[Rotation, ...] = ()  # Between static intervals, or of a known angle
    # shape (m, 3): specific force over gravity, in body axes, where the positions are known; a row of NaN is one
    # that is not
    direction: Array | None = None
    start_ns: Times | None = None  # shape (m,): first stamp used [ns]
    stop_ns: Times | None = None  # shape (m,): last stamp used [ns]
    temperature: Array | None = None  # shape (m,): [degC]
    where: tuple[str, ...] = ()  # Place of each interval, for messages
    left_out: tuple[int, ...] = ()  # Numbers, among all that were found, of intervals without enough readings
    recordings: tuple[int, ...] = ()  # Number of the recording that each interval lies in; empty: one
    # Of each kind of sensor: what earlier tests found, that was taken off, a dwell a position
    taken_off: Mapping[Kind, Mapping[Origin, Unknowns]] = field(default_factory=dict[Kind, Mapping[Origin, Unknowns]])
    spans_ns: tuple[tuple[int, int], ...] = ()  # First and last stamp of each recording [ns]
    remarks: tuple[Remark, ...] = field(default=())  # What reading them brought up

    def __len__(self) -> int:
        """Return the number of static intervals."""
        return len(self.acc.mean)

    @property
    def transitions(self) -> tuple[Rotation, ...]:
        """Rotations between two static intervals."""
        return tuple(one for one in self.rotations if one.before >= 0 and one.after >= 0)

    @property
    def turns(self) -> tuple[Rotation, ...]:
        """Rotations by a known angle about a known axis."""
        return tuple(one for one in self.rotations if one.known)

    def place(self, k: int) -> str:
        """Return where a static interval lies: ``"position 3"`` with its place."""
        return f"position {k + 1} ({self.where[k]})" if self.where else f"position {k + 1}"

    def take(self, start: int, stop: int) -> Readings:
        """Return the intervals start to stop - 1 with the rotations among them, counted anew; known turns stay."""
        part = slice(start, stop)
        kept = []
        for one in self.rotations:
            inside = start <= one.before < stop and start <= one.after < stop
            if inside:
                kept.append(replace(one, before=one.before - start, after=one.after - start))
            elif one.known:
                kept.append(replace(one, before=-1, after=-1))
        rows = np.arange(len(self))[part]
        return replace(
            self,
            acc=self.acc.take(rows),
            gyro=None if self.gyro is None else self.gyro.take(rows),
            rotations=tuple(kept),
            direction=None if self.direction is None else self.direction[part],
            start_ns=None if self.start_ns is None else self.start_ns[part],
            stop_ns=None if self.stop_ns is None else self.stop_ns[part],
            temperature=None if self.temperature is None else self.temperature[part],
            where=self.where[part],
            left_out=(),
            recordings=self.recordings[part],
            taken_off={
                kind: {origin: one.take(rows) for origin, one in off.items()} for kind, off in self.taken_off.items()
            },
        )


def local_gravity(plan: Plan) -> float:
    """Return the gravity that the plan gives, or that of its place, or the standard value [m/s^2]."""
    if plan.gravity is not None:
        return plan.gravity
    if plan.latitude is not None:
        return float(normal_gravity(plan.latitude, plan.height))
    return float(STANDARD_GRAVITY.value)


def by_axis(numbers: Mapping[str, float] | None, absent: float) -> Array:
    """Return one number an axis, shape (3,)."""
    return np.array([(numbers or {}).get(axis, absent) for axis in AXES], dtype=np.float64)


def site_problems(plan: Plan) -> list[Problem]:
    """Return what cannot be meant of gravity, latitude and the shortest rest.

    Parameters
    ----------
    plan : Plan
        With what the site says.
    """
    found = []
    if plan.gravity is not None and not 0.0 < plan.gravity < math.inf:
        do = "Give its size, like 9.8123 m/s2: the orientation carries the sign"
        found.append(Problem(f"gravity of {plan.gravity:g} m/s2: need more than 0", do=do, code="wrong_value"))
    if plan.latitude is not None and not abs(plan.latitude) <= 0.5 * math.pi:
        what = f"latitude of {math.degrees(plan.latitude):g} deg: need -90 to 90 deg"
        found.append(Problem(what, do="North is positive", code="wrong_value"))
    if plan.shortest is not None and not plan.shortest > 0.0:
        what = f"shortest rest of {plan.shortest:g} s: need more than 0"
        found.append(Problem(what, do="Leave it out: the noise then decides", code="wrong_value"))
    return found


def turn_problems(turn: float) -> list[Problem]:
    """Return what cannot be meant of a turn [rad]."""
    if turn != 0.0 and math.isfinite(turn):
        return []
    what = f"a turn by {math.degrees(turn):g} deg"
    return [Problem(what, "", "nothing was turned", "Give the angle of each turn, like 360 deg", "wrong_value")]
