"""Where a satellite was by its two-line elements (TLE): earth-fixed positions, and how well they are known.

Elements are propagated by SGP4 (package ``sgp4``, extra ``orbit``), the model that they were fitted with [1]_. It gives
positions in axes of the true equator and mean equinox of date (TEME); a turn about the pole by the mean sidereal time
of 1982 makes them earth-fixed. Two things are left out there: UT1 is taken for UTC (0.9 s apart at most: 0.46 km along
a parallel at 560 km), and the pole for the axis of the earth (20 m).

Elements state no uncertainty. In low orbits positions are good to about 1 km at their epoch, and run off by 1 to 3 km
a day along the orbit [1]_; taken here: 1 km each way, and 2 km a day along the orbit, before the epoch as after it.
That is no law beyond some days, when drag decides: elements older than `MOST_AGE` are refused.

References
----------
.. [1] D. A. Vallado, P. Crawford, R. Hujsak, T. S. Kelso, AIAA 2006-6753: Revisiting Spacetrack Report #3, with
   examples of TEME and earth-fixed positions in its appendix C.
.. [2] S. Aoki et al., Astron. Astrophys. 105 (1982) 359: mean sidereal time.
"""

from __future__ import annotations

import importlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np

from ..core.errors import DataError
from ..core.estimate import Array
from ..core.recording import SECOND
from ..core.show.rounding import number

DAY = 86_400.0  # [s]
MOST_AGE = 7.0  # [d] between epoch and record
AT_EPOCH, A_DAY = 1e3, 2e3  # standard uncertainty of a position: each way [m]; along the orbit, a day of age [m]
SIDEREAL = 2.7e2  # of a position across meridians: UT1 - UTC is within 0.9 s, all as likely [m]
WIDTH = 69  # of a line
EPOCH_1957 = 57  # two digits of a year from which it is of the last century
J2000 = 946_728_000  # 2000-01-01 12:00 UTC [s since 1970]
UNIX_EPOCH = 2_440_587.5  # Julian date
WHAT = {1: "mean eccentricity out of range", 2: "mean motion below zero", 3: "eccentricity out of range",
        4: "semi-latus rectum below zero", 6: "the satellite has decayed"}  # fmt: skip


@dataclass(frozen=True)
class Elements:
    """One set of two lines."""

    name: str  # that of the line before; empty where there is none
    number: str  # of the catalogue
    first: str
    second: str
    epoch_ns: int  # UTC [ns since 1970]
    where: str = ""  # file and line

    @property
    def called(self) -> str:
        """As people call the satellite."""
        return f"{self.name} ({self.number})" if self.name else self.number


@dataclass(frozen=True, eq=False)
class Track:
    """Positions by elements."""

    position: Array  # shape (n, 3): earth-fixed [m]
    directions: Array  # shape (n, 3, 3): along the orbit, across it, up; each as a column, earth-fixed
    u: Array  # shape (3,): standard uncertainty along these [m]
    speed: float  # along the orbit [m/s]
    age: float  # of the elements, the most over the track [d]
    elements: Elements


def parse_elements(text: str, file: str = "") -> tuple[Elements, ...]:
    """Return all sets of elements of a text, each with the name that stands before it.

    Raises
    ------
    DataError
        ``elements``: no set, a line that is cut off or lacks its partner, a checksum or a figure that is wrong.
    """
    lines = [(k, line.rstrip()) for k, line in enumerate(text.lstrip("\ufeff").splitlines(), 1)]
    lines = [(k, line) for k, line in lines if line and not line.startswith("#")]
    found, name, at = [], "", 0
    while at < len(lines):
        k, line = lines[at]
        if not line.startswith("1 "):
            if line.startswith("2 "):
                raise _wrong(file, k, "line 2 of elements without its line 1 before it")
            name, at = line.removeprefix("0 ").strip(), at + 1
            continue
        if at + 1 == len(lines) or not lines[at + 1][1].startswith("2 "):
            raise _wrong(file, k, "line 1 of elements without its line 2 after it")
        found.append(_set_of(name, (k, line), lines[at + 1], file))
        name, at = "", at + 2
    if not found:
        why = "two lines are needed that begin with 1 and 2, as catalogues of satellites have them"
        raise DataError("no two-line elements", file, why, "Give a file of two-line elements (TLE)", "elements")
    return tuple(found)


def _wrong(file: str, line: int, what: str, do: str = "") -> DataError:
    return DataError(what, f"{file}:{line}", "a wrong digit moves the orbit by many kilometres",
                     do or "Take the elements again, as the catalogue has them", "elements")  # fmt: skip


def _set_of(name: str, first: tuple[int, str], second: tuple[int, str], file: str) -> Elements:
    for place, line in (first, second):
        if len(line) != WIDTH:
            raise _wrong(file, place, f"a line of elements has {len(line)} characters, need {WIDTH}")
        if checksum(line) != line[-1]:
            raise _wrong(file, place, f"checksum {line[-1]}; the line adds up to {checksum(line)}")
    one, two = first[1], second[1]
    if one[2:7] != two[2:7]:
        what = f"two lines of different satellites: {one[2:7].strip()} and {two[2:7].strip()}"
        raise _wrong(file, second[0], what)
    try:
        year, day = int(one[18:20]), float(one[20:32])
        figures = [float(two[a:b]) for a, b in ((8, 16), (17, 25), (34, 42), (43, 51), (52, 63))]
        eccentricity = float(f"0.{two[26:33].strip()}")
    except ValueError:
        raise _wrong(file, first[0], "elements with a figure that is no number") from None
    if not (1.0 <= day < 367.0 and 0.0 <= figures[0] <= 180.0 and figures[4] > 0.0 and eccentricity < 1.0):
        raise _wrong(file, first[0], "elements with a figure that cannot be")
    start = datetime(year + (1900 if year >= EPOCH_1957 else 2000), 1, 1, tzinfo=UTC)
    epoch = int(start.timestamp()) * SECOND + round((day - 1.0) * DAY * SECOND)
    return Elements(name, one[2:7].strip(), one, two, epoch, f"{file}:{first[0]}")


