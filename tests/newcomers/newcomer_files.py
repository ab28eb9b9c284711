"""Files of loggers as people have them: made by the format's own library, or by hand as the logger writes them.

The options are others than those the readers were written from: other compressions, other names of topics and
channels, other numbers. Each writer takes a `Board` and writes a file, or a folder.
"""

from __future__ import annotations

import gc
import sqlite3
import struct
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from newcomer_boards import Board, G

START = 1_710_234_900  # 2024-03-12 09:15:00 UTC
XYZ = "xyz"
DEG = 180.0 / np.pi
Writer = Callable[[Board, Path], None]


def stamps(board: Board) -> np.ndarray[Any, Any]:
    """Return the instants of the samples [ns]."""
    return START * 10**9 + np.rint(board.time * 1e9).astype(np.int64)


def columns(board: Board, gyro: str, acc: str, by_axis: Sequence[str] = XYZ) -> dict[str, Any]:
    """Return both sensors as columns, in rad/s and m/s^2."""
    found = {gyro.format(name): board.gyro[:, i] for i, name in enumerate(by_axis)}
    return found | {acc.format(name): board.acc[:, i] for i, name in enumerate(by_axis)}


def _imu(types: Any, board: Board, ros_1: bool, rows: range) -> list[Any]:
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    imu, zeros = types["sensor_msgs/msg/Imu"], np.zeros(9)
    found = []
    for i, ns in zip(rows, stamps(board)[rows.start : rows.stop], strict=True):
        stamp = time(sec=int(ns // 10**9), nanosec=int(ns % 10**9))
        head = header(seq=i, stamp=stamp, frame_id="base") if ros_1 else header(stamp=stamp, frame_id="base")
        found.append(imu(header=head, orientation=turn(x=0.0, y=0.0, z=0.0, w=0.0), orientation_covariance=zeros,
                         angular_velocity=vector(*board.gyro[i]), angular_velocity_covariance=zeros,
                         linear_acceleration=vector(*board.acc[i]), linear_acceleration_covariance=zeros))  # fmt: skip
    return found


SLOW = 7  # samples to a message of a thermometer, which comes a third of a sample late


def _warm(types: Any, board: Board, old: bool) -> list[tuple[int, Any]]:
    """Return stamps and messages of a thermometer with a clock of its own."""
    kind = types["sensor_msgs/msg/Temperature"]
    stamp = types["builtin_interfaces/msg/Time"]
    head = types["std_msgs/msg/Header"]
    found = []
    late = round(1e9 / board.sample_rate / 3)
    for k in range(0, len(board.time), SLOW):
        ns = int(stamps(board)[k]) + late
        said = {"stamp": stamp(sec=ns // 10**9, nanosec=ns % 10**9), "frame_id": "housing"} | (
            {"seq": k} if old else {}
        )
        found.append((ns, kind(header=head(**said), temperature=float(board.temperature[k]), variance=0.0)))
    return found


def ros_1(topic: str, packed: str = "", warm: bool = False) -> Writer:
    """Return a writer of a bag of ROS 1 with a topic of words beside, and a thermometer."""

    def write(board: Board, path: Path) -> None:
        from rosbags.rosbag1 import Writer as Bag
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores.ROS1_NOETIC)
        bag = Bag(path)
        if packed:
            bag.set_compression(Bag.CompressionFormat[packed])
        with bag:
            said = bag.add_connection("/diag", "std_msgs/msg/String", typestore=store)
            one = bag.add_connection(topic, "sensor_msgs/msg/Imu", typestore=store)
            text = store.types["std_msgs/msg/String"](data="ready")
            bag.write(said, START * 10**9, store.serialize_ros1(text, "std_msgs/msg/String"))
            for stamp, message in zip(
                stamps(board), _imu(store.types, board, True, range(len(board.time))), strict=True
            ):
                bag.write(one, int(stamp) + 2_000_000, store.serialize_ros1(message, "sensor_msgs/msg/Imu"))
            slow = bag.add_connection("/housing", "sensor_msgs/msg/Temperature", typestore=store) if warm else one
            for stamp, message in _warm(store.types, board, True) if warm else ():
                bag.write(slow, stamp, store.serialize_ros1(message, "sensor_msgs/msg/Temperature"))

    return write


def ros_2(topic: str, plugin: str, packed: str = "", store_name: str = "ROS2_IRON", warm: bool = False) -> Writer:
    """Return a writer of a folder of ROS 2; a path with an ending gets its only file."""

    def write(board: Board, path: Path) -> None:
        from rosbags.rosbag2 import Writer as Bag
        from rosbags.rosbag2.enums import CompressionFormat, CompressionMode, StoragePlugin
        from rosbags.typesys import Stores, get_typestore

        store = get_typestore(Stores[store_name])
        folder = path if not path.suffix else path.parent / f"{path.name}_bag"
        bag = Bag(folder, version=8, storage_plugin=StoragePlugin[plugin])
        if packed:
            bag.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
        with bag:
            one = bag.add_connection(topic, "sensor_msgs/msg/Imu", typestore=store)
            said = bag.add_connection("/rosout", "std_msgs/msg/String", typestore=store)
            text = store.types["std_msgs/msg/String"](data="ready")
            bag.write(said, START * 10**9, store.serialize_cdr(text, "std_msgs/msg/String"))
            for stamp, message in zip(
                stamps(board), _imu(store.types, board, False, range(len(board.time))), strict=True
            ):
                bag.write(one, int(stamp) + 3_000_000, store.serialize_cdr(message, "sensor_msgs/msg/Imu"))
            slow = bag.add_connection("/housing", "sensor_msgs/msg/Temperature", typestore=store) if warm else one
            for stamp, message in _warm(store.types, board, False) if warm else ():
                bag.write(slow, stamp, store.serialize_cdr(message, "sensor_msgs/msg/Temperature"))
        if folder != path:
            (made,) = [one for one in folder.iterdir() if one.suffix in (".db3", ".mcap")]
            path.write_bytes(made.read_bytes())

    return write


def mcap_ros_1(board: Board, path: Path) -> None:
    """Write an MCAP converted from ROS 1: no index of chunks, no statistics, LZ4."""
    from mcap.writer import CompressionType, IndexType
    from mcap.writer import Writer as Mcap
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with path.open("wb") as stream:
        mcap = Mcap(stream, chunk_size=50_000, compression=CompressionType.LZ4, index_types=IndexType.NONE,
                    use_statistics=False, enable_crcs=False)  # fmt: skip
        mcap.start(profile="ros1", library="converted")
        text, _ = store.generate_msgdef("sensor_msgs/msg/Imu")
        schema = mcap.register_schema("sensor_msgs/Imu", "ros1msg", text.encode())
        one = mcap.register_channel("/xsens/imu", "ros1", schema)
        for stamp, message in zip(stamps(board), _imu(store.types, board, True, range(len(board.time))), strict=True):
            data = bytes(store.serialize_ros1(message, "sensor_msgs/msg/Imu"))
            mcap.add_message(one, int(stamp) + 900_000, data, int(stamp) + 900_000)
        mcap.finish()  # type: ignore[no-untyped-call]


def _field(number: int, content: bytes) -> bytes:
    """Return a field of Protobuf with a length."""
    size = len(content)
    return bytes([number << 3 | 2, *([size] if size < 128 else [size & 0x7F | 0x80, size >> 7])]) + content


def _declared(name: str, *fields: tuple[str, int, str]) -> bytes:
    """Return a type of messages of Protobuf: names of its fields, their types, and of which message they are."""
    found = _field(1, name.encode())
    for number, (label, kind, of) in enumerate(fields, start=1):
        about = _field(1, label.encode()) + bytes([3 << 3, number, 4 << 3, 1, 5 << 3, kind])
        found += _field(2, about + (_field(6, of.encode()) if of else b""))
    return found


def mcap_protobuf(board: Board, path: Path) -> None:
    """Write an MCAP of a team's own Protobuf messages, beside images, recorded later than they were stamped."""
    from mcap.writer import Writer as Mcap

    stamp = _declared("Timestamp", ("seconds", 3, ""), ("nanos", 5, ""))
    vector = _declared("Vector", *((name, 1, "") for name in XYZ))
    reading = _declared("Imu", ("stamp", 11, ".google.protobuf.Timestamp"), ("gyro_rad_s", 11, ".team.Vector"),
                        ("acc_m_s2", 11, ".team.Vector"), ("picture", 12, ""))  # fmt: skip
    files = (
        _field(2, b"google.protobuf") + _field(4, stamp),
        _field(2, b"team") + _field(4, vector) + _field(4, reading),
    )
    described = b"".join(_field(1, one + _field(12, b"proto3")) for one in files)

    def varint(value: int) -> bytes:
        return bytes([*((value >> 7 * i) & 0x7F | 0x80 for i in range(4)), value >> 28])

    def axes(values: Any) -> bytes:  # what is zero is not written
        return b"".join(bytes([n << 3 | 1]) + struct.pack("<d", one) for n, one in enumerate(values, start=1) if one)

    with path.open("wb") as stream:
        mcap = Mcap(stream, chunk_size=20_000)
        mcap.start(profile="", library="team")
        one = mcap.register_channel("/imu", "protobuf", mcap.register_schema("team.Imu", "protobuf", described))
        for i, ns in enumerate(stamps(board)):
            at = b"\x08" + varint(int(ns) // 10**9) + (b"\x10" + varint(int(ns) % 10**9) if ns % 10**9 else b"")
            data = _field(1, at) + _field(2, axes(board.gyro[i])) + _field(3, axes(board.acc[i])) + _field(4, bytes(9))
            mcap.add_message(one, int(ns) + 700_000 * (1 + i % 3), data, int(ns))
        mcap.finish()  # type: ignore[no-untyped-call]


def mcap_json(board: Board, path: Path) -> None:
    """Write an MCAP of JSON objects with stamps of seconds and nanoseconds."""
    import json

    from mcap.writer import Writer as Mcap

    with path.open("wb") as stream:
        mcap = Mcap(stream)
        mcap.start(profile="", library="script")
        schema = mcap.register_schema("Imu", "jsonschema", b'{"type": "object"}')
        one = mcap.register_channel("/imu", "json", schema)
        for i, ns in enumerate(stamps(board)):
            said = {"stamp": {"sec": int(ns) // 10**9, "nsec": int(ns) % 10**9},
                    "gyro_rad_s": board.gyro[i].tolist(), "acc_m_s2": board.acc[i].tolist()}  # fmt: skip
            mcap.add_message(one, int(ns) + 700_000 * (1 + i % 3), json.dumps(said).encode(), int(ns))
        mcap.finish()  # type: ignore[no-untyped-call]


def _ulog_message(kind: str, content: bytes) -> bytes:
    return struct.pack("<HB", len(content), ord(kind)) + content


def ulog_combined(board: Board, path: Path) -> None:
    """Write the topic `sensor_combined` of PX4, whose axes are elements of arrays, beside slow battery voltages."""
    form = (
        "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;"
        "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;"
        "uint8_t accelerometer_clipping;uint8_t gyro_clipping;uint8_t accelerometer_calibration_count;"
        "uint8_t gyro_calibration_count;"
    )
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 500), _ulog_message("B", bytes(40))]
    parts += [_ulog_message("I", struct.pack("<B", 20) + b"char[8] sys_name" + b"PX4\0")]
    parts += [_ulog_message("F", form.encode()), _ulog_message("F", b"battery:uint64_t timestamp;float voltage_v;")]
    for number, name in enumerate((b"sensor_combined", b"battery")):
        parts.append(_ulog_message("A", struct.pack("<BH", 0, number) + name))
    for i, t in enumerate(board.time):
        stamp = 30_000_000 + round(t * 1e6)
        row = struct.pack("<HQ3fIi3fI4B", 0, stamp, *board.gyro[i], 5000, 0, *board.acc[i], 5000, 0, 0, 1, 1)
        parts.append(_ulog_message("D", row))
        if i % 100 == 0:
            parts.append(_ulog_message("D", struct.pack("<HQf", 1, stamp, 12.1)))
    path.write_bytes(b"".join(parts))


def ulog_sensors(board: Board, path: Path) -> None:
    """Write gyro and accelerometer of PX4 as topics of their own, as it does when told to log all."""
    form = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;"
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 500), _ulog_message("B", bytes(40))]
    parts += [_ulog_message("F", f"{name}:{form}".encode()) for name in ("sensor_accel", "sensor_gyro")]
    for number, name in enumerate((b"sensor_accel", b"sensor_gyro")):
        parts.append(_ulog_message("A", struct.pack("<BH", 0, number) + name))
    for i, t in enumerate(board.time):
        stamp = 30_000_000 + round(t * 1e6)
        for number, table in enumerate((board.acc, board.gyro)):
            row = struct.pack("<HQQI4f", number, stamp + 400, stamp, 9, *table[i], board.temperature[i])
            parts.append(_ulog_message("D", row))
    path.write_bytes(b"".join(parts))


