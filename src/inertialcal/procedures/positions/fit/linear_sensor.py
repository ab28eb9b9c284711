"""Three sensors as a matrix and an offset, with the sources of uncertainty of both: what the fits hand on.

In units of the input: ``reading = A x + b`` where a reading is (output - zero) / ideal scale factor. The twelve numbers
are in the order A_xx, A_xy, A_xz, A_yx, ..., A_zz, b_x, b_y, b_z; of the gyros nine more follow, G_xx, ..., G_zz.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ....core.estimate import Array, fewer_joined, joined_dof
from ....core.influence import Influence
from ....core.key import AXES, Key, Origin, Reason
from ....core.unknowns import Unknowns
from ....statistics.two_levels import TwoLevels
from ...corrections import TakenOff, dof_of, moved
from ._kernels_sphere import fill_sizes

PAIRS = tuple(a + b for a in AXES for b in AXES)
MATRIX = tuple(Key("scale_factor_error", p[0]) if p[0] == p[1] else Key("misalignment", p) for p in PAIRS)
BIAS = tuple(Key("bias", a) for a in AXES)
G_SENSITIVITY = tuple(Key("g_sensitivity", p) for p in PAIRS)
LEAST_DOF, MOST_DOF, HALVINGS = 0.2, 1e6, 25
SECANTS, ENOUGH = 60, 1e-12  # at most so many; step of a logarithm that ends them
FEWEST = 1.0  # degrees of freedom by which something is judged at all
HIDDEN = "hidden"  # level of a bound on a scatter that nothing shows
SMALLEST = 1e-4  # singular value over the largest one
USELESS = 0.05  # standard uncertainty of a combination of size one, above which it is not determined
TAKES_PART = 0.03  # share of a parameter in a combination, below which it is determined


@dataclass(frozen=True, eq=False)
class Source:
    """One source of uncertainty of all the numbers at once: the fields of a Component, and what was stated."""

    name: str
    kind: str
    covariance: Array
    dof: Array | float = np.inf
    influence: Influence | None = None
    level: str = ""
    changes: Array | None = None
    unknowns: tuple[str, ...] = ()  # Which each of them is, where there are several
    off: Unknowns | None = None  # What an earlier test found, that was taken off the readings

    @property
    def origin(self) -> Origin:
        """Where it comes from."""
        if self.off is not None:
            return self.off.origin
        return Origin(self.name, level=self.level) if self.influence is None else self.influence.origin(self.name)


@dataclass(frozen=True, eq=False)
class OverTemperature:
    """How the numbers of a sensor change with temperature: coefficients of powers of T - T_ref, from the first on."""

    reference: float  # T_ref [degC]
    range: tuple[float, float]  # Temperatures that it was seen at [degC]
    values: Array  # shape (p, 12): of the plain entries of A and b, by power
    sources: tuple[Source, ...]  # Of the numbers at T_ref and of all powers together, 12 (p + 1) of them
    keys: tuple[Key, ...]  # shape (12 p,): their names
    units: tuple[str, ...]  # and units

    def scaled(self, rows: Array) -> OverTemperature:
        """Return the same with every number times a factor, shape (12,)."""
        each = np.tile(rows, len(self.values) + 1)
        return replace(self, values=self.values * rows, sources=tuple(_scaled(one, each) for one in self.sources))


@dataclass(frozen=True, eq=False)
class LinearSensor:
    """Matrix and offset of three sensors, relative to their ideal scale factor and zero."""

    values: Array  # shape (12,): in the order of the module head
    sources: tuple[Source, ...]  # Their covariances add; in the same order
    reasons: Mapping[int, Reason]  # Number -> why it is not estimated
    ideal: Array  # shape (3,): scale factor [unit of the readings/input unit]
    zero: Array  # shape (3,): reading for no input [unit of the readings]
    named: tuple[Key, ...] = field(default=(*MATRIX, *BIAS))
    temperature: OverTemperature | None = None  # Then the numbers are those at its reference temperature

    @property
    def matrix(self) -> Array:
        """A, shape (3, 3)."""
        return self.values[:9].reshape(3, 3)

    @property
    def offset(self) -> Array:
        """b, shape (3,) [input unit]."""
        return self.values[9:12]

    @property
    def g_sensitivity(self) -> Array | None:
        """G, shape (3, 3), or None."""
        return self.values[12:].reshape(3, 3) if len(self.values) > 12 else None

    @property
    def covariance(self) -> Array:
        """Sum of the sources."""
        total = np.zeros((len(self.values), len(self.values)))
        for one in self.sources:
            total = total + one.covariance
        return total

    def normalised(self, output: Array) -> Array:
        """Return readings [input unit] of outputs, shape (n, 3)."""
        return np.asarray((output - self.zero) / self.ideal)

    def applied(self, output: Array) -> Array:
        """Return the inputs that give these outputs, g-sensitivity left aside, shape (n, 3)."""
        return np.asarray((self.normalised(output) - self.offset) @ np.linalg.inv(self.matrix).T)


def ends_of(seen: Sequence[tuple[LinearSensor, Array]]) -> Array:
    """Return the least and the largest of the inputs that gave outputs, shape (n, 3), and zero, (sensors, 3, 2)."""
    found = np.zeros((len(seen), 3, 2))
    alike: dict[int, list[int]] = {}
    for k, (_, output) in enumerate(seen):
        alike.setdefault(len(output), []).append(k)
    for n, at in alike.items():
        if n:
            own, output = [seen[k][0] for k in at], np.array([seen[k][1] for k in at])
            zero, ideal = (np.array([[getattr(one, name)] for one in own]) for name in ("zero", "ideal"))
            values = np.array([one.values[:12] for one in own])
            back = np.linalg.inv(values[:, :9].reshape(-1, 3, 3)).swapaxes(1, 2)
            x = ((output - zero) / ideal - values[:, None, 9:]) @ back
            found[at, :, 0], found[at, :, 1] = np.minimum(x.min(axis=1), 0.0), np.maximum(x.max(axis=1), 0.0)
    return found


def with_ideal(sensor: LinearSensor, ideal: Array, zero: Array) -> LinearSensor:
    """Return the same sensor relative to another ideal scale factor and zero."""
    if np.array_equal(sensor.ideal, ideal) and np.array_equal(sensor.zero, zero):
        return sensor
    ratio = sensor.ideal / ideal
    rows = np.concatenate([np.repeat(ratio, 3), ratio, np.repeat(ratio, 3)])[: len(sensor.values)]
    values = sensor.values * rows
    values[9:12] += (sensor.zero - zero) / ideal
    sources = tuple(_scaled(one, rows) for one in sensor.sources)
    own = None if sensor.temperature is None else sensor.temperature.scaled(rows)
    return replace(sensor, values=values, sources=sources, ideal=ideal, zero=zero, temperature=own)


def _scaled(source: Source, rows: Array) -> Source:
    changes = None if source.changes is None else source.changes * rows
    return replace(source, covariance=source.covariance * np.outer(rows, rows), changes=changes)


def after_corrections(taken_off: TakenOff, per_reading: Array, per_level: Array | None = None) -> list[Source]:
    """Return the sources that corrections are, by the numbers per mean reading.

    Parameters
    ----------
    taken_off : mapping of Origin to Unknowns
        Of m positions.
    per_reading : ndarray, shape (q, m, 3)
        Numbers per mean reading of x, y and z in each position [per input unit].
    per_level : ndarray, shape (q, 3), optional
        Numbers per reading of x, y and z while the unit turns; it follows the mean over the positions.
    """
    gain = per_reading
    if per_level is not None:
        gain = per_reading + per_level[:, None, :] / per_reading.shape[1]
    found = []
    for off in taken_off.values():
        changes = moved(off, gain)
        if np.any(changes):
            whole = changes.T @ changes
            covariance, dof = 0.5 * (whole + whole.T), dof_of(off, gain)
            found.append(Source(str(off.origin), off.kind, covariance, dof, None, "", changes, off.unknowns, off))
    return found


def rounded_scale(sensor: LinearSensor, determined: NDArray[np.bool_]) -> Array:
    """Return the scale factors found, rounded to two digits: a definition to refer to, shape (3,)."""
    found = np.abs(np.where(determined, sensor.ideal * np.diag(sensor.matrix), sensor.ideal))
    power = 10.0 ** (np.floor(np.log10(found)) - 1.0)
    return np.asarray(np.round(found / power) * power)


def level_sources(
    fit: TwoLevels, back: Array, stated: Mapping[str, Influence], between: str, share: float = 1.0
) -> list[Source]:
    """Return the sources of the numbers ``back @ coefficients``.

    Parameters
    ----------
    fit : TwoLevels
        Its known sources by their names.
    back : ndarray, shape (q, p)
        Numbers per coefficient.
    stated : mapping of str to Influence
        Those of the known sources that are of Type B.
    between : str
        Name of the scatter between readings.
    share : float
        By which the variances of the known sources that are not stated are multiplied.
    """
    return many_level_sources([fit], back[None], stated, between, share)[0]


def many_level_sources(
    fits: Sequence[TwoLevels], back: Array, stated: Mapping[str, Influence], between: str, share: float = 1.0
) -> list[list[Source]]:
    """Return what `level_sources` gives of each of many fits of one shape; ``back``, shape (fits, q, p)."""
    parts = {
        name: propagated(back, np.array([one.parts[name] for one in fits])) for name in (fits[0].parts if fits else ())
    }
    moved = back @ np.array([one.by_scatter for one in fits])
    per_square = moved @ moved.swapaxes(1, 2)
    slope = per_square.diagonal(axis1=1, axis2=2)
    square = np.array([[one.between**2] for one in fits])
    own = [part.diagonal(axis1=1, axis2=2) for name, part in parts.items() if name not in stated]
    judged = sum(own, square * slope)
    whole = np.sum((back @ np.array([one.covariance for one in fits])) * back, axis=2)
    information = np.array([[one.information] for one in fits])
    with np.errstate(divide="ignore", invalid="ignore"):
        dof = np.where(slope > 0.0, (whole / slope) ** 2 * information, np.inf)
    hidden = _ratio(whole, judged) ** 2 * dof < FEWEST
    visible = _scatter(per_square, np.where(hidden, 0.0, square))
    bound = np.array([[max(one.hidden, one.between**2)] for one in fits])
    unseen = _scatter(per_square, np.where(hidden, bound, 0.0))
    squares = np.array([visible.diagonal(axis1=1, axis2=2), *(share * one for one in own)])
    shares = np.nan_to_num(squares / np.where(judged > 0.0, np.sum(squares, axis=0), 1.0))
    known = np.where(hidden | (judged == 0.0), np.inf, dof)
    each = dof_of_each(shares.reshape(len(squares), -1), known.ravel()).reshape(known.shape)
    most = f"{between}, as much as may be hidden"
    every: list[tuple[str, str, Array, Array | None, Influence | None, str]] = [
        (between, "A", visible, each, None, ""), (most, "A", unseen, None, None, HIDDEN)
    ]  # fmt: skip
    every += [
        (name, "B", part, None, stated[name], "") if name in stated else (name, "A", share * part, each, None, "")
        for name, part in parts.items()
    ]
    found: list[list[Source]] = [[] for _ in fits]
    for name, kind, covariances, dofs, influence, level in every:
        for k in np.flatnonzero((covariances.diagonal(axis1=1, axis2=2) > 0.0).any(axis=1)).tolist():
            found[k].append(Source(name, kind, covariances[k], np.inf if dofs is None else dofs[k], influence, level))
    return found


def dof_of_each(shares: Array, dof: Array) -> Array:
    """Return degrees of freedom that, given to each part of a variance, join to those of the whole, shape (k,).

    The parts are judged together, by one mixture of variances: none of them has degrees of freedom of its own.

    Parameters
    ----------
    shares : ndarray, shape (parts, k)
        Of the whole.
    dof : ndarray, shape (k,)
        Of the whole.
    """
    found, some = np.full(len(dof), np.inf), dof < MOST_DOF
    if not some.any():
        return found
    low, high = float(np.log(LEAST_DOF)), np.log(np.maximum(dof[some], LEAST_DOF))
    beyond = fewer_joined(shares[:, some], dof[some])
    steps = 2.0**HALVINGS  # the interval is told to so many parts of it
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.ceil((_falls_to_one(beyond, low, high) - low) / (high - low) * steps)
    high = low + (high - low) * np.clip(np.where(np.isnan(part), steps, part), 1.0, steps) / steps
    found[some] = np.exp(high)
    return found


def _falls_to_one(beyond: Callable[[Array, NDArray[np.intp]], Array], low: float, high: Array) -> Array:
    """Return the logarithm at which a function that falls with it is one, shape (k,), by secants of its own.

    Infinite where it is above one up to the end, ``low`` where it is below one from the start.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        value = np.log(beyond(np.exp(high), np.arange(len(high))))
        found = np.where(value > 0.0, np.inf, low)
        left = np.flatnonzero(~((value > 0.0) | np.isneginf(value)))
        old, value = high[left], value[left]
        below, above, before = np.full(len(left), low), old, np.full(len(left), np.inf)
        at = np.clip(old + value, below, above)  # it falls about as the inverse
        for _ in range(SECANTS):
            if not len(left):
                break
            new = np.log(beyond(np.exp(at), left))
            below, above = np.where(new > 0.0, at, below), np.where(new > 0.0, above, at)
            step = -new * (at - old) / (new - value)
            there = (new == 0.0) | (np.abs(step) <= ENOUGH)  # by rounding the step may lead out of the bracket
            inside = (at + step > below) & (at + step < above)
            old, value = at, new
            at = np.where(there, old, np.where(inside, old + step, 0.5 * (below + above)))
            found[left] = at
            # what a secant leaves is about the product of the last two steps, and less here
            going = ~(there | (inside & (np.abs(step * before) <= ENOUGH)) | (np.abs(at - old) <= ENOUGH))
            left, old, value, below, above, at, before = (
                one[going] for one in (left, old, value, below, above, at, step)
            )
    return found


