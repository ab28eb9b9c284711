"""Generalised least squares with white noise, 1/f noise and a random walk: a check of estimate and uncertainty.

The record is drive, a straight line and noise whose three parts are found by restricted maximum likelihood: only
contrasts enter that a straight line does not see, of which 1/f noise and random walks have a variance. Then the drive
is fitted with the covariance found. Where drift is no such noise (a thermostat's saw-tooth) the uncertainty is too
large, so this is the check and not the estimate. Time is of order n^3: for short records.

References
----------
.. [1] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320 (restricted maximum likelihood).
.. [2] G. Matheron, Adv. Appl. Prob. 5 (1973) 439 (generalised covariances).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ...core.errors import DataError
from ...core.estimate import Array
from ...statistics.slow_noise import flicker_covariance, walk_covariance
from .drive import Drive

LARGEST = 400  # samples
STARTS = (-4.0, 0.0, 4.0)  # of the search: ln of the slow parts over the white one, both at their mean variance
LOWEST, HIGHEST = -12.0, 16.0  # of it


@dataclass(frozen=True, eq=False)
class Generalised:
    """Estimate in phase, with the weights and the covariance behind it."""

    # value, u: amplitude in phase and its standard uncertainty, the noise taken as found
    value: float
    u: float
    weights: Array  # of the readings, shape (n,)
    covariance: Array  # generalised, of the readings: for weights that add up to 0, shape (n, n)


def generalised_fit(drive: Drive, readings: Array) -> Generalised:
    """Fit a drive with noise that is told from the record.

    Parameters
    ----------
    drive : Drive
        At the samples of the readings.
    readings : ndarray, shape (n,)
        All finite.

    Raises
    ------
    DataError
        ``too_long`` above 400 samples.
    """
    n = len(readings)
    if n > LARGEST:
        raise DataError(f"{n} samples", why=f"noise is told from {LARGEST} or fewer", code="too_long")
    place = 2.0 * (drive.times - drive.times[0]) / drive.span - 1.0
    rest = np.linalg.qr(np.column_stack([np.ones(n), place]), mode="complete")[0][:, 2:]
    parts = [rest.T @ part @ rest for part in _slow(drive)]
    line = [drive.in_phase] if drive.quadrature is None else [drive.in_phase, drive.quadrature]
    columns = rest.T @ np.column_stack([*line, readings])
    logs = _found(parts, columns)
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


def _found(parts: list[Array], columns: Array) -> NDArray[np.float64]:
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


__all__ = ["LARGEST", "Generalised", "generalised_fit"]
