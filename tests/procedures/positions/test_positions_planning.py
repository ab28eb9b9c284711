"""Planning of positions: against simulation, brute force, and what no positions tell."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from inertialcal.core.errors import PlanError
from inertialcal.procedures.positions.batch import positions_batch
from inertialcal.procedures.positions.planning.design import (
    Setup,
    course,
    cube,
    equations,
    next_position,
    parameter_names,
    predict_uncertainty,
    sphere,
)

G = 9.8
FACES = cube()[:6]
PAIRS = [(i, j) for i in range(3) for j in range(3) if i != j]
SETUP = Setup(scatter=2e-3, gravity=G)
KNOWN = Setup(scatter=2e-3, known=True, pose=1e-3, gravity=G)


def test_candidates_are_the_faces_edges_and_corners() -> None:
    assert cube().shape == (26, 3)
    np.testing.assert_allclose(np.linalg.norm(cube(), axis=1), 1.0)
    assert len({tuple(np.round(one, 9)) for one in cube()}) == 26
    assert {tuple(one) for one in FACES} == {tuple(s * e) for e in np.eye(3) for s in (1.0, -1.0)}
    assert np.max(np.abs(sphere(500).mean(axis=0))) < 0.01


def test_prediction_is_the_scatter_of_simulated_fits() -> None:
    rng = np.random.default_rng(1)
    r = G * cube() + rng.normal(0.0, SETUP.scatter, (4000, 26, 3))
    found = positions_batch(r, G)
    determined = predict_uncertainty(SETUP, cube())
    assert determined.names == found.names
    np.testing.assert_allclose(np.std(found.values, axis=0) / determined.u, 1.0, atol=0.05)
    own = positions_batch(r[:1], G, scatter=SETUP.scatter)
    np.testing.assert_allclose(own.u[0] / determined.u, 1.0, atol=0.01)


def test_prediction_with_known_positions_holds_the_error_of_each() -> None:
    rng = np.random.default_rng(2)
    n = 4000
    away = rng.normal(0.0, KNOWN.pose, (n, 26, 3))
    f = G * (cube() + np.cross(away, np.broadcast_to(cube(), away.shape)))
    read = f + rng.normal(0.0, KNOWN.scatter, f.shape)
    determined = predict_uncertainty(KNOWN, cube())
    across = np.sqrt(KNOWN.scatter**2 + (G * KNOWN.pose) ** 2 * (1.0 - cube() ** 2))  # along gravity no error
    design = np.column_stack([np.ones(26), G * cube()])
    lines = []
    for i in range(3):
        heavy = design / across[:, i, None]
        lines.append(np.linalg.pinv(heavy) @ (read[:, :, i] / across[:, i]).T)
    entries = np.array(lines)  # sensor, (b, M_i0, M_i1, M_i2), unit
    found = [*(entries[i, 1 + i] for i in range(3)), *(entries[i, 1 + j] for i, j in PAIRS), *entries[:, 0]]
    np.testing.assert_allclose(np.std(found, axis=1) / determined.u, 1.0, atol=0.05)


def test_six_faces_and_the_size_of_gravity_tell_six_of_nine() -> None:
    found = predict_uncertainty(SETUP, FACES)
    assert (found.rank, found.count) == (6, 9)
    lost = {name for name, u in zip(found.names, found.u, strict=True) if np.isinf(u)}
    assert lost == {"misalignment_yx", "misalignment_zx", "misalignment_zy"}
    assert len(found.undetermined) == 3
    assert np.isnan(found.covariance[3:6]).all()
    assert predict_uncertainty(KNOWN, FACES).rank == 12
    assert predict_uncertainty(SETUP, np.vstack([FACES, cube()[6:18]])).rank == 9


def test_six_faces_by_hand() -> None:
    """Two readings of opposite sign a sensor: half sum and half difference."""
    found = predict_uncertainty(SETUP, FACES)
    np.testing.assert_allclose(found.u[:3], SETUP.scatter / np.sqrt(2.0) / G)
    np.testing.assert_allclose(found.u[6:], SETUP.scatter / np.sqrt(2.0))


def test_error_of_gravity_is_common_and_stays() -> None:
    free = Setup(scatter=2e-3, gravity=G, gravity_u=1e-3)
    with_it, without = predict_uncertainty(free, cube()), predict_uncertainty(SETUP, cube())
    np.testing.assert_allclose(with_it.u[:3] ** 2 - without.u[:3] ** 2, (1e-3 / G) ** 2)
    np.testing.assert_allclose(with_it.u[3:], without.u[3:])
    assert with_it.covariance[0, 1] - without.covariance[0, 1] == pytest.approx((1e-3 / G) ** 2)
    with pytest.raises(PlanError, match="cannot be known better than"):
        course(free, {"scale_factor_error": 1e-4})


@pytest.mark.parametrize("setup", [SETUP, KNOWN])
def test_next_position_is_the_best_of_all(setup: Setup) -> None:
    taken = np.vstack([FACES, cube()[6:15]]) if not setup.known else cube()[:7]
    names = parameter_names(setup.known)
    unit = np.ones(len(names))
    unit[-3:] = G

    def score(extra: np.ndarray, goal: str) -> float:
        rows, deviations = equations(setup, *np.unique(np.vstack([taken, extra]), axis=0, return_counts=True))
        flat = (rows / deviations[..., None]).reshape(-1, len(names))
        inverse = np.linalg.inv(flat.T @ flat)
        if goal == "determinant":
            return float(np.linalg.slogdet(inverse)[1])
        return float(np.trace(inverse) if goal == "trace" else inverse[names.index(goal), names.index(goal)])

    for goal in ("determinant", "trace", "misalignment_zy", "bias_x"):
        chosen = next_position(setup, taken, goal=goal)
        best = min(score(one, goal) for one in cube())
        assert score(chosen, goal) == pytest.approx(best, rel=1e-6, abs=1e-6)


def test_after_six_faces_the_next_positions_tell_the_misalignments() -> None:
    taken = FACES
    for _ in range(3):
        taken = np.vstack([taken, next_position(SETUP, taken)])
    assert predict_uncertainty(SETUP, taken).rank == 9


def test_nine_positions_one_by_one_are_near_the_best_nine() -> None:
    """Against all sets of nine of a dozen candidates."""
    candidates = np.vstack([FACES, cube()[[6, 9, 10, 13, 14, 17]]])
    found = np.empty((0, 3))
    for _ in range(9):
        found = np.vstack([found, next_position(SETUP, found, candidates)])

    def volume(chosen: np.ndarray) -> float:
        rows = equations(SETUP, chosen)[0][:, 0]
        return float(np.linalg.slogdet(rows.T @ rows)[1])

    best = max(volume(candidates[list(one)]) for one in combinations(range(12), 9))
    assert volume(found) > best - 9 * 0.15  # the root of nine: within 15 % a parameter


@pytest.mark.parametrize("setup", [SETUP, KNOWN])
def test_course_meets_its_target_and_no_position_is_idle(setup: Setup) -> None:
    target = {"scale_factor_error": 1.2e-4, "bias": 1.2e-3, "misalignment_yx": 4e-4}
    found = course(setup, target)
    limits = [target.get(n, target.get(n.rsplit("_", 1)[0], np.inf)) for n in found.prediction.names]
    assert np.all(found.prediction.u <= limits)
    fewer = predict_uncertainty(setup, found.directions[:-1])
    assert np.any(fewer.u > limits)
    half = course(Setup(setup.scatter / 2, setup.known, setup.pose, G), target)
    assert len(half.directions) <= len(found.directions)
    begun = course(setup, target, directions=FACES)
    np.testing.assert_array_equal(begun.directions[:6], FACES)


def test_a_target_out_of_reach_says_what_stands_in_the_way() -> None:
    with pytest.raises(PlanError, match="after 12 positions") as caught:
        course(SETUP, {"bias": 1e-5}, most=12)
    assert caught.value.problems[0].code == "target_not_reached"
    with pytest.raises(PlanError, match="the candidates do not determine"):
        course(SETUP, {"misalignment": 1e-3}, candidates=FACES, most=12)


def test_what_cannot_be_meant_is_refused() -> None:
    with pytest.raises(PlanError, match="scatter -1"):
        Setup(scatter=-1)
    with pytest.raises(PlanError, match="pose nan"):
        Setup(scatter=1.0, pose=float("nan"))
    with pytest.raises(PlanError, match="no position"):
        predict_uncertainty(SETUP, np.empty((0, 3)))
    with pytest.raises(PlanError, match="goal 'best'"):
        next_position(SETUP, FACES, goal="best")
    for target in ({"drift": 1.0}, {"bias": -1.0}, {}):
        with pytest.raises(PlanError, match="target"):
            course(SETUP, target)


def test_a_known_direction_that_is_laid_again_is_off_alike() -> None:
    """Six faces, n times: misalignment keeps pose / sqrt 2, bias falls with the root of n; another direction helps."""
    setup = replace(SETUP, known=True, pose=0.01)
    faces = np.vstack([np.eye(3), -np.eye(3)])
    once, often = (predict_uncertainty(setup, np.tile(faces, (n, 1))) for n in (1, 100))
    at = {name: k for k, name in enumerate(once.names)}
    assert often.u[at["misalignment_xy"]] == pytest.approx(0.01 / np.sqrt(2.0), rel=1e-3)
    assert often.u[at["bias_x"]] == pytest.approx(once.u[at["bias_x"]] / 10.0, rel=0.05)
    new = next_position(setup, faces, goal="misalignment_xy")
    assert np.count_nonzero(new) > 1
