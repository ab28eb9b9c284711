"""Tests planned for the least time: what each length would give, which is the shortest that gives what is wanted.

A planner makes designs of its test (so many runs, so long a dwell, ...) and forecasts the uncertainty of each figure by
the estimator of the test itself. Here the shortest is chosen, its parts, limits and alternatives are told, and
simulated tests are set beside the forecast. A figure has parts; a part without a remedy is not made less by any length
of the test (a standard, a bias that wanders while it is read), and more than is wanted of them is a loud no.

The forecast takes the noise as it is stated. The test has to find it: ``stated`` is what it says of its own figures in
simulated tests, root mean square.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from scipy import special

from ..core.curve import Column, Curve
from ..core.errors import DataError, Problem, UsageError
from ..core.estimate import Array
from ..core.key import At, Key, Member
from ..core.remarks import Remark
from ..core.results import Row
from ..core.schema.settings import settings_values
from ..core.settings import settings_of
from ..core.show.frames import frame_of_rows
from ..core.show.result_tables import remarks_line
from ..core.show.rounding import number, uncertainty
from ..core.show.tables import Block, Table, html, text
from ..core.units import factor, parse_quantity
from ..files.write.atomic import atomic_write
from ..statistics.slow_noise import FLICKER, window_covariance

if TYPE_CHECKING:
    from pandas import DataFrame

T = TypeVar("T")

TEST = "plan"
WIDER = 1.2  # of the scatter, by which a test states more than it scatters
FEW = 20  # simulated tests, from which they check a forecast
CHANCE = 1e-3  # that sound simulated tests scatter so much more or less than the forecast
SHOWN = 7  # lengths in the table of what more time buys
REACHED = 1.0 + 1e-9
HOUR = 3600.0
WHOLE = 99.5  # from which on an uncertainty has no decimals and no exponent
SEED = 32


@dataclass(frozen=True)
class Slow:
    """Noise of a sensor at rest, SI."""

    white: float = 0.0  # Angle or velocity random walk [unit/sqrt(Hz)]
    instability: float = 0.0  # Coefficient of the flicker noise [unit]
    walk: float = 0.0  # Random walk of the bias [unit/sqrt(s)]

    def parts(self, start: Array, stop: Array) -> dict[str, Array]:
        """Return the covariance of means over windows of one run by source, shapes (n, n).

        Times count from power-up, where a random walk begins. Flicker has no level: it counts from its mean over the
        run, which belongs to what differs from power-up to power-up.
        """
        length = stop - start
        found = {}
        if self.white:
            found["noise"] = np.diag(self.white**2 / length)
        if self.instability:
            centred = np.eye(len(length)) - length / length.sum()
            kernel = self.instability**2 / math.pi * window_covariance(start, stop, FLICKER)
            found["bias instability"] = centred @ kernel @ centred.T
        if self.walk:
            middle = 0.5 * (start + stop)
            whole = np.minimum.outer(middle, middle)
            np.fill_diagonal(whole, start + length / 3.0)
            found["random walk of the bias"] = self.walk**2 * whole
        return found


@dataclass(frozen=True)
class Part:
    """What one source adds to an uncertainty."""

    label: str
    u: float
    remedy: str = ""  # What makes it less; empty where no length of the test does


@dataclass(frozen=True)
class Simulated:
    """One figure in simulated tests."""

    scatter: float  # About the true value
    stated: float  # By the test itself, root mean square
    tests: int
    free: float  # Degrees of freedom of the scatter

    def agrees(self, u: float) -> bool:
        """Whether the scatter is what a forecast makes likely."""
        if u == 0.0:
            return self.scatter == 0.0
        square = self.free * (self.scatter / u) ** 2
        low, high = special.chdtri(self.free, [1.0 - 0.5 * CHANCE, 0.5 * CHANCE])
        return bool(low <= square <= high)


@dataclass(frozen=True)
class Figure:
    """Forecast of one figure of a test, SI."""

    key: Key  # Of the figure itself: bias
    unit: str
    shown: str  # Unit that people speak it in
    parts: tuple[Part, ...]
    wanted: float | None = None
    simulated: Simulated | None = None

    @property
    def u(self) -> float:
        """Standard uncertainty."""
        return math.hypot(*(one.u for one in self.parts))

    @property
    def least(self) -> float:
        """What no length of the test makes less."""
        return math.hypot(*(one.u for one in self.parts if not one.remedy))

    @property
    def binds(self) -> Part:
        """The largest part."""
        return max(self.parts, key=lambda one: one.u)

    @property
    def name(self) -> str:
        """As people call it."""
        at = "" if self.key.at is None else f" at {number(self.key.at.value, 4)} {self.key.at.unit}"
        return f"{str(self.key.quantity).replace('_', ' ')}{at}"

    def said(self, u: float) -> str:
        """Return an uncertainty in the unit that people speak."""
        size = u / factor(self.shown, self.unit)
        return f"{number(round(size), 6) if size >= WHOLE else uncertainty(size)} {self.shown}"


@dataclass(frozen=True, eq=False)
class Design:
    """A test of one length."""

    time: float  # In all [s]
    choice: Mapping[str, str]  # What is chosen, in words: runs -> "5"
    figures: tuple[Figure, ...]
    detail: object = None  # What the planner makes the programme of

    def ratio(self, hopeless: frozenset[Key] = frozenset()) -> float:
        """Return the largest uncertainty over what is wanted, of those that can be reached."""
        of = [one.u / one.wanted for one in self.figures if one.wanted and one.key not in hopeless]
        return max(of, default=math.exp(float(np.mean([math.log(max(one.u, 1e-300)) for one in self.figures]))))


@dataclass(frozen=True, eq=False)
class TestPlan:
    """A test before it is made."""

    word: str  # Of the command
    design: Design
    others: tuple[Design, ...]  # Each longer than the one before, and better
    steps: Table | None = None  # The programme
    written: str = ""
    remarks: tuple[Remark, ...] = ()
    __test__ = False

    @property
    def figures(self) -> tuple[Figure, ...]:
        """Forecasts of the test that is chosen."""
        return self.design.figures

    @property
    def time(self) -> float:
        """Length of the test in all [s]."""
        return self.design.time

    def of(self, quantity: str) -> Figure:
        """Return the forecast of a quantity.

        Raises
        ------
        UsageError
            If there is none.
        """
        for one in self.figures:
            if one.key.quantity == quantity:
                return one
        names = ", ".join(one.key.quantity for one in self.figures)
        raise UsageError(f"no forecast of {quantity!r}", do=f"There are: {names}", code="unknown_name")

    @property
    def rows(self) -> tuple[Row, ...]:
        """Its figures as ``results.json`` has them."""
        return tuple(self._rows())

    def _rows(self) -> Iterator[Row]:
        yield Row(Key("test_time"), self.design.time, None, "s", test=TEST)
        for one in self.figures:
            key, scale, unit = one.key._replace(quantity=f"{one.key.quantity}_uncertainty"), 1.0, one.shown
            scale = factor(one.shown, one.unit)
            yield Row(key, one.u / scale, None, unit, test=TEST)
            for part in one.parts:
                yield Row(key, part.u / scale, None, unit, test=TEST, member=Member("influence", part.label))
            if one.simulated is not None:
                found = one.simulated
                size = found.scatter / scale
                yield Row(key, size, size / math.sqrt(2.0 * found.free), unit, found.free, test=TEST,
                          member=Member("simulated", f"scatter of {found.tests} simulated tests"))  # fmt: skip
                label = f"stated by {found.tests} simulated tests"
                yield Row(key, found.stated / scale, None, unit, test=TEST, member=Member("simulated", label))

    def curves(self) -> list[Curve]:
        """Return the uncertainty by the length of the test, of each figure, and which is chosen."""
        made = []
        for at, one in enumerate(self.figures):
            scale = factor(one.shown, one.unit)
            u = [other.figures[at].u / scale for other in self.others]
            columns = {
                "time": Column([other.time / HOUR for other in self.others], "h"),
                "u": Column(u, one.shown),
                "chosen": Column([other is self.design for other in self.others]),
            }
            if one.wanted is not None:
                columns["wanted"] = Column([one.wanted / scale] * len(u), one.shown)
            made.append(Curve("plan_time", "", columns, of=one.name))
        return made

    @property
    def results(self) -> dict[str, Any]:
        """Rows and curves as ``results.json`` has them, and what is chosen."""
        return {
            "results": [row.to_dict() for row in self.rows],
            "curves": [one.to_dict(TEST) for one in self.curves()],
            "chosen": dict(self.design.choice),
        }

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the test, its forecast, what more time buys."""
        about = [*self.design.choice.items(), ("time in all", hours(self.design.time))]
        if self.written:
            about.append(("programme written into", self.written))
        simulated = next((one.simulated for one in self.figures if one.simulated is not None), None)
        heads = [
            "figure",
            "u",
            *(["wanted"] if any(one.wanted for one in self.figures) else []),
            "most by",
            "by length",
        ]
        if simulated is not None:
            heads += ["scatter", "stated"]
        rows = [tuple(self._told(one, heads)) for one in self.figures]
        caption = "forecast: standard uncertainties"
        if simulated is not None:
            caption += f"; scatter and stated: of {simulated.tests} simulated tests"
        blocks: list[Block] = [Table(("programme", ""), about, f"plan {self.word}", ())]
        blocks.append(Table(tuple(heads), rows, caption, ()))
        if len(self.others) > 1:
            shown = _spread(self.others, self.design)
            names = [*self.design.choice]
            lengths = [
                (hours(one.time) + (" (chosen)" if one is self.design else ""), *(one.choice.get(n, "") for n in names),
                 *(figure.said(figure.u) for figure in one.figures))
                for one in shown
            ]  # fmt: skip
            blocks.append(Table(("time", *names, *(one.name for one in self.figures)), lengths,
                                "what more time buys: standard uncertainties", ()))  # fmt: skip
        if self.steps is not None:
            blocks.append(self.steps)
        return tuple(blocks)

    def _told(self, one: Figure, heads: Sequence[str]) -> Iterator[str]:
        yield one.name
        yield one.said(one.u)
        if "wanted" in heads:
            yield "-" if one.wanted is None else one.said(one.wanted)
        yield one.binds.label
        yield "at least " + one.said(one.least) if one.least > 0.0 else "any"
        if "scatter" in heads:
            found = one.simulated
            yield "-" if found is None else one.said(found.scatter)
            yield "-" if found is None else one.said(found.stated)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text((*self.parts(), *remarks_line(self.remarks)))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html((*self.parts(), *remarks_line(self.remarks)))


