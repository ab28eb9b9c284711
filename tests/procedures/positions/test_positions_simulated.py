"""Simulated units: the truth is found, mistakes are told, nothing else is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.procedures.positions.readings import local_gravity
from inertialcal.procedures.positions.reduction import Plan, Readings, Truth, on_faces, reduce, simulate
from inertialcal.procedures.positions.simulation import FACES
from positions_truths import (
    BODY,
    BY_HAND,
    BY_HAND_PLAN,
    CUBE,
    FIXTURE_PLAN,
    PLAN,
    TURNED,
    G,
    changed,
    held_out,
    true_values,
)

EYE = np.eye(3)
FAR = 5.0  # standard uncertainties
NEW = np.arange(16) * np.pi / 8.0
RING = np.column_stack([np.cos(NEW), np.sin(NEW), np.zeros(16)])


def simulated(truth: Truth = BY_HAND, plan: Plan = PLAN, seed: int = 1) -> Readings:
    return simulate(plan, truth, np.random.default_rng(seed))


@pytest.fixture(scope="module")
def clean() -> Readings:
    return simulated()


class TestTruth:
    @pytest.mark.parametrize(
        ("plan", "truth", "numbers"),
        [(BY_HAND_PLAN, BY_HAND, (9, 21)), (FIXTURE_PLAN, CUBE, (12, 21)), (FIXTURE_PLAN, TURNED, (12, 21))],
        ids=["by hand", "cube", "turned"],
    )
    def test_every_number_is_found(self, plan: Plan, truth: Truth, numbers: tuple[int, int]) -> None:
        result = reduce(plan, simulated(truth, plan))
        for kind, count in zip(("accelerometer", "gyro"), numbers, strict=True):
            found, true = result.estimates[kind], true_values(truth, kind)
            assert len(found.names) == count
            for name, value, u in zip(found.names, found.values, found.u, strict=True):
                assert abs(value - true[name]) < FAR * u, name
        assert not [one for one in result.remarks if one.code not in {"relative_to_fixture"}]

    def test_noise_free_readings_give_the_truth_itself(self) -> None:
        small = replace(BY_HAND, acc_noise=1e-9, gyro_noise=1e-9, acc_between=1e-9, gyro_between=1e-9,
                        angle_between=1e-9, sine_of_latitude=1.0, sample_interval=0.01)  # fmt: skip
        plan = Plan(gravity=G, latitude=0.5 * np.pi)  # earth rate is vertical at the pole, and taken off
        result = reduce(plan, simulated(small, plan))
        for kind in ("accelerometer", "gyro"):
            found, true = result.estimates[kind], true_values(small, kind)
            assert found.values == pytest.approx([true[name] for name in found.names], abs=2e-6)

    def test_model_compensates_what_was_simulated(self, clean: Readings) -> None:
        model = reduce(PLAN, clean).models["gyro"]
        assert model.g_sensitivity == pytest.approx(BODY.g_sensitivity, abs=3e-5)
        assert model.matrix[0] == pytest.approx(BODY.gyro_matrix, abs=3e-3)

    def test_held_out_positions_close_as_well_as_those_that_were_fitted(self) -> None:
        readings = simulated(replace(BY_HAND, directions=BY_HAND.directions))
        _, angle_rms = held_out(PLAN, readings, 13)
        assert angle_rms < 4.0 * BODY.angle_between
        _, without = held_out(replace(PLAN, g_sensitivity=False), readings, 13)
        assert without > 1.2 * angle_rms

    def test_gravity_of_the_place(self) -> None:
        assert local_gravity(Plan(latitude=0.0)) == pytest.approx(9.7803253, abs=1e-6)
        assert local_gravity(Plan(latitude=0.8, height=1000.0)) < local_gravity(Plan(latitude=0.8))
        assert "gravity_assumed" in {one.code for one in reduce(Plan(), simulated(plan=Plan())).remarks}


class TestNotTold:
    def test_six_faces_with_gravity_alone_tell_six_of_nine(self) -> None:
        result = reduce(PLAN, simulated(replace(BY_HAND, directions=np.vstack([FACES, FACES]))))
        assert (result.acc.observed.rank, result.acc.observed.count) == (6, 9)
        assert set(result.acc.observed.combinations) == {"misalignment_yx", "misalignment_zx", "misalignment_zy"}
        found = result.estimates["accelerometer"]
        assert set(found.names) == {f"{name}_{axis}" for name in ("scale_factor_error", "bias") for axis in "xyz"}
        rows = {(row.quantity, row.axis): row for row in result.rows() if row.key.sensor == "accelerometer"}
        assert rows["misalignment", "zy"].status == "not_estimated"
        assert rows["misalignment", "zy"].reason.code == "not_told"
        assert rows["misalignment", "yz"].reason.code == "of_frame"

    def test_as_many_positions_as_unknowns_have_no_uncertainty(self, clean: Readings) -> None:
        result = reduce(PLAN, clean.take(0, 9))
        assert "accelerometer" not in result.estimates
        assert "no_dof" in {one.code for one in result.remarks}
        assert all(row.u is None for row in result.rows() if row.key.sensor == "accelerometer")
        reasons = {
            row.reason.code for row in result.rows() if row.key.sensor == "gyro" and row.quantity == "misalignment"
        }
        assert reasons == {"no_gravity"}

    def test_known_positions_in_one_plane(self) -> None:
        result = reduce(PLAN, simulated(replace(CUBE, directions=RING)))
        assert set(result.acc.observed.combinations) == {"scale_factor_error_z", "misalignment_xz", "misalignment_yz"}

    def test_positions_that_are_not_named_take_no_part_among_named_ones(self) -> None:
        whole = simulated(CUBE)
        assert whole.direction is not None
        part = replace(whole, direction=np.where((np.arange(len(whole)) < 14)[:, None], whole.direction, np.nan))
        found, alone = reduce(PLAN, part), reduce(PLAN, whole.take(0, 14))
        assert found.acc.known
        assert found.estimates["accelerometer"].values == pytest.approx(alone.estimates["accelerometer"].values)
        assert found.acc.residuals.shape == (len(whole), 3)
        assert np.isnan(found.acc.residuals[14:]).all()
        few = replace(whole, direction=np.where((np.arange(len(whole)) < 3)[:, None], whole.direction, np.nan))
        assert not reduce(PLAN, few).acc.known

    def test_turns_made_once_need_stated_angles(self) -> None:
        once = replace(TURNED, directions=FACES, turns=2.0 * np.pi * EYE)
        bare, stated = reduce(PLAN, simulated(once)), reduce(FIXTURE_PLAN, simulated(once, FIXTURE_PLAN))
        assert not [name for name in bare.estimates["gyro"].names if name.startswith("misalignment")]
        assert "misalignment_xy" in stated.estimates["gyro"].names
        assert "not_repeated" in {one.code for one in stated.remarks}

    def test_gyros_that_rest_tell_their_bias(self, clean: Readings) -> None:
        result = reduce(PLAN, replace(clean, rotations=()))
        assert {name.rsplit("_", 1)[0] for name in result.estimates["gyro"].names} == {"bias", "g_sensitivity"}


SWAP = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
REFUSED: list[tuple[str, Array, Array, str, str]] = [
    ("acc in g", EYE / 9.80665, EYE, "unit_slip", "these are readings in g"),
    ("gyro in deg/s", EYE, np.degrees(1.0) * EYE, "unit_slip", "these are readings in deg/s"),
    ("gyros swapped", EYE, SWAP, "axes_disagree", "gyro x turns about accelerometer axis y"),
    ("gyro inverted", EYE, np.diag([1.0, 1.0, -1.0]), "axes_disagree", "gyro z turns about accelerometer axis -z"),
    ("acc inverted", np.diag([1.0, -1.0, 1.0]), EYE, "axes_disagree", "gyro x turns about accelerometer axis -x"),
]


class TestMistakes:
    @pytest.mark.parametrize(("name", "acc", "gyro", "code", "text"), REFUSED, ids=[one[0] for one in REFUSED])
    def test_refused(self, clean: Readings, name: str, acc: Array, gyro: Array, code: str, text: str) -> None:
        with pytest.raises(DataError, match=text) as error:
            reduce(PLAN, changed(clean, acc, gyro))
        assert error.value.problems[0].code == code, name

    @pytest.mark.parametrize(
        ("time", "code", "text"),
        [
            (0.5, "sample_rate_suspect", "2 times too high"),
            (2.0, "sample_rate_suspect", "2 times too low"),
            (0.05, "rotations_do_not_close", "the time axis"),
        ],
    )
    def test_time_axis(self, clean: Readings, time: float, code: str, text: str) -> None:
        found = [one for one in reduce(PLAN, changed(clean, EYE, EYE, time)).remarks if one.code == code]
        assert len(found) == 1
        assert text in found[0].what

    def test_too_few_positions(self, clean: Readings) -> None:
        with pytest.raises(DataError, match="need 4 or more, and 10") as error:
            reduce(PLAN, clean.take(0, 3))
        assert error.value.problems[0].code == "too_few_positions"

    def test_all_on_one_plane(self) -> None:
        with pytest.raises(DataError, match="all positions lie in one plane") as error:
            reduce(PLAN, simulated(replace(BY_HAND, directions=RING)))
        assert error.value.problems[0].code == "one_plane"

    def test_a_wrong_position_is_named_and_left_out(self, clean: Readings) -> None:
        mean = clean.acc.mean.copy()
        mean[5] *= 1.005  # 0.05 m/s2 too long
        result = reduce(PLAN, replace(clean, acc=replace(clean.acc, mean=mean)))
        assert np.flatnonzero(result.acc.outliers).tolist() == [5]
        named = [one for one in result.remarks if one.code == "outlier_position"]
        assert named[0].where.startswith("position 6")
        true = true_values(BY_HAND, "accelerometer")
        found = result.estimates["accelerometer"]
        assert np.all(np.abs(found.values - [true[name] for name in found.names]) < FAR * found.u)

    def test_a_wrong_rotation_is_named_and_left_out(self, clean: Readings) -> None:
        rotations = list(clean.rotations)
        rotations[3] = replace(rotations[3], gyro=rotations[3].gyro + np.array([0.05, 0.0, 0.0]))
        result = reduce(PLAN, replace(clean, rotations=tuple(rotations)))
        assert [one.where for one in result.remarks if one.code == "outlier_rotation"] == ["simulated rotation 4"]

    def test_a_unit_that_moved_while_it_should_rest(self, clean: Readings) -> None:
        assert clean.gyro is not None
        mean = clean.gyro.mean.copy()
        mean[7, 1] += 0.01
        result = reduce(PLAN, replace(clean, gyro=replace(clean.gyro, mean=mean)))
        assert [one.where[:10] for one in result.remarks if one.code == "outlier_at_rest"] == ["position 8"]

    def test_a_position_on_no_face(self, clean: Readings) -> None:
        with pytest.raises(DataError, match="deg away from any face") as error:
            on_faces(clean)
        assert error.value.problems[0].code == "no_face"

    def test_positions_on_faces_are_told_which(self) -> None:
        readings = on_faces(simulated(replace(BY_HAND, directions=FACES)))
        assert readings.direction == pytest.approx(FACES)
