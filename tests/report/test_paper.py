"""``report.pdf``: two pages and one a test, the same bytes twice, texts of the user shown as they are."""

from __future__ import annotations

import copy
import io
import json
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import UsageError
from inertialcal.files.binary.curves import read_curves
from inertialcal.report.drawings import Drawing
from inertialcal.report.paper import FIGURES, LONGEST, UNDATED, date_of, plain, report_pdf
from ran_campaigns import Ran

pikepdf: Any = pytest.importorskip("pikepdf")
pytest.importorskip("typst")

LINE = '<path d="M1 1l7 7" stroke="var(--fig-ink, #1b1b1b)"/>'
SQUARE = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">{LINE}</svg>'
HOSTILE = ('#eval("1")', "$x$", "@a", "[", "]", "\\", "*b*", "= head", "#pagebreak()", "// gone", "/* gone", "`raw`",
           "<label>", "~", "_i_", "'", '"', "#let x = 1;", "https://a.b", "-- ---", "\u202ex", "\x00")  # fmt: skip

Files = tuple[dict[str, Any], dict[str, Any] | None, dict[str, Any]]


def read(folder: Path) -> Files:
    out = folder / "out"
    results = json.loads((out / "results.json").read_text())
    results["curves"] = read_curves((out / "curves.parquet").read_bytes())
    model = json.loads((out / "model.json").read_text()) if (out / "model.json").is_file() else None
    return results, model, json.loads((out / "provenance.json").read_text())


def squares(wanted: Sequence[Drawing]) -> Mapping[str, str]:
    """Return a drawing for every figure that takes no time."""
    return {one.key: SQUARE for one in wanted}


def drawn(wanted: Sequence[Drawing]) -> Mapping[str, str]:
    return {one.key: str(one.svg()) for one in wanted}


def pages(data: bytes) -> int:
    with pikepdf.open(io.BytesIO(data)) as found:
        return len(found.pages)


@pytest.fixture
def small(campaign: Callable[..., Path]) -> Files:
    run(campaign())
    return read(campaign())


@pytest.fixture
def words(need: Callable[[str], str], tmp_path: Path) -> Callable[[bytes], str]:
    program = need("pdftotext")

    def text(data: bytes) -> str:
        path = tmp_path / "read.pdf"
        path.write_bytes(data)
        got = subprocess.run([program, str(path), "-"], capture_output=True, check=True)
        return got.stdout.decode().replace("\N{ZERO WIDTH SPACE}", "")

    return text


@pytest.mark.parametrize(
    "name",
    ["published", pytest.param("still", marks=pytest.mark.slow), pytest.param("simulated", marks=pytest.mark.slow)],
)
def test_two_pages_and_one_a_test(reports: dict[str, Path], name: str) -> None:
    files = read(reports[name].parent.parent)
    tests = len(files[0]["sequence"])
    data = report_pdf(*files, drawn)
    assert pages(data) == 2 + tests
    assert pages(report_pdf(*files, squares, appendices=True)) > 2 + tests


def test_a_campaign_of_the_suite_keeps_to_its_pages(campaign_ran: Ran) -> None:
    results = campaign_ran.results
    provenance: dict[str, Any] = {"inputs": [], "versions": {}, "rerun": "inertialcal run DIR"}
    assert pages(report_pdf(results, None, provenance, squares)) <= 2 + len(results["sequence"])


def test_what_changed_since_another_test_has_a_table(small: Files, words: Callable[[bytes], str]) -> None:
    results, model, provenance = copy.deepcopy(small)
    step = results["sequence"][0]
    row = next(one for one in results["results"] if one["test"] == step["test"] and one["u"] and not one["condition"])
    later = row | {"test": "later", "value": 3.0, "u": 0.1}
    at = {"what": "mode", "value": 2.0, "unit": ""}
    change = later | {"method": "change", "value": 1.25, "u": 0.125, "interval": {"lo": 1.0, "hi": 1.5, "p": 0.95}}
    placed = change | {"value": 7.5, "u": 0.25, "at": at}
    results["results"] += [later, change, placed]
    results["sequence"].append(step | {"test": "later", "against": step["test"]})
    said = words(report_pdf(results, model, provenance, squares, appendices=True))
    assert f"What changed since {step['test']}" in said
    assert f"Appendix: What later changed by since {step['test']}" in said
    for text in ("1.25 ± 0.12", "1.00 … 1.50", "3.00 ± 0.10", "(mode 2)", "7.50 ± 0.25"):
        assert said.count(text) >= 2
    assert "What changed" not in words(report_pdf(*small, squares))


