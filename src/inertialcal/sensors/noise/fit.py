"""Noise terms of a sensor axis from its Allan deviation: sizes with intervals, and what the record cannot tell.

The estimator and what it assumes stand in ``likelihood``, the choice of terms in ``order``, intervals, upper limits and
the record needed in ``limits``, the tests in ``goodness``. Parameters are those of ``terms``, SI inside.

The curve is taken as the overlapping Allan deviation of samples whose disturbances and lines are known: lines that
were found in the spectrum are given by their frequency, and their amplitude is fitted with the rest. The choice of
terms comes first, the interval after it: a term at the edge of what the record shows is named only where chance made
it large, and its interval does not allow for that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.remarks import Remark
from ...core.results import Interval
from .goodness import Test, agreement_test, residual_test
from .likelihood import (
    COARSE,
    GAUSS_MARKOV,
    LINEAR,
    Fitted,
    Problem,
    Sandwich,
    covariance_of_runs,
    estimate,
    mean_of,
    problem_of,
    sandwich,
    terms_of,
    time_at,
)
from .limits import power_interval, record_needed, time_interval, upper_limit
from .noise_fit import FoundTerm, NoiseFit, Parameter
from .order import NAMES, Choice, criterion, present, ranked, separable
from .runs import AllanLike, Run, run_of
from .terms import TERMS, Kind, quantity_name
from .units import parameter_unit, sample_unit

AUTO = (*NAMES, GAUSS_MARKOV)
SIGNIFICANT = 0.01  # probability below which a test is remarked


def fit(
    curves: AllanLike | Run | Sequence[AllanLike | Run],
    kind: Kind | None,
    *,
    terms: str | Sequence[str] = "auto",
    lines: Sequence[float] = (),
    axis: int | None = None,
    unit: str = "",
    p: float = 0.95,
) -> NoiseFit:
    """Return the noise terms of one sensor axis.

    Parameters
    ----------
    curves : curve or sequence of curves
        Overlapping Allan deviation of one run, or of several runs of the same axis: they are fitted together, and a
        test says whether they agree.
    kind : {"gyro", "accelerometer"} or None
        Of the sensor, whose deviations are SI [rad/s or m/s^2]; None where the unit is that of the file.
    terms : "auto" or sequence of str
        Which terms; "auto" chooses among all by the criterion of ``order``.
    lines : sequence of float
        Frequencies of known lines [Hz].
    axis : int, optional
        Column, where curves have several.
    unit : str
        Of the samples, where ``kind`` is None.
    p : float
        Probability of the intervals.

    Raises
    ------
    DataError
        If a curve carries too little, is constant or of another deviation, or a term is not known.
    """
    several = list(curves) if isinstance(curves, Sequence) else [curves]
    runs = [run_of(curve, axis) for curve in several]
    if not runs:
        raise DataError("no Allan deviation to fit", do="Give that of one run, or of several", code="too_short")
    problem = problem_of(runs, lines)
    chosen, table, candidates = _chosen(problem, terms)
    fitted = estimate(problem, chosen.terms)
    sigma = covariance_of_runs(problem, terms_of(problem, fitted))
    bread = sandwich(problem, fitted, sigma)
    scale = sample_unit(kind, unit)
    found = _estimated(problem, fitted, bread, kind, scale, p)
    missed = tuple(
        _not_identified(problem, name, candidates, chosen, table, fitted, sigma, kind, scale)
        for name in (AUTO if terms == "auto" else terms)
        if name not in present(problem, fitted)
    )
    residual, agreement = residual_test(problem, fitted, sigma), agreement_test(problem, fitted, sigma)
    return NoiseFit(
        kind,
        scale,
        found + missed,
        _estimate(problem, fitted, bread, found),
        tuple((choice.terms, choice.criterion - table[0].criterion) for choice in table),
        residual,
        agreement,
        terms_of(problem, fitted),
        tuple(run.tau for run in runs),
        tuple(run.variance for run in runs),
        tuple(np.split(mean_of(problem, fitted), np.cumsum([len(run.m) for run in runs])[:-1])),
        _remarks(problem, residual, agreement),
    )


def _chosen(problem: Problem, terms: str | Sequence[str]) -> tuple[Choice, tuple[Choice, ...], tuple[str, ...]]:
    """Return the choice, the table of all, and what was a candidate."""
    if terms == "auto":
        candidates = separable(problem, AUTO)
        table = ranked(problem, candidates)
        return table[0], table, candidates
    wanted = (terms,) if isinstance(terms, str) else tuple(terms)
    unknown = [name for name in wanted if name not in AUTO]
    if unknown or not wanted:
        raise DataError(
            f"no term of noise {', '.join(map(repr, unknown)) or 'asked for'}",
            do=f"There are: {', '.join(AUTO)}; lines by their frequency",
            code="unknown_term",
        )
    candidates = separable(problem, wanted)
    fitted = estimate(problem, candidates, precision=COARSE)
    if not np.isfinite(fitted.cost):
        raise DataError(
            f"{', '.join(wanted)} cannot give this Allan deviation",
            why="they are zero where it is not",
            do='Add "random_walk", or let the terms be chosen',
            code="wrong_terms",
        )
    choice = Choice(candidates, criterion(candidates, fitted), fitted)
    return choice, (choice,), candidates


def _estimated(
    problem: Problem, fitted: Fitted, bread: Sandwich, kind: Kind | None, unit: str, p: float
) -> tuple[FoundTerm, ...]:
    """Return the terms that have a size, with intervals."""
    u, stretch = np.sqrt(np.diag(bread.covariance)), bread.stretch
    names = present(problem, fitted)
    found = []
    for column, at in enumerate(np.flatnonzero(fitted.powers > 0.0)):
        power = float(fitted.powers[at])
        squared = power_interval(problem, names, fitted, int(at), u[column], stretch[column], p)
        interval = Interval(_root(squared.lo), _root(squared.hi), p)
        size = float(np.sqrt(power))
        first = (size, float(0.5 * u[column] / size), interval)
        if at == len(problem.names):
            log = column + 1
            time = time_at(problem, fitted.position)
            between = time_interval(problem, names, fitted, u[log], stretch[log], p)
            values = (first, (time, float(time * u[log]), between))
            found.append(_found(GAUSS_MARKOV, values, kind, unit))
        elif at >= len(LINEAR):
            frequency = problem.lines[int(at) - len(LINEAR)]
            known = (frequency, 0.0, Interval(frequency, frequency, p))
            found.append(_found("sinusoid", (first, known), kind, unit))
        else:
            found.append(_found(problem.names[at], (first,), kind, unit))
    return tuple(found)


def _found(
    name: str, values: tuple[tuple[float, float, Interval], ...], kind: Kind | None, unit: str
) -> FoundTerm:  # fmt: skip
    parameters = tuple(
        Parameter(quantity_name(name, word, kind), *value, parameter_unit(name, word, unit))
        for word, value in zip(TERMS[name].parameters, values, strict=True)
    )
    return FoundTerm(name, "estimated", parameters)


def _not_identified(
    problem: Problem,
    name: str,
    candidates: tuple[str, ...],
    chosen: Choice,
    table: tuple[Choice, ...],
    fitted: Fitted,
    sigma: Array,
    kind: Kind | None,
    unit: str,
) -> FoundTerm:
    """Return a term that the record does not show, with the reason, an upper limit and the record needed."""
    words = tuple(quantity_name(name, word, kind) for word in TERMS[name].parameters)
    if name not in candidates:
        reason = "looks like white noise, with dead time"
        return FoundTerm(name, "not_identified", (), words, reason)
    reason = _reason(name, chosen, table)
    if name == GAUSS_MARKOV:
        return FoundTerm(name, "not_identified", (), words, reason)
    at = NAMES.index(name)
    power = upper_limit(problem, chosen.terms, fitted, at, sigma)
    needed = None if power is None else record_needed(problem, fitted, at, power, sigma)
    limit = None if power is None else float(np.sqrt(power))
    wanted = parameter_unit(name, "coefficient", unit)
    return FoundTerm(name, "not_identified", (), words, reason, limit, wanted, needed, _length(problem))


def _reason(name: str, chosen: Choice, table: tuple[Choice, ...]) -> str:
    """Say why a term was not taken, by the best choice that has it."""
    better = next((choice for choice in table if name in choice.terms), None)
    if better is None:
        return "smaller than it would show"
    lost = [other for other in chosen.terms if other not in better.terms]
    worse = f"criterion +{better.criterion - chosen.criterion:.1f}"
    return f"not told from {', '.join(lost)} ({worse})" if lost else f"record too short ({worse})"


def _length(problem: Problem) -> float:
    return max(run.length for run in problem.runs)


def _root(power: float | None) -> float | None:
    return None if power is None else float(np.sqrt(power))


def _estimate(problem: Problem, fitted: Fitted, bread: Sandwich, found: tuple[FoundTerm, ...]) -> Estimate:
    """Return all parameters with their covariance: coefficients from powers, times from their logarithm."""
    known = [parameter for term in found for parameter in term.parameters if parameter.u > 0.0]
    slopes = [0.5 / np.sqrt(power) for power in fitted.powers if power > 0.0]
    if fitted.powers[-1] > 0.0:
        slopes.append(time_at(problem, fitted.position))
    covariance = bread.covariance * np.outer(slopes, slopes)
    names = _distinct([parameter.name for parameter in known])
    return Estimate(
        names,
        np.array([parameter.value for parameter in known]),
        tuple(parameter.unit for parameter in known),
        (Component("scatter of the noise itself", "A", 0.5 * (covariance + covariance.T)),),
    )


def _distinct(names: list[str]) -> tuple[str, ...]:
    """Return names numbered where they appear more than once: amplitudes of several lines."""
    counts = [names[: i + 1].count(name) for i, name in enumerate(names)]
    return tuple(
        f"{name}_{count}" if names.count(name) > 1 else name for name, count in zip(names, counts, strict=True)
    )


def _remarks(problem: Problem, residual: Test | None, agreement: Test | None) -> tuple[Remark, ...]:
    found = []
    if residual is not None and residual.p < SIGNIFICANT:
        found.append(
            Remark(
                "terms_do_not_explain",
                "warning",
                f"the terms do not explain the Allan deviation (chi-square {residual.statistic:.1f} with"
                f" {residual.dof} degrees of freedom, p = {residual.p:.1e}): intervals are too short",
                do="Look for lines, disturbances or drift (psd), and leave them out or name them",
            )
        )
    if agreement is not None and agreement.p < SIGNIFICANT:
        found.append(
            Remark(
                "runs_disagree",
                "warning",
                f"the {len(problem.runs)} runs do not agree on the terms (chi-square {agreement.statistic:.1f} with"
                f" {agreement.dof} degrees of freedom, p = {agreement.p:.1e})",
                do="Fit each run by itself, and look what differs",
            )
        )
    return tuple(found)
