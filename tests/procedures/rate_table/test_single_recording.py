"""A recording of a stepped table, in one file, without a campaign file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError, UsageError

RATES = [0.0, 10.0, -10.0, 20.0, -20.0, 40.0, -40.0, 80.0, -80.0, 0.0]  # [deg/s]
SENSED = np.array([0.02, 0.998, -0.01])  # what x, y, z read of y
BIAS = np.array([0.1, 0.5, -0.1])  # [deg/s]
HEAD = "t [s],table_rate [deg/s],wx [deg/s],wy [deg/s],wz [deg/s]"


def write(folder: Path, head: str = HEAD, seed: int = 1) -> Path:
    rng = np.random.default_rng(seed)
    rate = np.repeat(RATES, 400)
    readings = np.outer(rate, SENSED) + BIAS + rng.normal(0.0, 0.05, (len(rate), 3))
    path = folder / "unknown.csv"
    columns = np.column_stack([np.arange(len(rate)) / 10.0, rate, readings])
    np.savetxt(path, columns, "%.5f", ",", header=head, comments="")
    return path


def test_the_truth_is_found_with_no_more_than_the_axis(tmp_path: Path) -> None:
    found = ic.rate_table(write(tmp_path), axis="y")
    values = {(row.quantity, row.axis): row for row in found.rows if not str(row.case)}
    for quantity, axis, truth in (
        ("scale_factor_error", "y", 100.0 * (SENSED[1] - 1.0)),
        ("cross_axis_sensitivity", "xy", 100.0 * SENSED[0]),
        ("cross_axis_sensitivity", "zy", 100.0 * SENSED[2]),
        *(("bias", axis, bias) for axis, bias in zip("xyz", BIAS, strict=True)),
    ):
        row = values[quantity, axis]
        assert row.value is not None
        assert row.u is not None
        assert abs(row.value - truth) < 5.0 * row.u, quantity
    assert {axis: found.columns[axis] for axis in "xyz"} == {"x": "wx [deg/s]", "y": "wy [deg/s]", "z": "wz [deg/s]"}
    assert len(found.result.readings) == len(RATES)


def test_the_axis_is_asked_for_and_the_one_that_follows_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"axis not given; .* is followed by y") as refused:
        ic.rate_table(write(tmp_path))
    assert refused.value.problems[0].do == "Add: axis='y'"


def test_counts_need_a_chain(tmp_path: Path) -> None:
    path = write(tmp_path, "t [s],table_rate [deg/s],wx [count],wy [count],wz [count]")
    with pytest.raises(UsageError, match="without a unit of angular rate") as refused:
        ic.rate_table(path, axis="y")
    assert "chain" in refused.value.problems[0].why


def test_one_channel_may_be_named(tmp_path: Path) -> None:
    found = ic.rate_table(write(tmp_path), reading="wy [deg/s]", axis="y")
    assert {row.axis for row in found.rows if row.quantity == "bias"} == {"y"}
    with pytest.raises(DataError, match="no column 'wq'"):
        ic.rate_table(write(tmp_path), reading={"x": "wq"}, axis="x")


def test_a_table_of_dwells_on_a_regular_clock_stays_a_table(tmp_path: Path) -> None:
    path = tmp_path / "dwells.csv"
    rows = [f"{i},{rate},{rate * 1.01 + 0.2 + 1e-4 * i}" for i, rate in enumerate(RATES * 3)]
    path.write_text("\n".join(["time [s],rate [deg/s],gyro_z [deg/s]", *rows, ""]))
    found = ic.rate_table(path)
    assert len(found.result.readings) == len(rows)
