"""Faces of a fixture that are askew alike at every use: closed forms of six faces, coverage, what is stated."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.procedures.positions.fit import fixture
from inertialcal.procedures.positions.fit.fixture import ASSUMED, FACE, LAYING
from inertialcal.procedures.positions.reduction import Plan, Readings, Result, Triad, Truth, reduce, simulate
from inertialcal.procedures.positions.simulation import FACES
from inertialcal.statistics.intervals import coverage_factor, covers
from positions_truths import FULL, true_values

G = 9.81
PAIRS = ("xy", "xz", "yx", "yz", "zx", "zy")
DEGREE = np.radians(1.0)
TRUTH = Truth(acc_matrix=FULL, acc_bias=np.array([0.1, -0.2, 0.15]), known=True, acc_between=5e-4)
QUIET = 1e-5  # noise of a mean [m/s^2]


def laid(tilts: Array, repeats: int = 1) -> Readings:
    """Readings of a perfect sensor on faces turned by small rotation vectors, shape (6, 3)."""
    up = np.array([one + np.cross(t, one) for t, one in zip(tilts, FACES, strict=True)])
    up /= np.linalg.norm(up, axis=1)[:, None]
    mean = G * np.tile(up, (repeats, 1))
    mean = mean + QUIET * np.random.default_rng(1).standard_normal(mean.shape)
    triad = Triad(mean, np.full(mean.shape, QUIET), np.ones(mean.shape), "m/s^2")
    return Readings(triad, direction=np.tile(FACES, (repeats, 1)))


def plan(**standards: float) -> Plan:
    return Plan(gravity=G, standards={f"fixture.{name}": Influence(u, "rad") for name, u in standards.items()})


def figures(result: Result) -> dict[str, tuple[float, float]]:
    found = result.estimates["accelerometer"]
    return {str(name): (v, u) for name, v, u in zip(found.names, found.values, found.u, strict=True)}


@pytest.mark.parametrize("repeats", [1, 2])
def test_opposite_faces_show_the_face_error_and_repeats_do_not(repeats: int) -> None:
    """s^2 = 2 mean(r^2), r half the sum of opposite readings across gravity over g; misalignment has s / sqrt 2."""
    tilts = 0.5 * DEGREE * np.random.default_rng(3).standard_normal((6, 3))
    readings = laid(tilts, repeats)
    result = reduce(plan(), readings)
    y = readings.acc.mean[:6]
    bias = np.array([0.5 * (y[2 * i, i] + y[2 * i + 1, i]) for i in range(3)])
    r = [0.5 * (y[2 * j, i] + y[2 * j + 1, i]) - bias[i] for i in range(3) for j in range(3) if i != j]
    sigma = np.sqrt(2.0 * np.mean(np.square(r))) / G
    (row,) = (row for row in result.rows() if row.quantity == "face_error")
    assert row.value == pytest.approx(sigma, rel=0.01)
    assert row.dof == pytest.approx(6.0, rel=0.05)
    found = result.estimates["accelerometer"]
    for pair in PAIRS:
        k = found.index(f"misalignment_{pair}")
        assert found.u[k] == pytest.approx(sigma / np.sqrt(2.0), rel=0.02)
        assert found.dof[k] == pytest.approx(6.0, rel=0.1)


def test_the_cosine_is_taken_off_the_scale_factor() -> None:
    """All tilts alike in size: each axis reads too little by the cosine, which the faces show on average."""
    errors = []
    for seed in range(20):
        tilts = DEGREE * np.random.default_rng(seed).standard_normal((6, 3))
        errors += [figures(reduce(plan(), laid(tilts)))[f"scale_factor_error_{axis}"][0] for axis in "xyz"]
    assert np.mean(errors) == pytest.approx(0.0, abs=0.4 * DEGREE**2)  # without: - DEGREE^2


@pytest.mark.parametrize(("stated", "repeats"), [(False, 1), (False, 2), (True, 2)])
def test_intervals_hold_the_truth(stated: bool, repeats: int) -> None:
    hits: Counter[str] = Counter()
    truth, own = replace(TRUTH, directions=np.tile(FACES, (repeats, 1))), plan(orientation=0.5 * DEGREE)
    n = 15
    for seed in range(1, n + 1):
        readings = replace(simulate(own, truth, np.random.default_rng(seed)), gyro=None, rotations=())
        found = reduce(own if stated else plan(), readings).estimates["accelerometer"]
        true = true_values(truth, "accelerometer")
        for name, value, u, dof in zip(found.names, found.values, found.u, found.dof, strict=True):
            hits[str(name).partition("_")[0]] += abs(value - true[str(name)]) <= coverage_factor(float(dof)) * u
    assert {name: hits[name] for name in hits if not covers(hits[name], n * {"misalignment": 6}.get(name, 3))} == {}


def test_faces_laid_once_take_the_scatter_along_gravity_from_the_noise_inside() -> None:
    result = reduce(
        plan(orientation=0.02 * DEGREE), laid(0.02 * DEGREE * np.random.default_rng(2).standard_normal((6, 3)))
    )
    (remark,) = (one for one in result.remarks if one.code == "scatter_not_judged")
    assert "3 times the noise inside" in remark.what
    expected = np.sqrt((1.0 + ASSUMED**2) / 2.0) * QUIET
    assert figures(result)["scale_factor_error_x"][1] == pytest.approx(expected / G, rel=0.1)
    again = reduce(plan(orientation=0.1 * DEGREE), laid(np.zeros((6, 3)), 2))
    assert not [one for one in again.remarks if one.code == "scatter_not_judged"]


def test_noise_that_nobody_knows_is_bounded_by_all_residuals() -> None:
    readings = laid(0.1 * DEGREE * np.random.default_rng(2).standard_normal((6, 3)))
    readings = replace(readings, acc=replace(readings.acc, scatter=np.zeros((6, 3))))
    result = reduce(plan(), readings)
    (row,) = (row for row in result.rows() if row.quantity == "face_error")
    assert row.value is not None
    assert figures(result)["bias_x"][1] == pytest.approx(G * row.value / 2.0, rel=0.1)


def test_what_is_stated_is_taken_as_stated_unless_the_faces_contradict_it() -> None:
    tilts = 0.5 * DEGREE * np.random.default_rng(3).standard_normal((6, 3))
    right, small = (reduce(plan(orientation=u * DEGREE), laid(tilts, 2)) for u in (0.5, 0.05))
    assert figures(right)["misalignment_xy"][1] == pytest.approx(0.5 * DEGREE / np.sqrt(2.0), rel=0.02)
    assert not [row for row in right.rows() if row.quantity == "face_error"]
    assert "face_error_disagrees" not in {one.code for one in right.remarks}
    assert "face_error_disagrees" in {one.code for one in small.remarks}
    assert figures(small)["misalignment_xy"] == figures(reduce(plan(), laid(tilts, 2)))["misalignment_xy"]


def test_a_larger_face_error_is_looked_for_wherever_it_would_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The slope of the likelihood at the stated error decides as the fit that finds the error does."""
    given = [
        (plan(orientation=size * DEGREE, **more), laid(0.5 * DEGREE * rng.standard_normal((6, 3)), repeats))
        for size in (0.05, 0.15, 0.25, 0.3, 0.35, 0.5, 2.0)
        for repeats, more in ((1, {}), (2, {}), (3, {"repeatability": 0.01 * DEGREE}))
        for rng in map(np.random.default_rng, range(3))
    ]
    quick = [reduce(*one) for one in given]
    monkeypatch.setattr(fixture, "_may_be_larger", lambda laid, faces: True)
    always = [reduce(*one) for one in given]
    assert [figures(one) for one in quick] == [figures(one) for one in always]
    told = [{one.code for one in result.remarks} for result in always]
    assert [{one.code for one in result.remarks} for result in quick] == told
    contradicted = ["face_error_disagrees" in codes for codes in told]
    assert 0 < sum(contradicted) < len(contradicted)


