"""Bias on power-ups held out: as read, after the polynomial in air, and after that of their own condition.

The picture of the thesis (Figure 36) from results: temperature alone leaves in vacuum what the pressure does.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, Figure 36.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ....core.axes import AXES
from ....core.curve import Column, Curve
from ..fit.earth import earth_along
from ..reduction import Result

NAME = "overlay"


def overlays(held: Result, first: Result, second: Result | None) -> tuple[Curve, ...]:
    """Return a curve an axis: after the first polynomial, and after the second where there is one.

    Parameters
    ----------
    held : Result
        Of power-ups held out.
    first, second : Result, Result or None
        Of the fit in air, and of that in the condition of those held out; of one condition, the first alone.
    """
    made, unit = [], held.readings.unit
    earth = earth_along(held.plan)[0] if unit == "rad/s" else np.zeros(len(AXES))
    for axis, one in held.sensors.items():
        if axis not in first.sensors or (second is not None and axis not in second.sensors):
            continue
        columns: dict[str, Any] = {"temperature": Column(one.cells.temperature, "degC")}
        raw = one.cells.reading - earth[AXES.index(axis)]
        columns["raw"] = Column(raw, unit)
        columns["by_temperature"] = Column(raw - _bias(first, axis, one.cells.temperature), unit)
        if second is not None:
            left = raw - _bias(second, axis, one.cells.temperature)
            columns["by_temperature_and_pressure"] = Column(left, unit)
        columns["run"] = Column([held.readings.labels[run] for run in one.cells.run])
        made.append(Curve(NAME, axis, columns))
    return tuple(made)


def _bias(result: Result, axis: str, temperature: Any) -> Any:
    """Return the bias that a test found; NaN at temperatures where it is not known."""
    law = result.sensors[axis].law
    inside = (temperature >= law.domain[0]) & (temperature <= law.domain[1])
    value = law.basis(np.clip(temperature, *law.domain)) @ law.coefficients
    return np.where(inside, value - earth_along(result.plan)[0][AXES.index(axis)], np.nan)
