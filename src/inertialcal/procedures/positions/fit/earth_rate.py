"""Earth rate in positions laid by hand: what it adds to the mean readings of gyros at rest.

Along the vertical it is ``omega sin(latitude)`` and goes with the specific force: it adds to g-sensitivity, and is
taken off where the latitude is known. Across the vertical it is ``omega cos(latitude)``, towards north. Where north is
nobody knows, but it is one direction, and the gyros carry it from each position to the next: the errors of positions
that follow one another belong together, and would not average out as a scatter does. With a first heading anywhere,
two axes across the vertical, carried along, share the rate, each with the variance ``(omega cos(latitude))^2 / 2``. As
a known covariance of the readings it costs little where the readings are good enough to tell north themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.constants import EARTH_ROTATION_RATE
from ....core.estimate import Array
from ....core.influence import Influence
from ..gravity import local_gravity
from ..plan import Plan
from .attitudes import carried
from .linear_sensor import Source
from .rotation_errors import Problem, across

VERTICAL = "earth rate along the vertical"
LEVEL = "earth rate across the vertical"


@dataclass(frozen=True, eq=False)
class Carried:
    """Two axes across the vertical in each position, and which positions they are carried through.

    Parameters
    ----------
    axes : ndarray, shape (m, 2, 3)
        Unit vectors along the body axes.
    chain : ndarray of int, shape (m,)
        Positions of one number follow one another by rotations that were seen.
    """

    axes: Array
    chain: NDArray[np.int64]


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
    own = apart(force)
    axes, chain = own.axes.copy(), own.chain.copy()
    up = force / np.linalg.norm(force, axis=1)[:, None]
    ends, C = problem.ends, carried(problem.moves, W)[0]
    for k in np.argsort(ends.after, kind="stable"):
        before, after = ends.before[k], ends.after[k]
        first = C[k] @ axes[before, 0]
        first = first - (first @ up[after]) * up[after]
        first /= np.linalg.norm(first)
        axes[after] = first, np.cross(up[after], first)
        chain[after] = chain[before]
    return Carried(axes, chain)


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