def _dataflash(formats: dict[str, tuple[int, str, str]], rows: Sequence[tuple[Any, ...]]) -> bytes:
    """Return a log of ArduPilot: formats by number, letters, labels; rows begin with their name."""
    kinds = {"b": "b", "B": "B", "n": "4s", "N": "16s", "Z": "64s", "Q": "Q", "f": "f", "I": "I", "H": "H", "c": "h"}
    made = {"FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns")} | formats
    structs = {name: "<" + "".join(kinds[one] for one in letters) for name, (_, letters, _) in made.items()}
    parts = []
    for name, (number, letters, labels) in made.items():
        size = 3 + struct.calcsize(structs[name])
        about = struct.pack(structs["FMT"], number, size, name.encode(), letters.encode(), labels.encode())
        parts.append(b"\xa3\x95\x80" + about)
    parts += [b"\xa3\x95" + bytes([made[name][0]]) + struct.pack(structs[name], *values) for name, *values in rows]
    return b"".join(parts)


def dataflash_old(board: Board, path: Path) -> None:
    """Write a log from before units stood in logs, with parameters and text messages between."""
    formats = {
        "IMU": (140, "QffffffIIfBBHH", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
        "PARM": (141, "QNf", "TimeUS,Name,Value"),
        "MSG": (142, "QZ", "TimeUS,Message"),
    }
    rows: list[tuple[Any, ...]] = [("MSG", 10, b"ArduCopter V4.0.3"), ("PARM", 20, b"INS_GYR_ID", 1.0)]
    for i, t in enumerate(board.time):
        end = (0, 0, board.temperature[i], 1, 1, 1000, 1000)
        rows.append(("IMU", 5_000_000 + round(t * 1e6), *board.gyro[i], *board.acc[i], *end))
    path.write_bytes(_dataflash(formats, rows))


def dataflash_raw(board: Board, path: Path) -> None:
    """Write the raw logs of ArduPilot: gyro and accelerometer as messages of their own."""
    formats = {
        "GYR": (150, "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ"),
        "ACC": (151, "QBQfff", "TimeUS,I,SampleUS,AccX,AccY,AccZ"),
    }
    rows: list[tuple[Any, ...]] = []
    for i, t in enumerate(board.time):
        stamp = 5_000_000 + round(t * 1e6)
        rows += [("GYR", stamp, 0, stamp, *board.gyro[i]), ("ACC", stamp, 0, stamp, *board.acc[i])]
    path.write_bytes(_dataflash(formats, rows))


def dataflash_text(board: Board, path: Path) -> None:
    """Write the text of a ground station: an instance of the IMU, units as numbers of FMTU lines."""
    labels = "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,T"
    lines = ["FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns", f"FMT, 150, 40, IMU, QBfffffff, {labels}",
             "FMT, 151, 14, MODE, QMBB, TimeUS,Mode,ModeNum,Rsn", "MODE, 4000000, STABILIZE, 0, 1"]  # fmt: skip
    for i, t in enumerate(board.time):
        cells = [f"{one:.7f}" for one in (*board.gyro[i], *board.acc[i])]
        lines.append(f"IMU, {5_000_000 + round(t * 1e6)}, 0, {', '.join(cells)}, {board.temperature[i]:.2f}")
    path.write_text("\n".join(lines) + "\n")


def excel_pandas(board: Board, path: Path) -> None:
    """Write a workbook by pandas, its index in the first column, cells of dates as time."""
    import pandas as pd

    data = columns(board, "Gyro {} (rad/s)", "Acc {} (m/s²)", "XYZ")
    times = pd.to_datetime(stamps(board), unit="ns")
    pd.DataFrame({"Timestamp": times} | data).to_excel(path, sheet_name="Messung")


def excel_german(board: Board, path: Path) -> None:
    """Write a workbook with a title and a row of units, as a technician keeps it."""
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet("Daten")
    sheet.append(["Sensorplatine, Prüfling 7"])
    sheet.append(["Zeit", *(f"Drehrate {a}" for a in "XYZ"), *(f"Beschleunigung {a}" for a in "XYZ"), "Temperatur"])
    sheet.append(["s", *["°/s"] * 3, *["m/s²"] * 3, "°C"])
    for i, t in enumerate(board.time):
        sheet.append([float(t), *map(float, DEG * board.gyro[i]), *map(float, board.acc[i]),
                      float(board.temperature[i])])  # fmt: skip
    book.save(path)


def tdms_waveforms(board: Board, path: Path) -> None:
    """Write waveforms of a measurement card, each axis in a segment of its own, with its unit."""
    from nptdms import ChannelObject, RootObject, TdmsWriter

    about = {"wf_increment": 1.0 / board.sample_rate, "wf_start_time": np.datetime64(START, "s"),
             "wf_start_offset": 0.0, "wf_samples": 1}  # fmt: skip
    with TdmsWriter(str(path), version=4713) as writer:
        for name, values in columns(board, "Gyro {}", "Accel {}", "XYZ").items():
            unit = "rad/s" if name.startswith("Gyro") else "m/s^2"
            channel = ChannelObject("Log", name, values.astype(np.float32), about | {"unit_string": unit})
            writer.write_segment([RootObject({"Operator": "K."}), channel])


def tdms_time_channel(board: Board, path: Path) -> None:
    """Write a channel of times beside the others, units in the names, as a program in Python does."""
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(path)) as writer:
        for first in range(0, len(board.time), 1000):
            rows = slice(first, first + 1000)
            table = {"time [s]": board.time} | columns(board, "gyro_{} [rad/s]", "acc_{} [m/s^2]")
            writer.write_segment([ChannelObject("board", name, one[rows]) for name, one in table.items()])


