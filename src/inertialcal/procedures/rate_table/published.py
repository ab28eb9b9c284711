"""The reduction of the NPS thesis, as published: one unweighted straight line through all readings.

Volts over rate, every dwell of every sample set with the same weight, nothing left out, standard errors from
the residual mean square (Appendices E to J). It stands beside the default with ``Method.TEXTBOOK``.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, section IV.E and Appendices E to J.
"""

from __future__ import annotations

import numpy as np

from ...core.key import Key, Method, Reason
from ...core.results import Row, not_estimated
from ...statistics.intervals import t_interval
from ...statistics.least_squares import fit
from .plan import Plan
from .readings import Readings


def published_rows(plan: Plan, readings: Readings, sensor: str) -> list[Row]:
    """Return slope and intercept of the published fit of a sensor turned about its own axis.

    In volts where the plan has an ideal scale factor, else in the unit of the readings.
    """
    volts = None if plan.scale_factor is None else plan.scale_factor.get(sensor)
    units = ("V/(rad/s)", "V") if volts is not None else ("1", "rad/s")
    names = ("scale_factor", "intercept")
    own = (readings.axis == sensor) & np.isfinite(readings.outputs[sensor])
    if np.sum(own) < 3 or len(np.unique(readings.applied[own])) < 2:
        reason = Reason("few_dwells", "needs three dwells or more at two rates or more")
        return [
            not_estimated(Key(name, sensor), unit, reason, Method.TEXTBOOK)
            for name, unit in zip(names, units, strict=True)
        ]
    x = readings.applied[own]
    y = readings.outputs[sensor][own] * (1.0 if volts is None else volts)
    found = fit(np.column_stack([x, np.ones_like(x)]), y, names=names)
    assert found.covariance is not None  # noqa: S101 - more dwells than coefficients
    us = np.sqrt(np.diag(found.covariance))
    told = f"unweighted line through all {len(y)} dwells; its uncertainty takes them as independent"
    return [
        Row(
            Key(name, sensor),
            float(value),
            float(u),
            unit,
            float(found.dof),
            t_interval(float(value), float(u), found.dof),
            reason=Reason("limits", told),
            method=Method.TEXTBOOK,
        )
        for name, value, u, unit in zip(names, found.coefficients, us, units, strict=True)
    ]
