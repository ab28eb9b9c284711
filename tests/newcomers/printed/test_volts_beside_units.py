"""A folder with recordings of one gyro in volts, in counts and in deg/s: one sensor with its chain, and the truth."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from newcomer_truths import BIASES, ERRORS, SLOPES, Log, chamber, rate_table

from typed_commands import call

NOISE = 0.006  # %: of a scale factor by the noise of such records; three of them show less by chance
CHAIN = ("--lsb", "5 V / 4095", "--reference", "2.5 V", "--scale-factor", "0.02 V/(deg/s)")


def write(path: Path, log: Log, unit: str, other: str, values: np.ndarray[Any, Any]) -> None:
    by_unit: dict[str, Any] = {"V": log.volts(), "count": log.counts(), "deg/s": log.readings}
    columns = by_unit[unit]
    names = ",".join(f"gyro_{axis} [{unit}]" for axis in "xyz")
    table = np.column_stack([log.time, values, *(columns[axis] for axis in "xyz")])
    np.savetxt(path, table, "%.9g", ",", header=f"time [s],{other},{names}", comments="")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for seed, unit in ((1, "V"), (4, "deg/s"), (5, "count")):
        log = rate_table(seed=seed, dwell=8.0)
        write(tmp_path / f"table_{seed}.csv", log, unit, "table_rate [deg/s]", log.applied)
    for seed, unit in ((2, "deg/s"), (7, "V")):
        log = chamber(seed=seed, hours=0.7)
        write(tmp_path / f"chamber_{seed}.csv", log, unit, "temperature [degC]", log.temperature)
    return tmp_path


def estimates(content: Any, test: str) -> dict[tuple[str, str, int], tuple[float, float]]:
    return {(one["quantity"], one["axis"], one["power"] or 0): (one["value"], one["u"]) for one in content["results"]
            if one["test"] == test and one["method"] == "result" and one["u"]}  # fmt: skip


def test_init_and_run_give_the_truth(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, _, err = call(capsys, "init", str(folder), "--yes", "--axis", "x", *CHAIN)
    assert status == 0, err
    status, out, err = call(capsys, "run", str(folder), "--json")
    assert status == 0, err
    content = json.loads(out)
    rate, thermal = estimates(content, "rate"), estimates(content, "thermal_gyro")
    value, u = rate["scale_factor_error", "x", 0]
    assert value == pytest.approx(100.0 * ERRORS["x"], abs=5.0 * u + NOISE)
    for axis in "xyz":
        value, u = thermal["bias", axis, 0]
        assert value == pytest.approx((1.0 + ERRORS[axis]) * BIASES[axis], abs=5.0 * u)
        value, u = thermal["bias_temperature", axis, 1]
        assert value == pytest.approx((1.0 + ERRORS[axis]) * SLOPES[axis], abs=5.0 * u)


@pytest.mark.parametrize("order", [(2, 7), (7, 2)])
def test_the_noun_takes_both_and_its_model_compensates_both(
    order: tuple[int, int], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = [str(folder / f"chamber_{one}.csv") for one in order]
    model, out_path = folder / "model.json", folder / "out.csv"
    assert call(capsys, "thermal", *names, *CHAIN[2:], "-o", str(model))[0] == 0
    for name in names:
        assert call(capsys, "compensate", str(model), name, "-o", str(out_path))[0] == 0
        head, *rows = (line.split(",") for line in out_path.read_text().splitlines())
        at = [i for i, one in enumerate(head) if one.endswith("[deg/s]")]
        values = np.array([[float(row[i]) for i in at] for row in rows])
        assert np.abs(values.mean(axis=0)).max() < 1e-3
        assert values.std(axis=0) == pytest.approx(0.02, rel=0.05)


def test_without_the_chain_the_folder_says_what_is_missing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(capsys, "init", str(folder), "--yes", "--axis", "x")[0] == 0
    marked = [line for line in (folder / "campaign.toml").read_text().splitlines() if "FILL IN" in line]
    assert [line.split(" = ")[0] for line in marked] == ["chain", "chain"]


def test_one_recording_of_two_kinds_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An axis in volts beside one in deg/s is a mistake of the header."""
    path = folder / "chamber_7.csv"
    path.write_text(path.read_text().replace("gyro_y [V]", "gyro_y [deg/s]", 1))
    status, _, err = call(capsys, "thermal", str(path), *CHAIN[2:])
    assert status == 2
    assert "'gyro_y [deg/s]' (deg/s)" in err
