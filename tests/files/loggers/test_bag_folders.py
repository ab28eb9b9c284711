"""A folder of a ROS 2 bag is a recording for every noun, as a file of it is; what an Imu does not measure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import UsageError
from inertialcal.files import read

RATES = np.repeat([0.0, 0.5, -0.5, 1.0, -1.0, 0.0], 60)  # [rad/s]
SCALE, BIAS = 1.02, 0.01
START, STEP = 1_700_000_000_000_000_000, 20_000_000  # [ns]


def bag(folder: Path, orientation: tuple[float, float, float, float], covariance: float = 0.0) -> Path:
    """Write a bag with a table and an IMU on it, turned about z, both as sensor_msgs/Imu with the same stamps."""
    from rosbags.rosbag2 import Writer
    from rosbags.rosbag2.enums import StoragePlugin
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    types, kind = store.types, "sensor_msgs/msg/Imu"
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    rng = np.random.default_rng(7)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topics = {name: writer.add_connection(name, kind, typestore=store) for name in ("/imu", "/table")}
        for i, rate in enumerate(RATES):
            stamp = START + STEP * i
            head = types["std_msgs/msg/Header"](
                stamp=types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id=""
            )
            for name, connection in topics.items():
                z = rate if name == "/table" else BIAS + SCALE * rate + 1e-3 * rng.normal()
                unknown = np.zeros(9)
                message = types[kind](
                    header=head, orientation=turn(*orientation),
                    orientation_covariance=np.array([covariance, *[0.0] * 8]), angular_velocity=vector(0.0, 0.0, z),
                    angular_velocity_covariance=unknown, linear_acceleration=vector(0.1 * i, 0.2 * i, 9.8),
                    linear_acceleration_covariance=unknown)  # fmt: skip
                writer.write(connection, stamp, store.serialize_cdr(message, kind))
    return folder


@pytest.mark.parametrize("covariance", [0.0, -1.0])
def test_an_orientation_of_noughts_is_none(tmp_path: Path, covariance: float) -> None:
    found = read(bag(tmp_path / "bag", (0.0, 0.0, 0.0, 0.0), covariance), topics=["/imu"])
    assert not [name for name in found.names if "orientation" in name]
    (said,) = [one for one in found.remarks if "orientation" in one.what]
    assert (said.code, said.count) == ("variables_left_out", 4)


def test_an_orientation_is_read_where_there_is_one(tmp_path: Path) -> None:
    found = read(bag(tmp_path / "bag", (0.0, 0.0, 0.0, 1.0)), topics=["/imu"])
    assert [name for name in found.names if "orientation" in name] == [f"orientation.{axis}" for axis in "xyzw"]


def test_a_table_in_a_bag(tmp_path: Path) -> None:
    folder = bag(tmp_path / "bag", (0.0, 0.0, 0.0, 0.0))
    with pytest.raises(UsageError, match="no column says the rate of the table"):
        ic.rate_table(folder, axis="z", topics=["/imu"])
    reading, applied = "angular_velocity.z", "/table.angular_velocity.z"
    found = ic.rate_table(folder, topics=["/imu", "/table"], applied=applied, reading={"z": reading}, axis="z")
    rows = {row.quantity: row for row in found.rows if row.axis == "z" and not str(row.case)}
    for quantity, truth in (("scale_factor_error", 100.0 * (SCALE - 1.0)), ("bias", BIAS)):
        row = rows[quantity]
        assert row.value is not None
        assert row.u is not None
        assert abs(row.value - truth) < 5.0 * row.u
    (file,) = folder.glob("*.db3")
    of_file = ic.rate_table(file, topics=["/imu", "/table"], applied=applied, reading={"z": reading}, axis="z")
    assert [(row.value, row.u) for row in of_file.rows] == [(row.value, row.u) for row in found.rows]
