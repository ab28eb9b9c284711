"""What is said while loops are compiled: once, after a second in all, never where nobody waits."""

from __future__ import annotations

import time

import pytest

from inertialcal.core.show import compiling as module
from inertialcal.core.show.compiling import Compiling


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setattr(module, "PATIENCE", 0.05)
    return []


def watched(said: list[str]) -> Compiling:
    found = Compiling()
    found.say = lambda: said.append("compiling")
    return found


def test_it_is_said_once_while_a_loop_takes_long(said: list[str]) -> None:
    compiling = watched(said)
    for _ in range(2):
        compiling.begin("outer")
        compiling.begin("inner")  # a loop that the first one calls
        compiling.end()
        deadline = time.monotonic() + 10.0
        while not said and time.monotonic() < deadline:
            time.sleep(0.01)
        assert said == ["compiling"]
        compiling.end()
    assert compiling.names == ["outer", "inner"] * 2


def test_short_loops_add_up(said: list[str]) -> None:
    compiling = watched(said)
    for _ in range(20):  # 10 ms each, of 50
        compiling.begin("one")
        time.sleep(0.01)
        compiling.end()
    assert said == ["compiling"]


def test_nothing_is_said_before_a_second_or_to_nobody(said: list[str]) -> None:
    compiling = watched(said)
    compiling.begin("short")
    compiling.end()
    nobody = Compiling()
    nobody.begin("long")
    time.sleep(0.1)
    nobody.end()
    time.sleep(0.1)
    assert said == []
