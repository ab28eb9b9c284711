"""The page against the files it shows: every number equals its place in them, and nothing else stands there."""

from __future__ import annotations

import copy
import json
import re
from collections import Counter
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.show.requirement_lines import requirement_lines
from inertialcal.files.binary.curves import read_curves
from inertialcal.report.drawings import of_campaign
from inertialcal.report.page import LARGEST, content_of, environment, report_html
from sized import sized

LIMIT = 600_000  # bytes, from the issue
VOID = {"meta", "link", "br", "img", "input", "hr", "wbr"}
STATIC = {"pre", "svg", "script", "style", "title", "code"}  # code, CSV, figures: each has its own test
DIGIT = re.compile(r"\d")

Files = tuple[dict[str, Any], dict[str, Any] | None, dict[str, Any]]


class Page(HTMLParser):
    """Elements of a page: every <data>, and every other visible text with the elements that it stands in."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.stack: list[tuple[str, dict[str, str | None]]] = []
        self.data: list[tuple[str, str, str]] = []
        self.texts: list[tuple[str, str]] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.pres: dict[str, str] = {}
        self.feed(text)
        assert not self.stack, f"not closed: {self.stack}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        assert len(found) == len(attrs), f"an attribute twice: {attrs}"
        self.tags.append((tag, found))
        if tag == "data":
            self.data.append((found["value"] or "", found["data-at"] or "", ""))
        if tag not in VOID:
            self.stack.append((tag, found))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.stack, f"closed but never opened: {tag}"
        assert self.stack[-1][0] == tag, f"{tag} closes {self.stack[-1]}"
        self.stack.pop()

    def handle_data(self, text: str) -> None:
        inside = [tag for tag, _ in self.stack]
        if "data" in inside:
            value, at, shown = self.data[-1]
            self.data[-1] = (value, at, shown + text)
        elif "pre" in inside:
            name = next(one.get("id") or "" for tag, one in self.stack if tag == "pre")
            self.pres[name] = self.pres.get(name, "") + text
        elif not STATIC & set(inside):
            self.texts.append((inside[-1] if inside else "", text))


def at(files: Files, pointer: str) -> Any:
    """Follow a JSON pointer into the file that it names."""
    name, _, path = pointer.rpartition(":")
    value: Any = {"": files[0], "curves": files[0].get("curves"), "model": files[1], "provenance": files[2]}[name]
    for token in path.split("/")[1:]:
        key = token.replace("~1", "/").replace("~0", "~")
        value = value[int(key)] if isinstance(value, list) else value[key]
    return value


def strings(content: Any) -> Iterator[str]:
    """Yield every text of a file, keys too."""
    if isinstance(content, str):
        yield content
    elif isinstance(content, dict):
        for key, value in content.items():
            yield key
            yield from strings(value)
    elif isinstance(content, list):
        for value in content:
            yield from strings(value)


def is_rounding(shown: str, value: float) -> bool:
    """Whether a text is the number to as many digits as the text has."""
    shown, _, word = shown.partition(" ")  # lengths of records are in hours, and said as people do
    value *= {"days": 1 / 24.0, "min": 60.0, "s": 3600.0}.get(word, 1.0)
    if not re.fullmatch(r"-?\d+(\.\d+)?(e[+-]\d+)?", shown):
        return False
    mantissa, _, exponent = shown.partition("e")
    places = len(mantissa.partition(".")[2])
    step = 10.0 ** (int(exponent or 0) - places)
    return abs(float(shown) - value) <= 0.5000001 * step + 1e-12 * abs(value)


def read(folder: Path) -> Files:
    out = folder / "out"
    model = out / "model.json"
    return (
        json.loads((out / "results.json").read_text()) | {"curves": read_curves((out / "curves.parquet").read_bytes())},
        json.loads(model.read_text()) if model.is_file() else None,
        json.loads((out / "provenance.json").read_text()),
    )


@pytest.fixture(scope="module", params=["published", "still", pytest.param("simulated", marks=pytest.mark.slow)])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Files, str]:
    folder = tmp_path_factory.mktemp("page") / request.param
    if request.param == "published":
        copy_example("npsat2011", folder)
    else:
        simulate({"simulated": "rate_table", "still": "still_gyro"}[request.param], folder, seed=3)
    run(folder)
    return read(folder), (folder / "out" / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def thesis(tmp_path_factory: pytest.TempPathFactory) -> Files:
    folder = tmp_path_factory.mktemp("page") / "published"
    copy_example("npsat2011", folder)
    run(folder)
    return read(folder)


@pytest.fixture
def small(campaign: Callable[..., Path]) -> Files:
    run(campaign())
    return read(campaign())


def test_every_number_is_that_of_its_pointer(made: tuple[Files, str]) -> None:
    files, text = made
    page = Page(text)
    assert len(page.data) > (150 if {one["procedure"] for one in files[0]["sequence"]} == {"static_noise"} else 500)
    for value, pointer, shown in page.data:
        there = at(files, pointer)
        assert not isinstance(there, bool)
        assert repr(there) == value, pointer
        assert is_rounding(shown.strip(), there), f"{pointer}: {shown!r} for {there!r}"


def test_no_digit_stands_outside_a_number_or_a_text_of_the_files(made: tuple[Files, str]) -> None:
    files, text = made
    known = {one for file in files if file is not None for one in strings(file)}
    lines = requirement_lines(files[0])  # the table at the top: its words are checked where they are made
    known |= {one for line in lines for one in (*line.cells, line.requirement, line.text, line.place)}
    templates = "".join(path.read_text() for path in sorted(Path(environment().loader.searchpath[0]).glob("*.html")))  # type: ignore[union-attr]
    for tag, shown in Page(text).texts:
        said = " ".join(shown.split())
        if not DIGIT.search(said):
            continue
        if tag == "bdi":
            assert shown in known, shown
        else:
            for word in (one for one in said.split() if DIGIT.search(one)):
                assert word.strip(".,;:()") in templates or word in {"95"}, f"{word!r} in {said!r}"


@pytest.fixture
def roomy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a page hold everything that may be left out."""
    monkeypatch.setattr("inertialcal.report.page.LARGEST", 20 * LARGEST)


