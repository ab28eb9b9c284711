"""The line of one sensor: reading over applied rates, and the scatter at each level that was repeated.

Per sensor ``s``, with the rates ``x_a`` about the axes ``a`` that were turned, and a recording ``g`` (the dwells about
one axis in one power-up; where no power-ups are named, those of one file about one axis)::

    y_s = K0_sg + sum_a M_sa x_a + c_s |x_s| + b2_s x_s^2 + b3_s x_s^3 + noise

``K1' = 2 c / M_ss``, ``K2 = b2 / M_ss^2``, ``K3 = b3 / M_ss^3`` of the sensor equation. Slopes come from within the
recordings, so that no turn-on offset bends them; ``K0`` is the mean of the intercepts over power-ups (``own_offsets``).
Dwells have the same weight, or that of their number of samples where these differ by more than a factor of two. The
covariance of each slope comes from the highest level that was repeated:

runs (an axis turned in two runs or more; of recordings without labels, in two recordings)
    cluster-robust covariance CR2 over them, Satterthwaite degrees of freedom per coefficient [1]_ [2]_.
    Where every run has the same rates this is the scatter of the runs' own fits over the number of
    runs, with one degree of freedom fewer than there are runs: exact, also where slopes differ from run to run.
dwells
    residual mean square within the recordings.
samples (as many dwells as coefficients)
    scatter within the dwells over the number of samples, where both are given.

Recordings that cannot tell the coefficients apart by themselves (one pair of rates each, say) share one intercept;
their offsets are then a random effect whose size is found by restricted maximum likelihood, or left in the scatter
where nothing tells it. So it is too where twelve runs or more know an offset better than each its own.

Scatters are published as observed: each contains its share of the levels below it (mean squares, never
differences cut at zero).

Not held: (1) a scale factor that differs from power-up to power-up, each axis turned in one: its interval holds the
truth of that power-up; (2) one recording an axis whose bias walks while the rates rise in order: with a walk of half
the scatter of a dwell from dwell to dwell, 88 % of the intervals of the scale factor hold; (3) scatter that grows with
the rate, one recording an axis.

References
----------
.. [1] R. M. Bell and D. F. McCaffrey, Survey Methodology 28 (2002) 169-181.
.. [2] J. E. Pustejovsky and E. Tipton, J. Business & Economic Statistics 36 (2018) 672-683.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES
from ....statistics.clustered import clustered_covariance
from ....statistics.least_squares import Decomposed, Fit, fit, times
from ....statistics.own_offsets import mean_square_within
from ....statistics.random_offsets import group_moments, offset_ratio, whitened, whitening
from ..plan import Plan
from ..readings import Readings
from ..turned import LineDesign, columns_of

EARTH_PASSES = 3
UNEQUAL = 2.0  # most over fewest samples of a dwell, from which on they decide its weight
MANY = 12  # runs, from which on their scatter is known well enough to weigh an offset by it
COST = 2.0  # of an intercept for each recording, in u of any coefficient, that many runs need not pay
HALVINGS = 24
NO_SCATTER = "the scatter within the dwells was not given"


class Level(NamedTuple):
    """Scatter observed at one level."""

    name: str  # What was repeated
    # Standard deviation of one member of the level [rad/s]; None where it was not repeated or not given
    std: float | None
    dof: float = np.nan  # Degrees of freedom of ``std``; NaN where they are not known
    reason: str = ""  # Why there is none, or no uncertainty of it


@dataclass(frozen=True, eq=False)
class Solution:
    """Coefficients of a line as combinations of the readings."""

    coefficients: Array  # shape (p,)
    solve: Array  # shape (p, n): ``coefficients = solve @ readings``
    design: Array  # shape (n, p): the first column is 1
    residuals: Array  # shape (n,): reading less line, the offset of its recording included [rad/s]
    local: Array  # shape (n,): the same without that offset, where recordings have intercepts of their own [rad/s]
    leverage: Array  # shape (n,): change of the fitted value with its own reading
    basis: Array  # shape (n, q): orthonormal, of all that was fitted beside the intercepts of recordings
    groups: NDArray[np.intp]  # shape (n,): number of the recording of each dwell
    mean_square: float | None  # of ``local`` [(rad/s)^2]; None where nothing is left
    dof: float  # of it
    own: bool  # Whether recordings have intercepts of their own

    @classmethod
    def of_own(cls, **fields: object) -> Solution:
        """Return a solution of all its fields; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(fields)
        return found


