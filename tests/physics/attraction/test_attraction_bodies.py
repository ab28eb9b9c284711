"""Closed forms, Laplace's equation, symmetry, and references of sixty digits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from cuboid_reference import cuboid_field
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.constants import REINEL_GRAVITATIONAL_CONSTANT
from inertialcal.core.errors import DataError
from inertialcal.physics.attraction import (
    Body,
    Composite,
    Cylinder,
    Lattice,
    Placed,
    Point,
    Prism,
    ProofMass,
    Ring,
    Sphere,
    attraction,
    attraction_gradient,
    mean_field,
)
from inertialcal.physics.attraction.field import G

CLAIM = 1e-12  # relative error of the field
SLOPE = 1e-6  # relative error of a difference quotient over 1e-4 of the distance
CUBE = Prism((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), 1.0)
TUBE = Cylinder(mass=3.0, radius=0.3, length=0.5, inner_radius=0.1, axis=(1.0, 2.0, 2.0), centre=(0.1, 0.0, -0.2))
CELLS = np.random.default_rng(1).uniform(1.0, 2.0, (3, 4, 5))
BODIES: dict[str, Body] = {
    "point": Point(2.0, (0.1, 0.0, -0.2)),
    "sphere": Sphere(2.0, 0.4, (0.1, 0.2, 0.0)),
    "prism": Prism((-0.3, -0.1, 0.0), (0.2, 0.4, 0.3), 5.0),
    "solid cylinder": Cylinder(mass=3.0, radius=0.3, length=0.5),
    "tube": TUBE,
    "ring": Ring(2.0, 0.25, (0.1, 0.0, -0.2), (1.0, 2.0, 2.0)),
    "lattice": Lattice(CELLS, (0.1, 0.12, 0.08), (-0.2, -0.2, -0.2)),
    "together": Composite((Point(1.0), Sphere(1.0, 0.1, (0.2, 0.2, 0.2)))),
    "placed": Placed(TUBE, (0.1, -0.1, 0.0), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])),
}


def directions(n: int, seed: int) -> np.ndarray:
    found = np.random.default_rng(seed).normal(size=(n, 3))
    return found / np.linalg.norm(found, axis=1)[:, None]  # type: ignore[no-any-return]


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("away", [0.8, 3.0, 40.0])
def test_the_gradient_is_that_of_the_field_symmetric_and_without_trace(body: Body, away: float) -> None:
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
def test_far_away_a_body_is_a_point_of_its_mass(body: Body) -> None:
    points = 1e5 * directions(4, 3)
    np.testing.assert_allclose(
        body.field(points), Point(body.mass).field(points), rtol=0.0, atol=1e-5 * body.mass * 1e-10
    )


@pytest.mark.parametrize(
    "body", [CUBE, BODIES["solid cylinder"], BODIES["lattice"]], ids=["cube", "cylinder", "lattice"]
)
def test_inside_the_trace_is_that_of_the_density(body: Body) -> None:
    """Poisson: minus four pi times the density."""
    density = {id(CUBE): 1.0, id(BODIES["lattice"]): CELLS[2, 2, 2]}.get(id(body), 3.0 / (np.pi * 0.09 * 0.5))
    trace = np.trace(body.gradient(np.array([[0.03, 0.05, 0.01]]))[0])
    assert trace == pytest.approx(-4.0 * np.pi * density, rel=1e-10)


def test_a_sphere_is_a_point_outside_and_linear_inside() -> None:
    sphere = Sphere(4.0, 0.5)
    np.testing.assert_allclose(sphere.field(np.array([[2.0, 0.0, 0.0]])), [[-1.0, 0.0, 0.0]], rtol=1e-15)
    np.testing.assert_allclose(sphere.field(np.array([[0.25, 0.0, 0.0]])), [[-8.0, 0.0, 0.0]], rtol=1e-15)


@pytest.mark.parametrize("distance", [1e-9, 0.005, 0.1, 1.0, 30.0])
def test_on_its_axis_a_cylinder_is_its_closed_form(distance: float) -> None:
    a, length = 0.1, 0.2
    whole = Cylinder(mass=np.pi * a**2 * length, radius=a, length=length)
    far, near = np.hypot(a, distance + length), np.hypot(a, distance)
    # L + near - far, without its cancellation
    expected = 2.0 * np.pi * (length - (far**2 - near**2) / (far + near))
    found = whole.field(np.array([[0.0, 0.0, -length / 2.0 - distance]]))[0]
    assert found[2] == pytest.approx(expected, rel=3e-16 * max(1e3, (distance / a) ** 3))
    assert found[:2] == pytest.approx([0.0, 0.0], abs=1e-12 * found[2])


def test_a_cylinder_off_its_axis_is_many_thin_prisms() -> None:
    """No closed form: a lattice of fine cells, whose edge on the rim leaves about a cell's share."""
    n = 121
    h = 2.0 / n
    x = (np.arange(n) + 0.5) * h - 1.0
    fine = np.mean([(x[:, None] + dx * h) ** 2 + (x[None, :] + dy * h) ** 2 < 1.0
                    for dx in np.linspace(-0.45, 0.45, 10) for dy in np.linspace(-0.45, 0.45, 10)], axis=0)  # fmt: skip
    body = Lattice(fine[:, :, None].astype(float), (h, h, 0.7), (-1.0, -1.0, -0.35))
    points = np.array([[1.3, 0.4, 0.2], [0.5, 0.1, 0.6], [0.2, -0.3, 0.1], [3.0, 1.0, 2.0]])
    whole = Cylinder(mass=body.mass, radius=1.0, length=0.7)
    np.testing.assert_allclose(whole.field(points), body.field(points), rtol=2e-4, atol=2e-4)


