"""Score: do the stated intervals hold the truth? Of one simulated campaign, or of a rig over many seeds.

The rule for many seeds (DESIGN, coverage): seeds in a row, none selected; a quantity passes when the exact 99.9 %
binomial interval of its hit rate holds 95 %, or lies above it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from ...core.errors import DataError, InertialcalError, UsageError
from ...core.influence import influence_of
from ...core.key import PLAIN, Case, Key
from ...core.results import Interval, case_of, key_fields, key_of
from ...core.show.rounding import near, with_uncertainty
from ...core.show.rows import quantity_name
from ...core.show.tables import Block, Table, html, text
from ...core.units import convert
from ...files.source import checked_path
from ...rigs import RIGS
from ...rigs.protocol import Rig
from ...rigs.twin import DrawnError, Fault, TrueValue, Twin, parse_fault, size_text
from ...statistics.intervals import binomial_interval, contains, covers, t_interval
from ..engine.engine import ReducedTest
from ..outcome.publish import OUT
from ..outcome.results_file import find_results
from .expected import expected_range
from .faults import Brought, Named, brought_by, brought_from, brought_text, names_fault
from .fitted import fitted_tests
from .standards import apart, entering, standards_text
from .twin import Of, Truth, known_truth, read_truth, truth_by_key, truth_of

RULE = "the exact 99.9 % binomial interval of the hit rate holds 95 %, or lies above it"
P = 0.999
STEPS = 20  # times that progress is told
Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Score:
    """Estimates of a campaign beside the truth.

    Parameters
    ----------
    truth : Truth
        And its seal.
    rows : tuple of dict
        Rows of ``results.json`` of which the truth is known, each with ``truth`` in its unit, ``inside``, and
        ``inside_apart``: the same once the errors of the standards are taken off. None where nothing was estimated.
    fault : Fault, optional
        The mistake in it.
    brought : Brought, optional
        What the campaign brought up.
    unshared : tuple of str
        Standards of the campaign that no figure says to share: they are judged with the figures.
    """

    truth: Truth
    rows: tuple[dict[str, Any], ...]
    fault: Fault | None = None
    brought: Brought = field(default_factory=lambda: Brought(None))
    unshared: tuple[str, ...] = ()

    @property
    def estimated(self) -> int:
        """Number of rows with an interval."""
        return sum(row["inside"] is not None for row in self.rows)

    @property
    def inside(self) -> int:
        """Number of rows whose interval holds the truth."""
        return sum(row["inside"] is True for row in self.rows)

    @cached_property
    def expected(self) -> tuple[int, int]:
        """Least and largest number of such rows in 95 % of campaigns with the errors of these standards."""
        content = self.brought.results or {"covariances": [], "occasions": {}}
        made_of = {name: one["tests"] for name, one in content["occasions"].items()}
        drawn = {one.influence: one.error for one in self.truth.errors}
        rows = [row for row in self.rows if row["inside"] is not None]
        return expected_range(rows, content["covariances"], made_of, drawn)

    @property
    def judged_apart(self) -> int:
        """Number of rows that more than the standards makes uncertain."""
        return sum(row["inside_apart"] is not None for row in self.rows)

    @property
    def inside_apart(self) -> int:
        """Number of rows whose interval holds the truth, apart from the standards."""
        return sum(row["inside_apart"] is True for row in self.rows)

    @property
    def standards(self) -> dict[DrawnError, int]:
        """Errors of the standards that figures share, and how many figures share each."""
        return entering(self.rows, self.truth.errors)

    @property
    def verdict(self) -> str:
        """PASS or FAIL of a campaign with a fault, as its entry expects; empty where it has none."""
        if self.fault is None:
            return ""
        if self.fault.codes and names_fault(self.fault, self.truth.spoiled, self.brought):
            return "PASS"
        if self.fault.expects != "covered":
            return "FAIL"
        sequence = [] if self.brought.results is None else self.brought.results["sequence"]
        tests = {one["test"] for one in sequence if not self.fault.tests or one["procedure"] in self.fault.procedures}
        rows = [row for row in self.rows if row["test"] in tests]
        once = {(row["quantity"], row["axis"], row["value"], row["u"]): row["inside_apart"] for row in rows}
        judged = [inside for inside in once.values() if inside is not None]
        return "PASS" if judged and covers(sum(judged), len(judged)) else "FAIL"

    @property
    def said(self) -> list[str]:
        """What is shown below the table, a line each."""
        lines = [] if self.brought.problems else [self._held()]
        missing = len(self.rows) - self.estimated
        if missing:
            lines.append(f"{missing} not estimated")
        if standards := self.standards:
            lines.append(
                f"{self.inside_apart} of {self.judged_apart} hold it with the errors of the standards taken off"
            )
            lines.append(standards_text(standards))
            if self.unshared:
                lines.append(f"not taken off, for no figure says what it does to it: {', '.join(self.unshared)}")
        if self.fault is not None:
            size = f" = {self.truth.size}" if self.truth.size else ""
            lines.append(
                f"fault {self.truth.fault}{size}: expected {self.fault.expected}; {brought_text(self.brought)}"
            )
            lines.append(f"verdict: {self.verdict}")
        return lines

    def _held(self) -> str:
        low, high = self.expected
        expected = f"{low} to {high} expected, with errors that figures share counted once"
        word = "fewer than" if self.inside < low else "more than" if self.inside > high else "as"
        return f"{self.inside} of {self.estimated} stated 95 % intervals hold the truth; {expected}: {word} expected"

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: estimates beside the truth, how many intervals hold it."""
        caption = f"rig {self.truth.rig}, seed {self.truth.seed}"
        return (truth_grid(self.rows, caption), *self.said)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def truth_grid(rows: Sequence[Mapping[str, Any]], caption: str = "") -> Table:
    """Return estimates beside the truth, a row each."""
    heads = ("test", "quantity", "axis", "estimate ± u", "truth", "unit", "inside")
    return Table(heads, [_cells(row) for row in rows], caption, (3, 4))


