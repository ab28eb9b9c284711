"""Score of a simulated lot: the figures of every test, the population's, and what was named, against the sealed truth.

Each interval of each test is judged twice: as it stands, and with the error of its station taken off, which all units
of the station share: by the first a station that is off makes all its units miss together, by the second the tests are
independent, and the house's rule for coverage judges them. Tests that a mistake was put into are not counted; whether
they were named is told instead. The truth is ``.truth/truth.json`` of the lot, which `lot` does not read; its SHA-256
stands in the title of the lot, and so in what `lot` wrote.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ..campaign.twins.score import Score
from ..campaign.twins.score import score as score_campaign
from ..campaign.twins.twin import TRUTH
from ..core.errors import DataError
from ..core.estimate import Array
from ..core.key import AXES, Method
from ..core.results import Interval
from ..core.show.rounding import number
from ..core.show.tables import Block, Table, html, text
from ..files.own import LOT_DONE, own
from ..files.source import checked_path
from ..files.source import load as read_file
from ..statistics.intervals import contains, covers, t_interval, t_quantile
from .publish import PROVENANCE
from .table import ASSEMBLED
from .twin import POPULATION, REFERENCE

WHAT = ("mean", "scatter")  # of a population
MOST_POWER = 2  # of the law that the units have; higher ones are chosen where noise looks like them
TERMS = ("bias", "bias_temperature_1", "bias_temperature_2")  # of the law of a bias over temperature
LEAST = 1e-6  # of u that a station shares: below it there is nothing to take off
Figure = tuple[str, str, str, int, float | None]  # Test, quantity, axis, power, at


@dataclass(frozen=True)
class Held:
    """How many tests of units have an interval of a figure that holds the truth."""

    figure: Figure
    n: int
    inside: int
    apart: int  # With the error of the station taken off
    mistaken: str = ""  # Mistake of the lot by which it is not judged

    @property
    def verdict(self) -> str:
        """PASS or FAIL by the rule for coverage; empty where a mistake in the lot makes intervals miss."""
        return "" if self.mistaken else "PASS" if covers(self.apart, self.n) else "FAIL"

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``--json`` prints it."""
        test, quantity, axis, power, at = self.figure
        return {"test": test, "quantity": quantity, "axis": axis, "power": power, "at": at, "n": self.n,
                "inside": self.inside, "inside_apart": self.apart, "mistake": self.mistaken,
                "verdict": self.verdict}  # fmt: skip


@dataclass(frozen=True)
class OfPopulation:
    """A figure of the population beside the truth."""

    figure: Figure
    what: str  # "mean" or "scatter"
    value: float | None
    interval: Interval
    truth: float
    unit: str

    @property
    def inside(self) -> bool:
        """Whether the interval holds the truth."""
        return contains(self.interval, self.truth)

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``--json`` prints it."""
        test, quantity, axis, power, at = self.figure
        ends = {"lo": self.interval.lo, "hi": self.interval.hi, "p": self.interval.p}
        return {"test": test, "quantity": quantity, "axis": axis, "power": power, "at": at, "what": self.what,
                "value": self.value, "interval": ends, "truth": self.truth, "unit": self.unit,
                "inside": self.inside}  # fmt: skip


@dataclass(frozen=True)
class Found:
    """A mistake that was put in: in what it is, which of these were named, and what was named beside."""

    mistake: str
    put_in: tuple[str, ...]
    named: tuple[str, ...]
    beside: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """PASS where all of it was named."""
        return "PASS" if set(self.put_in) <= set(self.named) else "FAIL"

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``--json`` prints it."""
        return {"mistake": self.mistake, "put_in": list(self.put_in), "named": list(self.named),
                "beside": list(self.beside), "verdict": self.verdict}  # fmt: skip