@pytest.mark.usefixtures("roomy")
def test_data_behind_figures_are_the_curves(made: tuple[Files, str]) -> None:
    files, _ = made
    page = Page(report_html(*files))
    columns = [(c["name"], n, v["values"]) for c in files[0]["curves"] for n, v in c["columns"].items()]
    known = {tuple("" if one is None else repr(one) for one in values) for _, _, values in columns}
    csvs = {name: shown for name, shown in page.pres.items() if "rate_error" in name or "allan" in name}
    assert csvs
    for shown in csvs.values():
        rows = [line.split(",") for line in shown.strip().split("\n")]
        for column in zip(*rows[1:], strict=True):
            assert tuple(column) in known


def test_the_page_is_small_loads_nothing_and_knows_no_clock(made: tuple[Files, str]) -> None:
    files, text = made
    assert len(text.encode()) < LIMIT
    assert files[2]["made"] not in text
    page = Page(text)
    for tag, found in page.tags:
        assert tag not in {"link", "img", "iframe", "object", "embed", "base", "form"}
        assert not any(name.startswith("on") or name in {"src", "srcset", "action"} for name in found)
        assert (found.get("href") or "#").startswith("#")
        assert not re.search(r"url\((?!#)", found.get("style") or "")
        assert not any("<bdi" in (value or "") for value in found.values()), found
    assert "<bdi>" not in text.partition("<title>")[2].partition("</title>")[0]
    assert sum(tag == "script" for tag, _ in page.tags) == 1
    policy = next(one["content"] or "" for tag, one in page.tags if one.get("http-equiv"))
    assert policy.startswith("default-src 'none'")
    assert "script-src 'sha256-" in policy
    assert not re.search(r"https?://(?!www\.w3\.org)", text)


