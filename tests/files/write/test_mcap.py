"""MCAP of a recording: what rosbags and the mcap library read of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

import inertialcal as ic
from inertialcal.core.errors import DataError
from inertialcal.files.write.recording import write
from typed_commands import call

N = 50
RNG = np.random.default_rng(1)
GYRO, ACC, TEMPERATURE = RNG.normal(size=(N, 3)), RNG.normal(size=(N, 3)), 300.0 + np.arange(N)
HEAD = "time_ns,gx [deg/s],gy [deg/s],gz [deg/s],ax [mg],ay [mg],temperature [K],flag\n"


def source(folder: Path, start: int = 1_700_000_000_000_000_000) -> Path:
    path = folder / "a.csv"
    rows = (f"{start + 10_000_000 * i},{','.join(map(repr, [*map(float, GYRO[i]), *map(float, ACC[i, :2])]))},"
            f"{TEMPERATURE[i]},{i % 2}\n" for i in range(N))  # fmt: skip
    path.write_text(HEAD + "".join(rows))
    return path


def test_rosbags_reads_what_was_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "out.mcap"
    status, said, _ = call(capsys, "convert", str(source(tmp_path)), str(target))
    assert status == 0
    said = " ".join(said.split())
    assert "no place in such messages, not written: flag" in said
    assert "no reading of linear_acceleration.z: written as NaN" in said
    store = get_typestore(Stores.ROS2_HUMBLE)
    found: dict[str, list[Any]] = {}
    with Reader(target) as bag:
        for connection, stamp, data in bag.messages():
            message: Any = store.deserialize_cdr(data, connection.msgtype)
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == stamp
            assert message.header.frame_id == "imu"
            found.setdefault(connection.topic, []).append(message)
    imu, warm = found["/imu"], found["/temperature"]
    rates = np.array([[m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z] for m in imu])
    np.testing.assert_allclose(rates, np.radians(GYRO), rtol=1e-15)
    felt = np.array([[m.linear_acceleration.x, m.linear_acceleration.y, m.linear_acceleration.z] for m in imu])
    np.testing.assert_allclose(felt[:, :2], ACC[:, :2] * 9.80665e-3, rtol=1e-15)
    assert np.all(np.isnan(felt[:, 2]))
    assert {m.orientation_covariance[0] for m in imu} == {-1.0}
    assert {m.angular_velocity_covariance[0] for m in imu} == {0.0}
    np.testing.assert_allclose([m.temperature for m in warm], TEMPERATURE - 273.15, rtol=1e-14)


def test_what_was_written_reads_back(tmp_path: Path) -> None:
    target = tmp_path / "out.mcap"
    raw = ic.read(source(tmp_path))
    write(target, raw)
    found = ic.read(target)
    assert found.time_ns is not None
    np.testing.assert_array_equal(found.time_ns, raw.time_ns)
    assert found.names[:3] == ("angular_velocity.x", "angular_velocity.y", "angular_velocity.z")
    assert ic.read(target, topics=["/temperature"]).channel("temperature").unit == "degC"


def test_counts_are_refused_and_time_from_zero_is_remarked(tmp_path: Path) -> None:
    target = tmp_path / "out.mcap"
    raw = ic.read(source(tmp_path, start=0), units={"time_ns": "ns"})
    assert "elapsed_stamps" in {one.code for one in write(target, raw)}
    counts = replace(raw, channels=tuple(replace(one, unit="count") for one in raw.channels))
    with pytest.raises(DataError) as caught:
        write(target, counts)
    assert caught.value.problems[0].code == "no_channel"
