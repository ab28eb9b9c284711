"""PAD pairs: values bit for bit, stamps from the header, what the archive hides is remarked."""

from __future__ import annotations

import hashlib
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.recording import Recording
from inertialcal.core.remarks import Remark
from inertialcal.core.times import SECOND, read_instant
from pad_pairs_made import BIG, START, header, pair, records, stamp, systems

ZERO = read_instant(START)
REAL = "2014_10_22_09_36_36.324-2014_10_22_09_37_35.317.121f03006"
PLACEHOLDER = '<BiasCoeff x="1.23" y="4.46" z="7.89"/>'


def remark(recording: Recording, code: str) -> Remark:
    found = [one for one in recording.remarks if one.code == code]
    assert len(found) == 1, [one.code for one in recording.remarks]
    return found[0]


def codes(recording: Recording) -> set[str]:
    return {one.code for one in recording.remarks}


# One pair


@pytest.mark.parametrize(("kind", "text"), [("<f4", None), (">f4", header(layout=BIG))])
def test_both_byte_orders_read_bit_for_bit(tmp_path: Path, kind: str, text: str | None) -> None:
    table = records()
    path = pair(tmp_path, table, kind=kind, text=text)
    for given in (path, path.with_name(path.name + ".header"), tmp_path):
        found = ic.read(given)
        assert found.names == ("x", "y", "z")
        assert all(channel.unit == "g" and channel.quantity == "acc" for channel in found.channels)
        for i, channel in enumerate(found.channels):
            assert channel.data.dtype == np.float32
            assert np.array_equal(channel.data, table[:, i + 1])
        assert found.epoch == "utc"
        assert found.time_ns is not None
        assert np.array_equal(found.time_ns, ZERO + np.arange(20) * SECOND // 100)


def test_text_is_read_with_all_its_digits(tmp_path: Path) -> None:
    path = pair(tmp_path, records(3), text=header(layout="ascii"))
    path.write_text("0.00 1e-4 2.5e-4 -3e-4\n0.01, 4e-4, 5e-4, 6e-4\n0.02 7e-4 8e-4 9e-4\n", encoding="ascii")
    found = ic.read(path)
    assert found.array().tolist() == [[1e-4, 2.5e-4, -3e-4], [4e-4, 5e-4, 6e-4], [7e-4, 8e-4, 9e-4]]
    assert found.source.format == "PAD, 121f03, text"


def test_the_hash_is_that_of_data_and_header(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    both = path.read_bytes() + path.with_name(path.name + ".header").read_bytes()
    assert ic.read(path).source.sha256 == hashlib.sha256(both).hexdigest()


def test_raw_records_have_temperature_and_status(tmp_path: Path) -> None:
    table = records(columns=6)
    path = pair(tmp_path, table, sensor="ossraw", text=header(sensor="ossraw", more="", root="mams_accel_ossraw"))
    found = ic.read(path)
    assert found.names == ("x", "y", "z", "temperature", "status")
    assert [channel.unit for channel in found.channels] == ["g", "g", "g", None, None]
    assert np.array_equal(found.channel("status").data, table[:, 5])


def test_radiation_records_have_columns_without_names_and_units(tmp_path: Path) -> None:
    table = records(columns=14)
    path = pair(tmp_path, table, sensor="radgse", text=header(sensor="radgse", more="", root="iss_rad_radgse"))
    found = ic.read(path, frame="sensor")
    assert found.names == tuple(f"column_{i}" for i in range(2, 15))
    assert np.array_equal(found.channel("column_14").data, table[:, 13])
    assert "without names or units: column_2 to column_14" in remark(found, "columns_unnamed").what


def test_a_pair_under_other_names_is_known_by_its_header(tmp_path: Path) -> None:
    path = pair(tmp_path, records(), text=header(file="data.bin"))
    head = path.with_name(path.name + ".header").rename(tmp_path / "data.xml")
    path.rename(tmp_path / "data.bin")
    assert len(ic.read(head)) == 20
    head.rename(tmp_path / "data.bin.header")
    found = ic.read(tmp_path / "data.bin")
    assert "not compared" in remark(found, "name_not_archived").what


def test_the_units_flag_goes_before_the_format(tmp_path: Path) -> None:
    found = ic.read(pair(tmp_path, records()), units={"acc": "m/s^2"})
    assert {channel.unit for channel in found.channels} == {"m/s^2"}
    assert "unit_overridden" in codes(found)


def test_missing_numbers_are_counted(tmp_path: Path) -> None:
    table = records()
    table[3:5, 2] = np.nan
    assert remark(ic.read(pair(tmp_path, table)), "missing_cells").count == 2


# Time


def test_stamps_follow_the_header_not_the_jitter_of_its_floats(tmp_path: Path) -> None:
    table = records(2000, rate=500.0)
    table[:, 0] += np.float32(4096.0)  # there a float32 moves by 0.49 ms
    found = ic.read(pair(tmp_path, table, text=header(rate="500.00")))
    assert found.time_ns is not None
    assert np.all(np.diff(found.time_ns) == 2_000_000)
    assert found.time_ns[0] == ZERO + 4096 * SECOND
    assert "agrees within" in remark(found, "stamps_made").what


def test_stamps_that_run_away_are_remarked_with_their_own_rate(tmp_path: Path) -> None:
    path = pair(tmp_path, records(3000, rate=100.0 * (1.0 + 2e-4)))
    drift = remark(ic.read(path), "stamps_drift")
    assert "-200 ppm" in drift.what
    assert drift.do.startswith("If the stamps are right: --sample-rate 100.02")
    assert "stamps_drift" not in codes(ic.read(path, sample_rate=100.02))


def test_the_rate_by_flag_goes_before_the_header(tmp_path: Path) -> None:
    found = ic.read(pair(tmp_path, records()), sample_rate=50.0)
    assert found.sample_rate == 50.0
    assert "50 Hz was given, the stamps of the data say 100 Hz" in remark(found, "sample_rate_disagrees").what


def test_records_that_are_missing_inside_a_file_are_a_gap(tmp_path: Path) -> None:
    table = np.delete(records(60), slice(20, 31), axis=0)
    found = ic.read(pair(tmp_path, table))
    assert found.time_ns is not None
    assert np.flatnonzero(np.diff(found.time_ns) > 15_000_000).tolist() == [19]
    assert abs(int(found.time_ns[-1]) - ZERO - 590_000_000) < 100
    assert "11 sample(s) missing in all, longest step 0.12 s" in remark(found, "gaps").what


def test_ends_that_differ_are_told(tmp_path: Path) -> None:
    other = f"{START}-{stamp(START, 0.196)}.121f03"
    found = ic.read(pair(tmp_path, records(), text=header(file=other)))
    what = remark(found, "stop_differs").what
    assert "the name 2014-10-22T09:36:36.19Z" in what
    assert "GData in the header 2014-10-22T09:36:36.196Z" in what


# What the header says


def test_bias_is_never_applied(tmp_path: Path) -> None:
    table = records()
    found = ic.read(pair(tmp_path, table, text=header(more=PLACEHOLDER)))
    assert np.array_equal(found.channel("x").data, table[:, 1])
    said = remark(found, "bias_not_applied")
    assert (said.severity, "placeholder" in said.what) == ("warning", True)
    real = ic.read(pair(tmp_path, table, text=header(more='<BiasCoeff x="1e-5" y="0" z="0"/>')))
    assert (remark(real, "bias_not_applied").severity, "x=1e-05" in remark(real, "bias_not_applied").what) == (
        "info",
        True,
    )
    none = ic.read(pair(tmp_path, table, text=header(more='<BiasCoeff x="0" y="0" z="0"/>')))
    assert "bias_not_applied" not in codes(none)


def test_what_was_applied_is_kept(tmp_path: Path) -> None:
    more = (
        "<Gain>10.0</Gain><CutoffFreq>6.00</CutoffFreq>"
        "<DataQualityMeasure>No temperature compensation</DataQualityMeasure>"
        '<ScaleFactor x="1.0" y="1.0" z="1.5"/>'
    )
    what = remark(ic.read(pair(tmp_path, records(), text=header(more=more))), "as_archived").what
    for said in ("'No temperature compensation'", "Gain 10", "CutoffFreq 6 Hz", "ScaleFactor x=1 y=1 z=1.5"):
        assert said in what


# Axes


def test_axes_of_the_sensor(tmp_path: Path) -> None:
    table = records()
    path = pair(tmp_path, table, text=header(more=systems((0.0, 0.0, 90.0))))
    as_is, turned = ic.read(path), ic.read(path, frame="sensor")
    # The sensor's x axis points along the station's y, its y against the station's x.
    for axis, expected in (("x", table[:, 2]), ("y", -table[:, 1]), ("z", table[:, 3])):
        np.testing.assert_allclose(turned.channel(axis).data, expected, atol=1e-11)
    assert turned.channel("x").data.dtype == np.float32
    assert np.array_equal(as_is.channel("x").data, table[:, 1])
    assert "--frame sensor" in remark(as_is, "not_sensor_axes").do
    assert "turned from SSAnalysis" in remark(turned, "turned_to_sensor_axes").what
    same = ic.read(pair(tmp_path, table, text=header(more=systems((0.0, 0.0, 90.0), (0.0, 0.0, 90.0)))))
    assert not codes(same) & {"not_sensor_axes", "turned_to_sensor_axes"}


def test_a_sample_that_is_infinite_is_missing_on_all_axes_of_the_sensor(tmp_path: Path) -> None:
    table = records()
    table[3, 1] = np.inf
    path = pair(tmp_path, table, text=header(more=systems((0.0, 0.0, 90.0))))
    found = ic.read(path, frame="sensor")
    assert not np.isfinite(found.channel("x").data[3])
    assert np.isfinite(np.delete(found.channel("x").data, 3)).all()


# Folders


def joined(folder: Path, sign: str, seconds: float, text: str | None = None) -> Path:
    """Write two files of 20 samples; the second starts so long after the first."""
    later = stamp(START, seconds)
    pair(folder, records())
    pair(folder, records(scale=2e-4), start=later, sign=sign, text=text and text.replace(START, later))
    return folder


def test_files_that_go_on_are_one_record(tmp_path: Path) -> None:
    found = ic.read(joined(tmp_path, "+", 0.2))
    assert found.time_ns is not None
    assert np.all(np.diff(found.time_ns) == SECOND // 100)
    expected = np.concatenate([records()[:, 1], records(scale=2e-4)[:, 1]])
    assert np.array_equal(found.channel("x").data, expected)
    assert found.source.format == "PAD, 121f03, little endian, 2 files"
    assert not codes(found) & {"gaps", "contiguity_differs"}


def test_a_gap_between_files_is_remarked(tmp_path: Path) -> None:
    found = ic.read(joined(tmp_path, "-", 0.5))
    assert "30 sample(s) missing in all, longest step 0.31 s against 10 ms" in remark(found, "gaps").what
    assert "contiguity_differs" not in codes(found)


@pytest.mark.parametrize(
    ("sign", "seconds", "words"), [("+", 0.5, "continues; by the time stamps 30"), ("-", 0.2, "a gap")]
)
def test_a_sign_that_does_not_fit_the_times(tmp_path: Path, sign: str, seconds: float, words: str) -> None:
    assert words in remark(ic.read(joined(tmp_path, sign, seconds)), "contiguity_differs").what


def test_changes_from_file_to_file_are_remarked(tmp_path: Path) -> None:
    text = header(more="<Gain>100.0</Gain><CutoffFreq>200</CutoffFreq>")
    found = ic.read(joined(tmp_path, "+", 0.2, text))
    assert remark(found, "gain_changed").what == "Gain changes between files, from 10.0 to 100.0"
    assert "from 6.0 to 200.0" in remark(found, "filter_changed").what


def test_the_tree_of_the_archive(tmp_path: Path) -> None:
    for day, start in (("22", START), ("23", "2014_10_23_00_00_00.000")):
        folder = tmp_path / "year2014" / "month10" / f"day{day}" / "sams2_accel_121f03"
        folder.mkdir(parents=True)
        pair(folder, records(), start=start, text=header(start))
    assert len(ic.read(tmp_path)) == len(ic.read(tmp_path / "year2014")) == 40


def test_only_files_in_the_window_are_opened(tmp_path: Path) -> None:
    joined(tmp_path, "-", 60.0)
    later = next(tmp_path.glob("*37_36.000-*f03"))
    later.write_bytes(later.read_bytes()[:-1])  # truncated: reading it would refuse
    found = ic.read(tmp_path, start="2014/295/09:36:36.05", stop="2014-10-22T09:36:36.100Z")
    assert len(found) == 5
    assert remark(found, "cut_to_times").what == (
        "5 of 20 samples are in the requested time window; 1 file(s) outside not opened"
    )


# A day at 250 samples/s


def peak(path: Path, frame: str) -> int:
    """Return the most memory that reading takes [bytes]."""
    tracemalloc.start()
    try:
        ic.read(path, frame=frame)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("frame", ["data", "sensor"])
def test_a_day_of_records_takes_less_than_a_gibibyte(tmp_path: Path, frame: str) -> None:
    n, text = 600_000, header(rate="250.00", more=systems((0.0, 30.0, -90.0)))
    for length in (n, 2 * n):
        (tmp_path / str(length)).mkdir()
        pair(tmp_path / str(length), records(length, rate=250.0), text=text)
    once, twice = (peak(tmp_path / str(length), frame) for length in (n, 2 * n))
    assert twice + (twice - once) / n * (86_400 * 250 - 2 * n) < 2**30


@pytest.mark.slow
def test_a_whole_day_keeps_its_stamps_and_values(tmp_path: Path) -> None:
    n = 86_400 * 250
    table = np.empty((n, 4), dtype=np.float32)
    table[:, 0] = np.arange(n) / 250.0
    for axis in (1, 2, 3):
        table[:, axis] = np.random.default_rng(axis).standard_normal(n, dtype=np.float32) * np.float32(1e-4)
    found = ic.read(pair(tmp_path, table, text=header(rate="250.00")))
    assert found.time_ns is not None
    assert np.array_equal(found.time_ns, ZERO + np.arange(n) * (SECOND // 250))
    assert all(np.array_equal(c.data, table[:, i + 1]) for i, c in enumerate(found.channels))


# info, and the record of the archive itself


def test_info_leads_on_from_a_head_that_did_not_turn(tmp_path: Path) -> None:
    path = pair(tmp_path, records())
    from inertialcal.campaign.start.info import info as survey

    assert survey(path, commands=("info", "flip", "microgravity")).next == f"inertialcal microgravity {path}"
    assert survey(path, commands=("info", "init")).next == f"inertialcal init {tmp_path}"
    assert survey(path, commands=("info",)).next is None


def test_the_real_record_is_read_exactly_and_its_traps_are_remarked(shared: Path) -> None:
    path = shared / "data" / "pims_pad" / REAL
    table = np.fromfile(path, dtype="<f4").reshape(-1, 4)
    found = ic.read(path)
    assert (len(found), found.sample_rate) == (8378, 142.0)
    for i, channel in enumerate(found.channels):
        assert np.array_equal(channel.data, table[:, i + 1])
    assert found.time_ns is not None
    assert found.time_ns[0] == read_instant("2014-10-22T09:36:36.324Z")
    assert np.abs(np.diff(found.time_ns) - SECOND / 142).max() <= 1.0  # [ns]; the file's own spread is 3800
    assert np.abs((found.time_ns - found.time_ns[0]) / SECOND - table[:, 0]).max() < 2e-6
    assert {"stop_differs", "bias_not_applied", "as_archived", "stamps_made", "not_sensor_axes"} <= codes(found)
    stop = remark(found, "stop_differs").what
    assert "09:37:35.317Z" in stop
    assert "09:37:35.323Z" in stop
    assert "temperature+gain+axial-mis-alignment" in remark(found, "as_archived").what


def test_the_real_bias_lies_along_one_axis_of_the_sensor(shared: Path) -> None:
    # Ambient acceleration is a few ug; what is left of the bias (300 ug) is that of one axis, when turned rightly.
    found = ic.read(shared / "data" / "pims_pad", frame="sensor")
    x, y, z = found.array().mean(axis=0)
    assert x == pytest.approx(3.0e-4, rel=0.01)
    assert max(abs(y), abs(z)) < 0.03 * x
