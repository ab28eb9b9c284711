"""Allan variance from a spectrum, and whether a measured one agrees with it.

Means over m samples next to each other have the Allan variance [1]_::

    avar(m) = integral from 0 to 1/(2 dt) of S(f) 2 sin^4(pi f m dt) / (m sin(pi f dt))^2 df

exactly, for the one-sided density S of the samples as they are, whatever their averaging time. Below the lowest
frequency of the spectrum the density is continued with the slope that its lowest values have; where that part is more
than a tenth the spectrum cannot tell, and the time is not compared.

The test. Both variances are about chi-square over their degrees of freedom, so their ratio is compared with Fisher's F,
at the false-alarm probability divided by the number of times (Bonferroni). Both come from one record and share its
noise: the test is then on the safe side, false alarms are rarer than stated. An allowance covers what the smoothing by
the window does to a steep spectrum.

References
----------
.. [1] J. A. Barnes et al., IEEE Trans. Instrum. Meas. IM-20 (1971) 105-120, eq. (23) for means of samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ..allan.channel import Allan
from .density import Spectrum

MOST_CONTINUED = 0.1  # of the variance, from below the lowest frequency
SLOPE = (-2.5, 1.0)  # that a continued spectrum may have
LOWEST = 16  # values that give the slope
SHORT = 200_000  # frequencies and averaging times whose sums take less time than the start of a compiler
ALLOWED = 0.05  # relative difference of the variances that is no disagreement


@dataclass(frozen=True, eq=False)
class SpectralAllan:
    """Allan deviation that a spectrum means."""

    tau: Array  # averaging times [s], shape (k,)
    # deviation, edf: deviation [unit], and equivalent degrees of freedom of its square, shape (k, axes)
    deviation: Array
    edf: Array
    continued: Array  # part of the variance from below the lowest frequency of the spectrum, shape (k, axes)


def allan_of_spectrum(spectrum: Spectrum, tau: Array) -> SpectralAllan:
    """Return the Allan deviation that a spectrum of rates or accelerations means at averaging times, shape (k,) [s].

    Raises
    ------
    DataError
        If a time is no whole multiple of the sample interval.
    """
    times = np.asarray(tau, dtype=np.float64)
    m = np.round(times / spectrum.interval)
    if np.any(m < 1) or np.any(np.abs(m * spectrum.interval - times) > 1e-6 * times):
        raise DataError(
            f"averaging times {times} s are not all whole multiples of {spectrum.interval:g} s",
            do="Give multiples of the sample interval",
            code="bad_taus",
        )
    with np.errstate(invalid="ignore"):
        return _meant(spectrum, times, m.astype(np.int64))


def _meant(spectrum: Spectrum, times: Array, m: NDArray[np.int64]) -> SpectralAllan:
    """Return the deviation at averaging times that are so many samples, shape (k,)."""
    inside, spread = _summed(spectrum, m)
    outside = _continued(spectrum) * (m[:, None] * spectrum.interval) ** 2
    variance = inside + outside
    edf = spectrum.edf * inside**2 / spread
    return SpectralAllan(times, np.sqrt(variance), edf, outside / variance)


def _summed(spectrum: Spectrum, m: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the Allan variance at m samples of the density as it is, and its scatter squared, shape (k, axes).

    The latter is that of values with a scatter of their own size.

    Frequencies are whole multiples k of 1 over the n samples of a segment, and sin^2(pi k / n) has the period n in k:
    all sines that any m needs stand in one table, taken at whole numbers without the rounding of large angles.
    """
    from ._kernels import fill_sums, sums_of_windows  # noqa: PLC0415 - numba starts slowly

    n = spectrum.segment
    inside, spread = np.empty((2, spectrum.density.shape[1], len(m)))
    if len(spectrum.frequency) * len(m) <= SHORT:
        windows = _windows(n, spectrum.spacing, spectrum.frequency.tobytes(), m.tobytes())
        for axis, density in enumerate(spectrum.density.T):
            fill_sums(windows, density, spectrum.neighbours, inside[axis], spread[axis])
        return inside.T, spread.T
    order, fourth = np.rint(spectrum.frequency / spectrum.spacing).astype(np.int64), _sines(n)
    below = np.sqrt(fourth[order])
    for axis, density in enumerate(spectrum.density.T):
        level = density * (2.0 * spectrum.spacing / below)
        sums_of_windows(level, fourth, order, m, spectrum.neighbours, inside[axis], spread[axis])
    return inside.T, spread.T


@lru_cache(maxsize=2)  # records of one length share them
def _windows(n: int, spacing: float, frequency: bytes, m: bytes) -> Array:
    """Return the response of m samples at frequencies, times their spacing, shape (k, frequencies); not to be changed.

    Frequencies are whole multiples of the spacing.
    """
    fourth, at = _sines(n), np.rint(np.frombuffer(frequency) / spacing).astype(np.int64)
    size = np.frombuffer(m, np.int64)[:, None]
    return np.asarray(2.0 * spacing * fourth[size * at % n] / (size.astype(np.float64) ** 2 * np.sqrt(fourth[at])))


