"""Terms of noise: closed forms, exact sums, simulation, spectrum."""

from __future__ import annotations

from decimal import Decimal, getcontext, localcontext

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.core.units import kind_of_unit
from inertialcal.sensors.noise.expected import continuous_spectrum, expected_variance, sampled_spectrum
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    Phase,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    averaged_over,
    converted,
    flicker_covariance,
    parameter_unit,
    total_phase,
)
from inertialcal.signals.allan import allan

ROUNDING = 1e-9
T = 0.5
M = 2.0 ** np.arange(12)
TAU = M * T

ALL: list[Term] = [
    Quantization(2.0),
    RandomWalk(2.0),
    BiasInstability(2.0),
    RateRandomWalk(2.0),
    RateRamp(2.0),
    GaussMarkov(2.0, 3.0),
    GaussMarkov(2.0, 0.01),
    Sinusoid(2.0, 0.313),
]
NOISE = [term for term in ALL if not isinstance(term, RateRamp | Sinusoid)]


@pytest.mark.parametrize(
    ("term", "expected"),
    [  # IEEE Std 952-1997, Annex C, with tau = m T
        (Quantization(2.0), 3.0 * 4.0 / TAU**2),
        (RandomWalk(2.0), 4.0 / TAU),
        (BiasInstability(2.0), 4.0 * 2.0 * np.log(2.0) / np.pi * np.ones_like(TAU)),
        (RateRandomWalk(2.0), 4.0 * TAU / 3.0),
        (RateRamp(2.0), 4.0 * TAU**2 / 2.0),
        (Sinusoid(2.0, 0.313), 4.0 * np.sin(np.pi * 0.313 * TAU) ** 4 / (np.pi * 0.313 * TAU) ** 2),
    ],
    ids=lambda value: value.name if hasattr(value, "name") else "",
)
def test_without_dead_time_the_allan_variance_is_that_of_the_standard(term: Term, expected: Array) -> None:
    assert expected_variance(term, M, T) == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize("time", [0.001, 0.0334, 0.1, 5.0, 500.0, 1e6])
def test_gauss_markov_has_all_digits_for_short_and_long_correlation_times(time: float) -> None:
    getcontext().prec = 60  # 2 sigma^2 / x^2 (x - 3/2 + 2 exp(-x) - exp(-2x) / 2), IEEE Std 952-1997, C.1.6, sampled
    exact = []
    for tau in TAU:
        x = Decimal(float(tau)) / Decimal(time)
        value = 2 / x**2 * (x - Decimal("1.5") + 2 * (-x).exp() - (-2 * x).exp() / 2)
        exact.append(float(value))
    assert expected_variance(GaussMarkov(1.0, time), M, T) == pytest.approx(np.array(exact), rel=1e-6)


def covariance_of_samples(phase: Phase, n: int) -> Array:
    """Up to a constant, which contrasts do not see: minus the second difference of C."""
    lags = np.arange(-1.0, n + 1.0)
    return np.asarray(-np.diff(phase.covariance(lags), 2))


@pytest.mark.parametrize("averaging", [0.5, 0.3, 0.01])
@pytest.mark.parametrize("term", NOISE, ids=lambda term: term.name)
def test_every_deviation_is_that_of_the_contrast_summed_over_the_covariance_of_samples(
    term: Term, averaging: float
) -> None:
    m = 5
    R = covariance_of_samples(total_phase((term,), T, averaging), 60)
    mean = np.ones(m) / m
    contrasts = {
        "allan": (np.concatenate([-mean, mean]), 0.5),
        "hadamard": (np.concatenate([mean, -2.0 * mean, mean]), 1.0 / 6.0),
        "modified": (np.convolve(np.concatenate([-mean, mean]), mean), 0.5),
    }
    for name, (weights, factor) in contrasts.items():
        lags = np.abs(np.subtract.outer(np.arange(len(weights)), np.arange(len(weights))))
        brute = factor * float(weights @ R[lags] @ weights)
        assert expected_variance(term, [m], T, averaging, name)[0] == pytest.approx(brute, rel=1e-7)  # type: ignore[arg-type]


def test_modified_and_hadamard_have_their_closed_forms() -> None:
    m = np.array([1.0, 3.0, 64.0])
    tau = m * T
    white = RandomWalk(2.0)  # NIST SP 1065, clause 5.5: white FM, the modified variance tends to half
    assert expected_variance(white, m, T, deviation="modified") == pytest.approx(4.0 / tau * (m**2 + 1) / (2 * m**2))
    assert expected_variance(white, m, T, deviation="hadamard") == pytest.approx(4.0 / tau)
    assert expected_variance(RateRandomWalk(2.0), m, T, deviation="hadamard") == pytest.approx(4.0 * tau / 6.0)
    assert expected_variance(RateRamp(2.0), m, T, deviation="hadamard") == pytest.approx(np.zeros(3), abs=1e-12)


def test_one_second_averages_every_two_read_as_contiguous_raise_angle_random_walk_by_root_two() -> None:
    with_gap = expected_variance(RandomWalk(1.0), M, 2.0, 1.0)
    assert with_gap == pytest.approx(2.0 * expected_variance(RandomWalk(1.0), M, 2.0))


def test_dead_time_of_flicker_and_walk_is_forgotten_at_long_averaging_times() -> None:
    for term in (BiasInstability(1.0), RateRandomWalk(1.0)):
        ratio = expected_variance(term, [1, 100_000], 1.0, 0.2) / expected_variance(term, [1, 100_000], 1.0)
        assert ratio[0] > 1.1
        assert ratio[1] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("averaging", [0.5, 0.2])
