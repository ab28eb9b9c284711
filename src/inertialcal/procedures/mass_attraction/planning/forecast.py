"""Forecast of a mass-attraction test: uncertainty of the scale factor against hours, for a noise and a drive.

Means over the dwells are taken as::

    y = offset (+ line) + scale factor * applied + noise

all in the unit of the acceleration. The scale factor is that of generalised least squares with a free offset (and line,
if the noise has a ramp), for a noise that is known. Its relative variance is ``1 / (s' W s)``; s is what is applied, W
the inverse covariance of the dwell means with the offset projected out. Random walk and flicker have no covariance
themselves, but the differences of neighbouring dwells have one, and an offset leaves only these; it is exact for means
over a dwell with pauses between them (`sensors.noise`).

Up to ``EXACT`` dwells this is solved as it stands. Beyond, each further cycle adds what the last half of them added on
average: a drive has a frequency, and noise there does not change with the length of the record.

The uncertainty of what is applied is the same in every cycle, and does not decrease. Times are those of whole cycles.
The result is the standard deviation of scale factors from such tests; a real test has to estimate its noise too, and
loses a little by that.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg

from ....core.errors import DataError, InertialcalError, PlanError
from ....core.estimate import Array
from ....core.results import Row
from ....core.units import factor
from ....files.source import load
from ....sensors.noise import (
    BiasInstability,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Term,
    parameter_unit,
    quantity_name,
)
from ....sensors.noise.terms import Phase, total_phase
from .settings import Noise

EXACT = 1024  # dwells
LONGEST = 2**40  # cycles


@dataclass(frozen=True)
class Cycle:
    """One cycle: what each dwell applies [m/s^2], length of a dwell and of a move [s]."""

    applied: tuple[float, ...]
    dwell: float
    move: float

    def __post_init__(self) -> None:
        if len(self.applied) < 2 or not np.ptp(self.applied) > 0.0:
            raise PlanError("a cycle needs two or more dwells that apply different accelerations", code="schedule")
        if not (self.dwell > 0.0 and self.move >= 0.0):
            raise PlanError(f"a dwell of {self.dwell:g} s with moves of {self.move:g} s", code="schedule")

    @property
    def period(self) -> float:
        """[s]."""
        return len(self.applied) * (self.dwell + self.move)


@dataclass(frozen=True, eq=False)
class Forecast:
    """Uncertainty of the scale factor against time."""

    time: Array  # shape (n,): of whole cycles [s]
    u_noise: Array  # shape (n,): from the noise, relative [1]
    u_applied: float = 0.0  # From what is applied, relative [1]

    @property
    def u(self) -> Array:
        """From both, relative, shape (n,) [1]."""
        return np.hypot(self.u_noise, self.u_applied)


def forecast(cycle: Cycle, terms: Sequence[Term], times: ArrayLike, *, u_applied: float = 0.0) -> Forecast:
    """Return the relative standard uncertainty of the scale factor after each time.

    Parameters
    ----------
    cycle : Cycle
        Of the drive.
    terms : sequence of Term
        Noise of the sensor [m/s^2].
    times : array_like, shape (n,)
        Rounded down to whole cycles, at least one [s].
    u_applied : float
        Relative standard uncertainty of the amplitude [1].

    Raises
    ------
    PlanError
        If there is no noise.
    """
    cycles = np.maximum(np.floor(np.atleast_1d(np.asarray(times, dtype=float)) / cycle.period + 1e-9), 1.0)
    found = np.array([relative_noise(cycle, tuple(terms), int(count)) for count in cycles])
    return Forecast(cycles * cycle.period, found, u_applied)


def relative_noise(cycle: Cycle, terms: tuple[Term, ...], cycles: int, line: bool = False) -> float:
    """Return the relative standard uncertainty of the scale factor from the noise alone after so many cycles [1]."""
    information = _information(cycle, terms, cycles, line)
    return 1.0 / math.sqrt(information) if information > 0.0 else math.inf


def time_to(cycle: Cycle, terms: Sequence[Term], target: float, *, u_applied: float = 0.0) -> float | None:
    """Return the time of whole cycles after which the relative uncertainty is at most the target [s].

    None if no time is enough, because the uncertainty of what is applied exceeds the target.
    """
    if not target > u_applied:
        return None
    wanted = math.sqrt(target**2 - u_applied**2)
    high = 1
    while relative_noise(cycle, tuple(terms), high) > wanted:
        high *= 2
        if high > LONGEST:
            return None
    low = high // 2
    while high - low > 1:
        middle = (low + high) // 2
        enough = relative_noise(cycle, tuple(terms), middle) <= wanted
        low, high = (low, middle) if enough else (middle, high)
    return high * cycle.period


def takeover(cycle: Cycle, terms: Sequence[Term], u_applied: float) -> float | None:
    """Return the time after which the uncertainty of what is applied dominates [s]; None if it is zero."""
    return time_to(cycle, terms, math.sqrt(2.0) * u_applied, u_applied=u_applied) if u_applied else None


@lru_cache(512)
def _information(cycle: Cycle, terms: tuple[Term, ...], cycles: int, line: bool) -> float:
    """Inverse of the relative variance after so many cycles."""
    ramps = [isinstance(term, RateRamp) for term in terms]
    if all(ramps):
        raise PlanError(
            "no noise is given" + (" but a ramp" if ramps else ""),
            why="without noise any test is exact",
            do="Give white noise, flicker or random walk",
            code="no_noise",
        )
    line = line or any(ramps)
    most = max(EXACT // len(cycle.applied), 2)
    if cycles <= most:
        return _solved(cycle, terms, cycles, line)
    half, whole = (_information(cycle, terms, count, line) for count in (most // 2, most))
    return whole + (cycles - most) * (whole - half) / (most - most // 2)


def _solved(cycle: Cycle, terms: tuple[Term, ...], cycles: int, line: bool) -> float:
    """Generalised least squares of the differences of neighbouring dwells."""
    applied = np.diff(np.tile(np.array(cycle.applied), cycles))
    noise = total_phase(
        tuple(term for term in terms if not isinstance(term, RateRamp)), cycle.dwell + cycle.move, cycle.dwell
    )
    covariance = difference_covariance(noise, len(applied))
    design = np.column_stack([applied, np.ones((len(applied), int(line)))])
    solved = np.atleast_2d(linalg.solve_toeplitz(covariance, design))
    normal = design.T @ solved
    if not line:
        return float(normal[0, 0])
    if len(applied) < len(normal) or not normal[1, 1] > 0.0:
        return 0.0
    return float(normal[0, 0] - normal[0, 1] ** 2 / normal[1, 1])


def difference_covariance(noise: Phase, count: int) -> Array:
    """Return the covariance of differences of neighbouring samples at lags 0 to count - 1, shape (count,) [unit^2].

    Differences of samples are second differences of their running sum, whose covariance the noise gives.
    """
    C = noise.covariance(np.abs(np.arange(-2.0, count + 2.0)))
    found: Array = C[:-4] - 4.0 * C[1:-3] + 6.0 * C[2:-2] - 4.0 * C[3:-1] + C[4:]
    return found


KINDS: tuple[type[Any], ...] = (Quantization, RandomWalk, BiasInstability, RateRandomWalk, RateRamp)


NAMED = {quantity_name(kind.name, "coefficient", "accelerometer"): kind for kind in KINDS}


MAKE = "Write one with: inertialcal allan FILE --json > noise.json"


def terms_of(noise: Noise) -> tuple[Term, ...]:
    """Return the terms whose coefficients are given [m/s^2]."""
    given = {kind: getattr(noise, name) for name, kind in NAMED.items()}
    return tuple(kind(size) for kind, size in given.items() if size is not None)


def noise_from(path: Path, axis: str | None) -> tuple[tuple[Term, ...], str, str]:
    """Return the terms of one axis of a file [m/s^2], the axis, and the hash of the file.

    Raises
    ------
    DataError
        If the file is not output of `allan --json` or a run, or has no noise of an accelerometer.
    PlanError
        If it has several axes and none is chosen.
    """
    loaded, where = load(path, document=True), str(path)
    try:
        rows = [Row.from_dict(row) for row in json.loads(loaded.data)["results"]]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DataError("not output of allan --json or run", where, do=MAKE, code="schema") from None
    found: dict[str, dict[str, Term]] = {}
    for row in rows:  # the first row of each term counts: later ones are the same in other units
        kind = NAMED.get(row.key.quantity)
        if kind is None or row.status != "estimated" or not row.case.plain or not row.value:
            continue
        try:
            size = row.value * factor(row.unit, parameter_unit(kind.name, "coefficient", "m/s^2"))
        except InertialcalError:
            continue  # of a gyro, or without a known unit
        found.setdefault(row.axis, {}).setdefault(kind.name, kind(abs(size)))
    if not found:
        raise DataError("no estimated noise term of an accelerometer", where, do=MAKE, code="no_noise")
    if (len(found) > 1) if axis is None else (axis not in found):
        what = f"no noise of axis {axis!r}" if axis else f"noise of {len(found)} axes"
        raise PlanError(what, where, do=f"Set noise.axis to one of: {', '.join(found)}", code="axis")
    chosen = axis or next(iter(found))
    return tuple(found[chosen].values()), chosen, loaded.sha256
