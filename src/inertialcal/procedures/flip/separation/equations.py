"""Bias and ambient acceleration of one flip, by least squares.

The head is turned by the angle theta, right-handed, about one of its own axes a. Ambient acceleration g, given along
the head's axes at position 0, is read along its axes after the turn as ``C g``, where ``C_turned_0 = exp(-theta [a])``
takes it from the one to the other: about x::

    y: cos(theta) g_y + sin(theta) g_z          z: -sin(theta) g_y + cos(theta) g_z

A half turn changes the sign of both and leaves x alone [1]_. Each axis reads, in the dwell at position k::

    y_k = b + C_k g            b: bias, g: ambient acceleration

The axes across the turn are solved together, for the bias of each and both components of g across the turn; two
positions half a turn apart give ``G = (M_0 - M_pi) / 2`` and ``B = (M_0 + M_pi) / 2`` [1]_. The axis along the turn
reads the same everywhere, ``b + g`` together (``reading``); any part of it that follows the turn is the error of the
test itself (``control_error``, eq. (6) halved, as Table 5 has it; where the positions are not all on a line, cosine
and sine separate, the latter as ``control_error_quadrature``).

A drift, if the plan has one, counts from the middle of the flip (mean of time, or of an axis' temperature, over its
dwells): ``b`` and ``g`` hold there. A quantity that the positions cannot separate is left out with its reason; an axis
that was read at one position only gives ``reading``, bias and ambient acceleration together.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, eq. (1)-(7).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES, Key, Reason
from ..plan import Plan
from ..readings import Readings

RELATIVE = 1e-9  # singular values below this, of columns of length one, are rounding
RESOLVED = 1e-6  # a coefficient is determined to this
ROUNDING = 1e-9  # of a sine: half turns written in degrees, or as 3.141592653589793
SAME = 1e-6  # [rad] positions nearer than this are one

AMBIENT, BIAS, READING, CONTROL = "ambient_acceleration", "bias", "reading", "control_error"
QUADRATURE = f"{CONTROL}_quadrature"
RATES = {AMBIENT: f"{AMBIENT}_rate", BIAS: f"{BIAS}_rate", READING: f"{READING}_rate"}
WARM = {BIAS: f"{BIAS}_temperature_coefficient", READING: f"{READING}_temperature_coefficient"}


@dataclass(frozen=True, eq=False)
class Separated:
    """The quantities of one flip.

    Parameters
    ----------
    flip : str
        Its label.
    keys : tuple of Key
        Ambient acceleration of y, bias of y, control error of x, ...
    values : ndarray, shape (p,)
        SI.
    weights : mapping of str to ndarray, shape (p, n)
        Weight of each axis' readings, all dwells of the Readings, in the values.
    checks : mapping of str to ndarray, shape (r, n)
        Orthonormal combinations of each turned axis that are zero by the model: r degrees of freedom.
    reasons : mapping of Key to Reason
        Why a quantity cannot be separated.
    single : mapping of str to tuple of float
        The position of each axis that was read at one position only [deg].
    """

    flip: str
    keys: tuple[Key, ...]
    values: Array
    weights: Mapping[str, Array]
    checks: Mapping[str, Array]
    reasons: Mapping[Key, Reason]
    single: Mapping[str, tuple[float, ...]]

    def value(self, key: Key) -> float | None:
        """Return one value; None where it was not separated."""
        return float(self.values[self.keys.index(key)]) if key in self.keys else None


@dataclass(frozen=True, eq=False)
class _Rows:
    """Readings of some axes in one flip: row i is that of ``axis[i]`` in dwell ``dwell[i]``."""

    dwell: NDArray[np.intp]
    axis: NDArray[np.str_]
    y: Array
    angle: Array

    @classmethod
    def of(cls, readings: Readings, flip: str, axes: Sequence[str]) -> _Rows:
        own = np.flatnonzero(readings.flip == flip)
        pairs = [(k, axis) for axis in axes for k in own if np.isfinite(readings.outputs[axis][k])]
        dwell = np.array([k for k, _ in pairs], dtype=np.intp)
        y = np.array([readings.outputs[axis][k] for k, axis in pairs])
        return cls(dwell, np.array([axis for _, axis in pairs], dtype=str), y, readings.angle[dwell])

    def spread(self, lines: Array, axis: str, dwells: int) -> Array:
        """Return the weights of one axis by dwell, shape (p, n)."""
        spread = np.zeros((len(lines), dwells))
        own = self.axis == axis
        spread[:, self.dwell[own]] = lines[:, own]
        return spread

    def positions(self, axis: str) -> tuple[float, ...]:
        """Return the positions that an axis was read at [deg]."""
        return tuple(np.unique(np.round(np.degrees(self.angle[self.axis == axis]), 6)).tolist())

    def single(self, axis: str) -> bool:
        """Tell whether an axis was read, and at one position only."""
        angle = self.angle[self.axis == axis]
        return len(angle) > 0 and (directions(angle).shape[1] == 0 or bool(np.ptp(angle) < SAME))


@dataclass(frozen=True, eq=False)
class _Part:
    """Weights of some rows in each value, and the combinations that should be zero."""

    rows: _Rows
    keys: list[Key]
    lines: Array
    rest: Array
    reasons: dict[Key, Reason]


def separate(plan: Plan, readings: Readings, flip: str) -> Separated:
    """Separate bias from ambient acceleration in one flip.

    Raises
    ------
    DataError
        ``drift_not_carried`` if the dwells do not determine the plan's drift, or lack its time or temperature.
    """
    turned = [axis for axis in plan.turned if axis in readings.axes]
    control = [axis for axis in readings.axes if axis == plan.axis]
    across, along = _Rows.of(readings, flip, turned), _Rows.of(readings, flip, control)
    parts = [
        _part(plan, across, _turned_columns(plan, readings, across)),
        _part(plan, along, _control_columns(plan, readings, along)),
    ]
    return Separated(
        flip,
        tuple(key for part in parts for key in part.keys),
        np.concatenate([part.lines @ part.rows.y for part in parts]),
        {axis: np.vstack([p.rows.spread(p.lines, axis, len(readings)) for p in parts]) for axis in readings.axes},
        {axis: across.spread(parts[0].rest, axis, len(readings)) for axis in turned},
        parts[0].reasons | parts[1].reasons,
        {axis: rows.positions(axis) for rows, axes in ((across, turned), (along, control)) for axis in axes
         if rows.single(axis)},
    )  # fmt: skip


def _part(plan: Plan, rows: _Rows, columns: Mapping[Key, Array]) -> _Part:
    X = np.column_stack([np.zeros((len(rows.y), 0)), *columns.values()])
    solution, rest = _solve(X)
    own = np.abs(solution @ X - np.eye(len(columns))).max(axis=1, initial=0.0) < RESOLVED
    keys = [key for key, kept in zip(columns, own, strict=True) if kept]
    lost = [key for key in columns if key not in keys]
    if plan.drift != "none" and len(rows.y) and lost:
        count, names = len(np.unique(rows.dwell)), ", ".join(map(str, lost))
        what = f"{count} dwells of a flip cannot determine a drift of {plan.drift} as well as {names}"
        do = "Make three dwells or more, for example 0, 180 and 0 deg, or leave plan.drift out"
        raise DataError(what, why="any amount of drift fits as well", do=do, code="drift_not_carried")
    single = {
        Key(READING, axis): ((rows.axis == axis) / np.sum(rows.axis == axis))[None, :]
        for axis in plan.turned
        if rows.single(axis) and Key(BIAS, axis) not in keys
    }
    reasons = {key: _reason(rows, key.axis) for key in lost}
    return _Part(rows, [*keys, *single], np.vstack([solution[own], *single.values()]), rest, reasons)


def _turned_columns(plan: Plan, readings: Readings, rows: _Rows) -> dict[Key, Array]:
    C = rotation(plan.axis, rows.angle)
    at = np.array([AXES.index(axis) for axis in rows.axis], dtype=np.intp)
    across = [axis for axis in plan.turned if axis in readings.axes]
    cosines = {axis: C[np.arange(len(at)), at, AXES.index(axis)] for axis in plan.turned}
    columns = {Key(AMBIENT, axis): c for axis, c in cosines.items() if axis in across or np.any(c)}
    level = {axis: (rows.axis == axis).astype(float) for axis in across}
    columns |= {Key(BIAS, axis): one for axis, one in level.items()}
    if plan.drift == "ambient":
        since = _since(plan, readings, rows)
        columns |= {Key(RATES[AMBIENT], axis): since * cosines[axis] for axis in across}
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
    parts = directions(rows.angle) if len(rows.y) else np.zeros((0, 0))
    columns |= {Key(name, axis): part for name, part in zip((CONTROL, QUADRATURE), parts.T, strict=False)}
    if plan.drift != "none":
        name = WARM[READING] if plan.drift == "temperature" else RATES[READING]
        columns[Key(name, axis)] = _since(plan, readings, rows)
    return columns


def _since(plan: Plan, readings: Readings, rows: _Rows) -> Array:
    """Time or temperature of each row, from the mean of the flip's dwells."""
    unknown = np.full(len(readings), np.nan)
    if plan.drift == "temperature":
        pairs = zip(rows.axis, rows.dwell, strict=True)
        values = np.array([readings.temperature.get(str(axis), unknown)[k] for axis, k in pairs])
    else:
        values = (unknown if readings.time is None else readings.time)[rows.dwell]
    if not np.isfinite(values).all():
        word = "temperature" if plan.drift == "temperature" else "time"
        what = f"plan.drift = {plan.drift!r}, but a dwell has no {word}"
        raise DataError(what, do=f"Give the {word} of every dwell, or leave plan.drift out", code="drift_not_carried")
    middle = {axis: values[rows.axis == axis].mean() for axis in np.unique(rows.axis)}
    return np.asarray(values - np.array([middle[axis] for axis in rows.axis]))


