"""Formats of loggers: values, units, time, topics, and what is not whole."""

from __future__ import annotations

import gc
import json
import random
import signal
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from logger_files import COUNTS, STAMPS, WRITERS, N, Written, mcap, ulog_fifo
from rosbags.typesys import Stores, get_typestore

import inertialcal as ic
from inertialcal.core import batches
from inertialcal.core.errors import DataError, InertialcalError, UsageError
from inertialcal.core.recording import Recording
from inertialcal.files import apart
from inertialcal.files.loggers import dataflash
from inertialcal.files.loggers.ros_messages import decode
from typed_commands import call

ROUNDING = 2e-7  # of numbers with seven digits


def read(path: Path, written: Written) -> Recording:
    return ic.read(path, topics=[] if written.topic is None else [written.topic])


@pytest.mark.parametrize("name", WRITERS)
def test_what_was_written_comes_back(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    written = WRITERS[name](path)
    found = read(path, written)
    for column, values in written.columns.items():
        data = found.channel(column).data
        if written.exact:
            np.testing.assert_array_equal(data, values, err_msg=column)
        else:
            np.testing.assert_allclose(data, values, rtol=ROUNDING, atol=ROUNDING, err_msg=column)
    for column, unit in written.units.items():
        assert found.channel(column).unit == unit, column
    if written.time_ns is not None:
        assert found.time_ns is not None
        np.testing.assert_array_equal(found.time_ns, written.time_ns)
        assert found.epoch == ("utc" if written.time_ns[0] > 10**17 else "elapsed")
    assert found.sample_rate == pytest.approx(written.sample_rate, rel=1e-6)
    assert {one.code for one in found.remarks} >= set(written.remarks)


CUT_FILES = {  # name -> share of the file that is there, rows at least
    "plain.bag": (0.6, 200), "lz4.bag": (0.6, 100), "ros2.db3": (0.6, 200), "zstd.mcap": (0.6, 200),
    "flat.mcap": (0.6, 200), "px4.ulg": (0.6, 200), "ardu.bin": (0.6, 200), "ardu.log": (0.6, 200),
    "labview.tdms": (0.97, 200), "text.uff": (0.6, N), "sound.wav": (0.6, 200), "wide.wav": (0.97, 200),
    "zstd.feather": (0.6, 200), "stream.arrow": (0.6, 200), "labview.lvm": (0.6, 200), "steim.mseed": (0.6, 200),
    "table.db": (0.6, 100), "lines.jsonl": (0.6, 200),
}  # fmt: skip


@pytest.mark.parametrize("name", CUT_FILES)
def test_what_a_killed_logger_left_is_read_as_far_as_it_is_whole(tmp_path: Path, name: str) -> None:
    path, (share, least) = tmp_path / name, CUT_FILES[name]
    written = WRITERS[name](path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    found = read(path, written)
    assert least <= len(found) <= N
    for column, values in written.columns.items():
        if column in found.names:  # a set of a universal file may be gone
            np.testing.assert_allclose(found.channel(column).data, values[: len(found)], rtol=ROUNDING, atol=ROUNDING)
    if written.time_ns is not None:
        assert found.time_ns is not None
        np.testing.assert_array_equal(found.time_ns, written.time_ns[: len(found)])
    (remark, *_) = [one for one in found.remarks if one.code == "torn_file"]
    assert remark.severity == "warning"
    assert remark.count >= 1


@pytest.mark.parametrize("name", ["book.xlsx", "flat.mf4", "bz2.bag"])
def test_what_is_not_whole_and_cannot_be_read_is_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    path.write_bytes(path.read_bytes()[: int(0.6 * path.stat().st_size)])
    assert code(path) == "damaged_file"


def code(path: Path, *topics: str) -> str:
    with pytest.raises(DataError) as caught:
        ic.read(path, topics=topics)
    return caught.value.problems[0].code


@pytest.mark.parametrize("chunked", [True, False])
def test_a_changed_byte_is_told_by_the_checksum_of_the_data(tmp_path: Path, chunked: bool) -> None:
    """Two topics by turns, with messages of two lengths, in chunks or not; the checksum of the format's library."""
    from mcap.writer import CompressionType, Writer

    store, path, rate = get_typestore(Stores.ROS2_IRON), tmp_path / "a.mcap", 0.25
    vector, kind = store.types["geometry_msgs/msg/Vector3"], store.types["sensor_msgs/msg/MagneticField"]
    head, stamp = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    with path.open("wb") as stream:
        made = Writer(stream, 2000, CompressionType.NONE, use_chunking=chunked, enable_crcs=False,
                      enable_data_crcs=True)  # fmt: skip
        made.start("ros2", "test")
        schema = made.register_schema("sensor_msgs/msg/MagneticField", "ros2msg", b"")
        channels = [made.register_channel(topic, "cdr", schema) for topic in ("/a", "/b")]
        for i in range(90):
            about = head(stamp=stamp(sec=100, nanosec=i * 10**7), frame_id="b" * (1 + 9 * (i % 3 == 0)))
            field = vector(x=i * rate, y=float(i % 2), z=7.0)
            message = kind(header=about, magnetic_field=field, magnetic_field_covariance=np.zeros(9))
            data = bytes(store.serialize_cdr(message, "sensor_msgs/msg/MagneticField"))
            made.add_message(channels[i % 2], 10**9 + i, data, 10**9 + i)
        made.finish()  # type: ignore[no-untyped-call]
    found = ic.read(path, topics=["/b"])
    assert np.array_equal(found.channel("magnetic_field.x").data, rate * np.arange(1, 90, 2))
    assert np.all(found.channel("magnetic_field.y").data == 1.0)
    assert not [one for one in found.remarks if one.code in ("torn_file", "wrong_checksum")]
    content = bytearray(path.read_bytes())
    at = content.index(struct.pack("<d", 41 * rate))
    content[at] ^= 1
    path.write_bytes(content)
    assert [one.code for one in ic.read(path, topics=["/b"]).remarks].count("wrong_checksum") == 1


def test_a_bag_without_an_index_is_whole_but_said_to_have_none(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    WRITERS["plain.bag"](path)
    content = bytearray(path.read_bytes())
    at = content.index(b"index_pos=") + 10
    end = int.from_bytes(content[at : at + 8], "little")
    content[at : at + 8] = bytes(8)
    path.write_bytes(content[:end])
    found = ic.read(path)
    assert len(found) == N
    (remark,) = [one for one in found.remarks if one.code == "torn_file"]
    assert remark.what == "it has no index: what was not yet written is missing"


def test_a_flipped_bit_in_a_chunk_ends_the_reading_there(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    written = WRITERS["lz4.mcap"](path)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 16
    path.write_bytes(content)
    found = ic.read(path)
    assert 100 < len(found) < 250
    np.testing.assert_array_equal(
        found.channel("linear_acceleration.z").data, written.columns["linear_acceleration.z"][: len(found)]
    )
    (remark,) = [one for one in found.remarks if one.code == "torn_file"]
    assert "bytes from byte" in remark.what


def test_the_covariance_of_the_driver_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    WRITERS["flat.mcap"](path)
    (remark,) = [one for one in ic.read(path).remarks if one.code == "stated_covariance"]
    assert remark.what == "standard deviation of angular_velocity by the driver: 0.01, 0.02, 0.03 rad/s"
    (gone,) = [one for one in ic.read(path).remarks if one.code == "variables_left_out"]
    assert gone.count == 4


def test_another_topic_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.db3"
    WRITERS["ros2.db3"](path)
    found = ic.read(path, topics=["/temperature"])
    np.testing.assert_array_equal(found.channel("temperature").data, [20.0, 21.0, 22.0])
    assert found.channel("temperature").unit == "degC"
    assert code(path, "/imu") == "wrong_column"
    assert "temperature" not in ic.read(path, topics=["/imu/data"]).names
    status, out, _ = call(capsys, "info", str(path), "--topic", "/temperature")
    assert (status, "temperature" in out) == (0, True)
    target = tmp_path / "t.csv"
    assert call(capsys, "convert", str(path), str(target), "--topic", "/temperature")[0] == 0
    assert len(ic.read(target)) == 3


def test_a_folder_of_a_ros_2_bag_in_two_files(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    folder.mkdir()
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    for number, (first, stop) in enumerate([(0, 150), (150, N)], start=9):
        mcap(folder / f"bag_{number}.mcap", first=first, stop=stop)
    found = ic.read(folder)
    assert len(found) == N
    np.testing.assert_array_equal(found.time_ns, STAMPS)
    (folder / "metadata.yaml").unlink()
    assert len(ic.read(folder)) == N
    with pytest.raises(UsageError):
        ic.read(folder, frame="sensor")


def test_several_recordings_are_listed_and_one_command_chooses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.ulg"
    WRITERS["px4.ulg"](path)
    status, said, _ = call(capsys, "info", str(path))
    assert status == 0
    for part in ("sensor_accel[0], 400 rows", "sensor_accel[1], 400 rows", "sensor_gyro, 400 rows"):
        assert f"PX4 ULog, {part}" in " ".join(said.split())  # folded behind a long path
    for topic in ("'sensor_accel[0]'", "'sensor_accel[1]'", "sensor_gyro"):  # the command for each
        assert f"{path} --topic {topic}\n" in said
    assert call(capsys, "info", str(path), "--topic", "sensor_accel[1]")[0] == 0
    assert call(capsys, "allan", str(path), "--topic", "sensor_gyro", "--quiet")[0] == 0


def test_a_campaign_of_a_topic_gives_the_same(tmp_path: Path) -> None:
    path = tmp_path / "a.ulg"
    WRITERS["px4.ulg"](path)
    folder = tmp_path / "campaign"
    found = ic.allan(path, topics=["sensor_gyro"])
    found.write_campaign(folder)
    assert 'topics = ["sensor_gyro"]' in (folder / "campaign.toml").read_text()
    ic.run(folder)
    again = {
        (one["quantity"], one["axis"]): one["value"]
        for one in json.loads((folder / "out" / "results.json").read_text())["results"]
    }
    assert {(one.quantity, one.axis): one.value for one in found.rows}.items() <= again.items()


EXTRAS = {"px4.ulg": "pyulog", "book.xlsx": "python_calamine", "labview.tdms": "nptdms", "text.uff": "pyuff",
          "flat.mf4": "asammdf", "steim.mseed": "pymseed", "zstd.mcap": "zstandard", "lz4.bag": "lz4"}  # fmt: skip


@pytest.mark.parametrize("name", EXTRAS)
def test_a_missing_extra_is_named_with_the_command(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path, missing = tmp_path / name, tmp_path / "missing"
    WRITERS[name](path)
    missing.mkdir()
    (missing / f"{EXTRAS[name]}.py").write_text("raise ImportError\n")
    for module in [one for one in sys.modules if one.partition(".")[0] == EXTRAS[name]]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.syspath_prepend(missing)
    with pytest.raises(DataError) as caught:
        ic.read(path)
    (problem,) = caught.value.problems
    assert (problem.code, problem.do) == ("missing_extra", "Type: pip install 'inertialcal[formats]'")


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    frame=st.text("abcdefgh_/", max_size=20), n=st.integers(1, 20), big=st.booleans(), ros_1=st.booleans(),
    seed=st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_messages_of_any_frame_are_decoded_as_rosbags_does(
    frame: str, n: int, big: bool, ros_1: bool, seed: int
) -> None:
    store = get_typestore(Stores.ROS1_NOETIC if ros_1 else Stores.ROS2_HUMBLE)
    time, header = store.types["builtin_interfaces/msg/Time"], store.types["std_msgs/msg/Header"]
    vector = store.types["geometry_msgs/msg/Vector3"]
    values = np.random.default_rng(seed).normal(size=(n, 12))
    messages = []
    for i in range(n):
        stamp = time(sec=1000 + i, nanosec=i)
        head = header(seq=i, stamp=stamp, frame_id=frame) if ros_1 else header(stamp=stamp, frame_id=frame)
        one = store.types["sensor_msgs/msg/MagneticField"](
            header=head, magnetic_field=vector(*values[i, :3]), magnetic_field_covariance=values[i, 3:]
        )
        kind = "sensor_msgs/msg/MagneticField"
        data = store.serialize_ros1(one, kind) if ros_1 else store.serialize_cdr(one, kind, little_endian=not big)
        messages.append(bytes(data))
    found = decode(messages, "MagneticField", "ros1" if ros_1 else "cdr")
    np.testing.assert_array_equal(found.values, values)
    np.testing.assert_array_equal(found.time_ns, [(1000 + i) * 10**9 + i for i in range(n)])
    assert found.frames == ((frame,) if frame else ())
    torn = decode([message[:-1] for message in messages], "MagneticField", "ros1" if ros_1 else "cdr")
    assert not len(torn.values)


def test_a_fifo_of_px4_is_laid_out(tmp_path: Path) -> None:
    path = tmp_path / "a.ulg"
    ulog_fifo(path)
    found = ic.read(path)
    np.testing.assert_allclose(found.channel("x").data, 0.5 * np.arange(3 * 40), rtol=1e-6)
    assert found.channel("x").unit == "rad/s"
    np.testing.assert_array_equal(found.time_ns, 1_000_000_000 + 250_000 * np.arange(3 * 40))


def test_headers_of_wav_that_were_never_completed(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    WRITERS["sound.wav"](path)
    content = bytearray(path.read_bytes())
    at = content.index(b"data") + 4
    for size in (bytes(4), b"\xff\xff\xff\xff"):
        content[at : at + 4] = size
        path.write_bytes(content)
        found = ic.read(path)
        assert len(found) == N
        assert "never completed" in found.remarks[0].what


def test_a_big_endian_wav(tmp_path: Path) -> None:
    path = tmp_path / "a.wav"
    layout = struct.pack(">HHIIHH", 1, 3, 200, 1200, 6, 16)
    body = COUNTS.astype(">i2").tobytes()
    path.write_bytes(
        b"RIFX" + struct.pack(">I", 36 + len(body)) + b"WAVEfmt " + struct.pack(">I", 16) + layout + b"data"
        + struct.pack(">I", len(body)) + body
    )  # fmt: skip
    np.testing.assert_array_equal(ic.read(path).array(), COUNTS)


def test_dataflash_bytes_between_messages_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    written = WRITERS["ardu.bin"](path)
    content = path.read_bytes()
    at = content.rindex(b"\xa3\x95\x84", 0, len(content) // 2)
    path.write_bytes(content[:at] + b"\xa3\x95garbage" + content[at:] + bytes(500))
    found = read(path, written)
    assert len(found) == N
    (remark,) = [one for one in found.remarks if one.code == "damaged_records"]
    assert remark.what.startswith("9 bytes between messages")
    assert not [one for one in found.remarks if one.code == "torn_file"]


def test_batches_of_a_long_log_give_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.bin"
    written = WRITERS["ardu.bin"](path)
    whole = read(path, written)
    monkeypatch.setattr(dataflash, "BLOCK", 997)
    np.testing.assert_array_equal(read(path, written).array(), whole.array())
    monkeypatch.setattr(batches, "HELD", 2000)
    long = read(path, written)
    np.testing.assert_array_equal(long.array(), whole.array())
    assert batches.is_stored(long.channels[0].data)


@pytest.mark.parametrize("name", ["flat.mcap", "plain.bag", "px4.ulg", "labview.tdms", "flat.mf4", "sound.wav",
                                  "zstd.feather", "table.db"])  # fmt: skip
def test_long_files_stay_in_place_and_give_the_same(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / name
    written = WRITERS[name](path)
    whole = read(path, written)
    monkeypatch.setattr(batches, "HELD", 1000)
    long = read(path, written)
    assert long.names == whole.names
    np.testing.assert_array_equal(long.array(), whole.array())
    np.testing.assert_array_equal(long.time_ns, whole.time_ns)
    assert batches.is_stored(long.channels[0].data)


APART = (".feather", ".arrow", ".mf4", ".mseed")  # whose libraries can crash, and take half a second to load


def damaged(whole: bytes, choice: random.Random) -> bytes:
    """Return a file with a few bytes changed, put in or taken out, most of them near its beginning."""
    content = bytearray(whole)
    for _ in range(choice.randint(1, 6)):
        at = choice.randrange(min(len(content), choice.choice([200, 3000, len(content)])))
        match choice.randrange(3):
            case 0:
                content[at] = choice.randrange(256)
            case 1:
                content[at : at + choice.randint(1, 9)] = choice.choice([b"", b"\xff\xff\xff\xff", bytes(8)])
            case _:
                del content[at : at + choice.randint(1, 400)]
    return bytes(content)


def no_end(*_: object) -> None:
    raise TimeoutError  # as the limit of a process of its own would have it


@pytest.mark.parametrize("name", [name for name in WRITERS if not name.endswith(("bz2.bag", "lz4.bag"))])
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # libraries leave files open
@pytest.mark.parametrize("times", [4, pytest.param(100, marks=pytest.mark.slow)])
def test_damaged_files_are_read_or_refused(
    tmp_path: Path, name: str, times: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    whole = path.read_bytes()
    choice = random.Random(name)
    is_apart = name.endswith(APART)
    if not is_apart:
        monkeypatch.setattr(apart, "is_possible", lambda: False)
    former = signal.signal(signal.SIGVTALRM, no_end)
    try:
        for _ in range(times // 2 if is_apart else 3 * times):
            path.write_bytes(damaged(whole, choice))
            signal.setitimer(signal.ITIMER_VIRTUAL, 3.0)
            try:
                ic.read(path)
            except InertialcalError as error:
                json.dumps([problem.to_dict() for problem in error.problems])
            finally:
                signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    finally:
        signal.signal(signal.SIGVTALRM, former)
        gc.collect()


def test_a_library_that_comes_to_no_end_is_a_damaged_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.ulg"
    WRITERS["px4.ulg"](path)
    stub = tmp_path / "stub"
    stub.mkdir()
    (stub / "pyulog.py").write_text(
        "import resource\nresource.setrlimit(resource.RLIMIT_CPU, (1, -1))\nwhile True: pass"
    )
    monkeypatch.syspath_prepend(stub)
    assert code(path) == "damaged_file"


def test_a_library_that_swells_is_refused_by_the_budget(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.ulg"
    WRITERS["px4.ulg"](path)
    stub = tmp_path / "stub"
    stub.mkdir()
    (stub / "pyulog.py").write_text("held = [bytes(2**26) for _ in range(100)]")
    monkeypatch.syspath_prepend(stub)
    assert code(path) == "too_large"
