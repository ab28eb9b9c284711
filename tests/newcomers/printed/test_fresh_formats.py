"""Files of loggers in forms that no reader was written from, by the formats' own libraries: packed, beside, as text."""

from __future__ import annotations

import json
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.files import read

N, RATE, START = 500, 100.0, 1_730_000_000
GYRO = np.random.default_rng(77).normal((0.009, -0.005, 0.003), 1e-3, (N, 3))  # rad/s
STAMPS = START * 10**9 + np.arange(N) * 10**7  # ns


def refused(path: Path) -> Any:
    """Return the first problem of a file that is refused."""
    with pytest.raises(DataError) as caught:
        read(path)
    return caught.value.problems[0]


def ros_2(folder: Path, plugin: str, packed: str) -> Path:
    """Write a folder of ROS 2 with two sensors."""
    rosbag2 = pytest.importorskip("rosbags.rosbag2")
    from rosbags.rosbag2.enums import CompressionFormat, CompressionMode, StoragePlugin
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    types, zeros = store.types, np.zeros(9)
    turn, vector = types["geometry_msgs/msg/Quaternion"], types["geometry_msgs/msg/Vector3"]
    bag = rosbag2.Writer(folder, version=9, storage_plugin=StoragePlugin[plugin])
    bag.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
    with bag:
        both = [bag.add_connection(f"/imu_{one}", "sensor_msgs/msg/Imu", typestore=store) for one in "ab"]
        for ns, rate in zip(STAMPS.tolist(), GYRO, strict=True):
            stamp = types["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
            head = types["std_msgs/msg/Header"](stamp=stamp, frame_id="imu")
            for k, one in enumerate(both, 1):
                message = types["sensor_msgs/msg/Imu"](
                    header=head, orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0), orientation_covariance=zeros,
                    angular_velocity=vector(*(k * rate)), angular_velocity_covariance=zeros,
                    linear_acceleration=vector(0.0, 0.0, 9.8), linear_acceleration_covariance=zeros,
                )  # fmt: skip
                bag.write(one, ns, store.serialize_cdr(message, "sensor_msgs/msg/Imu"))
    return folder


@pytest.mark.parametrize("plugin", ["MCAP", "SQLITE3"])
def test_messages_that_are_packed_one_by_one_are_unpacked(plugin: str, tmp_path: Path) -> None:
    found = read(ros_2(tmp_path / "bag", plugin, "MESSAGE"), topics=["/imu_b"])
    names = [f"angular_velocity.{axis}" for axis in "xyz"]
    np.testing.assert_array_equal(found.array(names), 2.0 * GYRO)
    np.testing.assert_array_equal(found.time_ns, STAMPS)


def test_a_folder_whose_files_are_packed_says_how_to_unpack_them(tmp_path: Path) -> None:
    folder = ros_2(tmp_path / "bag", "SQLITE3", "FILE")
    problem = refused(folder)
    assert problem.code == "unsupported_format"
    assert problem.do == f"Unpack them: zstd -d {folder / 'bag.db3.zstd'}"
    assert refused(folder / "bag.db3.zstd").do == f"Unpack it: zstd -d {folder / 'bag.db3.zstd'}"


def test_messages_that_unpack_to_more_than_any_reading_are_not_unpacked(tmp_path: Path) -> None:
    zstandard = pytest.importorskip("zstandard")
    from inertialcal.files.loggers.bags import LARGEST, _without_packing

    small, large = (zstandard.ZstdCompressor().compress(bytes(size)) for size in (100, LARGEST + 1))
    torn = small[:-3]
    assert _without_packing([small, large, torn, b"\x00\x01"], "a")[:2] == [bytes(100), large]
    assert _without_packing([b"\x00\x01"], "a") == [b"\x00\x01"]


def in_json(path: Path, contents: list[bytes]) -> Path:
    """Write messages of JSON into an MCAP."""
    writer = pytest.importorskip("mcap.writer")
    with path.open("wb") as stream:
        mcap = writer.Writer(stream)
        mcap.start(profile="", library="fresh")
        schema = mcap.register_schema("Imu", "jsonschema", b'{"type":"object"}')
        one = mcap.register_channel("/imu", "json", schema)
        for ns, content in zip(STAMPS.tolist(), contents, strict=False):
            mcap.add_message(one, ns, content, ns)
        mcap.finish()
    return path


def test_messages_of_json_are_read_with_the_times_of_recording(tmp_path: Path) -> None:
    contents = [
        json.dumps({"gyro_rad": dict(zip("xyz", one, strict=True))}, indent=1).encode() for one in GYRO.tolist()
    ]
    found = read(in_json(tmp_path / "a.mcap", contents), units={"gyro": "rad/s"})
    np.testing.assert_array_equal(found.array([f"gyro_rad.{axis}" for axis in "xyz"]), GYRO)
    np.testing.assert_array_equal(found.time_ns, STAMPS)
    assert "log_time" in {one.code for one in found.remarks}


