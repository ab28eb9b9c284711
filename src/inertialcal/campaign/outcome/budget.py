"""Uncertainty budgets of a campaign, and which source must improve to reach a wanted uncertainty.

Sources are independent, so that ``u^2`` is the sum of their squares. To reach ``v``, one source alone must go to
``sqrt(v^2 - rest^2)``; where the rest is not below v, the largest together, all by one factor. A standard improves by a
better certificate; scatter by the root of the number of repeats (four times as many runs halve it), where repeats
are independent and as many at each place. What is not in the budget is not in the advice: an effect that no standard
states, or one that does not average (flicker between dwells), stays.

References
----------
.. [1] JCGM 100:2008 (GUM), clause 5.1.2.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...core.errors import DataError, UsageError
from ...core.results import Interval, case_of, key_of
from ...core.show.result_tables import degrees
from ...core.show.rounding import dof, number, rounded_down, settled_u
from ...core.show.rows import quantity_name
from ...core.show.tables import Block, Table, html, text
from ...core.units import Quantity, factor, parse_quantity, same_dimension
from ...files.source import checked_path
from .results_file import find_results

MOST = 20.0  # by how much a source may have to improve, to be advised
LEAST = 1e-3  # share of the variance below which a source is not shown
Of = tuple[str, Any]  # test and key of a figure


@dataclass(frozen=True)
class Change:
    """What one source must become."""

    source: str  # In words
    influence: str  # ``"rate_table.rate"``; empty for scatter
    level: str  # What was repeated; empty for a standard
    u_from: float  # Of the standard as stated; of scatter, its contribution
    u_to: float
    unit: str

    @property
    def times(self) -> float:
        """How many times as many repeats, for scatter."""
        return (self.u_from / self.u_to) ** 2

    def __str__(self) -> str:
        """Return it in words."""
        if self.influence:
            to = settled_u(rounded_down(self.u_to))  # what is typed back must suffice
            return f"{self.influence} from {settled_u(self.u_from)} to {to} {_shown(self.unit)}".strip()
        repeats = "repeats" if self.level in ("", "hidden") else f"{self.level.removesuffix('s')}s"
        repeats = repeats.removeprefix("between_").removeprefix("within_")
        return f"{self.source}: {_times(self.times)} times as many {repeats}"

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        return {
            "source": self.source, "influence": self.influence, "level": self.level, "from": self.u_from,
            "to": self.u_to, "unit": self.unit, "times": None if self.influence else self.times,
        }  # fmt: skip


@dataclass(frozen=True)
class Advice:
    """Whether an uncertainty is reached, and what would reach it."""

    u: float
    wanted: float
    unit: str
    alone: tuple[Change, ...]  # Any of these suffices
    together: tuple[Change, ...]  # Where none does: all of these
    scatter: float  # What scatter alone gives

    @property
    def reached(self) -> bool:
        """Whether u is as small as wanted."""
        return self.u <= self.wanted

    def __str__(self) -> str:
        """Return it in words."""
        if self.reached:
            return "reached"
        if self.alone:
            return "; or ".join(f"{one} would suffice" for one in self.alone)
        if not self.together:
            return f"{_times(self.u / self.wanted)} times smaller than now"
        floor = ""
        if self.scatter >= self.wanted:
            floor = (
                f"no better standard would suffice, scatter alone gives {settled_u(self.scatter)} {_shown(self.unit)}; "
            )
        needed = " and ".join(map(str, self.together))
        return f"{floor}{needed}" if len(self.together) == 1 else f"{floor}no source would suffice alone: {needed}"


@dataclass(frozen=True)
class Budgeted:
    """A figure with its sources of uncertainty, the largest first."""

    row: Mapping[str, Any]  # Of ``results``
    sources: tuple[Mapping[str, Any], ...]  # Of ``budgets``
    certificates: tuple[str, ...]  # One a source
    advice: Advice | None = None  # Where an uncertainty is wanted

    @property
    def name(self) -> str:
        """Quantity and axis."""
        return f"{quantity_name(self.row)} {self.row['axis']}".strip()

    def to_dict(self) -> dict[str, Any]:
        """Return the figure as ``--json`` prints it."""
        said = None
        if (one := self.advice) is not None:
            said = {
                "wanted": one.wanted, "reached": one.reached, "alone": [each.to_dict() for each in one.alone],
                "together": [each.to_dict() for each in one.together], "scatter": one.scatter, "text": str(one),
            }  # fmt: skip
        names = ("test", "quantity", "axis", "sensor", "power", "at", "u", "unit", "dof")
        figure = {name: self.row[name] for name in names}
        listed = [dict(one) | {"certificate": of} for one, of in zip(self.sources, self.certificates, strict=True)]
        return figure | {"sources": listed, "advice": said}


@dataclass(frozen=True)
class Budgets:
    """Budgets of a campaign that was run."""

    path: str  # Of the results
    sha256: str
    figures: tuple[Budgeted, ...]  # Test by test
    undecided: tuple[str, ...]  # What would decide requirements that are INCONCLUSIVE

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: sources test by test, what reaches what is wanted, what would decide."""
        return (*self.tables, *self.said)

    @property
    def tables(self) -> list[Table]:
        """Sources, test by test."""
        tables = []
        for test in dict.fromkeys(one.row["test"] for one in self.figures):
            rows = [line for one in self.figures if one.row["test"] == test for line in _lines(one)]
            heads = ("quantity", "source", "u", "unit", "share", "dof", "standard", "certificate")
            tables.append(Table(heads, rows, str(test), (2, 4, 5)))
        return tables

    @property
    def said(self) -> list[str]:
        """What reaches what is wanted, and what would decide requirements, a line each."""
        lines = []
        for one in self.figures:
            if (found := one.advice) is not None:
                now = f"u = {settled_u(found.u)} {_shown(found.unit)}".strip()
                aim = f"wanted {number(found.wanted)} {_shown(found.unit)}".strip()
                lines.append(f"{one.row['test']}, {one.name}: {now}, {aim}: {found}")
        return [*lines, *self.undecided]

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def budget(path: str | os.PathLike[str], wanted: Sequence[str] | str = (), test: str | None = None) -> Budgets:
    """Return the uncertainty budgets of a campaign that was run, and what must improve.

    Parameters
    ----------
    path : path
        Folder of the campaign, its ``out/`` or ``results.json``.
    wanted : sequence of str
        Standard uncertainties to reach: ``"scale_factor_error=0.02 %"``; budgets of these quantities alone.
    test : str, optional
        Budgets of this test alone; ``"model"`` for the model.

    Raises
    ------
    DataError
        ``no_results`` if there are none, ``no_budget`` if no figure has one of that test or quantity,
        ``unit_mismatch``; and as ``results_file.find_results``.
    UsageError
        ``wanted``, if one cannot be read.
    """
    aims = _wanted([wanted] if isinstance(wanted, str) else wanted)
    found = find_results(checked_path(path, "campaign"), of_campaign=True)
    if found is None:
        run = f"Type: inertialcal run {path}"
        do = "Name the folder of a campaign, or its results.json" if os.path.isfile(path) else run
        raise DataError(f"no results: {path}", do=do, code="no_results")
    content = found.content
    chosen = [
        one
        for one in budgeted(content)
        if test in (None, one.row["test"]) and (not aims or quantity_name(one.row) in aims)
    ]
    if not chosen:
        every = budgeted(content)
        of_test = [one for one in every if test in (None, one.row["test"])]
        have = dict.fromkeys(quantity_name(one.row) if of_test else one.row["test"] for one in of_test or every)
        what = " ".join(["no budget", *([f"of test {test!r}"] if test else []), *(f"of {name}" for name in aims)])
        each = "budgets of" if of_test else "budgets of tests"
        do = f"There are {each}: {', '.join(have)}" if have else "No figure has sources of uncertainty"
        raise DataError(what, str(path), do=do, code="no_budget")
    figures = tuple(_advised(one, aims.get(quantity_name(one.row))) for one in chosen)
    lines = [
        f"{one['requirement']}, {one['test']} {one['axis']}: {one['reason']}"
        for one in content.get("verdicts", [])
        if one["verdict"] == "INCONCLUSIVE" and one["deciding_u"] is not None
    ]
    return Budgets(found.path, found.sha256, figures, tuple(lines))


