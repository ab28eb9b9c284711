"""Curves of a campaign, in the units of its sensors: rates in that of the sensor, relative errors in percent.

Applied rates and times go through SI and come out to ten digits, so that 3 deg/s is 3; so does what only a picture
shows (``trace``). Readings, residuals and errors keep all digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...procedures.display import displayed_curve
from ..engine.engine import ReducedTest, sensor_of
from ..file.load import Campaign
from ..models.content import named_models
from ..models.judged import JudgedModel


def curves_content(
    campaign: Campaign, tested: Sequence[ReducedTest], modelled: JudgedModel | None
) -> list[dict[str, Any]]:
    """Return the curves of all tests, and those of the closed loop, as ``results.json`` holds them.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of ReducedTest
        Every test.
    modelled : JudgedModel or None
        Model and closed loop.
    """
    found = []
    for one in tested:
        for kind, part in one.parts.items():
            unit = sensor_of(campaign, one.test, kind).unit
            found += [displayed_curve(curve, unit).to_dict(one.test.id) for curve in one.procedure.curves(part)]
    for one in tested:
        unit = sensor_of(campaign, one.test).unit
        found += [displayed_curve(curve, unit).to_dict(one.test.id) for curve in one.curves]
    for name, (unit, made) in named_models(campaign, modelled).items():
        found += [displayed_curve(curve, unit).to_dict(name) for curve in made.curves]
    return found
