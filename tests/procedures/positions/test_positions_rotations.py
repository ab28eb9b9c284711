"""Rotations: attitude in closed form, derivatives against differences, covariances against what they describe."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from inspect import unwrap
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turned

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.procedures.positions.fit._kernels_transitions import through
from inertialcal.procedures.positions.fit.rotations import (
    ANGLE,
    GYRO_NOISE,
    ORIENTATION,
    POSITIONS,
    Packed,
    Problem,
    Rotated,
    angles,
    by_positions,
    by_rest,
    carried,
    carried_along,
    ends_of,
    errors,
    known_errors,
    packed,
    solve,
)
from inertialcal.procedures.positions.reduction import Plan, Rotation

EYE = np.eye(3)
STEP = 1e-5
CLOSE = 2e-6  # of differences over STEP, and of integrals over samples of SECONDS / SAMPLES
SECONDS, SAMPLES, MOVES = 2.0, 1500, 8
W_TRUE = np.array([[1.02, 0.013, -0.007], [-0.011, 0.97, 0.005], [0.004, -0.016, 1.01]])
TURNS = np.pi * np.array([[2.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, -1.0]])
STANDARDS = {ANGLE: Influence(0.002, "rad"), ORIENTATION: Influence(0.003, "rad")}
PLAN = Plan(gravity=9.81, standards=STANDARDS)


def samples(rates: Array, forces: Array, seconds: float = SECONDS) -> Packed:
    """Rotations (k, n, 3) that take equal times."""
    times = np.linspace(0.0, seconds, rates.shape[1])
    parts = [Rotation(times, rate, force, 0, 1) for rate, force in zip(rates, forces, strict=True)]
    return packed(parts, list(rates), list(forces))


def moved(z: Array, f: Array, up: Array) -> Problem:
    """Transitions from each position to the next, and turns, by readings z of both."""
    moves = [Rotation(np.zeros(1), z[0], f[0], k, k + 1) for k in range(MOVES)]
    last = z.shape[1]
    shape = (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, last))) / SECONDS
    turns = TURNS[:, None, :] * shape[:, None] @ np.linalg.inv(W_TRUE).T
    return Problem(
        samples(z, f), ends_of(moves, up), samples(turns, f[: len(TURNS)]), TURNS,
        np.array([1e-4, 2e-4, 3e-4]), np.linspace(1.0, 2.0, MOVES + 1) * 1e-8,
    )  # fmt: skip


def smooth(seed: int) -> tuple[Array, Array]:
    """Rates that begin and end at rest and turn by radians, and forces, each (MOVES, SAMPLES, 3)."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    waves = np.sin(np.pi * t * np.arange(1, 4)) ** 2  # (SAMPLES, 3)
    rates = waves @ rng.normal(0.0, 1.0, (MOVES, 3, 3))
    forces = 9.81 * np.array([1.0, 0.0, 0.0]) + waves @ rng.normal(0.0, 5.0, (MOVES, 3, 3))
    return rates, forces


@pytest.fixture(scope="module")
def readings() -> tuple[Array, Array, Array]:
    """z, f and the unit vectors of positions that the true W carries into one another."""
    rates, forces = smooth(1)
    z = rates @ np.linalg.inv(W_TRUE).T
    C = carried(samples(z, forces), W_TRUE[None])[0]
    up = [np.array([0.48, -0.6, 0.64])]
    for one in C:
        up.append(one @ up[-1])
    return z, forces, np.array(up)


@pytest.fixture(scope="module")
def problem(readings: tuple[Array, Array, Array]) -> Problem:
    return moved(*readings)


@pytest.fixture(scope="module")
def solved(problem: Problem) -> Rotated:
    return solve(PLAN, problem, EYE)


def differences(value: Callable[[Array], Array], size: int, step: float = STEP) -> Array:
    """Derivatives of a function by each of ``size`` numbers at zero, as last axis."""
    columns = []
    for k in range(size):
        change = np.zeros(size)
        change[k] = step
        columns.append((value(change) - value(-change)) / (2.0 * step))
    return np.stack(columns, axis=-1)


def shifted(problem: Problem, rest: Array) -> Problem:
    """The same rotations with other bias and g-sensitivity taken off."""
    b, G = rest[:3], rest[3:].reshape(3, 3)
    both = [replace(part, z=part.z - b - part.f @ G.T) for part in (problem.moves, problem.turns)]
    return replace(problem, moves=both[0], turns=both[1])