def budgeted(content: Mapping[str, Any]) -> list[Budgeted]:
    """Return the figures that have a budget, in the order of the results.

    Parameters
    ----------
    content : mapping
        Of ``results.json``.
    """
    sources: dict[Of, list[Mapping[str, Any]]] = {}
    for one in content["budgets"]:
        sources.setdefault((one["test"], key_of(one)), []).append(one)
    influences = content["influences"]
    found = []
    for row in content["results"]:
        mine = sources.get((row["test"], key_of(row)), [])
        if mine and case_of(row)._replace(at=None, times=0).plain and row["u"]:
            mine = sorted(mine, key=lambda one: -one["u"])
            certificates = (influences.get(one["influence"], {}).get("certificate", "") for one in mine)
            found.append(Budgeted(row, tuple(mine), tuple(certificates)))
    return found


def advice(sources: Sequence[Mapping[str, Any]], wanted: float, unit: str) -> Advice:
    """Return what would make the uncertainty of a figure as small as wanted.

    Parameters
    ----------
    sources : sequence of mapping
        Rows of its budget.
    wanted : float
        Standard uncertainty, in their unit.
    unit : str
        Of the figure.
    """
    ordered = sorted(sources, key=lambda one: -one["u"])
    squares = [float(one["u"]) ** 2 for one in ordered]
    total = math.fsum(squares)
    scatter = math.sqrt(math.fsum(s for s, one in zip(squares, ordered, strict=True) if one["kind"] == "A"))

    def shrunk(chosen: Sequence[int]) -> tuple[Change, ...]:
        own = math.fsum(squares[i] for i in chosen)
        left = wanted**2 - math.fsum(s for i, s in enumerate(squares) if i not in chosen)
        if not (own > 0.0 and left > own / MOST**2):
            return ()
        return tuple(_change(ordered[i], math.sqrt(left / own)) for i in chosen)

    u = math.sqrt(total)
    if u <= wanted:
        return Advice(u, wanted, unit, (), (), scatter)
    alone = tuple(change for i in range(len(ordered)) for change in shrunk([i]))
    fewest = (shrunk(range(n)) for n in range(2, len(ordered) + 1))
    together = () if alone else next((found for found in fewest if found), ())
    return Advice(u, wanted, unit, alone, together, scatter)


