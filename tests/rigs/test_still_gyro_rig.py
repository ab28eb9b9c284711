"""A gyro that stands still: its noise is what the truth says, and each mistake is named by the reduction."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fitted_results import fit_results
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.score import coverage
from inertialcal.campaign.twins.twin import csv_text
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.show.rows import case_name
from inertialcal.core.units import factor
from inertialcal.rigs.still_gyro import rig as still_gyro
from inertialcal.rigs.still_gyro.rig import Bench, build
from inertialcal.rigs.twin import SEAL, SEED, Twin
from sized import sized

SMALL = Bench(records=1, samples=3_000, skipped=0.0)


def found(twin: Twin) -> set[str]:
    """Codes of the remarks and reasons, or of the refusal."""
    try:
        (result,) = fit_results(twin)
    except DataError as error:
        return {problem.code for problem in error.problems}
    return {one.code for one in result.remarks} | {row.reason.code for row in result.rows()}


@pytest.mark.parametrize("fault", still_gyro.FAULTS)
def test_every_mistake_is_named(fault: str) -> None:
    bench = still_gyro.FAULTS[fault].put_into(SMALL)
    assert still_gyro.FAULTS[fault].shows in found(build(bench, 3))


def test_without_a_mistake_nothing_is_wrong() -> None:
    codes = found(build(replace(SMALL, rate_walk=1e-12), 3))  # a random walk may pass for a warm-up
    assert not codes & {fault.shows for fault in still_gyro.FAULTS.values()}


def test_a_mistake_that_is_not_known_is_refused() -> None:
    with pytest.raises(UsageError, match=r"no fault 'rain'.*There are: knocked"):
        still_gyro.RIG.twin(1, "rain")


def test_what_is_saved_has_the_scatter_of_the_truth_and_the_dead_time() -> None:
    twin = build(SMALL, 1)
    (recording,) = twin.recordings.values()
    truth = {(one.quantity, one.axis): one.value for one in twin.truth}
    scale = 1.0 + float(np.asarray(twin.drawn["scale_factor_error"]))
    x = np.radians(recording.channel("x").data)
    assert np.std(x) == pytest.approx(scale * truth["angle_random_walk", "x"], rel=0.05)  # means over 1 s
    assert recording.time_ns is not None
    assert set(np.diff(recording.time_ns).tolist()) == {2_000_000_000}
    assert twin.campaign.count('averaging = "1 s"') == 1


def test_the_same_seed_gives_the_same_record() -> None:
    one, other = (build(SMALL, 5).recordings["recordings/still1.csv"].channel("z").data for _ in range(2))
    assert np.array_equal(one, other)
    assert not np.array_equal(one, build(SMALL, 6).recordings["recordings/still1.csv"].channel("z").data)


def test_files_give_the_figures_of_what_is_in_memory(tmp_path: Path) -> None:
    twin = build(SMALL, 4)
    (tmp_path / "recordings").mkdir()
    for file, recording in twin.recordings.items():
        (tmp_path / file).write_text(csv_text(recording), encoding="utf-8")
    (tmp_path / "campaign.toml").write_text(twin.campaign.replace(SEED, "4").replace(SEAL, "none"), encoding="utf-8")
    files = {(r["quantity"], r["axis"], case_name(r)): r for r in run(tmp_path, write=False).results["results"]}
    (result,) = fit_results(twin)
    (axis,) = [one for one in result.rows() if (one.quantity, one.axis) == ("angle_random_walk", "x")]
    shown = files["angle_random_walk", "x", ""]
    times = factor(axis.unit, shown["unit"])
    assert shown["value"] == pytest.approx((axis.value or 0.0) * times, rel=1e-9)
    assert shown["u"] == pytest.approx((axis.u or 0.0) * times, rel=1e-9)


@pytest.mark.slow
def test_the_stated_intervals_hold_the_truth() -> None:
    bench = replace(SMALL, samples=2_000)
    for one in coverage(lambda seed: build(bench, seed), sized(100, 40)):
        assert one.verdict == "PASS", (one.key, one.hits, one.n)
