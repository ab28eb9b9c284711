"""Files that messages give advice on: short logs whose truth is known, each with one thing that it does not say."""

from __future__ import annotations

import shutil
import sqlite3
from functools import partial
from pathlib import Path

import numpy as np
from newcomer_boards import Board, board_at_rest, six_faces
from newcomer_tables import FILES, Columns, rounded
from newcomer_tables import csv as csv_bytes
from newcomer_truths import Log, at_rest, chamber, rate_table

LOGS = {"allan": partial(at_rest, minutes=1.0), "thermal": partial(chamber, hours=0.4),
        "rate-table": partial(rate_table, dwell=5.0)}  # fmt: skip
PER_COUNT = 16.4  # counts per deg/s of a digital gyro
CAMPAIGN = """schema = 2
[campaign]
id = "advised"
[sensors.suite]
kind = "gyro"
axes = ["x"]
unit = "deg/s"
[recordings.table]
sensor = "suite"
file = "dwells_units.csv"
rows = { applied = "rate", reading = "reading", scatter = "reading_std", samples = "n", unit = "deg/s" }
[[tests]]
id = "rate"
procedure = "rate_table"
recordings = ["table"]
plan = { axis = "x" }
"""
LAB = """schema = 1
[lab]
speed = 20000
sync = "60 s"
{}
[instruments.suite]
link = "rig"
rig = "npsat1"
recording = "x_run1"
over = "tcp"
interval = "2 s"
"""
SEQUENCE = """[sequence]
[[sequence.steps]]
name = "at rest"
record = { for = "30 s" }
"""
GUIDE = """schema = 1
[lab]
speed = 100
[instruments.imu]
link = "rig"
rig = "hand_held"
recording = "hand1"
"""
CAMPAIGNS = ("campaign", "campaign_new", "campaign_new2")  # never run, so far
FOLDERS = ("no_campaign", "no_campaign3")


def write_files(folder: Path) -> None:
    """Write every file into a folder."""
    logs = {name: made() for name, made in LOGS.items()}
    (folder / "LAB.toml").write_text(LAB.format(""))
    (folder / "SEQUENCE.toml").write_text(LAB.format("") + SEQUENCE)
    (folder / "GUIDE.toml").write_text(GUIDE)
    (folder / "FULL.toml").write_text(LAB.format('keep_free = "900000 TB"'))
    texts = {made.name: made.write(logs[made.noun]).decode() for made in FILES}
    for text in (
        texts,
        _rest(logs["allan"], texts),
        _turned(logs["rate-table"], texts),
        _chamber(texts),
        _boards(),
        _without_units(texts),
        _waves(),
    ):
        for name, content in text.items():
            (folder / name).write_text(content)
    _binary(folder, logs["allan"])
    for name in (*CAMPAIGNS, *FOLDERS):
        (folder / name).mkdir()
        (folder / name / "dwells_units.csv").write_text(texts["dwells_units.csv"])
    for name in CAMPAIGNS:
        (folder / name / "campaign.toml").write_text(CAMPAIGN)


def csv(columns: Columns) -> str:
    """Return columns as comma-separated text."""
    return csv_bytes(columns).decode()


def _without_units(texts: dict[str, str]) -> dict[str, str]:
    """Return a file without a header, and an export that names no units."""
    ticks = "".join(f"{i},{500 + 100 * i},0.1,0.2,9.8,0.01,0.02,{0.03 + 0.001 * (i % 7)}\n" for i in range(200))
    return {
        "nameless.csv": texts["chamber_units.csv"].split("\n", 1)[1],
        "xsens.csv": f"PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n{ticks}",
    }


def _head(text: str, *replaced: tuple[str, str]) -> str:
    """Return a text with other names in its header."""
    head, rest = text.split("\n", 1)
    for old, new in replaced:
        assert old in head, (old, head)
        head = head.replace(old, new)
    return f"{head}\n{rest}"


def _columns(text: str, keep: slice) -> str:
    """Return some columns of a text."""
    return "\n".join(",".join(row.split(",")[keep]) for row in text.splitlines()) + "\n"


