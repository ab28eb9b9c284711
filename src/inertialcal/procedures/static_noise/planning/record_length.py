"""How long to record: for each term what these records tell of it, and what a record for a wanted error would take.

A term that was found has the relative error of this fit; the record that brings it to the wanted one is that of the
planner (``sensors.noise.planner``), which takes all found terms as they are and as fitted together, and is long enough
for the term to be named again. A term that was not found has the record that would show it if it were at its upper
limit.
"""

from __future__ import annotations

from dataclasses import dataclass

from ....core.errors import InertialcalError
from ....sensors.noise.fitting.noise_fit import TermEstimate, duration
from ....sensors.noise.planner import plan_record
from ....sensors.noise.terms import Sinusoid
from ..axis_noise import FAST, AxisNoise
from ..plan import Plan


@dataclass(frozen=True)
class Reach:
    """What the records tell of one term, and how long one would have to be."""

    # Its word in ``sensors.noise``, and the field's word of its size
    term: str
    quantity: str
    relative_error: float | None  # Standard uncertainty over value; None for a term that was not found
    record: float  # Length of the longest record [s]
    # Length that gives the wanted error, or shows the term [s]; at most ``record`` where these records do it already;
    # None where no record that can be planned does
    needed: float | None
    reason: str = ""  # Why a term was not found, or what one that was could be as well
    doubt: str = ""  # Why the figures of the axis may not hold


def reaches(plan: Plan, found: AxisNoise) -> tuple[Reach, ...]:
    """Return what the records tell of each term of an axis; nothing where there are no terms."""
    if found.fit is None:
        return ()
    record = max(one.run.length for one in found.records)
    known = (term for term in found.fit.found if term.name in FAST or not found.slow_fault)
    return tuple(_reach(plan, found, term, record) for term in known if term.name != Sinusoid.name)


def _reach(plan: Plan, found: AxisNoise, term: TermEstimate, record: float) -> Reach:
    if term.status != "estimated":
        return Reach(term.name, term.words[0], None, record, term.record_needed, term.reason)
    first = term.parameters[0]
    error = first.u / first.value
    needed = record if error <= plan.relative_error else _planned(plan, found, term.name)
    if needed is not None and error > plan.relative_error and needed <= record:  # the planner takes the terms as known
        needed = record * (error / plan.relative_error) ** 2
    return Reach(term.name, first.name, error, record, needed, term.reason, found.doubt)


def _planned(plan: Plan, found: AxisNoise, name: str) -> float | None:
    assert found.fit is not None  # noqa: S101 - checked before
    run = found.records[0].run
    terms = tuple(term for term in found.fit.terms if not isinstance(term, Sinusoid))
    try:
        length = plan_record(terms, name, plan.relative_error, run.interval, run.averaging).record
    except InertialcalError:
        return None
    return length if length < float("inf") else None


def sentence(reach: Reach, wanted: float) -> str:
    """Return what to say of one term: how well it is known, and how long to record."""
    name = reach.quantity.replace("_", " ")
    if reach.relative_error is None:
        why = f"{name}: not found, {reach.reason}"
        if reach.needed is None or reach.needed <= reach.record:
            return why
        return f"{why}; {duration(reach.needed)} would show it at its limit"
    if reach.doubt:
        return f"{name}: in doubt: {reach.doubt}"
    known = f"{name}: known to {100.0 * reach.relative_error:.2g} %"
    if reach.reason:
        known += f", but {reach.reason.replace('_', ' ')}"
    if reach.relative_error <= wanted:
        return known
    aim = f"for {100.0 * wanted:.3g} %"
    if reach.needed is None:
        return f"{known}; no practical record is long enough {aim}"
    return f"{known}; record {duration(max(reach.needed, reach.record))} {aim}"
