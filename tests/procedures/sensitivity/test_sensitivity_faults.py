"""What goes wrong in a laboratory ends in a refusal, a remark, or in an interval that holds the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from sensitivity_cases import (
    SUPPLY,
    codes,
    hits,
    recordings_of,
    reduced,
    row,
    with_supply,
    with_transient,
)

from independent import climate
from independent.climate import Unit, Visits
from inertialcal.core.errors import DataError
from inertialcal.core.influence import Influence
from inertialcal.core.remarks import Remark
from inertialcal.procedures.sensitivity.plan import Plan
from inertialcal.procedures.sensitivity.readings import ConditionRecording, readings_from
from inertialcal.procedures.sensitivity.terms import terms

NAMES = ("bias_supply", "bias_supply_temperature")
QUICK = Visits(runs=3, dwell=200.0)


def remarks_in_air(highest: float) -> Sequence[Remark]:
    """Return the remarks of a test of pressure that begins in the air."""

    def pressed(one: ConditionRecording) -> ConditionRecording:
        pressure = {axis: highest * values / 5.15 for axis, values in one.conditions["supply"].items()}
        return replace(one, conditions={"pressure": pressure}, units={"pressure": "Pa"})

    return reduced(climate.supplied(1, visits=QUICK), Plan(to=["pressure"], unit="deg/s"), pressed).remarks


def test_a_condition_that_another_one_follows_is_refused_by_name() -> None:
    """Self-heating: the thermometer rises with the supply, so that nothing tells the two apart."""

    def heated(one: ConditionRecording) -> ConditionRecording:
        warm = {axis: 20.0 + 40.0 * (one.conditions["supply"][axis] - 5.0) for axis in one.conditions["supply"]}
        return replace(one, conditions={**one.conditions, "temperature": warm})

    result = reduced(climate.supplied(1, visits=replace(QUICK, temperatures=(20.0,))), spoil=heated)
    found = row(result, "bias_supply x")
    assert found.reason.code == "conditions_together"
    assert "temperature" in found.reason.text
    assert result.estimate is None


def test_glitches_of_a_condition_hide_no_level() -> None:
    """Two samples of a supply at 0 V: the range that tells levels apart is not theirs."""

    def dropped(one: ConditionRecording) -> ConditionRecording:
        volts = one.conditions["supply"]["x"].copy()
        volts[[40, 140]] = 0.0
        return replace(one, conditions={**one.conditions, "supply": dict.fromkeys("xy", volts)})

    case = climate.supplied(1, visits=QUICK)
    clean, result = reduced(case), reduced(case, spoil=dropped)
    assert [one.count for one in result.remarks if one.code == "glitches"] == [2] * 3
    assert "glitches" not in codes(clean)
    found, sure = row(result, "bias_supply x"), row(clean, "bias_supply x")
    assert found.value == pytest.approx(sure.value, abs=sure.u)
    assert found.u == pytest.approx(sure.u, rel=1.0)


def test_a_power_up_in_another_unit_is_named() -> None:
    """Torr that is said to be pascals: in one power-up beside the others, and in all by the pressure of the air."""

    def torr(one: ConditionRecording) -> ConditionRecording:
        pressure = {axis: values / 133.322 for axis, values in one.conditions["supply"].items()}
        return replace(one, conditions={**one.conditions, "supply": pressure})

    def one_torr(one: ConditionRecording) -> ConditionRecording:
        return torr(one) if one.name == "run2.csv" else one

    case = climate.supplied(1, visits=replace(QUICK, volts=(90.0, 120.0, 90.0)))
    named = [one.subject for one in reduced(case, spoil=one_torr).remarks if one.code == "unit_differs"]
    assert named == ["supply run2.csv"]
    assert "unit_differs" not in codes(reduced(case))
    air = remarks_in_air(101_325.0 / 133.322)
    assert [one.subject for one in air if one.code == "unit_differs"] == ["pressure"]
    assert not [one for one in remarks_in_air(101_325.0) if one.code == "unit_differs"]


def test_what_is_missing_is_said_by_its_power_up() -> None:
    def cold(one: ConditionRecording) -> ConditionRecording:
        kept = {name: values for name, values in one.conditions.items() if name != "temperature"}
        return replace(one, conditions=kept) if one.name == "run2.csv" else one

    found = row(reduced(climate.supplied(1, visits=QUICK), spoil=cold), "bias_supply_temperature x")
    assert found.reason.text == "no temperature was recorded in power-up run2.csv"


def test_noise_that_hides_the_steps_is_said() -> None:
    case = climate.supplied(1, unit=Unit(meter=0.3), visits=QUICK)
    assert "as far as its noise of 0.3" in row(reduced(case), "bias_supply x").reason.text


def test_a_supply_that_follows_the_temperature_is_refused() -> None:
    result = reduced(climate.supplied(1, visits=replace(QUICK, coupled=True)))
    assert {row(result, f"{name} {axis}").status for name in NAMES for axis in "xy"} == {"not_estimated"}
    assert row(result, "bias_supply x").reason.code == "conditions_together"


def test_a_square_of_the_temperature_that_a_product_with_the_supply_follows_is_refused() -> None:
    """The supply follows the temperature, so that their product is its square: its coefficient is of both."""
    case = climate.supplied(1, visits=replace(QUICK, coupled=True))
    result = reduced(case, replace(SUPPLY, to=["supply", "temperature"]))
    refused = {one.quantity: one.reason.code for one in result.rows() if one.axis == "x" and one.reason}
    assert refused["bias_temperature_1"] == refused["bias_temperature_2"] == "conditions_together"
    linear = reduced(case, replace(SUPPLY, to=["supply", "temperature"], interactions=False))
    assert row(linear, "bias_temperature_2 x").status == "estimated"


def test_a_power_up_without_the_condition_is_told_and_does_not_count() -> None:
    def lacking(one: ConditionRecording) -> ConditionRecording:
        return one if one.run or one.name != "run_1" else with_supply(one, lambda volts: volts * np.nan)

    case = climate.supplied(1, visits=replace(QUICK, runs=2))
    result = reduced(case, spoil=lambda one: lacking(replace(one, name="run_1") if one.name == next(iter(case.tables))
                                                     else one))  # fmt: skip
    told = {one.code: one.what for one in result.remarks}
    assert told["missing_condition"] == "power-up run_1 has no supply: its levels do not count"
    assert told["few_runs"].startswith("one power-up")
    assert terms(result, ()) is None, "one power-up tells no scatter between power-ups"


def test_conditions_that_mostly_move_together_are_told() -> None:
    def heated(one: ConditionRecording) -> ConditionRecording:
        volts = one.conditions["supply"]["x"]
        wave = 1.5 * np.sin(np.arange(len(volts)) / 15.0)
        warm = dict.fromkeys("xy", 20.0 + 40.0 * (volts - 5.0) + wave)
        return replace(one, conditions={**one.conditions, "temperature": warm})

    result = reduced(climate.supplied(1, visits=replace(QUICK, temperatures=(20.0,), dwell=400.0)), spoil=heated)
    assert row(result, "bias_supply x").status != "not_estimated"
    assert "conditions_together" in codes(result)


def test_a_stuck_channel_tells_nothing() -> None:
    result = reduced(climate.supplied(1, visits=QUICK), spoil=lambda one: with_supply(one, lambda v: 0.0 * v + 5.0))
    assert row(result, "bias_supply x").reason.code == "not_varied"
    assert "not_varied" in codes(result)


def test_a_supply_that_was_never_stepped_tells_nothing() -> None:
    result = reduced(climate.supplied(1, visits=replace(QUICK, volts=(5.0, 5.0, 5.0))))
    assert row(result, "bias_supply x").reason.code == "not_varied"


def test_a_coarse_channel_is_remarked_and_its_resolution_covers_it() -> None:
    """Codes of 50 mV, 13 mV off their middle: the levels keep a slope, the resolution is Type B."""
    step = 0.05
    influence = Influence(step / np.sqrt(12.0), "V", standard="supply_meter", quantity="resolution")
    case = climate.supplied(1, visits=replace(QUICK, runs=5))

    def coarse(one: ConditionRecording) -> ConditionRecording:
        return with_supply(one, lambda values: step * np.round((values + 0.013) / step))

    assert "set_values" in codes(reduced(case, spoil=coarse))
    plan = replace(SUPPLY, standards={"supply_meter.resolution": influence})
    result = reduced(case, plan, coarse)
    assert "set_values" not in codes(result)
    assert all(hits(case, result).values())


@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_a_wrong_unit_of_the_supply_is_refused(factor: float) -> None:
    with pytest.raises(DataError, match="supply: levels about") as refused:
        reduced(climate.supplied(1, visits=QUICK), spoil=lambda one: with_supply(one, lambda v: factor * v))
    assert refused.value.problems[0].code == "impossible_value"


def test_a_reference_says_that_a_unit_is_wrong() -> None:
    with pytest.raises(DataError, match="is its reference"):
        reduced(climate.supplied(1, visits=QUICK), replace(SUPPLY, references={"supply": "5 mV"}))


def test_a_settle_longer_than_every_level_is_refused() -> None:
    """The first level of a power-up follows no change: alone it tells nothing."""
    with pytest.raises(DataError, match="no level after a change is longer than settle") as refused:
        reduced(climate.supplied(1, visits=QUICK), replace(SUPPLY, settle=1e5))
    assert refused.value.problems[0].code == "nothing_left"


def test_readings_that_follow_a_step_late_are_told_and_settle_mends_it() -> None:
    case = climate.supplied(1, visits=replace(QUICK, dwell=400.0))
    late = reduced(case, spoil=with_transient)
    assert {"not_settled", "path_dependent"} & codes(late)
    mended = reduced(case, replace(SUPPLY, settle=250.0), with_transient)
    assert not {"not_settled", "path_dependent"} & codes(mended)
    assert hits(case, mended)["bias_supply x"]


def test_levels_in_one_order_under_a_warm_up_are_told_and_a_drift_helps() -> None:
    warming = Unit(warm_up=((0.02, 0.0, 3000.0),))
    visits = Visits(runs=3, volts=(4.85, 5.0, 5.15), temperatures=(20.0,), dwell=200.0)
    result = reduced(climate.supplied(1, warming, visits))
    assert "one_order" in codes(result)
    both_ways = replace(visits, volts=(4.85, 5.0, 5.15, 5.0, 4.85, 5.0, 5.15, 5.0, 4.85))
    case = climate.supplied(1, warming, both_ways)
    plain, fitted = (abs(_error(reduced(case, replace(SUPPLY, drift=drift)))) for drift in (0, 2))
    assert fitted < plain or fitted < np.radians(3e-4)


def _error(result: object) -> float:
    found = row(result, "bias_supply x").value  # type: ignore[arg-type]
    assert found is not None
    return found - float(np.radians(Unit().supply))


def test_a_curved_response_is_told() -> None:
    assert "curved" in codes(reduced(climate.supplied(1, Unit(bend=0.2), QUICK)))


def test_sound_records_bring_no_warning() -> None:
    found = [one for seed in range(1, 6) for one in reduced(climate.supplied(seed, visits=QUICK)).remarks]
    assert {one.code for one in found} <= {"few_runs"}


def test_one_power_up_is_told_and_gives_no_term_of_the_model() -> None:
    result = reduced(climate.supplied(1, visits=replace(QUICK, runs=1)))
    assert row(result, "bias_supply x").reason.code == "few_runs"
    assert [one.severity for one in result.remarks if one.code == "few_runs"] == ["warning"]


def test_a_settle_without_time_is_refused() -> None:
    found = [replace(one, recording=replace(one.recording, time_ns=None, sample_interval=None))
             for one in recordings_of(climate.supplied(1, visits=QUICK))]  # fmt: skip
    with pytest.raises(DataError, match="settle without a time axis"):
        readings_from(replace(SUPPLY, settle=60.0), found, "rad/s")


def test_a_settle_longer_than_all_levels_leaves_nothing() -> None:
    found = recordings_of(climate.supplied(1, visits=replace(QUICK, temperatures=(20.0,))))
    levels = readings_from(replace(SUPPLY, settle=0.0), found, "rad/s")
    fewer = readings_from(replace(SUPPLY, settle=190.0), found, "rad/s")
    assert len(fewer) < len(levels)


def test_too_few_levels_are_refused() -> None:
    visits = Visits(runs=1, volts=(5.0, 4.85, 5.15), temperatures=(20.0,), dwell=100.0)
    with pytest.raises(DataError, match="3 levels of 1 power-ups for 2 terms") as refused:
        reduced(climate.supplied(1, visits=visits), replace(SUPPLY, drift=1))
    assert refused.value.problems[0].code == "too_few_levels"
