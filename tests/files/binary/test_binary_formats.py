"""MATLAB, HDF5, NumPy and Parquet: written by their own libraries, read back as the same recording."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy import io as scipy_io

from inertialcal.core.errors import DataError
from inertialcal.files import read
from inertialcal.files.budget import max_memory
from inertialcal.files.registry import find_reader
from inertialcal.files.source import load

N = 200
T = 0.5 + np.arange(N) / 100
RNG = np.random.default_rng(11)
GYRO = RNG.normal(size=(N, 3))
COUNTS = RNG.integers(-3000, 3000, N).astype(np.int16)


def _hdf5(path: Path, **arrays: Any) -> None:
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file[name.replace("__", "/")] = values


WRITERS: list[tuple[str, Callable[[Path], object]]] = [
    ("a5.mat", lambda p: scipy_io.savemat(p, {"t": T, "gyro": GYRO, "raw": COUNTS, "note": "hello", "fs": 100.0})),
    ("az.mat", lambda p: scipy_io.savemat(p, {"t": T, "gyro": GYRO, "raw": COUNTS}, do_compression=True)),
    ("a4.mat", lambda p: scipy_io.savemat(p, {"t": T, "gyro": GYRO, "raw": COUNTS}, format="4")),
    ("a.npz", lambda p: np.savez(p, t=T, gyro=GYRO, raw=COUNTS)),
    ("az.npz", lambda p: np.savez_compressed(p, t=T, gyro=GYRO, raw=COUNTS)),
    ("a.h5", lambda p: _hdf5(p, t=T, gyro=GYRO, raw=COUNTS)),
]


@pytest.mark.parametrize(("name", "write"), WRITERS, ids=[name for name, _ in WRITERS])
def test_arrays_become_channels(tmp_path: Path, name: str, write: Callable[[Path], object]) -> None:
    path = tmp_path / name
    write(path)
    recording = read(path)
    assert set(recording.names) == {"gyro_1", "gyro_2", "gyro_3", "raw"}
    np.testing.assert_array_equal(recording.array(["gyro_1", "gyro_2", "gyro_3"]), GYRO)
    np.testing.assert_array_equal(recording.channel("raw").data, COUNTS)
    assert recording.channel("raw").data.dtype == np.int16
    assert recording.channel("gyro_2").quantity == "gyro"
    assert recording.sample_rate == pytest.approx(100.0)
    assert recording.first_row == 0


def test_a_matrix_with_time_in_front(tmp_path: Path) -> None:
    # As MATLAB's save -v7.3 lays it out: transposed, with its class as an attribute.
    path = tmp_path / "buffer.mat"
    with h5py.File(path, "w") as file:
        file["gyroBuffer"] = np.column_stack([T, GYRO]).T
        file["gyroBuffer"].attrs["MATLAB_class"] = np.bytes_("double")
        file["note"] = np.frombuffer(b"h\0i\0", dtype=np.uint16)
        file["note"].attrs["MATLAB_class"] = np.bytes_("char")
        file["#refs#/a"] = np.zeros(5)
    recording = read(path)
    assert recording.source.format == "MATLAB 7.3 (HDF5)"
    assert recording.names == ("gyroBuffer_2", "gyroBuffer_3", "gyroBuffer_4")
    np.testing.assert_array_equal(recording.array(), GYRO)
    assert {remark.code for remark in recording.remarks} == {"variables_left_out", "time_unnamed"}


def test_structures_and_groups(tmp_path: Path) -> None:
    mat, h5 = tmp_path / "s.mat", tmp_path / "s.h5"
    scipy_io.savemat(mat, {"imu": {"t": T, "acc": {"x": GYRO[:, 0]}}, "cells": np.array([[1], "a"], dtype=object)})
    _hdf5(h5, imu__t=T, imu__acc__x=GYRO[:, 0])
    for path in (mat, h5):
        recording = read(path)
        assert recording.names == ("imu.acc.x",)
        assert (recording.channels[0].quantity, recording.channels[0].axis) == ("acc", "x")
        assert recording.sample_rate == pytest.approx(100.0)


def test_doubles_of_whole_numbers_stay_doubles_and_counts_stay_counts(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    scipy_io.savemat(path, {"d": np.arange(50.0) % 7, "c": (np.arange(50) % 7).astype(np.uint16)})
    recording = read(path)
    assert [recording.channel(name).data.dtype for name in "dc"] == [np.float64, np.uint16]


def test_complex_matrices_are_left_out_not_halved(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    scipy_io.savemat(path, {"z": GYRO[:, 0] + 1j, "x": GYRO[:, 0], "s": {"z": GYRO[:, 1] * 1j}})
    recording = read(path)
    assert recording.names == ("x",)
    assert (recording.remarks[0].code, recording.remarks[0].count) == ("variables_left_out", 2)


def test_units_and_records_of_hdf5(tmp_path: Path) -> None:
    path = tmp_path / "u.h5"
    with h5py.File(path, "w") as file:
        file["w"] = GYRO[:, 0]
        file["w"].attrs["units"] = "deg/s"
        file["rec"] = np.array(list(zip(T, COUNTS, strict=True)), dtype=[("t", "f8"), ("acc_x", ">i2")])
    recording = read(path)
    assert recording.channel("w").unit == "deg/s"
    assert recording.channel("rec.acc_x").data.dtype == np.dtype("<i2")


def test_arrays_of_two_clocks(tmp_path: Path) -> None:
    path = tmp_path / "two.npz"
    np.savez(path, gyro=GYRO, mag=GYRO[:50, 0], flag=np.ones(50), word=np.array(["a", "b"]))
    recording = read(path)
    assert len(recording) == N
    found = {remark.code: remark for remark in recording.remarks}
    assert (found["other_clock"].count, found["variables_left_out"].count) == (2, 1)
    assert read(path, topics=["mag"]).names == ("mag",)
    with pytest.raises(DataError, match="variables differ in length: gyro has 200, mag has 50"):
        read(path, topics=["gyro", "mag"])
    with pytest.raises(DataError, match=r"no variable 'acc'\. The file has: gyro, mag, flag"):
        read(path, topics=["acc"])


def test_one_array(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    np.save(path, np.column_stack([T, GYRO]))
    recording = read(path)
    assert recording.names == ("column_2", "column_3", "column_4")
    assert recording.sample_rate == pytest.approx(100.0)
    np.save(path, GYRO.astype(">f4"))
    assert read(path).channels[0].data.dtype == np.dtype("<f4")
    np.save(path, np.array([(1, 2.0), (3, np.inf)], dtype=[("n", "i4"), ("acc_x", "f8")]))
    recording = read(path)
    assert recording.names == ("n", "acc_x")
    assert recording.remarks[-1].code == "nan_literal"


@pytest.mark.parametrize(
    "array", [np.array(5.0), np.array(["a", "b"]), np.zeros((2, 3, 4)), np.zeros((1500, 1200), "i1")]
)
def test_arrays_that_are_no_recording(tmp_path: Path, array: np.ndarray[Any, Any]) -> None:
    path = tmp_path / "a.npy"
    np.save(path, array)
    with pytest.raises(DataError, match="no array of two or more numbers") as caught:
        read(path)
    assert caught.value.problems[0].code == "no_channel"


def test_dates_truth_values_and_missing_values_of_arrays(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    when = np.datetime64("2010-09-01T16:22:19") + np.arange(20) * np.timedelta64(2, "s")
    x = np.where(np.arange(20) == 4, np.nan, 1.5)
    np.savez(path, when=when, x=x, ok=np.arange(20) % 2 == 0)
    recording = read(path)
    assert (recording.epoch, recording.sample_interval) == ("utc", 2.0)
    assert recording.channel("ok").data.dtype == np.uint8
    assert [(r.code, r.count) for r in recording.remarks] == [("missing_cells", 1)]


def test_python_objects_are_never_loaded(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    np.save(path, np.array([{"a": 1}, None], dtype=object), allow_pickle=True)
    with pytest.raises(DataError, match="cannot be read as a NumPy npy file: Object arrays cannot be loaded"):
        read(path)


def _parquet(path: Path, table: pa.Table) -> Path:
    parquet.write_table(table, path)
    return path


def test_parquet(tmp_path: Path) -> None:
    fields = [
        pa.field("time", pa.timestamp("ms", tz="UTC")),
        pa.field("gyro_x", pa.float32(), metadata={"unit": "deg/s"}),
        pa.field("acc_x [g]", pa.int32()),
        pa.field("ok", pa.bool_()),
        pa.field("part", pa.dictionary(pa.int8(), pa.string())),
        pa.field("many", pa.list_(pa.int8())),
        pa.field("s", pa.struct([pa.field("mag_x", pa.float64())])),
    ]
    stamps = [1_283_358_139_000 + 10 * i for i in range(5)]
    columns = [
        stamps, [1.0, None, 3.0, float("nan"), 5.0], [1, 2, None, 4, 5], [True] * 5, list("aabbc"), [[1]] * 5,
        [{"mag_x": float(i)} for i in range(5)],
    ]  # fmt: skip
    data = [pa.array(values, type=field.type) for values, field in zip(columns, fields, strict=True)]
    schema = pa.schema(fields, metadata={"sample_rate": "100"})
    recording = read(_parquet(tmp_path / "a.parquet", pa.table(data, schema=schema)))
    assert recording.names == ("gyro_x", "acc_x [g]", "ok", "s.mag_x")
    assert [c.unit for c in recording.channels[:2]] == ["deg/s", "g"]
    assert recording.channels[0].data.dtype == np.float32
    np.testing.assert_array_equal(recording.channel("acc_x [g]").data, [1, 2, np.nan, 4, 5])
    assert (recording.epoch, recording.interval_from, recording.sample_interval) == ("utc", "header", 0.01)
    counted = {(r.code, r.count) for r in recording.remarks}
    assert counted == {("missing_cells", 1), ("nan_literal", 1), ("text_column", 1), ("variables_left_out", 1)}


def test_whole_numbers_of_parquet_stay_whole_and_text_is_judged(tmp_path: Path) -> None:
    table = pa.table({"big": [2**60 + 1, 5, 9], "text": ["1.5", "", "2"], "t": pa.array([1, 2, 3], pa.duration("ms"))})
    recording = read(_parquet(tmp_path / "a.parquet", table))
    assert recording.channel("big").data.tolist() == [2**60 + 1, 5, 9]
    np.testing.assert_array_equal(recording.channel("text").data, [1.5, np.nan, 2.0])
    assert recording.sample_rate == 1000.0
    bad = pa.table({"x": ["1", "2", "three"]})
    with pytest.raises(DataError, match=r"a\.parquet:3: text 'three' in number column 'x'"):
        read(_parquet(tmp_path / "a.parquet", bad))


def test_a_name_twice_in_parquet(tmp_path: Path) -> None:
    table = pa.Table.from_arrays([pa.array([1]), pa.array([2])], names=["x", "x"])
    with pytest.raises(DataError, match="column name 'x' appears twice"):
        read(_parquet(tmp_path / "a.parquet", table))


def test_a_footer_that_contradicts_itself_is_refused(tmp_path: Path) -> None:
    """Pyarrow 26 ends the process where the histogram of a column's levels is not as long as there are levels."""
    path = tmp_path / "a.parquet"
    parquet.write_table(pa.table({"t": [0.0, None, 0.02], "x": [1.0, 2.0, 3.0]}), path)
    whole = path.read_bytes()
    levels = bytes([0x19, 0x26, 2, 4])  # field 3 of SizeStatistics: a list of two numbers, 1 null and 2 values
    assert whole.count(levels) == 1
    changed, size = whole.replace(levels, bytes([0x19, 0x16, 2])), int.from_bytes(whole[-8:-4], "little")
    path.write_bytes(changed[:-8] + (size - 1).to_bytes(4, "little") + b"PAR1")
    with pytest.raises(DataError) as refused:
        read(path)
    assert refused.value.problems[0].code == "damaged_file"


