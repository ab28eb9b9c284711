"""read: units, missing values, remarks; the file as it is."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError, UsageError
from inertialcal.files import read


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "a.csv"
    path.write_text(
        "t_s,gyro_x [deg/s],gyro_y,acc_x,temp_degC,status\n0.0,1,2,3,20,1\n0.1,1,,3,20,1\n0.2,2,3,NaN,20,1\n"
    )
    return path


def test_channels(file: Path) -> None:
    recording = read(file)
    assert [(c.name, c.quantity, c.axis, c.unit, c.unit_from) for c in recording.channels] == [
        ("gyro_x [deg/s]", "gyro", "x", "deg/s", "header"),
        ("gyro_y", "gyro", "y", None, ""),
        ("acc_x", "acc", "x", None, ""),
        ("temp_degC", "temperature", "", "degC", "header"),
        ("status", "status", "", None, ""),
    ]
    assert recording.channels[0].data.dtype == np.int64
    assert recording.first_row == 2
    assert recording.source.format == "text, comma-separated"
    with pytest.raises(ValueError, match="read-only"):
        recording.channels[0].data[0] = 5


def test_missing_values_are_nan_counted_and_placed(file: Path) -> None:
    recording = read(file)
    np.testing.assert_array_equal(recording.channel("gyro_y").data, [2.0, np.nan, 3.0])
    assert [str(remark) for remark in recording.remarks] == [
        f"info: {file}:3: empty cell in 'gyro_y': missing",
        f"warning: {file}:4: NaN or inf in 'acc_x': treated as missing",
    ]


def test_a_literal_nan_in_a_required_column(file: Path) -> None:
    read(file, required=["gyro_y", "gyro_x"])
    with pytest.raises(DataError, match=r"a\.csv:4: literal 'NaN' in required column 'acc_x'") as caught:
        read(file, required=["acc_x"])
    assert caught.value.problems[0].code == "nan_in_required"


def test_a_required_column_that_is_not_there_or_text(file: Path) -> None:
    with pytest.raises(DataError, match=r"no column 'acc_z'\. The file has: t_s, gyro_x"):
        read(file, required=["acc_z"])
    file.write_text("x,part\n1,a\n2,b\n")
    with pytest.raises(DataError, match="text 'a' in number column 'part'"):
        read(file, required=["part"])


def test_units_by_group_and_by_column(file: Path) -> None:
    recording = read(file, units={"gyr": "dps", "gyro_y": "rad/s", "acc": "m/s2"})
    assert [c.unit for c in recording.channels[:3]] == ["deg/s", "rad/s", "m/s^2"]
    assert [c.unit_from for c in recording.channels[:3]] == ["flag"] * 3
    assert read(file, units={"gyro_x": "mdps"}).channels[0].unit == "mdeg/s"


def test_a_flag_against_the_header_is_remarked(file: Path) -> None:
    (remark, *_) = read(file, units={"gyro": "rad/s"}).remarks
    assert remark.what == "'gyro_x [deg/s]' is deg/s by its header, rad/s by the option: the option wins"


@pytest.mark.parametrize(
    ("units", "words", "code"),
    [
        ({"magneto": "T"}, r"no column or group 'magneto' to.* Columns: t_s, .* Groups: acc, gyro", "wrong_column"),
        ({"mag": "uT"}, "no column or group 'mag'", "wrong_column"),
        ({"gyro": "g"}, "g measures acceleration, column 'gyro_x .*' is gyro", "unit_mismatch"),
        ({"acc": "deg/s"}, "deg/s measures angular rate, column 'acc_x' is acc", "unit_mismatch"),
    ],
)  # fmt: skip
def test_units_that_fit_nothing(file: Path, units: dict[str, str], words: str, code: str) -> None:
    with pytest.raises(UsageError, match=words) as caught:
        read(file, units=units)
    assert caught.value.problems[0].code == code


def test_an_unknown_unit(file: Path) -> None:
    with pytest.raises(DataError, match="furlong") as caught:
        read(file, units={"gyro": "furlong"})
    assert caught.value.problems[0].code == "unknown_unit"


def test_a_bracket_that_is_no_unit_is_remarked(file: Path) -> None:
    file.write_text("acc_x (filtered)\n1\n2\n")
    recording = read(file)
    assert recording.channels[0].unit is None
    assert recording.remarks[0].code == "unknown_unit"


def test_a_column_of_text_is_no_channel_and_remarked(file: Path) -> None:
    file.write_text("part,x\nx_a,1\nx_a,2\nx_p,3\n")
    recording = read(file)
    assert recording.names == ("x",)
    assert recording.remarks[0].what == "column 'part' is text (2 different: x_a, x_p): no channel"


def test_a_file_of_text_alone(file: Path) -> None:
    file.write_text("a,b\nx,y\nz,w\n")
    with pytest.raises(DataError, match=r"no column of numbers, apart from time\. The file has: a, b") as caught:
        read(file)
    assert caught.value.problems[0].code == "no_channel"


def test_gzip_is_the_same(file: Path, tmp_path: Path) -> None:
    packed = tmp_path / "a.csv.gz"
    packed.write_bytes(gzip.compress(file.read_bytes()))
    plain, unpacked = read(file), read(packed)
    np.testing.assert_array_equal(plain.array(), unpacked.array())
    assert unpacked.source.format == "text, comma-separated, gzip"


def test_the_unfilled_end_of_a_buffer_is_left_out_and_counted(file: Path) -> None:
    rows = [f"{0.1 + i / 10},{i % 7 - 3}" for i in range(50)] + ["0,0"] * 20
    file.write_text("\n".join(rows))
    recording = read(file)
    assert len(recording) == 50
    (remark, *_) = recording.remarks
    assert (remark.code, remark.count, remark.where) == ("unfilled_end", 20, f"{file}:51")


def test_zeros_at_the_end_of_a_measurement_stay(file: Path) -> None:
    for rows in ([f"{i % 5},{i % 7}" for i in range(1, 50)] + ["0,0"] * 20, ["1"] * 30 + ["0"] * 20):
        file.write_text("\n".join(rows))
        assert len(read(file)) == len(rows)
    file.write_text("0,0\n" * 30)
    assert len(read(file)) == 30


def test_gaps_and_order_are_remarked_with_their_row(file: Path) -> None:
    stamps = [i for i in range(100) if i not in (40, 41)]
    stamps[60] = stamps[59]
    stamps[80], stamps[81] = stamps[81], stamps[80]
    file.write_text("t_s,x\n" + "\n".join(f"{t},{t % 7}" for t in stamps))
    found = {remark.code: remark for remark in read(file).remarks}
    assert found["gaps"].where == f"{file}:41"
    assert "longest step 3 s against 1 s" in found["gaps"].what
    assert found["repeated_stamps"].where == f"{file}:62"
    assert found["time_backwards"].count == 1


@pytest.mark.parametrize("name", ["column_1", "1"])
def test_columns_without_a_name_can_be_meant(file: Path, name: str) -> None:
    file.write_text("1.5\n2.5\n1.0\n")
    assert read(file, units={name: "deg/s"}).channels[0].unit == "deg/s"
