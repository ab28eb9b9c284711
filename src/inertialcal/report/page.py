"""``report.html``: one file that holds a whole campaign, for readers who never saw the tool.

It loads nothing: no font, no picture, no script from anywhere. The one script inside fills the clipboard; a policy in
the head allows that script by its hash and nothing else, and without it the page works in full. What would make the
file too long is left out from the end of a list of priorities (tables before figures before their data), and said.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from ..core.show import wording
from ..core.show.output_tables import OutputTable, output_tables
from ..core.show.requirement_lines import HEADS, requirement_lines
from ..core.show.rows import case_name, case_words, quantity_name, verdict_of
from . import drawings, findings, numbers, record_length, sections
from .coefficients import delivered
from .drawings import Drawing
from .figures import variables
from .findings import highlights
from .numbers import Text
from .page_file import about_text, sealed_page

COPY = "copy.js"  # the script of every page
FOLDER = Path(__file__).parent / "templates"
LARGEST = 590_000  # bytes of the page
MOST_FIGURES = 21  # drawn on a page: each takes time
USES = ("fit", "hold_out", "report_only")  # figures of the first are wanted most, there those of tests that are judged
ZOOM = Markup('<label class="zoom"><input type="checkbox"> enlarge</label>')  # the style sheet does the rest
NO_ROOM = 20_000  # bytes left, with which no further figure is drawn
FILTERS: dict[str, Callable[..., Any]] = {
    "rounded": numbers.rounded,
    "uncertainty": numbers.uncertainty,
    "alone": numbers.alone,
    "freedom": numbers.freedom,
    "digits": numbers.digits,
    "both": numbers.both,
    "sentence": findings.html,
    "bare": numbers.clean,
    "quoted": Text,
    "breakable": lambda name: Markup(str(Text(name).__html__()).replace("_", "_<wbr>")),  # noqa: S704 - escaped
    "words": wording.words,
    "case_words": case_words,
    "named": lambda row: Text(quantity_name(row)),
    "case": lambda row: Text(case_name(row)),
    "time": numbers.time,
    "by_severity": sections.by_severity,
}


def report_html(
    results: Mapping[str, Any],
    model: Mapping[str, Any] | None,
    provenance: Mapping[str, Any],
    draw: Callable[[Sequence[Drawing]], Mapping[str, str]] | None = None,
) -> str:
    """Return the page of a campaign.

    Parameters
    ----------
    results, model, provenance : mapping
        Content of results.json, of model.json (None where none is delivered) and of provenance.json.
    draw : callable, optional
        Gives the markup of figures by their key; each is drawn here if not given.
    """
    page = content_of(results, model, provenance)
    page["svg"] = draw(page["pictures"]["drawn"]) if draw is not None else {}
    whole = environment().get_template("page.html")
    room = Room(LARGEST - _size(whole.render(page, blocks={})), {})
    for name, block in _blocks(page, room):
        size = _size(block)
        if size <= room.left:
            room.blocks[name] = block
            room.left -= size
    return sealed_page(whole.render(page, blocks=room.blocks))


@dataclass
class Room:
    """Space that is left on the page, and the blocks that fitted."""

    left: int
    blocks: dict[str, Markup]


def content_of(
    results: Mapping[str, Any], model: Mapping[str, Any] | None, provenance: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what the templates are handed: every number with its pointer."""
    r = numbers.wrap(results, "")
    lists = {name: r[name] for name in ("results", "sequence", "verdicts", "remarks", "budgets", "exclusions")}
    found = sections.sections(lists["results"], lists["sequence"], lists["verdicts"], lists["remarks"])
    sensor_of = {f"{sections.MODEL}_{name}": str(name) for name in r["sensors"]}
    glance = requirement_lines(results)
    modelled = None if model is None else numbers.wrap(model, "model:")
    return {
        "r": r,
        "about": about_text(results, model),
        "document": modelled,  # all of model.json
        "provenance": numbers.wrap(provenance, "provenance:"),
        "delivered": [] if model is None or modelled is None else delivered(model, modelled, lists["results"]),
        "sections": found,
        "models": [(sensor_of[one.test], one) for one in found if one.test in sensor_of],
        "model_lines": sections.table(row for row in lists["results"] if row["test"] == sections.MODEL),
        "glance": glance[: sections.FEW],
        "glance_heads": HEADS,
        "unlisted": wording.count(len(glance) - sections.FEW) if len(glance) > sections.FEW else "",
        "highlights": [] if glance else highlights(r),
        "output": _of_several(output_tables(results["sensors"], results["sequence"], lists["results"])),
        "reaches": record_length.reaches(numbers.wrap(results["curves"], "curves:"), lists["results"]),
        "budgets": _named(sections.grouped(lists["budgets"], "test"), "budget"),
        "totals": sections.budgeted(lists["results"]),
        "judged": _named(sections.grouped(lists["verdicts"], "requirement", "test", "sensor", "axis"), "verdicts"),
        "recordings": sum(len(step["recordings"]) for step in lists["sequence"]),
        "lists": lists,
        "pictures": _pictures(results),
        "find": findings,
        "record_length": record_length,
        "wording": wording,
        "grouped": sections.grouped,
        "by_key": sections.by_key,
        "tally": wording.tally,
    }


