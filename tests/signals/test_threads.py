"""Shares of a job on all cores: in order, the first failure raised, and no thread left behind."""

from __future__ import annotations

import threading
import time

import pytest

from inertialcal.signals import threads
from inertialcal.signals.threads import LARGE, each_of, side_by_side


@pytest.fixture(autouse=True, params=[1, 2, 5])
def cores(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    number: int = request.param
    monkeypatch.setattr(threads, "cores", lambda: number)
    return number


def test_results_stand_in_order_and_all_cores_work(cores: int) -> None:
    def late(share: int) -> tuple[int, str]:
        time.sleep(0.01 if share % 2 else 0.02)
        return share, threading.current_thread().name

    found = each_of(late, range(8), LARGE)
    assert [share for share, _ in found] == list(range(8))
    assert (len({name for _, name in found}) > 1) == (cores > 1)
    assert {name for _, name in each_of(late, range(2), LARGE - 1)} == {threading.current_thread().name}
    assert each_of(late, [], LARGE) == []


def test_first_failure_is_raised() -> None:
    done = []

    def fails(share: int) -> None:
        time.sleep(0.01 if share == 2 else 0.0)
        if share in {2, 5}:
            raise IndexError(f"share {share}")
        done.append(share)

    with pytest.raises(IndexError, match="share 2"):
        each_of(fails, range(8), LARGE)
    assert each_of(str, range(3), LARGE) == ["0", "1", "2"]


def test_shares_may_be_cut_into_shares() -> None:
    def inner(share: int) -> int:
        return sum(each_of(lambda part: 10 * share + part, range(10), LARGE))

    assert each_of(inner, range(10), LARGE) == [100 * share + 45 for share in range(10)]


def test_no_thread_is_left_behind() -> None:
    """A fork beside other threads may hang."""
    before = threading.active_count()
    each_of(str, range(3), LARGE)
    assert threading.active_count() == before


def test_two_jobs_side_by_side(cores: int) -> None:
    def own() -> str:
        time.sleep(0.01)
        return threading.current_thread().name

    one, other = side_by_side(own, own, LARGE)
    assert (one != other) == (cores > 1)
    assert len({*side_by_side(own, own, LARGE - 1)}) == 1
    before = threading.active_count()
    with pytest.raises(ZeroDivisionError):
        side_by_side(own, lambda: 1 // 0, LARGE)
    assert threading.active_count() == before