@lru_cache(maxsize=2)
def _sines(n: int) -> Array:
    """Return the fourth powers of sin(pi k / n), shape (n,)."""
    return np.asarray(np.sin(np.pi / n * np.arange(n)) ** 4)


def _continued(spectrum: Spectrum) -> Array:
    """Variance from below the lowest frequency, for an averaging time of 1 s, shape (axes,)."""
    from ._kernels import continued  # noqa: PLC0415 - numba starts slowly

    few = spectrum.frequency[:LOWEST]
    return np.array([continued(few, own[: len(few)], spectrum.spacing, *SLOPE) for own in spectrum.density.T])


@dataclass(frozen=True, eq=False)
class Agreement:
    """A measured Allan deviation beside the one that the spectrum means."""

    tau: Array  # times compared [s], shape (k,)
    ratio: Array  # measured deviation over that of the spectrum; NaN where not compared, shape (k, axes)
    # probability of a variance ratio so far from 1, beyond the allowance; NaN where not compared, shape (k, axes)
    chance: Array
    agree: NDArray[np.bool_]  # false where any time disagrees, shape (axes,)
    compared: int  # time and axis pairs compared
    false_alarm: float  # largest probability, an axis, of a disagreement between consistent figures

    def apart(self) -> list[Agreement]:
        """Return that of each axis by itself."""
        many = np.count_nonzero(np.isfinite(self.chance), axis=0).tolist()
        each = zip(self.ratio.T[:, :, None], self.chance.T[:, :, None], self.agree[:, None], many, strict=True)
        return [Agreement(self.tau, *one, self.false_alarm) for one in each]

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """One remark an axis that disagrees, or one if nothing could be compared."""
        if not self.compared:
            what = "no averaging time is short enough to compare Allan deviation and spectrum"
            return (Remark("allan_not_compared", "info", what, do="Give longer segments of the spectrum"),)
        found = []
        for axis in (axis for axis, agree in enumerate(self.agree.tolist()) if not agree):
            worst = int(np.nanargmin(self.chance[:, axis]))
            what = (
                f"axis {axis}: the Allan deviation at {number(float(self.tau[worst]), 4)} s is "
                f"{number(float(self.ratio[worst, axis]), 4)} times that of the spectrum"
            )
            do = "Check for gaps, a wrong sample interval, disturbances or drift"
            found.append(Remark("allan_spectrum_disagree", "warning", what, do=do))
        return tuple(found)


def compare_allan(spectrum: Spectrum, curve: Allan, false_alarm: float = 0.01) -> Agreement:
    """Test whether a measured Allan deviation agrees with the spectrum.

    Parameters
    ----------
    spectrum : Spectrum
        Of the same record, of rates or accelerations.
    curve : Allan
        Measured, overlapping or not.
    false_alarm : float
        Probability, an axis, that consistent figures are said to disagree: at most this much.

    Returns
    -------
    Agreement
        Of every time at which the spectrum can tell.

    Raises
    ------
    DataError
        If the axes differ in number, or a time is no whole multiple of the sample interval.
    PlanError
        If the probability is not between 0 and 1.
    """
    if not 0.0 < false_alarm < 1.0:
        raise PlanError(f"false_alarm {false_alarm:g}, need a probability between 0 and 1")
    if np.shape(curve.deviation)[1:] != spectrum.density.shape[1:]:
        shapes = f"{np.shape(curve.deviation)[1:]} and {spectrum.density.shape[1:]}"
        raise DataError(f"Allan deviation and spectrum have different axes: {shapes}")
    with np.errstate(divide="ignore", invalid="ignore"):
        if curve.interval == spectrum.interval:
            meant = _meant(spectrum, curve.tau, curve.m)
        else:
            meant = allan_of_spectrum(spectrum, curve.tau)
        usable = (meant.continued < MOST_CONTINUED) & np.isfinite(curve.deviation) & (curve.edf > 0.0)
        usable &= (meant.deviation > 0.0) & np.isfinite(meant.edf)
        ratio = curve.deviation / meant.deviation
        variances = ratio * ratio
        far = usable & ((variances < 1.0 - ALLOWED) | (variances > 1.0 + ALLOWED))
    chance = usable.astype(np.float64)
    if far.any():
        one, other, scaled = curve.edf[far], meant.edf[far], variances[far]
        scaled = scaled / np.minimum(np.maximum(scaled, 1.0 - ALLOWED), 1.0 + ALLOWED)
        tail = np.minimum(special.fdtrc(one, other, scaled), special.fdtr(one, other, scaled))
        chance[far] = np.minimum(2.0 * tail, 1.0)
    if not usable.all():
        ratio[~usable] = chance[~usable] = np.nan
    tested = usable.sum(axis=0)
    agree = ~(chance < false_alarm / np.maximum(tested, 1)).any(axis=0)
    return Agreement(meant.tau, ratio, chance, agree, int(tested.sum()), false_alarm)
