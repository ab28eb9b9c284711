"""A requirement on the deviation from the profile: all lines of a run together, one verdict a run.

PASS where each line's own interval lies inside the limits: a run with any line truly outside passes with the risk of
one line, 2.5 % with two limits (an intersection-union test). FAIL where, of intervals that hold for all lines
together, one lies wholly outside: a good run fails with 5 % at most, however many lines there are. Else INCONCLUSIVE,
and a longer run, or a coarser resolution, is what decides it.

A time above full level, a step upwards, whose overall level lies wholly above the upper limit, is FAIL too, of the
lines and of the overall level: spectra are of full level, but the item saw more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.judging import LEVEL, Asked, Basis, Verdict
from ...core.results import Interval
from ...core.show.rounding import number
from ...signals.vibration.deviation import NEPER, Deviation
from ...statistics.decision import Verdict as Decision
from ...statistics.decision import decide, decide_by
from ..protocol import Tested
from .plan import CONTROL, Plan
from .readings import Readings
from .reduction import Result

VibrationTest = Tested[Plan, Readings, Result]


def judge_lines(asked: Asked, tests: Sequence[VibrationTest]) -> list[Verdict]:
    """Return a verdict a run, at its line that does worst, or of its step above full level."""
    return [_of_steps(asked, one, "dB") or _judged(asked, one) for one in tests if asked.axis in (None, CONTROL)]


def judge_level(asked: Asked, tests: Sequence[VibrationTest]) -> list[Verdict] | None:
    """Return verdicts on the overall level, where a run has a step above full level that is too high; else None."""
    steps = [_of_steps(asked, one, "1") for one in tests]
    if asked.axis not in (None, CONTROL) or not any(steps):
        return None
    return [step or _of_level(asked, one) for step, one in zip(steps, tests, strict=True)]


def _of_level(asked: Asked, test: VibrationTest) -> Verdict:
    row = next(one for one in test.result.rows() if one.quantity == asked.quantity)
    lower, upper = asked.limits("1")
    found = decide(row.value, row.u, row.dof, lower, upper, rule=asked.rule)
    return Verdict(asked.id, test.id, CONTROL, None, "", row.value, row.u, "1", found.interval, lower, upper,
                   found.status, found.reason, basis=found.basis)  # fmt: skip


def _of_steps(asked: Asked, test: VibrationTest, unit: str) -> Verdict | None:
    """Return FAIL for the highest step above full level, where it is wholly above the limit."""
    steps = sorted(test.result.excursions, key=lambda one: one.value)
    try:
        lower, upper = asked.limits(unit)
    except DataError:
        return None
    if not steps or upper is None:
        return None
    one = steps[-1]
    z = -float(special.ndtri(0.5 * (1.0 - LEVEL)))
    ends = [one.value + sign * z * one.u_value for sign in (-1.0, 1.0)]
    value, u = one.value, one.u_value
    if unit != "dB":  # of the root mean square, less 1
        value, *ends = (10.0 ** (0.05 * level) - 1.0 for level in (value, *ends))
        u = (value + 1.0) * one.u_value / (2.0 * NEPER)
    if not ends[0] > upper:
        return None
    reason = f"the level steps up {one}: {number(one.value, 2)} dB above the profile"
    return Verdict(asked.id, test.id, CONTROL, None, "", value, u, unit, Interval(ends[0], ends[1], LEVEL), lower,
                   upper, "FAIL", reason)  # fmt: skip


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


__all__ = ["judge_level", "judge_lines"]
