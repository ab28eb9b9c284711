"""Exports as phones, boards, oscilloscopes, LabVIEW and MATLAB write them: the rate and the means in one command.

Each text is laid out as its program prints it, one minute at 100 Hz of a gyro at rest; what was put in is the truth.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from typed_commands import call

N, RATE = 3000, 100.0
BIAS = np.array([0.35, -0.21, 0.12])  # deg/s
NOISE = 0.02  # deg/s
VOLTS = 0.02  # per deg/s, about 2.5 V
GYRO = BIAS + NOISE * np.random.default_rng(2026).standard_normal((N, 3))
RAD, OUT = np.radians(GYRO), 2.5 + VOLTS * GYRO
MEANS, OUT_MEANS = GYRO.mean(axis=0), OUT.mean(axis=0)
START = 1710234567


def lines(line: Callable[[int], str], end: str = "\n") -> str:
    """Return a line for each sample."""
    return "".join(line(i) + end for i in range(N))


def cells(values: np.ndarray, form: str = "{:.8f}", separator: str = ",") -> str:
    """Return numbers of a row."""
    return separator.join(form.format(one) for one in values)


def comma(text: str) -> str:
    """Return a number with a decimal comma."""
    return text.replace(".", ",")


def clock(i: int) -> str:
    """Return a date as LabVIEW writes it in Germany."""
    return f"12.03.2024 09:15:{i // 100:02d},{10 * (i % 100):03d}"


def instant(i: int) -> str:
    """Return a date as SensorLog writes it."""
    return datetime.fromtimestamp(START + i / RATE, UTC).isoformat(timespec="milliseconds")


EXPORTS: dict[str, tuple[str, str, tuple[str, ...], np.ndarray]] = {  # text, unit, options, true means
    "phyphox.csv": (
        '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)","Gyroscope z (rad/s)","Absolute (rad/s)"\n'
        + lines(lambda i: f"{i / RATE:.9E},{cells(RAD[i], '{:.9E}')},{np.linalg.norm(RAD[i]):.9E}"),
        "rad/s", (), np.radians(MEANS),
    ),
    "phyphox_de.txt": (
        '"Zeit (s)"\t"Gyroskop x (rad/s)"\t"Gyroskop y (rad/s)"\t"Gyroskop z (rad/s)"\n'
        + comma(lines(lambda i: f"{i / RATE:.9E}\t" + cells(RAD[i], "{:.9E}", "\t"))),
        "rad/s", (), np.radians(MEANS),
    ),
    "physics_toolbox.csv": (
        "time,wx,wy,wz\n" + lines(lambda i: f"{i / RATE:.6f},{cells(RAD[i])}"),
        "rad/s", ("--unit", "gyro=rad/s"), np.radians(MEANS),
    ),
    "sensorlog.csv": (
        "loggingTime(txt),loggingSample(N),motionRotationRateX(rad/s),motionRotationRateY(rad/s),"
        "motionRotationRateZ(rad/s)\n" + lines(lambda i: f"{instant(i)},{i},{cells(RAD[i])}"),
        "rad/s", (), np.radians(MEANS),
    ),
    "matlab.txt": (
        "% Recorded with MATLAB R2023b\n%\n% t  gx  gy  gz\n% s  deg/s  deg/s  deg/s\n"
        + lines(lambda i: f"{i / RATE:.4f}  {cells(GYRO[i], '{:.8f}', '  ')}"),
        "deg/s", (), MEANS,
    ),
    "adis.csv": (
        "! ADIS16470 log\nTime,DATA_CNT,X_GYRO,Y_GYRO,Z_GYRO\n!s,,deg/s,deg/s,deg/s\n"
        + lines(lambda i: f"{i / RATE:.3f},{i},{cells(GYRO[i])}"),
        "deg/s", (), MEANS,
    ),
    "serial.log": (  # every line with the sign of a comment, as the sketch prints what is not for the host
        "# t[s] wx[deg/s] wy[deg/s] wz[deg/s]\n" + lines(lambda i: f"# {i / RATE:.2f} {cells(GYRO[i], '{:.8f}', ' ')}"),
        "deg/s", (), MEANS,
    ),
    "esp32.jsonl": (
        lines(lambda i: json.dumps({"ts_ms": 10 * i, "imu": {"gyro_dps": GYRO[i].round(8).tolist()}})),
        "deg/s", (), MEANS,
    ),
    "labview.txt": (
        "waveform\t[0]\t[1]\t[2]\r\n" + "t0" + 3 * "\t12.03.2024 09:15:00,000000" + "\r\ndelta t" + 3 * "\t0,010000"
        + "\r\n\r\ntime\tout_0 [V]\tout_1 [V]\tout_2 [V]\r\n"
        + lines(lambda i: f"{clock(i)}\t" + comma(cells(OUT[i], "{:.8f}", "\t")), "\r\n"),
        "V", (), OUT_MEANS,
    ),
    "tektronix.csv": (
        "Model,MSO24\nLabel,,,\nWaveform Type,ANALOG\nHorizontal Units,s\nSample Interval,0.01\nVertical Units,V\n\n"
        "TIME,CH1,CH2,CH3\n" + lines(lambda i: f"{i / RATE - 15.0:.6e},{cells(OUT[i], '{:.9e}')}"),
        "V", ("--unit", "CH1=V", "--unit", "CH2=V", "--unit", "CH3=V"), OUT_MEANS,
    ),
    "keysight.csv": (
        "x-axis,1,2,3\nsecond,Volt,Volt,Volt\n" + lines(lambda i: f"{i / RATE:+.8E},{cells(OUT[i], '{:+.9E}')}"),
        "V", (), OUT_MEANS,
    ),
    "siglent.csv": (
        "Record Length,Analog:3000\nSample Interval,CH1:0.01\n,\nSource,CH1,CH2,CH3\nSecond,Volt,Volt,Volt\n"
        + lines(lambda i: f"{i / RATE:.8f},{cells(OUT[i])}"),
        "V", (), OUT_MEANS,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", EXPORTS)
def test_an_export_is_read_as_it_is(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, unit, options, means = EXPORTS[name]
    (tmp_path / name).write_bytes(text.encode())
    status, out, err = call(capsys, "info", str(tmp_path / name), *options, "--json")
    assert status == 0, err
    (found,) = json.loads(out)["results"]
    assert found["rows"] == N
    assert found["time"]["sample_rate"] == pytest.approx(RATE, rel=1e-4)
    channels = [one for one in found["channels"] if one["unit"] == unit][:3]
    np.testing.assert_allclose([one["mean"] for one in channels], means, rtol=0, atol=1e-7)