def test_messages_of_json_that_are_no_objects_are_counted(tmp_path: Path) -> None:
    contents = [b'{"gx": 1.5}', b"{}", b"[1, 2]", b"\x00\x01", b'{"gx": 2.5}', b'{"gx": 3.5}']
    found = read(in_json(tmp_path / "a.mcap", contents))
    (damaged,) = [one for one in found.remarks if one.code == "damaged_records"]
    assert damaged.count == 2


def test_a_database_says_where_the_rows_lie_that_were_written_last(tmp_path: Path) -> None:
    path = tmp_path / "log.db"
    with sqlite3.connect(path) as open_one:
        open_one.execute("PRAGMA journal_mode=wal")
        open_one.execute("CREATE TABLE imu (time_s REAL, gyro_x_dps REAL)")
        rows = [(i / RATE, float(one)) for i, one in enumerate(GYRO[:, 0])]
        open_one.executemany("INSERT INTO imu VALUES (?, ?)", rows)
        open_one.commit()
        for end in ("", "-wal"):
            shutil.copy(f"{path}{end}", tmp_path / f"copy.db{end}")
        problem = refused(tmp_path / "copy.db")
        assert "copy.db-wal, which is not read" in problem.what
        assert "wal_checkpoint" in problem.do
        open_one.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        open_one.execute("INSERT INTO imu VALUES (99.0, 0.5)")
        open_one.commit()
        found = read(path)
    open_one.close()
    assert len(found) == N
    assert "beside_not_read" in {one.code for one in found.remarks}
    assert "beside_not_read" not in {one.code for one in read(path).remarks}


def test_numbers_that_a_sheet_holds_as_text_are_read_with_their_decimal_sign(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["Serie", "1234"])
    book.active.append(["t (s)", *(f"gyro_{axis} (rad/s)" for axis in "xyz")])
    for i, one in enumerate(GYRO):
        book.active.append([f"{i / RATE:.2f}".replace(".", ","), *(f"{value:.6f}".replace(".", ",") for value in one)])
    book.save(tmp_path / "a.xlsx")
    found = read(tmp_path / "a.xlsx")
    assert found.array([f"gyro_{axis} (rad/s)" for axis in "xyz"]) == pytest.approx(GYRO, abs=1e-6)
    assert found.sample_rate == pytest.approx(RATE)


def test_a_sheet_with_numbers_beside_texts_that_look_like_some_is_read_as_before(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["Serial", "1234", "7", "8"])
    book.active.append([])
    book.active.append(["t (s)", "gyro_x (rad/s)", "state"])
    for i, one in enumerate(GYRO[:, 0].tolist()):
        book.active.append([i / RATE, one, "1,5"])
    book.save(tmp_path / "a.xlsx")
    assert read(tmp_path / "a.xlsx").channel("gyro_x (rad/s)").data == pytest.approx(GYRO[:, 0], rel=1e-14)


def test_a_table_of_arrow_without_a_whole_row_is_refused(tmp_path: Path) -> None:
    import pyarrow as pa
    from pyarrow import feather

    feather.write_feather(pa.table({"gyro_x": GYRO[:, 0]}), tmp_path / "a.feather", compression="uncompressed")
    content = (tmp_path / "a.feather").read_bytes()
    (tmp_path / "b.feather").write_bytes(content[: len(content) // 2])
    problem = refused(tmp_path / "b.feather")
    assert (problem.code, problem.why) == ("damaged_file", "no rows before that are whole")


@pytest.mark.parametrize(("name", "content"), [("a.yaml", b"rate: 100\n"), ("a.txt", b"%YAML:1.0\n---\ngyr: 1\n")])
def test_settings_are_no_recording(name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    assert refused(tmp_path / name).what.startswith("this is YAML, settings or a model")


@pytest.mark.parametrize(
    ("content", "tool"), [(b"BZh91", "bunzip2 -k"), (b"\xfd7zXZ\x00", "unxz -k"), (b"7z\xbc\xaf\x27\x1c", "7z x")]
)
def test_a_packed_file_says_what_unpacks_it(content: bytes, tool: str, tmp_path: Path) -> None:
    (tmp_path / "a b.csv").write_bytes(content + bytes(50))
    assert refused(tmp_path / "a b.csv").do == f"Unpack it: {tool} '{tmp_path / 'a b.csv'}'"


def test_words_are_no_table(tmp_path: Path) -> None:
    lines = [
        "MIT License",
        "",
        "Copyright (c) 2014 a person",
        "",
        "Permission is hereby granted, free of charge, to any",
    ]
    (tmp_path / "LICENSE.txt").write_text("\n".join([*lines, "person obtaining a copy of this", "software, to deal"]))
    assert refused(tmp_path / "LICENSE.txt").what.startswith("no table of numbers")
