"""Estimate: named values with a full covariance that remembers where it comes from.

The covariance is a sum of components (JCGM 100, 5.1 and 5.2): each is one source of uncertainty, of
Type A (scatter that was observed) or Type B (a standard's certificate, a mounting tolerance), with its
own degrees of freedom. The degrees of freedom of a value follow from those of its components (`joined_dof`),
so a budget is no separate piece of book-keeping: it is the estimate itself.

An Estimate has no operators: propagate a function of it with ``statistics.propagate``.

References
----------
.. [1] JCGM 100:2008, Evaluation of measurement data - Guide to the expression of uncertainty in
   measurement (GUM), clauses 4.2, 4.3, 5.1, 5.2, G.4.
.. [2] S. K. Banerjee, Sankhya A 23 (1961) 85: confidence interval of a sum of normal means, any number of variances.
.. [3] Abramowitz and Stegun, Handbook of Mathematical Functions, 1972.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from .errors import DataError
from .key import Key, Origin
from .results import Curvature, changed
from .show.frames import frame
from .show.rounding import dof, with_uncertainty
from .show.tables import Block, Table, html, text

if TYPE_CHECKING:
    from pandas import DataFrame

    from .influence import Influence


Array = NDArray[np.float64]
Numbers = NDArray[np.integer | np.floating]  # readings as they were recorded: counts, or floats of any width

P = 0.95  # Of the two-sided interval that degrees of freedom are joined for
FEW = 1.5  # Degrees of freedom up to which Banerjee's bound is taken as it is
NO_EXCESS = 1e-7  # of k^2 over that of the normal distribution: degrees of freedom beyond 1e8 are infinite
AFTER = "after"  # of an unknown: it came with what another test found, which was taken off before
SYMMETRY = 1e-9  # largest relative asymmetry that a covariance may have from rounding
TINY = float(np.finfo(float).tiny)
BEND, TERMS, HALVINGS = 6.0, 36, 60  # of the series for degrees of freedom
MANY = 2e-3  # 1 / dof up to which four powers of it are enough


def joined_dof(variances: Sequence[Array], dofs: Sequence[Array | float], total: Array | None = None) -> Array:
    """Return the degrees of freedom of sums of independent parts, shape (k,): those whose t gives a 95 % interval.

    Welch-Satterthwaite takes the shares of the parts as known. With few degrees of freedom they are not: of a part with
    1 that is three times a known one, its intervals hold 87 %. Here, with q_i = w_i / sum(w), t_i Student's quantile of
    part i and z that of the normal distribution, the interval is ``k u``::

        k^2 = z^2 + sum q_i^a_i (t_i^2 - z^2)        a_i = max(1, 2 - 1.5 / dof_i)

    and the degrees of freedom are those with t = k. With all a_i = 1 this is Banerjee's bound [2]_, proven to hold 95 %
    or more whatever the true variances; a_i = 2 is Welch-Satterthwaite to first order in 1 / dof. It holds 94.9 to
    98.7 % for one part of 1 to 30 degrees of freedom with known ones of any size, up to 99.2 % for several such parts.
    One-sided bounds of 95 % hold as well; beyond 99 % probability the tails are those of t, and thinner than true ones.

    Parameters
    ----------
    variances : sequence of ndarray, shape (k,)
        Of each part.
    dofs : sequence of ndarray, shape (k,), or float
        Of each part; infinite where its size is known.
    total : ndarray, shape (k,), optional
        Variance of the sum, where it holds other parts of known size, or some cancel; by default the sum of the parts.

    Returns
    -------
    ndarray, shape (k,)
        From the fewest of a part to infinity.
    """
    from scipy import special  # noqa: PLC0415 - starts slowly, and many commands join nothing

    p = 0.5 * (1.0 + P)
    whole = np.asarray(sum(variances) if total is None else total, dtype=float)
    z_square = float(special.ndtri(p)) ** 2
    pairs = [(variance, dof) for variance, dof in zip(variances, dofs, strict=True)
             if not (isinstance(dof, float) and dof == np.inf)]  # fmt: skip
    each, dof = (np.empty((len(pairs), *whole.shape)) for _ in range(2))
    for row, (variance, given) in enumerate(pairs):
        each[row], dof[row] = variance, given
    acts = (each > 0.0) & (whole > 0.0) & np.isfinite(dof)
    if not acts.any():
        return np.full(whole.shape, np.inf)
    some = acts.any(axis=tuple(range(1, acts.ndim)))
    each, dof, acts = each[some], dof[some], acts[some]
    dof = np.where(acts, dof, 1.0)
    share = np.divide(each, whole, out=np.zeros(each.shape), where=acts)
    own = np.zeros(each.shape)
    own[acts] = special.stdtrit(dof[acts], p) ** 2 - z_square
    excess = np.sum(share ** np.maximum(1.0, 2.0 - FEW / dof) * own, axis=0)
    largest, fewest = np.max(np.where(acts, own, 0.0), axis=0), np.min(np.where(acts, dof, np.inf), axis=0)
    alone = excess >= largest * (1.0 - SYMMETRY)  # to the last digit that of the part
    between = ~alone & (excess > NO_EXCESS)
    joined = np.where(alone, fewest, np.inf)
    if between.any():
        joined[between] = np.maximum(_freedom_of(excess[between] / z_square), fewest[between])
    return joined


def _freedom_of(excess: Array) -> Array:
    """Return the degrees of freedom of which Student's t squared is so much above that of the normal, relative: (n,).

    To 1e-11 of 1 / dof over the excess, as a Chebyshev series, from 1 degree of freedom on.
    """
    from scipy import special  # noqa: PLC0415 - as in `joined_dof`

    series, most = _freedom_series()
    at = np.minimum(excess / (excess + BEND), most)
    angle = np.arccos(np.clip(2.0 * at / most - 1.0, -1.0, 1.0))  # of all terms at once: a loop over them takes longer
    terms = np.cos(angle[:, None] * np.arange(len(series))) * series
    found: Array = 1.0 / (excess * terms.sum(axis=1))
    wide = excess > most * BEND / (1.0 - most)  # fewer than 1
    if wide.any():
        p = 0.5 * (1.0 + P)
        found[wide] = special.stdtridf(p, special.ndtri(p) * np.sqrt(1.0 + excess[wide]))
    return found


@cache
def _freedom_series() -> tuple[Array, float]:
    """Return the series of `_freedom_of`, and the argument of 1 degree of freedom; with many, 26.7.5 of [3]_."""
    from scipy import special  # noqa: PLC0415 - as in `joined_dof`

    p = 0.5 * (1.0 + P)
    z = float(special.ndtri(p))
    powers = (
        0.0,
        (z**2 + 1.0) / 4.0,
        (5.0 * z**4 + 16.0 * z**2 + 3.0) / 96.0,
        (3.0 * z**6 + 19.0 * z**4 + 17.0 * z**2 - 15.0) / 384.0,
        (79.0 * z**8 + 776.0 * z**6 + 1482.0 * z**4 - 1920.0 * z**2 - 945.0) / 92160.0,
    )

    def above(w: Array) -> Array:
        """Return the excess of 1 / w degrees of freedom."""
        few = np.polynomial.polynomial.polyval(w, powers)
        return np.where(w < MANY, few * (2.0 + few), (special.stdtrit(1.0 / np.maximum(w, MANY), p) / z) ** 2 - 1.0)

    most = float(above(np.ones(1))[0])
    most /= most + BEND
    nodes = chebyshev.chebpts1(TERMS)
    at = 0.5 * most * (nodes + 1.0)
    excess = BEND * at / (1.0 - at)
    low, high = 1e-3 * excess, np.full(TERMS, 1.0 + 1e-6)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        small = above(middle) < excess
        low, high = np.where(small, middle, low), np.where(small, high, middle)
    return np.asarray(chebyshev.chebfit(nodes, 0.5 * (low + high) / excess, TERMS - 1)), most


def fewer_joined(variances: Array, dof: Array) -> Callable[[Array, NDArray[np.intp]], Array]:
    """Return whether parts with the same degrees of freedom join to fewer than so many, without what they join to.

    Parameters
    ----------
    variances : ndarray, shape (parts, k)
        Of each part.
    dof : ndarray, shape (k,)
        Those of the sum that are asked about.

    Returns
    -------
    callable
        Of finite degrees of freedom of all parts, shape (n,), below those asked about, and the places of these among
        them: a number above 1 where they join to fewer, which falls steadily with them; infinite where they join to
        what each has, shape (n,).
    """
    from scipy import special  # noqa: PLC0415 - as in `joined_dof`

    p = 0.5 * (1.0 + P)
    whole = np.asarray(sum(variances), dtype=float)
    z_square = float(special.ndtri(p)) ** 2
    share = np.divide(variances, whole, out=np.zeros(variances.shape), where=(variances > 0.0) & (whole > 0.0))
    largest = special.stdtrit(dof, p) ** 2
    least = np.maximum(largest - z_square, NO_EXCESS)

    def beyond(each: Array, at: NDArray[np.intp]) -> Array:
        own = special.stdtrit(each, p) ** 2 - z_square
        excess = np.sum(share[:, at] ** np.maximum(1.0, 2.0 - FEW / each), axis=0) * own
        return np.asarray(np.where(excess >= own * (1.0 - SYMMETRY), np.inf, excess / least[at]))

    return beyond


@lru_cache(maxsize=256)
def _unknown_names(origin: Origin, unknowns: tuple[str, ...], count: int) -> tuple[str, ...]:
    """Return the names of the unknowns of a standard."""
    indices = unknowns or ("",) * (count == 1)
    texts = [" ".join(filter(None, (AFTER if origin.test else "", one))) for one in indices]
    name = f"{origin.standard}.{origin.quantity}"
    return tuple(f"{name}[{one}]" if one else name for one in texts)


@dataclass(frozen=True, eq=False)
class Component:
    """One source of uncertainty of all values at once."""

    given: Origin | str  # Where it comes from, or that in words: ``"scatter between power-up runs"``, ``"table rate"``
    kind: Literal["A", "B"]  # Observed scatter (A) or other knowledge (B)
    covariance: Array  # shape (k, k): contribution to the covariance of the values [unit_i unit_j]
    # shape (k,): degrees of freedom, per value or for all; infinite where the size is taken as known
    dof: Array | float = np.inf
    distribution: str = "normal"  # Of the underlying quantity: ``"normal"``, ``"rectangular"``, ``"t"``
    # Standard uncertainty of the underlying quantity itself, and its unit: 0.05 % of the table's rate. The
    # sensitivity of a value to it is ``u / stated``; where several unknowns of that size enter (two mounting
    # angles), the root sum of squares over them. Absent for scatter, which is observed in the values.
    stated: tuple[float, str] | None = None
    # shape (s, k): signed change of each value for one standard uncertainty of each of s independent unknowns,
    # where these are known: ``covariance = changes.T @ changes``. With them the difference of two results knows
    # what both share.
    changes: Array | None = None
    # One a row of ``changes``: which unknown of the influence it is, by what it belongs to and not by its place:
    # ``"xz"``; empty where there is one alone. Several without names are known to no other result.
    unknowns: tuple[str, ...] = ()
    # Curvature of the unit that its line does not have, ``"third_order_x"``: ``changes`` are then for one unit of it,
    # and ``stated`` is how large it may be; 0 where it is taken as none.
    term: str = ""

    @classmethod
    def of_own(cls, shared: Mapping[str, object], **fields: object) -> Component:
        """Return a source of all its fields; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(shared, **fields)
        return found

    def changed(self, **fields: object) -> Component:
        """Return the source with other values of some fields; ``dataclasses.replace`` takes several times as long."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        return found

    @property
    def named_changes(self) -> dict[str, Array]:
        """Changes of all values, shape (k,), by the unknown of a standard: ``"rate_table.mounting[xz]"``.

        Unknowns of what another test found and took off before say so: ``"site.latitude[after]"``.
        """
        origin = self.origin
        if self.changes is None or not origin.standard:
            return {}
        return dict(zip(_unknown_names(origin, self.unknowns, len(self.changes)), self.changes, strict=False))

    @property
    def origin(self) -> Origin:
        """Where it comes from."""
        return self.given if isinstance(self.given, Origin) else Origin(self.given)

    @property
    def influence(self) -> str:
        """Name of the influence under [standards] that it is of, ``"rate_table.rate"``; empty for others."""
        given = self.given
        return f"{given.standard}.{given.quantity}" if isinstance(given, Origin) and given.standard else ""

    @property
    def source(self) -> str:
        """The same in words, as budgets show it."""
        return str(self.given)

    @property
    def u(self) -> Array:
        """Standard uncertainty that this source alone gives, shape (k,)."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, eq=False)
