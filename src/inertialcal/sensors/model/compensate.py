"""From readings to the true input: the inverse of the sensor equation, and the first-order form.

The inverse goes back through the equation in the order in which it was built: subtract K0 and G f, invert the
curve of each sensor, multiply by M^-1. It is refused where two inputs would give one reading inside the validity
range of the model. Readings that no input can give (beyond the end of the rising branch of a curved sensor) come
back as NaN; ``outside`` counts them, and those beyond the validity range.

The first-order form ``x = r - (b + (M - I) r)`` is that of published flight software [1]_; it differs from the
inverse by the square of the errors.

References
----------
.. [1] Badescu, NPS thesis, 2011, equation (2) and Table 15.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.unit.magnitudes import LARGEST
from .equation import Columns, Conditions, condition_columns, curve, inverted, matrix_at, mixed, offset, rows
from .nonlinearity import LOWEST_SLOPE, endless_slope, inverse, rising_branch, smallest_slope
from .sensitivity import PRESSURE, Sensitivity
from .sensor_model import SensorModel

CHUNK = 16_384  # rows that stay in the cache from step to step
KERNEL_ROWS = 1_000_000  # from here on the compiled loop is worth its compilation
KERNEL_CHUNK = 131_072  # rows of which a thread takes one lot after the other
WORKERS = os.cpu_count() or 1  # threads; no result depends on their number
LARGEST_CONDITION = 1e4  # of M: input axes nearer to one plane than this lose four digits
NOISE_OF_ENDS = 0.01  # of an end of the inputs of a model, by which a reading may lie beyond: noise does
NODES = 33  # temperatures at which M(T) is looked at


def compensate(model: SensorModel, readings: Array, **conditions: Unpack[Conditions]) -> Array:
    """Return the true inputs of readings: the inverse of `predict`.

    Parameters
    ----------
    readings : ndarray, shape (n, k)
        r = v / S0 [input unit]; see ``model.to_readings`` for outputs in volts or pulses a second.
    **conditions
        See `equation.Conditions`.

    Returns
    -------
    ndarray, shape (n, k)
        x [input unit]. NaN where a reading or a condition is NaN, or where no possible input gives that reading.

    Raises
    ------
    DataError
        If a shape does not fit, a condition is missing that a term needs (``missing_condition``), or the inverse
        is not unique (``not_invertible``, ``not_unique``, ``no_validity_range``).
    """
    r = rows(model, readings, "readings")
    columns = condition_columns(model, len(r), conditions)
    check_unique(model, columns)
    out = np.empty(r.shape)
    if len(r) >= KERNEL_ROWS and len(model.axes) == 3 and _compiled(model, columns, r, out):
        return out
    for part, here in pieces(columns, len(r)):
        with np.errstate(over="ignore", invalid="ignore"):  # a polynomial far away from its data
            out[part] = _inverse(model, r[part], here)
        empty_impossible(out[part])
    return out


def empty_impossible(values: Array) -> None:
    """Put NaN in the place of each value that is infinite, or of a size that nothing has."""
    with np.errstate(invalid="ignore"):
        values[np.abs(values) > LARGEST] = np.nan


def first_order(model: SensorModel, readings: Array, **conditions: Unpack[Conditions]) -> Array:
    """Return ``r - (b + (M - I) r)``, shape (n, k): the published first-order form, b = K0 + G f.

    Curves are left out, as there. Arguments and Raises as for `compensate`.
    """
    r = rows(model, readings, "readings")
    columns = condition_columns(model, len(r), conditions)
    errors = matrix_at(model, columns) - np.eye(len(model.axes))
    return r - (offset(model, columns) + mixed(errors, r))


def outside(
    model: SensorModel, compensated: Array, readings: Array, **conditions: Unpack[Conditions]
) -> tuple[Remark, ...]:
    """Count what lies beyond the validity range of a model.

    Parameters
    ----------
    compensated, readings : ndarray, shape (n, k)
        Out of and into `compensate` [input unit].

    Returns
    -------
    tuple of Remark
        ``no_inverse``, ``outside_input_range``, ``outside_temperature_range``, ``outside_pressure_range``,
        ``outside_channel_range`` of each channel that the model has a sensitivity to; only those with a count above
        zero.
    """
    return tuple(counted(one, len(compensated)) for one in beyond(model, compensated, readings, **conditions))


def counted(remark: Remark, among: int) -> Remark:
    """Return a remark of `beyond` that says of how many rows."""
    return replace(remark, what=f"{remark.count} of {among} row(s): {remark.what}")


def beyond(
    model: SensorModel, compensated: Array, readings: Array, **conditions: Unpack[Conditions]
) -> tuple[Remark, ...]:
    """Return what `outside` does of some rows of a record: the remarks do not say of how many."""
    x = rows(model, compensated, "compensated")
    r = rows(model, readings, "readings")
    columns = condition_columns(model, len(x), conditions)
    complete = np.isfinite(r).all(axis=1)
    for column in columns.values():
        complete &= np.isfinite(column).all(axis=1)
    lost = np.any(np.isnan(x), axis=1) & complete
    remarks = [_remark("no_inverse", "no input gives this reading; left empty", lost, "Look at these readings")]
    if model.input_range is not None:
        tested = model.input_range[:, 0] < model.input_range[:, 1]  # an axis that was never moved has no ends
        low, high = model.input_range.T
        edge = NOISE_OF_ENDS * np.maximum(np.abs(low), np.abs(high))
        over = np.any(((x < low - edge) | (x > high + edge)) & tested, axis=1)
        each = zip(model.axes, model.input_range, tested, strict=True)
        ends = ", ".join(f"{a} {lo:.4g} to {hi:.4g}" for a, (lo, hi), moved in each if moved)
        remarks.append(_remark("outside_input_range", f"beyond the input range ({ends} {model.unit})", over))
    ranges = [
        ("outside_temperature_range", "temperature", model.temperature_range, "degC"),
        ("outside_pressure_range", PRESSURE, model.pressure_range, "Pa"),
        *(("outside_channel_range", one.channel, one.range, one.unit) for one in model.sensitivities),
    ]
    for code, name, between, unit in ranges:
        if between is not None and name in columns:
            over = np.any((columns[name] < between[0]) | (columns[name] > between[1]), axis=1)
            text = f"beyond the {name} range ({between[0]:g} to {between[1]:g} {unit})"
            remarks.append(_remark(code, text, np.broadcast_to(over, len(x))))
    return tuple(remark for remark in remarks if remark.count)


def _remark(code: str, text: str, where: NDArray[Any], do: str = "The model extrapolates there") -> Remark:
    count = int(np.count_nonzero(where))
    at = int(np.argmax(where)) if count else 0
    return Remark(code, "warning", text, f"row {at}" if count else "", count, do, index=at)


def _compiled(model: SensorModel, columns: Columns, readings: Array, out: Array) -> bool:
    """Fill ``out`` by compiled loops over the rows of three sensors, which threads share.

    Return False where M is singular at a temperature of the data, which the plain path says, or changes from row to
    row with another channel.
    """
    from .. import _kernels  # noqa: PLC0415 - importing numba takes longer than a short recording

    bent = curve(model)
    branch = rising_branch(bent)
    curves = np.column_stack([bent.asymmetry, bent.second, bent.third, branch, endless_slope(bent, branch)])
    changing = model.matrix.shape[0] > 1 and len(columns["temperature"]) > 1
    scaled = [one.channel for one in model.sensitivities if one.scale_factor is not None]
    if scaled and (changing or any(len(columns[name]) > 1 for name in scaled)):
        return False
    matrices = model.matrix.copy() if changing else np.ascontiguousarray(inverted(matrix_at(model, columns)))

    def fill(piece: tuple[slice, dict[str, Array]]) -> bool:
        part, here = piece
        r = np.ascontiguousarray(readings[part])
        done = bool(_kernels.undo_3(*_thermal(model, here), curves, matrices, r, out[part]))
        empty_impossible(out[part])
        return done

    with ThreadPoolExecutor(WORKERS) as pool:
        return all(pool.map(fill, pieces(columns, len(readings), KERNEL_CHUNK)))


def _thermal(model: SensorModel, columns: Columns) -> tuple[Array, Array, Array, Array]:
    """Return the bias as the kernel takes it: shift, powers of temperature, T_ref, T.

    The powers are left to the kernel where temperature alone changes; else the shift holds all, a row a reading.
    """
    temperature = np.ascontiguousarray(columns.get("temperature", np.zeros((1, 1))))
    reference = np.array(model.terms.get("reference_temperature", np.zeros(len(model.axes))))
    if set(columns) == {"temperature"} and len(temperature) > 1:
        powers = np.array(model.terms.get("bias_temperature", np.empty((0, len(model.axes)))))
        return model.bias[np.newaxis].copy(), powers, reference, temperature
    return np.array(offset(model, columns)), np.empty((0, len(model.axes))), reference, temperature


def pieces(columns: Columns, n: int, size: int | None = None) -> Iterator[tuple[slice, dict[str, Array]]]:
    """Rows in chunks, of CHUNK rows where no size is given, and the conditions of each."""
    step = CHUNK if size is None else size
    for start in range(0, n, step):
        part = slice(start, min(start + step, n))
        yield part, {name: column if len(column) == 1 else column[part] for name, column in columns.items()}


def _inverse(model: SensorModel, r: Array, columns: Columns) -> Array:
    u = r - offset(model, columns)
    if not model.linear:
        u = inverse(curve(model), u)
    return mixed(inverted(matrix_at(model, columns)), u)


def check_unique(model: SensorModel, columns: Columns) -> None:
    """Refuse a model whose inverse is not unique.

    Looked at: M over the temperature range (else over the temperatures given), and the slope of each sensor's
    curve over all that it can feel inside the input range.

    Parameters
    ----------
    columns : mapping of ndarray
        Conditions as ``equation.condition_columns`` gives them.

    Raises
    ------
    DataError
        ``not_invertible`` if M is singular or nearly so; ``not_unique`` if a curve turns inside the validity
        range; ``no_validity_range`` if it turns somewhere and the model has no input range.
    """
    matrices = _matrices(model, columns)
    condition = np.linalg.cond(matrices)
    if not np.all(condition < LARGEST_CONDITION) or np.ptp(np.sign(np.linalg.det(matrices))):
        raise DataError(
            f"the matrix cannot be inverted: condition number {np.max(condition):.3g}, need below "
            f"{LARGEST_CONDITION:g} and no change of sign of its determinant",
            why="the readings do not tell the inputs apart",
            do="Look at the misalignments of the model",
            code="not_invertible",
        )
    if model.linear:
        return
    bent = curve(model)
    if model.input_range is None:
        ends = rising_branch(bent)
        if np.all(np.isinf(ends)):
            return
        axis = model.axes[int(np.argmax(np.any(np.isfinite(ends), axis=1)))]
        raise DataError(
            f"the {axis} sensor's curve turns, and the model has no input range",
            why="beyond the turn two inputs give one reading",
            do="Give input_range",
            code="no_validity_range",
        )
    slope = smallest_slope(bent, felt_range(matrices, model.input_range))
    worst = int(np.argmin(slope))
    if slope[worst] < LOWEST_SLOPE:
        raise DataError(
            f"the {model.axes[worst]} sensor's slope falls to {slope[worst]:.3g} inside the validity range, "
            f"need {LOWEST_SLOPE:g} or more",
            why="two inputs give one reading",
            do="Narrow input_range, or fit a lower order",
            code="not_unique",
        )


def _matrices(model: SensorModel, columns: Columns) -> Array:
    """M at temperatures over the range, and at both ends of the range of each channel that changes the scale factor."""
    places: dict[str, Array] = {}
    if model.matrix.shape[0] > 1:
        ends = model.temperature_range or _extremes(columns["temperature"], np.asarray(model.reference_temperature))
        places["temperature"] = np.linspace(*ends, NODES)
    for one in model.sensitivities:
        if one.scale_factor is not None:
            between = channel_range(model, one) or _extremes(columns[one.channel], np.array([one.reference]))
            places[one.channel] = np.array(between)
    grid = np.meshgrid(*places.values(), indexing="ij")
    return matrix_at(model, {name: nodes.reshape(-1, 1) for name, nodes in zip(places, grid, strict=True)})


def channel_range(model: SensorModel, one: Sensitivity) -> tuple[float, float] | None:
    """Range of a channel that a sensitivity holds for; that of the model for pressure without one of its own."""
    return one.range or (model.pressure_range if one.channel == PRESSURE else None)


def _extremes(temperature: Array, reference: Array) -> tuple[float, float]:
    """Lowest and highest finite temperature (or other condition); those of the reference where none is finite."""
    if temperature.size:
        lowest, highest = float(temperature.min()), float(temperature.max())
        if np.isfinite(lowest) and np.isfinite(highest):
            return lowest, highest
    given = temperature[np.isfinite(temperature)]
    given = given if given.size else reference
    return float(given.min()), float(given.max())


def felt_range(matrices: Array, input_range: Array) -> Array:
    """Lowest and highest u = M x that each sensor meets, widened to hold zero, shape (k, 2) [input unit].

    Parameters
    ----------
    matrices : ndarray, shape (t, k, k)
        M at the temperatures to cover.
    input_range : ndarray, shape (k, 2)
        Of x, each axis by itself: the extremes of u lie at corners of that box.
    """
    one, other = matrices * input_range[:, 0], matrices * input_range[:, 1]
    lowest = np.minimum(one, other).sum(axis=2).min(axis=0)
    highest = np.maximum(one, other).sum(axis=2).max(axis=0)
    return np.column_stack([np.minimum(lowest, 0.0), np.maximum(highest, 0.0)])
