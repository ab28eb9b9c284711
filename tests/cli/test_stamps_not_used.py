"""What a noun says of stamps that it does not use, and of a sample rate that contradicts them."""

from pathlib import Path

import numpy as np
import pytest

from typed_commands import call_json

N = 3_000


def written(path: Path, clock: str, back: float = 0.0) -> str:
    time = 0.1 * np.arange(N)
    time[N // 2 :] -= back
    rate = np.random.default_rng(3).normal(size=N)
    np.savetxt(path, np.column_stack((time, rate)), "%.4f", ",", header=f"{clock},gyro_x_dps", comments="")
    return str(path)


def test_a_clock_that_nobody_named_and_that_goes_back(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "q1", back=5.0)
    found = call_json(capsys, "allan", file, "--sample-rate", "10")
    (remark,) = (one for one in found["remarks"] if one["code"] == "time_backwards")
    assert remark["where"].endswith(f"a.csv:{N // 2 + 2}")
    assert "--time-column q1" in remark["do"]


def test_a_sample_rate_that_contradicts_the_stamps(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t_s")
    found = call_json(capsys, "allan", file, "--sample-rate", "0.1")
    (remark,) = (one for one in found["remarks"] if one["code"] == "sample_rate_disagrees")
    assert (found["exit"], remark["severity"]) == (4, "error")
    assert "0.1 Hz was given, the time stamps say 10 Hz" in remark["what"]
