"""Stamps: against Python's own calendar, and numbers whose digits are wrong."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.files.time.stamps import beyond_epoch, digits, epoch_unit, from_iso, is_utc, looks_iso, to_ns

NOW = 1_283_358_139  # 2010-09-01T16:22:19Z


@given(st.datetimes(datetime(1900, 1, 1), datetime(2199, 12, 31)), st.integers(-14 * 60, 14 * 60))
def test_iso_8601_as_the_calendar_has_it(moment: datetime, offset: int) -> None:
    there = moment.replace(tzinfo=timezone(timedelta(minutes=offset)))
    since = there - datetime(1970, 1, 1, tzinfo=UTC)
    expected = (since.days * 86_400 + since.seconds) * 10**9 + since.microseconds * 1000
    times, naive, bad = from_iso(np.array([there.isoformat()], dtype=object))
    assert (times.tolist(), naive, bad.tolist()) == ([expected], 0, [])


def test_ways_to_write_one_instant() -> None:
    cells = [
        "2010-09-01T16:22:19Z",
        "2010-09-01 16:22:19",
        "2010-09-01T16:22:19.000000000 UTC",
        "2010-09-01T18:22:19+0200",
    ]
    times, naive, bad = from_iso(np.array(cells, dtype=object))
    assert set(times.tolist()) == {NOW * 10**9}
    assert (naive, len(bad)) == (1, 0)
    assert from_iso(np.array(["2010-09-01T16:22:19,123456789Z"]))[0][0] == NOW * 10**9 + 123_456_789


def test_what_is_no_instant() -> None:
    cells = [
        "2010-09-01",
        "2010-02-30T00:00:00Z",
        "12:00:00",
        "2010-09-01T25:00Z",
        "9999-01-01T00:00Z",
        "2010-09-01T16:22Z",
    ]
    assert from_iso(np.array(cells, dtype=object))[2].tolist() == [0, 1, 2, 3, 4]


def test_dates_are_told_by_the_first_and_the_last_cell() -> None:
    assert looks_iso(np.array(["2010-09-01T16:22:19", "x", "2010-09-01T16:22:20"], dtype=object))
    assert not looks_iso(np.array(["2010-09-01T16:22:19", "x"], dtype=object))
    assert not looks_iso(np.array([], dtype=object))


@pytest.mark.parametrize(("unit", "power"), [("s", 0), ("ms", 3), ("us", 6), ("ns", 9)])
def test_epochs_are_told_by_their_digits(unit: str, power: int) -> None:
    assert epoch_unit(np.array([NOW * 10**power, (NOW + 60) * 10**power])) == unit


def test_other_numbers_are_no_epoch() -> None:
    for numbers in ([0, 1, 2], [12_833_581_390], [NOW, NOW * 1000], []):
        assert epoch_unit(np.array(numbers)) is None


def test_surplus_digits() -> None:
    assert beyond_epoch(np.array([NOW, 12_833_581_390, NOW])).tolist() == [1]
    assert digits(12_833_581_390) == digits(-12_833_581_390.5) == 11


@given(st.integers(-(4 * 10**9), 4 * 10**9))
def test_whole_seconds_are_exact(seconds: int) -> None:
    for values in (np.array([seconds]), np.array([float(seconds)])):
        stamps = to_ns(values, "s")
        assert stamps is not None
        assert stamps.tolist() == [seconds * 10**9]


def test_fractions_of_an_epoch_keep_what_float64_holds() -> None:
    stamps = to_ns(np.array([NOW + 0.25, NOW + 2.0**-20]), "s")
    assert stamps is not None
    assert stamps.tolist() == [NOW * 10**9 + 250_000_000, NOW * 10**9 + 954]


def test_other_units() -> None:
    for value, unit, expected in ((1.5, "min", 90 * 10**9), (7, "ns", 7), (3, "us", 3000), (0.5, "h", 1800 * 10**9)):
        stamps = to_ns(np.array([value]), unit)
        assert stamps is not None
        assert stamps.tolist() == [expected]


def test_stamps_that_do_not_fit() -> None:
    assert to_ns(np.array([1e10]), "s") is None
    assert to_ns(np.array([-(2**63)]), "us") is None


def test_utc_is_2001_to_2099() -> None:
    assert is_utc(np.array([NOW * 10**9]))
    assert not is_utc(np.array([NOW]))


def test_stamps_that_are_no_numbers_have_no_nanoseconds() -> None:
    assert to_ns(np.array([1.0, np.nan]), "s") is None
