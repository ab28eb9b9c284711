"""Orientations that a fixture gives, each a little off: what that does to matrix and offset.

Laying k on face p points up along ``d_p`` turned by a tilt ``a_k = t_p + l_k`` of two small angles across it: the error
of the face, the same whenever the unit is laid on it, and that of the laying, drawn anew. To second order::

    reading = A g [(1 - |a|^2 / 2) d + T a] + b + noise         T: two axes across d, (3, 2)

About what the readings tell of the tilts (a0 of a face, a1 of a laying on it, with covariance C) and of A this is
linear again::

    reading = A g [(1 - |a0|^2 / 2 - |a1 - a0|^2 / 2 - tr(C) / 2) d + T a0] + A_0 g (T - d a0') (a - a0) + b
    beyond: covariance of |a - a0|^2 / 2 between layings k and l: half the sum of squares of C_kl

so that the cosine, which takes the square of a tilt off the scale factor, is added again. Tilts move readings across
gravity in proportion, those along it by their square: opposite faces read across gravity show how large the tilts
are (half their sum, less the bias, is half the sum of two tilts), although each face was laid once. Three variances are
found by restricted maximum likelihood [1]_: of the face errors (not where ``fixture.orientation`` states them), of the
laying (where a face is laid again, and ``fixture.repeatability`` is not stated), and of the scatter of positions, which
readings along gravity tell where more of them are there than they have unknowns.

What the uncertainty means: the scatter of the figure over fixtures of the like errors, laid anew.

Three ways in which real data break this. Faces that are askew in common (the whole fixture is turned) are
``fixture.mounting``: no reading shows it. One face that is far worse than the others widens all u. Six faces laid once
each have no reading along gravity to spare: how a position scatters beyond the noise inside it is not seen; `ASSUMED`
times that noise is taken, and remarked.

References
----------
.. [1] ``variance_components``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ....core.estimate import Array
from ....core.influence import Influence
from ....core.key import AXES
from ._kernels_fixture import lay
from .linear_sensor import HIDDEN, Source, decomposed, dof_of_each, propagated
from .outliers import FREE
from .rotations import across
from .variance_components import Components, Shared, components_of, fit_components

INSIDE = "noise inside positions"
BETWEEN = "scatter between positions"
FACE, LAYING = "fixture.orientation", "fixture.repeatability"
FACE_FOUND, LAYING_FOUND = "face error of the fixture", "repeatability of laying"
COSINE = "cosine of the tilts"
ASSUMED = 3.0  # scatter between positions over the noise inside them, where no reading tells it
UNKNOWN = 0.01  # share of all residuals that is taken for it in the weights where that noise is not known
STANDS_OUT = 10.5  # square of a position's standardised deletion residual, three components, from which it is judged
SAME = 1e-6  # difference of directions that are one face
ROUNDS, FEW_ROUNDS, MANY = 12, 4, 60  # of linearisation; fewer for so many positions
SETTLED = 1e-9  # of gravity
CONTRADICTED = 0.001  # risk of calling a stated face error too small
SUSPECTED = 2.0  # twice the gain of a larger one, from which it is found; 9.5 contradicts
WELL_TOLD = 1e-6  # determinant over the cube of the mean variance, from which a block of three has an inverse

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Tilts:
    """Positions as a fixture gives them."""

    direction: Array  # shape (m, 3): as named
    axes: Array  # shape (m, 3, 2): across these
    same: Array  # shape (m, m): one where two layings are on one face
    stated: Mapping[str, Influence]  # ``fixture.orientation``, ``fixture.repeatability``, where they are stated

    @cached_property
    def repeated(self) -> bool:
        """Whether a face was laid again."""
        return bool(self.same.sum() > len(self.same))

    @cached_property
    def faces(self) -> Array:
        """One row a face: one where a position lies on it, shape (faces, m)."""
        return np.unique(self.same, axis=0)

    @cached_property
    def unknowns(self) -> tuple[str, ...]:
        """Names of the tilts of the faces, two a face, in that order."""
        names = [_face(self.direction[int(k)]) for k in np.argmax(self.faces, axis=1)]
        return tuple(f"{name} {k}" for name in names for k in (1, 2))

    @cached_property
    def design(self) -> Array:
        """Derivatives of the readings by A and b, for a gravity of one, shape (3 m, 12)."""
        return derivatives(self.direction)

    @cached_property
    def decomposed(self) -> tuple[Array, Array]:
        """Singular values and directions of it, shapes (1, 12) and (1, 12, 12)."""
        return decomposed(self.design[None])

    @cached_property
    def lengths(self) -> int:
        """Combinations of all numbers that the lengths along the directions determine."""
        return self._lengths(np.eye(12))

    def told(self, kept: Array) -> int:
        """Return how many of the combinations ``kept``, shape (12, rank), these determine."""
        return self.lengths if kept.shape[1] == len(kept) else self._lengths(kept)

    def _lengths(self, kept: Array) -> int:
        along = np.einsum("ki,kip->kp", self.direction, (self.design @ kept).reshape(len(self.same), 3, -1))
        return int(np.linalg.matrix_rank(along, tol=1e-6))

    @cached_property
    def free(self) -> Tilts:
        """The same without a stated error of the faces."""
        return Tilts(self.direction, self.axes, self.same, {k: v for k, v in self.stated.items() if k != FACE})


@dataclass(frozen=True, eq=False)
class Laid:
    """Twelve numbers with the tilts about which they are linear."""

    found: Components
    back: Array  # shape (12, rank): the numbers by the coefficients
    values: Array  # shape (12,)
    stretch: Array  # shape (m,): length of the specific force along each direction, over gravity
    assumed: bool  # Whether the scatter between positions was not told
    contradicted: bool  # Whether the stated face error is too small for what was read
    hidden: float  # Its variance at most, where it was not [(m/s^2)^2]
    widened: float  # By which the variance along gravity is then multiplied
    design: Array  # shape (3 m, rank): of the fit, linear about the tilts
    readings: Array  # shape (3 m,): the same
    lever: Array  # shape (3 m, 2 m): derivatives of these by the tilts
    known: Mapping[str, Array]  # Covariances of the readings that were known, by source
    shared: Shared  # That of them which readings of several faces share


def tilts_of(direction: Array, stated: Mapping[str, Influence]) -> Tilts:
    """Return positions as a fixture gives them; those of one direction lie on one face."""
    return _tilts(np.asarray(direction, dtype=np.float64).tobytes(), stated.get(FACE), stated.get(LAYING))


@lru_cache(maxsize=8)  # units of a lot are laid alike
def _tilts(given: bytes, face: Influence | None, laying: Influence | None) -> Tilts:
    direction = np.frombuffer(given).reshape(-1, 3)
    same = np.max(np.abs(direction[:, None] - direction[None]), axis=2) < SAME
    rounded = direction[np.argmax(same, axis=1)]
    kept = {name: one for name, one in ((FACE, face), (LAYING, laying)) if one is not None}
    return Tilts(rounded, np.swapaxes(across(rounded), 1, 2), same.astype(float), kept)


def chosen(tilts: Tilts, kept: Flags) -> Tilts:
    """Return some of the positions."""
    if kept.all():
        return tilts
    return Tilts(tilts.direction[kept], tilts.axes[kept], tilts.same[np.ix_(kept, kept)], tilts.stated)


def derivatives(force: Array) -> Array:
    """Return the derivatives of the readings by A and b, shape (3 m, 12)."""
    design = np.zeros((3 * len(force), 12))
    for i in range(3):
        design[i::3, 3 * i : 3 * i + 3] = force
        design[i::3, 9 + i] = 1.0
    return design


def judged(tilts: Tilts, rank: int) -> bool:
    """Tell whether anything judges the numbers: readings to spare on different faces, or a stated face error."""
    return 3 * len(tilts.same if FACE in tilts.stated else tilts.faces) > rank


def fit_laid(r: Array, inside: Array, g: float, tilts: Tilts, kept: Array) -> Laid:
    """Return the numbers of positions that a fixture gives.

    Parameters
    ----------
    r : ndarray, shape (m, 3)
        Readings in units of the input [m/s^2].
    inside : ndarray, shape (m, 3)
        Their variances by the noise inside.
    g : float
        Gravity.
    tilts : Tilts
        Positions as the fixture gives them.
    kept : ndarray, shape (12, rank)
        Combinations that the positions determine, the offset in gravities.
    """
    found = _fit(r, inside, g, tilts, kept)
    if FACE not in tilts.stated:
        return found
    free = tilts.free
    if not judged(free, kept.shape[1]) or not _may_be_larger(found, found.known[FACE]):
        return found
    other = _fit(r, inside, g, free, kept)
    square = tilts.stated[FACE].u ** 2
    if other.found.variances[FACE_FOUND] <= square:
        return found
    patterns = {name: one for name, one in other.found.patterns.items() if name != FACE_FOUND}
    known = {**other.known, FACE: square * other.found.patterns[FACE_FOUND]}
    smaller = fit_components(other.design, other.readings, known, patterns, other.shared)
    if 2.0 * (other.found.likelihood - smaller.likelihood) <= special.chdtri(1.0, 2.0 * CONTRADICTED):
        return found
    widened = other.widened  # the excess may be of the tilts or of the sensors: along gravity it counts as the latter
    if other.assumed and np.all(inside > 0.0):
        widened = max(1.0, other.hidden / float(np.mean(_hidden(inside, other.hidden)[0])))
    return replace(other, contradicted=True, widened=widened)


def _may_be_larger(laid: Laid, faces: Array) -> bool:
    """Tell whether the readings may contradict the stated face error, by the slope of the likelihood there.

    The square of the slope over its information is about twice what the likelihood gains by a larger error, or more:
    far below what contradicts, nothing is gained by a fit that finds the error.

    Parameters
    ----------
    laid : Laid
        With the stated error.
    faces : ndarray, shape (3 m, 3 m)
        Covariance of the readings by it.
    """
    found = laid.found
    P, pull = found.projector, found.projector @ laid.readings
    slope = 0.5 * float(pull @ faces @ pull - np.sum(P * faces))
    if slope <= 0.0:
        return False
    moved = [P @ one for one in (faces, *found.patterns.values())]
    information = np.array([[0.5 * np.sum(one * other.T) for other in moved] for one in moved])
    beside = information[1:, 0]
    own = float(information[0, 0] - beside @ np.linalg.pinv(information[1:, 1:]) @ beside)
    return slope**2 > SUSPECTED * max(own, 0.0)


def _fit(r: Array, inside: Array, g: float, tilts: Tilts, kept: Array) -> Laid:
    m = len(r)
    scale = np.concatenate([np.ones(9), np.full(3, g)])
    back = scale[:, None] * kept
    assumed = m <= tilts.told(kept)
    wanted = [FACE_FOUND] if FACE not in tilts.stated else []
    wanted += [LAYING_FOUND] if LAYING not in tilts.stated and tilts.repeated else []
    n, p = 3 * m, kept.shape[1]
    names = [*([] if assumed else [BETWEEN]), *wanted]
    own = ASSUMED**2 * inside.ravel()
    values, stretch, y, between = np.empty(12), np.empty(m), np.empty(n), np.empty(n)
    design, Z, turned = np.empty((n, p)), np.zeros((n, 2 * m)), np.empty((2, n, n))
    squares, seen = np.empty((m, m)), np.empty(n)
    theta, information = np.empty(len(names)), np.empty((len(names),) * 2)
    fit = np.empty((n, n)), np.empty((p, n)), np.empty((p, p)), np.empty((n, n)), np.empty(p)  # inverse to coefficients
    state, likely, most = lay(
        np.ascontiguousarray(r), np.ascontiguousarray(inside), g, np.ascontiguousarray(tilts.direction),
        np.ascontiguousarray(tilts.axes), tilts.same, back,
        np.array([tilts.stated[name].u ** 2 if name in tilts.stated else np.nan for name in (FACE, LAYING)]),
        np.array([float(name in wanted) for name in (FACE_FOUND, LAYING_FOUND)]),
        assumed, own if np.all(own > 0.0) else np.empty(0), UNKNOWN, ROUNDS if m <= MANY else FEW_ROUNDS, SETTLED,
        values, stretch, design, y, Z, turned, squares, seen, between, theta, information, *fit,
    )  # fmt: skip
    known = {INSIDE: np.diag(inside.ravel()), COSINE: _cosine(squares, seen)}
    if assumed:
        known[BETWEEN] = np.diag(between)
    of_tilts = {FACE: turned[0], LAYING: turned[1]}
    known |= {name: one.u**2 * of_tilts[name] for name, one in tilts.stated.items()}
    unknown = {} if assumed else {BETWEEN: np.eye(n)}
    unknown |= {name: of_tilts[FACE if name == FACE_FOUND else LAYING] for name in wanted}
    found = components_of(state, likely, design, y, known, unknown, theta, information, *fit)
    widened = _hidden(inside, most)[1]
    shared = Shared(COSINE, tilts.same, squares, seen)
    return Laid(found, back, values, stretch, assumed, False, most, widened, design, y, Z, known, shared)


def _lever(matrix: Array, moved: Array) -> Array:
    """Return derivatives of the readings by the tilts, (3 m, 2 m); ``moved``: those of the directions, (m, 3, 2)."""
    m = len(moved)
    Z = np.zeros((m, 3, m, 2))
    at = np.arange(m)
    Z[at, :, at] = matrix @ moved
    return Z.reshape(3 * m, 2 * m)


def _squares(spread: Array) -> Array:
    """Covariance of half the squares of the tilts, shape (m, m), by that of the tilts."""
    m = len(spread) // 2
    return np.asarray(0.5 * np.sum(spread.reshape(m, 2, m, 2) ** 2, axis=(1, 3)))


def _cosine(squares: Array, up: Array) -> Array:
    """Covariance of the readings by the squares of the tilts, shape (3 m, 3 m); ``up``: A g d of each, (3 m,)."""
    return np.asarray(np.repeat(np.repeat(squares, 3, axis=0), 3, axis=1) * np.outer(up, up))


def _hidden(inside: Array, most: float) -> tuple[Array, float]:
    """Variance between positions that no reading tells, shape (3 m,), and how many times that counts.

    `ASSUMED` times the noise inside, no more than all residuals show. Where the noise inside is not known these are
    all that bounds it; readings are weighed as if it were a part of that, for along gravity no tilt moves them.
    """
    own = ASSUMED**2 * inside.ravel()
    if np.all(own > 0.0):
        return np.minimum(own, most), 1.0
    return np.full(len(own), UNKNOWN * most), 1.0 / UNKNOWN


def many_sources(fits: Sequence[tuple[Laid, Tilts]]) -> list[list[Source]]:
    """Return the sources of the twelve numbers of each of many fits."""
    judged_by = [_judged(laid, tilts) for laid, tilts in fits]
    alike: dict[int, list[int]] = {}
    for k, one in enumerate(judged_by):
        alike.setdefault(len(one.exact), []).append(k)
    for at in alike.values():
        shares, dofs = [judged_by[k].shares for k in at], [judged_by[k].dof for k in at]
        joined = dof_of_each(np.concatenate(shares, axis=1), np.concatenate(dofs)).reshape(-1, 12)
        for k, dof in zip(at, joined, strict=True):
            judged_by[k].dof[:] = dof
    return [_sources(laid, tilts, one) for (laid, tilts), one in zip(fits, judged_by, strict=True)]


@dataclass(frozen=True, eq=False)
class _Judged:
    """What judges the twelve numbers of a fit."""

    parts: Mapping[str, Array]  # Covariances of the numbers, by source, shape (12, 12)
    exact: Mapping[str, Array]  # Those that are judged by the readings
    cosine: Array  # That of the squares of the tilts
    shares: Array  # shape (parts, 12): of the variances that are judged, by source
    dof: Array  # shape (12,): of their sum; then of each
    moved: Array  # shape (12, n): the numbers per reading


def _judged(laid: Laid, tilts: Tilts) -> _Judged:
    found, back = laid.found, laid.back
    stated = {name: one for name, one in tilts.stated.items() if name != FACE or not laid.contradicted}
    parts = {name: propagated(back, one) for name, one in (*found.known.items(), *found.unknown.items())}
    cosine = parts.pop(COSINE)
    face = FACE if FACE in stated else FACE_FOUND
    moved = back @ found.gain
    if laid.assumed and laid.widened > 1.0:  # along gravity; across it, the tilts that were found hold all scatter
        weights = (laid.widened - 1.0) * np.diag(laid.known[BETWEEN]).reshape(-1, 3)[:, 0]
        own = np.einsum("qki,ki->qk", moved.reshape(12, -1, 3), tilts.direction)
        parts[BETWEEN] = parts[BETWEEN] + (own * weights) @ own.T
    exact = {name: one for name, one in parts.items() if name not in stated}
    judged_by = sum((np.diag(one) for one in exact.values()), np.zeros(12))
    slopes = np.array([np.einsum("qn,nm,qm->q", moved, one, moved) for one in found.patterns.values()]).reshape(-1, 12)
    spread = np.einsum("jq,jk,kq->q", slopes, found.variances_covariance, slopes)
    if face == FACE_FOUND:  # what goes with the square of a variance is known half as well
        half = max(0.5 * found.variance_dof(FACE_FOUND), 1.0)
        spread = spread + 2.0 * np.diag(cosine) ** 2 / half
        judged_by = judged_by + np.diag(cosine)
        exact[FACE_FOUND] = exact[FACE_FOUND] + cosine
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = np.where(spread > 0.0, 2.0 * judged_by**2 / spread, np.inf)
        shares = np.array([np.diag(one) / judged_by for one in exact.values()])
    dof = np.where(judged_by > 0.0, dof, np.inf)
    return _Judged(parts, exact, cosine, np.nan_to_num(shares), dof, moved)


def _sources(laid: Laid, tilts: Tilts, judged_by: _Judged) -> list[Source]:
    stated = {name: one for name, one in tilts.stated.items() if name != FACE or not laid.contradicted}
    parts, cosine, moved, sources = judged_by.parts, judged_by.cosine, judged_by.moved, list[Source]()
    for name, part in judged_by.exact.items():
        level = HIDDEN if name == BETWEEN and laid.assumed else ""
        shown = f"{name}, as much as may be hidden" if level else name
        sources.append(Source(shown, "A", part, judged_by.dof, level=level))
    if LAYING in stated:
        sources.append(Source(LAYING, "B", parts[LAYING], stated[LAYING].dof, stated[LAYING]))
    if FACE in stated:
        one, by_tilt = stated[FACE], (moved @ laid.lever).T.reshape(-1, 24)
        changes = one.u * (tilts.faces @ by_tilt).reshape(-1, 12)  # those of a face are tilted alike
        whole = changes.T @ changes
        sources.append(Source(FACE, "B", whole, one.dof, one, changes=changes, unknowns=tilts.unknowns))
        sources.append(Source(COSINE, "B", cosine, one.dof))
    return [one for one in sources if (one.covariance.diagonal() > 0.0).any()]


def _face(direction: Array) -> str:
    """Return what a face is called: ``"x+"``, or its direction."""
    k = int(np.argmax(np.abs(direction)))
    if abs(direction[k]) > 1.0 - SAME:
        return f"{AXES[k]}{'+' if direction[k] > 0.0 else '-'}"
    return " ".join(f"{one:.4f}" for one in direction)


def fit_agreeing(r: Array, inside: Array, g: float, tilts: Tilts, kept: Array, risk: float) -> tuple[Laid, Flags]:
    """Return the fit of the positions that agree, and which do not, shape (m,).

    The position that stands out most is left out if the fit without it says that chance explains it at less than the
    risk, shared among all; and so on.

    Parameters
    ----------
    r, inside, g, tilts, kept
        As `fit_laid` takes them.
    risk : float
        Probability that any of a clean set is called an outlier.
    """
    m = len(r)
    rest, laid = np.ones(m, dtype=bool), fit_laid(r, inside, g, tilts, kept)
    scale = np.concatenate([np.ones(9), np.full(3, g)])
    usual = np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    by_numbers = derivatives(g * tilts.direction)
    design, y = by_numbers * scale @ kept, r.ravel() - by_numbers @ usual
    while True:
        P, pull = laid.found.projector, (laid.found.projector @ laid.readings).reshape(-1, 3)
        every = np.arange(len(pull))
        blocks = P.reshape(len(pull), 3, -1, 3)[every, :, every]
        mean = blocks.trace(axis1=1, axis2=2) / 3.0
        plain = (np.linalg.det(blocks) > WELL_TOLD * mean**3).all()
        inverse = np.linalg.inv(blocks) if plain else np.linalg.pinv(blocks, rcond=1e-9)
        ratios = np.einsum("ki,kij,kj->k", pull, inverse, pull)
        if ratios.max() < STANDS_OUT:
            break
        worst = int(np.flatnonzero(rest)[np.argmax(ratios)])
        fewer = rest & (np.arange(m) != worst)
        rows, among = np.repeat(fewer, 3), np.repeat(rest, 3)
        enough = rows.sum() - kept.shape[1] >= FREE and judged(chosen(tilts, fewer), kept.shape[1])
        if not enough or np.linalg.matrix_rank(design[rows]) < kept.shape[1]:
            break
        without = fit_laid(r[fewer], inside[fewer], g, chosen(tilts, fewer), kept)
        V = _covariance(without, tilts, inside, g)
        at = np.flatnonzero(np.flatnonzero(among) // 3 == worst)
        P = _projector(design[among], V[np.ix_(among, among)])
        a = (P @ y[among])[at]
        ratio = float(a @ np.linalg.solve(P[np.ix_(at, at)], a)) / 3.0
        found = without.found
        dofs = [found.variance_dof(name) for name, size in found.variances.items() if size > 0.0]
        if special.fdtrc(3, max(min(dofs, default=found.free), 2.0), ratio) >= risk / m:
            break
        rest, laid = fewer, without
    return laid, ~rest


def _covariance(laid: Laid, tilts: Tilts, inside: Array, g: float) -> Array:
    """Covariance of readings in positions, also in those that are not in the fit, shape (3 m, 3 m)."""
    m, A, found = len(inside), laid.values[:9].reshape(3, 3), laid.found
    sizes = {name: one.u**2 for name, one in tilts.stated.items()}
    face = found.variances.get(FACE_FOUND, sizes.get(FACE, 0.0))
    laying = found.variances.get(LAYING_FOUND, sizes.get(LAYING, 0.0))
    Z = _lever(g * A, tilts.axes)
    spread: Array = np.kron(face * tilts.same + laying * np.eye(m), np.eye(2)).astype(np.float64)
    hidden = _hidden(inside, laid.hidden)[0] if laid.assumed else found.variances[BETWEEN]
    return np.asarray(
        Z @ spread @ Z.T
        + _cosine(_squares(spread), g * (tilts.direction @ A.T).ravel())
        + np.diag(inside.ravel() + hidden)
    )


def scatter_interval(scatter: float, dof: float, square_variance: float) -> tuple[float, float]:
    """Interval of 95 % of a standard deviation whose square is known with a variance; from zero where it hardly is."""
    if dof >= 1.0:
        low, high = np.sqrt(dof / (2.0 * special.gammaincinv(0.5 * dof, [0.975, 0.025]))) * scatter
        return float(low), float(high)
    return 0.0, float(np.sqrt(scatter**2 + 1.96 * np.sqrt(square_variance)))


def _projector(design: Array, V: Array) -> Array:
    inverse = np.linalg.inv(V)
    weighted = inverse @ design
    return np.asarray(inverse - weighted @ np.linalg.solve(design.T @ weighted, weighted.T))
