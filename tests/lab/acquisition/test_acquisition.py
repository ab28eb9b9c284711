"""A whole acquisition: rehearsals over pty and sockets, what is shown, disks that fill, steps, faults of what moves."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from lab_devices import REHEARSAL, lab_folder, rehearsed

from inertialcal.core.errors import InertialcalError, InstrumentError, StoreError
from inertialcal.files import read
from inertialcal.files.loggers.rows import RowChannel, RowLayout
from inertialcal.lab.acquisition.acquisition import Acquisition
from inertialcal.lab.acquisition.lab_file import load_lab
from inertialcal.lab.acquisition.recorder import File
from inertialcal.lab.acquisition.seal import seal
from inertialcal.lab.clock import Clock, Instant
from inertialcal.lab.instruments.protocol import Batch
from inertialcal.rigs import RIGS

SUITE = RIGS.named("npsat1").twin(1).recordings["recordings/x_run1.csv"]


@pytest.mark.parametrize("over", ["serial", "tcp", "udp"])
def test_what_is_recorded_live_is_what_the_rig_recorded(tmp_path: Path, over: str) -> None:
    made = rehearsed(tmp_path, over)
    view = made.view()
    assert view.state == "done"
    (suite,) = view.instruments
    assert suite.rows == suite.acknowledged == len(SUITE)
    assert (suite.damaged, suite.doubled, suite.late, suite.lost) == (0, 0, 0, 0)
    summary = seal(tmp_path / "out")
    assert summary.whole
    found = read(tmp_path / "out" / "suite.parquet")
    for one in SUITE.channels:
        np.testing.assert_array_equal(found.channel(one.name).data, one.data, err_msg=one.name)
        assert one.unit in (None, found.channel(one.name).unit)
    np.testing.assert_array_equal(found.channel("stamp").data, SUITE.time_ns)
    assert summary.instruments[0].intervals is not None
    assert str(summary.instruments[0].intervals) == suite.intervals


def test_time_is_that_of_the_instruments_clock_put_on_the_computers(tmp_path: Path) -> None:
    rehearsed(tmp_path)
    summary = seal(tmp_path / "out")
    (one,) = summary.instruments
    assert one.time_from.startswith("stamp")
    estimate = one.clocks.estimate
    assert estimate is not None
    assert SUITE.time_ns is not None
    stamps = read(tmp_path / "out" / "suite.parquet").time_ns
    assert stamps is not None
    steps, own = np.diff(stamps), np.diff(SUITE.time_ns)
    used = 0.0 if one.clocks.uncertain else estimate.values[1]  # a busy machine may leave it unknown
    np.testing.assert_allclose(steps / own, 1.0 + used, atol=2e-9)
    content = json.loads((tmp_path / "out" / "acquisition.json").read_text())
    assert content["instruments"][0]["clocks"]["drift"]["u"] > 0
    assert content["finished"]


def test_what_a_clock_may_be_off_is_kept_with_the_recording(tmp_path: Path) -> None:
    said = REHEARSAL.format(over="tcp", faults="") + 'clock_within = "0.0001 %"\n'  # less than any delay lets be known
    made = Acquisition(load_lab(lab_folder(tmp_path, said)), tmp_path / "out")
    made.start()
    assert made.wait(60.0 * made.clock.speed)
    summary = seal(tmp_path / "out")
    assert "clock_uncertain" in {one.code for one in summary.remarks}
    (one,) = summary.instruments
    assert one.clocks.within == pytest.approx(1e-6)
    stamps = read(tmp_path / "out" / "suite.parquet").time_ns
    assert stamps is not None
    assert SUITE.time_ns is not None
    np.testing.assert_allclose(np.diff(stamps), np.diff(SUITE.time_ns), atol=2000)  # of doubles that hold UTC


def test_faults_of_the_link_are_said_and_no_number_is_wrong(tmp_path: Path) -> None:
    made = rehearsed(tmp_path, "tcp", '"late", "torn", "doubled", "lost", "unplugged"')
    codes = {one.remark.code for one in made.view().remarks}
    assert {"damaged_rows", "doubled_rows", "unplugged", "connected_again", "save_intervals"} <= codes
    summary = seal(tmp_path / "out")
    assert {one.code for one in summary.remarks} >= codes
    found = read(tmp_path / "out" / "suite.parquet")
    at = np.searchsorted(SUITE.time_ns, found.channel("stamp").data)  # type: ignore[arg-type]
    for one in SUITE.channels:
        np.testing.assert_array_equal(found.channel(one.name).data, one.data[at])


def test_a_replayed_file_is_recorded_again(tmp_path: Path) -> None:
    rehearsed(tmp_path)
    seal(tmp_path / "out")
    text = f"""schema = 1
