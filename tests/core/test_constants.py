"""Constants: each has a source and a unit; WGS 84 values follow from its four defining ones."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError

import pytest

from inertialcal.core import constants as c
from inertialcal.core.units import Quantity, factor, normalise

ROUNDING = 6e-11  # m/s^2, of values printed with ten decimals


@pytest.mark.parametrize("constant", c.CONSTANTS, ids=lambda constant: constant.name)
def test_each_has_a_source_a_unit_and_a_size(constant: c.Constant) -> None:
    assert len(constant.source) > 10
    assert constant.name
    assert normalise(constant.unit) == constant.unit
    assert constant.value > 0.0
    assert 0.0 <= constant.u < constant.value
    with pytest.raises(FrozenInstanceError):
        constant.value = 0.0  # type: ignore[misc]


def test_the_list_is_complete() -> None:
    here = [value for value in vars(c).values() if isinstance(value, c.Constant)]
    assert here == list(c.CONSTANTS)
    assert len({constant.name for constant in here}) == len(here)


def normal_gravity() -> tuple[float, float]:
    """At equator and pole of a level ellipsoid (Heiskanen and Moritz, Physical Geodesy, 1967, 2-73, 2-74)."""
    a, f = c.WGS84_SEMI_MAJOR_AXIS.value, c.WGS84_FLATTENING.value
    gm, omega = c.WGS84_GM.value, c.EARTH_ROTATION_RATE.value
    b = a * (1.0 - f)
    second = math.sqrt(a**2 - b**2) / b  # e'
    m = omega**2 * a**2 * b / gm
    q0 = 0.5 * ((1.0 + 3.0 / second**2) * math.atan(second) - 3.0 / second)
    q0_dash = 3.0 * (1.0 + 1.0 / second**2) * (1.0 - math.atan(second) / second) - 1.0
    ratio = m * second * q0_dash / q0
    return gm / (a * b) * (1.0 - m - ratio / 6.0), gm / a**2 * (1.0 + ratio / 3.0)


def test_normal_gravity_follows_from_the_ellipsoid() -> None:
    equator, pole = normal_gravity()
    assert equator == pytest.approx(c.NORMAL_GRAVITY_EQUATOR.value, abs=ROUNDING)
    assert pole == pytest.approx(c.NORMAL_GRAVITY_POLE.value, abs=2.0 * ROUNDING)


def test_somigliana_constant_follows_from_gravity_and_flattening() -> None:
    axes = 1.0 - c.WGS84_FLATTENING.value
    k = axes * c.NORMAL_GRAVITY_POLE.value / c.NORMAL_GRAVITY_EQUATOR.value - 1.0
    assert k == pytest.approx(c.SOMIGLIANA_CONSTANT.value, abs=2e-11)


def test_earth_turns_once_in_a_sidereal_day() -> None:
    sidereal_day = 86164.0989  # s, IERS
    turn = 2.0 * math.pi / sidereal_day
    assert pytest.approx(turn, rel=2e-7) == c.EARTH_ROTATION_RATE.value


def test_standard_gravity_is_the_unit_g() -> None:
    assert factor("g", c.STANDARD_GRAVITY.unit) == c.STANDARD_GRAVITY.value


def test_bias_instability_factor_as_the_thesis_prints_it() -> None:
    assert round(c.BIAS_INSTABILITY_FACTOR.value, 3) == 0.664
    assert round(c.BIAS_INSTABILITY_FACTOR.value, 5) == 0.66428


def test_constants_of_the_mass_attraction_report_in_si() -> None:
    gamma, g = c.REINEL_GRAVITATIONAL_CONSTANT, c.REINEL_GRAVITY
    assert Quantity(gamma.value, gamma.unit).to("m^3/s^2/kg") == pytest.approx(6.67e-11)
    assert Quantity(g.value, g.unit).to("m/s^2") == pytest.approx(9.81)
    assert gamma.value * 1e-3 == pytest.approx(c.GRAVITATIONAL_CONSTANT.value, rel=7e-4)
