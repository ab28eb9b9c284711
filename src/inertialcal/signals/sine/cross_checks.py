"""Other estimates of the same record beside the fit, and whether they agree with it.

Both are sums of the same readings with other weights, so they share most of their noise with the fit: what may differ
is the noise in the difference of the weights, far less than their uncertainties together. It is that of the noise found
with the fit; where the fit takes the scatter of its stretches, white noise with the density at the drive. More than
three standard deviations of that difference is called a disagreement.

Another length of the smoothing: drift that is smooth over 1.25 periods of the drive is mostly smooth over 1.5, and no
part of the amplitude. Where the amplitude depends on the length, drift is not smooth: a sine of less than two periods
of the drive is found before it matters, a kink or a corner is not.

Amplitude from alternating differences of half periods: a check that needs no model of drift.

The record is cut into half periods of the drive; each gives ``u_j``, the mean of its readings weighted by the drive,
over the mean of the drive's square. Of half periods one after another the sums::

    sum over k = 0 ... n of C(n, k) u_(j+k) / 2^n

keep the amplitude and take out drift that is a polynomial of a degree below n [1]_: the drive changes its sign each
time, so that a level enters neighbours with opposite signs. Their mean over all j is the estimate. Half periods with a
missing sample are left out, with the sums that they are in.

Generalised least squares: the drive, a cubic and the same smooth drift, in the noise that was found in place of white
noise. Where a random walk is strong it knows the amplitude better than the fit, whose weights are fixed.

References
----------
.. [1] H. E. Swanson and S. Schlamminger, Meas. Sci. Technol. 21 (2010) 115104, arXiv:1009.1894.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from .drive import Drive
from .fit import LineFit
from .smooth import LENGTH

FALSE = 0.01  # chance of a change with the smoothing by noise alone
LARGE = 0.7  # of the uncertainty: a smaller change with the smoothing is none
MOST = 3.0  # standard deviations of a difference
SMALL = 1e-3  # of the uncertainty of the fit: a smaller difference is none
ORDER = 8  # differences of nine half periods
PART = 4  # half periods for each order, in a short record
EVEN = 1e-3  # of a sample interval, by which samples may be off an even grid
ANTISYMMETRIC = 0.02  # of the drive's size, by which half periods may differ


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
        what = f"{words} differ from the fit by {number(self.difference or 0.0, 3)},"
        what += f" noise explains {number(self.u_difference or 0.0, 2)}"
        do = "Check the drift: one method may not remove a step, a saw-tooth or a change of the noise"
        return Remark("methods_disagree", "warning", what, do=do)


def smoothing_remark(shifts: Sequence[tuple[float, float, float, float]], value: float, u: float) -> Remark | None:
    """Return what is said of an amplitude that depends on the length of the smoothing; None where it does not.

    A change counts that noise explains in one of a hundred records, and that is as large as the uncertainty: drift that
    enters the amplitude enters that with a longer smoothing more.

    Parameters
    ----------
    shifts : sequence of (length, value, u, dof)
        Changes of the amplitude with other lengths [periods of the drive].
    value, u : float
        The amplitude and its standard uncertainty by noise.
    """
    found = []
    for length, change, u_change, dof in shifts:
        chance = 2.0 * len(shifts) * float(special.stdtr(dof, -abs(change) / u_change))
        if chance < FALSE and abs(change) > LARGE * u:
            found.append((abs(change), length, u_change))
    if not found:
        return None
    change, length, u_change = max(found)
    part = f"{number(100.0 * change / abs(value), 2)} %" if value else number(change, 2)
    what = f"the amplitude changes by {part} if drift is smooth over {length:g} periods of the drive in place of"
    what += (
        f" {LENGTH:g}: {number(change / u, 2)} times its uncertainty, {number(change / u_change, 2)} times the noise"
    )
    do = "Drift has parts near the frequency of the drive: find them, or drive at another frequency"
    return Remark("drift_near_drive", "error", what, do=do)


def cross_checks(found: LineFit, readings: Array) -> tuple[CrossCheck, ...]:
    """Estimate the same by alternating differences and by generalised least squares.

    Parameters
    ----------
    found : LineFit
        Of these readings.
    readings : ndarray, shape (n,)
        The first record of the fit.
    """
    design, noise = found.design, found.found
    checks = []
    try:
        checks.append(_compared("alternating_differences", difference_weights(design.drive), found, readings))
    except DataError as error:
        checks.append(CrossCheck("alternating_differences", reason=error.problems[0].why))
    name, cells = "generalised_least_squares", len(design.counts)
    if noise is None or len(design.stretches) > 1 or cells < len(design.cell):
        why = f"{len(design.cell)} samples: the fit is made in stretches, or of means"
        return (*checks, CrossCheck(name, reason=why))
    one = design.stretches[0]
    share = max(float(noise.share @ noise.chance[:, 0]), 0.0)
    walk = one.walk + 0.5 * np.ptp(one.times) / one.step  # no weight sees the constant, which makes it positive
    covariance = (1.0 - share) * np.eye(cells) + share / noise.unit * walk
    return (*checks, _compared(name, one.weights(noise=covariance)[0], found, readings))


def _compared(name: str, weights: Array, found: LineFit, readings: Array) -> CrossCheck:
    x = np.asarray(readings, dtype=np.float64)
    value = float(weights @ (x - np.median(x)))
    difference = value - float(found.in_phase[0])
    floor = SMALL * float(found.u_in_phase[0])
    each = [found.u_of(one) for one in (weights, weights - found.weights)]
    return CrossCheck(name, value, each[0], difference, max(each[1], floor))


def difference_weights(drive: Drive, order: int | None = None) -> Array:
    """Return what the estimate by differences of an order weighs each reading with, shape (n,).

    By default the order is 8, in a short record a quarter of its half periods.

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
    order = min(ORDER, max(count // PART, 2)) if order is None else order
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
