"""Instants: every way to write them means the same time; what cannot be is refused in its own words."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.times import (
    DAY,
    LATEST,
    SECOND,
    day_of_year_text,
    elapsed_text,
    instant_text,
    read_elapsed,
    read_instant,
)

LAUNCH = read_instant("1994-03-04T13:53:00Z")
INSTANTS = st.integers(0, LATEST * SECOND)


def test_text_and_number_are_the_same_instant() -> None:
    assert read_instant("2010-04-28T15:10:00Z") == read_instant(1272467400) == 1272467400 * 10**9
    assert read_instant("2010-04-28T17:10:00+02:00") == read_instant(1272467400.0)
    assert read_instant("1970-01-01T00:00:00.000001Z") == 1000
    assert read_instant(datetime(2010, 4, 28, 15, 10, tzinfo=UTC)) == read_instant(1272467400)


def test_nanoseconds_are_kept() -> None:
    assert read_instant("1970-01-01T00:00:00.123456789Z") == 123_456_789
    assert read_instant("1970-01-01T00:00:00,5Z") == SECOND // 2


@pytest.mark.parametrize(
    "text", ["2014/295/09:36:36.324", "2014:295:09:36:36.324", "GMT 2014/295/09:36:36.324", "2014/295T09:36:36.324Z"]
)
def test_day_of_the_year_is_the_date(text: str) -> None:
    # 22 October is day 295 of 2014: 273 days to the end of September, and 22.
    assert read_instant(text) == read_instant("2014-10-22T09:36:36.324Z") == read_instant("2014_10_22_09_36_36.324")


def test_leap_years_have_a_day_more() -> None:
    assert read_instant("2016/366/00:00") == read_instant("2016-12-31T00:00:00Z")
    assert read_instant("2016/060/00:00") == read_instant("2016-02-29T00:00:00Z")


@pytest.mark.parametrize(
    ("text", "seconds"), [("005/11:30", 473400), ("006/00:56", 521760), ("006/00:56:24", 521784), ("006/01:06", 522360)]
)
def test_mission_elapsed_time_of_the_published_flips(text: str, seconds: int) -> None:
    # NASA TM-106980: whole days and time of day since the start.
    assert read_elapsed(text) == seconds * SECOND
    assert read_instant(text, LAUNCH) == read_instant(f"MET {text}", LAUNCH) == LAUNCH + seconds * SECOND


@given(INSTANTS)
def test_what_is_written_reads_back(instant: int) -> None:
    assert read_instant(instant_text(instant)) == instant
    assert read_instant(day_of_year_text(instant)) == instant
    assert read_elapsed(elapsed_text(instant % (9999 * DAY))) == instant % (9999 * DAY)


@given(st.integers(0, 100 * DAY))
def test_mission_time_reads_back_with_its_start(elapsed: int) -> None:
    assert read_instant(elapsed_text(elapsed), LAUNCH) == LAUNCH + elapsed


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (12833581390, "11 digits: neither s nor ms"),  # thesis, Appendix B, FL2-2c (errata)
        (1272467400000, "no UNIX time in seconds"),
        (-5, "no UNIX time in seconds"),
        (float("nan"), "no UNIX time in seconds"),
        ("2010-04-28T15:10:00", "does not say its time zone"),
        ("yesterday", "'yesterday' is no time"),
        ("2010-04-28T15:10:00.1234567891Z ago", "is no time"),
        (True, "True is no time"),
        (None, "None is no time"),
        ("2015/366/00:00", "day 366 of 2015, which has days 001 to 365"),
        ("2015/000/00:00", "day 000 of 2015"),
        ("0000/001/00:00", "there is no year 0000"),
        ("2014/295/24:00:00", "there is no hour 24, only 00 to 23"),
        ("2014/295/23:60", "there is no minute 60"),
        ("2014/295/23:59:60", "there is no second 60"),
        ("2014/295", "is no time"),
        ("006/00:56:24", "when the mission started is not said"),
        ("2014_13_22_09_36_36", "is no time"),
        ("2214/001/00:00", "outside 1970 to 2100"),
        ("1969-12-31T23:59:59Z", "outside 1970 to 2100"),
    ],
)
def test_what_is_no_instant_is_refused(given: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        read_instant(given)


def test_elapsed_seconds() -> None:
    assert read_elapsed(12.5) == read_elapsed("12.5") == 12_500_000_000


@pytest.mark.parametrize("given", ["noon", None, float("nan"), float("inf"), "2014_10_22"])
def test_what_is_no_elapsed_time_is_refused(given: object) -> None:
    with pytest.raises(ValueError, match="is no elapsed time: write seconds, or DDD/HH:MM:SS"):
        read_elapsed(given)


def test_elapsed_time_of_no_day() -> None:
    with pytest.raises(ValueError, match="there is no hour 25"):
        read_elapsed("006/25:00")
    with pytest.raises(ValueError, match="-1 s lies before the start of the mission"):
        elapsed_text(-SECOND)
