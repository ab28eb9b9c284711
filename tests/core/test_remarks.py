"""Remarks: one line each; equal findings are counted, not repeated."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.remarks import Remark, Severity, condensed, gather

SKIPPED = Remark("skipped_saves", "warning", "a save was skipped", "rt_x.csv:7", do="Look at the logger")


def test_one_line() -> None:
    assert str(SKIPPED) == "warning: rt_x.csv:7: a save was skipped. Look at the logger"
    assert str(Remark("few_runs", "info", "3 runs")) == "info: 3 runs"
    assert str(Remark("skipped_saves", "warning", "a save was skipped", count=182)).endswith("skipped (182 x)")


def test_parts_for_json() -> None:
    assert SKIPPED.to_dict() == {
        "code": "skipped_saves",
        "severity": "warning",
        "what": "a save was skipped",
        "where": "rt_x.csv:7",
        "count": 1,
        "do": "Look at the logger",
    }


def test_place_is_put_before_its_own() -> None:
    assert SKIPPED.at("test rate_x").where == "test rate_x: rt_x.csv:7"
    assert Remark("few_runs", "info", "3 runs").at("test rate_x").where == "test rate_x"


def test_182_skipped_saves_are_one_line() -> None:
    rows = [Remark("skipped_saves", "warning", "a save was skipped", f"rt_x.csv:{row}") for row in range(2, 184)]
    (line,) = gather(rows)
    assert line.count == 182
    assert line.where == "rt_x.csv:2"


def test_many_alike_are_one_line_that_names_the_recordings() -> None:
    found = [Remark("glitch", "warning", f"{name}: x", f"{name}.csv:7", recording=name) for name in "abcde"]
    (line,) = condensed(found)
    assert line.what == "a: x; and the like at 4 other places (a, b, c, d, e)"
    assert line.count == 5


def test_errors_stand_one_by_one() -> None:
    found = [Remark("sign_disagrees", "error", f"{name}: x", f"{name}.csv") for name in "abcde"]
    assert condensed(found) == tuple(found)


severities: st.SearchStrategy[Severity] = st.sampled_from(["info", "warning", "error"])
remarks = st.builds(
    Remark,
    code=st.sampled_from(["a", "b"]),
    severity=severities,
    what=st.sampled_from(["x", "y"]),
    where=st.text(max_size=3),
    count=st.integers(1, 9),
)


@given(st.lists(remarks))
def test_gathering_loses_no_finding(found: list[Remark]) -> None:
    gathered = gather(found)
    keys = [(remark.code, remark.severity, remark.what, remark.do) for remark in gathered]
    assert sum(remark.count for remark in gathered) == sum(remark.count for remark in found)
    assert len(set(keys)) == len(keys)
    assert keys == list(dict.fromkeys((remark.code, remark.severity, remark.what, remark.do) for remark in found))
    assert gather(gathered) == gathered
