"""Other estimates of the same record beside the fit, and whether they agree with it.

All are sums of the same readings with other weights, so they share most of their noise: what may differ between them
is the noise in the difference of the weights, far less than their uncertainties together. Where noise is told by
generalised least squares its covariance is used for it; in longer records noise is taken as white with the density at
the drive. More than three standard deviations of that difference is called a disagreement: drift that one of them does
not take out.

Amplitude from alternating differences of half periods: a check that needs no model of drift.

The record is cut into half periods of the drive; each gives ``u_j``, the mean of its readings weighted by the drive,
over the mean of the drive's square. Of half periods one after another the sums::

    sum over k = 0 ... n of C(n, k) u_(j+k) / 2^n

keep the amplitude and take out drift that is a polynomial of a degree below n: the drive changes its sign each time,
so that a level enters neighbours with opposite signs. Their mean over all j is the estimate. Half periods with a
missing sample are left out, with the sums that they are in.

Generalised least squares with white noise, 1/f noise and a random walk: a check of estimate and uncertainty.

The record is drive, a straight line and noise whose three parts are found by restricted maximum likelihood: only
contrasts enter that a straight line does not see, of which 1/f noise and random walks have a variance. Then the drive
is fitted with the covariance found. Where drift is no such noise (a thermostat's saw-tooth) the uncertainty is too
large, so this is the check and not the estimate. Time is of order n^3: for short records.

References
----------
.. [1] H. E. Swanson and S. Schlamminger, Meas. Sci. Technol. 21 (2010) 115104, arXiv:1009.1894.
.. [2] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320 (restricted maximum likelihood).
.. [3] G. Matheron, Adv. Appl. Prob. 5 (1973) 439 (generalised covariances).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...statistics.slow_noise import flicker_covariance, walk_covariance
from .drive import Drive
from .fit import LineFit

MOST = 3.0  # standard deviations of a difference
SMALL = 1e-3  # of the uncertainty of the fit: a smaller difference is none
ORDER = 2  # differences of three half periods
EVEN = 1e-3  # of a sample interval, by which samples may be off an even grid
ANTISYMMETRIC = 0.02  # of the drive's size, by which half periods may differ
LARGEST = 400  # samples
STARTS = (-4.0, 0.0, 4.0)  # of the search: ln of the slow parts over the white one, both at their mean variance
LOWEST, HIGHEST = -12.0, 16.0  # of it


@dataclass(frozen=True)
class CrossCheck:
    """Another estimate of what is in phase."""

    name: str  # ``"alternating_differences"`` or ``"generalised_least_squares"``
    # value, u: amplitude in phase and its standard uncertainty; None where it could not be made
    value: float | None = None
    u: float | None = None
    # difference, u_difference: from that of the fit, and its standard uncertainty: of the difference, noise in common
    # left out
    difference: float | None = None
    u_difference: float | None = None
    reason: str = ""  # why it could not be made

    @property
    def disagrees(self) -> bool:
        """Whether it differs by more than noise explains."""
        return (
            self.difference is not None
            and self.u_difference is not None
            and abs(self.difference) > MOST * self.u_difference
        )

    def remark(self) -> Remark:
        """Return what is said of a disagreement."""
        words = self.name.replace("_", " ")
        what = f"{words} differ from the fit by {self.difference:.3g}, noise explains {self.u_difference:.2g}"
        do = "Check the drift: one method may not remove a step, a saw-tooth or a change of the noise"
        return Remark("methods_disagree", "warning", what, do=do)


def cross_checks(found: LineFit, readings: Array) -> tuple[CrossCheck, ...]:
    """Estimate the same by alternating differences and by generalised least squares.

    Parameters
    ----------
    found : LineFit
        Of these readings.
    readings : ndarray, shape (n,)
        The first record of the fit.
    """
    x = np.asarray(readings, dtype=np.float64) - float(np.median(readings))
    checks, noise = [], None
    try:
        noise = generalised_fit(found.design.drive, x)
        checks.append(_compared("generalised_least_squares", noise.weights, found, x, noise, noise.u))
    except DataError as error:
        problem = error.problems[0]
        checks.append(CrossCheck("generalised_least_squares", reason=f"{problem.what}: {problem.why}"))
    try:
        weights = difference_weights(found.design.drive)
        checks.insert(0, _compared("alternating_differences", weights, found, x, noise, None))
    except DataError as error:
        checks.insert(0, CrossCheck("alternating_differences", reason=error.problems[0].why))
    return tuple(checks)


def _compared(
    name: str, weights: Array, found: LineFit, x: Array, noise: Generalised | None, u: float | None
) -> CrossCheck:
    value, sigma = float(weights @ x), float(found.noise[0])
    difference = value - float(found.in_phase[0])
    if noise is not None and len(x) <= LARGEST:
        own = found.weights_on(np.eye(len(x)))
        apart = weights - own
        square, spread = float(apart @ noise.covariance @ apart), float(weights @ noise.covariance @ weights)
    else:
        shared = float(found.weights_on(weights[:, None])[0])
        own_square = float((found.u_in_phase[0] / sigma) ** 2)
        spread = sigma**2 * float(weights @ weights)
        square = spread - 2.0 * sigma**2 * shared + sigma**2 * own_square
    floor = SMALL * float(found.u_in_phase[0])
    return CrossCheck(name, value, u or float(np.sqrt(max(spread, 0.0))), difference,
                      float(np.sqrt(max(square, floor**2))))  # fmt: skip


def difference_weights(drive: Drive, order: int = ORDER) -> Array:
    """Return what the estimate by differences of an order weighs each reading with, shape (n,).

    Raises
    ------
    DataError
        ``no_half_periods`` if a half period is no whole number of samples, samples are not evenly spaced but for
        gaps, the drive does not just change its sign from one half period to the next, or no sum is complete.
    """
    size = _half_period(drive)
    at = np.round((drive.times - drive.times[0]) / drive.step).astype(np.int64)
    n = int(at[-1]) + 1
    count = n // size
    signal, there = np.zeros(n), np.zeros(n, dtype=np.bool_)
    signal[at], there[at] = drive.in_phase, True
    halves = signal[: count * size].reshape(count, size)
    complete = there[: count * size].reshape(count, size).all(axis=1)
    sums = np.convolve(complete, np.ones(order + 1), "valid") > order + 0.5
    if not sums.any():
        raise _impossible(f"no {order + 1} half periods in a row are complete")
    sign = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    pattern = _pattern(halves[complete] * sign[complete, None])
    binomial = special.comb(order, np.arange(order + 1)) / 2.0**order
    share = np.convolve(sums / sums.sum(), binomial)
    spread = np.zeros(n)
    spread[: count * size] = ((share * sign)[:, None] * pattern / (pattern @ pattern)).ravel()
    return np.asarray(spread[at])


def _half_period(drive: Drive) -> int:
    """Return the samples of a half period."""
    ticks = (drive.times - drive.times[0]) / drive.step
    size = 0.5 / (drive.frequency * drive.step)
    if np.abs(ticks - np.round(ticks)).max() > EVEN or round(size) < 1:
        raise _impossible("samples are not evenly spaced")
    if abs(size - round(size)) * drive.cycles * 2.0 > EVEN * len(ticks) or abs(size - round(size)) > EVEN:
        raise _impossible(f"a half period is {size:.6g} samples")
    return round(size)


def _pattern(halves: Array) -> Array:
    """Drive of a half period, its sign aside; every other half period is given with its sign changed."""
    mean = halves.mean(axis=0)
    if not np.abs(halves - mean).max() < ANTISYMMETRIC * np.abs(mean).max():
        raise _impossible("the drive does not just change its sign from one half period to the next")
    return np.asarray(mean)


def _impossible(why: str) -> DataError:
    return DataError("cannot form alternating differences", why=why, code="no_half_periods")


@dataclass(frozen=True, eq=False)
class Generalised:
    """Estimate in phase, with the weights and the covariance behind it."""

    # value, u: amplitude in phase and its standard uncertainty, the noise taken as found
    value: float
    u: float
    weights: Array  # of the readings, shape (n,)
    covariance: Array  # generalised, of the readings: for weights that add up to 0, shape (n, n)


def generalised_fit(drive: Drive, readings: Array) -> Generalised:
    """Fit a drive to readings, shape (n,), all finite, with noise that the record shows.

    Raises
    ------
    DataError
        ``too_long`` above 400 samples.
    """
    n = len(readings)
    if n > LARGEST:
        raise DataError(f"{n} samples", why=f"noise can be estimated from at most {LARGEST}", code="too_long")
    place = 2.0 * (drive.times - drive.times[0]) / drive.span - 1.0
    rest = np.linalg.qr(np.column_stack([np.ones(n), place]), mode="complete")[0][:, 2:]
    parts = [rest.T @ part @ rest for part in _slow(drive)]
    line = [drive.in_phase] if drive.quadrature is None else [drive.in_phase, drive.quadrature]
    columns = rest.T @ np.column_stack([*line, readings])
    logs = _likeliest_parts(parts, columns)
    shape = np.eye(n - 2) + sum(np.exp(q) * part for q, part in zip(logs, parts, strict=True))
    _, level = _cost(shape, columns)
    return _estimate(drive, readings, rest, level * shape, columns[:, :-1])


def _slow(drive: Drive) -> list[Array]:
    """Covariances of 1/f noise and a random walk, of unit mean variance of a contrast of the record."""
    found = []
    for kind in (flicker_covariance, walk_covariance):
        covariance = kind(drive.times - drive.times[0], drive.step)
        centred = covariance - covariance.mean(axis=0)
        centred -= centred.mean(axis=1, keepdims=True)
        found.append(covariance / np.trace(centred) * len(covariance))
    return found


def _likeliest_parts(parts: list[Array], columns: Array) -> NDArray[np.float64]:
    """Logarithms of both slow parts over the white one, of greatest restricted likelihood."""
    from scipy import optimize  # noqa: PLC0415 - heavy import, which most commands need not wait for

    def cost(q: Array) -> float:
        logs = np.clip(q, LOWEST, HIGHEST)
        shape = np.eye(len(columns)) + np.exp(logs[0]) * parts[0] + np.exp(logs[1]) * parts[1]
        return _cost(shape, columns)[0] + float(np.sum((q - logs) ** 2))

    starts = [np.array([a, b]) for a in STARTS for b in STARTS]
    best = min(starts, key=cost)
    found = optimize.minimize(cost, best, method="Nelder-Mead", options={"xatol": 0.02, "fatol": 1e-3, "maxfev": 120})
    return np.asarray(np.clip(found.x, LOWEST, HIGHEST))


def _cost(shape: Array, columns: Array) -> tuple[float, float]:
    """Minus the restricted log likelihood, and the level of the noise."""
    root = linalg.cholesky(shape, lower=True, check_finite=False)
    white = linalg.solve_triangular(root, columns, lower=True, check_finite=False)
    basis, upper = np.linalg.qr(white[:, :-1])
    free = len(columns) - basis.shape[1]
    square = float(white[:, -1] @ white[:, -1] - np.sum((basis.T @ white[:, -1]) ** 2))
    level = max(square, np.finfo(float).tiny) / free
    logs = float(np.sum(np.log(np.diag(root))) + np.sum(np.log(np.abs(np.diag(upper)))))
    return logs + 0.5 * free * float(np.log(level)), level


def _estimate(drive: Drive, readings: Array, rest: Array, covariance: Array, line: Array) -> Generalised:
    solved = linalg.solve(covariance, line, assume_a="pos")
    cofactors = linalg.inv(line.T @ solved)
    weights = rest @ (solved @ cofactors[:, 0])
    of_readings = rest @ covariance @ rest.T
    return Generalised(float(weights @ readings), float(np.sqrt(cofactors[0, 0])), weights, of_readings)
