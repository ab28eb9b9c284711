"""Every way in which a step can end: its name in the log, never PASS, all safe; and what comes after it."""

from __future__ import annotations

import csv
import threading
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import short_rig

from inertialcal.core.errors import InertialcalError, StoreError
from inertialcal.core.recording import Recording
from inertialcal.files import read
from inertialcal.files.write.recording import write
from inertialcal.lab.acquisition.acquisition import Acquisition
from inertialcal.lab.acquisition.lab_file import Lab, load_lab
from inertialcal.lab.clock import Clock
from inertialcal.lab.instruments.device import Device
from inertialcal.lab.instruments.links.bench import Bench, BenchLink, bench_of
from inertialcal.lab.instruments.links.link import LinkLostError
from inertialcal.lab.sequence import store as store_module
from inertialcal.lab.sequence.campaign_entries import campaign_problems
from inertialcal.lab.sequence.operator import Operator
from inertialcal.lab.sequence.sequence import Sequence
from typed_commands import call

PATIENCE = 60.0  # [s] of this machine
STEPS = """schema = 1
[lab]
speed = 100000
sync = "60 s"
[instruments.bench]
link = "bench"
rig = "short_table"
seed = 1
limits = {{ recording = ["1", "6"], rate = ["-5 deg/s", "5 deg/s"] }}
[sequence]
{more}
[[sequence.steps]]
name = "at rest"
recording = "one"
{prompt}
set = {{ "bench.recording" = "1", "bench.rate" = "0 deg/s" }}
stable = {{ channel = "rate_dps", follows = "bench.rate", within = "0.001 deg/s", for = "4 s", limit = "30 s" }}
record = {{ for = "20 s" }}
[[sequence.steps]]
name = "turning"
recording = "one"
set = {{ "bench.rate" = "{rate} deg/s" }}
stable = {{ channel = "rate_dps", follows = "bench.rate", within = "0.001 deg/s", for = "4 s", limit = "30 s" }}
record = {record}
"""


class Watched(BenchLink):
    """A bench that remembers what it was told, and is lost where a test says so."""

    def __init__(self, bench: Bench, clock: Clock) -> None:
        super().__init__(bench, clock)
        self.told: list[str] = []
        self.lost_after = self.deaf_after = self.mute_after = 2**62  # commands

    def read(self, wait: float) -> list[bytes]:
        if len(self.told) >= self.lost_after:
            raise LinkLostError("made: unplugged")
        found = super().read(wait)
        return [] if len(self.told) >= self.mute_after else found

    def write(self, data: bytes) -> None:
        if len(self.told) >= self.deaf_after:
            raise LinkLostError("made: unplugged")
        self.told.append(data.decode().strip())
        super().write(data)


def lab_of(folder: Path, more: str = "", record: str = '{ for = "20 s" }', rate: str = "1.5", prompt: str = "") -> Lab:
    """Write and read LAB.toml with two steps."""
    short_rig.add_rigs()
    path = folder / "LAB.toml"
    path.write_text(STEPS.format(more=more, record=record, rate=rate, prompt=prompt))
    return load_lab(path)


def changed(change: Callable[[np.ndarray], None]) -> Bench:
    """Return the bench with other rates in what it says of its first recording."""
    bench = bench_of(short_rig.TABLE, 1)
    rows = bench.rows[0].copy()
    change(rows["rate_dps"])
    return replace(bench, rows=(rows, *bench.rows[1:]))


def conducted(
    lab: Lab,
    folder: Path,
    bench: Bench | None = None,
    operator: Operator | None = None,
    faults: Mapping[str, int] | None = None,
) -> tuple[Sequence, Watched, str]:
    """Go through a sequence; return it, the bench, and the code of what ended it."""
    clock = lab.clock()
    link = Watched(bench or bench_of(short_rig.TABLE, 1), clock)
    for name, value in (faults or {}).items():
        setattr(link, name, value)
    made = Sequence(lab, folder, operator or Operator(answers=True))
    device = Device("bench", link, lab.dialects["bench"], clock, lambda remark: None, lab.limits["bench"])
    acquisition = Acquisition(lab, made.acquired(), clock, [device], conductor=made)
    acquisition.start()
    code = ""
    try:
        assert acquisition.wait(PATIENCE * clock.speed)
    except InertialcalError as error:
        code = error.problems[0].code
    made.log.close()
    return made, link, code