def _solve(X: Array) -> tuple[Array, Array]:
    """Least-squares weights, shape (p, rows), and an orthonormal basis of the null space of X', shape (r, rows)."""
    length = np.sqrt(np.sum(X**2, axis=0))
    scale = np.where(length > 0.0, length, 1.0)
    left, s, right = np.linalg.svd(X / scale, full_matrices=True)
    rank = int(np.sum(s > RELATIVE * s.max(initial=0.0)))
    solution = np.asarray((right[:rank].T / s[:rank]) @ left[:, :rank].T / scale[:, None])
    most = np.abs(solution).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(solution) > RELATIVE * most, solution, 0.0), np.asarray(left[:, rank:].T)


def _reason(rows: _Rows, axis: str) -> Reason:
    """Return why a coefficient of an axis is not determined."""
    if not np.any(rows.axis == axis):
        return Reason("not_read", f"the {axis} axis was not read")
    places = rows.positions(axis)
    if rows.single(axis):
        return Reason("missing_position", missing_position(places, axis))
    return Reason("not_told_apart", f"not separable from the rest at the positions read ({_listed(places)} deg)")


def missing_position(places: Sequence[float], *axes: str) -> str:
    """Return the message for axes that were read at one position [deg] only."""
    verb = "was" if len(axes) == 1 else "were"
    read = f"read at {_listed(places)} deg only, where bias and ambient acceleration cannot be separated"
    return f"missing position: {', '.join(axes)} {verb} {read}"