def uff(binary: int, spacing: int) -> Writer:
    """Return a writer of universal files by pyuff: an accelerometer of three axes, in single precision or text."""

    def write(board: Board, path: Path) -> None:
        import pyuff

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)  # its writer leaves files open
            file = pyuff.UFF(str(path))
            for i in range(3):
                file.write_sets(pyuff.prepare_58(
                    binary=binary, func_type=1, rsp_node=1, rsp_dir=i + 1, ref_dir=0, ref_node=0, data=board.acc[:, i],
                    x=board.time, id1="board", abscissa_spacing=spacing, abscissa_inc=1.0 / board.sample_rate,
                    abscissa_min=0.0, abscissa_spec_data_type=17, ordinate_spec_data_type=12,
                    ordinate_axis_units_lab="m/s2", orddenom_spec_data_type=0, num_pts=len(board.time),
                    z_axis_value=0.0,
                ), "add")  # fmt: skip
            gc.collect()

    return write


def feather(board: Board, path: Path) -> None:
    """Write what pandas keeps of a table, uncompressed, instants in its own zone."""
    import pandas as pd

    data = {"timestamp": pd.to_datetime(stamps(board), unit="ns", utc=True).tz_convert("Europe/Vienna")}
    data |= columns(board, "gyro_{}_radps", "acc_{}_mps2")
    pd.DataFrame(data).rename(columns=lambda name: name.replace("_radps", "_rad_s")).to_feather(
        path, compression="uncompressed"
    )


