"""Files of loggers with known content, written by the format's own library, or as its specification says.

Each writer puts three axes of a gyro and of an accelerometer into a file; what must come back stands in `Written`.
"""

from __future__ import annotations

import gc
import json
import sqlite3
import struct
import warnings
import wave
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

N, STEP = 400, 5_000_000  # samples, and nanoseconds between them
START = 1_700_000_000_000_000_000
RNG = np.random.default_rng(26)
GYRO, ACC = RNG.normal(size=(N, 3)), RNG.normal(size=(N, 3)) + np.array([0.0, 0.0, 9.8])
COUNTS = RNG.integers(-30_000, 30_000, size=(N, 3))
STAMPS = START + STEP * np.arange(N)
XYZ = ("x", "y", "z")


@dataclass(frozen=True)
class Written:
    """What a file must give."""

    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str | None]
    time_ns: NDArray[Any] | None = None
    sample_rate: float = 1e9 / STEP
    topic: str | None = None  # To be named, where there are several
    exact: bool = True
    remarks: tuple[str, ...] = field(default=())  # Codes that must be there


def _named(prefix: str, table: NDArray[Any]) -> dict[str, NDArray[Any]]:
    return {f"{prefix}{axis}": table[:, i] for i, axis in enumerate(XYZ)}


IMU = Written(
    _named("angular_velocity.", GYRO) | _named("linear_acceleration.", ACC),
    {"angular_velocity.x": "rad/s", "linear_acceleration.z": "m/s^2"},
    STAMPS,
    remarks=("stated_covariance", "frame_stated", "variables_left_out"),
)


