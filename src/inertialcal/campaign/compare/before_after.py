"""A test set against an earlier one of the same sensor: what each figure changed by, as after vibration.

Differences are made as ``compare`` makes them (`differences`): errors that both tests share cancel, the rest adds;
sizes (noise terms, scatters) are told as a ratio. What is drawn anew between two tests, though the unit is the same,
belongs into the uncertainty of a change:

- *Power-up.* The reading at rest and the scale factor settle anew with each. Where a test holds several power-ups, its
  uncertainty has their scatter. One power-up does not show it, so no change of such a figure is judged (``few_runs``),
  unless both tests state the same power-up.
- *Mounting.* The unit was taken off the table. Angles in the fixture change with each laying, by as much as
  ``[standards]`` says; where it says nothing, no change of them is judged (``mounting_unknown``), unless both tests
  state the same mounting.

Noise and scatter are taken to be drawn anew by neither. In one campaign a standard is one standard: what its
certificate does not know cancels.

References
----------
.. [1] JCGM 100:2008, clauses 5.2.2 and F.1.2.3.
.. [2] IEEE Std 1431-2004, 12.13 (repeatability of bias and scale factor); IEEE Std 1293-2018, 12.3.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from ...core.errors import InertialcalError
from ...core.key import AXES, NO_REASON, Key, Method, Reason
from ...core.remarks import Remark
from ...core.results import Row, not_estimated
from ...core.schema.standards import REDRAWN
from ...core.show.rounding import number
from ...procedures import all_quantities
from ...procedures.agreement import unit_mistaken
from ...procedures.protocol import Quantity, Result
from ...statistics.difference import Part
from ..engine.engine import Change, ReducedTest, computable, placed
from ..file.load import Campaign
from ..outcome.contents import with_shared
from .common import Common
from .differences import Difference, differences, is_size, matched
from .sources import Compared

FEW_RUNS = Reason(
    "few_runs",
    "one power-up in one of the tests: how far power-ups differ by themselves was not observed there. Record "
    "several in both, or state the same power_up in both if the unit stayed on",
)
REMOUNTED = Reason(
    "mounting_unknown",
    "the unit counts as laid anew, and how far a laying is off is not stated. State it under [standards], or the same "
    "mounting in both tests if the unit stayed where it was",
)
# Standard uncertainties of all changes together, beyond which axes may have changed places; and what is left then
FAR, SAME = 5.0, 0.1
OF_CAMPAIGN = ("certificate", "never")  # what draws a standard anew does not happen within a campaign


@dataclass(frozen=True, eq=False)
class Side:
    """One of the two tests."""

    test: ReducedTest
    compared: Compared  # As ``compare`` takes results
    over_power_ups: frozenset[Key]  # Figures whose uncertainty holds the scatter between power-ups

    def settles_as(self, other: Side) -> bool:
        """Whether both are of one power-up, as stated."""
        mine, its = (one.test.tested.occasion.power_up for one in (self, other))
        return bool(mine) and mine == its

    def lies_as(self, other: Side) -> bool:
        """Whether both are of one mounting, as stated."""
        mine, its = (one.test.tested.occasion.mounting for one in (self, other))
        return bool(mine) and mine == its


def beside_others(campaign: Campaign, tested: Sequence[ReducedTest]) -> list[ReducedTest]:
    """Return the tests, those ``against`` another with the rows of what the two differ by.

    Raises
    ------
    PlanError
        If the two cannot be set side by side.
    """
    by_name = {one.test.id: one for one in tested}
    return [_beside(campaign, one, by_name[one.tested.against.id]) if one.tested.against else one for one in tested]


def _beside(campaign: Campaign, one: ReducedTest, other: ReducedTest) -> ReducedTest:
    changes: list[Change] = []
    compared: tuple[Remark, ...] = ()
    try:
        with computable(one.test.id):
            rows = one.procedure.against(one.tested, other.tested)
            if rows is None:
                changes, compared = changes_of(campaign, one, other)
                rows = [change.row for change in changes]
    except InertialcalError as error:
        number = campaign.file.tests.index(one.test)
        raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None
    named = [replace(row, test=one.test.id) for row in rows]
    return replace(one, rows=[*one.rows, *named], against=named, changes=changes, compared=compared)


def changes_of(campaign: Campaign, one: ReducedTest, other: ReducedTest) -> tuple[list[Change], tuple[Remark, ...]]:
    """Return what every figure changed by that stands in both tests, SI, and remarks on what both share.

    Parameters
    ----------
    campaign : Campaign
        Of both.
    one, other : ReducedTest
        This test, and the earlier one.
    """
    first, second = _side(campaign, other), _side(campaign, one)
    pairs, _ = matched(first.compared.rows, second.compared.rows, by_test=False)
    pairs = [pair for pair in pairs if any(row.status == "estimated" for row in pair)
             or all(row.value is not None for row in pair)]  # fmt: skip
    lasting = frozenset(name for name, each in campaign.standards.items() if each.redrawn_by in OF_CAMPAIGN)
    common = Common(first.compared, second.compared, lasting, "")
    found = [_change(campaign, first, second, each) for each in differences(pairs, common)]
    shared = tuple(replace(remark, do="") for remark in common.remarks(pairs) if remark.code != "same_file")
    return found, (*shared, *_doubts(one, other, found))


def _doubts(one: ReducedTest, other: ReducedTest, found: Sequence[Change]) -> Iterator[Remark]:
    """Yield a unit that one of the tests is taken to be in and is not, and a test that came before its earlier one."""
    kind = {"rad/s": "angular_rate", "m/s^2": "acceleration"}.get(one.tested.facts.si, "")
    ratios: dict[str, list[float]] = {}
    for each in found:
        if (
            each.row.method == Method.RATIO
            and each.row.value
            and each.first.status == each.second.status == "estimated"
        ):
            ratios.setdefault(each.row.quantity, []).append(each.row.value)
    for quantity, values in ratios.items():
        mistaken = {unit_mistaken(value, kind) for value in values}
        if len(mistaken) == 1 and (why := mistaken.pop()):
            what = f"{quantity} changed {number(values[0], 3)} times since {other.test.id}: {why}?"
            yield Remark("unit_disagrees", "warning", what, count=len(values), do="Check the units of both tests")
            break
    yield from _exchanged(other, [each for each in found if each.row.method == Method.CHANGE])
    first, second = other.tested.occasion.day, one.tested.occasion.day
    if first and second and second < first:
        what = f"recorded on {second}, {other.test.id} on {first}: against names the earlier test"
        yield Remark("order", "warning", what, do="Let the later test name the earlier one")


def _exchanged(other: ReducedTest, found: Sequence[Change]) -> Iterator[Remark]:
    """Yield axes whose level is the one that another axis had."""
    for quantity in dict.fromkeys(each.row.quantity for each in found):
        levels = {each.row.key.axis: (float(each.first.value), float(each.second.value), float(each.row.u))
                  for each in found if each.row.quantity == quantity and each.row.u
                  and each.first.value is not None and each.second.value is not None}  # fmt: skip
        if not levels or not set(levels) <= set(AXES):
            continue
        axes = list(levels)
        apart = {order: sum(abs(levels[a][1] - levels[b][0]) for a, b in zip(axes, order, strict=True))
                 for order in permutations(axes)}  # fmt: skip
        own, best = apart[tuple(axes)], min(apart, key=apart.__getitem__)
        if own > FAR * sum(u for *_, u in levels.values()) and apart[best] < SAME * own:
            moved = ", ".join(f"{a} reads what {b} read" for a, b in zip(axes, best, strict=True) if a != b)
            what = f"{quantity}: {moved} in {other.test.id}"
            yield Remark("axes_disagree", "warning", what, do="Check the columns of the axes in both tests")
            return


def _side(campaign: Campaign, one: ReducedTest) -> Side:
    told = {name for name, quantity in all_quantities().items() if quantity.redrawn_by is not None}
    rows = [row for row in with_shared(campaign, one) if row.case.plain and row.quantity in told]
    influences = dict(campaign.standards)
    parts: dict[tuple[str, Key], tuple[Part, ...]] = {}
    over: set[Key] = set()
    for sensor, result in one.parts.items():
        levels = one.procedure.levels(result)
        rows += [replace(row, key=row.key._replace(sensor=sensor)) for row in levels.rows]
        over |= {row.key._replace(sensor=sensor) for row in levels.rows if row.u is not None}
        influences |= levels.influences
        estimate = result.estimate
        if estimate is None:
            continue
        runs = [source for source in estimate.components if source.origin.level == "run"]
        axes = {key.axis[:1] for i, key in enumerate(estimate.keys) if any(r.covariance[i, i] > 0.0 for r in runs)}
        over |= {row.key for row in rows if row.key.sensor in ("", sensor) and row.key.axis[:1] in axes}
        parts |= {(one.test.id, key._replace(sensor=sensor)): each for key, each in _sources(one, result).items()}
    named = tuple(replace(row, test=one.test.id, condition="") for row in rows)
    compared = Compared(
        one.test.id, f"{campaign.sha256} {one.test.id}", named, campaign.file.item.serial, frozenset(), {},
        influences=influences, occasions={one.test.id: one.tested.occasion},
        selections={one.test.id: (one.tested.selection,)}, parts=parts,
    )  # fmt: skip
    return Side(one, compared, frozenset(over))


def _sources(one: ReducedTest, result: Result) -> dict[Key, tuple[Part, ...]]:
    """Return the sources of figures that are not known in size, as shares of their uncertainties."""
    estimate = result.estimate
    if estimate is None:
        return {}
    found = {}
    for figure in one.procedure.budgeted(result):
        at, u = figure.at, float(estimate.u[figure.at])
        if u > 0.0:
            each = [(source.origin, float(source.u[at]) / u, float(np.broadcast_to(source.dof, len(estimate.keys))[at]))
                    for source in estimate.components]  # fmt: skip
            found[figure.key] = tuple(
                Part(f"{origin.standard}.{origin.quantity}" if origin.standard else "", share, dof)
                for origin, share, dof in each
                if share and math.isfinite(dof)
            )
    return {key: parts for key, parts in found.items() if parts}


def _change(campaign: Campaign, first: Side, second: Side, found: Difference) -> Change:
    before, after = found.first, found.second
    size = is_size(before)
    method, known = (Method.RATIO, found.ratio) if size else (Method.CHANGE, found.row)
    missing = _drawn_anew(campaign, first, second, before, after)
    if not missing and (found.word == "not compared" or known is None):
        missing = Reason("not_compared", _why_not(first, second, before, after) or found.row.reason.text)
    if known is not None and not missing:
        return Change(replace(known, method=method, condition=""), before, after)
    value = found.row.value
    if size:
        value = after.value / before.value if after.value is not None and before.value else None
    open_one = not_estimated(before.key, "1" if size else before.unit, missing, method)
    return Change(replace(open_one, value=value), before, after)


def _why_not(first: Side, second: Side, before: Row, after: Row) -> str:
    """Say which of two figures was not estimated; empty where both were."""
    for side, row in ((first, before), (second, after)):
        if row.status != "estimated":
            return f"{side.test.test.id}: {row.reason or row.status.replace('_', ' ')}"
    return ""


def _drawn_anew(campaign: Campaign, first: Side, second: Side, before: Row, after: Row) -> Reason:
    """Return what was drawn anew in between and is not in the uncertainty; empty where nothing was."""
    redrawn = all_quantities().get(before.quantity, Quantity()).redrawn_by or ()
    observed = before.key in first.over_power_ups and after.key in second.over_power_ups
    if "power_up" in redrawn and not (observed or second.settles_as(first)):
        return FEW_RUNS
    if "mounting" in redrawn and not second.lies_as(first):
        procedure, result = second.test.procedure, second.test.result
        laid = (name for name, by in REDRAWN.items() if by == "mounting" and name not in campaign.standards)
        if any(name in procedure.influences and procedure.needs(name, result) for name in laid):
            return REMOUNTED
    return NO_REASON
