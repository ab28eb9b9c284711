"""Pairs of the acceleration archive, made byte by byte; and those of a head that is turned, by a rig."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from inertialcal.rigs.sams_tsh.campaign import FILE
from inertialcal.rigs.sams_tsh.rig import Bench, build

START = "2014_10_22_09_36_36.000"
LITTLE = "binary 32 bit IEEE float little endian"
BIG = "binary 32 bit IEEE float big endian"


def stamp(start: str, seconds: float) -> str:
    """Return a time of the archive some seconds later, to the millisecond."""
    base = np.datetime64(f"{start[:10].replace('_', '-')}T{start[11:19].replace('_', ':')}{start[19:]}", "ms")
    return str(base + np.timedelta64(round(seconds * 1e3), "ms")).replace("-", "_").replace("T", "_").replace(":", "_")


def header(
    start: str = START,
    sensor: str = "121f03",
    rate: str = "100.00",
    layout: str = LITTLE,
    file: str = "",
    more: str = "<Gain>10.0</Gain><CutoffFreq>6.00</CutoffFreq>",
    root: str = "sams2_accel",
) -> str:
    return (
        f'<?xml version="1.0" encoding="US-ASCII"?><{root}>\n\t<SensorID>{sensor}</SensorID>\n'
        f"\t<TimeZero>{start}</TimeZero>\n\t<SampleRate>{rate}</SampleRate>\n"
        f'\t<GData file="{file}" format="{layout}"/>\n\t{more}\n</{root}>'
    )


def systems(sensor: tuple[float, float, float], data: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> str:
    """Return both coordinate systems by roll, pitch and yaw [deg]."""
    return "".join(
        f'<{kind}CoordinateSystem name="{name}" r="{a[0]}" p="{a[1]}" w="{a[2]}" x="0" y="0" z="0"/>'
        for kind, name, a in (("Sensor", "121f03", sensor), ("Data", "SSAnalysis", data))
    )


def records(n: int = 20, rate: float = 100.0, columns: int = 4, scale: float = 1e-4) -> NDArray[np.float32]:
    """Return records of time and distinct numbers."""
    table = np.empty((n, columns), dtype=np.float32)
    table[:, 0] = np.arange(n) / rate
    table[:, 1:] = scale * np.sin(1.0 + np.arange(n * (columns - 1))).reshape(n, columns - 1)
    return table


def pair(
    folder: Path,
    table: NDArray[np.float32],
    *,
    start: str = START,
    sign: str = "-",
    sensor: str = "121f03",
    stop: str | None = None,
    text: str | None = None,
    kind: str = "<f4",
) -> Path:
    """Write data file and header; return the path of the data file."""
    stop = stamp(start, float(table[-1, 0])) if stop is None else stop
    path = folder / f"{start}{sign}{stop}.{sensor}"
    path.write_bytes(table.astype(kind).tobytes())
    path.with_name(path.name + ".header").write_text(header(start, sensor) if text is None else text, encoding="ascii")
    return path


BENCH = replace(Bench(), rate=5.0, duration=1800.0, turn_starts=(600.0, 1200.0), window=200.0, saved="g", said="g")
TURNED = (0.0, 0.0, 90.0)  # attitude of the sensor: its axes are not those of the data


def flip_records(folder: Path, files: int = 3, sensor: str = "121f03", bench: Bench = BENCH, seed: int = 4) -> Path:
    """Write the record of a flip as pairs of the archive; return their folder."""
    folder.mkdir(parents=True, exist_ok=True)
    readings = build(bench, seed).recordings[FILE].array("xyz")
    for i, part in enumerate(np.array_split(readings, files)):
        table = np.column_stack([np.arange(len(part)) / bench.rate, part]).astype(np.float32)
        start = stamp(START, sum(len(one) for one in np.array_split(readings, files)[:i]) / bench.rate)
        text = header(start, sensor, rate=f"{bench.rate:g}", more=f"<Gain>10.0</Gain>{systems(TURNED)}")
        pair(folder, table, start=start, sign="+" if i else "-", sensor=sensor, text=text)
    return folder
