"""A body on a lattice is the sum of its cells, to twelve digits of the sum of their magnitudes."""

from __future__ import annotations

import numpy as np
import pytest
from cuboid_reference import cuboid_field
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.physics.attraction.bodies import Lattice, Prism

CLAIM = 1e-12


def sphere_of_cells(n: int) -> np.ndarray:
    at = np.arange(n) - (n - 1) / 2.0
    x, y, z = np.meshgrid(at, at, at, indexing="ij")
    return np.asarray(11340.0 * (x**2 + y**2 + z**2 < (n / 2.0) ** 2))


BODIES = {
    "random": np.random.default_rng(1).uniform(1e4, 1.2e4, (3, 3, 4)),
    "uniform": np.full((3, 3, 4), 11340.0),
    "sphere": sphere_of_cells(4),
    "of both signs": np.random.default_rng(2).normal(size=(3, 3, 3)),
    "one": np.ones((1, 1, 1)),
}


@pytest.mark.parametrize("density", BODIES.values(), ids=BODIES)
def test_twelve_digits_from_half_an_edge_to_a_million(density: np.ndarray) -> None:
    k = 0.0508
    body = Lattice(density, (k, k, k), (-0.1, -0.1, -0.1))
    centres, cells = body.cells
    rng = np.random.default_rng(3)
    points = centres.mean(axis=0) + k * np.exp(rng.uniform(np.log(0.5), np.log(1e6), 6))[:, None] * _ways(6)
    points[0] = centres[0] + 0.5 * k * np.array([1.0, 0.0, 0.0])
    for point, found in zip(points, body.field(points), strict=True):
        parts = cells[:, None] * np.array([cuboid_field(c - point, (k, k, k)) for c in centres])
        exact = np.array([_exact_sum(parts[:, axis]) for axis in range(3)])
        assert np.linalg.norm(found - exact) <= CLAIM * np.sum(np.linalg.norm(parts, axis=1)), point


def _ways(n: int) -> np.ndarray:
    found = np.random.default_rng(4).normal(size=(n, 3))
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


def _exact_sum(values: np.ndarray) -> float:
    from math import fsum

    return fsum(values)


def test_vertices_inside_uniform_material_drop_out() -> None:
    assert len(Lattice(np.full((10, 11, 12), 11340.0), (1.0, 1.0, 1.0)).vertices[1]) == 8
    assert len(Lattice(sphere_of_cells(20), (1.0, 1.0, 1.0)).vertices[1]) < sphere_of_cells(20).astype(bool).sum() / 4


@given(st.integers(0, 2**32 - 1))
def test_near_and_far_ways_agree_where_they_meet(seed: int) -> None:
    rng = np.random.default_rng(seed)
    density = rng.uniform(0.0, 1.0, (3, 3, 3)) * (rng.uniform(size=(3, 3, 3)) < 0.7)
    density[1, 1, 1] = 1.0
    body = Lattice(density, (1.0, 1.0, 1.0), (-1.5, -1.5, -1.5))
    way = rng.normal(size=3)
    way *= (body._reach - 3.0) / np.linalg.norm(way)
    points = np.stack([0.7 * way, 1.7 * way])
    assert body._near(points).tolist() == [True, False]
    parts = np.array([body.each(p) for p in points]) * density[None, ..., None]
    magnitudes = np.linalg.norm(parts, axis=-1).sum(axis=(1, 2, 3))
    errors = np.linalg.norm(body.field(points) - parts.sum(axis=(1, 2, 3)), axis=1)
    assert (errors <= CLAIM * magnitudes).all()


def test_each_cell_is_a_prism_of_density_one() -> None:
    body = Lattice(np.zeros((2, 3, 2)), (0.1, 0.2, 0.3), (1.0, 0.0, 0.0))
    point = np.array([0.9, 0.1, 0.2])
    found = body.each(point)
    one = Prism((1.1, 0.4, 0.3), (1.2, 0.6, 0.6), 1.0)
    np.testing.assert_allclose(found[1, 2, 1], one.field(point[None])[0], rtol=1e-12)
    assert not body.field(point[None]).any()
    assert not body.gradient(point[None]).any()


def test_the_gradient_is_the_sum_of_that_of_prisms() -> None:
    density = BODIES["random"]
    body = Lattice(density, (1.0, 1.0, 1.0))
    centres, cells = body.cells
    points = np.array([[-1.3, 2.2, 3.1], [30.0, 2.0, 1.0], [1e4, 1e3, 0.0]])
    prisms = [Prism(tuple(c - 0.5), tuple(c + 0.5), d) for c, d in zip(centres, cells, strict=True)]
    expected = sum(p.gradient(points) for p in prisms)
    sizes = np.abs(expected).max(axis=(1, 2))[:, None, None]
    np.testing.assert_allclose(body.gradient(points) / sizes, expected / sizes, atol=1e-10)


def test_many_points_side_by_side_are_those_one_by_one() -> None:
    body = Lattice(np.random.default_rng(5).uniform(size=(20, 20, 20)), (1.0, 1.0, 1.0))
    points = np.random.default_rng(6).uniform(-10.0, 30.0, (40, 3))
    together = body.field(points)
    np.testing.assert_array_equal(together, [body.field(p[None])[0] for p in points])
