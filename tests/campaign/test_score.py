"""Score: the truth beside the estimates, and how often the stated intervals hold it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.score import Coverage, Score, coverage, score, score_rig
from inertialcal.campaign.twins.standards import apart
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import DataError, PlanError, UsageError
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key
from inertialcal.core.show.rows import case_name
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.rate_table import rig as rate_table
from inertialcal.rigs.rate_table.setup import Bench, draw_gyro
from inertialcal.rigs.twin import DrawnError, Twin
from inertialcal.statistics.intervals import covers
from sized import sized
from written_rows import sealed_text

pytestmark = pytest.mark.usefixtures("undrawn")

# Standards about as uncertain as the scatter lets the estimates be: either kind alone would be seen to fail.
BALANCED = {
    "rate_table.rate": Influence(1e-4),
    "rate_table.mounting": Influence(7e-5, "rad"),
    "converter.reference": Influence(5e-5, distribution="rectangular"),
    "site.latitude": Influence(1e-4, "rad"),
}
BENCH = Bench(rates_deg_s=(0.0, 1.0, -1.0, 4.5, -4.5, 0.0), dwell=30.0, runs=5, standards=BALANCED)
ENTRIES = {f"{a}{b}" for a in "xyz" for b in "xyz" if a != b}
WALK = 3e-6  # [rad/s/sqrt(s)]; 1e-4 rad/s in 20 min, as much as the run-to-run bias


@pytest.fixture(scope="module")
def scored(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A simulated campaign that was run."""
    with pytest.MonkeyPatch.context() as patch:
        rig = Rig("small", "", lambda seed, changes: rate_table.build(BENCH, seed))
        patch.setitem(RIGS, "small", rig)
        folder = simulate("small", tmp_path_factory.mktemp("score") / "campaign", 2).folder
        run(folder)
        yield folder


def test_score_sets_the_truth_beside_every_estimate(scored: Path) -> None:
    found = score(scored)
    rows = {(row["test"], row["quantity"], row["axis"]): row for row in found.rows}
    truth = json.loads((scored / ".truth" / "truth.json").read_text())["values"]
    assert {("fit", one["quantity"], one["axis"]) for one in truth} <= set(rows)
    bias = next(one["value"] for one in truth if (one["quantity"], one["axis"]) == ("bias", "x"))
    row = rows["fit", "bias", "x"]
    assert row["unit"] == "deg/s"
    assert row["truth"] == pytest.approx(np.degrees(bias))
    for row in found.rows:
        assert row["inside"] == (row["interval"]["lo"] <= row["truth"] <= row["interval"]["hi"])
    assert found.inside == sum(row["inside"] for row in found.rows)
    assert found.estimated == len(found.rows)


def test_an_estimate_far_from_the_truth_is_outside_and_none_is_no_hit(scored: Path, tmp_path: Path) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(scored, copy)
    path = copy / "out" / "results.json"
    results = json.loads(path.read_text())
    mine = [row for row in results["results"] if row["test"] == "fit" and row["quantity"] == "bias"]
    mine[0] |= {"interval": {"lo": 7.0, "hi": 8.0, "p": 0.95}}
    mine[1] |= {
        "interval": None,
        "value": None,
        "u": None,
        "status": "not_estimated",
        "reason": {"code": "gone", "text": "gone"},
    }
    path.write_text(sealed_text(results))
    before, after = score(scored), score(copy)
    assert after.estimated == before.estimated - 1
    inside = {row["axis"]: row["inside"] for row in after.rows if (row["test"], row["quantity"]) == ("fit", "bias")}
    assert (inside["x"], inside["y"]) == (False, None)


def test_the_error_of_a_standard_is_taken_off_and_counts_once(scored: Path) -> None:
    """A table 30 uncertainties off: no scale factor holds the truth, all do apart from the table."""
    found = score(scored)
    rate = DrawnError("rate_table.rate", 30.0)
    rows = []
    for row in found.rows:
        off = 30.0 * row["shared"].get(rate.influence, 0.0)
        lo, hi = row["interval"]["lo"] + off, row["interval"]["hi"] + off
        moved = row | {"value": row["value"] + off, "interval": {"lo": lo, "hi": hi, "p": 0.95}}
        inside = bool(lo <= row["truth"] <= hi)
        rows.append(moved | {"inside": inside, "inside_apart": apart(moved, row["truth"], {rate.influence: rate})})
    far = Score(replace(found.truth, errors=(rate,)), tuple(rows))
    scale = [row for row in far.rows if row["quantity"].startswith("scale_factor") and rate.influence in row["shared"]]
    assert len(scale) >= 9
    assert not [row for row in scale if row["inside"]]
    assert far.inside_apart >= 0.9 * far.judged_apart
    assert "rate_table.rate drawn at 30.0 u: outside its 95 % interval (1 of 1)" in " ".join(str(far).split())


def test_what_is_left_of_an_interval_is_that_of_what_is_left_of_its_uncertainty() -> None:
    row: dict[str, Any] = {
        "value": 1.0, "u": 0.5, "dof": None, "interval": {"lo": 0.02, "hi": 1.98, "p": 0.95}, "shared": {"a.b": -0.4},
    }  # fmt: skip
    error = {"a.b": DrawnError("a.b", 2.0)}  # which changed the value by -0.8: 1.8 +- 0.3 is left
    assert apart(row, 1.8 - 1.95 * 0.3, error)
    assert apart(row, 1.8 - 1.97 * 0.3, error) is False
    assert apart(row, 0.1, {}) is True
    assert apart(row | {"shared": {"a.b": 0.5}}, 1.0, error) is None  # nothing but the standard


