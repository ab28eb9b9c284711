"""Whether a record of a given length would name a term, by the criterion that chooses terms (``order``).

The Allan variances are taken as the terms themselves expect them, and all choices without the term are fitted to them.
How much likelihood the best of these lose is expected so; in a record it scatters with the standard deviation that the
covariance of the Allan variances gives it (to first order, as the distance of two models does [1]_). A term counts as
named where in 95 % of records it is worth its price against each of those choices. Lengths came out long enough, by up
to twice (simulated).

References
----------
.. [1] Q. H. Vuong, Econometrica 57 (1989) 307: likelihood ratios of models that are not nested.
"""

from __future__ import annotations

import numpy as np
from scipy import special

from ..allan_of_terms import variance_of_phase
from ..forecast import NOISE_EDF, octaves
from ..runs import Run
from ..terms import Sinusoid, Term, total_phase
from .covariance_of_allan import covariance_of_allan, model_edf
from .likelihood import mean_of
from .order import NAMES, PRICE, ranked, separable, unknowns
from .problem import GAUSS_MARKOV, problem_of

NAMED = 0.95  # of records
CHOSEN_FROM = (*NAMES, GAUSS_MARKOV)


def can_be_chosen(terms: tuple[Term, ...], term: str) -> bool:
    """Whether the criterion decides on a term: lines are given, and two terms of one name are beyond it.

    Parameters
    ----------
    terms : tuple of Term
        All of the sensor.
    term : str
        Which of them.
    """
    names = [one.name for one in terms]
    return term in CHOSEN_FROM and all(names.count(name) == 1 for name in names if name != Sinusoid.name)


def separation(terms: tuple[Term, ...], term: str, record: float, interval: float, averaging: float | None) -> float:
    """Return by how much the criterion is better with a term than without in all but 5 % of records.

    Parameters
    ----------
    terms : tuple of Term
        All of the sensor [SI].
    term : str
        Which of them.
    record, interval : float
        Length of the record, time from sample to sample [s].
    averaging : float or None
        Averaging time of a sample [s]; the interval where absent.

    Returns
    -------
    separation : float
        Below zero where more records than those would not name it.
    """
    n = int(record / interval + 1e-9)
    m, phase = octaves(n), total_phase(terms, interval, averaging)
    pairs = n - 2.0 * m + 1.0
    mu, sigma = variance_of_phase(phase, m), covariance_of_allan(phase, m, pairs)
    edf = np.minimum(model_edf(mu, sigma), NOISE_EDF * n / m)
    run = Run(m, mu, pairs, edf, interval, averaging or interval, np.ones(len(m)))
    problem = problem_of([run], [one.frequency for one in terms if isinstance(one, Sinusoid)])
    names = tuple(one.name for one in terms if one.name in CHOSEN_FROM)
    least, worst = float(problem.weight @ (np.log(mu) + 1.0)), np.inf
    for choice in ranked(problem, separable(problem, tuple(one for one in CHOSEN_FROM if one != term))):
        gain = 2.0 * (choice.fitted.cost - least)
        slope = 2.0 * problem.weight * (1.0 / mean_of(problem, choice.fitted) - 1.0 / mu)
        price = PRICE * (unknowns(names) - unknowns(choice.terms))
        part = set(choice.terms) <= set(names)
        worst = min(worst, _mostly(gain, float(slope @ sigma @ slope), part) - price)
    return float(worst)


def _mostly(gain: float, variance: float, part: bool) -> float:
    """Return what a gain exceeds in all but 5 % of cases: normal, or gamma where it is never negative.

    It is not, of a choice that is a ``part`` of the terms; a rival can come out better than the truth.
    """
    if not part:
        return gain - float(special.ndtri(NAMED)) * float(np.sqrt(variance))
    if not (gain > 0.0 and variance > 0.0):
        return 0.0
    return float(special.gammaincinv(gain**2 / variance, 1.0 - NAMED)) * variance / gain
