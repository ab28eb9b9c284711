"""A gyro against a magnetometer in orbit: truth recovered, coverage, published sizes, what breaks it."""

from __future__ import annotations

from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from scipy.stats import t as student

import inertialcal as ic
from independent.coverage import keeps
from inertialcal.core.errors import DataError
from inertialcal.core.influence import Influence
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.magnetometer_bias.arcs import Arc, Noise, solved
from inertialcal.procedures.magnetometer_bias.plan import Plan
from inertialcal.procedures.magnetometer_bias.readings import Readings, track
from inertialcal.procedures.magnetometer_bias.reduction import Result, cut, reduce
from inertialcal.procedures.magnetometer_bias.start import by_magnitude, by_pairs

pytest.importorskip("ppigrf")
from independent.orbit.magnetometer import DEG, Orbit, recorded

Array = NDArray[np.float64]
START = 1_772_323_200_000_000_000  # 2026-03-01 [ns]
AXES = "xyz"


def recording(made: Orbit, **changes: Any) -> Recording:
    """Return a record as the engine hands it over: SI, named by role."""
    channels = [Channel(axis, made.rates[:, i], "rad/s") for i, axis in enumerate(AXES)]
    channels += [Channel(f"magnetometer_{axis}", made.field[:, i], "T") for i, axis in enumerate(AXES)]
    channels += [Channel(f"position_{axis}", made.position[:, i], "m") for i, axis in enumerate(AXES)]
    stamps = np.rint(made.time * 1e9).astype(np.int64) + START
    return Recording(tuple(channels), stamps, float(made.time[1] - made.time[0]), epoch=changes.get("epoch", "utc"))


def reduced(made: Orbit, **settings: Any) -> Result:
    return reduce(Plan(**settings), Readings((track(recording(made), "one", "one.csv", None),)))


@cache
def tumbling(seed: int = 1) -> Orbit:
    return recorded(np.random.default_rng(seed))


def held(made: Orbit, result: Result) -> dict[str, bool]:
    """Return whether each 95 % interval holds the truth."""
    truth = {f"bias_{axis}": made.bias[i] for i, axis in enumerate(AXES)}
    truth |= {f"magnetometer_bias_{axis}": made.offset[i] for i, axis in enumerate(AXES)}
    estimate = result.estimate
    u, dof = dict(zip(estimate.names, estimate.u, strict=True)), dict(zip(estimate.names, estimate.dof, strict=True))
    return {name: bool(abs(estimate.value(name) - true) <= student.ppf(0.975, dof[name]) * u[name])
            for name, true in truth.items()}  # fmt: skip


def codes(result: Result) -> set[str]:
    return {one.code for one in result.remarks} - {"relative_to_fixture"}


# ---- truth recovered ---------------------------------------------------------------------------------------------


def test_without_noise_the_truth_comes_out() -> None:
    made = recorded(np.random.default_rng(5), seconds=2400.0, noise_field=1e-12, noise_rate=1e-12)
    found = reduced(made).estimate
    assert np.max(np.abs(found.values[:3] - made.bias)) < 3e-6 * DEG  # rates are means, turns between them small
    assert np.max(np.abs(found.values[3:] - made.offset)) < 1e-9


def test_file_and_recording_give_the_same(tmp_path: Path) -> None:
    made = tumbling()
    fixed = ic.magnetometer_bias(made.write(tmp_path / "fixed.csv"), epoch="2026-03-01")
    level = ic.magnetometer_bias(made.write(tmp_path / "level.csv", geodetic=True), epoch="2026-03-01")
    for one in (fixed, level):
        assert one.result.estimate.values == pytest.approx(reduced(made).estimate.values, rel=1e-4)
    assert {row.key.quantity for row in fixed.rows} == {"bias", "magnetometer_bias", "field_residual"}


def test_the_model_has_the_bias(tmp_path: Path) -> None:
    found = ic.magnetometer_bias(tumbling().write(tmp_path / "orbit.csv"), epoch="2026-03-01")
    (model,) = found.models.values()
    assert model.bias.tolist() == pytest.approx(found.result.estimate.values[:3].tolist())


