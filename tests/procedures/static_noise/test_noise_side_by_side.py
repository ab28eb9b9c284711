"""Large records are analysed side by side: figures and remarks do not depend on the number of cores, to the bit."""

from __future__ import annotations

import gc
import threading
import time
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.estimate import Array
from inertialcal.core.recording import Channel, Recording
from inertialcal.procedures.static_noise import axis_noise
from inertialcal.procedures.static_noise.plan import Plan
from inertialcal.procedures.static_noise.readings import AtRest
from inertialcal.procedures.static_noise.recordings import readings_from
from inertialcal.procedures.static_noise.reduction import reduce
from inertialcal.signals import threads


def disturbed(kind: str) -> Array:
    x = np.random.default_rng(1).normal(size=threads.LARGE)
    if kind == "glitch":  # left out by the screening
        x[1234] = 900.0
    if kind == "bump":  # left out behind it
        x[300_000:302_000] += 20.0
    if kind == "missing":
        x[5_000:5_100] = np.nan
    return x


def shown(found: Any) -> list[Any]:
    return [row.to_dict() for row in found.rows] + [one.to_dict() for one in found.remarks]


@pytest.mark.parametrize("kind", ["clean", "glitch", "bump", "missing"])
def test_cores_change_nothing(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    x, found = disturbed(kind), []
    for cores in (1, 2, 3):
        monkeypatch.setattr(threads, "cores", lambda number=cores: number)
        assert threads.pays(len(x)) == (cores > 1)
        found.append(shown(ic.allan(x, sample_rate=100.0)))
    assert found[0] == found[1] == found[2]
    codes = {one["code"] for one in found[0] if "code" in one}
    assert kind == "clean" or {"glitch": "glitch", "bump": "disturbed", "missing": "gaps"}[kind] in codes


def test_no_thread_is_left_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fork beside other threads may hang."""
    monkeypatch.setattr(threads, "cores", lambda: 2)
    before = threading.active_count()
    for kind in ("clean", "bump", "missing"):
        ic.psd(disturbed(kind), sample_rate=100.0)
        assert threading.active_count() == before
    for refused in (np.ones(threads.LARGE), np.full(threads.LARGE, 1e70)):
        with pytest.raises(ic.DataError):
            ic.allan(refused, sample_rate=100.0)
        assert threading.active_count() == before


def test_what_was_begun_by_another_plan_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    x = disturbed("clean")
    channel = Channel("x", x, "deg/s", "header", "x")
    found = []
    for cores in (1, 2):
        monkeypatch.setattr(threads, "cores", lambda number=cores: number)
        begun, other = Plan(kind="gyro"), Plan(kind="gyro", segment=500.0)
        recording = Recording((channel,), None, 0.01)
        readings = readings_from(begun, [AtRest(recording, {"x": "x"})])
        spectrum = reduce(other, readings).axes[0].records[0].spectral.spectrum
        assert spectrum is not None
        found.append(spectrum)
    assert found[0].segment == found[1].segment == 50_000
    np.testing.assert_array_equal(found[0].density, found[1].density)


def test_a_record_that_nobody_reduces_is_let_go_of(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "cores", lambda: 2)
    before = threading.active_count()
    channel = Channel("x", disturbed("clean"), "deg/s", "header", "x")
    readings = readings_from(Plan(kind="gyro"), [AtRest(Recording((channel,), None, 0.01), {"x": "x"})])
    assert len(readings) == len(axis_noise._early) == 1
    del readings
    gc.collect()
    assert not axis_noise._early
    deadline = time.monotonic() + 30.0
    while threading.active_count() > before and time.monotonic() < deadline:
        time.sleep(0.01)
    assert threading.active_count() == before