def went_on(lab: Lab, folder: Path) -> None:
    """Go on with a sound bench: all is PASS in the end."""
    made, _, code = conducted(lab, folder)
    assert code == ""
    assert made.complete


def wander(rate: np.ndarray) -> None:
    rate += 0.1 * np.arange(len(rate)) % 0.7


def leave(rate: np.ndarray) -> None:
    turning = np.flatnonzero(np.abs(rate - 1.5) < 1e-6)
    rate[turning[8]] += 0.01


@pytest.mark.parametrize(
    ("code", "change", "given", "faults"),
    [
        ("not_stable", wander, {}, {}),
        ("left_stable", leave, {}, {}),
        (
            "u_not_reached",
            None,
            {"record": '{ for = "10 s", u = "0.001 count", channels = ["x"], limit = "30 s" }'},
            {},
        ),
        ("no_rows", None, {"rate": "1.7", "more": 'silence = "5 s"'}, {}),
        ("no_rows", None, {"more": 'silence = "5 s"'}, {"mute_after": 3}),
        ("unplugged", None, {}, {"lost_after": 3}),
        ("unreachable", None, {}, {"deaf_after": 2}),
    ],
)
def test_a_step_that_fails_is_named_is_not_pass_and_all_is_safe(
    tmp_path: Path,
    code: str,
    change: Callable[[np.ndarray], None] | None,
    given: dict[str, str],
    faults: dict[str, int],
) -> None:
    lab = lab_of(tmp_path, **given)
    made, link, ended = conducted(lab, tmp_path / "made", changed(change) if change else None, faults=faults)
    last = made.log.rows[-1]
    assert not made.complete
    assert last.status == "FAILED"
    if code == "unplugged":  # whoever sees it first: it is recorded, and it moves
        assert {ended, last.code} <= {"unplugged", "unreachable"}
    else:
        assert (ended, last.code) == (code, code)
        assert code == "unreachable" or link.told[-1] == "SAFE"
    if "rate" not in given and "record" not in given:
        went_on(lab, tmp_path / "made")


def test_it_is_tried_again_as_often_as_is_said(tmp_path: Path) -> None:
    lab = lab_of(tmp_path, more="tries = 3")
    made, _, ended = conducted(lab, tmp_path / "made", changed(leave))
    assert ended == "left_stable"
    assert [(row.step, row.status, row.attempt) for row in made.log.rows] == [
        (1, "PASS", 1), (2, "FAILED", 1), (2, "FAILED", 2), (2, "FAILED", 3)
    ]  # fmt: skip


def test_a_record_that_does_not_read_back_is_not_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def flipped(path: Path) -> Recording:
        found = read(path)
        first = found.channels[0]
        data = first.data.copy()
        data[-1] += 1
        return replace(found, channels=(replace(first, data=data), *found.channels[1:]))

    lab = lab_of(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(store_module, "read", flipped)
        made, link, ended = conducted(lab, tmp_path / "made")
    assert (ended, made.log.rows[-1].code, link.told[-1]) == ("not_read_again", "not_read_again", "SAFE")
    assert not made.passed
    went_on(lab, tmp_path / "made")


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-100])


def flip(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 4] ^= 1
    path.write_bytes(data)


