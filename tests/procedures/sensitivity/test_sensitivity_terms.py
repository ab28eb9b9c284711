"""Sensitivities against closed forms: readings without noise give their coefficients, whatever the offsets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sensitivity_cases import SUPPLY, codes, reduced, row, truth_of, with_supply

from independent import climate
from independent.climate import Unit, Visits
from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key
from inertialcal.procedures.sensitivity.plan import Plan

QUIET = Unit(sample=1e-9, thermometer=0.0, meter=0.0)
FEW = Visits(runs=2, dwell=100.0)
EXACT = 1e-5  # relative: files have seven digits


@pytest.mark.parametrize("name", ["bias_supply x", "bias_supply_temperature x", "bias_supply y"])
def test_readings_without_noise_give_the_coefficients(name: str) -> None:
    case = climate.supplied(1, QUIET, FEW)
    found = row(reduced(case), name)
    assert found.value == pytest.approx(truth_of(case, name), rel=EXACT)


def test_the_scale_factor_changes_with_supply_and_temperature() -> None:
    case = climate.on_table(1, QUIET, Visits(runs=2, volts=(4.85, 5.0, 5.15), rates=(-3.0, 0.0, 3.0), axes="x"))
    plan = Plan(to=["supply", "temperature"], order=2)
    result = reduced(case, plan)
    for name in ("scale_factor_error_supply x", "scale_factor_error_temperature_1 x"):
        assert row(result, name).value == pytest.approx(truth_of(case, name), rel=0.01)
    assert row(result, "scale_factor_error x").value == pytest.approx(QUIET.scale[0], rel=0.01)


def test_an_offset_of_a_power_up_changes_nothing() -> None:
    small, large = (reduced(climate.supplied(1, replace(QUIET, turn_on=size), FEW)) for size in (1e-6, 10.0))
    found = [row(one, "bias_supply x").value for one in (small, large)]
    assert found[0] == pytest.approx(found[1], rel=EXACT)


def test_the_reference_moves_the_interaction_into_nothing_else() -> None:
    case = climate.supplied(1, QUIET, FEW)
    at_20, at_50 = (reduced(case, replace(SUPPLY, reference_temperature=T)) for T in (20.0, 50.0))
    slope = row(at_20, "bias_supply_temperature x").value
    assert slope is not None
    moved = row(at_50, "bias_supply x").value
    assert moved == pytest.approx(truth_of(case, "bias_supply x") + 30.0 * slope, rel=EXACT)


def test_a_stated_reference_is_that_of_the_model() -> None:
    case = climate.supplied(1, visits=FEW)
    assert reduced(case).references["supply"] == 5.0
    assert reduced(case, replace(SUPPLY, references={"supply": "4900 mV"})).references["supply"] == pytest.approx(4.9)


def test_a_gain_of_the_meter_is_one_of_the_sensitivity() -> None:
    standards = {"supply_meter.voltage": Influence(0.01, standard="supply_meter", quantity="voltage")}
    result = reduced(climate.supplied(1, QUIET, FEW), replace(SUPPLY, standards=standards))
    assert result.estimate is not None
    at = result.estimate.index(Key("bias_supply", "x"))
    assert result.estimate.u[at] == pytest.approx(0.01 * result.estimate.values[at], rel=0.01)
    of_both = result.estimate.covariance[at, result.estimate.index(Key("bias_supply", "y"))]
    assert of_both == pytest.approx(result.estimate.u[at] ** 2, rel=0.1)  # one meter for both axes


def test_an_error_of_each_level_is_that_of_a_slope_through_them() -> None:
    """Three levels with errors u of their own: the slope over them has u(slope) = b u / sqrt(sum (V - mean)^2)."""
    u = 0.005
    standards = {"supply_meter.resolution": Influence(u, "V", standard="supply_meter", quantity="resolution")}
    visits = Visits(runs=2, temperatures=(20.0,), volts=(4.85, 5.0, 5.15), dwell=100.0)
    result = reduced(climate.supplied(1, QUIET, visits), replace(SUPPLY, standards=standards))
    found = row(result, "bias_supply x")
    assert found.u == pytest.approx(QUIET.supply * np.pi / 180.0 * u / np.sqrt(2 * 0.15**2), rel=0.01)


def test_a_stated_term_is_taken_off_and_has_its_source() -> None:
    said = '{ value = "0.02 deg/s/V", u = "1 mdeg/s/V", source = "data sheet" }'
    result = reduced(climate.supplied(1, QUIET, FEW), replace(SUPPLY, stated={"bias_supply_x": said}))
    found = row(result, "bias_supply x")
    assert found.value == pytest.approx(np.radians(0.02))
    assert found.u == pytest.approx(np.radians(1e-3))
    assert found.reason.code == "stated"
    assert [one.axis for one in result.curves() if one.of == "supply" and one.name == "sensitivity"] == ["y"]
    assert "data sheet" in found.reason.text
    assert row(result, "bias_supply y").reason.code == ""
    other = row(result, "bias_supply_temperature x")
    assert other.value == pytest.approx(np.radians(2e-4), rel=1e-3)


@pytest.mark.parametrize("said", ["5", '{ value = "1 deg/s/V" }', {"value": "1 deg", "u": "1 deg", "source": "x"}])
def test_a_stated_term_needs_value_uncertainty_and_source(said: object) -> None:
    with pytest.raises((PlanError, DataError)):
        reduced(climate.supplied(1, QUIET, FEW), replace(SUPPLY, stated={"bias_supply": said}))


def test_what_is_not_there_has_an_upper_limit_and_says_what_would_be_seen() -> None:
    result = reduced(climate.supplied(1, Unit(supply=0.0, supply_temperature=0.0)))
    found = row(result, "bias_supply x")
    assert found.status == "upper_limit"
    assert found.interval is not None
    assert found.value == found.interval.hi
    assert "90 %" in found.reason.text
    assert result.estimate is not None
    assert Key("bias_supply", "x") in result.estimate.keys


def test_no_temperature_no_interaction() -> None:
    result = reduced(climate.supplied(1, QUIET, replace(FEW, temperatures=(20.0,))))
    assert row(result, "bias_supply x").status == "estimated"
    assert row(result, "bias_supply_temperature x").reason.code == "not_varied"


@pytest.mark.parametrize(("order", "terms"), [(0, 0), (1, 1), (None, 3)])
def test_the_polynomial_in_temperature_has_the_order_that_is_asked_for(order: int | None, terms: int) -> None:
    result = reduced(climate.supplied(1), replace(SUPPLY, to=["supply", "temperature"], order=order))
    found = [one for one in result.rows() if one.key.quantity == "bias_temperature" and one.axis == "x"]
    assert len([one for one in found if one.status != "not_estimated"]) == terms


def test_power_ups_of_one_level_each_tell_nothing() -> None:
    case = climate.supplied(1, visits=Visits(runs=3, volts=(5.0,), temperatures=(20.0,), dwell=200.0))
    levels = dict(zip(case.tables, (-0.15, 0.0, 0.15), strict=True))
    result = reduced(case, spoil=lambda one: with_supply(one, lambda values: values + levels[one.name]))
    assert row(result, "bias_supply x").reason.code == "between_power_ups"
    assert "between_power_ups" in codes(result)
