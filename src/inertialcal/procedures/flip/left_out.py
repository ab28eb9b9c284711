"""What a flip did not read, as rows of the table of exclusions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..protocol import Exclusion
from .plan import Plan
from .readings import Readings

RULES = {"settling": ("settle", "window"), "no_reading": ("no_reading", "sample")}  # remark: what decided, what counts
UNREAD = {"dwell_incomplete": "missing", "gain_changed": "gain"}  # remark: what decided that an axis is not read


def left_out(plan: Plan, readings: Readings) -> Iterator[Exclusion]:
    """Yield starts of windows and samples as remarks count them, then dwells axis by axis."""
    for number, remark in enumerate(readings.remarks):
        if remark.code in RULES:
            key, counts = RULES[remark.code]
            yield Exclusion(remark.code, _decided(plan, key), remark.what, remark.where, count=remark.count,
                            counts=counts, place_in_list=number)  # fmt: skip
    for axis, values in readings.outputs.items():
        for why in [one for one in readings.remarks if one.code in UNREAD and one.axis == axis][:1]:
            for i in np.flatnonzero(np.isnan(values)):
                place = readings.where[i] if readings.where else ""
                yield Exclusion(why.code, _decided(plan, UNREAD[why.code]), why.what, place, axis, dwell=True)


def _decided(plan: Plan, key: str) -> str:
    value = getattr(plan, key, None)
    return f"rule: {key}" if value is None else f"rule: {key} = {value:g}"