def laid(readings: tuple[Array, Array, Array], change: Array) -> Problem:
    """The same rotations with other unit vectors of the positions."""
    z, f, up = readings
    up = up + change.reshape(up.shape)
    return moved(z, f, up / np.linalg.norm(up, axis=1)[:, None])


def across_all(up: Array) -> Array:
    """Projector that takes from a change of unit vectors what is along them, (3 m, 3 m)."""
    m = len(up)
    found = np.zeros((3 * m, 3 * m))
    for k, u in enumerate(up):
        found[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = EYE - np.outer(u, u)
    return found


class TestAttitude:
    @pytest.mark.parametrize("angle", [1e-9, 0.3, 3.0, 20.0], ids=["nearly none", "some", "half", "many"])
    @pytest.mark.parametrize("count", [4, 200], ids=["long steps", "short steps"])
    def test_a_constant_rate_turns_by_its_angle(self, angle: float, count: int) -> None:
        axis = np.array([2.0, -3.0, 6.0]) / 7.0
        rate = np.tile(angle / SECONDS * axis, (1, count, 1))
        C = carried(samples(rate, rate), EYE[None])[0][0]
        body = Turned.from_rotvec(angle * axis)  # the body turns so, what is fixed in space the other way
        assert pytest.approx(body.inv().as_matrix(), abs=1e-13) == C

    def test_turned_about_z_by_a_quarter_x_is_seen_along_minus_y(self) -> None:
        rate = np.tile([0.0, 0.0, 0.5 * np.pi / SECONDS], (1, 50, 1))
        C = carried(samples(rate, rate), EYE[None])[0][0]
        assert pytest.approx([0.0, -1.0, 0.0], abs=1e-14) == C @ [1.0, 0.0, 0.0]

    def test_a_rate_linear_in_time_is_integrated_to_fourth_order(self) -> None:
        """Coning: with half the step the error falls 16 times."""
        low, high = np.array([0.2, -0.4, 0.9]), np.array([-1.0, 0.5, 0.3])
        ends = [
            carried(samples(np.linspace(low, high, n + 1)[None], np.zeros((1, n + 1, 3))), EYE[None])[0][0]
            for n in (8, 16, 4096)
        ]
        wrong = [float(np.abs(one - ends[2]).max()) for one in ends[:2]]
        assert wrong[0] / wrong[1] == pytest.approx(16.0, rel=0.1)

    def test_integrals_over_a_constant_rate(self) -> None:
        """C(end, t) = R(-(T - t) omega): about z the integral of it is sin and 1 - cos over omega."""
        omega, n = 1.5, 2001
        rate = np.tile([0.0, 0.0, omega], (1, n, 1))
        C, found = carried_along(samples(rate, rate), EYE, np.column_stack([np.ones(n), np.linspace(0.0, SECONDS, n)]))
        s, c = np.sin(omega * SECONDS) / omega, (1.0 - np.cos(omega * SECONDS)) / omega
        assert found[0, :, :, 0] == pytest.approx(np.array([[s, c, 0.0], [-c, s, 0.0], [0.0, 0.0, SECONDS]]), abs=1e-6)
        assert found[0, 2, 2, 1] == pytest.approx(0.5 * SECONDS**2)
        late = np.linspace(0.0, SECONDS, n) * np.sin(omega * (SECONDS - np.linspace(0.0, SECONDS, n)))
        assert found[0, 0, 1, 1] == pytest.approx(np.trapezoid(late, dx=SECONDS / (n - 1)), abs=1e-9)
        assert carried(samples(rate, rate), EYE[None])[0] == pytest.approx(C, abs=1e-15)

    def test_rotations_do_not_look_at_one_another(self, problem: Problem) -> None:
        moves = problem.moves
        whole = carried_along(moves, W_TRUE, moves.f)
        a, b = moves.first[3], moves.first[4]
        alone = Packed(moves.z[a:b], moves.f[a:b], moves.h[a:b], np.array([0, b - a]))
        for one, other in zip(whole, carried_along(alone, W_TRUE, alone.f), strict=True):
            assert one[3] == pytest.approx(other[0], abs=1e-13)

    def test_kernel_with_and_without_the_compiler(self, problem: Problem) -> None:
        first = np.array([0, 40, 41, 41, 90])
        w = np.ascontiguousarray(problem.moves.z[:90] * np.where(np.arange(90) < 60, 1.0, 300.0)[:, None])
        outs = [(np.empty((2, 4, 3, 3)), np.empty((2, 4, 3, 3, 3))) for _ in range(2)]
        W, bias, G = np.stack([EYE, W_TRUE]), np.array([[0.0] * 3, [0.1, 0.2, 0.3]]), np.stack([0.0 * EYE, 0.1 * EYE])
        kernels: list[Any] = [through, unwrap(through)]
        for one, out in zip(kernels, outs, strict=True):
            one(w, w, problem.moves.h[:90], first, W, bias, G, w, *out)
        for compiled, plain in zip(*outs, strict=True):
            assert compiled == pytest.approx(plain, abs=1e-12)
        ends = outs[0][0]
        assert ends @ ends.swapaxes(2, 3) == pytest.approx(np.tile(EYE, (2, 4, 1, 1)), abs=1e-12)
        samples = Packed((w - bias[1] - w @ G[1].T) @ W[1].T, w, problem.moves.h[:90], first)
        assert ends[1] == pytest.approx(carried(samples, EYE[None])[0], abs=1e-12)

    def test_a_rotation_without_samples_turns_nothing(self) -> None:
        none = np.empty((0, 3))
        parts = [Rotation(np.empty(0), none, none, 0, 1), Rotation(np.arange(2.0), EYE[:2], EYE[:2], 1, 2)]
        found = packed(parts, [none, EYE[:2]], [none, EYE[:2]])
        assert carried_along(found, EYE, found.f)[0][0] == pytest.approx(EYE)
        assert found.squares.tolist() == [0.0, 1.0]


class TestErrors:
    def test_nothing_is_left_at_the_truth(self, problem: Problem) -> None:
        assert errors(problem, W_TRUE).e == pytest.approx(0.0, abs=1e-12)
        assert angles(problem, W_TRUE) == pytest.approx(0.0, abs=1e-7)

    def test_angles_are_those_by_which_gravity_is_missed(self, problem: Problem) -> None:
        e = errors(problem, W_TRUE + 1e-3).e[: 2 * MOVES].reshape(-1, 2)
        assert angles(problem, W_TRUE + 1e-3) == pytest.approx(np.hypot(*e.T), rel=1e-4)

    def test_an_arrival_ahead_along_an_axis_is_a_positive_error(self, problem: Problem) -> None:
        ends = problem.ends
        C = carried(problem.moves, W_TRUE[None])[0]
        off = replace(problem, ends=replace(ends, start=ends.start + np.linalg.inv(C)
                                            @ ends.across[:, 0, :, None] @ [1e-3]))  # fmt: skip
        found = errors(off, W_TRUE).e[: 2 * MOVES].reshape(-1, 2)
        assert found == pytest.approx(np.tile([1e-3, 0.0], (MOVES, 1)), abs=1e-9)

    @pytest.mark.parametrize("W", [EYE, W_TRUE], ids=["start", "truth"])
    def test_derivatives_by_the_matrix(self, problem: Problem, W: Array) -> None:
        found = differences(lambda change: errors(problem, W + change.reshape(3, 3)).e, 9)
        assert errors(problem, W).by_W == pytest.approx(found, abs=CLOSE)

    @pytest.mark.parametrize("W", [EYE, W_TRUE], ids=["start", "truth"])
    def test_derivatives_by_bias_and_g_sensitivity(self, problem: Problem, W: Array) -> None:
        found = differences(lambda change: errors(shifted(problem, change), W).e, 12, 1e-6)
        assert by_rest(problem, W) == pytest.approx(found, abs=10.0 * CLOSE)

    def test_derivatives_by_the_start(self, problem: Problem) -> None:
        ends = problem.ends

        def at(change: Array) -> Array:
            return errors(replace(problem, ends=replace(ends, start=ends.start + change)), EYE).e[: 2 * MOVES]

        assert errors(problem, EYE).by_start == pytest.approx(differences(at, 3), abs=1e-9)

    def test_derivatives_by_all_positions(self, problem: Problem, readings: tuple[Array, Array, Array]) -> None:
        up = readings[2]
        found = differences(lambda change: errors(laid(readings, change), W_TRUE).e, up.size)
        wide = by_positions(problem, errors(problem, W_TRUE).by_start).reshape(-1, up.size)
        assert wide @ across_all(up) == pytest.approx(found, abs=1e-8)


class TestKnown:
    def test_errors_of_a_position_are_in_the_rotations_to_it_and_from_it(
        self, problem: Problem, readings: tuple[Array, Array, Array]
    ) -> None:
        up = readings[2]
        by_up = differences(lambda change: errors(laid(readings, change), W_TRUE).e, up.size)
        expected = by_up * np.repeat(problem.up_variance, 3) @ by_up.T
        found = known_errors(PLAN, problem, errors(problem, W_TRUE).by_start)[POSITIONS]
        assert found == pytest.approx(expected, abs=1e-15)
        assert np.linalg.norm(expected[:2, 2:4]) > 0.5e-8  # neighbours share a position
        assert expected[:2, 4:6] == pytest.approx(0.0, abs=1e-15)

    def test_noise_of_the_gyros_is_that_of_an_integral(self, problem: Problem) -> None:
        found = known_errors(PLAN, problem, errors(problem, W_TRUE).by_start)[GYRO_NOISE]
        step = SECONDS / (SAMPLES - 1)
        assert found == pytest.approx(np.mean(problem.noise**2) * SECONDS * step, rel=1e-9)
        assert len(found) == 2 * MOVES + 3 * len(TURNS)

    def test_angle_is_uncertain_along_a_turn_and_orientation_across(self, problem: Problem) -> None:
        known = known_errors(PLAN, problem, errors(problem, W_TRUE).by_start)
        first = 2 * MOVES
        for row, vector in enumerate(TURNS):
            at = slice(first + 3 * row, first + 3 * row + 3)
            axis, size = np.abs(np.sign(vector)), float(np.linalg.norm(vector))
            assert known[ANGLE][at, at] == pytest.approx(0.002**2 * np.diag(axis))
            assert known[ORIENTATION][at, at] == pytest.approx((0.003 * size) ** 2 * np.diag(1.0 - axis))
            known[ANGLE][at, at] = 0.0
        assert not known[ANGLE].any()
        again = known[ORIENTATION][first + 6 : first + 9, first + 9 : first + 12]  # 2 pi and - pi about one axis
        assert again == pytest.approx(0.003**2 * -2.0 * np.pi**2 * np.diag([1.0, 1.0, 0.0]))
        assert not known[ORIENTATION][first : first + 3, first + 3 :].any()
        assert set(known_errors(Plan(), problem, errors(problem, W_TRUE).by_start)) == {GYRO_NOISE, POSITIONS}


class TestSolved:
    def test_the_truth_is_found(self, solved: Rotated) -> None:
        assert pytest.approx(W_TRUE, abs=1e-10) == solved.W
        assert not solved.outliers.any()

    def test_what_bias_and_g_sensitivity_do_to_the_matrix(self, problem: Problem, solved: Rotated) -> None:
        found = differences(lambda change: solve(PLAN, shifted(problem, change), W_TRUE).W.ravel(), 12, 1e-7)
        assert solved.by_rest == pytest.approx(found, abs=2e-5 * np.abs(found).max())

    def test_what_the_positions_do_to_the_matrix(self, readings: tuple[Array, Array, Array], solved: Rotated) -> None:
        up = readings[2]
        found = differences(lambda change: solve(PLAN, laid(readings, change), W_TRUE).W.ravel(), up.size)
        whole = solved.by_positions.reshape(9, -1) @ across_all(up)
        assert whole == pytest.approx(found, abs=1e-4 * np.abs(found).max())

    def test_one_rotation_that_is_wrong_is_left_out_and_its_error_told(self, problem: Problem) -> None:
        rng = np.random.default_rng(3)
        noise = rng.normal(0.0, 2e-4, problem.moves.z.shape)
        noisy = replace(problem, moves=replace(problem.moves, z=problem.moves.z + noise))
        turned = noisy.turned.copy()
        turned[1] += [0.0, 0.3, 0.0]  # it turned by less than was said
        plan = replace(PLAN, standards={})
        found = solve(plan, replace(noisy, turned=turned), EYE)
        assert np.flatnonzero(found.outliers).tolist() == [MOVES + 1]
        assert found.residuals[2 * MOVES + 4] == pytest.approx(-0.3, abs=1e-3)
        clean = solve(plan, noisy, EYE)
        assert not clean.outliers.any()
        assert pytest.approx(W_TRUE, abs=1e-3) == clean.W
        leverage = 1.0 - (clean.residuals / clean.deletion)[2 * MOVES :]
        assert np.all((leverage > 0.0) & (leverage < 1.0))  # a row pulls the fit towards itself

    def test_no_rotations(self, problem: Problem) -> None:
        none = packed([], [], [])
        empty = replace(problem, moves=none, turns=none, turned=np.zeros((0, 3)))
        with pytest.raises(DataError, match="at rest, gyros show only their bias") as error:
            solve(PLAN, empty, EYE)
        assert error.value.problems[0].code == "no_rotations"