class Sources:
    """One source of uncertainty of the same values of many units, each a `Component`."""

    given: Origin | str  # As that of a component, and so on
    kind: Literal["A", "B"]
    covariance: Array  # shape (u, k, k)
    dof: Array | float = np.inf  # shape (u, k)
    distribution: str = "normal"
    stated: tuple[float, str] | list[tuple[float, str] | None] | None = None  # of all, or one a unit
    changes: Array | None = None  # shape (u, s, k)
    unknowns: tuple[str, ...] = ()
    term: str = ""

    there: NDArray[np.bool_] | None = None  # shape (u,): which units have it; None for all
    counts: Sequence[int] | None = None  # of each unit: how many of the changes, the first ones, are its own; None: all

    @classmethod
    def of_changes(
        cls, given: Origin | str, changes: Array, dof: Array | float = np.inf, kind: Literal["A", "B"] = "B",
        distribution: str = "normal", stated: tuple[float, str] | None = None, unknowns: tuple[str, ...] = (),
    ) -> Sources:  # fmt: skip
        """Return a source by the changes of the values, (u, s, k), by one standard uncertainty of each unknown."""
        covariance = np.zeros((len(changes), changes.shape[2], changes.shape[2]))
        for row in changes.swapaxes(0, 1):  # in order: to the bit the same, whatever stands beside it
            covariance += row[:, :, None] * row[:, None]
        return cls(given, kind, covariance, dof, distribution, stated, changes, unknowns)

    @classmethod
    def of_influence(
        cls, given: Origin | str, changes: Array, one: Influence, unknowns: tuple[str, ...] = ()
    ) -> Sources:
        """Return that of an influence, by changes as above."""
        return cls.of_changes(given, changes, one.dof, "B", one.distribution, one.stated, unknowns)

    @property
    def plain(self) -> bool:
        """Whether a look at all units finds nothing that a check of each would refuse."""
        c, dof = self.covariance, self.dof
        variance = np.diagonal(c, axis1=1, axis2=2)
        stated: list[tuple[float, str] | None] = self.stated if isinstance(self.stated, list) else [self.stated]
        acts = (variance > 0.0).any(axis=1)
        return bool(
            (dof > 0.0 if isinstance(dof, float) else (dof > 0.0).all())
            and np.isfinite(c).all()
            and (variance >= 0.0).all()
            and (c == c.swapaxes(1, 2)).all()
            and not (acts & ~np.array([one is None or one[0] > 0.0 for one in stated])).any()
        )

    def each(self, sizes: Sequence[int]) -> list[Component | None]:
        """Return the source of each unit, of so many values."""
        own = {name: getattr(self, name) for name in ("given", "kind", "distribution", "unknowns", "term")}
        count, most = len(sizes), self.covariance.shape[1]
        dof = [self.dof] * count if isinstance(self.dof, float) else [*self.dof]
        stated = self.stated if isinstance(self.stated, list) else [self.stated] * count
        changes: list[Array | None] = [None] * count if self.changes is None else [*self.changes]
        if self.changes is not None and self.counts is not None:
            changes = [by[:n].copy() for by, n in zip(self.changes, self.counts, strict=True)]
        there = [True] * count if self.there is None else self.there.tolist()
        found: list[Component | None] = []
        for k, c, free, its, by, has in zip(sizes, self.covariance, dof, stated, changes, there, strict=True):
            if not has:
                found.append(None)
            elif k == most:
                found.append(Component.of_own(own, covariance=c, dof=free, stated=its, changes=by))
            else:
                few = None if by is None else by[:, :k].copy()
                less = free if isinstance(free, float) else free[:k].copy()
                found.append(Component.of_own(own, covariance=c[:k, :k].copy(), dof=less, stated=its, changes=few))
        return found


