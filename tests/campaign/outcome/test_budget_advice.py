"""What must improve to reach a wanted uncertainty: by closed form, and by a second run with what is advised."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.outcome.budget import MOST, Budgeted, advice, budget, budgeted, deciding_u
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.results import Interval
from inertialcal.statistics.decision import decide

Write = Callable[..., Path]
WANTED = "scale_factor_error=0.02 %"


def source(u: float, kind: str = "B", stated: float | None = None, level: str = "run") -> dict[str, Any]:
    named = {"source": "table rate", "influence": "rate_table.rate", "level": ""}
    scatter = {"source": "scatter between runs", "influence": "", "level": level}
    own = {"stated_u": stated or u, "stated_unit": "%", "u": u, "unit": "%", "kind": kind}
    return (named if kind == "B" else scatter) | own


@pytest.mark.parametrize(
    ("level", "noun"), [("run", "runs"), ("between_runs", "runs"), ("within_runs", "runs"), ("", "repeats")]
)
def test_scatter_is_reduced_by_more_of_what_was_repeated(level: str, noun: str) -> None:
    found = advice([source(0.4, "A", level=level)], 0.2, "%")
    assert str(found) == f"scatter between runs: 4 times as many {noun} would suffice"


def test_one_standard_goes_to_what_the_rest_leaves() -> None:
    found = advice([source(0.4, stated=0.8), source(0.3, "A")], 0.35, "%")
    assert found.u == pytest.approx(0.5)
    to = math.sqrt(0.35**2 - 0.3**2)
    (one,) = found.alone
    assert (one.u_from, one.u_to) == pytest.approx((0.8, 0.8 * to / 0.4))
    assert str(found) == "rate_table.rate from 0.80 to 0.36 % would suffice"


def test_either_of_two_suffices_alone() -> None:
    found = advice([source(0.4), source(0.39, "A")], 0.5, "%")
    assert [one.influence for one in found.alone] == ["rate_table.rate", ""]
    assert "; or scatter between runs: 1.7 times as many runs would suffice" in str(found)


def test_scatter_that_no_standard_makes_good_is_named() -> None:
    found = advice([source(0.4), source(0.3, "A")], 0.25, "%")
    assert found.alone == ()
    assert [one.influence for one in found.together] == ["rate_table.rate", ""]
    assert str(found) == (
        "no better standard would suffice, scatter alone gives 0.30 %; no source would suffice alone:"
        " rate_table.rate from 0.40 to 0.20 % and scatter between runs: 4 times as many runs"
    )


def test_what_is_reached_or_out_of_reach_says_so() -> None:
    assert str(advice([source(0.1)], 0.2, "%")) == "reached"
    assert str(advice([source(1.0, "A")], 0.01, "%")) == "100 times smaller than now"


@given(st.lists(st.floats(1e-3, 10.0), min_size=1, max_size=6), st.floats(1e-3, 10.0))
def test_what_is_advised_reaches_what_is_wanted(sizes: list[float], wanted: float) -> None:
    """Each source that suffices alone, or all together, changed as advised: u is then as wanted."""
    sources = [source(u, "AB"[i % 2]) | {"influence": f"s.{i}"} for i, u in enumerate(sizes)]
    found = advice(sources, wanted, "%")
    total = math.sqrt(math.fsum(u**2 for u in sizes))
    assert found.reached == (total <= wanted)
    for changes in [*([one] for one in found.alone), *([found.together] if found.together else [])]:
        by = {one.influence: one.u_to for one in changes}
        assert math.sqrt(math.fsum(by.get(f"s.{i}", u) ** 2 for i, u in enumerate(sizes))) == pytest.approx(wanted)
    if not (found.reached or found.alone or found.together):
        assert total > MOST * wanted * (1.0 - 1e-12)


@pytest.mark.parametrize(
    ("value", "lower", "upper"), [(0.7, -1.0, 1.0), (0.7, None, 1.0), (1.2, None, 1.0), (0.4, 0.2, None)]
)
def test_the_u_that_decides_decides(value: float, lower: float | None, upper: float | None) -> None:
    found = decide(value, 0.3, 6.0, lower, upper)
    assert found.status == "INCONCLUSIVE"
    u = deciding_u(value, 0.3, found.basis.compared, lower, upper)
    assert u is not None
    assert decide(value, 0.999 * u, 6.0, lower, upper).status in ("PASS", "FAIL")
    assert decide(value, 1.001 * u, 6.0, lower, upper).status == "INCONCLUSIVE"


def test_on_a_limit_no_u_decides() -> None:
    assert deciding_u(1.0, 0.3, Interval(0.4, 1.6), None, 1.0) is None
    assert deciding_u(None, None, None, None, 1.0) is None


OWN = '[[requirements]]\nid = "R2"\nquantity = "scale_factor_error"\naxis = "x"\nlimit = "1.05 %"\n'


def test_a_campaign_with_the_better_standard_has_the_wanted_uncertainty(campaign: Write) -> None:
    def figure(folder: Path) -> Budgeted:
        every = budgeted(run(folder, write=False).results)
        return next(one for one in every if (one.row["test"], one.name) == ("first", "scale_factor_error x"))

    folder = campaign()
    one = figure(folder)
    assert one.certificates[0] == "C-1"
    (change,) = advice(one.sources, 0.02, "%").alone
    assert change.influence == "rate_table.rate"
    text = (folder / "campaign.toml").read_text().replace('u = "0.05 %"', f'u = "{change.u_to!r} %"')
    (folder / "campaign.toml").write_text(text)
    assert figure(folder).row["u"] == pytest.approx(0.02, rel=1e-9)


def test_a_requirement_that_is_not_decided_says_what_would(campaign: Write) -> None:
    results = run(campaign(("[[requirements]]\nid", f"{OWN}[[requirements]]\nid")), write=False).results
    (one,) = [verdict for verdict in results["verdicts"] if verdict["requirement"] == "R2"]
    assert one["verdict"] == "INCONCLUSIVE"
    assert one["deciding_u"] == pytest.approx((1.05 - one["value"]) / 1.959964, rel=1e-4)
    assert "would decide: rate_table.rate from 0.050 to" in one["reason"]
    assert all(verdict["deciding_u"] is None for verdict in results["verdicts"] if verdict["requirement"] == "R1")


def test_the_command_and_its_refusals(campaign: Write, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    def printed(*given: str) -> str:
        with pytest.raises(SystemExit) as ended:
            main(["budget", str(folder), *given])
        assert ended.value.code == 0
        return " ".join(capsys.readouterr().out.split())

    folder = campaign(("[[requirements]]\nid", f"{OWN}[[requirements]]\nid"))
    with pytest.raises(DataError, match="no results"):
        budget(tmp_path / "nothing")
    run(folder)
    out = printed("--wanted", WANTED)
    assert "first, scale_factor_error x: u = 0.051 %, wanted 0.02 %: rate_table.rate from 0.050 to 0.019 %" in out
    assert "R2, first x: the interval reaches over a limit" in out
    content = json.loads(printed("--json"))
    assert content["budgets"][0]["sources"][0]["level"] == "run"
    assert len(content["undecided"]) == 1
    for wanted, words in (("scale_factor_error", "wanted 'scale_factor_error'"), ("bias=0 deg/s", "above zero")):
        with pytest.raises(UsageError, match=words):
            budget(folder, wanted)
    with pytest.raises(DataError, match="the figure is in '%'"):
        budget(folder, "scale_factor_error=1 deg/s")
    with pytest.raises(DataError, match="no budget of nothing"):
        budget(folder, "nothing=1 %")
    with pytest.raises(DataError, match="budgets of tests: first"):
        budget(folder, test="nothing")
    with pytest.raises(DataError, match="Name the folder of a campaign"):
        budget(folder / "out/model.json")
