"""A requirement on the deviation from the profile: all lines of a run together, one verdict a run.

PASS where each line's own interval lies inside the limits: a run with any line truly outside passes with the risk of
one line, 2.5 % with two limits (an intersection-union test). FAIL where, of intervals that hold for all lines
together, one lies wholly outside: a good run fails with 5 % at most, however many lines there are. Else INCONCLUSIVE,
and a longer run, or a coarser resolution, is what decides it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.judging import LEVEL, Asked, Basis, Verdict
from ...core.results import Interval
from ...core.show.rounding import number
from ...signals.vibration.deviation import Deviation
from ...statistics.decision import Verdict as Decision
from ...statistics.decision import decide_by
from ..protocol import Tested
from .plan import CONTROL, Plan
from .readings import Readings
from .reduction import Result

VibrationTest = Tested[Plan, Readings, Result]


def judge_lines(asked: Asked, tests: Sequence[VibrationTest]) -> list[Verdict]:
    """Return a verdict a run, at its line that does worst."""
    return [_judged(asked, one) for one in tests if asked.axis is None]


def _judged(asked: Asked, test: VibrationTest) -> Verdict:
    one = test.result.deviation
    inside = [asked.condition.holds({"frequency": f}) for f in one.frequency.tolist()]
    chosen = _selected(one, np.array(inside))
    nothing = (asked.id, test.id, CONTROL, None, "", None, None, "dB", None)
    try:
        lower, upper = asked.limits("dB")
    except DataError as error:
        return Verdict(*nothing, None, None, "INCONCLUSIVE", error.problems[0].what)
    if not len(chosen):
        return Verdict(*nothing, lower, upper, "INCONCLUSIVE", "no line lies where the requirement holds")
    each = _decisions(asked, chosen, LEVEL, (lower, upper))
    together = _decisions(asked, chosen, chosen.together(LEVEL), (lower, upper))
    failed = [i for i, found in enumerate(together) if found.status == "FAIL"]
    passed = all(found.status == "PASS" for found in each)
    worst = _worst(chosen, lower, upper, failed)
    status = "FAIL" if failed else "PASS" if passed else "INCONCLUSIVE"
    lo, hi = (float(end[worst]) for end in chosen.interval(chosen.together(LEVEL) if failed else LEVEL))
    interval = Interval(lo, hi, LEVEL)
    reason = _reason(chosen, worst, interval, status, failed, each)
    u = float(chosen.u_value[worst])
    return Verdict(asked.id, test.id, CONTROL, None, "", float(chosen.value[worst]), u, "dB", interval, lower, upper,
                   status, reason, basis=Basis(in_doubt=status != "PASS"))  # fmt: skip


def _selected(one: Deviation, inside: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> Deviation:
    return replace(one, frequency=one.frequency[inside], low=one.low[inside], high=one.high[inside],
                   density=one.density[inside], profile=one.profile[inside], edf=one.edf[inside],
                   each=one.each[inside])  # fmt: skip


def _decisions(asked: Asked, one: Deviation, p: float, limits: tuple[float | None, float | None]) -> list[Decision]:
    """Return the verdict on each line, by intervals of probability ``p`` where the rule says 95 %."""
    known: dict[float, tuple[Array, Array]] = {}

    def interval_at(i: int, wanted: float) -> Interval:
        if wanted not in known:  # of a rule of another probability: in proportion
            known[wanted] = one.interval(1.0 - (1.0 - wanted) * (1.0 - p) / (1.0 - LEVEL))
        lo, hi = known[wanted]
        return Interval(float(lo[i]), float(hi[i]), wanted)

    pairs = zip(one.value.tolist(), one.u_value.tolist(), strict=True)
    return [
        decide_by(partial(interval_at, i), value, u, *limits, rule=asked.rule) for i, (value, u) in enumerate(pairs)
    ]


def _worst(one: Deviation, lower: float | None, upper: float | None, failed: Sequence[int]) -> int:
    """Return the line with the least room to a limit, among those that failed where there are such."""
    low, high = one.interval(LEVEL)
    room = np.minimum(
        math.inf if upper is None else upper - high, math.inf if lower is None else low - lower
    ) * np.ones(len(one))
    if failed:
        left = np.full(len(one), math.inf)
        left[list(failed)] = room[list(failed)]
        room = left
    return int(np.argmin(room))


def _reason(
    one: Deviation, worst: int, interval: Interval, status: str, failed: Sequence[int], each: Sequence[Decision]
) -> str:
    f, value, edf = one.frequency[worst], one.value[worst], one.edf[worst]
    ends = f"{number(interval.lo or 0.0, 3)} to {number(interval.hi or 0.0, 3)} dB"
    at = (
        f"at {number(float(f), 5)} Hz {number(float(value), 3)} dB ({ends}), {number(float(edf), 3)} degrees of freedom"
    )
    if status == "PASS":
        return f"all {len(one)} lines inside; nearest {at}"
    if status == "FAIL":
        return f"{len(failed)} of {len(one)} lines outside; worst {at}"
    open_lines = sum(found.status != "PASS" for found in each)
    return f"not decided at {open_lines} of {len(one)} lines; worst {at}: run longer, or take a coarser resolution"


__all__ = ["judge_lines"]
