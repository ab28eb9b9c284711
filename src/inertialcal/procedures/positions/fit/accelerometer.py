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

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.influence import Influence, Standards
from ....core.key import AXES, Reason
from ....statistics.two_levels import TwoLevels, fit_many_levels
from ..plan import Plan
from ..readings import Triad, local_gravity
from ._kernels_sphere import SETTLED, converge, converge_all, fill_lengths, fill_many_lengths, fit_spheres
from .fixture import BETWEEN, INSIDE, Laid, Tilts, chosen, derivatives, fit_agreeing, judged, scatter_interval, tilts_of
from .fixture import many_sources as fixture_sources
from .linear_sensor import (
    BIAS,
    MATRIX,
    SMALLEST,
    LinearSensor,
    Observability,
    Source,
    many_level_sources,
    observe_many,
    propagated,
    told_by,
)
from .next_record import Wander
from .outliers import many_outliers

NOTHING_LEFT = Reason("nothing_left", "as many positions as unknowns: no degrees of freedom left")
NOT_TOLD = Reason("not_told", "these positions do not determine it")
OF_FRAME = Reason("of_frame", "0 by definition: the accelerometer axes define the body frame")
NO_LENGTH = "a reading of no length has no direction"
FEWEST = 4  # positions without which nothing is determined

Flags = NDArray[np.bool_]
LOWER = ((0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2))
FLAT = np.array([3 * i + j for i, j in LOWER])
NAMES = tuple(MATRIX[3 * i + j] for i, j in LOWER) + BIAS  # of the parameters of T and b, named as those of A
ROTATIONS = np.array([np.cross(np.eye(3), axis) for axis in np.eye(3)])  # about each axis, by one
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
    # shape (12, m, 3): the numbers per mean reading of each position; None where nothing is judged, or nobody asks
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
    found = fit_many_known(plan, [triad], [direction], [ideal], [zero])[0]
    if isinstance(found, DataError):
        raise found
    return found


def fit_many_known(
    plan: Plan, triads: Sequence[Triad], directions: Sequence[Array], ideals: Sequence[Array], zeros: Sequence[Array]
) -> list[Fitted | DataError]:
    """Return what `fit_known` gives of each of many units, or why it is refused."""
    found: list[Fitted | DataError | None] = [None] * len(triads)
    laid: dict[int, tuple[Callable[[list[Source]], Fitted], Laid, Tilts]] = {}
    for k, given in enumerate(zip(triads, directions, ideals, zeros, strict=True)):
        try:
            one = _fit_known(plan, *given)
        except DataError as error:
            found[k] = error
            continue
        if isinstance(one, Fitted):
            found[k] = one
        else:
            laid[k] = one
    sources = fixture_sources([(one, tilts) for _, one, tilts in laid.values()])
    for (k, (finish, _, _)), own in zip(laid.items(), sources, strict=True):
        found[k] = finish(own)
    return [one for one in found if one is not None]


def _fit_known(
    plan: Plan, triad: Triad, direction: Array, ideal: Array, zero: Array
) -> Fitted | tuple[Callable[[list[Source]], Fitted], Laid, Tilts]:
    """Return the fit where nothing judges it; else what makes it of its sources, and what these follow from."""
    m, g = len(triad.mean), local_gravity(plan)
    _check_count(m)
    r, inside = normalised(triad, ideal, zero)
    tilts, everyone = tilts_of(direction, plan.standards), np.ones(m, dtype=bool)
    (observed,) = told_by(*tilts.decomposed, (*MATRIX, *BIAS), np.array([np.sqrt(np.mean(inside)) / g]))
    scale, usual = np.concatenate([np.ones(9), np.full(3, g)]), np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    back = scale[:, None] * observed.kept
    if not observed.rank or not judged(tilts, observed.rank):
        design, y = derivatives(g * tilts.direction), r.ravel()
        values = usual + back @ np.linalg.lstsq(design @ back, y - design @ usual, rcond=None)[0]
        sensor = sensor_of(plan, values, None, observed.determined, ideal, zero)
        return finished(sensor, observed, ~everyone, (y - design @ values).reshape(m, 3), None, known=True)
    laid, outliers = fit_agreeing(r, inside, g, tilts, observed.kept, plan.outlier_risk)
    return partial(_known, plan, triad, ideal, zero, tilts, observed, laid, outliers), laid, chosen(tilts, ~outliers)


