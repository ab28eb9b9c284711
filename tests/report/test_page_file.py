"""The report as a file: it says what it is, carries the checksum of its content, and is refused where edited."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError
from inertialcal.core.schema.checksum import text_checksum
from inertialcal.report.page_file import SEAL, find_page, sealed_page

Typed = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page_file") / "demo"
    copy_example("npsat2011", folder)
    run(folder)
    return folder


@pytest.fixture
def page(ran: Path, tmp_path: Path) -> Path:
    shutil.copytree(ran / "out", tmp_path / "out")
    return tmp_path / "out/report.html"


@pytest.fixture
def typed(capsys: pytest.CaptureFixture[str]) -> Typed:
    def call(*words: Any) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as left:
            main([str(word) for word in words])
        out, err = capsys.readouterr()
        assert "internal error" not in err
        return int(left.value.code or 0), out, err

    return call


def checksum_in(path: Path) -> str:
    return str(json.loads(path.read_text(encoding="utf-8"))["checksum"])


def test_show_tells_what_a_report_is(page: Path, typed: Typed) -> None:
    results = json.loads((page.parent / "results.json").read_text(encoding="utf-8"))
    status, out, _ = typed("show", page, "--json")
    content = json.loads(out)
    assert (status, content["remarks"], content["unchanged"]) == (0, [], True)
    assert content["report"] == {
        "campaign": results["campaign"]["id"], "verdict": results["verdict"], "results": results["checksum"],
        "model": checksum_in(page.parent / "model.json"),
    }  # fmt: skip
    status, out, _ = typed("show", page)
    assert status == 0
    assert f"report of campaign {results['campaign']['id']}, unchanged" in " ".join(out.split())
    assert f"verdict: {results['verdict']}" in out
    assert results["checksum"] in out
    text = page.read_text(encoding="utf-8")
    assert f'<span class="hash"><bdi>{results["checksum"]}</bdi></span>' in text
    assert typed("show", page.rename(page.with_name("renamed.dat")))[0] == 0


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("INCONCLUSIVE", "PASS"), ("</body>", "<p>more</p></body>"), ("\n", "\r\n"), (SEAL, "<!-- "),
        ('"inertialcal-report" content="', '"inertialcal-report" content=" '), ("<td", "<td "), ("0", "1"),
    ],
)  # fmt: skip
def test_an_edited_report_is_refused(page: Path, typed: Typed, old: str, new: str) -> None:
    text = page.read_text(encoding="utf-8")
    assert old in text
    page.write_text(text.replace(old, new), encoding="utf-8", newline="")
    status, out, _ = typed("show", page, "--json")
    error = json.loads(out)["errors"][0]
    assert (status, error["code"], error["where"]) == (3, "checksum", str(page))
    assert "edited by hand" in error["why"]


def test_what_lies_beside_and_is_of_another_run_is_told(page: Path) -> None:
    content = json.loads((page.parent / "results.json").read_text(encoding="utf-8"))
    (page.parent / "results.json").write_text(json.dumps(content | {"checksum": "sha256:0"}), encoding="utf-8")
    found = find_page(page)
    assert found is not None
    assert [(one.code, "results.json" in one.what) for one in found.remarks] == [("other_run", True)]
    for name in ("results.json", "model.json"):
        (page.parent / name).unlink()
    alone = find_page(page)
    assert alone is not None
    assert alone.remarks == ()


def test_the_checksum_is_that_of_the_page_with_its_place_empty() -> None:
    page = f'<html>{SEAL}">{SEAL}">'
    sealed = sealed_page(page)
    digest = text_checksum(page)
    assert sealed == f'<html>{SEAL}{digest}">{SEAL}">'


@pytest.mark.parametrize("said", ["1", "[]", "{}", '{"campaign": [[1]]}', "not JSON", '{"more": 1}'])
def test_a_head_that_says_something_else_is_refused(tmp_path: Path, said: str) -> None:
    head = f'<meta name="inertialcal-report" content="{said.replace(chr(34), "&#34;")}">'
    (tmp_path / "page.html").write_text(sealed_page(f'<html>{head}{SEAL}">'), encoding="utf-8")
    with pytest.raises(DataError, match="not the head of a report") as caught:
        find_page(tmp_path / "page.html")
    assert caught.value.problems[0].code == "schema"


def test_a_report_gives_no_figure(page: Path, typed: Typed) -> None:
    status, _, err = typed("show", page, "-o", page.with_name("a.png"))
    assert status == 2
    assert "a report gives no figure" in err
    assert typed("show", page.with_name("absent.html"))[0] == 3
    assert typed("show", page, "-q")[1] == ""
