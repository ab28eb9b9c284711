"""What each standard adds to the uncertainty of accelerometers and gyros: closed forms of six faces laid twice."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.estimate import Estimate
from inertialcal.procedures.positions.fit.at_rest import INSIDE, apart, at_rest, sources_of
from inertialcal.procedures.positions.reduction import Plan, Triad, reduce, simulate
from inertialcal.procedures.positions.simulation import FACES
from positions_truths import FIXTURE_PLAN, FULL, PLAN, TURNED, G


@pytest.fixture(scope="module")
def found() -> tuple[Estimate, Estimate]:
    result = reduce(FIXTURE_PLAN, simulate(PLAN, TURNED, np.random.default_rng(1)))
    return result.estimates["accelerometer"], result.estimates["gyro"]


def part(of: Estimate, source: str, name: str) -> float:
    """Standard uncertainty of one value by one source."""
    (one,) = (component for component in of.components if component.source == source)
    return float(one.u[of.index(name)])


def test_gravity_is_in_proportion(found: tuple[Estimate, Estimate]) -> None:
    u = FIXTURE_PLAN.standards["gravity.value"].u / G
    acc, gyro = found
    for k, axis in enumerate("xyz"):
        assert part(acc, "gravity.value", f"scale_factor_error_{axis}") == pytest.approx(FULL[k, k] * u, rel=1e-3)
        assert part(acc, "gravity.value", f"bias_{axis}") == 0.0
        g_sensitivity = abs(gyro.values[gyro.index(f"g_sensitivity_x{axis}")])
        assert part(gyro, "gravity.value", f"g_sensitivity_x{axis}") == pytest.approx(g_sensitivity * u, rel=1e-6)


def test_the_clock_is_in_proportion(found: tuple[Estimate, Estimate]) -> None:
    for k, axis in enumerate("xyz"):
        u = FULL[k, k] * FIXTURE_PLAN.standards["clock.rate"].u
        assert part(found[1], "clock.rate", f"scale_factor_error_{axis}") == pytest.approx(u, rel=0.01)
        assert part(found[1], "clock.rate", f"bias_{axis}") == 0.0


def test_a_face_is_turned_across_gravity(found: tuple[Estimate, Estimate]) -> None:
    """Two faces tell a cross-axis entry, however often each is laid; along gravity a small turn does nothing."""
    u = FIXTURE_PLAN.standards["fixture.orientation"].u
    for name in ("misalignment_xy", "misalignment_zx"):
        assert part(found[0], "fixture.orientation", name) == pytest.approx(u / np.sqrt(2.0), rel=0.05)
    assert part(found[0], "fixture.orientation", "scale_factor_error_x") < 0.02 * u


def test_turns_have_their_angle_and_their_axis(found: tuple[Estimate, Estimate]) -> None:
    """Two turns about each axis: two errors of the angle over a whole turn, one of the axis, there and back alike."""
    angle, pose = (FIXTURE_PLAN.standards[name].u for name in ("turn.angle", "fixture.orientation"))
    expected = angle / (2.0 * np.pi) / np.sqrt(2.0)
    for axis in "xyz":
        assert part(found[1], "turn.angle", f"scale_factor_error_{axis}") == pytest.approx(expected, rel=0.05)
    assert part(found[1], "fixture.orientation", "misalignment_xy") == pytest.approx(pose, rel=0.05)


def test_scatter_below_the_noise_counts_as_it_is() -> None:
    """Six faces: the mean square of two degrees of freedom, not the noise, which would promise too little."""
    noise = 1e-2  # the rate of the earth is nothing to it
    mean = np.zeros((6, 3))
    mean[:, 0] = 0.2 * noise * np.array([1.0, 1.0, -1.0, -1.0, 0.0, 0.0])  # no bias, no g-sensitivity: all residual
    triad = Triad(mean + 1e-9 * np.arange(6)[:, None], np.full((6, 3), noise), np.ones((6, 3)), "rad/s")
    force = G * FACES
    rest = at_rest(Plan(gravity=G), triad, force, np.ones(3), np.zeros(3), apart(force))
    assert rest.fits is not None
    assert rest.fits[0].between == 0.0
    (inside,) = (one for one in sources_of(Plan(gravity=G), rest, np.eye(12)) if one.name == INSIDE)
    square = 4.0 * (0.2 * noise) ** 2 / 2.0
    assert inside.covariance[0, 0] == pytest.approx(square / 6.0, rel=0.02)
    assert np.asarray(inside.dof)[0] == pytest.approx(2.0, rel=0.02)
