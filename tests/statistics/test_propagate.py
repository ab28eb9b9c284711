"""Propagation against the examples of the GUM and of its Supplement 1, and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array, Component, Estimate
from inertialcal.statistics.intervals import ends, t_interval
from inertialcal.statistics.propagate import (
    MonteCarlo,
    compare,
    linear,
    monte_carlo,
    shortest_interval,
    tolerance,
)

# JCGM 100:2008, Table H.2: voltage [V], current [A], phase [rad], five simultaneous observations
IMPEDANCE = np.array(
    [
        (5.007, 19.663e-3, 1.0456),
        (4.994, 19.639e-3, 1.0438),
        (5.005, 19.640e-3, 1.0468),
        (4.990, 19.685e-3, 1.0428),
        (4.999, 19.678e-3, 1.0433),
    ]
)
ENDS = 0.04  # of u: four standard errors of a 95 % end from 200,000 draws are 0.026


def seed() -> np.random.Generator:
    return np.random.default_rng(20261101)


def single(value: float, u: float, dof: float = math.inf, distribution: str = "normal") -> Estimate:
    part = Component("input", "A", np.array([[u**2]]), dof, distribution)
    return Estimate(("x",), np.array([value]), ("m",), (part,))


def independent(values: list[float], us: list[float], distribution: str = "normal") -> Estimate:
    k = len(values)
    part = Component("inputs", "B", np.diag(np.square(us)), math.inf, distribution)
    return Estimate(tuple(f"x{i}" for i in range(k)), np.array(values), ("",) * k, (part,))


def impedance(v: Array) -> Array:
    V, current, phi = v
    return np.array([V * math.cos(phi) / current, V * math.sin(phi) / current, V / current])


def total(v: Array) -> Array:
    return np.asarray(np.sum(v, axis=-1, keepdims=True))


def test_impedance_of_the_gum() -> None:
    """JCGM 100, H.2.3 and Table H.4: resistance, reactance, modulus, and their correlations."""
    C = np.cov(IMPEDANCE, rowvar=False) / 5.0
    inputs = Estimate(
        ("V", "I", "phi"),
        IMPEDANCE.mean(axis=0),
        ("V", "A", "rad"),
        (Component("5 observations", "A", C, 4.0),),
    )
    found = linear(impedance, inputs, ("R", "X", "Z"), ("ohm",) * 3)
    assert found.values == pytest.approx([127.732, 219.847, 254.260], abs=5.1e-4)
    assert found.u == pytest.approx([0.071, 0.295, 0.236], abs=6e-4)
    r = found.covariance / np.outer(found.u, found.u)
    assert [r[0, 1], r[0, 2], r[1, 2]] == pytest.approx([-0.588, -0.485, 0.993], abs=5.1e-4)
    assert found.dof == pytest.approx([4.0] * 3)
    assert found.units == ("ohm",) * 3


def test_given_slopes_and_central_differences_agree() -> None:
    inputs = independent([4.999, 19.661e-3, 1.04446], [0.0032, 0.0095e-3, 0.00075])
    V, current, _ = inputs.values
    R, X, Z = impedance(inputs.values)
    J = np.array([[R / V, -R / current, -X], [X / V, -X / current, R], [Z / V, -Z / current, 0.0]])
    given_slopes = linear(impedance, inputs, ("R", "X", "Z"), ("ohm",) * 3, jacobian=J)
    differences = linear(impedance, inputs, ("R", "X", "Z"), ("ohm",) * 3)
    assert differences.covariance == pytest.approx(given_slopes.covariance, rel=1e-6)


@given(
    a=st.floats(0.1, 1e6),
    b=st.floats(-1e6, -0.1),
    ua=st.floats(1e-9, 0.1),
    ub=st.floats(1e-9, 0.1),
)
def test_product_and_ratio_add_relative_variances(a: float, b: float, ua: float, ub: float) -> None:
    inputs = independent([a, b], [ua * a, -ub * b])
    found = linear(lambda v: np.array([v[0] * v[1], v[0] / v[1]]), inputs, ("p", "r"), ("", ""))
    relative = math.hypot(ua, ub)
    # central differences of 1/b with a step of 1 % of u are off by (0.01 ub)² at most
    assert found.u / np.abs(found.values) == pytest.approx(np.full(2, relative), rel=2e-6)


def test_a_linear_function_is_exact() -> None:
    A = np.array([[1.0, 2.0, -1.0], [0.0, 3.0, 0.5]])
    C = np.array([[4.0, 1.0, 0.0], [1.0, 9.0, -2.0], [0.0, -2.0, 1.0]])
    inputs = Estimate(("a", "b", "c"), np.array([1.0, 2.0, 3.0]), ("",) * 3, (Component("s", "A", C, 7.0),))
    found = linear(lambda v: A @ v, inputs, ("p", "q"), ("", ""))
    assert found.covariance == pytest.approx(A @ C @ A.T, rel=1e-9)


def test_the_budget_survives() -> None:
    scatter = Component("scatter between runs", "A", np.diag([4.0, 1.0]), 3.0)
    table = Component("table rate", "B", np.array([[1.0, 2.0], [2.0, 4.0]]), math.inf, "rectangular", (0.05, "%"))
    inputs = Estimate(("x", "y"), np.array([1.0, 2.0]), ("V", "V"), (scatter, table))
    found = linear(total, inputs, ("sum",), ("V",))
    assert [(c.source, c.kind, c.distribution) for c in found.components] == [
        ("scatter between runs", "A", "normal"),
        ("table rate", "B", "rectangular"),
    ]
    assert [c.stated for c in found.components] == [None, (0.05, "%")]
    assert [c.u[0] for c in found.components] == pytest.approx([math.sqrt(5.0), 3.0], rel=1e-9)
    assert found.dof[0] == pytest.approx(14.0**2 / (5.0**2 / 3.0), rel=1e-9)  # Welch-Satterthwaite


def test_a_result_takes_the_fewest_degrees_of_freedom_it_depends_on() -> None:
    part = Component("runs", "A", np.diag([1.0, 1.0, 0.0]), np.array([3.0, 8.0, 1.0]))
    inputs = Estimate(("a", "b", "c"), np.ones(3), ("",) * 3, (part,))
    found = linear(lambda v: np.array([v[0] + v[1], v[1] + v[2]]), inputs, ("ab", "bc"), ("", ""))
    assert found.dof == pytest.approx([3.0, 8.0])


def test_correlation_of_one_stays_so() -> None:
    """A difference of two readings of one standard does not know its error."""
    part = Component("standard", "B", np.array([[4.0, 4.0], [4.0, 4.0]]))
    inputs = Estimate(("a", "b"), np.array([1e3, 7.0]), ("", ""), (part,))
    assert linear(lambda v: v[:1] - v[1:], inputs, ("d",), ("",)).u[0] == pytest.approx(0.0, abs=1e-6)


def test_four_normal_quantities_of_supplement_1() -> None:
    """JCGM 101, 9.2.2: sum of four N(0, 1): u = 2.0, interval ± 3.92, and the GUM is validated."""
    inputs = independent([0.0] * 4, [1.0] * 4)
    drawn = monte_carlo(total, inputs, ("Y",), ("",), seed(), draws=1_000_000, vectorised=True)
    assert drawn.estimate.u[0] == pytest.approx(2.0, abs=0.01)
    assert ends(drawn.intervals[0]) == pytest.approx((-3.92, 3.92), abs=0.03)
    (found,) = compare(linear(total, inputs, ("Y",), ("",)), drawn)
    assert found.delta == 0.05
    assert found.validated
    assert found.resolved


def test_four_rectangular_quantities_of_supplement_1() -> None:
    """JCGM 101, 9.2.3: the end is 2 sqrt(3) (2 - (3/5)^(1/4)) = 3.88, where the GUM has 3.92."""
    inputs = independent([0.0] * 4, [1.0] * 4, "rectangular")
    drawn = monte_carlo(total, inputs, ("Y",), ("",), seed(), draws=1_000_000, vectorised=True)
    exact = 2.0 * math.sqrt(3.0) * (2.0 - 0.6**0.25)
    assert exact == pytest.approx(3.88, abs=0.005)
    assert ends(drawn.intervals[0]) == pytest.approx((-exact, exact), abs=0.02)


def test_one_large_rectangular_quantity_is_not_validated() -> None:
    """JCGM 101, 9.2.4: one of the four has u = 10: Monte Carlo ± 17.0, the GUM ± 19.9."""
    inputs = independent([0.0] * 4, [1.0, 1.0, 1.0, 10.0], "rectangular")
    drawn = monte_carlo(total, inputs, ("Y",), ("",), seed(), vectorised=True)
    by_slopes = linear(total, inputs, ("Y",), ("",))
    assert drawn.estimate.u[0] == pytest.approx(10.1, abs=0.06)
    assert ends(drawn.intervals[0]) == pytest.approx((-17.0, 17.0), abs=0.1)
    assert ends(t_interval(0.0, by_slopes.u[0], math.inf)) == pytest.approx((-19.9, 19.9), abs=0.05)
    (found,) = compare(by_slopes, drawn)
    assert not found.validated
    assert min(found.d_low, found.d_high) > 2.5


def test_microwave_power_of_supplement_1() -> None:
    """JCGM 101, 9.4.2.2: X1² + X2² at 0: slopes vanish, Monte Carlo has 50e-6 and 0 to 150e-6."""
    inputs = independent([0.0, 0.0], [0.005, 0.005])

    def power(v: Array) -> Array:
        return np.asarray(np.sum(v**2, axis=-1, keepdims=True))

    drawn = monte_carlo(power, inputs, ("dY",), ("",), seed(), vectorised=True, shortest=True)
    assert drawn.estimate.values[0] == pytest.approx(50e-6, rel=0.01)
    assert drawn.estimate.u[0] == pytest.approx(50e-6, rel=0.02)
    exact = 25e-6 * stats.chi2.ppf(0.95, 2)
    assert ends(drawn.intervals[0]) == pytest.approx((0.0, exact), abs=2e-6)
    by_slopes = linear(power, inputs, ("dY",), ("",))
    assert (by_slopes.values[0], by_slopes.u[0]) == (0.0, 0.0)


@pytest.mark.parametrize("dof", [3.0, 7.5])
def test_few_degrees_of_freedom_draw_students_t(dof: float) -> None:
    drawn = monte_carlo(lambda v: v, single(2.0, 0.5, dof), ("y",), ("m",), seed(), vectorised=True)
    exact = t_interval(2.0, 0.5, dof)
    spread = coverage_scale(dof)
    assert ends(drawn.intervals[0]) == pytest.approx(ends(exact), abs=0.5 * ENDS * spread)
    central = np.quantile(drawn.samples[:, 0], [0.25, 0.75])
    assert central == pytest.approx(2.0 + 0.5 * stats.t.ppf([0.25, 0.75], dof), abs=0.01)


def coverage_scale(dof: float) -> float:
    """How much less dense Student's t is at its 97.5 % point than the normal."""
    return float(stats.norm.pdf(1.96) / stats.t.pdf(stats.t.ppf(0.975, dof), dof))


