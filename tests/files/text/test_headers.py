"""Headers: what people write above their columns."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core import units
from inertialcal.files.text.headers import Heading, bare_name, heading, normal_unit

NAMES = [
    ("gyro_x [deg/s]", "gyro", "x", "deg/s"),
    ("acc_x (m/s^2)", "acc", "x", "m/s^2"),
    ("gyro_x_dps", "gyro", "x", "deg/s"),
    ("acc_mps2", "acc", "", "m/s^2"),
    ("acc_z_g", "acc", "z", "g"),
    ("temp_degC", "temperature", "", "degC"),
    ("Temperature (°C)", "temperature", "", "degC"),
    ("temp [C]", "temperature", "", "degC"),
    ("acc_y [G]", "acc", "y", "g"),
    ("t_s", "time", "", "s"),
    ("time [ms]", "time", "", "ms"),
    ("Time (s)", "time", "", "s"),
    ("unix_s", "time", "", "s"),
    ("millis", "time", "", "ms"),
    ("timestamp", "time", "", None),
    ("%time", "time", "", None),
    ("imu.gyro.x", "gyro", "x", None),
    ("gyr_x", "gyro", "x", None),
    ("wx", "gyro", "x", None),
    ("ax", "acc", "x", None),
    ("gx", "gyro", "x", None),
    ("mz", "magnetometer", "z", None),
    ("GyroX(deg/s)", "gyro", "x", "deg/s"),
    ("AccY", "acc", "y", None),
    ("xgyro", "gyro", "x", None),
    ("accelz", "acc", "z", None),
    ("Acceleration x (m/s^2)", "acc", "x", "m/s^2"),
    ("Gyroscope z (rad/s)", "gyro", "z", "rad/s"),
    ("field.angular_velocity.y", "gyro", "y", None),
    ("linear_acceleration.x", "acc", "x", None),
    ("gyro_x_rad_s", "gyro", "x", "rad/s"),
    ("x_dps", "gyro", "x", "deg/s"),
    ("accelBuffer", "acc", "", None),
    ("slope_volt_per_dps", "", "", "V/(deg/s)"),
    ("bias_volt", "voltage", "", "V"),
    ("gain [V/(deg/s)]", "", "", "V/(deg/s)"),
    ("pressure_hPa", "pressure", "", "hPa"),
    ("x_counts", "", "x", "count"),
    ("n_samples", "index", "", None),
    ("samples", "index", "", None),
    ("frame", "index", "", None),
    ("packetCounter", "index", "", None),
    ("Unnamed: 0", "index", "", None),
    ("imu.t", "time", "", None),
    ("header.seq", "index", "", None),
    ("i [g]", "acc", "", "g"),
    ("record [V]", "voltage", "", "V"),
    ("imu.status", "status", "", None),
    ("Time Sigma", "", "", None),
    ("time_step", "", "", None),
    ("part", "", "", None),
]


@pytest.mark.parametrize(("name", "quantity", "axis", "unit"), NAMES)
def test_names(name: str, quantity: str, axis: str, unit: str | None) -> None:
    said = heading(name)
    assert (said.quantity, said.axis, said.unit) == (quantity, axis, unit)
    assert said.unknown == ""


def test_brackets_without_a_unit_are_named_and_give_none() -> None:
    assert heading("acc_x (filtered)") == Heading(None, "x", "acc", "filtered")


def test_a_unit_that_cannot_belong_to_the_quantity_is_none() -> None:
    assert heading("gyro_x [g]") == Heading(None, "x", "gyro", "g")
    assert heading("gyro_g").unit is None
    assert heading("time [degC]").unit is None


def test_a_unit_from_elsewhere_goes_before_the_name() -> None:
    assert heading("gyro_x_dps", "rad/s").unit == "rad/s"
    assert heading("acc_x [g]", "m/s2").unit == "m/s^2"


def test_names_without_their_unit() -> None:
    assert bare_name("gyro_x [deg/s]") == "gyro_x"
    assert bare_name(" gain [V/(deg/s)] ") == "gain"
    assert bare_name("plain") == "plain"
    assert bare_name("(x)") == "(x)"
    assert bare_name("a)") == "a)"


def test_quantities_settle_what_a_letter_means() -> None:
    assert normal_unit("C", "temperature") == "degC"
    with pytest.raises(Exception, match="coulomb"):
        normal_unit("C", "")


@given(st.text(max_size=40), st.none() | st.text(max_size=10))
def test_any_name_gives_a_heading_with_a_unit_that_is_printed_alike(name: str, unit: str | None) -> None:
    said = heading(name, unit)
    assert said.axis in ("", "x", "y", "z")
    assert said.unit is None or units.normalise(said.unit) == said.unit


@pytest.mark.parametrize(("name", "quantity"), [
    ("acc_GYRO_3_x [m/s^2]", "acc"), ("gyro_acc_x [deg/s]", "gyro"), ("gyro_x [m/s^2]", "gyro"),
])  # fmt: skip
def test_a_name_with_both_sensors_is_that_of_its_unit(name: str, quantity: str) -> None:
    """A name of one alone stays with it: its unit is then wrong, and ignored."""
    assert heading(name).quantity == quantity