def _change(source: Mapping[str, Any], share: float) -> Change:
    stated = source["stated_u"] if source["influence"] and source["stated_u"] else None
    size, unit = (source["u"], source["unit"]) if stated is None else (stated, source["stated_unit"])
    return Change(source["source"], source["influence"], source["level"], size, size * share, unit)


def deciding_u(
    value: float | None, u: float | None, compared: Interval | None, lower: float | None, upper: float | None
) -> float | None:
    """Return the standard uncertainty that would decide a requirement at this value; None where none would.

    Parameters
    ----------
    value, u : float or None
        What was measured.
    compared : Interval or None
        Value with its guard band, which is in proportion to u.
    lower, upper : float or None
        Limits.
    """
    if value is None or not u or compared is None or compared.lo is None or compared.hi is None:
        return None
    low, high = value - compared.lo, compared.hi - value  # guard bands
    if not (0.0 < low < math.inf and 0.0 < high < math.inf):
        return None
    if upper is not None and value > upper:
        return u * (value - upper) / low
    if lower is not None and value < lower:
        return u * (lower - value) / high
    rooms = [] if lower is None else [(value - lower) / low]
    rooms += [] if upper is None else [(upper - value) / high]
    return u * min(rooms) or None


def _wanted(texts: Sequence[str]) -> dict[str, Quantity]:
    found = {}
    for given in texts:
        name, _, size = given.partition("=")
        do = 'Write it like "scale_factor_error=0.02 %"'
        try:
            found[name.strip()] = parse_quantity(size)
        except DataError as error:
            raise UsageError(f"wanted {given!r}: {error.problems[0].what}", do=do, code="wanted") from None
        if not found[name.strip()].value > 0.0 or not name.strip():
            raise UsageError(f"wanted {given!r}: need a quantity and a number above zero", do=do, code="wanted")
    return found


def _advised(one: Budgeted, wanted: Quantity | None) -> Budgeted:
    unit = str(one.row["unit"])
    if wanted is None:
        return one
    if not same_dimension(wanted.unit, unit):
        what = f"wanted {one.row['quantity']} = {wanted}: the figure is in {unit!r}"
        raise DataError(what, do=f"Give it in {unit}", code="unit_mismatch")
    size = wanted.value * factor(wanted.unit, unit, difference=True)
    return Budgeted(one.row, one.sources, one.certificates, advice(one.sources, size, unit))


def _lines(one: Budgeted) -> Iterator[tuple[str, ...]]:
    name = one.name
    shown = [pair for pair in zip(one.sources, one.certificates, strict=True) if pair[0]["share"] >= LEAST]
    for source, certificate in shown:
        stated = "" if not source["influence"] else source["influence"]
        if source["influence"] and source["stated_u"] is not None:
            stated += f" {settled_u(source['stated_u'])} {_shown(source['stated_unit'])}"
        share = f"{100.0 * source['share']:.3g} %"
        yield (
            name,
            source["source"],
            settled_u(source["u"]),
            source["unit"],
            share,
            dof(source["dof"]),
            stated.strip(),
            certificate,
        )
        name = ""
    row = one.row
    rest = len(one.sources) - len(shown)
    yield (name, f"combined{f', {rest} more below 0.1 %' if rest else ''}", settled_u(row["u"]), row["unit"], "",
           degrees(row), "", "")  # fmt: skip


def _times(ratio: float) -> str:
    return f"{float(f'{ratio:.2g}'):g}"


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit
