"""Many triads at once: scale factors, misalignments and biases from what each read at rest in some positions.

The forward equation is that of ``sensors.model`` without the terms that rest cannot tell::

    r = b + M f                 row = the sensor that reads, column = the axis that moves

Where only the size of gravity is known, ``|f| = g``, nobody can tell M from M times a rotation: nine parameters remain.
Here M is triangular. ``lower`` makes the x sensor the x axis, with the y sensor in the plane of x and y; ``upper``
makes the z sensor the z axis, with the y sensor in the plane of y and z. What is made small is ``|M^-1 (r - b)| - g``.
Where f is known in each position, all twelve are determined, and the estimate is linear.

Positions with a NaN are missing, in that unit alone. The uncertainty is that of the scatter between positions, or of a
scatter that is given; what all positions share (gravity, the frame of known positions) is not in it.
No figure depends on the number of threads or on the other units.

References
----------
.. [1] Frosio, Pedersini and Borghese, IEEE Trans. Instrum. Meas. 58 (2009) 2034-2041 (``|f| = g`` at rest).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError, UsageError
from ...core.estimate import Array, Component, Estimate
from ...core.key import AXES
from ...core.remarks import Remark
from ...core.show.frames import frame
from ...core.show.result_tables import remarks_line
from ...core.show.rounding import near, uncertainty
from ...core.show.tables import Block, Table, html, text
from ...files.memory import numbers_of

if TYPE_CHECKING:
    from pandas import DataFrame

Form = Literal["lower", "upper"]
CHUNK = 256  # units that a thread takes at once
WORKERS = os.cpu_count() or 1  # threads; no result depends on their number
NORM, KNOWN = 9, 12  # parameters
OK, FEW, NO_SCATTER, ILL_POSED, NOT_CONVERGED, OTHER_UNIT = range(6)
LARGEST_CONDITION = 1e4  # of the Jacobian in units of gravity; recordings held by hand have 2 to 1,300
UNIT_SLIP = 3.0  # readings this many times too long or too short are in another unit
BY_LENGTH = 9  # parameters, where only the size of gravity is known
SOURCE = "scatter between positions"
STATUS = (
    "estimated",
    "too few positions: fewer than parameters",
    "as many positions as parameters: no scatter, so no uncertainty",
    "the positions cannot tell all parameters apart",
    "the search did not settle",
    "the readings are not near gravity in size: another unit?",
)
CODES = ("", "too_few_positions", "no_scatter", "ill_posed", "not_converged", "unit_slip")
WAYS_OUT = (
    "",
    "Add positions",
    "Add positions, or give the scatter of a position",
    "Add positions with gravity between the axes",
    "Look at these readings for outliers",
    "Convert the readings to the unit of gravity",
)


def positions_batch(
    readings: ArrayLike,
    gravity: ArrayLike,
    *,
    directions: ArrayLike | None = None,
    scatter: float | None = None,
    form: Form = "lower",
) -> PositionsBatch:
    """Calibrate many triads from their mean readings at rest.

    Parameters
    ----------
    readings : array_like, shape (units, positions, 3) or (positions, 3)
        Mean of each position [m/s2], nominal scale factor and offset taken off; NaN is missing.
    gravity : float or array_like, shape (units,)
        Local gravity [m/s2].
    directions : array_like, shape (positions, 3), optional
        Where the specific force points in each position, in body axes: up, at rest. With them all twelve parameters are
        estimated; otherwise nine, from ``|f| = g``.
    scatter : float, optional
        Standard uncertainty of one reading of one position, known beforehand [m/s2]. By default it is estimated in
        each unit from its residuals.
    form : {"lower", "upper"}
        Shape of M where directions are unknown.

    Returns
    -------
    PositionsBatch
        A row a unit; ``status`` tells which have no estimate, and why.

    Raises
    ------
    UsageError
        ``bad_argument`` for shapes that do not fit, gravity or scatter that is not positive.
    DataError
        ``ill_posed`` if the directions cannot tell the parameters apart, in any unit.
    """
    r, g = _checked(readings, gravity, scatter)
    if form not in ("lower", "upper"):
        raise UsageError(f"form {form!r}: no such form", do="Use lower or upper", code="bad_argument")
    if directions is not None:
        rows, m = np.asarray(directions, dtype=np.float64), r.shape[1]
        lengths = np.linalg.norm(rows, axis=-1, keepdims=True) if rows.ndim == 2 else np.zeros(1)
        if rows.shape != (m, 3) or not np.all(lengths > 0.0):
            what = f"directions of shape {rows.shape} for {m} positions: need ({m}, 3), none of length zero"
            raise UsageError(what, code="bad_argument")
        return _known(r, g, np.asarray(rows / lengths), scatter)
    return _norms(r, g, scatter, form)


def _checked(readings: ArrayLike, gravity: ArrayLike, scatter: float | None) -> tuple[Array, Array]:
    r = numbers_of(readings).astype(np.float64, copy=False)
    r = r[np.newaxis] if r.ndim == 2 else r
    if r.ndim != 3 or r.shape[2] != 3:
        raise UsageError(
            f"readings of shape {np.shape(readings)}: need (units, positions, 3)",
            do="Give the mean of each position, three sensors a row",
            code="bad_argument",
        )
    g = np.asarray(gravity, dtype=np.float64)
    if g.ndim > 1 or (g.ndim == 1 and len(g) != len(r)) or not np.all(np.isfinite(g) & (g > 0.0)):
        raise UsageError(
            f"gravity of shape {g.shape} for {len(r)} unit(s): need one positive value, or one a unit",
            code="bad_argument",
        )
    if scatter is not None and not (np.isfinite(scatter) and scatter > 0.0):
        raise UsageError(f"scatter {scatter!r}: need a positive number [m/s2]", code="bad_argument")
    return r, np.broadcast_to(g, (len(r),))


def _shared(work: Callable[[slice], None], n: int) -> None:
    """Do the work on lots of units, shared by threads."""
    if n <= CHUNK:
        work(slice(0, n))
        return
    with ThreadPoolExecutor(WORKERS) as pool:
        list(pool.map(work, (slice(start, min(start + CHUNK, n)) for start in range(0, n, CHUNK))))


def _norms(r: Array, g: Array, scatter: float | None, form: Form) -> PositionsBatch:
    """Nine parameters of each unit from ``|f| = g``."""
    from .fit import _kernels  # noqa: PLC0415 - importing numba takes longer than a small batch

    n, turned = len(r), form == "upper"
    flipped = r[:, :, ::-1] if turned else r
    relative = np.ascontiguousarray(flipped / g[:, np.newaxis, np.newaxis])
    used: NDArray[np.bool_] = np.asarray(np.isfinite(relative).all(axis=2))
    positions = used.sum(axis=1)
    size = np.sqrt((np.where(used[:, :, np.newaxis], relative, 0.0) ** 2).sum(axis=(1, 2)) / np.maximum(positions, 1))
    start = np.zeros((n, NORM))  # a common scale factor, so that a search that must fail for another unit still ends
    start[:, :3] = np.where(size > 0.0, size, 1.0)[:, np.newaxis] - 1.0
    slipped = ~((size < UNIT_SLIP) & (size > 1.0 / UNIT_SLIP))
    found, inverse = np.empty((n, NORM)), np.empty((n, NORM, NORM))
    squares, condition, steps = np.empty(n), np.empty(n), np.empty(n, dtype=np.int64)

    def fit(lot: slice) -> None:
        _kernels.fit_norms(
            relative[lot], used[lot], start[lot], found[lot], inverse[lot], squares[lot], condition[lot], steps[lot]
        )

    _shared(fit, n)
    ill = ~(condition <= LARGEST_CONDITION)
    status = _status(positions, NORM, slipped, ill, steps < 0, scatter)
    dof = np.maximum(positions - NORM, 0)
    back = np.array([2, 1, 0, 5, 4, 3, 8, 7, 6]) if turned else np.arange(NORM)
    pairs = ("yx", "zx", "zy") if form == "lower" else ("xy", "xz", "yz")
    scale, bias = (f"scale_factor_error_{a}" for a in AXES), (f"bias_{a}" for a in AXES)
    names = (*scale, *(f"misalignment_{pair}" for pair in pairs), *bias)
    lengths = np.ones((n, NORM))
    lengths[:, 6:] = g[:, np.newaxis]
    variance = _variance(squares, dof, None if scatter is None else (scatter / g) ** 2)
    covariance = inverse * variance[:, np.newaxis, np.newaxis] * lengths[:, :, np.newaxis] * lengths[:, np.newaxis, :]
    values = found * lengths
    if turned:
        values, covariance = values[:, back], covariance[:, back][:, :, back]
    units = ("1",) * 3 + ("rad",) * 3 + ("m/s^2",) * 3
    return _result(names, units, values, covariance, squares * g**2, scatter, dof, positions, condition, status)


def _status(
    positions: NDArray[np.int64],
    parameters: int,
    slipped: NDArray[np.bool_],
    ill: NDArray[np.bool_],
    lost: NDArray[np.bool_],
    scatter: float | None,
) -> NDArray[np.int64]:
    """First cause that holds for each unit."""
    bare = (positions == parameters) & (scatter is None)
    causes = [positions < parameters, slipped, ill, lost, bare]
    codes = [FEW, OTHER_UNIT, ILL_POSED, NOT_CONVERGED, NO_SCATTER]
    return np.select(causes, codes, OK).astype(np.int64)


def _variance(squares: Array, dof: NDArray[np.int64], known: Array | None) -> Array:
    if known is not None:
        return known
    return np.where(dof > 0, squares / np.maximum(dof, 1), np.nan)


def _result(
    names: tuple[str, ...],
    units: tuple[str, ...],
    values: Array,
    covariance: Array,
    squares: Array,
    scatter: float | None,
    dof: NDArray[np.int64],
    positions: NDArray[np.int64],
    condition: Array,
    status: NDArray[np.int64],
) -> PositionsBatch:
    """Blank what is no estimate, and count it."""
    without = ~np.isin(status, (OK, NO_SCATTER))
    values[without] = np.nan
    covariance[status != OK] = np.nan
    squares = np.where(without, np.nan, squares)
    chi_square = np.full(len(values), np.nan) if scatter is None else squares / scatter**2
    return PositionsBatch(
        names, units, values, covariance, squares, chi_square, dof, positions, condition, status,
        remarks_of(status), scatter is not None,
    )  # fmt: skip


def _known(r: Array, g: Array, directions: Array, scatter: float | None) -> PositionsBatch:
    """Twelve parameters of each unit, in known positions: units with the same positions at once."""
    n = len(r)
    used: NDArray[np.bool_] = np.asarray(np.isfinite(r).all(axis=2))
    positions = used.sum(axis=1)
    lines, squares = np.full((n, 3, 4), np.nan), np.full((n, 3), np.nan)
    inverse, condition = np.full((n, 4, 4), np.nan), np.full(n, np.inf)
    whole = bool(used.all())
    patterns, which = (used[:1], np.zeros(n, int)) if whole else np.unique(used, axis=0, return_inverse=True)
    for k, pattern in enumerate(patterns):
        units = np.flatnonzero(which.reshape(-1) == k)
        _solve_known(r, units, pattern, directions, lines, squares, inverse, condition)
    ill = ~(condition <= LARGEST_CONDITION)
    if np.all(ill & (positions >= 4)):
        raise DataError(
            f"the {r.shape[1]} directions cannot tell the parameters apart",
            why="with gravity along one line or in one plane, bias and scale factor of some sensor stay mixed",
            do="Add positions with gravity along the other axes, both ways",
            code="ill_posed",
        )
    lines[:, :, 1:] /= g[:, np.newaxis, np.newaxis]
    length = np.linalg.norm(lines[:, :, 1:], axis=2).mean(axis=1)
    slipped = ~((length < UNIT_SLIP) & (length > 1.0 / UNIT_SLIP))
    status = _status(positions, 4, slipped, ill, np.zeros(n, dtype=bool), scatter)
    each = np.maximum(positions - 4, 0)
    known = None if scatter is None else np.full((n, 3), scatter**2)
    variance = _variance(squares, each[:, np.newaxis], known)
    values, covariance = _in_words(lines, inverse, variance, g)
    pairs = [a + b for a in AXES for b in AXES if a != b]
    names = (
        *(f"scale_factor_error_{a}" for a in AXES), *(f"misalignment_{p}" for p in pairs), *(f"bias_{a}" for a in AXES)
    )  # fmt: skip
    units_of = ("1",) * 3 + ("rad",) * 6 + ("m/s^2",) * 3
    total = squares.sum(axis=1)
    return _result(names, units_of, values, covariance, total, scatter, 3 * each, positions, condition, status)


def _solve_known(
    r: Array, units: NDArray[np.int64], pattern: NDArray[np.bool_], directions: Array,
    lines: Array, squares: Array, inverse: Array, condition: Array,
) -> None:  # fmt: skip
    """Fill lines, squares, inverse normal matrix and condition of the units that have the same positions."""
    from .fit import _kernels  # noqa: PLC0415 - importing numba takes longer than a small batch

    design = np.column_stack([np.ones(int(pattern.sum())), directions[pattern]])
    if len(design) < 4:
        return
    singular = np.linalg.svd(design, compute_uv=False)
    condition[units] = singular[0] / singular[-1] if singular[-1] > 0.0 else np.inf
    if not singular[0] <= LARGEST_CONDITION * singular[-1]:
        return
    hat = np.ascontiguousarray(np.linalg.pinv(design))
    inverse[units] = hat @ hat.T
    whole = len(units) == len(r) and bool(pattern.all())
    own = np.ascontiguousarray(r if whole else r[units][:, pattern])
    found, left = np.empty((len(units), 3, 4)), np.empty((len(units), 3))
    _shared(lambda lot: _kernels.apply_known(hat, design, own[lot], found[lot], left[lot]), len(units))
    lines[units], squares[units] = found, left


def _in_words(lines: Array, inverse: Array, variance: Array, g: Array) -> tuple[Array, Array]:
    """Values and covariance of scale factor errors, misalignments and biases, from the lines b, M f of the sensors.

    The sensors share no scatter: the covariance has a block a sensor.
    """
    n = len(lines)
    values, covariance = np.empty((n, KNOWN)), np.zeros((n, KNOWN, KNOWN))
    for i in range(3):
        others = [j for j in range(3) if j != i]
        own = lines[:, i, 1 + i]
        ratio = lines[:, i, 1:][:, others] / own[:, np.newaxis]
        at = np.array([i, 3 + 2 * i, 4 + 2 * i, 9 + i])
        values[:, at] = np.column_stack([own - 1.0, ratio, lines[:, i, 0]])
        rows = np.zeros((n, 4, 4))  # derivatives by (b, M_i0 g, M_i1 g, M_i2 g)
        rows[:, 0, 1 + i] = 1.0 / g
        rows[:, 3, 0] = 1.0
        for k, j in enumerate(others):
            rows[:, 1 + k, 1 + j] = 1.0 / (own * g)
            rows[:, 1 + k, 1 + i] = -ratio[:, k] / (own * g)
        block = rows @ inverse @ rows.transpose(0, 2, 1) * variance[:, i, np.newaxis, np.newaxis]
        covariance[np.ix_(np.arange(n), at, at)] = block
    return values, covariance


@dataclass(frozen=True, eq=False)
class PositionsBatch:
    """Parameters of many triads with their covariance."""

    names: tuple[str, ...]  # Parameters as ``sensors.terms`` names them
    units: tuple[str, ...]  # Of the parameters
    values: Array  # shape (n, k): naN where a unit has no estimate
    covariance: Array  # shape (n, k, k): naN where it has none
    squares: Array  # shape (n,): sum of squared residuals [unit of the readings squared]
    chi_square: Array  # shape (n,): the same over the square of the scatter that was given; NaN where none was
    dof: NDArray[np.int64]  # shape (n,): residuals less parameters
    positions: NDArray[np.int64]  # shape (n,): positions without a missing reading
    # shape (n,): of the Jacobian, in units of gravity: up to three times the ratio of its singular values
    condition: Array
    status: NDArray[np.int64]  # shape (n,): index into ``STATUS``
    remarks: tuple[Remark, ...]  # Units without estimate or without uncertainty, counted by cause
    _given: bool = False

    def __len__(self) -> int:
        return len(self.values)

    @property
    def u(self) -> Array:
        """Standard uncertainties, shape (n, k)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    @property
    def words(self) -> tuple[str, ...]:
        """Status of each unit, in words."""
        return tuple(STATUS[one] for one in self.status)

    @property
    def estimated(self) -> NDArray[np.bool_]:
        """Which units have an estimate with an uncertainty, shape (n,)."""
        return np.asarray(self.status == OK)

    def estimate(self, unit: int) -> Estimate:
        """Return the parameters of one unit.

        Raises
        ------
        DataError
            If it has no estimate, or none with an uncertainty; with the code of its status.
        """
        status = int(self.status[unit])
        if status != OK:
            raise DataError(f"unit {unit}: {STATUS[status]}", do=WAYS_OUT[status], code=CODES[status])
        dof = np.inf if self._given else float(self.dof[unit]) / (1.0 if len(self.names) == BY_LENGTH else 3.0)
        component = Component(SOURCE, "A", self.covariance[unit], dof)
        return Estimate(self.names, self.values[unit], self.units, (component,))

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a unit: values, standard uncertainties and status."""
        found: dict[str, Any] = dict(zip(self.names, self.values.T, strict=True))
        found |= {f"u_{name}": u for name, u in zip(self.names, self.u.T, strict=True)}
        return frame(found | {"status": self.words})

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: of each parameter the median, how far units differ, and the median uncertainty."""
        good = self.estimated
        caption = f"{int(good.sum())} of {len(self)} units estimated"
        if not good.any():
            return (caption, *remarks_line(self.remarks))
        values, u = self.values[good], self.u[good]
        spread = values.std(axis=0, ddof=1) if len(values) > 1 else np.full(len(self.names), np.nan)
        columns = (np.median(values, axis=0), spread, np.median(u, axis=0))
        rows = [
            (
                name,
                near(float(columns[0][i]), float(columns[1][i])),
                *(uncertainty(float(c[i])) for c in columns[1:]),
                unit,
            )
            for i, (name, unit) in enumerate(zip(self.names, self.units, strict=True))
        ]
        heads = ("parameter", "median", "between units", "u (median)", "unit")
        return (Table(heads, rows, caption, (1, 2, 3)), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def remarks_of(status: NDArray[np.int64]) -> tuple[Remark, ...]:
    """Return the units without estimate or without uncertainty, counted by cause."""
    found = []
    for code in range(1, len(STATUS)):
        units = np.flatnonzero(status == code)
        if len(units):
            what = f"{len(units)} of {len(status)} unit(s) not estimated: {STATUS[code]}"
            found.append(Remark(CODES[code], "warning", what, f"unit {units[0]}", len(units), WAYS_OUT[code]))
    return tuple(found)
