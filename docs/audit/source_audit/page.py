"""The manual page: a summary first, then what matters, then each document, a section a table."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from inertialcal.core.show.rounding import with_uncertainty

from .figures import STANDS, UNTOLD, WORDS, Document, Figure, Section, Text
from .verdicts import Verdict, judge, tolerance

SHORT, FEW = 6, 2  # figures listed in a line; figures without data that get a line each
PLAIN, SMALL, PLACES = 1e6, 1e-3, 6  # sizes above and below which numbers are written otherwise; digits
FLOATING = 1e-9
HEAD = """\
# Source audit: which published figures hold

`inertialcal` repeats what three published calibrations did. For that the figures that they print were computed again
from their own data, as far as those reach: raw readings and plots are not in the documents. This page is what came
out. One command writes it, from the tables of the documents as data (`docs/audit/tables/`), and a test compares it
with what the command gives:

    python docs/audit/audit.py

No verdict was given by hand: [the rules](#how-a-verdict-is-reached) are below. A printed figure stands for every
number that rounds to it, and so do the printed figures that it is computed from.
"""

RULES = {
    "follows": "the recomputed figure lies within half a unit of the last printed digit and the carried rounding of "
    "what it "
    "is computed from; or the stated limit or order holds",
    "rounding": "beyond that, but by one unit of the last digit and 1 % of the figure at most",
    "misprint": "one wrong character (a digit, the point, two digits exchanged, one too many) mends it, or the figure "
    "belongs in another cell, or the printed formula with one symbol mended gives it",
    "sign": "the size follows with the opposite sign, or with one term of the opposite sign",
    "unit": (
        "a power of a thousand or the factor between two units mends it, or the unit cannot be that of the quantity"
    ),
    "does not follow": "none of these",
    "too coarse": "it lies inside the tolerance, but that is above twenty half units of its last digit: what it is "
    "computed from is rounded too coarsely for an agreement to say anything",
    "cannot be told": "the document does not hold what is needed",
}
NOTE = """\
A printed figure that does not follow need not be wrong: the document may have used data that it does not print.
What the page says is that nobody can get from the one to the other. The documents were read as text, not as scans:
a single wrong digit may be a reading error.
"""


def page(documents: Sequence[Document]) -> str:
    """Return the page as Markdown."""
    parts = [HEAD, *_summary(documents), "## What matters to users\n"]
    for document in documents:
        parts += [f"**{document.title}** ({document.citation})\n", *_effects(document)]
    parts += ["## How a verdict is reached\n", _table(["verdict", "meaning"], [[w, RULES[w]] for w in WORDS]), NOTE]
    for document in documents:
        parts += _document(document)
    return "\n".join(parts).rstrip("\n") + "\n"


def counts(sections: Sequence[Section]) -> Counter[str]:
    """Return how many figures have each verdict."""
    return Counter(judge(one).word for section in sections for one in section.figures)


def causes(sections: Sequence[Section]) -> int:
    """Return how many things are wrong: figures of a section with one verdict and one reason have one cause."""
    found = {
        (section.key, verdict.word, verdict.reason)
        for section in sections
        for verdict in map(judge, section.figures)
        if verdict.word not in (*STANDS, *UNTOLD)
    }
    return len(found)


def _summary(documents: Sequence[Document]) -> list[str]:
    rows, total, wrong = [], Counter[str](), 0
    for document in documents:
        own = [section for section in document.sections if not section.identity]
        found = counts(own)
        total += found
        wrong += causes(own)
        rows.append([f"[{document.title}](#{_anchor(document)})", *_numbers(found), str(causes(own))])
    apart = [section for document in documents for section in document.sections if section.identity]
    trivial = counts(apart)
    rows += [["all", *_numbers(total), str(wrong)], ["identities, apart", *_numbers(trivial), str(causes(apart))]]
    held, untold = (sum(total[word] for word in words) for words in (STANDS, UNTOLD))
    by_itself = sum(trivial[word] for word in STANDS)
    names = "; ".join(section.title for section in apart)
    text = (
        f"Of {total.total()} figures that can be computed from others, **{held} hold**, rounding included; "
        f"{total.total() - held - untold} do not, from {wrong} distinct causes; of {untold} it cannot be told. "
        f"{trivial.total()} more are identities: they repeat another figure, or are products and sums of their own "
        f"line ({names}). {by_itself} of those hold, which says little, so they are counted apart. Figures of one "
        "table with one verdict for one reason are one cause.\n"
    )
    scope = (
        "Looked at were the tables and the figures of the text that other printed figures determine. Plots, raw "
        "readings and what rests on them alone were not.\n"
    )
    return ["## In short\n", text, scope, _table(["document", "figures", *WORDS, "causes"], rows)]


def _numbers(found: Counter[str]) -> list[str]:
    return [str(found.total()), *(str(found[word]) if found[word] else "" for word in WORDS)]


def _anchor(document: Document) -> str:
    return document.title.lower().replace(" ", "-")


def _effects(document: Document) -> list[str]:
    return [_table(["finding", "effect"], [[one.finding, one.effect] for one in document.effects])]


def _document(document: Document) -> list[str]:
    found = counts(document.sections)
    words = ", ".join(f"{found[word]} {word}" for word in WORDS if found[word])
    head = [f"## {document.title}\n", f"{document.citation}. {found.total()} figures: {words}.\n"]
    return head + [part for section in document.sections for part in _section(section)]


def _section(section: Section) -> list[str]:
    judged = [(one, judge(one)) for one in section.figures]
    held = [one for one, verdict in judged if verdict.word in STANDS]
    rest = [(one, verdict) for one, verdict in judged if verdict.word not in STANDS]
    parts = [f"### {section.title}\n", f"{section.how}\n"]
    if held:
        parts += _folded(_share(len(held), len(judged)), held)
    coarse = [one for one, verdict in rest if verdict.word == "too coarse"]
    if coarse:
        rest = [(one, verdict) for one, verdict in rest if verdict.word != "too coarse"]
        parts += _folded(f"{len(coarse)} too coarse to tell", coarse)
    unknown = [one for one, verdict in rest if verdict.word == "cannot be told"]
    if len(unknown) > FEW:
        reason = next(verdict.reason for _, verdict in rest if verdict.word == "cannot be told")
        rest = [(one, verdict) for one, verdict in rest if verdict.word != "cannot be told"]
        parts += _folded(f"{len(unknown)} cannot be told ({reason})", unknown)
    if rest:
        heads = ["figure", "printed", "recomputed", "verdict", "remark"]
        parts.append(_table(heads, [_line(one, verdict) for one, verdict in rest]))
    return parts


def _folded(head: str, figures: Sequence[Figure | Text]) -> list[str]:
    """Return figures as a list in a line, or folded away where they are many; by what stands before the comma."""
    shared = Counter(one.place.partition(", ")[0] for one in figures)
    groups: dict[str, list[str]] = {}
    for one in figures:
        name, _, rest = one.place.partition(", ")
        grouped = shared[name] > 1 and rest
        groups.setdefault(name if grouped else "", []).append(f"{rest if grouped else one.place}{_value(one)}")
    lists = [f"{name}: {', '.join(them)}" if name else ", ".join(them) for name, them in groups.items()]
    if len(figures) <= SHORT:
        return [f"{head}: {'; '.join(lists)}.\n"]
    items = "\n".join(f"- {one}" for one in lists)
    return [f"<details><summary>{head}</summary>\n\n{items}\n\n</details>\n"]


def _share(held: int, n: int) -> str:
    if held == n:
        return "It holds" if n == 1 else f"All {n} hold"
    return f"{held} of {n} {'holds' if held == 1 else 'hold'}"


def _value(one: Figure | Text) -> str:
    """Return what is printed, with the recomputed value only where the last digit differs."""
    if isinstance(one, Text):
        return f" {one.printed}"
    rounded = f" (recomputed {_recomputed(one)})" if judge(one).word == "rounding" else ""
    return f" {one.printed.text}{rounded}"


def _line(one: Figure | Text, verdict: Verdict) -> list[str]:
    if isinstance(one, Text):
        return [one.place, one.printed, one.needed, verdict.word, verdict.reason]
    unit = f" {one.unit}" if one.unit else ""
    return [
        one.place,
        f"{one.printed.text}{unit}",
        _recomputed(one),
        verdict.word,
        verdict.reason or _off(one, verdict),
    ]


def _off(one: Figure, verdict: Verdict) -> str:
    """Return the difference, where nothing else is to be said."""
    if one.recomputed is None or verdict.word != "does not follow":
        return "the size follows" if verdict.word == "sign" else ""
    by = one.printed.value - one.recomputed.value
    part = f", {100.0 * by / one.recomputed.value:+.2g} %" if one.recomputed.value else ""
    return f"off by {by:+.3g}{part}"


def _recomputed(one: Figure) -> str:
    """Return the recomputed figure with the tolerance of the comparison."""
    if one.recomputed is None:
        return "-"
    limit = {"equal": "", "at most": "at most ", "at least": "at least "}[one.relation]
    value, both = one.recomputed.value, tolerance(one)
    both = both if both < abs(value) else one.recomputed.tolerance
    if abs(value) < FLOATING * abs(one.printed.value):
        return f"{limit}0"
    if one.recomputed.tolerance <= FLOATING * abs(value) or (abs(value) >= PLAIN and value.is_integer()):
        text = f"{value:.0f}" if value.is_integer() else f"{value:.{PLACES}g}"
        return limit + text
    if abs(value) < SMALL:
        decade = math.floor(math.log10(abs(value)))
        places = max(decade - math.floor(math.log10(both)) + 1, 0)
        return f"{limit}({value / 10.0**decade:.{places}f} ± {both / 10.0**decade:.{places}f})e{decade:+03d}"
    return limit + with_uncertainty(value, both)


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"
