"""An item on a shaker: its modes are found, each mistake is named, a crack fails, a sound campaign is silent."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fitted_results import fit_results
from inertialcal.campaign.calls.call import campaign_of
from inertialcal.campaign.engine.whole import reduce_campaign
from inertialcal.campaign.inputs.sources import Memory
from inertialcal.campaign.twins.score import coverage
from inertialcal.core.show.requirement_lines import requirement_lines
from inertialcal.procedures.sine_survey.against import change_rows
from inertialcal.procedures.vibration.profile_file import read_profile
from inertialcal.rigs.shaker import rig as shaker
from inertialcal.rigs.shaker.motion import Item, random_drive
from inertialcal.rigs.shaker.rig import build, small
from inertialcal.rigs.shaker.setup import Bench
from inertialcal.rigs.twin import SEED, Twin
from inertialcal.statistics.intervals import covers
from sized import sized

SMALL = small(Bench())
SHORT = replace(Bench(), start=800.0, stop=900.0)  # surveys that nobody judges
RUN_ALONE = replace(SHORT, power_ups=0)
AT_REST = replace(SHORT, full_level=0.0)


def codes(twin: Twin) -> set[str]:
    """Codes of remarks and reasons of both surveys."""
    results = fit_results(twin)
    return {one.code for result in results for one in result.remarks} | {
        row.reason.code for result in results for row in result.rows()
    }


def verdicts(twin: Twin, folder: Path) -> dict[str, str]:
    """Verdicts of a campaign by requirement, but those on surveys."""
    document = tomllib.loads(twin.campaign.replace(SEED, "1"))
    document["tests"] = [one for one in document["tests"] if one["procedure"] != "sine_survey"]
    ids = {one["id"] for one in document["tests"]}
    document["requirements"] = [one for one in document["requirements"] if ids & set(one["tests"])]
    profiles = {}
    for file, extra in twin.extras.items():
        (folder / file).write_text(extra.text)
        profiles[file] = read_profile(folder / file)
    store = Memory(twin.recordings, profiles)
    whole = reduce_campaign(campaign_of(document), store)
    return {one.requirement: one.verdict for one in requirement_lines(whole.results)}


NAMED = [name for name, one in shaker.FAULTS.items() if one.shows]
QUICK = ("clipped_drive", "loose_fixture")


@pytest.mark.parametrize(
    "fault", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in NAMED]
)
def test_every_mistake_is_named(fault: str) -> None:
    one = shaker.FAULTS[fault]
    assert set(one.codes) & codes(build(one.put_into(SMALL), 2))


def test_without_a_mistake_nothing_is_wrong() -> None:
    assert not codes(build(SMALL, 2)) & {code for one in shaker.FAULTS.values() for code in one.codes}


def test_a_crack_is_a_change_beyond_what_is_allowed() -> None:
    twin = build(shaker.FAULTS["cracked"].put_into(SMALL), 1)
    before, after = fit_results(twin)
    rows = change_rows(after, before, "before")
    (first,) = [row for row in rows if row.quantity == "resonance_frequency_change" and row.axis == "x"
                and row.key.at is not None and row.key.at.value == 1.0]  # fmt: skip
    assert first.interval is not None
    assert first.interval.hi is not None
    assert first.interval.hi < -0.05


CAUGHT = (
    ("bias_shift", AT_REST, {"R5": "FAIL", "R6": "PASS", "R7": "FAIL", "R8": "PASS"}),
    ("scale_shift", AT_REST, {"R5": "PASS", "R6": "PASS", "R7": "PASS", "R8": "FAIL"}),
    ("noisier", AT_REST, {"R5": "PASS", "R6": "FAIL", "R7": "PASS", "R8": "PASS"}),
    ("run_high", RUN_ALONE, {"R3": "FAIL"}),
    ("notch_missing", RUN_ALONE, {"R4": "FAIL"}),
)


@pytest.mark.parametrize(
    ("fault", "bench", "caught"),
    [pytest.param(*case, marks=() if case[0] == "scale_shift" else pytest.mark.slow) for case in CAUGHT],
)
def test_what_no_remark_names_fails_its_requirement(
    tmp_path: Path, fault: str, bench: Bench, caught: dict[str, str]
) -> None:
    found = verdicts(build(shaker.FAULTS[fault].put_into(bench), 1), tmp_path)
    assert {name: found[name].split()[0] for name in caught} == caught


def test_every_fault_is_named_or_fails() -> None:
    assert {name for name, one in shaker.FAULTS.items() if not one.codes} == {"cracked", *(name for name, *_ in CAUGHT)}


@pytest.mark.slow
def test_a_sound_run_passes(tmp_path: Path) -> None:
    assert set(verdicts(build(SHORT, 1), tmp_path).values()) == {"PASS"}


def test_the_run_follows_its_profile_and_the_fault_has_no_notch() -> None:
    tables = {}
    for notched in (True, False):
        bench = replace(Bench(), notched=notched, unevenness_db=0.0)
        tables[notched] = random_drive(bench, np.random.default_rng(1))
    n = len(tables[True])
    frequency = np.arange(n // 2 + 1) * Bench().sample_rate / n
    power = {name: np.abs(np.fft.rfft(table)) ** 2 for name, table in tables.items()}
    inside, below = (frequency > 134.0) & (frequency < 152.0), (frequency > 60.0) & (frequency < 110.0)
    for where, expected in ((inside, 0.25), (below, 1.0)):
        # the same draws: what differs is the profile alone, 0.01 for 0.04
        assert power[True][where].sum() / power[False][where].sum() == pytest.approx(expected, rel=0.02)


def test_an_item_is_one_where_it_follows_the_table() -> None:
    item = Item(np.array([[700.0, 20.0, 0.4, 0.1]]))
    still = item.transmissibility(np.array([1e-3]))
    assert abs(still[0]) == pytest.approx(1.0, rel=1e-6)
    assert abs(item.transmissibility(np.array([1e-3]), across=True)[0]) == pytest.approx(0.1, rel=1e-6)


@pytest.mark.slow
def test_intervals_hold_the_truth() -> None:
    held = coverage(lambda seed: build(SMALL, seed), sized(300, 12))
    assert held
    for one in held:
        assert covers(one.hits, one.n, 0.93), one
