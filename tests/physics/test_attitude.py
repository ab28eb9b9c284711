"""Attitude: closed forms of single turns, their order, and what every rotation keeps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.physics.attitude import between, from_roll_pitch_yaw

ROUNDING = 1e-12
QUARTER = math.pi / 2
ANGLE = st.floats(-7.0, 7.0)


@pytest.mark.parametrize(
    ("roll", "pitch", "yaw", "axis", "to"),
    [
        (0.0, 0.0, QUARTER, "x", "y"),  # a turn about z takes x to y
        (QUARTER, 0.0, 0.0, "y", "z"),
        (0.0, QUARTER, 0.0, "z", "x"),
    ],
)
def test_a_quarter_turn_is_right_handed(roll: float, pitch: float, yaw: float, axis: str, to: str) -> None:
    C = from_roll_pitch_yaw(roll, pitch, yaw)
    np.testing.assert_allclose(C[:, "xyz".index(axis)], np.eye(3)["xyz".index(to)], atol=ROUNDING)


def test_the_matrix_is_the_textbook_one() -> None:
    roll, pitch, yaw = 0.3, -0.7, 2.1
    (a, b, c), (A, B, C) = np.sin([roll, pitch, yaw]), np.cos([roll, pitch, yaw])
    expected = [
        [C * B, C * b * a - c * A, C * b * A + c * a],
        [c * B, c * b * a + C * A, c * b * A - C * a],
        [-b, B * a, B * A],
    ]
    np.testing.assert_allclose(from_roll_pitch_yaw(roll, pitch, yaw), expected, atol=ROUNDING)


@given(ANGLE, ANGLE, ANGLE)
def test_lengths_and_handedness_stay(roll: float, pitch: float, yaw: float) -> None:
    C = from_roll_pitch_yaw(roll, pitch, yaw)
    np.testing.assert_allclose(C.T @ C, np.eye(3), atol=ROUNDING)
    assert np.linalg.det(C) == pytest.approx(1.0)


@given(ANGLE, ANGLE, ANGLE)
def test_there_and_back(roll: float, pitch: float, yaw: float) -> None:
    C_a_s, C_a_d = from_roll_pitch_yaw(roll, pitch, yaw), from_roll_pitch_yaw(yaw, roll, pitch)
    np.testing.assert_allclose(between(C_a_s, C_a_d) @ between(C_a_d, C_a_s), np.eye(3), atol=ROUNDING)
    np.testing.assert_allclose(C_a_s @ between(C_a_s, C_a_d), C_a_d, atol=ROUNDING)


def test_an_angle_that_is_no_number() -> None:
    with pytest.raises(DataError, match="need finite angles"):
        from_roll_pitch_yaw(0.0, math.nan, 0.0)