def coverage(n: int, motion: str) -> tuple[Counter[str], Counter[str], list[float]]:
    """Return hits by figure, remarks, and uncertainties of the bias of x [deg/s]."""
    hits: Counter[str] = Counter()
    said: Counter[str] = Counter()
    u = []
    for seed in range(1, n + 1):
        made = recorded(np.random.default_rng(seed), 3600.0, 2.0, motion)
        result = reduced(made)
        hits.update({name: int(one) for name, one in held(made, result).items()})
        said.update(codes(result))
        u.append(float(result.estimate.u[0]) / DEG)
    return hits, said, u


@pytest.mark.parametrize("motion", ["tumbling", "nadir"])
def test_intervals_hold(motion: str) -> None:
    hits, said, u = coverage(4, motion)
    assert all(keeps("holds", one, 4) for one in hits.values()), hits
    assert not said
    assert np.median(u) < 5e-4


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["tumbling", "nadir"])
def test_intervals_hold_in_300(motion: str) -> None:
    hits, said, _ = coverage(300, motion)
    assert all(keeps("holds", one, 300) for one in hits.values()), hits
    assert all(count <= 4 for count in said.values()), said  # of 0.3 expected


def of_standards(seed: int) -> Orbit:
    """Return a record with errors of a gyro's matrix, an angle between the triads, a field that is off all along."""
    rng = np.random.default_rng([seed, 7])
    gyro = np.eye(3) + rng.normal(0.0, 2e-3, (3, 3))
    gyro[np.diag_indices(3)] = 1.0 + rng.normal(0.0, 0.005, 3)
    turned = Rotation.from_rotvec(rng.normal(0.0, 3e-3, 3)).as_matrix()
    return recorded(rng, 3600.0, 2.0, gyro=gyro, magnetometer=turned, extra=rng.normal(0.0, 30e-9, 3))


@pytest.mark.slow
def test_intervals_hold_with_errors_of_standards() -> None:
    """Scale factors, misalignments, an angle between the triads, a field that is off by 30 nT all along."""
    stated = {
        "sensor.scale_factor": Influence(0.005),
        "sensor.misalignment": Influence(2e-3, "rad"),
        "magnetometer.mounting": Influence(3e-3, "rad"),
        "earth_field.uniform": Influence(30e-9, "T"),
    }
    hits: Counter[str] = Counter()
    for seed in range(1, 101):
        made = of_standards(seed)
        result = reduced(made, standards=stated)
        hits.update({name: int(one) for name, one in held(made, result).items()})
    assert all(keeps("holds", one, 100) for one in hits.values()), hits


# ---- published sizes -----------------------------------------------------------------------------------------------


def pairs(made: Orbit, offset: Array, lag: float) -> float:
    """Return the error of the bias by pairs of one lag, that the literature takes, rms of the axes [deg/s]."""
    bias, _ = by_pairs(cut(track(recording(made), "one", "", None), 1435.0), offset, (15.0, 30.0, lag))
    return float(np.sqrt(np.mean((bias - made.bias) ** 2))) / DEG


@pytest.mark.parametrize(("lag", "low", "high"), [(30.0, 0.001, 0.006), (120.0, 1e-4, 6e-4), (300.0, 4e-5, 3e-4)])
def test_pairs_of_a_lag_err_as_published(lag: float, low: float, high: float) -> None:
    """0.003 to 0.004 deg/s at 30 s, 2 to 3e-4 at 120 s, 1 to 1.5e-4 at 300 s: one orbit, 50 nT, 0.004 deg/s."""
    errors = [pairs(made, made.offset, lag) for made in map(tumbling, (1, 2, 3))]
    assert low < np.sqrt(np.mean(np.square(errors))) < high


def test_arcs_know_more_than_pairs() -> None:
    made = [tumbling(seed) for seed in (1, 2, 3)]
    arcs = [float(np.sqrt(np.mean((reduced(one).estimate.values[:3] - one.bias) ** 2))) / DEG for one in made]
    assert np.sqrt(np.mean(np.square(arcs))) < np.sqrt(
        np.mean(np.square([pairs(one, one.offset, 120.0) for one in made]))
    )


def test_a_magnetometer_bias_left_out_costs_more_the_shorter_the_lag() -> None:
    made = recorded(np.random.default_rng(2), offset=np.array([300e-9, 0.0, 0.0]))
    short, middle, long = (pairs(made, np.zeros(3), lag) for lag in (30.0, 120.0, 300.0))
    assert short > middle > long
    assert short > 20.0 * pairs(
        made, by_magnitude(made.field, track(recording(made), "one", "", None).reference), 120.0
    )


