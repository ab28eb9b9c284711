"""Readers of other distributions: an entry point is enough, a broken one is named, none takes a file of ours."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError
from inertialcal.files.registry import READERS, readable

TOY = """
import numpy as np

from inertialcal.files.binary.arrays import number_column
from inertialcal.files.columns import Content
from inertialcal.files.reader import Reader


def recognises(data, path):
    return data.startswith(b"TOY1")


def read(loaded, variables):
    table = np.frombuffer(loaded.data[4:], dtype="<f8").reshape(-1, 2)
    columns = (number_column("time [s]", table[:, 0], None), number_column("gyro_x", table[:, 1], "deg/s"))
    return Content(columns, "Toy, little endian")


READER = Reader("toy", "Toy logger", (".toy",), recognises, read)
"""
Install = Callable[..., None]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Put a distribution with one module and its entry points on the path."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(site)
    made: list[str] = []

    def put(text: str, module: str = "toy_reader", /, **entries: str) -> None:
        (site / f"{module}.py").write_text(text)
        made.append(module)
        info = site / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module.replace('_', '-')}\nVersion: 1.0\n")
        lines = [f"{name} = {value}" for name, value in (entries or {"toy": f"{module}:READER"}).items()]
        (info / "entry_points.txt").write_text("\n".join(["[inertialcal.readers]", *lines, ""]))
        importlib.invalidate_caches()
        forget()

    yield put
    forget()
    for module in made:
        sys.modules.pop(module, None)


def forget() -> None:
    """Let the registry look for installed readers anew."""
    READERS.__dict__.pop("installed", None)
    READERS._loaded.clear()


def toy_file(folder: Path, name: str = "a.toy") -> Path:
    path = folder / name
    time = np.arange(200) * 0.01
    path.write_bytes(b"TOY1" + np.column_stack([time, np.sin(time)]).astype("<f8").tobytes())
    return path


def code(path: Path) -> str:
    with pytest.raises(DataError) as caught:
        ic.read(path)
    return caught.value.problems[-1].code


def test_a_reader_of_another_distribution_is_one_entry_point(
    install: Install, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = toy_file(tmp_path)
    assert code(path) == "not_text"
    install(TOY)
    recording = ic.read(path)
    assert recording.source.format == "Toy, little endian"
    assert recording.channel("gyro_x").unit == "deg/s"
    assert recording.sample_interval == pytest.approx(0.01)
    assert not recording.remarks
    assert ic.info(path).rows == 200
    assert len(ic.read_table(path)) == 200
    for words in (["info", str(path)], ["convert", str(path), str(tmp_path / "a.csv")]):
        with pytest.raises(SystemExit) as done:
            main(words)
        assert done.value.code == 0
    assert "Toy, little endian" in capsys.readouterr().out
    written = ic.read(tmp_path / "a.csv")
    np.testing.assert_array_equal(written.channels[0].data, recording.channels[0].data)


def test_it_is_loaded_only_where_nothing_of_ours_knows_the_file(install: Install, tmp_path: Path) -> None:
    install(TOY)
    (tmp_path / "a.csv").write_text("t [s],gyro_x [deg/s]\n0,1\n1,2\n2,3\n")
    np.save(tmp_path / "a.npy", np.arange(12.0).reshape(6, 2))
    ic.read(tmp_path / "a.csv")
    ic.read(tmp_path / "a.npy")
    assert "toy_reader" not in sys.modules
    ic.read(toy_file(tmp_path, "a.csv"))
    assert "toy_reader" in sys.modules


def test_text_under_an_ending_of_its_own_may_be_that_of_a_reader(install: Install, tmp_path: Path) -> None:
    text = TOY.replace('b"TOY1"', 'b"t,"').replace(
        'np.frombuffer(loaded.data[4:], dtype="<f8").reshape(-1, 2)', "np.ones((5, 2)) * np.arange(5)[:, None]"
    )
    install(text)
    for name in ("a.toy", "a.csv"):
        (tmp_path / name).write_text("t,gyro_x\n0,1\n1,2\n2,3\n")
    assert ic.read(tmp_path / "a.toy").source.format == "Toy, little endian"
    assert ic.read(tmp_path / "a.csv").source.format.startswith("text")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("import a_module_that_nobody_has", "cannot be loaded (ModuleNotFoundError"),
        ("def :", "cannot be loaded (SyntaxError"),
        ("READER = 3", "is a int, not a Reader"),
        (TOY.replace('"toy", "Toy', '"text", "Toy'), "calls itself 'text'"),
        (TOY.replace("return data.startswith", "return missing.startswith"), "name 'missing' is not defined"),
    ],
)
def test_a_broken_reader_is_named(text: str, why: str, install: Install, tmp_path: Path) -> None:
    install(text)
    path = toy_file(tmp_path)
    with pytest.raises(DataError) as caught:
        ic.read(path)
    assert [one.code for one in caught.value.problems] == ["not_text", "broken_plugin"]
    assert "reader 'toy' of toy-reader 1.0" in str(caught.value.problems[1])
    assert why in str(caught.value.problems[1])
    (tmp_path / "b.toy").write_text("t [s],gyro_x [deg/s]\n0,1\n1,2\n2,3\n")
    (remark,) = (one for one in ic.read(tmp_path / "b.toy").remarks if one.code == "broken_plugin")
    assert why in remark.what
    (tmp_path / "b.json").write_text('{"a": 1}')
    with pytest.raises(DataError, match=r"this is JSON[\s\S]*reader 'toy' of toy-reader 1.0"):
        ic.read(tmp_path / "b.json")


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("np.frombuffer(", "missing(", "cannot be read as Toy logger, by the reader 'toy' of toy-reader 1.0: name"),
        ('return Content(columns, "Toy, little endian")', "return columns", "gives a tuple, need a Content"),
        ("table[:, 0], None", "table[:9, 0], None", "columns of different length"),
        ('"gyro_x"', '"time [s]"', "two columns of one name"),
        ('number_column("gyro_x", table[:, 1], "deg/s")', "3", "neither numbers, times nor text"),
    ],
)
def test_a_reader_that_fails_gives_an_error_to_act_on(
    old: str, new: str, what: str, install: Install, tmp_path: Path
) -> None:
    assert old in TOY
    install(TOY.replace(old, new))
    with pytest.raises(DataError) as caught:
        ic.read(toy_file(tmp_path))
    assert what in caught.value.problems[0].what


def test_a_second_reader_works_beside_a_broken_one(install: Install, tmp_path: Path) -> None:
    install("import a_module_that_nobody_has", "broken_reader", bad="broken_reader:READER")
    install(TOY)
    recording = ic.read(toy_file(tmp_path))
    assert len(recording) == 200
    assert [one.code for one in recording.remarks] == ["broken_plugin"]


def test_the_name_of_a_built_in_reader_is_taken(install: Install, tmp_path: Path) -> None:
    install(TOY, text="toy_reader:READER")
    assert code(toy_file(tmp_path)) == "not_text"
    assert "toy_reader" not in sys.modules


def test_all_formats_are_listed() -> None:
    assert readable() == (
        "CSV and other text, Parquet, MATLAB, HDF5, NumPy, card images of 1969, ROS 1 and 2 bags, MCAP, PX4 ULog, "
        "ArduPilot logs, Excel, TDMS, UFF 58, WAV, Arrow (Feather), ASAM MDF, enDAQ IDE, LabVIEW measurement (LVM), "
        "miniSEED, SQLite, JSON lines, PAD pairs"
    )
