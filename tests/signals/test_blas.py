"""Linear algebra on one thread, and afterwards as before."""

from __future__ import annotations

from threading import Barrier, Thread
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.campaign.calls import call
from inertialcal.campaign.engine.whole import reduce_campaign
from inertialcal.signals.blas import _libraries, one_blas_thread


def threads() -> list[int]:
    return [count() for count, _ in _libraries()]


@pytest.fixture(autouse=True)
def _two_threads() -> None:
    """Independent of what the suite is started with."""
    if not _libraries():
        pytest.skip("neither numpy nor scipy brings OpenBLAS")
    for _, limit in _libraries():
        limit(2)


def test_the_libraries_that_numpy_and_scipy_bring_are_found() -> None:
    config = np.show_config(mode="dicts")
    assert isinstance(config, dict)
    if config["Build Dependencies"]["blas"]["name"] == "scipy-openblas":
        assert len(_libraries()) == 2


def test_one_thread_inside_and_as_before_outside() -> None:
    with one_blas_thread():
        assert set(threads()) == {1}
        with one_blas_thread():
            assert set(threads()) == {1}
        assert set(threads()) == {1}
    assert set(threads()) == {2}


def test_a_failure_inside_changes_nothing_outside() -> None:
    with pytest.raises(ZeroDivisionError), one_blas_thread():
        1 / 0  # noqa: B018
    assert set(threads()) == {2}


def test_of_two_at_once_the_last_puts_it_back() -> None:
    """The second begins while the first is inside, and ends after it."""
    began, ended, seen = Barrier(2), Barrier(2), []

    def second() -> None:
        with one_blas_thread():
            began.wait()
            ended.wait()
            seen.extend(threads())

    thread = Thread(target=second)
    with one_blas_thread():
        thread.start()
        began.wait()
    ended.wait()
    thread.join()
    assert set(seen) == {1}
    assert set(threads()) == {2}


def test_a_call_has_one_thread_and_puts_it_back(monkeypatch: pytest.MonkeyPatch) -> None:
    reduce, seen = reduce_campaign, []

    def seeing(*given: Any) -> Any:
        seen.extend(threads())
        return reduce(*given)

    monkeypatch.setattr(call, "reduce_campaign", seeing)
    ic.allan(np.random.default_rng(1).normal(size=1000), sample_rate=1.0)
    assert set(seen) == {1}
    assert set(threads()) == {2}