def test_ids_are_unique_links_lead_somewhere_and_tables_have_captions(made: tuple[Files, str]) -> None:
    page = Page(made[1])
    ids = [found["id"] for _, found in page.tags if "id" in found]
    assert len(set(ids)) == len(ids)
    for tag, found in page.tags:
        if tag == "a":
            assert (found["href"] or "")[1:] in ids
        for name in ("aria-labelledby", "data-from"):
            assert found.get(name) in {None, *ids}
    tags = [tag for tag, _ in page.tags]
    assert tags.count("table") == tags.count("caption") > 5
    levels = [int(tag[1]) for tag in tags if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1
    assert all(later - earlier <= 1 for earlier, later in pairwise(levels))
    assert tags.count("main") == tags.count("nav") == tags.count("h1") == 1


@pytest.mark.usefixtures("drawn_anew")
def test_same_files_same_bytes(small: Files) -> None:
    assert report_html(*small) == report_html(*copy.deepcopy(small))


def test_a_campaign_without_model_loop_or_requirement_says_so(campaign: Callable[..., Path]) -> None:
    folder = campaign(
        ("[[requirements]]", "[model]"), ('id = "R1"\n', ""), ('quantity = "rate_error"\n', ""),
        ('limit = "5 %"\n', ""), ('where = "abs(rate) >= 0.5 deg/s"\n', ""),
        ('id = "first"\n', 'id = "first"\nuse = "report_only"\n'),
    )  # fmt: skip
    run(folder)
    text = " ".join((folder / "out" / "report.html").read_text().split())
    assert "not stated" in text
    assert "so this report gives no verdict" in text
    assert "The closed loop was not run: <bdi>no model: no test for a fit gives a term of it</bdi>" in text
    assert "No model is delivered" in text
    assert "No requirements stated" in text
    assert not (folder / "out" / "model.json").exists()


def test_missing_standards_are_said_loudly(campaign: Callable[..., Path]) -> None:
    folder = campaign(("[standards.rate_table]\n", ""), ('rate = { u = "0.05 %", certificate = "C-1" }\n', ""))
    run(folder)
    text = (folder / "out" / "report.html").read_text()
    assert re.search(r"class=\"loud\".{0,200}Not stated", text, re.DOTALL)


def test_a_standard_stands_with_its_certificate(small: Files) -> None:
    assert "<bdi>C-1</bdi>" in report_html(*small)


HOSTILE = (
    "<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "' onfocus=alert(1) '", "</style><b>",
    "</pre></table>", "{{ 7 * 7 }}", "$\\frac{1}{2}$", "a\x00b\x1b[31m", "\u202egnp.exe", "\u2066open", "x" * 1900,
    "&lt;b&gt;", "]]>", "-->",
)  # fmt: skip


@pytest.mark.parametrize(
    "text", [pytest.param(one, marks=pytest.mark.slow if i % 3 else []) for i, one in enumerate(HOSTILE)]
)
def test_hostile_texts_are_shown_and_do_nothing(small: Files, text: str) -> None:
    results, model, provenance = copy.deepcopy(small)
    plain = Page(report_html(results, model, provenance))
    for place in (results["campaign"], results["item"]):
        place.update(dict.fromkeys(set(place) - {"id"}, text))
    results["remarks"].append(
        {"code": "c", "severity": "warning", "what": text, "where": "first", "count": 1, "do": text}
    )
    results["standards"][0]["certificate"] = text
    results["sequence"][0]["recordings"][0]["file"] = text
    results["verification"][0]["text"] = text
    provenance["inputs"][0]["path"] = text
    page = Page(report_html(results, model, provenance))
    safe = re.sub("[\x00\x1b\u202e\u2066]", "\N{REPLACEMENT CHARACTER}", text)
    assert sum(shown == safe for _, shown in page.texts) >= 5
    assert {tag for tag, _ in page.tags} <= {tag for tag, _ in plain.tags} | {
        "ul",
        "li",
        "details",
        "summary",
        "p",
        "bdi",
    }
    assert {name for _, found in page.tags for name in found} <= {n for _, found in plain.tags for n in found}


def test_models_of_two_conditions_stand_one_after_the_other(small: Files) -> None:
    results, model, provenance = copy.deepcopy(small)
    assert model is not None
    one = model["models"].pop("")
    supply = {"channel": "supply", "unit": "V", "reference": 5.0, "bias": [0.0125] * len(one["axes"]),
              "bias_temperature": None, "scale_factor": None, "range": None}  # fmt: skip
    model["models"] = {"air": one, "vacuum": {**one, "sensitivities": [supply]}}
    page = Page(report_html(results, model, provenance))
    ids = [found["id"] for _, found in page.tags if "id" in found]
    assert len(set(ids)) == len(ids)
    assert {"apply-python", "apply-python-2"} <= set(ids)
    pointers = [pointer for _, pointer, _ in page.data if pointer.startswith("model:/models/")]
    assert any(pointer.startswith("model:/models/air/terms") for pointer in pointers)
    assert "model:/models/vacuum/sensitivities/0/bias/0" in pointers
    for value, pointer, _ in page.data:
        assert repr(at((results, model, provenance), pointer)) == value


def twice(results: dict[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    """Return results in which each test was made once more, under another name."""
    copies = {key: [{**row, "test": f"{row['test']}_again"} for row in results[key]] for key in keys}
    return results | {key: results[key] + copies[key] for key in keys}


@pytest.mark.parametrize("most", [9, 10, 11, 12, 13])
def test_axes_of_a_figure_are_drawn_all_or_none(
    made: tuple[Files, str], monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    (results, model, provenance), _ = made
    results = twice(results, ("results", "sequence", "curves"))
    monkeypatch.setattr("inertialcal.report.page.MOST_FIGURES", most)
    drawn = content_of(results, model, provenance)["pictures"]["drawn"]
    there = Counter((one.spec.name, one.picture.test) for one in of_campaign(results))
    found = Counter((one.spec.name, one.picture.test) for one in drawn)
    assert 0 < len(drawn) <= most
    assert all(found[kind] == there[kind] for kind in found if kind[1].endswith("_again"))


@pytest.mark.slow  # half a minute
def test_a_large_campaign_stays_small(made: tuple[Files, str]) -> None:
    files, _ = made
    results, model, provenance = copy.deepcopy(files)
    for key in ("results", "sequence", "curves", "verdicts", "budgets", "exclusions"):
        rows = results[key]
        results[key] = rows + [
            {**row, "test": f"{row['test']}_{copies}"}
            for copies in range(sized(60, 30) // len(files[0]["sequence"]))
            for row in rows
        ]
    text = report_html(results, model, provenance)
    assert len(text.encode()) <= LARGEST
    page = Page(text)
    assert "verdict" in {found.get("id") for _, found in page.tags}
    assert "No room for" in text


def said(text: str) -> str:
    """Return what a page says, without its elements."""
    return " ".join(re.sub("<[^>]*>", "", text).split())


def test_what_was_not_estimated_does_not_look_measured(thesis: Files) -> None:
    text = report_html(*thesis)
    matrix = text.partition('<table class="matrix">')[2].partition("</table>")[0]
    assert matrix.count("not estimated") == 6
    assert "x scale factor: no error shown (0.099 ± 0.038 %)." in said(text)
    assert "y scale factor too high: error 0.530 ± 0.067 %." in said(text)


def test_the_way_from_codes_to_the_input_of_the_code_is_said(thesis: Files) -> None:
    results, model, provenance = copy.deepcopy(thesis)
    assert "times 0.5 V/(deg/s) they are volts." in said(report_html(results, model, provenance))
    sensor = results["sensors"]["suite"]
    sensor["mounting"] = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]
    sensor["chain"] |= {"kind": "adc", "lsb": "0.0012 V", "counts": [0, 4095], "reference": "channel"}
    sensor["chain"] |= {"gain": {"x": 100, "z": 10}, "zero": "0.1 V"}
    told = said(report_html(results, model, provenance))
    assert "volts are codes 0 to 4095 times 0.0012 V, minus the reference recorded with each signal" in told
    assert "minus the zero of 0.1 V, divided by the gain of x 100, z 10" in told
    assert "[-1, 0, 0], [0, 1, 0], [0, 0, -1]" in told
    sensor["chain"] |= {"kind": "pulse_rate", "gate": "100 s", "reference": None}
    assert "pulses per second are codes divided by a gate of 100 s" in said(report_html(results, model, provenance))


@pytest.mark.usefixtures("roomy")
def test_exclusions_of_many_are_in_the_plural(thesis: Files) -> None:
    results, model, provenance = copy.deepcopy(thesis)
    results["exclusions"][0] |= {"count": 22, "counts": "sample"}
    told = said(report_html(results, model, provenance))
    assert "22 samples" in told
    assert "1 dwells" not in told


@pytest.mark.usefixtures("roomy")
def test_a_budget_ends_with_the_uncertainty_of_its_quantity(thesis: Files) -> None:
    """The squares of the contributions add up to it: by hand, from the numbers on the page."""
    results, model, provenance = thesis
    page = report_html(results, model, provenance)
    feet = re.findall(r"<tbody>((?:(?!<tbody>).)*?)</tbody><tfoot>(.*?)</tfoot>", page, re.DOTALL)
    assert len(feet) == len({(one["test"], one["quantity"], one["axis"]) for one in results["budgets"]})
    for body, foot in feet:
        parts = [float(v) for v, _ in re.findall(r'<data value="([^"]*)" data-at="/budgets/(\d+)/u"', body)]
        (total,) = re.findall(r'<data value="([^"]*)" data-at="/results/\d+/u"', foot)
        assert float(total) == pytest.approx(sum(one * one for one in parts) ** 0.5, rel=1e-9)


def test_no_template_prints_a_bare_number() -> None:
    for wrong in (1.5, 3, True, None):
        with pytest.raises(TypeError, match="numbers of the page carry a pointer"):
            environment().from_string("{{ one }}").render(one=wrong)
