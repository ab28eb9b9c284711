"""The command: how it ends, what it prints, and that what it recorded gives the figures that its campaign gives."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lab_devices import REHEARSAL, lab_folder

import inertialcal as ic
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.twins.twin import write_twin
from inertialcal.files import read
from inertialcal.lab.acquisition.acquisition import Acquisition
from inertialcal.lab.acquisition.lab_file import load_lab
from inertialcal.lab.acquisition.seal import seal
from inertialcal.lab.clock import Clock
from inertialcal.lab.instruments.device import Device
from inertialcal.lab.instruments.dialect import Dialect, FieldEntry, FrameEntry
from inertialcal.lab.instruments.links.network import SocketLink
from inertialcal.lab.instruments.links.serial import SerialLink
from inertialcal.lab.instruments.served import Served
from npsat1_small import short_twin
from typed_commands import call, call_json

COMMAND = [sys.executable, "-m", "inertialcal"]
SLOW_REHEARSAL = REHEARSAL.replace("speed = 1000", "speed = 100").replace('"60 s"', '"20 s"')


def started(folder: Path) -> subprocess.Popen[str]:
    """Return a process that records, once rows are on the disk."""
    lab_folder(folder, SLOW_REHEARSAL.format(over="tcp", faults=""))
    process = subprocess.Popen(
        [*COMMAND, "acquire", "LAB.toml", "-o", "out"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, env=os.environ,
    )  # fmt: skip
    path, until = folder / "out" / "recording.mcap", time.monotonic() + 60.0
    while time.monotonic() < until and not (path.exists() and path.stat().st_size > 10_000):
        time.sleep(0.01)
    return process


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_an_interruption_ends_it_cleanly(tmp_path: Path, number: signal.Signals) -> None:
    process = started(tmp_path)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "sealed: out" in out
    content = json.loads((tmp_path / "out" / "acquisition.json").read_text())
    assert content["finished"]
    assert len(read(tmp_path / "out" / "suite.parquet")) == content["instruments"][0]["rows"] > 0


def test_what_a_kill_leaves_behind_is_sealed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    process = started(tmp_path)
    process.kill()
    process.communicate(timeout=60)
    found = call_json(capsys, "acquire", "--seal", str(tmp_path / "out"))
    assert not found["finished"]
    assert "torn_file" in {one["code"] for one in found["remarks"]}
    assert found["instruments"][0]["rows"] == len(read(tmp_path / "out" / "suite.parquet")) > 0
    status, out, _ = call(capsys, "acquire", "--seal", str(tmp_path / "out"))
    assert status == 0
    assert "all that is whole was sealed" in out


def test_its_object_holds_clocks_and_intervals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = lab_folder(tmp_path, REHEARSAL.format(over="tcp", faults="").replace("1000", "20000"))
    found = call_json(capsys, "acquire", str(path), "-o", str(tmp_path / "out"))
    (one,) = found["instruments"]
    assert one["save_intervals"]["odd"] == [
        {"length": 3.0, "count": 24}, {"length": 5.0, "count": 1}, {"length": 6.0, "count": 2}
    ]  # fmt: skip
    assert one["clocks"]["drift"]["u"] > 0
    status, _, err = call(capsys, "acquire", str(path), "-o", str(tmp_path / "out"))
    assert status == 3
    assert "inertialcal acquire --seal" in err


@pytest.mark.parametrize(
    ("words", "what"),
    [
        ((), "acquire needs LAB.toml, or --seal and a folder"),
        (("LAB.toml",), "acquire needs a new folder"),
        (("LAB.toml", "-o", "out", "--seal", "out"), "acquire needs LAB.toml, or --seal and a folder"),
    ],
)
def test_wrong_usage_is_said(capsys: pytest.CaptureFixture[str], words: tuple[str, ...], what: str) -> None:
    status, _, err = call(capsys, "acquire", *words)
    assert status == 2
    assert what in err


def test_a_mistake_in_lab_toml_is_said_with_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = lab_folder(tmp_path, REHEARSAL.format(over="tcp", faults="").replace("npsat1", "npsat2"))
    status, _, err = call(capsys, "acquire", str(path), "-o", str(tmp_path / "out"))
    assert status == 3
    assert err.startswith("error: LAB.toml:6: no rig 'npsat2'")
    assert not (tmp_path / "out").exists()


# ---- the small campaign of the suite, recorded live ----

COMMENT = "#"
SPEED = 100_000


def served_lines(path: Path) -> tuple[Dialect, list[tuple[float, bytes]], str]:
    """Return dialect and lines of a CSV of the campaign, as its logger would send them: text by text."""
    head, *lines = path.read_text().splitlines()
    names = head.split(",")
    table = [line.split(",") for line in lines]
    fields = []
    for i, name in enumerate(names):
        whole = all(re.fullmatch(r"-?\d+", row[i]) for row in table)
        plain = re.match(r"\w+", name)
        assert plain is not None
        role = "time" if i == 0 else "reading"
        fields.append(FieldEntry(name=plain[0], type="int64" if whole else "float64", role=role,  # type: ignore[arg-type]
                                 unit="s" if i == 0 else ""))  # fmt: skip
    begin = float(table[0][0])
    sent = [(float(row[0]) - begin, f"{line}\n".encode()) for row, line in zip(table, lines, strict=True)]
    return Dialect(frame=FrameEntry(kind="lines"), fields=tuple(fields)), sent, head


def record_live(folder: Path, csv: Path, over: str) -> Path:
    """Record a CSV that a device sends; return the Parquet file."""
    folder.mkdir()
    dialect, sent, head = served_lines(csv)
    clock = Clock(SPEED)
    served = Served(sent, clock, over, f"{COMMENT}{head}\n".encode()).start()
    link = SerialLink(served.address, 115_200, clock) if over == "serial" else SocketLink(served.address, False, clock)
    one = Device("suite", link, dialect, clock)
    text = (
        'schema = 1\n[lab]\nsync = "60 s"\n[instruments.suite]\nlink = "file"\naddress = "x"\ndialect = "mine.toml"\n'
    )
    mine = '[frame]\nkind = "lines"\n[[fields]]\nname = "a"\n'
    made = Acquisition(load_lab(lab_folder(folder, text, mine=mine)), folder / "out", clock, [one])
    made.start()
    served.ready()
    while made.view().instruments[0].rows < len(sent):
        assert not made.wait(0.01 * SPEED)
    made.stop()
    assert made.wait(60.0 * SPEED)
    served.close()
    seal(folder / "out")
    return folder / "out" / "suite.parquet"


@pytest.mark.parametrize("over", ["serial", "tcp"])
def test_a_record_that_is_recorded_live_gives_the_figures_of_the_recorded_one(tmp_path: Path, over: str) -> None:
    twin = replace(
        short_twin(3, table_runs=3, table_fit_runs=2, static_hours=0.3, chamber_runs=3), rig="npsat1", seed=3
    )
    write_twin(twin, tmp_path / "recorded")
    csv = tmp_path / "recorded" / "recordings" / "static_1.csv"
    found = record_live(tmp_path / "lab", csv, over)
    stated = {"clock.rate": "20 ppm"}  # else what acquire found out of the clock goes into u
    first, second = (
        ic.allan(path, columns=["x", "y", "z"], sample_rate=0.5, standards=stated).rows for path in (csv, found)
    )
    assert len(first) == len(second) > 3
    for one, other in zip(first, second, strict=True):
        assert (one.value, one.u) == (other.value, other.u)


@pytest.mark.slow
def test_a_campaign_that_is_recorded_live_gives_the_figures_of_the_recorded_one(tmp_path: Path) -> None:
    twin = replace(
        short_twin(3, table_runs=3, table_fit_runs=2, static_hours=0.3, chamber_runs=3), rig="npsat1", seed=3
    )
    write_twin(twin, tmp_path / "recorded")
    write_twin(twin, tmp_path / "live")
    text = (tmp_path / "live" / "campaign.toml").read_text()
    for number, name in enumerate(twin.recordings):
        found = record_live(tmp_path / f"lab_{number}", tmp_path / "live" / name, ("serial", "tcp")[number % 2])
        (tmp_path / "live" / name).unlink()
        taken = name.replace(".csv", ".parquet")
        found.rename(tmp_path / "live" / taken)
        text = text.replace(f'"{name}"', f'"{taken}"')
    recorded = (tmp_path / "recorded" / "campaign.toml").read_text()
    for folder, plan in (("recorded", recorded), ("live", text)):  # else u holds what acquire found out of the clock
        clock = '\n[standards.clock]\nrate = { u = "20 ppm" }\n'
        (tmp_path / folder / "campaign.toml").write_text(plan + clock)
    first, second = (run(tmp_path / folder, write=False).results for folder in ("recorded", "live"))
    assert len(first["results"]) == len(second["results"]) > 20
    for one, other in zip(first["results"], second["results"], strict=True):
        assert (one["quantity"], one["axis"], one["status"]) == (other["quantity"], other["axis"], other["status"])
        for key in ("value", "u"):
            if one[key] is not None:
                np.testing.assert_allclose(other[key], one[key], rtol=1e-12, err_msg=str(one))
