"""Bias and ambient acceleration of one flip, by least squares.

Each axis reads, in the dwell at position k::

    y_k = b + C_k g            b: bias, g: ambient acceleration along the head's axes at position 0

The axes across the turn are solved together, for the bias of each and both components of g across the turn; two
positions half a turn apart give ``G = (M_0 - M_pi) / 2`` and ``B = (M_0 + M_pi) / 2`` [1]_. The axis along the turn
reads the same everywhere, ``b + g`` together (``reading``); what it seems to read of a turned direction is the error of
the test itself (``control_error``, eq. (6) halved, as Table 5 has it; with positions that are not all on a line, cosine
and sine part, the latter ``control_error_quadrature``).

A drift, if the plan has one, counts from the middle of the flip (mean of time, or of an axis' temperature, over its
dwells): ``b`` and ``g`` hold there. What the positions cannot separate is left out with its reason; an axis that was
read at one position only gives ``reading``, bias and ambient acceleration together.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, eq. (1)-(7).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.axes import AXES
from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import Key, Reason
from ..plan import Plan
from ..readings import Readings
from .positions import SAME, directions, rotation

RELATIVE = 1e-9  # singular values below this, of columns of length one, are rounding
RESOLVED = 1e-6  # a coefficient that is its own to this

AMBIENT, BIAS, READING, CONTROL = "ambient_acceleration", "bias", "reading", "control_error"
QUADRATURE = f"{CONTROL}_quadrature"
RATES = {AMBIENT: f"{AMBIENT}_rate", BIAS: f"{BIAS}_rate", READING: f"{READING}_rate"}
WARM = {BIAS: f"{BIAS}_temperature_coefficient", READING: f"{READING}_temperature_coefficient"}


@dataclass(frozen=True, eq=False)
class Separated:
    """What one flip gives.

    Parameters
    ----------
    flip : str
        Its label.
    keys : tuple of Key
        Ambient acceleration of y, bias of y, control error of x, ...
    values : ndarray, shape (p,)
        SI.
    weights : mapping of str to ndarray, shape (p, n)
        Of each axis' readings, all dwells of the Readings, in the values.
    checks : mapping of str to ndarray, shape (r, n)
        Of each turned axis in orthonormal combinations that the model says are zero: r degrees of freedom are left.
    reasons : mapping of Key to Reason
        Why a quantity cannot be separated.
    single : mapping of str to tuple of float
        Where each axis was read that was read at one position only [deg].
    """

    flip: str
    keys: tuple[Key, ...]
    values: Array
    weights: Mapping[str, Array]
    checks: Mapping[str, Array]
    reasons: Mapping[Key, Reason]
    single: Mapping[str, tuple[float, ...]]

    def value(self, key: Key) -> float | None:
        """One value, or None where it was not separated."""
        return float(self.values[self.keys.index(key)]) if key in self.keys else None


def separate(plan: Plan, readings: Readings, flip: str) -> Separated:
    """Separate bias from ambient acceleration in one flip.

    Raises
    ------
    DataError
        ``drift_not_carried`` if the plan's drift cannot be told from the rest, or its time or temperature is missing.
    """
    turned = [axis for axis in plan.turned if axis in readings.axes]
    control = [axis for axis in readings.axes if axis == plan.axis]
    groups = [
        (_Rows.of(readings, flip, turned), _turned_columns),
        (_Rows.of(readings, flip, control), _control_columns),
    ]
    parts = [_part(plan, readings, rows, columns(plan, readings, rows)) for rows, columns in groups]
    reasons = {key: why for part in parts for key, why in part.reasons.items()}
    return Separated(
        flip,
        tuple(key for part in parts for key in part.keys),
        np.concatenate([part.lines @ part.rows.y for part in parts]),
        {axis: np.vstack([p.rows.spread(p.lines, axis, len(readings)) for p in parts]) for axis in readings.axes},
        {axis: parts[0].rows.spread(parts[0].rest, axis, len(readings)) for axis in turned},
        reasons,
        parts[0].rows.single() | parts[1].rows.single(),
    )


@dataclass(frozen=True, eq=False)
class _Part:
    """What one set of readings gives: weights of its rows in each value, and combinations that should be zero."""

    rows: _Rows
    keys: list[Key]
    lines: Array
    rest: Array
    reasons: dict[Key, Reason]


def _part(plan: Plan, readings: Readings, rows: _Rows, columns: Mapping[Key, Array]) -> _Part:
    X = np.column_stack([np.zeros((len(rows.y), 0)), *columns.values()])
    solution, rest = _solve(X)
    own = np.abs(solution @ X - np.eye(len(columns))).max(axis=1, initial=0.0) < RESOLVED
    keys = [key for key, kept in zip(columns, own, strict=True) if kept]
    lost = [key for key in columns if key not in keys]
    if plan.drift != "none" and len(rows.y) and lost:
        raise _not_carried(plan, rows, lost)
    single = _single_sided(plan, rows, keys)
    reasons = {key: _why(rows, key.axis) for key in lost}
    return _Part(rows, [*keys, *single], np.vstack([solution[own], *single.values()]), rest, reasons)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Readings of a flip, one a row: of dwell ``dwell`` and axis ``axis``."""

    dwell: NDArray[np.intp]
    axis: NDArray[np.str_]
    y: Array
    angle: Array

    @classmethod
    def of(cls, readings: Readings, flip: str, axes: Sequence[str]) -> _Rows:
        """Return the readings of some axes in one flip."""
        own = np.flatnonzero(readings.flip == flip)
        pairs = [(k, axis) for axis in axes for k in own if np.isfinite(readings.outputs[axis][k])]
        dwell = np.array([k for k, _ in pairs], dtype=np.intp)
        y = np.array([readings.outputs[axis][k] for k, axis in pairs])
        return cls(dwell, np.array([axis for _, axis in pairs], dtype=str), y, readings.angle[dwell])

    def spread(self, lines: Array, axis: str, dwells: int) -> Array:
        """Return the part of weights that belongs to an axis, by dwell, shape (p, n)."""
        found = np.zeros((len(lines), dwells))
        own = self.axis == axis
        found[:, self.dwell[own]] = lines[:, own]
        return found

    def positions(self, axis: str) -> tuple[float, ...]:
        """Return where an axis was read [deg]."""
        return tuple(np.unique(np.round(np.degrees(self.angle[self.axis == axis]), 6)).tolist())

    def single(self) -> dict[str, tuple[float, ...]]:
        """Return where those axes were read that were read at one position only [deg]."""
        axes = [str(axis) for axis in np.unique(self.axis)]
        return {axis: self.positions(axis) for axis in axes if _one_position(self.angle[self.axis == axis])}


