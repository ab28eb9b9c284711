"""The checks of pages find what they are for: each passes a good page and fails a bad one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from html import escape
from pathlib import Path

import pytest
from accessibility import serious_faults
from browsing import PAPER, PHONE, Visit, visit
from figure_checks import blank, cut_on_paper, empty_figures, faint_texts, small_texts
from hostile_page import bidi_leaks, elements, reactions
from injections import ELSEWHERE, EVALUATED, INJECTIONS, RUN
from layout import Texts, cut_texts, overlapping_texts, seen_texts, sideways
from playwright.sync_api import Browser, Page

DRAWN = (
    '<g clip-path="url(#c)"><path d="M 10 50 L 20 40 L 30 45 L 40 30 L 50 35 L 60 20" stroke="blue" fill="none"/></g>'
)
FIGURE = (
    '<figure><svg role="img" aria-label="f" viewBox="0 0 200 100" style="width:100%;max-width:400px">'
    '<defs><clipPath id="c"><rect width="200" height="100"/></clipPath></defs>'
    '<path d="M 5 5 L 5 90 L 190 90" stroke="gray" fill="none"/><text x="90" y="98" font-size="8">rate [deg/s]</text>'
    f"{DRAWN}</svg></figure>"
)
GOOD = f"""<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>good</title>
<meta name="viewport" content="width=device-width"><style>
body {{ margin: 1em; background: white; color: black }} figure, tr {{ break-inside: avoid }} figure {{ margin: 0 }}
.wide {{ overflow-x: auto }} h1 {{ line-height: 1.1 }}</style></head><body><main>
<h1>A finding of some length that takes more than one line on a phone: the bias is 0.0012(3) deg/s</h1>
<p>Text with a <b>bold</b> word, m<sup>2</sup> and <bdi>a name from the data</bdi>.</p><p id="verdict">PASS</p>
<div class="wide" tabindex="0" role="region" aria-label="t"><table><tr><th>axis</th><th>bias</th></tr>
<tr><td>x</td><td>0.0012</td></tr></table></div>{FIGURE}
<details><summary>Data</summary><pre>1,2</pre></details></main></body></html>"""

Check = Callable[[Page], list[str]]


def on_paper(page: Page) -> list[str]:
    return cut_on_paper(page, 300.0) + cut_texts(seen_texts(page), paper=True)


def on_texts(check: Callable[[Texts], list[str]]) -> Check:
    return lambda page: check(seen_texts(page))


overlapping, cut, small = on_texts(overlapping_texts), on_texts(cut_texts), on_texts(small_texts)


CHECKS: tuple[Check, ...] = (
    sideways, cut, overlapping, empty_figures, small, faint_texts, blank, serious_faults,
    on_paper, bidi_leaks,
)  # fmt: skip

# What is changed in the good page, and which check must say so.
FAULTS: tuple[tuple[Check, str, str], ...] = (
    (sideways, "<h1>", '<div style="width: 1500px">wide</div><h1>'),
    (sideways, "A finding", "A" * 300),
    (cut, "<h1>", '<h1 style="height: 0.5em; overflow: hidden">'),
    (cut, 'x="90" y="98"', 'x="180" y="98"'),
    (overlapping, "<p id", '<p style="margin-top: -1.6em" id'),
    (overlapping, "</svg>", '<text x="92" y="97" font-size="8">over it</text></svg>'),
    (overlapping, "<td>0.0012</td>", '<td style="position: relative; left: -2.5em">0.0012</td>'),
    (empty_figures, DRAWN, '<g clip-path="url(#c)"><path d="M 5 50 L 190 50" stroke="red"/></g>'),
    (empty_figures, DRAWN, ""),
    (small, 'font-size="8"', 'font-size="2"'),
    (faint_texts, 'font-size="8"', 'font-size="8" fill="#bbb"'),
    (faint_texts, "background: white; color: black", "background: #111; color: white"),
    (blank, "<body>", '<body style="visibility: hidden">'),
    (blank, 'role="img"', 'role="img" opacity="0"'),
    (serious_faults, 'aria-label="f"', ""),
    (serious_faults, "<p>Text", '<p style="color: #bbb">Text'),
    (serious_faults, "<pre>1,2</pre>", "<button></button>"),
    (on_paper, "figure, tr", "tr"),
    (on_paper, "figure, tr", "figure"),
    (on_paper, "max-width:400px", ""),
    (on_paper, "<td>0.0012</td>", f"<td>{'0' * 300}</td>"),
    (bidi_leaks, "<bdi>a name from the data</bdi>", "\u202ea name from the data"),
)


@pytest.fixture(scope="module")
def page(browser: Browser) -> Iterator[Page]:
    context = browser.new_context()
    yield context.new_page()
    context.close()


def faults(page: Page, check: Check, text: str) -> list[str]:
    paper = check is on_paper
    page.set_viewport_size({"width": PAPER if paper else PHONE, "height": 844})
    page.emulate_media(media="print" if paper else "screen")
    page.set_content(text)
    return check(page)


@pytest.mark.parametrize("check", CHECKS)
def test_a_good_page_has_no_fault(page: Page, check: Check) -> None:
    assert faults(page, check, GOOD) == []


@pytest.mark.parametrize(("check", "good", "bad"), FAULTS)
def test_a_bad_page_has_one(page: Page, check: Check, good: str, bad: str) -> None:
    assert good in GOOD
    assert faults(page, check, GOOD.replace(good, bad, 1))


# One for each way in which a text can be let through, by the words that the check must answer with.
LET_THROUGH = (
    (f"<img src=x onerror={RUN}>", "ran as a script"),
    (f"<script>{RUN}</script>", "ran as a script"),
    (f"<p onmouseover={RUN}>", "ran as a script"),
    ("<script>alert(1)</script>", "dialog: 1"),
    ("<script>throw 7</script>", "error: "),
    (f"<link rel=stylesheet href={ELSEWHERE}/x.css>", "asked for"),
    (f"<p style='background:url({ELSEWHERE}/x)'>x</p>", "asked for"),
    (f"<meta http-equiv=refresh content='0;url={ELSEWHERE}/'>", "asked for"),
    (f"<a href='javascript:{RUN}'>x</a>", "active: <a href"),
    (f"<svg><animate onbegin={RUN} attributeName=x dur=1s></svg>", "active: <animate onbegin"),
    (EVALUATED, "ran as a template"),
)


@pytest.fixture(scope="module")
def seen(browser: Browser) -> Iterator[Visit]:
    with visit(browser, Path(__file__)) as opened:
        yield opened


@pytest.fixture
def opened(seen: Visit, tmp_path: Path) -> Callable[[str], Visit]:
    """Open the good page with a text in it."""

    def put(text: str) -> Visit:
        path = tmp_path / "page.html"
        path.write_text(GOOD.replace("a name from the data", text), encoding="utf-8")
        seen.open(path)
        return seen

    return put


@pytest.mark.parametrize(("text", "answer"), LET_THROUGH)
def test_a_text_that_is_let_through_is_noticed(opened: Callable[[str], Visit], text: str, answer: str) -> None:
    assert any(answer in one for one in reactions(opened(text)))


def test_escaped_texts_bring_no_reaction(opened: Callable[[str], Visit]) -> None:
    plain = elements(opened("a name").page)
    escaped = opened(escape(" ".join(INJECTIONS)))
    assert elements(escaped.page) == plain
    assert reactions(escaped) == []
    assert elements(opened("</bdi><bdi>").page) != plain
