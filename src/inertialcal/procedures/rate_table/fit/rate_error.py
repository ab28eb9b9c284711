"""Error of rate: how far a reading is from the true rate, in percent of it, rate by rate.

At each signed rate of a sensor's own axis, ``error = (reading - applied) / applied``, positive when the sensor
reads too much (the NPS thesis prints the opposite sign). Three things can be asked for, and they are not the
same:

expected
    the mean error at that rate: uncertainty from the scatter over the number of runs (or dwells) there;
dwell_mean
    the error of the mean over one new dwell in a new run: that scatter once more;
reading
    the error of a single sample: the scatter within a dwell once more.

Where a rate was met in two or more runs, the scatter of the runs' means at that rate gives the uncertainty, with one
degree of freedom fewer than there are runs: scale factors that differ from run to run make it grow with the rate, and
no assumption is needed. Where each rate belongs to one run, as in the NPS thesis, the scatter is pooled from all
rates (it is a scatter of readings, not of percentages), which takes it as independent of the rate. Type B terms of
the table rate, the converter reference and the earth rate enter in full.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array, joined_dof
from ....core.key import AXES
from ..plan import Plan
from ..readings import Readings
from .quantities import matrix_entry
from .regression import Line, dwell_variance

Of = Literal["expected", "dwell_mean", "reading"]


@dataclass(frozen=True)
class RateError:
    """Error at one signed rate."""

    sensor: str  # Axis of the sensor
    applied: float  # Rate of the table [rad/s]
    error: float | None  # Relative error (1); None where every dwell at this rate was left out
    u: float | None  # Standard uncertainty of it (1)
    dof: float  # Degrees of freedom of ``u``
    dwells: int  # Behind the mean
    runs: int  # Behind the mean
    largest: float  # Largest absolute error of a single dwell at this rate, left out or not (1)
    reason: str = ""  # Why there is no error, or no uncertainty


def rate_errors(plan: Plan, everything: Readings, one: Line, of: Of = "dwell_mean") -> tuple[RateError, ...]:
    """Return the error of one sensor at each rate of its own axis, rest left out, by rising rate.

    Raises
    ------
    DataError
        If ``of`` is not one of the three.
    """
    if of not in ("expected", "dwell_mean", "reading"):
        raise DataError(f"of = {of!r}", do="There are: expected, dwell_mean, reading")
    s = one.sensor
    asked = everything.take((everything.axis == s) & (everything.applied != 0.0))
    used = one.readings
    found = []
    for rate in np.unique(asked.applied):
        read = asked.outputs[s][asked.applied == rate]
        all_errors = np.abs(read[np.isfinite(read)] / rate - 1.0)  # as the thesis has them
        at = (used.axis == s) & (used.applied == rate)
        found.append(_at_rate(plan, one, float(rate), used.take(at), of, float(all_errors.max(initial=0.0))))
    return tuple(found)


def _at_rate(plan: Plan, one: Line, rate: float, here: Readings, of: Of, largest: float) -> RateError:
    sensor = one.sensor
    if not len(here):
        return RateError(
            sensor,
            rate,
            None,
            None,
            np.nan,
            0,
            0,
            largest,
            "no reading at this rate: every dwell was left out, or is empty",
        )
    errors = (
        here.outputs[sensor] - (np.zeros(len(here)) if here.earth is None else here.earth[:, AXES.index(sensor)]) - rate
    )
    mean, found = _spread_of_runs(one, here, errors, of) if here.runs >= 2 else _pooled(one, here, errors, of)
    error = mean / rate
    if found is None:
        reason = "no level of scatter that this needs was repeated or given"
        return RateError(sensor, rate, error, None, np.nan, len(here), here.runs, largest, reason)
    type_a, dof = found[0] / rate**2, found[1]
    parts = [(type_a, dof), *_type_b(plan, one, 1.0 + error), (_earth_variance(here, sensor) / rate**2, np.inf)]
    variance = sum(part for part, _ in parts)
    known = float(joined_dof([np.array(part) for part, _ in parts], [d for _, d in parts]))
    return RateError(sensor, rate, error, float(np.sqrt(variance)), known, len(here), here.runs, largest)


Spread = tuple[float, float] | None  # variance [(rad/s)^2] and its degrees of freedom


def _spread_of_runs(one: Line, here: Readings, errors: Array, of: Of) -> tuple[float, Spread]:
    """Mean of the runs' means at one rate, and what scatters about it."""
    _, at = np.unique(np.asarray(here.run), return_inverse=True)
    dwells = np.bincount(at)
    means = np.bincount(at, errors) / dwells
    runs = len(means)
    square, dof = float(np.var(means, ddof=1)), runs - 1.0
    if of == "expected":
        return float(means.mean()), (square / runs, dof)
    dwell = next(level for level in one.levels if level.name == "dwell")
    share = 1.0 - float(np.mean(1.0 / dwells))  # of the dwell scatter, that the mean of a run's dwells lacks
    parts = [(square * (1.0 + 1.0 / runs), dof)]
    if share > 0.0 and dwell.std is not None:
        parts.append((share * dwell.std**2, dwell.dof))
    return float(means.mean()), _with_samples(one, parts, of)


