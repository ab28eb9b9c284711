"""A model as rows of results: every parameter with its uncertainty, or the reason why it has none."""

from __future__ import annotations

import numpy as np

from ...core.key import Reason
from ...core.results import Interval, Row, finite
from ...sensors.model.sensor_model import SensorModel, lines
from ...sensors.model.terms import values
from ...statistics.intervals import t_interval


def model_rows(model: SensorModel) -> tuple[Row, ...]:
    """Return a row a parameter, in SI and with full digits, in the order of the equation."""
    dofs = {} if model.estimate is None else dict(zip(model.estimate.names, model.estimate.dof, strict=True))
    numbers = values(model.parameters, model.terms)
    rows = []
    for one, value, line in zip(model.parameters, numbers, lines(model), strict=True):
        dof = float(dofs.get(one.name, np.nan))
        origin = model.provenance.get(one.name)
        rows.append(
            Row(
                one.key,
                float(value),
                line.u,
                one.unit,
                finite(dof),
                _interval(float(value), line.u, dof),
                "not_estimated" if line.u is None else "estimated",
                Reason("note", line.note),
                test=origin.test if origin is not None else "",
            )
        )
    return tuple(rows)


def _interval(value: float, u: float | None, dof: float) -> Interval | None:
    return t_interval(value, u, dof) if u is not None and dof > 0.0 else None
