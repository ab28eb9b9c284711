"""Positions that determine an accelerometer triad: uncertainty before the test, the next position, how many.

At rest a triad reads ``r = b + M f``. Where each position is known, a sensor has four unknowns and each position one
equation for it, with the error of the position on top of the scatter: ``g pose`` across what points up, the same
whenever a direction is laid again. Where only the size of gravity is known, a position has one equation for all nine
unknowns of a triangular M, and no error of the position matters::

    d(|M^-1 (r - b)| - g) = - g sum_i u_i^2 ds_i - g sum_(i>j) u_i u_j dm_ij - sum_i u_i db_i

with u the direction up. Predictions are for sensors near M = I, b = 0, a fit that weighs each reading by its error, and
scatter of one known size in all positions: degrees of freedom are infinite. The error of gravity is one for all
positions, and no number of them makes it smaller.

References
----------
.. [1] Fedorov, Theory of Optimal Experiments, Academic Press 1972 (D- and A-optimal designs, one point after another).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....core.constants import STANDARD_GRAVITY
from ....core.errors import PlanError
from ....core.estimate import Array
from ....core.key import AXES, Key
from ....core.show.rounding import uncertainty
from ..fit.linear_sensor import observe

MOST = 200  # positions that a person lays
FAINT = 1e-6  # information that a position is compared with, where no other tells yet; below, rounding decides
SAME = 1e-6  # difference of directions that are one
TIE = 1e-7  # of the logarithm of a goal: the order in which a machine adds makes no sign better
DETERMINANT, TRACE = "determinant", "trace"
LOWER = ((1, 0), (2, 0), (2, 1))


@dataclass(frozen=True)
class Setup:
    """What is known before the test."""

    scatter: float  # Standard deviation of the mean reading of one position, all causes [m/s2]
    known: bool = False  # Whether the direction of each position is known
    pose: float = 0.0  # Standard uncertainty of a known direction, about each axis, always the same in one [rad]
    gravity: float = field(default=float(STANDARD_GRAVITY.value))  # Local gravity [m/s2]
    gravity_u: float = 0.0  # Its standard uncertainty [m/s2]

    def __post_init__(self) -> None:
        numbers = {"scatter": self.scatter, "gravity": self.gravity}
        wrong = {name: value for name, value in numbers.items() if not 0.0 < value < np.inf}
        wrong |= {n: v for n, v in {"pose": self.pose, "gravity_u": self.gravity_u}.items() if not 0.0 <= v < np.inf}
        for name, value in wrong.items():
            raise PlanError(f"{name} {value!r}: need a positive number", code="bad_argument")


@dataclass(frozen=True, eq=False)
class Prediction:
    """Uncertainty that a set of positions would give."""

    keys: tuple[Key, ...]  # Parameters
    units: tuple[str, ...]  # SI
    u: Array  # shape (k,): standard uncertainties; infinite where not determined
    covariance: Array  # shape (k, k): NaN in rows and columns of what is not determined
    rank: int  # Combinations that are determined
    count: int  # Of how many
    condition: float  # Of these
    undetermined: tuple[str, ...]  # Combinations that are not, in words
    parts: tuple[frozenset[Key], ...]  # Parameters that take part in each of them

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters as a model names them."""
        return tuple(map(str, self.keys))


@dataclass(frozen=True, eq=False)
class Course:
    """Positions to take, one after another."""

    directions: Array  # shape (n, 3): what points up, in body axes
    prediction: Prediction  # After the last of them


def cube() -> Array:
    """Return the 26 directions of a cube: faces, edges, corners, shape (26, 3)."""
    found = [np.array(one, dtype=np.float64) for one in product((0, 1, -1), repeat=3) if any(one)]
    ordered = sorted(found, key=lambda one: float(one @ one))
    return np.array([one / np.linalg.norm(one) for one in ordered])


