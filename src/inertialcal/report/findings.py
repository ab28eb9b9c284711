"""What each section found, in one line: words, and numbers that stay numbers.

A finding is a tuple of parts, each a text or a figure with its uncertainty. It makes no number of its own: it
picks rows by a stated rule and says what they hold.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from markupsafe import Markup, escape

from ..core.results import case_of
from ..core.show.rows import Quoted, error_sentence, estimated, largest, quantity_name
from ..core.show.wording import VERDICTS, count, counted, listed, severities
from ..core.units import factor, kind
from ..procedures import procedure_of
from .numbers import Branch, Number, Text, both, clean, digits, time, unwrapped

LOOP = "closed loop"  # row of the verification matrix that is no requirement
ERRORS = ("scale_factor_error", "misalignment")
FALLBACKS = ("bias", "residual_bias", "ambient_acceleration", "scale_factor", "scatter_run", "scatter_dwell",
             "angle_random_walk", "velocity_random_walk", "bias_instability")  # fmt: skip


@dataclass(frozen=True)
class Figure:
    """A number of the files with its standard uncertainty and unit; few digits where it has no uncertainty."""

    value: Number
    u: Number | None = None
    unit: str = ""

    def __html__(self) -> Markup:
        shown = digits(self.value) if self.u is None else both(self.value, self.u)
        return Markup("{}{}{}").format(shown, " " if self.unit else "", self.unit)


@dataclass(frozen=True)
class Length:
    """A length of time of the files, in the unit that people would say it in."""

    value: Number
    unit: str

    def __html__(self) -> Markup:
        return Markup(time(self.value, self.unit))  # noqa: S704 - made of a number and a unit


Finding = tuple[str | Figure | Length, ...]


def html(finding: Finding) -> Markup:
    """Return a finding as markup: texts escaped, figures as ``<data>``."""
    return Markup("").join(escape(part if hasattr(part, "__html__") else clean(part)) for part in finding)


def of_row(row: Branch) -> Figure:
    """Return the figure of a row of results."""
    return Figure(row["value"], row["u"], _unit(row["unit"]))


def of_test(procedure: str, rows: Sequence[Branch], verdicts: Sequence[Branch]) -> Finding:
    """Say what a test found, in the words of its procedure, and what the requirements made of it.

    Parameters
    ----------
    procedure : str
        Its name; empty for what no single test gave, as the rows of a model.
    rows, verdicts : sequence of Branch
        Of the test.
    """
    say = procedure_of(procedure).finding if procedure else error_sentence
    at = {id(unwrapped(row)): row for row in rows}
    parts: list[str | Figure] = []
    for part in say([unwrapped(row) for row in rows]):
        if isinstance(part, str):
            parts.append(Text(part) if isinstance(part, Quoted) else part)
            continue
        row = at[id(part.row)]
        parts.append(Figure(row["value"], row["u"] if part.u else None, _unit(row["unit"]) if part.unit else ""))
    for requirement in dict.fromkeys(one["requirement"] for one in verdicts):
        mine = [one for one in verdicts if one["requirement"] == requirement]
        parts += ["; ", requirement, " ", worst(mine)]
    return tuple(parts)


def worst(verdicts: Iterable[Branch]) -> str:
    """Return the gravest verdict of some."""
    found = {str(one["verdict"]) for one in verdicts}
    return next((word for word in VERDICTS if word in found), "")


def of_closed_loop(loop: Branch) -> Finding:
    """Say what compensation did to hold-out readings, on the worst axis."""
    axis = worst_axis(loop)
    if axis is None:
        return ("Closed loop not run: ", loop["reason"])
    several = len({str(one["unit"]) for one in loop["axes"]}) > 1
    which = " (worst axis relative to raw) " if several else " (worst axis) "
    return (
        "Compensation takes the rms error of ", axis["axis"], which, "from ",
        Figure(axis["raw_rms"]), " to ", Figure(axis["compensated_rms"], None, axis["unit"]), ": ", loop["verdict"],
    )  # fmt: skip


def worst_axis(loop: Branch) -> Branch | None:
    """Return the axis with the largest rms error after compensation, relative to raw where units differ."""
    axes: list[Branch] = [one for one in loop["axes"] if one["compensated_rms"] is not None]
    if len({str(one["unit"]) for one in axes}) > 1:
        return max(axes, key=lambda one: one["compensated_rms"].raw / (one["raw_rms"].raw or 1.0))
    return max(axes, key=lambda one: one["compensated_rms"].raw, default=None)


def of_verdict(verdict: str | None, verification: Sequence[Branch], loop: Branch) -> Finding:
    """Say in one sentence why the verdict is what it is."""
    if not verdict:
        return ("No requirements stated and no closed loop run, so this report gives no verdict.",)
    named = {word: [row["requirement"] for row in verification if row["verdict"] == word] for word in VERDICTS}
    stated = {word: [name for name in names if name != LOOP] for word, names in named.items()}
    found: list[Finding] = []
    if verdict in ("FAIL", "INCONCLUSIVE"):
        if names := stated["FAIL"]:
            why = (
                ": by its decision rule."
                if _named_rule(verification)
                else ": an interval lies entirely outside its limits."
            )
            found.append((*_names(names), why))
        if LOOP in named["FAIL"]:
            found.append(("Compensation makes hold-out readings worse than raw, so no model is delivered.",))
        if names := stated["INCONCLUSIVE"]:
            why = ": an interval straddles a limit, or a needed reading is missing."
            found.append(("The data cannot decide ", *_names(names), why))
        if LOOP in named["INCONCLUSIVE"]:
            found.append(("The data cannot show whether compensation improves hold-out readings.",))
        if named["OPEN"]:
            found.append(("No test covers ", *_names(named["OPEN"]), "."))
    else:
        if any(stated.values()):
            by = "by their decision rules" if _named_rule(verification) else "uncertainty included"
            found.append((f"All requirements are met, {by}.",))
        if loop["axes"]:
            found.append(("Compensation improves hold-out readings.",))
    return tuple(part for i, one in enumerate(found) for part in ((" ", *one) if i else one))


def _named_rule(verification: Sequence[Branch]) -> bool:
    """Return whether a contract names a rule in place of the interval."""
    return any(row["decision"] and str(row["decision"]["rule"]) != "interval" for row in verification)


def own_rules(verification: Sequence[Branch], general: str) -> list[tuple[str, str]]:
    """Return the requirements with a rule of their own, and the rule."""
    return [(row["requirement"], row["rule"]) for row in verification if row["rule"] and row["rule"] != general]


def of_decision(verification: Sequence[Branch], verdicts: Sequence[Branch]) -> list[Finding]:
    """Say by which rules requirements were decided, and which verdict is the likeliest to be wrong."""
    rules = dict.fromkeys(row["rule"] for row in verification if row["rule"])
    lines: list[Finding] = []
    for rule in rules:
        mine = [row["requirement"] for row in verification if row["rule"] == rule]
        lines.append((*(("Decision rule",) if len(rules) == 1 else _names(mine)), ": ", rule, "."))
    one = max((one for one in verdicts if one["risk"] is not None), key=lambda row: row["risk"].raw, default=None)
    if one is None:
        return lines
    at: Finding = () if one["at"] is None else (" at ", Figure(one["at"], None, one["at_unit"]))
    ends = [(word, one[key]) for word, key in ((" from ", "accept_lower"), (" up to ", "accept_upper"))]
    parts = [part for word, end in ends if end is not None for part in (word, Figure(end, None, _unit(one["unit"])))]
    accepted: Finding = ("; PASS", *parts) if parts else ()
    ratio: Finding = () if one["ratio"] is None else ("; test uncertainty ratio ", Figure(one["ratio"]))
    lines.append(
        (
            "The verdict most likely to be wrong: ", one["requirement"], " ", one["verdict"],
            " (", one["test"], " ", one["axis"], *at, "), with probability ",
            Figure(one["risk"]), *accepted, *ratio, ".",
        )
    )  # fmt: skip
    return lines


def _names(names: Sequence[str]) -> Finding:
    """Names in a sentence, each isolated."""
    parts: list[str | Figure] = []
    for i, name in enumerate(names):
        parts += ["" if i == 0 else " and " if i == len(names) - 1 else ", ", Text(name)]
    return tuple(parts)


def of_requirements(verification: Sequence[Branch]) -> Finding:
    """Say how many of the rows of the verification matrix came out which way."""
    stated = [row for row in verification if row["requirement"] != LOOP]
    if not stated:
        return ("No requirements stated",)
    tally = [f"{count(n)} {word}" for word in VERDICTS if (n := sum(row["verdict"] == word for row in stated))]
    return (f"{counted(len(stated), 'requirement').capitalize()}: {listed(tally)}",)


def of_budget(rows: Sequence[Branch]) -> Finding:
    """Say which source the variance of a quantity mostly comes from."""
    known = [row for row in rows if row["share"] is not None]
    most = max(known, key=lambda row: row["share"].raw, default=None)
    if most is None:
        return ("No source of uncertainty is known",)
    return ("Mostly ", most["source"], ": ", Figure(most["share"]), " of the variance")


def of_exclusions(rows: Sequence[Branch]) -> Finding:
    """Say how many dwells were left out, where else something was, and by how many rules.

    A row is one dwell, or a place with the count of what was left out there.
    """
    if not rows:
        return ("Nothing was left out",)
    kinds = ("dwell", "row", "sample", "window", "position", "rotation")
    by_kind = {kind: [row for row in rows if str(row["counts"]) == kind] for kind in kinds}
    parts = [counted(len(by_kind["dwell"]), "dwell")] if by_kind["dwell"] else []
    parts += [f"{kind}s at {counted(len(by_kind[kind]), 'place')}" for kind in ("row", "sample") if by_kind[kind]]
    for name, text in (("window", "parts of "), ("position", ""), ("rotation", "")):
        number = sum(int(getattr(row["count"], "raw", row["count"])) for row in by_kind[name])
        parts += [f"{text}{counted(number, name)}"] if number else []
    rules = counted(len({str(row["rule"]) for row in rows}), "stated rule")
    several = len({str(row["test"]) for row in rows}) > 1
    note = "; items left out by several tests count once per test" if several else ""
    text = f"{listed(parts)} left out, by {rules}{note}"
    return (text[:1].upper() + text[1:],)


def of_remarks(remarks: Sequence[Branch]) -> Finding:
    """Say how many remarks there are of each severity."""
    return (severities([str(one["severity"]) for one in remarks]).capitalize(),)


def of_model(model: Branch | None, loop: Branch, condition: str = "") -> Finding:
    """Say whether there is a model, and whether recordings held out, of its condition, have judged it."""
    if model is None:
        return ("No model is delivered",)
    if condition and model["judged"]:
        return ("Model judged on hold-out readings: PASS",)
    if is_open(loop, condition):
        return ("Hold-out readings cannot show whether the model improves them",)
    if not model["judged"]:
        return ("Model not judged on hold-out readings",)
    return ("Model judged on hold-out readings: ", loop["verdict"])


def is_open(loop: Branch, condition: str = "") -> bool:
    """Tell whether readings held out, of a condition where one is named, were too few to judge a model."""
    if not condition:
        return bool(loop["verdict"] == "INCONCLUSIVE")
    every = (*loop["axes"], *loop["over_temperature"])
    return any(row["verdict"] == "INCONCLUSIVE" for row in every if str(row["condition"]) == condition)


def _unit(unit: str) -> str:
    return "" if unit == "1" else Text(unit)


@dataclass(frozen=True)
class Highlight:
    """One of the three most important numbers of a report."""

    label: Finding  # name of the quantity
    figure: Finding  # number with uncertainty and unit
    rule: str  # how it was chosen


def highlights(results: Branch) -> list[Highlight]:
    """Return up to three highlights of results.json, for a campaign in which nothing is required."""
    rows = [row for row in results["results"] if not case_of(row).beside]
    tests = {str(step["test"]) for step in results["sequence"]}
    delivered = [row for row in rows if str(row["test"]) not in tests] or rows  # of the models
    found = [_closed_loop(results["closed_loop"]), _largest_error(delivered)]
    chosen = [one for one in found if one is not None]
    others = () if chosen else dict.fromkeys(str(row["quantity"]) for row in delivered)  # of whatever was tested
    for quantity in dict.fromkeys([*FALLBACKS, *others]):
        every = estimated(delivered, quantity, any_case=True)
        row = largest(every)
        if len(chosen) < 3 and row is not None:
            several = len({str(one["test"]) for one in every}) > 1
            of = f" and tests (here: {clean(str(row['test']))})" if several else ""
            chosen.append(_of_row(row, f"largest {quantity.replace('_', ' ')} of all axes{of}"))
    return chosen


def _closed_loop(loop: Branch) -> Highlight | None:
    axis = worst_axis(loop)
    if axis is None:
        return None
    figure = (Figure(axis["raw_rms"]), " → ", Figure(axis["compensated_rms"], None, axis["unit"]))
    label = ("rms error of ", axis["axis"], ", raw → compensated")
    several = len({str(one["unit"]) for one in loop["axes"]}) > 1
    return Highlight(label, figure, f"hold-out readings, worst axis{' relative to raw' if several else ''}")


def _largest_error(rows: Sequence[Branch]) -> Highlight | None:
    """Return the largest relative error or angle: 1 % counts as much as 0.01 rad."""

    def size(row: Branch) -> float:
        unit = str(row["unit"])
        return abs(float(row["value"].raw)) * factor(unit, "rad" if kind(unit) == "angle" else "1")

    known = [row for quantity in ERRORS for row in estimated(rows, quantity, any_case=True)]
    row = max(known, key=size, default=None)
    return None if row is None else _of_row(row, "largest of all scale factor errors and misalignments")


def _of_row(row: Branch, rule: str) -> Highlight:
    return Highlight((quantity_name(row).replace("_", " "), " ", row["axis"]), (of_row(row),), rule)