def _cells(row: Mapping[str, Any]) -> tuple[str, ...]:
    estimate = with_uncertainty(row["value"], row["u"]) if row["inside"] is not None else "not estimated"
    word = {True: "yes", False: "NO", None: "-"}[row["inside"]]
    case = str(case_of(row)._replace(condition=""))
    quantity = f"{quantity_name(row)} ({case})" if case else quantity_name(row)
    return row["test"], quantity, row["axis"], estimate, near(row["truth"], row["u"]), row["unit"], word


@dataclass(frozen=True)
class Coverage:
    """How often the stated 95 % intervals of one quantity held the truth.

    Parameters
    ----------
    key : Key
        Which.
    hits, n : int
        Intervals that held it, and intervals.
    missing : int
        Campaigns that gave none.
    test : str
        Of which test, where there are several that give it.
    """

    key: Key
    hits: int
    n: int
    missing: int
    test: str = ""

    @property
    def rate(self) -> float | None:
        """Hit rate; None where there was no interval."""
        return self.hits / self.n if self.n else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Exact 99.9 % binomial interval of the hit rate."""
        return binomial_interval(self.hits, self.n, P) if self.n else None

    @property
    def verdict(self) -> str:
        """PASS or FAIL by the rule; FAIL where there was no interval at all."""
        return "PASS" if self.n and covers(self.hits, self.n) else "FAIL"

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``--json`` prints it."""
        interval = self.interval
        return key_fields(self.key) | {
            "test": self.test, "hits": self.hits, "n": self.n, "missing": self.missing,
            "rate": self.rate, "interval": interval and {"lo": interval[0], "hi": interval[1], "p": P},
            "verdict": self.verdict,
        }  # fmt: skip