def hours(time: float) -> str:
    """Return a length of time as people say it."""
    return f"{number(time / HOUR, 3)} h" if time >= HOUR else f"{number(time / 60.0, 3)} min"


def settings_said(kind: type[T], given: Mapping[str, Any], options: bool) -> tuple[T, dict[str, str]]:
    """Return settings of a planner given as text with units, and how each is called: as option, or as argument.

    Raises
    ------
    UsageError
        If one is unknown or wrong.
    """
    said = {name: value for name, value in given.items() if value is not None}
    words = {one.name: f"--{one.option}" if options else one.name for one in settings_of(kind)}
    if unknown := [name for name in said if name not in words]:
        raise UsageError(f"no setting {unknown[0]!r}", do=f"There are: {', '.join(words)}", code="unknown_name")

    def called(path: tuple[str | int, ...]) -> str:
        return words.get(str(path[0]), str(path[0]))

    values, problems = settings_values(kind, said, lambda *_: "", called=called)
    if problems:
        raise UsageError(problems)
    return kind(**values), words


def check_order(said: object, words: Mapping[str, str], least: str, most: str) -> None:
    """Refuse two settings, the least and the most of something, of which the most is less.

    Raises
    ------
    UsageError
        ``wrong_value``.
    """
    low, high = getattr(said, least), getattr(said, most)
    if high < low:
        what = f"{words[least]} is {low}, {words[most]} is {high}"
        raise UsageError(what, do=f"Give {words[most]} {low} or more", code="wrong_value")