def feather_floats(board: Board, path: Path) -> None:
    """Write floats of 32 bits by pyarrow, packed by LZ4, units in the names."""
    import pyarrow as pa
    from pyarrow import feather as arrow_feather

    data = {"t [s]": board.time} | {
        name: one.astype(np.float32) for name, one in columns(board, "w{} [rad/s]", "a{} [m/s^2]").items()
    }
    arrow_feather.write_feather(pa.table(data), path, compression="lz4")


def mdf_4(board: Board, path: Path) -> None:
    """Write an MDF 4.20 of a car: integers with a linear conversion, as the bus has them."""
    from asammdf import MDF, Signal

    signals = []
    for name, values in columns(board, "IMU_Gyro{}", "IMU_Acc{}", "XYZ").items():
        gyro = "Gyro" in name
        step = 1e-5 if gyro else 1e-3
        raw = np.rint(values / step).astype(np.int32)
        about: dict[str, object] = {"a": step, "b": 0.0}
        signals.append(Signal(raw, board.time, name=name, unit="rad/s" if gyro else "m/s²", conversion=about))
    with MDF(version="4.20") as file:
        file.header.start_time = datetime.fromtimestamp(START, UTC)
        file.append(signals, common_timebase=True, comment="board")
        file.save(path, overwrite=True, compression=1)


