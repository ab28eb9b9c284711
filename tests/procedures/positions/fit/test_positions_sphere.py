"""|f| = g: lengths and their derivatives against differences, the search against the truth, one plane refused."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.procedures.positions.fit._kernels_sphere import fill_sizes, shortest
from inertialcal.procedures.positions.fit.accelerometer import (
    NAMES,
    check_plane,
    converged,
    determined_forward,
    forward,
    lengths,
    nominal,
    parts,
    variances,
)
from inertialcal.procedures.positions.fit.linear_sensor import BIAS, MATRIX, decomposed, observe_many, told_by

G = 9.80
STEP = 1e-5
T_TRUE = np.array([[1.03, 0.0, 0.0], [0.02, 0.98, 0.0], [-0.03, 0.015, 1.01]])
B_TRUE = np.array([0.3, -0.2, 0.1])  # m/s2
THETA = np.concatenate([G * T_TRUE[np.tril_indices(3)], B_TRUE])


@pytest.fixture(scope="module")
def readings() -> Array:
    f = np.random.default_rng(1).normal(size=(20, 3))
    f *= G / np.linalg.norm(f, axis=1)[:, None]
    return np.asarray(f @ np.linalg.inv(T_TRUE).T + B_TRUE)


def differences(value: object, at: Array) -> Array:
    assert callable(value)
    away = STEP * np.eye(len(at))
    return np.stack([(value(at + one) - value(at - one)) / (2.0 * STEP) for one in away], axis=-1)


def test_parameters_are_the_lower_triangle_in_units_of_gravity_then_the_bias() -> None:
    T, b = parts(THETA, G)
    assert pytest.approx(T_TRUE) == T
    assert b == pytest.approx(B_TRUE)
    assert parts(nominal(G), G)[0] == pytest.approx(np.eye(3))
    assert tuple(map(str, NAMES[2:5])) == ("scale_factor_error_y", "misalignment_zx", "misalignment_zy")


def test_lengths_at_the_truth_are_those_of_gravity_and_grow_with_a_reading(readings: Array) -> None:
    e, _, u = lengths(THETA, readings, G)
    assert e == pytest.approx(0.0, abs=1e-12)
    assert u == pytest.approx((readings - B_TRUE) @ T_TRUE.T / G)
    longer = readings + 1e-3 * u @ np.linalg.inv(T_TRUE).T
    assert lengths(THETA, longer, G)[0] == pytest.approx(1e-3)


def test_derivatives_of_the_lengths(readings: Array) -> None:
    for theta in (THETA, nominal(G)):
        found = differences(lambda at: lengths(at, readings, G)[0], theta)
        assert lengths(theta, readings, G)[1] == pytest.approx(found, abs=1e-8)


def test_variance_of_a_length_is_that_of_the_reading_along_it(readings: Array) -> None:
    inside = np.array([1e-4, 4e-4, 9e-4]) * np.ones((20, 1))
    by_reading = np.stack(
        [(lengths(THETA, readings + STEP * one, G)[0] - lengths(THETA, readings - STEP * one, G)[0]) / (2.0 * STEP)
         for one in np.eye(3)], axis=1)  # fmt: skip
    u = lengths(THETA, readings, G)[2]
    assert variances(THETA, u, inside, G) == pytest.approx(np.sum(by_reading**2 * inside, axis=1), rel=1e-6)


def test_the_sensor_equation_and_its_derivatives() -> None:
    values, derivative = forward(THETA, G)
    assert values[:9].reshape(3, 3) @ T_TRUE == pytest.approx(np.eye(3))
    assert values[9:] == pytest.approx(B_TRUE)
    assert derivative == pytest.approx(differences(lambda at: forward(at, G)[0], THETA), abs=1e-8)


@pytest.mark.parametrize("name", [*map(str, NAMES)])
def test_what_is_told_of_the_triangle_is_told_of_the_matrix(name: str) -> None:
    determined = np.array([str(one) == name for one in NAMES])
    assert [str(one) for one, known in zip((*MATRIX, *BIAS), determined_forward(determined), strict=True) if known] == [
        name
    ]


def test_search_ends_at_the_truth_or_leaves_alone_what_is_not_told(readings: Array) -> None:
    everyone = np.ones(20)
    assert converged(readings, G, everyone, nominal(G), 1e-6) == pytest.approx(THETA, abs=1e-9)
    faces = np.vstack([np.eye(3), -np.eye(3)]) * G
    found = converged(faces * [1.02, 0.99, 1.0] + B_TRUE, G, np.ones(6), nominal(G), 0.02)
    assert found == pytest.approx([G / 1.02, 0.0, G / 0.99, 0.0, 0.0, G, *B_TRUE], abs=0.02)


def test_a_position_of_no_weight_moves_nothing(readings: Array) -> None:
    wrong = readings.copy()
    wrong[4] += 1.0
    weight = np.where(np.arange(20) == 4, 0.0, 1.0)
    assert converged(wrong, G, weight, nominal(G), 1e-6) == pytest.approx(THETA, abs=1e-9)


def test_one_plane_is_refused_and_named() -> None:
    angle = np.arange(12) * np.pi / 6.0
    ring = G * np.column_stack([np.cos(angle), 0.02 * np.cos(5.0 * angle), np.sin(angle)])
    with pytest.raises(DataError, match=r"one plane, across [+-]1\.00 y \(") as error:
        check_plane(ring, G)
    assert error.value.problems[0].code == "one_plane"
    check_plane(ring * [1.0, 5.0, 1.0], G)


@pytest.mark.parametrize("rows", [24, 9, 5])
def test_shortest_solution_is_that_of_numpy(rows: int) -> None:
    rng = np.random.default_rng(rows)
    design, readings = rng.normal(size=(rows, 9)) * 0.5 ** np.arange(9.0), rng.normal(size=rows)
    found = np.empty(9)
    shortest(design, readings, 0.02, found)
    np.testing.assert_allclose(found, np.linalg.lstsq(design, readings, rcond=0.02)[0], rtol=1e-10, atol=1e-12)
    with pytest.raises(np.linalg.LinAlgError):
        converged(np.full((rows, 3), np.nan), G, np.ones(rows), nominal(G), 0.02)


def test_bounds_of_singular_values_hold_them_and_tell_what_these_tell() -> None:
    """Well conditioned designs, bad ones, and one of too low a rank; each with a scatter small and large."""
    rng = np.random.default_rng(4)
    designs = rng.normal(size=(40, 12, 9)) * np.linspace(1.0, 0.0, 40)[:, None, None] ** np.arange(9.0)
    sizes = np.empty((40, 2))
    fill_sizes(designs, sizes)
    each = np.linalg.svd(designs, compute_uv=False)
    assert np.all(sizes[:, 0] <= each[:, -1] * (1.0 + 1e-9))
    assert np.all(sizes[:, 1] >= each[:, 0] * (1.0 - 1e-9))
    assert 0 < np.sum(sizes[:, 0] > 0.0) < 40
    for scatter in (1e-6, 0.05):
        own = np.full(40, scatter)
        for one, other in zip(
            observe_many(designs, NAMES, own), told_by(*decomposed(designs), NAMES, own), strict=True
        ):
            assert (one.rank, one.combinations, one.parts) == (other.rank, other.combinations, other.parts)
            np.testing.assert_array_equal(one.determined, other.determined)
            np.testing.assert_allclose(one.kept @ one.kept.T, other.kept @ other.kept.T, atol=1e-12)
