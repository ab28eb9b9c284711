"""Alignment of a unit at rest: roll and pitch from gravity, heading from the rate of the earth (module ``solving``).

Assumed: the base does not turn; the bias of a gyro is the same in all positions, but for what is drawn anew in each and
alike in all axes; noise within a record may be slow, up to a few periods in it.

What the uncertainty means. Type A of the accelerometers: the lowest cosines of each record, which are its degrees of
freedom. Of the gyros: what is left once bias and heading are taken off, the rate about the vertical and the length of
the level rate, which latitude tells: 2 values of one position, 3 m - 4 of m, as many degrees of freedom; it holds
noise, drift between positions, and in one position the bias, which is taken to be of one size in all axes. Where the
bias of one position was stated, or taken off after another test, it is the lowest cosines and that bias instead, unless
what is left says that it is larger. Type B: biases, scale factors, misalignment, turns, mounting, latitude, plumb line.

The interval of a heading is that of an angle: the level rate across a direction is normal about 0 for the true one,
whatever its length, so that ``abs(sin(heading - true)) <= t u`` holds in 95 % (Fieller). Beyond 45 deg to each side no
heading is told: the gyro is too coarse.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.key import AXES, Key, Kind, Origin
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...physics.earth import OMEGA, normal_gravity
from ...statistics.quantiles import t_upper
from ..corrections import components
from .doubts import check, doubts
from .keys import BIAS, EXCESS, HEADING, LATITUDE, RATE, ROLL, VERTICAL, keys_of
from .plan import Plan
from .readings import Position, Readings
from .rows import curves, rows
from .solving import Inputs, Solution, attitude, changes, figures, quaternion, solve
from .turns import per_hour, turns_of

COSINES = 6  # of each record
WIDEST = math.radians(45.0)  # of the interval of a heading, to each side
STEEP = math.radians(80.0)  # pitch, beyond which x has no azimuth
TAIL = 0.0005  # of a bias that is as stated, to each side


@dataclass(frozen=True, eq=False)
class Attitude:
    """Attitude of one position."""

    matrix: Array  # shape (3, 3): takes body axes to north, east, down
    quaternion: Array  # shape (4,): w, x, y, z, of the same turn
    covariance: Array  # shape (3, 3): of a small turn about north, east, down [rad^2]


@dataclass(frozen=True, eq=False)
class Result:
    """What an alignment gives."""

    plan: Plan
    readings: Readings
    given: Inputs
    solution: Solution
    measured: bool  # whether the turns are those that the gyro measured
    whole: Estimate  # of all figures, also those that are not told
    bias_u: float  # standard uncertainty of the level rate across the heading [rad/s]
    stated: bool = False  # whether the bias of one position is stated
    remarks: tuple[Remark, ...] = field(default=())

    @cached_property
    def coarse(self) -> bool:
        """Whether the interval of a heading would be too wide at the level rate that the latitude tells.

        That, and not the rate that was read, decides: else headings were told where it was read too large by chance.
        """
        widest = max(self.half_width(key) for key in self.whole.keys if key.quantity == HEADING)
        horizontal = OMEGA * math.cos(self.given.latitude)
        return widest >= 1.0 or widest * self.solution.rate > horizontal * math.sin(WIDEST)

    @property
    def forecast(self) -> float:
        """Standard uncertainty of the heading by what is not known of the level rate, over that of the earth [rad]."""
        return self.bias_u / (OMEGA * math.cos(self.given.latitude))

    @cached_property
    def steep(self) -> bool:
        """Whether x stands too steep for an azimuth in any position."""
        return bool(np.max(np.abs(self.solution.pitch)) > STEEP)

    @property
    def told(self) -> bool:
        """Whether headings are told."""
        return not self.coarse and not self.steep

    def half_width(self, key: Key) -> float:
        """Return the sine of half the interval of a heading; more than 1 is the whole circle."""
        at = self.whole.index(key)
        return float(t_upper(0.025, float(self.whole.dof[at])) * self.whole.u[at])

    @cached_property
    def estimate(self) -> Estimate:
        """Figures that are told, SI."""
        away = {HEADING} if not self.told else set()
        away |= {ROLL} if self.steep else set()
        away |= {BIAS} if len(self.readings) == 1 else {VERTICAL}
        away |= set() if self.latitude_told else {LATITUDE}
        return self.whole.select([key for key in self.whole.keys if key.quantity not in away])

    @property
    def latitude_told(self) -> bool:
        """Whether the rates tell the latitude better than to 20 deg."""
        at = self.whole.index(Key(LATITUDE))
        circular = len(self.readings) == 1 and not self.stated
        u, dof = float(self.whole.u[at]), float(self.whole.dof[at])
        return not circular and self.solution.rate < OMEGA and float(t_upper(0.025, dof)) * u < math.radians(20.0)

    @property
    def attitudes(self) -> tuple[Attitude, ...]:
        """Attitude of each position; none where no heading is told."""
        if not self.told:
            return ()
        found = []
        angles = zip(self.solution.roll, self.solution.pitch, self.solution.heading, strict=True)
        covariance = self.whole.covariance
        for at, (roll, pitch, heading) in enumerate(angles):
            matrix = attitude(roll, pitch, heading, self.given.up)
            c, s = math.cos(heading), math.sin(heading)
            # turns about x, about level y, and about down, to turns about north, east, down
            turn = np.array([[math.cos(pitch) * c, -s, 0.0], [math.cos(pitch) * s, c, 0.0],
                             [-math.sin(pitch), 0.0, 1.0]])  # fmt: skip
            part = covariance[3 * at : 3 * at + 3, 3 * at : 3 * at + 3]
            found.append(Attitude(matrix, quaternion(matrix), turn @ part @ turn.T))
        return tuple(found)

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        return tuple(rows(self))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return curves(self)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the figures in SI, how many remarks."""
        caption = f"alignment: z of the unit points {'up' if self.given.up else 'down'}"
        return (*estimate_table([row.to_dict() for row in self.rows()], caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Return the attitude of a unit at rest.

    Raises
    ------
    DataError
        ``no_latitude``; as ``turns.turns_of`` and ``doubts.check``.
    """
    if plan.latitude is None:
        do = "State the latitude of the site, north positive"
        raise DataError("no latitude", why="the rate of the earth depends on it", do=do, code="no_latitude")
    positions = readings.positions
    force = np.array([one.mean_acc for one in positions])
    up = plan.body == "z_up" or (plan.body == "auto" and bool(np.mean(force[:, 2]) > 0.0))
    gravity = plan.gravity if plan.gravity is not None else float(normal_gravity(plan.latitude, plan.height))
    flat = Inputs(force, np.array([one.mean_gyro for one in positions]), np.zeros(len(positions)), plan.latitude,
                  gravity, up)  # fmt: skip
    turns, measured, said = turns_of(plan, readings, flat)
    given = replace(flat, turns=turns)
    found = solve(given)
    check(plan, readings, given, found)
    result = _with_uncertainty(plan, readings, given, found, measured)
    remarks = (*readings.remarks, *said, *result.remarks, *doubts(result))
    return replace(result, remarks=tuple(dict.fromkeys(remarks)))


def long_run(series: Array) -> tuple[Array, int]:
    """Return the covariance of the means of series, shape (k, k), by the lowest cosines, and how many there are.

    Parameters
    ----------
    series : ndarray, shape (n, k)
        At equal intervals, 32 or more.
    """
    n = len(series)
    phase = np.pi * (np.arange(n) + 0.5) / n
    amplitudes = math.sqrt(2.0 / n) * np.cos(np.outer(np.arange(1, COSINES + 1), phase)) @ series
    return np.asarray(amplitudes.T @ amplitudes / COSINES / n), COSINES


def _with_uncertainty(plan: Plan, readings: Readings, given: Inputs, found: Solution, measured: bool) -> Result:
    gain = changes(given)
    keys, values = keys_of(len(readings)), figures(given)
    heading = [at for at, key in enumerate(keys) if key.quantity == HEADING]
    values[heading] = np.remainder(values[heading], 2.0 * math.pi)
    parts = [_scatter(gain["acc"], readings.positions, "acc"), *_stated(plan, readings, given, gain, measured)]
    named: tuple[tuple[Kind, str], ...] = (("accelerometer", "acc"), ("gyro", "gyro"))
    for kind, name in named:
        off = readings.taken_off.get(kind, {})
        wide = gain[name].reshape(len(keys), len(readings), 3)
        parts += components(off, keys, wide)
    stated = len(readings) == 1 and (plan.gyro_bias_u is not None or bool(readings.taken_off.get("gyro")))
    units = ["m/s^2" if key.quantity == EXCESS else "rad/s" if key.quantity in (BIAS, VERTICAL, RATE) else "rad"
             for key in keys]  # fmt: skip

    def made(of_gyro: Sequence[Component]) -> Estimate:
        return Estimate(tuple(keys), values, tuple(units), tuple(one for one in (*of_gyro, *parts) if np.any(one.u)))

    remarks: tuple[Remark, ...] = ()
    whole = made([_scatter(gain["gyro"], readings.positions, "gyro")])
    if stated and (far := _far(whole, given, found)):
        stated, remarks = False, (far,)
    if not stated:
        covariance = gain["gyro"] @ gain["gyro"].T * found.scatter**2
        origin = Origin("rates that the latitude does not explain", level="position")
        whole = made([Component(origin, "A", _even(covariance), float(found.dof), "t")])
    result = Result(plan, readings, given, found, measured, whole, 0.0, stated, remarks)
    across = found.rate * float(whole.u[whole.index(keys[2])])
    return replace(result, bias_u=across)


def _far(whole: Estimate, given: Inputs, found: Solution) -> Remark | None:
    """Return a remark where a stated bias is too small for what is read about the vertical and in level."""
    horizontal = OMEGA * math.cos(given.latitude)
    worst = max(abs(found.vertical) / float(whole.u[whole.index(Key(VERTICAL))]) if found.vertical else 0.0,
                abs(found.rate - horizontal) / float(whole.u[whole.index(Key(RATE))]))  # fmt: skip
    if worst < t_upper(TAIL, float(np.min(whole.dof[[whole.index(Key(RATE)), whole.index(Key(VERTICAL))]]))):
        return None
    off = [f"{per_hour(found.vertical)} about the vertical", f"{per_hour(found.rate - horizontal)} in level"]
    what = f"the gyros read {off[0]} and {off[1]} beyond the rate of the earth: more than the bias that is stated"
    do = "Calibrate the bias anew, or turn the unit half round for a second position: the figures take what is read"
    return Remark("bias_larger", "warning", what, do=do)


def _scatter(gain: Array, positions: Sequence[Position], name: str) -> Component:
    """Return what the noise within records does."""
    size = 3 * len(positions)
    covariance, dof = np.zeros((size, size)), COSINES
    for at, one in enumerate(positions):
        part = slice(3 * at, 3 * at + 3)
        covariance[part, part], dof = long_run(one.acc if name == "acc" else one.gyro)
    words = "accelerometers" if name == "acc" else "gyros"
    return Component(Origin(f"noise of the {words} within records", level="sample"), "A",
                     _even(gain @ covariance @ gain.T), float(dof), "t")  # fmt: skip


def _even(covariance: Array) -> Array:
    return np.asarray(0.5 * (covariance + covariance.T))


def _stated(plan: Plan, readings: Readings, given: Inputs, gain: dict[str, Array], measured: bool) -> list[Component]:
    """Return the sources that plan and standards state, as changes by each of their unknowns."""
    m = len(readings)
    acc, gyro = (gain[name].reshape(-1, m, 3) for name in ("acc", "gyro"))
    found = []
    for source, u, wide in (
        ("bias of the gyros", plan.gyro_bias_u if m == 1 else None, gyro),
        ("bias of the accelerometers", plan.accelerometer_bias_u, acc),
    ):
        if u is not None:
            each = wide.sum(axis=1).T * u
            found.append(Component(Origin(source), "B", each.T @ each, changes=each, unknowns=AXES))
    if plan.deflection_u is not None:
        each = gain["deflection"].T * plan.deflection_u
        found.append(Component(Origin("deflection of the vertical"), "B", each.T @ each, changes=each,
                               unknowns=("north", "east")))  # fmt: skip
    angles = np.array([one.angle for one in readings.positions]).cumsum()
    scale = {f"accelerometer {axis}": acc[:, :, i] @ given.acc[:, i] for i, axis in enumerate(AXES)}
    scale |= {f"gyro {axis}": gyro[:, :, i] @ given.gyro[:, i] for i, axis in enumerate(AXES)}
    if measured:
        scale["gyro z"] = scale["gyro z"] + gain["turns"] @ angles
    entries = [(i, j) for i in range(3) for j in range(3) if i != j]
    crossed = {f"accelerometer {AXES[i]}{AXES[j]}": acc[:, :, i] @ given.acc[:, j] for i, j in entries}
    crossed |= {f"gyro {AXES[i]}{AXES[j]}": gyro[:, :, i] @ given.gyro[:, j] for i, j in entries}
    turned = {} if measured else {str(at + 1): gain["turns"][:, at] for at in range(1, m)}
    excess = np.zeros(len(acc))
    excess[-1] = -1.0
    unknowns: dict[str, tuple[str, dict[str, Array]]] = {
        "sensor.scale_factor": ("scale factors", scale),
        "sensor.misalignment": ("misalignment of the axes", crossed),
        "turn.angle": ("angles of the turns", turned),
        "fixture.mounting": ("mounting", dict(zip(AXES, gain["mounting"].T, strict=True))),
        "site.latitude": ("latitude", {"": gain["latitude"][:, 0]}),
        "gravity.value": ("gravity", {"": excess}),
    }
    for name, (words, each_one) in unknowns.items():
        one = plan.standards.get(name)
        if one is not None and one.u > 0.0 and each_one:
            rows_of = np.array(list(each_one.values())) * one.u
            found.append(Component(one.origin(words), "B", rows_of.T @ rows_of, one.dof, one.distribution, one.stated,
                                   rows_of, tuple(each_one)))  # fmt: skip
    return found
