"""A thermal campaign from raw counts to results: chain, mounting, references, requirements, bad input, score."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine.engine import plan_of
from inertialcal.campaign.engine.run import Outcome, run
from inertialcal.campaign.engine.whole import check
from inertialcal.campaign.file.schema import CampaignFile
from inertialcal.campaign.file.sensors import Sensor
from inertialcal.campaign.inputs.sources import facts_of
from inertialcal.campaign.twins.fitted import fitted_tests
from inertialcal.campaign.twins.score import coverage, score
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import DataError, InertialcalError, PlanError
from inertialcal.core.show.rows import case_name, quantity_name
from inertialcal.procedures import procedure_of
from inertialcal.procedures.thermal import reduction as thermal
from inertialcal.rigs import RIGS
from inertialcal.rigs.npsat1 import rig as npsat1
from inertialcal.rigs.npsat1.setup import AIR, VACUUM, Bench, Chamber
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.twin import SEED, Twin

pytestmark = pytest.mark.usefixtures("undrawn")

SHORT = {
    AIR: Chamber(900.0, 300.0, 200.0, (760.0, 760.0)),
    VACUUM: Chamber(9000.0, 300.0, 200.0, (1e-5, 1e-6)),
}
BENCH = Bench(parts=("thermal",), chambers=SHORT, ramps=(6.0, 3.0), chamber_runs=5, chamber_fit_runs=5)
AXES = ("x", "y", "z")


def small(seed: int, **change: Any) -> Twin:
    return npsat1.build(replace(BENCH, **change), seed)


def file_of(twin: Twin) -> CampaignFile:
    return CampaignFile.model_validate(tomllib.loads(twin.campaign.replace(SEED, "0")))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(RIGS, "small", Rig("small", "", lambda seed, changes: small(seed)))
        yield simulate("small", tmp_path_factory.mktemp("thermal") / "campaign", 3).folder


@pytest.fixture(scope="module")
def outcome(folder: Path) -> Outcome:
    return run(folder)


def rows_of(outcome: Outcome, **want: str) -> list[dict[str, Any]]:
    return [row for row in outcome.results["results"] if all(row[key] == value for key, value in want.items())]


def test_files_and_memory_give_the_same_figures(outcome: Outcome) -> None:
    memory = {one.test.id: one for one in fitted_tests(small(3))}
    compared = 0
    for row in (row for row in outcome.results["results"] if row["test"] in memory):
        one = memory[row["test"]]
        assert one.rows is not None
        key = (row["quantity"], row["axis"])
        alike = [r for r in one.rows if (r.quantity, r.axis) == key and str(r.case) in (case_name(row), "")
                 and (str(r.case) or case_name(row) in ("air", "vacuum"))]  # fmt: skip
        if row["quantity"] == "bias" and row["status"] == "estimated" and alike:
            assert row["value"] == pytest.approx(np.degrees(alike[0].value or 0.0), rel=1e-12)
            compared += 1
    assert compared == 2 * 3 * 5


def test_figures_stand_in_the_units_of_the_sensor(outcome: Outcome) -> None:
    units = {quantity_name(row): row["unit"] for row in rows_of(outcome, axis="x", test="thermal_ambient")
             if case_name(row) != "as_published"}  # fmt: skip
    assert units["bias"] == "deg/s"
    assert units["bias_temperature_1"] == "deg/s/degC"
    assert units["bias_temperature_2"] == "deg/s/degC^2"
    assert units["bias_voltage_0"] == "V"
    assert units["path_difference"] == "deg/s"
    assert units["warm_up_time"] == "s"
    assert not [row for row in outcome.results["results"] if row["reason"] and "rad/s" in row["reason"]["text"]]


def test_the_vacuum_test_has_its_offset_from_air(outcome: Outcome) -> None:
    for axis in AXES:
        found = rows_of(outcome, quantity="vacuum_offset", axis=axis)
        assert {case_name(row) for row in found} == {"vacuum", "-20 degC", "0 degC", "20 degC", "60 degC"}
        assert all(row["test"] == "thermal_vacuum" for row in found)
    assert len(rows_of(outcome, quantity="vacuum_offset_run_to_run")) == 3


def test_reference_voltages_are_results(outcome: Outcome) -> None:
    for name in ("reference_voltage", "temperature_reference_voltage"):
        found = rows_of(outcome, quantity=name, test="thermal_ambient")
        assert [row["axis"] for row in found] == list(AXES)
        assert all(row["value"] == pytest.approx(2.5, abs=0.1) for row in found)


def test_the_sequence_the_standards_and_the_exclusions_tell_of_it(outcome: Outcome) -> None:
    results = outcome.results
    assert [step["against"] for step in results["sequence"]] == [None, "thermal_ambient"]
    assert {step["runs"] for step in results["sequence"]} == {5}
    stated = {f"{one['standard']}.{one['influence']}" for one in results["standards"]}
    assert {"thermometer.temperature", "converter.reference", "site.latitude"} <= stated
    rules = {(one["test"], one["axis"], one["rule"]) for one in results["exclusions"]}
    assert {("thermal_ambient", axis, rule) for axis in AXES for rule in ("warm_up", "turn_over")} <= rules


def test_budgets_add_up_to_the_figures(outcome: Outcome) -> None:
    sums: dict[tuple[str, str, str, int], float] = {}
    for one in outcome.results["budgets"]:
        key = (one["test"], one["quantity"], one["axis"], one["power"])
        sums[key] = sums.get(key, 0.0) + one["u"] ** 2
    for key, total in sums.items():
        (row,) = [r for r in rows_of(outcome, test=key[0], quantity=key[1], axis=key[2])
                  if case_name(r) in ("air", "vacuum") and r["power"] == key[3]]  # fmt: skip
        assert np.sqrt(total) == pytest.approx(row["u"], rel=1e-9), key


def test_the_requirement_over_temperature_is_judged_at_temperatures(outcome: Outcome) -> None:
    verdicts = outcome.results["verdicts"]
    assert {one["at_unit"] for one in verdicts} == {"degC"}
    assert {one["test"] for one in verdicts} == {"thermal_ambient"}
    assert len(verdicts) == 3 * 13
    assert outcome.verdict == "PASS"


def test_truth_deleted_gives_the_same_bytes(folder: Path, outcome: Outcome, tmp_path: Path) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy)
    shutil.rmtree(copy / ".truth")
    run(copy)
    for name in ("results.json", "results.csv", "verdicts.csv"):
        assert (copy / "out" / name).read_bytes() == (folder / "out" / name).read_bytes(), name


def test_the_score_knows_tests_and_conditions(folder: Path, outcome: Outcome) -> None:
    found = score(folder)
    keys = {(row["quantity"], row["axis"], row["test"], case_name(row)) for row in found.rows}
    assert ("bias", "x", "thermal_ambient", "-20 degC") in keys
    assert ("bias", "x", "thermal_vacuum", "vacuum") in keys
    assert ("vacuum_offset", "z", "thermal_vacuum", "60 degC") in keys
    values = {(row["test"], case_name(row)): row["truth"] for row in found.rows
              if (row["quantity"], row["axis"]) == ("bias", "x")}  # fmt: skip
    assert len(set(values.values())) == 8  # air and vacuum; the reference temperature is one of the four
    assert found.inside > 0.85 * found.estimated


def test_coverage_in_memory_counts_each_test_and_condition() -> None:
    found = {(one.key.quantity, one.key.axis, one.test, str(one.key.at or "")): one for one in coverage(small, 2)}
    assert found["bias", "x", "thermal_ambient", "-20 degC"].n == 2
    assert found["vacuum_offset", "y", "thermal_vacuum", ""].n == 2


# Set-up


def planned(file: CampaignFile, sensor: Sensor) -> thermal.Plan:
    plan = plan_of(procedure_of("thermal"), file.tests[0].plan, facts_of(sensor, {}, file.site))
    assert isinstance(plan, thermal.Plan)
    return plan


def test_the_plan_has_what_sensor_and_site_say() -> None:
    file = file_of(small(1))
    plan = planned(file, file.sensors["suite"])
    assert plan.at == [-20.0, 0.0, 20.0, 60.0]
    assert plan.latitude == pytest.approx(np.radians(36.6))
    assert plan.attitude is not None
    assert plan.thermometers is not None
    assert plan.thermometers["y"] == thermal.Thermometer(0.0264, -0.4909, 25.4)


def test_thermometers_and_references_follow_a_mounting_that_exchanges_axes() -> None:
    file = file_of(small(1))
    exchanged = file.sensors["suite"].model_copy(update={"mounting": [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]})
    straight, turned = (planned(file, one).thermometers for one in (file.sensors["suite"], exchanged))
    assert straight is not None
    assert turned == {"x": straight["y"], "y": straight["x"], "z": straight["z"]}
    assert turned["x"].temperature == 25.4  # that of the y sensor


def test_a_mounting_that_mixes_sensors_has_no_thermometer_of_an_axis() -> None:
    c = float(np.sqrt(0.5))
    file = file_of(small(1))
    mixed = file.sensors["suite"].model_copy(update={"mounting": [[c, c, 0], [-c, c, 0], [0, 0, 1]]})
    assert facts_of(mixed, {}).thermometers is None


# Bad input


def edited(folder: Path, tmp_path: Path, *pairs: tuple[str, str]) -> Path:
    copy = tmp_path / "campaign"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("out"))
    path = copy / "campaign.toml"
    text = path.read_text()
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new)
    path.write_text(text)
    return copy


@pytest.mark.parametrize(("change", "code"), [
    ({"set_points": (23.0, 23.0, 23.0, 23.0)}, "no_temperature_change"),
    ({"reference_saved": False}, "missing_reference"),
    ({"copied": True}, "duplicate_recording"),
])  # fmt: skip
def test_what_cannot_be_reduced_is_refused_by_name(change: dict[str, Any], code: str) -> None:
    with pytest.raises(DataError) as found:
        fitted_tests(small(1, **change))
    assert code in {problem.code for problem in found.value.problems}


def remarks_of(twin: Twin) -> set[str]:
    return {remark.code for one in fitted_tests(twin) for remark in one.result.remarks}


def test_only_cooling_gives_no_bias_midway() -> None:
    found = fitted_tests(small(1, set_points=(67.0, -30.0)))[0]
    assert found.rows is not None
    bias = next(row for row in found.rows if row.quantity == "bias" and row.case.plain)
    assert bias.status == "not_estimated"
    assert bias.reason.code == "one_path"
    assert "one_path" in {remark.code for remark in found.result.remarks}


def test_a_saturated_end_is_left_out_and_counted() -> None:
    twin = small(1, nominal_shift=-0.9)
    found = fitted_tests(twin)[0].result
    assert isinstance(found, thermal.Result)
    low = found.sensors["x"].law.domain[0]
    assert low > -29.0  # the converter ends before the ramp does
    assert found.sensors["x"].cells.left_out["invalid"] > 100
    assert "rail" in remarks_of(twin)


def test_one_recording_with_exchanged_axes_or_a_turned_sign_is_named() -> None:
    twin = small(1)
    file = file_of(twin).recordings["ambient_3"].file
    recording = twin.recordings[file]
    x, y = (recording.channel(name) for name in ("x", "y"))
    exchanged = {"x": replace(x, data=y.data), "y": replace(y, data=x.data)}
    turned = {"x": replace(x, data=2.0 * np.mean(x.data) - x.data)}
    for made, code in ((exchanged, "run_differs"), (turned, "sign_disagrees")):
        channels = tuple(made.get(channel.name, channel) for channel in recording.channels)
        recordings = {**twin.recordings, file: replace(recording, channels=channels)}
        found = fitted_tests(replace(twin, recordings=recordings))[0].result.remarks
        named = [remark for remark in found if remark.severity == "error"]
        assert {remark.code for remark in named} == {code}
        assert all("ambient_3" in remark.what and "ambient_3" in remark.where for remark in named)
    assert not {"run_differs", "sign_disagrees"} & set(remarks_of(twin))


def test_windows_that_overlap_are_refused(folder: Path, tmp_path: Path) -> None:
    window = (
        'windows = [["2010-04-01T00:00:00Z", "2010-06-01T00:00:00Z"], ["2010-05-01T00:00:00Z", "2010-07-01T00:00:00Z"]]'
    )
    copy = edited(folder, tmp_path, ('id = "thermal_ambient"\n', f'id = "thermal_ambient"\n{window}\n'))
    with pytest.raises(PlanError, match="two windows overlap"):
        check(copy)


def test_a_fit_and_a_hold_out_on_the_same_recordings_are_refused(folder: Path, tmp_path: Path) -> None:
    again = '[[tests]]\nid = "again"\nprocedure = "thermal"\nuse = "hold_out"\nrecordings = ["ambient_1"]\n'
    copy = edited(folder, tmp_path)
    path = copy / "campaign.toml"
    path.write_text(f"{path.read_text()}\n{again}")
    with pytest.raises(PlanError, match="use the same readings") as found:
        check(copy)
    assert found.value.problems[0].code == "overlap"


def test_a_requirement_wider_than_the_ramps_is_inconclusive(folder: Path, tmp_path: Path) -> None:
    copy = edited(folder, tmp_path, ("temperature >= -20 degC", "temperature >= -60 degC"))
    found = run(copy, write=False)
    assert found.exit_status == 4
    outside = [one for one in found.results["verdicts"] if one["at"] < -31.0]
    assert outside
    assert all("outside the range of the ramps" in one["reason"] for one in outside)


@pytest.mark.parametrize(("old", "new", "what"), [
    ('where = "temperature >=', 'where = "rate >=', "rate"),
    ('at = ["-20 degC"', 'at = ["-20 deg/s"', "plan.at"),
    ('against = "thermal_ambient"', 'against = "thermal"', "no other thermal test"),
    ('procedure = "thermal"\nuse = "fit"\nrecordings = ["ambient_1", "ambient_2"',
     'procedure = "thermal"\nuse = "fit"\nrecordings = ["ambient_1", "ambient_1"', "appears twice"),
    ('reference_temperature = "20 degC"', "turn_over = 3", "turn_over"),
    ('"pressure_torr", unit = "Torr"', '"pressure_torr", unit = "deg/s"', "pressure"),
])  # fmt: skip
def test_a_wrong_setting_is_named(folder: Path, tmp_path: Path, old: str, new: str, what: str) -> None:
    copy = edited(folder, tmp_path, (old, new))
    with pytest.raises(InertialcalError) as found:
        check(copy)
    assert any(what in problem.what for problem in found.value.problems), str(found.value)
