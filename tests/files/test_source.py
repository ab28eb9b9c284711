"""Bytes of a file: hashes, gzip, limits, and files that are none."""

from __future__ import annotations

import copy
import gzip
import hashlib
import os
import random
import socket
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from inertialcal.core import batches
from inertialcal.core.errors import DataError
from inertialcal.core.recording import Digest, Source
from inertialcal.files import read
from inertialcal.files.budget import max_memory
from inertialcal.files.source import FileBytes, Loaded, load, settled


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


def test_a_gzip_bomb_stops_early(tmp_path: Path) -> None:
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(bytes(10**7)))
    with max_memory("260MiB"):
        what, code = refused(path)
    assert (what, code) == ("needs more than 266 MiB of memory, the ceiling is 260 MiB", "too_large")
    assert len(load(path).data) == 10**7


def test_members_without_number(tmp_path: Path) -> None:
    path = tmp_path / "a.csv.gz"
    path.write_bytes(gzip.compress(b"1\n") * 200_001)
    assert refused(path) == ("200,001 gzip members, the ceiling is 200,000", "too_many")


@pytest.mark.parametrize("data", [b"1\n", b"ab" * 3_000_000, random.Random(1).randbytes(300_000), b"x" * 2**22])
def test_gzip_is_unpacked_as_by_gzip(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "a.gz"
    for packed in (gzip.compress(data), 3 * gzip.compress(data), gzip.compress(data) + bytes(5000)):
        path.write_bytes(packed)
        assert load(path).data == gzip.decompress(packed)


def test_a_pipe_a_socket_a_device_are_no_files(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with socket.socket(socket.AF_UNIX) as end:
        end.bind(str(tmp_path / "socket"))
        for path, what in ((tmp_path / "pipe", "pipe"), (tmp_path / "socket", "socket"), ("/dev/zero", "device")):
            assert refused(path) == (f"not a regular file but a {what}", "missing_file")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    assert refused(tmp_path / "loop")[1] == "missing_file"


def test_a_file_that_says_it_is_empty_is(tmp_path: Path) -> None:
    if Path("/proc/self/maps").exists():
        assert refused("/proc/self/maps") == ("the file is empty", "empty_file")


def test_a_long_file_that_changes_while_it_is_read_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"1,2\n")
    monkeypatch.setattr(batches, "HELD", 0)
    loaded = load(path, in_place=True)
    assert settled(loaded) == (hashlib.sha256(b"1,2\n").hexdigest(), ())
    path.write_bytes(b"1,2\n3,4\n")
    with pytest.raises(DataError, match="changed while it was read") as caught:
        settled(loaded)
    assert [one.code for one in caught.value.problems] == ["input_changed"]
    digest, (remark,) = settled(loaded, may_grow=True)
    assert (digest, remark.code) == (hashlib.sha256(b"1,2\n").hexdigest(), "still_written")
    for content in (b"1,3\n3,4\n", b"1,2", b"1,3\n"):  # other numbers, a shorter file
        path.write_bytes(content)
        with pytest.raises(DataError, match="changed while it was read"):
            settled(loaded, may_grow=True)


def test_a_hash_that_nobody_waits_for_is_that_of_what_was_read(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    content = b"time_s,x [V]\n" + b"".join(b"%d,%d.5\n" % (i, i % 7) for i in range(50_000))
    path.write_bytes(content)
    found = read(path)
    path.write_bytes(content.replace(b".5", b".7"))
    assert found.source.sha256 == hashlib.sha256(content).hexdigest()
    assert found.source == copy.deepcopy(found.source)


def in_place(path: Path, monkeypatch: pytest.MonkeyPatch) -> Loaded:
    """Return a Parquet file that stays where it is: only what it begins with matters here."""
    path.write_bytes(b"PAR1" + bytes(1000))
    monkeypatch.setattr(batches, "HELD", 2**7)
    return load(path, in_place=True)


def test_a_file_in_place_that_changes_before_it_is_hashed_has_no_hash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.parquet"
    loaded = in_place(path, monkeypatch)
    with monkeypatch.context() as patch:
        patch.setattr(Digest, "begin", lambda self: None)  # a thread that the machine has no time for
        hashed, remarks = settled(loaded)
    assert (type(hashed), remarks) == (Digest, ())
    source = Source(str(path), hashed)
    path.write_bytes(b"PAR1" + bytes(999) + b"1")
    for _ in range(2):  # whoever asks for it is told
        with pytest.raises(DataError, match="changed before it was hashed") as caught:
            print(source.sha256)
        assert [(one.where, one.code) for one in caught.value.problems] == [(str(path), "input_changed")]


def test_a_file_in_place_that_changed_while_it_was_read_is_refused_whoever_hashes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.parquet"
    loaded = in_place(path, monkeypatch)
    path.write_bytes(b"PAR1" + bytes(999) + b"1")
    with pytest.raises(DataError, match="changed while it was read"):
        settled(loaded)
    assert settled(in_place(path, monkeypatch))[1] == ()


def test_a_log_that_is_still_written_is_read_to_its_last_whole_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, rows = tmp_path / "a.csv", 3000
    path.write_text("time_s,x [V]\n" + "".join(f"{i / 100:.2f},{i % 7}.125\n" for i in range(rows)) + "30.00,1")
    monkeypatch.setattr(batches, "HELD", 2**12)
    first = FileBytes.__init__

    def opened_and_written_on(self: FileBytes, name: Path, most: int | None = None) -> None:
        first(self, name, most)
        with path.open("a") as log:
            log.write(".125\n30.01,2.125\n")

    monkeypatch.setattr(FileBytes, "__init__", opened_and_written_on)
    found = read(path)
    assert {"row_cut_off", "still_written"} <= {one.code for one in found.remarks}
    np.testing.assert_array_equal(found.channel("x [V]").data, np.arange(rows) % 7 + 0.125)


@given(content=st.binary(max_size=60), part=st.sampled_from([b"a", b"ab", b"PK\x01\x02"]), chunk=st.integers(1, 9))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_bytes_in_a_file_are_counted_over_the_ends_of_blocks(
    content: bytes, part: bytes, chunk: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = content.replace(b"\x00", part)
    (tmp_path / "any.bin").write_bytes(held)
    monkeypatch.setattr("inertialcal.files.source.CHUNK", chunk)
    assert FileBytes(tmp_path / "any.bin").count(part) == held.count(part)