def test_same_bytes_twice_and_the_date_that_is_asked_for(small: Files) -> None:
    first = report_pdf(*small, drawn)
    assert first == report_pdf(*copy.deepcopy(small), drawn)
    assert date_of({}) == UNDATED
    assert date_of({"SOURCE_DATE_EPOCH": "1700000000"}) == date(2023, 11, 14)
    assert date_of({"SOURCE_DATE_EPOCH": "soon"}) == UNDATED
    assert first != report_pdf(*small, drawn, made=date(2023, 11, 14))


def test_hostile_texts_are_shown_as_they_are(small: Files, words: Callable[[bytes], str]) -> None:
    results, model, provenance = copy.deepcopy(small)
    before = pages(report_pdf(*small, squares))
    for number, text in enumerate(HOSTILE):
        results["remarks"].insert(0, {"code": "c", "severity": "error", "what": f"{text} {number}", "where": text,
                                      "count": 1, "do": text})  # fmt: skip
    results["remarks"] = results["remarks"][:8]
    results["campaign"]["title"] = " ".join(HOSTILE[:12])
    results["item"]["part"] = HOSTILE[0]
    results["verification"][0]["text"] = " ".join(HOSTILE[12:])
    data = report_pdf(results, model, provenance, squares)
    shown = "".join(words(data).split())
    for text in HOSTILE[:-2]:
        assert "".join(text.split()) in shown, text
    assert "\u202e" not in shown
    assert pages(data) == before


@pytest.mark.parametrize("long", ["W" * 5000, "word " * 1000, "\n" * 500])
def test_long_texts_stay_on_their_page(small: Files, long: str) -> None:
    results, model, provenance = copy.deepcopy(small)
    before = pages(report_pdf(*small, squares))
    results["campaign"]["title"] = results["item"]["part"] = long
    for row in results["verification"]:
        row["text"] = long
    results["remarks"] = [
        {"code": "c", "severity": "info", "what": long, "where": "first", "count": 1, "do": long}
    ] * 40
    assert pages(report_pdf(results, model, provenance, squares)) == before


def test_lists_end_after_ten_with_a_count(small: Files, words: Callable[[bytes], str]) -> None:
    results, model, provenance = copy.deepcopy(small)
    one = {"code": "c", "severity": "info", "what": "said", "where": "", "count": 1, "do": ""}
    results["remarks"] = [one | {"what": f"said {number}"} for number in range(47)]
    assert "… and thirty-seven remarks more: see report.html" in " ".join(
        words(report_pdf(results, model, provenance, squares)).split()
    )
    assert FIGURES == 6
    assert len(plain("x y " * LONGEST)) <= LONGEST


def status(*words: str | Path) -> int:
    """Return the exit status of a command."""
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return int(ended.value.code or 0)


def test_run_writes_it_and_forgets_it(campaign: Callable[..., Path]) -> None:
    folder = campaign()
    assert status("run", folder, "--pdf", "--quiet") in {0, 1, 4}
    short = (folder / "out/report.pdf").read_bytes()
    assert "report.pdf" in (folder / "out/SHA256SUMS").read_text()
    status("run", folder, "--pdf", "--appendices", "--quiet")
    assert pages((folder / "out/report.pdf").read_bytes()) > pages(short)
    status("run", folder, "--quiet")
    assert not (folder / "out/report.pdf").exists()  # what it said may no longer hold


def test_appendices_need_the_pdf(campaign: Callable[..., Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert status("run", campaign(), "--appendices") == 2
    assert "Add --pdf" in capsys.readouterr().err


def test_without_typst_the_way_out_is_said_before_the_work(
    campaign: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "typst", None)
    with pytest.raises(UsageError, match="typst") as refused:
        run(campaign(), pdf=True)
    assert "pip install 'inertialcal[pdf]'" in str(refused.value)
    assert not (campaign() / "out").exists()
