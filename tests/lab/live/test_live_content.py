"""What the page is told: traces are the samples, deviations those of the truth, findings what was put in."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from shown_lab import HOSTILE, PLAIN, RAIL, RATE, STUCK, TOP, WHITE, lively

from inertialcal.lab.live.content import LiveContent, _spectrum, drawing


def unpacked(data: bytes) -> tuple[float, list[tuple[float, np.ndarray, np.ndarray, np.ndarray]]]:
    """Return now and, of each instrument, end, ages, least and most, shape (c, p), by struct alone."""
    count, now = struct.unpack_from("<Id", data)
    at, found = 12, []
    for _ in range(count):
        _, channels, points, _, end = struct.unpack_from("<IIIId", data, at)
        at += 24
        base = np.array(struct.unpack_from(f"<{channels}d", data, at))
        at += 8 * channels
        numbers = np.array(struct.unpack_from(f"<{points * (1 + 2 * channels)}f", data, at))
        at += 4 * len(numbers)
        low, high = numbers[points:].reshape(2, channels, points) + base[:, None]
        found.append((end, numbers[:points], low, high))
    assert at == len(data)
    return now, found


def test_what_it_shows_is_what_was_measured(tmp_path: Path) -> None:
    made = lively(tmp_path)
    try:
        content = LiveContent(made)
        made.clock.wait(3.0)
        now, ((end, ages, low, high),) = unpacked(content.traces(300, 2.0))
        told = json.loads(content.noise())["instruments"][0]
        state = json.loads(content.state())
        again = content.noise()
        assert json.loads(again)["instruments"][0] == told  # not made anew at once
    finally:
        made.stop()
        made.wait()
    assert 250 <= len(ages) <= 302
    assert -2.0 / 300 <= now - end < 2.0  # the end of a pixel may be to come
    assert ages[-1] == 0.0
    assert np.all(np.diff(ages) < 0)
    assert np.all(low <= high)
    for i in range(len(PLAIN)):
        assert abs(np.mean(low[i] + high[i]) / 2 - (4.25 if i == STUCK else i)) < 0.2
    assert low[STUCK].min() == high[STUCK].max() == 4.25
    assert high[RAIL].max() == pytest.approx(RAIL + TOP * WHITE, abs=1e-6)
    assert np.all(low[-1] == 25.0)

    rate = told["samples"] / told["seconds"]
    assert abs(rate / RATE - 1) < 0.1
    tau, deviation = np.array(told["tau"]), np.array(told["deviation"][0])
    few = tau < 0.02
    np.testing.assert_allclose(deviation[few], WHITE / np.sqrt(tau[few] * rate), rtol=0.2)  # white noise
    density = np.array(told["density"][0])[-20:]
    assert abs(np.mean(density**2) / (2 * WHITE**2 / rate) - 1) < 0.2
    texts = " | ".join(told["findings"])
    assert "gyro_y: stuck at 4.25 deg/s" in texts
    assert "gyro_z:" in texts
    assert "end of the range, 2.4 deg/s" in texts
    assert "temperature" not in texts  # may stand still
    assert "gyro_x" not in texts
    (one,) = state["instruments"]
    assert [name for name, _ in one["channels"]] == [*PLAIN, "temperature"]  # the counter is no reading
    assert one["channels"][-1] == ["temperature", "degC"]
    assert 0 < one["acknowledged"] <= one["rows"]


def test_before_the_first_sample_there_is_nothing_and_no_fault(tmp_path: Path) -> None:
    made = lively(tmp_path, HOSTILE)
    content = LiveContent(made)
    made.stop()
    made.wait()
    for _ in range(2):
        unpacked(content.traces(50, 10.0))
        assert json.loads(content.state())["instruments"][0]["channels"][0][0] == HOSTILE[0]
        json.loads(content.noise())


def test_what_it_is_told_does_not_grow(tmp_path: Path) -> None:
    """20,000 s of 1 kHz samples would be 2 GB; what is told holds no more than was asked for."""
    made = lively(tmp_path, speed=20)
    try:
        content = LiveContent(made)
        sizes = []
        for _ in range(2):
            made.clock.wait(20.0)
            sizes.append((len(content.traces(200, 5.0)), len(content.state())))
    finally:
        made.stop()
        made.wait()
    most = 12 + 24 + 13 * 8 + 4 * 202 * 27
    assert all(size <= most for size, _ in sizes)
    assert abs(sizes[1][1] - sizes[0][1]) < 100


@pytest.mark.parametrize("text", ["", "600", "600 ", "9 10", "2001 10", "600 0", "600 nan", "600 inf", "600 1e9",
                                  "-5 5", "1_000_000 5", "６００ ten", "a b", "600 10 10"])  # fmt: skip
def test_what_is_not_given_is_not_asked_for(text: str) -> None:
    assert drawing(text) is None


def test_what_is_given() -> None:
    assert drawing("600 10") == (600, 10.0)


def test_a_channel_that_stays_has_no_spectrum() -> None:
    varying = np.random.default_rng(1).normal(size=4096)
    _, density = _spectrum(np.column_stack([np.full(4096, 3439.8), varying]), 1e-3)
    assert isinstance(density, list)
    assert not any(density[0])
    assert all(density[1])
