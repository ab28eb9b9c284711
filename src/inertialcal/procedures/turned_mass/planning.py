"""A turned-mass test planned: rates, senses and hours, the null of recoil, and how well the scale factor will be known.

What ``plan turned-mass`` and ``inertialcal.plan_turned_mass`` do. Each run of the programme is fitted as the test fits
it, so its covariance for a noise that is known beforehand is exact; all runs are then joined as the test joins them.
The forecast is checked: tests with that noise are simulated and reduced, and their scale factors scatter as they should
within what so few show. A real test has to estimate its noise, and lines of the orbit cost what the fit of them costs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.curve import Column, Curve
from ...core.errors import DataError, UsageError
from ...core.key import At, Key, Member
from ...core.remarks import Remark
from ...core.results import Row
from ...core.schema.settings import settings_values
from ...core.settings import settings_of
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import remarks_line
from ...core.show.rounding import number, uncertainty, with_uncertainty
from ...core.show.tables import Block, Table, html, text
from ...core.units import factor, parse_quantity
from ...physics.motion.turns import Turn
from ...physics.orbit import orbital_rate
from ...physics.turned_mass import attraction, null_rates, recoil_arm, recoil_rates
from ...signals.sine.noise import Noise
from .joining import ARM, Orbit, S, join, model, separable
from .plan import PlannedTurns
from .programme import write_programme
from .readings import Run
from .response import Response, responses_of

if TYPE_CHECKING:
    from pandas import DataFrame

TEST = "plan"
PAUSE = 3600.0  # from run to run, to change the rate [s]
LINES = 2  # of the orbit that are fitted, as by default
CERTAIN = 1e12  # degrees of freedom of a noise that is known
FASTEST, SLOWEST, POINTS = 900.0, 28_800.0, 160  # turns of the curve of the null [s]
STEPS = 10  # of a gate, in simulated tests
FEW = 20  # simulated tests, from which they check a forecast
SEED = 32


@dataclass(frozen=True)
class PlannedRun:
    """One run of the programme."""

    turn: Turn
    response: float  # Of the first harmonic over the attraction
    u: float  # Its standard uncertainty over the attraction; NaN where the run meets the orbit
    met: int  # Multiple of the orbital rate that it meets; 0 for none


@dataclass(frozen=True, eq=False)
class TurnedPlan:
    """A programme before it is run."""

    wanted: PlannedTurns
    runs: tuple[PlannedRun, ...]
    orbit: Orbit
    arm: float  # Recoil arm [m]
    u_noise: float  # Of the scale factor by the noise, relative
    u_applied: float  # By mass and distance, relative
    u_arm: float  # Of the recoil arm by the noise, relative
    simulated: tuple[float, int] | None = None  # Scatter of simulated scale factors, relative, and how many
    remarks: tuple[Remark, ...] = ()

    @property
    def u(self) -> float:
        """Relative standard uncertainty of the scale factor."""
        return math.hypot(self.u_noise, self.u_applied)

    @property
    def nulls(self) -> tuple[float, float]:
        """Times of a turn at which recoil and attraction cancel, with the orbit and against it [s]; NaN for none."""
        both = null_rates(self.wanted.mass, self.wanted.radius, self.wanted.satellite, self.orbit.rate, self.orbit.axis)
        return 2.0 * math.pi / both[0], 2.0 * math.pi / abs(both[1])

    @property
    def needed(self) -> float | None:
        """Length of each run that reaches what is wanted [s]; infinite where mass and distance alone are worse."""
        if self.wanted.wanted is None:
            return None
        left = self.wanted.wanted**2 - self.u_applied**2
        return self.wanted.hours * self.u_noise**2 / left if left > 0.0 else math.inf

    @property
    def rows(self) -> tuple[Row, ...]:
        """Its figures as ``results.json`` has them."""
        return tuple(self._rows())

    def _rows(self) -> Iterator[Row]:
        figures = [("attraction", self.orbit.attraction, "m/s^2"), ("recoil_arm", self.arm, "m"),
                   ("scale_factor_uncertainty", self.u, "1"), ("recoil_arm_uncertainty", self.u_arm, "1")]  # fmt: skip
        yield from (Row(Key(name), value, None, unit, test=TEST) for name, value, unit in figures)
        for label, value in (("noise", self.u_noise), ("mass and distance", self.u_applied)):
            yield Row(Key("scale_factor_uncertainty"), value, None, "1", test=TEST, member=Member("influence", label))
        for sense, period in zip(("with the orbit", "against the orbit"), self.nulls, strict=True):
            if math.isfinite(period):
                yield Row(Key("null_period"), period, None, "s", test=TEST, member=Member("sense", sense))
        if self.simulated is not None:
            size, n = self.simulated
            yield Row(Key("scale_factor_uncertainty"), size, size / math.sqrt(2.0 * (n - 1)), "1", float(n - 1),
                      test=TEST, member=Member("simulated", f"{n} simulated tests"))  # fmt: skip
        if self.needed is not None and math.isfinite(self.needed):
            yield Row(Key("time_to_target"), self.needed, None, "s", test=TEST)
        for one in self.runs:
            at = At("turn", one.turn.period * math.copysign(1.0, one.turn.rate), "s")
            run = Member("run", one.turn.run)
            yield Row(Key("response_over_attraction", at=at), one.response, None, "1", test=TEST, member=run)
            if math.isfinite(one.u):
                yield Row(Key("response_uncertainty", at=at), one.u, None, "1", test=TEST, member=run)

    @property
    def results(self) -> dict[str, Any]:
        """Rows and curves as ``results.json`` has them."""
        return {
            "results": [row.to_dict() for row in self.rows],
            "curves": [one.to_dict(TEST) for one in self.curves()],
        }

    def curves(self) -> list[Curve]:
        """Return response over attraction by the time of a turn, for both senses, and the runs."""
        periods = np.geomspace(FASTEST, SLOWEST, POINTS)
        made = []
        for of, sign in (("with", 1.0), ("against", -1.0)):
            share = self.arm / self.orbit.attraction
            q = recoil_rates(sign * 2.0 * math.pi / periods, self.orbit.rate, self.orbit.axis)[0]
            columns = {"period": Column(periods / 3600.0, "h"), "response": Column(1.0 - share * q, "1")}
            made.append(Curve("turned_null", "", columns, of=of))
        columns = {
            "run": Column([one.turn.run for one in self.runs]),
            "period": Column([one.turn.period / 3600.0 for one in self.runs], "h"),
            "ahead": Column([one.turn.rate > 0.0 for one in self.runs]),
            "response": Column([one.response for one in self.runs], "1"),
            "u": Column([one.u for one in self.runs], "1"),
        }
        return [*made, Curve("turned_planned", "", columns)]

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the runs, then what they give together."""
        wanted = self.wanted
        rows = [
            (one.turn.run, one.turn.named, f"{one.turn.turns:.3g}", number(one.response, 3),
             "meets the orbit" if one.met else uncertainty(one.u))
            for one in self.runs
        ]  # fmt: skip
        ng = self.orbit.attraction / factor("ng", "m/s^2")
        caption = f"{number(wanted.mass, 4)} kg at {number(wanted.radius, 4)} m: attraction {number(ng, 4)} ng"
        caption += f", recoil arm {number(1e3 * self.arm, 4)} mm; runs of {number(wanted.hours / 3600.0, 4)} h"
        heads = ("run", "turn", "turns", "response / attraction", "u")
        figures = [("scale factor", f"{uncertainty(100.0 * self.u)} %"),
                   ("  by noise", f"{uncertainty(100.0 * self.u_noise)} %"),
                   ("  by mass and distance", f"{uncertainty(100.0 * self.u_applied)} %"),
                   ("recoil arm, by noise", f"{uncertainty(100.0 * self.u_arm)} %")]  # fmt: skip
        if self.simulated is not None:
            size, n = self.simulated
            said = with_uncertainty(100.0 * size, 100.0 * size / math.sqrt(2.0 * (n - 1)))
            figures.insert(2, (f"  scatter of {n} simulated tests", f"{said} %"))
        for sense, period in zip(("with", "against"), self.nulls, strict=True):
            said = f"{number(period, 4)} s a turn" if math.isfinite(period) else "none"
            figures.append((f"null of recoil, {sense} the orbit", said))
        if self.needed is not None:
            said = f"{number(self.needed / 3600.0, 3)} h a run" if math.isfinite(self.needed) else "not in any time"
            figures.append((f"{uncertainty(100.0 * float(wanted.wanted or 0.0))} % is reached with", said))
        if wanted.schedule is not None:
            figures.append(("programme written into", wanted.schedule))
        return (Table(heads, rows, caption, (2, 3, 4)), Table(("standard uncertainty", ""), figures, "", (1,)))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text((*self.parts(), *remarks_line(self.remarks)))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html((*self.parts(), *remarks_line(self.remarks)))


