"""Two-line elements of a low orbit, and the positions that they mean: by the package sgp4, turned in another way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DAY = 86_400.0  # [s]
JD_2026_03_01 = 2_461_100.5
MARCH = 60  # day of the year 2026 that 1 March is


def with_sum(line: str) -> str:
    """Return a line of 68 characters with the digit that its sum asks for."""
    assert len(line) == 68, len(line)
    return line + str((sum(map(int, filter(str.isdigit, line))) + line.count("-")) % 10)


def two_lines(rng: np.random.Generator, age: float = 0.0, number: int = 44332) -> tuple[str, str]:
    """Return elements of an orbit at some 560 km whose epoch lies so many days before 2026-03-01."""
    epoch = MARCH - age
    inclination, node, perigee, anomaly = 24.0 + rng.uniform(0, 70), *rng.uniform(0.0, 360.0, 3)
    first = f"1 {number:05d}U 19036F   26{epoch:012.8f}  .00002182  00000-0  11606-3 0  999"
    second = f"2 {number:05d} {inclination:8.4f} {node:8.4f} 0012345 {perigee:8.4f} {anomaly:8.4f} "
    second += f"15.05{rng.integers(10**6):06d}12345"
    return with_sum(first), with_sum(second)


def positions(lines: tuple[str, str], seconds: Array) -> tuple[Array, Array]:
    """Return earth-fixed positions [m] and the directions along the orbit, shapes (n, 3), from 2026-03-01 on."""
    from sgp4.api import Satrec

    wrong, r, v = Satrec.twoline2rv(*lines).sgp4_array(np.full(len(seconds), JD_2026_03_01), seconds / DAY)
    assert not np.any(wrong)
    days = JD_2026_03_01 - 2_451_545.0 + seconds / DAY
    theta = np.radians((280.46061837 + 360.98564736629 * days + 0.000387933 * (days / 36_525.0) ** 2) % 360.0)
    c, s, zero, one = np.cos(theta), np.sin(theta), np.zeros_like(theta), np.ones_like(theta)
    turn = np.moveaxis(np.array([[c, s, zero], [-s, c, zero], [zero, zero, one]]), -1, 0)
    along = np.einsum("kij,kj->ki", turn, v / np.linalg.norm(v, axis=1)[:, None])
    return np.einsum("kij,kj->ki", turn, r) * 1e3, along
