"""What a run keeps: a result is taken again where code, plan and inputs are the same to the last byte, else made anew.

The reference is a run of the same campaign that has nothing kept: it must write the same bytes.
"""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine import cache, processes, reductions
from inertialcal.campaign.engine.run import Outcome, run
from inertialcal.core.errors import DataError
from inertialcal.files import source

Write = Callable[..., Path]
KEPT = "out-cache"
OWN = {"provenance.json", "SHA256SUMS"}  # the time of the run, and the hash of the file that has it
SECOND = """
[[tests]]
id = "second"
procedure = "rate_table"
recordings = ["one"]
use = "report_only"
plan = { axis = "x" }
[[requirements]]
"""
STILL = """\
schema = 2
[campaign]
id = "still"
[item]
serial = "7"
[standards.sensor]
scale_factor = { u = "0.2 %", certificate = "data sheet" }
[sensors.suite]
kind = "gyro"
axes = ["x"]
unit = "deg/s"
"""
RECORDING = """\
[recordings.r{n}]
sensor = "suite"
file = "r{n}.csv"
[recordings.r{n}.channels]
x = {{ column = "x", unit = "deg/s" }}
[[tests]]
id = "t{n}"
procedure = "static_noise"
recordings = ["r{n}"]
[[tests]]
id = "again{n}"
procedure = "static_noise"
recordings = ["r{n}"]
use = "report_only"
"""


