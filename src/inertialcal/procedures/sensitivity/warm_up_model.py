"""Warm-up of a sensor from several power-ups together: exponentials with common times, settled levels of their own.

::

    y = level of its power-up + sum_j (w_j + v_j (T_start - T_ref)) exp(-t / tau_j)
        + sum_k c_k (T^k - T_start^k) + noise

``t`` is the time since power-up. The times ``tau_j`` are common to all axes and power-ups, as the sensor equation has
them; amplitudes ``w_j`` are those of an axis. ``v_j`` is there where four power-ups or more start from temperatures
that lie apart, whichever of them is left out: not where they show it, since a term that is told only where it looks
large is too large where it is told. ``c_k`` is there where a temperature was recorded and moves, unless a thermal model
has been taken off before; with as many powers as there are starting temperatures, up to three, since a unit that heats
itself changes its bias by the slope that its law has there.
Least squares over means of stretches that lengthen with time, each with the weight of its
samples; the ``tau_j`` are found by a search over their logarithms.

What is assumed: power-ups are independent; the noise within one may be of any colour. What the uncertainty means: how
far power-ups disagree, as the sandwich by power-up (CR2) of the fit made linear at its ``tau_j``, with Satterthwaite's
degrees of freedom and Student's t.

*Is there a warm-up?* Not judged by the fit, whose best ``tau`` would find one in any noise: for two fixed time
constants the amplitude is tested by Student's t over power-ups, with Bonferroni's correction for axes and times;
5 % of all tests without a warm-up find one (``FALSE_ALARM``). If there is none: an upper limit.

*One exponential or two?* Each power-up is predicted from the others, its level alone being its own. Two are taken where
the second lowers what is left of the power-ups held out, by Student's t over them.

Three ways in which real records break this: (1) the temperature moves as the warm-up does (self-heating): only a
thermal model can tell the two apart, the amplitude becomes uncertain and is given as an upper limit
(``temperature_moves``); without a temperature channel it cannot be seen (``no_temperature``); (2) the warm-up outlasts
the record: no amplitude and no time is given (``warm_up_long``); (3) a power-up was a restart of a warm unit: its
amplitude is too small (``power_up_differs``).

References
----------
.. [1] IEEE Std 1431-2004, 12.6 (warm-up) and 12.5 (turn-on).
.. [2] V. V. Badescu, NPS thesis, 2011, Table 14: warm-up of 5 min.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.key import Key, Origin, Reason
from ...core.remarks import Remark, Severity
from ...core.units import normalise
from ...statistics.clustered import clustered_covariance
from ...statistics.intervals import coverage_factor
from ...statistics.least_squares import fit
from .plan import START_TEMPERATURE

FEWEST = 12  # stretches of a power-up that the unknowns need
LENGTHENS = 1.05  # end of a stretch over its start
SEARCHED = (0.005, 1.0)  # of the length of the record: times that are looked for
GRID = 236  # of them that are tried
COARSE = 5  # of the grid, in pairs of times
NEGLIGIBLE = 1e-4  # of the squares of the warm-up: a second exponential that lowers what is left by less is none
APART = 2.0  # ratio of two times below which one exponential cannot be told from two
RESOLVED = 0.6  # of the length of the record: longest time that level and amplitude can be told apart with
FALSE_ALARM = 0.05  # of the test for a warm-up
SHAPES = (0.03, 0.2)  # of the length of the record: times that the test looks with
MOVES = 2.0  # scatter of a temperature over its noise, above which it moves
DEPENDS = 4  # power-ups that show how the amplitude depends on the starting temperature
WITHIN = 10.0  # starting temperatures that lie no further apart are one [degC]
MOST_POWERS = 3  # of the temperature
FIRST = 300.0  # first minutes after a power-up, of which residuals are told [s]
FEW_RUNS = 5  # with fewer, an interval is honest but wide
SEEN = 6.0  # deviation of an amplitude over its noise, above which a power-up is named
DIFFERENT = 0.01  # level of the test for axes that differ
SCATTER = Origin("scatter between power-ups", level="run")
ALONE = 0.5  # share of the amplitude of the others, below which a power-up is a warm restart
SHORT = Reason("warm_up_long", "still moving at the end of the record")
FEW = Reason("one_run", "one power-up: how far power-ups differ is not known")

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class PowerUps:
    """Readings of one sensor after power-up, in one unit."""

    axes: tuple[str, ...]
    unit: str  # Of the readings
    time: Array  # shape (n,): since the power-up of each [s]
    readings: Array  # shape (n, k)
    run: NDArray[Any]  # shape (n,): number of the power-up
    temperature: Array | None = None  # shape (n, k) [degC]; None where it was not recorded
    thermal_model: bool = False  # Whether the bias over temperature has been taken off
    labels: tuple[str, ...] = ()  # Of the power-ups, in order of their number


@dataclass(frozen=True, eq=False)
class Stretches:
    """Means over stretches of time, in order of power-up and time."""

    time: Array  # shape (s,): middle of each [s]
    width: Array  # shape (s,): from its first sample to its last [s]
    weight: Array  # shape (s,): samples
    readings: Array  # shape (s, k)
    temperature: Array  # shape (s, k, p): its powers less those of the start [degC^p]; p = 0 where it does not move
    run: Indices  # shape (s,): 0 to R - 1
    start: Array  # shape (R,): temperature at power-up [degC]; NaN where not known
    moves: float  # Largest range of the temperature of a power-up [degC]; 0 where it rests or is not known
    length: float  # From power-up to the end of the shortest [s]

    @property
    def runs(self) -> int:
        """Number of power-ups."""
        return len(self.start)


@dataclass(frozen=True, eq=False)
class HeldOutRun:
    """What is left of a power-up in its first minutes, predicted from the others: root mean squares."""

    label: str
    with_model: Array  # shape (k,) [unit of the readings]
    without: Array  # shape (k,): less its settled level alone


@dataclass(frozen=True, eq=False)
class WarmUpModel:
    """Joint warm-up of all axes of a sensor."""

    power_ups: PowerUps
    stretches: Stretches
    reference_temperature: float | None  # Of the dependence on the starting temperature [degC]
    times: tuple[float, ...]  # tau_j, ascending [s]; those of the best fit where nothing is given
    amplitudes: Array  # shape (m, k): w_j
    slopes: Array | None  # shape (m, k): v_j; None where the power-ups start alike
    levels: Array  # shape (R, k): settled readings
    by_temperature: Array  # shape (p, k): c_k; p = 0 where it is not fitted
    p_value: float  # Of no warm-up
    reason: Reason  # Why nothing is given; none where it is
    limits: Array  # shape (k,): largest amplitude that is compatible with the readings; NaN where not known
    estimate: Estimate | None  # Of times, amplitudes and slopes
    held_out: tuple[HeldOutRun, ...]
    remarks: tuple[Remark, ...] = field(default=())

    @property
    def parameters(self) -> tuple[Key, ...]:
        """Keys of the estimate that are parameters of the sensor model."""
        return () if self.estimate is None else tuple(
            key for key in self.estimate.keys if key.quantity in {"bias_warm_up", "warm_up_time"}
        )  # fmt: skip

    def of_temperature(self, means: Stretches, axis: int) -> Array:
        """Return what the temperature does to an axis, shape (s,) [unit of the readings]."""
        return np.asarray(means.temperature[:, axis] @ self.by_temperature[:, axis])

    def at(self, time: Array, axis: int, start: float | None = None) -> Array:
        """Return the warm-up of an axis at times since power-up, for a starting temperature [unit of the readings]."""
        amplitudes = self.amplitudes[:, axis]
        if self.slopes is not None and self.reference_temperature is not None and start is not None:
            amplitudes = amplitudes + self.slopes[:, axis] * (start - self.reference_temperature)
        return np.asarray(np.exp(-time[:, None] / np.asarray(self.times)) @ amplitudes)


def warm_up_model(power_ups: PowerUps, reference_temperature: float | None = None, first: float = FIRST) -> WarmUpModel:
    """Return the joint warm-up of all axes over all power-ups.

    Parameters
    ----------
    power_ups : PowerUps
        Readings at rest, earth rate included.
    reference_temperature : float, optional
        Starting temperature that the amplitudes are told for [degC]; the mean of the power-ups by default.
    first : float
        First part after a power-up whose residuals are told [s].

    Raises
    ------
    DataError
        ``no_recordings`` without a power-up; ``too_few_readings`` if one is too short to be fitted.
    """
    means = stretches_of(power_ups)
    known = bool(np.isfinite(means.start).all())
    middle = reference_temperature
    if known and middle is None:
        middle = float(means.start.mean())
    away = means.start - middle if known and middle is not None else np.zeros(means.runs)
    one = _Problem(means, np.zeros(means.runs))
    p_value, limits = _tested(one)
    depends = _carried(means.start) > 1
    used = _Problem(means, away) if depends else one
    if depends:
        p_value = min(1.0, 2.0 * min(p_value, _tested(used, slope=True)[0]))
    count, costs = _chosen(used)
    solved = used.solved(count)
    reason = _why_not(means, solved, p_value, used)
    estimate = _estimate(power_ups, solved, depends) if not reason else None
    held = tuple(_held_out(used, costs, power_ups, first)) if means.runs > 1 else ()
    found = WarmUpModel(
        power_ups,
        means,
        middle,
        solved.times,
        solved.amplitudes,
        solved.slopes,
        solved.levels,
        solved.by_temperature,
        p_value,
        reason,
        limits,
        estimate,
        held,
    )
    return replace(found, remarks=tuple(_remarks(found, used, solved)))


def _carried(starts: Array) -> int:
    """Return how many starting temperatures lie apart whichever power-up is left out; 1 where one is not known."""
    if len(starts) < DEPENDS or not np.isfinite(starts).all():
        return 1
    counts = []
    for r in range(len(starts)):
        count, last = 0, -math.inf
        for one in np.sort(np.delete(starts, r)):
            if one - last > WITHIN:
                count, last = count + 1, float(one)
        counts.append(count)
    return min(counts)


def stretches_of(power_ups: PowerUps, powers: int | None = None) -> Stretches:
    """Return the means over stretches that lengthen with the time since power-up.

    Parameters
    ----------
    powers : int, optional
        Of the temperature; as many as the starting temperatures carry by default, none where it rests.

    Raises
    ------
    DataError
        As `warm_up_model`.
    """
    numbers = np.unique(power_ups.run)
    if not len(numbers):
        raise DataError("no power-up was read", code="no_recordings")
    parts: list[tuple[Array, ...]] = []
    starts, moves, lengths = [], [], []
    for r, number in enumerate(numbers):
        own = np.flatnonzero(power_ups.run == number)
        finite = np.isfinite(power_ups.readings[own]).all(axis=1) & np.isfinite(power_ups.time[own])
        own = own[finite & (power_ups.time[own] >= 0.0)]
        own = own[np.argsort(power_ups.time[own], kind="stable")]
        t = power_ups.time[own]
        cut = _cuts(t)
        if len(cut) < FEWEST:
            label = power_ups.labels[r] if power_ups.labels else str(number)
            what = f"power-up {label}: {len(own)} readings after it make {len(cut)} means, need {FEWEST}"
            raise DataError(what, why="a warm-up cannot be fitted", do="Record longer", code="too_few_readings")
        size = np.diff(np.append(cut, len(t))).astype(float)

        def means(values: Array, cut: Indices = cut, size: Array = size) -> Array:
            return np.asarray(np.add.reduceat(values, cut, axis=0) / (size[:, None] if values.ndim > 1 else size))

        y = means(power_ups.readings[own])
        warm = np.zeros_like(y)
        start = math.nan
        if power_ups.temperature is not None and np.isfinite(power_ups.temperature[own]).all():
            warm = means(power_ups.temperature[own])
            start = float(warm[0].mean())
        last = np.append(cut[1:], len(t)) - 1
        parts.append((means(t), t[last] - t[cut], size, y, warm, np.full(len(cut), r, dtype=float)))
        starts.append(start)
        moves.append(_moved(warm))
        lengths.append(float(t[-1]))
    time, width, weight, y, warm, run = (np.concatenate(column) for column in zip(*parts, strict=True))
    moved = 0.0 if power_ups.thermal_model else max(moves)
    first = np.searchsorted(run, run)  # of the power-up of each
    began = np.array(starts)
    if powers is None:
        powers = min(_carried(began), MOST_POWERS) if moved else 0
    exponents = np.arange(1, powers + 1)
    temperature = warm[:, :, None] ** exponents - warm[first][:, :, None] ** exponents
    return Stretches(time, width, weight, y, temperature, run.astype(np.intp), began, moved, min(lengths))


def _cuts(time: Array) -> Indices:
    """First sample of each stretch: one sample at first, later a twentieth of the time since power-up."""
    found, at = [], 0
    while at < len(time):
        found.append(at)
        step = time[1] - time[0] if len(time) > 1 else 1.0
        at = max(int(np.searchsorted(time, time[at] + max((LENGTHENS - 1.0) * time[at], 0.5 * step))), at + 1)
    return np.array(found, dtype=np.intp)


def _moved(warm: Array) -> float:
    """Range of a temperature that moves by more than its noise [degC]; 0 where it rests."""
    spread = np.std(warm, axis=0)
    noise = np.sqrt(np.mean(np.diff(warm, axis=0) ** 2, axis=0) / 2.0)
    moving = spread > MOVES * noise
    return float(np.max(np.ptp(warm, axis=0)[moving])) if moving.any() else 0.0


@dataclass(frozen=True, eq=False)
class _Solved:
    """Least squares of all axes at the best times."""

    times: tuple[float, ...]
    amplitudes: Array  # (m, k)
    slopes: Array | None  # (m, k)
    by_temperature: Array  # (p, k)
    levels: Array  # (R, k)
    covariance: Array | None  # of times, then of each axis its amplitudes and slopes; None with one power-up
    dof: Array
    values: Array


class _Problem:
    """Sums over power-ups of every product that the fits need, at the times of a grid."""

    def __init__(self, means: Stretches, away: Array) -> None:
        self.means, self.away = means, away
        self.runs, self.axes = means.runs, means.readings.shape[1]
        self.sloped, self.powers = bool(np.any(away)), means.temperature.shape[2]
        lowest, highest = (math.log(share * means.length) for share in SEARCHED)
        self.grid = np.exp(np.linspace(lowest, highest, GRID))
        self.root = np.sqrt(means.weight)
        self.y = self.within(means.readings)
        self.scale = self._noise()
        shapes = self.within(self.shapes(self.grid))
        columns = np.hstack([shapes, shapes * away[means.run][:, None]]) if self.sloped else shapes
        self.gram = []  # of each axis, (R, p, p), with p columns and the readings last
        for a in range(self.axes):
            rows = np.column_stack([columns, self.temperature(a), self.y[:, a] / self.scale[a]])
            self.gram.append(np.array([rows[means.run == r].T @ rows[means.run == r] for r in range(self.runs)]))

    def shapes(self, times: Array) -> Array:
        """Means of exponentials over the stretches, shape (s, g)."""
        half = 0.5 * self.means.width[:, None] / times
        over = np.divide(np.sinh(half), half, out=np.ones_like(half), where=half > 1e-6)
        return np.asarray(np.exp(-self.means.time[:, None] / times) * over)

    def within(self, columns: Array) -> Array:
        """Columns less their mean of each power-up, weighted."""
        means = self.means
        total = np.bincount(means.run, means.weight)
        sums = np.column_stack([np.bincount(means.run, means.weight * one) for one in columns.T])
        return np.asarray((columns - (sums / total[:, None])[means.run]) * self.root[:, None])

    def temperature(self, axis: int) -> Array:
        """Columns of the temperature of an axis, shape (s, p)."""
        warm = self.means.temperature[:, axis]
        return self.within(warm) if warm.shape[1] else warm

    def _noise(self) -> Array:
        """Scatter of a sample of each axis, from neighbouring stretches."""
        same = np.diff(self.means.run) == 0
        steps = np.diff(self.means.readings, axis=0)[same]
        weight = 1.0 / (1.0 / self.means.weight[1:] + 1.0 / self.means.weight[:-1])[same]
        noise = np.sqrt(np.mean(steps**2 * weight[:, None], axis=0))
        whole = float(np.max(noise, initial=0.0))
        return np.maximum(noise, 1e-6 * whole) if whole > 0.0 else np.ones_like(noise)

    def candidates(self, count: int) -> Indices:
        """Places of the grid that are tried together, shape (c, count)."""
        if count == 1:
            return np.arange(GRID)[:, None]
        apart = math.ceil(math.log(APART) / math.log(self.grid[1] / self.grid[0]))
        pairs = [(i, j) for i in range(0, GRID, COARSE) for j in range(0, GRID, COARSE) if j - i >= apart]
        return np.array(pairs, dtype=np.intp)

    def best(self, runs: Indices, count: int, axes: Sequence[int] = ()) -> tuple[Indices, list[Array]]:
        """Return the places of the best times over some power-ups, and the coefficients of each axis, or of some."""
        tried = self.candidates(count)
        columns = np.hstack([tried, tried + GRID]) if self.sloped else tried
        total, solutions = np.zeros(len(tried)), []
        for a in axes or range(self.axes):
            whole = self.gram[a][runs].sum(axis=0)
            extra = np.arange(GRID * (2 if self.sloped else 1), len(whole) - 1)
            at = np.hstack([columns, np.broadcast_to(extra, (len(tried), len(extra)))])
            normal = whole[at[:, :, None], at[:, None, :]]
            size = np.sqrt(np.maximum(np.einsum("cii->ci", normal), 1e-300))
            normal = normal / size[:, :, None] / size[:, None, :] + 1e-10 * np.eye(at.shape[1])
            right = whole[at, -1] / size
            solution = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
            total -= np.einsum("ci,ci->c", solution, right)
            solutions.append(solution / size)
        i = int(np.argmin(total))
        return tried[i], [one[i] for one in solutions]

    def left_of(self, run: int, places: Indices, coefficients: Sequence[Array], axes: Sequence[int] = ()) -> float:
        """Sum of squares that is left of a power-up, its level its own."""
        left = 0.0
        columns = np.concatenate([places, places + GRID]) if self.sloped else places
        for a, b in zip(axes or range(self.axes), coefficients, strict=True):
            own = self.gram[a][run]
            at = np.concatenate([columns, np.arange(GRID * (2 if self.sloped else 1), len(own) - 1)])
            left += float(own[-1, -1] - 2.0 * b @ own[at, -1] + b @ own[np.ix_(at, at)] @ b)
        return left

    def predicted(self, run: int, places: Indices, coefficients: Sequence[Array]) -> tuple[Array, Array]:
        """Return warm-up and effect of the temperature on each axis of a power-up, each shape (s, k)."""
        own = self.means.run == run
        shapes, m = self.shapes(self.grid[places])[own], len(places)
        curve = np.zeros((int(own.sum()), self.axes))
        warm = np.zeros_like(curve)
        for a, b in enumerate(coefficients):
            amplitude = b[:m] + (self.away[run] * b[m : 2 * m] if self.sloped else 0.0)
            curve[:, a] = shapes @ amplitude * self.scale[a]
            warm[:, a] = self.means.temperature[own, a] @ b[len(b) - self.powers :] * self.scale[a]
        return curve, warm

    def design(self, axis: int, times: Array) -> Array:
        """Columns of one axis at some times: exponentials, those by starting temperature, temperature."""
        shapes = self.within(self.shapes(times))
        sloped = [shapes * self.away[self.means.run][:, None]] if self.sloped else []
        return np.hstack([shapes, *sloped, self.temperature(axis)])

    def solved(self, count: int) -> _Solved:
        """Return the fit of all power-ups with so many exponentials."""
        places, _ = self.best(np.arange(self.runs), count)

        def left(logs: Array) -> float:
            times = np.exp(np.clip(logs, math.log(self.grid[0]), math.log(self.grid[-1])))
            total = 0.0
            for a in range(self.axes):
                basis = np.linalg.qr(self.design(a, times))[0]
                y = self.y[:, a] / self.scale[a]
                total += float(y @ y - np.sum((basis.T @ y) ** 2))
            return total

        logs = np.log(self.grid[places])
        if count == 1:
            step = math.log(self.grid[1] / self.grid[0])
            found = optimize.minimize_scalar(
                lambda q: left(np.array([q])), bounds=(logs[0] - step, logs[0] + step), method="bounded",
                options={"xatol": 1e-6},
            )  # fmt: skip
            logs = np.array([found.x])
        else:
            logs = optimize.minimize(left, logs, method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-9}).x
        return self._linear(np.exp(np.sort(np.clip(logs, np.log(self.grid[0]), np.log(self.grid[-1])))))

    def _linear(self, times: Array) -> _Solved:
        """Return coefficients at these times, and the covariance of the fit made linear there."""
        m, k, n = len(times), self.axes, len(self.root)
        blocks = [self.design(a, times) for a in range(k)]
        solutions = [np.linalg.lstsq(X, self.y[:, a], rcond=None)[0] for a, X in enumerate(blocks)]
        step = 1e-5
        slopes = [
            (self.shapes(times * np.exp(step * np.eye(m)[j])) - self.shapes(times * np.exp(-step * np.eye(m)[j])))
            / (2.0 * step * times[j]) for j in range(m)
        ]  # fmt: skip
        q = blocks[0].shape[1]
        whole = np.zeros((k * n, m + k * q))
        for a, (X, b) in enumerate(zip(blocks, solutions, strict=True)):
            rows = slice(a * n, (a + 1) * n)
            amplitude = b[:m] + (np.outer(self.away, b[m : 2 * m])[self.means.run] if self.sloped else 0.0)
            for j in range(m):
                along = amplitude[:, j] if self.sloped else amplitude[j]
                whole[rows, j] = self.within((slopes[j][:, j] * along)[:, None])[:, 0] / self.scale[a]
            whole[rows, m + a * q : m + (a + 1) * q] = X / self.scale[a]
        per_axis = np.array(solutions)  # (k, q)
        values = np.concatenate([times, per_axis.ravel()])
        covariance, dof = None, np.zeros(len(values))
        if self.runs > 1:
            residual = np.concatenate([(self.y[:, a] - X @ b) / self.scale[a]
                                       for a, (X, b) in enumerate(zip(blocks, solutions, strict=True))])  # fmt: skip
            covariance, dof = _sandwich(whole, residual, np.tile(self.means.run, k))
        means = self.means
        curve = np.zeros_like(means.readings)
        shapes = self.shapes(times)
        for a, b in enumerate(solutions):
            amplitude = b[:m] + (np.outer(self.away, b[m : 2 * m])[means.run] if self.sloped else 0.0)
            curve[:, a] = np.sum(shapes * amplitude, axis=1)
            curve[:, a] += means.temperature[:, a] @ b[len(b) - self.powers :]
        total = np.bincount(means.run, means.weight)
        levels = np.column_stack([
            np.bincount(means.run, means.weight * (means.readings - curve)[:, a]) / total for a in range(k)
        ])  # fmt: skip
        return _Solved(
            tuple(times.tolist()),
            per_axis[:, :m].T,
            per_axis[:, m : 2 * m].T if self.sloped else None,
            per_axis[:, q - self.powers :].T,
            levels,
            covariance,
            dof,
            values,
        )


def _sandwich(design: Array, residual: Array, clusters: Indices) -> tuple[Array | None, Array]:
    """CR2 of a fit whose residuals are known; None where its columns cannot be told apart."""
    try:
        found = fit(design, residual)
    except DataError:
        return None, np.zeros(design.shape[1])
    return clustered_covariance(found, clusters)


def _smallest_p(values: Array, u: Array, dof: Array) -> float:
    """Return the p value of all being zero, by Student's t, after Bonferroni."""
    known = (u > 0.0) & (dof > 0.0)
    if not known.any():
        return 1.0
    p = 2.0 * special.stdtr(dof[known], -np.abs(values[known]) / u[known])
    return float(min(1.0, len(values) * p.min()))


