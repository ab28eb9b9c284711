"""Exclusions: what was not used, and who or which rule decided so.

A dwell that a rule leaves out has a row of its own for each sensor that leaves it out. What is left out by the
thousand (rows outside the groups and windows of a test, samples at the edges of dwells, samples while a built-in test
was low) is one row with its count. What a procedure leaves out it says itself; what was not chosen and what the chain
left out is found here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from ...core.remarks import Remark
from ...core.units import convert
from ...procedures.display import ten_digits
from ...procedures.protocol import Exclusion
from ..engine.engine import Prepared, ReducedTest, sensor_of
from ..file.load import Campaign
from ..file.sensors import Chain

# Rules on a sample, by the code of their remark: the key of the sensor's chain that decided.
SAMPLES = {"test_low": "validity_minimum", "rail": "counts"}


class LeftOut(NamedTuple):
    """What a test left out, and the unit that its sensor speaks."""

    test: str
    unit: str
    what: Exclusion


def left_out(campaign: Campaign, prepared: Sequence[Prepared], tested: Sequence[ReducedTest]) -> list[LeftOut]:
    """Return what each test left out, in the order run.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : sequence of Prepared
        Every test.
    tested : sequence of ReducedTest
        The same as they were run.
    """
    found = []
    for one, reduced in zip(prepared, tested, strict=True):
        sensor = sensor_of(campaign, one.test)
        mine = [
            *_not_chosen(one),
            *_by_chain(one, sensor.chain),
            *one.screened,
            *reduced.procedure.exclusions(reduced.tested),
        ]
        found += [LeftOut(one.test.id, sensor.unit, what) for what in mine]
    return found


def exclusion_rows(found: Sequence[LeftOut]) -> list[dict[str, Any]]:
    """Return the rows of ``results.json``.

    Returns
    -------
    list of dict
        ``count`` says how many of ``counts`` (``dwell``, ``row`` or ``sample``) a row is about.
    """
    return [_row(*one) for one in found]


def _row(test: str, unit: str, what: Exclusion) -> dict[str, Any]:
    applied = what.applied
    return {
        "test": test, "axis": what.axis, "place": what.place,
        "applied": None if applied is None else ten_digits(float(convert(applied, what.unit, unit))),
        "unit": "" if applied is None else unit, "rule": what.rule,
        "decided_by": what.decided_by, "reason": what.reason,
        "count": what.count, "counts": what.counts,
    }  # fmt: skip


def _not_chosen(one: Prepared) -> Iterator[Exclusion]:
    """Yield a row for each recording of which the campaign takes a part, and for dwells without a rate."""
    by = [name for name in ("groups", "windows") if getattr(one.test, name) is not None]
    for origin in one.origins:
        if origin.not_chosen:
            decided, reason = f"campaign: {', '.join(by)}", f"outside the {' and '.join(by)} of the test"
            yield Exclusion("not_chosen", decided, reason, origin.file, count=origin.not_chosen, counts=origin.counts)
        if origin.without_rate:
            reason = "the applied rate is missing"
            yield Exclusion("no_rate", "rule: applied", reason, origin.file, count=origin.without_rate, counts="row")


def _by_chain(one: Prepared, chain: Chain) -> Iterator[Exclusion]:
    """Yield what the chain left out."""
    for remark in one.readings.remarks:
        if remark.code in SAMPLES:
            yield Exclusion(remark.code, _decided(remark, chain), remark.what, remark.where, count=remark.count,
                            counts="sample")  # fmt: skip


def _decided(remark: Remark, chain: Chain) -> str:
    key = SAMPLES[remark.code]
    value = getattr(chain, key)
    said = f"{value:g} V" if isinstance(value, float) else f"{list(value or ())}"
    return f"rule: {key} = {said}"
