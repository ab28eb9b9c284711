"""Sources of uncertainty of fitted numbers, from a fit with two levels of variance.

Known errors that a certificate states are of Type B and stay as they are. What is not stated, the noise inside a
position and the scatter between positions, is judged by the residuals, and has the degrees of freedom by which these
judge the variance of the number [1]_. Where they are less than one, the residuals say nothing of it: a number that
rests on one reading at each place that decides it, while the others have far larger known errors. It then carries not
the scatter that was found but as much as may be hidden.

References
----------
.. [1] ``statistics.two_levels``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ....core.estimate import Array
from ....core.influence import Influence
from ....statistics.two_levels import TwoLevels
from .linear_sensor import Source

FEWEST = 1.0  # degrees of freedom by which something is judged at all
HIDDEN = "hidden"  # level of a bound on a scatter that nothing shows


def level_sources(
    fit: TwoLevels, back: Array, stated: Mapping[str, Influence], between: str, share: float = 1.0
) -> list[Source]:
    """Return the sources of the numbers ``back @ coefficients``.

    Parameters
    ----------
    fit : TwoLevels
        Its known sources by their names.
    back : ndarray, shape (q, p)
        Numbers per coefficient.
    stated : mapping of str to Influence
        Those of the known sources that are of Type B.
    between : str
        Name of the scatter between readings.
    share : float
        By which the variances of the known sources that are not stated are multiplied.
    """
    parts = {name: _moved(back, part) for name, part in fit.parts.items()}
    per_square = fit.by_between(back)
    own = [np.diag(part) for name, part in parts.items() if name not in stated]
    judged = sum(own, fit.between**2 * np.diag(per_square))
    whole = np.diag(back @ fit.covariance @ back.T)
    dof = _ratio(whole, judged) ** 2 * fit.dof_of(back)
    hidden = dof < FEWEST
    seen = _scatter(per_square, np.where(hidden, 0.0, fit.between**2))
    unseen = _scatter(per_square, np.where(hidden, max(fit.hidden, fit.between**2), 0.0))
    squares = sum([(share * one) ** 2 for one in own], np.diag(seen) ** 2)
    with np.errstate(invalid="ignore"):
        each = dof * _ratio(squares, (whole - judged + share * judged) ** 2)
    each[hidden | np.isnan(each)] = np.inf
    found = [
        Source(between, "A", seen, each),
        Source(f"{between}, as much as may be hidden", "A", unseen, level=HIDDEN),
    ]
    for name, part in parts.items():
        if name in stated:
            found.append(Source(name, "B", part, np.inf, stated[name]))
        else:
            found.append(Source(name, "A", share * part, each))
    return [one for one in found if np.any(np.diag(one.covariance) > 0.0)]


def _scatter(per_square: Array, square: Array) -> Array:
    return np.asarray(np.outer(np.sqrt(square), np.sqrt(square)) * per_square)


def _ratio(a: Array, b: Array) -> Array:
    """Return a / b, infinite where both are zero: nothing is judged there."""
    return np.asarray(np.divide(a, b, out=np.full(len(a), np.inf), where=b > 0.0))


def summed(groups: Sequence[Sequence[Source]]) -> list[Source]:
    """Return sources of one name as one: variances add, degrees of freedom by Welch and Satterthwaite."""
    found: dict[str, Source] = {}
    for one in (source for group in groups for source in group):
        before = found.get(one.name)
        found[one.name] = one if before is None else _sum(before, one)
    return list(found.values())


def _sum(a: Source, b: Source) -> Source:
    covariance = a.covariance + b.covariance
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.diag(a.covariance) ** 2 / a.dof + np.diag(b.covariance) ** 2 / b.dof
        dof = np.where(weight > 0.0, np.diag(covariance) ** 2 / weight, np.inf)
    return replace(a, covariance=covariance, dof=dof)


def _moved(back: Array, covariance: Array) -> Array:
    whole = back @ covariance @ back.T
    return np.asarray(0.5 * (whole + whole.T))