def _scatter(per_square: Array, square: Array) -> Array:
    root = np.sqrt(square)
    return np.asarray(root[..., :, None] * root[..., None, :] * per_square)


def _ratio(a: Array, b: Array) -> Array:
    """Return a / b, infinite where both are zero: nothing is judged there."""
    return np.asarray(np.divide(a, b, out=np.full(a.shape, np.inf), where=b > 0.0))


def summed(groups: Sequence[Sequence[Source]]) -> list[Source]:
    """Return sources of one name as one: variances and degrees of freedom are joined."""
    found: dict[str, Source] = {}
    for one in (source for group in groups for source in group):
        before = found.setdefault(one.name, one)
        if before is one:
            continue
        covariance = before.covariance + one.covariance
        dof = joined_dof([np.diag(before.covariance), np.diag(one.covariance)], [before.dof, one.dof])
        found[one.name] = replace(before, covariance=covariance, dof=dof, changes=None)
    return list(found.values())


def propagated(back: Array, covariance: Array) -> Array:
    """Return ``back C back'``, symmetric to the last bit."""
    whole = back @ covariance @ back.swapaxes(-1, -2)
    return np.asarray(0.5 * (whole + whole.swapaxes(-1, -2)))


@dataclass(frozen=True, eq=False)
class Observability:
    """What readings determine."""

    rank: int  # Combinations that are determined
    count: int  # Combinations in all
    determined: NDArray[np.bool_]  # shape (p,): parameters that take no part in a combination that is not
    kept: Array  # shape (p, rank): directions that are determined, in scaled parameters
    combinations: tuple[str, ...]  # Those that are not, in words
    parts: tuple[frozenset[Key], ...]  # Parameters that take part in each of them

    @property
    def whole(self) -> bool:
        """Whether everything is determined."""
        return self.rank == self.count


