"""Remarks on a time axis: gaps, repeated and unsorted stamps, stamps of arrival, late saves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...core.remarks import Remark
from ...signals.time.time_axis import TimeAxis

RATES_AGREE = 0.01  # relative difference of two sample rates that is passed over


def axis_remarks(axis: TimeAxis, row: Callable[[int], str]) -> tuple[Remark, ...]:
    """Return what a user should know about the stamps.

    Parameters
    ----------
    axis : TimeAxis
        Judged stamps.
    row : callable
        Gives ``file:row`` of a sample.
    """
    remarks = []
    if len(axis.repeated):
        remarks.append(_counted("repeated_stamps", "stamp equal to the one before it", axis.repeated, row))
    if len(axis.backward):
        remarks.append(_counted("unsorted_stamps", "stamp earlier than the one before it", axis.backward, row))
    if axis.pattern == "bursts" and axis.interval is not None:
        what = (
            f"stamps come in bursts: steps of {_si(axis.median_step)} (median) up to "
            f"{_si(axis.longest_step)}, {_si(axis.interval)} on average, which is taken as sample interval"
        )
        do = "If the sensor samples evenly, say its rate: --sample-rate"
        remarks.append(Remark("stamps_in_bursts", "warning", what, where=row(0), do=do))
    if len(axis.gaps) and axis.interval is not None:
        longest = float(axis.gaps.length.max())
        steps = ", ".join(f"{_si(step)} x{count}" for step, count in axis.steps[:6])
        what = (
            f"gap: {axis.lost} sample(s) missing in all, longest step {_si(longest)} "
            f"against {_si(axis.interval)} (steps: {steps})"
        )
        where = row(int(axis.gaps.after[0]))
        remarks.append(Remark("gaps", "warning", what, where=where, count=len(axis.gaps)))
    return tuple(remarks)


def rate_remark(axis: TimeAxis, interval: float, path: str) -> tuple[Remark, ...]:
    """Remark where the stamps disagree with a sample interval [s] that was said."""
    if axis.interval is None or abs(axis.interval - interval) <= RATES_AGREE * interval:
        return ()
    what = f"{1.0 / interval:.6g} Hz was said, the stamps say {1.0 / axis.interval:.6g} Hz"
    return (Remark("rate_disagrees", "warning", what, where=path, do="Check the rate and the unit of time"),)


def _counted(code: str, what: str, at: np.ndarray[tuple[int], np.dtype[np.int64]], row: Callable[[int], str]) -> Remark:
    return Remark(code, "warning", what, where=row(int(at[0])), count=len(at))


def _si(seconds: float) -> str:
    """Time with a fitting unit."""
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= size:
            return f"{seconds / size:.4g} {unit}"
    return f"{seconds / 1e-9:.4g} ns"
