"""Levels of pressure over decades: bias and noise of each, what is constant, a pump, and what breaks it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from independent.warm.pressure import Chamber, pumped
from inertialcal.core.key import Key
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.results import Row
from inertialcal.procedures.sensitivity.levels import PressureLevels, pressure_levels
from inertialcal.procedures.sensitivity.readings import ConditionRecording
from inertialcal.statistics.intervals import contains, covers
from sized import sized

PLAIN = Chamber()
THERE = ("x", "temperature", "pressure", "pump")


def levels_of(seed: int, truth: Chamber) -> PressureLevels | None:
    recorded = []
    for r, one in enumerate(pumped(seed, truth)):
        channels = (Channel("x", one["x"], unit="deg/s"),)
        recording = Recording(channels, source=Source(f"run{r}"), time_ns=np.round(one["time"] * 1e9).astype(np.int64))
        conditions = {name: {"x": one[name]} for name in ("temperature", "pressure", "pump")}
        units = {"temperature": "degC", "pressure": "Pa", "pump": "1"}
        recorded.append(ConditionRecording(recording, conditions, units, f"run{r}", f"run{r}"))
    return pressure_levels(recorded, ("x",), "deg/s")


def rows_of(seed: int, truth: Chamber) -> list[Row]:
    found = levels_of(seed, truth)
    assert found is not None
    return list(found.rows())


def codes(seed: int, truth: Chamber) -> set[str]:
    found = levels_of(seed, truth)
    assert found is not None
    return {one.code for one in found.remarks}


def at_levels(rows: list[Row], quantity: str) -> list[Row]:
    return [row for row in rows if row.key.quantity == quantity and row.key.at is not None]


def test_each_level_is_found_with_its_pressure_and_change() -> None:
    rows = rows_of(1, PLAIN)
    places = [row.key.at.value for row in at_levels(rows, "bias") if row.key.at is not None]
    assert places == pytest.approx(PLAIN.pressures, rel=0.05)
    changes = [row.value for row in at_levels(rows, "bias_change")]
    assert changes == pytest.approx(PLAIN.effects[1:], abs=1e-3)


def test_without_noise_changes_are_exact() -> None:
    rows = rows_of(1, replace(PLAIN, noise=1e-12, scatter=0.0))
    assert [row.value for row in at_levels(rows, "bias_change")] == pytest.approx(PLAIN.effects[1:], abs=1e-9)


def test_the_bias_is_constant_below_the_level_where_it_changes() -> None:
    rows = {row.key: row for row in rows_of(1, PLAIN)}
    below, bound = rows[Key("pressure_constant_below", "x")], rows[Key("bias_change_below", "x")]
    assert below.value == pytest.approx(0.1, rel=0.1)
    assert bound.status == "upper_limit"
    assert bound.value is not None
    assert bound.value < 2e-3
    differ = {row.key: row for row in rows_of(1, replace(PLAIN, effects=(0.0, 0.01, 0.02, 0.03, 0.04)))}
    assert differ[Key("pressure_constant_below", "x")].reason.code == "not_constant"


def test_noise_of_a_level_and_of_the_pump() -> None:
    rows = rows_of(1, replace(PLAIN, pump=1.5))
    stds = [row.value for row in at_levels(rows, "scatter_sample")]
    assert stds == pytest.approx([0.006] * 3 + [0.004] * 2, rel=0.05)
    (ratio,) = [row for row in rows if row.key.quantity == "pump_noise_ratio"]
    assert ratio.interval is not None
    assert contains(ratio.interval, 1.5)
    assert not contains(ratio.interval, 1.0)


def test_within_one_decade_there_are_no_levels() -> None:
    assert levels_of(1, replace(PLAIN, pressures=(9e4, 9.5e4, 1e5, 1.05e5, 1.1e5))) is None


def test_a_pump_down_in_one_order_is_remarked() -> None:
    assert "one_order" in codes(1, replace(PLAIN, order=(4, 3, 2, 1, 0), drift=1e-6))
    assert "one_order" not in codes(1, PLAIN)


def test_a_unit_that_warms_without_air_is_remarked() -> None:
    assert "temperature_follows" in codes(1, replace(PLAIN, warms=8.0, slope=1e-3))
    assert "temperature_follows" not in codes(1, PLAIN)


def test_a_gauge_at_its_end_of_scale_is_remarked() -> None:
    assert "gauge_floor" in codes(1, replace(PLAIN, floor=1e-2))


def test_the_command_reads_levels(tmp_path: Path) -> None:
    files = []
    for r, one in enumerate(pumped(1, PLAIN)):
        files.append(tmp_path / f"run{r}.csv")
        head = "time [s],gyro_x [deg/s],temperature [degC],pressure [Pa],pump"
        columns = np.column_stack([one[name] for name in ("time", "x", "temperature", "pressure", "pump")])
        np.savetxt(files[-1], columns, "%.9g", ",", header=head, comments="")
    rows = list(ic.sensitivity(files, to=["pressure", "pump"]).rows)
    assert [row.value for row in at_levels(rows, "bias_change")] == pytest.approx(PLAIN.effects[1:], abs=1e-3)
    assert any(row.key.quantity == "pump_noise_ratio" for row in rows)


def held(truth: Chamber, n: int) -> tuple[Counter[str], Counter[str]]:
    hits: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    for seed in range(1, n + 1):
        rows = rows_of(seed, truth)
        true = {"bias_change": truth.effects[1:], "bias": [0.01 + one for one in truth.effects]}
        true["scatter_sample"] = [truth.noise * (truth.pump if p < 1.0 else 1.0) for p in truth.pressures]
        for quantity, values in true.items():
            for i, (row, value) in enumerate(zip(at_levels(rows, quantity), values, strict=True)):
                assert row.interval is not None
                counts[f"{quantity} {i}"] += 1
                hits[f"{quantity} {i}"] += contains(row.interval, value)
        for row in rows:
            if row.key.quantity == "pump_noise_ratio" and row.interval is not None:
                counts["ratio"] += 1
                hits["ratio"] += contains(row.interval, truth.pump)
    return hits, counts


def test_intervals_hold_the_truth() -> None:
    hits, counts = held(replace(PLAIN, pump=1.1, dwell=200.0), 12)
    assert all(covers(hits[name], counts[name]) for name in counts), hits


@pytest.mark.slow
@pytest.mark.parametrize("truth", [
    replace(PLAIN, pump=1.1), replace(PLAIN, walk=5e-5), replace(PLAIN, scatter=2e-3),
    replace(PLAIN, warms=8.0, slope=1e-3), replace(PLAIN, runs=3),
], ids=["plain", "walk", "scatter", "warms", "three"])  # fmt: skip
def test_intervals_hold_the_truth_of_many(truth: Chamber) -> None:
    n = sized(60, 25)
    hits, counts = held(truth, n)
    if truth.walk:  # the walk inside a block counts as noise of a sample
        hits = Counter({name: one for name, one in hits.items() if name.startswith("bias")})
    assert all(covers(hits[name], counts[name]) for name in hits), (hits, counts)
