"""A run planned: how long, and at which resolution, for a wanted chance of a PASS.

What ``plan vibration`` and ``inertialcal.plan_vibration`` do. The theory is that of the verdict itself: a line of
``nu`` degrees of freedom, whose true deviation is d and whose scale factor is off by b, PASSes where its 95 % interval
lies inside the tolerance T, for which its chi-square error c, in decibels, must lie within::

    -T + lower side - d - b  <=  c  <=  T - upper side - d - b          c = 10 lg(chi^2(nu) / nu)

The chance of a PASS is the product over all lines, which are taken as independent (neighbours are not, which makes it
larger), averaged over b, and times that of the overall level where it has a tolerance. The controller's error is taken
as spread evenly between plus and minus ``control_error`` over the lines, and as zero in the overall level. Degrees of
freedom are those of half overlapping Hann segments, ``2 K / (1 + (K - 1)/(18 K))`` of K segments, times the number of
control channels where their noise is not one.

FAIL of a line takes an interval that holds for all lines together; how far out a line must be for it is told as well.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import special

from ...core.curve import Column, Curve
from ...core.errors import UsageError
from ...core.estimate import Array
from ...core.key import At, Key, Reason
from ...core.remarks import Remark
from ...core.results import Row, not_estimated
from ...core.schema.settings import settings_values
from ...core.settings import settings_of
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import remarks_line
from ...core.show.rounding import dof, number
from ...core.show.tables import Block, Table, html, text
from ...signals.vibration.deviation import NEPER, Deviation
from ...signals.vibration.profile import Profile, decibels
from .plan import FEWEST_LINES, PlannedRun
from .profile_file import read_profile
from .reduction import Power, default_resolution

if TYPE_CHECKING:
    from pandas import DataFrame

P = 0.95
STEPS = 21  # of the controller's error, from its lowest to its highest
RESOLUTIONS = (0.25, 0.5, 1.0, 2.0)  # times the default, that are compared
DURATIONS = np.geomspace(2.0, 600.0, 40)  # of the curve [s]
LONGEST, SHORTEST = 1e5, 0.5  # [s] that are looked through
MOST_MORE = 200.0  # [dB], and (1), by which a larger tolerance is looked for
LONG = 600.0  # [s] that a run may take where a setting is advised
FEWEST_SEGMENTS = 1.5  # lengths of a segment, that hold two that overlap by half
USUAL = 60.0  # [s] for which figures are told where no duration is given
TEST = "plan"
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(21)


@dataclass(frozen=True)
class RunForecast:
    """What a run would give at one resolution."""

    resolution: float  # [Hz]
    lines: int
    duration: float  # For which the figures below are [s]
    dof: float  # Of a line
    scatter: float  # Of a line by chance [dB]
    chance: float  # Of a PASS
    needed: float | None  # Duration for the wanted chance [s]; None where no duration gives it
    failed: float  # Deviation of one line that FAILs with the wanted chance [dB]


@dataclass(frozen=True, eq=False)
class VibrationPlan:
    """A run before it is made."""

    wanted: PlannedRun
    profile: Profile
    forecasts: tuple[RunForecast, ...]
    curves: tuple[Curve, ...]
    remarks: tuple[Remark, ...] = ()

    @property
    def rows(self) -> tuple[Row, ...]:
        """Degrees of freedom, chance and needed duration by resolution."""
        found = []
        for one in self.forecasts:
            at = At("resolution", one.resolution, "Hz")
            found.append(Row(Key("degrees_of_freedom", at=at), one.dof, None, "1", test=TEST))
            found.append(Row(Key("pass_probability", at=at), one.chance, None, "1", test=TEST))
            key = Key("duration_needed", at=at)
            why = Reason("never", "no duration gives that chance: the tolerance is used up by error and scale factor")
            found.append(not_estimated(key, "s", why) if one.needed is None else
                         Row(key, one.needed, None, "s", test=TEST))  # fmt: skip
            found.append(Row(Key("failed_deviation", at=at), one.failed, None, "dB", test=TEST))
        return tuple(found)

    @property
    def results(self) -> dict[str, Any]:
        """Rows and the curve as ``results.json`` has them."""
        return {"results": [row.to_dict() for row in self.rows], "curves": [one.to_dict(TEST) for one in self.curves]}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a resolution."""
        rows = [
            (number(one.resolution, 3), str(one.lines), dof(one.dof), number(one.scatter, 2),
             f"{100.0 * one.chance:.1f} %", "-" if one.needed is None else number(one.needed, 3), number(one.failed, 3))
            for one in self.forecasts
        ]  # fmt: skip
        duration = number(self.forecasts[0].duration, 3)
        heads = ("resolution [Hz]", "lines", "dof", "scatter [dB]", f"PASS in {duration} s",
                 f"for {100.0 * self.wanted.power:g} % [s]", "FAIL from [dB]")  # fmt: skip
        limits = f"tolerance {number(self.wanted.tolerance, 3)} dB"
        if self.wanted.overall is not None:
            limits += f", overall {number(100.0 * self.wanted.overall, 3)} %"
        caption = f"{limits}, true spectrum within {number(self.wanted.control_error, 3)} dB of the profile"
        return (Table(heads, rows, caption, tuple(range(7))),)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text((*self.parts(), *remarks_line(self.remarks)))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html((*self.parts(), *remarks_line(self.remarks)))


