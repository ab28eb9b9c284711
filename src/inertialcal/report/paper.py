"""``report.pdf``: the report for paper, by typst: a page for the verdict, one for the model, one a test.

Its words are those of the page, its figures the same drawings. They go in as data beside the template, which shows
them as text: nothing in them is read as markup. What is too long for its page is set smaller; long lists end after
ten with a count, and appendices, on request, hold them in full.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from ..core.show import wording
from ..core.show.requirement_lines import HEADS, requirement_lines
from ..core.show.rows import Changed, case_name, quantity_name
from ..files.write.typst import typst_pdf
from . import findings, numbers
from .drawings import Drawing
from .page import content_of
from .sections import FEW, Line, Section, by_severity

TEMPLATE = Path(__file__).parent / "templates" / "paper.typ"
FIGURES = 6  # of a test
LONGEST = 400  # letters of one text
UNBROKEN = 18  # letters, after which a word without a space may break
UNDATED = date(2000, 1, 1)  # results hold no clock time; a run says SOURCE_DATE_EPOCH where a date is wanted
_SVG = re.compile(r"<svg.*?</svg>", re.DOTALL)
_ROLE = re.compile(r"var\(--fig-(?:font, ([^)]*)|[a-z]+, ([^)]*))\)")
_LONG = re.compile(rf"(\S{{{UNBROKEN}}})(?=\S)")
LINE_HEADS = ("quantity", "axis", "value ± u", "unit", "95 % interval", "status")
LOOP_HEADS = ("axis", "condition", "rms raw", "rms compensated", "unit", "dwells", "verdict")
STANDARD_HEADS = ("standard", "influence", "u", "unit", "certificate")

Rows = list[list[str]]
Draw = Callable[[Sequence[Drawing]], Mapping[str, str]]


def report_pdf(
    results: Mapping[str, Any],
    model: Mapping[str, Any] | None,
    provenance: Mapping[str, Any],
    draw: Draw,
    appendices: bool = False,
    made: date = UNDATED,
) -> bytes:
    """Return the report as PDF: two pages, one more a test, and appendices where they are wanted.

    Parameters
    ----------
    results, model, provenance : mapping
        As `page.report_html` takes them.
    draw : callable
        Gives the markup of figures by their key.
    appendices : bool
        Add every quantity, verdict and input.
    made : date
        That the file gives as its own.

    Raises
    ------
    UsageError, StoreError
        As ``files.write.typst``.
    """
    page = content_of(results, model, provenance)
    files: dict[str, bytes] = {}
    drawn = draw(page["pictures"]["drawn"])
    data = _front(page, results, drawn, files) | {
        "tests": [_test(one, one.step, page, drawn, files) for one in page["sections"] if one.step is not None],
        "appendices": _appendices(page, results, provenance) if appendices else [],
    }
    return typst_pdf(TEMPLATE.read_text(encoding="utf-8"), data, made, files)


def check_typst() -> None:
    """Refuse before the work what could not be written after it.

    Raises
    ------
    UsageError, StoreError
        As ``files.write.typst``.
    """
    typst_pdf("", {}, UNDATED)


def date_of(environment: Mapping[str, str]) -> date:
    """Return the date that SOURCE_DATE_EPOCH asks for; a fixed one where it is not set, so that bytes repeat."""
    given = environment.get("SOURCE_DATE_EPOCH", "")
    return datetime.fromtimestamp(int(given), UTC).date() if given.isdecimal() and len(given) < 11 else UNDATED


def plain(text: object) -> str:
    """Return a text for paper: without markup and controls, bounded, breakable where it is long."""
    if isinstance(text, str) and not hasattr(text, "unescape"):
        said = numbers.clean(text)
    else:
        said = numbers.clean(str(text.striptags() if hasattr(text, "striptags") else text))
    said = said if len(said) <= LONGEST else said[: LONGEST - 1] + "…"
    return _LONG.sub("\\1\N{ZERO WIDTH SPACE}", said.replace("_", "_\N{ZERO WIDTH SPACE}"))


def _said(finding: findings.Finding) -> str:
    return plain(findings.html(finding))


def _front(
    page: dict[str, Any], results: Mapping[str, Any], drawn: Mapping[str, str], files: dict[str, bytes]
) -> dict[str, Any]:
    """Return what the first two pages say."""
    r, lists = page["r"], page["lists"]
    item = [str(r["item"][name] or "") for name in ("maker", "part", "serial")]
    top, partner = page["pictures"]["top"], page["pictures"]["partner"]
    lines = [line.cells for line in requirement_lines(results)]
    remarks = by_severity(lists["remarks"])
    absent = [one for one in r["standards"] if not one["stated"]]
    stated = [one for one in r["standards"] if one["stated"]]
    delivered = page["delivered"]
    return {
        "title": plain(" ".join(filter(None, item)) or "Item not named"),
        "campaign": plain(": ".join(filter(None, (str(r["campaign"]["id"]), str(r["campaign"]["title"] or ""))))),
        "verdict": plain(str(r["verdict"] or "not stated")),
        "why": _said(findings.of_verdict(r["verdict"], r["verification"], r["closed_loop"])),
        "decision": [_said(one) for one in findings.of_decision(r["verification"], r["verdicts"])],
        "heads": list(HEADS),
        "requirements": [[plain(cell) or "–" for cell in cells] for cells in lines[:FEW]],
        "more_requirements": _more(lines, "requirement"),
        "figures": _figures([one for one in (top, partner) if one is not None], drawn, files)[0],
        "model": _said(findings.of_model(delivered[0].model if delivered else None, r["closed_loop"])),
        "equation": [plain(one) for one in delivered[0].equation] if delivered else [],
        "sentences": [_said(one) for one in (delivered[0].sentences or ())[:FEW]] if delivered else [],
        "matrix": _figures([page["pictures"]["matrix"]] if page["pictures"]["matrix"] else [], drawn, files)[0],
        "loop": _said(findings.of_closed_loop(r["closed_loop"])),
        "loop_heads": list(LOOP_HEADS),
        "loops": [_loop(one) for one in r["closed_loop"]["axes"]][:FEW],
        "absent": [plain(", ".join(wording.words(one[name]) for name in ("standard", "influence")))
                   for one in absent[:FEW]] + [_more(absent, "influence")] * (len(absent) > FEW),
        "standard_heads": list(STANDARD_HEADS),
        "standards": [_standard(one) for one in stated[:FEW]],
        "more_standards": _more(stated, "influence"),
        "remarks": [_remark(one) for one in remarks[:FEW]],
        "more_remarks": _more(remarks, "remark"),
        "exclusions": _said(findings.of_exclusions(lists["exclusions"])),
        "checksums": [
            [name, plain(str(held["checksum"]))]
            for name, held in (("results.json", r), ("model.json", page["document"]))
            if held is not None and "checksum" in held
        ],
        "rerun": plain(str(page["provenance"]["rerun"])),
        "versions": plain(", ".join(f"{name} {page['provenance']['versions'][name]}" for name in
                                    page["provenance"]["versions"])),
    }  # fmt: skip


def _more(every: Sequence[object], noun: str, file: str = "report.html") -> str:
    """Return how many of a list are left out, and where they are; empty for none."""
    rest = len(every) - FEW
    return f"… and {wording.counted(rest, noun)} more: see {file}" if rest > 0 else ""


def _test(
    section: Section, step: Any, page: dict[str, Any], drawn: Mapping[str, str], files: dict[str, bytes]
) -> dict[str, Any]:
    """Return what the page of a test says."""
    kinds = (str(step["procedure"]), str(step["use"]), str(step["condition"] or ""))
    figures, rest = _figures(page["pictures"]["tests"].get(section.test, []), drawn, files)
    missing = [f"{', '.join(_of(row) for row in rows[:FEW])}: {reason}" for reason, rows in section.missing]
    return {
        "name": plain(section.test),
        "about": plain(" · ".join(filter(None, map(wording.words, kinds)))),
        "finding": _said(section.finding),
        "figures": figures,
        "more_figures": f"{wording.counted(rest, 'figure').capitalize()} more: see report.html" if rest else "",
        "heads": list(LINE_HEADS),
        "rows": [_line(line) for line in section.first_lines],
        "more": f"… and {wording.counted(len(section.more_lines), 'quantity')} more: see results.csv"
        if section.more_lines
        else "",
        "changes_title": plain(f"What changed since {step['against']}") if section.changes else "",
        "change_heads": [plain(one) for one in _change_heads(section, step)] if section.changes else [],
        "changes": [_change(one) for one in _changes(section)[:FEW]],
        "more_changes": _more(section.changes, "change"),
        "missing": [plain(one) for one in missing[:FEW]],
        "more_missing": _more(missing, "reason", "results.csv"),
        "remarks": [_remark(one) for one in section.remarks[:FEW]],
        "more_remarks": _more(section.remarks, "remark"),
    }


def _figures(
    wanted: Sequence[Drawing], drawn: Mapping[str, str], files: dict[str, bytes]
) -> tuple[list[dict[str, Any]], int]:
    """Return the figures that there is room for, each with its pictures, and how many are left out."""
    shown = [one for one in wanted if one.key in drawn][:FIGURES]
    found = []
    for one in shown:
        parts = _SVG.findall(str(drawn[one.key]))
        names = [f"{one.key}-{number}.svg" for number in range(len(parts))]
        files |= {name: _in_light(part).encode("utf-8", "replace") for name, part in zip(names, parts, strict=True)}
        found.append({"files": names, "caption": _said(one.caption), "alt": plain(one.picture.label)})
    return found, len(wanted) - len(shown)


def _in_light(svg: str) -> str:
    """Return a drawing with the colours and the font of paper in place of the names that a page gives them."""
    return _ROLE.sub(lambda found: found[1] or found[2], svg)


def _line(line: Line) -> list[str]:
    """Return the cells of a quantity."""
    row, name = line.row, wording.words(line.quantity) + (f" ({line.case})" if line.case else "")
    if row is None:
        return [plain(name), plain(line.axis), "–", plain(_unit(line.unit)), "–", "–"]
    limit = row["status"] == "upper_limit"
    value = numbers.digits(row["value"]) if limit and row["u"] is None else numbers.both(row["value"], row["u"])
    reason = "" if row["reason"] is None else str(getattr(row["reason"], "get", lambda *_: row["reason"])("text", ""))
    status = reason or ("upper limit" if limit else "estimated")
    cells = (name, line.axis, f"{'< ' if limit else ''}{_tagless(value)}", _unit(line.unit), _interval(row), status)
    return [plain(cell) for cell in cells]


def _changes(section: Section) -> list[Changed[Any]]:
    """Return what figures changed by, those that a requirement is about first."""
    return sorted(section.changes, key=lambda one: not one.verdict)


def _change_heads(section: Section, step: Any) -> tuple[str, ...]:
    return "quantity", "axis", str(step["against"]), section.test, "unit", "change", "95 % interval", "verdict"


def _change(one: Changed[Any]) -> list[str]:
    """Return the cells of a change: the figure in both tests, and by how much; of sizes, times how much."""
    row, own = one.change, one.before or one.after or one.change
    both = [
        "–" if each is None else _tagless(numbers.both(each["value"], each["u"])) for each in (one.before, one.after)
    ]
    change = f"{'× ' if one.is_ratio else ''}{_tagless(numbers.both(row['value'], row['u']))}"
    cells = (one.name, f"{row['sensor'] or ''} {row['axis']}", *both, _unit(own["unit"]), change,
             _interval(row), one.verdict)  # fmt: skip
    return [plain(str(cell).strip()) for cell in cells]


def _interval(row: Any) -> str:
    if row["interval"] is None:
        return "–"
    lo, hi = (row["interval"][end] for end in ("lo", "hi"))
    ends = (
        ("−∞" if lo is None else _tagless(numbers.rounded(lo, row["u"]))),
        ("∞" if hi is None else _tagless(numbers.rounded(hi, row["u"]))),
    )
    return " … ".join(ends)


def _tagless(text: Any) -> str:
    return str(text.striptags()) if hasattr(text, "striptags") else str(text)


def _unit(unit: object) -> str:
    return "" if str(unit) == "1" else str(unit)


def _of(row: Any) -> str:
    return " ".join(filter(None, (wording.words(quantity_name(row)), str(row["axis"]), str(case_name(row)))))


def _loop(one: Any) -> list[str]:
    rms = [_tagless(numbers.digits(one[name])) for name in ("raw_rms", "compensated_rms")]
    cells = (one["axis"], one["condition"] or "–", *rms, one["unit"], numbers.plain(one["dwells"]), one["verdict"])
    return [plain(str(cell)) for cell in cells]


def _standard(one: Any) -> list[str]:
    names = (wording.words(one["standard"]), wording.words(one["influence"]))
    return [plain(str(cell)) for cell in (*names, _tagless(numbers.digits(one["u"])), _unit(one["unit"]),
                                          one["certificate"] or "no certificate")]  # fmt: skip


def _remark(one: Any) -> list[str]:
    said = f"{one['what']}{'. ' if one['do'] else ''}{one['do']}"
    return [plain(wording.SEVERITY_NAMES.get(str(one["severity"]), "note")), plain(said), plain(str(one["where"]))]


def _appendices(
    page: dict[str, Any], results: Mapping[str, Any], provenance: Mapping[str, Any]
) -> list[dict[str, Any]]:
    """Return the long tables: every quantity of each test, every verdict, every input."""
    found = [_table(f"Quantities of {one.test}", LINE_HEADS, map(_line, one.together)) for one in page["sections"]]
    for one in page["sections"]:
        if one.changes and one.step is not None:
            title = f"What {one.test} changed by since {one.step['against']}"
            found.append(_table(title, _change_heads(one, one.step), map(_change, _changes(one))))
    judged = page["lists"]["verdicts"]
    heads = ("requirement", "test", "axis", "at", "value ± u", "limits", "margin", "verdict")
    found.append(_table("Verdicts", heads, map(_verdict, judged)))
    inputs = ([one["path"], one["sha256"]] for one in provenance["inputs"])
    found.append(_table("Inputs and their SHA-256", ("file", "SHA-256"), inputs))
    return [one for one in found if one["rows"]]


def _table(title: str, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> dict[str, Any]:
    return {"title": plain(title), "heads": list(heads), "rows": [[plain(cell) for cell in row] for row in rows]}


def _verdict(one: Any) -> list[str]:
    at = "–" if one["at"] is None else f"{numbers.plain(one['at'])} {one['at_unit']}"
    ends = ["−∞" if one["lower"] is None else numbers.plain(one["lower"]),
            "∞" if one["upper"] is None else numbers.plain(one["upper"])]  # fmt: skip
    value = f"{_tagless(numbers.both(one['value'], one['u']))} {_unit(one['unit'])}"
    margin = "–" if one["margin"] is None else _tagless(numbers.rounded(one["margin"], one["u"]))
    names = (one["requirement"], one["test"], one["axis"])
    return [str(cell) for cell in (*names, at, value, " … ".join(ends), margin, one["verdict"])]
