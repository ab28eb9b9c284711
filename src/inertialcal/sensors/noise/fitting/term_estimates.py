"""Terms as found: those that have a size with their intervals, the others with the reason and how large at most."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....core.axes import Kind
from ....core.estimate import Array, Component, Estimate
from ....core.key import Key
from ....core.results import Interval
from ..terms import TERMS, Quantization, RandomWalk, Sinusoid, quantity_name
from ..units import parameter_unit
from .likelihood import Fitted, estimate, time_at
from .limits import limit_and_record
from .noise_fit import Parameter, TermEstimate
from .order import NAMES, PRICE, Choice, present
from .problem import GAUSS_MARKOV, LINEAR, Problem
from .profile import interval_of
from .sandwich import Sandwich


@dataclass(frozen=True, eq=False)
class Solution:
    """The fit of the terms that were chosen.

    Parameters
    ----------
    problem : Problem
        Runs.
    candidates : tuple of str
        Terms that there were to choose from.
    table : tuple of Choice
        All choices, the one that was taken first.
    fitted : Fitted
        Sizes of its terms.
    sigma : ndarray, shape (k, k)
        Covariance of the Allan variances.
    bread : Sandwich
        Covariance of the sizes.
    kind : {"gyro", "accelerometer"} or None
        Of the sensor.
    unit : str
        Of the samples.
    p : float
        Probability of intervals.
    """

    problem: Problem
    candidates: tuple[str, ...]
    table: tuple[Choice, ...]
    fitted: Fitted
    sigma: Array
    bread: Sandwich
    kind: Kind | None
    unit: str
    p: float


def estimated(solution: Solution) -> tuple[TermEstimate, ...]:
    """Return the terms that have a size, with intervals."""
    problem, powers = solution.problem, solution.fitted.powers
    u = solution.bread.u
    found = []
    for column, at in enumerate(np.flatnonzero(powers > 0.0).tolist()):
        size = float(np.sqrt(powers[at]))
        squared = interval_of(problem, solution.fitted, at, solution.bread, solution.p)
        first = (size, float(0.5 * u[column] / size), Interval(_root(squared.lo), _root(squared.hi), solution.p))
        if at == len(problem.names):
            time = time_at(problem, solution.fitted.position)
            between = interval_of(problem, solution.fitted, at + 1, solution.bread, solution.p)
            found.append(_found(solution, GAUSS_MARKOV, first, (time, float(time * u[-1]), between)))
        elif at >= len(LINEAR):
            frequency = problem.lines[at - len(LINEAR)]
            found.append(
                _found(solution, Sinusoid.name, first, (frequency, 0.0, Interval(frequency, frequency, solution.p)))
            )
        else:
            found.append(_found(solution, problem.names[at], first))
    return tuple(found)


def _found(solution: Solution, name: str, *values: tuple[float, float, Interval]) -> TermEstimate:
    parameters = tuple(
        Parameter(quantity_name(name, word, solution.kind), *value, parameter_unit(name, word, solution.unit))
        for word, value in zip(TERMS[name].parameters, values, strict=True)
    )
    chosen = solution.table[0]
    other = _rival(
        solution.table, lambda choice: name not in choice.terms and not set(choice.terms) <= set(chosen.terms)
    )
    if name == Sinusoid.name or other is None:
        return TermEstimate(name, "estimated", parameters)
    gained = tuple(one for one in other.terms if one not in chosen.terms)
    worse = other.criterion - chosen.criterion
    return TermEstimate(name, "estimated", parameters, code="like_another", others=gained, worse=worse)


def not_identified(solution: Solution, name: str) -> TermEstimate:
    """Return a term that the record does not show: the reason, an upper limit, and the record that would show it."""
    problem, fitted, first = solution.problem, solution.fitted, TERMS[name].parameters[0]
    words = tuple(quantity_name(name, word, solution.kind) for word in TERMS[name].parameters)
    found = TermEstimate(
        name, "not_identified", (), words, unit=parameter_unit(name, first, solution.unit), record=problem.length
    )
    if name not in solution.candidates:
        return replace(found, code="like_white")
    at, limit_at = problem.names.index(name) if name in NAMES else len(problem.names), None
    if name == GAUSS_MARKOV:
        fitted = replace(fitted, position=_where_it_hides(problem, fitted))
        limit_at = time_at(problem, fitted.position)
    chosen = solution.table[0]
    other = _rival(solution.table, lambda choice: name in choice.terms and not set(chosen.terms) <= set(choice.terms))
    rival = None if other is None or name == GAUSS_MARKOV else other.fitted
    power, needed = limit_and_record(problem, fitted, at, solution.sigma, rival)
    added = next((choice for choice in solution.table if name in choice.terms), None)
    worse = None if added is None else added.criterion - chosen.criterion
    found = replace(found, upper_limit=_root(power), record_needed=needed, limit_at=limit_at, worse=worse)
    if other is not None:
        lost = tuple(one for one in chosen.terms if one not in other.terms)
        return replace(found, code="like_another", others=lost, worse=other.criterion - chosen.criterion)
    return replace(found, **_why_not(found, chosen))


def _why_not(found: TermEstimate, chosen: Choice) -> dict[str, Any]:
    """Return the code of the reason, and no length of a record where length is not what lacks."""
    if found.name == Quantization.name and RandomWalk.name in chosen.terms:
        return {"code": "hidden_by_white", "record_needed": None}
    if found.upper_limit is None:
        return {"code": "no_limit"}
    if found.record_needed is None:
        return {"code": "no_record"}
    return {"code": "too_short" if found.record_needed > found.record else "small"}


def _rival(table: tuple[Choice, ...], wanted: Callable[[Choice], bool]) -> Choice | None:
    """Return the best choice of a kind, where it is nearly as good as the one that was taken."""
    found = next((choice for choice in table[1:] if wanted(choice)), None)
    return found if found is not None and found.criterion - table[0].criterion < PRICE else None


def _where_it_hides(problem: Problem, fitted: Fitted) -> float:
    """Position of the correlation time at which Gauss-Markov noise beside the others fits best; else the middle."""
    best = estimate(problem, (*present(problem, fitted), GAUSS_MARKOV))
    return best.position if best.powers[-1] > 0.0 else 0.5 * (len(problem.table) - 1.0)


def _root(power: float | None) -> float | None:
    return None if power is None else float(np.sqrt(power))


def estimate_of(solution: Solution, found: tuple[TermEstimate, ...]) -> Estimate:
    """Return all parameters with their covariance: coefficients from powers, times from their logarithm."""
    known = [parameter for term in found for parameter in term.parameters if parameter.u > 0.0]
    fitted = solution.fitted
    slopes = list(0.5 / np.sqrt(fitted.powers[fitted.powers > 0.0]))
    if fitted.powers[-1] > 0.0:
        slopes.append(time_at(solution.problem, fitted.position))
    covariance = solution.bread.covariance * np.outer(slopes, slopes)
    return Estimate(
        _distinct([parameter.name for parameter in known]),
        np.array([parameter.value for parameter in known]),
        tuple(parameter.unit for parameter in known),
        (Component("scatter of the noise itself", "A", 0.5 * (covariance + covariance.T)),),
    )


def _distinct(names: list[str]) -> tuple[Key, ...]:
    """Return keys, numbered where a name appears more than once: amplitudes of several lines."""
    counts = [names[: i + 1].count(name) for i, name in enumerate(names)]
    return tuple(
        Key(name, power=count if names.count(name) > 1 else 0) for name, count in zip(names, counts, strict=True)
    )
