"""Period in which the certificate of a standard is valid, as campaigns state it."""

from __future__ import annotations

import calendar
import re
from datetime import date

DAY = re.compile(r"(?<![0-9])([0-9]{4})(?:-([0-9]{2})(?:-([0-9]{2}))?)?(?![0-9])")


def period_of(valid: str) -> tuple[date, date] | None:
    """Return the first and last day that a text names; None where it names none, or more than two.

    Parameters
    ----------
    valid : str
        ``"2026-01-01 to 2027-01-01"``, ``"until 2026-06"``, ``"2026"``: a lone month or year stands for its last day,
        and the period began at any time.

    Examples
    --------
    >>> period_of("until 2026-06")
    (datetime.date(1, 1, 1), datetime.date(2026, 6, 30))
    """
    days = DAY.findall(valid)
    if not 1 <= len(days) <= 2:
        return None
    try:
        first = date.min if len(days) == 1 else _day(days[0], last=False)
        return first, _day(days[-1], last=True)
    except ValueError:
        return None


def _day(found: tuple[str, str, str], last: bool) -> date:
    year, month = int(found[0]), int(found[1] or ("12" if last else "1"))
    if found[2]:
        return date(year, month, int(found[2]))
    if not 1 <= month <= 12:
        raise ValueError(month)
    return date(year, month, calendar.monthrange(year, month)[1] if last else 1)
