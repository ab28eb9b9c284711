"""Standard uncertainty of a compensated reading, from the covariance of the model.

The reading fixes ``r = K0 + g(M x) + G f``. A small change of a parameter theta at a fixed reading moves x by
``dx/dtheta = -M^-1 diag(1/g'(u)) dr/dtheta`` (implicit function theorem), with dr/dtheta from the equation itself:
the Jacobian is analytic, one column a parameter. The bias from power-up to power-up, which compensation cannot
know, enters as an independent variance of each sensor. Noise of the reading, and the uncertainty of the
conditions given (temperature, ...), are not in it.

References
----------
.. [1] JCGM 100:2008 (GUM), clauses 5.1 and 5.2; JCGM 102:2011 for several outputs.
"""

from __future__ import annotations

from typing import Unpack

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from .compensate import compensate, pieces
from .equation import Conditions, condition_columns
from .matrices import inverted
from .sensitivity import point, reading_by
from .sensor_model import SensorModel


def compensated_uncertainty(model: SensorModel, readings: Array, **conditions: Unpack[Conditions]) -> Array:
    """Return the standard uncertainty of compensated readings.

    Parameters
    ----------
    readings : ndarray, shape (n, k)
        As for ``compensate`` [input unit].
    **conditions
        See ``equation.Conditions``.

    Returns
    -------
    ndarray, shape (n, k)
        [input unit]. Parameters that the estimate does not hold count as exact: `without_uncertainty` names them.

    Raises
    ------
    DataError
        ``no_covariance`` if the model carries none; and as ``compensate``.
    """
    if model.estimate is None:
        raise DataError(
            "the model carries no covariance",
            why="the uncertainty of a compensated reading comes from it",
            do="Use a model that a campaign has estimated",
            code="no_covariance",
        )
    x = compensate(model, readings, **conditions)
    columns = condition_columns(model, len(x), conditions)
    by_name = {one.name: one for one in model.parameters}
    held = [by_name[name] for name in model.estimate.names]
    covariance = model.estimate.covariance
    out = np.empty(x.shape)
    for part, here in pieces(columns, len(x)):
        at = point(model, x[part], here)
        to_input = inverted(at.matrix) / at.slope[:, np.newaxis, :]
        moved = to_input @ np.stack([reading_by(model, one, at) for one in held], axis=2)
        variance = np.einsum("nkp,nkp->nk", moved @ covariance, moved)
        if model.bias_run_to_run is not None:
            variance = variance + to_input**2 @ model.bias_run_to_run**2
        out[part] = np.sqrt(np.maximum(variance, 0.0))
    return out


def without_uncertainty(model: SensorModel) -> tuple[str, ...]:
    """Names of the parameters that no covariance covers."""
    held = set() if model.estimate is None else set(model.estimate.names)
    return tuple(one.name for one in model.parameters if one.name not in held)
