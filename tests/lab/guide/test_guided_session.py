"""A guided calibration of an IMU on a pty, from its first row to its files: the guide's end is that of `positions`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_hand import RATE, live_imu, stepped
from simulated_hand import CLEAN, Habits

import inertialcal as ic
from inertialcal.core.errors import UsageError
from inertialcal.core.key import Key
from inertialcal.core.recording import ClockRate
from inertialcal.core.results import Interval, Row
from inertialcal.lab.guide.engine import Known
from inertialcal.lab.guide.session import COUNTED, Asked, Session
from inertialcal.lab.guide.source import lab_for
from sized import sized

WANTED = {"bias": "0.2 mg", "scale_factor_error": "200 ppm", "misalignment": "0.023 deg"}
SAID = {"gravity": "9.807 m/s2"}
LIST = 24  # positions of a fixed list
IN_COUNTS = {"scale_factor": {"acc": "800 count/(m/s2)", "gyro": "800 count/(rad/s)"}}


def test_its_end_is_that_of_positions_on_what_was_recorded(tmp_path: Path) -> None:
    """Two positions are taken back on the way: what counts is without them, and the figures are those of the rest."""
    asked = Asked(WANTED, SAID, formats=("px4", "ros", "c"), labels={"z+": "label"})
    with live_imu(tmp_path / "one", 5, asked=asked) as (imu, session):
        back = [4, 9]
        while session.step():
            if back and session.shown.positions >= back[0]:
                session.undo()
                back.pop(0)
        live = session.shown.positions
        ended = session.end()
    folder = tmp_path / "one" / "out"
    assert ended.reached
    assert ended.found is not None
    assert session.shown.phase == "done"
    assert sum(text.startswith("Taken back") for text in session.shown.notices) == 2
    found = ic.positions(folder / COUNTED, shortest="3 s", **SAID)  # type: ignore[arg-type]
    assert [row.value for row in found.rows] == [row.value for row in ended.found.rows]
    assert len(found.result.readings) == session.shown.positions == pytest.approx(live, abs=3)
    results = json.loads((folder / "out" / "results.json").read_text())["results"]
    values = {
        (row["quantity"], row["axis"], row["sensor"]): row["value"] for row in results if row["value"] is not None
    }
    for row in found.rows:
        if row.value is not None and not row.case.beside:
            assert values[row.key.quantity, row.key.axis, row.key.sensor] == row.value
    recorded, counted = ic.read(folder / "imu.parquet"), ic.read(folder / COUNTED)
    assert len(counted) < len(recorded) - 6.0 * RATE  # two rests less
    assert counted.time_ns is not None
    assert np.diff(counted.time_ns).max() > 3e9
    truth = imu.hand.imu.truth()
    for row in found.result.rows():
        name = f"{row.key.quantity}_{row.key.axis}"
        if row.key.sensor == "accelerometer" and name in truth and row.u:
            assert abs(row.value - truth[name]) < 6.0 * row.u
    assert "CAL_ACC0_XOFF" in (folder / "calibration.px4").read_text()
    assert {"ros", "c acc", "c gyro"} <= {*ended.written}
    assert "double" in (folder / "calibration_acc.c").read_text()
    assert (folder / "out" / "report.html").stat().st_size > 10_000
    assert (folder / "out" / "model_gyro.json").exists()
    assert ic.run(folder).results["verdicts"] == []


def test_counts_take_the_chain_of_positions_and_an_early_end_is_no_end(tmp_path: Path) -> None:
    asked = Asked({**WANTED, "gyro.bias": "1 deg/h"}, SAID | IN_COUNTS)
    with live_imu(tmp_path / "one", 5, asked=asked, counts=True, per=800.0, warming=0.1) as (imu, session):
        while session.step():
            if session.shown.positions >= 11:
                session.finish()
        ended = session.end()
    assert not ended.reached
    assert ended.found is not None
    assert "before every figure" in session.shown.text
    assert "gyro bias z" in {one.name for one in ended.figures if one.asked and not one.reached}
    truth = imu.hand.imu.truth()
    live = {one.key.axis: one.value for one in ended.found.result.rows()
            if one.key.quantity == "bias" and one.key.sensor == "accelerometer" and one.value is not None}  # fmt: skip
    assert all(abs(live[axis] - truth[f"bias_{axis}"]) < 0.02 for axis in "xyz")
    assert any("temperature has risen" in text for text in session.shown.notices)
    assert " K since the beginning" in session.shown.temperature
    shrunk = [[one for one in past if one is not None] for past in session.shown.history.values()]
    assert any(len(past) > 1 and past[-1] < past[0] for past in shrunk)


def stuck(both: np.ndarray) -> np.ndarray:
    return np.where(np.arange(6) == 1, 0.25, both)


def railed(both: np.ndarray) -> np.ndarray:
    return np.where(np.arange(6) == 5, np.clip(both, -0.3, 0.3), both)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"per": 1.0 / 9.80665}, "--unit acc=g"),
        ({"change": stuck}, "acc_y reads 0.25 however it lies"),
        ({"change": railed}, "gyro z stays at one value while it turns"),
    ],
    ids=["wrong units", "stuck", "rail"],
)
def test_what_is_wrong_with_the_sensor_is_told_while_it_goes_on(
    tmp_path: Path, given: dict[str, Any], said: str
) -> None:
    with live_imu(tmp_path / "one", 5, asked=Asked(WANTED, SAID), **given) as (_, session):
        begin = session.clock.seconds()
        while session.step() and session.clock.seconds() - begin < 120.0:
            shown = session.shown
            if said in " ".join([shown.text, *shown.notices]):
                break
    assert said in " ".join([session.shown.text, *session.shown.notices])


def test_rows_that_nothing_can_be_made_of_are_refused(tmp_path: Path) -> None:
    with (
        live_imu(tmp_path / "one", 5, asked=Asked(WANTED, SAID), counts=True, per=800.0) as (_, session),
        pytest.raises(UsageError, match="acc in count: nothing says"),
    ):
        stepped(session)


def test_a_source_becomes_a_lab(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('[frame]\nkind = "lines"\n[[fields]]\nname = "acc_x"\n')
    grows = tmp_path / "log.txt"
    grows.touch()
    dialect = str(tmp_path / "mine.toml")
    sources: tuple[tuple[str, dict[str, Any], str], ...] = (
        (str(grows), {"dialect": dialect}, "file"), ("COM3", {"dialect": dialect, "baud": 9600}, "serial"),
        ("phone", {}, "phone"), ("hand_held", {}, "rig"),
    )  # fmt: skip
    for source, given, link in sources:
        lab = lab_for(source, **given)
        (entry,) = lab.file.instruments.values()
        assert entry.link == link
        assert f'link = "{link}"' in lab.text
    for source, said in ((str(tmp_path / "none"), ""), ("none", dialect), ("allan_only", "")):
        with pytest.raises(UsageError) as caught:
            lab_for(source, said)
        assert caught.value.problems[0].code == "no_source"
    with pytest.raises(UsageError, match="--baud"):
        lab_for(str(grows), dialect, 9600)
    with pytest.raises(UsageError, match="no instrument gives three"):
        Session(lab_for(str(grows), dialect), tmp_path / "out", Asked())


@pytest.mark.parametrize(("wanted", "standards", "is_said"), [(2e-4, {}, True), (2e-3, {}, False),
                                                              (2e-4, {"clock.rate": "1 ppm"}, False)])  # fmt: skip
def test_a_clock_that_no_position_makes_better_is_told(
    tmp_path: Path, wanted: float, standards: dict[str, str], is_said: bool
) -> None:
    session = Session(lab_for("hand_held"), tmp_path / "out", Asked(WANTED, SAID | {"standards": standards}))
    row = Row(Key("scale_factor_error", "x", "gyro"), 0.01, 6e-4, "1", None, Interval(0.008, 0.012))
    session._look_for_the_clock([Known(row, wanted, 1.2)], ClockRate(5.8e-4))
    assert any("clock is known to 0.058 %" in text for text in session.shown.notices) == is_said


@pytest.mark.slow
def test_fewer_positions_than_a_list_on_the_median_over_a_pty(tmp_path: Path) -> None:
    counts = []
    for seed in range(1, sized(50, 5) + 1):
        with live_imu(tmp_path / str(seed), seed, Habits(), 12, Asked(WANTED, SAID)) as (_, session):
            codes = stepped(session)
            assert session.shown.phase == "working", (seed, codes[-3:])
            counts.append(session.shown.positions)
    print(f"{len(counts)} twins: median {np.median(counts):g} positions, {min(counts)} to {max(counts)}")
    assert np.median(counts) < LIST


def test_a_hand_without_mistakes_is_told_of_none(tmp_path: Path) -> None:
    """Nothing shakes, nothing is repeated, nothing is unplugged: what is said must be about that alone."""
    with live_imu(tmp_path / "one", 7, CLEAN, asked=Asked(WANTED, SAID)) as (_, session):
        codes = []
        while session.step() and session.shown.positions < 4:
            codes.append(session.shown.code)
    assert {*codes} <= {"waiting", "lay_down", "hold_still", "turn"}
    assert session.shown.notices == ()
