"""`thermal` on the command line: output, exit status, figure, one clear message for bad input."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.show.rows import case_name, quantity_name
from typed_commands import call, call_json

BIAS = 0.01  # at 20 degC [deg/s]
GAP = 0.002  # warming minus cooling [deg/s]
BEGIN = 1.7e9


def write(path: Path, run: int, head: str = "unix_s,temperature [degC],gyro_x [deg/s]", swing: float = 1.0) -> Path:
    """A loop from 20 degC down, up and back: a slope, a gap between the paths, an offset of the run, noise."""
    rng = np.random.default_rng(run)
    time = np.arange(0.0, 12_000.0, 20.0)
    T = 20.0 + swing * np.interp(time, [0.0, 900.0, 4000.0, 9000.0, 12_000.0], [0.0, 0.0, -40.0, 40.0, 0.0])
    bias = BIAS + 1e-4 * (T - 20.0) + 0.5 * GAP * np.sign(np.gradient(T)) + rng.normal(0.0, 2e-4)
    bias += rng.normal(0.0, 5e-4, time.size)
    rows = np.column_stack([BEGIN + 1e5 * run + time, T, bias])
    np.savetxt(path, rows, fmt="%.6f", delimiter=",", header=head, comments="")
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("thermal")
    return [str(write(folder / f"run{run}.csv", run)) for run in (1, 2, 3)]


def test_three_runs(capsys: pytest.CaptureFixture[str], runs: list[str]) -> None:
    status, out, err = call(capsys, "thermal", *runs, "--at", "0 degC", "--at", "90 degC", "--warm-up", "300 s")
    assert (status, err) == (0, "")
    assert "columns: x = gyro_x [deg/s], temperature = temperature [degC]" in out
    assert "bias (90 degC) x: outside the range of the ramps, -19." in " ".join(out.split())
    content = call_json(capsys, "thermal", *runs, "--at", "0 degC")
    rows = {(quantity_name(row), case_name(row)): row for row in content["results"]}
    for key, true in {
        ("bias", ""): BIAS,
        ("bias", "0 degC"): BIAS - 2e-3,
        ("bias_temperature_1", ""): 1e-4,
        ("path_difference", ""): GAP,
    }.items():
        assert rows[key]["unit"].startswith("deg/s")
        lo, hi = rows[key]["interval"]["lo"], rows[key]["interval"]["hi"]
        assert lo <= true <= hi, key
        assert hi - lo < 30.0 * abs(true), key
    assert [len(one["sha256"]) for one in content["inputs"]] == [64] * 3
    assert call(capsys, "thermal", *runs, "--quiet") == (0, "", "")


def test_an_order_and_a_reference_given_are_used(capsys: pytest.CaptureFixture[str], runs: list[str]) -> None:
    content = call_json(capsys, "thermal", *runs, "--order", "2", "--reference-temperature", "0 degC")
    rows = {quantity_name(row): row for row in content["results"] if not case_name(row)}
    assert rows["bias_temperature_2"]["value"] == pytest.approx(0.0, abs=2e-6)
    assert "bias_temperature_3" not in rows
    assert rows["bias"]["value"] == pytest.approx(BIAS - 2e-3, abs=6e-4)  # at 0 degC


def test_files_of_one_power_up_are_one_run(capsys: pytest.CaptureFixture[str], runs: list[str]) -> None:
    codes = {one["code"] for one in call_json(capsys, "thermal", *runs, "--one-run")["remarks"]}
    assert "no_runs" in codes


def test_figures_are_written(capsys: pytest.CaptureFixture[str], runs: list[str], tmp_path: Path) -> None:
    for name in ("thermal", "thermal_order", "start_up"):
        file = tmp_path / f"{name}.svg"
        status, out, _ = call(capsys, "thermal", *runs, "--figure", name, "-o", str(file))
        assert status == 0, name
        assert f"{file.name}" in out
        assert file.read_text(encoding="utf-8").startswith("<")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--column", "x"), "no column 'x'"),
        (("--column", "w=gyro_x"), "column 'w'"),
        (("--sensor", "mag"), "There are: gyro, acc"),
        (("--order", "12"), "--order = 12: should be less than or equal to 9"),
        (("--order", "-1"), "--order = -1: should be greater than or equal to 0"),
        (("--at", "20"), "--at: '20' has no unit"),
        (("--at", "hot"), "--at: quantity 'hot'"),
        (("--reference-temperature", "20 deg/s"), "--reference-temperature: '20 deg/s' is not in a unit like degC"),
        (("--warm-up", "300"), "--warm-up: '300' has no unit"),
        (("--unit", "gyro=furlong"), "furlong"),
        (("--figure", "thermal"), "--figure"),
    ],
)
def test_wrong_usage_is_told_in_one_message(
    capsys: pytest.CaptureFixture[str], runs: list[str], words: tuple[str, ...], told: str
) -> None:
    status, out, err = call(capsys, "thermal", *runs, *words)
    assert status in (2, 3)
    assert out == ""
    assert told in " ".join(err.split())


def test_all_units_are_asked_for_at_once(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    bare = write(tmp_path / "bare.csv", 1, "unix_s,temperature,gyro_x")
    status, out, err = call(capsys, "thermal", str(bare))
    assert (status, out) == (2, "")
    assert "--unit gyro=UNIT --unit temperature=degC (UNIT of gyro: deg/s, rad/s, ...; temp" in " ".join(err.split())


def test_counts_are_refused_with_what_they_need(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    counts = write(tmp_path / "counts.csv", 1, "unix_s,temperature [degC],gyro_x [count]")
    status, _, err = call(capsys, "thermal", str(counts))
    assert status == 2
    said = " ".join(err.split())
    assert "counts and volts need the chain of the sensor" in said
    assert '--lsb "NUMBER V" --reference "NUMBER V" --scale-factor "NUMBER V/(deg/s)"' in said
    assert "--unit" not in said


@pytest.mark.parametrize(
    ("head", "told"),
    [
        ("unix_s,pressure [Pa],gyro_x [deg/s]", "cannot tell which column is the temperature"),
        ("unix_s,temperature [degC],reading [deg/s]", "cannot tell which column is which axis of the gyro"),
    ],
)
def test_a_column_that_is_not_clear_is_asked_for(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, head: str, told: str
) -> None:
    status, out, err = call(capsys, "thermal", str(write(tmp_path / "odd.csv", 1, head)))
    assert (status, out) == (2, "")
    assert told in " ".join(err.split())
    assert "Add: --column" in " ".join(err.split())


def test_a_file_given_twice_is_no_second_run(capsys: pytest.CaptureFixture[str], runs: list[str]) -> None:
    status, _, err = call(capsys, "thermal", runs[0], runs[0])
    assert status == 2
    assert "given twice" in err


def test_a_copy_under_another_name_is_refused(
    capsys: pytest.CaptureFixture[str], runs: list[str], tmp_path: Path
) -> None:
    copy = tmp_path / "copy.csv"
    copy.write_bytes(Path(runs[0]).read_bytes())
    status, _, err = call(capsys, "thermal", runs[0], str(copy))
    assert status == 3
    assert "copy.csv" in err


def test_a_temperature_that_hardly_changes_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    status, _, err = call(capsys, "thermal", str(write(tmp_path / "room.csv", 1, swing=0.01)))
    assert status == 3
    assert "degC" in err


def test_a_file_that_is_not_there_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert call_json(capsys, "thermal", str(tmp_path / "nothing.csv"))["exit"] == 3


# A real record


def test_the_real_record_is_asked_for_its_units_and_then_told(capsys: pytest.CaptureFixture[str], shared: Path) -> None:
    path = shared / "data" / "tofupilot_thermal" / "imu_raw_data.csv"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    status, out, err = call(capsys, "thermal", str(path))
    assert (status, out) == (2, "")
    assert "--unit gyro=UNIT --unit temperature=degC" in " ".join(err.split())
    units = ("--unit", "gyro=rad/s", "--unit", "temperature=degC", "--unit", "timestamp=ns")
    status, out, err = call(capsys, "thermal", str(path), *units)
    assert (status, err) == (0, "")
    told = " ".join(out.split())
    for words in ("path_difference x -0.00", "the time axis is impossible", "hysteresis x", "unclear: one loop"):
        assert words in told
