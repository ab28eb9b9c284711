"""Speed against harmonica, three components, the faster of its serial and its parallel mode taken; and agreement."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np
import pytest

from inertialcal.physics.attraction import Lattice
from inertialcal.physics.attraction.field import G
from inertialcal.physics.mass_shape import Grid, best_cells

MGAL = 1e-5  # m/s^2
ROUNDS = 7
AGREED = 1e-11  # of the largest field: harmonica loses digits with distance
EDGE = 0.0508
FIELDS = ("g_e", "g_n", "g_z")  # g_z is positive downward


@dataclass(frozen=True)
class Case:
    """A body, points, and the least ratio to harmonica."""

    body: Lattice
    points: np.ndarray
    least: float


def random_body(*shape: int) -> Lattice:
    density = np.random.default_rng(1).uniform(1e4, 1.2e4, shape)
    return Lattice(density, (EDGE,) * 3, (0.0762, -shape[1] * EDGE / 2.0, -shape[2] * EDGE / 2.0))


def cases() -> dict[str, Callable[[], Case]]:
    here = np.zeros((1, 3))
    around = np.random.default_rng(2).uniform(-1.0, 0.0, (1000, 3))
    return {
        "4,000 cells, 1 point": lambda: Case(random_body(10, 20, 20), here, 10.0),
        "1e6 cells, 1 point": lambda: Case(random_body(100, 100, 100), here, 10.0),
        "1e4 cells, 1e3 points": lambda: Case(random_body(10, 25, 40), around, 8.0),
        "best 900 cells, 1 point": lambda: Case(best_cells(Grid(EDGE, (10, 20, 20), 0.0762, 11340.0), 900), here, 30.0),
    }


def harmonica_of(case: Case) -> Callable[[bool], np.ndarray]:
    """Make a function parallel -> field (n, 3) [m/s^2]; easting, northing and up stand for x, y and z."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import harmonica

    centres, density = case.body.cells
    half = EDGE / 2.0
    prisms = np.stack([centres - half, centres + half], axis=2).reshape(-1, 6)
    at = tuple(np.ascontiguousarray(case.points[:, i]) for i in range(3))

    def found(parallel: bool) -> np.ndarray:
        parts = [harmonica.prism_gravity(at, prisms, density, field=f, parallel=parallel) for f in FIELDS]
        return MGAL * np.stack([parts[0], parts[1], -parts[2]], axis=1)  # type: ignore[no-any-return]

    return found


@pytest.mark.parametrize("name", ["4,000 cells, 1 point", "best 900 cells, 1 point"])
def test_the_oracle_agrees(name: str) -> None:
    case = cases()[name]()
    peer = harmonica_of(case)(False)
    np.testing.assert_allclose(G * case.body.field(case.points), peer, atol=AGREED * np.abs(peer).max(), rtol=2e-5 * 0)


def seconds(work: Callable[[], Any]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


@pytest.mark.bench
@pytest.mark.parametrize("name", cases())
def test_faster_than_harmonica(benchmark: Any, name: str) -> None:
    case = cases()[name]()
    peer = harmonica_of(case)
    reference = peer(False)
    peer(True)
    np.testing.assert_allclose(G * case.body.field(case.points), reference, atol=AGREED * np.abs(reference).max())
    serial, parallel = [], []

    def setup() -> None:
        """Between any two rounds the peer has its turn."""
        serial.append(seconds(lambda: peer(False)))
        parallel.append(seconds(lambda: peer(True)))

    benchmark.pedantic(case.body.field, (case.points,), setup=setup, rounds=ROUNDS)
    own, theirs = benchmark.stats.stats.median, min(median(serial), median(parallel))
    print(f"\n{name}: {own * 1e3:.3f} ms, harmonica {theirs * 1e3:.3f} ms, ratio {theirs / own:.1f}")
    assert theirs / own >= case.least