def can_tell(
    s: Array, scatter: Array | float, useless: float = USELESS, smallest: float = SMALLEST
) -> NDArray[np.bool_]:
    """Return which combinations are determined, by singular values, shape (..., p), and the scatter of a reading."""
    most = s.max(axis=-1, initial=0.0, keepdims=True)
    return np.asarray((s > smallest * most) & (np.asarray(scatter)[..., None] < useless * s))


def observe(
    scaled: Array,
    names: Sequence[Key],
    scatter: float,
    useless: float = USELESS,
    takes_part: float = TAKES_PART,
    smallest: float = SMALLEST,
) -> Observability:
    """Return what a scaled Jacobian can tell.

    Parameters
    ----------
    scaled : ndarray, shape (n, p)
        Derivatives of the readings by scaled parameters, all in one unit.
    names : sequence of Key
        Of the parameters.
    scatter : float
        Standard deviation of a reading, in that unit.
    useless : float
        Standard uncertainty of a combination of size one, above which it is not determined.
    takes_part : float
        Share of a parameter in a combination that is not, below which the parameter is determined.
    smallest : float
        Singular value over the largest one, below which a combination is not determined.
    """
    return observe_many(scaled[None], names, np.array([scatter]), useless, takes_part, smallest)[0]


def observe_many(
    scaled: Array,
    names: Sequence[Key],
    scatter: Array,
    useless: float = USELESS,
    takes_part: float = TAKES_PART,
    smallest: float = SMALLEST,
) -> list[Observability]:
    """Return what `observe` gives of each of many scaled Jacobians, shape (sets, n, p); ``scatter``, shape (sets,)."""
    sizes = np.empty((len(scaled), 2))
    fill_sizes(np.ascontiguousarray(scaled), sizes)
    whole = (sizes[:, 0] > smallest * sizes[:, 1]) & (scatter < useless * sizes[:, 0])
    found = [_whole(scaled.shape[2])] * len(scaled)
    others = np.flatnonzero(~whole)
    told = told_by(*decomposed(scaled[others]), names, scatter[others], useless, takes_part, smallest)
    for k, one in zip(others.tolist(), told, strict=True):
        found[k] = one
    return found


