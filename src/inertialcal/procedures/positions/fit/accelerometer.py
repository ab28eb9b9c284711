"""Accelerometers from static positions: known orientations (linear), or none known but that |f| is gravity.

Known orientations: ``reading_k = A f_k + b`` with ``f_k = g d_k``; all twelve numbers follow from a fit that is linear
about the tilts of a fixture (``fixture``).

Unknown orientations: the inverse ``x_k = T (reading_k - b)`` has the length g in every position. A rotation of all
positions changes no length, so that the frame is a convention: T, and with it A, is lower triangular, which lays the
body's x along the input axis of the x sensor and its y in the plane of those of x and y. Nine numbers follow, by
Gauss-Newton with::

    e_k = |x_k| - g        de/dT_ij = u_i (reading - b)_j        de/db = -T' u        u = x / |x|

There the parameters are scaled to one size: the entries of T times gravity, and b, all [m/s^2].

Each position has the noise inside it (over its effective number of samples), and a scatter between positions of one
unknown size [1]_.

References
----------
.. [1] ``statistics.two_levels``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.influence import Influence, Standards
from ....core.key import AXES, Reason
from ....statistics.two_levels import TwoLevels, fit_two_levels
from ..plan import Plan
from ..readings import Triad, local_gravity
from ._kernels_sphere import SETTLED, converge, fill_lengths, fit_sphere
from .fixture import BETWEEN, INSIDE, Laid, chosen, derivatives, fit_agreeing, judged, scatter_interval, tilts_of
from .fixture import sources_of as fixture_sources
from .linear_sensor import (
    BIAS,
    MATRIX,
    SMALLEST,
    LinearSensor,
    Observability,
    Source,
    level_sources,
    observe,
    propagated,
)
from .next_record import Wander
from .outliers import found_outliers

NOTHING_LEFT = Reason("nothing_left", "as many positions as unknowns: no degrees of freedom left")
NOT_TOLD = Reason("not_told", "these positions do not determine it")
OF_FRAME = Reason("of_frame", "0 by definition: the accelerometer axes define the body frame")
NO_LENGTH = "a reading of no length has no direction"
FEWEST = 4  # positions without which nothing is determined

Flags = NDArray[np.bool_]
LOWER = ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))
FLAT = np.array([3 * i + j for i, j in LOWER])
NAMES = tuple(MATRIX[3 * i + j] for i, j in LOWER) + BIAS  # of the parameters of T and b, named as those of A
PLANE = 0.06  # spread of the positions across a plane [gravities], below which they lie in it
LOST = 1.0  # standard uncertainty of a combination of size one (100 % of gravity), above which it is not determined
UNKNOWN = 0.02  # standard uncertainty of such a combination, for parameters that hardly take part in it
NOT_DETERMINED = "combinations not determined"
FEW_FREE = 2  # degrees of freedom, fewer than which a scatter of zero says nothing


@dataclass(frozen=True, eq=False)
class Fitted:
    """Accelerometers, and how each position agrees."""

    sensor: LinearSensor  # Matrix and offset
    observed: Observability  # What the positions can tell
    outliers: Flags  # shape (m,): positions left out
    residuals: Array  # shape (m, 1): of each position, with it in the fit [m/s^2]
    deletion: Array  # shape (m, 1): without it in the fit [m/s^2]; of one left out the same
    between: float | None  # Standard deviation between positions [m/s^2]
    between_dof: float  # Degrees of freedom of that
    between_interval: tuple[float, float]  # Its interval of 95 %
    chi_square: float  # By both levels
    chi_square_known: float  # By the noise inside positions alone
    free: int  # Degrees of freedom
    known: bool  # Whether the orientations were known
    laid: Laid | None = None  # What a fixture's tilts are, where these were
    wandering: Wandering | None = (
        None  # How a bias that wanders from rest to rest is seen; None where nothing is judged
    )
    # shape (12, m, 3): the numbers per mean reading of each position; None where nothing is judged
    per_reading: Array | None = None


@dataclass(frozen=True, eq=False)
class Wandering:
    """How a bias that wanders is seen, and the bias that is found."""

    seen: Wander
    gain: Array  # shape (3, n): bias of x, y, z per reading
    noise: Array  # shape (3,): its variance by all but the scatter between positions


def normalised(triad: Triad, ideal: Array, zero: Array) -> tuple[Array, Array]:
    """Return readings and their variances by the noise inside, in units of the input, each shape (m, 3)."""
    return np.asarray((triad.mean - zero) / ideal), np.asarray((triad.u / ideal) ** 2)


def fit_known(plan: Plan, triad: Triad, direction: Array, ideal: Array, zero: Array) -> Fitted:
    """Return the accelerometers from positions of known orientation.

    Parameters
    ----------
    plan : Plan
        Gravity, standards, risk of an outlier.
    triad : Triad
        Readings.
    direction : ndarray, shape (m, 3)
        Unit vectors of specific force in the body frame.
    ideal, zero : ndarray, shape (3,)
        To which the readings are taken.
    """
    m, g = len(triad.mean), local_gravity(plan)
    _check_count(m)
    r, inside = normalised(triad, ideal, zero)
    tilts, everyone = tilts_of(direction, plan.standards), np.ones(m, dtype=bool)
    observed = observe(derivatives(tilts.direction), (*MATRIX, *BIAS), float(np.sqrt(np.mean(inside))) / g)
    scale, usual = np.concatenate([np.ones(9), np.full(3, g)]), np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    back = scale[:, None] * observed.kept
    if not observed.rank or not judged(tilts, observed.rank):
        design, y = derivatives(g * tilts.direction), r.ravel()
        values = usual + back @ np.linalg.lstsq(design @ back, y - design @ usual, rcond=None)[0]
        sensor = sensor_of(plan, values, None, observed.determined, ideal, zero)
        return finished(sensor, observed, ~everyone, (y - design @ values).reshape(m, 3), None, known=True)
    laid, outliers = fit_agreeing(r, inside, g, tilts, observed.kept, plan.outlier_risk)
    kept = ~outliers
    sensor = sensor_of(plan, laid.values, fixture_sources(laid, chosen(tilts, kept)), observed.determined, ideal, zero)
    stretch = np.ones(m)
    stretch[kept] = laid.stretch
    away = r - g * (tilts.direction * stretch[:, None]) @ sensor.matrix.T - sensor.offset
    fitted = finished(sensor, observed, outliers, away, None, known=True)
    found = laid.found
    scatter, dof = (None, 0.0) if laid.assumed else (found.variances[BETWEEN] ** 0.5, found.variance_dof(BETWEEN))
    limits = (0.0, np.inf) if scatter is None else scatter_interval(scatter, dof, found.variances_covariance[0, 0])
    fitted.deletion[kept] = found.deletion.reshape(-1, 3)
    alone = derivatives(g * tilts.direction[kept]) @ back
    noise = _chi_square(alone, r[kept].ravel() - derivatives(g * tilts.direction[kept]) @ usual, inside[kept].ravel())
    return replace(
        fitted, between=scatter, between_dof=dof, between_interval=limits, chi_square=found.chi_square,
        chi_square_known=noise, free=found.free, laid=laid,
        wandering=_wandering(laid, back, np.flatnonzero(kept)), per_reading=_placed(back @ found.gain, kept),
    )  # fmt: skip


def _placed(gain: Array, kept: Flags) -> Array:
    """Return numbers per reading of all positions, shape (12, m, 3), from those per reading of the kept ones."""
    whole = np.zeros((len(gain), len(kept), 3))
    whole[:, kept] = gain.reshape(len(gain), -1, 3)
    return whole


def of_lengths(back: Array, gain: Array, jacobian: Array, kept: Flags) -> Array:
    """Return the numbers per mean reading, shape (12, m, 3), where lengths are fitted.

    A reading lengthens by its part along the specific force.

    Parameters
    ----------
    back, gain : ndarray, shapes (12, p), (p, n)
        The numbers by the coefficients, and these by the lengths of the kept positions.
    jacobian : ndarray, shape (n, 9)
        Derivatives of these lengths by the scaled parameters; the last three are those by a bias.
    kept : ndarray of bool, shape (m,)
        Positions that were fitted.
    """
    return _placed(((back @ gain)[:, :, None] * jacobian[:, 6:]).reshape(len(back), -1), kept)


def _wandering(laid: Laid, back: Array, kept: NDArray[np.int64]) -> Wandering | None:
    """Return how a bias that wanders is seen by the positions of a fixture; None where no scatter of these is."""
    found = laid.found
    if laid.assumed:
        return None
    known = [part for name, part in (*found.known.items(), *found.unknown.items()) if name != BETWEEN]
    place, loading = np.repeat(kept, 3), np.tile(np.eye(3), (len(kept), 1))
    seen = Wander(found.projector, found.residuals, found.free, found.variances[BETWEEN], place, loading)
    noise = np.zeros((3, 3))
    for part in known:
        noise = noise + propagated(back[9:], part)
    return Wandering(seen, back[9:] @ found.gain, np.diag(noise))


def _chi_square(design: Array, y: Array, variances: Array) -> float:
    """Chi-square that the noise inside positions alone would give; NaN where that is not known."""
    if not np.all(variances > 0.0):
        return float("nan")
    root = np.sqrt(variances)
    white, target = design / root[:, None], y / root
    return float(np.sum((target - white @ np.linalg.lstsq(white, target, rcond=None)[0]) ** 2))


def fit_unknown(plan: Plan, triad: Triad, ideal: Array, zero: Array) -> Fitted:
    """Return the accelerometers from positions of which only gravity is known.

    Parameters
    ----------
    plan : Plan
        Gravity, risk of an outlier.
    triad : Triad
        Readings.
    ideal, zero : ndarray, shape (3,)
        To which the readings are taken; near enough to the truth for the readings to lie about a sphere.
    """
    m, g = len(triad.mean), local_gravity(plan)
    _check_count(m)
    r, inside = normalised(triad, ideal, zero)
    check_plane(r, g)
    theta, scatter, cut = sphere(r, inside, g)
    e, jacobian, u = lengths(theta, r, g)
    observed = _observe(jacobian, scatter, g)
    known = {INSIDE: variances(theta, u, inside, g)}
    outliers = _outliers(plan, jacobian @ observed.kept, -e, known, np.arange(m))
    kept = ~outliers
    theta = converged(r[kept], g, np.ones(int(kept.sum())), theta, cut)
    found, observed, theta = _second_level(r[kept], inside[kept], g, theta, scatter)
    e, jacobian, u = lengths(theta, r, g)
    values, to_values = forward(theta, g)
    determined = determined_forward(observed.determined)
    noise = variances(theta, u, inside, g)
    sources = wandering = per_reading = None
    if found is not None:
        per_reading = of_lengths(to_values @ observed.kept, found.gain, jacobian[kept], kept)
        back = (to_values @ observed.kept)[9:]
        place, loading = np.flatnonzero(kept), jacobian[kept, 6:]
        seen = Wander(found.projector, found.residuals, found.free, found.between**2, place, loading)
        inside_part = propagated(back, found.parts[INSIDE])
        wandering = Wandering(seen, back @ found.gain, np.diag(inside_part))
        sources = [
            *sources_of(found, to_values @ observed.kept, plan.standards, noise[kept]),
            *_undetermined(observed, to_values, g),
        ]
    sensor = sensor_of(plan, values, sources, determined, ideal, zero, of_frame=True)
    fitted = finished(sensor, observed, outliers, e[:, None], found, known=False)
    return replace(fitted, wandering=wandering, per_reading=per_reading)


def sphere(r: Array, inside: Array, g: float) -> tuple[Array, float, float]:
    """Return scaled parameters by a robust fit, the scatter of a length, and the singular value that is cut off."""
    theta = nominal(g)
    scatter, least = fit_sphere(_rows(r), _rows(inside), g, LOST, SMALLEST, theta)
    if np.isnan(least):
        raise np.linalg.LinAlgError(NO_LENGTH)
    return theta, scatter, least


def among(fitted: Fitted, named: Flags) -> Fitted:
    """Return a fit of some positions as one of all: no residual, and no outlier, where it was not fitted.

    Parameters
    ----------
    fitted : Fitted
        Of the positions whose orientation is known.
    named : ndarray of bool, shape (m,)
        Which these are, among all.
    """
    if named.all():
        return fitted
    residuals, deletion = (np.full((len(named), 3), np.nan) for _ in range(2))
    residuals[named], deletion[named] = fitted.residuals, fitted.deletion
    outliers = np.zeros(len(named), dtype=bool)
    outliers[named] = fitted.outliers
    own = fitted.wandering
    if own is not None:
        own = replace(own, seen=replace(own.seen, place=np.flatnonzero(named)[own.seen.place]))
    gain = fitted.per_reading
    if gain is not None:
        gain = np.zeros((len(gain), len(named), 3))
        gain[:, named] = fitted.per_reading
    return replace(fitted, residuals=residuals, deletion=deletion, outliers=outliers, wandering=own, per_reading=gain)


def _observe(jacobian: Array, scatter: float, g: float) -> Observability:
    return observe(jacobian / g, NAMES, scatter / g, LOST)


def _check_count(m: int) -> None:
    if m < FEWEST:
        raise DataError(
            f"{m} position(s): need {FEWEST} or more, and 10 for all nine parameters if the orientations are unknown",
            why="each axis needs two positions for its bias and scale factor alone",
            do="Lay the unit into more orientations, each still for some seconds",
            code="too_few_positions",
        )


def _outliers(plan: Plan, design: Array, y: Array, known: Mapping[str, Array], group: NDArray[np.int64]) -> Flags:
    if not design.shape[1]:
        return np.zeros(int(group.max()) + 1, dtype=bool)
    return found_outliers(design, y, known, group, plan.outlier_risk)


def _two_levels(design: Array, y: Array, known: Mapping[str, Array], kept: Flags) -> TwoLevels | None:
    """Fit what is kept; None where nothing is left to judge by."""
    n, p = design.shape
    if n <= p or not p:
        return None
    some = {name: part[kept] if part.ndim == 1 else part[np.ix_(kept, kept)] for name, part in known.items()}
    return fit_two_levels(design, y, some)


def _second_level(
    r: Array, inside: Array, g: float, theta: Array, scatter: float
) -> tuple[TwoLevels | None, Observability, Array]:
    """Fit again with both levels of variance until nothing moves."""
    everyone = np.ones(len(r), dtype=bool)
    for _ in range(10):
        e, jacobian, u = lengths(theta, r, g)
        observed = _observe(jacobian, scatter, g)
        found = _two_levels(jacobian @ observed.kept, -e, {INSIDE: variances(theta, u, inside, g)}, everyone)
        if found is None:
            break
        step = observed.kept @ found.coefficients
        theta = theta + step
        if np.max(np.abs(step)) <= SETTLED * g:
            break
    return found, observed, theta


def _undetermined(observed: Observability, to_values: Array, g: float) -> list[Source]:
    """Return what combinations that stay at their nominal value do to the parameters that hardly take part in them."""
    if observed.whole:
        return []
    moved = to_values @ (np.eye(observed.count) - observed.kept @ observed.kept.T) * (UNKNOWN * g)
    return [Source(NOT_DETERMINED, "B", moved @ moved.T, np.inf, Influence(UNKNOWN, certificate="none: assumed"))]


def sources_of(found: TwoLevels, back: Array, stated: Standards, noise: Array) -> list[Source]:
    """Return the sources of numbers; where next to nothing is left over, t counts even if no scatter shows."""
    sources = level_sources(found, back, stated, BETWEEN)
    free = max(1.0, found.information * float(np.mean(noise + found.between**2)) ** 2)
    if free >= FEW_FREE:
        return sources
    return [one if one.kind == "B" else replace(one, dof=np.minimum(one.dof, free)) for one in sources]


def sensor_of(
    plan: Plan,
    values: Array,
    sources: list[Source] | None,
    determined: Flags,
    ideal: Array,
    zero: Array,
    of_frame: bool = False,
) -> LinearSensor:
    """Gather values, sources and reasons; no sources: nothing judges the numbers."""
    names = (*MATRIX, *BIAS)
    reasons = {k: NOT_TOLD for k in range(12) if not determined[k]}
    if of_frame:
        reasons |= {3 * i + j: OF_FRAME for i in range(3) for j in range(i + 1, 3)}
    if sources is None:
        reasons |= {k: NOTHING_LEFT for k in range(12) if k not in reasons}
        return LinearSensor(values, (), reasons, ideal, zero, names)
    gravity = plan.standards.get("gravity.value")  # moves all positions alike, as the mounting does
    if gravity is not None:
        change = np.concatenate([-values[:9], np.zeros(3)]) * gravity.u / local_gravity(plan)
        sources.append(
            Source("gravity.value", "B", np.outer(change, change), gravity.dof, gravity, changes=change[None])
        )
    mounting = plan.standards.get("fixture.mounting")
    if mounting is not None and not of_frame:
        sources.append(mounting_source(values, mounting.u, plan))
    return LinearSensor(values, tuple(sources), reasons, ideal, zero, names)


def mounting_source(values: Array, u: float, plan: Plan) -> Source:
    """Return what a common rotation of all positions and turns does to a matrix: A is taken for A R."""
    changes = np.zeros((3, len(values)))
    for change, axis in zip(changes, np.eye(3), strict=True):
        change[:9] = u * (values[:9].reshape(3, 3) @ np.cross(np.eye(3), axis)).ravel()
    total = np.sum([np.outer(change, change) for change in changes], axis=0)
    influence = plan.standards["fixture.mounting"]
    return Source("fixture.mounting", "B", total, influence.dof, influence, changes=changes, unknowns=tuple(AXES))


def finished(
    sensor: LinearSensor, observed: Observability, outliers: Flags, away: Array, found: TwoLevels | None, known: bool
) -> Fitted:
    """Return a fit with how each position agrees."""
    deletion = np.full(away.shape, np.nan)
    if found is None:
        return Fitted(sensor, observed, outliers, away, deletion, None, 0.0, (0.0, np.inf), np.nan, np.nan, 0, known)
    sign = 1.0 if known else -1.0  # -e is the reading there
    deletion[~outliers] = sign * found.deletion.reshape(-1, away.shape[1])
    deletion[outliers] = away[outliers]
    levels = (found.between, found.between_dof, found.between_interval, found.chi_square, found.chi_square_known)
    return Fitted(sensor, observed, outliers, away, deletion, *levels, found.free, known)


def check_plane(r: Array, g: float) -> None:
    """Refuse positions that all lie in one plane: what is across it nobody sees."""
    middle = r - r.mean(axis=0)
    spread, axes = np.linalg.svd(middle / g, full_matrices=False)[1:]
    if spread[-1] < PLANE * np.sqrt(len(r)):
        across = ", ".join(
            f"{value:+.2f} {axis}" for value, axis in zip(axes[-1], AXES, strict=True) if abs(value) > 0.1
        )
        raise DataError(
            f"all positions lie in one plane, across {across}",
            why="bias, scale factor and misalignment across it change no reading",
            do="Lay the unit so that each of its axes points up, and down, at least once",
            code="one_plane",
        )


def nominal(g: float) -> Array:
    """Return T = I and b = 0, in scaled parameters: entries of T times g."""
    return np.concatenate([[g * (i == j) for i, j in LOWER], np.zeros(3)])


def parts(theta: Array, g: float) -> tuple[Array, Array]:
    """Return T and b of scaled parameters."""
    T = np.zeros(9)
    T[FLAT] = theta[:6] / g
    return T.reshape(3, 3), theta[6:]


def lengths(theta: Array, r: Array, g: float) -> tuple[Array, Array, Array]:
    """Return errors of length (m,), derivatives by the scaled parameters (m, 9), unit vectors (m, 3)."""
    m = len(r)
    e, jacobian, u = np.empty(m), np.empty((m, 9)), np.empty((m, 3))
    fill_lengths(theta, _rows(r), g, e, jacobian, u)
    return e, jacobian, u


def converged(
    r: Array, g: float, root: Array, theta: Array, cut: float, prior: Mapping[str, float] | None = None
) -> Array:
    """Return where damped Gauss-Newton with weights root^2 ends; what is not determined stays as it starts.

    Parameters
    ----------
    r, g, root, theta, cut
        As ``_kernels_sphere.converge`` takes them.
    prior : mapping of str to float, optional
        Standard uncertainties that are expected beside the readings, by quantity.
    """
    found = theta.copy()
    if not converge(_rows(r), g, root, found, cut, np.empty(0) if prior is None else by_kind(prior)):
        raise np.linalg.LinAlgError(NO_LENGTH)
    return found


def by_kind(prior: Mapping[str, float]) -> Array:
    """Return prior standard uncertainties of scale factors, misalignment and bias, NaN where there is none, (3,)."""
    return np.array([prior.get(name, np.nan) for name in ("scale_factor_error", "misalignment", "bias")])


def _rows(x: Array) -> Array:
    return np.ascontiguousarray(x)


def variances(theta: Array, u: Array, inside: Array, g: float) -> Array:
    """Return the variance of each length from the noise inside its position, shape (m,)."""
    T = parts(theta, g)[0]
    return np.asarray(np.sum((u @ T) ** 2 * inside, axis=1))


def forward(theta: Array, g: float) -> tuple[Array, Array]:
    """Return A = T^-1 and b as twelve values, and their derivatives by the scaled parameters, shape (12, 9)."""
    T, b = parts(theta, g)
    A = np.linalg.inv(T)
    derivative = np.zeros((12, 9))
    for column, (i, j) in enumerate(LOWER):
        derivative[:9, column] = -np.outer(A[:, i], A[j]).ravel() / g
    derivative[9:, 6:] = np.eye(3)
    return np.concatenate([A.ravel(), b]), derivative


def determined_forward(determined: Flags) -> Flags:
    """Return which of the twelve are determined, from those of T and b."""
    found = np.zeros(12, dtype=bool)
    for column, (i, j) in enumerate(LOWER):
        found[3 * i + j] = determined[column]
    found[9:] = determined[6:]
    return found
