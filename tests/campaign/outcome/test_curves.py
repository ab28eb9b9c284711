"""Curves of results.json: units and digits, the closed loop, recordings, size, the same bytes elsewhere."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine.engine import prepare
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load
from inertialcal.campaign.outcome.results_file import find_results
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.curve import Column, Curve
from inertialcal.core.show.rows import case_name
from inertialcal.procedures.display import displayed_curve, ten_digits
from inertialcal.procedures.rate_table.readings import BINS
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.setup import Bench
from inertialcal.statistics.intervals import coverage_factor

pytestmark = pytest.mark.usefixtures("undrawn")

SMALL = Bench(rates_deg_s=(0.0, 2.0, -2.0, 4.5, -4.5, 0.0), dwell=24.0, runs=5, fit_runs=3)
MEGABYTE = 1_000_000


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a simulated campaign on recordings, run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(RIGS, "small", Rig("small", "", lambda seed, changes: rate_table.build(SMALL, seed)))
        folder = simulate("small", tmp_path_factory.mktemp("twin") / "campaign", 3).folder
    run(folder)
    return folder


@pytest.fixture(scope="module")
def results(twin: Path) -> dict[str, Any]:
    found = find_results(twin / "out")
    assert found is not None
    return found.content


def named(results: dict[str, Any], name: str, **where: str) -> list[dict[str, Any]]:
    return [
        curve
        for curve in results["curves"]
        if curve["name"] == name and all(curve[key] == value for key, value in where.items())
    ]


def values(curve: dict[str, Any], column: str) -> list[Any]:
    found: list[Any] = curve["columns"][column]["values"]
    return found


def array(curve: dict[str, Any], column: str) -> np.ndarray:
    return np.array(values(curve, column), dtype=float)


def test_a_reduced_table_has_its_dwells_and_its_errors_in_the_units_of_the_campaign(
    campaign: Callable[..., Path],
) -> None:
    found = run(campaign(), write=False).results
    (table,) = named(found, "input_output")
    (error,) = named(found, "rate_error", of="dwell_mean")
    assert {curve["name"] for curve in found["curves"]} == {"input_output", "rate_error", "linearity"}
    rows = [line.split(",") for line in (campaign() / "one.csv").read_text().splitlines()[1:]]
    assert (table["test"], table["axis"]) == ("first", "x")
    assert values(table, "applied") == [float(row[0]) for row in rows]
    np.testing.assert_allclose(array(table, "reading"), [float(row[1]) for row in rows], rtol=1e-14)
    assert values(table, "group") == [row[3] for row in rows]
    assert values(table, "run") == [row[4] for row in rows]
    assert values(table, "place")[0] == "one.csv:2"
    assert {name: column["unit"] for name, column in table["columns"].items()} == {
        "applied": "deg/s", "reading": "deg/s", "residual": "deg/s", "run": "", "group": "", "used": "", "reason": "",
        "place": "",
    }  # fmt: skip
    assert {name: column["unit"] for name, column in error["columns"].items()} == {
        "rate": "deg/s", "error": "%", "u": "%", "dof": "", "lo": "%", "hi": "%",
    }  # fmt: skip
    assert values(error, "rate") == [-4.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 4.0]
    half = [coverage_factor(dof) * u for dof, u in zip(values(error, "dof"), values(error, "u"), strict=True)]
    np.testing.assert_allclose(array(error, "lo"), array(error, "error") - half, rtol=1e-9)
    np.testing.assert_allclose(array(error, "hi"), array(error, "error") + half, rtol=1e-9)


def test_residuals_follow_from_the_rows_of_the_results(campaign: Callable[..., Path]) -> None:
    found = run(campaign(("zero_reference = true", "zero_reference = false")), write=False).results
    (table,) = named(found, "input_output")
    row = {one["quantity"]: one["value"] for one in found["results"] if not case_name(one) and one["axis"] == "x"}
    x, gain = array(table, "applied"), 1.0 + row["scale_factor_error"] / 100.0
    bend = 0.5 * row["scale_factor_asymmetry"] / 100.0 * abs(gain)
    by_hand = array(table, "reading") - (row["bias"] + gain * x + bend * np.abs(x))
    np.testing.assert_allclose(array(table, "residual"), by_hand, atol=1e-12)


def test_dwells_left_out_have_the_counts_of_the_remarks_and_exclusions(campaign: Callable[..., Path]) -> None:
    found = run(campaign(('"-10 deg/s", "10 deg/s"', '"-10 deg/s", "4 deg/s"')), write=False).results
    (table,) = named(found, "input_output")
    count = next(remark["count"] for remark in found["remarks"] if remark["code"] == "at_rail")
    assert values(table, "reason").count("at_rail") == values(table, "used").count(False) == count > 0
    assert len(found["exclusions"]) == count
    left_out = [p for p, used in zip(values(table, "place"), values(table, "used"), strict=True) if not used]
    assert [row["place"] for row in found["exclusions"]] == left_out


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_compensated_errors_have_the_rms_of_the_closed_loop(results: dict[str, Any], axis: str) -> None:
    (curve,) = named(results, "compensated", axis=axis, test="model")
    loop = next(one for one in results["closed_loop"]["axes"] if one["axis"] == axis)
    raw, after = array(curve, "raw_error"), array(curve, "compensated_error")
    assert len(raw) == loop["dwells"]
    assert len(set(values(curve, "run"))) == loop["runs"] == 2
    assert np.sqrt(np.mean(raw**2)) == pytest.approx(loop["raw_rms"], rel=1e-12)
    assert np.sqrt(np.mean(after**2)) == pytest.approx(loop["compensated_rms"], rel=1e-12)
    assert np.mean(raw**2) - np.mean(after**2) == pytest.approx(loop["mean_square_gain"], rel=1e-9)
    (table,) = named(results, "input_output", axis=axis, test="check")
    read = array(curve, "applied") + raw
    assert all(np.min(np.abs(read - reading)) < 1e-9 for reading in values(table, "reading"))


def test_each_recording_has_its_channels_and_its_dwells(twin: Path, results: dict[str, Any]) -> None:
    for number, test in enumerate(load(twin).file.tests):
        traces = prepare(load(twin), number).readings.traces
        assert [one.recording for one in traces] == test.recordings
        for one in traces:
            found = named(results, "trace", test=test.id, recording=one.recording)
            assert [curve["axis"] for curve in found] == ["x", "y", "z"]
            assert all(len(values(curve, "time")) <= BINS for curve in found)
            (dwells,) = named(results, "dwells", recording=one.recording)
            assert dwells["axis"] == one.recording[0]
            assert values(dwells, "applied") == [0.0, 2.0, -2.0, 4.5, -4.5, 0.0]
            own = next(curve for curve in found if curve["axis"] == dwells["axis"])
            time, lo, hi = (array(own, name) for name in ("time", "lo", "hi"))
            for start, stop, level in zip(*(values(dwells, c) for c in ("start", "stop", "level")), strict=True):
                inside = (time >= start) & (time <= stop)
                assert np.nanmin(lo[inside]) < level < np.nanmax(hi[inside])


def test_results_of_a_copy_elsewhere_are_the_same_bytes_and_not_large(twin: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(twin, tmp_path / "else" / "where")
    shutil.rmtree(copy / "out")
    run(copy)
    for name in ("results.json", "curves.parquet", "results.csv"):
        first, second = ((folder / "out" / name).read_bytes() for folder in (twin, copy))
        assert first == second
        assert len(first) < 2 * MEGABYTE


def test_curves_of_the_file_are_those_of_the_run(results: dict[str, Any], twin: Path) -> None:
    assert results["curves"] == run(twin, write=False).results["curves"]


def test_every_curve_and_column_is_in_the_manual(results: dict[str, Any]) -> None:
    page = (Path(__file__).resolve().parents[3] / "docs" / "results.md").read_text(encoding="utf-8")
    columns = {(curve["name"], column) for curve in results["curves"] for column in curve["columns"]}
    assert {name for name, _ in columns} == {
        "input_output",
        "rate_error",
        "linearity",
        "trace",
        "save_intervals",
        "dwells",
        "compensated",
    }
    for name, column in columns:
        row = next(line for line in page.splitlines() if line.startswith(f"| `{name}` |"))
        assert f"`{column}`" in row, (name, column)


def test_rates_have_ten_digits_and_relative_errors_are_percent() -> None:
    curve = Curve(
        "rate_error",
        "x",
        {
            "rate": Column(np.radians([3.0, 0.1]), "rad/s"),
            "error": Column([0.01, None], "1"),
            "dof": Column([5.0, None]),
        },
    )
    shown = displayed_curve(curve, "deg/s").to_dict("t")["columns"]
    assert shown["rate"] == {"unit": "deg/s", "values": [3.0, 0.1]}
    assert shown["error"] == {"unit": "%", "values": [1.0, None]}
    assert shown["dof"] == {"unit": "", "values": [5.0, None]}
    assert ten_digits(1.00000000049) == 1.0