def plan_vibration(**settings: Any) -> VibrationPlan:
    """Plan a run of random vibration.

    Parameters
    ----------
    **settings
        Those of ``plan vibration``, quantities as text with a unit: ``profile`` (needed), ``tolerance``, ``overall``,
        ``control_error``, ``channels``, ``u``, ``power``, ``resolution``, ``duration``.

    Returns
    -------
    VibrationPlan
        Printable; ``.rows``, ``.forecasts``, ``.remarks``.

    Raises
    ------
    UsageError
        If a setting is wrong or missing.
    DataError
        If the profile cannot be read.
    """
    return planned(settings, options=False)


def planned(given: Mapping[str, Any], options: bool = True) -> VibrationPlan:
    """Return the plan that settings give, as text with units; messages speak of options, or of arguments of Python."""
    said = {
        name: str(value) if isinstance(value, Path) else value for name, value in given.items() if value is not None
    }
    words = {one.name: f"--{one.option}" if options else one.name for one in settings_of(PlannedRun)}
    if unknown := [name for name in said if name not in words]:
        raise UsageError(f"no setting {unknown[0]!r}", do=f"There are: {', '.join(words)}", code="unknown_name")

    def called(path: tuple[str | int, ...]) -> str:
        return words.get(str(path[0]), str(path[0]))

    values, problems = settings_values(PlannedRun, said, lambda *_: "", called=called)
    if problems:
        raise UsageError(problems)
    wanted = PlannedRun(**values)
    if wanted.profile is None:
        do = f"Add {words['profile']}{' ' if options else '='}FILE.csv, with the nodes of the profile"
        raise UsageError("no profile", do=do, code="missing")
    stated = read_profile(wanted.profile)
    usual = default_resolution(stated.profile)
    resolutions = [usual * one for one in RESOLUTIONS] if wanted.resolution is None else [wanted.resolution]
    if lines_of(stated.profile, resolutions[0]) < FEWEST_LINES:
        few = lines_of(stated.profile, resolutions[0])
        what = (
            f"{words['resolution']} {number(resolutions[0], 4)} Hz: {few} lines inside the profile, need {FEWEST_LINES}"
        )
        raise UsageError(what, do="Give a finer resolution", code="wrong_value")
    shortest = FEWEST_SEGMENTS / max(resolutions)
    if wanted.duration is not None and wanted.duration < shortest:
        what = f"{words['duration']} {number(wanted.duration, 3)} s: shorter than a spectrum takes, "
        what += f"{number(shortest, 3)} s at {number(max(resolutions), 3)} Hz"
        raise UsageError(what, do=f"Give {number(shortest, 3)} s or more", code="wrong_value")
    carried = math.inf if wanted.duration is None else wanted.duration
    resolutions = [one for one in resolutions if lines_of(stated.profile, one) >= FEWEST_LINES
                   and FEWEST_SEGMENTS / one <= carried]  # fmt: skip
    found = tuple(_forecast(wanted, stated.profile, one) for one in resolutions)
    return VibrationPlan(wanted, stated.profile, found, _curves(wanted, stated.profile, resolutions),
                         (*stated.remarks, *_remarks(wanted, stated.profile, found, words, options)))  # fmt: skip


