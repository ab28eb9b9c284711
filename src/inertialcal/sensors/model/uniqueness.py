"""Whether a reading tells the input: the model's inverse must be unique over its validity range."""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from .equation import Columns, curve, matrix_at
from .nonlinearity import LOWEST_SLOPE, rising_branch, smallest_slope
from .sensor_model import SensorModel

LARGEST_CONDITION = 1e4  # of M: input axes nearer to one plane than this lose four digits
NODES = 33  # temperatures at which M(T) is looked at


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
    if not model.linear:
        _check_curves(model, matrices)


def _matrices(model: SensorModel, columns: Columns) -> Array:
    if model.matrix.shape[0] == 1:
        return model.matrix
    ends = model.temperature_range or _extremes(columns["temperature"], np.asarray(model.reference_temperature))
    return matrix_at(model, {"temperature": np.linspace(*ends, NODES)[:, np.newaxis]})


def _extremes(temperature: Array, reference: Array) -> tuple[float, float]:
    """Lowest and highest finite temperature; those of the reference where none is finite."""
    if temperature.size:
        lowest, highest = float(temperature.min()), float(temperature.max())
        if np.isfinite(lowest) and np.isfinite(highest):
            return lowest, highest
    given = temperature[np.isfinite(temperature)]
    given = given if given.size else reference
    return float(given.min()), float(given.max())


def _check_curves(model: SensorModel, matrices: Array) -> None:
    bent = curve(model)
    if model.input_range is None:
        ends = rising_branch(bent)
        if np.all(np.isinf(ends)):
            return
        axis = model.axes[int(np.argmax(np.any(np.isfinite(ends), axis=1)))]
        raise DataError(
            f"the {axis} sensor's curve turns and the model has no input range",
            why="beyond the turn two inputs give one reading",
            do="Give input_range",
            code="no_validity_range",
        )
    slope = smallest_slope(bent, felt_range(matrices, model.input_range))
    worst = int(np.argmin(slope))
    if slope[worst] < LOWEST_SLOPE:
        raise DataError(
            f"the {model.axes[worst]} sensor's slope comes down to {slope[worst]:.3g} inside the validity range, "
            f"need {LOWEST_SLOPE:g} or more",
            why="two inputs give one reading",
            do="Narrow input_range, or fit a lower order",
            code="not_unique",
        )


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