def test_files_that_would_fill_the_memory(tmp_path: Path) -> None:
    zeros = np.zeros(10**6)
    np.savez_compressed(tmp_path / "a.npz", x=zeros)
    scipy_io.savemat(tmp_path / "a.mat", {"x": zeros}, do_compression=True)
    _parquet(tmp_path / "a.parquet", pa.table({"x": zeros}))
    for name in ("a.npz", "a.mat", "a.parquet"):
        with max_memory("270 MiB"), pytest.raises(DataError, match=r"needs .* of memory, the ceiling is 270") as caught:
            read(tmp_path / name)
        assert caught.value.problems[0].code == "too_large"
        assert "--max-memory 2GiB" in caught.value.problems[0].do
        assert len(read(tmp_path / name)) == 10**6


def test_a_header_of_npy_that_promises_too_much(tmp_path: Path) -> None:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**13,)})
    path = tmp_path / "a.npy"
    path.write_bytes(stream.getvalue() + bytes(80))
    with pytest.raises(DataError) as caught:
        read(path)
    assert caught.value.problems[0].code == "damaged_file"
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("x.npy", path.read_bytes())
    with pytest.raises(DataError):
        read(tmp_path / "a.npz")


@pytest.mark.parametrize(("name", "write"), WRITERS, ids=[name for name, _ in WRITERS])
def test_a_file_that_was_cut_off(tmp_path: Path, name: str, write: Callable[[Path], object]) -> None:
    path = tmp_path / name
    write(path)
    whole = path.read_bytes()
    for share in (0.3, 0.6, 0.9):
        path.write_bytes(whole[: int(len(whole) * share)])
        with pytest.raises(DataError) as caught:
            read(path)
        assert caught.value.problems[0].code in ("damaged_file", "no_channel")


def test_the_formats_are_told_by_content_not_by_name(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    with path.open("wb") as stream:
        np.save(stream, GYRO)
    assert find_reader(load(path)).name == "npy"
    assert len(read(path)) == N
