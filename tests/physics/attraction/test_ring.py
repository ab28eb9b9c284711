"""The ring: closed form on its axis, sixty digits elsewhere, and the limit of thin tubes and of many points."""

from __future__ import annotations

import mpmath as mp  # type: ignore[import-untyped]
import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.physics.attraction import Cylinder, Ring

CLAIM = 1e-12
RING = Ring(2.0, 0.5)


def of_points(place: np.ndarray) -> np.ndarray:
    """Field of a ring of mass two by its definition, with forty digits."""
    with mp.workdps(40):
        at = [mp.mpf(float(v)) for v in place]

        def part(phi: mp.mpf, axis: int) -> mp.mpf:
            away = [mp.cos(phi) / 2 - at[0], mp.sin(phi) / 2 - at[1], -at[2]]
            return away[axis] / mp.sqrt(sum(v * v for v in away)) ** 3

        toward = mp.atan2(at[1], at[0])
        cuts = [toward + s for s in (-mp.pi, -1, -0.1, -0.01, 0, 0.01, 0.1, 1, mp.pi)]
        return np.array([float(mp.quad(lambda phi, i=i: part(phi, i), cuts) / mp.pi) for i in range(3)])


@pytest.mark.parametrize("z", [0.0, 1e-9, 0.1, 0.5, 3.0, 1e5])
def test_on_its_axis_a_ring_is_its_closed_form(z: float) -> None:
    d_2 = 0.25 + z * z
    field = RING.field(np.array([[0.0, 0.0, z]]))[0]
    assert field[2] == pytest.approx(-2.0 * z / d_2**1.5, rel=1e-14)
    np.testing.assert_allclose(field[:2], 0.0, atol=1e-15 * 2.0 / d_2)
    slope = RING.gradient(np.array([[0.0, 0.0, z]]))[0]
    along = 2.0 * (2.0 * z * z - 0.25) / d_2**2.5
    np.testing.assert_allclose(slope, np.diag([-along / 2.0, -along / 2.0, along]), atol=1e-13 * 2.0 / d_2**1.5)


@pytest.mark.parametrize(
    "place",
    [(0.3, 0.1, 0.2), (1e-7, 0.0, 0.4), (0.49, 0.0, 0.003), (0.5, 0.0, 0.01), (0.0, 0.9, 0.0), (40.0, 30.0, -20.0)],
    ids=str,
)
def test_off_its_axis_a_ring_keeps_twelve_digits(place: tuple[float, float, float]) -> None:
    exact = of_points(np.array(place))
    found = RING.field(np.array([place]))[0]
    assert np.linalg.norm(found - exact) <= CLAIM * np.linalg.norm(exact)


def test_a_thin_tube_far_from_its_section_goes_over_into_the_ring() -> None:
    points = np.array([[0.9, 0.2, 0.1], [0.1, 0.0, 0.6], [0.2, 0.1, 0.0]])
    widths = np.array([0.02, 0.01])
    apart = [
        np.abs(Cylinder(2.0, 0.5 + w / 2.0, w, 0.5 - w / 2.0).field(points) - RING.field(points)).max() for w in widths
    ]
    assert apart[0] < 2e-3
    assert apart[1] / apart[0] == pytest.approx(0.25, rel=0.02)  # of second order in the width


def test_both_ways_of_the_slope_join() -> None:
    """Where k^2 passes a half: in the plane of the ring at (3 - sqrt(8)) / 2 of the radius."""
    r = 0.5 * (3.0 - np.sqrt(8.0))
    pair = RING.gradient(np.array([[r * (1.0 - 1e-13), 0.0, 0.0], [r * (1.0 + 1e-13), 0.0, 0.0]]))
    np.testing.assert_allclose(pair[0], pair[1], rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize(("radius", "axis", "words"), [
    (0.0, (0.0, 0.0, 1.0), "radius 0 is not above zero"),
    (1.0, (0.0, 0.0, 0.0), "has no direction"),
])  # fmt: skip
def test_a_ring_without_extent_is_refused(radius: float, axis: tuple[float, float, float], words: str) -> None:
    with pytest.raises(DataError, match=words):
        Ring(1.0, radius, axis=axis)


def test_on_the_ring_itself_there_is_no_field() -> None:
    on = np.array([[0.5, 0.0, 0.0]])
    with pytest.raises(DataError, match=r"no value on the ring itself.*cylinder with an inner radius"):
        RING.field(on)
    with pytest.raises(DataError, match="no value on the ring itself"):
        RING.gradient(on)
