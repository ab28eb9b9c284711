"""Exclusions: what was not used, and who or which rule decided so.

A dwell that a rule leaves out has a row of its own for each sensor that leaves it out. What is left out by the
thousand (rows outside the groups and windows of a test, samples at the edges of dwells, samples while a built-in test
was low) is one row with its count.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..core.remarks import Remark
from ..core.units import convert
from ..procedures.display import ten_digits
from ..procedures.flip import reduction as flip
from ..procedures.rate_table import reduction as rate_table
from ..procedures.rate_table.exclusions import Mask
from ..procedures.static_noise import reduction as static_noise
from .engine import Prepared
from .load import Campaign
from .prepared import sensor_of
from .requirements import Tested
from .schema_sensors import Chain

# Rules on a dwell, by the code of their remark: the key of the plan that decided, and why.
RULES = {
    "at_rail": ("rail_scatters", "the rate or the reading is {:g} scatters or less from the end of the range"),
    "odd_scatter": (
        "scatter_ratio",
        "its scatter is more than {0:g} times, or less than 1/{0:g} of, that of its neighbours in rate",
    ),
    "dwell_incomplete": ("missing", "more than {:.0%} of its samples are missing, invalid or at the rail"),
}
# Rules on a sample, by the code of their remark: the key of the sensor's chain that decided.
SAMPLES = {"test_low": "validity_minimum", "rail": "counts"}
# Of a flip, by the code of their remark: what decided, and what its count counts; then why an axis is not read.
FLIP_RULES = {"settling": ("settle", "window"), "no_reading": ("no_reading", "sample")}
# Of a test of noise, by the code of a fault: why samples are no readings.
NO_READINGS = {"stuck": "one value repeated for too long", "saturated": "at the end of the range"}
UNREAD = {"dwell_incomplete": "missing", "gain_changed": "gain"}


def exclusion_rows(
    campaign: Campaign, prepared: Sequence[Prepared], tested: Sequence[Tested] = ()
) -> list[dict[str, Any]]:
    """Return what each test left out, in the order run.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : sequence of Prepared
        Every test.
    tested : sequence of Tested
        Every test as it was run: what a reduction itself leaves out.

    Returns
    -------
    list of dict
        ``count`` says how many of ``counts`` (``dwell``, ``row`` or ``sample``) a row is about.
    """
    found: list[dict[str, Any]] = []
    for one in prepared:
        sensor = sensor_of(campaign, one.test)
        found += _not_chosen(one)
        if isinstance(one.readings, rate_table.Readings):
            found += [*_samples(one, sensor.chain), *_dwells(one, sensor.unit)]
        elif isinstance(one.readings, flip.Readings):
            found += _of_flip(one, sensor.chain)
        elif isinstance(one.readings, static_noise.Readings):
            result = next((other.result for other in tested if other.test is one.test), None)
            found += _of_noise(one, result, sensor.chain)
        else:
            said = one.readings.remarks
            found += [_by_chain(one, remark, sensor.chain) for remark in said if remark.code in SAMPLES]
    return found


def _of_noise(one: Prepared, result: static_noise.Result | None, chain: Chain) -> Iterator[dict[str, Any]]:
    """Yield what a test of noise did not use: the warm-up, disturbances, and samples that the chain left out."""
    for remark in one.readings.remarks:
        if remark.code in SAMPLES:
            yield _by_chain(one, remark, chain)
    for record in one.readings.records:
        if record.warm_up:
            decided = f"campaign: warm_up = {one.plan.warm_up:g} s"
            yield _row(one, "warm_up", decided, "the warm-up", record.name, count=record.warm_up, counts="sample")
        for fault in record.faults:
            if fault.left_out:
                decided = f"rule: disturbed = {one.plan.disturbed}"
                reason = NO_READINGS[fault.code]
                yield _row(one, fault.code, decided, reason, record.name, fault.axis, count=fault.count,
                           counts="sample")  # fmt: skip
    for axis in result.axes if result is not None else ():
        for found in axis.records:
            if found.looked.left_out:
                decided = f"rule: disturbed = {one.plan.disturbed}"
                count = found.looked.left_out
                reason = f"disturbances at {len(found.looked.bad)} place(s)"
                yield _row(one, "disturbed", decided, reason, found.run.name, axis.axis, count=count, counts="sample")


def _dwells(one: Prepared, unit: str) -> Iterator[dict[str, Any]]:
    """Yield a row for each dwell that a rule left out."""
    incomplete = one.readings.incomplete
    if incomplete is not None:
        yield from _of_rule(one, "dwell_incomplete", "", incomplete, unit)
    for sensor in one.readings.outputs:
        masks = rate_table.exclusions(one.plan, one.readings, sensor)
        yield from _of_rule(one, "at_rail", sensor, masks.rail, unit)
        yield from _of_rule(one, "odd_scatter", sensor, masks.scatter, unit)


def _of_rule(one: Prepared, rule: str, axis: str, mask: Mask, unit: str) -> Iterator[dict[str, Any]]:
    key, reason = RULES[rule]
    value = getattr(one.plan, key)
    rates = convert(one.readings.applied, "rad/s", unit)
    for i in np.flatnonzero(mask):
        place = one.readings.where[i] if one.readings.where else ""
        decided, why = f"rule: {key} = {value:g}", reason.format(value)
        yield _row(one, rule, decided, why, place, axis, ten_digits(float(rates[i])), unit)


def _not_chosen(one: Prepared) -> Iterator[dict[str, Any]]:
    """Yield a row for each recording of which the campaign takes a part, and for dwells without a rate."""
    by = [name for name in ("groups", "windows") if getattr(one.test, name) is not None]
    for origin in one.origins:
        if origin.not_chosen:
            decided, reason = f"campaign: {', '.join(by)}", f"outside the {' and '.join(by)} of the test"
            yield _row(one, "not_chosen", decided, reason, origin.file, count=origin.not_chosen, counts=origin.counts)
        if origin.without_rate:
            reason = "the applied rate is missing"
            yield _row(one, "no_rate", "rule: applied", reason, origin.file, count=origin.without_rate, counts="row")


def _samples(one: Prepared, chain: Chain) -> Iterator[dict[str, Any]]:
    """Yield what was left out sample by sample: at edges and as outliers of dwells, and by the chain."""
    files = [origin.file for origin in one.origins if origin.kind == "recording"]
    for file, tally in zip(files, one.readings.tallies, strict=True):
        ways = (
            ("edge", "first and last sample of a dwell: its average may reach into the ramp", tally.edge_dropped),
            ("outlier", "single outlier in a dwell", tally.outliers),
        )
        for rule, reason, count in ways:
            if count:
                yield _row(one, rule, f"rule: {rule}", reason, file, count=count, counts="sample")
    for remark in one.readings.remarks:
        if remark.code in SAMPLES:
            yield _by_chain(one, remark, chain)


def _of_flip(one: Prepared, chain: Chain) -> Iterator[dict[str, Any]]:
    """Yield what a flip did not read: samples and starts of windows as its remarks count them, dwells axis by axis."""
    for remark in one.readings.remarks:
        if remark.code in SAMPLES:
            yield _by_chain(one, remark, chain)
        elif remark.code in FLIP_RULES:
            key, counts = FLIP_RULES[remark.code]
            decided = _by_plan(one, key)
            yield _row(one, remark.code, decided, remark.what, remark.where, count=remark.count, counts=counts)
    for axis, values in one.readings.outputs.items():
        said = next((r for r in one.readings.remarks if r.code in UNREAD and r.axis == axis), None)
        if said is None:
            continue
        for i in np.flatnonzero(np.isnan(values)):
            place = one.readings.where[i] if one.readings.where else ""
            yield _row(one, said.code, _by_plan(one, UNREAD[said.code]), said.what, place, axis)


def _by_plan(one: Prepared, key: str) -> str:
    value = getattr(one.plan, key, None)
    return f"rule: {key}" if value is None else f"rule: {key} = {value:g}"


def _by_chain(one: Prepared, remark: Remark, chain: Chain) -> dict[str, Any]:
    key = SAMPLES[remark.code]
    value = getattr(chain, key)
    said = f"{value:g} V" if isinstance(value, float) else f"{list(value or ())}"
    decided = f"rule: {key} = {said}"
    return _row(one, remark.code, decided, remark.what, remark.where, count=remark.count, counts="sample")


def _row(
    one: Prepared,
    rule: str,
    decided_by: str,
    reason: str,
    place: str,
    axis: str = "",
    applied: float | None = None,
    unit: str = "",
    count: int = 1,
    counts: str = "dwell",
) -> dict[str, Any]:
    return {
        "test": one.test.id, "axis": axis, "place": place, "applied": applied, "unit": unit, "rule": rule,
        "decided_by": decided_by, "reason": reason, "count": count, "counts": counts,
    }  # fmt: skip