def _of_several(tables: list[OutputTable[numbers.Branch]]) -> list[OutputTable[numbers.Branch]]:
    """Return tables that collect what several tests found; nothing where one test says it all."""
    tests = {test for one in tables for line in one.lines for test in line.tests}
    return tables if len(tests) > 1 else []


def _named(groups: Iterable[tuple[tuple[str, ...], list[Any]]], kind: str) -> list[tuple[str, tuple[str, ...], Any]]:
    return [(f"{kind}-{number}", key, rows) for number, (key, rows) in enumerate(groups)]


def _pictures(results: Mapping[str, Any]) -> dict[str, Any]:
    """Return the figures by where they stand, and all in the order in which they are wanted."""
    found = drawings.of_campaign(results)
    leading = [one for one in found if one.spec.top is not None]
    top = min(leading, key=lambda one: one.spec.top or 0, default=None)
    partner = None  # of a pair at the top
    if top is not None:
        wanted_one = (top.spec.partner, top.picture.test, top.picture.axis)
        partner = next(
            (one for one in found if (one.spec.name, one.picture.test, one.picture.axis) == wanted_one), None
        )
    matrix = next((one for one in found if one.spec.place == "model" and one.picture.test == sections.MODEL), None)
    of_tests: dict[str, list[Drawing]] = {}
    for one in found:
        if one.spec.place == "test" and one not in (top, partner):
            of_tests.setdefault(one.picture.test, []).append(one)
    for drawn in of_tests.values():
        drawn.sort(key=lambda one: (one.spec.rank, one.picture.axis))
    budgets = {one.picture.test: one for one in found if one.spec.place == "budgets"}
    budgets = {sections.MODEL: budgets[sections.MODEL]} if sections.MODEL in budgets else budgets
    judged = {one["test"] for one in results["verdicts"]}
    first = [one for one in found if one.spec.first and one is not top]
    others: list[tuple[bool, int, bool, int, Drawing]] = []
    for step in results["sequence"]:
        kinds: dict[str, int] = {}  # of figures of the test, in the order in which they stand there
        for one in of_tests.get(step["test"], []):
            kind = kinds.setdefault(one.spec.name, len(kinds))
            if one not in first:
                others.append((kind > 0, USES.index(step["use"]), step["test"] not in judged, kind, one))
    others.sort(key=lambda found: found[:4])  # the first kind of each test before any second
    drawn = [one for one in (top, partner, *first, matrix, *budgets.values()) if one is not None][:MOST_FIGURES]
    for _, group in groupby((one for *_, one in others), lambda one: (one.spec.name, one.picture.test)):
        axes = list(group)
        if len(drawn) + len(axes) > MOST_FIGURES:  # all axes or none
            break
        drawn += axes
    return {"top": top, "partner": partner, "tests": of_tests, "budgets": budgets, "matrix": matrix, "drawn": drawn}


def _blocks(page: dict[str, Any], room: Room) -> Iterator[tuple[str, Markup]]:
    """Yield what may be left out, the most wanted first."""
    top, *others = page["pictures"]["drawn"] or [None]
    yield from _drawn([top] if top else [], page, room)
    for section in page["sections"]:
        yield from _of_section(section, page)
    if page["reaches"]:
        yield "noise", _block("noise", tests=record_length.by_test(page["reaches"]))
    yield from _drawn(others, page, room)
    yield from _lists(page)
    for one in page["pictures"]["drawn"]:
        if room.left > NO_ROOM:
            yield f"data-{one.key}", _block("data", key=one.key, tables=one.data())