def _known(
    plan: Plan,
    triad: Triad,
    ideal: Array,
    zero: Array,
    tilts: Tilts,
    observed: Observability,
    laid: Laid,
    outliers: Flags,
    sources: list[Source],
) -> Fitted:
    """Return the accelerometers from the fit of a fixture and the sources of its numbers."""
    m, g, kept = len(triad.mean), local_gravity(plan), ~outliers
    r, inside = normalised(triad, ideal, zero)
    usual, back = np.concatenate([np.eye(3).ravel(), np.zeros(3)]), laid.back
    sensor = sensor_of(plan, laid.values, sources, observed.determined, ideal, zero)
    stretch = np.ones(m)
    stretch[kept] = laid.stretch
    away = r - g * (tilts.direction * stretch[:, None]) @ sensor.matrix.T - sensor.offset
    fitted = finished(sensor, observed, outliers, away, None, known=True)
    found = laid.found
    scatter, dof = (None, 0.0) if laid.assumed else (found.variances[BETWEEN] ** 0.5, found.variance_dof(BETWEEN))
    limits = (0.0, np.inf) if scatter is None else scatter_interval(scatter, dof, found.variances_covariance[0, 0])
    fitted.deletion[kept] = found.deletion.reshape(-1, 3)
    alone = derivatives(g * tilts.direction[kept])
    noise = _chi_square(alone @ back, r[kept].ravel() - alone @ usual, inside[kept].ravel())
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
    found = fit_many_unknown(plan, [triad], [ideal], [zero])[0]
    if isinstance(found, DataError):
        raise found
    return found


def fit_many_unknown(
    plan: Plan, triads: Sequence[Triad], ideals: Sequence[Array], zeros: Sequence[Array], per_reading: bool = True
) -> list[Fitted | DataError]:
    """Return what `fit_unknown` gives of each of many units with equal numbers of positions, or why it is refused.

    ``per_reading``: whether the numbers per reading are asked for.
    """
    m, g = len(triads[0].mean), local_gravity(plan)
    _check_count(m)
    both = [normalised(*one) for one in zip(triads, ideals, zeros, strict=True)]
    r, inside = np.array([one for one, _ in both]), np.array([one for _, one in both])
    fitted: list[Fitted | DataError | None] = [*_in_one_plane(r, g)]
    sound = np.flatnonzero([one is None for one in fitted])
    if not len(sound):
        return [one for one in fitted if one is not None]
    r, inside = r[sound], inside[sound]
    theta, scatter, cut = spheres(r, inside, g)
    e, jacobian, u = lengths(theta, r, g)
    noise = variances(theta, u, inside, g)
    outliers = np.zeros((len(sound), m), dtype=bool)
    observed = _observe(jacobian, scatter, g)
    for rank, at in _alike([one.rank for one in observed]):
        if rank:
            design = jacobian[at] @ np.array([observed[k].kept for k in at])
            outliers[at] = many_outliers(design, -e[at], {INSIDE: noise[at]}, np.arange(m), plan.outlier_risk)
    for _, at in _alike(outliers.sum(axis=1).tolist()):
        kept = ~outliers[at]
        used, noise_used = (np.asarray(x[at][kept].reshape(len(at), -1, 3)) for x in (r, inside))
        end = np.empty((len(at), 9))
        end[:] = theta[at]
        settled = np.empty(len(at), dtype=bool)
        converge_all(used, g, end, cut[at], settled)
        if not settled.all():
            raise np.linalg.LinAlgError(NO_LENGTH)
        found, last = _second_level(used, noise_used, g, end, scatter[at])
        for k, one in zip(at.tolist(), last, strict=True):
            observed[k] = one
        where = [(ideals[sound[k]], zeros[sound[k]]) for k in at]
        judged = _judged(plan, r[at], inside[at], end, kept, found, last, where, per_reading)
        for k, whole in zip(sound[at].tolist(), judged, strict=True):
            fitted[k] = whole
    return [one for one in fitted if one is not None]


