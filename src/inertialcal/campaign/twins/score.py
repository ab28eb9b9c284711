"""Score: do the stated intervals hold the truth? Of one simulated campaign, or of a rig over many seeds.

The rule for many seeds (DESIGN, coverage): seeds in a row, none selected; a quantity passes when the exact 99.9 %
binomial interval of its hit rate overlaps 93 to 97 %.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.errors import DataError, UsageError
from ...core.key import case_of
from ...core.results import Interval
from ...core.show.rounding import number, with_uncertainty
from ...core.show.tables import Block, Table, html, text
from ...core.units import convert
from ...rigs import RIGS
from ...rigs.protocol import TrueValue, Twin
from ...statistics.intervals import binomial_interval, contains, covers, t_interval
from ..engine.engine import ReducedTest
from ..outcome.publish import OUT, previous
from .fitted import fitted_tests
from .twin import Key, Truth, known_truth, read_truth, truth_by_key

RULE = "the exact 99.9 % binomial interval of the hit rate overlaps 93 to 97 %"
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
        Rows of ``results.json`` of which the truth is known, each with ``truth`` in its unit and ``inside``; None
        where nothing was estimated.
    """

    truth: Truth
    rows: tuple[dict[str, Any], ...]

    @property
    def estimated(self) -> int:
        """Number of rows with an interval."""
        return sum(row["inside"] is not None for row in self.rows)

    @property
    def inside(self) -> int:
        """Number of rows whose interval holds the truth."""
        return sum(row["inside"] is True for row in self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: estimates beside the truth, how many intervals hold it."""
        missing = len(self.rows) - self.estimated
        said = f"{self.inside} of {self.estimated} stated 95 % intervals hold the truth"
        caption = f"rig {self.truth.rig}, seed {self.truth.seed}"
        return (truth_grid(self.rows, caption), said, *((f"{missing} not estimated",) if missing else ()))

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
    sensor = case_of(row["condition"]).sensor
    quantity = f"{row['quantity']} ({sensor})" if sensor else row["quantity"]
    return row["test"], quantity, row["axis"], estimate, number(row["truth"]), row["unit"], word


@dataclass(frozen=True)
class Coverage:
    """How often the stated 95 % intervals of one quantity held the truth.

    Parameters
    ----------
    quantity, axis : str
        Which.
    hits, n : int
        Intervals that held it, and intervals.
    missing : int
        Campaigns that gave none.
    test, condition : str
        Of which test, where there are several that give it, and under which condition.
    """

    quantity: str
    axis: str
    hits: int
    n: int
    missing: int
    test: str = ""
    condition: str = ""

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
        return {
            "quantity": self.quantity, "axis": self.axis, "test": self.test, "condition": self.condition,
            "hits": self.hits, "n": self.n, "missing": self.missing,
            "rate": self.rate, "interval": interval and {"lo": interval[0], "hi": interval[1], "p": P},
            "verdict": self.verdict,
        }  # fmt: skip


def score(folder: str | Path) -> Score:
    """Compare the results of a simulated campaign with its truth.

    Raises
    ------
    PlanError
        If there is no campaign in the folder.
    DataError
        ``no_results`` if it was not run; ``stale_results`` if the results are of another campaign; and as
        ``twin.read_truth``.
    """
    truth = read_truth(folder)
    results = previous(Path(folder))
    if results is None:
        what = f"no results in {Path(folder) / OUT}"
        raise DataError(what, do=f"Type first: inertialcal run {folder}", code="no_results")
    if truth.seal not in str(results.get("campaign", {}).get("source", "")):
        why = "they were made before the campaign was"
        raise DataError(f"{OUT}/results.json is of another campaign", "", why, f"Type: inertialcal run {folder}",
                        "stale_results")  # fmt: skip
    conditions = {step["test"]: step["condition"] for step in results["sequence"]}
    rows = [row for row in results["results"] if not case_of(row["condition"]).beside]
    pairs = [(row, truth.of(_key(row, conditions))) for row in rows]
    return Score(truth, tuple(_scored(row, true) for row, true in pairs if true is not None))


def _key(row: Mapping[str, Any], conditions: Mapping[str, str]) -> Key:
    """Return what a row is: a condition that is that of its whole test is none of its own."""
    own = row["condition"] if row["condition"] != conditions.get(row["test"], "") else ""
    return row["quantity"], row["axis"], row["test"], own


def _scored(row: Mapping[str, Any], true: TrueValue) -> dict[str, Any]:
    """Return a row with the truth in its unit, and whether the interval holds it."""
    value = float(convert([true.value], true.unit, row["unit"])[0])
    interval = row["interval"]
    inside = None if interval is None else bool(interval["lo"] <= value <= interval["hi"])
    return dict(row) | {"truth": value, "inside": inside}


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
    made = RIGS.named(rig)
    if n < 1 or first < 0:
        raise UsageError(f"{n} campaigns from seed {first}: need 1 or more, from seed 0 or more")
    return coverage(made.twin, n, first, progress)


def coverage(
    make: Callable[[int], Twin], n: int, first: int = 1, progress: Progress | None = None
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
    """
    tell = progress or (lambda done, total, what: None)
    held: dict[Key, list[bool]] = {}
    for seed in range(first, first + n):
        if (seed - first) % max(n // STEPS, 1) == 0:
            tell(seed - first, n, f"seed {seed}")
        for name, inside in _held(make(seed)).items():
            held.setdefault(name, []).append(inside)
    tell(n, n, "done")
    return tuple(
        Coverage(quantity, axis, sum(found), len(found), n - len(found), test, condition)
        for (quantity, axis, test, condition), found in held.items()
    )


def _held(twin: Twin) -> dict[Key, bool]:
    """Whether the interval of each quantity whose truth is known holds it; of one test where the truth is of one."""
    found = {}
    values = truth_by_key(twin.truth)
    for one in fitted_tests(twin):
        for key, interval in _intervals(one):
            true = known_truth(values, key)
            if true is not None:
                found[true.quantity, true.axis, true.test, true.condition] = contains(interval, true.value)
    return found


def _intervals(one: ReducedTest) -> Iterator[tuple[Key, Interval]]:
    """Yield the intervals of a test, SI."""
    rows = one.procedure.truths(one.result)
    if rows is not None:
        for row in (*rows, *one.against):
            if row.interval is not None and not row.case.beside:
                yield (row.quantity, row.axis, one.test.id, str(row.case)), row.interval
        return
    estimate = one.result.estimate
    if estimate is None:
        return
    for key, value, u, dof in zip(estimate.keys, estimate.values, estimate.u, estimate.dof, strict=True):
        shown = one.procedure.called(one.result, key)
        if shown.at is None:
            yield (shown.name, shown.axis, one.test.id, ""), t_interval(float(value), float(u), float(dof))
