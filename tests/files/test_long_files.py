"""A long file that stays in place, and is read a piece at a time, gives the recording of one that is read whole."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from inertialcal.core import batches
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.core.recording import Recording
from inertialcal.files import read
from inertialcal.files.binary import arrays
from inertialcal.files.source import FileBytes
from inertialcal.files.text import pieces
from inertialcal.files.write import csv
from inertialcal.files.write.recording import write

ROWS = 260  # more than the lines that tell a layout


def in_place(path: Path, piece: int, **options: Any) -> Recording:
    """Read a file in place, its text in pieces of so many bytes; the reading may not fall back to the whole file."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "HELD", 0)
        patch.setattr(batches, "SIZE", max(piece // 8, 50))
        patch.setattr(pieces, "PIECE", piece)
        patch.setattr(arrays, "AT_ONCE", piece)
        return read(path, **options)


def assert_same(found: Recording, expected: Recording) -> None:
    assert found.names == expected.names
    for name in expected.names:
        one, other = found.channel(name), expected.channel(name)
        assert (one.unit, one.quantity, one.data.dtype) == (other.unit, other.quantity, other.data.dtype), name
        np.testing.assert_array_equal(one.data, other.data)
        if one.data.dtype.kind == "f":
            np.testing.assert_array_equal(np.signbit(one.data), np.signbit(other.data))
    assert (found.time_ns is None) == (expected.time_ns is None)
    if found.time_ns is not None and expected.time_ns is not None:
        np.testing.assert_array_equal(found.time_ns, expected.time_ns)
    assert (found.source, found.first_row, found.sample_interval) == (
        expected.source, expected.first_row, expected.sample_interval,
    )  # fmt: skip
    assert [str(one) for one in found.remarks] == [str(one) for one in expected.remarks]


def outcome(reading: Callable[[], Recording]) -> Recording | tuple[Any, ...]:
    """Return the recording, or the problems of its refusal."""
    try:
        return reading()
    except InertialcalError as error:
        return type(error), error.problems


def assert_judged_alike(path: Path, piece: int, **options: Any) -> None:
    expected = outcome(lambda: read(path, **options))
    found = outcome(lambda: in_place(path, piece, **options))
    if isinstance(expected, Recording) and isinstance(found, Recording):
        assert_same(found, expected)
    else:
        assert found == expected


@pytest.fixture
def pieces_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a file in place fail that is read whole after all."""

    def refused(loaded: Any) -> Any:
        assert not isinstance(loaded.data, FileBytes), "read whole"
        return loaded

    monkeypatch.setattr(pieces, "whole", refused)


def rows(separator: str = ",", cells: Callable[[int], Sequence[str]] | None = None) -> list[str]:
    rng = np.random.default_rng(3)
    x = rng.normal(size=ROWS)

    def usual(i: int) -> Sequence[str]:
        return f"{i / 200:.3f}", f"{x[i]:.6f}", str(int(1000 * x[i]))

    return [separator.join((cells or usual)(i)) for i in range(ROWS)]


HEAD = "t [s],gyro_x [deg/s],raw\n"


def text(separator: str = ",", head: str = HEAD, end: str = "\n", last: str = "\n", **more: Any) -> bytes:
    return (head.replace(",", separator) + end.join(rows(separator, **more)) + last).encode()


REGULAR = {
    "plain": text(),
    "no line end": text(last=""),
    "blank end": text(last="\n\n \n"),
    "ctrl-z": text(last="\n\x1a"),
    "cut off": text(last="\n1.3,0.2"),
    "windows": text(head=HEAD.replace("\n", "\r\n"), end="\r\n", last="\r\n"),
    "tabs": text("\t"),
    "blanks": text("   ", head="t,gyro_x,raw\n"),
    "semicolons": text(";"),
    "degrees": text(head="# Gerät\nt [s],temp [°C],raw\n"),
    "bom": b"\xef\xbb\xbf" + text(),
    "latin-1": text(head="# Gerät\n" + HEAD).decode().encode("latin-1"),
    "no header": text(head="# sample rate: 200 Hz\n", cells=lambda i: (f"{i % 7}.5", str(i % 5))),
    "one column": text(head="gyro_x [deg/s]\n", cells=lambda i: (f"{i % 7}.5",)),
    "separator at the end": text(cells=lambda i: (f"{i / 200:.3f}", "1.5", str(i % 9), "")),
    "whole at first": text(cells=lambda i: (str(i), "-0" if i < 200 else f"{i}.5", str(i))),
    "empty among whole": text(cells=lambda i: (str(i / 100), "" if i in (7, 255) else str(i % 3), "3"[: i < 250])),
    "nan": text(cells=lambda i: (str(i / 100), "nan" if i in (7, 255) else f"{i % 3}.5", "NaN" if i == 99 else "3")),
    "unfilled": (HEAD + "\n".join([*rows()[1:], *(9 * ["0,0,0"])]) + "\n").encode(),
}  # fmt: skip
OPTIONS: dict[str, dict[str, Any]] = {"one column": {"sample_rate": 100.0}, "whole at first": {"units": {"t": "ms"}}}


@pytest.mark.usefixtures("pieces_only")
@pytest.mark.parametrize("name", REGULAR)
@pytest.mark.parametrize("shorter", [0, 1, 2])
def test_a_regular_text(tmp_path: Path, name: str, shorter: int) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(REGULAR[name])
    options = OPTIONS.get(name, {})
    expected = read(path, **options)
    least = len(REGULAR[name]) * 9 // 10  # the first piece holds the lines that tell the layout
    found = in_place(path, least - shorter, **options)
    assert_same(found, expected)
    assert all(batches.is_stored(one.data) for one in found.channels)


@pytest.mark.usefixtures("pieces_only")
def test_a_stated_decimal_comma(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(text(";").replace(b".", b","))
    assert_same(in_place(path, 4500, decimal="comma"), read(path, decimal="comma"))


def irregular(at: int, line: str) -> bytes:
    lines = rows()
    lines[at] = line
    return (HEAD + "\n".join(lines) + "\n").encode()


ODD = {
    "quotes": irregular(255, '"1.275","0.5","3"'),
    "comment": irregular(255, "# a note"),
    "blank line": irregular(255, ""),
    "blanks": irregular(255, "   "),
    "text": irregular(255, "1.275,many,3"),
    "ragged": irregular(255, "1.275,0.5"),
    "hexadecimal": irregular(255, "1.275,0x1F,3"),
    "infinite": irregular(255, "1.275,1e999,3"),
    "letters": irregular(255, "1.275,ä,3"),
    "nul": irregular(255, "1.275,\x00,3"),
    "control": irregular(255, "1.275,\x01,3"),
    "header again": irregular(255, HEAD.strip()),
    "labels": text(cells=lambda i: (f"{i / 200:.3f}", "1.5", "warm" if i < 99 else "cold")),
    "instants": text(cells=lambda i: (f"2024-05-01T10:{i // 60:02d}:{i % 60:02d}Z", "1.5", "3")),
    "decimal commas": text(";").replace(b".", b","),
    "commas late": text(";", cells=lambda i: (str(i), str(i % 7) if i < 240 else f"{i % 7},51", "3")),
    "across": " ".join(f"{i % 7}.5" for i in range(3000)).encode(),
    "short": b"t [s],gyro_x\n0,1\n1,2\n2,1\n",
    "no line": b"1" * 3000,
}


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("piece", [4600, 5500, 10**6])
def test_any_other_text_is_judged_as_a_whole(tmp_path: Path, name: str, piece: int) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(ODD[name])
    assert_judged_alike(path, piece, sample_rate=100.0)


CELLS = st.sampled_from(["1", "-0", "0.5", "", "nan", "7e3", " 2", "x", '"1"', "12345678901234567890"])


@given(odd=st.lists(st.tuples(st.integers(0, 59), CELLS), max_size=4), piece=st.integers(3900, 6000))
def test_wherever_pieces_end(tmp_path_factory: pytest.TempPathFactory, odd: list[tuple[int, str]], piece: int) -> None:
    lines = rows(cells=lambda i: (f"{i / 200:.3f}", str(i % 9), f"{i % 9}.25"))
    for back, cell in odd:
        lines[-1 - back] = f"{lines[-1 - back].split(',')[0]},{cell},{cell}"
    path = tmp_path_factory.mktemp("text") / "a.csv"
    path.write_text(HEAD + "\n".join(lines) + "\n")
    assert_judged_alike(path, piece)


@pytest.mark.parametrize(
    "stamp",
    ["2024-05-01T10:{:02d}:{:06.3f}Z", "2024-05-01 10:{:02d}:{:06.3f}", "1969-05-01T10:{:02d}:{:012.9f}+02:00",
     "2024-05-01T10:{:02d}:{:06.3f}-0330"],
)  # fmt: skip
@pytest.mark.parametrize("name", ["time", "logged"])
@pytest.mark.usefixtures("pieces_only")
def test_dates_are_read_in_pieces(tmp_path: Path, stamp: str, name: str) -> None:
    path = tmp_path / "a.csv"
    lines = (f"{stamp.format(i // 60, i % 60 + 0.125)},{i % 9},{i % 9}.25" for i in range(2 * ROWS))
    path.write_text(f"{name},gyro_x [deg/s],raw\n" + "\n".join(lines) + "\n")
    found = in_place(path, 11_000)
    assert found.time_ns is not None
    assert batches.is_stored(found.time_ns)
    assert_judged_alike(path, 11_000)


@pytest.mark.parametrize("cell", ["2024-02-30T10:00:00Z", "2024-05-01", "2024-05-01T10:00:00+02", "noon", "", "10",
                                  "1650-05-01T10:00:00Z", "2024-05-01T10:00:00", " 2024-05-01T10:00:00,5Z",
                                  "2024-05-01T10:00:60Z"])  # fmt: skip
@pytest.mark.parametrize("at", [100, 515])
def test_dates_that_are_none_are_judged_as_in_the_whole(tmp_path: Path, cell: str, at: int) -> None:
    stamps = [f"2024-05-01T10:{i // 60:02d}:{i % 60:02d}.5Z" for i in range(2 * ROWS)]
    stamps[at] = cell
    path = tmp_path / "a.csv"
    path.write_text("time,gyro_x [deg/s]\n" + "".join(f"{stamp},{i % 9}.25\n" for i, stamp in enumerate(stamps)))
    assert_judged_alike(path, 11_000)


@pytest.mark.parametrize(
    ("at", "line", "code"),
    [
        (250, "1.25,hello,1", "text_in_numbers"),
        (255, '1.28,"a, b",1', "text_in_numbers"),
        (251, "1.25,x,max", "text_in_numbers"),
        (251, "1.25,1", "ragged_row"),
        (251, '1.25,"1,242",1', "grouped_digits"),
        (251, '1.25,"1",1', "too_large"),
    ],
)
def test_what_is_wrong_in_a_text_too_long_to_be_held_is_said_with_its_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at: int, line: str, code: str
) -> None:
    lines = rows(cells=lambda i: (f"{i / 200:.3f}", str(i % 9), f"{i % 9}.25"))
    lines[at] = line
    path = tmp_path / "a.csv"
    path.write_text(HEAD + "\n".join(lines) + "\n")
    expected = outcome(lambda: read(path))

    def too_long(loaded: Any) -> Any:
        raise DataError("needs more memory", loaded.path, code="too_large")

    monkeypatch.setattr(pieces, "whole", too_long)
    for piece in (3900, 10**6):
        found = outcome(lambda one=piece: in_place(path, one))  # type: ignore[misc]
        assert isinstance(found, tuple)
        assert found[1][0].code == code
        if code != "too_large":
            assert found == expected
            assert f"{path}:{at + 2}" in str(found[1][0])


def test_a_column_of_labels_in_a_text_too_long_to_be_held_is_no_mistake(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(text(cells=lambda i: (f"{i / 200:.3f}", "run" if i != 9 else "", f"{i % 9}.25")))

    def too_long(loaded: Any) -> Any:
        raise DataError("needs more memory", loaded.path, code="too_large")

    monkeypatch.setattr(pieces, "whole", too_long)
    found = outcome(lambda: in_place(path, 3900))
    assert isinstance(found, tuple)
    assert found[1][0].code == "too_large"


N = 500
RNG = np.random.default_rng(7)
GYRO = RNG.normal(size=(N, 3))
GYRO[7, 1], GYRO[400, 2] = np.nan, np.inf
RECORDS = np.zeros(N, dtype=[("t", "f8"), ("gyro_x", "f4"), ("raw", ">i2")])
RECORDS["t"], RECORDS["gyro_x"], RECORDS["raw"] = np.arange(N) / 100, GYRO[:, 0], np.arange(N) % 77
ARRAYS: dict[str, Any] = {
    "matrix": GYRO,
    "channels first": np.ascontiguousarray(GYRO.T),
    "column by column": np.asfortranarray(GYRO),
    "one": GYRO[:, 0].copy(),
    "counts": (1000 * GYRO[:, 0]).astype(">i2"),
    "half": GYRO.astype(np.float16),
    "long double": GYRO.astype(np.longdouble),
    "flags": GYRO[:, 0] > 0,
    "records": RECORDS,
    "deep": GYRO[:, :, None],
}


@pytest.mark.parametrize("name", ARRAYS)
@pytest.mark.parametrize("piece", [1000, 10**6])
def test_a_long_npy_file(tmp_path: Path, name: str, piece: int) -> None:
    path = tmp_path / "a.npy"
    np.save(path, ARRAYS[name])
    options: dict[str, Any] = {} if name == "records" else {"sample_rate": 100.0}
    found = in_place(path, piece, **options)
    assert_same(found, read(path, **options))
    assert all(batches.is_stored(one.data) for one in found.channels)


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
@pytest.mark.parametrize("piece", [1000, 10**6])
def test_a_long_npz_file(tmp_path: Path, save: Callable[..., None], piece: int) -> None:
    path = tmp_path / "a.npz"
    save(path, t=np.arange(N) / 100, fs=100.0, note=np.array("hello"), nothing=np.empty((0, 3)), **ARRAYS)
    found = in_place(path, piece)
    assert_same(found, read(path))
    assert all(batches.is_stored(one.data) for one in found.channels)
    names = ["counts", "records.raw"]
    assert_same(in_place(path, piece, topics=names), read(path, topics=names))


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_a_damaged_npz_file_is_refused_in_place_as_it_is_whole(tmp_path: Path, save: Callable[..., None]) -> None:
    path = tmp_path / "a.npz"
    save(path, gyro=RNG.normal(size=(4000, 3)))
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    for found in (outcome(lambda: read(path, sample_rate=1.0)), outcome(lambda: in_place(path, 1000, sample_rate=1.0))):
        assert isinstance(found, tuple)
        assert found[1][0].code == "damaged_file"
    path.write_bytes(content[: len(content) // 2])
    assert_judged_alike(path, 1000, sample_rate=1.0)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("notes.txt", "hello")
    assert_judged_alike(path, 1000)


def test_npy_files_that_are_refused_whole_are_refused_in_place(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    np.save(path, np.array([{}, {}], dtype=object), allow_pickle=True)
    assert_judged_alike(path, 100, sample_rate=1.0)
    np.save(path, GYRO)
    path.write_bytes(path.read_bytes()[:-9])
    assert_judged_alike(path, 100, sample_rate=1.0)
    with pytest.warns(UserWarning, match="format 3.0"):
        np.save(path, np.zeros(50, dtype=[("\u03c9", "f8")]))
    assert_judged_alike(path, 100, sample_rate=1.0)


@pytest.mark.parametrize("packing", [{}, {"chunks": True, "compression": "gzip"}], ids=["plain", "packed"])
@pytest.mark.parametrize("piece", [1000, 10**6])
def test_a_long_hdf5_file(tmp_path: Path, packing: dict[str, Any], piece: int) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("t", data=np.arange(N) / 100, **packing).attrs["units"] = "s"
        for name, values in ARRAYS.items():
            file.create_dataset(f"imu/{name}", data=values, **packing)
        file["fs"], file["note"], file["nothing"] = 100.0, "hello", np.empty((0, 3))
        file.create_dataset("empty", dtype="f8", shape=None)
    found = in_place(path, piece)
    assert_same(found, read(path))
    assert all(batches.is_stored(one.data) for one in found.channels)
    names = ["imu.records.raw", "imu.counts"]
    assert_same(in_place(path, piece, topics=names), read(path, topics=names))


def test_a_damaged_hdf5_file_is_refused_in_place_as_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("gyro", data=RNG.normal(size=(4000, 3)), chunks=(1000, 3), compression="gzip")
    content = bytearray(path.read_bytes())
    content[len(content) // 2 : len(content) // 2 + 500] = bytes(500)
    path.write_bytes(content)
    assert_judged_alike(path, 10_000, sample_rate=1.0)
    path.write_bytes(content[: len(content) // 2])
    assert_judged_alike(path, 10_000, sample_rate=1.0)


def test_values_in_another_file_are_refused_in_place(tmp_path: Path) -> None:
    path, other = tmp_path / "a.h5", tmp_path / "other.bin"
    other.write_bytes(bytes(800))
    with h5py.File(path, "w") as file:
        file.create_dataset("gyro_x", (100,), "f8", external=[(str(other), 0, 800)])
    assert_judged_alike(path, 1000, sample_rate=1.0)


def test_a_csv_is_written_a_batch_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    long, alone = tmp_path / "long.csv", tmp_path / "alone.csv"
    long.write_bytes(text(cells=lambda i: (f"{i / 100}", "" if i == 255 else f"{i % 3}.0", f"{i % 7}.25")))
    alone.write_bytes(text(head="gyro_x [deg/s]\n", cells=lambda i: ("nan" if i == 7 else f"{i % 7}.5",)))
    instants = tmp_path / "instants.csv"
    instants.write_bytes(text(cells=lambda i: (f"2024-05-01T10:{i // 60:02d}:{i % 60:02d}.5Z", "1.5", "3")))
    for path in (long, alone, instants):
        recording = read(path) if path != alone else read(path, sample_rate=100.0)
        write(tmp_path / "whole.csv", recording)
        for size in (1, 100, 259):
            monkeypatch.setattr(csv, "GROUP", size)
            write(tmp_path / "batches.csv", recording)
            assert (tmp_path / "batches.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
        monkeypatch.undo()


def held(path: Path, piece: int, **options: Any) -> Recording:
    """Read a text in memory in pieces, its layout told by few lines."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pieces, "SHORT", 0)
        patch.setattr(pieces, "PIECE", piece)
        patch.setattr(pieces, "HEAD", 4400)
        return read(path, **options)


@pytest.mark.parametrize("name", REGULAR)
def test_a_regular_text_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(REGULAR[name])
    options = OPTIONS.get(name, {})
    expected = read(path, **options)

    def refused(*_: object) -> None:
        raise AssertionError("read whole")

    monkeypatch.setattr(pieces, "parse", refused)
    least = len(REGULAR[name]) * 9 // 10
    for piece in (least, least - 1, 10**6):
        assert_same(held(path, piece, **options), expected)


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("piece", [4600, 10**6])
def test_any_other_text_in_memory(tmp_path: Path, name: str, piece: int) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(ODD[name])
    expected = outcome(lambda: read(path, sample_rate=100.0))
    found = outcome(lambda: held(path, piece, sample_rate=100.0))
    if isinstance(expected, Recording) and isinstance(found, Recording):
        assert_same(found, expected)
    else:
        assert found == expected


def test_lines_above_the_table_that_were_stated_are_skipped_in_a_long_text_too(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"1,2,3\n4,5,6\n" + text())
    assert_same(in_place(path, 4000, skip=2), read(path, skip=2))


def test_a_last_piece_of_one_row_that_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    content = text(last="\n1.3,0.2")
    path.write_bytes(content)
    expected = read(path)
    assert "row_cut_off" in [one.code for one in expected.remarks]
    assert_same(in_place(path, len(content) - len("1.3,0.2")), expected)


@pytest.mark.parametrize("last", ["7.96,0.12", "7.96,0."])
def test_a_last_number_that_lost_its_digits_in_pieces(tmp_path: Path, last: str) -> None:
    path = tmp_path / "a.csv"
    content = "t [s],gyro_x [deg/s]\n" + "".join(f"{i / 100:.2f},{i / 7:.6f}\n" for i in range(796)) + last
    path.write_text(content)
    expected = read(path)
    assert "row_cut_off" in [one.code for one in expected.remarks]
    assert len(expected) == 796
    assert_same(in_place(path, 4000), expected)


@pytest.mark.usefixtures("pieces_only")
def test_rows_that_become_shorter_are_more_than_the_first_piece_makes_likely(tmp_path: Path) -> None:
    lines = [f"{i},0.{'5' * (20 if i < ROWS else 1)}" for i in range(20 * ROWS)]
    path = tmp_path / "a.csv"
    path.write_text("t [ms],gyro_x [deg/s]\n" + "\n".join(lines) + "\n")
    expected = read(path)
    found = in_place(path, 9000)
    assert_same(found, expected)
    assert batches.is_stored(found.channels[0].data)
