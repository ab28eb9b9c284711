"""The command `sensitivity`: files by power-up, channels by role or name, a campaign of it, requirements, refusals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import UsageError
from typed_commands import call, call_json

SLOPE = 0.02  # [deg/s/V]
VOLTS = (5.0, 4.85, 5.15, 5.0)
LEVEL = 40  # samples


def write(path: Path, volts: tuple[float, ...], seed: int, offset: float, **more: str) -> Path:
    """Write a power-up at one temperature; ``more`` are further columns by header, each a copy of the supply."""
    rng = np.random.default_rng(seed)
    V = np.repeat(volts, LEVEL) + rng.normal(0.0, 2e-4, LEVEL * len(volts))
    y = offset + SLOPE * (V - 5.0) + rng.normal(0.0, 5e-4, V.size)
    T = 20.0 + rng.normal(0.0, 0.01, V.size)
    heads = ["unix_s", "temperature [degC]", "supply [V]", "gyro_x [deg/s]", *more]
    time = 1.7e9 + 1e5 * seed + 5.0 * np.arange(V.size)
    columns = [time, T, V, y, *(factor * V for factor in map(float, more.values()))]
    with path.open("w") as file:
        file.write(",".join(heads) + "\n")
        file.writelines(",".join(f"{v:.7f}" for v in one) + "\n" for one in zip(*columns, strict=True))
    return path


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("power_ups")
    offsets = (0.01, -0.02, 0.005)
    return [str(write(folder / f"run{i}.csv", VOLTS, i, offset, **{"board_raw": "1000"}))
            for i, offset in enumerate(offsets, 1)]  # fmt: skip


def value(found: Any, quantity: str) -> float:
    rows = [row for row in found.rows if row.quantity == quantity]
    return float(rows[0].value)


def test_the_supply_is_found_by_its_name(runs: list[str]) -> None:
    found = ic.sensitivity(runs, to="supply")
    assert value(found, "bias_supply") == pytest.approx(SLOPE, rel=0.05)
    assert found.rows[0].unit == "deg/s/V"


def test_a_condition_is_found_without_the_unit_in_its_header_and_is_not_the_supply(tmp_path: Path) -> None:
    files = [write(tmp_path / f"run{i}.csv", VOLTS, i, 0.01 * i) for i in (1, 2, 3)]
    for file in files:
        file.write_text(file.read_text().replace("supply [V]", "reference [V]"))
    found = ic.sensitivity([str(file) for file in files], to="reference")
    assert value(found, "bias_reference") == pytest.approx(SLOPE, rel=0.05)
    assert "supply" not in found.write_campaign(tmp_path / "as_campaign").read_text()
    with pytest.raises(UsageError, match="is what the sensor reads, and no condition"):
        ic.sensitivity([str(file) for file in files], to="gyro_x")


def test_any_channel_is_a_condition_by_its_name(runs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["sensitivity", *runs, "--to", "board", "--column", "board=board_raw", "--unit", "board_raw=mV"]
    rows = call_json(capsys, *words)["results"]
    (one,) = [row for row in rows if row["quantity"] == "bias_board"]
    assert one["value"] == pytest.approx(SLOPE, rel=0.05)
    assert one["unit"] == "deg/s/V"


def test_a_channel_that_is_not_there_is_asked_for(runs: list[str]) -> None:
    with pytest.raises(UsageError, match="no column 'humidity'"):
        ic.sensitivity(runs, to="humidity")


def test_a_channel_without_a_unit_is_asked_for(runs: list[str]) -> None:
    with pytest.raises(UsageError, match="unit missing"):
        ic.sensitivity(runs, to="board", columns={"board": "board_raw"})


def test_files_of_one_level_are_of_the_power_up_that_they_are_named_by(tmp_path: Path) -> None:
    names = []
    for run, offset in (("A", 0.01), ("B", -0.03)):
        for i, volts in enumerate((5.0, 4.85, 5.15)):
            path = write(tmp_path / f"{run}{i}.csv", (volts,), 10 * i + ord(run), offset)
            names.append(f"{run}={path}")
    found = ic.sensitivity(names, to="supply")
    assert value(found, "bias_supply") == pytest.approx(SLOPE, rel=0.1)
    alone = ic.sensitivity([name.partition("=")[2] for name in names], to="supply")
    assert {row.reason.code for row in alone.rows if row.quantity == "bias_supply"} == {"between_power_ups"}


def test_the_campaign_of_a_call_gives_the_same_figures(runs: list[str], tmp_path: Path) -> None:
    found = ic.sensitivity(runs, to="board", columns={"board": "board_raw"}, units={"board_raw": "mV"})
    found.write_campaign(tmp_path / "campaign")
    text = (tmp_path / "campaign" / "campaign.toml").read_text(encoding="utf-8")
    assert "conditions" in text
    done = ic.run(tmp_path / "campaign")
    rows = {row["quantity"]: row["value"] for row in done.results["results"]}
    assert rows["bias_board"] == value(found, "bias_board")


def test_a_requirement_on_a_sensitivity_is_judged(runs: list[str], tmp_path: Path) -> None:
    ic.sensitivity(runs, to="supply").write_campaign(tmp_path / "campaign")
    path = tmp_path / "campaign" / "campaign.toml"
    limits = {"strict": "0.01 deg/s/V", "wide": "0.05 deg/s/V"}
    asked = "".join(f'\n[[requirements]]\nid = "{name}"\nquantity = "bias_supply"\nlimit = "{limit}"\n'
                    for name, limit in limits.items())  # fmt: skip
    path.write_text(path.read_text(encoding="utf-8") + asked, encoding="utf-8")
    done = ic.run(tmp_path / "campaign")
    verdicts = {one["requirement"]: one["verdict"] for one in done.results["verdicts"]}
    assert verdicts == {"strict": "FAIL", "wide": "PASS"}


def campaign_of_board(runs: list[str], folder: Path, asked: str) -> Path:
    """Write a campaign of readings against a channel of its own, with requirements."""
    ic.sensitivity(runs, to="board", columns={"board": "board_raw"}, units={"board_raw": "mV"}).write_campaign(folder)
    path = folder / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8") + asked, encoding="utf-8")
    return folder


def test_a_requirement_on_any_channel_is_known_where_a_test_names_it(runs: list[str], tmp_path: Path) -> None:
    asked = "".join(f'\n[[requirements]]\nid = "{name}"\nquantity = "bias_board"\nlimit = "{limit}"\n'
                    for name, limit in {"strict": "0.01 deg/s/V", "wide": "0.05 deg/s/V"}.items())  # fmt: skip
    folder = campaign_of_board(runs, tmp_path / "campaign", asked)
    ic.check(folder)
    verdicts = {one["requirement"]: one["verdict"] for one in ic.run(folder).results["verdicts"]}
    assert verdicts == {"strict": "FAIL", "wide": "PASS"}


def test_a_requirement_on_a_channel_that_no_test_names_is_refused(
    runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = '\n[[requirements]]\nid = "R"\nquantity = "bias_bord"\nlimit = "1 deg/s/V"\n'
    folder = campaign_of_board(runs, tmp_path / "campaign", asked)
    status, _, said = call(capsys, "check", str(folder))
    assert status == 3
    assert "no procedure gives a quantity 'bias_bord'" in said
    assert "Did you mean bias_board" in said


def test_the_model_has_the_term_and_what_it_refers_to(runs: list[str], tmp_path: Path) -> None:
    found = ic.sensitivity(runs, to="supply", references={"supply": "5 V"})
    (path,) = found.write_models(tmp_path / "model.json")
    model = ic.load_model(path)
    (one,) = model.sensitivities
    assert (one.channel, one.unit, one.reference) == ("supply", "V", 5.0)
    assert one.bias is not None
    assert np.degrees(one.bias[0]) == pytest.approx(SLOPE, rel=0.05)


def test_accelerometers_are_taken_too(tmp_path: Path) -> None:
    names = []
    for i in (1, 2):
        path = write(tmp_path / f"run{i}.csv", VOLTS, i, 0.01 * i)
        path.write_text(path.read_text().replace("gyro_x [deg/s]", "acc_x [mg]"))
        names.append(str(path))
    found = ic.sensitivity(names, to="supply")
    assert value(found, "bias_supply") == pytest.approx(SLOPE, rel=0.1)
    assert found.rows[0].unit == "mg/V"


def test_the_only_reference_voltage_is_found(runs: list[str]) -> None:
    for name in runs:
        path = Path(name)
        path.write_text(path.read_text().replace("supply [V]", "reference_voltage [V]"))
    assert value(ic.sensitivity(runs, to="reference"), "bias_reference") == pytest.approx(SLOPE, rel=0.05)


def test_the_end_of_the_time_is_stop(runs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    status, _, said = call(capsys, "sensitivity", runs[0], "--to", "supply", "--stop", "1970-01-02T00:00:00Z")
    assert status == 3
    assert "no sample" in said


@pytest.mark.parametrize("figure", ["sensitivity", "sensitivity_residuals"])
def test_figures_are_drawn(runs: list[str], tmp_path: Path, figure: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "figure.svg"
    words = ["sensitivity", *runs, "--to", "supply", "--figure", figure, "-o", str(path), "--quiet"]
    assert call(capsys, *words)[0] == 0
    assert path.read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.parametrize(
    ("more", "match"),
    [
        ({"references": {"suply": "5 V"}}, "Did you mean supply"),
        ({"references": {"temperature": "20 degC"}}, "its reference is reference_temperature"),
        ({"references": {"supply": "nan V"}}, r"references\.supply"),
        ({"stated": {"bias_suply": "{}"}}, "Did you mean bias_supply"),
        (
            {"stated": {"bias_supply_x": '{ value = "0 deg/s/V", u = "-1 deg/s/V", source = "s" }'}},
            "should not be below 0",
        ),
    ],
)
def test_what_would_do_nothing_is_refused_by_its_name(runs: list[str], more: dict[str, Any], match: str) -> None:
    with pytest.raises(UsageError, match=match):
        ic.sensitivity(runs, to="supply", **more)