def test_standard_deviation_of_students_t() -> None:
    """JCGM 101, 6.4.9.4: u is the scale; the standard deviation is sqrt(dof / (dof - 2)) larger."""
    drawn = monte_carlo(lambda v: v, single(0.0, 1.0, 12.0), ("y",), ("",), seed(), vectorised=True)
    assert drawn.estimate.u[0] == pytest.approx(math.sqrt(1.2), rel=0.01)
    assert math.isinf(drawn.estimate.dof[0])


def test_each_value_keeps_its_own_degrees_of_freedom_and_correlation() -> None:
    C = np.array([[1.0, 0.8, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 0.0]])
    part = Component("runs", "A", C, np.array([5.0, 50.0, 1.0]))
    inputs = Estimate(("a", "b", "c"), np.array([0.0, 0.0, 9.0]), ("",) * 3, (part,))
    drawn = monte_carlo(lambda v: v, inputs, ("a", "b", "c"), ("",) * 3, seed(), vectorised=True)
    for i, dof in enumerate((5.0, 50.0)):
        q = np.quantile(drawn.samples[:, i], [0.05, 0.95])
        assert q == pytest.approx(stats.t.ppf([0.05, 0.95], dof), abs=0.03)
    one_sign = np.mean(np.sign(drawn.samples[:, 0]) == np.sign(drawn.samples[:, 1]))
    assert one_sign == pytest.approx(0.5 + math.asin(0.8) / math.pi, abs=0.005)
    assert np.all(drawn.samples[:, 2] == 9.0)


