"""Conditions of a campaign: which models there are, which tests their terms come from, and what is refused."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from independent import conditions
from inertialcal.campaign.calls.call import campaign_of
from inertialcal.campaign.engine.whole import Whole, reduce_campaign
from inertialcal.campaign.file.conditions import chosen_tests, conditions_of
from inertialcal.campaign.file.cross_checks import cross_checks
from inertialcal.campaign.file.load import load
from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.campaign.inputs.sources import Memory
from inertialcal.campaign.models.build import model_files
from inertialcal.core.errors import PlanError
from inertialcal.rigs.twin import SEED, Twin
from npsat1_small import short_twin

RATE = 'condition = "air"\nafter = ["thermal_ambient"]'
NOT_AFTER = 'condition = "vacuum"\nafter = ["thermal_ambient"]'
UNSAID = 'after = ["thermal_ambient"]'


@pytest.fixture(scope="module")
def twin() -> Twin:
    return short_twin(4)


def file_of(text: str) -> CampaignFile:
    return CampaignFile.model_validate(tomllib.loads(text.replace(SEED, "4")))


def test_each_condition_has_a_model_and_decisions_bring_terms_of_another(twin: Twin) -> None:
    file = file_of(twin.campaign)
    assert conditions_of(file, "suite") == ("air", "vacuum")
    air, vacuum = (chosen_tests(file, "suite", one) for one in ("air", "vacuum"))
    assert {kind: [test.id for test in tests] for kind, tests in air.items()} == {
        "scale_factor": ["rate"], "misalignment": ["rate"], "asymmetry": ["rate"], "bias": ["thermal_ambient"],
        "noise": ["noise"],
    }  # fmt: skip
    assert [test.id for test in vacuum["bias"]] == ["thermal_vacuum"]
    assert [test.id for test in vacuum["scale_factor"]] == ["rate"]


def test_terms_named_for_every_condition_leave_each_its_own_tests(twin: Twin) -> None:
    """Else the polynomial of air would be the bias of the model in vacuum."""
    start, stop = twin.campaign.index("[model.by_condition]"), twin.campaign.index("[[requirements]]")
    terms = '[model]\nterms = { bias = ["thermal_ambient"], scale_factor = ["rate"], hysteresis = [] }\n'
    file = file_of(twin.campaign[:start] + terms + twin.campaign[stop:])
    air, vacuum = (
        {kind: [test.id for test in tests] for kind, tests in chosen_tests(file, "suite", one).items()}
        for one in ("air", "vacuum")
    )
    assert (air["bias"], vacuum["bias"]) == (["thermal_ambient"], ["thermal_vacuum"])
    assert (air["scale_factor"], vacuum["scale_factor"]) == (["rate"], ["rate"])  # no table was turned in vacuum
    assert not {"hysteresis"} & {*air, *vacuum}


@pytest.mark.parametrize(
    ("old", "new", "codes"),
    [
        (RATE, NOT_AFTER, {"condition_differs"}),
        (RATE, UNSAID, {"condition_differs", "condition_needed"}),
        ('condition = "air"\nmounting', 'condition = "aire"\nmounting', {"unknown_name"}),
        ("[model.by_condition.vacuum]", "[model.by_condition.space]", {"unknown_name"}),
        ('air = { bias = ["thermal_ambient"] }', 'air = { bias = ["noise"] }', {"unknown_name"}),
        ('misalignment = ["rate"]', 'misalignment = ["thermal_vacuum"]', {"unknown_name", "wrong_value"}),
    ],
    ids=["after", "unsaid", "condition", "decision", "kind", "matrix"],
)
def test_what_does_not_fit_its_condition_is_refused(twin: Twin, old: str, new: str, codes: set[str]) -> None:
    assert old in twin.campaign
    found = cross_checks(None, file_of(twin.campaign.replace(old, new)), lambda *key: ".".join(map(str, key)))
    assert codes <= {problem.code for problem in found}
    assert all(problem.where for problem in found)


def test_ranges_of_a_condition_rise(twin: Twin) -> None:
    with pytest.raises(ValueError, match="not above"):
        file_of(twin.campaign.replace('pressure = ["80 kPa", "120 kPa"]', 'pressure = ["120 kPa", "80 kPa"]'))


def whole_of(text: str, twin: Twin) -> Whole:
    """Return a campaign reduced and judged, from memory."""
    store = Memory(twin.recordings, {file: extra.content for file, extra in twin.extras.items()})
    return reduce_campaign(campaign_of(tomllib.loads(text.replace(SEED, "4"))), store)


@pytest.mark.slow
def test_the_model_of_each_condition_is_judged_on_its_own_readings(twin: Twin) -> None:
    whole = whole_of(twin.campaign, twin)
    assert whole.modelled is not None
    air, vacuum = whole.modelled.every
    assert (air.name, air.condition, vacuum.name, vacuum.condition) == ("model", "air", "model_vacuum", "vacuum")
    assert air.model is not None
    assert vacuum.model is not None
    assert air.loops
    assert not vacuum.loops  # no table was turned in vacuum
    assert {one.test for one in air.residuals} == {"thermal_ambient_check"}
    assert {one.test for one in vacuum.residuals} == {"thermal_vacuum_check"}
    assert "FAIL" not in (air.verdict, vacuum.verdict)  # few power-ups: it may be INCONCLUSIVE
    assert air.model.matrix == pytest.approx(vacuum.model.matrix)
    assert vacuum.model.pressure_range == (0.0, 0.053)
    named = {one.subject for one in vacuum.remarks if one.code == "term_of_another_condition"}
    assert named == {"vacuum"}
    assert not [one for one in air.remarks if one.code == "term_of_another_condition"]
    assert list(model_files(whole.modelled)) == ["model.json"]
    rows = whole.results["closed_loop"]
    assert {one["condition"] for one in rows["axes"]} == {"air"}
    assert {one["condition"] for one in rows["over_temperature"]} == {"air", "vacuum"}


@pytest.mark.slow
def test_a_bias_of_the_wrong_condition_fails_and_is_left_out(twin: Twin) -> None:
    """The polynomial of air in the model of vacuum: readings held out in vacuum refute it."""
    wrong = twin.campaign.replace('bias = ["thermal_vacuum"]', 'bias = ["thermal_ambient"]')
    whole = whole_of(wrong, twin)
    assert whole.modelled is not None
    vacuum = next(one for one in whole.modelled.every if one.condition == "vacuum")
    assert vacuum.model is not None
    assert {one.code for one in vacuum.remarks} >= {"term_of_another_condition"}
    compared = {one.loop.axis: one.loop for one in vacuum.residuals}
    right = {one.loop.axis: one.loop for one in whole.modelled.every[0].residuals}
    assert all(compared[axis].compensated > 2.0 * right[axis].compensated for axis in compared)


@pytest.mark.slow
def test_two_tests_of_one_term_are_refused_unless_model_decides(twin: Twin) -> None:
    """Two thermal tests of one condition: nothing says which bias it is."""
    text = twin.campaign
    start, stop = text.index("# The bias is that of the chamber"), text.index("[[requirements]]")
    alike = (text[:start] + text[stop:]).replace('condition = "vacuum"', 'condition = "air"')
    alike = alike.replace('["80 kPa", "120 kPa"]', '["0 Pa", "120 kPa"]')
    with pytest.raises(PlanError) as refused:
        whole_of(alike, twin)
    assert {problem.code for problem in refused.value.problems} == {"terms_twice"}


@pytest.mark.slow
def test_a_pressure_outside_the_condition_is_an_error_and_gives_no_model(twin: Twin) -> None:
    whole = whole_of(twin.campaign.replace('["0 Pa", "0.053 Pa"]', '["0 Pa", "1e-6 Pa"]'), twin)
    errors = {one.test.id: {remark.code for remark in one.errors} for one in whole.tested if one.errors}
    assert errors == {"thermal_vacuum": {"outside_condition"}, "thermal_vacuum_check": {"outside_condition"}}
    assert whole.modelled is not None
    assert [one.condition for one in whole.modelled.every] == ["air"]
    assert whole.verdict in ("FAIL", "INCONCLUSIVE")


@pytest.mark.slow
def test_readings_held_out_judge_the_bias_that_the_model_holds(tmp_path: Path) -> None:
    """The model of air has the constant of the rate table: what it leaves over temperature is told, not the polynomial.

    A recording that crosses into another condition is warned of, and power-ups of one sensor judge no other's.
    """
    case = conditions.suite(1, programme=conditions.Programme(runs=3, held_out=1))
    text = case.texts["campaign.toml"].replace('bias = ["thermal_air"]', 'bias = ["rate"]')
    entry = text.index("[recordings.vacuum4]")
    text = text[:entry] + text[entry:].replace('sensor = "gyros"', 'sensor = "spare"', 1)
    spare = '[sensors.spare]\nkind = "gyro"\naxes = ["x", "y", "z"]\nunit = "deg/s"\n\n'
    text = text.replace("[sensors.gyros]", f"{spare}[sensors.gyros]")
    pressure = case.tables["air1.csv"].columns["pressure [Pa]"]
    pressure[: len(pressure) // 3] = 1e-3
    case.texts["campaign.toml"] = text
    case.write(tmp_path)
    whole = reduce_campaign(load(tmp_path))
    assert whole.modelled is not None
    (air,) = (one for one in whole.modelled.every if one.condition == "air")
    loops = {one.test: one.loop for one in air.residuals if one.loop.axis == "x"}
    assert np.degrees(loops["held_air"].compensated) > 0.02  # 1.6e-3 deg/s/degC over 80 degC, of which no term is left
    assert {one.test for made in whole.modelled.every for one in made.residuals} == {"held_air"}
    assert not whole.modelled.residuals
    said = [one for test in whole.tested for one in test.remarks if one.code == "partly_outside_condition"]
    assert [(one.recording, one.count) for one in said] == [("air1", len(pressure) // 3)]