def _turned_columns(plan: Plan, readings: Readings, rows: _Rows) -> dict[Key, Array]:
    C = rotation(plan.axis, rows.angle)
    at = np.array([AXES.index(axis) for axis in rows.axis], dtype=np.intp)
    across = [axis for axis in plan.turned if axis in readings.axes]
    seen = {axis: C[np.arange(len(at)), at, AXES.index(axis)] for axis in plan.turned}
    columns = {Key(AMBIENT, axis): c for axis, c in seen.items() if axis in across or np.any(c)}
    level = {axis: (rows.axis == axis).astype(float) for axis in across}
    columns |= {Key(BIAS, axis): one for axis, one in level.items()}
    if plan.drift == "ambient":
        since = _since(plan, readings, rows)
        columns |= {Key(RATES[AMBIENT], axis): since * seen[axis] for axis in across}
    elif plan.drift != "none":
        since = _since(plan, readings, rows)
        name = RATES[BIAS] if plan.drift == "bias" else WARM[BIAS]
        columns |= {Key(name, axis): since * one for axis, one in level.items()}
    return columns


def _control_columns(plan: Plan, readings: Readings, rows: _Rows) -> dict[Key, Array]:
    axis = plan.axis
    if axis not in readings.axes:
        return {}
    columns = {Key(READING, axis): np.ones(len(rows.y)), Key(CONTROL, axis): np.zeros(len(rows.y))}
    told = directions(rows.angle) if len(rows.y) else np.zeros((0, 0))
    columns |= {Key(name, axis): part for name, part in zip((CONTROL, QUADRATURE), told.T, strict=False)}
    if plan.drift != "none":
        name = WARM[READING] if plan.drift == "temperature" else RATES[READING]
        columns[Key(name, axis)] = _since(plan, readings, rows)
    return columns