@pytest.mark.parametrize("term", ALL, ids=lambda term: term.name)
def test_simulated_terms_have_the_exact_allan_variance(term: Term, averaging: float) -> None:
    rng = np.random.default_rng(11)
    records = np.column_stack([simulate(term, 1024, T, rng, averaging) for _ in range(120)])
    curve = allan(records, T, quantity="rate", averaging=averaging, noise=0)
    used = curve.m <= 64
    found = curve.deviation[used] ** 2
    expected = expected_variance(term, curve.m[used], T, averaging)
    spread = found.std(axis=1) / np.sqrt(records.shape[1])
    assert np.all(np.abs(found.mean(axis=1) - expected) <= 4.5 * spread + 2e-3 * expected)


@pytest.mark.parametrize("averaging", [0.5, 0.2])
@pytest.mark.parametrize("term", NOISE, ids=lambda term: term.name)
def test_spectrum_and_allan_variance_belong_together(term: Term, averaging: float) -> None:
    m = 4  # sigma^2 = integral of S 2 sin^4(pi f m T) / (m sin(pi f T))^2
    f = (np.arange(2_000) + 0.5) / 2_000 * 0.5 / T
    gain = 2.0 * np.sin(np.pi * f * m * T) ** 4 / (m * np.sin(np.pi * f * T)) ** 2
    through = np.sum(sampled_spectrum(term, f, T, averaging) * gain) * (f[1] - f[0])
    assert expected_variance(term, [m], T, averaging)[0] == pytest.approx(through, rel=1e-4)


def test_far_below_the_sample_rate_samples_have_the_continuous_spectrum() -> None:
    for term in (BiasInstability(1.0), RateRandomWalk(1.0), GaussMarkov(1.0, 50.0)):
        assert sampled_spectrum(term, [0.002], T) == pytest.approx(continuous_spectrum(term, [0.002]), rel=5e-3)
    assert sampled_spectrum(RandomWalk(3.0), [0.1], T) == pytest.approx([18.0])


@given(st.floats(0.01, 100.0), st.sampled_from(ALL[:6]))
def test_variance_goes_with_the_square_of_the_unit(scale: float, term: Term) -> None:
    first, *rest = (getattr(term, name) for name in term.parameters)
    scaled = type(term)(first * scale, *rest)
    assert expected_variance(scaled, M, T) == pytest.approx(scale**2 * expected_variance(term, M, T), rel=1e-9)


def test_units_follow_by_algebra() -> None:
    assert parameter_unit("random_walk", "coefficient", "rad/s") == "rad/sqrt(s)"
    assert parameter_unit("quantization", "coefficient", "m/s^2") == "m/s"
    assert converted(1.0, "rad/sqrt(s)", "deg/sqrt(h)") == pytest.approx(np.degrees(1.0) * 60.0)
    assert converted(1.0, parameter_unit("rate_random_walk", "coefficient", "rad/s"), "deg/h/sqrt(h)") == pytest.approx(
        np.degrees(1.0) * 3600.0 * 60.0
    )
    n = converted(1.0, parameter_unit("random_walk", "coefficient", "m/s^2"), "ug/sqrt(Hz)")
    assert n == pytest.approx(1e6 / 9.80665)
    assert parameter_unit("random_walk", "coefficient", "count") == "count*sqrt(s)"
    assert (kind_of_unit("deg/s"), kind_of_unit("mg"), kind_of_unit("V")) == ("gyro", "accelerometer", None)
    with pytest.raises(DataError, match="cannot be expressed in"):
        converted(1.0, "", "deg/h")


def test_what_cannot_be_is_refused() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(DataError, match=r"averaging time of 2 s at a sample interval of 1 s"):
        expected_variance(RandomWalk(1.0), [1], 1.0, 2.0)
    with pytest.raises(DataError, match=r"averaging time of 0 s"):
        simulate(RandomWalk(1.0), 9, 1.0, rng, 0.0)
    assert averaged_over(1.0, 1.0 + 1e-7) == averaged_over(1.0, None) == 1.0  # no clock is better
    with pytest.raises(DataError, match=r"sampled every 1 s is constant"):
        expected_variance(Sinusoid(1.0, 3.0), [1], 1.0)
    with pytest.raises(DataError, match=r"1 sample\(s\), need 2"):
        simulate(RandomWalk(1.0), 1, 1.0, rng)
    with pytest.raises(DataError, match=r"outside 0 to 0\.5 Hz"):
        sampled_spectrum(RandomWalk(1.0), [0.7], 1.0)


@pytest.mark.parametrize("duty", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("lag", [2, 29, 30, 45, 1000])
def test_covariance_of_flicker_near_and_far_is_the_second_difference_of_its_integral(lag: int, duty: float) -> None:
    """Twice integrated -ln t over windows of a share of the interval, in 50 digits: no digit is lost far away."""
    with localcontext(prec=50):
        d = Decimal(duty)

        def twice(t: Decimal) -> Decimal:
            return t * t * t.ln() / 2

        exact = Decimal("1.5") - (twice(lag + d) - 2 * twice(Decimal(lag)) + twice(lag - d)) / d**2
    assert flicker_covariance(np.array([float(lag)]), duty)[0] == pytest.approx(float(exact), abs=1e-10)
