"""Recordings and tables of a gyro in units, volts and counts, as people write them with their own scripts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from newcomer_truths import LSB, Log, at_rest, chamber, rate_table

Columns = Mapping[str, Sequence[object]]
DATA_SHEET = {"lsb": "5 V / 4095", "reference": "2.5 V", "scale_factor": "0.02 V/(deg/s)"}


@dataclass(frozen=True)
class Made:
    """A file: its name, its bytes, the log behind it, and what it is a test of."""

    name: str
    write: Callable[[Log], bytes]
    log: Callable[[], Log]
    noun: str


def csv(columns: Columns) -> bytes:
    """Return columns as comma-separated text."""
    lines = [",".join(columns)]
    lines += [",".join(map(str, row)) for row in zip(*columns.values(), strict=True)]
    return ("\n".join(lines) + "\n").encode()


def rounded(values: np.ndarray, digits: int) -> list[float]:
    """Return numbers with so many digits behind the point."""
    return [round(float(one), digits) for one in values]


def readings(log: Log, kind: str, name: str = "gyro_{}") -> dict[str, Sequence[object]]:
    """Return the readings of a log in units, volts or counts, the unit in the header but of counts."""
    if kind == "counts":
        return {name.format(axis): [int(one) for one in values] for axis, values in log.counts().items()}
    unit, found = ("V", log.volts()) if kind == "volts" else ("deg/s", log.readings)
    return {f"{name.format(axis)} [{unit}]": rounded(values, 6) for axis, values in found.items()}


def recorded(kind: str) -> Callable[[Log], bytes]:
    """Return the recording of a log in units, volts or counts."""

    def write(log: Log) -> bytes:
        columns: dict[str, Sequence[object]] = {"time_s": rounded(log.time, 3)}
        if len(log.applied):
            columns["table_rate [deg/s]"] = rounded(log.applied, 1)
        columns |= readings(log, kind)
        if len(log.temperature) and not len(log.applied):
            columns["temperature [degC]"] = rounded(log.temperature, 2)
        return csv(columns)

    return write


def dwells(kind: str) -> Callable[[Log], bytes]:
    """Return a table with a row a dwell, of the turned axis alone."""

    def write(log: Log) -> bytes:
        ends = [0, *(np.flatnonzero(np.diff(log.applied)) + 1), len(log.applied)]
        values = {"units": log.readings["x"], "volts": log.volts()["x"], "counts": log.volts()["x"] / LSB}[kind]
        unit = {"units": "deg/s", "volts": "V", "counts": "count"}[kind]
        parts = [values[a:b] for a, b in pairwise(ends)]
        return csv({
            "rate [deg/s]": [float(log.applied[a]) for a in ends[:-1]],
            f"reading [{unit}]": [float(one.mean()) for one in parts],
            f"reading_std [{unit}]": [float(one.std(ddof=1)) for one in parts],
            "n": [len(one) for one in parts],
        })  # fmt: skip

    return write


KINDS = ("units", "volts", "counts")
FILES = (
    *(Made(f"turned_{kind}.csv", recorded(kind), rate_table, "rate-table") for kind in KINDS),
    *(Made(f"dwells_{kind}.csv", dwells(kind), rate_table, "rate-table") for kind in KINDS),
    *(Made(f"chamber_{kind}.csv", recorded(kind), chamber, "thermal") for kind in KINDS),
    *(Made(f"rest_{kind}.csv", recorded(kind), at_rest, "allan") for kind in KINDS),
)
