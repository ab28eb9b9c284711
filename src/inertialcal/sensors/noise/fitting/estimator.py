"""Noise terms of a sensor axis from its Allan deviation: sizes with intervals, and what the record cannot tell.

The estimator and what it assumes stand in ``likelihood``, the choice of terms in ``order``, intervals in ``profile``,
upper limits and the record needed in ``limits``, the tests in ``goodness``, what terms leave unexplained in ``misfit``.
Parameters are those of ``terms``, SI inside.

The curve is taken as the overlapping Allan deviation of samples whose disturbances and lines are known: lines that
were found in the spectrum are given by their frequency, and their amplitude is fitted with the rest. The choice of
terms comes first, the interval after it, and allows for it: flicker and a random walk are free in it, chosen or not
(``limits``). Where another choice is nearly as good (``order.PLAUSIBLE``), the interval of a slow term begins at zero,
the limit of one that was not chosen holds in that choice too, and a remark gives both.

Three ways in which real data break it, each simulated:

- a walk that is barely visible passes for flicker (44 of 250), flicker and a walk for one of them: the interval of what
  was found holds (95 to 100 %), the limit of what was missed holds (93 to 100 %), and ``terms_alike`` gives both;
- the angle is rounded, but by less than the record shows: N holds in 93 to 95 %, and in 41 % by the chosen terms alone;
- the noise is of another kind, as Gauss-Markov noise of 50 to 500 s: it is read as flicker or a walk, its own limit
  holds (99 to 100 %), and the interval of what it was read as reaches zero in 97 %; of 5 s it is found, with flicker
  besides in 4 %, whose interval does not reach zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from ....core.errors import DataError, InertialcalError, PlanError
from ....core.estimate import Array, Component, Estimate
from ....core.key import Key, Kind
from ....core.remarks import Remark
from ....core.results import Interval
from ....core.show.rounding import number
from ..terms import (
    TERMS,
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    converted,
    parameter_unit,
    quantity_name,
    sample_unit,
    shown_units,
)
from .filtered import Band
from .goodness import (
    MOST,
    SIGNIFICANT,
    SMALL,
    ChiSquare,
    agreement_test,
    chi_squares,
    misfit_of,
    residual_test,
)
from .likelihood import Fitted, Sandwich, covariance_of_runs, estimate, terms_of, time_at
from .limits import (
    NORMAL_BELOW,
    Limit,
    Missing,
    interval_of,
    limits_of_many,
    normal_ends,
    normal_point,
    wide_of_many,
)
from .noise_fit import NoiseFit, Parameter, Rival, TermEstimate
from .order import NAMES, NEARER, PLAUSIBLE, PRICE, SUPPLE, Choice, criterion, present, ranked, separable
from .problem import GAUSS_MARKOV, LINEAR, AllanLike, Problem, Run, inside, problem_of, run_of, unit_of, with_misfit
from .stack import Stack, estimate_each, know, means_of, stacks

AUTO = (*NAMES, GAUSS_MARKOV)
FAST = (Quantization.name, RandomWalk.name)  # terms of short averaging times
MOST_RIVALS = 2  # that a remark gives
FREE = (RandomWalk.name, BiasInstability.name, RateRandomWalk.name)  # in an interval, chosen or not
BRIEF = 10.0  # samples: a correlation time below is that of a filter, rather than of a drift
MATTERS = 1.05  # ratio of random walks from which a remark is given


def fit(
    curves: AllanLike | Run | Sequence[AllanLike | Run],
    kind: Kind | None,
    *,
    terms: str | Sequence[str] = "auto",
    lines: Sequence[float] = (),
    bands: Sequence[Band | None] = (),
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
    bands : sequence of Band or None
        What a filter leaves of each curve, where the sensor has one.
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
    (found,) = fit_many([Fit(curves, kind, terms, lines, bands, axis, unit, p)])
    if isinstance(found, InertialcalError):
        raise found
    return found


@dataclass(frozen=True, eq=False)
class Fit:
    """What `fit` is asked: the same arguments."""

    curves: AllanLike | Run | Sequence[AllanLike | Run]
    kind: Kind | None
    terms: str | Sequence[str] = "auto"
    lines: Sequence[float] = ()
    bands: Sequence[Band | None] = ()
    axis: int | None = None
    unit: str = ""
    p: float = 0.95
    also: tuple[float, ...] = ()  # Probabilities of other intervals, found at once


def fit_many(fits: Sequence[Fit]) -> list[NoiseFit | InertialcalError]:
    """Return what `fit` gives of each, or why there are no terms: series of one sampling are fitted together."""
    found: dict[int, NoiseFit | InertialcalError] = {}
    problems: dict[int, Problem] = {}
    units: dict[int, str] = {}
    for i, one in enumerate(fits):
        try:
            problems[i], units[i] = _problem(one)
        except InertialcalError as error:
            found[i] = error
    places = [*problems]
    for alike in stacks([*problems.values()]):
        ways: dict[tuple[tuple[str, ...], tuple[float, ...]], list[int]] = {}
        for i in (places[j] for j in alike):
            terms = fits[i].terms
            ps = fits[i].p, *fits[i].also
            ways.setdefault(((terms,) if isinstance(terms, str) else tuple(terms), ps), []).append(i)
        for (terms, ps), at in ways.items():
            own = [Asked(problems[i], fits[i].kind, units[i]) for i in at]
            found.update(zip(at, _fitted(own, terms, ps), strict=True))
    return [found[i] for i in range(len(fits))]


class Asked(NamedTuple):
    """One series to fit."""

    problem: Problem
    kind: Kind | None  # Of the sensor
    unit: str  # Of the samples


def _problem(one: Fit) -> tuple[Problem, str]:
    """Return the runs of a fit stacked, and the unit of their samples; what cannot be fitted is refused."""
    if not 0.0 < one.p < 1.0:
        raise PlanError(f"intervals of probability {one.p:g}", do="Give one between 0 and 1: 0.95", code="probability")
    several = list(one.curves) if isinstance(one.curves, Sequence) else [one.curves]
    if not several:
        raise DataError("no Allan deviation to fit", do="Give that of one run, or of several", code="too_short")
    samples = sample_unit(one.kind, one.unit or unit_of(several[0]))
    runs = [run_of(curve, one.axis, samples) for curve in several]
    if one.bands:
        runs = [run if band is None else inside(run, band) for run, band in zip(runs, one.bands, strict=True)]
    problem = problem_of(runs, one.lines)
    if one.terms != "auto":
        _names(one.terms)
    return problem, samples


def _fitted(asked: Sequence[Asked], terms: tuple[str, ...], ps: tuple[float, ...]) -> list[NoiseFit | InertialcalError]:
    """Return the fits of series of one sampling, with intervals of probabilities, the first of them shown."""
    wanted = AUTO if terms == ("auto",) else terms
    solved = _solved(asked, terms, ps[0])
    worse = {
        i: misfit
        for i, one in enumerate(solved)
        if isinstance(one, Solution) and one.residual is not None and one.residual.p < SIGNIFICANT
        for misfit in (misfit_of(one.problem, one.candidates),)
        if misfit > 0.0
    }
    if worse:
        again = [asked[i]._replace(problem=with_misfit(asked[i].problem, misfit)) for i, misfit in worse.items()]
        for i, one in zip(worse, _solved(again, terms, ps[0]), strict=True):
            solved[i] = one
    alike: dict[bytes, list[int]] = {}
    for i, one in enumerate(solved):
        if isinstance(one, Solution):
            alike.setdefault(_pattern(one.fitted), []).append(i)
    ready: dict[int, NoiseFit] = {}
    for at in alike.values():
        several = [one for one in (solved[i] for i in at) if isinstance(one, Solution)]
        ready.update(zip(at, _results([asked[i].problem for i in at], several, wanted, ps), strict=True))
    return [one if isinstance(one, InertialcalError) else ready[i] for i, one in enumerate(solved)]


def _pattern(fitted: Fitted) -> bytes:
    return (fitted.powers > 0.0).tobytes()


def _results(
    plain: Sequence[Problem], solutions: Sequence[Solution], wanted: Sequence[str], ps: Sequence[float]
) -> list[NoiseFit]:
    """Return solutions with the same terms as users see them: the terms found, those that are not, and the tests."""
    stack, there = Stack(tuple([one.problem for one in solutions])), present(solutions[0].fitted)
    names = [name for name in wanted if name not in there]
    every = _estimated(stack, solutions, ps)
    found, missed = every[0], _not_identified(stack, solutions, names)
    estimates, expected = estimates_of(solutions, found), means_of(stack, [one.fitted for one in solutions])
    known: list[dict[float, tuple[TermEstimate, ...]]] = [
        dict(zip(ps[1:], own, strict=True))
        for own in (zip(*every[1:], strict=True) if len(ps) > 1 else [()] * len(solutions))
    ]
    each = zip(plain, solutions, found, missed, estimates, expected, known, strict=True)
    return [_result(*one) for one in each]


def _result(
    plain: Problem, solution: Solution, found: tuple[TermEstimate, ...], missed: tuple[TermEstimate, ...],
    estimate: Estimate, expected: Array, known: dict[float, tuple[TermEstimate, ...]],
) -> NoiseFit:  # fmt: skip
    problem, fitted, best = solution.problem, solution.fitted, solution.table[0].criterion
    residual = solution.residual
    if problem is not plain:
        residual = residual_test(plain, fitted, covariance_of_runs(plain, fitted))
    agreement = agreement_test(problem, fitted, solution.sigma)
    runs, terms, rivals = problem.runs, terms_of(problem, fitted), rivals_of(solution)
    return NoiseFit(
        solution.kind,
        solution.unit,
        found + missed,
        estimate,
        tuple([(choice.terms, choice.criterion - best) for choice in solution.table]),
        residual,
        agreement,
        0.5 * problem.misfit,
        terms,
        tuple([run.tau for run in runs]),
        tuple([run.variance for run in runs]),
        (expected,) if len(runs) == 1 else tuple(np.split(expected, np.cumsum([len(run.m) for run in runs])[:-1])),
        EstimatedAt(solution, known),
        remarks_of(solution, residual, agreement, terms, rivals),
        rivals,
    )


def _solved(asked: Sequence[Asked], terms: tuple[str, ...], p: float) -> list[Solution | InertialcalError]:
    """Choose the terms of series of one sampling, and fit those of the choice closely."""
    stack = Stack(tuple([one.problem for one in asked]))
    candidates = separable(stack.problems[0], AUTO if terms == ("auto",) else terms)
    if terms == ("auto",):
        tables = ranked(stack, candidates)
    else:
        alone = estimate_each(stack, [candidates] * len(stack), looks=1)
        tables = [(Choice(candidates, criterion(candidates, one), *one),) for one in alone]
    fits = estimate_each(stack, [table[0].terms for table in tables])
    found: dict[int, Solution | InertialcalError] = {}
    alike: dict[bytes, list[int]] = {}
    for i, (table, one) in enumerate(zip(tables, fits, strict=True)):
        if not np.isfinite(table[0].cost):
            what = f"{', '.join(candidates)} cannot give this Allan deviation"
            do = 'Add "random_walk", or let the terms be chosen'
            found[i] = DataError(what, why="they are zero where it is not", do=do, code="wrong_terms")
        elif not set(present(one)) - {RateRamp.name}:
            what, why = "the terms are a ramp or a line alone, without noise", "nothing would scatter"
            do = 'Add "random_walk", or check whether the record is computed rather than measured'
            found[i] = DataError(what, why=why, do=do, code="no_noise")
        else:
            alike.setdefault(_pattern(one), []).append(i)
    for at in alike.values():
        known = know(stack.take(at), [fits[i] for i in at], SMALL)
        tests = chi_squares(known.tests)
        for j, i in enumerate(at):
            own = asked[i]
            found[i] = Solution(
                own.problem, candidates, tables[i], fits[i], known.sigma[j], known.bread(j), tests[j], own.kind,
                own.unit, p,
            )  # fmt: skip
    return [found[i] for i in range(len(asked))]


def _names(terms: str | Sequence[str]) -> tuple[str, ...]:
    """Return the wanted terms; unknown ones are refused."""
    wanted = (terms,) if isinstance(terms, str) else tuple(terms)
    unknown = [name for name in wanted if name not in AUTO]
    if unknown or not wanted:
        raise DataError(
            f"no term of noise {', '.join(map(repr, unknown)) or 'given'}",
            do=f"There are: {', '.join(AUTO)}; lines by their frequency",
            code="unknown_term",
        )
    return wanted


def remarks_of(
    solution: Solution, residual: ChiSquare | None, agreement: ChiSquare | None, terms: Sequence[Term],
    rivals: Sequence[Rival],
) -> tuple[Remark, ...]:  # fmt: skip
    """Return what should be known of a fit.

    Parameters
    ----------
    solution : Solution
        The fit.
    residual, agreement : ChiSquare or None
        Whether the terms explain the Allan deviation, and whether runs agree.
    terms : sequence of Term
        Those that were fitted.
    rivals : sequence of Rival
        Those that may be true in their place.
    """
    agree = agreement is None or agreement.p >= SIGNIFICANT
    return (
        *_unexplained(solution, residual, agree),
        *_runs(solution, agree, agreement),
        *_white_beyond(solution, terms),
        *_alike(solution, terms, rivals[:MOST_RIVALS]),
    )


def rivals_of(solution: Solution) -> tuple[Rival, ...]:
    """Return other terms of long averaging times that may be true in place of those taken, the best of each kind."""
    if not solution.rivals:
        return ()
    chosen = solution.table[0]
    found: dict[frozenset[str], Rival] = {frozenset(chosen.terms) - {*FAST}: Rival((), 0.0)}
    for one in solution.rivals:
        terms = terms_of(solution.problem, one.fitted)
        found.setdefault(frozenset(one.terms) - {*FAST}, Rival(terms, one.criterion - chosen.criterion))
    return tuple(one for one in found.values() if one.terms)


def _alike(solution: Solution, terms: Sequence[Term], rivals: Sequence[Rival]) -> tuple[Remark, ...]:
    """Say which terms of long averaging times the record cannot separate, with their sizes in each fit."""
    if not rivals:
        return ()

    def told(terms: Sequence[Term]) -> str:
        return " and ".join(
            _size(solution, term)
            for term in terms
            if term.name not in FAST and term.name != Sinusoid.name
        ) or "white noise alone"  # fmt: skip

    ways = [told(terms), *(told(one.terms) for one in rivals)]
    what = f"terms that the record cannot separate: {', or '.join(ways)}"
    do = "Record longer. Settings of filters take the larger drive of the bias: choose with --take"
    return (Remark("terms_alike", "warning", what, do=do),)


def _size(solution: Solution, term: Term) -> str:
    """Return a term and its size as data sheets have it; of Gauss-Markov noise also its correlation time."""
    word = term.parameters[0]
    inside = parameter_unit(term.name, word, solution.unit)
    unit = next(iter(shown_units(term.name, word, solution.kind)), inside if solution.unit else "")
    value = float(getattr(term, word))
    size = f"{number(converted(value, inside, unit) if unit not in {inside, ''} else value, 3)} {unit}".rstrip()
    if isinstance(term, GaussMarkov):
        return f"Gauss-Markov noise of {size} over {number(term.correlation_time, 2)} s"
    return f"{quantity_name(term.name, word, solution.kind).replace('_', ' ')} {size}"


def _unexplained(solution: Solution, residual: ChiSquare | None, agree: bool) -> tuple[Remark, ...]:
    if residual is None or residual.p >= SIGNIFICANT:
        return ()
    misfit = solution.problem.misfit
    what = f"the terms do not explain the Allan deviation ({residual}): "
    if misfit >= MOST:
        what += f"even allowing each deviation {50.0 * MOST:.2g} % only; no figure of this fit holds"
    elif misfit > 0.0:
        what += f"each deviation is taken as known to {50.0 * misfit:.2g} % at best, and intervals allow for it"
    elif not agree:
        return ()  # that runs differ is said, and each by itself may be explained
    else:
        what += "intervals are too short"
    do = "Look for lines, disturbances or drift (psd)"
    return (Remark("terms_do_not_explain", "warning", what, do=do),)


def _runs(solution: Solution, agree: bool, agreement: ChiSquare | None) -> tuple[Remark, ...]:
    if agree:
        return ()
    what = (
        f"the {len(solution.problem.runs)} runs do not agree on the terms ({agreement}): "
        "the joint figures are a mean, and their intervals do not cover the difference"
    )
    return (Remark("runs_disagree", "warning", what, do="Fit each record alone and see what differs"),)


def _white_beyond(solution: Solution, terms: Sequence[Term]) -> tuple[Remark, ...]:
    markov = terms[-1] if isinstance(terms[-1], GaussMarkov) else None
    white = next((term.coefficient for term in terms if isinstance(term, RandomWalk)), 0.0)
    interval = min(run.interval for run in solution.problem.runs)
    if markov is None or markov.correlation_time >= BRIEF * interval:
        return ()
    both = float(np.hypot(white, markov.sigma * np.sqrt(2.0 * markov.correlation_time)))
    if both < MATTERS * white:
        return ()
    inside = parameter_unit(RandomWalk.name, "coefficient", solution.unit)
    unit = next(iter(shown_units(RandomWalk.name, "coefficient", solution.kind)), inside)
    shown = both if unit == inside else converted(both, inside, unit)
    word = quantity_name(RandomWalk.name, "coefficient", solution.kind).replace("_", " ")
    what = (
        f"Gauss-Markov noise with a correlation time of {number(markov.correlation_time, 2)} s looks white to anything "
        f"slower: together the {word} is {number(shown, 4)} {unit}".rstrip()
    )
    do = "Use that figure for a slower filter, and the terms as they are to simulate samples"
    return (Remark("white_with_filter", "info", what, do=do),)


@dataclass(frozen=True, eq=False)
class Solution:
    """The fit of the terms that were chosen."""

    problem: Problem  # Runs
    candidates: tuple[str, ...]  # Terms that there were to choose from
    table: tuple[Choice, ...]  # All choices, the one that was taken first
    fitted: Fitted  # Sizes of its terms
    sigma: Array  # shape (k, k): Covariance of the Allan variances
    bread: Sandwich  # Covariance of the sizes
    residual: ChiSquare | None  # Whether the terms explain the Allan variances
    kind: Kind | None  # Of the sensor
    unit: str  # Of the samples
    p: float  # Probability of intervals

    @cached_property
    def first(self) -> dict[str, float]:
        """Criterion of the best choice with each term."""
        return {name: one.criterion for one in reversed(self.table) for name in one.terms}

    @cached_property
    def rivals(self) -> tuple[Choice, ...]:
        """Choices that may be true in place of the one that was taken, best first: not with more terms, nor fewer."""
        chosen, *others = self.table
        own, found = {*chosen.terms}, []
        for one in others:
            behind, terms = one.criterion - chosen.criterion, {*one.terms}
            near = behind < PLAUSIBLE and behind < (NEARER if SUPPLE & (terms - own) else PLAUSIBLE)
            if near and terms - own and own - terms:
                found.append(one)
        return tuple(found)


def _free(stack: Stack, solutions: Sequence[Solution]) -> list[tuple[str, ...]]:
    """Return terms that intervals leave free: chosen ones, flicker and a walk, quantisation where it fits."""
    candidates = solutions[0].candidates
    names = present(solutions[0].fitted)
    names += tuple([name for name in FREE if name in candidates and name not in names])
    if Quantization.name not in candidates or Quantization.name in names:
        return [names] * len(solutions)
    more = (*names, Quantization.name)
    at = NAMES.index(Quantization.name)
    return [more if one.powers[at] > 0.0 else names for one in estimate_each(stack, [more] * len(stack), looks=1)]


def estimated(solution: Solution, p: float) -> tuple[TermEstimate, ...]:
    """Return the terms that have a size, with intervals of a probability."""
    return _estimated(Stack((solution.problem,)), [solution], [p])[0][0]


def _estimated(
    stack: Stack, solutions: Sequence[Solution], ps: Sequence[float]
) -> list[list[tuple[TermEstimate, ...]]]:
    """Return the same of solutions with the same terms: of each probability, those of each."""
    problem = solutions[0].problem
    ats: list[int] = np.flatnonzero(solutions[0].fitted.powers > 0.0).tolist()
    last = len(problem.names)
    wanted = [column for column, at in enumerate(ats) if at < len(LINEAR) or at == last]  # not a line
    covariance, naive = (np.array([getattr(one.bread, name) for one in solutions]) for name in ("covariance", "naive"))
    variance = np.diagonal(covariance, axis1=1, axis2=2)
    stretches = (variance / np.diagonal(naive, axis1=1, axis2=2))[:, wanted]
    us, fits = np.sqrt(variance).tolist(), [one.fitted for one in solutions]
    powers, free = np.array([one.powers for one in fits])[:, ats].tolist(), _free(stack, solutions)
    found = []
    for p in ps:
        wide = wide_of_many(stack, fits, [ats[i] for i in wanted], free, stretches, p)
        each = zip(solutions, powers, us, wide, strict=True)
        found.append(
            [_of_solution(one, p, ats, best, u, dict(zip(wanted, own, strict=True))) for one, best, u, own in each]
        )
    return found


def _of_solution(
    solution: Solution, p: float, ats: Sequence[int], powers: Sequence[float], u: Sequence[float],
    wide: Mapping[int, tuple[float, float | None]],
) -> tuple[TermEstimate, ...]:  # fmt: skip
    problem, point = solution.problem, normal_point(p)
    found = []
    for column, at in enumerate(ats):
        lo, hi = _ends(solution, p, at, powers[column], u[column], wide.get(column))
        size = math.sqrt(powers[column])
        half = 0.0 if hi is None else 0.5 * (hi - (lo or 0.0)) / point
        first = (size, max(0.5 * u[column] / size, half), Interval(lo, hi, p))
        if at == len(problem.names):
            time = time_at(problem, solution.fitted.position)
            between = interval_of(problem, solution.fitted, at + 1, solution.bread, p)
            found.append(_found(solution, GAUSS_MARKOV, first, (time, float(time * u[-1]), between)))
        elif at >= len(LINEAR):
            frequency = problem.lines[at - len(LINEAR)]
            found.append(_found(solution, Sinusoid.name, first, (frequency, 0.0, Interval(frequency, frequency, p))))
        else:
            found.append(_found(solution, problem.names[at], first))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class EstimatedAt:
    """The same with intervals of another probability; plain data, so that a fit can be kept."""

    solution: Solution
    known: Mapping[float, tuple[TermEstimate, ...]] = field(default_factory=dict[float, tuple[TermEstimate, ...]])

    def __call__(self, p: float) -> tuple[TermEstimate, ...]:
        """Return the terms that have a size, with intervals of this probability."""
        return self.known[p] if p in self.known else estimated(self.solution, p)


def _ends(
    solution: Solution, p: float, at: int, power: float, u: float, more: tuple[float, float | None] | None
) -> tuple[float | None, float | None]:
    """Return the interval of the size at a place, also with the terms free that were not chosen but may be there."""
    problem, fitted = solution.problem, solution.fitted
    lo: float | None
    hi: float | None
    if u / power < NORMAL_BELOW:
        lo, hi = normal_ends(power, u / power, p)
    else:
        own = interval_of(problem, fitted, at, solution.bread, p)
        lo, hi = own.lo, own.hi
    if more is not None:
        lo = min(lo or 0.0, more[0])
        hi = None if hi is None or more[1] is None else max(hi, more[1])
        if solution.rivals:
            name = problem.names[at] if at < len(problem.names) else GAUSS_MARKOV
            without = [{*one.terms} for one in solution.rivals if name not in one.terms and name not in FAST]
            if any(name in SUPPLE or not SUPPLE & terms - {*present(fitted)} for terms in without):
                lo = 0.0
    return _root(lo), _root(hi)


@cache
def _parameters(name: str, kind: Kind | None, unit: str) -> tuple[tuple[str, str], ...]:
    """Return the field's word of each parameter of a term, and its unit."""
    return tuple((quantity_name(name, word, kind), parameter_unit(name, word, unit)) for word in TERMS[name].parameters)


