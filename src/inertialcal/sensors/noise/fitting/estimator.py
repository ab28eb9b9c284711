"""Noise terms of a sensor axis from its Allan deviation: sizes with intervals, and what the record cannot tell.

The estimator and what it assumes stand in ``likelihood``, the choice of terms in ``order``, intervals in ``profile``,
upper limits and the record needed in ``limits``, the tests in ``goodness``, what terms leave unexplained in ``misfit``.
Parameters are those of ``terms``, SI inside.

The curve is taken as the overlapping Allan deviation of samples whose disturbances and lines are known: lines that
were found in the spectrum are given by their frequency, and their amplitude is fitted with the rest. The choice of
terms comes first, the interval after it: a term at the edge of what the record shows is named only where chance made
it large, and its interval does not allow for that.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....core.axes import Kind
from ....core.errors import DataError, PlanError
from ..runs import AllanLike, Run, run_of, unit_of
from ..terms import RateRamp, Sinusoid
from ..units import sample_unit
from .goodness import SIGNIFICANT, agreement_test, residual_test
from .likelihood import Fitted, covariance_of_runs, estimate, mean_of, sandwich, terms_of
from .misfit import misfit_of
from .noise_fit import NoiseFit
from .order import NAMES, Choice, criterion, present, ranked, separable
from .problem import GAUSS_MARKOV, Problem, problem_of, with_misfit
from .remarks import remarks_of
from .term_estimates import Solution, estimate_of, estimated, not_identified

AUTO = (*NAMES, GAUSS_MARKOV)


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
        test says whether they agree. A curve that says its unit is converted; one that does not is taken as SI, or in
        the unit of the file.
    kind : {"gyro", "accelerometer"} or None
        Of the sensor, whose terms are then SI [rad/s or m/s^2]; None where the unit is that of the file.
    terms : "auto" or sequence of str
        Which terms; "auto" chooses among all by the criterion of ``order``.
    lines : sequence of float
        Frequencies of known lines [Hz].
    axis : int, optional
        Column, where curves have several.
    unit : str
        Of the result, where ``kind`` is None; that of the first curve by default.
    p : float
        Probability of the intervals.

    Raises
    ------
    DataError
        If a curve carries too little, is constant, without noise, of another deviation, or in a unit of something
        else, or a term is not known.
    PlanError
        If the probability is not between 0 and 1.
    """
    if not 0.0 < p < 1.0:
        raise PlanError(f"intervals of probability {p:g}", do="Give one between 0 and 1: 0.95", code="probability")
    several = list(curves) if isinstance(curves, Sequence) else [curves]
    if not several:
        raise DataError("no Allan deviation to fit", do="Give that of one run, or of several", code="too_short")
    samples = sample_unit(kind, unit or unit_of(several[0]))
    plain = problem_of([run_of(curve, axis, samples) for curve in several], lines)
    solution = _solved(plain, terms, kind, samples, p)
    return _result(plain, solution, AUTO if terms == "auto" else _names(terms))


def _result(plain: Problem, solution: Solution, wanted: Sequence[str]) -> NoiseFit:
    """Return what is told of a solution: the terms found, those that are not, and the tests."""
    problem, fitted, best = solution.problem, solution.fitted, solution.table[0]
    found = estimated(solution)
    missed = tuple(not_identified(solution, name) for name in wanted if name not in present(problem, fitted))
    scatter = solution.sigma if problem is plain else covariance_of_runs(plain, fitted)
    residual = residual_test(plain, fitted, scatter)
    agreement = agreement_test(problem, fitted, solution.sigma)
    runs = problem.runs
    return NoiseFit(
        solution.kind,
        solution.unit,
        found + missed,
        estimate_of(solution, found),
        tuple((choice.terms, choice.criterion - best.criterion) for choice in solution.table),
        residual,
        agreement,
        0.5 * problem.misfit,
        terms_of(problem, fitted),
        tuple(run.tau for run in runs),
        tuple(run.variance for run in runs),
        tuple(np.split(mean_of(problem, fitted), np.cumsum([len(run.m) for run in runs])[:-1])),
        remarks_of(solution, residual, agreement),
    )


def _solved(problem: Problem, terms: str | Sequence[str], kind: Kind | None, unit: str, p: float) -> Solution:
    """Choose the terms, and fit those of the choice closely; with a misfit, where scatter does not explain the rest."""
    candidates = separable(problem, AUTO if terms == "auto" else _names(terms))

    def solution(problem: Problem) -> Solution:
        table = ranked(problem, candidates) if terms == "auto" else (_the_only(problem, candidates),)
        fitted = estimate(problem, table[0].terms)
        _check_noise(problem, fitted)
        sigma = covariance_of_runs(problem, fitted)
        bread = sandwich(problem, fitted, sigma)
        return Solution(problem, candidates, table, fitted, sigma, bread, kind, unit, p)

    first = solution(problem)
    test = residual_test(problem, first.fitted, first.sigma)
    if test is None or test.p >= SIGNIFICANT:
        return first
    misfit = misfit_of(problem, candidates)
    return solution(with_misfit(problem, misfit)) if misfit > 0.0 else first


def _check_noise(problem: Problem, fitted: Fitted) -> None:
    if not any(not isinstance(term, RateRamp | Sinusoid) for term in terms_of(problem, fitted)):
        raise DataError(
            "the terms are a ramp or a line alone, without noise",
            why="nothing would scatter",
            do='Add "random_walk", or look whether the record is computed rather than measured',
            code="no_noise",
        )


def _names(terms: str | Sequence[str]) -> tuple[str, ...]:
    """Return the terms that are asked for, refused where one is none."""
    wanted = (terms,) if isinstance(terms, str) else tuple(terms)
    unknown = [name for name in wanted if name not in AUTO]
    if unknown or not wanted:
        raise DataError(
            f"no term of noise {', '.join(map(repr, unknown)) or 'asked for'}",
            do=f"There are: {', '.join(AUTO)}; lines by their frequency",
            code="unknown_term",
        )
    return wanted


def _the_only(problem: Problem, candidates: tuple[str, ...]) -> Choice:
    fitted = estimate(problem, candidates, looks=1)
    if not np.isfinite(fitted.cost):
        raise DataError(
            f"{', '.join(candidates)} cannot give this Allan deviation",
            why="they are zero where it is not",
            do='Add "random_walk", or let the terms be chosen',
            code="wrong_terms",
        )
    return Choice(candidates, criterion(candidates, fitted), fitted)
