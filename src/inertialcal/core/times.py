"""Instants as people write them: UTC, UNIX seconds, GMT day of the year, mission elapsed time, archive names.

All become nanoseconds since 1970 UTC, on a scale without leap seconds (as UNIX time). Days of the year count from
001; mission elapsed time counts from 000/00:00:00 at the start of the mission [1]_, so that 006/00:56 is six whole
days and 56 minutes after it. An instant without its zone or its origin is refused: nothing here is guessed.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996: rotations at MET 005/11:30, 006/00:56 and 006/01:06.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta

SECOND = 1_000_000_000  # [ns]
DAY = 86_400 * SECOND
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
EARLIEST, LATEST = 0, 4_102_444_800  # 1970 and 2100 [s]
CLOCK = r"(?P<hour>[0-9]{2}):(?P<minute>[0-9]{2})(?::(?P<second>[0-9]{2})(?:[.,](?P<part>[0-9]{1,9}))?)?"
DAY_OF_YEAR = re.compile(r"(?:GMT\s*)?(?P<year>[0-9]{4})[/:](?P<day>[0-9]{3})[/:T]" + CLOCK + "Z?", re.ASCII)
ELAPSED = re.compile(r"(?:MET\s*)?(?P<day>[0-9]{1,4})/" + CLOCK, re.ASCII)
ARCHIVE = re.compile(
    r"([0-9]{4})_([0-9]{2})_([0-9]{2})_([0-9]{2})_([0-9]{2})_([0-9]{2})(?P<part>\.[0-9]{1,9})?", re.ASCII
)
FRACTION = re.compile(
    r"(?<=:[0-9]{2}:[0-9]{2})[.,](?P<part>[0-9]{1,9})(?![0-9])", re.ASCII
)  # datetime keeps six digits


class NoMissionStartError(ValueError):
    """Mission elapsed time, where nobody said when the mission started."""


def read_instant(given: object, mission_start: int | None = None) -> int:
    """Return UTC nanoseconds since 1970.

    Parameters
    ----------
    given : str, int, float or datetime
        ``"2010-04-28T15:10:00Z"`` (or with an offset); UNIX seconds; GMT day of the year
        ``"2014/295/09:36:36"`` or ``"2014:295:09:36:36"``; mission elapsed time ``"006/00:56:24"``; or as the names
        of archive files have it, ``"2014_10_22_09_36_36.324"`` (UTC).
    mission_start : int, optional
        Instant at which mission elapsed time is zero [ns since 1970 UTC]; elapsed time is refused without it.

    Raises
    ------
    ValueError
        If it is none of these; if it has no offset from UTC or no start of the mission; if there is no such day or
        time; if the number of digits fits no epoch; if it lies outside 1970 to 2100.

    Examples
    --------
    >>> read_instant("2014/295/09:36:36") == read_instant("2014-10-22T09:36:36Z")
    True
    >>> launch = read_instant("2014-01-01T12:00:00Z")
    >>> read_instant("006/00:56", mission_start=launch) == read_instant("2014-01-07T12:56:00Z")
    True
    """
    if isinstance(given, str):
        return _in_range(_from_text(given.strip(), mission_start), given)
    if isinstance(given, datetime):
        return _in_range(_from_datetime(given, str(given)), str(given))
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise ValueError(f'{given!r} is no time: write "2010-04-28T15:10:00Z" or UNIX seconds')
    if not EARLIEST <= given <= LATEST:
        digits = len(str(abs(int(given)))) if abs(given) < 1e300 else 0
        hint = " (11 digits: neither s nor ms; a digit too many?)" if digits == 11 else ""
        raise ValueError(f"{given} is no UNIX time in seconds: it lies outside 1970 to 2100{hint}")
    return round(given * SECOND)


def read_elapsed(given: object) -> int:
    """Return nanoseconds since a time zero that the file or the mission has.

    Parameters
    ----------
    given : str, int or float
        Seconds, or mission elapsed time ``"006/00:56:24"``.

    Raises
    ------
    ValueError
        If it is neither, or there is no such time of day.
    """
    match = ELAPSED.fullmatch(given.strip()) if isinstance(given, str) else None
    if match:
        return int(match["day"]) * DAY + _time_of_day(match, str(given))
    try:
        if isinstance(given, str) and "_" in given:  # Python takes it as a separator of digits
            raise ValueError
        return round(float(given) * SECOND)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{given!r} is no elapsed time: write seconds, or DDD/HH:MM:SS like 006/00:56:24") from None


def instant_text(instant: int) -> str:
    """Return UTC nanoseconds since 1970 as text that ``read_instant`` takes, with the digits it needs.

    Examples
    --------
    >>> instant_text(read_instant("2010-04-28T15:10:00.5Z"))
    '2010-04-28T15:10:00.5Z'
    """
    whole, fraction = _whole(instant)
    return f"{whole:%Y-%m-%dT%H:%M:%S}{fraction}Z"


def day_of_year_text(instant: int) -> str:
    """Return UTC nanoseconds since 1970 as GMT day of the year, with the digits it needs.

    Examples
    --------
    >>> day_of_year_text(read_instant("2014-10-22T09:36:36.324Z"))
    '2014/295/09:36:36.324'
    """
    whole, fraction = _whole(instant)
    return f"{whole:%Y/%j/%H:%M:%S}{fraction}"


def elapsed_text(elapsed: int) -> str:
    """Return nanoseconds since the start of a mission as DDD/HH:MM:SS, with the digits it needs.

    Raises
    ------
    ValueError
        If it lies before the start.

    Examples
    --------
    >>> elapsed_text(521_784 * 10**9)
    '006/00:56:24'
    """
    if elapsed < 0:
        raise ValueError(f"{elapsed / SECOND:.9g} s lies before the start of the mission")
    days, rest = divmod(elapsed, DAY)
    whole, fraction = _whole(rest)
    return f"{days:03d}/{whole:%H:%M:%S}{fraction}"


def _from_text(given: str, mission_start: int | None) -> int:
    if match := DAY_OF_YEAR.fullmatch(given):
        year, day = int(match["year"]), int(match["day"])
        if not year:
            raise ValueError(f"{given!r}: there is no year 0000")
        first = datetime(year, 1, 1, tzinfo=UTC)
        days = (first.replace(month=12, day=31) - first).days + 1
        if not 1 <= day <= days:
            raise ValueError(f"{given!r}: day {day:03d} of {year}, which has days 001 to {days}")
        return ((first - EPOCH).days + day - 1) * DAY + _time_of_day(match, given)
    if match := ELAPSED.fullmatch(given):
        if mission_start is None:
            raise NoMissionStartError(
                f"{given!r} is mission elapsed time, but when the mission started is not said: "
                "say it, or write UTC or GMT with its year (2014/295/09:36:36)"
            )
        return mission_start + int(match["day"]) * DAY + _time_of_day(match, given)
    if match := ARCHIVE.fullmatch(given):
        given = "{}-{}-{}T{}:{}:{}".format(*match.groups()[:6]) + (match["part"] or "") + "Z"
    return _from_iso(given)


def _from_iso(given: str) -> int:
    match = FRACTION.search(given)
    part = int(match["part"].ljust(9, "0")) if match else 0
    try:
        instant = datetime.fromisoformat(FRACTION.sub("", given))
    except ValueError:
        raise ValueError(
            f'{given!r} is no time: write "2010-04-28T15:10:00Z", or GMT with the day of the year, "2014/295/09:36:36"'
        ) from None
    return _from_datetime(instant, given) + part


def _from_datetime(instant: datetime, given: str) -> int:
    if instant.tzinfo is None:
        raise ValueError(f"{given!r} does not say its time zone: add Z for UTC, or an offset")
    since = instant - EPOCH
    return (since.days * 86_400 + since.seconds) * SECOND + since.microseconds * 1000


def _time_of_day(match: re.Match[str], given: str) -> int:
    """Nanoseconds since midnight."""
    hour, minute, second = int(match["hour"]), int(match["minute"]), int(match["second"] or 0)
    for value, name, most in ((hour, "hour", 23), (minute, "minute", 59), (second, "second", 59)):
        if value > most:
            raise ValueError(f"{given!r}: there is no {name} {value}, only 00 to {most}")
    return ((hour * 60 + minute) * 60 + second) * SECOND + int((match["part"] or "").ljust(9, "0"))


def _in_range(instant: int, given: str) -> int:
    if not EARLIEST * SECOND <= instant <= LATEST * SECOND:
        raise ValueError(f"{given!r} lies outside 1970 to 2100")
    return instant


def _whole(instant: int) -> tuple[datetime, str]:
    """Instant to the second, and the rest as text."""
    seconds, part = divmod(instant, SECOND)
    return EPOCH + timedelta(seconds=seconds), f".{part:09d}".rstrip("0") if part else ""