def _alike(numbers: Sequence[int]) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Yield each number that there is, and the places where it stands."""
    every = np.asarray(numbers, dtype=np.int64)
    for number in dict.fromkeys(every.tolist()):
        yield number, np.flatnonzero(every == number)


def _judged(
    plan: Plan,
    r: Array,
    inside: Array,
    theta: Array,
    kept: Flags,
    found: Sequence[TwoLevels | DataError | None],
    observed: Sequence[Observability],
    where: Sequence[tuple[Array, Array]],
    per_reading: bool,
) -> list[Fitted | DataError]:
    """Return the fits of units of as many positions each, from where the search ended and what judges it.

    Parameters
    ----------
    plan : Plan
        Gravity and standards.
    r, inside : ndarray, shape (units, m, 3)
        Readings of all positions in units of the input, and their variances by the noise inside.
    theta : ndarray, shape (units, 9)
        Scaled parameters.
    kept : ndarray of bool, shape (units, m)
        Positions that were fitted, as many in each unit.
    found, observed
        What `_second_level` gives.
    where : sequence of (ndarray, ndarray)
        Ideal scale factor and zero of each unit.
    per_reading : bool
        Whether the numbers per reading are asked for.
    """
    g = local_gravity(plan)
    e, jacobian, u = lengths(theta, r, g)
    values, to_values = forward(theta, g)
    noise = variances(theta, u, inside, g)
    sources: dict[int, list[Source]] = {}
    gains: dict[int, tuple[Wandering | None, Array | None]] = {}
    ranks = [one.rank if isinstance(fit, TwoLevels) else 0 for fit, one in zip(found, observed, strict=True)]
    for rank, at in _alike(ranks):
        if not rank:
            continue
        fits = [one for k in at if isinstance(one := found[k], TwoLevels)]
        back = to_values[at] @ np.array([observed[k].kept for k in at])
        fitted_jacobian = jacobian[at][kept[at]].reshape(len(at), -1, 9)
        fitted_noise = noise[at][kept[at]].reshape(len(at), -1)
        gain = back @ np.array([one.gain for one in fits])
        numbers: Array | None = None
        if per_reading:
            numbers = np.zeros((len(at), 12, kept.shape[1], 3))
            numbers.swapaxes(1, 2)[kept[at]] = (
                (gain[..., None] * fitted_jacobian[:, None, :, 6:]).swapaxes(1, 2).reshape(-1, 12, 3)
            )
        own = propagated(back[:, 9:], np.array([one.parts[INSIDE] for one in fits])).diagonal(axis1=1, axis2=2)
        each = many_sources(fits, back, plan.standards, fitted_noise)
        for i, (k, fitted) in enumerate(zip(at.tolist(), fits, strict=True)):
            place, loading = np.flatnonzero(kept[k]), fitted_jacobian[i, :, 6:]
            seen = Wander(fitted.projector, fitted.residuals, fitted.free, fitted.between**2, place, loading)
            gains[k] = Wandering(seen, gain[i, 9:], own[i]), None if numbers is None else numbers[i]
            sources[k] = [*each[i], *_undetermined(observed[k], to_values[k], g)]
    made: list[Fitted | DataError] = []
    for k, (fit, one, (ideal, zero)) in enumerate(zip(found, observed, where, strict=True)):
        if isinstance(fit, DataError):
            made.append(fit)
            continue
        determined = determined_forward(one.determined)
        sensor = sensor_of(plan, values[k], sources.get(k), determined, ideal, zero, of_frame=True)
        made.append(finished(sensor, one, ~kept[k], e[k, :, None], fit, False, *gains.get(k, (None, None))))
    return made


def spheres(r: Array, inside: Array, g: float) -> tuple[Array, Array, Array]:
    """Return what `sphere` gives of many units, along the first axis."""
    theta, judged = np.empty((len(r), 9)), np.empty((len(r), 2))
    theta[:] = nominal(g)
    fit_spheres(_rows(r), _rows(inside), g, LOST, SMALLEST, theta, judged)
    if np.isnan(judged[:, 1]).any():
        raise np.linalg.LinAlgError(NO_LENGTH)
    return theta, judged[:, 0], judged[:, 1]


def sphere(r: Array, inside: Array, g: float) -> tuple[Array, float, float]:
    """Return scaled parameters by a robust fit, the scatter of a length, and the singular value that is cut off."""
    theta, scatter, cut = spheres(r[None], inside[None], g)
    return theta[0], float(scatter[0]), float(cut[0])


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


def _observe(jacobian: Array, scatter: Array, g: float) -> list[Observability]:
    return observe_many(jacobian / g, NAMES, scatter / g, LOST)


def _check_count(m: int) -> None:
    if m < FEWEST:
        raise DataError(
            f"{m} position(s): need {FEWEST} or more, and 10 for all nine parameters if the orientations are unknown",
            why="each axis needs two positions for its bias and scale factor alone",
            do="Lay the unit into more orientations, each still for some seconds",
            code="too_few_positions",
        )


def _second_level(
    r: Array, inside: Array, g: float, theta: Array, scatter: Array
) -> tuple[list[TwoLevels | DataError | None], list[Observability]]:
    """Move the parameters of each unit, shape (units, 9), by fits with both levels of variance until nothing moves.

    Return the last fit, None where nothing is left to judge by, and what is determined there.
    """
    units, n = r.shape[:2]
    found: list[TwoLevels | DataError | None] = [None] * units
    observed: dict[int, Observability] = {}
    left = np.arange(units)
    for last in (*[False] * 9, True):
        e, jacobian, u = lengths(theta[left], r[left], g)
        noise, own = variances(theta[left], u, inside[left], g), _observe(jacobian, scatter[left], g)
        observed |= zip(left.tolist(), own, strict=True)
        moving = np.zeros(len(left), dtype=bool)
        for rank, at in _alike([one.rank for one in own]):
            if not 0 < rank < n:
                for k in left[at]:
                    found[k] = None
                continue
            kept = np.array([own[k].kept for k in at])
            fitted = fit_many_levels(jacobian[at] @ kept, -e[at], {INSIDE: noise[at]})
            step = (kept @ fitted.coefficients[:, :, None])[:, :, 0]
            step[[*fitted.refused]] = 0.0
            theta[left[at]] += step
            moving[at] = ~(np.abs(step).max(axis=1) <= SETTLED * g)
            ended = np.flatnonzero(~moving[at] | last)
            for k, fit in zip(left[at[ended]].tolist(), fitted.fits(ended.tolist(), with_scatter=True), strict=True):
                found[k] = fit
        left = left[moving]
        if not len(left):
            break
    return found, [observed[k] for k in range(units)]


def _undetermined(observed: Observability, to_values: Array, g: float) -> list[Source]:
    """Return what combinations that stay at their nominal value do to the parameters that hardly take part in them."""
    if observed.whole:
        return []
    moved = to_values @ (np.eye(observed.count) - observed.kept @ observed.kept.T) * (UNKNOWN * g)
    return [Source(NOT_DETERMINED, "B", moved @ moved.T, np.inf, Influence(UNKNOWN, certificate="none: assumed"))]


def sources_of(found: TwoLevels, back: Array, stated: Standards, noise: Array) -> list[Source]:
    """Return the sources of numbers; where next to nothing is left over, t counts even if no scatter shows."""
    return many_sources([found], back[None], stated, noise[None])[0]


def many_sources(fits: Sequence[TwoLevels], back: Array, stated: Standards, noise: Array) -> list[list[Source]]:
    """Return what `sources_of` gives of each of many fits of one shape; ``noise``, shape (fits, n)."""
    sources = many_level_sources(fits, back, stated, BETWEEN)
    for k, found in enumerate(fits):
        free = max(1.0, found.information * float(np.mean(noise[k] + found.between**2)) ** 2)
        if free < FEW_FREE:
            sources[k] = [one if one.kind == "B" else replace(one, dof=np.minimum(one.dof, free)) for one in sources[k]]
    return sources


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
    reasons = _reasons(determined.tobytes(), of_frame, sources is None)
    if sources is None:
        return LinearSensor(values, (), reasons, ideal, zero)
    gravity = plan.standards.get("gravity.value")  # moves all positions alike, as the mounting does
    if gravity is not None:
        change = np.concatenate([-values[:9], np.zeros(3)]) * gravity.u / local_gravity(plan)
        sources.append(
            Source("gravity.value", "B", np.outer(change, change), gravity.dof, gravity, changes=change[None])
        )
    mounting = plan.standards.get("fixture.mounting")
    if mounting is not None and not of_frame:
        sources.append(mounting_source(values, mounting.u, plan))
    return LinearSensor(values, tuple(sources), reasons, ideal, zero)


@lru_cache(maxsize=64)  # the same of all units whose positions determine the same
def _reasons(determined: bytes, of_frame: bool, nothing_left: bool) -> Mapping[int, Reason]:
    """Return why numbers are not estimated: of which it is known what is determined, a byte each."""
    found = {k: NOT_TOLD for k in range(12) if not determined[k]}
    if of_frame:
        found |= {3 * i + j: OF_FRAME for i in range(3) for j in range(i + 1, 3)}
    if nothing_left:
        found |= {k: NOTHING_LEFT for k in range(12) if k not in found}
    return found


def mounting_source(values: Array, u: float, plan: Plan) -> Source:
    """Return what a common rotation of all positions and turns does to a matrix: A is taken for A R."""
    changes = np.zeros((3, len(values)))
    changes[:, :9] = u * (values[:9].reshape(3, 3) @ ROTATIONS).reshape(3, 9)
    total = changes.T @ changes
    influence = plan.standards["fixture.mounting"]
    return Source("fixture.mounting", "B", total, influence.dof, influence, changes=changes, unknowns=tuple(AXES))


def finished(
    sensor: LinearSensor,
    observed: Observability,
    outliers: Flags,
    away: Array,
    found: TwoLevels | None,
    known: bool,
    wandering: Wandering | None = None,
    per_reading: Array | None = None,
) -> Fitted:
    """Return a fit with how each position agrees."""
    deletion = np.full(away.shape, np.nan)
    if found is None:
        return Fitted(sensor, observed, outliers, away, deletion, None, 0.0, (0.0, np.inf), np.nan, np.nan, 0, known)
    sign = 1.0 if known else -1.0  # -e is the reading there
    deletion[~outliers] = sign * found.deletion.reshape(-1, away.shape[1])
    deletion[outliers] = away[outliers]
    levels = (found.between, found.between_dof, found.between_interval, found.chi_square, found.chi_square_known)
    return Fitted(sensor, observed, outliers, away, deletion, *levels, found.free, known, None, wandering, per_reading)


def check_plane(r: Array, g: float) -> None:
    """Refuse positions that all lie in one plane: what is across it nobody sees."""
    if (problem := _in_one_plane(r[None], g)[0]) is not None:
        raise problem


def _in_one_plane(r: Array, g: float) -> list[DataError | None]:
    """Return why each unit is refused whose positions lie in one plane; ``r``, shape (units, m, 3)."""
    middle = r - r.mean(axis=1, keepdims=True)
    spread, directions = np.linalg.svd(middle / g, full_matrices=False)[1:]
    found: list[DataError | None] = [None] * len(r)
    for k in np.flatnonzero(spread[:, -1] < PLANE * np.sqrt(r.shape[1])):
        across = ", ".join(
            f"{value:+.2f} {axis}" for value, axis in zip(directions[k, -1], AXES, strict=True) if abs(value) > 0.1
        )
        found[k] = DataError(
            f"all positions lie in one plane, across {across}",
            why="bias, scale factor and misalignment across it change no reading",
            do="Lay the unit so that each of its axes points up, and down, at least once",
            code="one_plane",
        )
    return found


def nominal(g: float) -> Array:
    """Return T = I and b = 0, in scaled parameters: entries of T times g."""
    return np.concatenate([[g * (i == j) for i, j in LOWER], np.zeros(3)])


def parts(theta: Array, g: float) -> tuple[Array, Array]:
    """Return T and b of scaled parameters, shape (..., 9)."""
    T = np.zeros(theta.shape)
    T[..., FLAT] = theta[..., :6] / g
    return T.reshape(*theta.shape[:-1], 3, 3), theta[..., 6:]


def lengths(theta: Array, r: Array, g: float) -> tuple[Array, Array, Array]:
    """Return errors of length (..., m), derivatives by the scaled parameters (..., m, 9), unit vectors (..., m, 3).

    Of one unit, or of many along the first axis of parameters and readings.
    """
    e, jacobian, u = np.empty(r.shape[:-1]), np.empty((*r.shape[:-1], 9)), np.empty(r.shape)
    fill = fill_lengths if r.ndim == 2 else fill_many_lengths
    fill(_rows(theta), _rows(r), g, e, jacobian, u)
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
    """Return the variance of each length from the noise inside its position, shape (..., m)."""
    T = parts(theta, g)[0]
    return np.asarray(np.sum((u @ T) ** 2 * inside, axis=-1))


def forward(theta: Array, g: float) -> tuple[Array, Array]:
    """Return A = T^-1 and b as twelve values, and their derivatives by the scaled parameters, shape (..., 12, 9)."""
    T, b = parts(theta, g)
    A, shape = np.linalg.inv(T), theta.shape[:-1]
    derivative = np.zeros((*shape, 12, 9))
    for column, (i, j) in enumerate(LOWER):
        each = A[..., :, i, None] * A[..., None, j, :]
        derivative[..., :9, column] = -each.reshape(*shape, 9) / g
    derivative[..., 9:, 6:] = np.eye(3)
    return np.concatenate([A.reshape(*shape, 9), b], axis=-1), derivative


def determined_forward(determined: Flags) -> Flags:
    """Return which of the twelve are determined, from those of T and b."""
    found = np.zeros(12, dtype=bool)
    for column, (i, j) in enumerate(LOWER):
        found[3 * i + j] = determined[column]
    found[9:] = determined[6:]
    return found
