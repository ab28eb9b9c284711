"""What the rates of a test decide by themselves: the same for all units that were turned alike.

A production line turns every unit by one programme. Designs of lines, their decompositions, recordings, runs, and which
curvatures the rates tell apart depend on rates, axes and labels alone; they are made once and remembered by what these
arrays hold.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...signals.remembered import remembered
from ...statistics.least_squares import Decomposed, decompose
from ...statistics.own_offsets import OffsetDesign, offset_design
from ...statistics.random_offsets import whitened

POWERS = {"K2": 2, "K3": 3}
WORDS = {"K2": "second-order term", "K3": "third-order term"}
MOST = 100  # choices of rows that are kept in order of rate
LIKE = 0.2  # relative difference of largest rates up to which runs are compared
ROUNDING = 1e-9  # part of a column that varies beside the lines of the recordings, below which it does not
APART = 0.02  # part of a term's column that the other columns do not explain, from which on it is told apart


class LineDesign:
    """Design of a line: its columns, and what a fit takes of them.

    Parameters
    ----------
    turned : Turned
        The rates.
    sensor, asymmetry, curvature
        Of the line.
    """

    def __init__(self, turned: Turned, sensor: str, asymmetry: bool, curvature: tuple[str, ...]) -> None:
        self.turned, self.sensor, self.asymmetry, self.curvature = turned, sensor, asymmetry, curvature
        x = {axis: np.where(turned.axis == axis, turned.applied, 0.0) for axis in turned.axes}
        self.columns, self.words = columns_of(x, sensor, asymmetry, curvature)  # (n, p), in words

    @cached_property
    def plain(self) -> Decomposed | DataError:
        """With one intercept and equal weights; the refusal where the rates do not tell the coefficients apart.

        Of as many dwells as coefficients, or more.
        """
        if not np.isfinite(self.columns).all():
            return DataError(
                "rates that are not finite", do="Leave out what is missing, and count it", code="not_finite"
            )
        try:
            return decompose(self.columns, self.words)
        except DataError as error:
            return error

    @cached_property
    def own(self) -> OffsetDesign | None:
        """With an intercept of its own in each recording, and equal weights; None where that cannot be."""
        return self.own_weighed(None)

    def own_weighed(self, weights: Array | None) -> OffsetDesign | None:
        """Return the same with weights, shape (n,)."""
        return offset_design(self.columns[:, 1:], self.turned.groups, self.turned.clusters, weights)

    @cached_property
    def beside_lines(self) -> tuple[Array, float]:
        """Basis, (n, q), of what varies beside a line of each recording; degrees of freedom beside both."""
        groups, applied = self.turned.numbers, self.turned.applied
        columns = np.column_stack([self.turned.beside(column) for column in self.columns[:, 1:].T])
        size = np.linalg.norm(columns, axis=0)
        varies = size > ROUNDING * np.linalg.norm(self.columns[:, 1:], axis=0)
        basis, singular, _ = np.linalg.svd(columns[:, varies] / size[varies], full_matrices=False)
        basis = basis[:, singular > ROUNDING]
        slopes = np.count_nonzero(np.bincount(groups, about_means(applied, groups) ** 2))
        return basis, float(len(groups) - np.max(groups) - 1 - slopes - basis.shape[1])

    @cached_property
    def within_runs(self) -> Array:
        """Orthonormal basis of what varies within the runs, shape (n, q): no offset of a run can take it up."""
        at = self.turned.of_run
        within = whitened(self.columns, np.ones(len(at)), at, np.inf)
        left, singular, _ = np.linalg.svd(within, full_matrices=False)
        size = np.hypot(np.linalg.norm(self.columns), np.sqrt(np.max(np.bincount(at))))
        return np.asarray(left[:, singular > size * 1e-10])


class RunAbout(NamedTuple):
    """A run about one axis: its recording, its label, the axis, its rows; whether its recording has others."""

    recording: str
    run: str
    axis: str
    at: NDArray[np.intp]
    several: bool


class Highest(NamedTuple):
    """Of some rows the largest size of rate, how many sizes there are, and the two highest rates of each way.

    Those of the negative way first: of each the rate and its rows, the higher first.
    """

    rows: NDArray[np.intp]
    largest: float
    sizes: int
    ways: tuple[tuple[tuple[float, NDArray[np.intp]], tuple[float, NDArray[np.intp]]], ...]


class LikeRows(NamedTuple):
    """Rows of sets of runs that are alike, shape (sets, rows), and those at one rate each, (sets, rates, rows)."""

    rows: NDArray[np.intp]
    at_rates: list[NDArray[np.intp]]


class Turned:
    """Rates of dwells, shape (n,), with axes turned, runs and recordings.

    Parameters
    ----------
    applied : ndarray, shape (n,)
        Rates [rad/s].
    axis : ndarray of str, shape (n,)
        Axis turned.
    run, recording : ndarray of str, shape (n,), or None
        As `Readings` has them.
    """

    def __init__(
        self, applied: Array, axis: NDArray[Any], run: NDArray[Any] | None, recording: NDArray[Any] | None
    ) -> None:
        self.applied, self.axis = applied.copy(), axis.copy()
        self.axes = tuple(str(one) for one in np.unique(axis))
        runs, self.of_run = (
            (np.zeros(0), np.zeros(0, dtype=np.intp))
            if run is None or np.all(run == "")
            else np.unique(run, return_inverse=True)
        )
        self.runs = len(runs)
        label = run if self.runs else recording
        names = np.full(len(axis), "") if label is None else label
        pairs = zip(names.tolist(), axis.tolist(), strict=True)
        self.groups = np.array([f"{one} {about}" for one, about in pairs])  # recording of each dwell
        self.clusters = names.copy() if self.runs else self.groups  # its power-up, or the recording
        self.numbers = np.unique(self.groups, return_inverse=True)[1]
        blank = np.full(len(axis), "")
        self._recording, self._run = (blank if one is None else one.copy() for one in (recording, run))
        self._lines: dict[tuple[str, bool, tuple[str, ...]], LineDesign] = {}
        self._highest: dict[bytes, Highest | None] = {}
        self._at_rates: dict[bytes, list[NDArray[np.intp]]] = {}
        self._sets_alike: dict[float, list[tuple[NDArray[np.intp], LikeRows]]] = {}
        self._beside_basis: dict[str, tuple[Array, Array]] = {}
        self._spread: Array | None = None
        self._tells_asymmetry: dict[str, bool] = {}
        self._straight: dict[bytes, Decomposed] = {}
        self._neighbours: dict[tuple[str, int], NDArray[np.intp]] = {}
        self._allowed: dict[tuple[str, bool, bool, float], tuple[str, ...]] = {}
        self._spans: dict[str, tuple[float, float]] = {}

    def line(self, sensor: str, asymmetry: bool, curvature: tuple[str, ...] = ()) -> LineDesign:
        """Return the design of a line of a sensor."""
        key = sensor, asymmetry, curvature
        if key not in self._lines:
            self._lines[key] = LineDesign(self, *key)
        return self._lines[key]

    def span(self, axis: str) -> tuple[float, float]:
        """Return the lowest and the highest rate that an axis was turned at, or 0 [rad/s]; 0 where it was not."""
        if axis not in self._spans:
            rates = self.applied[self.axis == axis]
            self._spans[axis] = float(np.fmin.reduce(rates, initial=0.0)), float(np.fmax.reduce(rates, initial=0.0))
        return self._spans[axis]

    @cached_property
    def runs_about(self) -> tuple[RunAbout, ...]:
        """Its runs about each axis, in order."""
        rows: dict[tuple[str, str, str], list[int]] = {}
        labels = zip(self._recording.tolist(), self._run.tolist(), self.axis.tolist(), strict=True)
        for i, label in enumerate(labels):
            rows.setdefault(label, []).append(i)
        return tuple(
            RunAbout(*label, np.array(at), bool(np.count_nonzero(self._recording == label[0]) > len(at)))
            for label, at in rows.items()
        )

    @cached_property
    def run_numbers(self) -> NDArray[np.intp]:
        """Number of the run about an axis of each dwell, shape (n,)."""
        numbers = np.empty(len(self.axis), dtype=np.intp)
        for i, one in enumerate(self.runs_about):
            numbers[one.at] = i
        return numbers

    @cached_property
    def like_runs(self) -> tuple[tuple[int, ...], ...]:
        """Runs about one axis at like rates, by number."""
        ends = [np.array([np.min(x), np.max(x)]) for x in (self.applied[one.at] for one in self.runs_about)]
        found: list[list[int]] = []
        for i, one in enumerate(self.runs_about):
            for like in found:
                first = like[0]
                alike = np.all(np.abs(ends[i] - ends[first]) <= LIKE * np.max(np.abs(ends[first])))
                if self.runs_about[first].axis == one.axis and alike:
                    like.append(i)
                    break
            else:
                found.append([i])
        return tuple(tuple(one) for one in found)

    @cached_property
    def run_lengths(self) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp]], ...]:
        """Runs about an axis of one length: their numbers, shape (r,), and rows, shape (r, length)."""
        lengths: dict[int, list[int]] = {}
        for i, one in enumerate(self.runs_about):
            lengths.setdefault(len(one.at), []).append(i)
        return tuple((np.array(at), np.array([self.runs_about[i].at for i in at])) for at in lengths.values())

    @cached_property
    def set_of_run(self) -> NDArray[np.intp]:
        """Number of the set of like runs that each run is of, shape (runs,)."""
        numbers = np.empty(len(self.runs_about), dtype=np.intp)
        for k, one in enumerate(self.like_runs):
            numbers[list(one)] = k
        return numbers

    @cached_property
    def rows_of_sets(self) -> tuple[NDArray[np.intp], ...]:
        """Rows of each set of like runs, run after run."""
        return tuple(np.concatenate([self.runs_about[i].at for i in one]) for one in self.like_runs)

    @cached_property
    def set_lengths(self) -> tuple[tuple[NDArray[np.intp], NDArray[np.intp]], ...]:
        """Sets of as many like runs: their numbers, shape (s,), and runs, shape (s, length)."""
        lengths: dict[int, list[int]] = {}
        for k, one in enumerate(self.like_runs):
            lengths.setdefault(len(one), []).append(k)
        return tuple((np.array(at), np.array([self.like_runs[k] for k in at])) for at in lengths.values())

    def sets_alike(self, step: float) -> list[tuple[NDArray[np.intp], LikeRows]]:
        """Return the numbers of sets of as many like runs, with their rows at as many rates, up to a step."""
        if step not in self._sets_alike:
            kinds: dict[tuple[object, ...], list[int]] = {}
            rates = [self.at_rates(rows, step) for rows in self.rows_of_sets]
            for k, (one, rows) in enumerate(zip(self.like_runs, self.rows_of_sets, strict=True)):
                kinds.setdefault((len(one), len(rows), *(same.shape for same in rates[k])), []).append(k)
            self._sets_alike[step] = [
                (np.array(at), LikeRows(np.array([self.rows_of_sets[k] for k in at]),
                                        [np.array(same) for same in zip(*(rates[k] for k in at), strict=True)]))
                for at in kinds.values()
            ]  # fmt: skip
        return self._sets_alike[step]

    def spread_in_runs(self, read: NDArray[np.bool_]) -> Array:
        """Return the sum of squares of the rates that were read about their mean, run by run, shape (runs,)."""
        whole = bool(read.all())
        if whole and self._spread is not None:
            return self._spread
        numbers, x, runs = self.run_numbers[read], self.applied[read], len(self.runs_about)
        count = np.maximum(np.bincount(numbers, minlength=runs), 1)
        away = x - (np.bincount(numbers, x, runs) / count)[numbers]
        found = np.asarray(np.bincount(numbers, away**2, runs), dtype=float)
        if whole:
            self._spread = found
        return found

    def highest(self, rows: NDArray[np.intp]) -> Highest | None:
        """Return the highest rates of rows; None where one way has fewer than two."""
        key = rows.tobytes()
        if key not in self._highest:
            x = self.applied[rows]
            ways = []
            for way in (-1.0, 1.0):
                rates = way * np.unique(np.abs(x[np.sign(x) == way]))[::-1][:2]
                ways.append([(float(rate), rows[x == rate]) for rate in rates])
            two = [(one[0], one[1]) for one in ways if len(one) == 2]
            if len(self._highest) > MOST:
                self._highest.clear()
            sizes = np.unique(np.abs(x))
            self._highest[key] = Highest(rows, float(sizes[-1]), len(sizes), tuple(two)) if len(two) == 2 else None
        return self._highest[key]

    def at_rates(self, rows: NDArray[np.intp], step: float) -> list[NDArray[np.intp]]:
        """Return rows at one rate each, up to a step of the largest: by how many they are, shape (rates, rows)."""
        key = rows.tobytes() + f"{step}".encode()
        if key not in self._at_rates:
            x = self.applied[rows]
            numbers = np.unique(np.round(x / (step * float(np.max(np.abs(x))) or 1.0)), return_inverse=True)[1]
            lengths: dict[int, list[NDArray[np.intp]]] = {}
            for k in range(int(numbers.max()) + 1):
                same = rows[numbers == k]
                lengths.setdefault(len(same), []).append(same)
            if len(self._at_rates) > MOST:
                self._at_rates.clear()
            self._at_rates[key] = [np.array(one) for one in lengths.values()]
        return self._at_rates[key]

    @cached_property
    def rates(self) -> Mapping[str, tuple[Array, Array]]:
        """By axis, its rates in order, shape (r,), and the weights of the mean of the dwells at each, shape (r, n)."""
        found = {}
        for axis in self.axes:
            own = self.axis == axis
            rates = np.unique(self.applied[own])
            at = own & (self.applied == rates[:, None])
            found[axis] = rates, at / np.sum(at, axis=1, keepdims=True)
        return found

    def beside_basis(self, axis: str, basis: Array) -> Array:
        """Return the variance of the mean at each rate about an axis beside offsets of recordings and a basis, (r,).

        Over that of a dwell; the basis, shape (n, q), is orthonormal, and has no offset of a recording.
        """
        known = self._beside_basis.get(axis)
        if known is None or known[0] is not basis:
            beside = about_means(self.rates[axis][1], self.numbers)
            left = np.maximum(np.sum(beside**2, axis=1) - np.sum((beside @ basis) ** 2, axis=1), 0.0)
            known = self._beside_basis[axis] = basis, left
        return known[1]

    @cached_property
    def shared_rates(self) -> Mapping[str, bool]:
        """By axis, whether each of its rates belongs to half of the recordings about it or more."""
        found = {}
        for axis in self.axes:
            own = self.axis == axis
            rates = np.unique(self.applied[own], return_inverse=True)[1]
            recordings, numbers = np.unique(self.groups[own], return_inverse=True)
            pairs = np.unique(np.column_stack([rates, numbers]), axis=0)
            found[axis] = bool(2 * np.min(np.bincount(pairs[:, 0])) >= len(recordings))
        return found

    @cached_property
    def _about_means(self) -> tuple[Array, Array]:
        """Rates about the mean of their recording, shape (n,), and the sum of their squares in each, 1 for 0."""
        x = about_means(self.applied, self.numbers)
        square = np.bincount(self.numbers, x**2)
        return x, np.where(square > 0.0, square, 1.0)

    def beside(self, values: Array) -> Array:
        """Return values, shape (..., n), less a line in the rate of its own in each recording."""
        x, square = self._about_means
        slope = group_sums(values * x, self.numbers) / square
        return np.asarray(about_means(values, self.numbers) - slope[..., self.numbers] * x)

    def straight(self, rows: NDArray[np.bool_]) -> Decomposed:
        """Return a line through the readings at some rates, all alike."""
        key = rows.tobytes()
        if key not in self._straight:
            if len(self._straight) > MOST:
                self._straight.clear()
            x = self.applied[rows]
            self._straight[key] = decompose(np.column_stack([x, np.ones_like(x)]), ("scale_factor", "intercept"))
        return self._straight[key]

    def neighbours(self, axis: str, count: int) -> NDArray[np.intp]:
        """Return the nearest others of each dwell about an axis in size of rate, shape (dwells about it, count).

        The earlier rows first where several are equally near. For more dwells than that.
        """
        if (axis, count) not in self._neighbours:
            self._neighbours[axis, count] = nearest(np.abs(self.applied[self.axis == axis]), count)
        return self._neighbours[axis, count]

    def tells_asymmetry(self, sensor: str) -> bool:
        """Return True where the sensor's own axis was turned both ways at two or more rates each, or with rest."""
        if sensor not in self._tells_asymmetry:
            rates = np.unique(self.applied[self.axis == sensor])
            positive, negative = np.count_nonzero(rates > 0.0), np.count_nonzero(rates < 0.0)
            self._tells_asymmetry[sensor] = bool(min(positive, negative) >= 1 and len(rates) >= 3)
        return self._tells_asymmetry[sensor]

    def allowed(self, sensor: str, asymmetry: bool, own: bool, spare: float) -> tuple[str, ...]:
        """Return the curvatures that the rates tell apart from the other coefficients, and from each other.

        Parameters
        ----------
        sensor : str
            Axis of the sensor.
        asymmetry : bool
            Whether the line has a coefficient of it.
        own : bool
            Whether recordings have intercepts of their own.
        spare : float
            Degrees of freedom of the line.
        """
        key = sensor, asymmetry, own, spare
        if key not in self._allowed:
            self._allowed[key] = self._told_apart(*key)
        return self._allowed[key]

    def _told_apart(self, sensor: str, asymmetry: bool, own: bool, spare: float) -> tuple[str, ...]:
        found: tuple[str, ...] = ()
        numbers = self.numbers if own else np.zeros_like(self.numbers)
        for name in POWERS if sensor in self.axes else ():
            columns = self.line(sensor, asymmetry, (*found, name)).columns[:, 1:]
            within = whitened(columns, np.ones(len(columns)), numbers, np.inf)
            size = np.linalg.norm(within, axis=0)
            if spare < 2.0 or not np.all(size > 0.0):
                continue
            unit = within / size
            left = unit[:, -1] - unit[:, :-1] @ np.linalg.lstsq(unit[:, :-1], unit[:, -1], rcond=None)[0]
            if np.linalg.norm(left) > APART:
                found, spare = (*found, name), spare - 1.0
        return found