def score(folder: str | Path) -> Score:
    """Compare the results of a simulated campaign with its truth; one that was not run is run, and nothing written.

    Raises
    ------
    PlanError
        If there is no campaign in the folder.
    DataError
        ``stale_results`` if the results are of another campaign; if the campaign is refused though no fault is in it;
        and as ``results_file.find_results`` and ``twin.read_truth``.
    """
    checked_path(folder, "campaign")
    truth = read_truth(folder)
    fault = RIGS.named(truth.rig).every_fault[truth.fault] if truth.fault else None
    found = find_results(Path(folder) / OUT)
    brought = brought_from(Path(folder)) if found is None else Brought(found.content)
    if brought.problems and fault is None:
        raise DataError(list(brought.problems))
    if brought.results is not None and truth.seal not in str(brought.results["campaign"].get("source", "")):
        why = "they were made before the campaign was"
        raise DataError(f"{OUT}/results.json is of another campaign", "", why, f"Type: inertialcal run {folder}",
                        "stale_results")  # fmt: skip
    return _score(truth, fault, brought)


def _score(truth: Truth, fault: Fault | None, brought: Brought) -> Score:
    """Return what a campaign brought up beside its truth."""
    if brought.results is None:
        return Score(truth, (), fault, brought)
    rows = [row for row in brought.results["results"] if _is_result(case_of(row))]
    pairs = [(row, truth.of((key_of(row), row["test"]))) for row in rows]
    errors = {one.influence: one for one in truth.errors}
    scored = tuple(_scored(row, true, errors) for row, true in pairs if true is not None)
    drawn = {one.influence for one in truth.errors}
    shared = {influence_of(name) for row in scored for name in row["shared"] if name in drawn}
    unshared = tuple(name for name in brought.results["influences"] if name not in shared)
    return Score(truth, scored, fault, brought, unshared)


def _is_result(case: Case) -> bool:
    """Whether a figure is a result, at whatever place."""
    return case._replace(condition="", at=None, times=0, sensor="") == PLAIN


def _scored(row: Mapping[str, Any], true: TrueValue, errors: Mapping[str, DrawnError]) -> dict[str, Any]:
    """Return a row with the truth in its unit, and whether the interval holds it: as it is, apart from standards."""
    value = float(convert([true.value], true.unit, row["unit"])[0])
    interval = row["interval"]
    inside = None if interval is None else bool(interval["lo"] <= value <= interval["hi"])
    left = None if interval is None else apart(row, value, errors)
    return dict(row) | {"truth": value, "inside": inside, "inside_apart": left}


@dataclass(frozen=True)
class FaultScore:
    """How a rig with a fault does over many seeds: named, or covered.

    Parameters
    ----------
    fault : Fault
        Its entry.
    name, size : str
        As it was typed; the size with its unit.
    named : Named
        Campaigns that name it; of a fault that needs no naming, those that were not refused.
    coverage : tuple of Coverage
        Of each quantity, where the intervals must hold the truth.
    """

    fault: Fault
    name: str
    size: str
    named: Named
    coverage: tuple[Coverage, ...] = ()

    @property
    def verdict(self) -> str:
        """PASS where it is named, or covered, as expected."""
        verdicts = {self.named.verdict, *(one.verdict for one in self.coverage)}
        return "FAIL" if "FAIL" in verdicts else "PASS"


def score_fault(rig: str, fault: str, n: int, first: int = 1, progress: Progress | None = None) -> FaultScore:
    """Return how often a rig with a fault does what the entry of the fault expects, over seeds in a row.

    Parameters
    ----------
    rig, n, first, progress
        As in `score_rig`.
    fault : str
        Name, or name and size.

    Raises
    ------
    UsageError
        As in `score_rig`, or if there is no such fault, or its size is wrong.
    """
    made = _counted(rig, n, first)
    name, size = parse_fault(fault, made.every_fault)
    one = made.every_fault[name]
    shown = "" if size is None else size_text(size, one.unit)
    tell = progress or (lambda done, total, what: None)

    def make(seed: int) -> Twin:
        return made.twin(seed, fault)

    if one.codes:
        return FaultScore(one, name, shown, _counted_seeds(make, one, n, first, tell))
    refused = Counter[str]()
    found = coverage(make, n, first, tell, refused)
    return FaultScore(one, name, shown, Named(n - sum(refused.values()), n, dict(refused)), found)