def _remarks(
    wanted: PlannedRun, profile: Profile, found: Sequence[RunForecast], words: Mapping[str, str], options: bool
) -> list[Remark]:
    remarks = []
    if wanted.u == 0.0:
        what = "scale factor of the control accelerometers taken as exact"
        remarks.append(Remark("no_standard_uncertainty", "warning", what, do="State it: --u"))
    if all(one.needed is None for one in found):
        what = "no duration gives that chance of a PASS"
        if wanted.control_error >= wanted.tolerance:
            what += f": a controller's error of {number(wanted.control_error, 3)} dB uses the tolerance of "
            what += f"{number(wanted.tolerance, 3)} dB up"
        ways = list(_what_helps(wanted, profile, max(one.resolution for one in found)))
        shown = [f"{words[name]}{' ' if options else '='}{json.dumps(value)} or {word}" for name, value, word in ways]
        do = f"Plan with {', or with '.join(shown)}" if shown else \
            "Change more than one of tolerance, controller's error, overall tolerance and scale factor"  # fmt: skip
        remarks.append(Remark("never", "warning", what, do=do))
    return remarks


def _what_helps(wanted: PlannedRun, profile: Profile, resolution: float) -> Iterator[tuple[str, str, str]]:
    """Yield each setting that alone gives the wanted chance in ten minutes, from which value on, and which way.

    A coarser resolution is left to the table: its first row is the finest.
    """

    def enough(name: str, value: float) -> bool:
        changed = {
            "control_error": replace(wanted, control_error=value), "u": replace(wanted, u=value),
            "tolerance": replace(wanted, tolerance=value), "overall": replace(wanted, overall=value),
        }  # fmt: skip
        return pass_chance(changed[name], profile, resolution, LONG) >= wanted.power

    usual = default_resolution(profile)
    if resolution < usual and pass_chance(wanted, profile, usual, LONG) >= wanted.power:
        yield "resolution", f"{number(usual, 4)} Hz", "coarser"
    known = {"control_error": (wanted.control_error, 1.0, "dB"), "u": (wanted.u, 100.0, "%")}
    for name, (value, scale, unit) in known.items():
        if value > 0.0 and enough(name, 0.0):
            low, high = 0.0, value
            for _ in range(12):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if enough(name, middle) else (low, middle)
            size = _rounded(low * scale, math.floor)
            yield name, f"{size:g} {unit}", "less"
    upward = {"tolerance": (wanted.tolerance, 1.0, "dB"), "overall": (wanted.overall or math.inf, 100.0, "%")}
    for name, (value, scale, unit) in upward.items():
        low, high = value, value + MOST_MORE
        if math.isfinite(value) and enough(name, high):
            while high / low > 1.01:
                middle = math.sqrt(low * high)
                low, high = (low, middle) if enough(name, middle) else (middle, high)
            yield name, f"{_rounded(high * scale, math.ceil):g} {unit}", "more"


def _rounded(value: float, way: Callable[[float], int]) -> float:
    """Return a positive value with two digits, rounded down or up."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1) if value > 0.0 else 1.0
    return round(way(value / step * (1.0 + 1e-12)) * step, 12)


def lines_of(profile: Profile, resolution: float) -> int:
    """Return how many lines are judged: their windows, two lines on each side, lie inside the profile."""
    low, high = profile.band
    first, last = math.ceil(low / resolution + 2.0 - 1e-9), math.floor(high / resolution - 2.0 + 1e-9)
    return max(0, last - first + 1)


def degrees_of_freedom(duration: float, resolution: float, channels: int = 1) -> float:
    """Return those of a line: half overlapping Hann segments, of channels whose noise is not one.

    Examples
    --------
    >>> f"{degrees_of_freedom(60.0, 5.0):.0f}"
    '1135'
    """
    segments = max(1.0, 2.0 * duration * resolution - 1.0)
    return 2.0 * segments / (1.0 + (segments - 1.0) / (18.0 * segments)) * channels


def pass_chance(wanted: PlannedRun, profile: Profile, resolution: float, duration: float) -> float:
    """Return the chance that a run whose true spectrum is within the controller's error PASSes."""
    lines, dof = lines_of(profile, resolution), degrees_of_freedom(duration, resolution, wanted.channels)
    u = 2.0 * NEPER * wanted.u
    own = np.linspace(-wanted.control_error, wanted.control_error, STEPS)
    one = _line(dof, u)
    low, high = (float(end[0]) for end in one.interval(P))
    chance, weight = 0.0, WEIGHTS / WEIGHTS.sum()
    for b, share in zip(NODES * u, weight, strict=True):
        each = _between(dof, -wanted.tolerance - low - own - b, wanted.tolerance - high - own - b)
        with np.errstate(divide="ignore"):
            every = math.exp(lines * float(np.mean(np.log(each))))
        chance += share * every * _overall(wanted, profile, duration, float(b))
    return chance


