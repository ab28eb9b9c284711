"""The models that a campaign makes: tests with ``use = "fit"``, judged on those with ``use = "hold_out"``.

A procedure says which terms its tests give, and what they do to readings held out; here they become a model a sensor,
with what the campaign says of item and output, and with one verdict.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np

from ...core.errors import InertialcalError, PlanError
from ...core.influence import Occasion, influence_of
from ...core.remarks import Remark
from ...files.models.model_json import dump_model
from ...procedures import procedure_of
from ...procedures.model_terms import ModelTerms
from ...procedures.protocol import Correction, Procedure, Tested
from ...sensors.model.assemble import model_from
from ...sensors.model.sensor_model import Item, SensorModel
from ...statistics.closed_loop import judged, overall
from ..engine.engine import computable, placed, sensors_of
from ..file.load import Campaign
from ..file.schema import Test
from ..file.sensors import Sensor
from ..inputs.chains import body_scale_factors
from .judged import NOT_RUN, JudgedModel, Residual, ResidualLoop

FIRST = "model.json"
MATRIX = ("scale_factor", "misalignment", "asymmetry")  # of [model] terms, all from one reduction

Reduced = Mapping[str, Tested[Any, Any, Any]]
Errors = Mapping[str, Sequence[Remark]]  # By test


def build_models(
    campaign: Campaign,
    reduced: Reduced,
    corrections: Mapping[str, Correction],
    residuals: Mapping[str, Residual],
    errors: Errors,
) -> JudgedModel | None:
    """Return the model of the sensor that was fitted first, and with it those of others that may each have one.

    There is none where a test behind it, or held out for it, has a remark that is an error.

    Raises
    ------
    PlanError
        If tests are for a fit that make no model of their own, or tests that belong together differ in their plan;
        problems get the place of the first test of each.
    DataError
        If they cannot be reduced together.
    """
    by_sensor: dict[str, list[Test]] = {}
    for test in campaign.file.tests:
        if test.use == "fit" and procedure_of(test.procedure).makes_model:
            for name in sensors_of(campaign, test):
                by_sensor.setdefault(name, []).append(test)
    if not by_sensor:
        return _residuals_alone(residuals)
    _check(campaign, by_sensor)
    found = {}
    for name, tests in by_sensor.items():
        number = campaign.file.tests.index(tests[0])
        try:
            with computable(tests[0].id):
                made = _build(campaign, name, tests[0].procedure, reduced, corrections, residuals, errors)
        except InertialcalError as error:
            raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None
        if made is not None:
            found[name] = made
    first, *others = found or [""]
    if not found:
        return _residuals_alone(residuals)
    return replace(found[first], others={name: found[name] for name in others})


def _residuals_alone(residuals: Mapping[str, Residual]) -> JudgedModel | None:
    """Return the closed loop of tests held out where no model is made; None where none is."""
    loops = _residual_loops(residuals, 1.0)
    return JudgedModel(None, residuals=loops, verdict=overall([one.loop for one in loops])) if loops else None


def _residual_loops(residuals: Mapping[str, Residual], share: float) -> tuple[ResidualLoop, ...]:
    """Return each axis of each test held out with its verdict."""
    every = [(test, one.against, loop) for test, one in residuals.items() for loop in one.found.loops]
    words = judged([loop for *_, loop in every], share)
    return tuple(ResidualLoop(test, against, loop) for (test, against, _), loop in zip(every, words, strict=True))


def _check(campaign: Campaign, by_sensor: Mapping[str, Sequence[Test]]) -> None:
    """Refuse a second model where a campaign makes one, and two procedures that both fit one sensor."""
    _, *others = by_sensor.values()
    wrong = [test for tests in others for test in tests if not procedure_of(test.procedure).model_of_each]
    if wrong:
        names = ", ".join(sorted({test.id for test in wrong}))
        procedure = wrong[0].procedure.replace("_", " ")
        what = f"tests {names} are for a fit of another sensor: a campaign makes one model of a {procedure}"
        do = 'Give them use = "report_only", or their own campaign'
        raise PlanError(what, campaign.at("tests", campaign.file.tests.index(wrong[0])), do=do)
    for name, tests in by_sensor.items():
        other = next((test for test in tests if test.procedure != tests[0].procedure), None)
        if other is not None:
            what = f"tests {tests[0].id!r} and {other.id!r} both fit the model of {name!r}"
            do = 'Give one of them use = "report_only"'
            where = campaign.at("tests", campaign.file.tests.index(other))
            raise PlanError(what, where, "a sensor has one model", do, "plans_differ")


def _build(
    campaign: Campaign,
    name: str,
    of_procedure: str,
    reduced: Reduced,
    corrections: Mapping[str, Correction],
    residuals: Mapping[str, Residual],
    errors: Errors,
) -> JudgedModel | None:
    """Make and judge the model of a sensor, of all tests of a procedure on it; None where there is none."""
    sensor, procedure = campaign.file.sensors[name], procedure_of(of_procedure)
    mine = [test for test in campaign.file.tests if test.procedure == of_procedure
            and name in sensors_of(campaign, test)]  # fmt: skip
    fitted = [test for test in mine if test.use == "fit"]
    held = [test for test in mine if test.use == "hold_out"]
    matrix, bias = (_chosen(campaign, fitted, terms) for terms in (MATRIX, ("bias",)))
    if any(errors.get(test.id) for test in (*matrix, *bias, *held)):
        return None
    result, terms = _joint(procedure, [reduced[test.id] for test in matrix], sensor.kind)
    if {test.id for test in bias} != {test.id for test in matrix} and terms is not None:
        terms = terms.with_bias_of(
            _joint(procedure, [reduced[test.id] for test in bias], sensor.kind)[1] if bias else None
        )
    if terms is None or terms.estimate is None:
        return None
    correction = _correction([*matrix, *bias, *held], corrections)
    own = dict.fromkeys(one.id for one in (*matrix, *bias))
    before = dict.fromkeys(name for test in (*matrix, *bias) for name in test.after)
    sources = [[reduced[test] for test in tests] for tests in (own, before)]
    model = whole = _model(campaign, sensor, terms, sources)
    if correction is not None and bias:
        whole = _model(campaign, sensor, correction.with_terms(terms), sources)
    procedure.check_alike([reduced[test.id] for test in (*fitted, *held)])
    if not held:
        return JudgedModel(whole)
    behind, unseen = ([reduced[test.id] for test in tests] for tests in ([*matrix, *bias], held))
    found = procedure.held_out(result, behind, unseen, model)
    if found is None:
        return JudgedModel(whole)
    left = residuals if procedure.takes_corrections else {}
    share = _share(campaign, procedure) / (2.0 if any(one.found.loops for one in left.values()) else 1.0)
    loops = judged(found.loops, share)
    warm = _residual_loops(left, share)
    every = (*loops, *(one.loop for one in warm))
    verdict = overall(every) if every else NOT_RUN
    whole = replace(whole, judged=verdict == "PASS")
    return JudgedModel(whole, loops, verdict, found.remarks, found.curves, warm)


def _chosen(campaign: Campaign, fitted: Sequence[Test], terms: Sequence[str]) -> list[Test]:
    """Return the tests that terms come from: those that [model] names; all where it names none of them."""
    named = campaign.file.model.terms
    wanted = {test for term in terms for test in named.get(term, [])}  # type: ignore[call-overload]
    own = [one for one in fitted if one.id in wanted]
    says_nothing = not any(term in named for term in terms) or (wanted and not own)
    return list(fitted) if says_nothing else own


def _joint(
    procedure: Procedure[Any, Any, Any], tests: Sequence[Tested[Any, Any, Any]], kind: str
) -> tuple[Any, ModelTerms | None]:
    """Return the result of tests reduced together, as it is about one kind of sensor, and the terms that it gives."""
    if not tests:
        return None, None
    made = procedure.joined(tests)
    parts = procedure.by_sensor(tests[0].result if made is None else procedure.reduce(*made))
    result = parts.get(kind, parts.get(""))
    return result, None if result is None else procedure.terms(result, tests)


def _correction(tests: Sequence[Test], corrections: Mapping[str, Correction]) -> Correction | None:
    """Return what was taken off the readings of all of these tests; None where nothing was.

    Raises
    ------
    PlanError
        If it was not the same in all: their biases mean different things.
    """
    names = {"".join(one.after) for one in tests}
    if len(names) > 1:
        what = "tests that make one model, or judge it, differ in after: their biases mean different things"
        raise PlanError(what, do="Give them the same after", code="plans_differ")
    return corrections.get(names.pop()) if names else None


def _model(
    campaign: Campaign, sensor: Sensor, terms: ModelTerms, sources: Sequence[Sequence[Tested[Any, Any, Any]]]
) -> SensorModel:
    """Return the model for the output of the sensor: volts where its chain has them and its axes are the body's.

    Parameters
    ----------
    campaign, sensor, terms
        Of it.
    sources : (sequence of Tested, sequence of Tested)
        Tests that it is made of, and those whose results were taken off before.
    """
    assert terms.estimate is not None  # noqa: S101 - the caller has looked
    assert sensor.kind != "other"  # noqa: S101 - of which no procedure makes a model
    volts = None if sensor.mounting is not None else body_scale_factors(sensor)
    item = campaign.file.item
    of_temperature: dict[str, Any] = {
        "reference_temperature": terms.reference_temperature,
        "temperature_range": terms.temperature_range,
    }
    estimate = terms.estimate.select(terms.parameters)
    drawn_on = {influence_of(name) for one in estimate.components for name in one.named_changes}
    return model_from(
        estimate,
        sensor.kind,
        terms.axes,
        scale_factor=terms.scale_factor if volts is None else np.array([volts[axis] for axis in terms.axes]),
        output_unit=terms.output_unit if volts is None else "V",
        source="" if sensor.mounting is None else f"readings in body axes, after mounting {sensor.mounting}",
        item=Item(item.maker, item.part, item.serial),
        input_range=terms.input_range,
        bias_run_to_run=terms.bias_run_to_run,
        not_estimated=terms.not_estimated,
        values=terms.values,
        references=terms.references,
        provenance={str(key): one for key, one in terms.provenance.items()},
        influences={name: one for name, one in campaign.standards.items() if name in drawn_on},
        occasion=reduce(Occasion.joined, [one.occasion for one in sources[0]]),
        tests=tuple(one.id for tests in sources for one in tests),
        selections=tuple(one.selection for tests in sources for one in tests),
        **({} if terms.reference_temperature is None else of_temperature),
    )


def _share(campaign: Campaign, procedure: Procedure[Any, Any, Any]) -> float:
    """Return the share of the risk of a wrong verdict that is left to one sensor."""
    if not procedure.model_of_each:
        return 1.0
    held = {name for test in campaign.file.tests if test.use == "hold_out" for name in sensors_of(campaign, test)}
    return 1.0 / max(len(held), 1)


def model_files(modelled: JudgedModel) -> dict[str, str]:
    """Return the text of each model file, by its name; none of a model that is worse than none."""
    named = {FIRST: modelled} | {f"model_{name}.json": one for name, one in modelled.others.items()}
    return {name: dump_model(one.model) for name, one in named.items()
            if one.model is not None and one.verdict != "FAIL"}  # fmt: skip
