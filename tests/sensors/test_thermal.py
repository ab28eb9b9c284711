"""Change of variable: exact, there and back, and the published tables of the flight unit in both variables."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import PlanError
from inertialcal.sensors.catalogue import SLOPE, T_REFERENCE, V_NOMINAL
from inertialcal.sensors.thermal import change_variable, in_unit, over_temperature, over_voltage
from inertialcal.statistics.polynomial import Polynomial, from_monomials, powers_from_series

FINITE = st.floats(-3.0, 3.0)
DPS_PER_VOLT = 2.0  # 0.5 V/(deg/s)
ROUNDING = 2e-4  # [deg/s]: five decimals of the cubes' coefficients over 66 degC
AXES = ("X", "Y", "Z")

# Badescu 2011, Table 3: bias [V] over volts of the temperature channel, with standard errors; B, m1, m2, m3.
TABLE_3 = {
    "X": ((-0.03562, -0.05444, -0.00816, -0.00560), (7.29979e-5, 1.24357e-4, 2.40767e-4, 1.03657e-4)),
    "Y": ((-0.00295, -0.01634, -0.00622, -0.00542), (7.14013e-5, 1.16579e-4, 2.25414e-4, 9.68825e-5)),
    "Z": ((0.01428, -0.01493, -0.00899, -0.00808), (8.37201e-5, 1.44301e-4, 2.76961e-4, 1.18105e-4)),
}
# Table 4: bias [deg/s] over degC.
TABLE_4 = {
    "X": (0.05232, -0.00309, 1.61507e-5, -2.06176e-7),
    "Y": (0.03262, -0.00127, 1.7812e-5, -1.99291e-7),
    "Z": (0.06502, -0.00144, 2.71648e-5, -2.97345e-7),
}
RAMP = (-29.0, 66.0)  # section IV.B [degC]


def in_volts(axis: str) -> Polynomial:
    slope, voltage, temperature = SLOPE, V_NOMINAL[AXES.index(axis)], T_REFERENCE[AXES.index(axis)]
    domain = tuple(voltage + slope * (T - temperature) for T in RAMP)
    return from_monomials(TABLE_3[axis][0], (domain[0], domain[1]))


def largest_difference(axis: str, reference: float) -> float:
    """Of Table 3 taken to degrees from Table 4 over the ramp [deg/s]."""
    volts = in_unit(in_volts(axis), DPS_PER_VOLT)
    found = over_temperature(volts, SLOPE, V_NOMINAL[AXES.index(axis)], reference)
    printed = from_monomials(TABLE_4[axis], (-40.0, 80.0))
    at = np.linspace(found.domain[0], found.domain[1], 300)
    return float(np.max(np.abs(found.values(at) - printed.values(at))))


def test_table_4_follows_from_table_3_for_z() -> None:
    assert largest_difference("Z", T_REFERENCE[2]) < ROUNDING


def test_tables_4_for_x_and_y_were_made_with_the_exchanged_reference_temperatures() -> None:
    x, y = T_REFERENCE[0], T_REFERENCE[1]
    assert (x, y) == (25.7, 25.4)  # Table 2
    assert largest_difference("X", y) < ROUNDING
    assert largest_difference("Y", x) < ROUNDING
    assert largest_difference("X", x) > 4.0 * ROUNDING  # with their own they do not agree
    assert largest_difference("Y", y) > 4.0 * ROUNDING


def test_residual_sums_of_table_4_are_four_times_those_of_table_3(shared: Path) -> None:
    """Volts to deg/s is a factor 2, so squares take 4 (Tables 3 and 4)."""
    rows = {}
    for name in ("table03_poly_ground_volt", "table04_poly_ground_degc_dps"):
        with (shared / "reference" / "npsat2011" / f"{name}.csv").open(encoding="utf-8") as file:
            found = [row for row in csv.DictReader(file) if row["coefficient"] == "B"]
        rows[name[:7]] = [float(row["residual_sum_of_squares"]) for row in found]
    assert rows["table04"] == pytest.approx([4.0 * one for one in rows["table03"]], abs=5e-5)


@given(st.lists(FINITE, min_size=1, max_size=6), st.floats(0.1, 4.0), st.sampled_from([-1.0, 1.0]), FINITE)
def test_the_change_is_exact_and_can_be_undone(
    coefficients: list[float], size: float, sign: float, zero: float
) -> None:
    scale = sign * size
    covariance = np.diag(np.arange(1.0, len(coefficients) + 1.0))
    p = Polynomial(np.array(coefficients), covariance, 7.0, (-2.0, 5.0))
    q = change_variable(p, scale, zero)
    z = np.linspace(*q.domain, 11)
    x = np.clip(scale * z + zero, *p.domain)
    assert q.values(z) == pytest.approx(p.values(x), abs=1e-8)
    assert q.u(z) == pytest.approx(p.u(x), abs=1e-8)
    back = change_variable(q, 1.0 / scale, -zero / scale)
    assert back.coefficients == pytest.approx(p.coefficients)
    assert back.covariance == pytest.approx(covariance)
    assert back.domain == pytest.approx(p.domain)


def test_degrees_and_volts_are_inverses() -> None:
    p = in_volts("X")
    there = over_temperature(p, SLOPE, V_NOMINAL[0], T_REFERENCE[0])
    assert there.domain == pytest.approx(RAMP)
    assert over_voltage(there, SLOPE, V_NOMINAL[0], T_REFERENCE[0]).coefficients == pytest.approx(p.coefficients)


def test_powers_are_those_of_the_series() -> None:
    p = Polynomial(np.array([1.0, -2.0, 0.5, 0.25]), None, 0.0, (-30.0, 60.0))
    powers = powers_from_series(3, p.domain, 20.0) @ p.coefficients
    at = np.linspace(-30.0, 60.0, 9)
    assert np.polynomial.polynomial.polyval(at - 20.0, powers) == pytest.approx(p.values(at))


@pytest.mark.parametrize("scale", [0.0, np.nan, np.inf])
def test_a_scale_of_zero_is_refused(scale: float) -> None:
    with pytest.raises(PlanError, match="need a finite number other than 0"):
        change_variable(Polynomial(np.ones(2), None, 0.0, (0.0, 1.0)), scale, 0.0)


def test_a_channel_without_slope_is_refused() -> None:
    with pytest.raises(PlanError, match="does not tell temperatures"):
        over_voltage(Polynomial(np.ones(2), None, 0.0, (0.0, 1.0)), 0.0, 0.0, 25.0)
