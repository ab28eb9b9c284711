"""Earth rate and gravity: published points, closed forms against quadrature, symmetries."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import integrate

from inertialcal.core.errors import DataError
from inertialcal.physics.earth import (
    OMEGA,
    axis_earth_rate,
    earth_rate,
    earth_rate_along,
    earth_rate_in_dwell,
    earth_rate_sensitivities,
    geocentric_latitude,
    level_to_table,
    normal_gravity,
)

DEG = np.pi / 180.0
SITE = 36.6 * DEG  # Badescu, NPS thesis (2011): Monterey

latitudes = st.floats(-0.5 * np.pi, 0.5 * np.pi)
angles = st.floats(-2.0 * np.pi, 2.0 * np.pi)


def turned(angle: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Table from level-fixed table axes: the frame turned by an angle about z."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


class TestRate:
    def test_magnitude_is_what_the_thesis_prints(self) -> None:
        rate_deg_s = OMEGA / DEG
        assert rate_deg_s == pytest.approx(0.0042, abs=0.00005)

    def test_north_pole_turns_left_about_up(self) -> None:
        assert earth_rate(0.5 * np.pi) == pytest.approx([0.0, 0.0, -OMEGA], abs=1e-20)
        assert earth_rate(0.0) == pytest.approx([OMEGA, 0.0, 0.0])
        assert earth_rate([0.1, 0.2]).shape == (2, 3)

    def test_along_the_three_level_axes(self) -> None:
        north, east, down = earth_rate(SITE)
        assert earth_rate_along(SITE, 0.5 * np.pi, 0.0) == pytest.approx(north)
        assert earth_rate_along(SITE, 0.5 * np.pi, 0.5 * np.pi) == pytest.approx(east, abs=1e-20)
        assert earth_rate_along(SITE, 0.0, 1.0) == pytest.approx(-down)

    def test_tilts_of_the_thesis(self) -> None:
        # Leaning the axis to the north by the colatitude points it at the pole; to the south by the latitude,
        # along the equator's plane.
        assert earth_rate_along(SITE, 53.4 * DEG, 0.0) == pytest.approx(OMEGA)
        assert earth_rate_along(SITE, -36.6 * DEG, 0.0) == pytest.approx(0.0, abs=1e-20)

    @given(latitudes, angles, angles)
    def test_is_the_z_row_of_the_table(self, latitude: float, tilt: float, azimuth: float) -> None:
        z = level_to_table(tilt, azimuth)[2] @ earth_rate(latitude)
        assert earth_rate_along(latitude, tilt, azimuth) == pytest.approx(z, abs=1e-18)

    @given(latitudes, angles, angles)
    def test_sensitivities_are_derivatives(self, latitude: float, tilt: float, azimuth: float) -> None:
        latitude *= 0.999
        at, step = np.array([latitude, tilt, azimuth]), 1e-6
        numeric = [
            (earth_rate_along(*(at + step * e)) - earth_rate_along(*(at - step * e))) / (2.0 * step) for e in np.eye(3)
        ]
        assert earth_rate_sensitivities(latitude, tilt, azimuth) == pytest.approx(numeric, abs=1e-9 * OMEGA)


class TestTableFrame:
    @given(angles, angles)
    def test_is_a_rotation(self, tilt: float, azimuth: float) -> None:
        c = level_to_table(tilt, azimuth)
        assert c @ c.T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(c) == pytest.approx(1.0)

    def test_axes_of_a_level_table(self) -> None:
        # Facing north: x north, y west, z up.
        assert level_to_table(0.0, 0.0) == pytest.approx(np.diag([1.0, -1.0, -1.0]))
        assert level_to_table(0.0, 0.5 * np.pi)[0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)


class TestDwell:
    @settings(max_examples=60, deadline=None)
    @given(latitudes, angles, angles, angles, st.floats(-40.0, 40.0))
    def test_closed_form_is_the_integral(
        self, latitude: float, tilt: float, azimuth: float, start: float, angle: float
    ) -> None:
        c = level_to_table(tilt, azimuth)
        mean = [
            integrate.quad(
                lambda part, k=k: (turned(start + part * angle) @ c @ earth_rate(latitude))[k],
                0.0,
                1.0,
                epsabs=1e-14,
                limit=200,
            )[0]
            for k in range(3)
        ]
        assert earth_rate_in_dwell(latitude, c, start, angle) == pytest.approx(mean, abs=1e-9 * OMEGA)

    def test_table_at_rest_sees_it_all(self) -> None:
        c = level_to_table(0.3, 0.4)
        assert earth_rate_in_dwell(SITE, c, 0.0, 0.0) == pytest.approx(c @ earth_rate(SITE))

    def test_whole_turns_leave_the_axis_alone(self) -> None:
        c = level_to_table(0.3, 0.4)
        mean = earth_rate_in_dwell(SITE, c, [0.0, 1.0, 2.0], 2.0 * np.pi * np.array([1, -1, 3]))
        assert mean == pytest.approx(np.outer(np.ones(3), [0.0, 0.0, (c @ earth_rate(SITE))[2]]), abs=1e-15 * OMEGA)

    def test_quarter_turn_on_a_level_table(self) -> None:
        # Turned left from north, x goes to the west and sees the north less; y, from west, sees the south.
        north = OMEGA * np.cos(SITE)
        mean = earth_rate_in_dwell(SITE, level_to_table(0.0, 0.0), 0.0, 0.5 * np.pi)
        assert mean[:2] == pytest.approx([2.0 / np.pi * north, -2.0 / np.pi * north])


class TestAxisUncertainty:
    def test_vertical_axis_of_the_thesis(self) -> None:
        # Equation (13): 0.0025 +- 0.0002 deg/s, for a latitude of 36.4 deg and 3 deg of tilt.
        estimate = axis_earth_rate(36.4 * DEG, 0.0, 0.0, u_tilt=3.0 * DEG)
        assert estimate.value("earth_rate") / DEG == pytest.approx(0.00248, abs=5e-6)
        assert estimate.u[0] / DEG == pytest.approx(0.00018, abs=5e-6)

    def test_level_axis_of_unknown_azimuth(self) -> None:
        # Equation (14) has 0.0034 +- 0.0034 deg/s; a level axis has -0.0034 to 0.0034, so 0.0024 to one sigma.
        estimate = axis_earth_rate(36.4 * DEG, 0.5 * np.pi)
        assert estimate.value("earth_rate") == pytest.approx(0.0, abs=1e-20)
        assert estimate.u[0] / DEG == pytest.approx(0.00336 / np.sqrt(2.0), abs=1e-5)
        assert estimate.components[2].distribution == "arcsine"
        assert [c.kind for c in estimate.components] == ["B", "B", "B"]

    @settings(max_examples=20, deadline=None)
    @given(st.floats(-1.4, 1.4), angles, st.integers(0, 1000))
    def test_monte_carlo_with_unknown_azimuth(self, latitude: float, tilt: float, seed: int) -> None:
        rng, n = np.random.default_rng(seed), 40_000
        drawn = earth_rate_along(
            latitude + 0.01 * rng.normal(size=n), tilt + 0.02 * rng.normal(size=n), rng.uniform(0.0, 2.0 * np.pi, n)
        )
        estimate = axis_earth_rate(latitude, tilt, u_latitude=0.01, u_tilt=0.02)
        assert estimate.value("earth_rate") == pytest.approx(drawn.mean(), abs=0.02 * OMEGA)
        assert estimate.u[0] == pytest.approx(drawn.std(), rel=0.03, abs=5e-4 * OMEGA)

    def test_monte_carlo_with_known_azimuth(self) -> None:
        rng, n = np.random.default_rng(1), 200_000
        u = np.array([0.01, 0.02, 0.05])
        drawn = earth_rate_along(*(np.array([[0.6], [0.7], [0.8]]) + u[:, None] * rng.normal(size=(3, n))))
        estimate = axis_earth_rate(0.6, 0.7, 0.8, u_latitude=0.01, u_tilt=0.02, u_azimuth=0.05)
        assert estimate.u[0] == pytest.approx(drawn.std(), rel=0.01)


class TestLatitude:
    def test_thesis(self) -> None:
        # errata.csv, table angles: geodetic 36.6 is geocentric 36.42.
        assert geocentric_latitude(SITE) / DEG == pytest.approx(36.42, abs=0.005)

    @given(latitudes, st.floats(0.0, 1e5))
    def test_is_the_direction_of_the_position(self, latitude: float, height: float) -> None:
        a, f = 6378137.0, 1.0 / 298.257223563
        e2 = f * (2.0 - f)
        n = a / np.sqrt(1.0 - e2 * np.sin(latitude) ** 2)
        position = (n + height) * np.cos(latitude), ((1.0 - e2) * n + height) * np.sin(latitude)
        assert geocentric_latitude(latitude, height) == pytest.approx(np.arctan2(*position[::-1]), abs=1e-12)

    def test_degrees_are_refused(self) -> None:
        for function in (earth_rate, geocentric_latitude, normal_gravity):
            with pytest.raises(DataError, match=r"latitude 36\.6 rad, need -pi/2 to pi/2\. Latitudes are in radians"):
                function(36.6)
        with pytest.raises(DataError, match="latitude nan rad"):
            earth_rate(np.nan)


class TestGravity:
    def test_equator_and_pole_of_wgs84(self) -> None:
        # NIMA TR8350.2, Table 3.4.
        assert normal_gravity(0.0) == pytest.approx(9.7803253359, abs=1e-12)
        assert normal_gravity(0.5 * np.pi) == pytest.approx(9.8321849378, abs=2e-10)
        assert normal_gravity(-0.5 * np.pi) == pytest.approx(9.8321849378, abs=2e-10)

    def test_at_45_degrees(self) -> None:
        # Hand calculation: 9.7803253359 (1 + 0.00193185265241/2) / sqrt(1 - 0.00669437999014/2).
        assert normal_gravity(0.25 * np.pi) == pytest.approx(9.8061977694, abs=1e-9)

    def test_falls_with_height_as_the_exact_field_does(self) -> None:
        # On the axis through the pole the field is that of the mass, expanded to J2, without rotation.
        gm, a, f, j2 = 3.986004418e14, 6378137.0, 1.0 / 298.257223563, 1.082629821e-3

        def field(h: float) -> float:
            r = a * (1.0 - f) + h
            return gm / r**2 * (1.0 - 3.0 * j2 * (a / r) ** 2)

        for height in (100.0, 1000.0, 10_000.0):
            fall = float(normal_gravity(0.5 * np.pi) - normal_gravity(0.5 * np.pi, height))
            assert fall == pytest.approx(field(0.0) - field(height), rel=1e-4)

    @given(latitudes)
    def test_is_the_same_north_and_south(self, latitude: float) -> None:
        assert normal_gravity(latitude, 500.0) == normal_gravity(-latitude, 500.0)