def mdf_3(board: Board, path: Path) -> None:
    """Write an MDF 3.30, floats."""
    from asammdf import MDF, Signal

    signals = [Signal(values, board.time, name=name, unit="deg/s" if "gyro" in name else "m/s^2")
               for name, values in columns(board, "gyro_{}", "acc_{}").items()]  # fmt: skip
    for one in signals[:3]:
        one.samples = DEG * one.samples
    with MDF(version="3.30") as file:
        file.append(signals, common_timebase=True)
        file.save(path, overwrite=True)


def lvm(board: Board, path: Path) -> None:
    """Write a LabVIEW measurement without a column of time, comma separated, decimal point."""
    n = len(board.time)
    names = list(columns(board, "Gyro {}", "Accel {}", "XYZ"))
    head = ["LabVIEW Measurement,", "Writer_Version,0.92", "Reader_Version,1", "Separator,Comma", "Multi_Headings,No",
            "X_Columns,No", "Time_Pref,Relative", "Operator,lab", "Date,2024/03/12", "Time,09:15:00.5",
            "***End_of_Header***,", "", f"Channels,{len(names)},,,,,", f"Samples,{','.join([str(n)] * 6)},",
            f"Date,{','.join(['2024/03/12'] * 6)},", f"Time,{','.join(['09:15:00.5'] * 6)},",
            "Y_Unit_Label,rad/s,rad/s,rad/s,m/s^2,m/s^2,m/s^2,", f"X_Dimension,{','.join(['Time'] * 6)},",
            f"X0,{','.join(['0.0E+0'] * 6)},", f"Delta_X,{','.join([repr(1.0 / board.sample_rate)] * 6)},",
            "***End_of_Header***,,,,,,", f"X_Value,{','.join(names)},Comment"]  # fmt: skip
    rows = np.column_stack([board.gyro, board.acc])
    lines = [f",{','.join(f'{one:.6f}' for one in row)}" for row in rows]
    path.write_text("\r\n".join([*head, *lines]) + "\r\n")