def test_an_error_of_a_standard_is_inside_the_middle_of_its_distribution() -> None:
    assert DrawnError("a.b", -1.95).inside
    assert not DrawnError("a.b", 1.97).inside
    assert not DrawnError("a.b", 1.70, "rectangular").inside


def test_other_ways_of_reduction_are_not_scored(scored: Path) -> None:
    conditions = {case_name(row) for row in json.loads((scored / "out/results.json").read_text())["results"]}
    assert "as_published" in conditions
    assert {case_name(row) for row in score(scored).rows} == {""}


def test_score_runs_what_was_not_run_and_refuses_what_is_of_another_campaign(scored: Path, tmp_path: Path) -> None:
    copy = tmp_path / "campaign"
    shutil.copytree(scored, copy, ignore=shutil.ignore_patterns("out"))
    assert [row["inside"] for row in score(copy).rows] == [row["inside"] for row in score(scored).rows]
    assert not (copy / "out").exists()
    (copy / "out").mkdir()
    results = json.loads((scored / "out/results.json").read_text())
    results["campaign"]["source"] = "another"
    (copy / "out/results.json").write_text(sealed_text(results))
    with pytest.raises(DataError, match="of another campaign"):
        score(copy)
    with pytest.raises(PlanError, match="No campaign here"):
        score(tmp_path)


def test_coverage_counts_hits_and_what_is_missing() -> None:
    assert Coverage(Key("bias", "x"), 285, 300, 0).verdict == "PASS"
    assert Coverage(Key("bias", "x"), 240, 300, 0).verdict == "FAIL"
    assert Coverage(Key("bias", "x"), 300, 300, 0).verdict == "PASS"  # intervals wider than need be
    nothing = Coverage(Key("bias", "x"), 0, 0, 300)
    assert (nothing.verdict, nothing.rate, nothing.to_dict()["interval"]) == ("FAIL", None, None)


def test_wrong_truth_is_seen() -> None:
    """A unit whose truth is told with a bias of the wrong sign fails the count."""

    def lying(seed: int) -> Twin:
        twin = rate_table.build(BENCH, seed)
        return replace(twin, truth=tuple(replace(t, value=-t.value) for t in twin.truth))

    zero = ("second_order", "third_order")  # with either sign
    verdicts = {one.key: one.verdict for one in coverage(lying, 5) if one.key.quantity not in zero}
    assert set(verdicts.values()) == {"FAIL"}


def test_a_quantity_that_is_not_estimated_is_missing() -> None:
    found = coverage(lambda seed: rate_table.RIG.twin(seed, "only_positive"), 2)
    assert not [one for one in found if one.key.quantity == "scale_factor_asymmetry"]


def test_seeds_follow_the_first_and_progress_is_told() -> None:
    told: list[tuple[int, int, str]] = []
    seeds: list[int] = []

    def make(seed: int) -> Twin:
        seeds.append(seed)
        return rate_table.build(BENCH, seed)

    coverage(make, 3, 11, lambda done, total, what: told.append((done, total, what)))
    assert seeds == [11, 12, 13]
    assert told == [(0, 3, "seed 11"), (1, 3, "seed 12"), (2, 3, "seed 13"), (3, 3, "done")]


def test_score_rig_refuses_what_it_cannot_count() -> None:
    with pytest.raises(UsageError, match=r"no rig 'nothing'"):
        score_rig("nothing", 3)
    with pytest.raises(UsageError, match="0 campaigns from seed 1: need 1 or more"):
        score_rig("rate_table", 0)


KNOWN = 0.93  # of 1,000 campaigns of this bench 924 (bias y) to 975 (asymmetry z) hold it: a little too narrow


def failures(found: tuple[Coverage, ...]) -> dict[str, Any]:
    entries = {one.key.axis for one in found if one.key.quantity == "misalignment"}
    assert entries == ENTRIES
    assert {one.key.quantity for one in found} >= {"bias", "scale_factor_error", "cross_axis_sensitivity"}
    return {str(one.key): (one.hits, one.n) for one in found if not covers(one.hits, one.n, KNOWN)}


@pytest.mark.parametrize("n", [8, pytest.param(sized(1000, 100), marks=pytest.mark.slow)])
def test_coverage_of_the_rig(n: int) -> None:
    """Bias and all nine matrix entries; earth rate, tilt, and scatter at every level (DESIGN, coverage)."""
    assert not failures(coverage(lambda seed: rate_table.build(BENCH, seed), n))


@pytest.mark.slow
def test_coverage_with_balanced_standards_long() -> None:
    bench = replace(BENCH, u_tilt_deg=3.0)

    def make(seed: int) -> Twin:
        unit = draw_gyro(bench.inverted, np.random.default_rng([seed, 1]))
        return rate_table.build(bench, seed, replace(unit, walk=WALK))

    assert not failures(coverage(make, sized(1000, 100)))
