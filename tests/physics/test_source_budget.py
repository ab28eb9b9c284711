"""Budget of the applied acceleration: slopes against differences of the whole body, and against Monte Carlo."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from closed_bodies import Placed
from scipy import stats
from scipy.spatial.transform import Rotation

from inertialcal.core.errors import DataError, UsageError
from inertialcal.physics.budget import amplitude as drawing
from inertialcal.physics.budget.amplitude import compared, linear_budget, monte_carlo_budget, shares
from inertialcal.physics.budget.source import Doubts, Source
from inertialcal.physics.mass_shape.cells import Grid, best_cells

BODY = best_cells(Grid(0.0508, (6, 12, 12), 0.0762, 11340.0), 150)
SOURCE = Source(BODY, (0.0, -1.0, 0.0), (0.127, 0.432))
ALL = Doubts(0.003, 0.005, 0.5e-3, (0.5e-3, 0.5e-3, 0.5e-3), 1e-3, 2e-3)
SMALL = 1e-6


def amplitude(shifts: np.ndarray, turn: np.ndarray) -> float:
    """Of the whole body, turned about the origin of its frame and shifted at each stop."""
    C = Rotation.from_rotvec(turn).as_matrix()
    fields = [Placed(BODY, tuple(s), C).field(np.zeros((1, 3)))[0, 0] for s in shifts]
    return float(SOURCE.gravitational_constant * (fields[0] - fields[1]) / 2.0)


def slope(shifts: np.ndarray, turn: np.ndarray) -> float:
    """Central difference for a small change."""
    return abs(
        amplitude(SOURCE.shifts + SMALL * shifts, SMALL * turn)
        - amplitude(SOURCE.shifts - SMALL * shifts, -SMALL * turn)
    ) / (2.0 * SMALL)


def test_each_share_is_the_slope_of_the_whole_body() -> None:
    found = {one.name: one.u for one in shares(SOURCE, ALL)}
    none = np.zeros(3)
    both = {name: np.array([axis, axis]) for name, axis in zip("xyz", np.eye(3), strict=True)}
    expected = {
        **{f"place {name}": 0.5e-3 * slope(both[name], none) for name in "xy"},
        "stop 1": 1e-3 * slope(np.array([[0.0, -1.0, 0.0], none]), none),
        "stop 2": 1e-3 * slope(np.array([none, [0.0, -1.0, 0.0]]), none),
        "angle about z": 2e-3 * slope(np.zeros((2, 3)), np.array([0.0, 0.0, 1.0])),
        "density": 0.003 * SOURCE.amplitude,
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-5)
    # by symmetry, only what the cells at the edge of the choice leave
    assert found.get("place z", 0.0) < 0.05 * found["place x"]


def test_pieces_add_as_many_independent_ones() -> None:
    """Equal pieces far away: the share of their densities is the whole over the root of their number."""
    far = Source(BODY, (1.0, 0.0, 0.0), (1000.0, 2000.0))
    found = {one.name: one.u for one in shares(far, Doubts(0.01, 0.01, gravitational_constant=0.0))}
    assert found["density of pieces"] == pytest.approx(found["density"] / math.sqrt(150), rel=1e-3)


def test_the_budget_is_an_estimate_with_a_component_each() -> None:
    found = linear_budget(SOURCE, ALL)
    assert found.values[0] == pytest.approx(amplitude(SOURCE.shifts, np.zeros(3)))
    assert found.u[0] == pytest.approx(math.sqrt(sum(one.u**2 for one in shares(SOURCE, ALL))))
    assert {part.kind for part in found.components} == {"B"}


def test_monte_carlo_agrees_within_two_per_cent() -> None:
    drawn, u = monte_carlo_budget(SOURCE, ALL, np.random.default_rng(1)), linear_budget(SOURCE, ALL).u[0]
    assert drawn.estimate.u[0] == pytest.approx(u, rel=0.02)
    assert drawn.estimate.values[0] == pytest.approx(SOURCE.amplitude, abs=4.0 * u / 100.0)
    assert compared(SOURCE, ALL, drawn).validated


def test_doubts_so_large_that_slopes_change_are_told() -> None:
    wild = Doubts(place=(0.05, 0.0, 0.0), stop=0.05)
    drawn = monte_carlo_budget(SOURCE, wild, np.random.default_rng(2))
    found = compared(SOURCE, wild, drawn)
    assert found.resolved
    assert not found.validated


def test_draws_without_doubts_are_the_amplitude() -> None:
    """The points with their shape factors are the cuboids."""
    draws = monte_carlo_budget(SOURCE, Doubts(gravitational_constant=0.0, density=1e-300), np.random.default_rng(3), 5)
    np.testing.assert_allclose(draws.samples[:, 0], SOURCE.amplitude, rtol=1e-11)


def test_the_draws_do_not_depend_on_the_number_of_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for processors in (1, 3):
        monkeypatch.setattr(drawing, "cpu_count", lambda n=processors: n)
        found.append(monte_carlo_budget(SOURCE, ALL, np.random.default_rng(4), 1050).samples)
    np.testing.assert_array_equal(found[0], found[1])
    assert len(np.unique(found[0])) == 1050  # no chunk repeats another


def test_one_normal_number_stands_for_the_densities_of_all_pieces() -> None:
    """Against draws of each piece's density, with doubts so large that the law is not normal."""
    doubts = Doubts(density=0.2, piece_density=0.6, piece_place=0.03, gravitational_constant=0.0)
    body = best_cells(Grid(0.1, (2, 2, 2), 0.1, 11340.0), 4)
    source = Source(body, (1.0, 0.0, 0.0), (0.0, 0.3))
    short = monte_carlo_budget(source, doubts, np.random.default_rng(5), 40_000).samples[:, 0]
    rng, (centres, density), n = np.random.default_rng(6), body.cells, 40_000
    mass = density * 1e-3 * source.gravitational_constant
    places = centres + doubts.piece_place * rng.standard_normal((n, 4, 3))
    away = [places + shift for shift in source.shifts]
    near, far = (
        c * a[..., 0] / np.linalg.norm(a, axis=2) ** 3
        for c, a in zip(drawing._shape(source, centres).T, away, strict=True)
    )
    weighed = 1.0 + doubts.piece_density * rng.standard_normal((n, 4))
    long = (1.0 + doubts.density * rng.standard_normal(n)) * np.sum(mass * weighed * (near - far) / 2.0, axis=1)
    assert abs(stats.skew(long)) > 0.3
    assert stats.ks_2samp(short, long).pvalue > 1e-3


