"""Bias on power-ups held out: as read, after the polynomial in air, and after that of their own condition.

The picture of the thesis (Figure 36) from results: temperature alone leaves in vacuum what the pressure does.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, Figure 36.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core.axes import AXES
from ..core.curve import Column, Curve
from ..procedures.thermal import reduction as thermal
from ..procedures.thermal.reduction import earth_along
from .load import Campaign
from .requirements import Tested
from .thermal_left import against_of

NAME = "overlay"


def overlays(campaign: Campaign, tested: Sequence[Tested]) -> list[tuple[str, Curve]]:
    """Return the curves of thermal tests held out, each with its test, SI."""
    by_name = {one.test.id: one for one in tested}
    found = []
    for one in tested:
        other = against_of(campaign.file.tests, one.test)
        if one.test.use != "hold_out" or not isinstance(one.result, thermal.Result) or other is None:
            continue
        own = by_name[other]
        first = by_name[own.test.against].result if own.test.against else own.result
        second = own.result if own.test.against else None
        found += [(one.test.id, curve) for curve in _of_test(one.result, first, second)]
    return found


def _of_test(held: thermal.Result, first: thermal.Result, second: thermal.Result | None) -> list[Curve]:
    """Return a curve an axis: after the first polynomial, and after the second where there is one."""
    made = []
    for axis, one in held.sensors.items():
        if axis not in first.sensors or (second is not None and axis not in second.sensors):
            continue
        columns: dict[str, Any] = {"temperature": Column(one.cells.temperature, "degC")}
        raw = one.cells.reading - earth_along(held.plan)[0][AXES.index(axis)]
        columns["raw"] = Column(raw, "rad/s")
        columns["by_temperature"] = Column(raw - _bias(first, axis, one.cells.temperature), "rad/s")
        if second is not None:
            left = raw - _bias(second, axis, one.cells.temperature)
            columns["by_temperature_and_pressure"] = Column(left, "rad/s")
        columns["run"] = Column([held.readings.labels[run] for run in one.cells.run])
        made.append(Curve(NAME, axis, columns))
    return made


def _bias(result: thermal.Result, axis: str, temperature: Any) -> Any:
    """Return the bias that a test found; NaN at temperatures where it is not known."""
    law = result.sensors[axis].law
    inside = (temperature >= law.domain[0]) & (temperature <= law.domain[1])
    value = law.basis(np.clip(temperature, *law.domain)) @ law.coefficients
    return np.where(inside, value - earth_along(result.plan)[0][AXES.index(axis)], np.nan)
