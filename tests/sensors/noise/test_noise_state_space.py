"""State space of terms: Van Loan against closed forms, simulated covariance against the terms' own Allan variance."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, linalg

from inertialcal.core.errors import PlanError
from inertialcal.core.estimate import Array
from inertialcal.sensors.noise.expected import expected_variance
from inertialcal.sensors.noise.state_space import (
    StateSpace,
    bias_state,
    combined,
    discretise,
    flicker_bank,
    state_space,
)
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
)

DT = 0.1  # s
times = st.floats(1e-3, 1e3)


def phase_variance(space: StateSpace, lags: Array) -> Array:
    """Variance of sums of readings from rest, by stepping the covariance of states and sum: no closed form in it."""
    n = len(space.names)
    step = np.zeros((n + 1, n + 1))
    step[:n, :n], step[n, :n], step[n, n] = space.Phi, space.H[0], 1.0
    noise = np.zeros_like(step)
    noise[:n, :n], noise[n, n] = space.Qd, space.R
    P = np.zeros_like(step)
    P[:n, :n] = np.diag(np.where(np.isfinite(space.start), space.start, 0.0))
    found = [0.0]
    for _ in range(int(lags.max())):
        P = step @ P @ step.T + noise
        found.append(P[n, n])
    return np.asarray(np.array(found)[lags.astype(int)], dtype=np.float64)


def allan_of(space: StateSpace, m: Array) -> Array:
    """Allan variance of readings that start at rest: (4 V(m) - V(2m)) / (2 m^2)."""
    return np.asarray((4.0 * phase_variance(space, m) - phase_variance(space, 2 * m)) / (2.0 * m**2))


@pytest.mark.parametrize(
    ("term", "rel"),
    [(RandomWalk(0.3), 1e-9), (GaussMarkov(2.0, 5.0), 0.02), (Quantization(0.02), 1e-9)],
)
def test_readings_have_the_allan_variance_of_the_term(term: Term, rel: float) -> None:
    """Values of what wanders, not means over dt: 1 + 1 / (2 m^2) times the variance, (2 m^2 + 1) / (6 m) for m / 3."""
    m = np.array([1, 2, 8, 40, 200])
    instant = 1.0 + 0.5 / m**2 if isinstance(term, GaussMarkov) else 1.0
    assert allan_of(state_space(term, DT), m) == pytest.approx(instant * expected_variance(term, m, DT), rel=rel)


def test_a_simulated_random_walk_of_the_rate_has_its_allan_variance() -> None:
    space = state_space(RateRandomWalk(0.7), DT)
    rng = np.random.default_rng(1)
    x = np.cumsum(rng.normal(0.0, np.sqrt(space.Qd[0, 0]), (3_000, 400)), axis=1)
    means = x.reshape(3_000, 10, 40).mean(axis=2)
    seen = 0.5 * np.mean(np.diff(means, axis=1) ** 2)
    assert seen == pytest.approx(0.7**2 * 4.0 / 3.0, rel=0.04)
    assert np.isinf(space.start[0])


def simulated(space: StateSpace, steps: int, records: int, rng: np.random.Generator) -> Array:
    """Readings of a filter's model, drawn with Phi, Qd, H and R from rest, shape (steps, records)."""
    values, vectors = np.linalg.eigh(space.Qd)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    start = np.where(np.isfinite(space.start), space.start, 0.0)
    state = np.sqrt(start)[:, None] * rng.normal(size=(len(start), records))
    found = np.empty((steps, records))
    for k in range(steps):
        found[k] = space.H[0] @ state
        state = space.Phi @ state + root @ rng.normal(size=state.shape)
    return np.asarray(found + np.sqrt(space.R) * rng.normal(size=found.shape))


def overlapping(x: Array, m: Array) -> Array:
    """Allan variance of all columns together, by its definition."""
    phase = np.concatenate((np.zeros((1, x.shape[1])), np.cumsum(x, axis=0)))
    second = [phase[2 * k :] - 2.0 * phase[k:-k] + phase[: -2 * k] for k in m]
    return np.array([np.mean(d**2) / (2.0 * k**2) for d, k in zip(second, m, strict=True)])


@pytest.mark.parametrize(
    "terms",
    [
        (RandomWalk(0.3), RateRandomWalk(0.05)),
        (RandomWalk(0.3), GaussMarkov(0.5, 3.0)),
        (RandomWalk(0.3), GaussMarkov(0.5, 3.0), RateRandomWalk(0.05), Sinusoid(0.4, 0.37)),
    ],
)
def test_a_simulated_filter_model_has_the_allan_variance_of_its_terms(terms: tuple[Term, ...]) -> None:
    """The integral's steps over dt are the mean rates of a sensor: no approximation is in between."""
    space, m = bias_state(terms, DT), np.array([1, 2, 4, 8, 16, 32, 64])
    angle = simulated(space, 4_001, 200, np.random.default_rng(3))
    seen = overlapping(np.diff(angle, axis=0) / DT, m)
    assert seen == pytest.approx(expected_variance(terms, m, DT), rel=0.03)  # scatter of the last is below 1 %


