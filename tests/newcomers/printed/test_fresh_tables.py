"""Tables in counts and volts, as a bench leaves them: titles wider than the table, a chain in a file of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.files import read
from inertialcal.files.text.headers import heading
from typed_commands import call, call_json

RATES = np.array([0.0, 10.0, 20.0, 40.0, 60.0, -60.0, -40.0, -20.0, -10.0, 0.0])  # deg/s
REFERENCE, SCALE, ERROR, BIAS = 2.5, 0.025, 0.008, 1.7  # V, V/(deg/s), 1, deg/s
CHAIN = 'lsb = "5 V / 65535"\nreference = "2.5 V"\nscale_factor = {x = "0.02 V/(deg/s)", y = "0.03 V/(deg/s)"}\n'
FEW = 5.0  # standard uncertainties


def comma(value: float, digits: int) -> str:
    """Return a number with decimal comma."""
    return f"{value:.{digits}f}".replace(".", ",")


def estimate(content: dict[str, Any], quantity: str, axis: str) -> tuple[float, float]:
    """Return value and standard uncertainty of a result."""
    (one,) = [
        row for row in content["results"]
        if (row["quantity"], row["axis"], row["method"], row["power"]) == (quantity, axis, "result", 0) and row["u"]
    ]  # fmt: skip
    return float(one["value"]), float(one["u"])


def bench(path: Path) -> Path:
    """Write reduced readings in volts below titles with more cells than the table."""
    rng = np.random.default_rng(11)
    volts = REFERENCE + SCALE * ((1.0 + ERROR) * np.tile(RATES, 3) + BIAS) + 2e-3 * rng.standard_normal(30)
    rows = (f"{comma(r, 1)};{comma(v, 5)};{comma(0.0012, 4)}" for r, v in zip(np.tile(RATES, 3), volts, strict=True))
    head = ["Prüfling;GY-7;;", "Datum;12.03.2024;;", "", "Drehrate Soll [°/s];Spannung [V];Spannung_std [V]"]
    path.write_bytes("\r\n".join([*head, *rows]).encode("cp1252"))
    return path


def test_titles_wider_than_the_table_are_found_and_its_only_other_column_is_the_reading(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = bench(tmp_path / "drehtisch.csv")
    words = ("--axis", "x", "--reference", "2.5 V", "--scale-factor", "0.025 V/(deg/s)")
    content = call_json(capsys, "rate-table", str(path), *words)
    assert content["exit"] == 0, content["errors"]
    for quantity, true in (("bias", BIAS), ("scale_factor_error", 100.0 * ERROR)):
        value, u = estimate(content, quantity, "x")
        assert abs(value - true) < FEW * u, (quantity, value, u)


def recording(path: Path) -> Path:
    """Write a recording of a rate table in counts: x turned, y at rest."""
    rng, rate = np.random.default_rng(12), 50.0
    t = np.arange(len(RATES) * 600) / rate
    applied = RATES[(t // 12).astype(int)]
    volts = [0.02 * ((1.0 + ERROR) * applied + BIAS), np.full(len(t), 0.03 * 0.5)]
    x, y = (np.rint((REFERENCE + one + 2e-3 * rng.standard_normal(len(t))) / 5.0 * 65535).astype(int) for one in volts)
    rows = zip((1000.0 * t).astype(int), applied, x, y, strict=True)
    path.write_text("time_ms,rate_dps,gx,gy\n" + "".join(f"{a},{r:g},{b},{c}\n" for a, r, b, c in rows))
    return path


@pytest.mark.parametrize("head", ["", "[chain]\n"])
def test_a_chain_in_a_file_says_that_readings_are_counts(
    head: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "chain.toml").write_text(head + CHAIN)
    path = recording(tmp_path / "turn.csv")
    content = call_json(capsys, "rate-table", str(path), "--axis", "x", "--chain", str(tmp_path / "chain.toml"))
    assert content["exit"] == 0, content["errors"]
    for quantity, axis, true in (("bias", "x", BIAS), ("bias", "y", 0.5), ("scale_factor_error", "x", 100.0 * ERROR)):
        value, u = estimate(content, quantity, axis)
        assert abs(value - true) < FEW * u, (quantity, axis, value, u)


def test_positions_in_counts_need_no_unit_beside_their_chain(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng, faces = np.random.default_rng(13), np.concatenate([np.eye(3), -np.eye(3)])
    biases, errors = np.array([0.2, -0.1, 0.15]), np.array([0.01, -0.01, 0.005])  # m/s^2, 1
    sense = np.repeat(np.tile(faces, (2, 1)), 800, axis=0) * 9.80665 * (1.0 + errors) + biases
    sense += 0.01 * rng.standard_normal(sense.shape)
    sense[np.arange(len(sense)) % 800 >= 700] += rng.normal(0.0, 3.0, (100 * 12, 3))
    counts = np.rint((1.65 + 0.08 * sense) / 3.3 * 65535).astype(int)
    rows = (f"{i / 100:.2f},{x},{y},{z}\n" for i, (x, y, z) in enumerate(counts))
    (tmp_path / "faces.csv").write_text("t [s],ax,ay,az\n" + "".join(rows))
    words = ("--lsb", "3.3 V / 65535", "--reference", "1.65 V", "--scale-factor", "0.08 V/(m/s^2)")
    content = call_json(capsys, "positions", str(tmp_path / "faces.csv"), *words)
    assert content["exit"] == 0, content["errors"]
    for axis, true in zip("xyz", biases, strict=True):
        value, u = estimate(content, "bias", axis)
        assert abs(value - true) < FEW * u + 1e-3, (axis, value, u)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [("Vitesse X (V)", "gyro"), ("Rate Z [count]", "gyro"), ("Vitesse X (m/s)", ""), ("Rate (V)", "voltage")],
)
def test_what_turns_is_a_gyro_in_volts_about_an_axis_alone(name: str, quantity: str) -> None:
    assert heading(name).quantity == quantity


def test_a_chamber_log_in_volts_is_thermal_for_info_and_for_init(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    temperature = np.linspace(-20.0, 60.0, 2000)
    volts = REFERENCE + SCALE * (0.5 + 0.02 * (temperature - 20.0)) + 1e-3 * np.random.default_rng(14).normal(size=2000)
    every = enumerate(zip(volts, temperature, strict=True))
    rows = (f"{comma(2.0 * i, 1)};{comma(v, 6)};{comma(t, 3)}\n" for i, (v, t) in every)
    (tmp_path / "etuve.csv").write_text("Temps (s);Vitesse X (V);Température (°C)\n" + "".join(rows))
    (found,) = call_json(capsys, "info", str(tmp_path / "etuve.csv"))["results"]
    assert found["next"].split()[1] == "thermal"
    assert call(capsys, "init", str(tmp_path), "--yes")[0] == 0
    assert 'procedure = "thermal"' in (tmp_path / "campaign.toml").read_text()
    words = ("--reference", "2.5 V", "--scale-factor", "0.025 V/(deg/s)")
    content = call_json(capsys, "thermal", str(tmp_path / "etuve.csv"), *words)
    (slope,) = [
        one for one in content["results"]
        if (one["quantity"], one["power"], one["method"]) == ("bias_temperature", 1, "result") and not one["member"]
    ]  # fmt: skip
    assert abs(slope["value"] - 0.02) < FEW * slope["u"]


def test_a_title_of_two_filled_cells_above_a_table_of_two_columns_stays_its_header(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time_s,gyro_x,\n" + "".join(f"{i / 10},{i % 7}\n" for i in range(50)))
    assert read(tmp_path / "a.csv").names == ("gyro_x",)
