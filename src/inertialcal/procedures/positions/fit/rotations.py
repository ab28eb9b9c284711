"""Matrix of the gyros from rotations: between static positions, where gravity tells the end, or by a known angle.

Errors and derivatives stand in ``rotation_errors``. The errors known of each rotation are the noise of the gyros over
the time that it takes, the errors of both positions, the stated uncertainties of turns; the scatter between rotations
beside it is of one unknown size (``statistics.two_levels``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....statistics.two_levels import TwoLevels, fit_two_levels
from ..plan import Plan
from .linear_sensor import MATRIX
from .observability import Observed, observed
from .outliers import found_outliers
from .rotation_errors import (
    ANGLE,
    ORIENTATION,
    Errors,
    Problem,
    by_positions,
    by_rest,
    errors,
    known_errors,
    noise_variances,
)

BETWEEN = "scatter between rotations"
STEPS, HALVINGS = 40, 10
SETTLED = 1e-10
ROUNDS = 4  # of leaving out and looking again
REFINED, REFINEMENTS = 1e-8, 6  # step of W from which its weights no longer move it; at most so many

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Rotated:
    """Matrix of the gyros, and how each rotation agrees.

    Parameters
    ----------
    W : ndarray, shape (3, 3)
        Inverse of the matrix.
    found : TwoLevels or None
        Of the parameters of W that are told; None where nothing judges them.
    seen : Observed
        What the rotations can tell.
    by_rest : ndarray, shape (9, 12)
        Derivatives of W by bias and g-sensitivity.
    by_positions : ndarray, shape (9, m, 3)
        Derivatives of W by the unit vectors of the positions.
    outliers : ndarray of bool, shape (rotations,)
        Left out.
    residuals, deletion : ndarray, shape (rows,)
        Of the rows of all rotations, transitions first (two each), then turns (three each) [rad].
    """

    W: Array
    found: TwoLevels | None
    seen: Observed
    by_rest: Array
    by_positions: Array
    outliers: Flags
    residuals: Array
    deletion: Array


def solve(plan: Plan, problem: Problem, start: Array, judge: bool = True) -> Rotated:
    """Find W.

    Parameters
    ----------
    plan : Plan
        Standards, risk of an outlier.
    problem : Problem
        Rotations.
    start : ndarray, shape (3, 3)
        W to begin with.
    judge : bool
        Whether rotations that do not agree are left out.

    Raises
    ------
    DataError
        ``no_rotations`` if there are none.
    """
    group = problem.group
    if not len(group):
        raise DataError(
            "no rotations",
            why="gyros that rest tell their bias alone",
            do="Turn the unit between positions while recording, or by known angles",
            code="no_rotations",
        )
    outliers = np.zeros(int(group.max()) + 1, dtype=bool)
    W, here = _searched(problem, start, errors(problem, start), ~outliers[group])
    for _ in range(ROUNDS if judge else 0):
        found = _outliers(plan, problem, W - start, here)
        if np.array_equal(found, outliers):
            break
        outliers = found
        W, here = _searched(problem, W, here, ~outliers[group])
    return _refined(plan, problem, W, here, ~outliers[group], outliers)


def _outliers(plan: Plan, problem: Problem, change: Array, here: Errors) -> Flags:
    """Rotations that do not agree, by errors linear in W; a wrong W, bent by a wrong rotation, may accuse others."""
    group = problem.group
    seen = _seen(problem, here.by_W, np.ones(len(group), dtype=bool))
    if not seen.rank:
        return np.zeros(int(group.max()) + 1, dtype=bool)
    y, known = here.by_W @ change.ravel() - here.e, known_errors(plan, problem, here.by_start)
    return found_outliers(here.by_W @ seen.kept, y, known, group, plan.outlier_risk)


def converged(problem: Problem, W: Array, kept: Flags) -> Array:
    """Return where Gauss-Newton with equal weights ends, from a W; ``kept``, shape (rows,): rows that count."""
    return _searched(problem, W, errors(problem, W), kept)[0]


def _searched(problem: Problem, W: Array, here: Errors, kept: Flags) -> tuple[Array, Errors]:
    """Gauss-Newton with equal weights, damped, and the errors where it ends; what is not told stays as it starts."""
    cost = float(np.sum(here.e[kept] ** 2))
    for _ in range(STEPS):
        step = np.linalg.lstsq(here.by_W[kept], -here.e[kept], rcond=1e-4)[0].reshape(3, 3)
        for _ in range(HALVINGS):
            there = errors(problem, W + step)
            new = float(np.sum(there.e[kept] ** 2))
            if new <= cost:
                break
            step = 0.5 * step
        else:
            break
        W, here, cost = W + step, there, new
        if np.max(np.abs(step)) <= SETTLED:
            break
    return W, here


def _refined(plan: Plan, problem: Problem, W: Array, here: Errors, kept: Flags, outliers: Flags) -> Rotated:
    """Fit with all that is known of the errors, whose covariance moves a little with W."""
    for _ in range(REFINEMENTS):
        seen = _seen(problem, here.by_W, kept)
        found = _two_levels(plan, problem, here, seen.kept, kept)
        if found is None:
            break
        step = (seen.kept @ found.coefficients).reshape(3, 3)
        W = W + step
        here = errors(problem, W)
        if np.max(np.abs(step)) <= REFINED:
            break
    deletion = here.e.copy()
    if found is not None:
        deletion[kept] = -found.deletion
    gain = _gain(found, seen, here.by_W, kept)
    by_ends = -np.tensordot(gain, by_positions(problem, here.by_start)[kept], axes=1)
    return Rotated(W, found, seen, -gain @ by_rest(problem, W)[kept], by_ends, outliers, here.e, deletion)


def _gain(found: TwoLevels | None, seen: Observed, by_W: Array, kept: Flags) -> Array:
    """Change of W by each row of errors, shape (9, rows)."""
    if found is not None:
        return np.asarray(seen.kept @ found.gain)
    return np.asarray(seen.kept @ np.linalg.pinv(by_W[kept] @ seen.kept))


def _two_levels(plan: Plan, problem: Problem, here: Errors, told: Array, kept: Flags) -> TwoLevels | None:
    """Fit with a scatter between rotations, or without where there is none to be seen but the turns are stated."""
    known = known_errors(plan, problem, here.by_start)
    some = {name: part[kept] if part.ndim == 1 else part[np.ix_(kept, kept)] for name, part in known.items()}
    design, y = here.by_W[kept] @ told, -here.e[kept]
    n, p = design.shape
    if n > p > 0:
        return fit_two_levels(design, y, some)
    stated = ANGLE in known and ORIENTATION in known
    return fit_two_levels(design, y, some, between=0.0) if n == p and stated else None


def _seen(problem: Problem, by_W: Array, kept: Flags) -> Observed:
    scatter = float(np.sqrt(np.mean(noise_variances(problem)[kept])))
    return observed(by_W[kept], MATRIX, scatter)
