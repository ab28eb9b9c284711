"""Placements of a sensor set down by hand: how long they must be, what is between them, disturbances inside."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.signals.segmentation.placements import (
    Placement,
    between,
    disturbed_inside,
    placements,
    shortest_placement,
)
from inertialcal.signals.segmentation.segments import detect

RATE = 100.0  # Hz
LEVELS = np.array([[0.0, 0, 9.8], [9.8, 0, 0], [0, 9.8, 0], [0, -9.8, 0], [-9.8, 0, 0], [0, 0, -9.8]])


def laid(seed: int = 1, rest: int = 600, move: int = 100, drift: float = 0.0) -> Array:
    """Six placements with ramps between them, noise 0.02, and a random walk."""
    rng = np.random.default_rng(seed)
    parts = []
    for k, level in enumerate(LEVELS):
        parts.append(np.tile(level, (rest, 1)))
        if k + 1 < len(LEVELS):
            share = np.linspace(0.0, 1.0, move)[:, None]
            parts.append((1.0 - share) * level + share * LEVELS[k + 1] + 0.3 * rng.normal(size=(move, 3)))
    x = np.vstack(parts)
    return np.asarray(x + 0.02 * rng.normal(size=x.shape) + drift * np.cumsum(rng.normal(size=x.shape), axis=0))


def placed(x: Array, rates: Array | None = None) -> tuple[Placement, ...]:
    return placements(detect(x, sample_interval=1.0 / RATE), 1.0, rates)


def turning(seed: int = 1) -> Array:
    """Rates of the turns of ``laid``, which begin and end slowly a third of a second earlier and later."""
    rng = np.random.default_rng(seed)
    rates = 2e-3 * rng.normal(size=(6 * 600 + 5 * 100, 3))
    for k in range(5):
        rates[k * 700 + 565 : k * 700 + 735, 1] += 1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, 170))
    return np.asarray(rates)


def test_what_is_between_placements_reaches_from_rest_to_rest() -> None:
    x = laid()
    found = placed(x)
    assert len(found) == 6
    for (start, stop), one, other in zip(between(found), found[:-1], found[1:], strict=True):
        assert (start, stop) == (one.stop - 1, other.start + 1)
        assert 200 <= stop - start <= 220  # half a second into both


def test_gyros_tell_where_a_slow_turn_begins_and_ends() -> None:
    """Where they rest one tenth of a second is enough; a turn that only they see is left out whole."""
    for one in placed(laid(), turning()):
        k = one.start // 700
        assert one.start >= (k * 700 + 34 if k else 0)
        assert k == 5 or one.stop <= k * 700 + 566
        assert one.stop - one.start >= 500
    at_rest = 2e-3 * np.random.default_rng(2).normal(size=turning().shape)
    assert all(one.stop - one.start >= 550 for one in placed(laid(), at_rest))


def test_a_turn_about_the_vertical_parts_two_placements_and_a_knock_none() -> None:
    x, rates = laid(), turning()
    middle = 2 * 700 + 300
    x[middle - 50 : middle + 50] += 0.5 * np.sin(np.arange(100))[:, None]
    assert len(placed(x, rates)) == 6
    rates[middle - 50 : middle + 50, 2] += 2.0
    assert len(placed(x, rates)) == 7


def test_a_placement_must_be_longer_where_noise_is_white_for_longer() -> None:
    white = shortest_placement(detect(laid(rest=3000), sample_interval=1.0 / RATE))
    drifting = shortest_placement(detect(laid(rest=3000, drift=1e-3), sample_interval=1.0 / RATE))
    assert drifting == 1.0  # never shorter than a hand that pauses
    assert drifting <= white <= 10.0


def test_a_quiet_record_has_no_disturbed_placement() -> None:
    for seed in range(1, 7):
        x = laid(seed)
        found = placed(x)
        assert not disturbed_inside(x, found).any()
        assert not any(one.touched for one in found)


@pytest.mark.parametrize("kind", ["step", "shaking"])
def test_a_disturbed_placement_is_found(kind: str) -> None:
    x = laid()
    found = placed(x)
    rng = np.random.default_rng(5)
    one = found[2]
    gyro = 0.001 * rng.normal(size=x.shape)  # what the accelerometers do not see
    if kind == "step":
        gyro[(one.start + one.stop) // 2 : one.stop, 1] += 0.002
    else:
        gyro[one.start : one.stop] *= 4.0
    assert np.flatnonzero(disturbed_inside(gyro, found)).tolist() == [2]


@pytest.mark.parametrize(("count", "inside"), [(30, False), (100, True)])
def test_a_disturbance_that_the_detector_cuts_out_is_counted(count: int, inside: bool) -> None:
    x = laid()
    middle = 2 * 700 + 300
    x[middle : middle + count] += 0.5 * np.sin(np.arange(count))[:, None]
    found = placed(x)
    assert len(found) == 6
    assert [one.touched > 0 for one in found] == [False, False, True, False, False, False]
    assert found[2].inside is inside


def test_no_sample_interval_is_refused() -> None:
    with pytest.raises(DataError, match="no sample interval") as error:
        shortest_placement(detect(laid()))
    assert error.value.problems[0].code == "no_time"


def test_never_still_is_refused() -> None:
    x = np.cumsum(np.random.default_rng(1).normal(size=(2000, 3)), axis=0)
    segmentation = detect(x, sample_interval=0.01)
    if not segmentation.still.any():
        with pytest.raises(DataError, match="never at rest"):
            shortest_placement(segmentation)
