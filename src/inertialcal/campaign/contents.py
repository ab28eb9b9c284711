"""What ``results.json`` holds: set-up, sequence, rows, covariances, budgets, curves, verdicts, closed loop, matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..core.estimate import Estimate
from ..core.judging import Verdict
from ..core.key import Reason, key_of
from ..core.remarks import Remark, condensed
from ..core.results import Row, finite, not_estimated
from ..core.units import convert, factor, kind
from ..procedures import procedure_of
from ..procedures.display import display_unit, displayed, scaled, scaled_interval, ten_digits
from ..procedures.positions.of_sensor import by_quantity
from ..procedures.rate_table.closed_loop import AxisLoop
from ..statistics.intervals import t_interval
from .budgets import budget_rows
from .cross_checks import MODELLED
from .curves import curves_content
from .engine import Prepared
from .exclusions import exclusion_rows, left_out
from .load import Campaign
from .margins import margin
from .modelling import Modelled
from .prepared import modelled_sensor, sensor_of
from .requirements import RULE, Tested, judge, worst
from .sequence import sequence_rows
from .set_up import sensors_content, site_content
from .standards import standards_rows
from .thermal_loop import loop_rows


def results_content(
    campaign: Campaign,
    prepared: Sequence[Prepared],
    tested: Sequence[Tested],
    modelled: Modelled | None,
    remarks: Sequence[Remark],
) -> tuple[dict[str, Any], list[Verdict]]:
    """Return the content of ``results.json``, and the verdicts behind it.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : sequence of Prepared
        Every test, ready to be reduced.
    tested : sequence of Tested
        Every test, with its rows, SI; they come out in the units of the campaign.
    modelled : Modelled or None
        Model and closed loop.
    remarks : sequence of Remark
        Of all tests.
    """
    rows = [
        displayed(replace(row, condition=one.test.condition), sensor_of(campaign, one.test).unit)
        for one in tested
        for row in one.rows
    ]
    if modelled is not None:
        for name, (unit, one) in _named(campaign, modelled).items():
            rows += [displayed(replace(row, test=name), unit) for row in _model_rows(one)]
    judged: list[tuple[Verdict, str]] = []
    units = {one.test.id: sensor_of(campaign, one.test).unit for one in tested}
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
        "schema": 1,
        "campaign": campaign.file.campaign.model_dump(),
        "item": campaign.file.item.model_dump(),
        "site": site_content(campaign.file.site),
        "sensors": sensors_content(campaign.file.sensors),
        "standards": standards_rows(campaign, tested),
        "sequence": sequence_rows(prepared, unused),
        "exclusions": exclusion_rows(unused),
        "results": [row.to_dict() for row in rows],
        "covariances": [c for one in tested if (c := _covariance(one)) is not None],
        "budgets": _budgets(campaign, tested, modelled),
        "curves": curves_content(campaign, tested, modelled),
        "remarks": [remark.to_dict() for remark in condensed(remarks)],
        "decision_rule": RULE,
        "verdicts": [_verdict_row(verdict, units.get(verdict.test, unit), asked) for verdict, asked in judged],
        "closed_loop": _closed_loop(campaign, modelled, unit),
        "verification": _verification(campaign, verdicts, modelled),
    }
    return results, verdicts


def _budgets(campaign: Campaign, tested: Sequence[Tested], modelled: Modelled | None) -> list[dict[str, Any]]:
    """Return the budgets of all tests, then those of the model that is delivered."""
    found = []
    for one in tested:
        unit = sensor_of(campaign, one.test).unit
        found += budget_rows(one.test.id, one.result.estimate, unit, one.procedure.budgeted(one.result))
    if modelled is not None:
        for name, (unit, made) in _named(campaign, modelled).items():
            found += budget_rows(name, made.model.estimate, unit)
    return found


def _named(campaign: Campaign, modelled: Modelled) -> dict[str, tuple[str, Modelled]]:
    """Return unit and model of each sensor that has one, by what its rows are named: as its file is."""
    others = {f"model_{name}": (campaign.file.sensors[name].unit, one) for name, one in modelled.others.items()}
    return {"model": (modelled_sensor(campaign).unit, modelled)} | others


def _covariance(one: Tested) -> dict[str, Any] | None:
    estimate: Estimate | None = one.result.estimate
    if estimate is None:
        return None
    return {
        "test": one.test.id,
        "names": list(estimate.names),
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
        "at": at, "at_unit": shown if at is not None else "", "of": verdict.of,
        "value": finite(scaled(verdict.value, scale)), "u": finite(scaled(verdict.u, scale)), "unit": unit,
        "interval": None if interval is None else
        {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
        "lower": lower, "upper": upper, "margin": margin(interval, lower, upper),
        "verdict": verdict.verdict, "reason": verdict.reason,
    }  # fmt: skip


def _model_rows(modelled: Modelled) -> list[Row]:
    """Rows of the parameters of the model: what goes into model.json."""
    estimate = modelled.model.estimate
    rows = []
    if estimate is not None:
        for i, key in enumerate(estimate.keys):
            value, u, dof = float(estimate.values[i]), float(estimate.u[i]), float(estimate.dof[i])
            rows.append(Row(key, value, u, estimate.units[i], finite(dof), t_interval(value, u, dof)))
    units = {one.name: one.unit for one in modelled.model.parameters}
    for name, reason in modelled.model.not_estimated.items():
        rows.append(not_estimated(key_of(name), units.get(name, "1"), Reason("not_estimated", reason)))
    return rows if modelled.result is not None else by_quantity(rows)


def _not_run(campaign: Campaign, modelled: Modelled | None) -> str:
    """Say why there is no closed loop."""
    if modelled is not None:
        return "no test is held out"
    procedures = dict.fromkeys(test.procedure for test in campaign.file.tests)
    made = [one for one in procedures if one in MODELLED]
    named = (procedure_of(one).kind_of_test or one.replace("_", " ") for one in procedures)
    return "no model" if made else f"no model is made of a {' or a '.join(named)}"


def _closed_loop(campaign: Campaign, modelled: Modelled | None, unit: str) -> dict[str, Any]:
    """Say what the closed loop gave, in the unit of the sensor."""
    every = () if modelled is None else tuple(one for one in modelled.every if one.loops)
    if modelled is None or not every:
        reason = _not_run(campaign, modelled)
        return {"verdict": "not run", "reason": reason, "axes": [], "over_temperature": []}
    axes = [_loop_row(campaign, one, loop, unit) for one in every for loop in one.loops]
    warm = loop_rows(modelled.thermal_loops, factor("rad/s", unit), unit) if modelled.thermal_loops else []
    return {"verdict": modelled.whole_verdict, "reason": "", "axes": axes, "over_temperature": warm}


def _loop_unit(campaign: Campaign, own: str, unit: str) -> str:
    """Return the unit that a closed loop is told in: that of its sensor, degrees for angles."""
    if own == "rad":
        return "deg"
    units = [sensor.unit for sensor in campaign.file.sensors.values() if kind(sensor.unit) == kind(own)]
    return unit if kind(unit) == kind(own) else units[0]


def _loop_row(campaign: Campaign, of: Modelled, one: AxisLoop, unit: str) -> dict[str, Any]:
    own = of.loop_units.get(one.axis, of.unit)
    told = _loop_unit(campaign, own, unit)
    scale = factor(own, told)
    return {
        "axis": one.axis, "dwells": one.dwells, "runs": one.runs, "unit": told,
        "raw_rms": one.raw * scale, "compensated_rms": one.compensated * scale,
        "mean_square_gain": one.gain * scale**2, "u": one.u * scale**2, "dof": finite(one.dof),
        "allowed": one.allowed * scale**2, "verdict": one.verdict, "reason": one.reason,
    }  # fmt: skip


def _verification(campaign: Campaign, verdicts: Sequence[Verdict], modelled: Modelled | None) -> list[dict[str, Any]]:
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
    if modelled is not None and any(one.loops for one in modelled.every):
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
