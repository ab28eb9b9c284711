"""Two models, or the results of two campaigns, figure by figure: the difference with its uncertainty.

``not shown different`` is not "unchanged": for that, state what change is allowed, and ``no_change`` judges each
figure.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...core.errors import DataError, UsageError
from ...core.judging import Rule
from ...core.remarks import Remark
from ...core.results import Interval, Row, finite, identity_fields
from ...core.show.result_tables import folded, remarks_line
from ...core.show.rounding import number, settled, settled_ends
from ...core.show.tables import Block, Table, html, text
from ...files.source import checked_path
from ...statistics.decision import Verdict, decide_by, no_change, overall
from ...statistics.guard_band import INTERVAL
from ..file.decisions import read_decision
from .allowed_change import Allowed, allowed_for, is_named, parse_allowed
from .common import common_of
from .differences import Difference, P, differences, is_scatter, matched, quantities_compared, rows_remark
from .sources import Compared, Kind, load_both


@dataclass(frozen=True)
class Comparison:
    """All figures that two models or results share."""

    kind: Kind  # What was compared
    differences: tuple[Difference, ...]  # In the order of the first
    remarks: tuple[Remark, ...]  # The assumption made, and what it may miss
    inputs: Mapping[str, str]  # SHA-256 of each file
    rule: Rule = INTERVAL  # By which allowed changes were judged

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a figure, test by test, why others were not compared, how many remarks."""
        return comparison_parts(self.kind, self.differences, self.remarks, self.verdict, self.rule)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())

    @property
    def verdict(self) -> str:
        """PASS, FAIL or INCONCLUSIVE over all allowed changes; empty where none is stated."""
        found = [one.no_change for one in self.differences if one.no_change is not None]
        return overall(found) if found else ""

    @property
    def verdicts(self) -> list[dict[str, Any]]:
        """Each judged figure as ``--json`` prints it."""
        return [_verdict(one, one.no_change) for one in self.differences if one.no_change is not None]

    @property
    def exit_status(self) -> int:
        """0 PASS or nothing stated, 1 FAIL, 4 INCONCLUSIVE."""
        return {"": 0, "PASS": 0, "FAIL": 1}.get(self.verdict, 4)


def compare(
    first: str | os.PathLike[str],
    second: str | os.PathLike[str],
    allowed: Sequence[str] = (),
    decision: str = "",
    shared: Sequence[str] = (),
    condition: str | None = None,
) -> Comparison:
    """Compare two models, or the results of two campaigns; models for several conditions condition by condition.

    Parameters
    ----------
    first, second : path
        ``model.json``, ``results.json``, or the folder of a campaign: its results, or its model if the other is
        a model.
    allowed : sequence of str
        Changes that do not matter: ``"0.1 %"``, ``"bias=0.01 deg/s"``; see ``campaign.compare.allowed_change``.
    decision : str
        Rule by which allowed changes are judged: ``"simple_acceptance"``, ``"guard_factor=1"``,
        ``"false_accept_risk=2 %"``, ``"test_uncertainty_ratio=4"``, or a table as ``campaign.toml`` has it; the
        95 % interval where not given.
    shared : sequence of str
        Standards whose error is the same in both though the campaigns do not say so: ``"rate_table.mounting"``.
    condition : str, optional
        Of which models are compared, where the files have several.

    Raises
    ------
    DataError
        As ``load_both``; ``no_shared_quantity`` if no figure stands in both, or none that a change is allowed for.
    UsageError
        ``allowed``, ``decision``; ``not_shared`` for a standard that is not in both, or of which both state two.
    """
    for side in (first, second):
        checked_path(side, "model or campaign")
    stated, rule = _stated(allowed, decision)
    kind, sides, gone = load_both(first, second, condition)
    found = [_compared(kind, one, other, stated, rule, shared) for one, other in sides]
    remarks = list(dict.fromkeys(remark for one in found for remark in one.remarks))
    for one, other in sides:
        if one.condition != other.condition:
            first_in, second_in = (side.condition or "no stated condition" for side in (one, other))
            what = f"the first is the model in {first_in}, the second that in {second_in}"
            remarks.append(Remark("conditions_differ", "warning", f"{what}: their figures may well differ"))
    if gone:
        what = f"only one of the two has a model for {', '.join(gone)}: not compared"
        remarks.append(Remark("condition_not_in_both", "warning", what, count=len(gone)))
    return replace(
        found[0], differences=tuple(each for one in found for each in one.differences), remarks=tuple(remarks)
    )


