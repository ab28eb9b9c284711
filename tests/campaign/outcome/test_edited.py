"""Results edited after the run: refused wherever they are read, by name and in plain words."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.compare.compare import compare
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.campaign.outcome.results_file import edited_since, find_results, previous
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError
from inertialcal.core.schema.checksum import checksum, is_unchanged

PLACED = ("provenance.json", "report.html", "SHA256SUMS")  # say when, or where the campaign lies


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("edited") / "demo"
    copy_example("npsat2011", folder)
    run(folder)
    return folder


@pytest.fixture
def folder(ran: Path, tmp_path: Path) -> Path:
    shutil.copytree(ran, tmp_path / "demo")
    return tmp_path / "demo"


def edited(folder: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    path = folder / "out/results.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def refused(call: Callable[[], object]) -> tuple[str, str, str]:
    with pytest.raises(DataError) as caught:
        call()
    problem = caught.value.problems[0]
    return problem.code, problem.where, problem.why


def values(content: dict[str, Any]) -> None:
    content["results"][0]["value"] = 0.0


def test_every_member_is_under_the_checksum(folder: Path) -> None:
    content = json.loads((folder / "out/results.json").read_text(encoding="utf-8"))
    assert is_unchanged(content)
    assert content["checksum"] == checksum({name: part for name, part in content.items() if name != "checksum"})
    for name in content:
        assert not is_unchanged({key: part for key, part in content.items() if key != name}), name
        assert not is_unchanged(content | {name: "another"}), name
    assert not is_unchanged(content | {"more": 1})
    assert not is_unchanged(json.loads('{"a": 1e400, "checksum": "sha256:0"}'))


def test_results_edited_by_hand_are_refused(folder: Path, ran: Path) -> None:
    path = edited(folder, values)
    for call in (
        lambda: find_results(path),
        lambda: find_results(folder / "out"),
        lambda: find_results(folder, of_campaign=True),
        lambda: compare(path, ran),
        lambda: compare(ran, folder),
    ):
        code, where, why = refused(call)
        assert (code, where) == ("checksum", str(path))
        assert "edited by hand" in why
    assert previous(folder) is None


def test_results_laid_out_anew_are_read(folder: Path) -> None:
    path = folder / "out/results.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    turned = dict(sorted(content.items(), reverse=True))
    path.write_text(json.dumps(turned, indent=4, ensure_ascii=True), encoding="utf-8")
    found = find_results(path)
    assert found is not None
    assert {name: part for name, part in found.content.items() if name != "curves"} == content
    assert previous(folder) == content


@pytest.mark.parametrize("wrong", [[1.0], {"x": 1}, True])
@pytest.mark.parametrize("key", ["value", "u", "axis", "condition", "interval", "status"])
def test_what_has_not_the_form_of_results_is_refused(folder: Path, key: str, wrong: object) -> None:
    def change(content: dict[str, Any]) -> None:
        content["results"][0][key] = wrong
        content["checksum"] = checksum({name: part for name, part in content.items() if name != "checksum"})

    path = edited(folder, change)
    assert refused(lambda: find_results(path))[:2] == ("schema", str(path))
    assert previous(folder) is None


def test_curves_of_another_run_are_refused(folder: Path, ran: Path) -> None:
    curves = folder / "out/curves.parquet"
    curves.write_bytes(curves.read_bytes() + b"\n")
    for call in (lambda: find_results(folder / "out"), lambda: compare(ran, folder)):
        code, where, why = refused(call)
        assert (code, where) == ("checksum", str(curves))
        assert "edited by hand" in why
    curves.unlink()
    found = find_results(folder / "out")
    assert found is not None
    assert "curves" not in found.content


def test_the_same_inputs_give_the_same_bytes(folder: Path) -> None:
    first = {path.name: path.read_bytes() for path in (folder / "out").iterdir() if path.name not in PLACED}
    run(folder)
    assert {name: (folder / "out" / name).read_bytes() for name in first} == first


def test_a_run_over_edited_results_lists_no_changes(folder: Path) -> None:
    edited(folder, values)
    assert run(folder, write=False).changed == []


def test_show_of_a_folder_names_what_was_edited_in_it(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert edited_since(folder) == ()
    for name in ("report.html", "verdicts.csv"):
        path = folder / "out" / name
        path.write_bytes(path.read_bytes() + b" ")
    for place in (folder, folder / "out"):
        with pytest.raises(SystemExit) as left:
            main(["show", str(place), "--json"])
        content = json.loads(capsys.readouterr().out)
        remarks = [one for one in content["remarks"] if one["code"] == "edited_by_hand"]
        assert left.value.code == 0
        assert [Path(one["where"]).name for one in remarks] == ["report.html", "verdicts.csv"]
        with pytest.raises(SystemExit):
            main(["show", str(place)])
        said = capsys.readouterr().out
        assert sum(line.startswith("warning: ") for line in said.split("\n")) >= 2
        assert " ".join(said.split()).count("edited by hand") >= 2
    (folder / "out/verdicts.csv").unlink()
    assert [Path(one.where).name for one in edited_since(folder)] == ["report.html"]
    (folder / "out/SHA256SUMS").unlink()
    assert edited_since(folder) == ()