@dataclass(frozen=True, eq=False)
class LotScore:
    """A lot beside its truth.

    Parameters
    ----------
    lot, seal : str
        Its name; SHA-256 of the truth.
    units, tests : int
        How many.
    held : tuple of Held
        Of each figure whose truth is known.
    population : tuple of OfPopulation
        Mean and scatter of each.
    found : tuple of Found
        Of each mistake.
    beside : tuple of str
        What was named of which nothing was put in.
    """

    lot: str
    seal: str
    units: int
    tests: int
    held: tuple[Held, ...]
    population: tuple[OfPopulation, ...]
    found: tuple[Found, ...]
    beside: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """FAIL where the intervals of a figure do not keep their promise, or a mistake was not named; else PASS."""
        verdicts = {*(one.verdict for one in self.held), *(one.verdict for one in self.found)}
        return "FAIL" if "FAIL" in verdicts else "PASS"

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` prints it."""
        return {
            "lot": self.lot, "truth_sha256": self.seal, "units": self.units, "tests": self.tests,
            "results": [one.to_dict() for one in self.held], "population": [one.to_dict() for one in self.population],
            "mistakes": [one.to_dict() for one in self.found], "beside": list(self.beside), "verdict": self.verdict,
        }  # fmt: skip

    @property
    def said(self) -> list[str]:
        """What is shown below the tables, a line each."""
        inside = sum(one.inside for one in self.population)
        n, held, apart = (sum(getattr(one, name) for one in self.held) for name in ("n", "inside", "apart"))
        return [
            f"{held} of {n} stated 95 % intervals of tests hold the truth; {apart} with the errors of the stations "
            "taken off, by which they are judged",
            f"{inside} of {len(self.population)} intervals of the population hold it",
            "named, though nothing of it was put in: " + ("; ".join(self.beside) or "nothing"),
            f"verdict: {self.verdict}",
        ]

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a quantity, its axes together; what of the population is missed; the mistakes."""
        rows: dict[str, tuple[list[Held], list[OfPopulation]]] = {}
        for one in self.held:
            rows.setdefault(_name(one.figure), ([], []))[0].append(one)
        for each in self.population:
            rows.setdefault(_name(each.figure), ([], []))[1].append(each)
        cells = []
        for name, (held, population) in rows.items():
            counts = [str(sum(getattr(one, count) for one in held)) for count in ("n", "inside", "apart")]
            words = [sum(one.inside for one in population if one.what == what) for what in WHAT]
            axes = [sum(one.what == what for one in population) for what in WHAT]
            of = [f"{inside} of {n}" if n else "-" for inside, n in zip(words, axes, strict=True)]
            verdicts = {one.verdict for one in held}
            word = "FAIL" if "FAIL" in verdicts else "PASS" if "PASS" in verdicts else held[0].mistaken if held else "-"
            cells.append((name, *counts, *of, word))
        heads = ("figure", "tests", "hold it", "station off", *WHAT, "verdict")
        caption = f"{self.lot}: {self.units} units, {self.tests} tests; 95 % intervals that hold the truth"
        missed = [_missed(one) for one in self.population if not one.inside]
        found = [(one.mistake, _few(one.put_in), _few(one.named), _few(one.beside), one.verdict) for one in self.found]
        mistakes = Table(("mistake", "in", "named", "others named", "verdict"), found, "mistakes put in")
        shown = Table(heads, cells, caption, (1, 2, 3, 4, 5))
        return (shown, *missed, *([mistakes] if found else []), *self.said)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def score(folder: str | Path) -> Score | LotScore:
    """Compare the results of a simulated campaign, or of a simulated lot, with the sealed truth.

    Parameters
    ----------
    folder : path
        Of the campaign; of a lot that of what `lot` wrote.

    Raises
    ------
    PlanError, DataError
        As ``campaign.twins.score.score``; ``no_truth``, ``seal_broken``, ``damaged_truth``, ``no_results`` of a lot.
    """
    given = Path(checked_path(folder, "campaign"))
    known = own(given)
    if known is None or known.what == "a campaign":
        return score_campaign(given)
    if known.file != LOT_DONE:
        what, do = f"{given} is {known.what}: `score` takes what `lot` wrote", f"Type: {known.do}, then score that"
        raise DataError(what, do=do, code="no_results")
    return score_lot(given if given.is_dir() else given.parent)


def score_lot(folder: Path) -> LotScore:
    """Compare what `lot` wrote with the truth of its lot.

    Raises
    ------
    DataError
        ``no_truth`` if it is no simulated lot, or that is not where it was; ``seal_broken``, ``damaged_truth``.
    """
    content = json.loads(read_file(folder / LOT_DONE, document=True).data)
    seal, truth = _truth(folder, str(content["title"]))
    tests = _tests([folder / one["file"] for one in content["parts"]])
    broken = {(str(serial), int(again)) for every in truth["broken"].values() for serial, again in every}
    whole = [(serial, again) not in broken for serial, again in zip(tests.serials, tests.again, strict=True)]
    statistics = content["statistics"]
    if statistics is None:
        do = "Resume the lot: its statistics are made again"
        raise DataError("the statistics of this lot failed", str(folder / LOT_DONE), do=do, code="no_results")
    found, beside = _found(truth, statistics, tests)
    population = [one for row in statistics["figures"] for one in _population(row, truth["faults"])]
    return LotScore(
        str(content["id"]), seal, int(truth["n"]), len(tests.serials), tuple(_held(tests, np.array(whole), truth)),
        tuple(population), found, beside,
    )  # fmt: skip


def _truth(folder: Path, title: str) -> tuple[str, dict[str, Any]]:
    said = json.loads(read_file(folder / PROVENANCE, document=True).data)
    lot = Path(str(said["lot"]))
    path = (lot if lot.is_dir() else lot.parent) / TRUTH
    if not path.is_file():
        why = "only a lot of `simulate lot` can be scored, as long as its folder is where it was"
        do = "Try: inertialcal simulate lot -o DIR"
        raise DataError(f"no truth: {path} does not exist", why=why, do=do, code="no_truth")
    loaded = read_file(path, document=True)
    if loaded.sha256 not in title:
        what = f"the truth has SHA-256 {loaded.sha256[:12]}..., the title of the lot names another"
        why, do = "it was changed, or belongs to another lot", "Simulate the lot again from its seed"
        raise DataError(what, str(path), why, do, "seal_broken")
    try:
        content = json.loads(loaded.data)
        return loaded.sha256, {
            name: content[name] for name in ("n", "faults", "stations", "odd_units", "broken", "units")
        }
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise DataError(f"not a truth of a lot: {error}", str(path), code="damaged_truth") from None


@dataclass(frozen=True, eq=False)
class _Tests:
    """Tests of units, and their figures: row of the test, figure, value, u, dof, common, lo, hi."""

    serials: list[str]
    again: list[int]
    stations: list[str]
    statuses: list[str]
    verdicts: list[str]
    figures: Mapping[Figure, tuple[NDArray[np.intp], Array]]


def _tests(parts: Sequence[Path]) -> _Tests:
    rows: dict[Figure, list[tuple[float, ...]]] = {}
    heads: dict[str, list[Any]] = {name: [] for name in ("serial", "again", "station", "status", "verdict")}
    numbers = ("value", "u", "dof", "common", "lo", "hi")
    for path in parts:
        part = pq.read_table(path, columns=[*heads, "results"])
        first = len(heads["serial"])
        for name, column in heads.items():
            column.extend(part[name].to_pylist())
        results = part["results"].combine_chunks()
        table = pa.Table.from_struct_array(results.flatten())
        table = table.append_column("row", pa.array(pc.list_parent_indices(results).to_numpy() + first))
        keep = pc.and_(pc.equal(table["method"], Method.RESULT.value), pc.is_null(table["member_kind"]))
        keep = pc.and_(keep, pc.equal(table["status"], "estimated"))
        for one in table.filter(pc.and_(keep, pc.not_equal(table["test"], ASSEMBLED))).to_pylist():
            figure = (one["test"], one["quantity"], one["axis"], int(one["power"] or 0), one["at"])
            if not _is_known(figure):
                continue
            found = (np.nan if one[name] is None else one[name] for name in numbers)
            rows.setdefault(figure, []).append((one["row"], *found))
    arrays = {name: np.array(every, dtype=np.float64) for name, every in rows.items()}
    made = {name: (every[:, 0].astype(np.intp), every[:, 1:]) for name, every in arrays.items()}
    return _Tests(heads["serial"], heads["again"], heads["station"], heads["status"], heads["verdict"], made)


def _held(tests: _Tests, whole: NDArray[np.bool_], truth: Mapping[str, Any]) -> list[Held]:
    """Return how many intervals hold the truth, of the tests without a mistake in them."""
    found = []
    for figure, (every, numbers) in tests.figures.items():
        rows = every[whole[every]]
        if not rows.size:
            continue
        value, u, dof, common, low, high = numbers[whole[every]].T
        units = [truth["units"][tests.serials[row]] for row in rows]
        stations = [truth["stations"][tests.stations[row]] for row in rows]
        pairs = (_true(figure, unit, station) for unit, station in zip(units, stations, strict=True))
        true, shift = np.array(list(pairs)).T
        inside = (low <= true) & (true <= high)
        shares = common > LEAST * u
        mine = np.sqrt(np.maximum(u**2 - common**2, 0.0))
        free = np.maximum(np.where(np.isfinite(dof), dof, np.inf) * (mine / u) ** 4, 1.0)
        half = np.array([t_quantile(one, 0.975) for one in free]) * mine
        apart = np.where(shares, np.abs(value - shift - true) <= half, inside)
        mistake = "understated" if "understated" in truth["faults"] and figure[1] == "misalignment" else ""
        found.append(Held(figure, rows.size, int(inside.sum()), int(apart.sum()), mistake))
    return found


def _is_known(figure: Figure) -> bool:
    """Tell whether the truth of a figure is known, and no other figure is the same."""
    test, quantity, _, power, at = figure
    if quantity in ("bias", "bias_temperature"):
        return test == "thermal" and power <= MOST_POWER and at != REFERENCE
    return quantity in POPULATION


def _law(power: int, at: float | None) -> tuple[float, float, float]:
    """Return what bias, slope and square weigh in a figure of a bias over temperature."""
    if power:
        return (0.0, 1.0, 0.0) if power == 1 else (0.0, 0.0, 1.0)
    off = (REFERENCE if at is None else at) - REFERENCE
    return 1.0, off, off**2


def _true(figure: Figure, unit: Mapping[str, Any], station: Mapping[str, float]) -> tuple[float, float]:
    """Return the true value of a figure of a unit, and what the errors of its station add to it."""
    _, quantity, axis, power, at = figure
    a = AXES.index(axis[0])
    if quantity == "scale_factor_error":
        error = float(unit[quantity][a])
        return error, (100.0 + error) * station["rate"]
    if quantity == "misalignment":
        return float(unit[quantity][a][AXES.index(axis[1])]), 0.0
    if quantity == "angle_random_walk":
        return float(unit[quantity][a]), 0.0
    bias, slope, square = (float(unit[name][a]) for name in TERMS)
    weights, warm = _law(power, at), -station["temperature"]  # at what is shown it is colder than that
    shift = 0.0 if power else slope * warm + square * (2.0 * weights[1] * warm + warm**2)
    shift += 2.0 * square * warm if power == 1 else 0.0
    return float(np.dot(weights, (bias, slope, square))), shift


def _population(row: Mapping[str, Any], faults: Mapping[str, float]) -> list[OfPopulation]:
    """Return mean and scatter of a figure beside those of the population that the units were drawn from."""
    test, quantity, axis, power = str(row["test"]), str(row["quantity"]), str(row["axis"]), int(row["power"] or 0)
    figure = (test, quantity, axis, power, None if row["at"] is None else float(row["at"]))
    if row["mean"] is None or not _is_known(figure):
        return []
    if quantity in POPULATION and quantity != "bias":
        mean, scatter = POPULATION[quantity].mean, POPULATION[quantity].scatter
    else:
        weights = np.array(_law(power, figure[-1]))
        mean = float(weights @ [POPULATION[name].mean for name in TERMS])
        scatter = float(np.linalg.norm(weights * [POPULATION[name].scatter for name in TERMS]))
    if quantity == "scale_factor_error":
        scatter = float(np.hypot(scatter, faults.get("drift", 0.0) * scatter / np.sqrt(12.0)))
    unit = str(row["unit"])
    of_mean = t_interval(row["mean"], row["mean_u"], row["mean_dof"] or np.inf)
    of_scatter = Interval(row["scatter_interval"]["lo"], row["scatter_interval"]["hi"], row["scatter_interval"]["p"])
    return [OfPopulation(figure, "mean", row["mean"], of_mean, mean, unit),
            OfPopulation(figure, "scatter", row["scatter"], of_scatter, scatter, unit)]  # fmt: skip


def _found(
    truth: Mapping[str, Any], statistics: Mapping[str, Any], tests: _Tests
) -> tuple[tuple[Found, ...], tuple[str, ...]]:
    """Return what became of each mistake, and what was named of which none was put in."""
    faults = truth["faults"]
    off = sorted({f"{one['column']} {one['level']}" for one in statistics["off"]})
    drifts = sorted({str(one["figure"]) for one in statistics["drifts"]})
    odd = sorted({str(one["serial"]) for one in statistics["odd_units"]})
    told = {
        f"{serial}/{again}"
        for row, (serial, again) in enumerate(zip(tests.serials, tests.again, strict=True))
        if tests.statuses[row] != "done" or tests.verdicts[row] != "PASS" or serial in odd
    }
    broken = {name: [f"{serial}/{again}" for serial, again in every] for name, every in truth["broken"].items()}
    spoiled = {one.partition("/")[0] for every in broken.values() for one in every}
    bad = [f"station S{len(truth['stations']) // 2 + 1}"] if "bad_station" in faults else []
    drifting = [f"scale factor error {axis}" for axis in AXES] if "drift" in faults else []
    under = ["misalignment"] if "understated" in {one["code"] for one in statistics["remarks"]} else []
    kinds = [
        _sorted_out("bad_station", bad, off),
        _sorted_out(
            "odd_units", truth["odd_units"], [one for one in odd if one not in spoiled - {*truth["odd_units"]}]
        ),
        _sorted_out("drift", drifting, drifts),
        _sorted_out("understated", ["misalignment"] if "understated" in faults else [], under),
        *(_sorted_out(name, every, [one for one in every if one in told]) for name, every in broken.items()),
    ]
    return (
        tuple(one for one in kinds if one.mistake in faults),
        tuple(each for one in kinds if one.mistake not in faults for each in one.beside),
    )


def _sorted_out(mistake: str, put_in: Sequence[str], named: Sequence[str]) -> Found:
    """Return what was named, apart for what was put in and what was not."""
    known = tuple(one for one in named if one in put_in)
    return Found(mistake, tuple(put_in), known, tuple(one for one in named if one not in put_in))


def _name(figure: Figure) -> str:
    """Return a figure in words, without its axis."""
    test, quantity, _, power, at = figure
    name = f"{quantity}_{power}" if power else quantity
    return f"{test}: {name.replace('_', ' ')}" + ("" if at is None else f" at {at:g} degC")


def _missed(one: OfPopulation) -> str:
    low, high = (number(float(end or 0.0), 3) for end in (one.interval.lo, one.interval.hi))
    name, true = f"{_name(one.figure)} {one.figure[2]}", number(one.truth, 3)
    return f"{name}: {one.what} of the units {low} to {high} {one.unit}, true {true}"


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "") or "-"