def compare_sides(
    first: Compared, second: Compared, allowed: Sequence[str] = (), decision: str = "", shared: Sequence[str] = ()
) -> Comparison:
    """Compare the results of two campaigns that were read already; arguments and refusals as `compare`."""
    return _compared("results", first, second, *_stated(allowed, decision), shared)


def _stated(allowed: Sequence[str], decision: str) -> tuple[tuple[Allowed, ...], Rule]:
    """Return the changes that are allowed, and the rule by which they are judged."""
    stated, rule = parse_allowed(allowed), read_decision(decision) if decision else INTERVAL
    if decision and not stated:
        raise UsageError(
            f"--decision {decision!r} without an allowed change",
            do="Add --allowed CHANGE, the largest that is allowed",
            code="decision",
        )
    return stated, rule


def _compared(
    kind: Kind, one: Compared, other: Compared, stated: Sequence[Allowed], rule: Rule, shared: Sequence[str]
) -> Comparison:
    pairs, remarks = matched(one.rows, other.rows, by_test=kind == "results")
    if not pairs:
        raise DataError(
            "no figure stands in both",
            where=f"{one.path}, {other.path}",
            do="Compare campaigns of one kind of sensor and test",
            code="no_shared_quantity",
        )
    common = common_of(one, other, shared)
    found, judging = judged(differences(pairs, common), stated, rule)
    if one.sha256 == other.sha256:  # nothing is left to assume
        everything = (*common.remarks(pairs), *remarks, *judging)
        return Comparison(kind, found, everything, {one.path: one.sha256, other.path: other.sha256}, rule)
    what = "first and second are taken as independent, but for standards that both share"
    assumed = Remark("taken_as_independent", "info", what)
    k = quantities_compared(found)
    chance = f"one of them may be called different by chance in up to {100 * (1 - P**k):.0f} % of comparisons"
    each = f"{k} quantities, each judged at {100 * P:g} % by itself: {chance}"
    by_chance = (Remark("judged_by_quantity", "info", each, count=k),) if k > 1 else ()
    everything = (assumed, *by_chance, *common.remarks(pairs), *remarks, *judging)
    return Comparison(kind, found, everything, {one.path: one.sha256, other.path: other.sha256}, rule)


def judged(
    found: Sequence[Difference], stated: Sequence[Allowed], rule: Rule = INTERVAL
) -> tuple[tuple[Difference, ...], tuple[Remark, ...]]:
    """Return the differences with a verdict where a change is allowed, and a remark on those without one.

    A change stated for all judges the figures that could be compared, without other ways of reduction beside them
    (``as_published``, ``all_readings``); one stated for a quantity judges every figure of it that has an
    uncertainty, and is INCONCLUSIVE of a result that has none.

    Raises
    ------
    DataError
        ``no_shared_quantity``, if no figure is judged though a change is stated; ``unit_mismatch``.
    """
    if not stated:
        return tuple(found), ()
    done = [replace(one, no_change=_judge(one, stated, rule)) for one in found]
    open_ones = [one.row for one in done if one.no_change is None]
    if len(open_ones) == len(done):
        raise DataError(
            "no figure in both that the allowed change can judge",
            do='State it for a quantity, like --allowed bias="0.01 deg/s"',
            code="no_shared_quantity",
        )
    return tuple(done), tuple(rows_remark("not_judged", "no allowed change is stated for", open_ones))


def _judge(one: Difference, stated: Sequence[Allowed], rule: Rule) -> Verdict | None:
    compared, beside = one.word != "not compared", one.row.case.beside
    named = is_named(one.row, stated) and (compared or not beside)  # a figure without u beside the result is none
    if not (named or (compared and not beside)):
        return None
    limit = allowed_for(one.first, stated)
    if limit is None:
        return None
    interval = one.row.interval
    if interval is None or not (is_scatter(one.row) or one.row.u == 0.0):
        return no_change(one.row.value, one.row.u, one.row.dof, limit, P, rule)

    def interval_at(p: float) -> Interval | None:
        return interval if p == P or not one.row.u else None  # one figure of the same readings twice: no u, at any p

    return decide_by(interval_at, one.row.value, one.row.u, -limit, limit, P, rule)


