"""Bytes of a file: hashes, gzip, limits, and files that are none."""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path

import pytest

from inertialcal.core.errors import DataError
from inertialcal.files import source
from inertialcal.files.source import check_size, load


def refused(path: Path | str) -> tuple[str, str]:
    with pytest.raises(DataError) as caught:
        load(path)
    (problem,) = caught.value.problems
    assert problem.where == str(path)
    return problem.what, problem.code


def test_the_hash_is_that_of_the_file_as_it_lies_there(tmp_path: Path) -> None:
    packed = gzip.compress(b"1,2\n3,4\n")
    path = tmp_path / "a.csv.gz"
    path.write_bytes(packed)
    loaded = load(path)
    assert (loaded.data, loaded.packed) == (b"1,2\n3,4\n", True)
    assert loaded.sha256 == hashlib.sha256(packed).hexdigest()


def test_gzip_of_several_members(tmp_path: Path) -> None:
    path = tmp_path / "a.gz"
    path.write_bytes(gzip.compress(b"1\n") + gzip.compress(b"2\n"))
    assert load(path).data == b"1\n2\n"


def test_no_such_file(tmp_path: Path) -> None:
    assert refused(tmp_path / "none.csv") == ("no such file", "missing_file")


def test_a_folder(tmp_path: Path) -> None:
    assert refused(tmp_path) == ("this is a folder, not a file", "missing_file")


def test_a_device() -> None:
    assert refused("/dev/zero") == ("not a regular file", "missing_file")


def test_a_name_that_cannot_be() -> None:
    what, code = refused("a\0b.csv")
    assert (what.startswith("cannot be read"), code) == (True, "missing_file")


@pytest.mark.parametrize("content", [b"", gzip.compress(b"")], ids=["nothing", "packed"])
def test_an_empty_file(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    assert refused(path) == ("the file is empty", "empty_file")


@pytest.mark.parametrize("damage", [lambda b: b[:-20], lambda b: b[:50] + bytes(40) + b[90:], lambda b: b[:2]])
def test_damaged_gzip(tmp_path: Path, damage: object) -> None:
    path = tmp_path / "a.csv.gz"
    content = gzip.compress("\n".join(str(i * i) for i in range(2000)).encode())
    path.write_bytes(damage(content))  # type: ignore[operator]
    what, code = refused(path)
    assert (what.startswith("damaged gzip file"), code) == (True, "damaged_file")


def test_a_file_beyond_the_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"1\n" * 600)
    monkeypatch.setattr(source, "LARGEST", 1000)
    what, code = refused(path)
    assert (what.startswith("holds 1.12e-06 GiB or more"), code) == (True, "too_large")
    path.write_bytes(gzip.compress(b"1\n" * 600))
    assert refused(path)[1] == "too_large"


def test_a_gzip_bomb_stops_early(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(bytes(10**7)))
    monkeypatch.setattr(source, "RATIO_FROM", 10**6)
    what, code = refused(path)
    assert (what, code) == ("unpacks to more than 400 times its size", "too_large")


def test_a_recording_that_packs_well_is_no_bomb() -> None:
    check_size("a.gz", 2**30, 2**24)