def test_near_and_far_cylinders_join() -> None:
    """Both sides of the distance at which the way of summing changes."""
    whole = BODIES["solid cylinder"]
    edge = 10.0 * np.hypot(0.3, 0.25)
    for way in directions(6, 4):
        pair = np.stack([way * edge * (1.0 - 1e-12), way * edge * (1.0 + 1e-12)])
        field, slope = whole.field(pair), whole.gradient(pair)
        np.testing.assert_allclose(field[0], field[1], atol=CLAIM * float(np.linalg.norm(field[0])))
        np.testing.assert_allclose(slope[0], slope[1], atol=1e-9 * np.abs(slope[0]).max())


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


def test_newtons_third_law_between_a_cylinder_and_a_point() -> None:
    """The mean over a cylinder of a point's field is the cylinder's field at the point, turned round."""
    shape = ProofMass(0.5, 0.3, 0.0, axis=(0.0, 0.0, 1.0))
    whole = Cylinder(mass=1.0, radius=0.3, length=0.5)
    at = np.array([0.5, 0.2, 0.9])
    np.testing.assert_allclose(
        mean_field(Point(1.0, tuple(at)), shape, np.zeros((1, 3)))[0], -whole.field(at[None])[0], rtol=1e-9
    )


def test_the_constant_is_the_callers() -> None:
    one = Point(1.0, (1.0, 0.0, 0.0))
    np.testing.assert_allclose(attraction(one, [0.0, 0.0, 0.0]), [G, 0.0, 0.0], rtol=1e-15)
    reinel = REINEL_GRAVITATIONAL_CONSTANT.value * 1e-3  # cm^3/(g s^2)
    np.testing.assert_allclose(attraction(one, [0.0, 0.0, 0.0], reinel), [reinel, 0.0, 0.0], rtol=1e-15)
    assert attraction_gradient(one, np.zeros((4, 5, 3))).shape == (4, 5, 3, 3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Sphere(1.0, 0.0), "radius 0 is not above zero"),
        (lambda: Sphere(1.0, np.inf), "radius inf is not finite"),
        (lambda: Sphere(np.nan, 1.0), "mass nan is not finite"),
        (lambda: Point(1.0, (0.0, np.nan, 0.0)), "centre of the point mass nan is not finite"),
        (lambda: Prism((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), np.inf), "density inf is not finite"),
        (lambda: Ring(1.0, np.nan), "radius nan is not finite"),
        (lambda: Cylinder(1.0, 0.1, -0.1), "length -0.1 is not above zero"),
        (lambda: Cylinder(1.0, 0.1, 0.1, centre=(0.0, 0.0, np.inf)), "centre of the cylinder inf is not finite"),
        (lambda: ProofMass(0.0, 0.1), "length of the proof mass 0 is not above zero"),
        (lambda: Lattice(np.full((2, 2, 2), np.nan), (1.0, 1.0, 1.0)), "is no lattice of finite numbers"),
        (lambda: Lattice(np.ones((2, 2, 2)), (1.0, 1.0, 1.0), (0.0, np.nan, 0.0)), "lower vertex .* nan is not finite"),
        (lambda: Prism((0.0, 0.0, 0.0), (1.0, -1.0, 1.0), 1.0), "extent of the prism along y -1 is not above zero"),
        (
            lambda: Cylinder(1.0, 0.1, 0.1, inner_radius=0.1),
            "inner radius 0.1 m is not between 0 and the radius, 0.1 m",
        ),
        (lambda: Cylinder(1.0, 0.1, 0.1, axis=(0.0, 0.0, 0.0)), "has no direction"),
        (lambda: ProofMass(1.0, 0.1, 0.2), "inner radius 0.2 m is not between"),
        (lambda: ProofMass(1.0, 0.1, axis=(0.0, 0.0, 0.0)), "has no direction"),
        (lambda: Lattice(np.ones((2, 2)), (1.0, 1.0, 1.0)), "is no lattice of finite numbers"),
        (lambda: Lattice(np.ones((2, 2, 2)), (1.0, 0.0, 1.0)), "edge of a cell along y 0 is not above zero"),
        (lambda: attraction(Point(1.0), [0.0, 0.0, 0.0]), "has no value in its own place"),
        (lambda: attraction_gradient(Point(1.0), [0.0, 0.0, 0.0]), "has no value in its own place"),
        (lambda: attraction(Point(1.0), [0.0, 1.0]), "are not triples of finite numbers"),
        (lambda: attraction(Point(1.0), [0.0, 1.0, np.nan]), "are not triples of finite numbers"),
    ],
)
def test_what_has_no_attraction_is_refused(make: object, words: str) -> None:
    with pytest.raises(DataError, match=words):
        make()  # type: ignore[operator]
