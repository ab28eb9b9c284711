"""Exports of oscilloscopes, laid out as each maker's manual prints them: settings above, beside and among the names."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core.errors import InertialcalError
from inertialcal.files import read
from typed_commands import call

N, RATE, START = 600, 100.0, -3.0
TIME = START + np.arange(N) / RATE
OUT = 2.5 + 0.004 * np.random.default_rng(41).standard_normal((N, 2))  # V

TDS = (
    "Record Length,6.000000e+02", "Sample Interval,1.000000e-02", "Trigger Point,3.0e+02", ",", ",", "Source,CH1",
    "Vertical Units,V", "Vertical Scale,5.0e-01", "Horizontal Units,s", "Horizontal Scale,1.0", "Pt Fmt,Y",
    "Model Number,TDS2024B", "Serial Number,C012345", "Firmware Version,FV:v22.01",
)  # fmt: skip


def rows(line: str, first: int = 0) -> str:
    """Return a line for each sample."""
    every = enumerate(zip(TIME, *OUT.T, strict=True))
    return "".join(line.format(i=i, t=t, a=a, b=b) + "\n" for i, (t, a, b) in every if i >= first)


def beside() -> str:
    """Return what a TDS writes: its settings left of the first rows, and empty cells left of the others."""
    every = enumerate(zip(TIME, OUT[:, 0], strict=True))
    return "".join(f"{TDS[i] if i < len(TDS) else ','},,{t:018.12f},{a:.7f},\r\n" for i, (t, a) in every)


TWO = ["CH1", "CH2"]
EXPORTS: dict[str, tuple[str, list[str], bool]] = {  # text, channels, whether a column is the time
    "rigol_z.csv": (
        "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-3.000000e+00,1.000000e-02\n" + rows("{i},{a:.7e},{b:.7e},,"),
        TWO, False,
    ),
    "rigol_e.csv": ("Time,X(CH1),X(CH2),\nSecond,Volt,Volt,\n" + rows("{t:.8f},{a:.7f},{b:.7f},"), TWO, True),
    "rigol_dho.csv": (
        "Time(s),CH1V,CH2V,t0 = -3.000000, tInc = 0.010000,\n" + rows("{t:.6e},{a:.7e},{b:.7e},,"), TWO, True,
    ),
    "rigol_mso.csv": ("CH1V,CH2V,t0 = -3.0e+00, tInc = 1.0e-02,\n" + rows("{a:.7e},{b:.7e},,"), TWO, False),
    "tektronix_tds.csv": (beside(), TWO[:1], True),
    "tektronix_mso2.csv": (
        '"Model","MSO2024"\n"Firmware Version","1.52"\n\n"Waveform Type","ANALOG","",\n"Point Format","Y","",\n'
        '"Horizontal Units","S","",\n"Sample Interval","0.01","",\n"Record Length","600","",\n'
        '"Vertical Units","V","V",\n"Vertical Offset","0","0",\n"Label","","",\n"TIME","CH1","CH2",\n'
        + rows("{t:.6e},{a:.7f},{b:.7f},"),
        TWO, True,
    ),
    "tektronix_mso5.csv": (
        "Model,MSO54\nLabel,,\nWaveform Type,ANALOG,\nHorizontal Units,s\nSample Interval,0.01,\nRecord Length,600\n"
        "Zero Index,300,\nVertical Units,V,V\n,\nLabels,,\nTIME,CH1,CH2\n" + rows("{t:.6e},{a:.7f},{b:.7f}"),
        TWO, True,
    ),
    "lecroy.csv": (
        "LECROYHDO4054A,12345,Waveform\nSegments,1,SegmentSize,600\nSegment,TrigTime,TimeSinceSegment1\n"
        "#1,12-Mar-2024 09:15:00,0                 \nTime,Ampl\n" + rows("{t:.9g},{a:.9g}"),
        ["Ampl"], True,
    ),
    "infiniium.csv": (
        "Revision:,0\nType:,raw\nPoints:,600\nXInc:,0.01\nXOrg:,-3\nXRef:,0\nXUnits:,second\nYUnits:,Volt\n"
        "Frame:,MSO9064A:MY12345\nDate:,12 MAR 2024\nTime:,09:15:00:12\nData:\n" + rows("{t:+.12E}, {a:+.10E}"),
        TWO[:1], True,
    ),
    "instek.csv": (
        "Format,1.0B\nMemory Length,600\nTrigger Address,299\nSource,CH1\nVertical Units,V\nLabel,,\n"
        "Horizontal Units,s\nSampling Period,1.0E-02\nTime,12-Mar-24 09:15:00\nMode,Fast\nWaveform Data,\n"
        + rows("{t:.6f},{a:.7f}"),
        TWO[:1], True,
    ),
    "yokogawa.csv": (
        '//YOKOGAWA ASCII FILE FORMAT\n"Model","DL850"\n"TraceName","CH1","CH2"\n"BlockSize",600,600\n"VUnit","V","V"\n'
        '"HResolution",1.0E-02,1.0E-02\n"HOffset",0,0\n"HUnit","s","s"\n"Date","2024/03/12","2024/03/12"\n\n'
        + rows("{a:.7E},{b:.7E},"),
        TWO, False,
    ),
    "hantek.txt": (
        "".join(f"#CHANNEL:CH{k + 1}\n#CLOCK=10.0mS\n#SIZE=600\n#UNITS:V\n\n"
                + "".join(f"{value:.7f}\n" for value in OUT[:, k]) + "\n\n" for k in (0, 1)),
        TWO, False,
    ),
    "hantek_one.csv": (
        "#CHANNEL:CH1\n#CLOCK=10000.0uS\n#SIZE=600\n#UNITS:V\n" + rows("{a:.7f}"), TWO[:1], False,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", EXPORTS)
def test_volts_and_rate_come_back(name: str, tmp_path: Path) -> None:
    text, channels, has_time = EXPORTS[name]
    (tmp_path / name).write_text(text)
    found = read(tmp_path / name)
    assert found.array(channels) == pytest.approx(OUT[:, : len(channels)], abs=1e-7)
    assert {found.channel(one).unit for one in channels} == {None if name == "lecroy.csv" else "V"}
    assert not any(found.channel(one).axis for one in channels)
    assert found.sample_rate == pytest.approx(RATE, rel=1e-4)
    assert (found.time_ns is not None) == has_time
    if found.time_ns is not None:
        assert found.time_ns[0] == round(START * 1e9)
    assert {one.code for one in found.remarks} <= {"preamble", "empty_column", "time_unit_assumed"}


ROW_BY_ROW = [name for name, (_, _, has_time) in EXPORTS.items() if not has_time and name != "hantek.txt"]


@pytest.mark.parametrize("name", ROW_BY_ROW)
def test_a_long_export_is_read_in_pieces_as_a_short_one(name: str, tmp_path: Path) -> None:
    text, channels, _ = EXPORTS[name]
    body = "".join(text.splitlines(keepends=True)[-N:])
    repeats = 2**20 // len(body) + 2
    (tmp_path / name).write_text(text + body * (repeats - 1))
    found = read(tmp_path / name)
    assert len(found) == repeats * N
    assert found.sample_rate == pytest.approx(RATE)
    assert {found.channel(one).unit for one in channels} == {"V"}


def test_one_command_gives_the_noise_of_a_trace(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.csv").write_text(EXPORTS["rigol_z.csv"][0])
    words = ("--column", "x=CH1", "--reference", "2.5 V", "--scale-factor", "0.02 V/(deg/s)")
    status, out, err = call(capsys, "allan", str(tmp_path / "a.csv"), *words, "--json")
    assert status == 0, err
    found = [one for one in json.loads(out)["results"] if one["quantity"] == "angle_random_walk" and one["value"]]
    assert found[0]["value"] == pytest.approx(60.0 * 0.004 / 0.02 / RATE**0.5, rel=0.1)


def test_a_word_among_the_numbers_of_an_export_is_still_refused(tmp_path: Path) -> None:
    text = EXPORTS["tektronix_mso5.csv"][0].replace(f"{TIME[7]:.6e}", "overload")
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InertialcalError) as caught:
        read(tmp_path / "a.csv")
    assert caught.value.problems[0].code == "text_in_numbers"
    assert caught.value.problems[0].where.endswith(f"a.csv:{11 + 8}")


@pytest.mark.parametrize("header", ["Y[0]\tY[1]\tY[2]", "Time (s)\tY[0]\tY[1]\tY[2]\tY[3]"])
def test_curves_of_a_graph_are_no_axes(header: str, tmp_path: Path) -> None:
    width = header.count("\t") + 1
    lines = ("\t".join(f"{i / RATE + k:.2f}" for k in range(width)) for i in range(50))
    (tmp_path / "a.txt").write_text("\n".join([header, *lines]))
    assert {one.axis for one in read(tmp_path / "a.txt").channels} == {""}


HEADS = (
    "Record Length,1", "Sample Interval,", "X,CH1,Start,Increment", "Vertical Units,V", "TIME,CH1", "Sequence,Volt",
    "1,2", "LECROY,1", "0.1,2e3,,", "CH1V,t0 = 1, tInc = 0", "XInc:,nan", "Data:", ",,,", "a", '"',
    "Record Length,1,,0,1",
)  # fmt: skip


@given(lines=st.lists(st.sampled_from(HEADS), max_size=12))
def test_whatever_stands_above_is_read_or_refused_in_words(
    lines: list[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("scope") / "a.csv"
    path.write_text("\n".join(lines))
    with suppress(InertialcalError):
        read(path)