def test_a_laying_repeats_as_well_as_is_stated_or_found() -> None:
    rng = np.random.default_rng(5)
    readings = laid(np.zeros((6, 3)), 4)
    away = DEGREE * rng.standard_normal((24, 3))
    mean = readings.acc.mean + G * np.cross(away, np.tile(FACES, (4, 1)))
    readings = replace(readings, acc=replace(readings.acc, mean=mean))
    found = reduce(plan(), readings)
    (row,) = (row for row in found.rows() if row.quantity == "scatter_laying")
    assert row.value == pytest.approx(DEGREE, rel=0.3)
    stated = reduce(plan(orientation=1e-5, repeatability=DEGREE), readings)
    assert {one.origin.what for one in stated.estimates["accelerometer"].components} >= {FACE, LAYING}
    assert figures(stated)["misalignment_xy"][1] == pytest.approx(DEGREE / np.sqrt(8.0), rel=0.05)


def test_more_orientations_judge_the_faces_better() -> None:
    edges = np.array([[a, b, 0.0] for a in (1, -1) for b in (1, -1)]) / np.sqrt(2.0)
    directions = np.vstack([FACES, edges, np.roll(edges, 1, axis=1), np.roll(edges, 2, axis=1)])
    truth = replace(TRUTH, directions=directions)
    readings = simulate(plan(orientation=0.5 * DEGREE), truth, np.random.default_rng(1))
    result = reduce(plan(), replace(readings, gyro=None, rotations=()))
    (row,) = (row for row in result.rows() if row.quantity == "face_error")
    assert row.dof is not None
    assert row.dof > 20.0
    assert row.value == pytest.approx(0.5 * DEGREE, rel=0.3)
    assert "scatter_not_judged" not in {one.code for one in result.remarks}


