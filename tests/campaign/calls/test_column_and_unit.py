"""However a column and its unit are named, the same rows: with a chain or without, by name, axis, group or alone."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from typed_commands import call

CHAIN: dict[str, Any] = {"lsb": "5 V / 4095", "reference": "2.5 V", "scale_factor": "0.5 V/(deg/s)"}
COUNTS, RATES = 5 / 4095, 0.5  # V, and V/(deg/s)


@pytest.fixture(scope="module")
def rates() -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.random.default_rng(1).normal(0.02, 0.1, 3000)


@pytest.fixture
def folder(tmp_path: Path, rates: np.ndarray[Any, Any], monkeypatch: pytest.MonkeyPatch) -> Path:
    """A column that names its axis, and one that names nothing, in counts and in deg/s."""
    time, codes = np.arange(rates.size) / 10, np.round((2.5 + RATES * rates) / COUNTS)
    for name in ("gyro_x", "speed", "gyro_y"):
        for ending, values in (("counts", codes), ("rates", rates)):
            table = np.column_stack([time, values])
            np.savetxt(tmp_path / f"{name}_{ending}.csv", table, "%.9g", ",", header=f"time [s],{name}", comments="")
    monkeypatch.chdir(tmp_path)
    return tmp_path


WAYS: list[tuple[str, dict[str, str], dict[str, str]]] = [
    ("gyro_x", {}, {"gyro_x": "U"}),
    ("gyro_x", {}, {"gyro": "U"}),
    ("gyro_x", {}, {"x": "U"}),
    ("gyro_x", {}, {"U": "U"}),
    ("gyro_x", {"gyro_x": "gyro_x"}, {"U": "U"}),
    ("gyro_x", {"x": "gyro_x"}, {"x": "U"}),
    ("speed", {"speed": "speed"}, {"U": "U"}),
    ("speed", {"speed": "speed"}, {"speed": "U"}),
    ("speed", {"x": "speed"}, {"x": "U"}),
    ("speed", {"x": "speed"}, {"speed": "U"}),
]


def density(name: str | ic.Recording, **said: Any) -> float:
    """Angle random walk [deg/sqrt(h)] of a file."""
    (row,) = (one for one in ic.allan(name, **said).rows if one.quantity == "angle_random_walk")
    assert row.value is not None
    return row.value


@pytest.mark.parametrize(("name", "columns", "units"), WAYS)
@pytest.mark.usefixtures("folder")
def test_counts_by_a_chain_and_rates_without_one(name: str, columns: dict[str, str], units: dict[str, str]) -> None:
    white = 0.1 * np.sqrt(0.1) * 60.0  # deg/sqrt(h): standard deviation times the root of the sample interval

    def of(unit: str) -> dict[str, str]:
        return {key.replace("U", unit) if key == "U" else key: unit for key in units}

    in_rates = density(f"{name}_rates.csv", columns=columns, units=of("deg/s"))
    in_counts = density(f"{name}_counts.csv", columns=columns, units=of("count"), **CHAIN)
    for found in (in_rates, in_counts):
        assert found == pytest.approx(white, rel=0.05)


@pytest.mark.usefixtures("folder")
def test_a_column_alone_is_of_the_axis_that_it_names() -> None:
    found = ic.allan("gyro_y_counts.csv", columns={"gyro_y": "gyro_y"}, units={"count": "count"}, **CHAIN)
    assert {row.axis for row in found.rows if row.axis} == {"y"}


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("units", [{"x": "deg/s"}, {"speed": "deg/s"}, {"deg/s": "deg/s"}])
def test_a_recording_in_memory_takes_them_as_a_file_does(units: dict[str, str]) -> None:
    for columns in ({"x": "speed"}, {"speed": "speed"}):
        if "x" not in units or "x" in columns:
            told = density(ic.read("speed_rates.csv"), columns=columns, units=units)
            assert told == density("speed_rates.csv", columns=columns, units=units)


@pytest.mark.parametrize("unit", ["deg/s", None])
def test_a_channel_made_in_memory_is_what_its_name_says(tmp_path: Path, unit: str | None) -> None:
    values = np.random.default_rng(2).normal(0.02, 0.1, 3000)
    name = "gyro_y" if unit else "gyro_y [deg/s]"
    path = tmp_path / "same.csv"
    np.savetxt(path, values, "%.17g", header="gyro_y [deg/s]", comments="")
    made = ic.Recording((ic.Channel(name, values, unit),), sample_interval=0.1)
    of_memory, of_file = ic.allan(made), ic.allan(str(path), sample_rate=10.0)
    assert {row.axis for row in of_memory.rows if row.axis} == {"y"}
    assert [(r.quantity, r.value, r.u) for r in of_memory.rows] == [(r.quantity, r.value, r.u) for r in of_file.rows]


def test_a_unit_that_nobody_knows_is_refused_by_its_name_not_dropped() -> None:
    made = ic.Recording(
        (ic.Channel("gyro_x", np.random.default_rng(3).normal(size=300), "furlong"),), sample_interval=0.1
    )
    with pytest.raises(ic.InertialcalError, match="furlong"):
        ic.allan(made)


def test_a_unit_alone_is_that_of_columns_whose_names_say_nothing(folder: Path) -> None:
    said = ic.allan(str(folder / "speed_rates.csv"), units={"deg/s": "deg/s"})
    assert {row.unit for row in said.rows if row.quantity == "angle_random_walk"} == {"deg/sqrt(h)"}


@pytest.mark.parametrize(
    ("option", "words"),
    [
        (("--reference", "2,5 V"), "chain.reference: quantity '2,5 V': the character ',' does not belong here. Use a"),
        (("--reference", "2.5 deg"), "chain.reference: '2.5 deg' is not in a unit like V; or 'channel'"),
        (("--gain", "2,0"), "chain.gain: should be a valid number"),
        (("--gain", "x=2,0"), "chain.gain.x: should be a valid number"),
    ],
)
def test_a_value_of_several_kinds_is_refused_in_one_message(
    option: tuple[str, str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without the names that the schema's library has for the kinds."""
    rows = "".join(f"{t},{2.5 + 1e-4 * (t % 7)},{20 + t}\n" for t in range(60))
    (tmp_path / "log.csv").write_text("time [s],gyro_x [V],temperature [degC]\n" + rows)
    options = ("--scale-factor", "0.02 V/(deg/s)", *option)
    status, out, _ = call(capsys, "thermal", str(tmp_path / "log.csv"), *options, "--json")
    (error,) = json.loads(out)["errors"]
    assert status == 2
    assert words in error["what"]
    assert "[" not in error["what"]
