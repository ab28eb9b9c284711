"""allan and psd: a command, Python and a campaign give the same rows of one file, bare columns and codes included."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from typed_commands import same_rows

N, INTERVAL = 4_000, 0.01


def table(path: Path, head: str, *columns: NDArray[Any]) -> Path:
    """Write columns after the time."""
    time = np.arange(N) * INTERVAL
    np.savetxt(path, np.column_stack([time, *columns]), "%.9g", ",", header=f"time [s],{head}", comments="")
    return path


def white(seed: int, size: float = 0.04) -> NDArray[np.float64]:
    """Return white noise."""
    return np.random.default_rng(seed).normal(0.0, size, N)


WAYS: dict[str, tuple[str, list[NDArray[Any]], dict[str, Any]]] = {
    "a gyro": ("gyro_x [deg/s],gyro_y [deg/s]", [white(1), white(2)], {"standards": {"sensor.scale_factor": "0.2 %"}}),
    "both sensors": ("gyro_x [deg/s],acc_x [m/s2]", [white(1), white(2) + 9.8], {"warm_up": "2 s"}),
    "no unit": ("rate", [white(3)], {"taus": "decade"}),
    "counts": ("gyro_x [count]", [np.rint(white(4, 500.0))], {"quantity": "rate"}),
    "scaled counts": ("gyro_x [count]", [np.rint(white(4, 500.0))], {"scale_factor": {"gyro": "131 count/(deg/s)"}}),
    "increments": ("gyro_x [deg]", [white(5) * INTERVAL], {"quantity": "increment"}),
    "an angle": ("gyro_x [deg]", [np.cumsum(white(6) * INTERVAL)], {"quantity": "angle"}),
    "axes unknown": ("a [mV],b [mV],c [mV],d [mV]", [white(i) for i in range(4)], {"columns": ["a [mV]", "d [mV]"]}),
    "averages": ("gyro_x [deg/s]", [white(7)], {"averaging": "5 ms", "terms": ["random_walk"]}),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("word", ["allan", pytest.param("psd", marks=pytest.mark.slow)])
def test_one_way(tmp_path: Path, capsys: pytest.CaptureFixture[str], way: str, word: str) -> None:
    head, columns, settings = WAYS[way]
    file = table(tmp_path / "still.csv", head, *columns)
    found = same_rows(capsys, word, [file], tmp_path / "campaign", **settings)
    assert any(row.quantity.endswith("random_walk") and row.value for row in found.rows)


def test_several_records(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [table(tmp_path / f"still{seed}.csv", "gyro_x [deg/s]", white(seed)) for seed in (1, 2)]
    found = same_rows(capsys, "allan", files, tmp_path / "campaign")
    assert {row.member.label for row in found.rows if row.member} == {"still1", "still2"}


def test_arrays_and_recordings_and_files(tmp_path: Path) -> None:
    file = table(tmp_path / "still.csv", "gyro_x [deg/s]", white(1))
    recording = ic.read(file)
    rows = [[(row.key, row.value, row.u) for row in ic.allan(one).rows] for one in (file, recording)]
    assert rows[0] == rows[1]
    of_array = ic.allan(recording.channel("gyro_x [deg/s]").data, sample_rate=1.0 / INTERVAL, units="deg/s")
    walk = next(row.value for row in of_array.rows if row.quantity == "angle_random_walk")
    assert walk == pytest.approx(rows[0][0][1], rel=1e-6)  # the interval of an array is stated, that of stamps measured


def test_like_a_campaign_takes_its_plan_and_standards(tmp_path: Path) -> None:
    file = table(tmp_path / "still.csv", "gyro_x [deg/s]", white(1))
    first = ic.allan(file, warm_up="2 s", standards={"sensor.scale_factor": "3 %"})
    first.write_campaign(tmp_path / "campaign")
    again = ic.allan(file, like=tmp_path / "campaign")
    assert [(row.key, row.value, row.u) for row in again.rows] == [(row.key, row.value, row.u) for row in first.rows]


def test_a_bare_column_is_written_as_a_sensor_of_another_kind(tmp_path: Path) -> None:
    file = table(tmp_path / "still.csv", "rate", white(3))
    ic.allan(file).write_campaign(tmp_path / "campaign")
    written = tomllib.loads((tmp_path / "campaign" / "campaign.toml").read_text())
    (sensor,) = written["sensors"].values()
    assert sensor["kind"] == "other"
    assert sensor["unit"] == ""
