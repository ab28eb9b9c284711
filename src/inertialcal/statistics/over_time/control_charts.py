"""Control charts of figures with uncertainty, some of which share errors of standards.

A figure ``y_i`` of a unit is the process (mean, and a standard deviation ``s`` from unit to unit) plus an error of the
test: independent with variance ``o_i``, and ``c_ik`` times unknowns k that several tests share. With ``r = y - mean``::

    var(r_i) = s^2 (1 - 1/n) + [own errors of the tests less their mean]_i + sum_k (c_ik - mean of c_k)^2

so that an error which all share is in no limit, and one that changed with a certificate widens them for the tests on
either side. Limits stand at three of these standard deviations about the mean.

*Individuals.* ``s`` follows from the mean moving range [1]_, of which the part of the tests is taken off::

    (MR / 1.128)^2 = s^2 + mean of {(o_i + o_i+1) + sum_k (c_i+1,k - c_ik)^2} / 2        not below 0

(ranges across a change of standard are left out where there are others). With tests of equal u and one
standard these are the limits of the textbook, mean -+ 2.66 MR. The chart of the moving range has the limit 3.267 MR.

*Lots.* Means of lots against the scatter inside lots, ``S / c4`` (the S chart has ``B3 S`` and ``B4 S``) [1]_; the
scatter inside a lot holds that of its tests. What tests of a lot share does not scatter inside it and is added.

A signal is a figure beyond its limits, or the last of ``RUN`` in a row on one side of the mean. In control, a figure of
normal units lies outside in 0.27 %, and a run of nine ends with a figure in 0.4 %.

Real data break this where (1) the order is not that of production or time: moving ranges then mix what was apart;
(2) units drift: successive figures are alike and the limits too narrow; (3) few figures (below 20) make limits that are
themselves uncertain.

References
----------
.. [1] NIST/SEMATECH e-Handbook of Statistical Methods, 6.3.2.1 (X-bar and S), 6.3.2.2 (individuals); constants d2, c4.
.. [2] L. S. Nelson, J. Quality Technology 16 (1984) 237-239: runs.
.. [3] ISO 7870-2:2023 (Shewhart charts).
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ..difference import Figure

D2 = 2.0 / math.sqrt(math.pi)  # mean range of two normal values, 1.128
D4 = 1.0 + 3.0 * math.sqrt(2.0 - D2**2) / D2  # 3.267
WIDTH = 3.0  # standard deviations from the mean to a limit
ALIKE = 0.01  # of the largest variance by a standard: a smaller change of it is none
RUN = 9  # in a row on one side of the mean


@dataclass(frozen=True, eq=False)
class Chart:
    """A control chart.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Figures, or means of lots, in order.
    centre : float
        Their mean.
    lower, upper : ndarray, shape (n,)
        Limits of each.
    process : float
        Standard deviation from unit to unit, without the errors of tests; inside lots with them.
    spread : ndarray, shape (n,)
        Moving ranges (the first NaN), or standard deviations of lots.
    spread_centre : float
        Their mean.
    spread_lower, spread_upper : ndarray, shape (n,)
        Their limits.
    out, in_run, spread_out : ndarray of bool, shape (n,)
        Beyond its limits; the last of a run; whose spread is beyond its limits.
    """

    values: Array
    centre: float
    lower: Array
    upper: Array
    process: float
    spread: Array
    spread_centre: float
    spread_lower: Array
    spread_upper: Array
    out: NDArray[np.bool_]
    in_run: NDArray[np.bool_]
    spread_out: NDArray[np.bool_]

    @property
    def in_control(self) -> bool:
        """Whether there is no signal."""
        return not (self.out | self.in_run | self.spread_out).any()


def individuals(figures: Sequence[Figure]) -> Chart:
    """Return the chart of single figures in order, and of their moving ranges.

    Raises
    ------
    DataError
        ``few_figures`` for fewer than three.
    """
    y = _values(figures, 3, "figures")
    own, shared = _parts(figures)
    moving = np.abs(np.diff(y))
    redrawn = sum((np.diff(c) ** 2 for c in shared), np.zeros(y.size - 1))
    alike = redrawn <= ALIKE * max((float(np.max(c**2)) for c in shared), default=0.0)
    used = alike if alike.sum() >= 2 else np.ones(y.size - 1, dtype=bool)
    mean_range = float(moving[used].mean())
    tests = 0.5 * (own[1:] + own[:-1] + redrawn)[used]
    process = math.sqrt(max((mean_range / D2) ** 2 - float(tests.mean()), 0.0))
    n = y.size
    variance = process**2 * (1.0 - 1.0 / n) + own * (1.0 - 2.0 / n) + own.sum() / n**2
    half = WIDTH * np.sqrt(variance + sum(((c - c.mean()) ** 2 for c in shared), np.zeros(n)))
    if not shared and np.ptp(own) == 0.0 and process > 0.0:
        half = np.full(n, WIDTH * mean_range / D2)  # as the textbook has it
    spread = np.concatenate([[np.nan], moving])
    high = np.concatenate([[0.0], D4 * D2 * np.sqrt((mean_range / D2) ** 2 + np.where(used, 0.0, 0.5 * redrawn))])
    return _chart(y, half, process, spread, mean_range, np.zeros(n), high)


def lots(figures: Sequence[Figure], names: Sequence[Hashable]) -> Chart:
    """Return the chart of means of lots in their order, and of the standard deviations inside them.

    Parameters
    ----------
    figures : sequence of Figure
        In any order.
    names : sequence
        Lot of each; one of a single figure is left out.

    Raises
    ------
    DataError
        ``few_figures`` for fewer than two lots of two figures or more.
    """
    members: dict[Hashable, list[int]] = {}
    for i, name in enumerate(names):
        members.setdefault(name, []).append(i)
    groups = [np.array(each) for each in members.values() if len(each) > 1]
    y = _values(figures, 1, "figures")
    if len(groups) < 2:
        raise DataError("fewer than two lots of two units", do="Take a point a unit", code="few_figures")
    _, shared = _parts(figures)
    sizes = np.array([each.size for each in groups], dtype=float)
    means = np.array([y[each].mean() for each in groups])
    deviations = np.array([y[each].std(ddof=1) for each in groups])
    scale = c4(sizes)
    sigma = float(deviations.sum() / scale.sum())
    between = np.array([[c[each].mean() for each in groups] for c in shared]).reshape(-1, len(groups))
    half = WIDTH * np.sqrt(sigma**2 / sizes + sum(((c - c.mean()) ** 2 for c in between), np.zeros(len(groups))))
    wide = WIDTH * np.sqrt(1.0 - scale**2) * sigma
    return _chart(means, half, sigma, deviations, sigma * float(scale.mean()), np.maximum(scale * sigma - wide, 0.0),
                  scale * sigma + wide)  # fmt: skip


def c4(n: Array) -> Array:
    """Return the mean of the standard deviation of n normal values, in their standard deviations.

    Examples
    --------
    >>> round(float(c4(np.array(5.0))), 4)
    0.94
    """
    return np.asarray(np.sqrt(2.0 / (n - 1.0)) * np.exp(special.gammaln(n / 2.0) - special.gammaln((n - 1.0) / 2.0)))


def _values(figures: Sequence[Figure], least: int, what: str) -> Array:
    if len(figures) < least:
        raise DataError(f"{len(figures)} {what}, need {least} or more for a chart", code="few_figures")
    return np.array([one.value for one in figures])


def _parts(figures: Sequence[Figure]) -> tuple[Array, list[Array]]:
    """Return the own variance of each figure, and the changes of all of them by each unknown that two or more share."""
    n = len(figures)
    count: dict[str, int] = {}
    for one in figures:
        for name in one.changes:
            count[name] = count.get(name, 0) + 1
    shared = {name: np.zeros(n) for name, times in count.items() if times > 1}
    own = np.empty(n)
    for i, one in enumerate(figures):
        for name, change in one.changes.items():
            if name in shared:
                shared[name][i] = change
        own[i] = one.own(_known(one.changes, shared))
    return own, list(shared.values())


def _known(changes: Mapping[str, float], shared: Mapping[str, Array]) -> list[str]:
    return [name for name in changes if name in shared]


def _chart(y: Array, half: Array, process: float, spread: Array, centre: float, low: Array, high: Array) -> Chart:
    mean = float(y.mean())
    out = np.abs(y - mean) > half
    beyond = (spread > high) | (spread < low)
    return Chart(y, mean, mean - half, mean + half, process, spread, centre, low, high, out, _runs(y - mean), beyond)


def _runs(rest: Array) -> NDArray[np.bool_]:
    """Return where a run on one side of the mean has become as long as a signal, or goes on."""
    found, length, side = np.zeros(rest.size, dtype=bool), 0, 0.0
    for i, one in enumerate(np.sign(rest).tolist()):
        length = length + 1 if one == side and one else 1
        side = one
        found[i] = length >= RUN
    return found
