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

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES
from ....statistics.clustered import clustered_covariance
from ....statistics.least_squares import Fit, fit
from ....statistics.own_offsets import OwnOffsets, fit_own_offsets, mean_square_within
from ....statistics.random_offsets import group_moments, offset_ratio, whitened, whitening
from ..plan import Plan
from ..readings import Labels, Readings

EARTH_PASSES = 3
UNEQUAL = 2.0  # most over fewest samples of a dwell, from which on they decide its weight
MANY = 12  # runs, from which on their scatter is known well enough to weigh an offset by it
COST = 2.0  # of an intercept for each recording, in u of any coefficient, that many runs need not pay
HALVINGS = 24
POWERS = {"K2": 2, "K3": 3}
WORDS = {"K2": "second-order term", "K3": "third-order term"}


@dataclass(frozen=True)
class Level:
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


@dataclass(frozen=True, eq=False)
class Unresolved:
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

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        entries = tuple(f"M_{self.sensor}{axis}" for axis in self.axes)
        return ("K0", *entries, *(("c",) if self.asymmetry else ()), *self.curvature)

    def coefficient(self, name: str) -> float:
        """One coefficient by name."""
        return float(self.fit.coefficients[self.names.index(name)])


def line(plan: Plan, readings: Readings, sensor: str, asymmetry: bool, curvature: tuple[str, ...] = ()) -> Line:
    """Fit the line of one sensor to the dwells that it read.

    Raises
    ------
    DataError
        If there are fewer dwells than coefficients, or the rates do not tell the coefficients apart.
    """
    used = readings.take(np.isfinite(readings.outputs[sensor]))
    axes = tuple(str(axis) for axis in np.unique(used.axis))
    columns, names = design(used, sensor, axes, asymmetry, curvature)
    y = _without_earth(used, sensor, columns, axes)
    if len(y) < len(names):
        raise DataError(
            f"{sensor} sensor: {len(y)} dwells, need {len(names)} or more for {', '.join(names)}",
            where=used.where[0] if used.where else "",
            code="too_few_dwells",
        )
    try:
        plain = fit(columns, y, names=names)
    except DataError as error:
        if error.problems[0].code != "rank_deficient":
            raise
        rates = ", ".join(f"{rate:+g}" for rate in np.unique(np.degrees(used.applied).round(9))[:8])
        what = f"{sensor} sensor: the rates ({rates} deg/s) do not tell {', '.join(names)} apart"
        raise DataError(
            what, used.where[0] if used.where else "", do="Turn at more rates", code="rank_deficient"
        ) from None
    found, covariance, dof, level = _solved(used, sensor, columns, y, plain)
    levels = (_sample_level(used, sensor), *_dwell_and_run_levels(used, plain, found))
    return Line(sensor, axes, asymmetry, found, covariance, dof, level, levels, used, curvature)


def recordings_of(readings: Readings) -> tuple[Labels, Labels]:
    """Return the recording of each dwell, and its run: the power-up, or the recording where none is named."""
    if readings.runs:
        assert readings.run is not None  # noqa: S101 - for the type checker
        label = readings.run
    else:
        label = np.full(len(readings), "") if readings.recording is None else readings.recording
    groups = np.array([f"{one} {axis}" for one, axis in zip(label, readings.axis, strict=True)])
    return groups, label if readings.runs else groups


Solved = tuple[Solution, Array | None, Array, str]


def _solved(readings: Readings, sensor: str, columns: Array, y: Array, plain: Fit) -> Solved:
    """Return coefficients with covariance, degrees of freedom and the level that those of the slopes come from."""
    groups, clusters = recordings_of(readings)
    numbers = np.unique(groups, return_inverse=True)[1]
    weights = _weights(readings, sensor, columns, y, numbers)
    own = fit_own_offsets(columns[:, 1:], y, groups, clusters, weights)
    ratio = offset_ratio(group_moments(columns, y, weights, numbers)) if plain.dof >= 2 else 0.0
    white = fit(whitened(columns, weights, numbers, ratio), whitened(y[:, None], weights, numbers, ratio)[:, 0])
    many = readings.runs >= MANY and own is not None and _cost(own, white) > COST
    if own is None or many:
        solve = whitening(white.transform @ white.basis.T, weights, numbers, ratio)
        return _with_random_offsets(readings, sensor, columns, y, white, solve, numbers)
    found = Solution(
        own.coefficients,
        own.solve,
        columns,
        y - columns @ own.coefficients,
        own.local,
        np.sum(own.basis**2, axis=1) + weights / np.bincount(numbers, weights)[numbers],
        own.basis,
        numbers,
        own.mean_square,
        own.spare,
        True,
    )
    between = "run" if readings.runs else "recording"
    return found, own.covariance, own.dof, between if np.all(own.repeated[1:]) else "dwell"


def _cost(own: OwnOffsets, white: Fit) -> float:
    """Return by how much an intercept for each recording makes u of a slope larger, at most."""
    size = np.sqrt(np.sum(own.solve[1:] ** 2, axis=1))
    return float(np.max(size / np.sqrt(np.sum(white.transform[1:] ** 2, axis=1))))


def _with_random_offsets(
    readings: Readings, sensor: str, columns: Array, y: Array, white: Fit, solve: Array, numbers: NDArray[np.intp]
) -> Solved:
    """Return a line with one intercept, the offsets of recordings a random effect, or in the scatter."""
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