@pytest.mark.parametrize("harm", [Path.unlink, cut, flip])
@pytest.mark.parametrize("when", ["before", "after"])
def test_a_file_that_is_harmed_while_it_is_read_again_is_not_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, harm: Callable[[Path], None], when: str
) -> None:
    """Between writing and reading, and between reading and taking its SHA-256."""

    def reading(path: Path) -> Recording:
        found = read(path)
        harm(path)
        return found

    def writing(path: Path, recording: Recording) -> None:
        write(path, recording)
        harm(path)

    lab = lab_of(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(store_module, *(("write", writing) if when == "before" else ("read", reading)))
        made, link, ended = conducted(lab, tmp_path / "made")
    assert (ended, made.log.rows[-1].code, link.told[-1]) == ("not_read_again", "not_read_again", "SAFE")
    assert not made.passed
    assert "PASS" not in {row.status for row in made.log.rows}


@pytest.mark.parametrize("harm", [Path.unlink, cut, flip])
def test_a_file_that_is_harmed_after_pass_makes_no_campaign_and_is_made_anew(
    tmp_path: Path, harm: Callable[[Path], None]
) -> None:
    lab = lab_of(tmp_path)
    made, _, ended = conducted(lab, tmp_path / "made")
    assert (ended, made.complete) == ("", True)
    (tmp_path / "campaign").mkdir()
    (tmp_path / "campaign" / "campaign.toml").write_text('[recordings.one]\nfile = "one.parquet"\n')
    harm(tmp_path / "made" / made.records[2].file)
    with pytest.raises(StoreError) as caught:
        store_module.build_campaign(tmp_path / "campaign", tmp_path / "made", lab.sequence, made.records)
    assert caught.value.problems[0].code == "damaged_file"
    again = Sequence(lab, tmp_path / "made", Operator(answers=True))
    again.log.close()
    assert again.passed == set()
    went_on(lab, tmp_path / "made")


def test_two_instruments_with_one_quantity_have_columns_of_their_own(tmp_path: Path) -> None:
    lab = lab_of(tmp_path)
    made, _, _ = conducted(lab, tmp_path / "made")
    steps = [replace(one, values=(*one.values, ("oven", "rate", 7.0))) for one in lab.sequence]
    campaign = tmp_path / "campaign"
    campaign.mkdir()
    text = '[recordings.one]\nfile = "one.parquet"\nschedule = {{ file = "one.csv", unit = "deg/s"{} }}\n'
    (campaign / "campaign.toml").write_text(text.format(""))
    (problem,) = campaign_problems(campaign, steps, "LAB.toml:1")
    assert problem.code == "unknown_name"
    assert "bench.rate, oven.rate" in problem.do
    assert campaign_problems(campaign, lab.sequence, "LAB.toml:1") == []
    (campaign / "campaign.toml").write_text(text.format(', rate = "bench.rate"'))
    assert campaign_problems(campaign, steps, "LAB.toml:1") == []
    store_module.build_campaign(campaign, tmp_path / "made", steps, made.records)
    with (tmp_path / "made" / "campaign" / "one.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(float(row["bench.rate"]), float(row["oven.rate"])) for row in rows] == [(0.0, 7.0), (1.5, 7.0)]
    assert "recording" in rows[0]


def test_an_operator_who_stops_a_record_ends_it_safely(tmp_path: Path) -> None:
    lab, operator = lab_of(tmp_path, record='{ for = "1000 s" }', more='silence = "10 h"'), Operator(answers=True)
    stop = threading.Timer(1.5, operator.say, ["stop"])
    stop.start()
    made, link, ended = conducted(lab, tmp_path / "made", operator=operator)
    stop.join()
    assert (ended, made.log.rows[-1].code, link.told[-1]) == ("operator_stop", "operator_stop", "SAFE")
    assert 2 not in made.passed
    assert [row.status for row in made.log.rows if row.step == 2] in ([], ["FAILED"])


def test_a_record_that_cannot_be_written_is_not_pass(tmp_path: Path) -> None:
    lab = lab_of(tmp_path)
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "records").write_text("a file stands in the way")
    made, link, ended = conducted(lab, tmp_path / "made")
    assert (ended, link.told[-1]) == ("not_written", "SAFE")
    assert not made.passed


def test_the_operator_is_asked_and_may_pause_and_stop(tmp_path: Path) -> None:
    """A prompt waits; a pause has the step done anew; a stop ends it safely, and it goes on from there."""
    lab, operator = lab_of(tmp_path, prompt='prompt = "Mount it with x up"'), Operator()
    asked: list[str] = []

    def person() -> None:
        while not operator.asked:
            operator_seen.wait(0.01)
        asked.append(operator.asked)
        operator.say("pause")
        operator.say("done")
        operator_seen.wait(0.3)
        operator.say("stop")

    operator_seen = threading.Event()
    thread = threading.Thread(target=person)
    thread.start()
    made, link, ended = conducted(lab, tmp_path / "made", operator=operator)
    thread.join()
    assert asked == ["Mount it with x up"]
    assert (ended, link.told[-1]) == ("operator_stop", "SAFE")
    assert "PASS" not in {row.status for row in made.log.rows}
    went_on(lab, tmp_path / "made")


def test_a_record_ends_as_soon_as_it_is_known_well_enough(tmp_path: Path) -> None:
    lab = lab_of(tmp_path, record='{ for = "10 s", u = "2 count", channels = ["x"], limit = "230 s" }')
    made, _, ended = conducted(lab, tmp_path / "made", bench_of(short_rig.LONG, 1))
    assert ended == ""
    early = made.log.rows[-1]
    assert 0.0 < float(early.u) <= 2.0
    assert 46 <= early.rows < 100


def test_a_file_with_mistakes_is_refused_with_their_lines(tmp_path: Path) -> None:
    short_rig.add_rigs()
    path = tmp_path / "LAB.toml"
    text = STEPS.format(more='campaign = "missing"', record='{ for = "20 s", u = "1 count" }', rate="7", prompt="")
    path.write_text(
        text.replace('channel = "rate_dps"', 'channel = "rate"', 1).replace("[lab]", '[lab]\nduration = "1 h"')
    )
    with pytest.raises(InertialcalError) as caught:
        load_lab(path)
    codes = [one.code for one in caught.value.problems]
    assert codes == ["unknown_name", "beyond_limits", "missing_key", "unknown_key", "missing_file"]
    assert all(one.where for one in caught.value.problems)


def test_rows_of_a_schedule_are_steps(tmp_path: Path) -> None:
    short_rig.add_rigs()
    head = STEPS.format(more="", record="{}", rate="0", prompt="").partition("[[sequence.steps]]")[0]
    (tmp_path / "LAB.toml").write_text(head + """[sequence.schedule]
file = "schedule.csv"
set = { "bench.rate" = "rate" }
recording = "one"
prompt = "Turn to {name}"
name = "position"
record = { for = "5 s" }
""")  # fmt: skip
    (tmp_path / "schedule.csv").write_text("position,start [min],stop [min],rate [deg/min]\nA,0,1,60\nB,2,4,-120\n")
    steps = load_lab(tmp_path / "LAB.toml").sequence
    assert [one.name for one in steps] == ["A", "B"]
    assert [one.prompt for one in steps] == ["Turn to A", "Turn to B"]
    assert [one.values[0][2] for one in steps] == pytest.approx([1.0, -2.0])
    assert [one.record.least for one in steps if one.record] == [60.0, 120.0]
    (tmp_path / "schedule.csv").write_text("position,start [min],stop [min],rate [deg/s]\nA,0,1,6\n")
    with pytest.raises(InertialcalError) as caught:
        load_lab(tmp_path / "LAB.toml")
    assert caught.value.problems[0].code == "beyond_limits"
    assert caught.value.problems[0].where == "schedule.csv:2"


def test_a_programme_that_was_planned_is_a_sequence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Names, recordings, prompts, rates and durations of `plan rate-table`."""
    short_rig.add_rigs()
    words = ["--noise", "0.2 deg/sqrt(h)", "--fastest", "4 deg/s", "--latitude", "36.6 deg", "--wanted",
             "scale_factor_error=500 ppm", "--simulate", "0", "--schedule", str(tmp_path / "schedule.csv")]  # fmt: skip
    assert call(capsys, "plan", "rate-table", *words)[0] == 0
    head = STEPS.format(more="", record="{}", rate="0", prompt="").partition("[[sequence.steps]]")[0]
    (tmp_path / "LAB.toml").write_text(head + """[sequence.schedule]
file = "schedule.csv"
set = { "bench.rate" = "rate" }
name = "name"
recording = "recording"
prompt = "prompt"
duration = "duration"
record = { for = "1 s" }
""")  # fmt: skip
    steps = load_lab(tmp_path / "LAB.toml").sequence
    assert steps[0].name == "x run 1 dwell 1"
    assert steps[0].recording == "x_run1"
    assert "along the axis of the table" in steps[0].prompt
    assert not steps[1].prompt
    assert {one.values[0][2] for one in steps} == {-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0}
    assert all(one.record is not None and one.record.least >= 5.0 for one in steps)
