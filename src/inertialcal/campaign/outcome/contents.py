"""What ``results.json`` holds: set-up, sequence, rows, covariances, budgets, curves, verdicts, closed loop, matrix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ...core.estimate import Estimate
from ...core.influence import Influence
from ...core.judging import Verdict
from ...core.key import Key, Method
from ...core.remarks import Remark, condensed
from ...core.results import SCHEMA, Row, finite, key_fields
from ...core.schema.standards import OUTLIVES
from ...core.units import convert, factor
from ...procedures.display import display_unit, displayed, scaled, scaled_interval, ten_digits
from ..engine.engine import Prepared, ReducedTest, sensor_of
from ..file.load import Campaign
from ..models.content import closed_loop_content, named_models, parameter_rows
from ..models.judged import NOT_RUN, JudgedModel
from .budgets import budget_rows
from .curves import curves_content
from .exclusions import exclusion_rows, left_out
from .margins import margin
from .requirements import RULE, judge, worst
from .sequence import sequence_rows
from .set_up import sensors_content, site_content
from .standards import standards_rows


def results_content(
    campaign: Campaign,
    prepared: Sequence[Prepared],
    tested: Sequence[ReducedTest],
    modelled: JudgedModel | None,
    remarks: Sequence[Remark],
) -> tuple[dict[str, Any], list[Verdict]]:
    """Return the content of ``results.json``, and the verdicts behind it.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : sequence of Prepared
        Every test, ready to be reduced.
    tested : sequence of ReducedTest
        Every test, with its rows, SI; they come out in the units of the campaign.
    modelled : JudgedModel or None
        Model and closed loop.
    remarks : sequence of Remark
        Of all tests.
    """
    rows = displayed_rows(campaign, tested)
    for name, (unit, one) in named_models(campaign, modelled).items():
        estimate = None if one.model is None else one.model.estimate
        for row in parameter_rows(one):
            shared = {} if estimate is None or row.u is None else _outliving(campaign, estimate.shared(row.key))
            rows.append(displayed(replace(row, test=name, shared=shared), unit))
    judged: list[tuple[Verdict, str]] = []
    tests = {one.test.id: one.test for one in tested}
    unit = campaign.file.sensors[next(iter(campaign.file.sensors))].unit
    for requirement in campaign.file.requirements:
        found, more = judge(requirement, tested)
        judged += [(verdict, requirement.quantity) for verdict in found]
        known = {(row.test, row.key, row.case) for row in rows}
        new = [row for row in more if (row.test, row.key, row.case) not in known]
        rows += [displayed(row, unit) for row in new]
    verdicts = [verdict for verdict, _ in judged]
    unused = left_out(campaign, prepared, tested)
    results = {
        "schema": SCHEMA,
        "campaign": campaign.file.campaign.model_dump(),
        "item": campaign.file.item.model_dump(),
        "site": site_content(campaign.file.site),
        "sensors": sensors_content(campaign.file.sensors),
        "standards": standards_rows(campaign, tested),
        "influences": {name: _influence(one) for name, one in sorted(campaign.standards.items())},
        "sequence": sequence_rows(prepared, unused),
        "exclusions": exclusion_rows(unused),
        "results": [row.to_dict() for row in rows],
        "covariances": [c for one in tested for kind in one.parts if (c := _covariance(one, kind)) is not None],
        "budgets": _budgets(campaign, tested, modelled),
        "curves": curves_content(campaign, tested, modelled),
        "remarks": [remark.to_dict() for remark in condensed(remarks)],
        "decision_rule": RULE,
        "verdicts": [
            _verdict_row(
                verdict,
                sensor_of(campaign, tests[verdict.test], verdict.sensor).unit if verdict.test in tests else unit,
                asked,
            )
            for verdict, asked in judged
        ],
        "closed_loop": closed_loop_content(campaign, modelled, unit),
        "verification": _verification(campaign, verdicts, modelled),
    }
    return results, verdicts


def displayed_rows(campaign: Campaign, tested: Sequence[ReducedTest]) -> list[Row]:
    """Return the rows of tests in the units of their sensors, each with its condition and what it shares."""
    found = []
    for one in tested:
        known = {kind: _known(one, kind) for kind in one.parts}
        for row in one.rows:
            estimate, keys = known.get(row.key.sensor, (None, {}))
            shared = dict(row.shared)
            if estimate is not None and row.u is not None and row.method is Method.RESULT and row.member is None:
                shared = shared or (estimate.shared(keys[row.key]) if row.key in keys else {})
            whole = replace(row, condition=one.test.condition, shared=_outliving(campaign, shared))
            found.append(displayed(whole, sensor_of(campaign, one.test, row.key.sensor).unit))
    return found


def _known(one: ReducedTest, kind: str) -> tuple[Estimate | None, dict[Key, Key]]:
    """Return the estimate of a sensor, and the key of each of its values by that of its row."""
    part = one.parts[kind]
    if part.estimate is None:
        return None, {}
    called = {one.procedure.called(part, key): key for key in part.estimate.keys}
    return part.estimate, {key._replace(sensor=kind): own for key, own in called.items()} | called


def _outliving(campaign: Campaign, shared: Mapping[str, float]) -> dict[str, float]:
    """Return the changes by influences whose error is the same in the next test."""
    stated = {name: one for name, one in campaign.standards.items() if one.redrawn_by in OUTLIVES}
    return {name: change for name, change in shared.items() if name.partition("[")[0] in stated and change}


def _influence(one: Influence) -> dict[str, Any]:
    u, unit = one.stated
    return {
        "standard": one.standard, "quantity": one.quantity, "u": u, "unit": unit, "certificate": one.certificate,
        "valid": one.valid, "redrawn_by": one.redrawn_by,
    }  # fmt: skip


def _budgets(campaign: Campaign, tested: Sequence[ReducedTest], modelled: JudgedModel | None) -> list[dict[str, Any]]:
    """Return the budgets of all tests, then those of the model that is delivered."""
    found = []
    for one in tested:
        for kind, part in one.parts.items():
            unit = sensor_of(campaign, one.test, kind).unit
            found += budget_rows(one.test.id, part.estimate, unit, one.procedure.budgeted(part), kind)
    for name, (unit, made) in named_models(campaign, modelled).items():
        if made.model is not None:
            found += budget_rows(name, made.model.estimate, unit)
    return found


def _covariance(one: ReducedTest, kind: str) -> dict[str, Any] | None:
    estimate: Estimate | None = one.parts[kind].estimate
    if estimate is None:
        return None
    return {
        "test": one.test.id,
        "keys": [key_fields(key) | ({"sensor": kind} if kind else {}) for key in estimate.keys],
        "units": list(estimate.units),
        "matrix": estimate.covariance.tolist(),
    }


def _verdict_row(verdict: Verdict, sensor_unit: str, quantity: str) -> dict[str, Any]:
    relative = verdict.unit == "1"
    unit = "%" if relative else display_unit(quantity, verdict.unit, sensor_unit) if verdict.unit else ""
    scale = factor(verdict.unit, unit) if verdict.unit else 1.0
    interval = scaled_interval(verdict.interval, scale)
    lower, upper = scaled(verdict.lower, scale), scaled(verdict.upper, scale)
    shown = sensor_unit if verdict.at_unit == "rad/s" else verdict.at_unit
    at = None if verdict.at is None else ten_digits(float(convert([verdict.at], verdict.at_unit, shown)[0]))
    return {
        "requirement": verdict.requirement, "test": verdict.test, "axis": verdict.axis,
        "sensor": verdict.sensor, "at": at, "at_unit": shown if at is not None else "", "of": verdict.of,
        "value": finite(scaled(verdict.value, scale)), "u": finite(scaled(verdict.u, scale)), "unit": unit,
        "interval": None if interval is None else
        {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
        "lower": lower, "upper": upper, "margin": margin(interval, lower, upper),
        "verdict": verdict.verdict, "reason": verdict.reason,
    }  # fmt: skip


def _verification(
    campaign: Campaign, verdicts: Sequence[Verdict], modelled: JudgedModel | None
) -> list[dict[str, Any]]:
    """Rows of the verification matrix: requirement, method, evidence, verdict; untested requirements are OPEN."""
    rows: list[dict[str, Any]] = []
    for requirement in campaign.file.requirements:
        mine = [one for one in verdicts if one.requirement == requirement.id]
        is_open = all(one.verdict == "OPEN" for one in mine)
        rows.append(
            {
                "requirement": requirement.id, "text": requirement.text, "method": "" if is_open else "test",
                "evidence": list(dict.fromkeys(one.test for one in mine if one.test)),
                "verdict": "OPEN" if is_open else worst(mine),
            }
        )  # fmt: skip
    if modelled is not None and modelled.whole_verdict != NOT_RUN:
        held = [test.id for test in campaign.file.tests if test.use == "hold_out"]
        text = "compensation improves readings that the model has not seen"
        row = {
            "requirement": "closed loop",
            "text": text,
            "method": "test",
            "evidence": held,
            "verdict": modelled.whole_verdict,
        }
        rows.append(row)
    return rows