def quantity(word: str, said: str, unit: str, example: str, least: float = 0.0) -> float:
    """Return a quantity of a setting that is text, in a unit.

    Raises
    ------
    UsageError
        If it is none, or not above the least.
    """
    try:
        found = parse_quantity(said).to(unit)
    except DataError as error:
        do = f'Write {word} "{example}"'
        raise UsageError([replace(one, what=f"{word} {said!r}: {one.what}", do=one.do or do)
                          for one in error.problems]) from None  # fmt: skip
    if not (math.isfinite(found) and found > least):
        raise UsageError(f"{word} {said!r}: need more than {least:g}", do=f'Write {word} "{example}"',
                         code="wrong_value")  # fmt: skip
    return found


def targets(word: str, said: Mapping[str, str], there: Mapping[str, tuple[str, str]]) -> dict[str, tuple[float, str]]:
    """Return what is wanted of each quantity, SI, with the unit that it was said in.

    Parameters
    ----------
    word : str
        Of the setting.
    said : mapping of str to str
        As given.
    there : mapping of str to (str, str)
        Unit and example of each quantity that there is.

    Raises
    ------
    UsageError
        If a quantity is unknown, or its uncertainty none.
    """
    found = {}
    for name, value in said.items():
        if name not in there:
            raise UsageError(f"{word} {name!r}: no such figure", do=f"There are: {', '.join(there)}",
                             code="unknown_name")  # fmt: skip
        unit, example = there[name]
        u = quantity(f"{word} {name}=", value, unit, example)
        found[name] = (u, parse_quantity(value).unit)
    return found