def sqlite_pandas(board: Board, path: Path) -> None:
    """Write a table by pandas, with its index, instants as text."""
    import pandas as pd

    times = pd.to_datetime(stamps(board), unit="ns").strftime("%Y-%m-%d %H:%M:%S.%f")
    data = pd.DataFrame({"timestamp": times} | columns(board, "gyro_{} [rad/s]", "acc_{} [m/s^2]"))
    connection = sqlite3.connect(path)
    data.to_sql("imu", connection)
    connection.close()


def sqlite_phone(board: Board, path: Path) -> None:
    """Write what an app keeps: milliseconds since 1970, a key that runs, settings in a table of their own."""
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE settings (name TEXT, value TEXT)")
        connection.execute("INSERT INTO settings VALUES ('rate', 'fastest')")
        names = ", ".join(f"{name} REAL" for name in columns(board, "gyro_{}_rad_s", "accel_{}_m_s2"))
        connection.execute(f"CREATE TABLE samples (id INTEGER PRIMARY KEY, timestamp_ms INTEGER, {names}) STRICT")
        times = stamps(board) // 1_000_000
        rows = [(int(t), *map(float, gyro), *map(float, acc))
                for t, gyro, acc in zip(times, board.gyro, board.acc, strict=True)]  # fmt: skip
        marks = ", ".join("?" * 7)
        connection.executemany(f"INSERT INTO samples VALUES (NULL, {marks})", rows)
    connection.close()


def wav_floats(board: Board, path: Path) -> None:
    """Write floats by scipy, three channels of g, as a vibration recorder does."""
    from scipy.io import wavfile

    wavfile.write(path, round(board.sample_rate), (board.acc / G).astype(np.float32))


def miniseed(board: Board, path: Path) -> None:
    """Write an accelerometer of 10^-6 m/s^2 a count in miniSEED 2, Steim 1, records of 4096 bytes, big endian."""
    from pymseed import DataEncoding, MS3TraceList

    counts = np.rint(board.acc * 1e6).astype(np.int32)
    with MS3TraceList() as traces, path.open("wb") as stream:
        for i, component in enumerate("ENZ"):
            traces.add_data(sourceid=f"FDSN:GR_BOARD__H_N_{component}", data_samples=counts[:, i], sample_type="i",
                            sample_rate=board.sample_rate, starttime=START * 10**9)  # fmt: skip
        for record in traces.generate(max_record_length=4096, encoding=DataEncoding.STEIM1, format_version=2):
            stream.write(record)


