"""Flight logs of PX4 (ULog), by pyulog.

A log holds a topic for each message and each instance of a sensor. Units are those that PX4 documents in its message
definitions [1]_; a log itself names none. Stamps count microseconds since the autopilot started. The FIFO topics hold
many samples a message, as counts with their scale: they are laid out one after the other.

References
----------
.. [1] PX4-Autopilot, msg/SensorAccel.msg, SensorGyro.msg, SensorCombined.msg, VehicleImu.msg, SensorAccelFifo.msg, ...
.. [2] docs.px4.io, ULog File Format: a message is its size (2 bytes), its type and its content.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..columns import Column, Content
from ..reader import Reader
from ..source import Loaded
from .topics import (
    INERTIAL,
    OTHER,
    Topic,
    choose,
    frame_remark,
    joined,
    left_out,
    library,
    on_disk,
    other_topics,
    torn,
)

MAGIC = b"ULog\x01\x12\x35"
HEADER, AT_ONCE = 16, 2**20
XYZ = ("x", "y", "z")
RATE, ACCELERATION, FIELD = "rad/s", "m/s^2", "gauss"
# Units of the fields of a message; those of a vector by its name alone.
VECTORS: dict[str, dict[str, str]] = {
    "sensor_accel": dict.fromkeys(XYZ, ACCELERATION),
    "sensor_gyro": dict.fromkeys(XYZ, RATE),
    "sensor_accel_fifo": dict.fromkeys(XYZ, ACCELERATION),
    "sensor_gyro_fifo": dict.fromkeys(XYZ, RATE),
    "sensor_combined": {"gyro_rad": RATE, "accelerometer_m_s2": ACCELERATION},
    "vehicle_imu": {"gyro": RATE, "acc": ACCELERATION},
    "vehicle_imu_status": {"mean_gyro": RATE, "mean_accel": ACCELERATION},
    "vehicle_acceleration": {"xyz": ACCELERATION},
    "vehicle_angular_velocity": {"xyz": RATE},
    "sensor_mag": dict.fromkeys(XYZ, FIELD),
    "vehicle_magnetometer": {"magnetometer_ga": FIELD},
    "sensor_baro": {"pressure": "Pa"},
}
NOT_INERTIAL = ("sensor_mag", "vehicle_magnetometer", "sensor_baro", "vehicle_imu_status")
# Increments of a message, and how long it gathered them [us]: in one field in older logs.
INCREMENTS = {"gyro": ("delta_angle", ("delta_angle_dt", "dt")), "acc": ("delta_velocity", ("delta_velocity_dt", "dt"))}
CLOCKS = ("timestamp_sample", "timestamp")  # that of the measurement before that of the message
FRAME = "body of the autopilot, x forward, y right, z down"


def read_ulog(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of a topic.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``missing_extra``, ``damaged_file``.
    """
    pyulog = library("pyulog", "a PX4 log", loaded.path)
    with on_disk(loaded, ".ulg") as path:
        log = pyulog.ULog(path)
    several = {one.name for one in log.data_list if one.multi_id}
    by_name = {f"{one.name}[{one.multi_id}]" if one.name in several else one.name: one for one in log.data_list}
    topics = [_topic(name, one) for name, one in by_name.items()]
    chosen = choose(topics, variables, loaded.path)
    content = joined([(one, _columns(by_name[one.name], loaded.path)) for one in chosen], loaded.path)
    remarks = (*content.remarks, *_damage(log, loaded), *other_topics(topics, chosen, loaded.path))
    return Content(content.columns, "PX4 ULog", remarks=remarks)


def _topic(name: str, one: Any) -> Topic:
    rank = INERTIAL if one.name in VECTORS and one.name not in NOT_INERTIAL else OTHER
    fields = [field for field in one.data if field not in CLOCKS]
    return Topic(name, " ".join(fields[:6]) + (" ..." if len(fields) > 6 else ""), len(one.data["timestamp"]), rank)


def _columns(one: Any, path: str) -> Content:
    """Return the columns of a topic, its clock first."""
    units, data = VECTORS.get(one.name, {}), dict(one.data)
    remarks: tuple[Remark, ...] = ()
    if one.name.endswith("_fifo") and "samples" in data:
        data, remarks = _laid_out(data, path)
    elif one.name == "vehicle_imu":
        data, remarks = _mean_rates(data, path)
    elif one.name == "vehicle_imu_status":
        aside = [field for field in data if not field.startswith(("timestamp", "mean_", "temperature"))]
        data = {field: values for field, values in data.items() if field not in aside}
        remarks = left_out(
            list(dict.fromkeys(field.partition("[")[0] for field in aside)), path, "about the sensor, no readings"
        )
    sizes = Counter(field.partition("[")[0] for field in data)
    runs = [name for name in CLOCKS if name in data
            and (np.any(data[name] != data[name][0]) or (len(data[name]) == 1 and data[name][0]))]  # fmt: skip
    columns: list[Column] = [number_column(name, data[name], "us") for name in runs or ["timestamp"]]
    for field, values in data.items():
        base, _, number = field.partition("[")
        if field in CLOCKS:
            continue
        index = number.rstrip("]")
        name = base if not number else f"{base}.{XYZ[int(index)]}" if sizes[base] == len(XYZ) else f"{base}_{index}"
        unit = "degC" if base.startswith("temperature") else units.get(base)
        columns.append(number_column(name, np.asarray(values), unit))
    frame = FRAME if one.name.startswith("vehicle_") or one.name == "sensor_combined" else ""
    return Content(tuple(columns), "PX4 ULog", remarks=(*remarks, *frame_remark(frame, path)))