[lab]
speed = 100000
[instruments.again]
link = "replay"
address = "{tmp_path}/out/suite.parquet"
"""
    made = Acquisition(load_lab(lab_folder(tmp_path, text)), tmp_path / "again")
    made.start()
    assert made.wait(60.0 * made.clock.speed)
    seal(tmp_path / "again")
    found = read(tmp_path / "again" / "again.parquet")
    np.testing.assert_array_equal(found.channel("x").data, SUITE.channel("x").data)


# ---- a made instrument, to see what the acquisition itself does ----


class Made:
    """An instrument whose rows are a ramp, and that can be told a rate."""

    name = "made"
    layout = RowLayout((RowChannel("value", "float64", "deg/s"),))

    def __init__(self, clock: Clock, rows: int = 10**9, refuses: float = np.inf) -> None:
        self.clock, self.count, self.refuses = clock, rows, refuses
        self.told: list[tuple[str, float]] = []
        self.is_closed = False

    @property
    def settable(self) -> Mapping[str, str]:
        return {"rate": "deg/s"}

    def open(self) -> None:
        pass

    def identify(self) -> str:
        return "made for a test"

    def configure(self) -> None:
        pass

    def stream(self, stop: threading.Event) -> Iterator[Batch]:
        for first in range(0, self.count, 10):
            if self.clock.wait(0.1, stop):
                return
            rows = np.array([(i,) for i in range(first, first + 10)], self.layout.dtype)
            yield Batch(rows, self.clock.now())

    def set(self, quantity: str, value: float) -> Instant:
        if value >= self.refuses:
            raise InstrumentError("made: refused", code="interlock_open")
        self.told.append((quantity, value))
        return self.clock.now()

    def read(self, quantity: str) -> float:
        return self.told[-1][1]

    def check(self, quantity: str, value: float) -> str:
        return ""

    def safe(self) -> None:
        self.told.append(("safe", 0.0))

    def close(self) -> None:
        self.is_closed = True


MADE = """schema = 1
[lab]
sync = "1 s"
{more}
[instruments.made]
link = "tcp"
address = "127.0.0.1:1"
dialect = "aerosmith"
parameters = {{ acceleration = "1" }}
limits = {{ rate = ["-100 deg/s", "100 deg/s"] }}
"""
STEPS = """
[[steps]]
name = "slow"
set = { "made.rate" = "1 deg/s" }
hold = "5 s"
[[steps]]
set = { "made.rate" = "50 deg/s" }
hold = "5 s"
"""


def made_one(folder: Path, more: str = "", steps: str = "", **given: object) -> tuple[Acquisition, Made]:
    lab = load_lab(lab_folder(folder, MADE.format(more=more) + steps))
    clock = Clock(200)
    one = Made(clock, given.pop("rows", 10**9), given.pop("refuses", np.inf))  # type: ignore[arg-type]
    return Acquisition(lab, folder / "out", clock, [one], **given), one  # type: ignore[arg-type]


def test_steps_are_gone_through_and_the_end_is_safe(tmp_path: Path) -> None:
    made, one = made_one(tmp_path, steps=STEPS)
    made.start()
    assert made.wait(10_000)
    assert one.told == [("rate", 1.0), ("rate", 50.0), ("safe", 0.0)]
    assert one.is_closed
    view = made.view()
    assert view.step is not None
    assert (view.step.number, view.step.count, view.step.values) == (2, 2, (("made.rate", 50.0, "deg/s"),))
    assert 10.0 <= view.elapsed < 60.0


def test_a_fault_of_what_moves_ends_it_and_brings_about_the_safe_state(tmp_path: Path) -> None:
    made, one = made_one(tmp_path, steps=STEPS, refuses=40.0)
    made.start()
    with pytest.raises(InstrumentError):
        made.wait(10_000)
    assert one.told[:2] == [("rate", 1.0), ("safe", 0.0)]
    assert ("rate", 50.0) not in one.told
    assert made.view().state == "failed"
    assert "sequence_ended" in {told.remark.code for told in made.view().remarks}
    assert seal(tmp_path / "out").whole  # what came before is kept


def test_a_stop_is_safe_and_keeps_all_rows(tmp_path: Path) -> None:
    made, one = made_one(tmp_path, steps=STEPS.replace("5 s", "1000 s"))
    made.start()
    made.clock.wait(20.0)
    made.stop()
    assert made.wait(10_000)
    assert one.told[-1] == ("safe", 0.0)
    (view,) = made.view().instruments
    assert view.rows == view.acknowledged > 0
    summary = seal(tmp_path / "out")
    assert summary.instruments[0].rows == view.rows
    np.testing.assert_array_equal(read(tmp_path / "out" / "made.parquet").channel("value").data, np.arange(view.rows))


def test_it_ends_after_its_duration(tmp_path: Path) -> None:
    made, _ = made_one(tmp_path, more='duration = "10 s"')
    made.start()
    assert made.wait(10_000)
    assert 10.0 <= made.view().elapsed < 60.0


def test_a_disk_that_fills_is_announced_and_ends_it_before_it_is_full(tmp_path: Path) -> None:
    begin = 500e6

    def free(folder: Path) -> int:
        done = acquisition[0].view().elapsed if acquisition else 0.0
        return round(max(begin - 4e6 * done, 0.0))  # another program writes too

    acquisition: list[Acquisition] = []
    made, one = made_one(tmp_path, more='keep_free = "100 MB"\nwarn_before = "1e9 s"', free=free)
    acquisition.append(made)
    made.start()
    with pytest.raises(StoreError) as refused:
        made.wait(100_000)
    told = [one.remark for one in made.view().remarks]
    assert "the disk is full" in refused.value.problems[0].what
    assert "inertialcal acquire --seal" in refused.value.problems[0].do
    codes = [remark.code for remark in told]
    assert "disk_filling" in codes
    assert one.told[-1] == ("safe", 0.0)
    assert seal(tmp_path / "out").instruments[0].rows > 0


class SetBack(Clock):
    """A clock whose UTC is set back by an hour after 30 s."""

    def now(self) -> Instant:
        found = super().now()
        back = 3600 * 10**9 if found.monotonic_ns - self._monotonic > 30 * 10**9 else 0
        return Instant(found.monotonic_ns, found.utc_ns - back)


def test_times_go_on_when_utc_is_set_back_and_that_is_said(tmp_path: Path) -> None:
    lab = load_lab(lab_folder(tmp_path, MADE.format(more='duration = "60 s"')))
    clock = SetBack(200)
    made = Acquisition(lab, tmp_path / "out", clock, [Made(clock)])
    made.start()
    assert made.wait(10_000)
    summary = seal(tmp_path / "out")
    (said,) = (one for one in summary.remarks if one.code == "clock_set")
    assert said.what.startswith("the clock of this computer was set back by 3600.0 s")
    time_ns = read(tmp_path / "out" / "made.parquet").time_ns
    assert time_ns is not None
    assert np.all(np.diff(time_ns) >= 0)
    assert 50e9 < time_ns[-1] - time_ns[0] < 100e9


class Full(File):
    """A disk that takes so many bytes."""

    left = 20_000

    def write(self, data: bytes) -> None:
        if len(data) > self.left:
            super().write(data[: self.left])
            self.left = 0
            raise OSError(28, "No space left on device")
        self.left -= len(data)
        super().write(data)


def test_a_disk_that_is_full_all_the_same_loses_nothing_that_was_acknowledged(tmp_path: Path) -> None:
    made, one = made_one(tmp_path, disk=Full)
    made.start()
    with pytest.raises(StoreError) as refused:
        made.wait(100_000)
    acknowledged = made.view().instruments[0].acknowledged
    assert f"{acknowledged:,} of made" in refused.value.problems[0].why
    assert one.told[-1] == ("safe", 0.0)
    summary = seal(tmp_path / "out")
    assert not summary.whole
    assert summary.instruments[0].rows >= acknowledged > 0


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").write_text("mine")
    made, _ = made_one(tmp_path)
    with pytest.raises(StoreError) as refused:
        made.start()
    assert refused.value.problems[0].code == "not_empty"


def test_what_cannot_be_reached_is_said_with_its_place_and_nothing_is_written(tmp_path: Path) -> None:
    made = Acquisition(load_lab(lab_folder(tmp_path, MADE.format(more=""))), tmp_path / "out")
    with pytest.raises(InstrumentError) as refused:
        made.start()
    assert refused.value.problems[0].where == "LAB.toml:5"
    assert not (tmp_path / "out" / "recording.mcap").exists()


def test_nothing_to_seal_is_said(tmp_path: Path) -> None:
    with pytest.raises(InertialcalError) as refused:
        seal(tmp_path)
    assert refused.value.problems[0].code == "missing_file"


def test_what_is_shown_is_the_last_seconds_in_units(tmp_path: Path) -> None:
    made, _ = made_one(tmp_path, more='duration = "200 s"')
    made.start()
    assert made.wait(100_000)
    seconds, values = made.samples("made", 50)
    (view,) = made.view().instruments
    assert values[:, 0].tolist() == list(range(view.rows - 50, view.rows))
    assert np.all(np.diff(seconds) >= 0)
    recent = made.recent("made", 0.5, -20)
    assert 15 <= len(recent.parts) <= 20
    assert np.all(recent.high >= recent.low)
    assert recent.high[-1, 0] == view.rows - 1
    assert np.all(recent.low[1:, 0] == recent.high[:-1, 0] + 1)  # no sample is left out, none stands twice
    again = made.recent("made", 0.5, int(recent.parts[-3]))
    np.testing.assert_array_equal(again.parts, recent.parts[-3:])
    np.testing.assert_array_equal(again.low, recent.low[-3:])
    came, _ = made.samples("made", 10**6)
    count, later, values = made.since("made", 100)
    assert count == 100 + len(later)
    assert np.array_equal(later, came[100:])
    assert len(made.since("made", count)[2]) == 0
    late = came[came >= came[-1] - 5.0]
    assert view.row_rate == pytest.approx((len(late) - 1) / (late[-1] - late[0]))
    assert [(one.name, one.unit) for one in view.channels] == [("value", "deg/s")]
    assert view.identity == "made for a test"
    with pytest.raises(InstrumentError, match="There are: made"):
        made.samples("other", 5)


class Steady(Made):
    """An instrument of 100 rows a second, in lots of 10 s."""

    def stream(self, stop: threading.Event) -> Iterator[Batch]:
        for first in range(0, self.count, 1000):
            if self.clock.wait(10.0, stop):
                return
            yield Batch(np.arange(first, first + 1000, dtype=np.float64).view(self.layout.dtype), self.clock.now())


@pytest.mark.slow
def test_a_day_takes_no_more_memory_than_its_first_hours(tmp_path: Path) -> None:
    """Kernels of the screening are loaded once there is much to look through: on a slow computer after some hours."""
    lab = load_lab(lab_folder(tmp_path, MADE.format(more='duration = "24 h"').replace('"1 s"', '"30 s"')))
    clock = Clock(5000)
    made = Acquisition(lab, tmp_path / "out", clock, [Steady(clock)])
    made.start()
    held = []
    while not made.wait(3600.0):
        held.append(resident())
    rows = made.view().instruments[0].rows
    print(
        f"{rows:,} rows in 24 h: {1e-6 * held[11]:.0f} MB after 12 h, {1e-6 * max(held[11:]):.0f} MB at most after that"
    )
    assert rows > 1_000_000
    assert max(held[11:]) - held[11] < 10e6
    summary = seal(tmp_path / "out")
    assert summary.instruments[0].rows == made.view().instruments[0].rows


def resident() -> int:
    """Return the memory that this process takes now [byte]."""
    with open("/proc/self/statm") as stream:
        return int(stream.read().split()[1]) * 4096
