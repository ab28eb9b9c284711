"""Gyros at rest: bias, and what they read of specific force, from the mean readings of static positions.

``reading_k = b_k + G f_k + earth rate + scatter between positions``, each sensor by itself. The bias b that is told is
the mean of b_k over the time at rest: of the readings less G f, weighted by the length of each rest. Its error is the
noise inside, and what G takes of the wander of b_k; the wander itself belongs to it. What b is in the next record says
``next_record``. Specific force at rest points
up, so that the part of the earth rate along the vertical goes with f: where the latitude is known it is taken off,
``G = G_seen - A omega sin(latitude) / g``; where it is not, it is an uncertainty of G. What the horizontal part adds
changes with the heading of each position, which the rotations tell but for the first (``earth_rate``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.constants import EARTH_ROTATION_RATE
from ....core.estimate import Array
from ....core.influence import Influence
from ....statistics.two_levels import TwoLevels, fit_two_levels, with_gain
from ..plan import Plan
from ..readings import Triad, local_gravity
from ._kernels_transitions import join
from .linear_sensor import Source, level_sources, summed
from .next_record import Rests, Slow, Wander, slow_noise_of
from .outliers import found_outliers
from .rotations import Problem, across, carried

FEWEST = 6  # positions from which g-sensitivity is separable from scatter
LEAST_SPREAD = 0.05  # least singular value of the directions, one where they are spread evenly
INSIDE = "noise inside positions"
BETWEEN = "scatter between positions, gyros at rest"
NEED = f"needs {FEWEST} positions that point into all directions"

Flags = NDArray[np.bool_]
VERTICAL = "earth rate along the vertical"
LEVEL = "earth rate across the vertical"


@dataclass(frozen=True, eq=False)
class AtRest:
    """Bias and g-sensitivity of three gyros, before their matrix is known."""

    bias: Array  # shape (3,): [rad/s]
    g_sensitivity: Array | None  # shape (3, 3): as it was seen, earth rate included [(rad/s)/(m/s^2)]
    # Of x, y, z; coefficients bias and three of G; None with too few positions for a scatter
    fits: tuple[TwoLevels, ...] | None
    residuals: Array  # shape (m, 3): [rad/s]
    outliers: Flags  # shape (m,): positions left out
    reason: str  # Why there is no g-sensitivity
    share: float  # Part of the variance of the mean readings that g-sensitivity explains; NaN without
    slow: tuple[Slow | None, ...] = (None,) * 3  # Of x, y, z: how the bias wanders, where the readings show it

    @property
    def between(self) -> Array | None:
        """Standard deviation between positions of each gyro [rad/s], shape (3,)."""
        return None if self.fits is None else np.array([one.between for one in self.fits])


def at_rest(
    plan: Plan,
    triad: Triad,
    force: Array,
    ideal: Array,
    zero: Array,
    north: Carried | None = None,
    rests: Rests | None = None,
) -> AtRest:
    """Return bias and g-sensitivity from static positions.

    Parameters
    ----------
    plan : Plan
        Whether g-sensitivity is wanted.
    triad : Triad
        Mean readings of the gyros.
    force : ndarray, shape (m, 3)
        Specific force in the positions, in the body frame [m/s^2].
    ideal, zero : ndarray, shape (3,)
        To which the readings are taken.
    north : Carried, optional
        How the earth rate across the vertical is carried through the positions; without it nothing is judged: a start.
    rests : Rests, optional
        When they were; without it the positions weigh as their errors say.
    """
    r, inside = (triad.mean - zero) / ideal, (triad.u / ideal) ** 2
    reason = "the plan leaves it out" if plan.g_sensitivity is False else ""
    if not reason and len(force) < FEWEST:
        reason = f"{len(force)} position(s): {NEED}"
    if not reason:
        directions = np.hstack([np.ones((len(force), 1)), np.sqrt(3.0) * force / local_gravity(plan)])
        smallest = float(np.linalg.svd(directions / np.sqrt(len(force)), compute_uv=False)[-1])
        reason = "" if smallest >= LEAST_SPREAD else f"the positions lie in one plane: {NEED}"
    with_g = not reason
    design = np.hstack([np.ones((len(r), 1)), force]) if with_g else np.ones((len(r), 1))
    outliers, fits = np.zeros(len(r), dtype=bool), None
    if north is not None:
        outliers, fits = _judged(plan, design, r, inside, level_covariance(plan, north))
    kept = ~outliers
    found = np.linalg.lstsq(design[kept], r[kept], rcond=None)[0]
    slow: tuple[Slow | None, ...] = (None,) * 3
    if fits is not None and rests is not None:
        used = rests.take(kept)
        timed = [_over_time(one, force[kept], used) for one in fits]
        fits, slow = tuple(one for one, _ in timed), tuple(one for _, one in timed)
    if fits is not None:
        found = np.column_stack([one.coefficients for one in fits])
    residuals = r - design @ found
    centred = r[kept] - r[kept].mean(axis=0)
    total = float(np.sum(centred**2))
    share = 1.0 - float(np.sum(residuals[kept] ** 2)) / total if with_g and total else float("nan")
    G = np.asarray(found[1:].T, dtype=np.float64) if with_g else None
    return AtRest(np.asarray(found[0]), G, fits, residuals, outliers, reason, share, slow)


def _over_time(fit: TwoLevels, force: Array, rests: Rests) -> tuple[TwoLevels, Slow | None]:
    """Return a fit whose bias is the mean over the time at rest, and the wander of the bias.

    Of the scatter between positions that part is counted in the bias which is one of positions; the other, the wander
    of the bias, only by what G takes of it.
    """
    alone = np.tile([1.0, 0.0, 0.0], (len(force), 1))
    wander = Wander(fit.projector, fit.residuals, fit.free, fit.between**2, np.arange(len(force)), alone)
    slow = slow_noise_of(wander, rests)
    share = 1.0 if slow is None else slow.of_positions
    weights, gain = rests.weights, fit.gain.copy()
    gain[0] = weights - (weights @ force) @ gain[1:] if len(gain) > 1 else weights
    moved = gain.copy()
    moved[0] -= weights
    by_scatter = np.hstack([np.sqrt(share) * gain, np.sqrt(1.0 - share) * moved])
    return with_gain(fit, gain, by_scatter), slow


def _judged(
    plan: Plan, design: Array, r: Array, inside: Array, level: Array
) -> tuple[Flags, tuple[TwoLevels, ...] | None]:
    """Return which positions disagree, and the fits of the others, where there are enough of them."""
    outliers = np.zeros(len(r), dtype=bool)
    for k in range(3):
        known = {INSIDE: inside[:, k], LEVEL: level[k]}
        outliers |= found_outliers(design, r[:, k], known, np.arange(len(r)), plan.outlier_risk / 3.0)
    kept = ~outliers
    if np.sum(kept) <= design.shape[1] or not np.all(np.ptp(r[kept], axis=0) > 0.0):
        return outliers, None
    some = np.ix_(kept, kept)
    fits = tuple(
        fit_two_levels(design[kept], r[kept, k], {INSIDE: inside[kept, k], LEVEL: level[k][some]}) for k in range(3)
    )
    return outliers, fits


def sources_of(plan: Plan, rest: AtRest, back: Array) -> list[Source]:
    """Return the uncertainty of bias and G as that of numbers that depend on them.

    Where the noise inside explains more than the positions scatter, their mean square decides all the same, with its
    own degrees of freedom: cut at the noise, an interval of few positions would hold the truth too often.

    Parameters
    ----------
    plan : Plan
        Latitude.
    rest : AtRest
        The fits.
    back : ndarray, shape (q, 12)
        Numbers per b_x, b_y, b_z, G_xx, ..., G_zz.
    """
    if rest.fits is None:
        return []
    level = level_influence(plan)
    groups = []
    for k, fit in enumerate(rest.fits):
        at = np.array([k, 3 + 3 * k, 4 + 3 * k, 5 + 3 * k])[: len(fit.coefficients)]
        share = fit.chi_square / fit.free if fit.between == 0.0 and fit.chi_square > 0.0 else 1.0
        groups.append(level_sources(fit, back[:, at], {LEVEL: level}, BETWEEN, share))
    return summed(groups)


@dataclass(frozen=True, eq=False)
class Carried:
    """Two axes across the vertical in each position, and which positions they are carried through."""

    axes: Array  # shape (m, 2, 3): unit vectors along the body axes
    chain: NDArray[np.int64]  # shape (m,): positions of one number follow one another by rotations that were seen


def apart(force: Array) -> Carried:
    """Return axes of positions none of which is joined to another; ``force``, shape (m, 3): specific force."""
    up = force / np.linalg.norm(force, axis=1)[:, None]
    return Carried(across(up), np.arange(len(up)))


def joined(problem: Problem, force: Array, W: Array) -> Carried:
    """Return axes carried through the transitions.

    Parameters
    ----------
    problem : Problem
        Transitions, each to the position after the one that it leaves.
    force : ndarray, shape (m, 3)
        Specific force in the positions, in the body frame.
    W : ndarray, shape (3, 3)
        Inverse of the matrix of the gyros, near enough.
    """
    own, ends = apart(force), problem.ends
    up = force / np.linalg.norm(force, axis=1)[:, None]
    turn = np.argsort(ends.after, kind="stable")
    C = carried(problem.moves, W[None])[0]
    join(C[turn], up, ends.before[turn], ends.after[turn], own.axes, own.chain)
    return own


def level_influence(plan: Plan) -> Influence:
    """Return the rate along one axis across the vertical; the mean square over all sines of a latitude not known."""
    mean_square = 1.0 / 3.0 if plan.latitude is None else 0.5 * np.cos(plan.latitude) ** 2
    return Influence(EARTH_ROTATION_RATE.value * float(np.sqrt(mean_square)), "rad/s")


def level_covariance(plan: Plan, north: Carried) -> Array:
    """Return the covariances of the mean readings of gyros x, y, z, shape (3, m, m) [(rad/s)^2]."""
    same = north.chain[:, None] == north.chain[None, :]
    return np.asarray(level_influence(plan).u ** 2 * same * np.einsum("mak,nak->kmn", north.axes, north.axes))


def earth_in_g(plan: Plan, matrix: Array) -> tuple[Array, Source | None]:
    """Return what the vertical earth rate adds to G, shape (3, 3), and its uncertainty over bias and G, (12, 12)."""
    per_force = matrix * EARTH_ROTATION_RATE.value / local_gravity(plan)
    if plan.latitude is not None:
        return np.asarray(per_force * np.sin(plan.latitude)), None
    change = np.concatenate([np.zeros(3), (per_force / np.sqrt(3.0)).ravel()])  # sine of a place anywhere: flat
    influence = Influence(EARTH_ROTATION_RATE.value / np.sqrt(3.0), "rad/s", distribution="rectangular")
    return np.zeros((3, 3)), Source(VERTICAL, "B", np.outer(change, change), np.inf, influence)
