"""Start-up transient of a sensor: how much its reading moves after power-up, how fast, and when it has settled.

::

    y = level of its run + A exp(-t / tau) + noise        t: since power-up

A and tau are common to all power-ups, the level is each one's own. Least squares, tau by a search over its logarithm.
With two power-ups or more the covariance of A and tau is what the power-ups disagree about (CR2 on the fit made linear
at its best tau); with one it is that of stretches of the record, a tenth each, and drift slower than a stretch is not
in it.

Whether there is a transient at all is judged apart from that fit, whose best tau would find one in any noise: a
transient of one fixed time constant, a fifth of the record, is fitted to each power-up, and Student's t over the
power-ups says whether its mean differs from zero. The test finds a transient where there is none in 5 % of all tests
(``FALSE_ALARM``), whatever the noise within a power-up: white, flicker or walk; it assumes that power-ups are alike.
With one power-up it is judged by the scatter of stretches, which noise slower than a stretch makes too small.

Three ways in which real records break this, each simulated (300 records each of a hold of 1800 s, white noise of
0.002 deg/s at 0.1 Hz): a random walk that stands out of the white noise (false alarms 5 % with two power-ups and with
five, 12 % with one); a transient that varies by 20 % from power-up to power-up (0.01 deg/s is found in 100 % with five,
42 % with two; 91 % where it does not vary); a time constant beyond the record (found; no figure is given: `resolved`).

Settled: what is left of the transient, ``|A| exp(-t / tau)``, is below a stated tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from ..core.errors import DataError
from ..core.estimate import Array
from ..statistics.clustered import clustered_contrasts
from ..statistics.least_squares import fit

FEWEST = 12  # readings of a power-up that three unknowns need
SEARCHED = (0.01, 1.0)  # of the length of the record: time constants that are looked for
GRID = 25  # of them that are tried first
STRETCHES = 10  # of a single power-up
FALSE_ALARM = 0.05  # of the test for a transient
RESOLVED = 0.9  # of the length of the record: largest time constant that is no bound of the search
SHAPE = 0.2  # of the length of the record: time constant that the test looks with


@dataclass(frozen=True, eq=False)
class WarmUp:
    """A start-up transient."""

    change: float  # A: reading at power-up less the settled one [unit of the readings]
    time_constant: float  # tau [s]
    covariance: Array  # shape (2, 2): of both
    dof: Array  # shape (2,): degrees of freedom of each; 0 where not known
    level: str  # What the covariance is made of
    p_value: float  # Of no transient
    resolved: bool  # Whether the record is long enough to show the time constant

    @property
    def identified(self) -> bool:
        """Whether the transient stands out of the noise."""
        return self.p_value < FALSE_ALARM

    def settled_after(self, tolerance: float) -> float:
        """Time after power-up from which less than the tolerance is left [s]; 0 without a transient."""
        if not self.identified or abs(self.change) <= tolerance:
            return 0.0
        return self.time_constant * math.log(abs(self.change) / tolerance)

    def u_settled_after(self, tolerance: float) -> tuple[float, float]:
        """Return the standard uncertainty of `settled_after` [s], and its degrees of freedom: the fewer of the two."""
        by_change = self.time_constant / self.change
        by_time = math.log(abs(self.change) / tolerance)
        row = np.array([by_change, by_time])
        return math.sqrt(max(float(row @ self.covariance @ row), 0.0)), float(self.dof.min())


def find_warm_up(time: Array, readings: Array, runs: NDArray[Any]) -> WarmUp:
    """Return the start-up transient of readings at a steady temperature.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Since power-up [s].
    readings : ndarray, shape (n,)
        Means of equally long stretches, in one unit.
    runs : ndarray, shape (n,)
        Power-up of each.

    Raises
    ------
    DataError
        ``too_few_readings`` if a power-up has fewer than twelve.
    """
    numbers, counts = np.unique(runs, return_inverse=True, return_counts=True)[1:]
    if not len(counts) or counts.min() < FEWEST:
        what = f"{int(counts.min()) if len(counts) else 0} readings after a power-up, need {FEWEST}"
        raise DataError(what, why="a start-up cannot be fitted", do="Record longer", code="too_few_readings")
    length = float(time.max() - time.min())
    lowest, highest = (math.log(share * length) for share in SEARCHED)
    grid = np.linspace(lowest, highest, GRID)
    left = _without_levels(readings[:, None], numbers, counts)[:, 0]

    def cost(log_tau: Array) -> Array:
        shapes = _without_levels(np.exp(-time[:, None] / np.exp(log_tau)), numbers, counts)
        along, size = left @ shapes, np.sum(shapes**2, axis=0)
        return np.asarray(left @ left - np.divide(along**2, size, out=np.zeros_like(size), where=size > 0.0))

    best = int(np.argmin(cost(grid)))
    bounds = (grid[max(best - 1, 0)], grid[min(best + 1, GRID - 1)])
    found = optimize.minimize_scalar(lambda q: float(cost(np.array([q]))[0]), bounds=bounds, method="bounded")
    levels = np.eye(len(counts))[numbers]
    return _judged(
        float(math.exp(found.x)), time, readings, numbers, levels, _p_value(time, readings, numbers, SHAPE * length)
    )


def _p_value(time: Array, readings: Array, numbers: NDArray[np.intp], tau: float) -> float:
    """Return the p value of no transient, by Student's t over power-ups; of one, over its stretches."""
    counts = np.bincount(numbers)
    shape = np.exp(-time / tau)
    if len(counts) == 1:
        found = fit(np.column_stack([shape, np.ones(len(time))]), readings)
        covariance, dof = clustered_contrasts(found, _stretches(time), np.array([[1.0, 0.0]]))
        mean, u, free = float(found.coefficients[0]), math.sqrt(float(covariance[0, 0])), float(dof[0])
    else:
        off = _without_levels(np.column_stack([shape, readings]), numbers, counts)
        sizes = np.bincount(numbers, off[:, 0] ** 2)
        each = np.bincount(numbers, off[:, 0] * off[:, 1])[sizes > 0.0] / sizes[sizes > 0.0]
        free = len(each) - 1.0
        mean, u = float(each.mean()), float(each.std(ddof=1)) / math.sqrt(len(each)) if free > 0.0 else 0.0
    if not (free > 0.0 and u > 0.0):
        return 1.0
    return 2.0 * float(special.stdtr(free, -abs(mean) / u))