def choose(designs: Sequence[Design], available: float | None) -> tuple[Design, tuple[Design, ...], list[Remark]]:
    """Return the shortest test that gives what is wanted, those that more time buys, and what cannot be had.

    Raises
    ------
    UsageError
        ``nothing_to_plan`` if nothing is wanted and no time is given.
    """
    wanted = any(one.wanted for one in designs[0].figures)
    if not wanted and available is None:
        what = "nothing is wanted, and no time is given"
        raise UsageError(what, do="Say what is wanted of a figure, or the time available", code="nothing_to_plan")
    remarks, hopeless = [], set()
    for at, figure in enumerate(designs[0].figures):
        best = min((one.figures[at] for one in designs), key=lambda one: one.least)
        if figure.wanted is not None and best.least * REACHED > figure.wanted:
            hopeless.add(figure.key)
            by = max((one for one in best.parts if not one.remedy), key=lambda one: one.u)
            what = f"{figure.name}: {figure.said(figure.wanted)} is wanted; {by.label} alone leaves"
            what += f" {figure.said(best.least)}, however long the test is"
            remarks.append(Remark("not_reached", "error", what, do=f"Make this less: {by.label}; or want less"))
    lost = frozenset(hopeless)
    front: list[Design] = []
    for one in sorted(designs, key=lambda one: (one.time, one.ratio(lost))):
        if not front or one.ratio(lost) < front[-1].ratio(lost) * (1.0 - 1e-6):
            front.append(one)
    aimed = any(one.wanted and one.key not in lost for one in designs[0].figures)
    enough = [one for one in front if aimed and one.ratio(lost) <= REACHED]
    inside = [one for one in front if available is None or one.time <= available * REACHED]
    if not inside:
        what = f"{hours(available or 0.0)} is available; the shortest test that there is takes {hours(front[0].time)}"
        raise UsageError(what, do="Give more time, or make pauses shorter", code="not_in_time")
    if aimed and not enough:
        worst = max((one for one in front[-1].figures if one.wanted and one.key not in lost),
                    key=lambda one: one.u / (one.wanted or 1.0))  # fmt: skip
        what = f"{worst.name}: {worst.said(worst.wanted or 0.0)} is wanted; the longest test that was looked at"
        what += f" ({hours(front[-1].time)}) gives {worst.said(worst.u)}"
        binds = worst.binds
        first = f"{binds.remedy[:1].upper()}{binds.remedy[1:]}" if binds.remedy else f"Make this less: {binds.label}"
        remarks.append(Remark("not_reached", "error", what, do=f"{first}; or want less"))
    elif enough and enough[0] not in inside:
        what = f"what is wanted takes {hours(enough[0].time)}; {hours(available or 0.0)} is available"
        remarks.append(Remark("not_in_time", "error", what, do="Give more time, or want less"))
    chosen = enough[0] if enough and enough[0] in inside else inside[-1]
    if not aimed and available is None:
        chosen = front[0]
    return chosen, tuple(front), remarks


def _spread(designs: Sequence[Design], chosen: Design) -> list[Design]:
    """Return some of the lengths, evenly in their logarithm, the one that is chosen among them."""
    if len(designs) <= SHOWN:
        return list(designs)
    wanted = np.geomspace(designs[0].time, designs[-1].time, SHOWN)
    at = {int(np.argmin(np.abs(np.log([one.time / time for one in designs])))) for time in wanted}
    at |= {i for i, one in enumerate(designs) if one is chosen}
    return [designs[i] for i in sorted(at)]


def with_simulated(design: Design, found: Mapping[Key, Simulated]) -> Design:
    """Return a design with what simulated tests gave of its figures."""
    figures = tuple(replace(one, simulated=found.get(one.key)) for one in design.figures)
    return replace(design, figures=figures)