# ---- changes by influences -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("entry", ["xx", "yz", "zx"])
def test_entries_of_the_gyro_move_the_bias_as_said(entry: str) -> None:
    i, j = AXES.index(entry[0]), AXES.index(entry[1])
    matrix = np.eye(3)
    matrix[i, j] += 2e-3
    plain, moved = (recorded(np.random.default_rng(3), seconds=2400.0, gyro=one) for one in (np.eye(3), matrix))
    before = reduced(plain)
    change = reduced(moved).estimate.values - before.estimate.values
    said = 2e-3 * before.solution.changes()[3 * i + j]
    assert change[:3] == pytest.approx(said[:3], abs=0.05 * float(np.max(np.abs(said[:3]))))


def test_a_turned_magnetometer_moves_the_bias_as_said() -> None:
    turned = Rotation.from_rotvec([0.0, 2e-3, 0.0]).as_matrix()
    plain, moved = (recorded(np.random.default_rng(3), seconds=2400.0, magnetometer=one) for one in (np.eye(3), turned))
    stated = {"magnetometer.mounting": Influence(2e-3, "rad")}
    change = reduced(moved).estimate.values[:3] - reduced(plain).estimate.values[:3]
    (part,) = [one for one in reduced(plain, standards=stated).estimate.components if one.kind == "B"]
    assert part.unknowns == ("x", "y", "z")
    assert part.changes is not None
    assert abs(change) == pytest.approx(abs(part.changes[1, :3]), abs=0.1 * float(np.max(np.abs(change))))


# ---- what breaks it ----------------------------------------------------------------------------------------------


def refusal(made: Orbit, **settings: Any) -> tuple[str, str]:
    with pytest.raises(DataError) as caught:
        reduced(made, **settings)
    return caught.value.problems[0].code, str(caught.value)


@pytest.mark.parametrize(
    ("matrix", "said"),
    [(np.eye(3)[[1, 0, 2]], "x is y, y is x, z is z"), (np.diag([1.0, 1.0, -1.0]), "x is x, y is y, z is -z")],
)
def test_axes_that_do_not_belong_together_are_named(matrix: Array, said: str) -> None:
    code, text = refusal(recorded(np.random.default_rng(2), seconds=2100.0, magnetometer=matrix))
    assert code == "axes_disagree"
    assert said in text


def test_a_magnetometer_with_all_axes_turned_round_is_refused() -> None:
    """Angles between two readings are the same: what an attitude cannot bring about shows it."""
    code, text = refusal(recorded(np.random.default_rng(2), seconds=2100.0, magnetometer=-np.eye(3)))
    assert code == "axes_disagree"
    assert "with the sign of every axis changed" in text


def test_gaps_are_named_where_they_leave_too_few_arcs() -> None:
    made = recorded(np.random.default_rng(2), seconds=2100.0)
    made.rates[::100] = np.nan
    code, text = refusal(made)
    assert code == "too_short"
    assert "gap" in text


def test_a_dead_axis_is_refused() -> None:
    made = recorded(np.random.default_rng(15), seconds=2100.0)
    made.rates[:, 1] = 0.0
    assert refusal(made)[0] == "no_fit"


def test_a_field_of_another_time_is_refused() -> None:
    made = recorded(np.random.default_rng(14), seconds=2100.0)
    made.field = made.field[::-1].copy()
    assert refusal(made)[0] == "no_fit"


def test_degrees_taken_for_radians_are_refused() -> None:
    made = recorded(np.random.default_rng(8), seconds=600.0)
    made.rates /= DEG
    assert refusal(made)[0] == "sample_rate"


def test_a_wrong_unit_of_the_field_is_refused() -> None:
    made = recorded(np.random.default_rng(8), seconds=600.0)
    made.field *= 1e3
    assert refusal(made)[0] == "wrong_unit"


def test_a_short_record_is_refused() -> None:
    assert refusal(recorded(np.random.default_rng(9), seconds=1200.0))[0] == "too_short"


