"""The models that a campaign makes: one a sensor, of a rate table or of positions; and their files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ..core.errors import InertialcalError, PlanError
from ..files.models.model_json import dump_model
from ..procedures.thermal.correction import ThermalCorrection
from .cross_checks import MODELLED
from .engine import Prepared
from .load import Campaign
from .modelling import Modelled, make_model
from .positions_model import make_positions_model
from .prepared import placed, sensor_of
from .requirements import Tested
from .schema import Test
from .thermal_left import LeftOver

FIRST = "model.json"


def models_of(
    campaign: Campaign,
    prepared: Sequence[Prepared],
    tested: Sequence[Tested],
    biases: Mapping[str, ThermalCorrection],
    left: LeftOver,
) -> Modelled | None:
    """Make the model of the sensor that was fitted first, and with it those of others whose positions were fitted.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared, tested : sequence of Prepared, of Tested
        Every test, before and after its reduction.
    biases, left
        As ``modelling.make_model`` takes them.

    Raises
    ------
    PlanError
        If tests are for a fit that make no model of their own; problems get the place of the first test of each.
    """
    fitted = [one.test for one in prepared if one.test.procedure in MODELLED and one.test.use == "fit"]
    by_sensor: dict[str, list[Test]] = {}
    for test in fitted:
        by_sensor.setdefault(_name(campaign, test), []).append(test)
    if not by_sensor:
        return None
    _check(campaign, by_sensor)
    made = {}
    for name, tests in by_sensor.items():
        number = campaign.file.tests.index(tests[0])
        try:
            made[name] = _one(campaign, tests[0], prepared, tested, biases, left)
        except InertialcalError as error:
            raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None
    found = {name: one for name, one in made.items() if one is not None}
    first, *others = found or [""]
    return replace(found[first], others={name: found[name] for name in others}) if found else None


def _one(
    campaign: Campaign,
    test: Test,
    prepared: Sequence[Prepared],
    tested: Sequence[Tested],
    biases: Mapping[str, ThermalCorrection],
    left: LeftOver,
) -> Modelled | None:
    """Make the model of the sensor of a test, of all tests of its procedure."""
    sensor = sensor_of(campaign, test)

    def mine(one: Prepared | Tested) -> bool:
        return one.test.procedure == test.procedure and sensor_of(campaign, one.test) is sensor

    if test.procedure == "positions":
        held = {_name(campaign, one) for one in campaign.file.tests if one.use == "hold_out"}
        return make_positions_model(campaign, [one for one in tested if mine(one)], sensor, 1.0 / max(len(held), 1))
    return make_model(campaign, [one for one in prepared if mine(one)], sensor, biases, left)


def _check(campaign: Campaign, by_sensor: Mapping[str, Sequence[Test]]) -> None:
    """Refuse a second model by a rate table, and two procedures that both fit one sensor."""
    first, *others = by_sensor.values()
    wrong = [test for tests in others for test in tests if test.procedure != "positions"]
    if wrong:
        names = ", ".join(sorted(test.id for test in wrong))
        what = f"tests {names} are for a fit of another sensor: a campaign makes one model of a rate table"
        do = 'Give them use = "report_only", or their own campaign'
        raise PlanError(what, campaign.at("tests", campaign.file.tests.index(wrong[0])), do=do)
    for tests in (first, *others):
        other = next((test for test in tests if test.procedure != tests[0].procedure), None)
        if other is not None:
            what = f"tests {tests[0].id!r} and {other.id!r} both fit the model of {_name(campaign, other)!r}"
            do = 'Give one of them use = "report_only"'
            where = campaign.at("tests", campaign.file.tests.index(other))
            raise PlanError(what, where, "a sensor has one model", do, "plans_differ")


def _name(campaign: Campaign, test: Test) -> str:
    return campaign.file.recordings[test.recordings[0]].sensor


def model_files(modelled: Modelled) -> dict[str, str]:
    """Return the text of each model file, by its name; none of a model that is worse than none."""
    named = {FIRST: modelled} | {f"model_{name}.json": one for name, one in modelled.others.items()}
    return {name: dump_model(one.model) for name, one in named.items() if one.verdict != "FAIL"}