class Unresolved(NamedTuple):
    """A curvature that the rates tell apart: what it changes of a line without it, and how large it may be."""

    name: str  # ``"K2"``
    size: float  # Root mean square of what it may be [(rad/s)^(1 - power)]; 0 where it is taken as none
    pattern: Array  # shape (p,): what one unit of it adds to the coefficients of the line; 0 where the line has it


@dataclass(frozen=True, eq=False)
class Line:
    """Fit of one sensor."""

    sensor: str  # Axis of the sensor
    axes: tuple[str, ...]  # Axes that were turned: the order of the matrix entries
    asymmetry: bool  # Whether there is a coefficient of ``|x_s|``
    fit: Solution  # Coefficients (K0, M_sa for a in ``axes``, c, b2, b3) and residuals [rad/s]
    covariance: Array | None  # shape (p, p): type A; None where nothing was repeated
    dof: Array  # shape (p,): degrees of freedom of each coefficient
    level: str  # Level that the covariance of the slopes comes from
    levels: tuple[Level, ...]  # Scatter at each level
    readings: Readings  # The dwells that were used, and read by this sensor
    curvature: tuple[str, ...] = ()  # Of ``"K2"``, ``"K3"``: what it has
    unresolved: tuple[Unresolved, ...] = ()  # What it may lack

    @classmethod
    def of_own(cls, **fields: object) -> Line:
        """Return a line of all its fields; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(fields)
        return found

    def changed(self, **fields: object) -> Line:
        """Return the line with other values of some fields; ``dataclasses.replace`` takes several times as long."""
        return Line.of_own(**(self.__dict__ | fields))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return _names(self.sensor, self.axes, self.asymmetry, self.curvature)

    def coefficient(self, name: str) -> float:
        """One coefficient by name."""
        return float(self.fit.coefficients[self.names.index(name)])


@lru_cache(maxsize=256)  # the same of all units that are turned alike
def _names(sensor: str, axes: tuple[str, ...], asymmetry: bool, curvature: tuple[str, ...]) -> tuple[str, ...]:
    entries = (f"M_{sensor}{axis}" for axis in axes)
    return ("K0", *entries, *(("c",) if asymmetry else ()), *curvature)


def line(plan: Plan, readings: Readings, sensor: str, asymmetry: bool, curvature: tuple[str, ...] = ()) -> Line:
    """Fit the line of one sensor to the dwells that it read.

    Raises
    ------
    DataError
        If there are fewer dwells than coefficients, or the rates do not tell the coefficients apart.
    """
    found = lines([readings], sensor, asymmetry, curvature)[0]
    if isinstance(found, DataError):
        raise found
    return found


def lines(
    units: Sequence[Readings], sensor: str, asymmetry: bool, curvature: tuple[str, ...] = ()
) -> list[Line | DataError]:
    """Return the line of a sensor of each of several units, or why it has none; those turned alike are fitted at once.

    Every line is the same, to the bit, as that of its unit alone.
    """
    used = _read(units, sensor)
    found: dict[int, Line | DataError] = {}
    alike: dict[int, tuple[LineDesign, Decomposed, list[int]]] = {}
    for i, one in enumerate(used):
        if not len(one):
            where = units[i].where[0] if units[i].where else ""
            found[i] = DataError(f"{sensor} sensor: no readings", where=where, code="too_few_dwells")
            continue
        design = one.turned.line(sensor, asymmetry, curvature)
        if len(one) < len(design.words):
            what = f"{sensor} sensor: {len(one)} dwells, need {len(design.words)} or more for {', '.join(design.words)}"
            found[i] = DataError(what, where=one.where[0] if one.where else "", code="too_few_dwells")
        elif isinstance(design.plain, DataError):
            found[i] = _not_told_apart(one, design, design.plain)
        else:
            alike.setdefault(id(design), (design, design.plain, []))[2].append(i)
    for design, plain, members in alike.values():
        found.update(zip(members, _alike(design, plain, [used[i] for i in members]), strict=True))
    return [found[i] for i in range(len(used))]


def _read(units: Sequence[Readings], sensor: str) -> list[Readings]:
    """Return the dwells of each unit that a sensor was read in, without traces."""
    outputs = [one.outputs[sensor] for one in units]
    if len({len(one) for one in outputs}) == 1 and np.isfinite(np.array(outputs)).all():
        return [one.changed(traces=()) if one.traces else one for one in units]
    return [one.take(np.isfinite(own)) for one, own in zip(units, outputs, strict=True)]


def _not_told_apart(one: Readings, design: LineDesign, error: DataError) -> DataError:
    if error.problems[0].code != "rank_deficient":
        return error
    rates = ", ".join(f"{rate:+g}" for rate in np.unique(np.degrees(one.applied).round(9))[:8])
    what = f"{design.sensor} sensor: the rates ({rates} deg/s) do not tell {', '.join(design.words)} apart"
    where = one.where[0] if one.where else ""
    return DataError(what, where, do="Turn at more rates", code="rank_deficient")


@dataclass(frozen=True, eq=False)
class _Plain:
    """Fits with one intercept and equal weights, of units turned alike."""

    residuals: Array  # (units, n)
    dof: float


def _alike(design: LineDesign, plain: Decomposed, units: Sequence[Readings]) -> list[Line]:
    """Return the lines of units that were turned alike."""
    sensor, columns = design.sensor, design.columns
    y = _without_earth(design, plain, units)
    fitted = _Plain(y - times(columns, plain.coefficients(y)), float(columns.shape[0] - columns.shape[1]))
    weights: list[Array | None] = [None] * len(units)
    for i in _uneven(units, sensor):
        weights[i] = _weights(units[i], sensor, columns, y[i], design.turned.numbers)
    equal = [i for i, one in enumerate(weights) if one is None]
    solved: dict[int, Solved] = dict(
        zip(equal, _solved(design, [units[i] for i in equal], y[equal], None), strict=True)
    )
    for i, weight in enumerate(weights):
        if weight is not None:
            solved[i] = _solved(design, [units[i]], y[[i]], weight)[0]
    own = np.sum(np.array([solved[i][0].local for i in range(len(units))]) ** 2, axis=1)
    levels = _dwell_and_run_levels(design, fitted, [solved[i][0] for i in range(len(units))], own)
    made = []
    for i, (one, sample) in enumerate(zip(units, _sample_levels(units, sensor), strict=True)):
        found, covariance, dof, level = solved[i]
        made.append(Line.of_own(
            sensor=sensor, axes=design.turned.axes, asymmetry=design.asymmetry, fit=found, covariance=covariance,
            dof=dof, level=level, levels=(sample, *levels[i]), readings=one, curvature=design.curvature, unresolved=(),
        ))  # fmt: skip
    return made


Solved = tuple["Solution", Array | None, Array, str]


def _solved(design: LineDesign, units: Sequence[Readings], y: Array, weights: Array | None) -> list[Solved]:
    """Return coefficients with covariance, degrees of freedom and the level that those of the slopes come from.

    Parameters
    ----------
    design : LineDesign
        Of all units.
    units : sequence of Readings
        All of the same weights.
    y : ndarray, shape (units, n)
        Their readings, without the earth's rotation.
    weights : ndarray, shape (n,), or None
        Of the dwells; None for equal ones.
    """
    if not units:
        return []
    offsets = design.own if weights is None else design.own_weighed(weights)
    every = np.ones(y.shape[1]) if weights is None else weights
    if offsets is None:
        return [_with_random_offsets(design, one, y[i], every) for i, one in enumerate(units)]
    numbers, columns = design.turned.numbers, design.columns
    own = offsets.fit(y)
    residuals = y - times(columns, own.coefficients)
    leverage = np.sum(own.basis**2, axis=1) + every / np.bincount(numbers, every)[numbers]
    between = "run" if design.turned.runs else "recording"
    level = between if np.all(own.repeated[1:]) else "dwell"
    mean_square = own.mean_square.tolist()
    found: list[Solved] = []
    for i, one in enumerate(units):
        if design.turned.runs >= MANY:
            white = _white(design, y[i], every)[0]
            if _cost(own.solve[i], white) > COST:
                found.append(_with_random_offsets(design, one, y[i], every))
                continue
        solution = Solution.of_own(
            coefficients=own.coefficients[i], solve=own.solve[i], design=columns, residuals=residuals[i],
            local=own.local[i], leverage=leverage, basis=own.basis, groups=numbers, mean_square=mean_square[i],
            dof=own.spare, own=True,
        )  # fmt: skip
        found.append((solution, own.covariance[i], own.dof, level))
    return found


def _white(design: LineDesign, y: Array, weights: Array) -> tuple[Fit, float]:
    """Return the fit with one intercept, and the variance of the offsets of recordings over that of a dwell."""
    columns, numbers = design.columns, design.turned.numbers
    spare = columns.shape[0] - columns.shape[1]
    ratio = offset_ratio(group_moments(columns, y, weights, numbers)) if spare >= 2 else 0.0
    white = whitened(np.column_stack([columns, y]), weights, numbers, ratio)
    return fit(white[:, :-1], white[:, -1]), ratio


def _cost(solve: Array, white: Fit) -> float:
    """Return by how much an intercept for each recording makes u of a slope larger, at most."""
    size = np.sqrt(np.sum(solve[1:] ** 2, axis=1))
    return float(np.max(size / np.sqrt(np.sum(white.transform[1:] ** 2, axis=1))))


def _with_random_offsets(design: LineDesign, readings: Readings, y: Array, weights: Array) -> Solved:
    """Return a line with one intercept, the offsets of recordings a random effect, or in the scatter."""
    sensor, columns, numbers = design.sensor, design.columns, design.turned.numbers
    white, ratio = _white(design, y, weights)
    solve = whitening(white.transform @ white.basis.T, weights, numbers, ratio)
    residuals = y - columns @ white.coefficients
    found = Solution(
        white.coefficients, solve, columns, residuals, residuals, white.leverage, white.basis, numbers,
        white.mean_square, white.dof, False,
    )  # fmt: skip
    p = len(white.coefficients)
    if readings.runs >= 2 and white.dof > 0:
        assert readings.run is not None  # noqa: S101 - for the type checker
        covariance, dof = clustered_covariance(white, readings.run)
        if np.all(dof > 0.0):
            return found, covariance, dof, "run"
        # One coefficient has one run only: use the scatter of the dwells about the line.
    if white.dof > 0:
        return found, white.covariance, np.full(p, float(white.dof)), "dwell"
    scatter, samples = readings.scatters.get(sensor), readings.samples
    if scatter is not None and samples is not None and np.all(np.isfinite(scatter)) and np.all(samples > 1):
        covariance = (solve * (scatter**2 / samples)) @ solve.T
        return found, covariance, np.full(p, float(np.sum(samples - 1))), "sample"
    return found, None, np.full(p, np.nan), ""


def _uneven(units: Sequence[Readings], sensor: str) -> list[int]:
    """Return which of units turned alike may have dwells of other weights: their number of samples differs much."""
    known = [(i, one.samples) for i, one in enumerate(units) if one.samples is not None and sensor in one.scatters]
    if not known:
        return []
    samples = np.array([one for _, one in known])
    even = np.max(samples, axis=1) <= UNEQUAL * np.min(samples, axis=1)  # a NaN is not
    return [i for (i, _), alike in zip(known, even.tolist(), strict=True) if not alike]


def _weights(readings: Readings, sensor: str, columns: Array, y: Array, numbers: NDArray[np.intp]) -> Array | None:
    """Return the weights of dwells, shape (n,), by their number of samples where these differ much; None for equal.

    The variance of a mean is that of a sample over their number and that of a dwell, the latter such that the
    residuals are as large as expected.
    """
    samples, scatter = readings.samples, readings.scatters.get(sensor)
    if samples is None or scatter is None or not (np.all(np.isfinite(samples)) and np.all(np.isfinite(scatter))):
        return None
    if np.max(samples) <= UNEQUAL * np.min(samples) or not np.any(scatter > 0.0):
        return None
    within = float(np.sum(samples * scatter**2) / np.sum(samples)) / samples

    def left(dwell: float) -> float:
        square = mean_square_within(columns[:, 1:], y, numbers, 1.0 / (within + dwell))
        return 0.0 if square is None else square - 1.0

    low, high = 0.0, float(np.var(y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0])) * len(y)
    if left(0.0) > 0.0:
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if left(middle) > 0.0 else (low, middle)
    found = 1.0 / (within + low)
    return np.asarray(found / found.mean())


def _without_earth(design: LineDesign, plain: Decomposed, units: Sequence[Readings]) -> Array:
    """Return readings less what each sensor reads of the earth's rotation, by its own matrix row, shape (units, n)."""
    sensor = design.sensor
    y = np.stack([one.outputs[sensor] for one in units])
    earth = [one.earth for one in units if one.earth is not None]
    if len(earth) < len(units):  # all have it, or none
        return y
    row = np.tile((np.array(AXES) == sensor).astype(float), (len(units), 1))
    at = [AXES.index(axis) for axis in design.turned.axes]
    alike = all(one is earth[0] for one in earth)
    stacked = earth[0] if alike else np.stack(earth)
    read = times(plain.transform, times(plain.basis.T, y))  # coefficients of readings, and of the earth's rotation
    turned = plain.transform @ (plain.basis.T @ stacked)
    for _ in range(EARTH_PASSES):  # each gains two digits: the row is known to a percent before the first
        row[:, at] = (read - times(turned, row))[:, 1 : 1 + len(at)]
    return np.asarray(y - times(stacked, row))


