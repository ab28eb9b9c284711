"""Run a campaign: every test, every requirement, one ``out/``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..core.errors import DataError, InertialcalError, PlanError, Problem
from ..core.estimate import Estimate
from ..core.remarks import Remark, gather
from ..core.results import Row, finite, not_estimated
from ..core.units import convert, factor, parse_quantity, si_unit
from ..files.model_json import dump_model
from ..procedures import rate_table
from ..procedures.rate_table.recordings import Turned, readings_from
from ..statistics.intervals import t_interval
from .chains import scale_factors
from .channels import turned_recording
from .display import display_unit, displayed, scaled, scaled_interval
from .load import Campaign, load
from .modelling import Modelled, Prepared, make_model
from .plans import plan_values
from .provenance import provenance
from .publish import ROW_COLUMNS, changes, csv_text, flat, json_text, previous, swap_in
from .requirements import RULE, Tested, Verdict, judge, worst
from .schema import Sensor, Test
from .tables import rate_table_readings, together

EXIT = {"PASS": 0, "FAIL": 1, "INCONCLUSIVE": 4}
VERDICT_COLUMNS = (
    "requirement", "test", "axis", "at", "at_unit", "of", "value", "u", "unit", "lo", "hi", "p", "lower", "upper",
    "verdict", "reason",
)  # fmt: skip
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run gave.

    Parameters
    ----------
    campaign : Campaign
        As read.
    results : dict
        Content of ``results.json``.
    inputs : dict of str to str
        SHA-256 of each input, by path in the campaign folder.
    verdict : {"PASS", "FAIL", "INCONCLUSIVE", ""}
        Over all requirements; empty where none is stated.
    changed : list of str
        What differs from the last run.
    """

    campaign: Campaign
    results: dict[str, Any]
    inputs: dict[str, str]
    verdict: str
    changed: list[str]

    @property
    def exit_status(self) -> int:
        """0 PASS or no requirement, 1 FAIL, 4 INCONCLUSIVE."""
        return EXIT[self.verdict] if self.verdict else 0


def check(folder: str | Path) -> tuple[Campaign, dict[str, str], tuple[Remark, ...]]:
    """Judge the inputs of a campaign without reducing them.

    Returns
    -------
    (campaign, inputs, remarks)
        SHA-256 of each input by its path; what reading the inputs brought up.

    Raises
    ------
    PlanError, DataError
        With every problem of the campaign file, or of the recordings.
    """
    campaign = load(folder)
    inputs = {"campaign.toml": campaign.sha256}
    remarks: list[Remark] = []
    problems: list[Problem] = []
    for number in range(len(campaign.file.tests)):
        try:
            prepared = _prepare(campaign, number)
        except InertialcalError as error:
            problems += error.problems
            continue
        inputs |= prepared.inputs
        remarks += prepared.readings.remarks
    if problems:
        raise DataError(list(dict.fromkeys(problems)))
    return campaign, inputs, gather(remarks)


def run(folder: str | Path, progress: Progress | None = None, write: bool = True) -> Outcome:
    """Reduce every test of a campaign, judge its requirements, write ``out/``.

    Parameters
    ----------
    folder : path
        With campaign.toml.
    progress : callable, optional
        Called with (tests done, tests in all, what comes next).
    write : bool
        Write ``out/``.

    Raises
    ------
    PlanError, DataError
        If the campaign or a recording is refused; ``out/`` stays as it was.
    StoreError
        If ``out/`` cannot be written.
    """
    campaign = load(folder)
    tell = progress or (lambda done, total, what: None)
    prepared, tested, remarks = _reduce_all(campaign, tell)
    inputs = {"campaign.toml": campaign.sha256} | {p: h for one in prepared for p, h in one.inputs.items()}
    tell(len(tested), len(tested), "model and requirements")
    modelled = _modelled(campaign, prepared)
    if modelled is not None:
        remarks += [remark.at("closed loop") for remark in modelled.remarks]
    results, verdicts = _results(campaign, tested, modelled, remarks)
    stated = [worst(verdicts)] if campaign.file.requirements else []
    if modelled is not None and modelled.loops:
        stated.append(modelled.verdict)
    verdict = next((word for word in ("FAIL", "INCONCLUSIVE", "PASS") if word in stated), "")
    results["verdict"] = verdict or None
    before = previous(campaign.folder)
    if write:
        swap_in(campaign.folder, _files(campaign, results, modelled, inputs, str(folder)))
    return Outcome(campaign, results, inputs, verdict, changes(before, results))


