"""Recording: one clock, channels of one length, counts that stay integers."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.recording import SECOND, Channel, Digest, Recording, Source

COUNTS = np.array([2047, 2048, 4095], dtype=np.int16)
VOLTS = np.array([0.25, np.nan, 0.75])
TIMES = np.array([10, 12, 14], dtype=np.int64) * SECOND
SOURCE = Source("rt_x.csv", "ab" * 32, "csv")


def recording() -> Recording:
    channels = (Channel("x", COUNTS, "count", "header", "x", "gyro"), Channel("xr", VOLTS, "V", "header"))
    return Recording(channels, TIMES, 2.0, 1.0, source=SOURCE)


def test_size_names_and_sampling() -> None:
    assert len(recording()) == 3
    assert recording().names == ("x", "xr")
    assert recording().sample_rate == 0.5
    assert Recording(()).sample_rate is None


def test_size_without_channels_or_time() -> None:
    assert len(Recording((), TIMES)) == 3
    assert len(Recording((Channel("x", COUNTS),))) == 3
    assert len(Recording(())) == 0


def test_counts_stay_integers() -> None:
    assert recording().channel("x").data.dtype == np.int16


def test_array_is_time_first_and_in_the_order_asked_for() -> None:
    np.testing.assert_array_equal(recording().array(), np.column_stack([COUNTS, VOLTS]))
    both = recording().array(["xr", "x"])
    assert both.shape == (3, 2)
    assert both.dtype == np.float64
    np.testing.assert_array_equal(both[:, 1], COUNTS)
    assert recording().array([]).shape == (3, 0)


def test_seconds_are_exact_for_utc_nanoseconds() -> None:
    start = 1_272_467_400 * SECOND  # 2010-04-28T15:10:00Z: as a float it would be rounded to 256 ns
    times = start + np.array([0, 1, 2_000_000_001], dtype=np.int64)
    seconds = Recording((), times, epoch="utc").seconds
    assert seconds is not None
    np.testing.assert_array_equal(seconds, [0.0, 1e-9, 2.000000001])


def test_no_time_no_seconds() -> None:
    assert Recording((Channel("x", COUNTS),)).seconds is None
    assert Recording((), np.empty(0, dtype=np.int64)).seconds is None


def test_unit_said_later_leaves_numbers_and_other_channels() -> None:
    said = recording().with_unit(["x"], "deg/s", "flag")
    assert (said.channel("x").unit, said.channel("x").unit_from) == ("deg/s", "flag")
    assert said.channel("x").data is COUNTS
    assert said.channel("xr").unit == "V"
    assert recording().channel("x").unit == "count"


@pytest.mark.parametrize(
    "ask", [lambda r: r.channel("y"), lambda r: r.array(["y"]), lambda r: r.with_unit(["y"], "V", "")]
)
def test_wrong_column(ask: object) -> None:
    assert callable(ask)
    with pytest.raises(DataError, match=r"rt_x\.csv: no column 'y'\. The file has: x, xr") as caught:
        ask(recording())
    assert caught.value.problems[0].code == "wrong_column"


def test_text_in_a_channel() -> None:
    text = Recording((Channel("mode", np.array(["on", "off"])),), source=SOURCE)
    with pytest.raises(DataError, match=r"rt_x\.csv: column 'mode' holds <U3 that are not all numbers"):
        text.array()


def test_channels_that_do_not_fit_together() -> None:
    with pytest.raises(DataError, match="channel x appears twice"):
        Recording((Channel("x", COUNTS), Channel("x", VOLTS)))
    with pytest.raises(DataError, match=r"channels of different length: \[\(2,\), \(3,\)\]"):
        Recording((Channel("x", COUNTS), Channel("y", VOLTS[:2])))
    with pytest.raises(DataError, match="channels of different length"):
        Recording((Channel("x", COUNTS),), TIMES[:2])
    with pytest.raises(DataError, match=r"channels of shape \(3, 1\), need \(n,\)"):
        Recording((Channel("x", COUNTS[:, None]),))


def test_time_must_be_whole_nanoseconds() -> None:
    with pytest.raises(DataError, match="time of type float64, need int64 ns"):
        Recording((Channel("x", COUNTS),), TIMES.astype(float))


def test_a_digest_is_worked_out_once_whoever_asks() -> None:
    worked = []

    def work() -> str:
        time.sleep(0.02)
        worked.append(1)
        return "ab"

    digest = Digest(work)
    with ThreadPoolExecutor(4) as threads:
        assert set(threads.map(lambda _: digest.result(), range(8))) == {"ab"}
    assert worked == [1]


def test_the_error_of_a_digest_is_raised_each_time_it_is_asked_for() -> None:
    source = Source("a.csv", Digest(lambda: str(1 // 0)))
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            assert source.sha256


def test_a_digest_is_there_without_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    def none_left(work: object, given: object) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr("_thread.start_new_thread", none_left)
    assert Source("a.csv", Digest(lambda: "ab")).sha256 == "ab"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no process becomes two here")
def test_a_process_becomes_two_when_no_thread_works_on_a_digest() -> None:
    def slow() -> str:
        time.sleep(0.1)
        return "ab"

    source = Source("a.csv", digest := Digest(slow))
    digest.begin()
    child = os.fork()
    if not child:
        os._exit(0 if source.sha256 == "ab" else 1)
    assert os.waitpid(child, 0)[1] == 0


ENDING = """
import atexit, time
done = []
atexit.register(lambda: print(done))
from inertialcal.core.recording import Digest
Digest(lambda: time.sleep(0.3) or done.append(1) or "ab").begin()
"""


def test_a_process_does_not_end_while_a_thread_works_on_a_digest() -> None:
    ended = subprocess.run([sys.executable, "-c", ENDING], check=True, capture_output=True, text=True)
    assert (ended.stdout, ended.stderr) == ("[1]\n", "")