def _weights(readings: Readings, sensor: str, columns: Array, y: Array, numbers: NDArray[np.intp]) -> Array:
    """Return the weights of dwells, shape (n,): equal, or by their number of samples where these differ much.

    The variance of a mean is that of a sample over their number and that of a dwell, the latter such that the
    residuals are as large as expected.
    """
    equal, samples, scatter = np.ones(len(y)), readings.samples, readings.scatters.get(sensor)
    if samples is None or scatter is None or not (np.all(np.isfinite(samples)) and np.all(np.isfinite(scatter))):
        return equal
    if np.max(samples) <= UNEQUAL * np.min(samples) or not np.any(scatter > 0.0):
        return equal
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


def _without_earth(readings: Readings, sensor: str, columns: Array, axes: tuple[str, ...]) -> Array:
    """Return the readings less what the sensor reads of the earth's rotation, by its own matrix row, shape (n,)."""
    y = readings.outputs[sensor]
    if readings.earth is None or len(y) < columns.shape[1]:
        return y
    row = (np.array(AXES) == sensor).astype(float)
    for _ in range(EARTH_PASSES):  # each gains two digits: the row is known to a percent before the first
        coefficients = np.linalg.lstsq(columns, y - readings.earth @ row, rcond=None)[0]
        for at, axis in enumerate(axes):
            row[AXES.index(axis)] = coefficients[1 + at]
    return np.asarray(y - readings.earth @ row)


def reading_of_line(one: Line, readings: Readings) -> Array:
    """Return what a fitted line expects the sensor to read in each dwell, the earth's rotation included [rad/s].

    Returns
    -------
    ndarray, shape (n,)
    """
    columns, _ = design(readings, one.sensor, one.axes, one.asymmetry, one.curvature)
    expected: Array = columns @ one.fit.coefficients
    if readings.earth is None:
        return expected
    row = (np.array(AXES) == one.sensor).astype(float)
    for at, axis in enumerate(one.axes):
        row[AXES.index(axis)] = one.fit.coefficients[1 + at]
    return np.asarray(expected + readings.earth @ row)


def design(
    readings: Readings, sensor: str, axes: tuple[str, ...], asymmetry: bool, curvature: tuple[str, ...] = ()
) -> tuple[Array, list[str]]:
    """Return the columns of a line, the first one of the intercept, shape (n, p), and their names in words."""
    x = {axis: np.where(readings.axis == axis, readings.applied, 0.0) for axis in axes}
    return columns_of(x, sensor, asymmetry, curvature)


def columns_of(
    x: Mapping[str, Array], sensor: str, asymmetry: bool, curvature: tuple[str, ...]
) -> tuple[Array, list[str]]:
    """Return the columns of a line for rates about its axes, and their names in words."""
    columns = [np.ones(len(next(iter(x.values())))), *x.values()]
    names = ["bias", *(f"matrix entry {sensor}{axis}" for axis in x)]
    if asymmetry:
        columns.append(np.abs(x[sensor]))
        names.append("asymmetry")
    for name in curvature:
        columns.append(x[sensor] ** POWERS[name])
        names.append(WORDS[name])
    return np.column_stack(columns), names


def can_tell_asymmetry(readings: Readings, sensor: str) -> bool:
    """Return True where the sensor's own axis was turned both ways at two or more rates each, or with rest."""
    rates = readings.applied[(readings.axis == sensor) & np.isfinite(readings.outputs[sensor])]
    positive, negative = np.unique(rates[rates > 0.0]), np.unique(rates[rates < 0.0])
    at_rest = bool(np.any(rates == 0.0))
    return min(len(positive), len(negative)) >= 1 and len(positive) + len(negative) + at_rest >= 3


def _sample_level(readings: Readings, sensor: str) -> Level:
    scatter = readings.scatters.get(sensor)
    if scatter is None or not np.any(np.isfinite(scatter)):
        return Level("sample", None, reason="the scatter within the dwells was not given")
    given = np.isfinite(scatter)
    if readings.samples is None:
        std = float(np.sqrt(np.mean(scatter[given] ** 2)))
        return Level("sample", std, reason="the number of samples of a dwell was not given")
    weight = readings.samples[given] - 1.0
    if not np.all(np.isfinite(weight)) or weight.sum() <= 0.0:
        std = float(np.sqrt(np.mean(scatter[given] ** 2)))
        return Level("sample", std, reason="the number of samples of a dwell is missing, or one")
    return Level("sample", float(np.sqrt(np.sum(weight * scatter[given] ** 2) / np.sum(weight))), float(weight.sum()))


def _dwell_and_run_levels(readings: Readings, found: Fit, own: Solution) -> tuple[Level, Level]:
    total = float(found.residuals @ found.residuals)
    if readings.runs < 2:
        reason = "one run: not repeated" if readings.runs else "runs were not given"
        square = float(own.local @ own.local) if own.own else total
        return _dwell_level(square, own.dof if own.own else found.dof), Level("run", None, reason=reason)
    assert readings.run is not None  # noqa: S101 - for the type checker
    labels, at = np.unique(readings.run, return_inverse=True)
    # What no offset of a run can take up: within the runs, beside the columns there
    within = whitened(np.column_stack([found.design, found.residuals]), np.ones(len(at)), at, np.inf)
    left, singular, _ = np.linalg.svd(within[:, :-1], full_matrices=False)
    size = np.hypot(np.linalg.norm(found.design), np.sqrt(np.max(np.bincount(at))))
    basis: Array = left[:, singular > size * 1e-10]
    residuals = within[:, -1] - basis @ (basis.T @ within[:, -1])
    square = float(residuals @ residuals)
    dof = float(len(residuals) - len(labels) - basis.shape[1])
    dof_run = found.dof - dof
    dwell = _dwell_level(square, dof)
    if dof_run < 1:
        return dwell, Level("run", None, reason="the rates differ from run to run: no scatter between runs")
    per_run = len(readings) / len(labels)
    return dwell, Level("run", float(np.sqrt(max(total - square, 0.0) / dof_run / per_run)), dof_run)


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