def _mean_rates(data: dict[str, NDArray[Any]], path: str) -> tuple[dict[str, NDArray[Any]], tuple[Remark, ...]]:
    """Return mean rates and accelerations of the messages, their increments divided by how long they were gathered."""
    found = {name: data[name] for name in CLOCKS if name in data}
    used, remarks = [*found], tuple[Remark, ...]()
    for sensor, (field, durations) in INCREMENTS.items():
        spans = [name for name in durations if name in data]
        own = [f"{field}[{i}]" for i in range(len(XYZ)) if f"{field}[{i}]" in data]
        if not spans or not own:
            continue
        seconds = data[spans[0]].astype(float) * 1e-6
        whole = seconds > 0
        for name in own:
            values = np.full(len(seconds), np.nan)
            found[name.replace(field, sensor)] = np.divide(data[name], seconds, out=values, where=whole)
        used += [*own, spans[0]]
        unit = VECTORS["vehicle_imu"][sensor]
        remarks += (Remark("derived", "info", f"{sensor} = {field} / {spans[0]}, in {unit}", where=path),)
        if not whole.all():
            what = f"messages whose {spans[0]} is 0: no {sensor}"
            remarks += (Remark("damaged_records", "warning", what, where=path, count=int(np.sum(~whole))),)
    gone = [name for name in data if name not in used]
    return found, (*remarks, *left_out(gone, path, "about the sensors, no readings"))


def _laid_out(data: dict[str, NDArray[Any]], path: str) -> tuple[dict[str, NDArray[Any]], tuple[Remark, ...]]:
    """Return the samples of the messages of a FIFO one after the other; the last of a message is the newest."""
    count = data["samples"].astype(int)
    held = sum(1 for name in data if name.startswith("x["))
    kept = (count > 0) & (count <= held)
    if not np.any(kept):
        raise DataError("no message of the FIFO holds a sample", where=path, code="no_channel")
    count, rows = count[kept], np.flatnonzero(kept)
    message = np.repeat(rows, count)
    number = np.arange(len(message)) - np.repeat(np.cumsum(count) - count, count)
    newest = np.repeat(count, count) - 1 - number
    step = data["dt"].astype(float)[message]
    clock = data["timestamp_sample"].astype(np.int64)[message]
    found: dict[str, NDArray[Any]] = {"timestamp_sample": clock - np.rint(newest * step).astype(np.int64)}
    for axis in XYZ:
        table = np.column_stack([data[f"{axis}[{i}]"] for i in range(held)])
        found[axis] = table[message, number] * data["scale"].astype(float)[message]
    gone = [name for name in data if "[" not in name and name not in (*CLOCKS, "samples", "dt", "scale")]
    remarks = left_out(gone, path, "once a message of the FIFO, not once a sample")
    if len(rows) < len(kept):
        what = "messages of the FIFO with no samples, or more than they hold: left out"
        remarks += (Remark("damaged_records", "warning", what, where=path, count=len(kept) - len(rows)),)
    return found, remarks


def _damage(log: Any, loaded: Loaded) -> tuple[Remark, ...]:
    """Return remarks on what the logger lost, and on what is not whole."""
    remarks: tuple[Remark, ...] = ()
    if log.dropouts:
        lost = sum(one.duration for one in log.dropouts)
        what = f"dropouts of the logger, {lost / 1000:.3g} s in all"
        remarks += (Remark("dropouts", "warning", what, where=loaded.path, count=len(log.dropouts)),)
    end = _whole_until(loaded.data)
    if end < len(loaded.data):
        remarks += torn(loaded.path, len(loaded.data) - end, end)
    if log.file_corruption:
        what = "damaged messages: left out by pyulog, which does not count them"
        remarks += (Remark("damaged_records", "warning", what, where=loaded.path),)
    return remarks


def _whole_until(data: bytes) -> int:
    """Return the byte at which the last whole message ends."""
    at, begin, block = HEADER, HEADER, data[HEADER : HEADER + AT_ONCE]
    size = len(data)
    while at + 3 <= size:
        if at + 3 > begin + len(block):
            begin, block = at, data[at : at + AT_ONCE]
        following = at + 3 + (block[at - begin] | block[at - begin + 1] << 8)
        if following > size:
            break
        at = following
    return at


READER = Reader(
    "ulog", "PX4 ULog", (".ulg", ".ulog"), lambda data, path: data.startswith(MAGIC),
    apart(read_ulog, "a PX4 log"), True,
)  # fmt: skip