def _found(solution: Solution, name: str, *values: tuple[float, float, Interval]) -> TermEstimate:
    words = _parameters(name, solution.kind, solution.unit)
    parameters = tuple([Parameter(word, *value, unit) for (word, unit), value in zip(words, values, strict=True)])
    chosen = solution.table[0]
    other = _rival(solution, name, False)
    if name == Sinusoid.name or other is None:
        return TermEstimate(name, "estimated", parameters)
    gained = tuple(one for one in other.terms if one not in chosen.terms)
    worse = other.criterion - chosen.criterion
    return TermEstimate(name, "estimated", parameters, code="like_another", others=gained, worse=worse)


def _not_identified(
    stack: Stack, solutions: Sequence[Solution], names: Sequence[str]
) -> list[tuple[TermEstimate, ...]]:  # fmt: skip
    """Return terms that records do not show: the reason, an upper limit, and the record that would show each."""
    own = [name for name in names if name in solutions[0].candidates]
    rivals = [{name: _rival(one, name, True) for name in own} for one in solutions]
    hidden = _hidden_markov(stack, solutions, [one[GAUSS_MARKOV] for one in rivals]) if GAUSS_MARKOV in own else []
    missing = [
        [
            hidden[i] if name == GAUSS_MARKOV else Missing(NAMES.index(name), one.fitted.position, _fit_of(other[name]))
            for name in own
        ]
        for i, (one, other) in enumerate(zip(solutions, rivals, strict=True))
    ]
    limits: list[list[Limit]] = [[]] * len(solutions)
    if own:
        sigma = np.array([one.sigma for one in solutions])
        limits = limits_of_many(stack, [one.fitted for one in solutions], missing, sigma)
    found = []
    for i, one in enumerate(solutions):
        known = dict(zip(own, zip(missing[i], limits[i], strict=True), strict=True))
        found.append(tuple([
            _hidden(one, name, known[name][0], rivals[i][name], *known[name][1])
            if name in known
            else _like_another(one, name)
            for name in names
        ]))  # fmt: skip
    return found


