"""Margins by hand, and their sign is the verdict."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.outcome.requirements import margin
from inertialcal.core.results import Interval
from inertialcal.statistics.decision import decide
from ran_campaigns import Ran

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.mark.parametrize(
    ("interval", "lower", "upper", "wanted"),
    [
        ((1.0, 2.0), -5.0, 5.0, 3.0),
        ((-4.0, 2.0), -5.0, 5.0, 1.0),
        ((1.0, 2.0), 0.5, None, 0.5),
        ((1.0, 5.0), None, 5.0, 0.0),
        ((4.0, 7.0), -5.0, 5.0, -2.0),  # across the upper limit
        ((-9.0, 6.0), -5.0, 5.0, -4.0),  # beyond both
        ((6.0, 8.0), -5.0, 5.0, -1.0),  # wholly outside: its nearest end
        ((-8.0, -6.0), -5.0, 5.0, -1.0),
        ((None, 2.0), None, 5.0, 3.0),
        ((None, 2.0), -5.0, 5.0, None),
        ((1.0, 2.0), None, None, None),
    ],
)
def test_margins_by_hand(
    interval: tuple[float | None, float | None], lower: float | None, upper: float | None, wanted: float | None
) -> None:
    assert margin(Interval(*interval), lower, upper) == wanted


def test_without_an_interval_there_is_no_margin() -> None:
    assert margin(None, -1.0, 1.0) is None


@given(st.floats(-10, 10), st.floats(0.01, 5), st.floats(-10, 0), st.floats(0.1, 10))
def test_a_positive_margin_is_a_pass(value: float, u: float, lower: float, width: float) -> None:
    found = decide(value, u, np.inf, lower, lower + width)
    m = margin(found.interval, lower, lower + width)
    assert m is not None
    assert (m > 0.0) == (found.status == "PASS") or m == 0.0


def test_every_verdict_of_the_published_campaign_has_its_margin(published: Ran) -> None:
    rows = published.results["verdicts"]
    for row in rows:
        assert (row["margin"] is None) == (row["interval"] is None)
        if row["margin"] is not None:
            assert (row["margin"] > 0.0) == (row["verdict"] == "PASS")
    judged = next(row for row in rows if row["interval"] is not None)
    near = min(judged["interval"]["lo"] - judged["lower"], judged["upper"] - judged["interval"]["hi"])
    assert judged["margin"] == pytest.approx(near, rel=1e-12)


def test_margins_stand_in_the_table_of_verdicts(published: Ran) -> None:
    results = run(published.folder).results
    with (published.folder / "out" / "verdicts.csv").open(encoding="utf-8") as handle:
        cells = [row["margin"] for row in csv.DictReader(handle)]
    assert cells == ["" if row["margin"] is None else repr(row["margin"]) for row in results["verdicts"]]