def test_a_fully_correlated_rectangular_quantity_is_one_draw() -> None:
    part = Component("table rate", "B", np.outer([1.0, -2.0, 3.0], [1.0, -2.0, 3.0]), math.inf, "rectangular")
    inputs = Estimate(("a", "b", "c"), np.zeros(3), ("",) * 3, (part,))
    drawn = monte_carlo(total, inputs, ("sum",), ("",), seed(), vectorised=True)
    assert np.max(np.abs(drawn.samples)) == pytest.approx(2.0 * math.sqrt(3.0), rel=1e-3)
    assert np.max(np.abs(drawn.samples)) <= 2.0 * math.sqrt(3.0) * (1.0 + 1e-6)


def test_triangular_quantity() -> None:
    drawn = monte_carlo(
        lambda v: v, single(0.0, 1.0, distribution="triangular"), ("y",), ("",), seed(), vectorised=True
    )
    edge = math.sqrt(6.0) * (1.0 - math.sqrt(0.05))  # 95 % of the mass of a triangle
    assert ends(drawn.intervals[0]) == pytest.approx((-edge, edge), abs=0.02)


def test_a_curved_function_shifts_the_mean() -> None:
    """exp of N(0, 0.3): mean exp(0.045), as the log-normal distribution has it."""
    inputs = single(0.0, 0.3)
    drawn = monte_carlo(np.exp, inputs, ("y",), ("",), seed(), vectorised=True)
    assert drawn.estimate.values[0] == pytest.approx(math.exp(0.045), rel=0.003)
    assert not compare(linear(np.exp, inputs, ("y",), ("",)), drawn)[0].validated