def _since(plan: Plan, readings: Readings, rows: _Rows) -> Array:
    """Time or temperature of each row, from the mean of the flip's dwells."""
    values = _drifting(plan, readings, rows)
    if not np.isfinite(values).all():
        word = "temperature" if plan.drift == "temperature" else "time"
        what = f"the plan has a drift of {plan.drift} fitted, but the {word} of a dwell is missing"
        raise DataError(what, do=f"Give the {word} of every dwell, or leave the drift out", code="drift_not_carried")
    middle = {axis: values[rows.axis == axis].mean() for axis in np.unique(rows.axis)}
    return np.asarray(values - np.array([middle[axis] for axis in rows.axis]))


def _drifting(plan: Plan, readings: Readings, rows: _Rows) -> Array:
    """Time or temperature of each row; NaN where it is not given."""
    unknown = np.full(len(readings), np.nan)
    if plan.drift != "temperature":
        return (unknown if readings.time is None else readings.time)[rows.dwell]
    pairs = zip(rows.axis, rows.dwell, strict=True)
    return np.array([readings.temperature.get(str(axis), unknown)[k] for axis, k in pairs])


def _not_carried(plan: Plan, rows: _Rows, lost: Sequence[Key]) -> DataError:
    count, told = len(np.unique(rows.dwell)), ", ".join(map(str, lost))
    what = f"{count} dwells of a flip cannot carry a drift of {plan.drift}: {told} cannot be told apart"
    do = "Make three dwells or more, as 0, 180 and 0 deg, or leave plan.drift out"
    return DataError(what, why="any amount of it fits as well", do=do, code="drift_not_carried")


def _solve(X: Array) -> tuple[Array, Array]:
    """Least-squares weights, shape (p, rows), and an orthonormal basis of what X does not see, shape (r, rows)."""
    length = np.sqrt(np.sum(X**2, axis=0))
    scale = np.where(length > 0.0, length, 1.0)
    left, s, right = np.linalg.svd(X / scale, full_matrices=True)
    rank = int(np.sum(s > RELATIVE * s.max(initial=0.0)))
    solution = np.asarray((right[:rank].T / s[:rank]) @ left[:, :rank].T / scale[:, None])
    most = np.abs(solution).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(solution) > RELATIVE * most, solution, 0.0), np.asarray(left[:, rank:].T)


def _single_sided(plan: Plan, rows: _Rows, keys: list[Key]) -> dict[Key, Array]:
    """Mean reading of each turned axis that was read at one position only: bias and ambient acceleration together."""
    found = {}
    for axis in plan.turned:
        own = rows.axis == axis
        if own.any() and Key(BIAS, axis) not in keys and _one_position(rows.angle[own]):
            found[Key(READING, axis)] = (own / own.sum())[None, :]
    return found


def _one_position(angle: Array) -> bool:
    return directions(angle).shape[1] == 0 or bool(np.ptp(angle) < SAME)


def _why(rows: _Rows, axis: str) -> Reason:
    """Return why a coefficient of an axis cannot be told from the others."""
    own = rows.axis == axis
    if not own.any():
        return Reason("not_read", f"the {axis} axis was not read")
    if _one_position(rows.angle[own]):
        return Reason("missing_position", missing_position(rows.positions(axis), axis))
    told = _listed(rows.positions(axis))
    return Reason("not_told_apart", f"the positions read ({told} deg) cannot tell it from the rest")


def missing_position(places: Sequence[float], *axes: str) -> str:
    """Say that axes were read at one position only.

    Parameters
    ----------
    places : sequence of float
        Where [deg].
    *axes : str
        Which.
    """
    verb = "was" if len(axes) == 1 else "were"
    told = f"read at {_listed(places)} deg only, where bias and ambient acceleration are one"
    return f"missing position: {', '.join(axes)} {verb} {told}"


def _listed(places: Sequence[float]) -> str:
    return ", ".join(f"{one:.6g}" for one in places)