def test_one_position_that_does_not_repeat_is_left_out() -> None:
    readings = laid(0.5 * DEGREE * np.random.default_rng(3).standard_normal((6, 3)), 3)
    mean = readings.acc.mean.copy()
    mean[9] += [0.0, 0.0, 0.3]
    result = reduce(plan(), replace(readings, acc=replace(readings.acc, mean=mean)))
    assert np.flatnonzero(result.acc.outliers).tolist() == [9]


@pytest.mark.parametrize("stated", ["orientation", "repeatability"])
def test_errors_of_the_faces_are_stated_of_the_positions_that_are_kept(stated: str) -> None:
    """One bad laying of a face changes the figures by little, and the face error that is stated stays in their u."""
    readings = laid(0.1 * DEGREE * np.random.default_rng(3).standard_normal((6, 3)), 3)
    mean = readings.acc.mean.copy()
    mean[9] += [0.0, 0.0, 0.3]
    own = plan(**{stated: 0.1 * DEGREE})
    spoiled = reduce(own, replace(readings, acc=replace(readings.acc, mean=mean)))
    assert np.flatnonzero(spoiled.acc.outliers).tolist() == [9]
    clean = figures(reduce(own, readings))
    for name, (value, u) in figures(spoiled).items():
        assert value == pytest.approx(clean[name][0], abs=u), name
        assert u == pytest.approx(clean[name][1], rel=0.3), name


def test_what_a_tilt_does_to_misalignment_it_does_to_the_bias_by_its_cosine() -> None:
    """Both faces of an axis tilted by s + d and s - d: misalignment is off by d, the bias by - g s d."""
    s, d = 0.5 * DEGREE, 0.3 * DEGREE
    tilts = np.zeros((6, 3))
    tilts[4, 1], tilts[5, 1] = s + d, -(s - d)  # z+ and z- about y: x feels g (s + d), g (s - d)
    result = reduce(plan(orientation=0.5 * DEGREE), laid(tilts))
    found = result.estimates["accelerometer"]
    wrong = {name: float(found.values[found.index(name)]) for name in ("misalignment_xz", "bias_z")}
    assert wrong == pytest.approx({"misalignment_xz": d, "bias_z": -G * s * d}, rel=0.05)
    a, b = found.index("misalignment_xz"), found.index("bias_z")
    slope = found.covariance[a, b] / found.covariance[a, a]
    assert slope == pytest.approx(-G * s, rel=0.1)