def _without_levels(columns: Array, numbers: NDArray[np.intp], counts: NDArray[np.intp]) -> Array:
    """Columns less their mean in each power-up."""
    means = np.column_stack([np.bincount(numbers, column) for column in columns.T]) / counts[:, None]
    return np.asarray(columns - means[numbers])


def _stretches(time: Array) -> NDArray[np.intp]:
    return np.minimum((np.argsort(np.argsort(time)) * STRETCHES) // len(time), STRETCHES - 1)


def _judged(
    tau: float, time: Array, readings: Array, numbers: NDArray[np.intp], levels: Array, p_value: float
) -> WarmUp:
    """Covariance of A and tau from the fit made linear at its best tau."""
    shape = np.exp(-time / tau)
    change = float(fit(np.column_stack([np.exp(-time / tau), levels]), readings).coefficients[0])
    many = levels.shape[1] >= 2
    slope = change * time / tau**2 * shape
    columns = np.column_stack([shape, slope if np.ptp(slope) > 0.0 else time, levels])
    found = fit(columns, readings)
    clusters = numbers if many else _stretches(time)
    rows = np.eye(2, columns.shape[1])
    covariance, dof = clustered_contrasts(found, clusters, rows)
    return WarmUp(
        change, tau, covariance, dof, "run" if many else "stretch", p_value, tau < RESOLVED * float(np.ptp(time))
    )