def checked(
    design: Design,
    trials: int,
    test: Callable[[np.random.Generator], Mapping[Key, tuple[Array, Array]]],
    wider: str = "what the test cannot exclude",
) -> tuple[Design, list[Remark]]:
    """Return a design beside simulated tests, and what they say of its forecast.

    Parameters
    ----------
    design : Design
        That is chosen.
    trials : int
        How many; none with fewer than 20.
    test : callable
        One simulated test: errors and stated uncertainties of each figure, one of each sensor, SI.
    wider : str
        What the interval of the test allows for beyond its scatter, where it states more.
    """
    if trials == 0:
        return design, []
    if trials < FEW:
        what = f"{trials} simulated tests do not check a forecast"
        return design, [Remark("few_trials", "info", what, do=f"Simulate {FEW} or more")]
    rng = np.random.default_rng(SEED)
    errors: dict[Key, list[Array]] = {}
    stated: dict[Key, list[Array]] = {}
    lost = 0
    for _ in range(trials):
        try:
            one = test(rng)
        except DataError:
            lost += 1
            continue
        for key, (error, u) in one.items():
            errors.setdefault(key, []).append(error**2)
            stated.setdefault(key, []).append(u**2)
    remarks = []
    if lost:
        what = f"{lost} of {trials} simulated tests were refused by the test itself"
        remarks.append(Remark("trials_refused", "warning", what, count=lost, do="Choose a longer test"))
    found = {}
    for key, squares in errors.items():
        n = len(squares)
        scatter = math.sqrt(float(np.mean(np.concatenate(squares))))
        said = math.sqrt(float(np.mean(np.concatenate(stated[key]))))
        found[key] = Simulated(scatter, said, n, float(n))
    made = with_simulated(design, found)
    remarks += [remark for one in made.figures if (remark := _beside(one, wider)) is not None]
    return made, remarks


def _beside(figure: Figure, wider: str) -> Remark | None:
    """Return what simulated tests say of a forecast; None where they agree with it."""
    beside = figure.simulated
    if beside is None:
        return None
    if not beside.agrees(figure.u):
        what = f"{figure.name}: {beside.tests} simulated tests scatter by {figure.said(beside.scatter)},"
        what += f" the forecast is {figure.said(figure.u)}"
        return Remark("forecast_differs", "warning", what, do="Trust the simulated tests")
    size = max(beside.scatter, figure.u)
    if beside.stated <= WIDER * size:
        return None
    what = f"{figure.name}: the test will state {figure.said(beside.stated)}, {number(beside.stated / size, 2)} times "
    what += f"what it scatters by: its interval allows for {wider}"
    if figure.wanted is None or not figure.u <= figure.wanted < beside.stated:
        return Remark("states_more", "info", what)
    do = f"Want less, until {figure.said(figure.wanted)} is stated"
    return Remark("states_more", "warning", what, do=do)


def adopted(others: Sequence[Design], before: Design, after: Design) -> tuple[Design, ...]:
    """Return the lengths with the one that is chosen in place of what it was before it was checked."""
    return tuple(after if one is before else one for one in others)


def exact(named: Mapping[str, float], word: str = "") -> list[Remark]:
    """Return a remark on what is taken as exact, since nobody said its uncertainty."""
    absent = [name for name, u in named.items() if not u]
    if not absent:
        return []
    what = f"taken as exact: {', '.join(absent)}"
    return [Remark("taken_as_exact", "warning", what, do=word or "State what they are known to")]


def write_schedule(path: str, heads: Sequence[str], rows: Iterable[Sequence[str]], notes: Iterable[str]) -> None:
    """Write a programme as CSV: notes, heads with units, a row a step; an existing file is replaced.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    written = io.StringIO()
    written.writelines(f"# {one}\n" for one in notes)
    csv.writer(written, lineterminator="\n").writerows((heads, *rows))  # prompts have commas
    with atomic_write(Path(path), []) as aside:
        aside.write_text(written.getvalue(), encoding="utf-8", newline="\n")


def refused(error: DataError) -> UsageError:
    """Return what is wrong with the data of a plan as what is wrong with its settings."""
    problems: list[Problem] = list(error.problems)
    return UsageError(problems)


__all__ = [
    "At", "Design", "Figure", "Part", "Simulated", "Slow", "TestPlan", "adopted", "checked", "choose", "exact", "hours",
    "quantity", "refused", "settings_said", "targets", "with_simulated", "write_schedule",
]  # fmt: skip