def _fit_of(choice: Choice | None) -> Fitted | None:
    return None if choice is None else choice.fitted


def _hidden_markov(
    stack: Stack, solutions: Sequence[Solution], rivals: Sequence[Choice | None]
) -> list[Missing]:  # fmt: skip
    """Return Gauss-Markov noise at the correlation time where it hides best, else at the middle of those tried."""
    found, middle = [], 0.5 * (len(solutions[0].problem.table) - 1.0)
    wanted = (*present(solutions[0].fitted), GAUSS_MARKOV)
    every = estimate_each(stack, [wanted] * len(stack))
    for solution, other, best in zip(solutions, rivals, every, strict=True):
        position, rival, chosen = best.position if best.powers[-1] > 0.0 else middle, _fit_of(other), solution.table[0]
        alone = tuple(one for one in chosen.terms if one in FAST)
        if rival is None and alone != chosen.terms:  # in place of what wanders
            instead = estimate(solution.problem, (*alone, GAUSS_MARKOV))
            behind = criterion((*alone, GAUSS_MARKOV), instead) - chosen.criterion
            rival = instead if behind < PLAUSIBLE and instead.powers[-1] > 0.0 else None
        found.append(Missing(len(solution.problem.names), position, rival))
    return found


def _like_another(solution: Solution, name: str) -> TermEstimate:
    """Return a term that is no candidate: it looks like white noise, or like the filter."""
    code = "like_filter" if any(run.band is not None for run in solution.problem.runs) else "like_white"
    words, unit = _words(name, solution.kind, solution.unit)
    return TermEstimate.missing(name, words, code, (), None, None, unit, None, solution.problem.length, None)