def reading_of_line(one: Line, readings: Readings) -> Array:
    """Return what a fitted line expects the sensor to read in each dwell, the earth's rotation included [rad/s].

    Returns
    -------
    ndarray, shape (n,)
    """
    x = {axis: np.where(readings.axis == axis, readings.applied, 0.0) for axis in one.axes}
    columns, _ = columns_of(x, one.sensor, one.asymmetry, one.curvature)
    expected: Array = columns @ one.fit.coefficients
    if readings.earth is None:
        return expected
    row = (np.array(AXES) == one.sensor).astype(float)
    for at, axis in enumerate(one.axes):
        row[AXES.index(axis)] = one.fit.coefficients[1 + at]
    return np.asarray(expected + readings.earth @ row)


def _sample_levels(units: Sequence[Readings], sensor: str) -> list[Level]:
    """Return the scatter of samples of each of several units turned alike, at once where all of it is given."""
    scatters = [one.scatters[sensor] for one in units if sensor in one.scatters]
    samples = [one.samples for one in units if one.samples is not None]
    if not scatters:
        return [Level("sample", None, reason=NO_SCATTER)] * len(units)
    if len(scatters) == len(samples) == len(units):
        scatter, weight = np.array(scatters), np.array(samples) - 1.0
        total = weight.sum(axis=1)
        if np.isfinite(scatter).all() and np.isfinite(weight).all() and (total > 0.0).all():
            std = np.sqrt((weight * scatter**2).sum(axis=1) / total)
            return [Level("sample", *own) for own in zip(std.tolist(), total.tolist(), strict=True)]
    return [_sample_level(one, sensor) for one in units]


