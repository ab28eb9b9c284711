"""Score: do the stated intervals hold the truth? Of one simulated campaign, or of a rig over many seeds.

The rule for many seeds (DESIGN, coverage): seeds in a row, none selected; a quantity passes when the exact 99.9 %
binomial interval of its hit rate holds 95 %, or lies above it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.errors import DataError, UsageError
from ...core.key import PLAIN, At, Case, Key
from ...core.results import Interval, case_of, key_fields, key_of
from ...core.show.rounding import number, with_uncertainty
from ...core.show.rows import quantity_name
from ...core.show.tables import Block, Table, html, text
from ...core.units import convert
from ...rigs import RIGS
from ...rigs.protocol import TrueValue, Twin
from ...statistics.intervals import binomial_interval, contains, covers, t_interval
from ..engine.engine import ReducedTest
from ..outcome.publish import OUT
from ..outcome.results_file import find_results
from .fitted import fitted_tests
from .twin import Of, Truth, known_truth, read_truth, truth_by_key

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
    case = str(case_of(row)._replace(condition=""))
    quantity = f"{quantity_name(row)} ({case})" if case else quantity_name(row)
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
    test : str
        Of which test, where there are several that give it.
    sensor, power, at
        Of the key.
    """

    quantity: str
    axis: str
    hits: int
    n: int
    missing: int
    test: str = ""
    sensor: str = ""
    power: int = 0
    at: At | None = None

    @property
    def key(self) -> Key:
        """What it is of."""
        return Key(self.quantity, self.axis, self.sensor, self.power, self.at)

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
    """Compare the results of a simulated campaign with its truth.

    Raises
    ------
    PlanError
        If there is no campaign in the folder.
    DataError
        ``no_results`` if it was not run; ``stale_results`` if the results are of another campaign; and as
        ``results_file.find_results`` and ``twin.read_truth``.
    """
    truth = read_truth(folder)
    found = find_results(Path(folder) / OUT)
    if found is None:
        what = f"no results in {Path(folder) / OUT}"
        raise DataError(what, do=f"Type first: inertialcal run {folder}", code="no_results")
    results = found.content
    if truth.seal not in str(results.get("campaign", {}).get("source", "")):
        why = "they were made before the campaign was"
        raise DataError(f"{OUT}/results.json is of another campaign", "", why, f"Type: inertialcal run {folder}",
                        "stale_results")  # fmt: skip
    rows = [row for row in results["results"] if _is_result(case_of(row))]
    pairs = [(row, truth.of((key_of(row), row["test"]))) for row in rows]
    return Score(truth, tuple(_scored(row, true) for row, true in pairs if true is not None))


def _is_result(case: Case) -> bool:
    """Whether a figure is a result, at whatever place."""
    return case._replace(condition="", at=None, times=0, sensor="") == PLAIN


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
    held: dict[Of, list[bool]] = {}
    for seed in range(first, first + n):
        if (seed - first) % max(n // STEPS, 1) == 0:
            tell(seed - first, n, f"seed {seed}")
        for name, inside in _held(make(seed)).items():
            held.setdefault(name, []).append(inside)
    tell(n, n, "done")
    return tuple(
        Coverage(key.quantity, key.axis, sum(found), len(found), n - len(found), test, key.sensor, key.power, key.at)
        for (key, test), found in held.items()
    )


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