def checksum(line: str) -> str:
    """Return the last digit of a line by the others: the sum of its digits, a minus for one."""
    return str(sum(int(one) if one.isdigit() else one == "-" for one in line[:-1]) % 10)


def chosen(sets: Sequence[Elements], satellite: str | None, at_ns: int) -> Elements:
    """Return the set of a satellite whose epoch is nearest to an instant.

    Raises
    ------
    DataError
        ``no_satellite`` where it is not there, or where there are several and none is named.
    """
    file = sets[0].where.rpartition(":")[0]
    named = list(dict.fromkeys(one.called for one in sets))
    if satellite is None:
        if len({one.number for one in sets}) > 1:
            what = f"elements of {len({one.number for one in sets})} satellites: {', '.join(named)}"
            raise DataError(what, file, do="Name yours by its number or name", code="no_satellite")
        own = list(sets)
    else:
        wanted = satellite.strip().upper()
        own = [one for one in sets if wanted in (one.number.upper(), one.number.lstrip("0").upper(), one.name.upper())]
    if not own:
        what = f"no elements of {satellite!r}; there are {', '.join(named)}"
        raise DataError(what, file, "its orbit is needed", "Name it as the file does, or give its own file",
                        "no_satellite")  # fmt: skip
    return min(own, key=lambda one: abs(one.epoch_ns - at_ns))


def age_text(days: float) -> str:
    """Return an age as people say it."""
    return f"{number(abs(days), 2)} d" if abs(days) >= 1.0 else f"{number(24.0 * abs(days), 2)} h"


def track_by(elements: Elements, times: Array, start_ns: int, ut1_utc: float = 0.0) -> Track:
    """Return where a satellite was.

    Parameters
    ----------
    elements : Elements
        Of the satellite.
    times : ndarray, shape (n,)
        Since the first instant [s].
    start_ns : int
        First instant, UTC [ns since 1970].
    ut1_utc : float
        UT1 - UTC, where it is known [s].

    Raises
    ------
    DataError
        ``missing_extra`` without the package sgp4; ``elements_old`` where the record lies further from the epoch than
        ``MOST_AGE``; ``elements`` where they cannot be propagated.
    """
    since = (start_ns - elements.epoch_ns) / SECOND / DAY
    ages = since + np.array([times[0], times[-1]]) / DAY
    age = float(ages[np.argmax(np.abs(ages))])
    if abs(age) > MOST_AGE:
        side = "after" if age > 0.0 else "before"
        epoch = _date(elements.epoch_ns)
        what = f"the record lies {age_text(age)} {side} the epoch of the elements of {elements.called}, {epoch} UTC"
        why = f"by then the position along the orbit is not known: {MOST_AGE:g} d at most"
        raise DataError(what, elements.where, why, "Take elements of the days of the record", "elements_old")
    try:
        api = importlib.import_module("sgp4.api")
    except ImportError:
        what = "an orbit from two-line elements needs the package sgp4, which is not installed"
        raise DataError(what, elements.where, do="Type: pip install 'inertialcal[orbit]'",
                        code="missing_extra") from None  # fmt: skip
    whole, rest = divmod(start_ns, round(DAY) * SECOND)
    part = rest / SECOND / DAY + times / DAY
    satellite = api.Satrec.twoline2rv(elements.first, elements.second)
    wrong, position, velocity = satellite.sgp4_array(np.full(len(times), UNIX_EPOCH + float(whole)), part)
    if np.any(wrong):
        what = f"elements of {elements.called} cannot be propagated: {WHAT.get(int(np.max(wrong)), 'unknown error')}"
        raise DataError(what, elements.where, do="Take elements of the days of the record", code="elements")
    angle = sidereal_angle(start_ns, times + ut1_utc)
    r, v = (_earth_fixed(np.asarray(one) * 1e3, angle) for one in (position, velocity))
    up = r / np.linalg.norm(r, axis=1)[:, None]
    across = np.cross(r, v)
    across /= np.linalg.norm(across, axis=1)[:, None]
    directions = np.stack([np.cross(across, up), across, up], axis=2)
    along = math.hypot(AT_EPOCH, A_DAY * age, SIDEREAL)
    u = np.array([along, math.hypot(AT_EPOCH, SIDEREAL), AT_EPOCH])
    return Track(r, directions, u, float(np.mean(np.linalg.norm(v, axis=1))), age, elements)


def sidereal_angle(start_ns: int, times: Array) -> Array:
    """Return the mean sidereal angle of 1982 [rad], shape (n,): equinox of date to the meridian of Greenwich.

    Parameters
    ----------
    start_ns : int
        First instant, UT1 [ns since 1970].
    times : ndarray, shape (n,)
        Since then [s].
    """
    since = (start_ns // SECOND - J2000) + (start_ns % SECOND) / SECOND + times
    days, centuries = since / DAY, since / DAY / 36_525.0
    seconds = 67_310.54841 + 8_640_184.812866 * centuries + 0.093104 * centuries**2 - 6.2e-6 * centuries**3
    return np.asarray(2.0 * np.pi * ((seconds / DAY) % 1.0 + days % 1.0))


def _earth_fixed(vectors: Array, angle: Array) -> Array:
    x, y, z = vectors.T
    return np.column_stack([x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle), z])


def _date(ns: int) -> str:
    return (datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=ns // 1000)).strftime("%Y-%m-%d %H:%M")