def _hidden(
    solution: Solution, name: str, missing: Missing, other: Choice | None, power: float | None, needed: float | None,
    beside_rival: bool,
) -> TermEstimate:  # fmt: skip
    problem, chosen = solution.problem, solution.table[0]
    record = problem.length
    added = solution.first.get(name)
    worse = None if added is None else added - chosen.criterion
    lost: tuple[str, ...] = ()
    if other is not None:
        lost = tuple(one for one in chosen.terms if one not in other.terms)
        code, worse = "like_another", other.criterion - chosen.criterion
    elif name == Quantization.name and RandomWalk.name in chosen.terms:
        code, needed = "hidden_by_white", None  # length is not what lacks
    elif power is None:
        code = "no_limit"
    elif needed is None:
        code = "no_record"
    else:
        code = "too_short" if needed > record else "small"
    limit_at = None
    if name == GAUSS_MARKOV:
        rival = missing.rival if beside_rival else None
        limit_at = time_at(problem, missing.position if rival is None else rival.position)
    words, unit = _words(name, solution.kind, solution.unit)
    return TermEstimate.missing(name, words, code, lost, worse, _root(power), unit, needed, record, limit_at)


@cache
def _words(name: str, kind: Kind | None, unit: str) -> tuple[tuple[str, ...], str]:
    """Return the field's words of the parameters of a term, and the unit of the first."""
    known = _parameters(name, kind, unit)
    return tuple(word for word, _ in known), known[0][1]