def _pooled(one: Line, here: Readings, errors: Array, of: Of) -> tuple[float, Spread]:
    """Mean of the dwells at one rate, and the scatter of all rates."""
    readings = one.readings
    total = dwell_variance(one.levels, len(readings) / readings.runs if readings.runs else 1.0)
    mean = float(np.mean(errors))
    if total is None:
        return mean, None
    scale = 1.0 / (here.runs or len(here)) + (0.0 if of == "expected" else 1.0)
    return mean, _with_samples(one, [(total[0] * scale, total[1])], of)


def _with_samples(one: Line, parts: list[tuple[float, float]], of: Of) -> Spread:
    """Join the parts, with the scatter within a dwell where single readings are asked for."""
    if of == "reading":
        sample = next(level for level in one.levels if level.name == "sample")
        if sample.std is None:
            return None
        parts = [*parts, (sample.std**2, sample.dof if np.isfinite(sample.dof) else np.inf)]
    whole = sum(part for part, _ in parts)
    return whole, float(joined_dof([np.array(part) for part, _ in parts], [dof for _, dof in parts]))


def _type_b(plan: Plan, one: Line, gain: float) -> list[tuple[float, float]]:
    """Variances of the relative error from the standards (1), with their degrees of freedom."""
    parts = []
    for name in ("rate_table.rate", "converter.reference"):
        influence = plan.standards.get(name)
        if influence is not None:
            parts.append(((gain * influence.u) ** 2, influence.dof))
    mounting = plan.standards.get("rate_table.mounting")
    if mounting is not None:
        others = sum(matrix_entry(one, axis) ** 2 for axis in AXES if axis != one.sensor)
        parts.append((others * mounting.u**2 + 2.0 * mounting.u**4, mounting.dof))
    return parts


def _earth_variance(here: Readings, sensor: str) -> float:
    """Return the variance of the mean earth rate along the sensor's axis [(rad/s)^2]."""
    means = [patterns[:, :, AXES.index(sensor)].mean(axis=1) for patterns in here.earth_sources.values()]
    return float(sum(float(mean @ mean) for mean in means))


@dataclass(frozen=True)
class Resolution:
    """Lowest rate from which a requirement on the error holds."""

    value: float | None  # That rate [rad/s]; None where it does not hold at the highest rate either
    below: float | None  # Next lower rate tested, where it does not hold; None where ``value`` is the lowest tested

    @property
    def u(self) -> float | None:
        """Standard uncertainty [rad/s]: the limit lies anywhere between the two rates (rectangular)."""
        if self.value is None or self.below is None:
            return None
        return (self.value - self.below) / float(np.sqrt(12.0))


def resolution(rates: Array, holds: Array) -> Resolution:
    """Find the lowest rate from which on upward the requirement holds at every rate, both senses.

    Parameters
    ----------
    rates : ndarray, shape (n,)
        Signed rates [rad/s].
    holds : ndarray of bool, shape (n,)
        Whether the requirement holds there.
    """
    sizes = np.unique(np.round(np.abs(rates), 15))
    good = [bool(np.all(np.asarray(holds, dtype=bool)[np.isclose(np.abs(rates), size, rtol=1e-9)])) for size in sizes]
    first = len(good)
    while first > 0 and good[first - 1]:
        first -= 1
    value = float(sizes[first]) if first < len(good) else None
    return Resolution(value, float(sizes[first - 1]) if first > 0 else None)