@lru_cache(maxsize=256)  # the same of all units that are tested alike
def _named(given: tuple[Key | str, ...]) -> tuple[tuple[Key, ...], tuple[str, ...], Mapping[Key | str, int]]:
    """Return what values are of, the same as text, and the position of each by both."""
    names = tuple(str(one) for one in given)
    places = {name: at for each in (names, given) for at, name in enumerate(each)}
    return tuple(one if isinstance(one, Key) else Key(one) for one in given), names, MappingProxyType(places)


@dataclass(frozen=True, eq=False)
class Estimate:
    """Named values with covariance, degrees of freedom and units.

    Raises
    ------
    DataError
        If shapes disagree, a name appears twice, a covariance is not symmetric with a non-negative
        diagonal, or degrees of freedom are not positive.
    """

    given: tuple[Key | str, ...]  # One a value: what it is, or a name that stands for a quantity without axis
    values: Array  # shape (k,): in ``units``
    units: tuple[str, ...]  # One a value, as ``core.units`` prints them
    components: tuple[Component, ...]  # Sources of uncertainty; their covariances add

    def __post_init__(self) -> None:
        k = len(self.names)
        if np.shape(self.values) != (k,) or len(self.units) != k:
            raise DataError(f"{k} names, values of shape {np.shape(self.values)}, {len(self.units)} units")
        if len(set(self.names)) != k:
            raise DataError(f"a name appears twice in {self.names}")
        for component in self.components:
            if component.covariance.shape != (k, k):
                shape = component.covariance.shape
                raise DataError(f"{component.source}: covariance of shape {shape}, need ({k}, {k})")
            dof = component.dof
            alike = isinstance(dof, float) or np.shape(dof) in {(), (k,)}
            if not (alike and (dof > 0.0 if isinstance(dof, float) else (np.asarray(dof, dtype=float) > 0.0).all())):
                raise DataError(
                    f"{component.source}: degrees of freedom {component.dof}, need {k} positive ones or one for all"
                )
        if self.components:
            self._check_covariances()

    @classmethod
    def of_own(
        cls, given: tuple[Key, ...], values: Array, units: tuple[str, ...], components: tuple[Component, ...]
    ) -> Estimate:
        """Return the same of parts of estimates that were checked: nothing is checked again."""
        found = object.__new__(cls)
        found.__dict__.update(given=given, values=values, units=units, components=components)
        return found

    @classmethod
    def of_each(
        cls, given: Sequence[tuple[Key, ...]], values: Array, units: Sequence[tuple[str, ...]],
        sources: Sequence[Sources], checked: bool = False,
    ) -> list[Estimate | DataError]:  # fmt: skip
        """Return the estimates of several units at once, or why there is none: each as alone.

        What they are asked first is known already: covariance, u and degrees of freedom.

        Parameters
        ----------
        given, units : sequence of tuple
            As `Estimate` has them, unit by unit.
        values : ndarray, shape (u, k)
            Those of a unit come first; k is the largest number of them. Covariances and changes of the rest are 0.
        sources : sequence of Sources
            All that any unit has.
        checked : bool
            Whether all are sums of sources of estimates, which were checked.
        """
        count, k = values.shape
        sizes = [len(one) for one in given]
        columns = zip(*(one.each(sizes) for one in sources), strict=True)
        made = [
            cls.of_own(keys, row[: len(keys)], its, tuple([part for part in own if part is not None]))
            for keys, row, its, own in zip(given, values, units, columns, strict=True)
        ]
        total = np.zeros((count, k, k))
        for one in sources:
            total += one.covariance
        variances = [np.diagonal(one.covariance, axis1=1, axis2=2) for one in sources]
        whole = np.diagonal(total, axis1=1, axis2=2)
        alike = {id(one): one for one in given}.values()  # of many units the same
        named = all(len(set(one)) == len(one) for one in alike)
        if not (named and (checked or all(one.plain for one in sources))):
            return [one.checked() for one in made]
        u, dof = np.sqrt(whole), joined_dof(variances, [one.dof for one in sources], whole)
        total.flags.writeable = u.flags.writeable = dof.flags.writeable = False
        for i, (each, n) in enumerate(zip(made, sizes, strict=True)):
            each.__dict__.update(covariance=total[i, :n, :n], u=u[i, :n], dof=dof[i, :n])
        return list(made)

    def checked(self) -> Estimate | DataError:
        """Return it, or why it cannot be."""
        try:
            self.__post_init__()
        except DataError as error:
            return error
        return self

    def _check_covariances(self) -> None:
        c: Array = np.array([component.covariance for component in self.components])
        variance = np.diagonal(c, axis1=1, axis2=2)
        plain = np.isfinite(c).all() and (variance >= 0.0).all() and (c == c.swapaxes(1, 2)).all()
        if plain and not any(one.stated is not None and not one.stated[0] > 0.0 for one in self.components):
            return
        deviations = np.sqrt(np.abs(variance))
        with np.errstate(invalid="ignore"):
            allowed = SYMMETRY * deviations[:, :, np.newaxis] * deviations[:, np.newaxis] + TINY
            skew = (variance < 0.0).any(axis=1) | (np.abs(c - c.swapaxes(1, 2)) > allowed).any(axis=(1, 2))
        acts = np.any(variance > 0.0, axis=1)
        is_finite = np.all(np.isfinite(c), axis=(1, 2)).tolist()
        for component, bad, active, finite in zip(
            self.components, np.atleast_1d(skew), np.atleast_1d(acts), is_finite, strict=True
        ):
            if not finite:
                raise DataError(f"{component.source}: covariance is not finite", do="Leave out what is not estimated")
            if bad:
                raise DataError(f"{component.source}: not a covariance (negative variance or not symmetric)")
            if active and component.stated is not None and not component.stated[0] > 0.0:
                raise DataError(f"{component.source}: contributes, but its own uncertainty is {component.stated[0]:g}")

    @cached_property
    def keys(self) -> tuple[Key, ...]:
        """What each value is of."""
        return _named(self.given)[0]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Keys as text, to be shown and printed."""
        return _named(self.given)[1]

    @cached_property
    def covariance(self) -> Array:
        """Sum of the components, shape (k, k); read-only."""
        k = len(self.names)
        total = np.zeros((k, k))
        for component in self.components:
            total += component.covariance
        total.flags.writeable = False
        return total

    @cached_property
    def u(self) -> Array:
        """Standard uncertainties, shape (k,); read-only."""
        found = np.sqrt(np.diag(self.covariance))
        found.flags.writeable = False
        return found

    @cached_property
    def dof(self) -> Array:
        """Degrees of freedom whose t gives the interval, shape (k,); infinite where all sources are known."""
        variances = [component.covariance.diagonal() for component in self.components]
        return joined_dof(variances, [component.dof for component in self.components], self.covariance.diagonal())

    @cached_property
    def _by_unknown(self) -> dict[str, Array]:
        found: dict[str, Array] = {}
        for one in self.components:
            for unknown, changes in one.named_changes.items():
                found[unknown] = found[unknown] + changes if unknown in found else np.asarray(changes, dtype=float)
        return found

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Unknowns of standards, by name."""
        return tuple(self._by_unknown)

    @cached_property
    def changes(self) -> Array:
        """Change of each value by one standard uncertainty of each of the `unknowns`, shape (s, k)."""
        return np.array([*self._by_unknown.values()]).reshape(len(self._by_unknown), len(self.names))

    @cached_property
    def _curved(self) -> list[tuple[str, list[float], float]]:
        """Curvatures of the unit: the changes of all values by one unit of each, and how large it may be."""
        return [
            (one.term, one.changes[0].tolist(), float(one.stated[0]))
            for one in self.components
            if one.term and one.stated is not None and one.changes is not None
        ]

    def shared(self, name: Key | str, times: float = 1.0) -> dict[str, float]:
        """Return the change of a value for one standard uncertainty of each unknown of a standard, with its sign.

        Unknowns go by the name of their influence: ``"rate_table.rate"``; of several, ``"rate_table.mounting[xz]"``.
        """
        return self.shared_at(self.index(name), times)

    def shared_at(self, at: int, times: float = 1.0) -> dict[str, float]:
        """Return the same of the value at a place."""
        return dict(zip(self.unknowns, (0.0 + self.changes[:, at] * times).tolist(), strict=True))

    def curvature(self, name: Key | str, times: float = 1.0) -> dict[str, Curvature]:
        """Return what one unit of each curvature of the unit would change of a value whose line does not have it."""
        return self.curvature_at(self.index(name), times)

    def curvature_at(self, at: int, times: float = 1.0) -> dict[str, Curvature]:
        """Return the same of the value at a place."""
        found: dict[str, Curvature] = {}
        for term, changes, size in self._curved:
            change = changes[at] * times
            if change or term[-1:] == self.keys[at].axis[:1]:
                found[term] = Curvature(change, size)
        return found

    def index(self, name: Key | str) -> int:
        """Position of a value.

        Raises
        ------
        DataError
            If there is none of that name; the message lists those there are.
        """
        try:
            return self._places[name if name in self._places else str(name)]
        except KeyError:
            raise DataError(f"no value {str(name)!r}", do=f"There are: {', '.join(self.names)}") from None

    @cached_property
    def _places(self) -> Mapping[Key | str, int]:
        """Position of each value by its name and by its key."""
        return _named(self.given)[2]

    def value(self, name: Key | str) -> float:
        """One value, in its unit."""
        return float(self.values[self.index(name)])

    def select(self, names: Sequence[Key | str]) -> Estimate:
        """Return the estimate of some of the values, in the order given."""
        at = [self.index(name) for name in names]
        if at == [*range(len(self.values))]:
            return self
        grid = np.ix_(at, at)
        components = tuple(
            one.changed(
                covariance=one.covariance[grid],
                dof=(one.dof[at] if isinstance(one.dof, np.ndarray) else one.dof),
                changes=None if one.changes is None else one.changes[:, at],
            )
            for one in self.components
        )
        given, units = (tuple([of[i] for i in at]) for of in (self.given, self.units))
        return changed(self, given=given, values=self.values[at], units=units, components=components)

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame: a row a value, with ``value``, ``u``, ``unit`` and ``dof``."""
        return frame(
            {"value": self.values, "u": self.u, "unit": list(self.units), "dof": self.dof},
            index=list(self.names),
        )

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a value, rounded to its uncertainty."""
        columns = zip(self.names, self.values, self.u, self.units, self.dof, strict=True)
        rows = [(name, with_uncertainty(v, u), unit, dof(d) if u > 0.0 else "-") for name, v, u, unit, d in columns]
        sources = ", ".join(
            component.source for component in self.components if component.u.any() or not component.term
        )
        caption = f"{len(self.names)} value(s); uncertainty from: {sources or 'nothing stated'}"
        return (Table(("name", "value ± u", "unit", "dof"), rows, caption, (1, 3)),)

    def __str__(self) -> str:
        """Return a table with a row a value."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the same table for a notebook."""
        return html(self.parts())
