"""``--scale-factor`` of readings that stay in counts; ``--acc-zero`` as a table and as names."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from inertialcal.cli.__main__ import main

SCALE, ZERO = np.array([415.0, 417.0, 413.0]), np.array([32768.0, 32760.0, 32775.0])


@pytest.fixture
def counts(tmp_path: Path) -> str:
    """Write eighteen rests about the faces, in counts, with motion between them."""
    rng, parts = np.random.default_rng(1), []
    for axis in range(3):
        for sign in (1, -1) * 3:
            up = sign * np.eye(3)[axis] + rng.normal(0.0, 0.2, 3)
            f = 9.81 * up / np.linalg.norm(up)
            parts.append(ZERO + SCALE * f + 2.0 * rng.standard_normal((300, 3)))
            parts.append(ZERO + 0.8 * SCALE * f + 400.0 * rng.standard_normal((60, 3)))
    values = np.round(np.vstack(parts))
    table = np.column_stack([np.arange(len(values)) / 50.0, values])
    np.savetxt(tmp_path / "a.csv", table, "%.6g", ",", header="time [s],acc_x,acc_y,acc_z", comments="")
    return str(tmp_path / "a.csv")


def reduced(capsys: pytest.CaptureFixture[str], file: str, *words: str) -> tuple[object, dict[str, float], str]:
    command = ["positions", file, "--unit", "acc=count", "--gravity", "9.81 m/s2", "--scale-factor", *words]
    with pytest.raises(SystemExit) as left:
        main([*command, "--json"])
    out, _ = capsys.readouterr()
    found = json.loads(out)
    errors = {row["axis"]: row["value"] for row in found["results"] if row["quantity"] == "scale_factor_error"}
    return left.value.code, errors, " ".join(one["what"] + one["do"] for one in found["errors"])


@pytest.mark.parametrize("zero", [["32768"], ["{ x = 32768, y = 32768, z = 32768 }"]], ids=["bare", "table"])
def test_the_nominal_of_counts(capsys: pytest.CaptureFixture[str], counts: str, zero: list[str]) -> None:
    status, errors, _ = reduced(capsys, counts, "415 count/(m/s^2)", "--acc-zero", *zero)
    assert status == 0
    assert [errors[axis] for axis in "xyz"] == pytest.approx(SCALE / 415.0 - 1.0, abs=2e-4)


def test_a_unit_that_cannot_be_is_named_with_one_that_can(capsys: pytest.CaptureFixture[str], counts: str) -> None:
    status, _, error = reduced(capsys, counts, "4.15 V/(m/s^2)")
    assert status == 2
    assert "Give a unit like count/(m/s^2)" in error


def test_its_model_takes_the_counts_that_it_was_made_of(
    capsys: pytest.CaptureFixture[str], counts: str, tmp_path: Path
) -> None:
    model, out = str(tmp_path / "model.json"), tmp_path / "out.csv"
    assert reduced(capsys, counts, "415 count/(m/s^2)", "--acc-zero", "32768", "-o", model)[0] == 0
    with pytest.raises(SystemExit) as left:
        main(["compensate", model, counts, "--unit", "acc=count", "-o", str(out), "-q"])
    assert left.value.code == 0
    still = np.genfromtxt(out, delimiter=",", names=True)
    first = np.array([still[name][:300].mean() for name in (still.dtype.names or ())[1:4]])
    assert np.linalg.norm(first) == pytest.approx(9.81, abs=0.01)
