"""Samples that are no readings: stretches in which one value is stuck, and codes at the end of the range.

They are left out and counted. A stuck stretch has no noise, so that terms fitted across it are too small. What lies at
the end of the range was cut there: left out, too, but where noise itself reaches so far, what is left of it is too
small, which is remarked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....core.remarks import Remark
from ....core.show.rounding import number
from ....signals.codes import levels_of, rails
from ....signals.record_quality import BadSegment, stuck_stretches
from ..plan import Plan
from ..readings import Fault, Run

LISTED = 3  # stretches of an axis that are named
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Told:
    """How a sample of an axis is told."""

    times: float  # What a value is multiplied by
    unit: str  # Of the product; empty where nobody said
    row: Callable[[int], int]  # Gives the row of the file of a sample; 0 where it has none

    def value(self, value: float) -> str:
        """Return a value with its unit.

        Parameters
        ----------
        value : float
            As it was sampled.
        """
        return f"{number(value * self.times, 5)} {self.unit}".strip()


@dataclass(frozen=True, eq=False)
class _Bad:
    """Samples of one axis that are no readings: masks of shape (n,), and the values at the ends of the range."""

    stretches: tuple[BadSegment, ...]
    stuck: Mask
    saturated: Mask
    ends: tuple[float, ...]


def without_faults(plan: Plan, run: Run, told: Mapping[str, Told]) -> tuple[Run, list[Remark]]:
    """Return a record without the samples that are no readings, and what there is to say of them.

    Parameters
    ----------
    plan : Plan
        Its ``disturbed`` says whether they are kept.
    run : Run
        The record.
    told : mapping of str to Told
        How a sample is told, by axis.
    """
    found = {axis: _bad(run, axis) for axis in run.values}
    found = {axis: bad for axis, bad in found.items() if bad.stretches or bad.ends}
    if not found:
        return run, []
    left_out = plan.disturbed == "leave_out"
    fate = "left out" if left_out else "kept in"
    remarks = [_stuck(run, axis, bad, told[axis], fate) for axis, bad in found.items() if bad.stretches]
    remarks += _saturated(run, found, told, fate)
    faults = tuple(fault for axis, bad in found.items() for fault in _faults(axis, bad, left_out))
    if not left_out:
        return replace(run, faults=faults), remarks
    present = {axis: run.there(axis) & ~bad.stuck & ~bad.saturated for axis, bad in found.items()}
    return replace(run, present={**run.present, **present}, faults=faults), remarks


def _bad(run: Run, axis: str) -> _Bad:
    values, there = run.values[axis], run.there(axis)
    stretches = stuck_stretches(np.where(there, values.astype(np.float64), np.nan), run.interval)
    stuck = np.zeros(len(values), dtype=bool)
    for one in stretches:
        stuck[one.first : one.last + 1] = there[one.first : one.last + 1]
    rest = there & ~stuck
    ends = tuple(rail.value for rail in rails(levels_of(values[rest]))) if rest.any() else ()
    return _Bad(stretches, stuck, rest & np.isin(values, ends) if ends else np.zeros_like(stuck), ends)


def _faults(axis: str, bad: _Bad, left_out: bool) -> Iterator[Fault]:
    if bad.stuck.any():
        yield Fault(axis, "stuck", int(bad.stuck.sum()), left_out)
    if bad.saturated.any():
        yield Fault(axis, "saturated", int(bad.saturated.sum()), left_out)


def _stuck(run: Run, axis: str, bad: _Bad, told: Told, fate: str) -> Remark:
    """Return one remark on the stuck stretches of an axis, the longest first."""
    places = []
    for one in bad.stretches[:LISTED]:
        value = told.value(float(run.values[axis][one.first]))
        row = f" (row {told.row(one.first)})" if told.row(one.first) else ""
        places.append(f"at {value} from {number(run.time(one.first), 6)} s to {number(run.time(one.last), 6)} s{row}")
    more = "; ..." if len(bad.stretches) > LISTED else ""
    what = f"{axis}: stuck {'; '.join(places)}{more}: {int(bad.stuck.sum())} of {len(run)} samples {fate}"
    return Remark("stuck", "warning", what, count=len(bad.stretches), do="Look at the wiring and at the logger")


def _saturated(run: Run, found: Mapping[str, _Bad], told: Mapping[str, Told], fate: str) -> list[Remark]:
    """Return one remark on the samples of all axes that lie at an end of the range."""
    each = [
        f"{axis} {int(bad.saturated.sum())} at {' and '.join(map(told[axis].value, bad.ends))}"
        for axis, bad in found.items()
        if bad.ends
    ]
    if not each:
        return []
    what = f"saturated: samples lie at the end of the range: {', '.join(each)}, of {len(run)}; {fate}"
    do = "Noise that reaches so far is cut, and seems too small: change the range"
    return [Remark("saturated", "warning", what, do=do)]
