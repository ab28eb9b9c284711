"""Profiles as people write them: Table 1 as printed, slopes alone, contradictions, what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError, InertialcalError, UsageError
from inertialcal.procedures.vibration.profile_file import read_profile
from typed_commands import call, call_json

G = 9.80665
# NPS 2011 ("NPSAT1 MEMS 3-Axis Rate Sensor Suite ..."), Table 1: workmanship level, as printed
TABLE_1 = """frequency_hz,asd_g2_per_hz,slope_db_per_octave,note
20,0.01,,breakpoint
20-50,,3,rising segment
50-500,0.04,0,plateau
500-2000,,-3,falling segment
2000,0.01,,breakpoint
"""
# The same with the knee where +3 dB/octave puts it, by one level and slopes alone
BY_SLOPES = """nodes = [
  { frequency = "20 Hz" }, { slope = "3.0103 dB/octave" }, { frequency = "80 Hz", level = "0.04 g2/Hz" },
  { slope = "0 dB/octave" }, { frequency = "500 Hz" }, { slope = "-3.0103 dB/octave" }, { frequency = "2 kHz" },
]
rms = "6.8 g"
"""


def label(row: dict[str, Any]) -> str:
    """Return which band a row is of; empty for all."""
    return "" if row["member"] is None else str(row["member"]["label"])


def written(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def test_table_1_is_read_and_its_contradiction_named_with_both_figures(tmp_path: Path) -> None:
    found = read_profile(written(tmp_path, "t.csv", TABLE_1))
    assert (found.profile.density / G**2).tolist() == pytest.approx([0.01, 0.04, 0.04, 0.01], rel=1e-14)
    assert found.profile.rms() / G == pytest.approx(6.8148, abs=5e-5)
    (one,) = found.contradictions
    assert (one.low, one.high, one.stated) == (20.0, 50.0, 3.0)
    assert one.implied == pytest.approx(4.554, abs=5e-4)
    assert one.knee == pytest.approx(80.4, abs=0.05)
    (remark,) = found.remarks
    assert remark.code == "slope_disagrees"
    for figure in ("3 dB/octave", "4.554 dB/octave", "80.38 Hz", "6.8148 g", "6.7839 g"):
        assert figure in remark.what


def test_slopes_alone_complete_a_profile(tmp_path: Path) -> None:
    found = read_profile(written(tmp_path, "p.toml", BY_SLOPES))
    assert (found.profile.density / G**2).tolist() == pytest.approx([0.01, 0.04, 0.04, 0.01], rel=1e-5)
    assert found.profile.rms() / G == pytest.approx(6.784, abs=5e-4)
    assert found.stated == (False, True, False, False)
    assert not found.remarks
    wrong = read_profile(written(tmp_path, "q.toml", BY_SLOPES.replace("6.8 g", "6.9 g")))
    assert [one.code for one in wrong.remarks] == ["overall_disagrees"]


def test_units_and_forms_of_a_table(tmp_path: Path) -> None:
    """Kilohertz, (m/s2)2/Hz and a slope at a node mean what they say; a rounded slope is no contradiction."""
    text = "f [kHz],psd [(m/s2)^2/Hz],slope [dB/octave]\n0.02,0.9617,3\n0.08,3.8468,0\n0.5,3.8468,-3\n2,0.9617,\n"
    found = read_profile(written(tmp_path, "p.csv", text))
    assert found.profile.frequency.tolist() == pytest.approx([20.0, 80.0, 500.0, 2000.0])
    assert found.profile.rms() / G == pytest.approx(6.784, abs=1e-3)
    assert not found.remarks


@pytest.mark.parametrize(
    "head",
    [
        "frequency [Hz],density [g2/Hz]", "frequency [Hz],density [g^2/Hz]", "frequency [Hz],density [g**2/Hz]",
        "Frequency (Hz),PSD (g²/Hz)", "frequency [Hz],density [G^2/Hz]", "Frequency (Hz),Amplitude (G²/Hz)",
        "freq [Hz],asd [grms^2/Hz]", "f,g2/Hz", "frequency,level\nHz,g2/Hz", "frequency_hz,psd_g2_per_hz",
        "frequency [Hz],level g^2/Hz",
    ],
)  # fmt: skip
def test_a_level_in_g_is_read_however_it_is_written(tmp_path: Path, head: str) -> None:
    found = read_profile(written(tmp_path, "p.csv", f"{head}\n20,0.01\n80,0.04\n"))
    assert (found.profile.density / G**2).tolist() == pytest.approx([0.01, 0.04])
    assert not found.remarks


@pytest.mark.parametrize(
    "unit", ["(m/s2)2/Hz", "(m/s²)²/Hz", "(m/s^2)^2/Hz", "(m/s2)^2 / Hz", "m2/s3", "(m/s**2)**2/Hz", "m^2/s^4/Hz"]
)
def test_a_level_in_si_is_read_however_it_is_written(tmp_path: Path, unit: str) -> None:
    for name, text in (
        ("p.csv", f"frequency [Hz],density [{unit}]\n20,1\n80,4\n"),
        (
            "p.toml",
            f'nodes = [{{frequency = "20 Hz", level = "1 {unit}"}}, {{frequency = "80 Hz", level = "4 {unit}"}}]',
        ),
    ):
        assert read_profile(written(tmp_path, name, text)).profile.density.tolist() == pytest.approx([1.0, 4.0])
    table = ic.vibration_profile({"20 Hz": f"1 {unit}", "80 Hz": f"4 {unit}"})
    assert table.stated.profile.density.tolist() == pytest.approx([1.0, 4.0])


def test_the_root_of_a_density_is_squared_and_that_is_told(tmp_path: Path) -> None:
    found = read_profile(written(tmp_path, "p.csv", "frequency [Hz],asd [g/sqrt(Hz)],slope\n20,0.1,3\n80,0.2,\n"))
    assert (found.profile.density / G**2).tolist() == pytest.approx([0.01, 0.04])
    assert (found.unit, [one.code for one in found.remarks]) == ("g^2/Hz", ["squared"])
    nodes = '{frequency = "20 Hz", level = "0.1 g/rtHz"}, {frequency = "80 Hz", level = "0.04 G2/Hz"}'
    text = f'rms = "0.99 Grms"\nnodes = [{nodes}]'
    both = read_profile(written(tmp_path, "p.toml", text))
    assert (both.profile.density / G**2).tolist() == pytest.approx([0.01, 0.04])
    assert both.overall == pytest.approx(0.99 * G)


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        ("a.csv", "frequency [Hz],density\n20,0.01\n50,0.04\n", "wrong_unit"),
        ("a.csv", "frequency [Hz],density [g/Hz]\n20,0.01\n50,0.04\n", "wrong_unit"),
        ("a.csv", "frequency [Hz],density [dB]\n20,0.01\n50,0.04\n", "wrong_unit"),
        ("a.csv", "frequency [Hz],density [(deg/s)^2/Hz]\n20,0.01\n50,0.04\n", "wrong_unit"),
        ("a.csv", "frequency [Hz],density [g/sqrt(Hz)]\n20,-0.01\n50,0.04\n", "profile"),
        ("a.toml", 'nodes = [ { frequency = "20 Hz", level = "0.01 g/Hz" }, { frequency = "50 Hz" } ]', "wrong_unit"),
        ("a.csv", "place,density [g2/Hz]\n20,0.01\n50,0.04\n", "no_column"),
        ("a.csv", "frequency [Hz],density [g2/Hz]\n20,0.01\n", "profile"),
        ("a.csv", "frequency [Hz],density [g2/Hz]\n20,0.01\n10,0.04\n", "profile"),
        ("a.csv", "frequency [Hz],density [g2/Hz]\n20,0.01\n50,\n", "profile"),
        ("a.csv", "frequency [Hz],density [g2/Hz]\n20,-0.01\n50,0.04\n", "profile"),
        ("a.csv", "frequency [Hz],density [g2/Hz]\n20,x\n50,0.04\n", "wrong_value"),
        ("a.toml", "nodes = 3", "profile"),
        ("a.toml", "nodes = [", "not_toml"),
        ("a.toml", "node = []", "unknown_key"),
        ("a.toml", 'nodes = [ { frequency = "20 Hz", level = "0.01 g" }, { frequency = "50 Hz" } ]', "wrong_unit"),
        ("a.toml", 'nodes = [ { slope = "3 dB/octave" } ]', "profile"),
    ],
)
def test_what_is_no_profile_is_refused(tmp_path: Path, name: str, text: str, code: str) -> None:
    with pytest.raises(DataError) as refused:
        read_profile(written(tmp_path, name, text))
    assert refused.value.problems[0].code == code
    assert name in refused.value.problems[0].where


def test_command_and_call_say_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "t.csv", TABLE_1)
    found = ic.vibration_profile(path, bands=["20..100"])
    said = call_json(capsys, "vibration", "profile", str(path), "--band", "20..100")
    assert said["command"] == "vibration profile"
    assert said["results"] == found.results["results"]
    rms = {label(row): row["value"] for row in said["results"] if row["quantity"] == "acceleration_rms"}
    assert rms[""] == pytest.approx(6.8148, abs=5e-5)
    parts = [rms[one] for one in ("20 to 50 Hz", "50 to 500 Hz", "500 to 2000 Hz")]
    assert sum(one**2 for one in parts) == pytest.approx(rms[""] ** 2, rel=1e-12)
    assert said["contradictions"][0]["stated_slope"] == 3.0
    assert "overall" in str(found)
    drawn = tmp_path / "profile.svg"
    assert call(capsys, "vibration", "profile", str(path), "-q", "-o", str(drawn))[0] == 0
    assert drawn.stat().st_size > 1000
    levels = {"20 Hz": "0.01 g2/Hz", "50 Hz": "0.04 g2/Hz", "500 Hz": "0.04 g2/Hz", "2000 Hz": "0.01 g2/Hz"}
    assert ic.vibration_profile(levels).stated.profile.rms() == pytest.approx(found.stated.profile.rms(), rel=1e-14)


@pytest.mark.parametrize("band", ["20", "100..20", "5..10"])
def test_a_band_that_is_none_is_refused(tmp_path: Path, band: str) -> None:
    with pytest.raises(UsageError):
        ic.vibration_profile(written(tmp_path, "t.csv", TABLE_1), bands=[band])
    with pytest.raises(InertialcalError):
        ic.vibration_profile({"20 Hz": "0.01 g2/Hz", "50 m": "0.04 g2/Hz"})
