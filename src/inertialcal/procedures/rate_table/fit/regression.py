"""The line of one sensor: reading over applied rates, and the scatter at each level that was repeated.

Per sensor ``s``, with the rates ``x_a`` about the axes that were turned::

    y_s = K0_s + sum_a M_sa x_a + c_s |x_s| + noise          c_s = K1'_s |M_ss| / 2

Every dwell has the same weight. The scatter has three levels: samples within a dwell, dwells about the
line within a run, runs. The covariance of the coefficients comes from the highest level that was repeated:

runs (two or more)
    cluster-robust covariance CR2 over the runs, Satterthwaite degrees of freedom per coefficient [1]_ [2]_.
    Where every run has the same rates this is the scatter of the runs' own fits over the number of
    runs, with one degree of freedom fewer than there are runs: exact.
dwells (no runs, or some coefficient rests on one run alone; more dwells than coefficients)
    residual mean square, n - p degrees of freedom.
samples (as many dwells as coefficients)
    scatter within the dwells over the number of samples, where both are given.

Scatters are published as observed: each contains its share of the levels below it (mean squares, never
differences cut at zero).

References
----------
.. [1] R. M. Bell and D. F. McCaffrey, Survey Methodology 28 (2002) 169-181.
.. [2] J. E. Pustejovsky and E. Tipton, J. Business & Economic Statistics 36 (2018) 672-683.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES
from ....statistics.clustered import clustered_covariance
from ....statistics.least_squares import Fit, fit
from ..plan import Plan
from ..readings import Readings

EARTH_PASSES = 3


@dataclass(frozen=True)
class Level:
    """Scatter observed at one level."""

    name: str  # What was repeated
    # Standard deviation of one member of the level [rad/s]; None where it was not repeated or not given
    std: float | None
    dof: float = np.nan  # Degrees of freedom of ``std``; NaN where they are not known
    reason: str = ""  # Why there is none, or no uncertainty of it


@dataclass(frozen=True, eq=False)
class Line:
    """Fit of one sensor."""

    sensor: str  # Axis of the sensor
    axes: tuple[str, ...]  # Axes that were turned: the order of the matrix entries
    asymmetry: bool  # Whether the last coefficient is that of ``|x_s|``
    fit: Fit  # Coefficients (K0, M_sa for a in ``axes``, c) and residuals [rad/s]
    covariance: Array | None  # shape (p, p): type A; None where nothing was repeated
    dof: Array  # shape (p,): degrees of freedom of each coefficient
    level: str  # Level that the covariance comes from
    levels: tuple[Level, ...]  # Scatter at each level
    readings: Readings  # The dwells that were used, and read by this sensor

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        entries = tuple(f"M_{self.sensor}{axis}" for axis in self.axes)
        return ("K0", *entries, "c") if self.asymmetry else ("K0", *entries)

    def coefficient(self, name: str) -> float:
        """One coefficient by name."""
        return float(self.fit.coefficients[self.names.index(name)])


def line(plan: Plan, readings: Readings, sensor: str, asymmetry: bool) -> Line:
    """Fit the line of one sensor to the dwells that it read.

    Raises
    ------
    DataError
        If there are fewer dwells than coefficients, or the rates do not tell the coefficients apart.
    """
    used = readings.take(np.isfinite(readings.outputs[sensor]))
    axes = tuple(str(axis) for axis in np.unique(used.axis))
    columns, names = _design(used, sensor, axes, asymmetry)
    y = _without_earth(used, sensor, columns, axes)
    if len(y) < len(names):
        raise DataError(
            f"{sensor} sensor: {len(y)} dwells, need {len(names)} or more for {', '.join(names)}",
            where=used.where[0] if used.where else "",
            code="too_few_dwells",
        )
    try:
        found = fit(columns, y, names=names)
    except DataError as error:
        if error.problems[0].code != "rank_deficient":
            raise
        rates = ", ".join(f"{rate:+g}" for rate in np.unique(np.degrees(used.applied).round(9))[:8])
        what = f"{sensor} sensor: the rates ({rates} deg/s) do not tell {', '.join(names)} apart"
        raise DataError(
            what, used.where[0] if used.where else "", do="Turn at more rates", code="rank_deficient"
        ) from None
    covariance, dof, level = _type_a(used, sensor, found)
    return Line(sensor, axes, asymmetry, found, covariance, dof, level, scatter_levels(used, sensor, found), used)


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
    columns, _ = _design(readings, one.sensor, one.axes, one.asymmetry)
    expected: Array = columns @ one.fit.coefficients
    if readings.earth is None:
        return expected
    row = (np.array(AXES) == one.sensor).astype(float)
    for at, axis in enumerate(one.axes):
        row[AXES.index(axis)] = one.fit.coefficients[1 + at]
    return np.asarray(expected + readings.earth @ row)


def _design(readings: Readings, sensor: str, axes: tuple[str, ...], asymmetry: bool) -> tuple[Array, list[str]]:
    x = {axis: np.where(readings.axis == axis, readings.applied, 0.0) for axis in axes}
    columns = [np.ones(len(readings)), *x.values()]
    names = ["bias", *(f"matrix entry {sensor}{axis}" for axis in axes)]
    if asymmetry:
        columns.append(np.abs(x[sensor]))
        names.append("asymmetry")
    return np.column_stack(columns), names


def can_tell_asymmetry(readings: Readings, sensor: str) -> bool:
    """Return True where the sensor's own axis was turned both ways at two or more rates each, or with rest."""
    rates = readings.applied[(readings.axis == sensor) & np.isfinite(readings.outputs[sensor])]
    positive, negative = np.unique(rates[rates > 0.0]), np.unique(rates[rates < 0.0])
    at_rest = bool(np.any(rates == 0.0))
    return min(len(positive), len(negative)) >= 1 and len(positive) + len(negative) + at_rest >= 3