def sphere(n: int) -> Array:
    """Return n directions spread over the sphere along a spiral, shape (n, 3)."""
    k = np.arange(n) + 0.5
    z = 1.0 - 2.0 * k / n
    around = np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - z**2)
    return np.column_stack([ring * np.cos(around), ring * np.sin(around), z])


def parameters(known: bool) -> tuple[tuple[Key, ...], tuple[str, ...]]:
    """Return the parameters that a test determines, and their units."""
    pairs = [(i, j) for i in range(3) for j in range(3) if i != j] if known else LOWER
    keys = (
        *(Key("scale_factor_error", a) for a in AXES),
        *(Key("misalignment", AXES[i] + AXES[j]) for i, j in pairs),
        *(Key("bias", a) for a in AXES),
    )
    return keys, ("1",) * 3 + ("rad",) * len(pairs) + ("m/s^2",) * 3


def parameter_names(known: bool) -> tuple[str, ...]:
    """Return the names of the parameters that a test determines."""
    return tuple(map(str, parameters(known)[0]))


def equations(setup: Setup, directions: ArrayLike, counts: ArrayLike = 1.0) -> tuple[Array, Array]:
    """Return the derivatives of mean readings by the parameters, biases in gravities, and the standard deviations.

    Parameters
    ----------
    directions : array_like, shape (n, 3)
        What points up, in body axes.
    counts : array_like, shape (n,), optional
        How often each is laid; once by default.

    Returns
    -------
    tuple of ndarray
        Shape (n, e, k) [gravities] and (n, e) [gravities]: e is 1 where directions are not known, else 3.
    """
    u = np.asarray(directions, dtype=np.float64).reshape(-1, 3)
    u = u / np.linalg.norm(u, axis=1, keepdims=True)
    relative = setup.scatter / setup.gravity / np.sqrt(np.broadcast_to(counts, len(u)))[:, np.newaxis]
    if not setup.known:
        rows = np.column_stack([u**2, *(u[:, i] * u[:, j] for i, j in LOWER), u])
        return -rows[:, np.newaxis], relative
    rows = np.zeros((len(u), 3, 12))
    pairs = [(i, j) for i in range(3) for j in range(3) if i != j]
    for i in range(3):
        rows[:, i, i], rows[:, i, 9 + i] = u[:, i], 1.0
    for at, (i, j) in enumerate(pairs):
        rows[:, i, 3 + at] = u[:, j]
    return rows, np.sqrt(relative**2 + setup.pose**2 * (1.0 - u**2))


def _faces(directions: ArrayLike) -> tuple[Array, Array]:
    """Return the directions without repeats, and how often each is laid."""
    u = np.asarray(directions, dtype=np.float64).reshape(-1, 3)
    unit = u / np.linalg.norm(u, axis=1, keepdims=True)
    same = np.max(np.abs(unit[:, None] - unit[None]), axis=2, initial=0.0) < SAME
    first = np.argmax(same, axis=1) == np.arange(len(u)) if len(u) else np.zeros(0, dtype=bool)
    return u[first], same.sum(axis=1)[first].astype(np.float64)


def predict_uncertainty(setup: Setup, directions: ArrayLike) -> Prediction:
    """Return the uncertainty that positions would give.

    Parameters
    ----------
    directions : array_like, shape (n, 3)
        What points up, in body axes.

    Raises
    ------
    PlanError
        ``bad_argument`` without a position.
    """
    rows, deviations = equations(setup, *_faces(directions))
    if not len(rows):
        raise PlanError("no position given", do="Give one or more", code="bad_argument")
    keys, units = parameters(setup.known)
    k = len(keys)
    flat, weights = rows.reshape(-1, k), 1.0 / deviations.reshape(-1, 1)
    scaled = flat * (setup.scatter / setup.gravity) * weights
    observed = observe(scaled, keys, setup.scatter / setup.gravity)
    sizes = np.linalg.svd(scaled @ observed.kept, compute_uv=False)
    covariance = _covariance(setup, flat * weights, observed.kept, observed.determined)
    with np.errstate(invalid="ignore"):
        u = np.where(observed.determined, np.sqrt(np.diag(covariance)), np.inf)
    return Prediction(
        keys,
        units,
        u,
        covariance,
        observed.rank,
        observed.count,
        float(sizes[0] / sizes[-1]) if observed.rank else np.inf,
        observed.combinations,
        observed.parts,
    )


