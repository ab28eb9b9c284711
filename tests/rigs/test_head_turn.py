"""A head that is turned: its course, what it feels of a fixed vector, what the turn adds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.procedures.flip.separation.equations import rotation
from inertialcal.rigs.parts.head_turn import course, felt, swung

SECONDS = np.arange(5000) / 100.0
ANGLES = st.floats(-7.0, 7.0)


def test_the_head_rests_turns_in_half_a_cosine_and_rests() -> None:
    found = course(SECONDS, np.array([10.0, 30.0]), np.array([np.pi, 0.2]), 5.0)
    assert not found.angle[SECONDS < 10.0].any()
    assert np.all(found.angle[(SECONDS >= 15.0) & (SECONDS < 30.0)] == np.pi)
    assert np.all(found.angle[SECONDS >= 35.0] == 0.2)
    assert found.angle[1250] == pytest.approx(0.5 * np.pi)
    assert found.rate.max() == pytest.approx(np.pi**2 / 10.0, rel=1e-6)
    moving = (SECONDS > 10.05) & (SECONDS < 14.95)
    assert found.rate[moving] == pytest.approx(np.gradient(found.angle, 0.01)[moving], abs=1e-5)
    assert found.acceleration[moving] == pytest.approx(np.gradient(found.rate, 0.01)[moving], abs=1e-4)


def test_half_a_turn_about_x_turns_the_signs_of_y_and_z() -> None:
    assert felt(np.array([1.0, 2.0, 3.0]), np.array([np.pi]), np.eye(3)[0])[0] == pytest.approx([1.0, -2.0, -3.0])


def test_a_quarter_turn_about_x_brings_the_vector_along_z_to_y() -> None:
    assert felt(np.array([0.0, 0.0, 1.0]), np.array([0.5 * np.pi]), np.eye(3)[0])[0] == pytest.approx([0.0, 1.0, 0.0])


@given(st.sampled_from("xyz"), ANGLES, st.integers(0, 2**31))
def test_the_rig_and_the_reduction_agree_about_positions(axis: str, angle: float, seed: int) -> None:
    fixed = np.random.default_rng(seed).normal(size=3)
    along = np.eye(3)["xyz".index(axis)]
    one = felt(fixed, np.array([angle]), along)[0]
    assert one == pytest.approx(rotation(axis, np.array([angle]))[0] @ fixed, abs=1e-8)
    assert np.linalg.norm(one) == pytest.approx(np.linalg.norm(fixed))


def test_a_point_on_a_circle_is_drawn_to_its_axis_and_pushed_along() -> None:
    motion = course(np.array([12.5, 10.0]), np.array([10.0]), np.array([np.pi]), 5.0)
    along, arm = np.eye(3)[0], np.array([7.0, 0.02, 0.0])
    found = swung(motion, along, arm)
    fastest, hardest = np.pi**2 / 10.0, np.pi**3 / 50.0
    assert found[0] == pytest.approx([0.0, -0.02 * fastest**2, 0.0], abs=1e-12)
    assert found[1] == pytest.approx([0.0, 0.0, 0.02 * hardest], abs=1e-12)