def test_simulated_readings_have_the_flat_of_bias_instability() -> None:
    """Readings at instants: white noise and a bank whose flat reaches from 10 to 1,000 steps."""
    terms = (RandomWalk(0.05), BiasInstability(0.5))
    space, m = bias_state(terms, DT, integrated=False, flat=(1.0, 100.0)), np.array([20, 40, 80, 160, 320])
    seen = overlapping(simulated(space, 8_000, 100, np.random.default_rng(4)), m)
    assert np.sqrt(seen) == pytest.approx(np.sqrt(expected_variance(terms, m, DT)), rel=0.06)


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), times)
def test_angle_and_bias_have_the_closed_form(N: float, K: float, dt: float) -> None:
    space = bias_state((RandomWalk(N), RateRandomWalk(K)), dt)
    Q = np.array([[N**2 * dt + K**2 * dt**3 / 3.0, K**2 * dt**2 / 2.0], [K**2 * dt**2 / 2.0, K**2 * dt]])
    assert space.Qd == pytest.approx(Q, rel=1e-9)
    assert space.Phi == pytest.approx(np.array([[1.0, dt], [0.0, 1.0]]), rel=1e-12)
    assert space.names == ("integral", "rate_random_walk")
    assert space.R == 0.0


@given(st.floats(1e-2, 1e2), st.floats(1e-2, 1e3), st.floats(1e-3, 1e1))
def test_gauss_markov_steps_have_the_closed_form(sigma: float, time: float, dt: float) -> None:
    space = state_space(GaussMarkov(sigma, time), dt)
    assert space.Phi[0, 0] == pytest.approx(np.exp(-dt / time), rel=1e-9)
    assert space.Qd[0, 0] == pytest.approx(-(sigma**2) * np.expm1(-2.0 * dt / time), rel=1e-9)
    assert space.start[0] == pytest.approx(sigma**2)


def test_a_step_is_the_integral_that_it_stands_for() -> None:
    rng = np.random.default_rng(2)
    F, root = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    Q = root @ root.T
    phi, qd = discretise(F, Q, 0.7)
    direct = integrate.quad_vec(lambda t: linalg.expm(F * t) @ Q @ linalg.expm(F * t).T, 0.0, 0.7)[0]
    assert phi == pytest.approx(linalg.expm(0.7 * F), rel=1e-10)
    assert qd == pytest.approx(direct, rel=1e-8)
    size = len(F)  # the same by Van Loan's block matrix (IEEE Trans. AC-23 (1978) 395)
    block = linalg.expm(0.7 * np.block([[-F, Q], [np.zeros((size, size)), F.T]]))
    assert qd == pytest.approx(block[size:, size:].T @ block[:size, size:], rel=1e-9)
    half, part = discretise(F, Q, 0.35)  # two half steps are one step
    assert half @ part @ half.T + part == pytest.approx(qd, rel=1e-10)


def test_ramp_and_sinusoid_move_without_noise() -> None:
    ramp = state_space(RateRamp(0.2), DT)
    assert (ramp.Phi @ [1.0, 0.2])[0] == pytest.approx(1.0 + 0.2 * DT)
    sine = state_space(Sinusoid(3.0, 2.0), DT)
    state = np.array([0.0, 3.0])
    for _ in range(7):
        state = sine.Phi @ state
    assert float((sine.H @ state)[0]) == pytest.approx(3.0 * np.sin(2.0 * np.pi * 2.0 * 0.7))
    assert not ramp.Qd.any()
    assert not sine.Qd.any()
    assert sine.start.sum() == pytest.approx(9.0)


@pytest.mark.parametrize("decades", [1, 2, 3, 4])
def test_gauss_markov_states_hold_the_flat_of_bias_instability(decades: int) -> None:
    ends = (1.0, 10.0**decades)
    terms, largest = flicker_bank(0.5, *ends)
    m = np.unique(np.geomspace(*ends, 40).round())
    deviation = np.sqrt(expected_variance(terms, m / 1e-3, 1e-3))
    assert largest < 0.07
    assert deviation == pytest.approx(np.sqrt(2.0 * np.log(2.0) / np.pi) * 0.5, rel=largest + 2e-3)
    space = state_space(BiasInstability(0.5), DT, flat=ends)
    assert len(space.names) == len(terms)
    assert f"{100.0 * largest:.2g} %" in space.remarks[0]
    assert flicker_bank(0.5, *ends, states=6)[1] < largest


def test_states_are_put_below_each_other() -> None:
    terms = (RandomWalk(0.1), GaussMarkov(1.0, 5.0), GaussMarkov(2.0, 50.0), RateRandomWalk(0.1))
    space = bias_state(terms, DT, integrated=False)
    assert space.names == ("gauss_markov_1", "gauss_markov_2", "rate_random_walk")
    assert pytest.approx(0.01 / DT) == space.R
    assert np.array_equal(space.H, np.ones((1, 3)))
    rounded = bias_state((*terms, Quantization(0.1)), DT, integrated=False)
    assert rounded.F is None
    assert len(rounded.Phi) == 5


def test_what_cannot_be_written_is_refused() -> None:
    with pytest.raises(PlanError, match="bias instability has no finite state"):
        state_space(BiasInstability(1.0), DT)
    with pytest.raises(PlanError, match=r"a step of 0\.0 s"):
        state_space(RandomWalk(1.0), 0.0)
    with pytest.raises(PlanError, match=r"a step of -1\.0 s"):
        discretise(np.eye(1), np.eye(1), -1.0)
    with pytest.raises(PlanError, match=r"Q of shape \(1, 1\)"):
        discretise(np.eye(2), np.eye(1), 1.0)
    with pytest.raises(PlanError, match="quantisation has no differential equation"):
        bias_state((Quantization(1.0),), DT)
    with pytest.raises(PlanError, match="averaging times from 10 to 1 s"):
        flicker_bank(1.0, 10.0, 1.0)
    with pytest.raises(PlanError, match="0 states"):
        flicker_bank(1.0, 1.0, 10.0, 0)
    with pytest.raises(PlanError, match="0 state space"):
        combined([])
