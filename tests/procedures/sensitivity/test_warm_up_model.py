"""Joint warm-up of several power-ups: closed forms, truth found again, intervals that hold it, and what breaks it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from independent.warm.warm_up import Chamber, power_ups, starts
from inertialcal.core.errors import DataError
from inertialcal.procedures.sensitivity.warm_up import warm_up_curves, warm_up_loops, warm_up_rows
from inertialcal.procedures.sensitivity.warm_up_model import PowerUps, WarmUpModel, stretches_of, warm_up_model
from inertialcal.statistics.intervals import contains, covers, t_interval
from sized import sized

SPREAD = starts(-20.0, 40.0, 6)
PLAIN = Chamber()
TWO = Chamber(((0.02, -0.01), (0.02, 0.01), (0.01, 0.015)), (60.0, 600.0), length=3600.0)
BY_START = Chamber(by_start=3e-4, starts=SPREAD)
NONE = Chamber(amplitudes=((0.0,),) * 3)
SELF_HEATED = replace(NONE, slope=2e-3, heating=3.0, heating_time=150.0)


def found_in(seed: int, truth: Chamber, *, thermometer: bool = True, **more: Any) -> WarmUpModel:
    t, y, run, T = power_ups(seed, truth)
    return warm_up_model(PowerUps(tuple("xyz"[: y.shape[1]]), "deg/s", t, y, run, T if thermometer else None, **more))


def codes(found: WarmUpModel) -> set[str]:
    return {one.code for one in found.remarks}


def true_values(truth: Chamber) -> dict[str, float]:
    at = float(np.mean(truth.starts)) - 20.0
    values = {f"warm_up_time_{j + 1}": tau for j, tau in enumerate(truth.times)}
    for axis, amplitudes in zip("xyz", truth.amplitudes, strict=True):
        for j, one in enumerate(amplitudes):
            values[f"bias_warm_up_{j + 1}_{axis}"] = one + (truth.by_start * at if j == 0 else 0.0)
        values[f"warm_up_start_temperature_1_{axis}"] = truth.by_start
    return values


def test_without_noise_the_truth_is_found() -> None:
    exact = {"noise": 0.0, "thermometer": 0.0}
    for truth in (replace(PLAIN, **exact), replace(TWO, **exact), replace(BY_START, **exact)):  # type: ignore[arg-type]
        found = found_in(1, truth)
        assert found.estimate is not None
        true = true_values(truth)
        for name, value in zip(found.estimate.names, found.estimate.values, strict=True):
            assert value == pytest.approx(true[name], rel=2e-3), name


def test_a_stretch_is_the_mean_of_its_samples() -> None:
    t = np.arange(0.0, 600.0)
    one = PowerUps(("x",), "deg/s", np.tile(t, 2), np.tile(2.0 * t, 2)[:, None], np.repeat([0, 1], 600))
    means = stretches_of(one)
    assert means.weight.sum() == 1200.0
    assert means.readings[:, 0] == pytest.approx(2.0 * means.time)
    assert np.all(means.width <= 0.05 * means.time + 1.0)


def test_power_ups_that_are_alike_have_the_scatter_of_their_own_fits() -> None:
    """Where designs are alike the sandwich is the variance of the amplitudes over their number, R - 1 dof."""
    truth = replace(PLAIN, amplitudes=((0.024,),), scatter=0.2, noise=1e-5, walk=0.0)
    found = found_in(3, truth)
    assert found.estimate is not None
    t, y, run, _ = power_ups(3, truth)
    shape = np.exp(-t / found.times[0])
    own = [np.polyfit(shape[run == r], y[run == r, 0], 1)[0] for r in range(5)]
    assert found.estimate.value("bias_warm_up_1_x") == pytest.approx(np.mean(own), rel=1e-3)
    assert found.estimate.u[1] == pytest.approx(np.std(own, ddof=1) / np.sqrt(5.0), rel=0.01)
    assert found.estimate.dof[1] == pytest.approx(4.0, rel=0.05)


def test_offset_and_unit_change_nothing() -> None:
    t, y, run, _ = power_ups(2, PLAIN)
    first, other = (warm_up_model(PowerUps(("x", "y", "z"), "deg/s", t, one, run)) for one in (y, -7.0 * y + 3.0))
    assert first.estimate is not None
    assert other.estimate is not None
    factor = np.array([1.0, -7.0, -7.0, -7.0])
    assert other.estimate.values == pytest.approx(first.estimate.values * factor, rel=1e-5)
    assert other.estimate.u == pytest.approx(first.estimate.u * np.abs(factor), rel=1e-3)


def test_power_ups_held_out_are_predicted() -> None:
    found = found_in(1, PLAIN)
    rows = {(row.quantity, row.axis): row for row in warm_up_rows(found)}
    with_model, without = rows["warm_up_residual", "x"].value, rows["warm_up_residual_without_model", "x"].value
    assert with_model is not None
    assert without is not None
    assert with_model < 0.003  # noise of the means
    # root mean square of a exp(-t / tau) over the first 300 s
    assert without == pytest.approx(0.024 * np.sqrt(150.0 / 600.0 * (1.0 - np.exp(-4.0))), rel=0.05)
    held_out = next(one for one in warm_up_curves(found) if one.name == "warm_up_held_out")
    assert list(held_out.columns["with_model"].values) == pytest.approx([with_model] * 5, rel=0.2)
    assert {curve.of for curve in warm_up_curves(found) if curve.name == "warm_up_joint"} == {"1", "2", "3", "4", "5"}
    assert [key.quantity for key in found.parameters] == ["warm_up_time"] + 3 * ["bias_warm_up"]


def test_one_exponential_where_there_is_one_and_two_where_there_are_two() -> None:
    assert len(found_in(1, PLAIN).times) == 1
    assert len(found_in(1, TWO).times) == 2


def test_the_amplitude_is_told_by_starting_temperature_where_power_ups_start_apart() -> None:
    """Whatever it looks like: a term that is told only where it looks large is too large where it is told."""
    for truth in (BY_START, replace(PLAIN, starts=SPREAD)):
        found = found_in(1, truth)
        assert found.slopes is not None
        assert codes(found) == {"warm_up_by_start"}
    for near in ((18.0, 20.0, 22.0, 24.0, 26.0), (0.0, 20.0, 40.0)):  # alike, or too few
        assert found_in(1, replace(PLAIN, starts=near)).slopes is None


def test_amplitudes_for_a_start_that_no_power_up_is_near_are_remarked() -> None:
    t, y, run, T = power_ups(1, BY_START)
    for place, severity in ((-25.0, "info"), (80.0, "warning")):
        found = warm_up_model(PowerUps(("x", "y", "z"), "deg/s", t, y, run, T), place)
        assert [one.severity for one in found.remarks if one.code == "warm_up_by_start"] == [severity]


def test_a_bias_that_bends_over_temperature_is_no_warm_up() -> None:
    """Without noise: what the law does to a unit that heats itself depends on where it starts."""
    bent = replace(BY_START, noise=0.0, thermometer=0.0, heating=5.0, slope=2e-4, bend=2e-5)
    found = found_in(1, bent)
    assert found.estimate is not None
    true = true_values(bent)
    for name, value in zip(found.estimate.names, found.estimate.values, strict=True):
        assert value == pytest.approx(true[name], rel=2e-3), name
    assert found.by_temperature[:2, 0] == pytest.approx([2e-4 - 40.0 * 2e-5, 2e-5], rel=1e-2)


def test_without_a_warm_up_there_is_an_upper_limit() -> None:
    found = found_in(1, NONE)
    assert found.reason.code == "no_transient"
    rows = [row for row in warm_up_rows(found) if row.quantity == "bias_warm_up_1"]
    assert {row.status for row in rows} == {"upper_limit"}
    assert all(row.value is not None and 0.0 < row.value < 0.005 for row in rows)


def test_self_heating_is_no_warm_up() -> None:
    """The temperature moves as the readings do: no amplitude; without a thermometer one that is not there."""
    found = found_in(1, SELF_HEATED)
    assert found.reason.code == "temperature_moves"
    assert found.estimate is None
    blind = found_in(1, SELF_HEATED, thermometer=False)
    assert blind.estimate is not None
    assert "no_temperature" in codes(blind)
    known = found_in(1, SELF_HEATED, thermal_model=True)  # whose effect was not taken off here
    assert not len(known.by_temperature)


def test_a_warm_up_that_outlasts_the_record_is_not_given() -> None:
    found = found_in(1, replace(PLAIN, times=(1500.0,)))
    assert found.reason.code == "warm_up_long"
    assert "warm_up_long" in codes(found)
    assert all(row.status == "not_estimated" for row in warm_up_rows(found) if row.quantity.startswith("bias"))


def test_a_warm_restart_is_named() -> None:
    found = found_in(1, replace(PLAIN, warm_restarts=(3,), starts=(20.0,) * 6))
    assert [one.subject for one in found.remarks if one.code == "power_up_differs"] == ["4"]


def test_axes_with_times_of_their_own_are_remarked() -> None:
    remarked = sum("axes_differ" in codes(found_in(s, replace(PLAIN, own_times=(60.0, 150.0, 900.0)))) for s in (1, 2))
    assert remarked >= 1
    assert "axes_differ" not in codes(found_in(1, PLAIN))


def test_one_power_up_has_no_uncertainty() -> None:
    found = found_in(1, replace(PLAIN, starts=(20.0,)))
    assert found.reason.code == "one_run"
    assert "one_power_up" in codes(found)
    assert found.estimate is None


def test_too_short_a_power_up_is_refused() -> None:
    with pytest.raises(DataError) as caught:
        found_in(1, replace(PLAIN, length=10.0))
    assert caught.value.problems[0].code == "too_few_readings"
    with pytest.raises(DataError) as caught:
        warm_up_model(PowerUps(("x",), "deg/s", np.zeros(0), np.zeros((0, 1)), np.zeros(0, dtype=np.int64)))
    assert caught.value.problems[0].code == "no_recordings"


def held(truth: Chamber, n: int) -> tuple[Counter[str], Counter[str]]:
    hits: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    true = true_values(truth)
    for seed in range(1, n + 1):
        found = found_in(seed, truth)
        if found.estimate is None or len(found.times) != len(truth.times):
            continue
        given = zip(found.estimate.keys, found.estimate.values, found.estimate.u, found.estimate.dof, strict=True)
        for key, value, u, dof in given:
            counts[key.name] += 1
            hits[key.name] += contains(t_interval(float(value), float(u), float(dof)), true[str(key)])
    return hits, counts


def test_intervals_hold_the_truth() -> None:
    hits, counts = held(PLAIN, 12)
    assert counts["warm_up_time_1"] == 12
    assert all(covers(hits[name], counts[name]) for name in counts), hits


@pytest.mark.slow
@pytest.mark.parametrize(
    "truth",
    [
        PLAIN,
        replace(PLAIN, scatter=0.2),
        replace(PLAIN, walk=3e-5),
        replace(PLAIN, starts=(20.0,) * 3),
        TWO,
        BY_START,
        replace(PLAIN, slope=2e-3, heating=3.0, starts=SPREAD),
        replace(BY_START, bend=5e-5, heating=5.0, walk=1e-5),
        replace(BY_START, scatter=0.1),
        replace(PLAIN, times=(900.0,)),
    ],
    ids=["plain", "scatter", "walk", "three", "two_times", "by_start", "heated", "bent", "sizes", "half_the_record"],
)
def test_intervals_hold_the_truth_of_many(truth: Chamber) -> None:
    n = sized(60, 25)
    hits, counts = held(truth, n)
    assert counts["warm_up_time_1"] >= 0.9 * n
    assert all(covers(hits[name], counts[name]) for name in counts), (hits, counts)


@pytest.mark.slow
@pytest.mark.parametrize("truth", [NONE, replace(NONE, walk=1e-4), replace(NONE, starts=SPREAD)])
def test_false_alarms_are_those_stated(truth: Chamber) -> None:
    n = 60
    found = sum(found_in(seed, truth).estimate is not None for seed in range(1, n + 1))
    assert covers(n - found, n)


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    t, y, run, T = power_ups(1, BY_START)
    found = []
    for r in range(6):
        mine = run == r
        columns = np.column_stack([t[mine], y[mine], T[mine, 0]])
        found.append(tmp_path / f"up{r + 1}.csv")
        head = "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s],temperature [degC]"
        np.savetxt(found[-1], columns, "%.6f", ",", header=head, comments="")
    return found


def test_files_give_what_arrays_give(files: list[Path]) -> None:
    result = ic.sensitivity(files, to="warm_up")
    rows = {row.key: row for row in result.rows}
    t, y, run, T = power_ups(1, BY_START)
    found = warm_up_model(PowerUps(("x", "y", "z"), "deg/s", t, y, run, T), 20.0)
    assert found.estimate is not None
    for key, value in zip(found.estimate.keys, found.estimate.values, strict=True):
        given = rows[key].value
        assert given is not None
        assert given == pytest.approx(value, rel=0.01)


def held_out_power_ups(seed: int, truth: Chamber) -> PowerUps:
    t, y, run, T = power_ups(seed, truth)
    return PowerUps(("x", "y", "z"), "deg/s", t, y, run, T)


def test_the_model_lowers_the_mean_square_of_power_ups_that_it_has_not_seen() -> None:
    found = found_in(1, BY_START)
    for loop in warm_up_loops(found, [held_out_power_ups(2, BY_START)]):
        assert loop.runs == 6
        assert loop.gain > 3.0 * loop.u > 0.0
        assert loop.compensated < 0.45 * loop.raw  # what is left is noise
        assert 0.0 < loop.allowed < loop.compensated**2
    # of a unit that warms up the other way it doubles the error
    other = replace(BY_START, amplitudes=tuple((-a[0],) for a in BY_START.amplitudes), by_start=-BY_START.by_start)
    for loop in warm_up_loops(found, [held_out_power_ups(2, other)]):
        assert loop.compensated == pytest.approx(2.0 * loop.raw, rel=0.1)


def test_power_ups_too_short_to_be_compared_are_left_out() -> None:
    assert not warm_up_loops(found_in(1, PLAIN), [held_out_power_ups(2, replace(PLAIN, length=10.0))])