def _tested(problem: _Problem, *, slope: bool = False) -> tuple[float, Array]:
    """Return the p value of no warm-up, and the largest amplitude of each axis that the readings allow."""
    if problem.runs < 2:
        return 1.0, np.full(problem.axes, np.nan)
    values, us, dofs = [], [], []
    for share in SHAPES:
        for a in range(problem.axes):
            X = problem.design(a, np.array([share * problem.means.length]))
            b = np.linalg.lstsq(X, problem.y[:, a], rcond=None)[0]
            covariance, dof = _sandwich(X, problem.y[:, a] - X @ b, problem.means.run)
            at = 1 if slope else 0
            values.append(float(b[at]))
            us.append(0.0 if covariance is None else math.sqrt(float(covariance[at, at])))
            dofs.append(float(dof[at]))
    p_value = _smallest_p(np.array(values), np.array(us), np.array(dofs))
    limits = [
        abs(v) + coverage_factor(d) * u if d > 0.0 and u > 0.0 else math.nan
        for v, u, d in zip(values, us, dofs, strict=True)
    ]
    return p_value, np.max(np.array(limits).reshape(len(SHAPES), -1), axis=0)


def _chosen(problem: _Problem) -> tuple[int, list[tuple[Indices, list[Array]]]]:
    """Return the number of exponentials, and the fit of all power-ups but one, for each."""
    runs = np.arange(problem.runs)
    if problem.runs < 2:
        return 1, []
    fits = {m: [problem.best(np.delete(runs, r), m) for r in runs] for m in (1, 2)}
    costs = {m: np.array([problem.left_of(int(r), *fits[m][r]) for r in runs]) for m in fits}
    gain = costs[1] - costs[2]
    u = float(gain.std(ddof=1)) / math.sqrt(len(gain))
    whole = sum(float(gram[:, -1, -1].sum()) for gram in problem.gram) - float(costs[1].sum())
    better = gain.sum() > NEGLIGIBLE * max(whole, 0.0) and (
        u == 0.0 or special.stdtr(len(gain) - 1.0, -gain.mean() / u) < FALSE_ALARM
    )
    count = 2 if better else 1
    return count, fits[count]


