"""Accelerometers from positions of unknown orientation, with a stated prior on misalignment, scale factor and bias.

Where the positions leave combinations of the nine numbers open, a prior fills them: each quantity q is expected at
its ideal value, within a stated standard uncertainty P::

    minimum of  sum (e_k / s)^2 + sum (q / P)^2          e_k = |x_k| - g, s from the noise and the scatter

The scatter between positions follows from the positions with the prior integrated out (restricted maximum
likelihood), so that nine positions or fewer have degrees of freedom, too. The uncertainty is that of the posterior;
what the prior contributes is a component of Type B of its own.

What is assumed: the true values are drawn from normal distributions of mean 0 and the stated standard uncertainties,
independent of each other. What the uncertainty means: over such units, laid in such positions, 95 % of the intervals
hold the truth. Three ways in which real data break it: a prior that is too narrow biases what the positions hardly tell
(`conflict` shows it only where they tell something, `prior_conflict`); a position that was touched pulls all the
figures, and with few positions none stands out (positions left out show it: `left_out`); misalignments that come from
one cause, a bent board, are not independent: their intervals hold together or fail together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy import special

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.influence import Influence
from ....core.key import Key
from ....statistics.two_levels import TwoLevels, fit_with_prior
from ..plan import Plan
from ..readings import Triad, local_gravity
from ._kernels_sphere import SETTLED, prior_rows
from .accelerometer import (
    LOST,
    NAMES,
    Fitted,
    by_kind,
    converged,
    determined_forward,
    finished,
    forward,
    lengths,
    nominal,
    normalised,
    of_lengths,
    sensor_of,
    sources_of,
    sphere,
    variances,
)
from .fixture import INSIDE
from .linear_sensor import Observability, observe

STEPS = 30
SMALL = 1e-9  # singular value over the largest one: what neither the positions nor the prior determine
START = 1e-3  # scatter of a length that the first steps take [gravities]
PRIORS = {name: f"prior.{name}" for name in ("misalignment", "scale_factor_error", "bias")}  # sources, by quantity
IDEAL = {"acc_scale_factor": "the ideal scale factor", "acc_zero": "the reading for no input"}
UNIT = {"misalignment": "rad", "scale_factor_error": "1", "bias": "m/s^2"}


@dataclass(frozen=True, eq=False)
class Judgement:
    """How a prior agrees with the positions, and whether it helps."""

    without: Fitted  # The same positions without the prior
    stated: Mapping[str, float]  # Prior standard uncertainties, by quantity [rad, 1, m/s^2]
    p_value: float  # Probability of a disagreement as large as this one, were the prior right
    farthest: tuple[Key, float]  # Quantity that lies farthest from 0, and by how many of its prior u
    left_out: Mapping[str, Array]  # shape (m,): error of gravity in each position left out, by the fit [m/s^2]


def check_prior(plan: Plan, si: bool) -> None:
    """Refuse a prior on figures that readings in counts define themselves.

    Raises
    ------
    DataError
        ``prior_without_ideal``.
    """
    needs = {"scale_factor_error": ("acc_scale_factor",), "bias": ("acc_scale_factor", "acc_zero")}
    for quantity, names in needs.items():
        absent = [name for name in names if quantity in plan.priors and not si and getattr(plan, name) is None]
        if absent:
            raise DataError(
                f"a prior on {quantity} needs {' and '.join(IDEAL[name] for name in absent)}",
                why="the readings are not in m/s^2, and the prior is about the ideal scale factor and zero",
                do="Give the sensor a chain with the scale factor and zero of its data sheet, or leave this prior out",
                code="prior_without_ideal",
            )


def rows_of(theta: Array, g: float, stated: Mapping[str, float]) -> Mapping[str, tuple[Array, Array]]:
    """Return what a prior expects of scaled parameters, quantity by quantity.

    The derivatives of each by the parameters, and its values, over its prior u.
    """
    rows, q = np.empty((9, 9)), np.empty(9)
    prior_rows(theta, g, by_kind(stated), rows, q)
    at = {"scale_factor_error": slice(3), "misalignment": slice(3, 6), "bias": slice(6, 9)}
    return {quantity: (rows[at[quantity]], q[at[quantity]]) for quantity in stated}


def fit_prior(plan: Plan, triad: Triad, ideal: Array, zero: Array, without: Fitted) -> tuple[Fitted, Judgement | None]:
    """Return the accelerometers with the prior that the plan states, and how it agrees with the positions.

    Parameters
    ----------
    plan, triad, ideal, zero
        As `fit_unknown` takes them.
    without : Fitted
        What that gives.

    Returns
    -------
    Fitted
        With the prior; without it where even so no degree of freedom is left.
    Judgement or None
        None there.
    """
    g, stated = local_gravity(plan), plan.priors
    r, inside = normalised(triad, ideal, zero)
    kept = ~without.outliers
    r, inside = r[kept], inside[kept]
    theta = converged(r, g, np.full(len(r), 1.0 / (START * g)), nominal(g), SMALL, stated)
    size, most = START * g, without.between_interval[1] if without.free else np.inf
    solved = _solved(theta, r, inside, g, stated, size, most)
    for _ in range(STEPS):
        if solved is None:
            return without, None
        observed, found, noise = solved
        step = observed.kept @ found.coefficients
        theta = theta + step
        if np.max(np.abs(step)) <= SETTLED * g:
            break
        size = float(np.sqrt(np.mean(noise) + found.between**2))
        solved = _solved(theta, r, inside, g, stated, size, most)
    away = lengths(theta, normalised(triad, ideal, zero)[0], g)[0]
    values, to_values = forward(theta, g)
    influences = {PRIORS[name]: Influence(u, UNIT[name], certificate="stated prior") for name, u in stated.items()}
    sources = sources_of(found, to_values @ observed.kept, {**plan.standards, **influences}, noise)
    sensor = sensor_of(plan, values, sources, determined_forward(observed.determined), ideal, zero, of_frame=True)
    worth = max(1, round(found.information * float(np.mean(noise + found.between**2)) ** 2))
    fitted = finished(sensor, observed, without.outliers, away[:, None], replace(found, free=worth), known=False)
    gain = of_lengths(to_values @ observed.kept, found.gain[:, : len(r)], lengths(theta, r, g)[1], kept)
    # The positions alone show how a bias wanders
    fitted = replace(fitted, wandering=without.wandering, per_reading=gain)
    chi_square, free, farthest = conflict(theta, r, inside, g, stated, found.between)
    p_value = float(special.chdtrc(free, chi_square)) if free else 1.0
    return fitted, Judgement(without, stated, p_value, farthest, left_out(r, inside, g, stated, found.between))


def _solved(
    theta: Array, r: Array, inside: Array, g: float, stated: Mapping[str, float], size: float, most: float
) -> tuple[Observability, TwoLevels, Array] | None:
    """Return what is determined, the step from scaled parameters, and the noise; None with no degree of freedom left.

    ``size``: scatter of a length, to judge by what is determined; ``most``: largest scatter between positions.
    """
    e, jacobian, u = lengths(theta, r, g)
    noise, rows = variances(theta, u, inside, g), rows_of(theta, g, stated)
    every = np.vstack([jacobian / g, *(size / g * row for row, _ in rows.values())])
    observed = observe(every, NAMES, size / g, LOST, smallest=SMALL)
    if len(r) <= observed.rank - sum(len(q) for _, q in rows.values()):
        return None
    prior = {PRIORS[name]: (row @ observed.kept, -q) for name, (row, q) in rows.items()}
    return observed, fit_with_prior(jacobian @ observed.kept, -e, {INSIDE: noise}, prior, most), noise


def conflict(
    theta: Array, r: Array, inside: Array, g: float, stated: Mapping[str, float], between: float
) -> tuple[float, int, tuple[Key, float]]:
    """Return by how much prior and positions disagree (chi-square and its degrees of freedom), and what is farthest.

    Were the prior right, what it adds to the weighted sum of squares is a chi-square, whatever the positions tell.
    """
    e, jacobian, u = lengths(theta, r, g)
    variance = variances(theta, u, inside, g) + between**2
    root = 1.0 / np.sqrt(np.where(variance > 0.0, variance, (START * g) ** 2))
    rows = rows_of(theta, g, stated)
    H, h = (np.concatenate([part[k] for part in rows.values()]) for k in range(2))
    J, y = jacobian * root[:, None], e * root
    alone = y - J @ np.linalg.lstsq(J, y, rcond=SMALL)[0]
    chi_square = float(y @ y + h @ h - alone @ alone)
    rank = partial(np.linalg.matrix_rank, rtol=SMALL)
    keys = [key for name in rows for key in NAMES if key.quantity == name]
    k = int(np.argmax(np.abs(h)))
    return max(chi_square, 0.0), int(rank(J) + rank(H) - rank(np.vstack([J, H]))), (keys[k], float(h[k]))


def left_out(r: Array, inside: Array, g: float, stated: Mapping[str, float], between: float) -> Mapping[str, Array]:
    """Return the error of gravity in each position by a fit of the others: with the prior, without it, and as read.

    Parameters
    ----------
    r, inside : ndarray, shape (m, 3)
        Readings in units of the input, and their variances by the noise inside.
    g : float
        Gravity.
    stated : mapping of str to float
        Prior standard uncertainties.
    between : float
        Scatter between positions [m/s^2].
    """
    variance = np.mean(inside, axis=1) + between**2
    root = 1.0 / np.sqrt(np.where(variance > 0.0, variance, (START * g) ** 2))
    found: dict[str, list[float]] = {"prior": [], "without_prior": [], "as_read": []}
    for k in range(len(r)):
        rest = np.arange(len(r)) != k
        fits = {
            "prior": converged(r[rest], g, root[rest], nominal(g), SMALL, stated),
            "without_prior": sphere(r[rest], inside[rest], g)[0],
            "as_read": nominal(g),
        }
        for name, theta in fits.items():
            found[name].append(float(lengths(theta, r[[k]], g)[0][0]))
    return {name: np.array(errors) for name, errors in found.items()}
