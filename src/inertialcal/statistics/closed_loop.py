"""Closed loop: the verdict on a model by hold-out readings, raw and compensated.

A procedure states for every axis (or other way to judge) how much compensation reduces the mean square error, and the
uncertainty of that; the rule is the same for all. Tests are one-sided t tests; Holm's rule holds the risk over the axes
at 5 %.

A model made from a finite test is off by its own (Type A) uncertainty even where it is right; that much is
allowed: an axis FAILs if it is worse beyond the mean square of that uncertainty. It PASSes if it is shown better;
else it is INCONCLUSIVE.

Better than nothing is not enough: a transposed matrix can still improve every axis where scale factor and bias
prevail. So a model can also be held against its own mixed-up forms (transposed, signs turned, axes exchanged):
an axis FAILs where one of them is shown to do better. The risk of 5 % is then shared in halves between the two ways to
FAIL.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from scipy import special

from .decision import holm

RISK = 0.05  # of calling a model wrong that is not, over all axes; and the same for calling it better

Word = Literal["PASS", "FAIL", "INCONCLUSIVE"]


@dataclass(frozen=True)
class AxisLoop:
    """One axis, before and after."""

    axis: str  # input axis, or the name of another quantity that is judged
    # numbers judged
    dwells: int
    runs: int
    # root mean square error [unit]
    raw: float
    compensated: float
    gain: float  # reduction of the mean square error [unit^2]; positive = improved
    u: float  # standard uncertainty of the gain [unit^2]
    dof: float  # degrees of freedom
    allowed: float  # mean square uncertainty of the model itself [unit^2]
    unit: str = "rad/s"  # of the errors, SI
    # mixed-up forms of the model: p value of doing better than the model
    rivals: Mapping[str, float] = field(default_factory=dict[str, float])
    verdict: Word = "INCONCLUSIVE"  # by the rule
    reason: str = ""  # reason for a FAIL or INCONCLUSIVE


def judged(loops: Sequence[AxisLoop], share: float = 1.0) -> tuple[AxisLoop, ...]:
    """Return the axes with their verdicts, Holm over all of them.

    Parameters
    ----------
    loops : sequence of AxisLoop
        Without verdicts.
    share : float
        Of the risk of a wrong verdict that is left to these; the rest belongs to another closed loop of the campaign.
    """
    if not loops:
        return ()
    of_worse = 0.5 * share if any(one.rivals for one in loops) else share
    worse = holm([_p(one.gain + one.allowed, one) for one in loops], RISK * of_worse)
    better = holm([_p(-one.gain, one) for one in loops], RISK * share)
    rivals = _better_rivals(loops, share)
    found = []
    for i, (one, is_worse, is_better) in enumerate(zip(loops, worse, better, strict=True)):
        if i in rivals:
            reason = f"{rivals[i]} does better on hold-out readings: the model is mixed up"
            found.append(replace(one, verdict="FAIL", reason=reason))
        elif is_worse:
            reason = "worse on hold-out readings, beyond the uncertainty of the model"
            found.append(replace(one, verdict="FAIL", reason=reason))
        elif is_better:
            found.append(replace(one, verdict="PASS"))
        else:
            found.append(replace(one, reason="neither better nor worse on hold-out readings"))
    return tuple(found)


def overall(loops: Sequence[AxisLoop]) -> Word:
    """Return FAIL if any axis does, PASS if every axis does, else INCONCLUSIVE."""
    found = {one.verdict for one in loops}
    if "FAIL" in found:
        return "FAIL"
    return "PASS" if found == {"PASS"} else "INCONCLUSIVE"


def _better_rivals(loops: Sequence[AxisLoop], share: float) -> dict[int, str]:
    """Return the mixed-up form that does better than the model, by number of the loop, where one is shown to."""
    tests = [(i, name, p) for i, one in enumerate(loops) for name, p in one.rivals.items()]
    if not tests:
        return {}
    shown = holm([p for _, _, p in tests], RISK * share / 2.0)
    best: dict[int, tuple[float, str]] = {}
    for (i, name, p), significant in zip(tests, shown, strict=True):
        if significant and p <= best.get(i, (1.0, ""))[0]:
            best[i] = (p, name)
    return {i: name for i, (_, name) in best.items()}


def _p(size: float, one: AxisLoop) -> float:
    """Probability of so negative a size or less, if its expectation were zero."""
    if not (np.isfinite(one.u) and one.u > 0.0):
        return 1.0
    return float(special.stdtr(one.dof, size / one.u))
