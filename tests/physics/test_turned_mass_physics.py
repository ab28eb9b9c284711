"""Attraction and recoil of a turned mass: the figures that were worked out by hand, closed forms, another frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from independent.orbit.turned_mass import Bench, felt
from inertialcal.core.constants import STANDARD_GRAVITY, WGS84_GM, WGS84_SEMI_MAJOR_AXIS
from inertialcal.core.errors import DataError
from inertialcal.physics.turned_mass import attraction, harmonics, null_rates, recoil_arm, recoil_rates
from inertialcal.procedures.turned_mass.rows import hidden_second_order

MASS, RADIUS, SATELLITE = 4.0, 0.2, 1000.0
# 560 km over the equator, as the figures were worked out
ORBIT = math.sqrt(WGS84_GM.value / (WGS84_SEMI_MAJOR_AXIS.value + 560e3) ** 3)
A = attraction(MASS, RADIUS)
ARM = recoil_arm(MASS, RADIUS, SATELLITE)
LAST_DIGIT = 0.5


def printed(value: float, text: str) -> bool:
    """Whether a figure is the one printed, to its last digit."""
    mantissa, _, power = text.partition("e")
    digits = len(mantissa.partition(".")[2])
    return abs(value - float(text)) <= LAST_DIGIT * 10.0 ** (int(power or 0) - digits) * (1.0 + 1e-9)


def test_the_attraction_is_the_one_printed() -> None:
    assert printed(A, "6.6743e-9")
    assert printed(A / STANDARD_GRAVITY.value, "6.806e-10")
    assert printed(math.hypot(2.0 * 1e-4 / RADIUS, 1e-3 / MASS), "1.03e-3")
    assert printed(ARM, "7.97e-4")


@pytest.mark.parametrize(("hours", "share"), [(1.0, "0.3637"), (2.0, "0.0909"), (6.0, "0.0101")])
def test_without_a_planet_the_recoil_is_the_one_printed(hours: float, share: str) -> None:
    along, across = recoil_rates(2.0 * math.pi / (3600.0 * hours), 0.0)
    assert printed(ARM * float(along) / A, share)
    assert along == across


def test_without_a_planet_recoil_and_attraction_cancel_where_printed() -> None:
    both = null_rates(MASS, RADIUS, SATELLITE, 0.0)
    assert printed(2.0 * math.pi / both[0], "2171")
    assert both[0] == -both[1]
    assert both[0] ** 2 == pytest.approx(6.6743e-11 * (SATELLITE + MASS) / RADIUS**3, rel=1e-12)


@pytest.mark.parametrize(("sense", "share"), [(1.0, "-0.246"), (-1.0, "0.664")])
def test_in_orbit_the_amplitude_is_the_one_printed(sense: float, share: str) -> None:
    along, _ = recoil_rates(sense * 2.0 * math.pi / 3600.0, ORBIT)
    assert printed(1.0 - ARM * float(along) / A, share)


def test_the_gradient_over_a_metre_is_hundreds_of_attractions() -> None:
    gradient = 3.0 * ORBIT**2
    assert printed(gradient, "3.58e-6")
    assert round(gradient / A) in (536, 537)


def test_an_offset_gives_the_harmonics_printed() -> None:
    e = 1e-3
    own = harmonics(e, 0.0)[0]
    assert own[0, 0] == pytest.approx(e / 2.0, rel=1e-5)
    assert own[1, 0] == pytest.approx(1.0 + 9.0 * e**2 / 8.0, abs=1e-11)
    assert own[2, 0] == pytest.approx(3.0 * e / 2.0, rel=1e-5)
    assert own[3, 0] == pytest.approx(15.0 * e**2 / 8.0, rel=1e-5)
    assert np.abs(own[:, 1]).max() < 1e-15


def test_a_nonlinearity_is_hidden_by_the_offset_as_printed() -> None:
    assert printed(hidden_second_order(1e-3, A) * STANDARD_GRAVITY.value, "4.4e6")


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(0.0, 6.28))
def test_harmonics_are_those_of_the_field(along: float, across: float, phi: float) -> None:
    """To the third: a fit of four harmonics of the exact field by another way has them."""
    angle = 2.0 * np.pi * np.arange(720) / 720
    apart = np.exp(1j * angle) - complex(along, across)
    field = apart / np.abs(apart) ** 3
    for part, own in zip((field.real, field.imag), harmonics(along, across), strict=True):
        assert np.mean(part * np.cos(2.0 * angle)) * 2.0 == pytest.approx(own[2, 0], abs=1e-9)
        assert np.mean(part * np.sin(3.0 * angle)) * 2.0 == pytest.approx(own[3, 1], abs=1e-9)
    turned = harmonics(*_turned(along, across, phi))  # turning everything turns what is read
    back = np.array([[np.cos(phi), np.sin(phi)], [-np.sin(phi), np.cos(phi)]])
    level = np.array([turned[0, 0, 0], turned[1, 0, 0]])
    assert back @ level == pytest.approx(harmonics(along, across)[:, 0, 0], abs=1e-9)


def _turned(along: float, across: float, phi: float) -> tuple[float, float]:
    place = complex(along, across) * np.exp(1j * phi)
    return float(place.real), float(place.imag)


@pytest.mark.parametrize("period", [3600.0, -3600.0, 1500.0, -8000.0])
@pytest.mark.parametrize("direction", [0.0, 0.3])
def test_an_inertial_frame_gives_the_same(period: float, direction: float) -> None:
    bench = Bench(direction=direction)
    phi = np.linspace(0.0, 2.0 * np.pi, 41)
    along, across = recoil_rates(2.0 * math.pi / period, bench.orbit)
    expected = math.cos(direction) * (A - ARM * along) * np.cos(phi)
    expected += math.sin(direction) * (A - ARM * across) * np.sin(phi)
    assert felt(bench, period, phi) == pytest.approx(expected, abs=1e-6 * A)


@pytest.mark.parametrize("period", [3600.0, -2500.0])
def test_along_the_track_the_tide_does_not_enter(period: float) -> None:
    """The input axis ahead is the radial one, turned by a quarter."""
    bench = Bench(direction=0.5 * math.pi)
    phi = np.linspace(0.0, 2.0 * np.pi, 41)
    along, _ = recoil_rates(2.0 * math.pi / period, bench.orbit, "along_track")
    expected = (A - ARM * along) * np.cos(phi - 0.5 * math.pi)
    assert felt(bench, period, phi) == pytest.approx(expected, abs=1e-6 * A)


@pytest.mark.parametrize("axis", ["radial", "along_track"])
def test_at_the_null_nothing_is_read(axis: str) -> None:
    for rate in null_rates(MASS, RADIUS, SATELLITE, ORBIT, axis):  # type: ignore[arg-type]
        along, _ = recoil_rates(rate, ORBIT, axis)  # type: ignore[arg-type]
        assert ARM * float(along) == pytest.approx(A, rel=1e-12)


def test_a_proof_mass_where_the_mass_passes_is_refused() -> None:
    with pytest.raises(DataError, match="would hit the instrument"):
        harmonics(1.0, 0.2)