FAR = (0.127, 0.432)
NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Doubts(stop=-0.1), r"uncertainty stop = -0.1 is below zero"),
        (lambda: Doubts(place=(0.0, NAN, 0.0)), "uncertainty place nan is not finite"),
        (lambda: Doubts(angle=INF), "uncertainty angle inf is not finite"),
        (
            lambda: Doubts(density=1.5),
            r"uncertainty density = 1.5 is 100 % or more.* If 1.5 % was meant, give 0.015",
        ),
        (lambda: Source(BODY, (0.0, -2.0, 0.0), FAR), r"direction \(0.0, -2.0, 0.0\) is not of length one"),
        (lambda: Source(BODY, (0.0, -1.0, 0.0), FAR, (0.0, 0.0, 0.0)), r"axis \(0.0, 0.0, 0.0\) is not of length one"),
        (lambda: Source(BODY, (0.0, -1.0, 0.0), (0.1, 0.1)), "both stops are at 0.1 m: the field does not change"),
        (lambda: Source(BODY, (0.0, -1.0, 0.0), (0.1, NAN)), "stop nan is not finite"),
        (
            lambda: Source(BODY, (1.0, 0.0, 0.0), (-0.2, 0.3)),
            "at position -0.2 m the mass would overlap the instrument",
        ),
    ],
)
def test_what_is_no_source_is_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(DataError, match=words):
        make()


def test_one_draw_has_no_standard_deviation() -> None:
    with pytest.raises(UsageError, match="1 draws: 2 or more are needed"):
        monte_carlo_budget(SOURCE, ALL, np.random.default_rng(1), 1)