def _counted_seeds(make: Callable[[int], Twin], fault: Fault, n: int, first: int, tell: Progress) -> Named:
    """Return how many campaigns of seeds in a row do as the entry of their fault expects."""
    others = Counter[str]()
    for seed in range(first, first + n):
        tell(seed - first, n, f"seed {seed}")
        twin = make(seed)
        brought = brought_by(twin)
        if _score(truth_of(twin), fault, brought).verdict == "FAIL":
            others[brought_text(brought)] += 1
    tell(n, n, "done")
    return Named(n - sum(others.values()), n, dict(others.most_common()))


def _counted(rig: str, n: int, first: int) -> Rig:
    """Return a rig of which so many campaigns can be counted."""
    made = RIGS.named(rig)
    if n < 1 or first < 0:
        raise UsageError(f"{n} campaigns from seed {first}: need 1 or more, from seed 0 or more")
    return made


def score_rig(rig: str, n: int, first: int = 1, progress: Progress | None = None) -> tuple[Coverage, ...]:
    """Return the coverage of every quantity of a rig, over seeds in a row, all in memory.

    Parameters
    ----------
    rig : str
        Name in the registry of rigs.
    n : int
        Campaigns.
    first : int
        Seed of the first; the others follow.
    progress : callable, optional
        Called with (campaigns done, in all, what comes next).

    Raises
    ------
    UsageError
        If there is no such rig, the package that adds it is broken, or there is nothing to count.
    """
    return coverage(_counted(rig, n, first).twin, n, first, progress)


def coverage(
    make: Callable[[int], Twin],
    n: int,
    first: int = 1,
    progress: Progress | None = None,
    refused: Counter[str] | None = None,
) -> tuple[Coverage, ...]:
    """Return the coverage of every quantity over n campaigns.

    Parameters
    ----------
    make : callable
        Seed -> twin.
    n, first : int
        Number of seeds, and the first of them.
    progress : callable, optional
        As in `score_rig`.
    refused : Counter, optional
        Gets why campaigns were refused; without it that is an error.
    """
    tell = progress or (lambda done, total, what: None)
    held: dict[Of, list[bool]] = {}
    for seed in range(first, first + n):
        if (seed - first) % max(n // STEPS, 1) == 0:
            tell(seed - first, n, f"seed {seed}")
        try:
            found = _held(make(seed))
        except InertialcalError as error:
            if refused is None:
                raise
            refused[brought_text(Brought(None, error.problems))] += 1
            continue
        for name, inside in found.items():
            held.setdefault(name, []).append(inside)
    tell(n, n, "done")
    return tuple(Coverage(key, sum(hits), len(hits), n - len(hits), test) for (key, test), hits in held.items())


def _held(twin: Twin) -> dict[Of, bool]:
    """Whether the interval of each quantity whose truth is known holds it; of one test where the truth is of one."""
    found = {}
    values = truth_by_key(twin.truth)
    for one in fitted_tests(twin):
        for key, interval in _intervals(one):
            true = known_truth(values, (key, one.test.id))
            if true is not None:
                found[true.key, true.test] = contains(interval, true.value)
    return found


def _intervals(one: ReducedTest) -> Iterator[tuple[Key, Interval]]:
    """Yield the intervals of a test, SI."""
    rows = one.procedure.truths(one.result)
    if rows is not None:
        for row in (*rows, *one.against):
            if row.interval is not None and _is_result(row.case):
                yield row.key, row.interval
        return
    estimate = one.result.estimate
    if estimate is None:
        return
    for key, value, u, dof in zip(estimate.keys, estimate.values, estimate.u, estimate.dof, strict=True):
        shown = one.procedure.called(one.result, key)
        if shown.at is None:
            yield shown, t_interval(float(value), float(u), float(dof))