def _lists(page: dict[str, Any]) -> Iterator[tuple[str, Markup]]:
    """Yield the long tables that stand folded."""
    for name, _, rows in page["judged"]:
        yield name, _block("verdicts", rows=rows)
    if page["output"]:
        yield "output", _block("output", tables=page["output"])
    yield "exclusions", _block("exclusions", rows=page["lists"]["exclusions"])
    for section in page["sections"]:
        if section.step is not None:
            yield f"recordings-{section.anchor}", _block("recordings", step=section.step)
    yield from _budgets(page, True)
    for section in page["sections"]:
        if section.more_lines:
            yield _lines(f"more-lines-{section.anchor}", section.more_lines, section, page)
    yield from _budgets(page, False)


def _budgets(page: dict[str, Any], of_model: bool) -> Iterator[tuple[str, Markup]]:
    """Yield the tables of the budgets of the first model, or of all others, which are long."""
    for name, key, rows in page["budgets"]:
        if (key[0] == sections.MODEL) == of_model:
            yield name, _block("budget", rows=rows, totals=page["totals"], by_key=sections.by_key, find=findings)


def _of_section(section: sections.Section, page: dict[str, Any]) -> Iterator[tuple[str, Markup]]:
    """Yield the tables of a test: its quantities, those of single recordings, the comparison with another test."""
    yield _lines(f"lines-{section.anchor}", section.first_lines, section, page)
    if section.alone:
        own = [line for line in section.lines if any(way in line.alternatives for way, _ in section.alone)]
        yield f"alone-{section.anchor}", _block("alone", lines=own, names=section.alone)
    if section.pairs:
        other = section.step["against"] if section.step else ""
        names = {"test": section.test, "caption": section.pairs_caption, "other": other}
        yield f"pairs-{section.anchor}", _block("pairs", pairs=section.pairs, verdict_of=verdict_of, **names)
    if section.changes and section.step is not None:
        names = {"test": section.test, "other": section.step["against"]}
        yield f"changes-{section.anchor}", _block("changes", changes=section.changes, **names)


def _lines(
    name: str, lines: list[sections.Line], section: sections.Section, page: dict[str, Any]
) -> tuple[str, Markup]:
    elsewhere = record_length.explained(page["reaches"])
    ways = [way for way in section.ways if any(way in line.alternatives for line in lines)]
    return name, _block("lines", lines=lines, ways=ways, elsewhere=elsewhere)


def _drawn(wanted: Iterable[Drawing], page: dict[str, Any], room: Room) -> Iterator[tuple[str, Markup]]:
    for one in wanted:
        if room.left > NO_ROOM:
            yield one.key, Markup(page["svg"].get(one.key) or one.svg()) + ZOOM  # noqa: S704 - as there


def _block(name: str, **content: Any) -> Markup:
    return Markup(environment().get_template(f"{name}.html").render(content))  # noqa: S704 - a template escaped it


def _size(text: str) -> int:
    return len(text.encode("utf-8", "surrogatepass"))


def script(name: str) -> Markup:
    """Return one of our own scripts as it stands in a page."""
    return Markup((FOLDER / name).read_text(encoding="utf-8"))  # noqa: S704 - our own file


def policy(*names: str) -> str:
    """Return the policy in the head of a page: it allows these scripts by their hashes and nothing else."""
    digests = (base64.b64encode(hashlib.sha256(script(name).encode()).digest()).decode() for name in names)
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests)
    return (
        f"default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src {allowed}; "
        "base-uri 'none'; form-action 'none'"
    )


@cache
def environment() -> Environment:
    """Return the templates' environment: everything is escaped, and no bare number can be printed."""
    made = Environment(
        loader=FileSystemLoader(FOLDER), autoescape=True, undefined=StrictUndefined, finalize=_printable,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    made.filters |= FILTERS
    made.globals |= {
        "count": wording.count,
        "counted": wording.counted,
        "most": sections.FEW,
        "script": script(COPY),
        "style": Markup((FOLDER / "style.css").read_text(encoding="utf-8")),  # noqa: S704 - our own file
        "light": variables(),
        "dark": variables(dark=True),
        "policy": policy(COPY),
    }
    return made


def _printable(value: Any) -> Any:
    """Return what a template prints.

    Raises
    ------
    TypeError
        For a number without its pointer, and for nothing.
    """
    if value is None or isinstance(value, int | float):
        raise TypeError(f"a template prints {value!r}: numbers of the page carry a pointer")
    return value if hasattr(value, "__html__") else numbers.clean(value)