def _type_a(readings: Readings, sensor: str, found: Fit) -> tuple[Array | None, Array, str]:
    p = len(found.coefficients)
    if readings.runs >= 2 and found.dof > 0:
        assert readings.run is not None  # noqa: S101 - for the type checker
        covariance, dof = clustered_covariance(found, readings.run)
        if np.all(dof > 0.0):
            return covariance, dof, "run"
        # One coefficient has one run only: use the scatter of the dwells about the line.
    if found.dof > 0:
        return found.covariance, np.full(p, float(found.dof)), "dwell"
    scatter, samples = readings.scatters.get(sensor), readings.samples
    if scatter is not None and samples is not None and np.all(np.isfinite(scatter)) and np.all(samples > 1):
        solve = np.linalg.pinv(found.design)
        covariance = (solve * (scatter**2 / samples)) @ solve.T
        return covariance, np.full(p, float(np.sum(samples - 1))), "sample"
    return None, np.full(p, np.nan), ""


def scatter_levels(readings: Readings, sensor: str, found: Fit) -> tuple[Level, ...]:
    """Observe the scatter of samples within dwells, of dwells within runs, and of runs."""
    return (_sample_level(readings, sensor), *_dwell_and_run_levels(readings, found))


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


def _dwell_and_run_levels(readings: Readings, found: Fit) -> tuple[Level, Level]:
    total = float(found.residuals @ found.residuals)
    if readings.runs == 0:
        return _dwell_level(total, found.dof), Level("run", None, reason="runs were not given")
    if readings.runs == 1:
        return _dwell_level(total, found.dof), Level("run", None, reason="one run: not repeated")
    assert readings.run is not None  # noqa: S101 - for the type checker
    labels, at = np.unique(readings.run, return_inverse=True)
    columns = np.column_stack([found.design, np.eye(len(labels))[at]])
    left, singular, _ = np.linalg.svd(columns, full_matrices=False)
    basis: Array = left[:, singular > singular[0] * 1e-10]
    residuals = found.residuals - basis @ (basis.T @ found.residuals)  # what no run offset can take up
    square = float(residuals @ residuals)
    dof = float(len(residuals) - basis.shape[1])
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
