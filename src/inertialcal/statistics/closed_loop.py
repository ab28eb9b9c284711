"""Closed loop: the verdict on a model by readings that it has not seen, as they are and compensated.

A procedure says for every axis (or other way to judge) how much the squares of errors gain by compensation, and how
well that is known; the rule is the same for all. Tests are one-sided t tests; Holm's rule holds the risk over the axes
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
    """One axis, before and after.

    Parameters
    ----------
    axis : str
        Of the input, or the name of what judges.
    dwells, runs : int
        Judged.
    raw, compensated : float
        Root mean square error [unit].
    gain : float
        Mean of the squares before less after [unit^2]: positive where compensation helped.
    u : float
        Standard uncertainty of it [unit^2].
    dof : float
        Degrees of freedom.
    allowed : float
        Mean square uncertainty of the model itself [unit^2].
    unit : str
        Of the errors, SI.
    rivals : mapping of str to float
        Mixed-up forms of the model: probability that one does so much better if the model is right.
    verdict : {"PASS", "FAIL", "INCONCLUSIVE"}
        By the rule.
    reason : str
        Why neither.
    """

    axis: str
    dwells: int
    runs: int
    raw: float
    compensated: float
    gain: float
    u: float
    dof: float
    allowed: float
    unit: str = "rad/s"
    rivals: Mapping[str, float] = field(default_factory=dict[str, float])
    verdict: Word = "INCONCLUSIVE"
    reason: str = ""


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
    worse = holm([_p_worse(one) for one in loops], RISK * of_worse)
    better = holm([_p_better(one) for one in loops], RISK * share)
    rivals = _beaten(loops, share)
    return tuple(
        _judged(one, bool(w), bool(b), rivals.get(one.axis, "")) for one, w, b in zip(loops, worse, better, strict=True)
    )


def overall(loops: Sequence[AxisLoop]) -> Word:
    """Return FAIL if any axis does, PASS if every axis does, else INCONCLUSIVE."""
    found = {one.verdict for one in loops}
    if "FAIL" in found:
        return "FAIL"
    return "PASS" if found == {"PASS"} else "INCONCLUSIVE"


def _beaten(loops: Sequence[AxisLoop], share: float) -> dict[str, str]:
    """Return the mixed-up form that does better than the model, by axis, where one is shown to."""
    tests = [(one.axis, name, p) for one in loops for name, p in one.rivals.items()]
    if not tests:
        return {}
    shown = holm([p for _, _, p in tests], RISK * share / 2.0)
    best: dict[str, tuple[float, str]] = {}
    for (axis, name, p), significant in zip(tests, shown, strict=True):
        if significant and p <= best.get(axis, (1.0, ""))[0]:
            best[axis] = (p, name)
    return {axis: name for axis, (_, name) in best.items()}


def _p_worse(one: AxisLoop) -> float:
    return _p(one.gain + one.allowed, one)


def _p_better(one: AxisLoop) -> float:
    return _p(-one.gain, one)


def _p(size: float, one: AxisLoop) -> float:
    """Probability of so negative a size or less, if its expectation were zero."""
    if not (np.isfinite(one.u) and one.u > 0.0):
        return 1.0
    return float(special.stdtr(one.dof, size / one.u))


def _judged(one: AxisLoop, worse: bool, better: bool, rival: str) -> AxisLoop:
    if rival:
        reason = f"{rival} does better on readings held out: the model is mixed up"
        return replace(one, verdict="FAIL", reason=reason)
    if worse:
        reason = "worse on readings held out, beyond the uncertainty of the model"
        return replace(one, verdict="FAIL", reason=reason)
    if better:
        return replace(one, verdict="PASS")
    return replace(one, reason="not shown better, nor worse, on readings held out")
