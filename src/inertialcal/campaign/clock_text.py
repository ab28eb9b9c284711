"""Instants of a campaign file: ISO 8601 with an offset, or UNIX seconds."""

from __future__ import annotations

from datetime import UTC, datetime

SECOND = 1_000_000_000  # [ns]
EARLIEST, LATEST = 0, 4_102_444_800  # 1970 and 2100 [s]


def read_instant(given: object) -> int:
    """Return UTC nanoseconds since 1970.

    Parameters
    ----------
    given : str, int, float or datetime
        ``"2010-04-28T15:10:00Z"`` or UNIX seconds.

    Raises
    ------
    ValueError
        If it is neither; if it has no offset from UTC; if the number of digits fits no epoch.
    """
    if isinstance(given, str):
        return _from_text(given)
    if isinstance(given, datetime):
        return _from_datetime(given, str(given))
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise ValueError(f'{given!r} is no time: write "2010-04-28T15:10:00Z" or UNIX seconds')
    if not EARLIEST <= given <= LATEST:
        digits = len(str(abs(int(given)))) if abs(given) < 1e300 else 0
        hint = " (11 digits: neither s nor ms; a digit too many?)" if digits == 11 else ""
        raise ValueError(f"{given} is no UNIX time in seconds: it lies outside 1970 to 2100{hint}")
    return round(given * SECOND)


def instant_text(instant: int) -> str:
    """Return UTC nanoseconds since 1970 as text that ``read_instant`` takes, with the digits it needs.

    Examples
    --------
    >>> instant_text(read_instant("2010-04-28T15:10:00.5Z"))
    '2010-04-28T15:10:00.5Z'
    """
    whole, part = divmod(instant, SECOND)
    fraction = f".{part:09d}".rstrip("0") if part else ""
    return f"{datetime.fromtimestamp(whole, UTC):%Y-%m-%dT%H:%M:%S}{fraction}Z"


def _from_text(given: str) -> int:
    try:
        instant = datetime.fromisoformat(given)
    except ValueError:
        raise ValueError(f'{given!r} is no time: write "2010-04-28T15:10:00Z"') from None
    return _from_datetime(instant, given)


def _from_datetime(instant: datetime, given: str) -> int:
    if instant.tzinfo is None:
        raise ValueError(f"{given!r} does not say its time zone: add Z for UTC, or an offset")
    since = instant - datetime(1970, 1, 1, tzinfo=UTC)
    return (since.days * 86_400 + since.seconds) * SECOND + since.microseconds * 1000