def _why_not(means: Stretches, solved: _Solved, p_value: float, problem: _Problem) -> Reason:
    """Return the reason why no amplitude and no time is given; none where they are."""
    if means.runs < 2:
        return FEW
    if p_value >= FALSE_ALARM:
        if means.moves and _tested_bare(problem) < FALSE_ALARM:
            what = "the temperature moves as the readings do: their warm-up cannot be told from a bias over temperature"
            return Reason("temperature_moves", what)
        return Reason("no_transient", "no warm-up above what power-ups differ by")
    if solved.times[-1] > RESOLVED * means.length:
        what = f"{SHORT.text}: the slowest time is {RESOLVED:g} of its {means.length:.4g} s or more"
        return Reason(SHORT.code, what)
    if solved.covariance is None or not np.all(solved.dof > 0.0):
        return Reason("not_identified", "the readings cannot tell the terms apart, or one power-up alone decides some")
    return Reason()


def _tested_bare(problem: _Problem) -> float:
    """P value of no warm-up if the temperature had no effect."""
    means = problem.means
    return _tested(_Problem(replace(means, temperature=means.temperature[:, :, :0]), np.zeros(means.runs)))[0]


def _estimate(power_ups: PowerUps, solved: _Solved, depends: bool) -> Estimate | None:
    """Return times, amplitudes and slopes with the covariance between them."""
    if solved.covariance is None:
        return None
    m, k = len(solved.times), len(power_ups.axes)
    q = (len(solved.values) - m) // k
    keys = [Key("warm_up_time", power=j + 1) for j in range(m)]
    units, at = ["s"] * m, list(range(m))
    by_start = normalise(f"({power_ups.unit})/degC")
    for a, axis in enumerate(power_ups.axes):
        for j in range(m):
            keys.append(Key("bias_warm_up", axis, power=j + 1))
            units.append(power_ups.unit)
            at.append(m + a * q + j)
    for a, axis in enumerate(power_ups.axes if depends else ()):
        for j in range(m):
            keys.append(Key(START_TEMPERATURE, axis, power=j + 1))
            units.append(by_start)
            at.append(m + a * q + m + j)
    covariance = solved.covariance[np.ix_(at, at)]
    scatter = Component(SCATTER, "A", 0.5 * (covariance + covariance.T), solved.dof[at], "t")
    return Estimate(tuple(keys), solved.values[at], tuple(units), (scatter,))


