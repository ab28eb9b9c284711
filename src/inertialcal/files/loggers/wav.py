"""WAV files of data loggers: RIFF, RIFX (big endian), RF64 and its like, whole numbers of 8 to 32 bits and floats.

Numbers are handed over as they are stored, whole numbers of 24 bits as 32: a WAV file says no unit.

References
----------
.. [1] IBM and Microsoft, Multimedia Programming Interface and Data Specifications 1.0 (1991); Microsoft,
   WAVEFORMATEXTENSIBLE; EBU Tech 3306 (RF64).
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.remarks import Remark
from ..binary.arrays import MOST_CHANNELS, number_column
from ..budget import check_count, claim, claim_room
from ..columns import Column, Content, LongColumns
from ..reader import Reader
from ..source import FileBytes, Loaded, as_data_errors
from .topics import torn

MAGICS = {b"RIFF": "<", b"RF64": "<", b"BW64": "<", b"RIFX": ">"}
PCM, FLOAT, EXTENSIBLE = 1, 3, 0xFFFE
KINDS = {(PCM, 1): "u1", (PCM, 2): "i2", (PCM, 4): "i4", (FLOAT, 4): "f4", (FLOAT, 8): "f8"}
BATCH = 2**23  # bytes
UNKNOWN = 0xFFFFFFFF  # size of a chunk whose writer did not come back to it


def read_wav(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return a column a channel, whatever variables are named.

    Raises
    ------
    DataError
        ``damaged_file``; ``unsupported_format`` for packed sound; ``too_large``, ``too_many``.
    """
    path, data = loaded.path, loaded.data
    with as_data_errors(path, "a WAV file"):
        order = MAGICS[data[:4]]
        layout, first, size, remarks = _chunks(data, order, path)
        tag, channels, rate, _, frame, bits = struct.unpack_from(f"{order}HHIIHH", layout)
        if tag == EXTENSIBLE and len(layout) >= 26:
            (tag,) = struct.unpack_from(f"{order}H", layout, 24)
        width = frame // channels if channels else 0
        if (tag, width) not in KINDS and (tag, width) != (PCM, 3):
            do = "Save it as PCM"
            raise DataError(f"sound of type {tag} with {bits} bits", where=path, do=do, code="unsupported_format")
        check_count(channels, MOST_CHANNELS, "channels", path)
        rows, rest = divmod(size, frame)
        if rest:
            remarks += torn(path, rest, first + rows * frame, "it ends in the middle of a sample")
        in_place = isinstance(data, FileBytes)
        kind = np.dtype(order + KINDS.get((tag, width), "i4"))
        need = rows * channels * kind.itemsize
        if in_place:
            claim_room(path, loaded.on_disk, 2 * need, f"{rows * channels:,} values")
        else:
            claim(path, loaded.on_disk, len(data) + 3 * need, f"{rows * channels:,} values")
        long = LongColumns(rows)
        step = max(BATCH // frame, 1)
        for at in range(0, rows, step):
            count = min(step, rows - at)
            begin = first + at * frame
            table = _numbers(data[begin : begin + count * frame], kind, width, order).reshape(count, channels)
            long.add([Column(f"channel_{i + 1}", np.ascontiguousarray(table[:, i])) for i in range(channels)])
        columns = [number_column(one.name, one.values, None) for one in long.columns()]
        what = f"WAV, {8 * width} bits{', float' if tag == FLOAT else ''}"
        return Content(tuple(columns), what, None, float(rate) or None, remarks)


def _chunks(data: bytes, order: str, path: str) -> tuple[bytes, int, int, tuple[Remark, ...]]:
    """Return the chunk with the format, first byte and size of the samples, and remarks."""
    layout, at, long = b"", 12, 0
    while at + 8 <= len(data):
        name, (size,) = data[at : at + 4], struct.unpack(f"{order}I", data[at + 4 : at + 8])
        begin = at + 8
        if name == b"ds64":
            (long,) = struct.unpack_from("<Q", data[begin : begin + 16], 8)
        elif name == b"fmt ":
            layout = data[begin : begin + min(size, 64)]
        elif name == b"data" and len(layout) >= 16:
            size = long if size == UNKNOWN and long else size
            there = len(data) - begin
            if size == UNKNOWN or (size == 0 and there > 0):
                return layout, begin, there, torn(path, 0, len(data), "its header was never completed")
            if size > there:
                what = f"the header says {size:,} bytes of samples, {there:,} are there"
                remark = Remark("torn_file", "warning", what, where=path, count=size - there)
                return layout, begin, there, (remark,)
            return layout, begin, size, ()
        at = begin + size + size % 2
    raise ValueError("no samples in it")


def _numbers(data: bytes, kind: np.dtype[np.generic], width: int, order: str) -> NDArray[np.generic]:
    if width != 3:
        return np.frombuffer(data, kind).astype(kind.newbyteorder("="), copy=False)
    raw = np.frombuffer(data, np.uint8).reshape(-1, 3)
    wide = np.zeros((len(raw), 4), np.uint8)
    wide[:, 1:] = raw if order == "<" else raw[:, ::-1]  # as the upper bytes, so that the sign is in its place
    numbers: NDArray[np.generic] = wide.view("<i4")[:, 0].astype(np.int32) >> 8
    return numbers


READER = Reader(
    "wav", "WAV", (".wav",),
    lambda data, path: data[:4] in MAGICS and data[8:12] == b"WAVE", read_wav, True,
)  # fmt: skip
