"""What breaks a run, by its cause: level, time, distribution, channels, sampling, lines, resolution.

Each is looked for with a chance of a false alarm of ``CHANCE`` a run, shared by channels and lines; and only said where
it matters (``MATTERS``), as a long run shows deviations that nobody need care about.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy import special

from ...core.constants import STANDARD_GRAVITY
from ...core.remarks import Remark
from ...core.show.rounding import number, uncertainty
from ...core.show.wording import listed
from ...signals.spectrum.lines import Lines, find_lines
from ...signals.vibration.deviation import NEPER
from ...signals.vibration.gaussian import crest_reached, crossing_rate
from ...signals.vibration.profile import decibels
from .notches import CARVED, departures, standing_out
from .plan import FEWEST_LINES

if TYPE_CHECKING:
    from ...core.estimate import Array
    from ...signals.vibration.levels import Stretch
    from .reduction import ChannelFigures, Result

CHANCE = 1e-4
MATTERS = 1.0  # deviation of a level [dB]
GRAVITY, ALMOST = 20.0 * math.log10(STANDARD_GRAVITY.value), 0.5  # a level in the wrong unit [dB]
STEADY = 0.5  # range of the level at full level, below which nobody need care [dB]
KURTOSIS = 0.25  # from 3
CLIPPED = 4.0  # crest from which on nobody need care
RAILS = 3  # runs of equal values at the end of a range
RAIL_CREST = 5.0  # at which they matter
FOLLOWS, STRAYS = (
    2.0,
    4.0,
)  # root mean square of the deviation, without its mean, of a channel that does and does not [dB]
FITS, RATES = 2.0, 241  # root mean square of the deviation by another sample rate [dB]; rates that are tried
DIFFERS = 3.0  # the same of a control channel and the mean of the others [dB]
ROLL_OFF = 0.79  # of half the sampling frequency: above it filters against aliasing begin
FOLDED = 0.05  # density below half the sampling frequency, over that of the band, that no filter leaves
TOP = 0.9  # of half the sampling frequency, from which that is looked at
LOW_PASS = 3.0  # deviation at the top of the band [dB]
STEEP = 6.0  # and its fall over the last half octave [dB]
SINE = 0.5  # of the mean square, from which a vibration is no random one
LINE = 0.02  # of the mean square in its bandwidth band, from which a line matters
PEAK = 1.0  # that a line of the spectrum is too low [dB]
SHOWN = 4  # lines that are listed


def findings(result: Result) -> Iterator[Remark]:
    """Yield remarks on a run."""
    if sine := list(_not_random(result)):
        yield from sine
        yield from (one for one in _sampling(result) if one.code == "sample_rate")
        yield from _gaps(result)
        return
    yield from _levels(result)
    yield from _duration(result)
    yield from _stationarity(result)
    yield from _shapes(result)
    yield from _channels(result)
    yield from _shape(result)
    yield from _sampling(result)
    yield from _lines(result)
    yield from _narrow(result)
    yield from _gaps(result)
    yield from _edges(result)


def _where(result: Result) -> str:
    return result.readings.where


def _not_random(result: Result) -> Iterator[Remark]:
    """Yield a control that is a sine, or several, for the most part: nothing else of a random run can be said of it."""
    whole, count = result.control.square, len(result.readings.controls)
    found = [one for one in lines_of(result).found if one.axis < count and one.kind == "line"]
    power = sum(0.5 * one.amplitude**2 for one in found) / count
    if power > SINE * whole:
        largest = max(found, key=lambda one: one.amplitude)
        what = f"{number(100.0 * min(power / whole, 1.0), 3)} % of the control's mean square is a sine at"
        what += f" {number(largest.frequency, 5)} Hz or several: this is no random vibration"
        do = "Give the recording of the random run; a sine that is swept is one of: vibration survey"
        yield Remark("not_random", "error", what, _where(result), do=do)


def _levels(result: Result) -> Iterator[Remark]:
    """Yield a run at another level than its profile throughout; steps of level; time above."""
    away = result.away
    spread = NEPER * math.sqrt(2.0 / result.control.dof)
    deviation = float(np.median(result.deviation.value))
    off = abs(deviation) > MATTERS and abs(away) > MATTERS + 4.0 * spread
    in_g = next((word for word, one in (("above", away), ("below", -away)) if abs(one - GRAVITY) < ALMOST), "")
    if off and in_g:
        what = f"full level lies {number(abs(away), 3)} dB {in_g} the profile, which is the factor of g and m/s^2"
        yield Remark("level", "warning", what, _where(result), do="Check the unit of the control channels")
    elif off and not _swapped(result)[0] and not list(_low_pass(result)):  # these say why
        word = "above" if away > 0.0 else "below"
        what = f"full level lies {number(abs(away), 2)} dB {word} the profile over its band"
        do = f'Check the gain of the controller; a run meant to be at that level: level = "{number(away, 2)} dB"'
        yield Remark("level", "warning", what, _where(result), do=do)
    above, between = result.levels.above, result.levels.left
    others = [one for one in result.levels.stretches if not one.full
              and not any(each.start <= one.start < each.stop for each in (*above, *between))]  # fmt: skip
    if others:
        what = f"other levels: {_few([_stretch(one) for one in others])}; spectra are of full level alone"
        yield Remark("level_steps", "info", what, _where(result), count=len(others))
    if result.excursions:
        what = f"the level steps up: {_few([str(one) for one in result.excursions])}"
        do = "Find what the controller did then: an over-test counts for the item, spectra are of full level alone"
        yield Remark("above_level", "warning", what, _where(result), len(result.excursions), do)


def _stretch(one: Stretch) -> str:
    """Return a level and when it was; a ramp by its ends."""
    when = f"from {number(one.start, 4)} to {number(one.stop, 4)} s"
    if one.ends is not None:
        return f"a ramp {when} from {number(one.ends[0], 2)} to {number(one.ends[1], 2)} dB"
    return f"{number(one.level, 2)} dB {when}"


def _few(shown: Sequence[str]) -> str:
    more = f" and {len(shown) - SHOWN} more" if len(shown) > SHOWN else ""
    return f"{', '.join(shown[:SHOWN])}{more}"


def _duration(result: Result) -> Iterator[Remark]:
    levels, wanted = result.levels, result.plan.duration
    below = [one for one in levels.left if not one.level > levels.alike]
    if below:
        what = f"full level was left and reached again: {_few([_pause(one) for one in below])}"
        do = "The duration is the sum of its parts"
        yield Remark("interrupted", "warning", what, _where(result), len(below), do)
    if wanted is not None and levels.duration < wanted - 2.0 * levels.u_duration:
        what = f"{number(levels.duration, 4)} s at full level, {number(wanted, 4)} s were asked for"
        yield Remark("short_run", "warning", what, _where(result), do="Run again for what is missing")


def _pause(one: Stretch) -> str:
    how = "at rest" if one.level == -math.inf else f"at {number(one.level, 2)} dB" if one.level == one.level else "lost"
    return f"{how} from {number(one.start, 4)} to {number(one.stop, 4)} s"


def _stationarity(result: Result) -> Iterator[Remark]:
    levels = result.levels
    scatter, slope, change = levels.stationarity()
    level = levels.level[levels.inner]
    low, high = (float(one) for one in np.nanpercentile(level, (5, 95))) if len(level) else (0.0, 0.0)
    chance = 2.0 * 1.645 * levels.deviation
    at, size, by_chance = levels.step()
    if by_chance < 0.1 * CHANCE and abs(size) > STEADY:  # of few windows, whose levels are skewed
        what = f"the level at full level steps by {number(size, 2)} dB at {number(at, 4)} s"
        yield Remark("not_stationary", "warning", what, _where(result), do="The spectrum is a mean over it")
    elif slope < CHANCE and abs(change) > STEADY:
        what = f"the level at full level changes by {number(change, 2)} dB from its beginning to its end"
        yield Remark("not_stationary", "warning", what, _where(result), do="The spectrum is a mean over it")
    elif scatter < CHANCE and high - low > chance + STEADY:
        what = (
            f"the level at full level ranges over {number(high - low, 2)} dB (5 to 95 %), by chance {number(chance, 2)}"
        )
        yield Remark("not_stationary", "warning", what, _where(result), do="The spectrum is a mean over it")


def _shapes(result: Result) -> Iterator[Remark]:
    """Yield channels at rails, clipped ones, and those that are not Gaussian."""
    chance = CHANCE / len(result.channels)
    z = -float(special.ndtri(0.5 * chance))
    n = int(np.count_nonzero(result.levels.samples(len(result.readings))))
    for place, one in enumerate(result.channels):
        control, name = place < len(result.readings.controls), _called(one)
        shape = one.shape
        if shape.rails.runs >= RAILS and shape.crest < RAIL_CREST:
            what = f"{name} stands at the end of its range {shape.rails.runs} times:"
            what += f" {number(shape.crest, 3)} times its rms"
            do = "Take a larger range: peaks are cut off, the spectrum is wrong at all frequencies"
            yield Remark("saturated", "error" if control else "warning", what, _where(result), shape.rails.runs, do,
                         subject=one.column)  # fmt: skip
            continue
        if control and shape.chance < chance and shape.crest < CLIPPED:
            crossings = crossing_rate(result.fine.frequency, result.fine.density[:, place])
            usual = crest_reached(crossings * n * result.readings.interval, n, 0.5)
            what = (f"{name} never exceeds {number(shape.crest, 3)} times its rms, noise of its spectrum reaches "
                    f"about {number(usual, 2)}")  # fmt: skip
            do = "The drive is clipped: check the limit in the controller against what the document asks for"
            yield Remark("clipped_drive", "warning", what, _where(result), do=do, subject=one.column)
        elif abs(shape.kurtosis - 3.0) > max(z * shape.u_kurtosis, KURTOSIS):
            what = (
                f"{name} has a kurtosis of {number(shape.kurtosis, 3)}; 3 and {uncertainty(shape.u_kurtosis)} by chance"
            )
            do = "Look for shocks, rattling or a loose part" if shape.kurtosis > 3.0 else "Look for a sine or a limit"
            yield Remark("kurtosis", "warning", what, _where(result), do=do, subject=one.column)


def _called(one: ChannelFigures) -> str:
    return f"channel {one.column!r}" if one.column == one.name else f"channel {one.name} ({one.column})"


def shape_errors(result: Result) -> Array:
    """Return how far the shape of each channel's spectrum is from the profile: rms, mean level taken off [dB]."""
    f = result.spectra.frequency
    width = 2.0 * result.spectra.spacing
    use = (f - width >= result.band[0]) & (f + width <= result.band[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        away = decibels(result.spectra.density[use] / result.target.at(f[use])[:, None])
    return np.asarray(np.std(away, axis=0))


def _swapped(result: Result) -> tuple[list[int], list[int]]:
    """Return control channels that do not follow the profile, and responses that do; none where none does."""
    errors, count = shape_errors(result), len(result.readings.controls)
    followers = [i for i in range(count, len(errors)) if result.channels[i].power.unit == "m/s^2"
                 and errors[i] < FOLLOWS and abs(_level(result, i)) < 3.0]  # fmt: skip
    return [i for i in range(count) if errors[i] > STRAYS] if followers else [], followers


def _channels(result: Result) -> Iterator[Remark]:
    """Yield a control that is none, and control channels that differ."""
    errors, count = shape_errors(result), len(result.readings.controls)
    swapped, followers = _swapped(result)
    for i in swapped:
        other = min(followers, key=lambda k: float(errors[k]))
        one, two = (f"{_called(result.channels[k])}" for k in (i, other))
        away, near = (number(float(errors[k]), 2) for k in (i, other))
        what = f"{one} does not follow the profile ({away} dB), {two} does ({near} dB): they are swapped?"
        do = "Check which cable is which"
        yield Remark("swapped_channels", "error", what, _where(result), do=do, subject=result.channels[i].column)
    if count > 1 and not swapped:
        density = result.spectra.density[:, :count]
        f = result.spectra.frequency
        use = (f >= result.band[0]) & (f <= result.band[1])
        logs = decibels(density[use])
        apart = (logs - logs.mean(axis=1, keepdims=True)) * count / (count - 1.0)  # from the mean of the others
        strays = np.sqrt(np.mean(apart**2, axis=0))
        i = int(np.argmax(strays))
        if strays[i] > DIFFERS:
            at = float(f[use][int(np.argmax(np.abs(apart[:, i])))])
            size = number(float(strays[i]), 2)
            what = f"{_called(result.channels[i])} differs from the other control channels by {size} dB,"
            if count == 2:  # which of the two it is, nobody knows
                what = f"{_called(result.channels[0])} and {_called(result.channels[1])} differ by {size} dB,"
            what += f" most at {number(at, 3)} Hz"
            do = "Check gain, mounting and fixture: a mean hides it"
            yield Remark("control_disagrees", "warning", what, _where(result), do=do, subject=result.channels[i].column)


def _shape(result: Result) -> Iterator[Remark]:
    """Yield bands that do not have the shape of the profile, where nothing else says why."""
    if _swapped(result)[0]:
        return
    if wrong := list(_wrong_rate(result)):
        yield from wrong
        return
    if list(_low_pass(result)):
        return
    off = list(departures(result, CHANCE))
    if len(off) > SHOWN:
        most = max(off, key=lambda one: abs(one.most))
        what = f"the control has not the shape of the profile: {len(off)} bands are off, the furthest {most}"
        do = "Check that this is the profile of this run, and that the control channel is the one"
        yield Remark("band_off", "warning", what, _where(result), len(off), do)
        return
    tones = [one.frequency for one in lines_of(result).found
             if one.axis < len(result.readings.controls) and one.kind == "line"]  # fmt: skip
    for one in off:
        if any(one.low <= f <= one.high for f in tones):
            continue
        if one.mean > 0.0 and one.carved > CARVED:
            what = f"{one}: its notch of {number(one.carved, 2)} dB there is missing in the run"
            do = "Check that the controller was given this profile: the item saw more than was asked for"
            yield Remark("notch_missing", "warning", what, _where(result), do=do)
        elif one.mean < 0.0 and not one.open_low and not one.open_high:
            names = standing_out(result, one)
            what = f"{one}: the run has a notch that its profile has not"
            if names:
                what += f"; there {listed(names)} {'stands' if len(names) == 1 else 'stand'} out over the control"
            do = "Was a response limited there? Then judge by the profile with that notch"
            yield Remark("notch_not_asked", "warning", what, _where(result), do=do)
        else:
            what = str(one)
            do = "Check the controller's limits and lines there, and that the table and the fixture can follow"
            yield Remark("band_off", "warning", what, _where(result), do=do)


def _wrong_rate(result: Result) -> Iterator[Remark]:
    """Yield a sample rate by which the spectrum is that of the profile, which it is not by the rate that was said.

    Each octave counts alike, in the fine spectrum: the lower edge of the profile tells a wrong rate from a low pass.
    """
    f, (density, _) = result.fine.frequency, result.controlled(result.fine)
    low, high = result.target.band
    width = 2.0 * result.fine.spacing

    def error(times: float, top: float) -> float:
        use = (f - width >= low / times) & (f + width <= min(high / times, top))
        if np.count_nonzero(use) < FEWEST_LINES or high / times > top:
            return math.inf
        away = decibels(density[use] / result.target.at(times * f[use]))
        away = away - np.average(away, weights=1.0 / f[use])
        return math.sqrt(float(np.average(away**2, weights=1.0 / f[use])))

    if not error(1.0, math.inf) > STRAYS:
        return
    rates = np.geomspace(0.125, 8.0, RATES)
    errors = [error(one, float(f[-1]) + width) for one in rates.tolist()]
    i = int(np.argmin(errors))
    if errors[i] < FITS and abs(math.log2(rates[i])) > 0.1:
        rate = 1.0 / result.readings.interval
        what = f"the spectrum has the shape of the profile at {number(float(rates[i]), 3)} times the sample rate, of"
        what += f" {number(rate, 5)} Hz"
        do = "Check the sample rate, or the time column"
        yield Remark("wrong_rate", "error", what, _where(result), do=do)


def _level(result: Result, place: int) -> float:
    return float(decibels(result.channels[place].power.square / result.target.rms(*result.band) ** 2))


def _sampling(result: Result) -> Iterator[Remark]:
    """Yield a profile beyond what the sampling shows, energy that was folded, a low pass inside the band."""
    nyquist, top = 0.5 / result.readings.interval, result.target.band[1]
    if top > nyquist:
        what = f"the profile goes up to {number(top, 5)} Hz, samples show {number(nyquist, 5)} Hz at most"
        do = f"Record {number(2.56 * top, 3)} samples a second or more: what lies above is not judged"
        yield Remark("sample_rate", "error", what, _where(result), do=do)
    elif top > ROLL_OFF * nyquist:
        what = f"the profile goes up to {number(top, 5)} Hz, half of the sampling frequency is {number(nyquist, 5)} Hz"
        do = f"Record {number(2.56 * top, 3)} samples a second or more: no filter against aliasing is so steep"
        yield Remark("sample_rate", "warning", what, _where(result), do=do)
    density, _ = result.controlled(result.spectra)
    f = result.spectra.frequency
    near, inside = (f > TOP * nyquist) & (f > 1.1 * top), (f >= result.band[0]) & (f <= result.band[1])
    if near.any() and inside.any():
        share = float(np.median(density[near]) / np.median(density[inside]))
        if share > FOLDED:
            what = (
                f"below half of the sampling frequency the density is still {number(100.0 * share, 2)} % of the band's"
            )
            do = "No filter against aliasing? What lies above is folded into the band: filter before sampling"
            yield Remark("aliasing", "warning", what, _where(result), do=do)
    yield from _low_pass(result)


def _low_pass(result: Result) -> Iterator[Remark]:
    away, f = result.deviation.value, result.deviation.frequency
    top = float(f[-1])
    last, before = f > top * 2.0**-0.1, (f > top * 2.0**-0.7) & (f <= top * 2.0**-0.5)
    cut_off = result.readings.cut_off
    falls = last.any() and before.any()
    end = float(np.median(away[last])) if falls else 0.0
    fall = float(np.median(away[before])) - end if falls else 0.0
    middle = float(np.median(away))
    known = cut_off is not None and cut_off < result.band[1] and result.readings.own
    if (end < middle - LOW_PASS and fall > STEEP) or known:
        what = f"the control falls off below {number(top, 4)} Hz by {number(fall, 2)} dB within half an octave"
        if known:
            what = f"the sensor's low pass of {number(cut_off or 0.0, 4)} Hz lies inside the profile"
        do = "A low pass before the converter lies in the band: the true level is higher than what was read"
        yield Remark("low_pass", "warning", what, _where(result), do=do)


def lines_of(result: Result) -> Lines:
    """Return sine tones in the channels, in the order of channels."""
    return find_lines(result.fine.as_spectrum(), CHANCE)


def _lines(result: Result) -> Iterator[Remark]:
    """Yield sine tones in the control."""
    count, spectra = len(result.readings.controls), result.spectra
    found: list[str] = []
    for one in lines_of(result).found:
        if one.axis >= count or one.kind != "line" or not result.band[0] <= one.frequency <= result.band[1]:
            continue
        share = 0.5 * one.amplitude**2 / (float(result.target.at(one.frequency)) * spectra.enbw)
        if share > LINE:
            digits = 2 + int(math.log10(one.frequency / result.fine.spacing))  # to a tenth of a line
            size = number(one.amplitude / STANDARD_GRAVITY.value, 2)
            found.append(f"{number(one.frequency, digits)} Hz, amplitude {size} g")
    if found:
        shown = list(dict.fromkeys(found))
        more = f" and {len(shown) - SHOWN} more" if len(shown) > SHOWN else ""
        what = f"sine in the random spectrum: {listed(shown[:SHOWN])}{more}"
        do = "Look for hum, a fan or a rotating part: its density depends on the bandwidth"
        yield Remark("lines", "warning", what, _where(result), len(shown), do)


def _narrow(result: Result) -> Iterator[Remark]:
    """Yield peaks that a line's bandwidth is too coarse for: by the spectrum four times finer."""
    coarse, fine = result.spectra, result.fine
    if fine.spacing >= coarse.spacing:
        return
    times = round(coarse.spacing / fine.spacing)
    count = len(result.readings.controls)  # of a response a resonance may be as narrow as a sine
    tones = {(one.axis, round(one.frequency / coarse.spacing)) for one in lines_of(result).found
             if one.kind == "line" and one.axis < count}  # fmt: skip
    low, high = result.band[0] + 2.0 * coarse.spacing, result.band[1] - 2.0 * coarse.spacing
    use = np.flatnonzero((coarse.frequency >= low) & (coarse.frequency <= high))
    z = -float(special.ndtri(CHANCE / (len(use) * len(result.channels))))
    threshold = max(PEAK, z * NEPER * math.sqrt(2.0 / fine.edf))
    for place, one in enumerate(result.channels):
        own, near = coarse.density[:, place], fine.density[:, place]
        gains = []
        for k in use.tolist():
            at = times * (k + 1) - 1  # the same frequency among the finer lines
            peak = near[max(at - times // 2, 0) : at + times // 2 + 1].max(initial=0.0)
            gains.append(float(decibels(peak / own[k])) if own[k] > 0.0 and peak > 0.0 else 0.0)
        away = np.array(gains)
        away[[i for i, k in enumerate(use.tolist()) if any((place, k + 1 + d) in tones for d in (-2, -1, 0, 1, 2))]] = (
            0.0
        )
        if len(away) and away.max() > threshold:
            f = float(coarse.frequency[use[int(np.argmax(away))]])
            what = (f"{_called(one)} has a peak at {number(f, 4)} Hz that is narrower than a line: its density is "
                    f"{number(float(away.max()), 2)} dB or more too low there")  # fmt: skip
            do = f'Give a finer resolution: "{number(fine.spacing, 3)} Hz"'
            yield Remark("narrow_peaks", "warning", what, _where(result), do=do, subject=one.column)


def _gaps(result: Result) -> Iterator[Remark]:
    missing = result.spectra.missing
    if missing:
        n = len(result.readings)
        level = "warning" if missing > 0.01 * n else "info"
        what = f"{missing} of {n} samples are missing: segments lie between the gaps"
        do = "Look at the logger: gaps shorten what a spectrum is made of"
        yield Remark("gaps", "warning" if level == "warning" else "info", what, _where(result), missing, do)


def _edges(result: Result) -> Iterator[Remark]:
    """Yield what of the profile is not judged."""
    if result.plan.octave is not None:
        return
    low, high = result.band
    first, last = float(result.deviation.frequency[0]), float(result.deviation.frequency[-1])
    spacing = result.spectra.spacing
    if first > 1.6 * low:  # a quarter of the lowest frequency apart, as by default, they begin at 1.5 times it
        what = (
            f"nothing is judged from {number(low, 4)} to {number(first, 4)} Hz: lines are {number(spacing, 3)} Hz apart"
        )
        yield Remark("edges", "warning", what, _where(result), do="Give a finer resolution")
    else:
        what = (f"judged from {number(first, 4)} to {number(last, 5)} Hz: windows of lines beyond reach out of the "
                f"profile of {number(low, 4)} to {number(high, 5)} Hz")  # fmt: skip
        yield Remark("edges", "info", what, _where(result))


__all__ = ["findings", "lines_of", "shape_errors"]