def _modelled(campaign: Campaign, prepared: Sequence[Prepared]) -> Modelled | None:
    """Make the model of the sensor that was fitted; problems get the place of the first such test."""
    fitted = [one for one in prepared if one.test.use == "fit"]
    if not fitted:
        return None
    sensor = _sensor(campaign, fitted[0].test)
    mine = [one for one in prepared if _sensor(campaign, one.test) is sensor]
    number = campaign.file.tests.index(fitted[0].test)
    try:
        return make_model(campaign, mine, sensor)
    except InertialcalError as error:
        raise type(error)([_placed(problem, campaign, number) for problem in error.problems]) from None


def _prepare(campaign: Campaign, number: int) -> Prepared:
    """Return readings and plan of one test; problems get the place of the test where they have none."""
    test = campaign.file.tests[number]
    try:
        sensor = _sensor(campaign, test)
        plan = _plan(campaign, test, sensor)
        readings, inputs = test_readings(campaign, test, sensor, plan)
        return Prepared(test, plan, readings, inputs)
    except InertialcalError as error:
        raise type(error)([_placed(problem, campaign, number) for problem in error.problems]) from None


def test_readings(
    campaign: Campaign, test: Test, sensor: Sensor, plan: rate_table.Plan
) -> tuple[rate_table.Readings, dict[str, str]]:
    """Return the readings of all recordings of a test, and SHA-256 of their files by path."""
    parts: list[rate_table.Readings] = []
    turned: list[Turned] = []
    inputs: dict[str, str] = {}
    for name in test.recordings:
        entry = campaign.file.recordings[name]
        if entry.rows is None:
            one, hashes = turned_recording(campaign.folder, name, entry, sensor, test)
            turned.append(one)
            inputs |= hashes
        else:
            readings, table = rate_table_readings(campaign.folder, name, entry, sensor, test)
            parts.append(readings)
            inputs[entry.file] = table.source.sha256
    if turned:
        parts.append(readings_from(plan, turned))
    return together(parts), inputs


def _placed(problem: Problem, campaign: Campaign, number: int) -> Problem:
    """Files are told by their name in the campaign; what has no place gets that of its test."""
    where = problem.where.removeprefix(f"{campaign.folder}/") or campaign.at("tests", number)
    return replace(problem, where=where)


def _sensor(campaign: Campaign, test: Test) -> Sensor:
    return campaign.file.sensors[campaign.file.recordings[test.recordings[0]].sensor]


def _plan(campaign: Campaign, test: Test, sensor: Sensor) -> rate_table.Plan:
    values, problems = plan_values(test.procedure, test.plan, "")
    if problems:
        raise PlanError(problems)
    si = si_unit(sensor.unit)
    ends = None if sensor.range is None else [parse_quantity(text).to(si) for text in sensor.range]
    factors = scale_factors(sensor, tuple(sensor.axes))
    volts = None if factors is None else dict(zip(sensor.axes, factors.tolist(), strict=True))
    return rate_table.Plan(
        **values,
        input_range=None if ends is None else (min(ends), max(ends)),
        scale_factor=volts,
        latitude=campaign.file.site.latitude,
        standards=campaign.standards,
    )