def plan_turned_mass(**settings: Any) -> TurnedPlan:
    """Plan a turned-mass test.

    Parameters
    ----------
    **settings
        Those of ``plan turned-mass``, quantities as text with a unit: ``mass``, ``radius``, ``satellite``,
        ``altitude``, ``input_axis``, ``scale_factor``, ``gate``, ``noise``, ``walk``, ``periods``, ``hours``,
        ``repeats``, ``wanted``, ``u_mass``, ``u_radius``, ``trials``, ``schedule``.

    Returns
    -------
    TurnedPlan
        Printable; ``.rows``, ``.runs``, ``.remarks``.

    Raises
    ------
    UsageError
        If a setting is wrong.
    """
    return planned(settings, options=False)


def planned(given: Mapping[str, Any], options: bool = True) -> TurnedPlan:
    """Return the plan that settings give, as text with units; messages speak of options, or of arguments of Python."""
    said = {name: value for name, value in given.items() if value is not None}
    words = {one.name: f"--{one.option}" if options else one.name for one in settings_of(PlannedTurns)}
    if unknown := [name for name in said if name not in words]:
        raise UsageError(f"no setting {unknown[0]!r}", do=f"There are: {', '.join(words)}", code="unknown_name")

    def called(path: tuple[str | int, ...]) -> str:
        return words.get(str(path[0]), str(path[0]))

    values, problems = settings_values(PlannedTurns, said, lambda *_: "", called=called)
    if problems:
        raise UsageError(problems)
    wanted = PlannedTurns(**values)
    turns = programme(wanted, words["periods"])
    try:
        found = forecast(wanted, turns)
    except DataError as error:
        raise UsageError(list(error.problems)) from error
    if wanted.schedule is not None:
        notes = (f"turned mass of {wanted.mass:g} kg at {wanted.radius:g} m; + is the sense of the orbit",)
        write_programme(wanted.schedule, turns, notes)
    return found


