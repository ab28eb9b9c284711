"""Several runs of a planned test: the phases of their schedules, and the forecast with a drift that repeats."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from inertialcal.procedures.mass_attraction.plan import Plan
from inertialcal.procedures.mass_attraction.planning.planner import MassPlan
from inertialcal.procedures.mass_attraction.planning.runs import phases, started
from inertialcal.procedures.mass_attraction.readings import Readings, Run
from inertialcal.procedures.mass_attraction.reduction import reduce
from inertialcal.procedures.mass_attraction.schedule_csv import read_schedule
from typed_commands import call

UG = 9.80665e-6
WAVE = {"size": "20 ug", "period": "10 min"}
NOISE = 55e-9 * 9.80665 / np.sqrt(100.0)  # of a mean over a dwell [m/s^2]


def planned(starts: str, runs: int = 4, drift: dict[str, str] | None = None) -> MassPlan:
    groups: dict[str, Any] = {"drift": drift} if drift else {}
    return ic.plan_mass_attraction(
        body={"cube": "20 cm", "count": 18, "stand_off": "10 cm"},
        timing={"length": "4 h", "runs": runs, "starts": starts},
        motion={"rig": ["0 cm", "60 cm"], "stroke": ["0 cm", "50 cm"]},
        noise={"velocity_random_walk": "55 ng/sqrt(Hz)"}, **groups,
    )  # fmt: skip


def figure(plan: MassPlan, quantity: str, case: str) -> float:
    (row,) = [row for row in plan.rows if (row.quantity, str(row.case)) == (quantity, f"sine, four runs, {case}")]
    assert row.value is not None
    return row.value / 100.0


def simulated(plan: MassPlan, n: int, **thermostat: float) -> tuple[np.ndarray, np.ndarray]:
    """Return errors of the scale factor, relative, and their stated u, of runs as planned, with a sine as drift."""
    off, u = [], []
    for seed in range(n):
        rng, runs = np.random.default_rng(seed), []
        phase = rng.uniform(0.0, 2.0 * np.pi)
        for k, ahead in enumerate(plan.starts):
            one = plan.schedules[ahead]
            wave = 0.5 * thermostat["size"] * np.sin(2.0 * np.pi * one.middle / thermostat["period"] + phase)
            runs.append(Run(str(k), one, one.applied + wave + NOISE * rng.standard_normal(len(one))))
        estimate = reduce(Plan(tilt="ignored"), Readings(tuple(runs))).estimate
        assert estimate is not None
        off.append(float(estimate.values[0]) - 1.0)
        u.append(float(estimate.u[0]))
    return np.array(off), np.array(u)


def test_each_start_is_the_same_cycle_from_another_dwell_on() -> None:
    plan = planned("quarters")
    assert plan.starts == (0, 90, 180, 270)
    first = plan.schedules[0].applied
    for k, (ahead, one) in enumerate(plan.schedules.items()):
        assert ahead == 90 * k
        np.testing.assert_array_equal(one.applied, np.roll(first, -k))
        np.testing.assert_array_equal(one.start, plan.schedules[0].start)
    assert phases("alternating", 5) == (0, 180, 0, 180, 0)
    assert len(planned("alike").schedules) == 1


def test_a_drift_near_the_drive_is_forecast_as_simulations_have_it() -> None:
    drift = {"size": "1 ug", "period": "12 min"}  # six dwells
    plan = planned("alternating", drift=drift)
    alike, alternating = (figure(plan, "scale_factor_uncertainty", one) for one in ("alike", "alternating"))
    error = figure(plan, "repeating_drift_error", "alike")
    assert figure(plan, "repeating_drift_error", "alternating") == 0.0
    assert alike == pytest.approx(np.hypot(error, alternating), rel=1e-6)
    found, u = simulated(plan, 25, size=UG, period=720.0)
    assert np.std(found) == pytest.approx(alternating, rel=0.5)
    assert np.median(u) == pytest.approx(alternating, rel=0.25)
    same, _ = simulated(planned("alike", drift=drift), 25, size=UG, period=720.0)
    assert np.sqrt(np.mean(same**2)) == pytest.approx(alike, rel=0.35)


def test_runs_of_noise_alone_are_forecast_by_their_number() -> None:
    plan = planned("alike")
    (one,) = [row.value for row in plan.rows if str(row.case) == "sine, after 4 h"]
    u_applied = plan.schedule.u_applied if plan.schedule else None
    assert one is not None
    assert u_applied is not None
    together = figure(plan, "scale_factor_uncertainty", "alike")
    noise = np.sqrt((one / 100.0) ** 2 - u_applied**2)
    assert together == pytest.approx(np.hypot(noise / 2.0, u_applied), rel=1e-6)
    assert figure(plan, "scale_factor_uncertainty", "alternating") == pytest.approx(together, rel=1e-6)


def test_a_drift_larger_than_the_noise_is_remarked_with_what_cures_it() -> None:
    (said,) = [one for one in planned("alike", drift=WAVE).remarks if one.code == "repeating_drift"]
    assert 'timing.starts = "alternating"' in said.do
    assert not [one for one in planned("alternating", drift=WAVE).remarks
                if one.code == "repeating_drift"]  # fmt: skip


@pytest.mark.parametrize(
    ("runs", "starts", "drift", "words"),
    [
        (1, "alternating", {}, "needs 2 runs"), (3, "quarters", {}, "needs 4 runs"),
        (1, "alike", {"size": "1 ug"}, "time or period"),
        (1, "alike", {"size": "1 ug", "time": "1 h", "period": "1 h"}, "time or period"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(runs: int, starts: str, drift: dict[str, str], words: str) -> None:
    with pytest.raises(InertialcalError, match=words):
        planned(starts, runs, drift)


def test_schedules_are_written_read_and_taken_by_the_files_one_after_the_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sets = ["body.cube=20 cm", "body.count=18", "body.stand_off=10 cm", "motion.stroke=0 cm, 50 cm",
            "timing.length=4 h", "timing.runs=2", "timing.starts=alternating"]  # fmt: skip
    words = [word for one in sets for word in ("--set", one)]
    code, text, _ = call(capsys, "plan", "mass-attraction", *words, "--schedule", str(tmp_path / "s.csv"))
    assert code == 0
    assert "s_180.csv (120 dwells, run 2)" in text
    rng, files, paths = np.random.default_rng(1), [tmp_path / "s.csv", tmp_path / "s_180.csv"], []
    for k, file in enumerate(files):
        one = read_schedule(file)
        np.testing.assert_array_equal(one.applied, started(read_schedule(files[0]), 180 * k).applied)
        pulses = np.rint(1e4 + 100.0 * (one.applied / UG * 10.0 + 0.05 * rng.standard_normal(len(one)))).astype(int)
        paths.append(tmp_path / f"run{k}.csv")
        rows = [f"{t:.1f},{p}" for t, p in zip(1e9 + one.start + 50.0, pulses, strict=True)]
        paths[-1].write_text("\n".join(["unix_s,pulses [count]", *rows, ""]))
    found = ic.mass_attraction(paths, schedule=[str(file) for file in files], gate="100 s", averaging="100 s")
    assert found.rows[0].value == pytest.approx(10.0, rel=0.05)
    assert np.abs(found.result.joined.phases) == pytest.approx([0.0, np.pi])
    with pytest.raises(InertialcalError, match="one after the other"):
        ic.mass_attraction(paths[0], schedule=[str(file) for file in files], gate="100 s")