def _held_out(
    problem: _Problem, fits: Sequence[tuple[Indices, list[Array]]], power_ups: PowerUps, first: float
) -> Iterator[HeldOutRun]:
    """Yield what is left of each power-up in its first part, predicted from the others; its level is its own."""
    means = problem.means
    for r, (places, coefficients) in enumerate(fits):
        own = means.run == r
        weight = means.weight[own]
        curve, warm = problem.predicted(r, places, coefficients)
        left = means.readings[own] - curve - warm
        left = left - np.average(left, axis=0, weights=weight)
        early = means.time[own] <= first
        share = weight[early] / weight[early].sum()
        label = power_ups.labels[r] if power_ups.labels else str(r + 1)
        squares = [share @ one[early] ** 2 for one in (left, left + curve)]
        yield HeldOutRun(label, *(np.sqrt(one) for one in squares))


def _remarks(found: WarmUpModel, problem: _Problem, solved: _Solved) -> Iterator[Remark]:
    means, power_ups = found.stretches, found.power_ups
    if means.runs < 2:
        do = "Repeat the power-up, from several starting temperatures"
        yield Remark("one_power_up", "warning", "one power-up: no uncertainty of the warm-up can be given", do=do)
    elif means.runs < FEW_RUNS:
        what = f"{means.runs} power-ups: intervals of the warm-up are wide and rest on Student's t"
        yield Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW_RUNS} power-ups or more")
    if power_ups.temperature is None and not power_ups.thermal_model:
        what = "no temperature was recorded: what it does to the bias after power-up counts as warm-up"
        yield Remark("no_temperature", "warning", what, do="Record the temperature")
    if means.moves:
        what = f"the temperature moves by up to {means.moves:.3g} degC after power-up"
        do = "Hold the temperature, or start from several temperatures"
        severity: Severity = "warning" if found.reason.code == "temperature_moves" else "info"
        yield Remark("temperature_moves", severity, what, do=do)
    if found.reason.code == SHORT.code:
        do = f"Record {math.ceil(solved.times[-1] / RESOLVED / 60.0)} min or more after power-up"
        yield Remark("warm_up_long", "warning", found.reason.text, do=do)
    if found.estimate is None:
        return
    if found.slopes is not None:
        yield _by_start(found)
    yield from _alone(found, problem)
    if _axes_differ(problem, len(found.times)):
        what = "the axes warm up with different times: one time for all leaves more of power-ups held out"
        yield Remark("axes_differ", "warning", what, do="Fit the axes apart (axes = [...])")