def _rival(solution: Solution, name: str, has: bool) -> Choice | None:
    """Return the best choice, with or without a term, that may be true in place of that taken; None where none may."""
    if not solution.rivals:
        return None
    nearly = PRICE if name in FAST else PLAUSIBLE
    worse = solution.table[0].criterion + nearly
    return next((one for one in solution.rivals if (name in one.terms) is has and one.criterion < worse), None)


def _root(power: float | None) -> float | None:
    return None if power is None else math.sqrt(power)


def estimates_of(solutions: Sequence[Solution], found: Sequence[tuple[TermEstimate, ...]]) -> list[Estimate]:
    """Return all parameters of solutions with the same terms, as correlated as powers and the logarithm of a time."""
    known = [[one for term in own for one in term.parameters if one.u > 0.0] for own in found]
    values, us = ([[getattr(one, name) for one in own] for own in known] for name in ("value", "u"))
    covariance = np.array([one.bread.covariance for one in solutions])
    # terms not chosen are free
    sizes = np.array(us) / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    covariance *= sizes[:, :, None] * sizes[:, None]
    return [
        Estimate.of_own(
            _keys(tuple([one.name for one in own])), value, tuple([one.unit for one in own]),
            (Component("scatter of the noise itself", "A", spread),),
        )
        for own, value, spread in zip(known, np.array(values), covariance, strict=True)
    ]  # fmt: skip


@lru_cache(256)
def _keys(names: tuple[str, ...]) -> tuple[Key, ...]:
    """Return keys of names, numbered where one appears more than once: several lines."""
    powers = [names[: i + 1].count(name) if names.count(name) > 1 else 0 for i, name in enumerate(names)]
    return tuple([Key(name, power=n) for name, n in zip(names, powers, strict=True)])