def _covariance(setup: Setup, weighted: Array, kept: Array, determined: NDArray[np.bool_]) -> Array:
    """Return the covariance in the units of the parameters, the error of gravity in it."""
    k = weighted.shape[1]
    inner = kept.T @ (weighted.T @ weighted) @ kept
    total = kept @ np.linalg.inv(inner) @ kept.T if kept.shape[1] else np.zeros((k, k))
    common = np.zeros(k)
    common[:3] = setup.gravity_u / setup.gravity
    total = total + np.outer(common, common)
    lengths = np.ones(k)
    lengths[-3:] = setup.gravity
    total = total * np.outer(lengths, lengths)
    total[~determined] = np.nan
    total[:, ~determined] = np.nan
    return np.asarray(total)


def next_position(
    setup: Setup,
    directions: ArrayLike,
    candidates: ArrayLike | None = None,
    goal: str | Mapping[str, float] = DETERMINANT,
) -> Array:
    """Return the candidate that helps most after the positions taken.

    Parameters
    ----------
    directions : array_like, shape (n, 3)
        Positions taken; may be empty.
    candidates : array_like, shape (c, 3), optional
        By default the 26 directions of a cube.
    goal : str, or mapping of str to float
        ``"determinant"`` (all parameters together: D-optimal), ``"trace"`` (sum of variances, biases in gravities:
        A-optimal), or the name of a parameter; or what is wanted, as `course` takes it: the sum of the variances over
        the squares of what is wanted.

    Returns
    -------
    ndarray, shape (3,)
        First of the best.

    Raises
    ------
    PlanError
        ``unknown_parameter``.
    """
    names, weights = parameter_names(setup.known), None
    if not isinstance(goal, str):
        weights = _wanted(setup, _limits(setup, goal))
    elif goal not in (DETERMINANT, TRACE, *names):
        do = f"Use {DETERMINANT}, {TRACE} or one of {', '.join(names)}"
        raise PlanError(f"goal {goal!r}: no such parameter", do=do, code="unknown_parameter")
    elif goal != DETERMINANT:
        weights = np.array([float(goal in (TRACE, name)) for name in names])
    options = cube() if candidates is None else np.asarray(candidates, dtype=np.float64).reshape(-1, 3)
    best = _best(setup, directions, options, weights)
    return np.asarray(options[best], dtype=np.float64)


def _information(setup: Setup, directions: ArrayLike) -> Array:
    rows, deviations = equations(setup, *_faces(directions))
    weighted = (rows / deviations[..., np.newaxis]).reshape(-1, rows.shape[-1])
    return np.asarray(weighted.T @ weighted)


def _best(setup: Setup, directions: ArrayLike, options: Array, weights: Array | None) -> int:
    """Return the number of the option after which the goal is best; ties go to the first."""
    taken, counts = _faces(directions)
    unit = [one / np.linalg.norm(one, axis=1, keepdims=True) for one in (options, taken)]
    same = np.max(np.abs(unit[0][:, None] - unit[1][None]), axis=2, initial=0.0) < SAME
    before = same @ counts  # times that each option was laid
    rows, deviations = equations(setup, options, before + 1.0)
    k = rows.shape[-1]
    base = _information(setup, directions) + FAINT * (setup.gravity / setup.scatter) ** 2 * np.eye(k)
    gained = deviations**-2.0
    gained[before > 0.0] -= equations(setup, options[before > 0.0], before[before > 0.0])[1] ** -2.0
    after = base + np.einsum("cek,ce,cel->ckl", rows, gained, rows)
    if weights is None:
        score = -np.linalg.slogdet(after)[1]
    else:
        score = np.log(np.diagonal(np.linalg.inv(after), axis1=1, axis2=2) @ weights)
    shape = np.sort(np.abs(options), axis=-1)
    best = int(np.argmin(score))
    alike = np.all(np.isclose(shape, shape[best]), axis=-1)  # the same but for signs and the order of axes
    return int(np.argmax(alike & (score <= score[best] + TIE)))