def _verdict(one: Difference, verdict: Verdict) -> dict[str, Any]:
    row, interval = one.row, verdict.interval
    return {
        "requirement": "no_change",
        **identity_fields(row),
        "of": "difference",
        "value": finite(row.value),
        "u": finite(row.u),
        "unit": row.unit,
        "interval": None if interval is None else {"lo": interval.lo, "hi": interval.hi, "p": interval.p},
        "lower": verdict.limit_lower,
        "upper": verdict.limit_upper,
        "verdict": verdict.status,
        "reason": verdict.reason,
        "rule": verdict.rule,
        "accept_lower": verdict.basis.accept_lower,
        "accept_upper": verdict.basis.accept_upper,
        "risk": verdict.basis.risk,
        "ratio": verdict.basis.ratio,
    }


HEADS = ("quantity", "axis", "first", "second", "difference", "unit", "95 % interval", "verdict")


JUDGED = ("allowed", "no change")


def comparison_parts(
    kind: str, differences: Sequence[Difference], remarks: Sequence[Remark], verdict: str, rule: Rule = INTERVAL
) -> tuple[Block, ...]:
    """Return what is shown of a comparison; the columns are fewer than `compare` prints, to fit a notebook.

    Parameters
    ----------
    kind : {"models", "results"}
        What was compared; results come test by test.
    differences : sequence of Difference
        All figures that stand in both.
    remarks : sequence of Remark
        Of the comparison.
    verdict : str
        Over all allowed changes; empty where none is stated.
    rule : Rule
        By which they were judged.
    """
    shown = [one for one in differences if is_shown(one)]
    judged = any(one.no_change is not None for one in shown)
    parts: list[Block] = []
    for test in dict.fromkeys(one.row.test if kind == "results" else "" for one in shown):
        rows = [_narrow(one, judged) for one in shown if kind != "results" or one.row.test == test]
        heads = ("quantity", "difference", "unit", "95 % interval", *(JUDGED if judged else ("verdict",)))
        parts.append(Table(heads, rows, f"{test}: second less first" if test else "second less first", (1, 3)))
    reasons = folded("not compared, for {n} reason(s): see .differences", not_compared(differences))
    parts += [*reasons, *remarks_line(remarks)]
    if not shown:
        parts.insert(0, "nothing could be compared")
    return (*parts, *rule_lines(rule), *((f"overall: {verdict}",) if verdict else ()))


def rule_lines(rule: Rule) -> list[str]:
    """Return by which rule changes were judged, in a line; none where it is the interval."""
    return [] if rule == INTERVAL else [f"no change by {rule}"]


def is_shown(one: Difference) -> bool:
    """Leave out what says nothing: no value, two equal ones without uncertainty, other ways of reduction alike."""
    if one.no_change is not None or one.word == "different":
        return True
    return not is_beside(one) and (one.word == "not shown different" or bool(one.row.value))


def is_beside(one: Difference) -> bool:
    """Return whether the figure is of another way of reducing the same readings, or of a part of them."""
    return one.row.case.beside


def line(one: Difference, judged: bool) -> list[str]:
    """Return the cells of a figure under ``HEADS``, and ``JUDGED`` where changes are judged."""
    figures = [_figure(row) for row in (one.first, one.second, one.row)]
    cells = [_name(one.row), one.row.axis, *figures, one.row.unit, _interval(one.row), one.word]
    return [*cells, *_words(one)] if judged else cells


def _narrow(one: Difference, judged: bool) -> list[str]:
    """Return the difference alone, to fit a notebook and a terminal."""
    row = one.row
    name = f"{_name(row)} {row.axis}".strip()
    return [name, _figure(row), row.unit, _interval(row), *(_words(one) if judged else (one.word,))]


def _name(row: Row) -> str:
    return f"{row.quantity} ({case})" if (case := str(row.case)) else row.quantity


def _interval(row: Row) -> str:
    ends = row.interval
    return "" if ends is None else settled_ends(row.value, row.u, ends.lo, ends.hi)


def _words(one: Difference) -> tuple[str, str]:
    if one.no_change is None:
        return "", ""
    return f"± {number(one.no_change.limit_upper, 5)}", one.no_change.status


def _figure(row: Row) -> str:
    return settled(row.value, row.u)


def not_compared(differences: Sequence[Difference]) -> list[str]:
    """Return a line a reason why figures were not compared."""
    reasons: dict[str, list[str]] = {}
    for one in differences:
        if one.word == "not compared" and not is_beside(one):
            reasons.setdefault(one.row.reason.text, []).append(f"{one.row.quantity} {one.row.axis}".strip())
    return [f"not compared: {', '.join(dict.fromkeys(names))}: {reason}" for reason, names in reasons.items()]