def _sample_level(readings: Readings, sensor: str) -> Level:
    scatter = readings.scatters.get(sensor)
    if scatter is None or not np.any(np.isfinite(scatter)):
        return Level("sample", None, reason=NO_SCATTER)
    given = np.isfinite(scatter)
    if readings.samples is None:
        std = float(np.sqrt(np.mean(scatter[given] ** 2)))
        return Level("sample", std, reason="the number of samples of a dwell was not given")
    weight = readings.samples[given] - 1.0
    if not np.all(np.isfinite(weight)) or weight.sum() <= 0.0:
        std = float(np.sqrt(np.mean(scatter[given] ** 2)))
        return Level("sample", std, reason="the number of samples of a dwell is missing, or one")
    return Level("sample", float(np.sqrt(np.sum(weight * scatter[given] ** 2) / np.sum(weight))), float(weight.sum()))


def _dwell_and_run_levels(
    design: LineDesign, found: _Plain, solutions: Sequence[Solution], own: Array
) -> list[tuple[Level, Level]]:
    """Return the scatter of dwells and of runs of units turned alike.

    Parameters
    ----------
    design : LineDesign
        Of all units.
    found : _Plain
        Their fits with one intercept.
    solutions : sequence of Solution
        Their lines.
    own : ndarray, shape (units,)
        Sum of squares of their residuals without the offsets of recordings [(rad/s)^2].
    """
    runs = design.turned.runs
    if runs < 2:
        reason = "one run: not repeated" if runs else "runs were not given"
        missing = Level("run", None, reason=reason)
        total = np.sum(found.residuals**2, axis=-1)
        squares = [(own[i], one.dof) if one.own else (total[i], found.dof) for i, one in enumerate(solutions)]
        return [(_dwell_level(float(square), dof), missing) for square, dof in squares]
    # What no offset of a run can take up: within the runs, beside the columns there
    at, basis = design.turned.of_run, design.within_runs
    per_run = np.bincount(at)
    order = np.argsort(at, kind="stable")
    means = np.add.reduceat(found.residuals[:, order], np.cumsum(per_run) - per_run, axis=-1) / per_run
    within = found.residuals - means[:, at]
    left = within - times(basis, times(basis.T, within))
    square = np.sum(left**2, axis=-1)
    dof = float(len(at) - runs - basis.shape[1])
    dof_run = found.dof - dof
    if dof_run < 1:
        missing = Level("run", None, reason="the rates differ from run to run: no scatter between runs")
        return [(_dwell_level(one, dof), missing) for one in square.tolist()]
    of_run = np.sqrt(np.sum((found.residuals - left) ** 2, axis=-1) / dof_run / (len(at) / runs))
    return [
        (_dwell_level(one, dof), Level("run", std, dof_run))
        for one, std in zip(square.tolist(), of_run.tolist(), strict=True)
    ]


def _dwell_level(square: float, dof: float) -> Level:
    if dof < 1:
        return Level("dwell", None, reason="as many dwells as coefficients: not repeated")
    return Level("dwell", float(np.sqrt(square / dof)), float(dof))


def dwell_variance(levels: tuple[Level, ...], per_run: float) -> tuple[float, float] | None:
    """Variance of the mean of a new dwell in a new run about the line, and its degrees of freedom.

    The run level as observed holds 1 / per_run of the dwell level; the sum is completed with the rest, and
    the degrees of freedom follow by Satterthwaite.

    Returns
    -------
    (variance, dof) : [(rad/s)^2], or None where no level above the samples was repeated.
    """
    dwell = next(level for level in levels if level.name == "dwell")
    run = next(level for level in levels if level.name == "run")
    parts = []
    if run.std is not None:
        parts.append((run.std**2, run.dof))
    if dwell.std is not None:
        share = 1.0 - 1.0 / per_run if run.std is not None else 1.0
        parts.append((share * dwell.std**2, dwell.dof))
    variance = sum(part for part, _ in parts)
    if not parts or variance == 0.0:
        return None
    return variance, variance**2 / sum(part**2 / dof for part, dof in parts)
