"""What should be known of a fit of noise terms: what it does not explain, runs that differ, noise that looks white.

Gauss-Markov noise whose correlation time is but a few samples long is the mark of a sensor's filter: to all that is
slower it is white, with a random walk of sigma sqrt(2 t_c) of its own. Whoever takes the random walk alone for a filter
that runs slower takes too little.
"""

from __future__ import annotations

import numpy as np

from ....core.remarks import Remark
from ....core.show.rounding import number
from ..terms import GaussMarkov, RandomWalk, quantity_name
from ..units import converted, parameter_unit, shown_units
from .goodness import SIGNIFICANT, ChiSquare
from .likelihood import terms_of
from .misfit import MOST
from .term_estimates import Solution

BRIEF = 10.0  # samples: a correlation time below is that of a filter, rather than of a drift
MATTERS = 1.05  # ratio of random walks from which it is told


def remarks_of(solution: Solution, residual: ChiSquare | None, agreement: ChiSquare | None) -> tuple[Remark, ...]:
    """Return what should be known of a fit.

    Parameters
    ----------
    solution : Solution
        The fit.
    residual, agreement : ChiSquare or None
        Whether the terms explain the Allan deviation, and whether runs agree.
    """
    agree = agreement is None or agreement.p >= SIGNIFICANT
    return (
        *_unexplained(solution, residual, agree),
        *_runs(solution, agree, agreement),
        *_white_beyond(solution),
    )


def _unexplained(solution: Solution, residual: ChiSquare | None, agree: bool) -> tuple[Remark, ...]:
    if residual is None or residual.p >= SIGNIFICANT:
        return ()
    misfit = solution.problem.misfit
    what = f"the terms do not explain the Allan deviation ({residual}): "
    if misfit >= MOST:
        what += f"even if each deviation were known to {50.0 * MOST:.2g} % only; no figure of this fit holds"
    elif misfit > 0.0:
        what += f"each deviation was taken as known to {50.0 * misfit:.2g} % at best, in intervals too"
    elif not agree:
        return ()  # that runs differ is said, and each by itself may be explained
    else:
        what += "intervals are too short"
    do = "Look for lines, disturbances or drift (psd), and leave them out or name them"
    return (Remark("terms_do_not_explain", "warning", what, do=do),)


def _runs(solution: Solution, agree: bool, agreement: ChiSquare | None) -> tuple[Remark, ...]:
    if agree:
        return ()
    what = (
        f"the {len(solution.problem.runs)} runs do not agree on the terms ({agreement}): "
        "figures of all together are a mean, and their intervals do not hold the difference"
    )
    return (Remark("runs_disagree", "warning", what, do="Fit each run by itself, and look what differs"),)


def _white_beyond(solution: Solution) -> tuple[Remark, ...]:
    terms = terms_of(solution.problem, solution.fitted)
    white = next((term.coefficient for term in terms if isinstance(term, RandomWalk)), 0.0)
    markov = next((term for term in terms if isinstance(term, GaussMarkov)), None)
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
        f"Gauss-Markov noise with a correlation time of {number(markov.correlation_time, 2)} s is white to all that is "
        f"slower: with it the {word} is {number(shown, 4)} {unit}".rstrip()
    )
    do = "Take that figure for a filter that runs slower, and the terms as they stand to simulate the samples"
    return (Remark("white_with_filter", "info", what, do=do),)
