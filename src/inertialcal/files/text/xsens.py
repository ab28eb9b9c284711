"""Exports of Xsens: counters that begin anew, a clock in ticks, and units that the file does not name.

MT Manager counts ``SampleTimeFine`` in ticks of 0.1 ms, as 32 bits, and ``PacketCounter`` in 16 bits; it writes rates
in rad/s. The app of Xsens DOT counts it in microseconds, and writes rates in deg/s. Both write accelerations in m/s^2
[1]_, [2]_. No unit is rated above 1 kHz or below 2 Hz, which tells the two clocks apart.

References
----------
.. [1] Xsens, MT Low-Level Communication Protocol, XDI 0x1060 SampleTimeFine: "time of the sample in 10 kHz ticks".
.. [2] Xsens DOT User Manual, timestamp: "in microseconds".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ..columns import Column, Content

FINE, PACKET = "SampleTimeFine", "PacketCounter"
PARTS = ("UTC_Year", "UTC_Month", "UTC_Day", "UTC_Hour", "UTC_Minute", "UTC_Second", "UTC_Nano")
VALID = ("UTC_Valid", "UTC_ValidFlags", "UTC_Flags")
DATE_AND_TIME = 0b11  # flags of an instant that is known
TICK = 100_000  # ns, of a counter of 10 kHz
MICROSECOND = 1_000  # ns
SLOWEST = 5_000  # ticks of 0.1 ms between two samples: beyond, a count is of microseconds
FINE_BITS, PACKET_BITS = 32, 16
SENSORS = {"Acc": "m/s^2", "Gyr": "rad/s"}
OF_DOT = {"Acc": "m/s^2", "Gyr": "deg/s"}


def settled(content: Content, path: str) -> Content:
    """Return the content of an export with counters that go on, one clock, and units; another one as it is."""
    columns = {one.name: one for one in content.columns}
    fine = columns.get(FINE)
    has_utc = all(name in columns and columns[name].is_number for name in PARTS)
    named = fine is not None and fine.values.dtype.kind in "iu" and fine.is_complete and len(fine.values) > 1
    if not named and not (has_utc and PACKET in columns):
        return content
    remarks: list[Remark] = []
    instants = _instants(columns) if has_utc else None
    clock, units = instants, SENSORS
    if fine is not None and named:
        count = _going_on(fine.values, FINE_BITS)
        in_ticks = float(np.median(np.diff(count))) <= SLOWEST
        time_ns = (count - count[0]) * (TICK if in_ticks else MICROSECOND)
        start = count[0] * (TICK if in_ticks else MICROSECOND)
        units = SENSORS if in_ticks else OF_DOT
        clock = time_ns + (start if instants is None else int(np.median(instants - time_ns)))
        tick = "0.1 ms" if in_ticks else "1 us"
        remarks.append(Remark("ticks", "info", f"{FINE} counts {tick}; it begins anew at 2^{FINE_BITS}", path))
    aside = {FINE, *PARTS, *VALID} if clock is not None else set()
    if has_utc and instants is None:
        what = "the instants of UTC_Year to UTC_Nano are not marked as valid: not used"
        remarks.append(Remark("utc_not_valid", "warning", what, path))
        aside |= {*PARTS, *VALID}
    found: list[Column] = []
    if clock is not None:
        utc = instants is not None
        values = clock.view("datetime64[ns]") if utc else clock
        found.append(Column("UTC" if utc else FINE, values, None if utc else "ns"))
    taken: dict[str, None] = {}
    for one in content.columns:
        sensor = one.name[:-2] if one.name[-2:] in ("_X", "_Y", "_Z") else ""
        if one.name in aside:
            continue
        if sensor in units and one.unit is None:
            taken[f"{sensor} in {units[sensor]}"] = None
            found.append(replace(one, unit=units[sensor]))
        elif one.name == PACKET and one.values.dtype.kind in "iu" and one.is_complete:
            found.append(replace(one, values=_going_on(one.values, PACKET_BITS)))
        else:
            found.append(one)
    if taken:
        what = f"units as {'MT Manager' if units is SENSORS else 'Xsens DOT'} writes them: {', '.join(taken)}"
        do = "If the export was set to other units: --unit gyro=UNIT"
        remarks.append(Remark("units_of_format", "warning", what, path, do=do))
    return replace(content, columns=tuple(found), remarks=(*content.remarks, *remarks))


def _going_on(count: NDArray[Any], bits: int) -> Times:
    """Return a counter that goes on where it began anew."""
    values = count.astype(np.int64)
    if not len(values):
        return values
    back = np.diff(values) < -(2 ** (bits - 1))
    return np.asarray(values + 2**bits * np.concatenate([[0], np.cumsum(back)]), dtype=np.int64)


def _instants(columns: Mapping[str, Column]) -> Times | None:
    """Return the instants that the parts of UTC make [ns since 1970]; None where they are not known throughout."""
    year, month, day, hour, minute, second, nano = (columns[name].values for name in PARTS)
    parts = [year, month, day, hour, minute, second, nano]
    if any(one.dtype.kind not in "iu" for one in parts) or year.min() < 1970 or year.max() > 2200:
        return None
    valid = next((columns[name].values for name in VALID if name in columns), None)
    if valid is not None and (valid.dtype.kind not in "iu" or np.any(valid & DATE_AND_TIME != DATE_AND_TIME)):
        return None
    if month.min() < 1 or month.max() > 12:
        return None
    months = (year.astype(np.int64) - 1970) * 12 + month - 1
    days = months.astype("datetime64[M]").astype("datetime64[D]").astype(np.int64) + day - 1
    seconds = ((days * 24 + hour) * 60 + minute) * 60 + second
    return np.asarray(seconds * SECOND + nano, dtype=np.int64)
