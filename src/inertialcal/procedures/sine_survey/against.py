"""Modes after against modes before: which is which, and by how much frequency, Q and transmissibility changed.

A change is relative to before. Two modes are one where nothing else is near: within `NEAR` of its frequency there is
one mode in each survey; or as many in both, each nearer to its own, in order, than half of what parts it from the next.
Else, or where the sizes of two near modes are each other's, which is which is not told: the change is refused
(``ambiguous``). A mode that only one survey has is ``lost`` or ``new``.

The uncertainty: the scatter of both. The clock of the recorder acts on both frequencies alike, and not on their ratio,
unless it was another one (``redrawn_by`` of its standard).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ...core.errors import PlanError
from ...core.estimate import Array
from ...core.influence import Occasion
from ...core.key import Key, Reason
from ...core.results import Row, not_estimated
from ...core.show.rounding import number
from ...statistics.difference import Figure, difference
from ...statistics.intervals import t_interval
from .match import NEAR, matched
from .plan import CLOCK
from .reduction import AMPLIFICATION, FREQUENCY, OF_MODE, PEAK, Result, mode_key
from .swept import OfAxis

CHANGES = {
    FREQUENCY: "resonance_frequency_change",
    AMPLIFICATION: "amplification_change",
    PEAK: "transmissibility_change",
}
CROSSED = 3.0  # times as alike as they stand, that sizes of two modes are across


def change_rows(
    after: Result, before: Result, name: str, occasions: tuple[Occasion, Occasion] = (Occasion(), Occasion())
) -> list[Row]:
    """Return the relative changes of the modes of each response.

    Parameters
    ----------
    after, before : Result
        This survey, and the one that it is set against.
    name : str
        Of the other.
    occasions : (Occasion, Occasion)
        What drew the errors of standards in each.

    Raises
    ------
    PlanError
        ``plans_differ`` if no response is in both.
    """
    axes = [axis for axis in after.axes if axis in before.axes]
    if not axes:
        what = f"no response is in both surveys: {', '.join(after.axes)} and {', '.join(before.axes)}"
        raise PlanError(what, do="Set a survey against one of the same channels", code="plans_differ")
    found: list[Row] = []
    for axis in axes:
        found += _of_axis(after, before, axis, name, _clock_shared(after, before, occasions))
    return found


def _clock_shared(after: Result, before: Result, occasions: tuple[Occasion, Occasion]) -> bool:
    one, other = (result.plan.standards.get(CLOCK) for result in (after, before))
    if one is None or other is None or one.redrawn_by in ("", "never", "certificate"):
        return True
    labels = [each.drew(one.redrawn_by) for each in occasions]
    return bool(labels[0]) and labels[0] == labels[1]


def known(of_axis: OfAxis) -> Array:
    """Return the frequencies of the modes that are estimated, in order."""
    return np.asarray(of_axis.modes.frequency[~of_axis.edge])


def _of_axis(after: Result, before: Result, axis: str, name: str, shared: bool) -> list[Row]:
    mine, its = known(after.axes[axis]), known(before.axes[axis])
    pairs, refused = matched(mine, its)
    places = _changed_places(pairs, its, *(one.axes[axis].modes.peak[~one.axes[axis].edge] for one in (after, before)))
    pairs = [one for one in pairs if one not in places]
    for one, (_, j) in places.items():
        size = f"its size is that of the mode at {number(float(its[j]), 4)} Hz before: they may have changed places"
        refused.append((Reason("ambiguous", size), one[0] + 1, float(mine[one[0]])))
    found: list[Row] = []
    for i, j in pairs:
        for quantity in OF_MODE:
            found.append(_change(after, before, mode_key(quantity, axis, i + 1), mode_key(quantity, axis, j + 1),
                                 name, shared))  # fmt: skip
    single = [f for one in (after, before) for f, _ in one.axes[axis].sweeps.single]
    for reason, own, frequency in sorted(refused, key=lambda one: one[1]):
        if any(abs(math.log(frequency / one)) < NEAR for one in single):
            reason = Reason("sweeps_differ", "not every sweep of one survey has it")  # noqa: PLW2901
        why = Reason(reason.code, f"{number(frequency, 4)} Hz: {reason.text}")
        found += [not_estimated(mode_key(CHANGES[quantity], axis, own), "1", why) for quantity in OF_MODE]
    return found


def _changed_places(
    pairs: Sequence[tuple[int, int]], before: Array, new: Array, old: Array
) -> dict[tuple[int, int], tuple[int, int]]:
    """Return pairs whose sizes are each other's, and whose; only of modes that are near to each other."""
    found: dict[tuple[int, int], tuple[int, int]] = {}
    for one, other in pairwise(pairs):
        straight, crossed = (
            sum(abs(math.log(new[i] / old[j])) for i, j in both)
            for both in ((one, other), ((one[0], other[1]), (other[0], one[1])))
        )
        near = math.log(before[other[1]] / before[one[1]]) < NEAR
        if near and straight > math.log(2.0) and crossed < straight / CROSSED:
            found |= {one: other, other: one}
    return found


def _change(after: Result, before: Result, key: Key, other: Key, name: str, shared: bool) -> Row:
    figures = []
    for result, which in ((after, key), (before, other)):
        estimate = result.estimate
        assert estimate is not None  # noqa: S101 - it has this mode
        at = estimate.index(which)
        figures.append((float(estimate.values[at]), float(estimate.u[at]), float(estimate.dof[at]),
                        estimate.shared(which)))  # fmt: skip
    (new, u_new, dof_new, own), (old, u_old, dof_old, its) = figures
    ratio = new / old
    # of the ratio: in units of before, where what both share acts on both alike
    one = Figure(ratio, u_new / old, dof_new, {k: v / old for k, v in own.items()})
    two = Figure(1.0, u_old * ratio / old, dof_old, {k: v * ratio / old for k, v in its.items()})
    change = difference(two, one, None if shared else ())
    dof = change.dof if math.isfinite(change.dof) else None
    reason = Reason("limits", f"relative to {name}, where it was {number(old, 6)}")
    kept = key._replace(quantity=CHANGES[key.quantity])
    return Row(kept, ratio - 1.0, change.u, "1", dof, t_interval(ratio - 1.0, change.u, change.dof), reason=reason)
