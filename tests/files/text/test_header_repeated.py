"""Two recordings in one file: the header stands again, or time starts again."""

from pathlib import Path

import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.files import read, read_table


def part(first: float = 0.0, rows: int = 40, separator: str = ",") -> str:
    return "".join(f"{first + 0.1 * i:.1f}{separator}{(i * 37 % 11) / 10}\n" for i in range(rows))


@pytest.mark.parametrize(("header", "separator"), [("t_s,gyro_x", ","), ("t_s gyro_x", None), ('"t_s";"gyro_x"', ";")])
def test_the_header_in_the_middle_is_refused_with_its_row(tmp_path: Path, header: str, separator: str | None) -> None:
    file = tmp_path / "a.csv"
    body = part(separator=separator or " ")
    file.write_text(f"{header}\n{body}{header}\n{body}")
    for reading in (read, read_table):
        with pytest.raises(DataError) as refused:
            reading(file)
        (problem,) = refused.value.problems
        assert (problem.code, problem.where) == ("header_repeated", f"{file}:42")
        assert "Split the file" in problem.do


def test_a_header_that_is_a_comment_is_remarked(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text(f"# t_s, gyro_x\n{part()}# t_s, gyro_x\n{part(4.0)}")
    found = {one.code: one for one in read(file).remarks}
    assert found["header_repeated"].where == f"{file}:42"
    assert "time_backwards" not in found


def test_a_name_among_the_cells_is_no_header(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("x,y\n1,x\n2,y\n3,x\n")
    assert read(file).names == ("x",)


def test_time_that_starts_again_is_named_with_its_row(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text(f"t_s,gyro_x\n{part(5.0)}{part(5.0)}")
    found = {one.code: one for one in read(file).remarks}
    assert found["time_backwards"].where == f"{file}:42"
    assert found["time_backwards"].what == (
        "time goes back by 3.9 s, from 3.9 s to 0 s after the first stamp, its beginning: "
        "a second recording in the same file?"
    )
    assert found["time_backwards"].do == "Split the file there"


def test_a_stamp_out_of_order_is_no_second_recording(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    time = 0.1 * np.arange(60)
    time[30] -= 1.0
    file.write_text("t_s,gyro_x\n" + "".join(f"{t:.1f},1\n" for t in time))
    (found,) = [one for one in read(file).remarks if one.code == "time_backwards"]
    assert found.where == f"{file}:32"
    assert found.what == "time goes back by 0.9 s, from 2.9 s to 2 s after the first stamp"
    assert "--sample-rate" in found.do
