"""Calibration of an IMU by hand, guided: samples in, what to do next and what is known out; no input or output.

Rest and rotation are judged by the functions that cut a recording (``rests``). After each position the procedure's own
fit is made of all of them (``procedures.positions.reduce``), and the next position is the one that the planner takes:
of the 26 directions of a cube the one after which the variances over the squares of what is wanted are least. Once the
accelerometers are known well enough, and a gyro is not, it is the one that the longest turn about that gyro leads to.

It is enough when the 95 % interval of every wanted figure is no wider than that of the standard uncertainty asked for,
1.96 times it to both sides. With few positions, of which the scatter is badly known, intervals are wide by Student's t,
so that luck with the scatter alone does not end it. ``FREE`` positions more than unknowns are needed at least: who
stops at the first uncertainty that is small enough stops where the scatter happens to look small.

What is assumed: as of the procedure; one power-up, at one temperature. What the uncertainty means is the procedure's.
The live figures are of positions cut as samples came; the final ones are those of the procedure on the recording of
all samples that were ``accepted``, and `Guide.judge` has the last word on whether these are enough.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError, PlanError, UsageError
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.key import AXES
from ...core.recording import SECOND, Times
from ...core.results import Row
from ...core.units import parse_quantity
from ...procedures.positions.plan import Plan
from ...procedures.positions.planning.design import Setup, course, cube, next_position
from ...procedures.positions.planning.planner import limits_of
from ...procedures.positions.readings import local_gravity
from ...procedures.positions.reduction import Result, reduce
from .rests import HELD, MARGIN, LiveRests
from .words import named, turn

FREE = 4  # positions beyond the unknowns, before the fit is believed
UNKNOWNS = 9
WIDE = 1.96  # half of a 95 % interval, standard uncertainties that are known well
UNJUDGED = 3.0  # scatter between positions over the noise of a mean, before the fit shows it
MOST = 100  # positions
GAP = 0.5  # samples that are missing for so long mean that the sensor was not there [s]
THERE = np.cos(np.radians(25.0))  # cosine of the angle from the position asked for that is near enough
SAME = np.cos(np.radians(18.0))  # of two positions that are one
MORE_CURE = ("too_few_positions", "one_plane")  # refusals of a fit that other positions cure
SHOCK = 3.0  # gravities
GYRO_UNITS = {"bias": "rad/s", "scale_factor_error": "1", "misalignment": "rad"}
PAIRS = [a + b for a in AXES for b in AXES if a != b]
WANTED_OF_GYROS = {  # what may be wanted of gyros: its name as of a figure, and its unit
    f"gyro.{own}": (own, unit)
    for quantity, unit in GYRO_UNITS.items()
    for own in (quantity, *(f"{quantity}_{axis}" for axis in (PAIRS if quantity == "misalignment" else AXES)))
}
LONGEST_TURN = np.radians(140.0)  # that a hand makes about the axis that is meant
TURNS = np.radians(20.0)  # what moves, and does not turn by so much, is held in a hand
SHORT = 0.8  # a rest so long that then ends was meant as one [s]


@dataclass(frozen=True)
class Known:
    """A parameter as it is known now, SI."""

    row: Row  # As the procedure has it
    wanted: float | None  # Standard uncertainty asked for; None: none
    ratio: float | None  # Its 95 % interval over that of what is wanted; None: nothing is wanted, or nothing is known

    @property
    def reached(self) -> bool:
        """Whether its interval is no wider than that of what is wanted."""
        return self.ratio is not None and self.ratio <= 1.0


@dataclass(frozen=True)
class Notice:
    """What happened: programs read the code, people the text."""

    code: str
    text: str


@dataclass(frozen=True, eq=False)
class State:
    """What to do, and what is known."""

    # ``lay_down``, ``hold_still``, ``turn``, ``repeated``, ``held_in_hand``, ``unplugged``, ``refused``, ``enough``,
    # ``out_of_reach``
    code: str
    text: str  # The same for people
    positions: int  # That count
    still: bool  # Whether it rests
    rest_left: float | None  # For how long it has to rest yet [s]; None where it need not
    up: tuple[float, float, float] | None  # What points up now, in body axes; None while nobody knows
    target: tuple[float, float, float] | None  # What should point up, in body axes
    known: tuple[Known, ...]  # Empty before the fit can be made
    to_go: int | None  # Positions that the planner would add by the scatter seen so far; None where it cannot say
    notices: tuple[Notice, ...]  # What happened since the state before
    accepted: NDArray[np.bool_]  # shape (n,): which samples of the batch belong to the recording


class Guide:
    """A calibration by hand, in progress.

    Parameters
    ----------
    wanted : mapping of str to str
        Standard uncertainty wanted of an accelerometer quantity or parameter: ``{"bias": "1 mg", "misalignment_yx":
        "0.1 deg"}``. ``bias``, ``scale_factor_error``, ``misalignment``; of gyros, beside them, ``gyro.bias``, ...
    sample_rate : float
        [Hz]
    rest : float
        Shortest rest that counts as a position [s]; the procedure is given the same.
    gravity : float, optional
        Local gravity [m/s^2]; standard gravity by default.
    gravity_u : float
        Its standard uncertainty [m/s^2]; 0: not stated.
    latitude : float, optional
        Geodetic [rad]; with it, gyro biases are without the rate of the earth.
    gyros : bool
        Whether batches hold angular rates.
    labels : mapping of str to str
        What stands on a face of the sensor, by what points up: ``{"z+": "label", "x+": "plug"}``.
    sides : mapping of str to str
        How people call its axes: ``{"x": "its long side"}``.

    Raises
    ------
    UsageError
        ``unknown_name``, ``no_unit``, ``wrong_value`` of what is wanted.
    PlanError
        ``target_not_reached`` where the uncertainty of gravity alone is larger than what is wanted.
    """

    def __init__(
        self,
        wanted: Mapping[str, str],
        sample_rate: float,
        *,
        rest: float = 3.0,
        gravity: float | None = None,
        gravity_u: float = 0.0,
        latitude: float | None = None,
        gyros: bool = True,
        labels: Mapping[str, str] | None = None,
        sides: Mapping[str, str] | None = None,
    ) -> None:
        standards = {"gravity.value": Influence(gravity_u, "m/s^2")} if gravity_u else {}
        self.plan = Plan(gravity=gravity, latitude=latitude, shortest=rest, standards=standards)
        self._setup = Setup(1e-3, gravity=local_gravity(self.plan), gravity_u=gravity_u)
        of_gyros = {name: said for name, said in wanted.items() if name in WANTED_OF_GYROS}
        self.wanted = limits_of(
            self._setup, {k: v for k, v in wanted.items() if k not in of_gyros}, {"target": "wanted"}
        )
        if not self.wanted:
            do = 'Say it like {"bias": "1 mg"}'
            raise UsageError("nothing wanted of the accelerometers", do=do, code="wrong_value")
        self.wanted_gyros = _limits_of_gyros(of_gyros, gyros)
        course(replace(self._setup, scatter=1e-9), self.wanted)
        self._rests = LiveRests(self.plan, 1.0 / sample_rate, gyros)
        self._labels, self._sides, self._gyros = labels or {}, sides or {}, gyros
        self._last: int | None = None
        self._result: Result | None = None
        self._figures: tuple[Known, ...] = ()
        self._refusal = ""
        self._target: Array | None = None
        self._to_go: int | None = None
        self._more = 0  # positions that are needed at least
        self._unplugged = self._out_of_reach = False

    @property
    def settings(self) -> dict[str, Any]:
        """What `inertialcal.positions` is called with on the recording, whose channels have units: the same plan."""
        said: dict[str, Any] = {
            "gravity": f"{local_gravity(self.plan)!r} m/s2",
            "shortest": f"{self.plan.shortest!r} s",
        }
        if self.plan.latitude is not None:
            said["latitude"] = f"{self.plan.latitude!r} rad"
        if self._setup.gravity_u:
            said["standards"] = {"gravity.value": f"{self._setup.gravity_u!r} m/s2"}
        return said

    @property
    def result(self) -> Result | None:
        """Fit of the positions so far; None before there is one."""
        return self._result

    @property
    def bytes_kept(self) -> int:
        """Memory that samples take."""
        return self._rests.bytes_kept

    def add(self, time_ns: Times, force: ArrayLike, rate: ArrayLike | None = None) -> State:
        """Take samples, and say what to do.

        Parameters
        ----------
        time_ns : ndarray of int64, shape (n,)
            Stamps [ns]. Samples that are not later than the one before are not accepted.
        force : array_like, shape (n, 3)
            Specific force [m/s^2].
        rate : array_like, shape (n, 3), optional
            Angular rate [rad/s]; needed where there are gyros.

        Raises
        ------
        DataError
            ``wrong_shape`` if the arrays do not fit each other.
        """
        stamps = np.asarray(time_ns, dtype=np.int64)
        parts = [np.asarray(one, dtype=np.float64) for one in (force, rate) if one is not None]
        if len(parts) != 1 + self._gyros or any(one.shape != (len(stamps), 3) for one in parts):
            shapes = ", ".join(str(one.shape) for one in parts)
            need = "force and rate" if self._gyros else "force alone"
            what = f"samples of shape {shapes} with {len(stamps)} stamps"
            raise DataError(what, why=f"need {need}, (n, 3) each", code="wrong_shape")
        values = np.hstack(parts)
        before = np.iinfo(np.int64).min if self._last is None else self._last
        latest = np.concatenate([[before], np.maximum.accumulate(np.concatenate([[before], stamps]))[1:-1]])
        accepted = np.asarray(stamps > latest[: len(stamps)], dtype=np.bool_)
        notices = []
        if not accepted.all():
            late = int(np.sum(~accepted))
            notices.append(Notice("late_samples", f"{late} samples came twice or late: left out"))
        stamps, values = stamps[accepted], values[accepted]
        if len(stamps):
            notices += self._taken(stamps, values)
        return self._said(notices, accepted)

    def silent(self, now_ns: int) -> State:
        """Say what to do when no sample has come up to a time of the same clock [ns]."""
        if self._last is not None and now_ns - self._last > GAP * SECOND:
            self._unplugged = True
        return self._said([], np.zeros(0, dtype=np.bool_))

    def judge(self, rows: Sequence[Row]) -> State:
        """Say whether the figures of the procedure on the recording are enough; if not, ask for one position more."""
        asked = [one for one in self.known(rows) if one.wanted is not None]
        if not asked or not all(one.reached for one in asked):
            self._more = self._count() + 1
            self._choose()
        return self._said([], np.zeros(0, dtype=np.bool_))

    def undo(self) -> tuple[int, State] | None:
        """Forget the last position, and all that came since it began.

        Returns
        -------
        (int, State) or None
            Stamp at which the position began [ns]: samples from it on, up to the last that was added, do not belong to
            the recording; what to do now. None where there is no position.
        """
        began = self._rests.undo()
        if began is None:
            return None
        self._fit()
        self._choose()
        text = f"Taken back: {self._count()} positions count. Lay it as it should lie"
        return began, self._said([Notice("taken_back", text)], np.zeros(0, dtype=np.bool_))

    def _count(self) -> int:
        return 0 if self._rests.readings is None else len(self._rests.readings)

    def _taken(self, stamps: Times, values: Array) -> list[Notice]:
        """Take samples in order of time, parted where some are missing for long."""
        notices = []
        last = stamps[:1] - 1 if self._last is None else np.array([self._last])
        steps = np.diff(np.concatenate([last, stamps]))
        self._unplugged = False
        for part in np.split(np.arange(len(stamps)), np.flatnonzero(steps > GAP * SECOND)):
            if not len(part):
                continue
            if steps[part[0]] > GAP * SECOND:
                gone = float(steps[part[0]] / SECOND)
                text = f"The sensor was not there for {gone:.0f} s. What was measured before counts"
                notices.append(Notice("was_unplugged", text))
                self._rests.part()
            notices += self._next(stamps[part], values[part])
        self._last = int(stamps[-1])
        return notices

    def _next(self, stamps: Times, values: Array) -> list[Notice]:
        """Take samples without a gap."""
        notices, g = [], local_gravity(self.plan)
        largest = float(np.nanmax(np.linalg.norm(values[:, :3], axis=1), initial=0.0)) / g
        if largest > SHOCK:
            text = f"It was knocked or dropped ({largest:.0f} g). If it is whole, lay it down again and go on"
            notices.append(Notice("shock", text))
        before = self._count()
        if self._rests.add(stamps, values):
            self._fit()
            if self._count() != before:
                self._choose()
        broken = self._rests.now.broken
        if SHORT < broken < self._rests.shortest:
            text = f"It lay still for only {broken:.1f} s: leave it for {self._rests.shortest + MARGIN:.1f} s"
            notices.append(Notice("too_short", text))
        return notices

    def _fit(self) -> None:
        """Fit the positions so far as the procedure does."""
        readings = self._rests.readings
        try:
            self._result = None if readings is None else reduce(self.plan, readings)
            self._figures = () if self._result is None else self.known(self._result.rows())
            self._refusal = ""
        except DataError as error:
            self._result, self._figures = None, ()
            problem = error.problems[0]
            self._refusal = "" if problem.code in MORE_CURE else str(problem)

    def _directions(self) -> Array:
        """Return what pointed up in each position, (m, 3)."""
        readings = self._rests.readings
        if readings is None:
            return np.zeros((0, 3))
        if self._result is None:
            return _unit(readings.acc.mean)
        return _unit(self._result.acc.sensor.applied(readings.acc.mean))

    def _choose(self) -> None:
        """Choose the next position, and count how many it will take."""
        readings = self._rests.readings
        inside = 1e-3 if readings is None else float(np.sqrt(np.mean(readings.acc.u**2)))
        scatter = UNJUDGED * max(inside, 1e-6)
        fit = None if self._result is None else self._result.acc
        if fit is not None and fit.between is not None and fit.free >= FREE:
            scatter = float(np.hypot(fit.between, inside))
        setup, taken = replace(self._setup, scatter=scatter), self._directions()
        other = self._target is not None and len(taken) > 0 and taken[-1] @ self._target < THERE
        repeated = other and np.max(taken[:-1] @ taken[-1], initial=-1.0) > SAME
        turned = self._turned_to(taken)
        if not repeated:  # who repeats a position is asked for the same one still
            self._target = next_position(setup, taken, goal=self.wanted) if turned is None else turned
        self._out_of_reach = False
        try:
            to_go = len(course(setup, self.wanted, taken, most=MOST).directions) - len(taken)
            least = max(UNKNOWNS + FREE, self._more) - len(taken)
            self._to_go = max(to_go, least, 1)
        except PlanError:
            self._to_go, self._out_of_reach = None, True

    def _turned_to(self, taken: Array) -> Array | None:
        """Return what should point up next for the gyro that is known worst; None while accelerometers come first."""
        asked = [one for one in self._figures if one.wanted is not None]
        open_ = [one for one in asked if not one.reached]
        if not open_ or not len(taken) or any(one.row.key.sensor != "gyro" for one in open_):
            return None
        worst = max(open_, key=lambda one: (one.row.u or np.inf) / (one.wanted or 1.0)).row.key
        axis, up = np.eye(3)[AXES.index(worst.axis[-1])], taken[-1]  # of a misalignment the axis that is turned about
        candidates = cube()
        if abs(up @ axis) > np.sqrt(0.5):  # nothing turns about what points up, as gravity tells it
            return np.asarray(candidates[np.argmin(np.abs(candidates @ axis))])
        angles = np.arccos(np.clip(candidates @ up, -1.0, 1.0))
        across = np.cross(candidates, up)
        about = angles * np.abs(across @ axis) / np.maximum(np.linalg.norm(across, axis=1), 1e-9)
        return np.asarray(candidates[np.argmax(np.where(angles < LONGEST_TURN, about, 0.0))])

    def known(self, rows: Sequence[Row]) -> tuple[Known, ...]:
        """Return figures of the procedure with what is wanted of them."""
        found = []
        for row in rows:
            limits = {"accelerometer": self.wanted, "gyro": self.wanted_gyros}.get(row.key.sensor, {})
            limit = limits.get(str(row.key._replace(sensor="")), limits.get(row.key.quantity))
            if row.case.beside or row.reason.code == "of_frame":
                limit = None
            ratio = None
            ends = row.interval
            if limit is not None and ends is not None and ends.lo is not None and ends.hi is not None:
                ratio = 0.5 * (ends.hi - ends.lo) / (WIDE * limit)
            found.append(Known(row, limit, ratio))
        return tuple(found)

    def _said(self, notices: list[Notice], accepted: NDArray[np.bool_]) -> State:
        """Return the state as it is now."""
        now, count = self._rests.now, self._count()
        known = self._figures
        asked = [one for one in known if one.wanted is not None]
        free = 0 if self._result is None else self._result.acc.free
        enough = bool(asked) and free >= FREE and count >= self._more and all(one.reached for one in asked)
        up = None if now.level is None else _unit(self._calibrated(now.level)[None])[0]
        left = None
        if now.still:
            left = 0.0 if now.counts else max(self._rests.shortest + MARGIN - now.since, 0.5)
        code, text = self._instruction(enough, up, left)
        return State(
            code, text, count, now.still, left, _triple(up), _triple(self._target), known,
            0 if enough else self._to_go, tuple(notices), accepted,
        )  # fmt: skip

    def _instruction(self, enough: bool, up: Array | None, left: float | None) -> tuple[str, str]:
        """Return what to do now."""
        now = self._rests.now
        far = f"More than {MOST} positions would be needed: the readings scatter too much for what is wanted"
        first = (
            (self._unplugged, "unplugged",
             "The sensor sends nothing: plug it in again. What was measured so far counts"),
            (bool(self._refusal), "refused", self._refusal),
            (enough, "enough", "Enough: every figure is known as well as was asked for"),
            (self._out_of_reach and self._count() >= UNKNOWNS + FREE, "out_of_reach",
             f"{far}. Rest it on something firmer, and longer; or ask for less"),
            (not now.still and now.since > HELD and now.wanders < TURNS, "held_in_hand",
             "It is never quite still: put it on a table or against a wall, and take the hand away"),
        )  # fmt: skip
        return next(((code, text) for so, code, text in first if so), None) or self._move(up, left)

    def _move(self, up: Array | None, left: float | None) -> tuple[str, str]:
        """Return how to lay it, or for how long to leave it."""
        target = self._target
        if up is None or target is None:
            if left:
                return "hold_still", f"Good. Leave it as it lies for {max(left, 1.0):.0f} s more"
            return "lay_down", "Lay the sensor on a table and leave it"
        if left is None:
            return "turn", f"Lay it {named(target, self._labels)}, and leave it"
        how = turn(up, target, self._labels, self._sides)
        if left == 0.0:
            return "turn", how
        if up @ target < THERE and np.max(self._directions() @ up, initial=-1.0) > SAME:
            return "repeated", f"You have shown this position already. {how}"
        other = "" if up @ target >= THERE else "Not the position that was asked for, but a new one: it counts. "
        return "hold_still", f"{other}Leave it as it lies for {max(left, 1.0):.0f} s more"

    def _calibrated(self, level: Array) -> Array:
        return level if self._result is None else np.asarray(self._result.acc.sensor.applied(level[None]))[0]


def _limits_of_gyros(wanted: Mapping[str, str], gyros: bool) -> dict[str, float]:
    """Return the uncertainty wanted of gyros by parameter or quantity, SI."""
    found = {}
    for name, said in wanted.items():
        own, unit = WANTED_OF_GYROS[name]
        if not gyros:
            raise UsageError(f"wanted {name!r}: there are no gyros", do="Leave it out", code="unknown_name")
        try:
            found[own] = parse_quantity(said).to(unit)
        except DataError as error:
            usual = {"rad/s": "0.1 deg/s", "1": "0.1 %", "rad": "0.1 deg"}[unit]
            do = f'Write it like {name}="{usual}"'
            raise UsageError(f"{name}: {said!r}", why=error.problems[0].what, do=do, code="no_unit") from None
        if not 0.0 < found[own] < np.inf:
            raise UsageError(f"{name}: {said!r}: need more than 0", code="wrong_value")
    return found


def _unit(force: Array) -> Array:
    return np.asarray(force / np.maximum(np.linalg.norm(force, axis=-1, keepdims=True), 1e-9))


def _triple(one: Array | None) -> tuple[float, float, float] | None:
    return None if one is None else (float(one[0]), float(one[1]), float(one[2]))
