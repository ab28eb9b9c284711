"""Profile of a random vibration: closed forms, an independent integration, an outside library, invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from inertialcal.core.errors import DataError
from inertialcal.signals.vibration.profile import Profile, decibels, fractional_octaves, octaves, ratio

TABLE_1 = ((20.0, 0.01), (50.0, 0.04), (500.0, 0.04), (2000.0, 0.01))  # NPS 2011, Table 1: g^2/Hz
KNEE = ((20.0, 0.01), (80.0, 0.04), (500.0, 0.04), (2000.0, 0.01))  # where +3 dB/octave reaches 0.04


def profile(nodes: tuple[tuple[float, float], ...]) -> Profile:
    """Return a profile of pairs."""
    f, s = np.array(nodes).T
    return Profile(f, s)


def test_closed_forms() -> None:
    flat = profile(((10.0, 2.0), (110.0, 2.0)))
    assert flat.power() == pytest.approx(200.0, rel=1e-14)
    assert flat.width == pytest.approx(100.0, rel=1e-14)
    falling = profile(((1.0, 3.0), (math.e, 3.0 / math.e)))  # slope -3.01 dB/octave: the logarithm
    assert falling.power() == pytest.approx(3.0, rel=1e-14)
    rising = profile(((1.0, 1.0), (10.0, 100.0)))  # f^2
    assert rising.power() == pytest.approx((1000.0 - 1.0) / 3.0, rel=1e-13)
    assert rising.slopes[0] == pytest.approx(20.0 * math.log10(2.0), rel=1e-14)
    # A flat density of acceleration: velocity and displacement by hand
    assert flat.rms(integrals=1) == pytest.approx(math.sqrt(2.0 * (1 / 10 - 1 / 110)) / (2 * math.pi), rel=1e-13)
    assert flat.rms(integrals=2) == pytest.approx(
        math.sqrt(2.0 / 3.0 * (10.0**-3 - 110.0**-3)) / (2 * math.pi) ** 2, rel=1e-13
    )


def test_near_the_special_slope_is_as_exact_as_elsewhere() -> None:
    """The integral of a slope next to -3.01 dB/octave goes over into the logarithm without a step."""
    for away in (1e-3, 1e-6, 1e-9, 1e-12, 0.0):
        own = profile(((1.0, 1.0), (1000.0, 1000.0 ** (-1.0 + away))))
        m, length = away, math.log(1000.0)
        series = sum(m**k * length ** (k + 1) / math.factorial(k + 1) for k in range(12))
        assert own.power() == pytest.approx(series, rel=1e-12)


def test_table_1_and_its_knee() -> None:
    """6.8148 g rms as printed, 6.784 with the knee where the slope puts it; the slopes differ, the sum does not."""
    printed, knee = profile(TABLE_1), profile(KNEE)
    assert printed.rms() == pytest.approx(6.8148, abs=5e-5)
    assert knee.rms() == pytest.approx(6.784, abs=5e-4)
    assert printed.slopes[0] == pytest.approx(4.55, abs=0.005)
    assert knee.slopes[0] == pytest.approx(3.01, abs=0.005)
    assert octaves(20.0, 80.0) == 2.0


@pytest.mark.parametrize("order", [0.0, -2.0, -4.0])
def test_against_an_independent_integration(order: float) -> None:
    own = profile(TABLE_1)

    def density(f: float) -> float:
        x = np.interp(math.log(f), np.log(own.frequency), np.log(own.density))
        return math.exp(float(x)) * math.pow(f, order)

    for low, high in ((20.0, 50.0), (50.0, 500.0), (500.0, 2000.0), (30.0, 45.0), (700.0, 1300.0)):
        found, _ = quad(density, low, high, epsabs=0.0, epsrel=1e-12, limit=200)
        assert own.power(low, high, order) == pytest.approx(found, rel=1e-10)


nodes = st.lists(
    st.tuples(st.floats(0.05, 3.0), st.floats(-9.0, 1.0)), min_size=2, max_size=8
)  # logarithms: step of the frequency, density


def drawn(given_nodes: list[tuple[float, float]]) -> Profile:
    """Return a profile of drawn logarithms."""
    f = np.exp(np.cumsum([step for step, _ in given_nodes]))
    return Profile(f, np.exp([level for _, level in given_nodes]))


@given(nodes, st.floats(0.0, 1.0), st.floats(-40.0, 40.0))
def test_power_adds_over_bands_and_scales_with_decibels(
    given_nodes: list[tuple[float, float]], part: float, level: float
) -> None:
    own = drawn(given_nodes)
    low, high = own.band
    middle = low + part * (high - low)
    for order in (0.0, -2.0, -4.0):
        whole = own.power(order=order)
        assert own.power(low, middle, order) + own.power(middle, high, order) == pytest.approx(whole, rel=1e-10)
        assert own.scaled(level).power(order=order) == pytest.approx(whole * 10.0 ** (0.1 * level), rel=1e-10)
    assert own.power() <= own.density.max() * (high - low) * (1.0 + 1e-12)
    assert own.width <= (high - low) * (1.0 + 1e-9)


@given(nodes, st.floats(0.0, 1.0))
def test_a_node_on_a_line_changes_nothing(given_nodes: list[tuple[float, float]], part: float) -> None:
    own = drawn(given_nodes)
    low, high = own.band
    f = low * (high / low) ** min(max(part, 0.01), 0.99)
    at = int(np.searchsorted(own.frequency, f))
    more = Profile(np.insert(own.frequency, at, f), np.insert(own.density, at, own.at(f)))
    assert more.power() == pytest.approx(own.power(), rel=1e-9)


def test_density_at_nodes_steps_and_outside() -> None:
    step = profile(((10.0, 1.0), (20.0, 1.0), (20.0, 4.0), (40.0, 4.0)))
    assert step.at([9.0, 10.0, 19.0, 20.0, 40.0, 41.0]).tolist() == pytest.approx([0.0, 1.0, 1.0, 4.0, 4.0, 0.0])
    assert step.power() == pytest.approx(10.0 + 80.0, rel=1e-14)
    assert profile(TABLE_1).at(100.0) == pytest.approx(0.04, rel=1e-14)


def test_what_is_no_profile_is_refused() -> None:
    for f, s in (([1.0], [1.0]), ([1.0, 1.0], [1.0, 2.0]), ([2.0, 1.0], [1.0, 1.0]), ([1.0, 2.0], [1.0, 0.0]),
                 ([0.0, 2.0], [1.0, 1.0])):  # fmt: skip
        with pytest.raises(DataError) as refused:
            Profile(np.array(f), np.array(s))
        assert refused.value.problems[0].code == "profile"


def test_decibels_and_bands() -> None:
    assert decibels(2.0) == pytest.approx(3.0102999566398120, rel=1e-15)
    assert ratio(decibels(7.0)) == pytest.approx(7.0, rel=1e-14)
    edges = fractional_octaves(20.0, 2000.0, 3)
    assert np.all(np.diff(np.log2(edges)) == pytest.approx(1.0 / 3.0, rel=1e-12))
    assert edges[0] >= 20.0
    assert edges[-1] <= 2000.0
    centres = np.sqrt(edges[:-1] * edges[1:])
    assert np.min(np.abs(centres - 1000.0)) < 1e-6


# Root mean squares by pyyeti 1.4.7 (numpy 2.4.6), all digits: sqrt(pyyeti.psd.area(np.array(nodes)))
PYYETI = {
    "table_1": (TABLE_1, 6.8148499057578285),
    "knee": (KNEE, 6.784238146055739),
    "falling_3_db": (((20.0, 0.1), (40.0, 0.05), (80.0, 0.025)), 1.6651092223153954),
    "minus_one": (((10.0, 1.0), (1000.0, 0.01)), 6.7861404244151124),
    "steep": (((20.0, 0.001), (60.0, 0.2), (61.0, 0.01), (900.0, 0.3), (1500.0, 1e-5)), 11.627644731119652),
    "flat": (((5.0, 0.02), (2000.0, 0.02)), 6.316644678941502),
}


@pytest.mark.parametrize("name", PYYETI)
def test_against_pyyeti(name: str) -> None:
    given_nodes, expected = PYYETI[name]
    assert profile(given_nodes).rms() == pytest.approx(expected, rel=1e-10)