def _reduce_all(campaign: Campaign, tell: Progress) -> tuple[list[Prepared], list[Tested], list[Remark]]:
    tests = campaign.file.tests
    ready: list[Prepared] = []
    tested: list[Tested] = []
    remarks: list[Remark] = []
    problems: list[Problem] = []
    for number, test in enumerate(tests):
        tell(number, len(tests), test.id)
        try:
            prepared = _prepare(campaign, number)
            result = rate_table.reduce(prepared.plan, prepared.readings)
        except InertialcalError as error:
            problems += [_placed(problem, campaign, number) for problem in error.problems]
            continue
        ready.append(prepared)
        tested.append(Tested(test, result, [replace(row, test=test.id) for row in result.rows()]))
        remarks += [remark.at(test.id) for remark in result.remarks]
    if problems:
        raise DataError(list(dict.fromkeys(problems)))
    return ready, tested, remarks


def _results(
    campaign: Campaign, tested: Sequence[Tested], modelled: Modelled | None, remarks: Sequence[Remark]
) -> tuple[dict[str, Any], list[Verdict]]:
    rows = [
        displayed(_conditioned(row, one.test), _sensor(campaign, one.test).unit) for one in tested for row in one.rows
    ]
    if modelled is not None:
        rows += [displayed(replace(row, test="model"), _model_sensor(campaign).unit) for row in _model_rows(modelled)]
    verdicts: list[Verdict] = []
    unit = campaign.file.sensors[next(iter(campaign.file.sensors))].unit
    for requirement in campaign.file.requirements:
        found, more = judge(requirement, tested)
        verdicts += found
        rows += [displayed(row, unit) for row in more]
    results = {
        "schema": 1,
        "campaign": campaign.file.campaign.model_dump(),
        "item": campaign.file.item.model_dump(),
        "results": [row.to_dict() for row in rows],
        "covariances": [c for one in tested if (c := _covariance(one)) is not None],
        "budgets": [b for one in tested for b in _budget(one, _sensor(campaign, one.test).unit)],
        "curves": [curve for one in tested for curve in _curves(one, _sensor(campaign, one.test).unit)],
        "remarks": [remark.to_dict() for remark in gather(remarks)],
        "decision_rule": RULE,
        "verdicts": [_verdict_row(verdict, unit) for verdict in verdicts],
        "closed_loop": _closed_loop(modelled, unit),
        "verification": _verification(campaign, verdicts, modelled),
    }
    return results, verdicts


def _conditioned(row: Any, test: Test) -> Any:
    """Give a row the condition of its test, where it has none of its own."""
    return replace(row, condition=test.condition) if test.condition and not row.condition else row


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


def _budget(one: Tested, sensor_unit: str) -> list[dict[str, Any]]:
    """Return the sources of uncertainty of each quantity, in the unit that it is shown in."""
    estimate: Estimate | None = one.result.estimate
    if estimate is None:
        return []
    rows = []
    for i, name in enumerate(estimate.names):
        quantity, _, axis = name.rpartition("_")
        unit = display_unit(quantity, estimate.units[i], sensor_unit)
        scale = factor(estimate.units[i], unit)
        for component in estimate.components:
            u = float(component.u[i]) * scale
            if u > 0.0:
                dof = component.dof if isinstance(component.dof, float) else float(component.dof[i])
                rows.append(
                    {
                        "test": one.test.id, "quantity": quantity, "axis": axis, "source": component.source,
                        "kind": component.kind, "distribution": component.distribution, "u": u, "unit": unit,
                        "dof": finite(dof),
                    }
                )  # fmt: skip
    return rows


def _curves(one: Tested, unit: str) -> list[dict[str, Any]]:
    found = []
    for sensor, line in one.result.lines.items():
        if sensor not in line.axes:
            continue
        errors = rate_table.rate_errors(one.result.plan, one.result.readings, line, "dwell_mean")
        rates = convert([error.applied for error in errors], "rad/s", unit)
        found.append(
            {
                "name": "rate_error", "test": one.test.id, "axis": sensor, "of": "dwell_mean",
                "x": {"name": "rate", "unit": unit, "values": rates.tolist()},
                "y": {"name": "error", "unit": "%", "values": [scaled(error.error, 100.0) for error in errors]},
                "u": [scaled(error.u, 100.0) for error in errors],
                "dof": [finite(error.dof) for error in errors],
            }
        )  # fmt: skip
    return found


