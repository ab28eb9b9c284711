"""Closed forms, Laplace's equation, symmetry, and references of sixty digits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from closed_bodies import Point
from cuboid_reference import cuboid_field
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import DataError
from inertialcal.physics.attraction.bodies import Lattice, Prism
from inertialcal.physics.attraction.extended import ProofMass, mean_field

CLAIM = 1e-12  # relative error of the field
SLOPE = 1e-6  # relative error of a difference quotient over 1e-4 of the distance
CUBE = Prism((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), 1.0)
CELLS = np.random.default_rng(1).uniform(1.0, 2.0, (3, 4, 5))
BODIES: dict[str, Prism | Lattice] = {
    "prism": Prism((-0.3, -0.1, 0.0), (0.2, 0.4, 0.3), 5.0),
    "lattice": Lattice(CELLS, (0.1, 0.12, 0.08), (-0.2, -0.2, -0.2)),
}


def directions(n: int, seed: int) -> np.ndarray:
    found = np.random.default_rng(seed).normal(size=(n, 3))
    return found / np.linalg.norm(found, axis=1)[:, None]  # type: ignore[no-any-return]


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("away", [0.8, 3.0, 40.0])
def test_the_gradient_is_that_of_the_field_symmetric_and_without_trace(body: Prism | Lattice, away: float) -> None:
    points = away * directions(5, 2)
    h = 1e-4 * away
    slopes = np.stack(
        [(body.field(points + h * e) - body.field(points - h * e)) / (2.0 * h) for e in np.eye(3)], axis=2
    )
    found = body.gradient(points)
    size = np.abs(found).max()
    np.testing.assert_allclose(found, slopes, atol=SLOPE * size * 10)
    np.testing.assert_allclose(found, np.swapaxes(found, 1, 2), atol=1e-14 * size)
    np.testing.assert_allclose(np.trace(found, axis1=1, axis2=2), 0.0, atol=1e-8 * size)


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_far_away_a_body_is_a_point_of_its_mass(body: Prism | Lattice) -> None:
    points = 1e5 * directions(4, 3)
    np.testing.assert_allclose(
        body.field(points), Point(body.mass).field(points), rtol=0.0, atol=1e-5 * body.mass * 1e-10
    )


@pytest.mark.parametrize("body", [CUBE, BODIES["lattice"]], ids=["cube", "lattice"])
def test_inside_the_trace_is_that_of_the_density(body: Prism | Lattice) -> None:
    """Poisson: minus four pi times the density."""
    density = 1.0 if body is CUBE else CELLS[2, 2, 2]
    trace = np.trace(body.gradient(np.array([[0.03, 0.05, 0.01]]))[0])
    assert trace == pytest.approx(-4.0 * np.pi * density, rel=1e-10)


@pytest.mark.parametrize("edges", [(1.0, 1.0, 1.0), (1.0, 1.3, 0.8), (1.0, 1.0, 1e-6), (1.0, 1e-3, 1e-3)], ids=str)
def test_a_prism_keeps_twelve_digits_from_half_an_edge_to_a_million(edges: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(5)
    away = np.exp(rng.uniform(np.log(0.5), np.log(1e6), 40))
    ways = directions(40, 6)
    ways[:9] = np.repeat(np.eye(3), 3, axis=0)
    body = Prism(tuple(-e / 2.0 for e in edges), tuple(e / 2.0 for e in edges), 1.0)  # type: ignore[arg-type]
    points = ways * away[:, None]
    for point, found in zip(points, body.field(points), strict=True):
        exact = cuboid_field(-point, edges)
        assert np.linalg.norm(found - exact) <= CLAIM * np.linalg.norm(exact), point


SINGULAR = {
    "face": (0.5, 0.1, 0.2),
    "edge": (0.5, 0.5, 0.2),
    "vertex": (0.5, 0.5, 0.5),
    "along an edge": (0.5, 0.5, 3.0),
    "in the plane of a face": (0.5, 2.0, 3.0),
    "centre": (0.0, 0.0, 0.0),
    "off an edge by the least": (0.5, 5e-324, 0.5),
    "off a face's plane by 1e-200": (1e-200, 0.5, 0.7),
}


@pytest.mark.parametrize("where", SINGULAR.values(), ids=SINGULAR)
def test_faces_edges_and_vertices_are_no_exception(where: tuple[float, float, float]) -> None:
    exact = cuboid_field(-np.array(where), (1.0, 1.0, 1.0))
    found = CUBE.field(np.array([where]))[0]
    np.testing.assert_allclose(found, exact, atol=1e-14)


@pytest.mark.parametrize("offset", [5e-324, 1e-310, 1e-165, 1e-150, 1e-80, 1e-20])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_offsets_whose_squares_vanish_are_no_exception(offset: float, axis: int) -> None:
    """A vertex in the origin, so that the offset survives; the field is that of the edge itself."""
    corner = Prism((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 1.0)
    on = np.array([[0.0, 0.0, 0.0]])
    on[0, (axis + 1) % 3] = 0.4
    off = on.copy()
    off[0, axis] = -offset
    np.testing.assert_allclose(corner.field(off), corner.field(on), atol=1e-15 + 60 * offset)


@pytest.mark.parametrize("edges", [(1.0, 1.3, 0.8), (1.0, 1.0, 1e-3)], ids=str)
def test_a_point_of_many_has_the_field_of_the_point_alone(edges: tuple[float, float, float]) -> None:
    """To the last bit, wherever a block or a share of the points ends: near ones, far ones and those on an edge."""
    body = Prism((0.0, 0.0, 0.0), edges, 2.0)
    rng = np.random.default_rng(7)
    points = directions(20_000, 8) * np.exp(rng.uniform(np.log(0.1), np.log(1e3), 20_000))[:, None]
    points[::50] = (0.5, 0.0, 0.0)
    found = body.field(points)
    some = np.r_[:100, 19_000:19_100]
    np.testing.assert_array_equal(found[some], [body.field(points[i : i + 1])[0] for i in some])


def triple(values: Iterable[float]) -> tuple[float, float, float]:
    x, y, z = values
    return x, y, z


@given(st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3), st.floats(0.1, 10.0), st.permutations(range(3)))
def test_scale_and_the_order_of_axes_change_nothing(where: list[float], scale: float, order: list[int]) -> None:
    body = Prism((-0.5, -0.4, -0.3), (0.5, 0.4, 0.3), 1.0)
    point = np.array([where])
    field = body.field(point)
    larger = Prism(triple(scale * v for v in body.lower), triple(scale * v for v in body.upper), 1.0)
    np.testing.assert_allclose(larger.field(scale * point), scale * field, atol=1e-13 * scale)
    other = Prism(triple(body.lower[i] for i in order), triple(body.upper[i] for i in order), 1.0)
    np.testing.assert_allclose(other.field(point[:, order]), field[:, order], atol=1e-13)
    np.testing.assert_allclose(body.field(-point), -field, atol=1e-13)


def test_the_mean_over_a_proof_mass_follows_the_second_order_rule() -> None:
    """Six digits of the difference, a kilogram at one metre and a proof mass of centimetres."""
    source = Point(1.0, (1.0, 0.0, 0.0))
    long, flat = ProofMass(0.03, 0.004), ProofMass(0.002, 0.02, 0.01)
    centre = np.zeros((1, 3))
    for shape in (long, flat):
        change = mean_field(source, shape, centre)[0, 0] - 1.0
        assert change == pytest.approx(0.5 * 6.0 * shape.second_order, rel=4e-3)  # f = x^-2, f'' = 6


@pytest.mark.parametrize("inner", [0.0, 0.01, 0.02])
def test_a_proof_mass_of_the_stated_length_is_a_point(inner: float) -> None:
    source = Point(1.0, (1.0, 0.2, 0.1))
    radius = 0.02
    shape = ProofMass(ProofMass(1.0, radius, inner).pointlike_length, radius, inner)
    assert shape.second_order == pytest.approx(0.0, abs=1e-18)
    field = mean_field(source, shape, np.zeros((1, 3)))
    np.testing.assert_allclose(field, source.field(np.zeros((1, 3))), rtol=1e-5)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Prism((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), np.inf), "density inf is not finite"),
        (lambda: ProofMass(0.0, 0.1), "length of the proof mass 0 is not above zero"),
        (lambda: Lattice(np.full((2, 2, 2), np.nan), (1.0, 1.0, 1.0)), "is not a lattice of finite numbers"),
        (lambda: Lattice(np.ones((2, 2, 2)), (1.0, 1.0, 1.0), (0.0, np.nan, 0.0)), "lower vertex .* nan is not finite"),
        (lambda: Prism((0.0, 0.0, 0.0), (1.0, -1.0, 1.0), 1.0), "extent of the prism along y -1 is not above zero"),
        (lambda: ProofMass(1.0, 0.1, 0.2), "inner radius 0.2 m is not between"),
        (lambda: ProofMass(1.0, 0.1, axis=(0.0, 0.0, 0.0)), "has no direction"),
        (lambda: Lattice(np.ones((2, 2)), (1.0, 1.0, 1.0)), "is not a lattice of finite numbers"),
        (lambda: Lattice(np.ones((2, 2, 2)), (1.0, 0.0, 1.0)), "edge of a cell along y 0 is not above zero"),
    ],
)
def test_what_has_no_attraction_is_refused(make: object, words: str) -> None:
    with pytest.raises(DataError, match=words):
        make()  # type: ignore[operator]
