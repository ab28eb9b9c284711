"""Field of the earth along an orbit: against the model by other coordinates, axes that do not turn, knots."""

from __future__ import annotations

from datetime import datetime

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.physics.geomagnetic import earth_fixed, field_along

ppigrf = pytest.importorskip("ppigrf")
START = 1_772_323_200_000_000_000  # 2026-03-01 [ns]


def test_geodetic_to_earth_fixed_on_axes() -> None:
    found = earth_fixed(np.array([0.0, np.pi / 2]), np.array([0.0, 0.0]), np.array([1000.0, 0.0]))
    assert found[0] == pytest.approx([6_379_137.0, 0.0, 0.0])
    assert found[1] == pytest.approx([0.0, 0.0, 6_356_752.3142], abs=1e-3)


def test_at_the_first_instant_it_is_that_of_the_model() -> None:
    latitude, longitude, height = np.radians([48.0]), np.radians([11.0]), np.array([560e3])
    place = earth_fixed(latitude, longitude, height)
    found = field_along(np.array([0.0, 1.0]), np.vstack([place, place]), START)[0]
    east, north, up = (float(np.ravel(one)[0]) for one in ppigrf.igrf(11.0, 48.0, 560.0, datetime(2026, 3, 1)))
    lat, lon = latitude[0], longitude[0]
    level = np.array([
        [-np.sin(lon), np.cos(lon), 0.0],
        [-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)],
        [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)],
    ])  # fmt: skip
    assert level @ found == pytest.approx(np.array([east, north, up]) * 1e-9, abs=1e-12)


def test_axes_do_not_turn_with_the_earth() -> None:
    place = np.tile(earth_fixed(np.radians([10.0]), np.radians([20.0]), np.array([560e3])), (601, 1))
    time = np.linspace(0.0, 6000.0, 601)
    found = field_along(time, place, START)
    angle = np.unwrap(np.arctan2(found[:, 1], found[:, 0]))
    assert (angle[-1] - angle[0]) / time[-1] == pytest.approx(7.292115e-5, rel=1e-9)
    assert np.ptp(found[:, 2]) < 1e-12


def test_between_knots_it_is_that_of_the_model() -> None:
    time = np.arange(0.0, 600.0, 0.5)
    along = time * 1.1e-3
    place = 6.93e6 * np.column_stack([np.cos(along), 0.6 * np.sin(along), 0.8 * np.sin(along)])
    fine = field_along(time, place, START)
    for k in (7, 333, 1001):
        one = field_along(np.array([0.0, 1.0]), np.vstack([place[k], place[k]]), START)[0]  # as if it were the first
        c, s = np.cos(7.292115e-5 * time[k]), np.sin(7.292115e-5 * time[k])
        assert fine[k] == pytest.approx([c * one[0] - s * one[1], s * one[0] + c * one[1], one[2]], abs=2e-11)


@pytest.mark.parametrize(("scale", "start", "code"), [(1e-3, START, "position"), (1.0, 2 * START, "no_date")])
def test_what_is_no_orbit_or_no_date_is_refused(scale: float, start: int, code: str) -> None:
    place = np.tile([6.93e6, 0.0, 0.0], (5, 1)) * scale
    with pytest.raises(DataError) as caught:
        field_along(np.arange(5.0), place, start)
    assert caught.value.problems[0].code == code