def programme(wanted: PlannedTurns, word: str = "periods") -> tuple[Turn, ...]:
    """Return the runs: each time of a turn in its sense, or in both, as often as is wanted.

    Raises
    ------
    UsageError
        If a time of a turn is none.
    """
    rates = []
    for given in wanted.periods:
        try:
            period = parse_quantity(given).to("s")
        except DataError as error:
            raise UsageError([replace(one, what=f"{word} {given!r}: {one.what}") for one in error.problems]) from None
        if not math.isfinite(period) or period == 0.0:
            raise UsageError(f"{word} {given!r}: not a time of a turn", do=f'Write {word} "1 h"', code="wrong_value")
        both = not given.strip().startswith(("+", "-"))
        rates += [2.0 * math.pi / period, *([-2.0 * math.pi / period] if both else [])]
    turns: list[Turn] = []
    for rate in rates * wanted.repeats:
        start = turns[-1].stop + PAUSE if turns else 0.0
        turns.append(Turn(f"run{len(turns) + 1}", start, start + wanted.hours, rate))
    return tuple(turns)


def forecast(wanted: PlannedTurns, turns: Sequence[Turn]) -> TurnedPlan:
    """Return what a programme will give.

    Raises
    ------
    DataError
        ``one_speed`` if its runs do not tell recoil and attraction apart; as `response.responses_of`.
    """
    n = orbital_rate(wanted.altitude).value("orbital_rate")
    orbit = Orbit(attraction(wanted.mass, wanted.radius), wanted.radius, n, wanted.input_axis)
    arm = recoil_arm(wanted.mass, wanted.radius, wanted.satellite)
    rng = np.random.default_rng(SEED)
    simulated = _simulated(wanted, turns, orbit, arm, rng)
    found = responses_of(simulated, n, LINES)
    used = [one for one in found if not one.met]
    if not separable(used, orbit):
        what = "all runs turn at one rate and in one sense: scale factor and recoil cannot be told apart"
        raise DataError(what, do="Add the other sense, or another time of a turn", code="one_speed")
    ideal = [_known(one, wanted) for one in used]
    truth = np.array([wanted.scale_factor, arm, 0.0, 0.0, 0.0, 0.0])
    ideal = [replace(one, values=values) for one, values in zip(ideal, model(truth, ideal, orbit), strict=True)]
    covariance = join(ideal, orbit).within
    q = [float(recoil_rates(one.run.turn.rate, n, orbit.axis)[0]) for one in found]
    size = wanted.scale_factor * orbit.attraction
    runs = tuple(
        PlannedRun(one.run.turn, 1.0 - arm * rate / orbit.attraction,
                   math.nan if one.met else float(_known(one, wanted).u[0]) / size, one.met)
        for one, rate in zip(found, q, strict=True)
    )  # fmt: skip
    applied = math.hypot(wanted.u_mass / wanted.mass, 2.0 * wanted.u_radius / wanted.radius)
    made = TurnedPlan(wanted, runs, orbit, arm, math.sqrt(covariance[S, S]) / wanted.scale_factor, applied,
                      math.sqrt(covariance[ARM, ARM]) / arm)  # fmt: skip
    trials = None if wanted.trials < FEW else _trials(wanted, turns, orbit, arm, rng)
    made = replace(made, simulated=trials)
    return replace(made, remarks=tuple(_remarks(made)))


