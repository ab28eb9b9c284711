"""Messages of ROS 1 and ROS 2 that hold readings: many at a time, as arrays.

Both serialisations lay a stamped message out as a header (stamp and name of the frame) and doubles [1]_, [2]_. All
messages of one length and one length of the frame's name have their doubles in the same places.

References
----------
.. [1] ROS 1: wiki.ros.org/msg; little endian, packed, a string is its length and its bytes.
.. [2] OMG DDS-XTypes 1.3, 7.4: four bytes that say the byte order, then values aligned to their own size; a string
   ends with a nul, which its length counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from .topics import INERTIAL, OTHER, frame_remark, left_out

XYZ = ("x", "y", "z")
QUATERNION = tuple(f"orientation.{axis}" for axis in "xyzw")
ENCODINGS = ("ros1", "cdr")
FRAMES = 8  # different frames that are told apart


@dataclass(frozen=True)
class Part:
    """Doubles of a message that belong together, with what is stated of their covariance."""

    names: tuple[str, ...]
    unit: str | None
    covariance: int = 0  # Doubles behind them: 9 of a matrix, 1 of a variance


def _vector(name: str, unit: str | None, covariance: int = 0) -> Part:
    return Part(tuple(f"{name}.{axis}" for axis in XYZ), unit, covariance)


MESSAGES: dict[str, tuple[int, tuple[Part, ...]]] = {  # by type: rank as a topic, parts in order
    "Imu": (
        INERTIAL,
        (
            Part(QUATERNION, None, 9),
            _vector("angular_velocity", "rad/s", 9),
            _vector("linear_acceleration", "m/s^2", 9),
        ),
    ),
    "MagneticField": (OTHER, (_vector("magnetic_field", "T", 9),)),
    "Temperature": (OTHER, (Part(("temperature",), "degC", 1),)),
    "FluidPressure": (OTHER, (Part(("fluid_pressure",), "Pa", 1),)),
}


def message_type(name: str) -> str:
    """Return the type of a message as ``MESSAGES`` has it, of ``sensor_msgs/msg/Imu``; or ``""``."""
    found = name.removeprefix("sensor_msgs/").removeprefix("msg/") if name.startswith("sensor_msgs/") else ""
    return found if found in MESSAGES else ""


@dataclass(frozen=True, eq=False)
class Decoded:
    """Messages of one topic, those that are whole."""

    time_ns: Times  # shape (n,): stamps of the headers [ns]
    values: Array  # shape (n, doubles)
    frames: tuple[str, ...]  # That the headers name, each once
    whole: NDArray[np.bool_]  # shape (messages,): which are of this type


def decode(messages: Sequence[bytes], kind: str, encoding: str) -> Decoded:
    """Return what messages of one type hold.

    Parameters
    ----------
    messages : sequence of bytes
        As recorded.
    kind : str
        Type, of ``MESSAGES``.
    encoding : {"ros1", "cdr"}
        How they were serialised.
    """
    doubles = sum(len(part.names) + part.covariance for part in MESSAGES[kind][1])
    time_ns, values = np.zeros(len(messages), np.int64), np.full((len(messages), doubles), np.nan)
    whole = np.zeros(len(messages), dtype=bool)
    lengths = np.fromiter(map(len, messages), np.int64, len(messages))
    frames: dict[str, None] = {}
    for length in np.unique(lengths).tolist():
        at = np.flatnonzero(lengths == length)
        table = np.frombuffer(b"".join(messages[i] for i in at.tolist()), np.uint8).reshape(len(at), length)
        head = 4  # bytes of the encapsulation; in ROS 1 the count of messages
        if length < head + 12:
            continue
        marks = table[:, :2].astype(np.int64) @ (256, 1) if encoding == "cdr" else np.ones(len(at), np.int64)
        for mark in np.unique(marks).tolist():
            order = {0: ">", 1: "<"}.get(mark)
            if order is None:
                continue
            chosen = np.flatnonzero(marks == mark)
            texts = _numbers(table[chosen], head + 8, f"{order}u4", 1)[:, 0].astype(np.int64)
            for size in np.unique(texts).tolist():
                start = head + 12 + size
                start += (-(start - head)) % 8 if encoding == "cdr" else 0
                if start + 8 * doubles > length:
                    continue
                rows = chosen[texts == size]
                here = table[rows]
                stamp = _numbers(here, head, f"{order}i4" if encoding == "cdr" else "<u4", 1)[:, 0].astype(np.int64)
                rest = _numbers(here, head + 4, f"{order}u4", 1)[:, 0].astype(np.int64)
                time_ns[at[rows]] = stamp * SECOND + rest
                values[at[rows]] = _numbers(here, start, f"{order}f8", doubles)
                whole[at[rows]] = True
                names = here[:, head + 12 : head + 12 + size]
                for _ in range(FRAMES):
                    if not len(names):
                        break
                    frames[names[0].tobytes().rstrip(b"\0").decode("utf-8", "replace")] = None
                    names = names[(names != names[0]).any(axis=1)]
    return Decoded(time_ns[whole], values[whole], tuple(name for name in frames if name), whole)


def _numbers(table: NDArray[np.uint8], first: int, kind: str, count: int) -> NDArray[np.generic]:
    """Return numbers that stand in each row from one byte on, shape (n, count)."""
    size = np.dtype(kind).itemsize * count
    return np.ascontiguousarray(table[:, first : first + size]).view(kind)


def part_columns(kind: str) -> list[tuple[Part, slice, slice]]:
    """Return the parts of a type, with the places of their doubles and of their covariance."""
    found, at = [], 0
    for part in MESSAGES[kind][1]:
        end = at + len(part.names)
        found.append((part, slice(at, end), slice(end, end + part.covariance)))
        at = end + part.covariance
    return found


def stated(kind: str, first: Array, low: Array, high: Array, frames: Sequence[str], path: str) -> tuple[
    list[tuple[str, str | None, int]], tuple[Remark, ...]
]:  # fmt: skip
    """Return name, unit and place of each double that was measured, and remarks on covariance and frame.

    Parameters
    ----------
    kind : str
        Type of the messages.
    first, low, high : ndarray, shape (doubles,)
        Of all messages: the first, the least and the largest of each double.
    frames : sequence of str
        That the headers name.
    path : str
        File, for messages.
    """
    columns: list[tuple[str, str | None, int]] = []
    remarks: list[Remark] = []
    absent: list[str] = []
    zero: list[str] = []
    for part, values, covariance in part_columns(kind):
        said, name = first[covariance], part.names[0].partition(".")[0]
        if len(said) > 1 and said[0] == -1.0 and high[covariance][0] == -1.0:
            absent += part.names  # REP 145: the driver has no such reading
            continue
        if part.names == QUATERNION and not (np.any(low[values]) or np.any(high[values])):
            zero += part.names  # an orientation has norm 1
            continue
        columns += [(one, part.unit, values.start + i) for i, one in enumerate(part.names)]
        if not np.any(said) or not np.all(np.isfinite(said)):
            continue  # zeros: not known
        sizes = ", ".join(f"{size:.4g}" for size in np.sqrt(np.abs(said[:: len(XYZ) + 1])))
        steady = np.array_equal(low[covariance], high[covariance])
        what = f"standard deviation of {name} by the driver: {sizes} {part.unit or 'rad'}"
        what += "" if steady else " at first, later another"
        do = "It is the driver's word, and used nowhere: inertialcal allan finds the noise"
        remarks.append(Remark("stated_covariance", "info", what, where=path, do=do, subject=name))
    remarks += left_out(absent, path, "covariance -1, so the driver has no such reading")
    remarks += left_out(zero, path, "0 in all messages, so the driver has no such reading")
    many = len(frames) > 1
    remarks += frame_remark(f"those of frame {', '.join(map(repr, frames[:FRAMES]))}" if frames else "", path)
    if many:
        what = f"messages of {len(frames)} frames in one topic"
        remarks.append(Remark("several_frames", "warning", what, where=path, do="Is it one sensor?"))
    return columns, tuple(remarks)
