"""Recordings that others made: an Xsens MTi laid by hand, and a Ferraris session, with their published results."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.core.constants import STANDARD_GRAVITY
from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.recording import Channel, Recording
from inertialcal.files import read
from inertialcal.procedures.positions.recordings import ACC, GYRO
from inertialcal.procedures.positions.reduction import (
    Plan,
    Readings,
    Result,
    Section,
    ferraris,
    readings_from,
    reduce,
)
from positions_truths import held_out

GRAVITY = 9.81744  # m/s2, of the Xsens recording
SHEET_ACC, SHEET_GYRO = (415.0, 413.0, 415.0), (4778.0, 4758.0, 4766.0)  # count/(m/s2), count/(rad/s), rounded to 1
SHEET_MISALIGNMENT = {"yx": 0.01, "zx": 0.02, "zy": 0.01}  # of the accelerometers, rounded to 0.01
WITHIN = 0.003
HELD_OUT_WITH_G, HELD_OUT_WITHOUT = 0.17, 0.45  # deg
PUBLISHED = 1e-6
WARNINGS_OF_DATA = {"outliers", "relative_to_fixture"}  # single samples that stand out; standards nobody stated


def recording(acc: Array, gyro: Array, units: tuple[str, str], rate: float, time: Array | None = None) -> Recording:
    columns = np.column_stack([acc, gyro]).T
    named = zip(ACC + GYRO, columns, [units[0]] * 3 + [units[1]] * 3, strict=True)
    stamps = None if time is None else np.round(time * 1e9).astype(np.int64)
    return Recording(tuple(Channel(n, np.array(c), u) for n, c, u in named), stamps, 1.0 / rate)


@dataclass(frozen=True, eq=False)
class Xsens:
    recording: Recording
    readings: Readings
    result: Result


@pytest.fixture(scope="module")
def xsens(shared: Path) -> Xsens:
    folder = shared / "data" / "imu_tk_xsens_mti"
    acc, gyro = np.loadtxt(folder / "xsens_acc.mat"), np.loadtxt(folder / "xsens_gyro.mat")
    one = recording(acc[:, 1:], gyro[:, 1:], ("count", "count"), 100.0, acc[:, 0])
    plan = Plan(gravity=GRAVITY)
    readings = readings_from(plan, [one])
    return Xsens(one, readings, reduce(plan, readings))


class TestXsens:
    def test_static_intervals_and_rotations_between(self, xsens: Xsens) -> None:
        assert len(xsens.readings) == 38
        assert len(xsens.readings.transitions) == 37
        worth = xsens.readings.acc.n_effective / np.asarray(xsens.readings.acc.samples)[:, None]
        assert 0.5 < np.median(worth) < 0.9  # neighbours are correlated, by about 0.165

    @pytest.mark.parametrize(("kind", "sheet"), [("accelerometer", SHEET_ACC), ("gyro", SHEET_GYRO)])
    def test_scale_factors_are_those_of_the_factory(self, xsens: Xsens, kind: str, sheet: tuple[float, ...]) -> None:
        found = xsens.result.estimates[kind]
        for axis, value in zip("xyz", sheet, strict=True):
            assert found.value(f"scale_factor_{axis}") == pytest.approx(value, rel=WITHIN)

    def test_misalignment_of_the_accelerometers_against_the_sheet(self, xsens: Xsens) -> None:
        """The sheet is in a frame of its own: in that of the accelerometers its lower and upper entries add."""
        found = xsens.result.estimates["accelerometer"]
        upper = {"yx": 0.0, "zx": -0.01, "zy": 0.01}  # xy, xz, yz of the sheet
        for pair, value in SHEET_MISALIGNMENT.items():
            assert found.value(f"misalignment_{pair}") == pytest.approx(value + upper[pair], abs=0.0075)

    def test_noise_inside_positions_alone_promises_too_much(self, xsens: Xsens) -> None:
        acc = xsens.result.acc
        assert acc.chi_square_known / acc.free > 8.0
        assert 0.8 < acc.chi_square / acc.free < 1.25
        assert acc.between == pytest.approx(0.11e-3 * GRAVITY, rel=0.1)
        rotated = xsens.result.gyro.rotated if xsens.result.gyro else None
        assert rotated is not None
        assert rotated.found is not None
        assert 0.8 < rotated.found.chi_square / rotated.found.free < 1.25

    def test_left_out_one_by_one_the_positions_agree_with_their_uncertainty(self, xsens: Xsens) -> None:
        acc = xsens.result.acc
        assert not acc.outliers.any()
        leverage = 1.0 - acc.residuals / acc.deletion
        assert np.sum(leverage) == pytest.approx(9.0, abs=0.3)  # the parameters that were fitted

    def test_g_sensitivity_explains_the_gyros_at_rest_and_the_rotations(self, xsens: Xsens) -> None:
        gyro = xsens.result.gyro
        assert gyro is not None
        assert gyro.rest.share > 0.9
        length_rms, with_g = held_out(Plan(gravity=GRAVITY), xsens.readings, 19)
        _, without = held_out(Plan(gravity=GRAVITY, g_sensitivity=False), xsens.readings, 19)
        assert np.degrees(with_g) <= HELD_OUT_WITH_G
        assert np.degrees(without) >= HELD_OUT_WITHOUT
        assert length_rms < 2e-3  # m/s2

    def test_no_false_alarm(self, xsens: Xsens) -> None:
        warnings = {one.code for one in xsens.result.remarks if one.severity != "info"}
        assert warnings <= WARNINGS_OF_DATA

    def test_models_take_the_counts_to_gravity(self, xsens: Xsens) -> None:
        model = xsens.result.models["accelerometer"]
        counts = xsens.readings.acc.mean
        x = (counts / model.scale_factor - model.bias) @ np.linalg.inv(model.matrix[0]).T
        assert np.linalg.norm(x, axis=1) == pytest.approx(GRAVITY, abs=0.005)
        assert model.output_unit == "count"

    def test_half_the_time_is_remarked_where_the_scale_factor_is_stated(self, xsens: Xsens) -> None:
        plan = Plan(gravity=GRAVITY, gyro_scale_factor=dict(zip("xyz", SHEET_GYRO, strict=True)))
        faster = tuple(replace(one, seconds=one.seconds / 2.0) for one in xsens.readings.rotations)
        found = reduce(plan, replace(xsens.readings, rotations=faster))
        assert "sample_rate_suspect" in {one.code for one in found.remarks}
        assert "sample_rate_suspect" not in {one.code for one in reduce(plan, xsens.readings).remarks}

    def test_swapped_gyros_are_refused_though_their_scale_is_unknown(self, xsens: Xsens) -> None:
        assert xsens.readings.gyro is not None
        order = [1, 0, 2]
        gyro = replace(xsens.readings.gyro, mean=xsens.readings.gyro.mean[:, order])
        rotations = tuple(replace(one, gyro=one.gyro[:, order]) for one in xsens.readings.rotations)
        with pytest.raises(DataError, match="gyro x turns about accelerometer axis y") as error:
            reduce(Plan(gravity=GRAVITY), replace(xsens.readings, gyro=gyro, rotations=rotations))
        assert error.value.problems[0].code == "axes_disagree"

    def test_a_copy_is_no_repeat(self, xsens: Xsens) -> None:
        with pytest.raises(DataError, match="hold the same samples") as error:
            readings_from(Plan(), [xsens.recording, replace(xsens.recording)])
        assert error.value.problems[0].code == "duplicate_recording"


def sections(parts: dict[str, tuple[int, int]]) -> list[Section]:
    """x_p: x up, x_a: x down, x_rot: turned about x by a whole turn clockwise."""
    found = []
    for name, (start, stop) in parts.items():
        k = "xyz".index(name[0])
        axis: Any = tuple(float(j == k) for j in range(3))
        if name.endswith("rot"):
            found.append(Section(start, stop, axis=axis, angle=-2.0 * np.pi, name=name))
        else:
            sign = 1.0 if name.endswith("p") else -1.0
            found.append(Section(start, stop, direction=tuple(sign * a for a in axis), name=name))
    return found


@pytest.fixture(scope="module")
def annotated(shared: Path) -> tuple[Array, Array, dict[str, tuple[int, int]]]:
    with (shared / "data" / "imucal_ferraris" / "annotated_session.csv").open() as file:
        rows = list(csv.DictReader(file))
    parts: dict[str, tuple[int, int]] = {}
    for k, row in enumerate(rows):
        parts[row["part"]] = (parts.get(row["part"], (k, k))[0], k + 1)
    acc, gyro = (np.array([[float(row[f"{s}_{a}"]) for a in "xyz"] for row in rows]) for s in ("acc", "gyr"))
    return acc, gyro, parts


class TestFerraris:
    def test_published_snapshot(self, annotated: tuple[Array, Array, dict[str, tuple[int, int]]], shared: Path) -> None:
        acc, gyro, parts = annotated
        one = recording(acc, gyro, ("count", "count"), 204.8)
        found = ferraris(readings_from(Plan(), [one], [sections(parts)]), 9.81)
        text = (shared / "data" / "imucal_ferraris" / "expected_snapshot_example_cal.json").read_text()
        expected = {
            name: np.array(value) for name, value in json.loads(text).items() if name[1:2] == "_" or "K_" in name
        }
        degree = np.pi / 180.0
        ours = {
            "K_a": np.diag(found.K_a), "R_a": found.R_a, "b_a": found.b_a, "K_g": degree * np.diag(found.K_g),
            "R_g": found.R_g, "K_ga": found.K_ga, "b_g": found.b_g,
        }  # fmt: skip
        for name, value in ours.items():
            assert np.abs(value - expected[name]).max() < PUBLISHED, name

    def test_least_squares_agrees_with_the_closed_form(
        self, annotated: tuple[Array, Array, dict[str, tuple[int, int]]]
    ) -> None:
        acc, gyro, parts = annotated
        plan = Plan(gravity=9.81)
        readings = readings_from(plan, [recording(acc, gyro, ("count", "count"), 204.8)], [sections(parts)])
        result, closed = reduce(plan, readings), ferraris(readings, 9.81)
        matrix = result.acc.sensor.matrix * result.acc.sensor.ideal[:, None]
        assert matrix == pytest.approx(closed.K_a[:, None] * closed.R_a, abs=2e-4 * closed.K_a.max())
        assert np.all(np.diag(matrix) > np.diag(closed.K_a[:, None] * closed.R_a))  # the cosine of the tilts added
        assert result.gyro is not None
        own = result.gyro.sensor.matrix * result.gyro.sensor.ideal[:, None]
        assert own == pytest.approx(closed.K_g[:, None] * closed.R_g, abs=3e-3 * closed.K_g.max())
        assert "turn_sense" in {one.code for one in result.remarks}
        why = {row.reason.code for row in result.rows() if row.key.sensor == "gyro" and row.quantity == "misalignment"}
        assert why == {"nothing_left"}

    @pytest.mark.parametrize(("rate", "suspect"), [(102.4, False), (204.8, True)])
    def test_twice_the_sample_rate_is_remarked(self, shared: Path, rate: float, suspect: bool) -> None:
        folder = shared / "data" / "imucal_ferraris"
        table = np.genfromtxt(folder / "example_ferraris_session.csv", delimiter=",", names=True)
        acc, gyro = (np.column_stack([table[f"{s}_{a}"] for a in "xyz"]) for s in ("acc", "gyr"))
        one = recording(acc, np.radians(gyro), ("m/s^2", "rad/s"), rate)
        listed = json.loads((folder / "example_ferraris_session_list.json").read_text())
        parts = {name: (part["start"], part["end"]) for name, part in listed.items()}
        stated = {name: Influence(0.02, "rad") for name in ("fixture.orientation", "fixture.mounting", "turn.angle")}
        by_protocol = reduce(Plan(gravity=9.81, standards=stated), readings_from(Plan(), [one], [sections(parts)]))
        by_itself = reduce(Plan(gravity=9.81), readings_from(Plan(), [one]))
        for found in (by_protocol, by_itself):
            assert ("sample_rate_suspect" in {remark.code for remark in found.remarks}) is suspect
        if not suspect:
            codes = {remark.code for remark in by_protocol.remarks if remark.severity != "info"}
            once = {"not_repeated", "scatter_not_judged"}  # each turn was made, and each face laid, once
            assert codes == {*once, "relative_to_fixture"}


DISTURBED, CLEAN = "set-1__unmoved-x-pointing-up", "set-1__unmoved-x-pointing-forward"


@pytest.mark.parametrize(("name", "disturbed"), [(DISTURBED, True), (CLEAN, False)])
def test_a_disturbance_while_the_unit_lay_is_told_and_left_out(shared: Path, name: str, disturbed: bool) -> None:
    """An MPU-6050 that its owner calls unmoved, and that was turned at up to 8.9 deg/s within its first second."""
    folder = shared / "data" / "sunsided_mpu6050_static" / name
    acc = read(folder / "mpu6050_accelerometer.mat").array()
    gyro = read(folder / "mpu6050_gyroscope.mat").array()
    n = min(len(acc), len(gyro))
    one = recording(acc[:n] * STANDARD_GRAVITY.value, np.radians(gyro[:n]), ("m/s^2", "rad/s"), 100.0)
    readings = readings_from(Plan(), [one])
    assert ("placement_parted" in {remark.code for remark in readings.remarks}) is disturbed
    largest = np.abs(gyro[:n, 0] - np.median(gyro[:n, 0])).max()  # deg/s
    assert bool(largest > 4.0) is disturbed
    assert len(readings) == 1


@pytest.mark.parametrize(("lost", "left"), [((0, 0), 3), ((60, 64), 3), ((60, 110), 2)])
def test_rotation_through_a_gap_in_time_is_left_out_where_the_gap_matters(lost: tuple[int, int], left: int) -> None:
    """Four rests of 5 s with quarter turns of 2 s between them; of the second turn samples never came."""
    rng, rest, turn, rate = np.random.default_rng(1), 500, 200, 100.0
    speed = np.concatenate(
        [np.r_[np.zeros(rest), np.pi / 4.0 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, turn)))]] * 3
    )
    speed = np.r_[speed, np.zeros(rest)]
    angle = np.cumsum(speed) / rate
    force = 9.8 * np.column_stack([np.cos(angle), -np.sin(angle), np.zeros(len(angle))])
    gyro = np.column_stack([np.zeros((len(angle), 2)), speed])
    time = np.arange(len(angle)) / rate
    there = np.ones(len(angle), dtype=bool)
    there[2 * rest + turn + lost[0] : 2 * rest + turn + lost[1]] = False
    noisy = [one + 1e-3 * rng.standard_normal(one.shape) for one in (force, gyro)]
    one = recording(noisy[0][there], noisy[1][there], ("m/s^2", "rad/s"), rate, time[there])
    found = readings_from(Plan(gravity=9.8), [one])
    assert len(found) == 4
    assert len(found.transitions) == left
    assert ("rotation_incomplete" in {remark.code for remark in found.remarks}) == (left < 3)