def _verdict_row(verdict: Verdict, sensor_unit: str) -> dict[str, Any]:
    relative = verdict.unit == "1"
    unit = "%" if relative else display_unit("", verdict.unit, sensor_unit) if verdict.unit else ""
    scale = factor(verdict.unit, unit) if verdict.unit else 1.0
    interval = scaled_interval(verdict.interval, scale)
    at = None if verdict.at is None else float(convert([verdict.at], "rad/s", sensor_unit)[0])
    return {
        "requirement": verdict.requirement, "test": verdict.test, "axis": verdict.axis,
        "at": at, "at_unit": sensor_unit if at is not None else "", "of": verdict.of,
        "value": finite(scaled(verdict.value, scale)), "u": finite(scaled(verdict.u, scale)), "unit": unit,
        "interval": None if interval is None else
        {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
        "lower": scaled(verdict.lower, scale), "upper": scaled(verdict.upper, scale),
        "verdict": verdict.verdict, "reason": verdict.reason,
    }  # fmt: skip


def _model_sensor(campaign: Campaign) -> Sensor:
    return _sensor(campaign, next(test for test in campaign.file.tests if test.use == "fit"))


def _model_rows(modelled: Modelled) -> list[Row]:
    """Rows of the parameters of the model: what goes into model.json."""
    estimate = modelled.model.estimate
    rows = []
    if estimate is not None:
        for i, name in enumerate(estimate.names):
            quantity, _, axis = name.rpartition("_")
            value, u, dof = float(estimate.values[i]), float(estimate.u[i]), float(estimate.dof[i])
            rows.append(Row(quantity, axis, value, u, estimate.units[i], finite(dof), t_interval(value, u, dof)))
    for name, reason in modelled.model.not_estimated.items():
        quantity, _, axis = name.rpartition("_")
        rows.append(not_estimated(quantity, axis, "rad" if quantity == "misalignment" else "1", reason))
    return rows


def _closed_loop(modelled: Modelled | None, unit: str) -> dict[str, Any]:
    """Say what the closed loop gave, in the unit of the sensor."""
    if modelled is None or not modelled.loops:
        reason = "no test is for a fit" if modelled is None else "no test is held out"
        return {"verdict": "not run", "reason": reason, "axes": []}
    scale = factor("rad/s", unit)
    axes = [
        {
            "axis": one.axis, "dwells": one.dwells, "runs": one.runs, "unit": unit,
            "raw_rms": one.raw * scale, "compensated_rms": one.compensated * scale,
            "mean_square_gain": one.gain * scale**2, "u": one.u * scale**2, "dof": finite(one.dof),
            "allowed": one.allowed * scale**2, "verdict": one.verdict, "reason": one.reason,
        }
        for one in modelled.loops
    ]  # fmt: skip
    return {"verdict": modelled.verdict, "reason": "", "axes": axes}


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
    if modelled is not None and modelled.loops:
        held = [test.id for test in campaign.file.tests if test.use == "hold_out"]
        text = "compensation improves readings that the model has not seen"
        row = {
            "requirement": "closed loop",
            "text": text,
            "method": "test",
            "evidence": held,
            "verdict": modelled.verdict,
        }
        rows.append(row)
    return rows


def _files(
    campaign: Campaign, results: dict[str, Any], modelled: Modelled | None, inputs: dict[str, str], folder: str
) -> dict[str, str]:
    record = provenance(inputs, folder, {})
    model = {} if modelled is None or modelled.verdict == "FAIL" else {"model.json": dump_model(modelled.model)}
    return model | {
        "results.json": json_text(results),
        "results.csv": csv_text([flat(row) for row in results["results"]], ROW_COLUMNS),
        "verdicts.csv": csv_text([flat(row) for row in results["verdicts"]], VERDICT_COLUMNS),
        "provenance.json": json_text(record | {"campaign": campaign.file.campaign.id}),
    }


__all__ = ["EXIT", "Outcome", "check", "run"]