def _rest(log: Log, texts: dict[str, str]) -> dict[str, str]:
    """Return logs of a gyro at rest, 50 Hz."""
    plain = texts["rest_units.csv"]
    title = ",".join(["Test", "Lab", "Bench", "Day", "Run", "By", "At"][: 1 + plain.split("\n")[0].count(",")])
    bare = _head(plain, *((f"gyro_{axis} [deg/s]", f"gyro_{axis}") for axis in "xyz"))
    ms = np.rint(1e3 * log.time).astype(int)
    n = len(log.time)
    gyro = {f"gyro_{axis} [deg/s]": rounded(values, 6) for axis, values in log.readings.items()}
    packets = np.repeat(log.time[::10], 10)[:n] + np.tile(np.arange(10) * 1e-4, n // 10 + 1)[:n]
    jumped = log.time - np.where(np.arange(n) >= n // 2, 11.013, 0.0)
    days = [f"3/{12 + int(t // 30)}/2024 09:15:{t % 30:06.3f}" for t in log.time]
    mixed = [f"3/12/2024 09:{15 + int(t // 60)}:{t % 60:06.3f}" for t in log.time]
    increments = {f"{name[:6]} [deg]": rounded(np.asarray(values) / 50.0, 9) for name, values in gyro.items()}
    sums = {name: rounded(np.cumsum(values), 9) for name, values in increments.items()}
    return {
        "no_time.csv": _columns(plain, slice(1, None)),
        "bare.csv": bare,
        "titled.csv": f"{title}\n{plain}",
        "no_header.csv": "\n".join(f"{t},{x},{y}" for t, x, y in zip(ms, *list(gyro.values())[:2], strict=True)) + "\n",
        "restarted.csv": csv({"stamp": [int(t) for t in np.where(ms >= ms[n // 2], ms - ms[n // 2], ms)], **gyro}),
        "bursts.csv": csv({"time_s": rounded(packets, 4), **gyro}),
        "milliseconds.csv": csv({"time_s": [int(t) for t in ms], **gyro}),
        "dated.csv": csv({"time": mixed, **gyro}),
        "dates_mixed.csv": csv({"time": days, **gyro}),
        "clock_set.csv": csv({"time_s": rounded(jumped, 3), **gyro}),
        "grouped.csv": csv({"time_s": rounded(log.time, 3), "gyro_x [deg/s]": ['"1,234"'] * n}),
        "grouped_whole.csv": csv({"time_s": rounded(log.time, 3), "gyro_x [deg/s]": ['"1,234"', "2"] * (n // 2)}),
        "temperatures.csv": csv({"time_s": rounded(log.time, 3), "warm": ["20"] * 5 + ["21"] * (n - 5)}),
        "rest_more.csv": csv({"time_s": rounded(log.time, 3), **gyro, "extra": gyro["gyro_x [deg/s]"]}),
        "rest_two.csv": _columns(plain, slice(0, 3)),
        "angles.csv": csv({"time_s": rounded(log.time, 3), **increments}),
        "angles_summed.csv": csv({"time_s": rounded(log.time, 3), **sums}),
    }


def _turned(log: Log, texts: dict[str, str]) -> dict[str, str]:
    """Return logs of a gyro on a rate table, and tables of its dwells."""
    plain, dwells = texts["turned_units.csv"], texts["dwells_units.csv"]
    bare = [(f"gyro_{axis} [deg/s]", f"gyro_{axis}") for axis in "xyz"]
    _, *rows = dwells.splitlines()
    cells = [row.split(",") for row in rows]
    digital = [[rate, str(PER_COUNT * float(reading)), str(PER_COUNT * float(scatter)), n]
               for rate, reading, scatter, n in cells]  # fmt: skip
    counted = _head(texts["turned_counts.csv"], *((f"gyro_{axis}", f"gyro_{axis} [deg/s]") for axis in "xyz"))
    raw, *rows = texts["turned_counts.csv"].splitlines()
    measured = [f"{raw},v_ref", *(f"{row},{2047 + i % 2}" for i, row in enumerate(rows))]  # 2.5 V, to a half count
    head = next(one for one in plain.splitlines()[0].split(",") if one.startswith("table_rate"))
    at = plain.splitlines()[0].split(",").index(head)
    steps = [0, 20, 40, 60, 80, 0, -20, -40, -60, -80, 0]  # deg/s, 5 s each
    return {
        "turned_bared.csv": "\n".join(",".join(cell for i, cell in enumerate(row.split(",")) if i != at)
                                      for row in plain.splitlines()) + "\n",
        "turned_stage.csv": _head(plain, (head, "stage [deg/s]")),
        "dwells_at.csv": "\n".join(["start,stop,rate [deg/s]", *(f"{5 * k},{5 * k + 5},{rate}"
                                                                 for k, rate in enumerate(steps))]) + "\n",
        "turned_ref.csv": "\n".join(measured) + "\n",
        "turned_bare.csv": _head(plain, *bare),
        "turned_abc.csv": _columns(_head(plain, *((one, name) for (one, _), name in zip(bare, "abc", strict=True))),
                                   slice(0, 5)),
        "turned_headed.csv": _head(
            texts["turned_counts.csv"], *((f"gyro_{axis}", f"gyro_{axis} [count]") for axis in "xyz")
        ),
        "turned_wrong.csv": counted,
        "dwells_named.csv": _columns("\n".join(["given,out", *(",".join(row[:2]) for row in cells)]), slice(None)),
        "digital.csv": "\n".join(["rate [deg/s],reading,reading_std,n", *map(",".join, digital)]) + "\n",
    }  # fmt: skip


def _chamber(texts: dict[str, str]) -> dict[str, str]:
    """Return logs of a gyro in a chamber."""
    plain = texts["chamber_units.csv"]
    bare = [(f"gyro_{axis} [deg/s]", f"gyro_{axis}") for axis in "xyz"]
    rows = [row.split(",") for row in plain.splitlines()[1:]]
    levels = ["4.5", "5.0", "5.5"]
    step = len(rows) // 12 + 1
    supplied = [[*row[:4], levels[(i // step) % 3]] for i, row in enumerate(rows)]
    fast = [[f"{0.001 * i:.3f}", *row[1:]] for i, row in enumerate(rows)]
    return {
        "chamber_bare.csv": _head(plain, *bare),
        "abc.csv": _head(plain, *((one, name) for (one, _), name in zip(bare, "abc", strict=True))),
        "chamber_no_name.csv": _head(plain, ("temperature [degC]", "probe [degC]")),
        "two_probes.csv": "\n".join(f"{row},{row.rpartition(',')[2]}".replace("degC],temperature [", "degC],probe [")
                                    for row in plain.splitlines()) + "\n",
        "chamber_no_unit.csv": _head(plain, ("temperature [degC]", "probe")),
        "too_fast.csv": "\n".join([plain.split("\n", 1)[0], *map(",".join, fast)]) + "\n",
        "supplied.csv": "\n".join([_columns(plain, slice(0, 4)).split("\n", 1)[0] + ",supply [V]",
                                   *map(",".join, supplied)]) + "\n",
        "humid.csv": "\n".join([_columns(plain, slice(0, 4)).split("\n", 1)[0] + ",humidity",
                                *map(",".join, supplied)]) + "\n",
    }  # fmt: skip


def _acc(board: Board, name: str) -> dict[str, list[float]]:
    """Return the columns of the accelerometer of a board."""
    return {name.format(axis): rounded(board.acc[:, i], 6) for i, axis in enumerate("xyz")}


def _codes(board: Board) -> dict[str, list[int]]:
    """Return the accelerometer of a board in codes that begin at none: 400 a m/s^2, 32768 without input."""
    return {f"acc_{axis}": [int(one) for one in np.rint(32768 + 400 * board.acc[:, i])] for i, axis in enumerate("xyz")}


def _boards() -> dict[str, str]:
    """Return logs of a board with both sensors: at rest, and on its faces."""
    board, laid = board_at_rest(seconds=10.0), six_faces()
    gyro = {f"gyro_{axis} [rad/s]": rounded(board.gyro[:, i], 6) for i, axis in enumerate("xyz")}
    stamps = [int(t) for t in np.rint(1e9 * board.time)]
    named = {name: rounded(laid.acc[:, i], 6) for i, name in enumerate("abc")}
    return {
        "board.csv": csv({"t [s]": rounded(board.time, 3), **_acc(board, "acc_{} [m/s2]"), **gyro}),
        "fast.csv": csv({"t [s]": rounded(board.time, 3), **_acc(board, "acc_{}"), **gyro}),
        "acc_ns.csv": csv({"t": stamps, **_acc(board, "acc_{} [m/s2]")}),
        "gyro_ns.csv": csv({"t": stamps[::2], **{k: v[::2] for k, v in gyro.items()}}),
        "faces_named.csv": csv({"t [s]": rounded(laid.time, 3), **named}),
        "faces_bare.csv": csv({"t [s]": rounded(laid.time, 3), **_acc(laid, "acc_{}")}),
        "faces_codes.csv": csv({"t [s]": rounded(laid.time, 3), **_codes(laid)}),
        "faces_wrong.csv": csv({"t [s]": rounded(laid.time, 3), **_acc(laid, "acc_{} [m]")}),
    }


def _waves() -> dict[str, str]:
    """Return a sine of 3 at 4 s, 20 Hz, in a little noise."""
    rng = np.random.default_rng(11)
    time = np.arange(2400) / 20.0
    wave = rounded(3.0 * np.sin(2.0 * np.pi * time / 4.0) + 0.05 * rng.standard_normal(len(time)), 5)
    return {"wave.csv": csv({"time_s": rounded(time, 2), "pulses": wave, "other": wave}),
            "wave_no_time.csv": csv({"pulses": wave})}  # fmt: skip


def _binary(folder: Path, log: Log) -> None:
    """Write a MAT file with two clocks, and a database of two gyros at a time."""
    from scipy.io import savemat

    t = log.time
    (folder / "staged").mkdir()
    shutil.copy(folder / "turned_stage.csv", folder / "staged")
    (folder / "two_gyros").mkdir()
    with sqlite3.connect(folder / "two_gyros" / "imu.db") as connection:
        for name in ("front gyro", "back gyro"):
            connection.execute(f'CREATE TABLE "{name}" ("t_s" REAL, "x_dps" REAL)')
            rows = zip(map(float, t[:2000]), map(float, log.readings["x"][:2000]), strict=True)
            connection.executemany(f'INSERT INTO "{name}" VALUES (?, ?)', rows)
    connection.close()
    savemat(folder / "other_clock.mat", {"time": t, "gyro": log.readings["x"], "slow": t[:100]})
