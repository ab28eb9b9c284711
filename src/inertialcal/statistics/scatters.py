"""Two standard deviations of normal readings compared: test of equality, interval of their difference.

A standard deviation is no normal value: with few degrees of freedom a t test of two of them goes wrong both ways.
The squares over one another have Fisher's F distribution where the true ones are equal [1]_. The interval of the
difference joins the exact chi-square interval of each by the method of variance estimates recovery [2]_. The ratio has
the exact interval of F; that of two sizes that have other intervals, as of a profile, joins these by the same method on
a logarithmic scale.

References
----------
.. [1] NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.5.9 (F test for equality of two variances).
.. [2] Zou and Donner, Statistics in Medicine 27 (2008) 1693-1702.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy import special

from ..core.errors import DataError
from ..core.results import Interval
from ..core.show.rounding import freedom
from .intervals import chi_square_interval, ends


class Size(NamedTuple):
    """A size with its interval."""

    value: float
    lo: float | None
    hi: float | None


def equality_p_value(first: float, first_dof: float, second: float, second_dof: float) -> float:
    """Return the two-sided p value of equal true standard deviations.

    Parameters
    ----------
    first, second : float
        Standard deviations found, in one unit.
    first_dof, second_dof : float
        Degrees of freedom behind each, finite.

    Raises
    ------
    DataError
        If a standard deviation or its degrees of freedom are not positive and finite.
    """
    for std, dof in ((first, first_dof), (second, second_dof)):
        if not (std > 0.0 and dof > 0.0 and math.isfinite(std) and math.isfinite(dof)):
            raise DataError(
                f"standard deviation {std:g} with {freedom(dof)}",
                do="Need positive finite numbers",
                code="no_dof",
            )
    ratio = (second / first) ** 2
    below = float(special.fdtr(second_dof, first_dof, ratio))
    above = float(special.fdtrc(second_dof, first_dof, ratio))
    return min(2.0 * min(below, above), 1.0)


def difference_interval(first: float, first_dof: float, second: float, second_dof: float, p: float = 0.95) -> Interval:
    """Return the interval of second less first, of probability about ``p``, in their unit.

    Raises
    ------
    DataError, PlanError
        As ``intervals.chi_square_interval``.
    """
    low_1, high_1 = ends(chi_square_interval(first, first_dof, p))
    low_2, high_2 = ends(chi_square_interval(second, second_dof, p))
    difference = second - first
    return Interval(
        difference - math.hypot(second - low_2, high_1 - first),
        difference + math.hypot(high_2 - second, first - low_1),
        p,
    )


def scatter_ratio_interval(
    first: float, first_dof: float, second: float, second_dof: float, p: float = 0.95
) -> Interval:
    """Return the interval of second over first, of two standard deviations: by F, exact for normal readings.

    Raises
    ------
    DataError
        As `equality_p_value`.
    """
    equality_p_value(first, first_dof, second, second_dof)  # refuses what has no interval
    ratio = second / first
    low, high = (float(special.fdtri(second_dof, first_dof, q)) for q in (0.5 * (1.0 - p), 0.5 * (1.0 + p)))
    return Interval(ratio / math.sqrt(high), ratio / math.sqrt(low), p)


def ratio_interval(first: Size, second: Size, common: float = 0.0, p: float = 0.95) -> Interval:
    """Return the interval of second over first, of two sizes with intervals of their own of probability ``p``.

    Parameters
    ----------
    first, second : Size
        Above zero, in one unit. An end at zero, or none, leaves the ratio open there.
    common : float
        Relative standard uncertainty that both share, as of a scale factor: it is in each interval, and cancels.
    p : float
        Probability.

    Raises
    ------
    DataError
        If a size is not above zero.
    """
    for one in (first, second):
        if not (one.value > 0.0 and math.isfinite(one.value)):
            raise DataError(f"size {one.value:g}", do="Need a positive finite number", code="no_size")
    gone = (float(special.ndtri(0.5 * (1.0 + p))) * common) ** 2

    def reach(end: float | None, value: float) -> float | None:
        """Return how far an end lies from its value, squared, without what is common; None for an open one."""
        return None if end is None or end <= 0.0 else max(math.log(end / value) ** 2 - gone, 0.0)

    middle = math.log(second.value / first.value)
    below = reach(second.lo, second.value), reach(first.hi, first.value)
    above = reach(second.hi, second.value), reach(first.lo, first.value)
    lo = 0.0 if None in below else math.exp(middle - math.sqrt(sum(one or 0.0 for one in below)))
    hi = None if None in above else math.exp(middle + math.sqrt(sum(one or 0.0 for one in above)))
    return Interval(lo, hi, p)
