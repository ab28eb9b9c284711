"""What the page is told: traces are the samples, deviations those of the truth."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from shown_lab import HOSTILE, PLAIN, RAIL, RATE, STUCK, TOP, WHITE, lively

from inertialcal.lab.live.content import Drawing, LiveContent, _spectrum, drawing


@dataclass
class Traces:
    """What a page is told of an instrument: number of each part, least and most, shape (c, p)."""

    newest: float
    parts: np.ndarray[tuple[int], np.dtype[np.float64]]
    low: np.ndarray[tuple[int, int], np.dtype[np.float64]]
    high: np.ndarray[tuple[int, int], np.dtype[np.float64]]


def unpacked(data: bytes) -> tuple[float, int, list[Traces]]:
    """Return now, number of the recording, and the traces of each instrument, by struct alone."""
    count, run, now, _ = struct.unpack_from("<IIdd", data)
    at, found = 24, []
    for _ in range(count):
        _, channels, points, _, newest = struct.unpack_from("<IIIId", data, at)
        at += 24
        parts = np.array(struct.unpack_from(f"<{points}d", data, at))
        base = np.array(struct.unpack_from(f"<{channels}d", data, at + 8 * points))
        at += 8 * (points + channels)
        numbers = np.array(struct.unpack_from(f"<{2 * points * channels}f", data, at))
        at += 4 * len(numbers)
        low, high = numbers.reshape(2, channels, points) + base[:, None]
        found.append(Traces(newest, parts, low, high))
    assert at == len(data)
    return now, run, found


def test_what_it_shows_is_what_was_measured(tmp_path: Path) -> None:
    made = lively(tmp_path)
    try:
        content = LiveContent(made)
        made.clock.wait(3.0)
        now, run, (one_part,) = unpacked(content.traces(Drawing(300, 2.0, 0, {})))
        made.clock.wait(0.1)
        later = content.traces(Drawing(300, 2.0, run, {0: int(one_part.parts[-1])}))
        other = content.traces(Drawing(300, 2.0, run + 1, {0: int(one_part.parts[-1])}))
        told = json.loads(content.noise())["instruments"][0]
        state = json.loads(content.state())
        again = content.noise()
        assert json.loads(again)["instruments"][0] == told  # not made anew at once
    finally:
        made.stop()
        made.wait()
    parts, low, high = one_part.parts, one_part.low, one_part.high
    assert 250 <= len(parts) <= 301
    assert 0.0 <= now - one_part.newest < 0.5
    assert parts[-1] == one_part.newest // (2.0 / 300)
    assert np.all(np.diff(parts) > 0)
    _, _, (then,) = unpacked(later)
    assert then.parts[0] == parts[-1]  # it has grown
    assert len(then.parts) < 100
    assert len(unpacked(other)[2][0].parts) > 200  # it has parts of another recording: it is given all
    assert np.all(then.low[:, 0] <= low[:, -1] + 1e-5)
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
        unpacked(content.traces(Drawing(50, 10.0, 0, {})))
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
            sizes.append((len(content.traces(Drawing(200, 5.0, 0, {}))), len(content.state())))
    finally:
        made.stop()
        made.wait()
    most = 24 + 24 + 8 * (13 + 201) + 8 * 13 * 201
    assert all(size <= most for size, _ in sizes)
    assert abs(sizes[1][1] - sizes[0][1]) < 100


@pytest.mark.parametrize("text", ["", "600", "600 ", "600 10", "9 10 0", "2001 10 0", "600 0 0", "600 nan 0",
                                  "600 inf 0", "600 1e9 0", "-5 5 0", "1_000_000 5 0", "６００ ten", "a b",
                                  "600 10 10 10", "600 10 -1", "600 10 0 1=-2", "600 10 0 1=", "600 10 0" + " 1=1" * 65,
                                  "600 10 0 \n"])  # fmt: skip
def test_what_is_not_given_is_not_asked_for(text: str) -> None:
    assert drawing(text) is None


def test_what_is_given() -> None:
    assert drawing("600 10 0") == Drawing(600, 10.0, 0, {})
    assert drawing("600 0.5 3 0=812 2=790") == Drawing(600, 0.5, 3, {0: 812, 2: 790})


def test_pages_that_have_the_same_are_given_the_same_bytes(tmp_path: Path) -> None:
    made = lively(tmp_path)
    try:
        content = LiveContent(made)
        made.clock.wait(0.5)

        def given() -> str | bytes | None:
            try:
                content.answer("300 2 0").send(None)  # it waits for nothing
            except StopIteration as end:
                found: str | bytes | None = end.value
                return found
            raise AssertionError

        first = given()
        assert first is given()
        made.clock.wait(0.1)
        assert given() != first
    finally:
        made.stop()
        made.wait()


def test_a_channel_that_stays_has_no_spectrum() -> None:
    varying = np.random.default_rng(1).normal(size=4096)
    _, density = _spectrum(np.column_stack([np.full(4096, 3439.8), varying]), 1e-3)
    assert isinstance(density, list)
    assert not any(density[0])
    assert all(density[1])
