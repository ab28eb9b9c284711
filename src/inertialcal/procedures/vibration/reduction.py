"""Random vibration: spectrum of a run at full level against its profile, levels, duration, and what breaks it.

1. Level over time (``signals.vibration.levels``): steps and ramps, the part at full level, all that follows is of it.
2. Spectra of all channels with lines at the wanted resolution, and four times finer (``signals.vibration.spectra``):
   the first is judged, the second gives powers over bands, lines, and what the first is too coarse for.
3. Control: mean, or maximum, of the control channels; the degrees of freedom of a mean by their coherence.
4. Deviation from the profile as the same window would read it, at each line whose window lies wholly inside the
   profile (two lines at each end are not judged), or over bands of 1/N octave (``signals.vibration.deviation``).

The root mean square over the profile's band has the Type A uncertainty of its degrees of freedom,
``u = rms / sqrt(2 dof)``, and that of the scale factor in proportion (Type B, common to all lines and channels).

Assumed: stationary Gaussian noise at full level; a spectrum that is smooth over a line's bandwidth; accelerometers
whose scale factor holds over the whole band; one certificate for all control channels, so that averaging them takes
nothing off its error. Each of these but the last two is looked at, and remarked where it does not hold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from ...core.constants import STANDARD_GRAVITY
from ...core.curve import Curve
from ...core.errors import DataError, PlanError
from ...core.estimate import Array, Estimate
from ...core.key import Key
from ...core.remarks import Remark, gather
from ...core.results import Interval, Row
from ...core.show.rounding import number
from ...core.show.wording import listed
from ...signals.vibration.deviation import NEPER, Deviation, lines_against
from ...signals.vibration.gaussian import Shape, shape_of
from ...signals.vibration.levels import Levels, Stretch, find_levels
from ...signals.vibration.profile import Profile, decibels, fractional_octaves
from ...signals.vibration.spectra import CrossSpectra, cross_spectra, hann_kernel
from .plan import CONTROL, CONTROL_SCALE, FEWEST_LINES, SENSOR_SCALE, Plan
from .readings import Readings

KEPT = "_reduced"  # with the readings: looking whether channels agree takes the result, too
QUARTER = 4.0  # lines up to the lowest frequency of the profile, by default
FINER = 4  # times, of the second spectrum
SHORTEST_SEGMENT = 16  # samples
DEAD = 0.02  # of the largest control channel, below which another one is dead
TINY = 1e-9  # of the largest value, below which a channel stands still
ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)  # what a default resolution is rounded down to


@dataclass(frozen=True)
class Power:
    """Mean square over the profile's band of a channel, or of the control channels together.

    Parameters
    ----------
    square : float
        [unit^2]
    dof : float
        Of it.
    u : float
        Relative standard uncertainty of the scale factor.
    unit : str
        Of the channel, SI.
    influence : str
        Whose uncertainty ``u`` is.
    """

    square: float
    dof: float
    u: float
    unit: str
    influence: str

    @property
    def rms(self) -> float:
        """Root mean square [unit]."""
        return math.sqrt(self.square)

    @property
    def u_rms(self) -> float:
        """Its standard uncertainty [unit]."""
        return self.rms * math.hypot(self.u, math.sqrt(0.5 / self.dof))

    @property
    def dof_rms(self) -> float:
        """Degrees of freedom of that (Welch and Satterthwaite)."""
        return self.dof * (1.0 + 2.0 * self.dof * self.u**2) ** 2

    def interval(self, p: float) -> Interval:
        """Return the interval of the root mean square: chi-square, with the scale factor in quadrature of each side."""
        tail = 0.5 * (1.0 - p)
        common = -float(special.ndtri(tail)) * 2.0 * NEPER * self.u
        up = float(decibels(self.dof / special.chdtri(self.dof, 1.0 - tail)))
        down = float(decibels(special.chdtri(self.dof, tail) / self.dof))
        low, high = -math.hypot(down, common), math.hypot(up, common)
        return Interval(self.rms * 10.0 ** (0.05 * low), self.rms * 10.0 ** (0.05 * high), p)


@dataclass(frozen=True)
class ChannelFigures:
    """What was found of a channel."""

    name: str  # ``control_1`` or axis
    column: str  # Of the file
    power: Power
    shape: Shape


@dataclass(frozen=True)
class Excursion:
    """A time above full level: its level against the profile [dB], degrees of freedom, u of the scale factor [dB]."""

    stretch: Stretch
    value: float
    dof: float
    u: float

    @property
    def u_value(self) -> float:
        """Standard uncertainty of the level [dB]."""
        return math.hypot(NEPER * math.sqrt(2.0 / self.dof), self.u)

    def __str__(self) -> str:
        """Return when, how long, and how much."""
        one = self.stretch
        when = f"from {number(one.start, 4)} to {number(one.stop, 4)} s"
        return f"{when}, for {number(one.stop - one.start, 3)} s, {number(one.level, 2)} dB above full level"


@dataclass(frozen=True, eq=False)
class Result:
    """A run reduced.

    Parameters
    ----------
    plan, readings
        Of the run.
    levels : Levels
        Over time.
    spectra, fine : CrossSpectra
        Of all channels, control first: at the resolution, and four times finer.
    target : Profile
        At the level of this run.
    deviation : Deviation
        Of the control from it.
    control : Power
        Of the control channels together.
    channels : tuple of ChannelFigures
        Control channels, then responses.
    """

    plan: Plan
    readings: Readings
    levels: Levels
    spectra: CrossSpectra
    fine: CrossSpectra
    target: Profile
    deviation: Deviation
    control: Power
    channels: tuple[ChannelFigures, ...]
    remarks: tuple[Remark, ...] = ()

    @property
    def estimate(self) -> Estimate | None:
        """None: each figure stands in its row."""
        return None

    @property
    def band(self) -> tuple[float, float]:
        """Of the profile, below half of the sampling frequency [Hz]."""
        low, high = self.target.band
        return low, min(high, 0.5 / self.readings.interval)

    @property
    def away(self) -> float:
        """Overall level of the control at full level against that of the profile [dB]."""
        return float(decibels(self.control.square / self.target.rms(*self.band) ** 2))

    @property
    def excursions(self) -> tuple[Excursion, ...]:
        """Times above full level, with their level against the profile."""
        return tuple(Excursion(one, self.away + one.level, one.dof, 2.0 * NEPER * self.control.u)
                     for one in self.levels.above)  # fmt: skip

    @property
    def errors(self) -> tuple[Remark, ...]:
        """Remarks on what must not be judged."""
        return tuple(one for one in self.remarks if one.severity == "error")

    def controlled(self, spectra: CrossSpectra) -> tuple[Array, Array]:
        """Return density and degrees of freedom of the control, at the lines of a spectrum."""
        return controlled(self.plan, spectra, len(self.readings.controls))

    def powers(self) -> dict[Key, Power]:
        """Return the powers by the key of their row."""
        from .rows import power_keys  # noqa: PLC0415

        return power_keys(self)

    def rows(self) -> Sequence[Row]:
        """Return the rows of ``results.json``."""
        from .rows import rows  # noqa: PLC0415

        return rows(self)

    def curves(self) -> Sequence[Curve]:
        """Return the curves of ``results.json``."""
        from .curves import curves  # noqa: PLC0415

        return curves(self)


def controlled(plan: Plan, spectra: CrossSpectra, count: int) -> tuple[Array, Array]:
    """Return density and degrees of freedom of the first channels: their mean, or the largest of them."""
    if plan.average == "mean" or count == 1:
        return spectra.mean(np.arange(count))
    density = spectra.density[:, :count].max(axis=1)
    return density, np.full(len(density), spectra.edf)


def default_resolution(profile: Profile) -> float:
    """Return a quarter of the lowest frequency, rounded down to 1, 2, 2.5 or 5 times a power of ten [Hz]."""
    wanted = profile.band[0] / QUARTER
    power = 10.0 ** math.floor(math.log10(wanted))
    return power * max(one for one in ROUND if one * power <= wanted * (1.0 + 1e-9))


def reduce(plan: Plan, readings: Readings) -> Result:
    """Set a run against its profile.

    Raises
    ------
    DataError
        ``too_short`` for a run without enough windows or segments; ``no_vibration``; ``beyond_nyquist`` where half of
        the sampling frequency lies below the profile.
    PlanError
        ``wrong_value`` for a resolution at which too few lines are left.
    """
    kept: tuple[Plan, Result] | None = vars(readings).get(KEPT)
    if kept is not None and kept[0] == plan:
        return kept[1]
    result = _reduced(plan, readings)
    vars(readings)[KEPT] = (plan, result)
    return result


def _reduced(plan: Plan, readings: Readings) -> Result:
    target = readings.profile.profile.scaled(plan.level)
    interval, nyquist = readings.interval, 0.5 / readings.interval
    if nyquist <= target.band[0] * 1.5:
        what = f"{number(2.0 * nyquist, 4)} samples a second, the profile begins at {number(target.band[0], 4)} Hz"
        raise DataError(what, readings.where, "nothing of it can be seen", "Record faster", "beyond_nyquist")
    readings = _alive(readings)
    every = np.hstack([readings.control, readings.responses])
    resolution = plan.resolution or default_resolution(target)
    segment = round(1.0 / (resolution * interval))
    band = (target.band[0], min(target.band[1], nyquist))
    levels = find_levels(readings.control, interval, _width(target, readings, segment), target.power(*band))
    chosen = levels.samples(len(readings))
    if segment < SHORTEST_SEGMENT:
        what = f"resolution = {number(resolution, 4)} Hz: {segment} samples of a segment"
        raise PlanError(
            what, do=f"Give {number(1.0 / (SHORTEST_SEGMENT * interval), 3)} Hz or finer", code="wrong_value"
        )
    spectra = cross_spectra(every, interval, segment, chosen)
    fine = _finer(every, interval, segment, chosen, spectra)
    count = len(readings.controls)
    density, edf = controlled(plan, spectra, count)
    u = _u(plan, CONTROL_SCALE)
    expected = target.smoothed(spectra.frequency, *hann_kernel(spectra.spacing))
    edges = None if plan.octave is None else fractional_octaves(*band, plan.octave)
    each = spectra.density[:, : count if plan.average == "maximum" and count > 1 else 0]
    deviation = lines_against(spectra, density, edf, expected, band, edges, each, 2.0 * NEPER * u)
    if len(deviation) < FEWEST_LINES:
        what = f"{len(deviation)} lines of {number(spectra.spacing, 4)} Hz lie inside the profile, need {FEWEST_LINES}"
        raise PlanError(what, do="Give a finer resolution", code="wrong_value")
    control = _power(fine, *controlled(plan, fine, count), band, u, "m/s^2", CONTROL_SCALE)
    channels = tuple(_channel(plan, readings, fine, chosen, every, i, band) for i in range(every.shape[1]))
    result = Result(plan, readings, levels, spectra, fine, target, deviation, control, channels)
    from .findings import findings  # noqa: PLC0415 - it takes a result

    known = {(one.code, one.what) for one in readings.remarks}  # what `agreement` has brought up
    own = [one for one in findings(result) if (one.code, one.what) not in known]
    return replace(result, remarks=gather([*readings.remarks, *own]))


def _alive(readings: Readings) -> Readings:
    """Return a run without the responses that do not move.

    Raises
    ------
    DataError
        ``dead_channel`` where one of several control channels does not move with the others; ``no_vibration`` where
        none moves.
    """
    control, responses = (np.nanstd(one, axis=0) if one.shape[1] else np.zeros(0)
                          for one in (readings.control, readings.responses))  # fmt: skip
    if not np.nanmax(control) > TINY * max(float(np.nanmax(np.abs(readings.control))), 1e-300):
        do = "Check cables and range of the control accelerometers"
        raise DataError("the control channels do not move", readings.where, do=do, code="no_vibration")
    i = int(np.argmin(control))
    if not control[i] > DEAD * np.max(control):
        sizes = [number(float(one) / STANDARD_GRAVITY.value, 2) for one in (control[i], np.max(control))]
        what = f"control channel {readings.controls[i]!r} reads {sizes[0]} g rms, the largest {sizes[1]} g: it is dead"
        why = "a mean over it is too low, and the table is then driven too hard"
        raise DataError(what, readings.where, why, "Check its cable, or judge by the others: leave it out",
                        "dead_channel")  # fmt: skip
    sizes_of = np.nanmax(np.abs(readings.responses), axis=0, initial=0.0) if len(responses) else responses
    moves = responses > TINY * np.maximum(sizes_of, 1e-300)
    if moves.all():
        return readings
    dead = [axis for axis, moving in zip(readings.axes, moves.tolist(), strict=True) if not moving]
    remark = Remark("dead_channel", "warning", f"response {listed(dead)} does not move: left out", readings.where,
                    do="Check its cable")  # fmt: skip
    axes = tuple(axis for axis in readings.axes if axis not in dead)
    return replace(readings, responses=readings.responses[:, moves], axes=axes, remarks=(*readings.remarks, remark))


def _width(target: Profile, readings: Readings, segment: int) -> float:
    """Return the statistical bandwidth of what was recorded, that of the profile at most [Hz]."""
    count = len(readings.controls)
    spectra = cross_spectra(readings.control, readings.interval, max(segment, SHORTEST_SEGMENT))
    density, edf = spectra.mean(np.arange(count))
    squares = float(np.sum(density**2 / (1.0 + 2.0 / edf)))
    return min(target.width, float(density.sum()) ** 2 * spectra.spacing / squares) if squares > 0.0 else target.width


def _finer(
    x: Array, interval: float, segment: int, chosen: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    spectra: CrossSpectra,
) -> CrossSpectra:  # fmt: skip
    """Return the spectra four times finer, or as much finer as the run carries."""
    for times in (FINER, 2):
        try:
            found = cross_spectra(x, interval, times * segment, chosen)
        except DataError:
            continue
        if found.segments >= FINER:
            return found
    return spectra


def _u(plan: Plan, influence: str) -> float:
    stated = plan.standards.get(influence)
    return 0.0 if stated is None else stated.u


def _power(
    spectra: CrossSpectra, density: Array, edf: Array, band: tuple[float, float], u: float, unit: str, influence: str
) -> Power:
    square, dof = spectra.band(density, edf, *band)
    return Power(square, dof, u, unit, influence)


def _channel(
    plan: Plan, readings: Readings, fine: CrossSpectra, chosen: np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
    every: Array, i: int, band: tuple[float, float],
) -> ChannelFigures:  # fmt: skip
    count = len(readings.controls)
    control = i < count
    influence = CONTROL_SCALE if control else SENSOR_SCALE
    unit = "m/s^2" if control else readings.unit
    density = fine.density[:, i]
    power = _power(fine, density, np.full(len(density), fine.edf), band, _u(plan, influence), unit, influence)
    shape = shape_of(every[chosen, i], fine.frequency, density, readings.interval)
    name = f"{CONTROL}_{i + 1}" if control else readings.axes[i - count]
    return ChannelFigures(name, readings.controls[i] if control else name, power, shape)


__all__ = ["ChannelFigures", "Excursion", "Power", "Result", "controlled", "default_resolution", "reduce"]