@remembered
def turned(applied: Array, axis: NDArray[Any], run: NDArray[Any] | None, recording: NDArray[Any] | None) -> Turned:
    """Return what the rates of dwells decide: once for the same rates, axes, runs and recordings."""
    return Turned(applied, axis, run, recording)


def columns_of(
    x: Mapping[str, Array], sensor: str, asymmetry: bool, curvature: tuple[str, ...]
) -> tuple[Array, list[str]]:
    """Return the columns of a line for rates about its axes, and their names in words."""
    columns = [np.ones(len(next(iter(x.values())))), *x.values()]
    names = ["bias", *(f"matrix entry {sensor}{axis}" for axis in x)]
    if asymmetry:
        columns.append(np.abs(x[sensor]))
        names.append("asymmetry")
    for name in curvature:
        columns.append(x[sensor] ** POWERS[name])
        names.append(WORDS[name])
    return np.column_stack(columns), names


def about_means(values: Array, groups: NDArray[np.intp]) -> Array:
    """Return values, shape (..., n), less the mean of their group, numbered from 0."""
    return np.asarray(values - (group_sums(values, groups) / np.bincount(groups))[..., groups])


def group_sums(values: Array, groups: NDArray[np.intp]) -> Array:
    """Return the sums of values, shape (..., n), of each group, numbered from 0: shape (..., g)."""
    counts = np.bincount(groups)
    order = np.argsort(groups, kind="stable")
    return np.asarray(np.add.reduceat(values[..., order], np.cumsum(counts) - counts, axis=-1))


def nearest(sizes: Array, count: int) -> NDArray[np.intp]:
    """Return the nearest others of each of n sizes, shape (n, count), the earlier ones first where equally near."""
    order = np.argsort(sizes, kind="stable")
    reach = np.concatenate([np.arange(-count, 0), np.arange(1, count + 1)])
    places = np.arange(len(sizes))[:, None] + reach[None, :]
    inside = (places >= 0) & (places < len(sizes))
    places = np.clip(places, 0, len(sizes) - 1)
    distance = np.where(inside, np.abs(sizes[order][:, None] - sizes[order][places]), np.inf)
    chosen = np.argsort(distance, axis=1, kind="stable")[:, :count]
    near = np.empty((len(sizes), count), dtype=np.intp)
    near[order] = order[np.take_along_axis(places, chosen, axis=1)]
    return near
