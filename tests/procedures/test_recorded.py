"""Sampling, saves and built-in test of a recording against stamps that were made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.key import Member
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.core.results import Row
from inertialcal.procedures.recorded import QUANTITIES, recorded_rows, saves_curve

N = 1000
INTERVAL = 2.0  # [s]


def recording(seconds: Array) -> Recording:
    stamps = np.round(seconds * SECOND).astype(np.int64)
    return Recording((Channel("x", np.zeros(len(stamps))),), stamps)


def found(seconds: Array, clock: Influence | None = None) -> dict[str, Row]:
    return {row.quantity: row for row in recorded_rows("one", recording(seconds), {}, None, clock)}


def saves(skipped: tuple[int, ...] = (), late: float = 0.0) -> Array:
    """Return stamps of a save every two seconds, without the skipped ones; the 500th and those after it are late."""
    times = INTERVAL * np.arange(N, dtype=float)
    times[500:] += late
    return np.delete(times, skipped)


def test_regular_saves() -> None:
    rows = found(saves())
    assert rows["save_interval"].value == pytest.approx(INTERVAL)
    assert rows["sample_rate"].value == pytest.approx(1.0 / INTERVAL)
    assert rows["longest_gap"].value == pytest.approx(INTERVAL)
    assert rows["skipped_saves"].value == 0.0
    assert rows["late_saves"].value == 0.0
    assert all(row.member == Member("recording", "one") for row in rows.values())


def test_stamps_are_off_by_their_last_decimal_and_not_by_their_steps() -> None:
    """Saves every two whole seconds are stamps of a second; those of 25 Hz are stamps of 10 ms."""
    for interval, resolution in ((2.0, 1.0), (10.0, 1.0), (0.04, 0.01), (60.0, 60.0)):
        u = found(interval * np.arange(float(N)))["longest_gap"].u
        assert u == pytest.approx(resolution / np.sqrt(6.0))


def test_skipped_and_late_saves_do_not_move_the_interval() -> None:
    rows = found(saves(skipped=(100, 300, 301), late=1.0))
    assert rows["save_interval"].value == pytest.approx(INTERVAL)
    assert rows["skipped_saves"].value == pytest.approx(3 / N)
    assert rows["skipped_saves"].reason.text == f"3 of {N} saves due"
    assert rows["late_saves"].value == pytest.approx(3 / (N - 4))  # of N - 3 saves: two steps with room, one late
    assert rows["longest_gap"].value == pytest.approx(3 * INTERVAL)


def test_the_rate_of_the_clock_stretches_every_time() -> None:
    own, stated = found(saves()), found(saves(), Influence(1e-3, "1"))
    for name, sign in (("save_interval", 1.0), ("sample_rate", -1.0), ("longest_gap", 1.0)):
        value = float(own[name].value or 0.0)
        assert own[name].reason.code == "own_clock"
        assert not stated[name].reason
        assert stated[name].shared["clock.rate"] == pytest.approx(sign * 1e-3 * value)
        assert float(stated[name].u or 0.0) >= 1e-3 * value


def test_intervals_hold_the_true_interval_of_jittered_stamps() -> None:
    true, hits = 0.0103, 0
    for seed in range(1, 201):
        rng = np.random.default_rng(seed)
        stamps = true * np.arange(300.0) + rng.normal(0.0, 2e-4, 300)
        interval = found(np.round(stamps, 4))["save_interval"].interval
        assert interval is not None
        hits += (interval.lo or 0.0) <= true <= (interval.hi or 0.0)
    assert hits >= 180  # of 200


def test_bursts_tell_nothing_of_skipped_saves() -> None:
    times = np.repeat(np.arange(100.0), 10)
    rows = found(times)
    assert rows["skipped_saves"].status == rows["late_saves"].status == "not_estimated"
    assert rows["skipped_saves"].reason.code == "bursts"


def test_without_time_nothing_is_estimated() -> None:
    bare = Recording((Channel("x", np.zeros(5)),), None)
    assert {row.reason.code for row in recorded_rows("one", bare, {}, None, None)} == {"no_time"}


def test_the_built_in_test_is_counted_and_missing_is_not_good() -> None:
    volts = np.array([4.2, 2.4, 2.39, np.nan, 4.2])
    rows = recorded_rows("one", recording(saves()[:5]), {"x": volts}, 2.4, None)
    (tested,) = (row for row in rows if row.quantity == "built_in_test")
    assert (tested.axis, tested.value) == ("x", 0.6)
    assert {row.quantity for row in rows} == set(QUANTITIES)


def test_how_often_it_was_saved_after_which_time() -> None:
    """As in the suite of 2011: saves every 2 s, some after 3, 5 and 6 s."""
    rng = np.random.default_rng(1)
    steps = rng.permutation(np.repeat([2.0, 3.0, 5.0, 6.0], [900, 17, 7, 2]))
    curve = saves_curve("one", recording(np.concatenate([[0.0], np.cumsum(steps)])))
    assert curve is not None
    assert (curve.name, curve.recording, curve.columns["length"].unit) == ("save_intervals", "one", "s")
    assert curve.columns["length"].plain() == [2.0, 3.0, 5.0, 6.0]
    assert curve.columns["count"].plain() == [900, 17, 7, 2]


@pytest.mark.parametrize("seconds", [saves(), np.zeros(5), np.zeros(1)])
def test_where_no_save_is_late_nothing_is_shown(seconds: Array) -> None:
    assert saves_curve("one", recording(seconds)) is None