def _overall(wanted: PlannedRun, profile: Profile, duration: float, b: float) -> float:
    """Return the chance that the overall level of a run on the profile passes, its scale factor off by b [dB]."""
    if wanted.overall is None:
        return 1.0
    dof = 2.0 * profile.width * duration * wanted.channels
    power = Power(1.0, dof, wanted.u, "1", "")
    half = 1.96 * power.u_rms  # the verdict takes the t interval of that many degrees of freedom
    upper, lower = 1.0 + wanted.overall - half, 1.0 - wanted.overall + half
    if lower >= upper:
        return 0.0
    ends = 2.0 * decibels(np.array([max(lower, 1e-9), upper])) - b
    return float(_between(dof, ends[:1], ends[1:])[0])


def _between(dof: float, low: Array, high: Array) -> Array:
    """Return the chance that a chi-square value lies between two ends in decibels of its mean."""
    ends = [special.chdtr(dof, dof * 10.0 ** (0.1 * one)) for one in (low, high)]
    return np.asarray(np.clip(ends[1] - ends[0], 0.0, 1.0))


def _line(dof: float, u: float) -> Deviation:
    one = np.ones(1)
    return Deviation(one, one, one, one, one, np.array([dof]), np.zeros((1, 0)), u)


def _forecast(wanted: PlannedRun, profile: Profile, resolution: float) -> RunForecast:
    needed = _needed(wanted, profile, resolution)
    duration = wanted.duration or max(USUAL, FEWEST_SEGMENTS / resolution)
    dof, lines = degrees_of_freedom(duration, resolution, wanted.channels), lines_of(profile, resolution)
    together = P ** (1.0 / max(lines, 1))
    one = _line(dof, 2.0 * NEPER * wanted.u)
    low = float(one.interval(together)[0][0])
    usual = float(decibels(special.chdtri(dof, wanted.power) / dof))  # exceeded with the wanted chance
    return RunForecast(resolution, lines, duration, dof, float(one.u_value[0]),
                       pass_chance(wanted, profile, resolution, duration), needed,
                       wanted.tolerance - low - usual)  # fmt: skip


def _needed(wanted: PlannedRun, profile: Profile, resolution: float) -> float | None:
    """Return the shortest duration with the wanted chance; None where the longest has not."""
    low, high = max(SHORTEST, 2.0 / resolution), LONGEST
    if pass_chance(wanted, profile, resolution, high) < wanted.power:
        return None
    if pass_chance(wanted, profile, resolution, low) >= wanted.power:
        return low
    while high / low > 1.001:
        middle = math.sqrt(low * high)
        low, high = (
            (low, middle) if pass_chance(wanted, profile, resolution, middle) >= wanted.power else (middle, high)
        )
    return high


def _curves(wanted: PlannedRun, profile: Profile, resolutions: Sequence[float]) -> tuple[Curve, ...]:
    """Return the chance of a PASS over the duration, a curve a resolution."""
    found = []
    for one in resolutions:
        chance = np.array([pass_chance(wanted, profile, one, t) for t in DURATIONS.tolist()])
        line = np.full(len(DURATIONS), wanted.power)
        columns = {"duration": Column(DURATIONS, "s"), "chance": Column(chance, "1"), "wanted": Column(line, "1")}
        found.append(Curve("vibration_plan", "", columns, of=f"{number(one, 4)} Hz"))
    return tuple(found)


__all__ = ["RunForecast", "VibrationPlan", "degrees_of_freedom", "lines_of", "pass_chance", "plan_vibration", "planned"]