def _listed(places: Sequence[float]) -> str:
    return ", ".join(f"{one:.6g}" for one in places)


def rotation(axis: str, angle: Array) -> Array:
    """Return C_turned_0 about an axis for each angle [rad], shape (n, 3, 3)."""
    along = np.eye(3)[AXES.index(axis)]
    rest = np.eye(3) - np.outer(along, along)
    return np.asarray(
        np.outer(along, along) + _clean(np.cos(angle))[:, None, None] * rest
        - _clean(np.sin(angle))[:, None, None] * cross(along)
    )  # fmt: skip


def slope(axis: str, angle: Array) -> Array:
    """Return the derivative of C_turned_0 with respect to the angle, shape (n, 3, 3)."""
    return np.asarray(-cross(np.eye(3)[AXES.index(axis)]) @ rotation(axis, angle))


def tilted(axis: str, angle: Array, small: Array) -> Array:
    """Return the change of C_turned_0 for a turn axis that is off by a small rotation vector [rad], shape (n, 3, 3)."""
    C = rotation(axis, angle)
    return np.asarray(cross(small) @ C - C @ cross(small))


def cross(vector: Array) -> Array:
    """Return the matrix of a cross product, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def directions(angle: Array) -> Array:
    """Return the components of a fixed direction that the positions separate: shape (n, 0..2).

    Two columns are cosine and sine. One, where all positions lie on a line, is the coordinate along it, from its
    middle, so that a half turn gives +1 and -1; it is positive at the end that is nearer position 0.
    """
    points = np.column_stack([_clean(np.cos(angle)), _clean(np.sin(angle))])
    if not len(points):
        return np.zeros((0, 0))
    spread, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1:]
    rank = int(np.sum(spread > SAME))
    if rank != 1:
        return points[:, :rank]
    along = axes[0] if axes[0, 0] > ROUNDING or (abs(axes[0, 0]) <= ROUNDING and axes[0, 1] > 0.0) else -axes[0]
    coordinate = points @ along
    return np.asarray(coordinate - 0.5 * (coordinate.max() + coordinate.min()))[:, None]


def _clean(values: Array) -> Array:
    return np.where(np.abs(values) < ROUNDING, 0.0, values)