def course(
    setup: Setup,
    target: Mapping[str, float],
    directions: ArrayLike = (),
    candidates: ArrayLike | None = None,
    most: int = MOST,
) -> Course:
    """Return positions, one after another, until every target is met.

    Parameters
    ----------
    target : mapping of str to float
        Parameter (``bias_x``) or quantity (``bias``: on all axes) -> largest standard uncertainty, in its unit.
    directions : array_like, shape (n, 3)
        Positions taken already.
    candidates : array_like, shape (c, 3), optional
        By default the 26 directions of a cube. One may be taken again.
    most : int
        Positions in all, those taken already too.

    Raises
    ------
    PlanError
        ``unknown_parameter``; ``target_not_reached`` with what is left, and what stands in the way.
    """
    limits = _limits(setup, target)
    options = cube() if candidates is None else np.asarray(candidates, dtype=np.float64).reshape(-1, 3)
    taken = [np.asarray(one, dtype=np.float64) for one in np.reshape(np.asarray(directions, dtype=np.float64), (-1, 3))]
    relative = setup.gravity_u / setup.gravity
    if np.any(limits[:3] <= relative):
        raise PlanError(
            f"scale_factor_error cannot be known better than {relative:.2g}: the uncertainty of gravity",
            why="an error of gravity is the same in all positions",
            do="Give gravity with a smaller uncertainty, or another target",
            code="target_not_reached",
        )
    wanted = _wanted(setup, limits)
    while True:
        found = predict_uncertainty(setup, np.array(taken)) if taken else None
        if found is not None and np.all(found.u <= limits):
            return Course(np.array(taken), found)
        if found is not None and len(taken) >= most:
            limited = np.isfinite(limits)
            worst = int(np.argmax(np.where(limited, found.u, 0.0) / np.where(limited, limits, 1.0)))
            blind = f"the candidates do not determine {found.undetermined[0]}" if np.isinf(found.u[worst]) else ""
            u, unit = uncertainty(float(found.u[worst])), found.units[worst]
            raise PlanError(
                f"{found.names[worst]}: {u} {unit} after {most} positions, {limits[worst]:.3g} wanted",
                why=blind
                or "scatter falls with the root of their number, the error of a known direction laid again never",
                do="Average longer in each position, or allow other positions",
                code="target_not_reached",
            )
        taken.append(options[_best(setup, np.array(taken).reshape(-1, 3), options, wanted)])


def _wanted(setup: Setup, limits: Array) -> Array:
    """Return the weight of each variance, biases in gravities: that of one that is as wanted is 1."""
    scale = np.ones(len(limits))
    scale[-3:] = setup.gravity
    return np.asarray((scale / limits) ** 2)


def _limits(setup: Setup, target: Mapping[str, float]) -> Array:
    keys, names = parameters(setup.known)[0], parameter_names(setup.known)
    limits = np.full(len(keys), np.inf)
    for wanted, value in target.items():
        at = [i for i, key in enumerate(keys) if wanted in (str(key), key.quantity)]
        if not at or not 0.0 < value < np.inf:
            raise PlanError(
                f"target {wanted} = {value!r}: no such parameter, or no positive number",
                do=f"There are: {', '.join(names)}, and their names without axis",
                code="unknown_parameter",
            )
        limits[at] = np.minimum(limits[at], value)
    if not target:
        do = f"Give one: {names[0]} = NUMBER; there are: {', '.join(names)}"
        raise PlanError("no target given", do=do, code="unknown_parameter")
    return limits