def test_no_date_is_asked_for() -> None:
    made = recorded(np.random.default_rng(9), seconds=600.0)
    with pytest.raises(DataError, match="--epoch") as caught:
        track(recording(made, epoch="elapsed"), "one", "one.csv", None)
    assert caught.value.problems[0].code == "no_date"


@pytest.mark.parametrize("late", [20.0, -6.0])
def test_a_clock_that_is_off_is_told_by_its_size(late: float) -> None:
    found = reduced(recorded(np.random.default_rng(3), late=late))
    (remark,) = [one for one in found.remarks if one.code == "clock_offset"]
    words = remark.what.split()
    assert float(words[words.index("s") - 1]) == pytest.approx(abs(late), abs=1.0)
    assert ("ahead" in remark.what) == (late > 0.0)


def test_a_drift_is_told_and_the_mean_is_held() -> None:
    made = recorded(np.random.default_rng(4), drift=0.003 * DEG)
    found = reduced(made)
    assert codes(found) == {"bias_drifts"}
    assert found.estimate.values[0] == pytest.approx(made.bias[0] + 0.0015 * DEG, abs=4e-4 * DEG)


def test_scale_factors_are_told_and_estimated() -> None:
    made = recorded(np.random.default_rng(5), magnetometer=np.diag([1.01, 0.99, 1.0]))
    assert "scale_factor_seen" in codes(reduced(made))
    found = reduced(made, magnetometer_model="scale_factor")
    assert codes(found) <= {"disturbed"}
    assert found.estimate.values[6:] == pytest.approx([0.01, -0.01, 0.0], abs=5e-4)
    assert all(held(made, found).values())


def test_magnetorquers_are_left_out() -> None:
    made = recorded(np.random.default_rng(6))
    acting = np.arange(len(made.time)) % 60 < 8
    made.field[acting] += np.random.default_rng(1).normal(0.0, 5e-6, (int(acting.sum()), 3))
    found = reduced(made)
    assert codes(found) == {"disturbed"}
    assert sum(one.count for one in found.remarks if one.code == "disturbed") == pytest.approx(acting.sum(), rel=0.05)
    assert sum(held(made, found).values()) >= 5


def test_gaps_and_a_slow_magnetometer_are_worked_with() -> None:
    made = recorded(np.random.default_rng(10))
    made.field[np.arange(len(made.time)) % 10 != 0] = np.nan
    made.rates[(np.arange(len(made.time)) % 1500) > 1100] = np.nan
    found = reduced(made)
    assert not codes(found)
    assert sum(held(made, found).values()) >= 5
    assert all(one.length < 500.0 for one in found.arcs)


def test_large_biases_are_found() -> None:
    made = recorded(np.random.default_rng(13), seconds=2400.0, bias=np.array([2.0, -1.5, 1.0]) * DEG)
    assert reduced(made).estimate.values[:3] == pytest.approx(made.bias, abs=5e-4 * DEG)


def test_noise_of_short_lags_does_not_lead_the_search_astray() -> None:
    """Pairs 15 s apart are off by 0.3 deg/s here, and longer ones that begin there by 0.2."""
    made = of_standards(78)
    assert np.max(np.abs(reduced(made).estimate.values[:3] - made.bias)) < 0.01 * DEG


def test_a_lag_as_long_as_the_arcs_is_left_out() -> None:
    """Arcs of 300 s have a handful of pairs 298 s apart, which tell three unknowns badly."""
    made = recorded(np.random.default_rng(2), 1800.0, 2.0)
    arcs = cut(track(recording(made), "one", "", None), 300.0)
    lags = (15.0, 30.0, 60.0, 120.0)
    assert by_pairs(arcs, made.offset, (*lags, 298.0))[0].tolist() == by_pairs(arcs, made.offset, lags)[0].tolist()


def test_arcs_that_say_nothing_of_a_bias_are_refused() -> None:
    n = 100
    steady = np.tile([2e-5, 0.0, 3e-5], (n, 1))  # neither field nor body turn
    arcs = [Arc(np.arange(n, dtype=float), np.zeros((n - 1, 3)), 1.0, np.arange(n), steady, steady, 0.0)] * 6
    with pytest.raises(DataError) as caught:
        solved(arcs, np.zeros(6), Noise(5e-8, 1e-6), scale=False)
    assert caught.value.problems[0].code == "not_observable"
