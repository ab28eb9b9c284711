"""Files that would fill the memory or take minutes: refused within seconds, below 1 GiB and three times the file."""

from __future__ import annotations

import gzip
import io
import subprocess
import sys
import time
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

import inertialcal as ic
from inertialcal.cli.commands import OF_ARCHIVE, READ_NOTHING, OfArchive, Planners, Root
from inertialcal.core.errors import DataError, PlanError, UsageError
from inertialcal.files.budget import FREE, PER_BYTE, ceiling, parse_size
from inertialcal.files.models.yaml_text import parse_yaml
from typed_commands import call

T = np.arange(64) * 0.01
SECONDS = 60  # of a loaded machine; alone each takes one or two


def never_written(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("gyro_x", (120_000_000,), "f8")


def packed_zeros(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("gyro_x", (500_000_000,), "f8", chunks=(1_000_000,), compression="gzip")


def chunk_larger_than_its_values(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("gyro_x", (64,), "f8", chunks=(400_000_000,), maxshape=(None,), compression="gzip")
        file["t"] = T


def stream_larger_than_its_chunk(path: Path) -> None:
    with h5py.File(path, "w") as file:
        dataset = file.create_dataset("gyro_x", (1000,), "f8", chunks=(1000,), compression="gzip")
        packer = zlib.compressobj()
        start = packer.compress(b"") + packer.flush(zlib.Z_FULL_FLUSH)
        block = packer.compress(bytes(2**26)) + packer.flush(zlib.Z_FULL_FLUSH)  # stands for itself: can be repeated
        dataset.id.write_direct_chunk((0,), start + 24 * block + packer.flush())


def one_text_often(path: Path) -> None:
    label = pa.DictionaryArray.from_arrays(pa.array(np.zeros(20_000, np.int32)), pa.array(["x" * 400_000 + " "]))
    parquet.write_table(pa.table({"t": np.arange(20_000) * 0.01, "label": label}), path, compression="zstd")


def packed_numbers(path: Path) -> None:
    parquet.write_table(pa.table({"x": pa.nulls(300_000_000)}), path)


def archive_of_zeros(path: Path) -> None:
    head = io.BytesIO()
    shape = {"descr": "<f8", "fortran_order": False, "shape": (100_000_000,)}
    np.lib.format.write_array_header_1_0(head, shape)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("x.npy", "w") as member:
        member.write(head.getvalue())
        for _ in range(100):
            member.write(bytes(8_000_000))


def packed_lines(path: Path) -> None:
    path.write_bytes(20 * gzip.compress(b"1,2\n" * 10_000_000))


def one_line(path: Path) -> None:
    path.write_bytes(b"," * 50_000_000)


BOMBS = (
    ("never.h5", never_written), ("zeros.h5", packed_zeros), ("chunk.h5", chunk_larger_than_its_values),
    ("stream.h5", stream_larger_than_its_chunk), ("label.parquet", one_text_often), ("nulls.parquet", packed_numbers),
    ("zeros.npz", archive_of_zeros), ("lines.csv.gz", packed_lines), ("commas.csv", one_line),
)  # fmt: skip
QUICK = {"never.h5", "label.parquet", "zeros.npz", "lines.csv.gz"}  # in the default suite: one a format


# A process begins with the peak of the one that starts it, and that of the tests is large.
STARTER = """
import os, sys
started = os.posix_spawn(sys.executable, [sys.executable, "-m", "inertialcal.cli", *sys.argv[1:]], os.environ)
_, status, usage = os.wait4(started, 0)
print(os.waitstatus_to_exitcode(status), usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024))
"""


def typed(*words: str) -> tuple[int, int, float, str]:
    """Exit status, peak of memory [byte], time [s] and errors of a command in a process of its own."""
    start = time.monotonic()
    words = (sys.executable, "-S", "-c", STARTER, *words, "--quiet")
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    status, peak = map(int, done.stdout.split()[-2:])
    return status, peak, time.monotonic() - start, done.stderr


@pytest.mark.parametrize(
    ("name", "write"),
    [pytest.param(*one, id=one[0], marks=[] if one[0] in QUICK else pytest.mark.slow) for one in BOMBS],
)
def test_a_file_that_would_fill_the_memory(tmp_path: Path, name: str, write: Callable[[Path], None]) -> None:
    path = tmp_path / name
    write(path)
    status, peak, seconds, said = typed("info", str(path))
    assert status == 3, said
    assert peak < FREE + PER_BYTE * path.stat().st_size
    assert seconds < SECONDS


ROWS, MOST = 6_000_000, 600 * 2**20  # samples of a long record, bytes that a command on it may take; it holds 144 MB


def long_columns() -> dict[str, Any]:
    """Return time, a gyro and its temperature, which goes up and down."""
    rng, at = np.random.default_rng(1), np.arange(ROWS)
    warm = np.interp(at, [0, ROWS // 20, ROWS // 2, ROWS], [20.0, 20.0, 60.0, 20.0]) + rng.normal(0.0, 0.01, ROWS)
    gyro = 1e-4 * warm + rng.normal(0.0, 0.02, ROWS)
    return {"t [s]": at / 200.0, "gyro_x [deg/s]": gyro, "temperature [degC]": warm}


def long_parquet(path: Path) -> None:
    parquet.write_table(pa.table(long_columns()), path)


def long_npz(path: Path) -> None:
    np.savez(path, **long_columns())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("word", "name", "write"),
    [("thermal", "a.parquet", long_parquet), ("info", "a.npz", long_npz)],
)
def test_a_long_record_is_worked_on_by_batches(
    tmp_path: Path, word: str, name: str, write: Callable[[Path], None]
) -> None:
    write(tmp_path / name)
    status, peak, _, said = typed(word, str(tmp_path / name))
    assert status == 0, said
    assert peak < MOST


ARRAYS: Any = {f"a{i}": T for i in range(10_001)}
MANY: dict[str, Callable[[Path], object]] = {
    "a.npz": lambda path: np.savez(path, **ARRAYS),
    "a.csv": lambda path: path.write_text("\n".join(3 * [",".join(map(str, range(10_001)))])),
    "a.parquet": lambda path: parquet.write_table(pa.table({f"c{i}": [1.0, 2.0] for i in range(10_001)}), path),
}


@pytest.mark.parametrize("name", MANY)
def test_more_parts_than_seconds_allow(tmp_path: Path, name: str) -> None:
    MANY[name](tmp_path / name)
    with pytest.raises(DataError, match=r"10,001 .*, the ceiling is 10,000") as caught:
        ic.read(tmp_path / name)
    assert caught.value.problems[0].code == "too_many"


def test_groups_that_hold_each_other(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        groups = [file.create_group(f"g{i}") for i in range(20)]
        for group in groups:
            for i, other in enumerate(groups):
                group[f"to{i}"] = other
        file["gyro_x"] = file["t"] = T
    assert ic.read(tmp_path / "a.h5").names == ("gyro_x",)


def _external(file: h5py.File, other: Path) -> None:
    file.create_dataset("gyro_x", (64,), "f8", external=[(str(other), 0, 512)])


def _virtual(file: h5py.File, other: Path) -> None:
    layout = h5py.VirtualLayout((64,), "f8")
    layout[:] = h5py.VirtualSource(str(other), "x", (64,))
    file.create_virtual_dataset("gyro_x", layout)


def _link(file: h5py.File, other: Path) -> None:
    file["gyro_x"] = h5py.ExternalLink(str(other), "/x")


@pytest.mark.parametrize("refer", [_external, _virtual, _link])
def test_values_in_other_files_are_refused_by_name(
    tmp_path: Path, refer: Callable[[h5py.File, Path], None], capsys: pytest.CaptureFixture[str]
) -> None:
    path, other, out = tmp_path / "a.h5", tmp_path / "other.h5", tmp_path / "out.csv"
    with h5py.File(other, "w") as file:
        file["x"] = T
    with h5py.File(path, "w") as file:
        file["t"] = T
        refer(file, other)
    with pytest.raises(DataError, match=r"'gyro_x' is .*other\.h5: its values are not in this file") as caught:
        ic.read(path)
    assert caught.value.problems[0].code == "external_storage"
    assert call(capsys, "convert", str(path), str(out))[0] == 3
    assert not out.exists()


def test_a_soft_link_is_left_out_with_a_remark(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["x"] = T**2
        file["soft"] = h5py.SoftLink("/x")
    recording = ic.read(tmp_path / "a.h5")
    assert (recording.names, recording.remarks[0].code) == (("x",), "variables_left_out")


def test_a_filter_that_is_not_there(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        packing = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        packing.set_chunk((100,))
        packing.set_filter(32015, h5py.h5z.FLAG_OPTIONAL, ())
        space = h5py.h5s.create_simple((1000,))
        h5py.h5d.create(file.id, b"x", h5py.h5t.IEEE_F64LE, space, packing).write_direct_chunk((0,), bytes(800))
    with pytest.raises(DataError, match="'x' is packed by filter 32015") as caught:
        ic.read(tmp_path / "a.h5")
    assert caught.value.problems[0].code == "missing_filter"


def test_a_library_that_crashes_is_a_damaged_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    never = tmp_path / "a.h5"
    with h5py.File(never, "w") as file:
        file["x"] = T
    for name, body in (("crash", "import os; os.abort()"), ("loop", "while True: pass")):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "h5py.py").write_text(body if name == "crash" else f"def __getattr__(name):\n    {body}\n")
        monkeypatch.syspath_prepend(str(folder))
        with pytest.raises(DataError, match=r"it stops the HDF5 library|it comes to no end") as caught:
            ic.read(never)
        assert caught.value.problems[0].code == "damaged_file"


@pytest.mark.parametrize(
    ("text", "size"), [("4GiB", 2**32), ("500 MB", 500_000_000), ("1.5g", 3 * 2**29), ("1000", 1000)]
)
def test_sizes(text: str, size: int) -> None:
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "lots", "-1GB", "4 parsecs", "0", "1e400", "9" * 400])
def test_what_is_no_size(text: str) -> None:
    with pytest.raises(UsageError, match="not a size"):
        parse_size(text)


def test_three_ways_to_set_the_ceiling(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("gyro_x", (20_000_000,), "u1", fillvalue=7)
    assert ceiling(1000) == 2**30 + 3000
    with pytest.raises(DataError, match=r"needs 1\.\d* GiB of memory, the ceiling is 1 GiB") as caught:
        ic.read(path)
    assert caught.value.problems[0].do == "If the file is right, add --max-memory 2GiB"
    with ic.max_memory("3 GiB"):
        assert len(ic.read(path)) == 20_000_000
    status, _, said = call(capsys, "convert", str(path), str(tmp_path / "a.npz"), "--max-memory", "300MB")
    assert (status, "the ceiling is 286 MiB" in said) == (3, True)
    assert call(capsys, "convert", str(path), str(tmp_path / "a.npz"), "--max-memory", "3GiB")[0] == 0
    assert ceiling(0) == 2**30  # the option ends with its command
    monkeypatch.setenv("INERTIALCAL_MAX_MEMORY", "3GiB")
    assert len(ic.read(path)) == 20_000_000


def test_every_command_that_reads_files_has_the_option() -> None:
    root, plans = Root(), Planners()
    commands = {word: root.get_command(None, word) for word in root.names() if word not in ("plan", "archive")}
    commands |= {f"archive {word}": OfArchive(name="archive").get_command(None, word) for word in OF_ARCHIVE}
    commands |= {f"plan {word}": plans.get_command(None, word) for word in plans.names()}
    without = [
        word for word, one in commands.items()
        if one is not None and not any("--max-memory" in parameter.opts for parameter in one.params)
    ]  # fmt: skip
    assert without == list(READ_NOTHING)


def test_a_campaign_that_would_take_minutes(tmp_path: Path) -> None:
    path = tmp_path / "campaign.toml"
    path.write_text(".".join(400_000 * ["a"]) + " = 1\n")
    with pytest.raises(PlanError, match="a key of more than 64 parts"):
        ic.check(tmp_path)
    path.write_text("".join(f"[t{i}]\n" for i in range(5000)))
    with pytest.raises(PlanError) as caught:
        ic.check(tmp_path)
    assert len(caught.value.problems) == 101
    assert "more problems" in caught.value.problems[-1].what


def test_documents_that_swell(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text("[" + ",".join(4_000_000 * ['{"":{}}']) + "]")
    with pytest.raises(DataError, match="bytes of structured text") as caught:
        ic.load_model(tmp_path / "a.json")
    assert caught.value.problems[0].code == "too_large"
    with pytest.raises(DataError, match="characters of YAML, the ceiling is 100,000"):
        parse_yaml("imu0:\n" + 100_000 * " a: 1\n")