def _imu_messages(types: Any, ros_1: bool) -> list[Any]:
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    found = []
    for i in range(N):
        stamp = time(sec=int(STAMPS[i] // 10**9), nanosec=int(STAMPS[i] % 10**9))
        head = header(seq=i, stamp=stamp, frame_id="imu_link") if ros_1 else header(stamp=stamp, frame_id="imu_link")
        found.append(types["sensor_msgs/msg/Imu"](
            header=head, orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0),
            orientation_covariance=np.array([-1.0, *[0.0] * 8]),
            angular_velocity=vector(*GYRO[i]), angular_velocity_covariance=np.diag([1e-4, 4e-4, 9e-4]).ravel(),
            linear_acceleration=vector(*ACC[i]), linear_acceleration_covariance=np.zeros(9)))  # fmt: skip
    return found


def temperatures(types: Any) -> list[Any]:
    """Return messages of a thermometer, one a second."""
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    kind = types["sensor_msgs/msg/Temperature"]
    stamps = [time(sec=1_700_000_000 + i, nanosec=0) for i in range(3)]
    return [kind(header=header(stamp=stamp, frame_id=""), temperature=20.0 + i, variance=0.25)
            for i, stamp in enumerate(stamps)]  # fmt: skip


def ros_1(path: Path, packed: str = "", chunk: int = 0) -> Written:
    """Write a bag of ROS 1, by default with the chunks of its library."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    writer = Writer(path)
    writer.chunk_threshold = chunk or writer.chunk_threshold
    if packed:
        writer.set_compression(Writer.CompressionFormat[packed])
    with writer:
        one = writer.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for stamp, message in zip(STAMPS, _imu_messages(store.types, True), strict=True):
            writer.write(one, int(stamp) + 700, store.serialize_ros1(message, "sensor_msgs/msg/Imu"))
    return IMU


def ros_2(path: Path, plugin: str = "SQLITE3") -> Written:
    """Write a bag of ROS 2, of which the file alone is kept, beside a thermometer."""
    from rosbags.rosbag2 import Writer
    from rosbags.rosbag2.enums import StoragePlugin
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    folder = path.parent / f"{path.stem}_folder"
    with Writer(folder, version=9, storage_plugin=StoragePlugin[plugin]) as writer:
        slow = writer.add_connection("/temperature", "sensor_msgs/msg/Temperature", typestore=store)
        one = writer.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for i, message in enumerate(temperatures(store.types)):
            data = store.serialize_cdr(message, "sensor_msgs/msg/Temperature")
            writer.write(slow, START + i * 10**9, data)
        for stamp, message in zip(STAMPS, _imu_messages(store.types, False), strict=True):
            writer.write(one, int(stamp) + 700, store.serialize_cdr(message, "sensor_msgs/msg/Imu"))
    (made,) = [one for one in folder.iterdir() if one.suffix in (".db3", ".mcap")]
    path.write_bytes(made.read_bytes())
    return Written(IMU.columns, IMU.units, STAMPS, remarks=(*IMU.remarks, "joined_by_time"))


def mcap(path: Path, packed: str = "ZSTD", chunked: bool = True, first: int = 0, stop: int = N) -> Written:
    """Write an MCAP file with messages of ROS 2, big endian."""
    from mcap.writer import CompressionType, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=10_000, compression=CompressionType[packed], use_chunking=chunked)
        writer.start(profile="ros2", library="other")
        schema = writer.register_schema("sensor_msgs/msg/Imu", "ros2msg", b"...")
        one = writer.register_channel("/imu/data", "cdr", schema)
        messages = _imu_messages(store.types, False)
        for stamp, message in zip(STAMPS[first:stop], messages[first:stop], strict=True):
            data = bytes(store.serialize_cdr(message, "sensor_msgs/msg/Imu", little_endian=False))
            writer.add_message(one, int(stamp) + 700, data, int(stamp))
        writer.finish()  # type: ignore[no-untyped-call]
    return IMU


def _ulog_message(kind: str, content: bytes) -> bytes:
    return struct.pack("<HB", len(content), ord(kind)) + content


def ulog(path: Path) -> Written:
    """Write a PX4 log as its specification says: two accelerometers and a gyro, a dropout between."""
    form = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;"
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1000), _ulog_message("B", bytes(40))]
    parts += [_ulog_message("F", f"{name}:{form}".encode()) for name in ("sensor_accel", "sensor_gyro")]
    for number, (multi, name) in enumerate([(0, "sensor_accel"), (1, "sensor_accel"), (0, "sensor_gyro")]):
        parts.append(_ulog_message("A", struct.pack("<BH", multi, number) + name.encode()))
    for i in range(N):
        stamp = 1_000_000 + STEP // 1000 * i
        for number, table in enumerate([ACC, -ACC, GYRO]):
            row = struct.pack("<HQQI4f", number, stamp + 333, stamp, 7, *table[i], 25.0 + i)
            parts.append(_ulog_message("D", row))
        if i == 5:
            parts.append(_ulog_message("O", struct.pack("<H", 40)))
    path.write_bytes(b"".join(parts))
    wanted = _named("", GYRO.astype(np.float32)) | {"temperature": (25.0 + np.arange(N)).astype(np.float32)}
    time_ns = 1_000_000_000 + STEP * np.arange(N)
    units = {"x": "rad/s", "temperature": "degC", "device_id": None}
    return Written(wanted, units, time_ns, topic="sensor_gyro", remarks=("dropouts", "other_topics"))


def ulog_fifo(path: Path) -> None:
    """Write 40 messages of a FIFO with three samples each, every 250 us."""
    arrays = ";".join(f"int16_t[32] {axis}" for axis in XYZ)
    form = (
        f"sensor_gyro_fifo:uint64_t timestamp;uint64_t timestamp_sample;float dt;float scale;uint8_t samples;{arrays};"
    )
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1000), _ulog_message("B", bytes(40))]
    parts += [_ulog_message("F", form.encode()), _ulog_message("A", struct.pack("<BH", 0, 0) + b"sensor_gyro_fifo")]
    for i in range(40):
        newest = 1_000_000 + 250 * (3 * i + 2)
        counts = [3 * i, 3 * i + 1, 3 * i + 2, *[0] * 29]
        row = struct.pack("<HQQffB96h", 0, newest + 50, newest, 250.0, 0.5, 3, *counts, *[0] * 64)
        parts.append(_ulog_message("D", row))
    path.write_bytes(b"".join(parts))


FORMATS = {  # number, letters, labels, units, multipliers
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns", "", ""),
    "FMTU": (129, "QBNN", "TimeUS,FmtType,UnitIds,MultIds", "", ""),
    "UNIT": (130, "QbZ", "TimeUS,Id,Label", "", ""),
    "MULT": (131, "Qbd", "TimeUS,Id,Mult", "", ""),
    "IMU": (132, "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz",
            "s#EEEooo--O--zz", "F-000000-----00"),
    "ATT": (133, "Qccc", "TimeUS,Roll,Pitch,Yaw", "sddd", "FBBB"),
}  # fmt: skip
STRUCTS = {
    "b": "b",
    "B": "B",
    "n": "4s",
    "N": "16s",
    "Z": "64s",
    "Q": "Q",
    "d": "d",
    "f": "f",
    "I": "I",
    "H": "H",
    "c": "h",
}
UNITS = {"s": "s", "E": "rad/s", "o": "m/s/s", "O": "degC", "d": "deg", "z": "Hz", "#": "instance", "-": ""}
MULTIPLIERS = {"F": 1e-6, "0": 1.0, "B": 1e-2, "-": 0.0}


def dataflash_message(name: str, *values: Any) -> bytes:
    """Return a message of an ArduPilot log."""
    number, letters, *_ = FORMATS[name]
    packed = [value.encode() if isinstance(value, str) else value for value in values]
    return b"\xa3\x95" + bytes([number]) + struct.pack("<" + "".join(map(STRUCTS.get, letters)), *packed)  # type: ignore[arg-type]


def dataflash(path: Path) -> Written:
    """Write an ArduPilot log with two IMUs."""
    parts = []
    for name, (number, letters, labels, *_) in FORMATS.items():
        size = 3 + struct.calcsize("<" + "".join(map(STRUCTS.get, letters)))  # type: ignore[arg-type]
        parts.append(dataflash_message("FMT", number, size, name, letters, labels))
    for name, text in UNITS.items():
        parts.append(dataflash_message("UNIT", 5, ord(name), text))
    for name, factor in MULTIPLIERS.items():
        parts.append(dataflash_message("MULT", 5, ord(name), factor))
    for number, _, _, units, multipliers in FORMATS.values():
        if units:
            parts.append(dataflash_message("FMTU", 5, number, units, multipliers))
    for i in range(N):
        stamp = 2_000_000 + STEP // 1000 * i
        for instance, sign in ((0, 1.0), (1, -1.0)):
            readings = (*sign * GYRO[i], *sign * ACC[i])
            parts.append(dataflash_message("IMU", stamp, instance, *readings, 0, 0, 31.5, 1, 1, 200, 200))
        parts.append(dataflash_message("ATT", stamp, -1234, 5, i))
    path.write_bytes(b"".join(parts))
    wanted = {f"{name}{axis}": -table[:, i].astype(np.float32)
              for name, table in (("Gyr", GYRO), ("Acc", ACC)) for i, axis in enumerate("XYZ")}  # fmt: skip
    return Written(
        wanted,
        {"GyrX": "rad/s", "AccZ": "m/s^2", "T": "degC", "GHz": "Hz"}, 2_000_000_000 + STEP * np.arange(N),
        topic="IMU[1]", remarks=("frame_stated", "other_topics"),
    )  # fmt: skip


def dataflash_text(path: Path) -> Written:
    """Write a log of an old ArduPilot as text."""
    lines = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
             "FMT, 131, 43, IMU, Qffffff, TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ",
             "FMT, 132, 14, ATT, Qccc, TimeUS,Roll,Pitch,Yaw"]  # fmt: skip
    lines[1] = lines[1].replace("43", "35")
    lines[2] = lines[2].replace("14", "17")
    for i in range(N):
        stamp = STEP // 1000 * i
        lines.append(f"IMU, {stamp}, {', '.join(f'{value:.6f}' for value in (*GYRO[i], *ACC[i]))}")
        lines.append(f"ATT, {stamp}, -12.34, 0.05, {i / 100:.2f}")
    path.write_text("\r\n".join(lines) + "\r\n")
    wanted = {"GyrX": GYRO[:, 0].round(6), "AccZ": ACC[:, 2].round(6)}
    return Written(wanted, {"GyrX": "rad/s", "AccX": "m/s^2"}, STEP * np.arange(N), remarks=("other_topics",))


def excel(path: Path) -> Written:
    """Write a workbook: a title above, a sheet of notes, formulas that nobody computed."""
    from openpyxl import Workbook

    book = Workbook()
    sheet = book.active
    sheet.title = "Run 7"
    sheet.append(["Rate table, 7 May"])
    sheet.append([])
    sheet.append(["time", "gyro_x [deg/s]", "gyro_y [deg/s]", "gyro_z [deg/s]", "count", "twice"])
    for i in range(N):
        row = [i * STEP / 1e9, *map(float, GYRO[i]), int(COUNTS[i, 0]), f"=2*B{i + 4}"]
        sheet.append(row)
    sheet.cell(10, 3).value = None
    book.create_sheet("Notes").append(["made by", "K."])
    book.save(path)
    gyro_y = GYRO[:, 1].copy()
    gyro_y[6] = np.nan
    wanted = {"gyro_x [deg/s]": GYRO[:, 0], "gyro_y [deg/s]": gyro_y, "count": COUNTS[:, 0]}
    time_ns = np.rint(np.arange(N) * STEP / 1e9 * 1e9).astype(np.int64)
    return Written(wanted, {"gyro_x [deg/s]": "deg/s"}, time_ns, exact=False,
                   remarks=("not_computed", "other_topics", "missing_cells"))  # fmt: skip


def tdms(path: Path) -> Written:
    """Write a TDMS file in two segments: a waveform in UTC, and a slow group of another rate."""
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

    about = {"wf_increment": STEP / 1e9, "wf_start_time": np.datetime64(START, "ns").astype("datetime64[us]"),
             "wf_start_offset": 0.0, "unit_string": "deg/s"}  # fmt: skip
    with TdmsWriter(str(path)) as writer:
        for part in (slice(0, 150), slice(150, N)):
            fast = [ChannelObject("IMU", f"gyro_{axis}", GYRO[part, i], about) for i, axis in enumerate(XYZ)]
            raw = ChannelObject("IMU", "raw", COUNTS[part, 0].astype(np.int16), about | {"unit_string": "count"})
            writer.write_segment([RootObject({"author": "K."}), GroupObject("IMU"), *fast, raw])
        writer.write_segment([ChannelObject("slow", "label", np.array(["a", "b"]))])
    wanted = _named("gyro_", GYRO) | {"raw": COUNTS[:, 0].astype(np.int16)}
    return Written(wanted, {"gyro_x": "deg/s", "raw": "count"}, STAMPS, remarks=("variables_left_out",))


def uff(path: Path, binary: int = 0) -> Written:
    """Write a universal file: three axes as functions of time, and a spectrum."""
    import pyuff

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # its writer leaves files open
        _write_uff(pyuff, path, binary)
        gc.collect()
    wanted = _named("acc_12_", ACC)
    time_ns = STEP * np.arange(N)
    return Written(wanted, {"acc_12_x": "m/s^2"}, time_ns, exact=bool(binary), remarks=("variables_left_out",))


def _write_uff(pyuff: Any, path: Path, binary: int) -> None:
    file = pyuff.UFF(str(path))
    x = np.arange(N) * STEP / 1e9
    for i in range(3):
        file.write_sets(pyuff.prepare_58(
            binary=binary, func_type=1, rsp_node=12, rsp_dir=i + 1, rsp_ent_name="NONE", ref_dir=0, ref_node=0,
            data=ACC[:, i], x=x, id1="accelerometer", abscissa_spacing=1, abscissa_inc=STEP / 1e9, abscissa_min=0.0,
            abscissa_spec_data_type=17, ordinate_spec_data_type=12, ordinate_axis_units_lab="m/s^2",
            orddenom_spec_data_type=0, num_pts=N, z_axis_value=0.0,
        ), "add")  # fmt: skip
    file.write_sets(pyuff.prepare_58(
        binary=0, func_type=4, rsp_node=1, rsp_dir=1, ref_dir=1, ref_node=1, data=np.ones(5) + 1j, x=np.arange(5.0),
        id1="frf", abscissa_spacing=1, abscissa_inc=1.0, abscissa_min=0.0, abscissa_spec_data_type=18,
        ordinate_spec_data_type=12, orddenom_spec_data_type=13, num_pts=5,
    ), "add")  # fmt: skip


def uff_binary(path: Path) -> Written:
    """Write the same in binary sets 58b."""
    return uff(path, 1)


def wav(path: Path) -> Written:
    """Write a WAV file of 16 bits."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(3)
        file.setsampwidth(2)
        file.setframerate(200)
        file.writeframes(COUNTS.astype("<i2").tobytes())
    return Written({f"channel_{i + 1}": COUNTS[:, i] for i in range(3)}, {"channel_1": None}, None)


def wav_float(path: Path) -> Written:
    """Write a WAV file of floats, by scipy."""
    from scipy.io import wavfile

    wavfile.write(path, 200, ACC.astype(np.float32))
    return Written({f"channel_{i + 1}": ACC[:, i].astype(np.float32) for i in range(3)}, {}, None)


def wav_24(path: Path) -> Written:
    """Write a WAV file of 24 bits."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(3)
        file.setsampwidth(3)
        file.setframerate(200)
        wide = (COUNTS * 200).astype("<i4")
        file.writeframes(wide.reshape(-1, 1).view(np.uint8).reshape(-1, 4)[:, :3].tobytes())
    return Written({f"channel_{i + 1}": COUNTS[:, i] * 200 for i in range(3)}, {}, None)


def _arrow_table() -> Any:
    import pyarrow as pa

    fields = [pa.field("time", pa.timestamp("us", tz="UTC")), pa.field("label", pa.string())]
    fields += [pa.field(f"gyro_{axis}", pa.float32(), metadata={"unit": "deg/s"}) for axis in XYZ]
    arrays = [pa.array(STAMPS // 1000, pa.int64()).cast(fields[0].type), pa.array(["a"] * N)]
    arrays += [pa.array(GYRO[:, i].astype(np.float32)) for i in range(3)]
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


ARROW = Written(_named("gyro_", GYRO.astype(np.float32)), {"gyro_x": "deg/s"}, STAMPS, remarks=("text_column",))


def feather(path: Path) -> Written:
    """Write a Feather file packed by zstd, in several batches."""
    from pyarrow import feather as arrow_feather

    arrow_feather.write_feather(_arrow_table(), path, compression="zstd", chunksize=70)
    return ARROW


def arrow_stream(path: Path) -> Written:
    """Write an Arrow stream."""
    from pyarrow import ipc

    table = _arrow_table()
    with ipc.new_stream(path, table.schema) as writer:
        writer.write_table(table, max_chunksize=70)
    return ARROW


def mdf(path: Path, compression: Literal[0, 2] = 2) -> Written:
    """Write an MDF 4 file: packed data blocks, a linear conversion, a group of another rate."""
    from asammdf import MDF, Signal

    t = np.arange(N) * STEP / 1e9
    scale: dict[str, object] = {"a": 0.125, "b": -3.0}
    fast = [Signal(GYRO[:, i], t, name=f"gyro_{axis}", unit="deg/s") for i, axis in enumerate(XYZ)]
    fast.append(Signal(COUNTS[:, 0].astype(np.int16), t, name="volts", unit="V", conversion=scale))
    with MDF(version="4.10") as file:
        file.header.start_time = datetime(2024, 3, 12, 9, 15, tzinfo=UTC)
        file.append(fast, acq_name="imu", common_timebase=True)
        file.append([Signal(np.arange(5.0), np.arange(5.0), name="temperature", unit="degC")], acq_name="slow")
        file.save(path, overwrite=True, compression=compression)
    wanted = _named("gyro_", GYRO) | {"volts": COUNTS[:, 0] * 0.125 - 3.0}
    units = {"gyro_x": "deg/s", "volts": "V"}
    return Written(wanted, units, STEP * np.arange(N), topic="imu", remarks=("other_topics", "start_stated"))


def lvm(path: Path) -> Written:
    """Write a LabVIEW measurement with a decimal comma, two segments and a special block."""
    head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t,",
            "Multi_Headings\tYes", "X_Columns\tOne", "Time_Pref\tAbsolute", "Date\t2024/03/12", "Time\t09:15:00,0",
            "***End_of_Header***\t", "\t"]  # fmt: skip
    for first, stop in ((0, 250), (250, N)):
        clock = f"09:15:{first * STEP / 1e9:09.6f}".replace(".", ",")
        head += ["Channels\t3\t\t\t", f"Samples\t{stop - first}\t{stop - first}\t{stop - first}\t",
                 "Date\t2024/03/12\t2024/03/12\t2024/03/12\t", "\t".join(["Time", *[clock] * 3, ""]),
                 "Y_Unit_Label\tdeg/s\tdeg/s\tdeg/s\t", "X_Dimension\tTime\tTime\tTime\t",
                 "X0\t0,0\t0,0\t0,0\t", "Delta_X\t0,005\t0,005\t0,005\t", "***Start_Special***\t", "anything\tat all",
                 "***End_Special***\t", "***End_of_Header***\t\t\t\t",
                 "X_Value\tgyro_x\tgyro_y\tgyro_z\tComment"]  # fmt: skip
        for i in range(first, stop):
            cells = [f"{(i - first) * STEP / 1e9:.6f}", *(f"{value:.9f}" for value in GYRO[i])]
            head.append("\t".join(cells).replace(".", ","))
        head.append("")
    path.write_text("\r\n".join(head))
    wanted = _named("gyro_", GYRO.round(9))
    return Written(wanted, {"gyro_x": "deg/s"}, STEP * np.arange(N), remarks=("start_stated", "variables_left_out"))


def miniseed(path: Path) -> Written:
    """Write three components in miniSEED 3, packed by Steim 2, in records of 512 bytes."""
    from pymseed import DataEncoding, MS3TraceList

    with MS3TraceList() as traces, path.open("wb") as stream:
        for i, component in enumerate("12Z"):
            traces.add_data(sourceid=f"FDSN:XX_LAB_00_H_N_{component}", data_samples=COUNTS[:, i].astype(np.int32),
                            sample_type="i", sample_rate=200.0, starttime=START)  # fmt: skip
        for record in traces.generate(max_record_length=512, encoding=DataEncoding.STEIM2, format_version=3):
            stream.write(record)
    wanted = {f"XX_LAB_00_H_N_{component}": COUNTS[:, i] for i, component in enumerate("12Z")}
    return Written(wanted, {"XX_LAB_00_H_N_Z": "count"}, STAMPS)


def sqlite(path: Path) -> Written:
    """Write a table of a database, with a text column and a missing cell, beside a table of words."""
    with sqlite3.connect(path) as connection:
        connection.execute('CREATE TABLE "my log" (time_ns INTEGER, "gyro_x [deg/s]" REAL, raw INTEGER, label TEXT)')
        rows = [(int(STAMPS[i]), None if i == 3 else GYRO[i, 0], int(COUNTS[i, 0]), "a") for i in range(N)]
        connection.executemany('INSERT INTO "my log" VALUES (?, ?, ?, ?)', rows)
        connection.execute("CREATE TABLE about (name TEXT)")
        connection.execute("INSERT INTO about VALUES ('K.')")
    connection.close()
    gyro = GYRO[:, 0].copy()
    gyro[3] = np.nan
    return Written({"gyro_x [deg/s]": gyro, "raw": COUNTS[:, 0]}, {"gyro_x [deg/s]": "deg/s"}, STAMPS,
                   remarks=("other_topics", "text_column", "missing_cells"))  # fmt: skip


def json_lines(path: Path, words: bool = True) -> Written:
    """Write an object a line: nested, with a list, a text, a key that some lack, and of a second sensor among them."""
    with path.open("w", encoding="utf-8") as file:
        for i in range(N):
            cells: dict[str, Any] = {"sensor": "imu", "time_ns": int(STAMPS[i]), "acc": GYRO[i].tolist(),
                                     "gyro_dps": dict(zip(XYZ, ACC[i].tolist(), strict=True)), "raw": int(COUNTS[i, 0]),
                                     **({"state": "run"} if words else {})}  # fmt: skip
            file.write(json.dumps(cells | ({} if i == 3 else {"field": COUNTS[i, 1] / 8})) + "\n")
            file.write(json.dumps({"sensor": "baro", "t": i, "p": 1013.2}) + "\n" if i % 4 == 0 else "")
    field = COUNTS[:, 1] / 8
    field[3] = np.nan
    wanted = {f"acc.{i + 1}": GYRO[:, i] for i in range(3)} | _named("gyro_dps.", ACC)
    return Written(wanted | {"raw": COUNTS[:, 0], "field": field}, {"gyro_dps.x": "deg/s", "raw": None}, STAMPS,
                   remarks=("other_topics", "text_column", "missing_cells"))  # fmt: skip


WRITERS: dict[str, Callable[[Path], Written]] = {
    "plain.bag": ros_1,
    "bz2.bag": lambda path: ros_1(path, "BZ2"),
    "lz4.bag": lambda path: ros_1(path, "LZ4"),
    "ros2.db3": ros_2,
    "ros2.mcap": lambda path: ros_2(path, "MCAP"),
    "zstd.mcap": mcap,
    "lz4.mcap": lambda path: mcap(path, "LZ4"),
    "flat.mcap": lambda path: mcap(path, "NONE", False),
    "px4.ulg": ulog,
    "ardu.bin": dataflash,
    "ardu.log": dataflash_text,
    "book.xlsx": excel,
    "labview.tdms": tdms,
    "text.uff": uff,
    "binary.uff": uff_binary,
    "sound.wav": wav,
    "float.wav": wav_float,
    "wide.wav": wav_24,
    "zstd.feather": feather,
    "stream.arrow": arrow_stream,
    "packed.mf4": mdf,
    "flat.mf4": lambda path: mdf(path, 0),
    "labview.lvm": lvm,
    "steim.mseed": miniseed,
    "table.db": sqlite,
    "lines.jsonl": json_lines,
}
