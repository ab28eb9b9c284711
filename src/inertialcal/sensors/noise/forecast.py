"""What a record of a given length tells of each noise term, if all are fitted together.

The answer is the covariance of the fit (``likelihood``) to overlapping Allan variances at octaves, as the terms
themselves imply it: it knows that terms hide behind each other.

Relative errors are standard uncertainties over values. A term counts as *shown* where that of its size is at most a
quarter: the square of the size, of which the Allan variance is made, then lies two standard deviations from zero. A
larger figure says no more than that the record cannot show the term.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.show.rounding import number
from ...core.show.tables import Block, Table, html, text
from .allan_of_terms import variance_of_phase
from .fitting.covariance_of_allan import covariance_of_allan, model_edf
from .fitting.sandwich import sandwich_of
from .terms import Term, total_phase

SHOWN = 0.25  # relative error of a size that is shown to be there
SPANS = 3  # longest averaging time of the octaves, in its lengths that a record holds
NOISE_EDF = 1.5  # degrees of freedom of an averaging time that a record holds, most of all noises (white)
STEP = 1e-4  # relative, of the derivative for a parameter that the variance is not a power of
SCALES = ("coefficient", "sigma", "amplitude")  # parameters whose square the Allan variance is proportional to
GIVEN = ("frequency",)  # parameters that are told before a fit
SEVERAL = ("gauss_markov", "sinusoid")  # terms that there may be several of


@dataclass(frozen=True)
class Known:
    """What a record tells of one parameter.

    Parameters
    ----------
    term, parameter : str
        ``"random_walk"``, ``"coefficient"``.
    value : float
        That was assumed [SI].
    relative_error : float
        Standard uncertainty of a fit of all terms, over the value.
    shown : bool
        Whether the term is shown to be there: relative error of its size at most a quarter.
    """

    term: str
    parameter: str
    value: float
    relative_error: float
    shown: bool


@dataclass(frozen=True)
class Forecast:
    """What a record of one length tells of all terms.

    Parameters
    ----------
    record, interval : float
        Length, time from sample to sample [s].
    known : tuple of Known
        One a parameter.
    """

    record: float
    interval: float
    known: tuple[Known, ...]

    def of(self, term: str, parameter: str = "") -> Known:
        """One parameter; the first of the term where none is named.

        Raises
        ------
        PlanError
            If it is not among them.
        """
        for one in self.known:
            if one.term == term and parameter in {"", one.parameter}:
                return one
        there = ", ".join(f"{one.term} {one.parameter}" for one in self.known)
        raise PlanError(f"no parameter {term} {parameter}".rstrip(), do=f"There are: {there}")

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a parameter."""
        heads = ("term", "parameter", "value [SI]", "relative error", "shown")
        rows = [
            (one.term, one.parameter, number(one.value, 4), number(one.relative_error, 2), "yes" if one.shown else "no")
            for one in self.known
        ]
        caption = f"what {number(self.record, 5)} s at {number(1.0 / self.interval, 5)} Hz tell, all terms fitted"
        return (Table(heads, rows, caption, (2, 3)),)

    def __str__(self) -> str:
        """Return a table with a row a parameter."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the same table for a notebook."""
        return html(self.parts())


def forecast(terms: tuple[Term, ...], record: float, interval: float, averaging: float | None = None) -> Forecast:
    """Return what a record tells of each term, if the noise is that of the terms given.

    Parameters
    ----------
    terms : tuple of Term
        All of the sensor, with values from a data sheet or a first record [SI].
    record, interval : float
        Length of the record, time from sample to sample [s].
    averaging : float, optional
        Averaging time of a sample [s]; the interval by default.

    Raises
    ------
    DataError
        ``too_short`` if the record has fewer averaging times than unknowns.
    PlanError
        If there is no term, or one twice.
    """
    check_terms(terms)
    errors = relative_errors(terms, record, interval, averaging)
    at = iter(errors)
    known = []
    for term in terms:
        names = free_parameters(term)
        each = [float(next(at)) for _ in names]
        values = [float(getattr(term, name)) for name in names]
        shown = bool(each[0] <= SHOWN)
        known += [Known(term.name, n, v, e, shown) for n, v, e in zip(names, values, each, strict=True)]
    return Forecast(record, interval, tuple(known))


def free_parameters(term: Term) -> tuple[str, ...]:
    """Return the parameters of a term that a fit finds, its size first."""
    return tuple(name for name in term.parameters if name not in GIVEN)


@lru_cache(64)
def relative_errors(terms: tuple[Term, ...], record: float, interval: float, averaging: float | None) -> Array:
    """Return the relative standard uncertainty of each free parameter of each term, in order.

    Raises
    ------
    DataError
        ``too_short`` if the record has fewer averaging times than unknowns.
    """
    n = int(record / interval + 1e-9)
    m = octaves(n)
    slopes = np.stack(
        [_slope(term, name, m, interval, averaging) for term in terms for name in free_parameters(term)], axis=1
    )
    if len(m) < slopes.shape[1]:
        what = f"a record of {record:g} s: {len(m)} averaging times for {slopes.shape[1]} unknowns"
        raise DataError(what, do="Record longer, or assume fewer terms", code="too_short")
    phase = total_phase(terms, interval, averaging)
    mean = variance_of_phase(phase, m)
    sigma = covariance_of_allan(phase, m, n - 2.0 * m + 1.0)
    edf = np.minimum(model_edf(mean, sigma), NOISE_EDF * n / m)  # the fit weighs a ramp or a line as if it were noise
    return sandwich_of(slopes, 0.5 * edf / mean**2, sigma).u


def octaves(n: int) -> Array:
    """Return averaging times 1, 2, 4, ... of a record of n samples, three of the longest fitting in [samples]."""
    return np.asarray(2.0 ** np.arange(max(1, int(np.floor(np.log2(max(n, SPANS) / SPANS))) + 1)))


def _slope(term: Term, name: str, m: Array, interval: float, averaging: float | None) -> Array:
    """Return the derivative of the Allan variance by the logarithm of a parameter."""
    if name in SCALES:
        return 2.0 * variance_of_phase(total_phase((term,), interval, averaging), m)
    changes: Any = [{name: getattr(term, name) * np.exp(sign * STEP)} for sign in (1.0, -1.0)]
    above, below = (variance_of_phase(total_phase((replace(term, **c),), interval, averaging), m) for c in changes)
    return np.asarray((above - below) / (2.0 * STEP))


def check_terms(terms: tuple[Term, ...]) -> None:
    """Refuse no terms, and a term twice that is one size only.

    Raises
    ------
    PlanError
        In both cases.
    """
    names = [term.name for term in terms]
    twice = sorted({name for name in names if names.count(name) > 1 and name not in SEVERAL})
    if not terms or twice:
        raise PlanError("no terms" if not terms else f"term {', '.join(twice)} given twice", do="Give each term once")
