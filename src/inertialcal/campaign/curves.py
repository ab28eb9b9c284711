"""Curves of a campaign, in the units of its sensors: rates in that of the sensor, relative errors in percent.

Applied rates and times go through SI and come out to ten digits, so that 3 deg/s is 3; so does what only a picture
shows (``trace``). Readings, residuals and errors keep all digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..core.curve import Column, Curve
from ..procedures.display import displayed_curve
from ..procedures.rate_table.closed_loop import HeldOut
from .load import Campaign
from .modelling import Modelled
from .overlays import overlays
from .prepared import modelled_sensor, sensor_of
from .requirements import Tested


def curves_content(campaign: Campaign, tested: Sequence[Tested], modelled: Modelled | None) -> list[dict[str, Any]]:
    """Return the curves of all tests, and those of the closed loop, as ``results.json`` holds them.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of Tested
        Every test.
    modelled : Modelled or None
        Model and closed loop.
    """
    found = []
    for one in tested:
        unit = sensor_of(campaign, one.test).unit
        found += [displayed_curve(curve, unit).to_dict(one.test.id) for curve in one.procedure.curves(one.result)]
    units = {one.test.id: sensor_of(campaign, one.test).unit for one in tested}
    found += [displayed_curve(curve, units[test]).to_dict(test) for test, curve in overlays(campaign, tested)]
    if modelled is not None:
        unit = modelled_sensor(campaign).unit
        found += [displayed_curve(compensated(one), unit).to_dict("model") for one in modelled.errors]
    return found


def compensated(one: HeldOut) -> Curve:
    """Return the errors of the dwells held out of one axis, before and after compensation [rad/s]."""
    return Curve(
        "compensated",
        one.axis,
        {
            "applied": Column(one.applied, "rad/s"),
            "raw_error": Column(one.raw, "rad/s"),
            "compensated_error": Column(one.compensated, "rad/s"),
            "run": Column(one.run),
        },
    )
