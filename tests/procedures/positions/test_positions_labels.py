"""Names of positions against what is read there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.procedures.positions.orientations import check_names, check_sections, missing_faces, pointing
from inertialcal.procedures.positions.readings import Readings, Triad

FACES = np.vstack([np.eye(3), -np.eye(3)])
MIXED = np.array([[1.02, 0.03, -0.02], [-0.04, 0.97, 0.05], [0.01, -0.03, 1.05]])


@dataclass(frozen=True)
class Part:
    """A section."""

    start: int
    stop: int
    name: str


def readings(direction: Array, mean: Array, unit: str = "m/s^2") -> Readings:
    one = np.ones_like(mean)
    return Readings(acc=Triad(mean, 0.01 * one, 100.0 * one, unit), direction=direction)


@pytest.mark.parametrize(("size", "zero"), [(9.8, 0.3), (410.0, 33000.0)])
def test_directions_as_named_pass_whatever_unit_and_zero(size: float, zero: float) -> None:
    assert np.sum(pointing(size * FACES @ MIXED.T + zero) * FACES, axis=1).min() > 0.99
    check_names(readings(FACES, size * FACES @ MIXED.T + zero))
    five = np.delete(FACES, 1, axis=0)  # the middle of y is not its zero
    check_names(readings(five, size * five @ MIXED.T + zero))


@pytest.mark.parametrize("size", [9.8, -9.8])
def test_a_sign_that_is_turned_is_refused(size: float) -> None:
    direction = FACES if size < 0.0 else FACES * [-1.0, 1.0, 1.0]
    with pytest.raises(DataError, match="are misnamed") as caught:
        check_names(readings(direction, size * FACES))
    (problem,) = caught.value.problems
    assert ("All read the opposite" in problem.do) == (size < 0.0)
    assert problem.code == "position_misnamed"


def test_what_is_not_known_is_not_judged() -> None:
    direction = FACES.copy()
    direction[2] = np.nan
    check_names(readings(direction, 9.8 * FACES))
    check_names(replace(readings(FACES, 9.8 * FACES), direction=None))
    level = np.vstack([FACES[:2], FACES[3:5]])  # z is never turned: its zero is not told
    check_names(readings(level, 9.8 * level + [0.0, 0.0, 5.0]))


def test_missing_faces_are_named_where_all_lie_on_faces() -> None:
    assert missing_faces(readings(FACES, 9.8 * FACES)) == []
    (remark,) = missing_faces(readings(FACES[:4], 9.8 * FACES[:4]))
    assert "4 of the six faces, y-, z- missing" in remark.what
    tilted = np.vstack([FACES[:4], [[0.6, 0.8, 0.0]]])
    assert missing_faces(readings(tilted, 9.8 * tilted)) == []


@pytest.mark.parametrize(
    ("parts", "match"),
    [
        ([(0, 10), (9, 20)], "overlap"),
        ([(0, 10), (20, 101)], "samples 20 to 101, of 100"),
        ([(-1, 10)], "samples -1 to 10"),
        ([(5, 6)], "samples 5 to 6"),
    ],
)
def test_sections_outside_or_on_one_another_are_refused(parts: list[tuple[int, int]], match: str) -> None:
    with pytest.raises(DataError, match=match):
        check_sections([Part(a, b, "x_p") for a, b in parts], 100, "a.csv")


def test_sections_side_by_side_pass() -> None:
    check_sections([Part(10, 100, "x_p"), Part(0, 10, "x_a")], 100, "a.csv")
