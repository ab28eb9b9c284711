"""Every figure that campaigns print stands by one rounding rule."""

from __future__ import annotations

import re

from inertialcal.campaign.outcome.tables import outcome_parts
from inertialcal.cli.shown.summary import closed_loop_text, results_text, verdicts_text
from inertialcal.core.show.tables import text
from ran_campaigns import Ran

NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?"
FIGURE = re.compile(rf"(?P<open>\()?(?P<value>{NUMBER}) ± (?P<u>{NUMBER})(?(open)\)(?P<power>e[+-]\d+))")
LINE = re.compile(
    FIGURE.pattern + rf"  +\S+  +\(?(?P<lo>{NUMBER}) \.\. (?P<hi>{NUMBER})(?(open)\)(?P<of_ends>e[+-]\d+))"
)


def places(number: str) -> int:
    return len(number.partition(".")[2])


def test_printed_figures(campaign_ran: Ran) -> None:
    results = campaign_ran.results
    printed = [
        results_text(results),
        closed_loop_text(results),
        verdicts_text(results) if results["verdicts"] else "",
        text(outcome_parts(results, "", [])),
    ]
    whole = "\n".join(printed)
    figures = list(FIGURE.finditer(whole))
    assert len(figures) == whole.count(" ± ") - whole.count("value ± u")
    for one in figures:
        digits = one["u"].replace(".", "").lstrip("0")
        assert len(digits) == 2, one[0]
        assert places(one["value"]) == places(one["u"]), one[0]
    rows = list(LINE.finditer(whole))
    assert len(rows) >= 10
    for one in rows:
        assert one["power"] == one["of_ends"], one[0]
        assert places(one["lo"]) == places(one["hi"]) in {places(one["u"]), places(one["u"]) + 1}, one[0]
