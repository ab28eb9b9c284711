"""Margin: how far an interval lies inside its limits."""

from __future__ import annotations

import math

from ...core.results import Interval, finite


def margin(interval: Interval | None, lower: float | None, upper: float | None) -> float | None:
    """Return the distance from the nearer end of an interval to the nearer limit, positive inside.

    Wholly inside, it is what is left to the limit; wholly outside, what the nearest end is beyond it, negative;
    across a limit, what the farthest end is beyond it, negative too.

    Parameters
    ----------
    interval : Interval or None
        An open end is at infinity.
    lower, upper : float or None
        Limits, in the unit of the interval.

    Returns
    -------
    float or None
        In that unit; None where there is no interval or no limit, or only an open end stands against a limit.

    Examples
    --------
    >>> margin(Interval(1.0, 2.0), None, 5.0), margin(Interval(6.0, 8.0), None, 5.0)
    (3.0, -1.0)
    >>> margin(Interval(4.0, 7.0), 0.0, 5.0)
    -2.0
    """
    if interval is None:
        return None
    lo, hi = (-math.inf if interval.lo is None else interval.lo), (math.inf if interval.hi is None else interval.hi)
    below, above = (-math.inf if lower is None else lower), (math.inf if upper is None else upper)
    if lo > above:
        return finite(above - lo)
    if hi < below:
        return finite(hi - below)
    to_lower = math.inf if lower is None else lo - lower
    to_upper = math.inf if upper is None else upper - hi
    return finite(min(to_lower, to_upper))