def _known(one: Response, wanted: PlannedTurns) -> Response:
    """Return a response whose noise is that of the plan."""
    white, walk = wanted.noise**2, wanted.walk**2 / wanted.gate
    both = white + walk
    noise = Noise(np.array([walk / both]), 1.0, np.array([[both]]), np.ones((1, 1)), int(CERTAIN))
    return replace(one, noise=noise)


def _simulated(
    wanted: PlannedTurns, turns: Sequence[Turn], orbit: Orbit, arm: float, rng: np.random.Generator
) -> list[Run]:
    """Return the runs of a simulated test."""
    runs = []
    for turn in turns:
        n = int((turn.stop - turn.start) / wanted.gate)
        fine = (np.arange(n * STEPS) + 0.5) * wanted.gate / STEPS
        size = orbit.attraction - arm * float(recoil_rates(turn.rate, orbit.rate, orbit.axis)[0])
        rate = wanted.scale_factor * size * np.cos(turn.angle + turn.rate * fine).reshape(n, STEPS).mean(axis=1)
        noise = rng.normal(0.0, wanted.noise, n) + np.cumsum(rng.normal(0.0, wanted.walk, n))
        times = (np.arange(n, dtype=np.float64) + 0.5) * wanted.gate
        runs.append(Run(turn, times, rate + noise, wanted.gate))
    return runs


def _trials(
    wanted: PlannedTurns, turns: Sequence[Turn], orbit: Orbit, arm: float, rng: np.random.Generator
) -> tuple[float, int]:
    """Return the relative scatter of the scale factors of simulated tests about the true one, and their number."""
    found = []
    for _ in range(wanted.trials):
        used = [
            one for one in responses_of(_simulated(wanted, turns, orbit, arm, rng), orbit.rate, LINES) if not one.met
        ]
        found.append(float(join(used, orbit).values[S]) / wanted.scale_factor)
    return float(np.std(found, ddof=1)), wanted.trials


def _remarks(found: TurnedPlan) -> Iterator[Remark]:
    for one in found.runs:
        if one.met:
            what = (
                f"{one.turn.run}: a turn of {one.turn.named} meets {one.met} times the orbital rate: it tells nothing"
            )
            period = 2.0 * math.pi / found.orbit.rate
            yield Remark("orbit_line", "warning", what, do=f"Turn at another rate; an orbit takes {period:.0f} s")
    rates = {abs(one.turn.rate) for one in found.runs if not one.met}
    if len(rates) == 1:
        what = "one rate of turn: scale factor and recoil are told apart by the sense alone"
        yield Remark("one_rate", "info", what, do="Add another time of a turn, which checks the orbit")
    if found.needed is not None and not math.isfinite(found.needed):
        what = f"mass and distance alone give {uncertainty(100.0 * found.u_applied)} %: no time reaches what is wanted"
        yield Remark("not_reached", "warning", what, do="Measure mass and distance better")
    if found.wanted.trials and found.simulated is None:
        what = f"{found.wanted.trials} simulated tests do not check a forecast"
        yield Remark("few_trials", "info", what, do=f"Simulate {FEW} or more")


__all__ = ["PlannedRun", "TurnedPlan", "forecast", "plan_turned_mass", "planned", "programme"]
