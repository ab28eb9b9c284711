"""Which dwells are left out, by which stated rule.

Two rules, both on what a dwell shows by itself, never on how well it fits the line:

rail
    The rate or the reading lies within ``rail_scatters`` scatters of the end of the range: part of the
    samples is clipped, so the mean reads too little and the scatter is too small.
scatter
    The scatter within the dwell is more than ``scatter_ratio`` times, or less than 1 / ``scatter_ratio`` of
    the median of its neighbours in rate: the table was not settled, or the sensor saturated or hung.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.remarks import Remark
from ..protocol import Exclusion
from .plan import Plan
from .readings import Readings
from .turned import nearest

Mask = NDArray[np.bool_]


class Exclusions(NamedTuple):
    """Rules by which dwells of one sensor are left out, shape (n,) each; and the remarks."""

    rail: Mask
    scatter: Mask
    remarks: tuple[Remark, ...]

    @property
    def any(self) -> Mask:
        """Dwells left out by any rule."""
        return self.rail | self.scatter


def exclusions(plan: Plan, readings: Readings, sensor: str) -> Exclusions:
    """Find the dwells of a sensor that are not to be used."""
    scatter = readings.scatters.get(sensor)
    output, none = readings.outputs[sensor], np.zeros(len(readings), dtype=bool)
    if scatter is None and plan.input_range is None:
        return Exclusions(none, none, ())
    read = np.isfinite(output)
    rail = (
        none if plan.input_range is None else at_rail(plan, readings.applied, output, readings.axis == sensor, scatter)
    )
    odd = none if scatter is None else odd_scatter(plan, readings, scatter)
    rail, odd = rail & read, odd & read & ~rail
    return Exclusions(rail, odd, tuple(_remarks(plan, readings, sensor, rail, odd)))


def at_rail(plan: Plan, applied: Array, output: Array, own: Mask, scatter: Array | None) -> Mask:
    """Return True where the rate about the sensor's own axis, or its reading, is at the end of the range."""
    assert plan.input_range is not None  # noqa: S101 - for the type checker
    low, high = plan.input_range
    margin = plan.rail_scatters * (np.zeros_like(applied) if scatter is None else np.nan_to_num(scatter))
    beyond = (output + margin >= high) | (output - margin <= low)
    turned = own & ((applied + margin >= high) | (applied - margin <= low))
    return np.asarray(beyond | turned)


def odd_scatter(plan: Plan, readings: Readings, scatter: Array) -> Mask:
    """Return True where a scatter is far from that of the neighbours in rate about the same axis."""
    odd = np.zeros(len(readings), dtype=bool)
    for axis in readings.turned.axes:
        at = np.flatnonzero((readings.axis == axis) & np.isfinite(scatter))
        if at.size <= plan.neighbours:
            continue  # too few to say what is usual
        whole = len(at) == np.count_nonzero(readings.axis == axis)
        sizes, count = np.abs(readings.applied[at]), plan.neighbours
        near = readings.turned.neighbours(axis, count) if whole else nearest(sizes, count)
        usual = np.median(scatter[at][near], axis=1)
        own = scatter[at]
        told = (own > 0.0) & (usual > 0.0)  # a scatter printed as zero is one below its rounding
        odd[at] = told & ((own > plan.scatter_ratio * usual) | (own * plan.scatter_ratio < usual))
    return odd


def _remarks(plan: Plan, readings: Readings, sensor: str, rail: Mask, odd: Mask) -> list[Remark]:
    found = []
    scatter = readings.scatters.get(sensor)
    if rail.any():
        rates = _rates(readings, rail)
        what = f"{sensor} sensor: readings at the end of the range left out ({rates})"
        found.append(
            Remark(
                "at_rail", "warning", what, _place(readings, rail), int(rail.sum()), "Both results are given", sensor
            )
        )
    if odd.any() and scatter is not None:
        usual = float(np.nanmedian(scatter))
        far = scatter[odd][np.argmax(np.abs(np.log(np.maximum(scatter[odd], 1e-300) / max(usual, 1e-300))))]
        ratio = f"{plan.scatter_ratio:g}"
        what = (
            f"{sensor} sensor: scatter more than {ratio} times, or less than 1/{ratio} of, that of the neighbouring"
            f" rates: left out ({_rates(readings, odd)}; farthest: {far / usual:.3g} times the median of all)"
        )
        found.append(
            Remark(
                "odd_scatter",
                "warning",
                what,
                _place(readings, odd),
                int(odd.sum()),
                "Both results are given",
                sensor,
            )
        )
    return found


def _rates(readings: Readings, mask: Mask) -> str:
    rates = sorted({round(float(rate), 12) for rate in np.degrees(readings.applied[mask])})
    return ", ".join(f"{rate:+g}" for rate in rates) + " deg/s"


def _place(readings: Readings, mask: Mask) -> str:
    places = [readings.where[i] for i in np.flatnonzero(mask).tolist()] if readings.where else []
    return ", ".join(places[:4]) + (", ..." if len(places) > 4 else "")


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
    for i in np.flatnonzero(mask).tolist():
        place = readings.where[i] if readings.where else ""
        applied = float(readings.applied[i])
        yield Exclusion(rule, f"rule: {key} = {value:g}", reason.format(value), place, axis,
                        applied=applied, unit="rad/s", dwell=True)  # fmt: skip