def test_one_call_a_draw_and_one_call_for_all_agree() -> None:
    inputs = independent([1.0, 2.0], [0.1, 0.2])
    one = monte_carlo(total, inputs, ("y",), ("",), seed(), draws=2000)
    other = monte_carlo(total, inputs, ("y",), ("",), seed(), draws=2000, vectorised=True)
    assert np.array_equal(one.samples, other.samples)
    assert isinstance(one, MonteCarlo)
    estimate, intervals, samples = one
    assert (estimate.names, len(intervals), samples.shape) == (("y",), 1, (2000, 1))


def test_too_few_draws_are_seen() -> None:
    inputs = independent([0.0] * 4, [1.0] * 4)
    drawn = monte_carlo(total, inputs, ("Y",), ("",), seed(), draws=2000, vectorised=True)
    assert not compare(linear(total, inputs, ("Y",), ("",)), drawn)[0].resolved


def test_shortest_interval_of_an_exponential_starts_at_its_edge() -> None:
    samples = stats.expon.ppf((np.arange(10_000) + 0.5) / 10_000)
    assert ends(shortest_interval(samples, 0.9)) == pytest.approx((0.0, -math.log(0.1)), abs=2e-3)


@pytest.mark.parametrize(
    ("u", "digits", "delta"),
    [(0.00035, 2, 0.000005), (0.00035, 1, 0.00005), (2.0, 2, 0.05), (10.1, 2, 0.5), (0.0996, 2, 0.005)],
)
def test_numerical_tolerance(u: float, digits: int, delta: float) -> None:
    """JCGM 101, 7.9.2: half a unit of the last digit kept (0.0996 is kept as 0.10)."""
    assert tolerance(u, digits) == pytest.approx(delta, rel=1e-12)


def test_refusals_by_their_words() -> None:
    inputs = independent([1.0, 2.0], [0.1, 0.2])
    with pytest.raises(DataError, match=r"is \[nan\]. Need 1 finite number"):
        linear(lambda v: np.array([math.nan]), inputs, ("y",), ("",))
    with pytest.raises(DataError, match=r"Need 2 finite number\(s\), one a name"):
        linear(total, inputs, ("y", "z"), ("", ""))
    with pytest.raises(DataError, match=r"slopes of shape \(1, 3\)"):
        linear(total, inputs, ("y",), ("",), jacobian=np.ones((1, 3)))
    with pytest.raises(DataError, match=r"function gives shape \(2000, 2\), need \(2000, 1\)"):
        monte_carlo(lambda v: v, inputs, ("y",), ("",), seed(), draws=2000, vectorised=True)
    with (
        np.errstate(invalid="ignore"),
        pytest.raises(DataError, match=r"not finite for \d+ of 2000 draws"),
    ):
        monte_carlo(np.sqrt, single(0.0, 1.0), ("y",), ("",), seed(), draws=2000, vectorised=True)
    with pytest.raises(DataError, match="input: 2 degrees of freedom"):
        monte_carlo(total, single(0.0, 1.0, 2.0), ("y",), ("",), seed())
    with pytest.raises(DataError, match="input: distribution 'cauchy'"):
        monte_carlo(total, single(0.0, 1.0, distribution="cauchy"), ("y",), ("",), seed())
    with pytest.raises(PlanError, match=r"1000 draws for an interval of probability 0\.95"):
        monte_carlo(total, inputs, ("y",), ("",), seed(), draws=1000)
    impossible = Component("s", "A", np.array([[1.0, 2.0], [2.0, 1.0]]))
    with pytest.raises(DataError, match="s: covariance is not positive semi-definite"):
        linear(total, Estimate(("a", "b"), np.zeros(2), ("", ""), (impossible,)), ("y",), ("",))
    drawn = monte_carlo(total, inputs, ("y",), ("",), seed(), draws=2000, vectorised=True)
    with pytest.raises(DataError, match="compared with"):
        compare(linear(total, inputs, ("z",), ("",)), drawn)
    with pytest.raises(DataError, match="numerical tolerance of a standard uncertainty 0"):
        tolerance(0.0)


def test_the_cosine_of_an_unknown_angle_has_an_arcsine_distribution() -> None:
    """Amplitude a = sqrt(2) u; its quantile p is a sin(pi (p - 1/2)), as JCGM 101, 6.4.6, has it."""
    drawn = monte_carlo(total, single(1.0, 0.1, distribution="arcsine"), ("y",), ("m",), np.random.default_rng(1))
    end = 0.1 * math.sqrt(2.0) * math.sin(math.pi * 0.475)
    assert [drawn.intervals[0].lo, drawn.intervals[0].hi] == pytest.approx([1.0 - end, 1.0 + end], abs=2e-4)
    assert drawn.estimate.u[0] == pytest.approx(0.1, rel=5e-3)
