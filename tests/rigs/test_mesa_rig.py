"""The moved-mass rig: what it counts is what the truth says, and each mistake is named by the reduction."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fitted_results import fit_results
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.score import coverage
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.show.rows import case_name
from inertialcal.physics.motion.schedule import Schedule
from inertialcal.procedures.mass_attraction.reduction import Result
from inertialcal.rigs.mesa import rig as mesa
from inertialcal.rigs.mesa.record import nominal
from inertialcal.rigs.mesa.rig import Bench, Run, build
from inertialcal.rigs.mesa.setup import GATE, UG
from inertialcal.rigs.twin import Twin
from inertialcal.statistics.intervals import contains, covers, t_interval
from sized import sized

QUIET = Bench(
    runs=(Run("run1"), Run("null1", moved=False)), white=0.0, flicker=0.0, walk=0.0, cubic=0.0, thermostat=0.0,
    pad_tilt=0.0, pad_noise=0.0, meter_noise=0.0, stop_scatter=0.0, lost=0.0,
)  # fmt: skip
TABLE_3 = 23.0  # ng: amplitude of the published mass
PUBLISHED = 1e-3  # its rows are in hundredths of a cm


def schedule(twin: Twin) -> Schedule:
    content = twin.extras["schedule.csv"].content
    assert isinstance(content, Schedule)
    return content


def found(twin: Twin) -> set[str]:
    """Codes of the remarks and reasons, or of the refusal."""
    try:
        (result,) = fit_results(twin)
    except DataError as error:
        return {problem.code for problem in error.problems}
    return {one.code for one in result.remarks} | {row.reason.code for row in result.rows()}


@pytest.mark.parametrize("fault", mesa.FAULTS)
def test_every_mistake_is_named(fault: str) -> None:
    assert mesa.FAULTS[fault].shows in found(mesa.RIG.twin(3, fault))


def test_without_a_mistake_nothing_is_wrong() -> None:
    assert not found(mesa.RIG.twin(3)) & {fault.shows for fault in mesa.FAULTS.values()}


def test_a_mistake_that_is_not_known_is_refused() -> None:
    with pytest.raises(UsageError, match=r"no fault 'rain'.*There are: slipped"):
        mesa.RIG.twin(1, "rain")


def test_pulses_are_whole_and_follow_the_mass_by_the_true_scale_factor() -> None:
    twin = build(QUIET, 2)
    pulses = twin.recordings["recordings/run1.csv"].channel("pulses").data
    assert pulses.dtype == np.int64
    plan = schedule(twin)
    slope = np.polyfit(plan.applied, pulses / GATE, 1)[0]
    applied = 1.0 + float(np.asarray(twin.drawn["applied_error"]))
    assert slope == pytest.approx(twin.truth[0].value * applied, rel=5e-3)  # counts of 0.01 pulses/s
    rest = twin.recordings["recordings/null1.csv"].channel("pulses").data
    assert np.ptp(rest) <= 1
    assert np.mean(rest) / GATE == pytest.approx(17.0 * UG * twin.truth[0].value, rel=1e-4)


def test_the_mass_applies_what_the_report_says() -> None:
    twin = build(QUIET, 1)
    amplitude = 0.5 * float(np.ptp(schedule(twin).applied)) / (1e-3 * UG)
    assert amplitude == pytest.approx(TABLE_3, rel=PUBLISHED)


def test_both_ranges_and_both_drives_are_there() -> None:
    high, abab = (build(replace(QUIET, **change), 2) for change in ({"range": "high"}, {"drive": "ABAB"}))  # type: ignore[arg-type]
    assert nominal(replace(QUIET, range="high")) == pytest.approx(1.024 / UG)
    assert high.truth[0].value == pytest.approx(1.024 / UG, rel=0.05)
    assert schedule(abab).samples_per_cycle == 2
    assert "1.024 count/s/ug" in high.campaign


def test_work_hours_are_noisier_and_the_mercury_moves_with_the_mass_alone() -> None:
    bench = replace(Bench(), runs=(Run("run1"), Run("run2", work=True), Run("null1", moved=False)), cubic=0.0,
                    thermostat=0.0, flicker=0.0, walk=0.0, lost=0.0, pad_tilt=0.0)  # fmt: skip
    spread: dict[str, float] = {}
    for seed in range(1, 6):
        twin = build(bench, seed)
        for name in ("run1", "run2"):
            pulses = twin.recordings[f"recordings/{name}.csv"].channel("pulses").data / GATE
            left = np.asarray(pulses).reshape(-1, 4)
            spread[name] = spread.get(name, 0.0) + float(np.var(left - left.mean(axis=0)))
    assert np.sqrt(spread["run2"] / spread["run1"]) == pytest.approx(2.07, rel=0.25)


def test_the_same_seed_gives_the_same_record() -> None:
    one, other = (mesa.RIG.twin(5).recordings["recordings/run2.csv"].channel("pulses").data for _ in range(2))
    assert np.array_equal(one, other)
    assert not np.array_equal(one, mesa.RIG.twin(6).recordings["recordings/run2.csv"].channel("pulses").data)


def test_files_give_the_figures_of_what_is_in_memory(tmp_path: Path) -> None:
    folder = simulate("mesa", tmp_path / "mesa", 4).folder
    (result,) = fit_results(mesa.RIG.twin(4))
    assert isinstance(result, Result)
    (own,) = [row for row in result.rows() if (row.quantity, str(row.case)) == ("scale_factor", "")]
    (shown,) = [
        row for row in run(folder, write=False).results["results"]
        if (row["quantity"], case_name(row)) == ("scale_factor", "")
    ]  # fmt: skip
    assert shown["unit"] == "count/s/ug"
    assert shown["value"] == pytest.approx((own.value or 0.0) * UG, rel=1e-9)
    assert shown["u"] == pytest.approx((own.u or 0.0) * UG, rel=1e-9)


def test_the_interval_holds_the_truth_in_a_few_campaigns() -> None:
    (scale,) = coverage(mesa.RIG.twin, 8)
    assert covers(scale.hits, scale.n)
    assert scale.missing == 0


@pytest.mark.slow
def test_the_interval_holds_the_truth_without_bias_and_null_runs_are_zero() -> None:
    n, held, alarms, errors = sized(1000, 60), 0, 0, []
    for seed in range(1, n + 1):
        twin = mesa.RIG.twin(seed)
        (result,) = fit_results(twin)
        assert isinstance(result, Result)
        assert result.estimate is not None
        value, u, dof = (float(x[0]) for x in (result.estimate.values, result.estimate.u, result.estimate.dof))
        truth = twin.truth[0].value
        held += contains(t_interval(value, u, dof), truth)
        alarms += any(one.code == "null_run_not_zero" for one in result.remarks)
        errors.append(value / truth - 1.0)
    assert covers(held, n), held
    assert covers(n - alarms, n), alarms
    assert abs(np.mean(errors)) < 0.005
    assert abs(np.mean(errors)) < 4.0 * np.std(errors) / np.sqrt(n)
