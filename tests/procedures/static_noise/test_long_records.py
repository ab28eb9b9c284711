"""A record longer than memory gives the figures of one that is held whole, wherever its batches end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import inertialcal as ic
from inertialcal.core import batches
from inertialcal.signals.allan import streamed

N, RATE = 30_000, 200.0
ROUNDING = 1e-12  # relative


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three axes: one with glitches, a burst and missing cells, one in coarse steps with a stuck stretch, one clean."""
    rng = np.random.default_rng(5)
    t = np.arange(N) / RATE
    columns: dict[str, Any] = {"t [s]": t}
    for axis in "xyz":
        x = 0.1 + 0.05 * rng.normal(size=N) + 1e-5 * np.cumsum(rng.normal(size=N))
        if axis == "x":
            x[5000], x[9000:9400], x[12_000:12_003] = 9.0, x[9000:9400] + 1.0, np.nan
        if axis == "y":
            x = np.rint(100.0 * x) / 100.0
            x[16_000:16_300] = x[16_000]
        columns[f"gyro_{axis} [deg/s]"] = x
    path = tmp_path_factory.mktemp("long") / "messy.parquet"
    pq.write_table(pa.table(columns), path)
    whole = path.with_name("clean.parquet")
    pq.write_table(pa.table({"t [s]": t, "gyro_z [deg/s]": columns["gyro_z [deg/s]"]}), whole)
    gaps = path.with_name("gaps.parquet")
    kept = np.ones(N, dtype=bool)
    kept[20_000:20_150] = False
    pq.write_table(pa.table({"t [s]": t[kept], "gyro_z [deg/s]": columns["gyro_z [deg/s]"][kept]}), gaps)
    return path


def figures(path: Path) -> tuple[list[Any], list[str], list[float]]:
    found = ic.allan(path)
    rows = [(row.key, row.test, row.value, row.u) for row in found.rows]
    curves = [
        np.asarray(one.columns[name].values, dtype=float)
        for one in found.result.curves()
        for name in ("deviation", "density", "edf")
        if name in one.columns
    ]
    return rows, [str(one) for one in found.remarks], np.concatenate(curves).tolist()


@pytest.mark.parametrize("name", ["messy", "clean", "gaps"])
@pytest.mark.parametrize("size", [997, 16_384])
def test_figures_and_remarks_are_those_of_the_whole_record(
    file: Path, name: str, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = file.with_name(f"{name}.parquet")
    rows, remarks, curves = figures(path)
    monkeypatch.setattr(batches, "HELD", 0)
    monkeypatch.setattr(batches, "SIZE", size)
    monkeypatch.setattr(streamed, "LONG", 0)
    monkeypatch.setattr(streamed, "BLOCK", size)
    monkeypatch.setattr(streamed, "NEAR", 50)
    recording = ic.read(path)
    assert all(batches.is_stored(one.data) for one in recording.channels)
    again_rows, again_remarks, again_curves = figures(path)
    assert again_remarks == remarks
    assert [row[:2] for row in again_rows] == [row[:2] for row in rows]
    for column in (2, 3):
        again, once = ([np.nan if row[column] is None else row[column] for row in one] for one in (again_rows, rows))
        np.testing.assert_allclose(again, once, rtol=1e-9)  # fits stop where their steps are small, not at a number
    np.testing.assert_allclose(again_curves, curves, rtol=ROUNDING)


@pytest.mark.parametrize("size", [100, 20_000])
def test_a_recording_is_compensated_and_written_as_the_whole(
    file: Path, size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = "flight_unit"
    recording = ic.read(file)
    expected = ic.compensate(model, recording, temperature=20.0)
    ic.write(tmp_path / "whole.parquet", expected)
    monkeypatch.setattr(batches, "HELD", 0)
    monkeypatch.setattr(batches, "SIZE", size)
    found = ic.compensate(model, file, temperature=20.0)
    assert found.names == expected.names
    for name in found.names:
        np.testing.assert_array_equal(found.channel(name).data, expected.channel(name).data)
    assert [str(one) for one in found.remarks] == [str(one) for one in expected.remarks]
    ic.write(tmp_path / "batches.parquet", found)
    assert (tmp_path / "batches.parquet").read_bytes() == (tmp_path / "whole.parquet").read_bytes()