def matlab(board: Board, path: Path) -> None:
    """Write matrices by scipy, packed, a column an axis."""
    from scipy.io import savemat

    savemat(path, {"t": board.time, "gyro_rad_s": board.gyro, "acc_m_s2": board.acc}, do_compression=True)


def hdf5(board: Board, path: Path) -> None:
    """Write data sets by h5py, packed, units as attributes."""
    import h5py

    with h5py.File(path, "w") as file:
        group = file.create_group("imu")
        group.create_dataset("time", data=board.time).attrs["units"] = "s"
        for name, values in columns(board, "gyro_{}", "acc_{}").items():
            made = group.create_dataset(name, data=values, compression="gzip", chunks=(500,))
            made.attrs["units"] = "rad/s" if "gyro" in name else "m/s^2"


def parquet(board: Board, path: Path) -> None:
    """Write what pandas keeps of a table whose index is the time, packed by brotli."""
    import pandas as pd

    index = pd.DatetimeIndex(pd.to_datetime(stamps(board), unit="ns"), name="time")
    data = columns(board, "gyro_{} [rad/s]", "acc_{} [m/s^2]")
    pd.DataFrame(data, index=index).to_parquet(path, compression="brotli", row_group_size=1000)


@dataclass(frozen=True)
class Kept:
    """A file: its name, its kind, who writes it, and which sensors are in it."""

    name: str
    kind: str
    write: Writer
    noun: str = "allan"
    sensors: tuple[str, ...] = ("gyro", "accelerometer")
    recordings: int = 1  # of one sensor each where there are several, in the order of `sensors`


ACC, GYRO = ("accelerometer",), ("gyro",)
KEPT = (
    Kept("bench.bag", "ROS 1 bag", ros_1("/camera/imu", "BZ2")),
    Kept("faces.bag", "ROS 1 bag", ros_1("/mavros/imu/data_raw"), "positions"),
    Kept("bench.db3", "ROS 2 db3", ros_2("/livox/imu", "SQLITE3")),
    Kept("faces_folder", "ROS 2 folder", ros_2("/imu", "SQLITE3"), "positions"),
    Kept("bench_folder", "ROS 2 folder", ros_2("/imu/raw", "MCAP", store_name="ROS2_FOXY")),
    Kept("faces.mcap", "MCAP", ros_2("/os_cloud_node/imu", "MCAP", "STORAGE"), "positions"),
    Kept("bench.mcap", "MCAP", mcap_ros_1),
    Kept("own.mcap", "MCAP", mcap_protobuf, "positions"),
    Kept("json.mcap", "MCAP", mcap_json),
    Kept("bench.ulg", "ULog", ulog_combined),
    Kept("faces.ulg", "ULog", ulog_combined, "positions"),
    Kept("sensors.ulg", "ULog", ulog_sensors, sensors=ACC + GYRO, recordings=2),
    Kept("faces.bin", "DataFlash .bin", dataflash_old, "positions"),
    Kept("raw.bin", "DataFlash .bin", dataflash_raw, sensors=GYRO + ACC, recordings=2),
    Kept("bench.log", "DataFlash .log", dataflash_text),
    Kept("bench.xlsx", "Excel", excel_pandas),
    Kept("faces.xlsx", "Excel", excel_german, "positions"),
    Kept("bench.tdms", "TDMS", tdms_waveforms),
    Kept("faces.tdms", "TDMS", tdms_time_channel, "positions"),
    Kept("faces.uff", "UFF 58", uff(1, 1), "positions", ACC),
    Kept("bench.unv", "UFF 58", uff(0, 0), sensors=ACC),
    Kept("bench.wav", "WAV", wav_floats, sensors=ACC),
    Kept("bench.feather", "Feather", feather),
    Kept("faces.feather", "Feather", feather_floats, "positions"),
    Kept("faces.mf4", "MDF 4", mdf_4, "positions"),
    Kept("bench.mdf", "MDF 3", mdf_3),
    Kept("bench.lvm", "LVM", lvm),
    Kept("bench.mseed", "miniSEED", miniseed, sensors=ACC),
    Kept("bench.sqlite", "SQLite", sqlite_pandas),
    Kept("faces.db", "SQLite", sqlite_phone, "positions"),
    Kept("bench.mat", "MATLAB", matlab),
    Kept("faces.h5", "HDF5", hdf5, "positions"),
    Kept("bench.parquet", "Parquet", parquet),
)
