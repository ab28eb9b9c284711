"""What is written reads back: bits, time, gaps, units, missing values, in every format."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.io import loadmat, savemat

from inertialcal.campaign.start.info import info as survey
from inertialcal.core.errors import DataError, InertialcalError, StoreError, UsageError
from inertialcal.core.recording import SECOND, Channel, ClockRate, Recording, Source
from inertialcal.files import read
from inertialcal.files.binary.parquet import clock_in, clock_of
from inertialcal.files.info.survey import survey_recording
from inertialcal.files.write.file_columns import numbers, time_column, time_name
from inertialcal.files.write.recording import WRITERS, write

FORMATS = [".csv", ".parquet", ".npz", ".h5", ".mat"]
DTYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "i8", "f2", "f4", "f8", "bool", ">f8", ">i4"]
UNITS = [None, "deg/s", "rad/s", "g", "ug", "m/s^2", "V", "count", "degC", "Pa", "%", "V/(deg/s)", "ug/sqrt(Hz)"]
NAMES = ["gyro_x", "gyro_y [rad/s]", "acc_z", "wx", "x", "temp", "temperature [degC]", "volts", "slope_volt_per_dps",
         "acc_mps2", "status", "a,b", 'say "x"', "ä°", "  padded", "line\nbreak", "u (V)"]  # fmt: skip
UTC = np.int64(1_272_467_400 * SECOND)  # 2010-04-28T15:10:00Z
FAST = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def recording(*channels: Channel, **rest: Any) -> Recording:
    return Recording(tuple(channels), **rest)


def there_and_back(folder: Path, ending: str, one: Recording, **how: Any) -> Recording:
    path = folder / f"out{ending}"
    write(path, one)
    return read(path, **how)


def same_bits(a: NDArray[Any], b: NDArray[Any]) -> bool:
    """Whether numbers are the same in the type of the first, missing ones alike."""
    return np.array_equal(a, b.astype(a.dtype), equal_nan=a.dtype.kind == "f")


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    n = draw(st.integers(2, 30))
    names = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=5, unique=True))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    channels = []
    for name in names:
        kind = np.dtype(draw(st.sampled_from(DTYPES)))
        bits = rng.integers(0, 256, n * kind.itemsize, dtype=np.uint8)
        data = bits.view(kind) if kind.kind != "b" else bits > 127
        if kind.kind == "f":
            data = np.where(np.isfinite(data), data, np.nan).astype(kind)
            data[draw(st.integers(0, n - 1))] = draw(st.sampled_from([np.nan, 0.0, -0.0, 1.0, 0.1]))
        if draw(st.booleans()) and kind.kind == "f":
            data = np.rint(data)
        channels.append(Channel(name, data, draw(st.sampled_from(UNITS)), "flag"))
    return Recording(tuple(channels), **draw(times(n)))


@st.composite
def times(draw: st.DrawFn, n: int) -> dict[str, Any]:
    """Time with gaps, in any step, elapsed or UTC, from columns of any name; or a stated rate; or nothing."""
    if not draw(st.booleans()):
        rate = draw(st.one_of(st.none(), st.floats(1e-3, 1e5)))
        return {} if rate is None else {"sample_interval": 1.0 / rate, "interval_from": "flag"}
    step = draw(st.sampled_from([1, 1000, 7_812_500, 10_000_000, SECOND, 33_333_333]))
    steps = draw(st.lists(st.sampled_from([1, 1, 1, 1, 5, 1000]), min_size=n, max_size=n))
    epoch = draw(st.sampled_from(["utc", "elapsed"]))
    start = UTC if epoch == "utc" else np.int64(draw(st.sampled_from([0, 5 * SECOND, -3 * SECOND, 123_456_789])))
    name = draw(
        st.sampled_from(["t", "time", "Time (s)", "t_ms", "unix_s", "timestamp", "millis", "column_1", "x [V]"])
    )
    time_ns = start + np.cumsum(np.array(steps, dtype=np.int64) * step)
    return {"time_ns": time_ns, "epoch": epoch, "interval_from": "column", "time_column": name}


@pytest.mark.parametrize("ending", FORMATS)
@FAST
@given(one=recordings())
def test_a_recording_reads_back(tmp_path: Path, ending: str, one: Recording) -> None:
    again = there_and_back(tmp_path, ending, one)
    assert len(again.channels) == len(one.channels)
    for was, now in zip(one.channels, again.channels, strict=True):
        assert same_bits(was.data, now.data), was
        assert now.unit == was.unit
        if ending != ".csv" and was.data.dtype.kind != "b":
            half = ending == ".mat" and was.data.dtype == np.float16  # MATLAB has no such
            assert now.data.dtype == (np.dtype(np.float32) if half else was.data.dtype.newbyteorder("="))
        assert (now.data.dtype.kind == "f") == (was.data.dtype.kind == "f")
    if one.time_ns is None:
        assert again.time_ns is None
        assert again.sample_interval == (one.sample_interval or None)
    else:
        np.testing.assert_array_equal(again.time_ns, one.time_ns)
        assert again.epoch == one.epoch


@pytest.mark.parametrize("ending", FORMATS)
def test_unsigned_64_bits(tmp_path: Path, ending: str) -> None:
    """CSV has no type: whole numbers beyond int64 come back as floats, all others to the bit."""
    data = np.array([0, 2**63 - 1, 7], dtype=np.uint64)
    again = there_and_back(tmp_path, ending, recording(Channel("a", data), Channel("b", data + np.uint64(1))))
    np.testing.assert_array_equal(again.channel("a").data, data)
    np.testing.assert_array_equal(again.channel("b").data.astype(float), (data + np.uint64(1)).astype(float))


@pytest.mark.parametrize("ending", FORMATS)
@pytest.mark.parametrize(
    "text",
    [
        "t_s,gyro_x_dps,gyro_y [rad/s],n,temp (degC)\n0,1.5,2,0,20\n0.5,,3,1,21\n2.5,1e-7,-0,2,\n3,0.1,4,3,22\n",
        "time,acc_x,acc_y\n2010-04-28T15:10:00.5Z,1,2\n2010-04-28T15:10:01.5Z,3,4\n2010-04-28T15:10:02.5Z,5,6\n",
        "unix_s,counts_x\n1272467400.25,1\n1272467400.5,2\n1272467400.75,3\n1272467402,4\n",
        '# sample rate: 128 Hz\ngyro_z [deg/s]\n0.25\n""\n0.5\n0.75\n',
        "t_ms;acc_z_g\n1;0,5\n2;0,25\n3;1,5\n40;1,5\n",
        "1,2\n3,4\n5,6\n",
    ],
)
def test_info_says_the_same_of_what_was_written(tmp_path: Path, ending: str, text: str) -> None:
    source = tmp_path / "in.csv"
    source.write_text(text, encoding="utf-8")
    one = read(source)
    write(tmp_path / f"out{ending}", one)
    was, now = survey_recording(one).to_dict(), survey(tmp_path / f"out{ending}").to_dict()
    assert now["time"] == was["time"] | {"interval_from": now["time"]["interval_from"]}
    assert now["rows"] == was["rows"]
    names = [channel.pop("name") for channel in was["channels"]]
    for channel, said, name in zip(now["channels"], was["channels"], names, strict=True):
        assert bare(channel.pop("name")) == bare(name, ending)
        assert channel | {"unit_from": ""} == said | {"unit_from": ""}
    codes = [{one["code"] for one in content["remarks"]} for content in (was, now)]
    assert codes[0] - codes[1] <= {"time_unit_assumed", "naive_time", "decimal_comma"}  # what is written says it
    assert codes[1] <= codes[0]


def bare(name: str, ending: str = "") -> str:
    """The name without its unit, as the format has it."""
    plain = name.split(" [", maxsplit=1)[0].split(" (", maxsplit=1)[0]
    return plain.replace(".", "_") if ending == ".mat" else plain


@pytest.mark.parametrize("ending", FORMATS)
@pytest.mark.parametrize(
    "name",
    [
        "imucal_ferraris/ferraris_example.csv",
        "sunsided_mpu6050_static/set-1__unmoved-x-pointing-up/mpu6050_gyroscope.mat",
        "tofupilot_thermal/imu_raw_data.csv",
        "imu_tk_xsens_mti/xsens_acc.mat",
        "noise/l3g_gyro_x/gyro2_x.txt",
    ],
)
def test_recordings_of_others(shared: Path, tmp_path: Path, name: str, ending: str) -> None:
    path = shared / "data" / name
    if not path.exists():
        pytest.skip(f"no {name}")
    one = read(path)
    again = there_and_back(tmp_path, ending, one)
    assert [bare(n) for n in again.names] == [bare(n, ending) for n in one.names]
    assert [c.unit for c in again.channels] == [c.unit for c in one.channels]
    for was, now in zip(one.channels, again.channels, strict=True):
        assert same_bits(was.data, now.data)
    assert (one.time_ns is None) == (again.time_ns is None)
    if one.time_ns is not None:
        np.testing.assert_array_equal(again.time_ns, one.time_ns)
    assert again.sample_interval == one.sample_interval


@pytest.mark.parametrize("ending", FORMATS)
def test_a_unit_said_by_flag_goes_into_the_file(tmp_path: Path, ending: str) -> None:
    source = tmp_path / "in.csv"
    source.write_text("t,wx,wy,temp\n0.1,1,2,20\n0.2,2,3,21\n0.4,3,4,21\n", encoding="utf-8")
    one = read(source, units={"gyro": "deg/s", "t": "min", "temp": "degC"})
    assert write(tmp_path / f"out{ending}", one) == ()
    again = read(tmp_path / f"out{ending}")
    assert [c.unit for c in again.channels] == ["deg/s", "deg/s", "degC"]
    assert [c.quantity for c in again.channels] == ["gyro", "gyro", "temperature"]
    np.testing.assert_array_equal(again.time_ns, one.time_ns)
    assert not [r for r in again.remarks if "unit" in r.code]


def test_a_csv_as_a_person_would_write_it(tmp_path: Path) -> None:
    data = np.array([1.0, np.nan, 3.0, 0.1])
    whole = Channel("volts", np.array([1.0, 2.0, np.nan, 4.0], dtype=np.float32), "V")
    time_ns = UTC + np.array([0, 1, 2, 5]) * SECOND
    one = recording(
        Channel("wx", data, "deg/s"), whole, Channel("n", np.arange(4, dtype=np.int16)),
        time_ns=time_ns, epoch="utc", sample_interval=1.0, interval_from="column", time_column="when",
    )  # fmt: skip
    write(tmp_path / "out.csv", one)
    assert (tmp_path / "out.csv").read_text() == (
        "time,wx [deg/s],volts [V],n\n"
        "2010-04-28 15:10:00Z,1,1.0,0\n2010-04-28 15:10:01Z,,2.0,1\n"
        "2010-04-28 15:10:02Z,3,,2\n2010-04-28 15:10:05Z,0.1,4.0,3\n"
    )
    flagged = recording(Channel("wx", data, "deg/s"), sample_interval=0.01, interval_from="flag")
    write(tmp_path / "out.csv", flagged)
    assert (tmp_path / "out.csv").read_text() == '# sample rate: 100.0 Hz\nwx [deg/s]\n"1"\n""\n"3"\n"0.1"\n'


@pytest.mark.parametrize("ending", [".csv", ".h5"])
def test_a_unit_in_any_spelling_goes_into_the_file(tmp_path: Path, ending: str) -> None:
    channels = tuple(
        Channel(f"acc_{axis}", np.arange(3.0), unit) for axis, unit in zip("xy", ("m/s2", "µg"), strict=True)
    )
    path = tmp_path / f"own{ending}"
    assert not write(path, Recording(channels, np.arange(3) * SECOND))
    assert [one.unit for one in read(path).channels] == ["m/s^2", "ug"]


def test_the_same_recording_gives_the_same_bytes(tmp_path: Path) -> None:
    one = recording(Channel("wx", np.array([0.1, 0.2]), "deg/s"), time_ns=np.array([0, SECOND]))
    for ending in FORMATS:
        contents = []
        for name in ("a", "b"):
            write(tmp_path / f"{name}{ending}", one)
            contents.append((tmp_path / f"{name}{ending}").read_bytes())
        assert contents[0] == contents[1]


def test_a_name_that_contradicts_its_unit_gives_way(tmp_path: Path) -> None:
    one = recording(
        Channel("voltage_x", np.array([0.1, 0.2]), "rad/s", "model", "x", "gyro"),
        Channel("status", np.array([1.5, 2.5]), "V"),
        Channel("n", np.array([5, 6]), "count"),
        Channel("gyro_y_mv", np.array([5, 6]), "deg/s", "model", "y", "gyro"),
    )
    for ending in FORMATS:
        remarks = write(tmp_path / f"out{ending}", one)
        again = read(tmp_path / f"out{ending}")
        assert [c.unit for c in again.channels] == ["rad/s", "V", "count", "deg/s"]
        assert [bare(name) for name in again.names] == ["gyro_x", "status", "channel_3", "gyro_y"]
        assert [r.code for r in remarks] == ["column_renamed"] * 3
    assert "'voltage_x' is written as 'gyro_x [rad/s]'" in write(tmp_path / "out.csv", one)[0].what


def test_no_two_columns_get_one_name(tmp_path: Path) -> None:
    one = recording(
        Channel("wx", np.array([0.1, 0.2]), "deg/s"),
        Channel("wx [deg/s]", np.array([1.5, 2.5]), "deg/s"),
        Channel("time", np.array([1.5, 2.5]), "V"),
        time_ns=np.array([0, SECOND]),
    )
    for ending in FORMATS:
        again = there_and_back(tmp_path, ending, one)
        assert len(set(again.names)) == 3
        assert [c.unit for c in again.channels] == ["deg/s", "deg/s", "V"]
        np.testing.assert_array_equal(again.time_ns, [0, SECOND])


# Time


def test_numbers_are_the_nearest_floats() -> None:
    """Against the decimal text of each stamp, which Python rounds correctly."""
    stamps = np.array([1, 100_000_000, 123_456_000_000, -10_000_001, 9_007_199_254_740_991], dtype=np.int64)
    expected = [float(f"{'-' if s < 0 else ''}{abs(int(s)) // SECOND}.{abs(int(s)) % SECOND:09d}") for s in stamps]
    np.testing.assert_array_equal(numbers(stamps, "s"), expected)
    assert numbers(np.array([0, 2 * SECOND]), "s").dtype == np.int64
    np.testing.assert_array_equal(numbers(np.array([0, 2_500_000]), "ms"), [0.0, 2.5])
    np.testing.assert_array_equal(numbers(np.array([0, 90 * SECOND]), "min"), [0.0, 1.5])
    epochs = numbers(UTC + np.array([250_000_000, 500_000_000, SECOND]), "s")
    np.testing.assert_array_equal(epochs, [1_272_467_400.25, 1_272_467_400.5, 1_272_467_401.0])


def test_time_keeps_its_name_where_the_recording_tells_it() -> None:
    said = {"t_s": "t_s", "Time (s)": "Time (s)", "it's": "it's", "": "time", "wx": "time"}
    for name, expected in said.items():
        one = recording(Channel("wx", np.zeros(2)), interval_from="column", time_column=name)
        assert time_name(one) == expected
    assert time_name(recording(interval_from="flag")) == "time"


def test_stamps_that_seconds_cannot_hold_go_in_nanoseconds_or_instants() -> None:
    fine = np.array([0, 1]) + 10**17  # 0.1 years in steps of 1 ns
    column = time_column(recording(Channel("a", np.zeros(2)), time_ns=fine), in_names=True)
    assert column is not None
    assert column.name == "time [ns]"
    in_ms = recording(Channel("a", np.zeros(2)), time_ns=fine, interval_from="column", time_column="t_ms")
    column = time_column(in_ms, in_names=False)
    assert column is not None
    assert (column.name, column.unit) == ("time", "ns")
    named = recording(
        Channel("a", np.zeros(2)), time_ns=UTC + fine, epoch="utc", interval_from="column", time_column="unix_s"
    )
    column = time_column(named, in_names=True)
    assert column is not None
    assert column.values.dtype == "datetime64[ns]"


def test_time_that_cannot_be_told_is_refused(tmp_path: Path) -> None:
    elapsed = recording(Channel("a", np.zeros(2)), time_ns=np.array([UTC, UTC + 1]), epoch="elapsed")
    early = recording(Channel("a", np.zeros(2)), time_ns=np.array([-(2**63) + 1, 0]), epoch="utc")
    for one in (elapsed, early):
        with pytest.raises(DataError, match="cannot be written in a form that reads back"):
            write(tmp_path / "out.csv", one)
    np.testing.assert_array_equal(there_and_back(tmp_path, ".parquet", early).time_ns, early.time_ns)
    for ending in FORMATS:
        flight = recording(Channel("time_of_flight", np.array([0.5, 0.7]), "s"))
        with pytest.raises(DataError, match=r"time_of_flight.* would be mistaken for the time"):
            write(tmp_path / f"out{ending}", flight)
        backward = recording(Channel("a", np.zeros(3)), time_ns=np.array([3, 2, 1]) * SECOND)
        with pytest.raises(DataError, match="there would be no time"):
            write(tmp_path / f"out{ending}", backward)


# What is refused


def test_the_input_is_never_replaced(tmp_path: Path) -> None:
    source = tmp_path / "in.csv"
    source.write_text("t_s,a\n0,1\n1,2\n2,3\n")
    (tmp_path / "link.csv").symlink_to(source)
    os.link(source, tmp_path / "hard.csv")
    for name in ("in.csv", "link.csv", "hard.csv"):
        with pytest.raises(DataError, match="would overwrite the input") as caught:
            write(tmp_path / name, read(source))
        assert caught.value.problems[0].code == "overwrites_input"
    assert source.read_text() == "t_s,a\n0,1\n1,2\n2,3\n"


def test_a_file_is_complete_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    one = recording(Channel("a", np.array([1.0, 2.0])))
    write(tmp_path / "out.csv", one)
    before = (tmp_path / "out.csv").read_bytes()

    def broken(path: Path, _: Recording) -> tuple[()]:
        path.write_text("half")
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(WRITERS, ".csv", broken)
    with pytest.raises(StoreError, match="No space left"):
        write(tmp_path / "out.csv", one)
    assert (tmp_path / "out.csv").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["out.csv"]


@pytest.mark.parametrize(("name", "words"), [("no/out.csv", "no folder"), ("a.csv", "a folder"), ("\0.csv", "a nul")])
def test_places_that_cannot_be_written(tmp_path: Path, name: str, words: str) -> None:
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(StoreError, match=words):
        write(tmp_path / name, recording(Channel("a", np.array([1.0, 2.0]))))


@pytest.mark.parametrize("name", ["out", "out.xlsx", "out.csv.gz"])
def test_other_endings_are_wrong_usage(tmp_path: Path, name: str) -> None:
    with pytest.raises(UsageError, match="is not a format that can be written") as caught:
        write(tmp_path / name, recording(Channel("a", np.array([1.0, 2.0]))))
    assert ".csv, .parquet, .npz" in caught.value.problems[0].do


@pytest.mark.parametrize("data", [np.array(["a", "b"]), np.array([1j, 2]), np.array([1, 2], np.longdouble)])
def test_what_is_no_number_is_refused(tmp_path: Path, data: NDArray[Any]) -> None:
    with pytest.raises(DataError, match="need whole numbers or floats") as caught:
        write(tmp_path / "out.csv", recording(Channel("a", data)))
    assert caught.value.problems[0].code == "not_numbers"


def test_names_that_csv_cannot_hold_are_refused(tmp_path: Path) -> None:
    for names in (("1", "2"), ("# a", "b")):
        one = recording(*(Channel(name, np.array([1.5, 2.5])) for name in names))
        with pytest.raises(DataError, match="would not be recognised") as caught:
            write(tmp_path / "out.csv", one)
        assert "Parquet" in caught.value.problems[0].do
        assert there_and_back(tmp_path, ".parquet", one).names == names


def test_one_sample_and_no_channel(tmp_path: Path) -> None:
    single = recording(Channel("a", np.array([1.5])), time_ns=np.array([5 * SECOND]))
    with pytest.raises(DataError, match="need 2 for a file of arrays"):
        write(tmp_path / "out.npz", single)
    assert there_and_back(tmp_path, ".parquet", single).channel("a").data == [1.5]
    with pytest.raises(DataError, match="without channels"):
        write(tmp_path / "out.csv", recording())


def test_what_is_not_kept_is_remarked(tmp_path: Path) -> None:
    one = recording(Channel("a", np.array([1.5, 2.5])), averaging_time=1.0, source=Source("gone.csv"))
    assert [remark.code for remark in write(tmp_path / "out.csv", one)] == ["averaging_time_not_kept"]


def test_what_the_clock_is_known_to_stands_in_parquet_alone(tmp_path: Path) -> None:
    clock = ClockRate(5.8e-5, 812.0, "acquire: clock of imu from 2026-11-30T02:00:00Z")
    one = recording(Channel("a", np.array([1.5, 2.5])), time_ns=np.array([0, SECOND]), clock=clock)
    assert there_and_back(tmp_path, ".parquet", one).clock == clock
    assert clock_in(tmp_path / "out.parquet") == clock
    write(tmp_path / "none.parquet", replace(one, clock=None))
    (tmp_path / "no.parquet").write_bytes(b"PAR1")
    assert [clock_in(tmp_path / f"{name}.parquet") for name in ("none", "no", "gone")] == [None] * 3
    assert [remark.code for remark in write(tmp_path / "out.csv", one)] == ["clock_not_kept"]
    assert read(tmp_path / "out.csv").clock is None
    for said in (b"", b"[", b"[]", b"7", b'{"u": 0}', b'{"u": "x"}', b'{"u": NaN}', b'{"u": 1e-5, "dof": -1}'):
        assert clock_of(said) is None


def test_every_refusal_is_one_that_a_user_can_act_on(tmp_path: Path) -> None:
    with pytest.raises(InertialcalError) as caught:
        write(tmp_path / "no" / "out.csv", recording(Channel("a", np.array([1.5, 2.5]))))
    assert caught.value.exit_status == 3


# Files of arrays, as other programs see them


def flight() -> Recording:
    return recording(
        Channel("gyro_x [deg/s]", np.array([0.5, np.nan, 1.5]), "deg/s"),
        Channel("n/s", np.array([1, 2, 3], dtype=np.int16)),
        time_ns=UTC + np.array([0, 1, 3]) * SECOND, epoch="utc", interval_from="column", time_column="when",
    )  # fmt: skip


def test_hdf5_as_h5py_sees_it(tmp_path: Path) -> None:
    write(tmp_path / "out.h5", flight())
    with h5py.File(tmp_path / "out.h5") as file:
        assert list(file) == ["when", "gyro_x", "n_s"]
        assert file["gyro_x"].attrs["units"] == "deg/s"
        np.testing.assert_array_equal(file["gyro_x"], [0.5, np.nan, 1.5])
        np.testing.assert_array_equal(file["when"][()] - UTC // SECOND, [0, 1, 3])
        assert file["when"].attrs["units"] == "s"


def test_matlab_as_scipy_sees_it(tmp_path: Path) -> None:
    write(tmp_path / "out.mat", flight())
    content = loadmat(tmp_path / "out.mat", simplify_cells=True)
    assert content["units"] == {"when": "s", "gyro_x": "deg/s"}
    np.testing.assert_array_equal(content["gyro_x"], [0.5, np.nan, 1.5])
    np.testing.assert_array_equal(content["when"] - UTC // SECOND, [0, 1, 3])
    assert content["n_s"].dtype == np.int16


def test_a_structure_named_units_that_holds_numbers_is_data(tmp_path: Path) -> None:
    savemat(tmp_path / "in.mat", {"units": {"a": np.arange(5.0), "b": np.arange(5.0)}, "gyro_x": np.arange(5.0)})
    assert set(read(tmp_path / "in.mat").names) == {"units.a", "units.b", "gyro_x"}


@pytest.mark.parametrize("ending", [".h5", ".mat"])
def test_names_that_the_format_cannot_hold_are_told(tmp_path: Path, ending: str) -> None:
    one = recording(*(Channel(name, np.array([1.5, 2.5])) for name in ("#a", "a/b", "a_b", "ä°", "1")))
    remarks = write(tmp_path / f"out{ending}", one)
    again = read(tmp_path / f"out{ending}")
    assert len(set(again.names)) == len(again.channels) == 5
    assert {remark.code for remark in remarks} == {"column_renamed"}


@pytest.mark.parametrize("ending", [".npz", ".h5", ".mat"])
def test_names_that_the_format_needs_itself_lose_no_channel(tmp_path: Path, ending: str) -> None:
    names = ("units", "sample_rate", "sample_rate_hz", "gyro_x")
    channels = [Channel(name, np.array([i + 0.5, i + 1.5]), "V") for i, name in enumerate(names)]
    again = there_and_back(tmp_path, ending, recording(*channels, sample_interval=0.01, interval_from="flag"))
    assert [one.data[0] for one in again.channels] == [0.5, 1.5, 2.5, 3.5]
    assert [one.unit for one in again.channels] == ["V"] * 4
    assert again.sample_rate == 100.0


def test_units_of_no_variable_are_told(tmp_path: Path) -> None:
    savemat(tmp_path / "in.mat", {"gyro_x": np.arange(5.0), "units": {"gyro": "deg/s"}})
    again = read(tmp_path / "in.mat")
    assert "units.gyro" in next(one.what for one in again.remarks if one.code == "variables_left_out")
