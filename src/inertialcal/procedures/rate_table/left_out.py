"""What a rate table did not use, as rows of the table of exclusions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..protocol import Exclusion
from .exclusions import Mask, exclusions
from .plan import Plan
from .readings import Readings

# Rules on a dwell, by the code of their remark: the key of the plan that decided, and why.
RULES = {
    "at_rail": ("rail_scatters", "the rate or the reading is {:g} scatters or less from the end of the range"),
    "odd_scatter": (
        "scatter_ratio",
        "its scatter is more than {0:g} times, or less than 1/{0:g} of, that of its neighbours in rate",
    ),
    "dwell_incomplete": ("missing", "more than {:.0%} of its samples are missing, invalid or at the rail"),
}


def samples_left_out(readings: Readings) -> Iterator[Exclusion]:
    """Yield what was left out sample by sample, recording by recording: edges and outliers of dwells."""
    for file, tally in zip(readings.files, readings.tallies, strict=True):
        ways = (
            ("edge", "first and last sample of a dwell: its average may reach into the ramp", tally.edge_dropped),
            ("outlier", "single outlier in a dwell", tally.outliers),
        )
        for rule, reason, count in ways:
            if count:
                yield Exclusion(rule, f"rule: {rule}", reason, file, count=count, counts="sample")


def dwells_left_out(plan: Plan, readings: Readings) -> Iterator[Exclusion]:
    """Yield each dwell that a rule left out, for each sensor that leaves it out."""
    if readings.incomplete is not None:
        yield from _of_rule(plan, readings, "dwell_incomplete", "", readings.incomplete)
    for sensor in readings.outputs:
        masks = exclusions(plan, readings, sensor)
        yield from _of_rule(plan, readings, "at_rail", sensor, masks.rail)
        yield from _of_rule(plan, readings, "odd_scatter", sensor, masks.scatter)


def _of_rule(plan: Plan, readings: Readings, rule: str, axis: str, mask: Mask) -> Iterator[Exclusion]:
    key, reason = RULES[rule]
    value = getattr(plan, key)
    for i in np.flatnonzero(mask):
        place = readings.where[i] if readings.where else ""
        applied = float(readings.applied[i])
        yield Exclusion(rule, f"rule: {key} = {value:g}", reason.format(value), place, axis,
                        applied=applied, unit="rad/s", dwell=True)  # fmt: skip
