"""Samples that thermal tests left out, sensor by sensor: a row a rule with its count.

What the chain left out (rails, built-in test) is told by ``exclusions``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..procedures.thermal import reduction as thermal
from ..procedures.thermal.fit.sensor import WORDS, OfSensor
from .requirements import Tested

RULES = ("warm_up", "turn_over", "one_path", "sparse")


def thermal_exclusions(tested: Sequence[Tested]) -> list[dict[str, Any]]:
    """Return what the thermal tests left out, in the order run.

    Parameters
    ----------
    tested : sequence of Tested
        Every test; those of other procedures are passed over.
    """
    return [
        _row(one, axis, sensor, rule)
        for one in tested
        if isinstance(one.result, thermal.Result)
        for axis, sensor in one.result.sensors.items()
        for rule in RULES
        if sensor.cells.left_out.get(rule)
    ]


def _row(one: Tested, axis: str, sensor: OfSensor, rule: str) -> dict[str, Any]:
    decided = {
        "warm_up": f"rule: warm_up = {sensor.start_up.cut:.4g} s",
        "turn_over": f"rule: turn_over = {sensor.series.turn_over:.4g} degC",
    }
    return {
        "test": one.test.id, "axis": axis, "place": "", "applied": None, "unit": "", "rule": rule,
        "decided_by": decided.get(rule, f"rule: {rule}"), "reason": WORDS[rule],
        "count": sensor.cells.left_out[rule], "counts": "sample",
    }  # fmt: skip