@lru_cache
def _whole(p: int) -> Observability:
    """Return that of readings that determine all of so many parameters well: each is a direction as good as any."""
    return Observability(p, p, np.ones(p, dtype=bool), np.eye(p), (), ())


def decomposed(scaled: Array) -> tuple[Array, Array]:
    """Return singular values and directions of scaled Jacobians, shape (sets, n, p), as many as columns."""
    sets, n, p = scaled.shape
    padded = scaled if n >= p else np.concatenate([scaled, np.zeros((sets, p - n, p))], axis=1)
    sizes, directions = np.linalg.svd(padded, full_matrices=False)[1:]
    return sizes, directions


def told_by(
    sizes: Array,
    directions: Array,
    names: Sequence[Key],
    scatter: Array,
    useless: float = USELESS,
    takes_part: float = TAKES_PART,
    smallest: float = SMALLEST,
) -> list[Observability]:
    """Return what `observe_many` gives of Jacobians that are `decomposed`."""
    found, p = [], sizes.shape[1]
    for rows, good in zip(directions, can_tell(sizes, scatter, useless, smallest), strict=True):
        if good.all():
            found.append(Observability(p, p, np.ones(p, dtype=bool), rows.T, (), ()))
            continue
        lost = rows[~good].T
        determined = np.sqrt(np.sum(lost**2, axis=1)) < takes_part
        rank = int(np.sum(good))
        simple = _simple(lost, names)
        parts = tuple(frozenset(name for _, name in terms) for terms in simple)
        combinations = tuple(map(_in_words, simple))
        found.append(Observability(rank, p, determined, rows[good].T, combinations, parts))
    return found


def _simple(lost: Array, names: Sequence[Key]) -> list[list[tuple[float, Key]]]:
    """Return each combination with as few parameters in it as can be, the largest with factor one."""
    if not lost.shape[1]:
        return []
    pivots = np.sort(linalg.qr(lost.T, mode="r", pivoting=True)[1][: lost.shape[1]])
    vectors = (vector / vector[np.argmax(np.abs(vector))] for vector in (lost @ np.linalg.inv(lost[pivots])).T)
    return [[(factor, names[i]) for i, factor in enumerate(one) if abs(factor) > TAKES_PART] for one in vectors]


def _in_words(terms: Sequence[tuple[float, Key]]) -> str:
    words: list[str] = []
    for factor, name in terms:
        size = "" if abs(abs(factor) - 1.0) < 0.005 else f"{abs(factor):.2g} "
        sign = "-" if factor < 0.0 else "+"
        words.append(f"{sign} {size}{name}" if words else f"{sign if factor < 0.0 else ''}{size}{name}")
    return " ".join(words)
