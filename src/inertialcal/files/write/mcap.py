"""A recording as MCAP with messages of ROS 2: sensor_msgs/Imu, Temperature and MagneticField.

Angular rate and acceleration of the three axes make one message a sample, in rad/s and m/s^2. What a recording does not
say is marked as ROS has it: a covariance of zeros is not known, one that begins with -1 says that there is no such
reading (REP 145); an axis that is not there, and a missing sample, is NaN.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, extremes
from ...core.errors import DataError, InertialcalError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording, Times
from ...core.remarks import Remark
from ...core.units import convert, kind, same_dimension
from ..loggers.ros_messages import MESSAGES, part_columns
from ..loggers.topics import library
from ..text.headers import RAW

FRAME = "imu"
GROUP = 2**14  # messages that are made at once
LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # plain CDR
TOPICS = {"Imu": "/imu", "Temperature": "/temperature", "MagneticField": "/magnetic_field"}
VECTORS = {"gyro": ("angular_velocity", "rad/s"), "acc": ("linear_acceleration", "m/s^2"),
           "magnetometer": ("magnetic_field", "T")}  # fmt: skip
HEADER = """
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
VECTOR = """
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
SCHEMAS = {
    "Imu": f"""std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
{HEADER}{VECTOR}
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
""",
    "Temperature": f"std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n{HEADER}",
    "MagneticField": f"""std_msgs/Header header
geometry_msgs/Vector3 magnetic_field
float64[9] magnetic_field_covariance
{HEADER}{VECTOR}""",
}


def write_mcap(path: Path, recording: Recording) -> tuple[Remark, ...]:
    """Write a recording as MCAP.

    Raises
    ------
    DataError
        ``no_time``; ``time_not_writable``; ``no_channel`` where neither an angular rate nor an acceleration has axis
        and unit; ``missing_extra``.
    """
    where = recording.source.path
    writer_module = library("mcap.writer", "MCAP", where, "writing")
    time_ns, remarks = _stamps(recording)
    taken = _taken(recording)
    if not any(kind_name == "Imu" for kind_name, _ in taken):
        units = "Give the units: --unit gyro=UNIT --unit acc=UNIT"
        model = f"Counts and volts need a model: inertialcal compensate MODEL {shlex.quote(where)} -o OUT.mcap"
        is_raw = any(one.quantity in VECTORS and kind(one.unit or "1") in RAW for one in recording.channels)
        what = "no angular rate or acceleration with axis and unit, as sensor_msgs/Imu needs them"
        raise DataError(what, where=where, do=model if is_raw else units, code="no_channel")
    names = {name for _, columns in taken for name in columns.values()}
    gone = [name for name in recording.names if name not in names]
    if gone:
        what = f"no place in such messages, not written: {', '.join(gone)[:120]}"
        remarks += (Remark("channels_not_kept", "warning", what, where=where, count=len(gone), do="Write Parquet"),)
    with path.open("wb") as stream:
        writer = writer_module.Writer(stream)
        writer.start(profile="ros2", library="inertialcal")
        for number, (name, columns) in enumerate(taken):
            schema = writer.register_schema(f"sensor_msgs/msg/{name}", "ros2msg", SCHEMAS[name].encode())
            again = sum(one == name for one, _ in taken[:number])
            channel = writer.register_channel(f"{TOPICS[name]}{f'_{again + 1}' if again else ''}", "cdr", schema)
            remarks += _not_there(name, columns, where)
            used = [recording.channel(one).data for one in columns.values()]
            for first, stop in batches(time_ns, *used, size=GROUP):
                stamps = time_ns[first:stop]
                content = _messages(stamps, _doubles(recording, name, columns, first, stop))
                for stamp, message in zip(stamps.tolist(), content, strict=True):
                    writer.add_message(channel, stamp, message.tobytes(), stamp)
        writer.finish()
    return remarks


def _stamps(recording: Recording) -> tuple[Times, tuple[Remark, ...]]:
    """Return the stamps of the messages, and remarks on what they count from."""
    where, time_ns = recording.source.path, recording.stamps
    if time_ns is None:
        raise DataError("no time", where, "each message has a stamp", "Add --sample-rate", "no_time")
    low, high = extremes(time_ns)
    if low < 0 or high >= 2**31 * SECOND:
        do = "Write Parquet"
        raise DataError("stamps before 1970 or after 2038", where, "ROS has none", do, "time_not_writable")
    if recording.time_ns is not None and recording.epoch == "utc":
        return time_ns, ()
    what = "the stamps count from the beginning of the recording, not from 1970"
    return time_ns, (Remark("elapsed_stamps", "info", what, where=where),)


def _taken(recording: Recording) -> list[tuple[str, dict[str, str]]]:
    """Return the messages to write: type, and channel by name of its field."""
    imu: dict[str, str] = {}
    field: dict[str, str] = {}
    others: list[tuple[str, dict[str, str]]] = []
    for one in recording.channels:
        name, unit = VECTORS.get(one.quantity, ("", ""))
        if name and one.axis in AXES and _converts(one, unit):
            place = field if one.quantity == "magnetometer" else imu
            place.setdefault(f"{name}.{one.axis}", one.name)
        elif one.quantity == "temperature" and _converts(one, "degC"):
            others.append(("Temperature", {"temperature": one.name}))
    return [*([("Imu", imu)] if imu else []), *([("MagneticField", field)] if field else []), *others]


def _converts(channel: Channel, unit: str) -> bool:
    try:
        return channel.unit is not None and same_dimension(channel.unit, unit)
    except InertialcalError:
        return False


def _not_there(name: str, columns: Mapping[str, str], where: str) -> tuple[Remark, ...]:
    """Return a remark on axes that the recording does not have, of vectors that it has."""
    begun = {field.partition(".")[0] for field in columns}
    gone = [field for part in MESSAGES[name][1] for field in part.names
            if field.partition(".")[0] in begun and field not in columns]  # fmt: skip
    what = f"no reading of {', '.join(gone)}: written as NaN"
    return (Remark("axes_not_there", "warning", what, where=where, count=len(gone)),) if gone else ()


def _doubles(recording: Recording, name: str, columns: Mapping[str, str], first: int, stop: int) -> Array:
    """Return the doubles of messages, shape (n, doubles)."""
    parts = part_columns(name)
    values = np.zeros((stop - first, parts[-1][2].stop))
    for part, place, covariance in parts:
        begun = [one for one in part.names if one in columns]
        if not begun:
            values[:, covariance.start] = -1.0
            values[:, place.stop - 1] = float(len(part.names) == 4)  # orientation: that of no turn
            continue
        for i, one in enumerate(part.names):
            values[:, place.start + i] = np.nan
            if one in columns:
                channel = recording.channel(columns[one])
                values[:, place.start + i] = convert(channel.data[first:stop], str(channel.unit), str(part.unit))
    return values


def _messages(time_ns: Times, values: Array) -> NDArray[np.void]:
    """Return serialised messages, shape (n,)."""
    text = FRAME.encode() + b"\0"
    pad = -(12 + len(text)) % 8
    layout = np.dtype([("mark", "V4"), ("sec", "<i4"), ("nanosec", "<u4"), ("size", "<u4"),
                       ("frame", f"V{len(text) + pad}"), ("values", "<f8", values.shape[1])])  # fmt: skip
    found = np.zeros(len(time_ns), dtype=layout)
    found["mark"], found["size"] = np.void(LITTLE_ENDIAN), len(text)
    found["frame"] = np.void(text + bytes(pad))
    found["sec"], found["nanosec"], found["values"] = time_ns // SECOND, time_ns % SECOND, values
    return found
