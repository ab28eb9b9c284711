"""The table of speed: what is measured, named and stored. Nothing here is timed against anything."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from speed import comparison
from speed.comparison import Line, Measured, Work, every_line, line, measured
from speed.table import regressions, row, store, stored, table


def found(ratio: float, best: float, goal: float = 2.0, name: str = "a") -> Measured:
    return Measured(Line(name, "peer", goal, lambda: Work(int, int)), 0.5, 0.5 * ratio, ratio, best, math.inf)


def test_a_slow_line_is_named_only_where_its_best_is_slow_too() -> None:
    before = {"a": 10.0}
    assert regressions([found(7.9, 7.9)], before) == ["a: ratio 7.9 (best 7.9), stored 10"]
    assert regressions([found(7.9, 8.1)], before) == []
    assert regressions([found(8.1, 7.0)], before) == []
    assert regressions([found(1.0, 1.0, name="new")], before) == []


def test_stored_ratios_come_back_and_others_stay(tmp_path: Path) -> None:
    path = tmp_path / "ratios.csv"
    assert stored(path) == {}
    store([found(3.0, 4.0, name="a"), found(0.125, 1.0, name="b, with a comma")], path)
    store([found(5.0, 5.0, name="a")], path)
    assert stored(path) == {"a": 5.0, "b, with a comma": 0.125}


def test_a_row_says_whether_the_goal_is_met() -> None:
    assert [row(one)[-1] for one in (found(2.0, 2.0), found(1.9, 2.1), found(1.9, 1.9))] == [
        "met", "met at best", "not met",
    ]  # fmt: skip
    assert row(found(0.1, 0.1, goal=0.0))[-2:] == ("none", "")
    heads, first = table([row(found(2.0, 2.5))]).splitlines()
    assert heads.split() == ["product", "peer", "own", "of", "peer", "ratio", "best", "limit", "goal"]
    assert first.split() == ["a", "peer", "500", "ms", "1", "s", "2", "2.5", "2", "met"]


def test_a_limit_is_the_time_of_the_peer_over_that_of_reading() -> None:
    entry = Line("a", "peer", 1.0, lambda: Work(lambda: None, 2.0, moved=100))
    assert measured(entry, speed=200.0).limit == 4.0


def test_an_amount_other_than_time_is_what_the_call_returns() -> None:
    one = measured(Line("a", "allowed", 1.0, lambda: Work(lambda: 256.0, 1024.0, unit="MiB")), speed=1.0)
    assert (one.ratio, row(one)[2:4]) == (4.0, ("256 MiB", "1024 MiB"))


def test_a_name_stands_for_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(comparison, "LINES", {})
    line("a", "peer", 1.0)(lambda: Work(int, int))
    with pytest.raises(ValueError, match="two lines of the name 'a'"):
        line("a", "peer", 1.0)(lambda: Work(int, int))


def test_every_stored_ratio_is_of_a_line() -> None:
    assert set(stored()) <= set(every_line())
