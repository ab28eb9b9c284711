"""An item on a shaker: its modes are found, each mistake is named, a crack fails, a sound campaign is silent."""

from __future__ import annotations

import numpy as np
import pytest

from fitted_results import fit_results
from inertialcal.campaign.twins.score import coverage
from inertialcal.procedures.sine_survey.against import change_rows
from inertialcal.rigs.shaker import rig as shaker
from inertialcal.rigs.shaker.motion import Item
from inertialcal.rigs.shaker.rig import build, small
from inertialcal.rigs.shaker.setup import Bench
from inertialcal.rigs.twin import Twin
from inertialcal.statistics.intervals import covers
from sized import sized

SMALL = small(Bench())


def codes(twin: Twin) -> set[str]:
    """Codes of remarks and reasons of both surveys."""
    results = fit_results(twin)
    return {one.code for result in results for one in result.remarks} | {
        row.reason.code for result in results for row in result.rows()
    }


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