@pytest.fixture
def reduced(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the tests that are reduced, as they are."""
    found: list[str] = []
    plain = reductions.reduce

    def reduce(campaign: Any, number: int, *rest: Any) -> Any:
        found.append(campaign.file.tests[number].id)
        return plain(campaign, number, *rest)

    monkeypatch.setattr(reductions, "reduce", reduce)
    return found


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often each file is read whole, by name."""
    found: Counter[str] = Counter()
    plain = source.read_bytes

    def read_bytes(path: str | Path, most: int | None = None) -> bytes:
        found[Path(path).name] += most is None
        return plain(path, most)

    monkeypatch.setattr(source, "read_bytes", read_bytes)
    return found


def written(folder: Path) -> dict[str, bytes]:
    return {one.name: one.read_bytes() for one in (folder / "out").iterdir() if one.name not in OWN}


def fresh(folder: Path, into: Path) -> dict[str, bytes]:
    """Return what a run writes that has nothing kept, under the same name of the folder."""
    into.mkdir()
    for one in folder.iterdir():
        if one.is_file():
            shutil.copy2(one, into)
    here = Path.cwd()
    os.chdir(into)
    try:
        run(".")
    finally:
        os.chdir(here)
    return written(into)


def run_here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Outcome:
    monkeypatch.chdir(folder)
    return run(".")


def test_unchanged_nothing_is_read_reduced_or_written(campaign: Write, reduced: list[str], read: Counter[str]) -> None:
    folder = campaign()
    first = run(folder)
    assert reduced == ["first"]
    before = {one.name: (one.stat().st_ino, one.stat().st_mtime_ns) for one in (folder / "out").iterdir()}
    read.clear()
    second = run(folder)
    assert reduced == ["first"]
    assert not read["one.csv"]
    assert {one.name: (one.stat().st_ino, one.stat().st_mtime_ns) for one in (folder / "out").iterdir()} == before
    assert second.results == first.results
    assert list(second.results) == list(first.results)
    assert (second.verdict, second.inputs, second.exit_status) == (first.verdict, first.inputs, first.exit_status)
    assert second.changed == []
    assert str(second) == str(first)
    assert second.campaign.sha256 == first.campaign.sha256


def test_a_changed_requirement_is_judged_without_reducing(
    campaign: Write, reduced: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = campaign()
    first = run_here(folder, monkeypatch)
    changed = campaign(('limit = "5 %"', 'limit = "0.001 %"'))
    second = run_here(changed, monkeypatch)
    assert reduced == ["first"]
    assert first.verdict != second.verdict
    assert second.changed
    assert written(folder) == fresh(folder, tmp_path_factory.mktemp("fresh") / "copy")


def test_plan_inputs_and_code_each_ask_for_a_new_reduction(
    campaign: Write, reduced: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = campaign()
    run_here(folder, monkeypatch)
    campaign(("zero_reference = true", "zero_reference = false"))
    run_here(folder, monkeypatch)
    assert reduced == ["first"] * 2

    table = folder / "one.csv"
    campaign()
    run_here(folder, monkeypatch)
    about, text = table.stat(), table.read_text(encoding="utf-8")
    table.write_text(text.replace("0.004", "0.005"), encoding="utf-8")
    os.utime(table, ns=(about.st_atime_ns, about.st_mtime_ns))
    assert table.stat().st_size == about.st_size  # neither size nor time tell of it
    run_here(folder, monkeypatch)
    assert reduced == ["first"] * 4
    assert written(folder) == fresh(folder, tmp_path_factory.mktemp("fresh") / "copy")

    del reduced[:]
    monkeypatch.setattr(cache, "code_digest", lambda: "another")
    run_here(folder, monkeypatch)
    run_here(folder, monkeypatch)
    assert reduced == ["first"]


def test_the_code_is_all_of_the_package_and_the_versions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "small"
    package.mkdir()
    (package / "__init__.py").write_text("A = 1\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(cache, "packages", lambda: ("small",))

    def look() -> str:
        cache.code_digest.cache_clear()
        return cache.code_digest()

    digests = [look()]
    (package / "__pycache__").mkdir()
    (package / "__pycache__" / "made.pyc").write_bytes(b"1")
    assert look() == digests[0]
    (package / "__init__.py").write_text("A = 2\n", encoding="utf-8")
    digests.append(look())
    (package / "page.html").write_text("<p>", encoding="utf-8")
    digests.append(look())
    (tmp_path / "numpy-99.0.dist-info").mkdir()
    digests.append(look())
    assert len({*digests}) == 4
    cache.code_digest.cache_clear()


@pytest.mark.parametrize("harm", ["flip", "cut", "empty", "another"])
def test_a_damaged_entry_is_noticed_and_made_anew(
    campaign: Write, reduced: list[str], monkeypatch: pytest.MonkeyPatch, harm: str
) -> None:
    folder = campaign()
    run_here(folder, monkeypatch)
    before = written(folder)
    for one in (folder / KEPT).iterdir():
        if one.name.startswith("run-"):
            one.unlink()
        elif one.name.startswith("test-"):
            data = bytearray(one.read_bytes())
            data[len(data) // 2] ^= 1
            other = {"flip": bytes(data), "cut": bytes(data[:-9]), "empty": b"", "another": b"inertialcal cache 1\n"}
            one.write_bytes(other[harm])
    run_here(folder, monkeypatch)
    assert reduced == ["first"] * 2
    assert written(folder) == before
    run_here(folder, monkeypatch)
    assert len(reduced) == 2


def test_what_is_missing_or_edited_in_out_is_written_again(
    campaign: Write, reduced: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = campaign()
    run_here(folder, monkeypatch)
    before = written(folder)
    (folder / "out" / "results.csv").unlink()
    run_here(folder, monkeypatch)
    assert written(folder) == before
    (folder / "out" / "verdicts.csv").write_text("mine", encoding="utf-8")
    noted = run_here(folder, monkeypatch)
    assert [one.code for one in noted.notes] == ["file_moved"]
    (folder / "out" / "note.txt").write_text("mine", encoding="utf-8")
    noted = run_here(folder, monkeypatch)
    assert [one.code for one in noted.notes] == ["file_kept"]
    assert reduced == ["first"]


def test_the_folder_can_go_and_one_of_the_user_is_left_alone(
    campaign: Write, reduced: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = campaign()
    run_here(folder, monkeypatch)
    shutil.rmtree(folder / KEPT)
    (folder / KEPT).mkdir()
    (folder / KEPT / "mine.txt").write_text("mine", encoding="utf-8")
    run_here(folder, monkeypatch)
    assert [one.name for one in (folder / KEPT).iterdir()] == ["mine.txt"]
    assert reduced == ["first"] * 2


def test_entries_that_nobody_takes_go(campaign: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = campaign()
    run_here(folder, monkeypatch)
    first = {one.name for one in (folder / KEPT).iterdir()}
    campaign(("zero_reference = true", "zero_reference = false"))
    run_here(folder, monkeypatch)
    second = {one.name for one in (folder / KEPT).iterdir()}
    assert sum(one.startswith("test-") for one in second) == 1
    assert not {one for one in first & second if one.startswith(("test-", "run-"))}


def test_a_file_is_read_once(campaign: Write, read: Counter[str], reduced: list[str]) -> None:
    run(campaign(("[[requirements]]\n", SECOND)))
    assert reduced == ["first", "second"]
    assert read["one.csv"] == 1


def test_without_writing_nothing_is_kept(campaign: Write) -> None:
    folder = campaign()
    run(folder, write=False)
    assert not (folder / KEPT).exists()


# ---- several processes ----------------------------------------------------------------------------------------------


@pytest.fixture
def still(tmp_path: Path) -> Path:
    """Three recordings of noise, each read by two tests."""
    rng = np.random.default_rng(3)
    text = STILL
    for n in range(3):
        text += RECORDING.format(n=n)
        rows = "\n".join(f"{0.1 * k:.1f},{x:.6f}" for k, x in enumerate(rng.normal(0.0, 0.01, 2000)))
        (tmp_path / f"r{n}.csv").write_text(f"t [s],x\n{rows}\n", encoding="utf-8")
    (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
    return tmp_path


def in_two(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let two processes work on anything."""
    for module in (processes, reductions):
        monkeypatch.setattr(module, "can_fork", lambda: True)
        monkeypatch.setattr(module, "cores", lambda: 2)
    monkeypatch.setattr(reductions, "WORTH_IT", 0)


def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (processes, reductions):
        monkeypatch.setattr(module, "can_fork", lambda: False)


def test_one_process_several_and_the_cache_write_the_same_bytes(
    still: Path, reduced: list[str], read: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[tuple[int, int, str]] = []
    alone(monkeypatch)
    monkeypatch.chdir(still)
    run(".", lambda *words: told.append(words))
    serial = written(still)
    assert sorted(reduced) == sorted([f"t{n}" for n in range(3)] + [f"again{n}" for n in range(3)])
    assert all(read[f"r{n}.csv"] == 1 for n in range(3))
    assert [what for _, _, what in told][:6] == [f"{name}{n}" for n in range(3) for name in ("t", "again")]

    shutil.rmtree(still / KEPT)
    del reduced[:]
    read.clear()
    in_two(monkeypatch)
    run(".")
    assert written(still) == serial
    assert not reduced  # here
    assert not any(read[f"r{n}.csv"] for n in range(3))

    shutil.rmtree(still / "out")
    run(".")
    assert written(still) == serial
    assert not reduced


def test_a_refusal_of_another_process_is_the_same_one(still: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (still / "r1.csv").write_text("t [s],x\n0,1\n1,2\nword,3\n", encoding="utf-8")
    monkeypatch.chdir(still)
    refusals = []
    for way in (alone, in_two):
        way(monkeypatch)
        with pytest.raises(DataError) as error:
            run(".")
        refusals.append(error.value.problems)
        shutil.rmtree(still / KEPT, ignore_errors=True)
    assert refusals[0] == refusals[1]
    assert not (still / "out").exists()


def test_what_a_process_that_was_killed_had_is_done_here(still: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here, plain = os.getpid(), reductions.as_bytes

    def as_bytes(one: reductions.Reduced) -> bytes:
        if os.getpid() != here:
            os._exit(9)
        return plain(one)

    in_two(monkeypatch)
    monkeypatch.setattr(reductions, "as_bytes", as_bytes)
    assert run(still).results["results"]
    assert (still / "out" / "results.json").is_file()
