"""The rig of six faces: what its protocol says is what was done, mistakes show, intervals hold the truth."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.fitted import fitted_tests
from inertialcal.campaign.twins.score import score, score_rig
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.labelled import LabelledPart
from inertialcal.rigs import RIGS
from inertialcal.rigs.hand_held.rig import CHANNELS, Bench, build
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.six_faces.rig import FAULTS, RIG
from inertialcal.rigs.six_faces_over_temperature.rig import FAULTS as FAULTS_WARM
from inertialcal.rigs.six_faces_over_temperature.rig import RIG as WARM
from inertialcal.rigs.twin import Twin
from sized import sized

pytestmark = pytest.mark.usefixtures("undrawn")

SHORT = Bench(variant="ferraris", dwell=2.5, first=5.0, sample_rate=50.0)
IDEAL = replace(
    SHORT, acc_noise=0.0, gyro_noise=0.0, acc_between=0.0, gyro_between=0.0, lift=0.0, scale=0.0, misalignment=0.0,
    acc_bias=0.0, gyro_bias=0.0, g_sensitivity=0.0, angle=Influence(0.0, "rad"), orientation=Influence(0.0, "rad"),
    repeatability=0.0,    gravity_error=Influence(0.0, "m/s^2"), clock=Influence(0.0), mounting=Influence(0.01, "rad"),
)  # fmt: skip
OVER_TEMPERATURE = ("bias_temperature", "scale_factor_error_temperature", "cross_axis_sensitivity_temperature")
DIRECTION = {f"{axis}{sign}1": float(f"{sign}1") * row for axis, row in zip("xyz", np.eye(3), strict=True)
             for sign in "+-"}  # fmt: skip
HELD_OUT = 3e-3  # of gravity in positions held out at other temperatures [m/s^2]
RISK = 0.1  # of five kinds of outliers at 1 % each, in two tests, and of a disturbance


def codes(made: Twin) -> set[str]:
    """Return the codes of what is refused or remarked."""
    try:
        found = fitted_tests(made)
    except DataError as error:
        return {one.code for one in error.problems}
    return {one.code for fitted in found for one in fitted.result.remarks if one.severity != "info"}


def first_record(made: Twin) -> tuple[Array, tuple[LabelledPart, ...]]:
    """Return the readings of the first record, and its protocol."""
    parts = next(iter(made.extras.values())).content
    assert isinstance(parts, tuple)
    return next(iter(made.recordings.values())).array(CHANNELS), parts


def test_what_is_written_down_is_what_was_done_but_for_a_mounting_that_all_share() -> None:
    made = build(IDEAL, 1)
    data, parts = first_record(made)
    off = np.array(made.drawn["mounting"])
    assert np.abs(off).max() > 3e-3
    for part in parts:
        assert isinstance(part, LabelledPart)
        meant = DIRECTION[f"{part.label}1"] if part.angle is None else DIRECTION[f"{part.label[0]}+1"]
        true = meant + np.cross(off, meant)
        inside = data[part.start : part.stop]
        if part.angle is None:
            np.testing.assert_allclose(inside[:, :3].mean(axis=0) / IDEAL.gravity, true, atol=2e-4)
        else:
            angle = inside[:, 3:].sum(axis=0) / IDEAL.sample_rate
            np.testing.assert_allclose(angle / part.angle, true, atol=5e-4)  # the earth turns on meanwhile
    labels = Counter(part.label for part in parts)
    assert labels == Counter(dict.fromkeys(("x+", "x-", "y+", "y-", "z+", "z-", "x_rot", "y_rot", "z_rot"), 2))
    assert sum(part.angle or 0.0 for part in parts) == pytest.approx(0.0)


def test_without_a_mistake_nothing_is_remarked() -> None:
    assert not [codes(RIG.twin(seed)) for seed in range(1, 4) if codes(RIG.twin(seed))]


@pytest.mark.parametrize("fault", FAULTS)
def test_mistakes_show(fault: str) -> None:
    assert FAULTS[fault].shows in codes(RIG.twin(1, fault))


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS_WARM)
def test_mistakes_show_over_temperature(fault: str) -> None:
    assert FAULTS_WARM[fault].shows in codes(WARM.twin(1, fault))


def test_a_chamber_that_was_never_switched_on_is_refused() -> None:
    assert codes(WARM.twin(1, "one_temperature")) == {"too_few_temperatures"}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_mistakes_show_whatever_the_seed(fault: str) -> None:
    assert all(FAULTS[fault].shows in codes(RIG.twin(seed, fault)) for seed in range(2, 6))


def test_from_files_to_a_score(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(RIGS, "short", Rig("short", "", lambda seed, changes: build(SHORT, seed)))
    simulate("short", tmp_path / "d", 1)
    outcome = run(tmp_path / "d")
    assert {one["verdict"] for one in outcome.results["verdicts"]} == {"PASS"}
    assert "FAIL" not in {one["verdict"] for one in outcome.results["closed_loop"]["axes"]}
    assert not outcome.results["remarks"]
    found = score(tmp_path / "d")
    assert (len(found.rows), found.estimated) == (69, 69)  # of the fit, and of what is held out
    memory = {(one.test.id, row.quantity, row.key.sensor, row.axis): row for one in fitted_tests(build(SHORT, 1))
              for row in one.result.rows() if row.quantity in ("scale_factor_error", "misalignment")}  # fmt: skip
    factor = {"%": 100.0}
    for row in found.rows:
        other = memory.get((row["test"], row["quantity"], row["sensor"], row["axis"]))
        if other is not None and other.value is not None:
            assert row["value"] == pytest.approx(factor.get(row["unit"], 1.0) * other.value, abs=1e-4 * row["u"])


def test_several_temperatures_from_files_to_a_score(tmp_path: Path) -> None:
    """Readings held out at other temperatures are compensated to the scatter of positions and faces."""
    simulate(WARM.name, tmp_path / "d", 1)
    outcome = run(tmp_path / "d")
    assert {one["verdict"] for one in outcome.results["verdicts"]} == {"PASS"}
    assert not outcome.results["remarks"]
    loop = {one["axis"]: one for one in outcome.results["closed_loop"]["axes"]}
    assert "FAIL" not in {one["verdict"] for one in loop.values()}
    assert loop["accelerometer"]["compensated_rms"] < HELD_OUT < 0.02 * loop["accelerometer"]["raw_rms"]
    found = score(tmp_path / "d")
    assert found.estimated == len(found.rows)
    for test in ("imu", "imu_held_out"):
        warm = Counter(row["quantity"] for row in found.rows if row["test"] == test and row["power"])
        assert warm == dict(zip(OVER_TEMPERATURE, (3, 3, 6), strict=True))


def test_temperatures_change_nothing_else() -> None:
    """The unit, the bench and the readings at the reference temperature are those of a bench without temperatures."""
    one, other = build(SHORT, 1), build(replace(SHORT, temperatures=(20.0, 20.0)), 1)
    np.testing.assert_array_equal(first_record(one)[0], first_record(other)[0])
    assert set(one.truth) < set(other.truth)
    assert {value.quantity for value in set(other.truth) - set(one.truth)} == {*OVER_TEMPERATURE}


@pytest.mark.slow
def test_intervals_over_temperature_hold_the_truth() -> None:
    assert not [one for one in score_rig(WARM.name, sized(60, 20), 1) if one.verdict == "FAIL"]


@pytest.mark.slow
def test_intervals_hold_the_truth_and_clean_records_raise_no_alarm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(RIGS, "short", Rig("short", "", lambda seed, changes: build(SHORT, seed)))
    assert not [one for one in score_rig("short", sized(300, 80), 1) if one.verdict == "FAIL"]
    assert sum(bool(codes(build(SHORT, seed))) for seed in range(1, 101)) <= 100 * RISK