def _by_start(found: WarmUpModel) -> Remark:
    """Return for which start the amplitudes are; a warning where none of the power-ups is near it."""
    start, place = found.stretches.start, found.reference_temperature
    assert place is not None  # noqa: S101 - amplitudes by starting temperature are about one
    lowest, highest = float(start.min()), float(start.max())
    what = f"amplitudes are for a start at {place:.4g} degC; power-ups start at {lowest:.4g} to {highest:.4g} degC"
    if lowest - WITHIN <= place <= highest + WITHIN:
        return Remark("warm_up_by_start", "info", what)
    do = f"State a start among them: --reference-temperature '{0.5 * (lowest + highest):.3g} degC'"
    return Remark("warm_up_by_start", "warning", f"{what}: they are extrapolated", do=do)


def _alone(found: WarmUpModel, problem: _Problem) -> Iterator[Remark]:
    """Yield a remark on power-ups that warm up far less than the others."""
    means = found.stretches
    for r in range(means.runs):
        own = means.run == r
        start = float(means.start[r]) if math.isfinite(means.start[r]) else None
        along, size = 0.0, 0.0
        for a in range(problem.axes):
            whole = np.zeros(len(means.time))
            whole[own] = found.at(means.time[own], a, start)
            model = problem.within(whole[:, None])[own, 0] / problem.scale[a]
            y = problem.within((means.readings[:, a] - found.of_temperature(means, a))[:, None])[own, 0]
            along, size = along + float(model @ y) / problem.scale[a], size + float(model @ model)
        if size > 0.0 and along / size < ALONE and (1.0 - along / size) * math.sqrt(size) > SEEN:
            label = found.power_ups.labels[r] if found.power_ups.labels else str(r + 1)
            what = f"power-up {label} warms up {along / size:.2f} times as much as the joint model says"
            do = "Leave out a restart of a unit that was still warm"
            yield Remark("power_up_differs", "warning", what, do=do, subject=label)


def _axes_differ(problem: _Problem, count: int) -> bool:
    """Whether times of its own for each axis leave less of power-ups held out, by Student's t over them."""
    if problem.axes < 2 or problem.runs < 3:
        return False
    gain = np.zeros(problem.runs)
    for r in range(problem.runs):
        others = np.delete(np.arange(problem.runs), r)
        gain[r] = problem.left_of(r, *problem.best(others, count))
        gain[r] -= sum(problem.left_of(r, *problem.best(others, count, [a]), [a]) for a in range(problem.axes))
    u = float(gain.std(ddof=1)) / math.sqrt(len(gain))
    return bool(gain.mean() > 0.0 and u > 0.0 and special.stdtr(len(gain) - 1.0, -gain.mean() / u) < DIFFERENT)
