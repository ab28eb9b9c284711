"""The sweep that a control channel shows: its law, where it starts and ends, its level and what is wrong with it.

A logarithmic sweep has the frequency ``f(t) = f_s exp(k t)``, a linear one ``f(t) = f_s + k t`` [1]_. A ridge of short
spectra gives a first law; then the control channel is turned back by the phase of that law, summed over whole numbers
of cycles, and the phase that is left is fitted again until it no longer moves. The uncertainty of the law is that of
the phase left, in stretches that are taken as independent (``statistics.clustered``): a shaker turns the phase of the
drive slowly as it passes its own resonances, so that neighbouring sums are not.

The ends are where the level rises and falls; their uncertainty is a rectangle as wide as the rise and one cycle.

References
----------
.. [1] IEC 60068-2-6:2007, 4.3: sweep, logarithmic, one octave a minute; here any rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...signals.time.samples import Indices
from ...statistics.clustered import clustered_covariance
from ...statistics.least_squares import fit

FRAME = 0.25  # of short spectra [s]
RANGE = 0.25  # least range of a sweep [octaves]
ACTIVE = 0.2  # of the typical level, from which the drive is on
CYCLES = 8  # that are summed to one phase
STRETCHES = 24  # of the phase left, that are independent
HARMONICS = (2, 3, 4, 5)
RISEN, ABOVE_NOISE = 0.1, 3.0  # of the level, and times the noise, from which it rises
FULL = 0.9  # of the level, where it has risen
LOST = 0.1  # jump of the phase beside the law [cycles]
SWEPT = 0.4  # share of the power of the control that is the sine
STEADY = 0.5  # share of the frames of a sweep that move the one way


@dataclass(frozen=True, eq=False)
class Sweep:
    """One sweep of a record.

    Times count from the first sample of the record [s]; ``rate`` is in octaves a second where the law is logarithmic,
    else in hertz a second, negative downwards.
    """

    law: str  # ``"log"`` or ``"linear"``
    begin: float
    end: float
    at_begin: float  # Frequency there [Hz]
    rate: float
    u_rate: float
    dof: float
    u_start: float  # [Hz]
    u_end: float
    u_law: float  # Of a frequency by the law, relative
    times: Array  # shape (m,): of the sums of cycles
    amplitude: Array  # shape (m,): of the control there
    left: Array  # shape (m,): phase beside the law [cycles]
    harmonics: Array  # shape (4, m): multiples 2 to 5 over the drive; zero beyond 0.45 of the sample rate

    @property
    def start(self) -> float:
        """Frequency at which it starts [Hz]."""
        return self.at_begin

    @property
    def stop(self) -> float:
        """Frequency at which it ends [Hz]."""
        return float(self.frequency(np.array([self.end]))[0])

    @property
    def up(self) -> bool:
        """Whether it goes to higher frequencies."""
        return self.rate > 0.0

    @property
    def lowest(self) -> float:
        """Lowest frequency [Hz]."""
        return min(self.start, self.stop)

    @property
    def highest(self) -> float:
        """Highest frequency [Hz]."""
        return max(self.start, self.stop)

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.end - self.begin

    def frequency(self, times: Array) -> Array:
        """Return the frequency of the drive at some times [Hz]."""
        return _frequency(self.law, (self.at_begin, _inner(self.law, self.rate)), times - self.begin)

    def phase(self, times: Array) -> Array:
        """Return the phase of the drive at some times [rad], zero at the beginning."""
        return _phase(self.law, (self.at_begin, _inner(self.law, self.rate)), times - self.begin)

    def when(self, frequency: float) -> float:
        """Return when the drive passes a frequency [s]."""
        if self.law == "log":
            return self.begin + math.log2(frequency / self.at_begin) / self.rate
        return self.begin + (frequency - self.at_begin) / self.rate


def sweep_duration(start: float, stop: float, rate: float) -> float:
    """Return how long a logarithmic sweep from one frequency to another lasts [s], at ``rate`` octaves a second.

    Examples
    --------
    >>> round(sweep_duration(20.0, 1000.0, 4.0 / 60.0), 3)
    84.658
    """
    return abs(math.log2(stop / start)) / rate


def _inner(law: str, rate: float) -> float:
    return rate * math.log(2.0) if law == "log" else rate


def _frequency(law: str, laws: tuple[float, float], t: Array) -> Array:
    first, k = laws
    return first * np.exp(k * t) if law == "log" else first + k * t


def _phase(law: str, laws: tuple[float, float], t: Array) -> Array:
    first, k = laws
    cycles = first * np.expm1(k * t) / k if law == "log" else first * t + 0.5 * k * t * t
    return 2.0 * np.pi * cycles


def find_sweeps(control: Array, rate: float, where: str = "") -> list[Sweep]:
    """Return the sweeps of a control channel, in order.

    Parameters
    ----------
    control : ndarray, shape (n,)
        Acceleration, without missing samples.
    rate : float
        Samples a second [Hz].
    where : str
        File, for messages.

    Raises
    ------
    DataError
        ``no_sweep`` if there is none.
    """
    times, ridge, level = _ridge(control, rate)
    parts = _monotone(times, ridge, level)
    found = [one for part in parts if (one := _refined(control, rate, times[part], ridge[part], level[part]))]
    if not found:
        what = "the control channel has no swept sine"
        why = "its strongest frequency does not move steadily over a quarter of an octave; steps of a sine do not"
        do = "Check which column was taken for the control"
        raise DataError(what, where, why, do, "no_sweep")
    return found


def _ridge(control: Array, rate: float) -> tuple[Array, Array, Array]:
    """Return times, strongest frequency and its amplitude of short spectra."""
    size = max(64, round(FRAME * rate))
    step = max(1, size // 2)
    count = max((len(control) - size) // step + 1, 0)
    if count < 8:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    window = np.hanning(size)
    padded = 1 << (2 * size - 1).bit_length()
    frequency, level = np.empty(count), np.empty(count)
    for first in range(0, count, 256):
        rows = np.arange(first, min(first + 256, count))
        frames = control[rows[:, None] * step + np.arange(size)]
        spectra = np.abs(np.fft.rfft((frames - frames.mean(axis=1, keepdims=True)) * window, padded, axis=1))
        peak = np.clip(np.argmax(spectra[:, 1:-1], axis=1) + 1, 1, spectra.shape[1] - 2)
        a, b, c = (spectra[np.arange(len(rows)), peak + shift] for shift in (-1, 0, 1))
        curve = a - 2.0 * b + c
        offset = np.divide(0.5 * (a - c), curve, out=np.zeros(len(rows)), where=curve != 0.0)
        frequency[rows] = (peak + offset) * rate / padded
        level[rows] = 2.0 * b / window.sum()
    return np.asarray((np.arange(count) * step + 0.5 * size) / rate), frequency, level


def _monotone(times: Array, ridge: Array, level: Array) -> list[Indices]:
    """Return the frames of each sweep: the drive is on, and moves one way."""
    if not len(times):
        return []
    strong = np.quantile(level, 0.9)
    on = level > ACTIVE * strong
    smooth = _running_median(np.log2(np.maximum(ridge, 1e-9)), 9)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], on.astype(int), [0]])))
    found: list[Indices] = []
    for first, stop in edges.reshape(-1, 2).tolist():
        found += _split(np.arange(first, stop), smooth)
    kept = []
    for part in found:
        moved = np.diff(smooth[part])
        way = np.sign(smooth[part[-1]] - smooth[part[0]])
        steps = moved[moved != 0.0]
        if np.ptp(smooth[part]) >= RANGE and len(steps) and np.mean(np.sign(steps) == way) > STEADY:
            kept.append(part)
    return kept


def _split(part: Indices, smooth: Array) -> list[Indices]:
    """Return a stretch cut where the frequency turns."""
    if len(part) < 8:
        return []
    values = smooth[part]
    for turn in (int(np.argmax(values)), int(np.argmin(values))):
        ahead, behind = values[: turn + 1], values[turn:]
        if 4 < turn < len(part) - 4 and min(np.ptp(ahead), np.ptp(behind)) >= RANGE:
            return [*_split(part[: turn + 1], smooth), *_split(part[turn:], smooth)]
    return [part]


def _running_median(values: Array, size: int) -> Array:
    if len(values) < size:
        return values
    padded = np.pad(values, size // 2, mode="edge")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, size), axis=1))


def _refined(control: Array, rate: float, times: Array, ridge: Array, level: Array) -> Sweep | None:
    """Return a sweep whose phase is fitted; None where no law holds."""
    laws = {}
    middle = times - times[0]
    for law in ("log", "linear"):
        y = np.log(ridge) if law == "log" else ridge
        keep = np.ones(len(y), dtype=bool)
        slope = offset = 0.0
        for _ in range(6):  # frames on a resonance or a harmonic are left out
            slope, offset = np.polyfit(middle[keep], y[keep], 1)
            apart = np.abs(y - offset - slope * middle)
            keep = apart <= max(4.0 * float(np.median(apart)), 1e-9)
        rest = np.log(np.maximum(_frequency(law, _of_line(law, slope, offset), middle), 1e-6) / ridge)
        laws[law] = (float(np.median(np.abs(rest))), _of_line(law, slope, offset))
    order = sorted(laws, key=lambda one: laws[one][0])
    best: tuple[float, Sweep] | None = None
    for law in order:
        found = _phase_fit(control, rate, law, laws[law][1], float(times[0]), float(times[-1]))
        if found is not None:
            spread = float(np.std(found.left))
            if best is None or spread < best[0]:
                best = (spread, found)
    return None if best is None else best[1]


def _of_line(law: str, slope: float, offset: float) -> tuple[float, float]:
    return (math.exp(offset), slope) if law == "log" else (offset, slope)


def _sums(values: Array, rate: float, law: str, laws: tuple[float, float], zero: float, first: float, last: float,
          multiples: tuple[int, ...] = (1,)) -> tuple[Array, list[Array], Array] | None:  # fmt: skip
    """Return middles [s], complex amplitudes of each multiple, and lengths, of sums over whole numbers of cycles."""
    a, b = max(0, math.ceil(first * rate)), min(len(values), math.floor(last * rate))
    if b - a < 64:
        return None
    t = np.arange(a, b) / rate
    frequency = _frequency(law, laws, t - zero)
    if not np.all((frequency > 0.0) & (frequency < 0.5 * rate)):
        good = (frequency > 0.0) & (frequency < 0.5 * rate)
        if np.count_nonzero(good) < 64:
            return None
        t, frequency, a = t[good], frequency[good], a + int(np.argmax(good))
        b = a + len(t)
    phase = _phase(law, laws, t - zero)
    turns = np.floor((phase - min(phase[0], phase[-1])) / (2.0 * np.pi * CYCLES)).astype(np.int64)
    starts = np.flatnonzero(np.diff(turns, prepend=turns[0] - 1))
    if len(starts) < 12:
        return None
    counts = np.diff(np.append(starts, len(turns)))
    own, turn = values[a:b], np.exp(-1j * phase)
    first_order, second = np.add.reduceat(own * turn, starts), np.add.reduceat(turn**2, starts)
    # a straight sum takes what a part of a cycle leaves of the sine itself for its amplitude: solved for instead
    amplitude = (
        2.0 * (counts * first_order - second * first_order.conj()) / np.maximum(counts**2 - np.abs(second) ** 2, 1e-3)
    )
    rest = own - (np.repeat(amplitude, counts) * turn.conj()).real
    sums = [amplitude if m == 1 else 2.0 * np.add.reduceat(rest * turn**m, starts) / counts for m in multiples]
    middles = np.add.reduceat(t, starts) / counts
    whole = slice(1, -1)  # the first and the last need not be whole
    return middles[whole], [one[whole] for one in sums], counts[whole] / rate


def _phase_fit(control: Array, rate: float, law: str, laws: tuple[float, float], zero: float, last: float
               ) -> Sweep | None:  # fmt: skip
    """Return the sweep by the phase of the drive beside a first law."""
    begin, end = zero, last
    middles = left = design = np.zeros(0)
    for turn in range(12):
        found = _sums(control, rate, law, laws, zero, begin, end)
        if found is None:
            return None
        middles, (sums,), _ = found
        left = np.unwrap(np.angle(sums)) / (2.0 * np.pi)
        t = middles - zero
        f = _frequency(law, laws, t)
        if law == "log":  # changes of the cycles by (phase, relative frequency, k)
            design = np.column_stack([np.ones(len(t)), f - laws[0], _slope_of_k(laws, t)])
        else:
            design = np.column_stack([np.ones(len(t)), t, 0.5 * t * t])
        scale = np.max(np.abs(design), axis=0)
        moved = np.linalg.lstsq(design / scale, left, rcond=None)[0] / scale
        laws = _moved(law, laws, moved)
        if laws[0] <= 0.0 or laws[1] == 0.0:
            return None
        if turn > 1 and np.max(np.abs(design @ moved - moved[0])) < 1e-6:
            break
    return _measured(control, rate, law, laws, zero, begin, end)


def _moved(law: str, laws: tuple[float, float], moved: Array) -> tuple[float, float]:
    """Return a law changed by (phase, what moves the first frequency, what moves the rate)."""
    first, k = laws
    return (first * (1.0 + float(moved[1]) * k) if law == "log" else first + float(moved[1])), k + float(moved[2])


def _slope_of_k(laws: tuple[float, float], t: Array) -> Array:
    first, k = laws
    return first * (t * np.exp(k * t) - np.expm1(k * t) / k) / k


def _measured(control: Array, rate: float, law: str, laws: tuple[float, float], zero: float, first: float, last: float
              ) -> Sweep | None:  # fmt: skip
    """Return a sweep with its ends, its level, its harmonics, and the uncertainty of its law."""
    found = _sums(control, rate, law, laws, zero, first, last, (1, *HARMONICS))
    if found is None:
        return None
    sums = found[1]
    typical = float(np.median(np.abs(sums[0])))
    own = control[round(first * rate) : round(last * rate)]
    noise = math.sqrt(max(2.0 * float(np.var(own)) - float(np.mean(np.abs(sums[0]) ** 2)), 0.0))
    low = min(max(RISEN, ABOVE_NOISE * noise / typical), 0.5 * FULL)
    ends = [_edge(control, rate, law, laws, zero, one, typical, low, up)
            for one, up in ((first, True), (last, False))]  # fmt: skip
    if any(one is None for one in ends):
        return None
    (begin, u_begin), (end, u_end) = (one for one in ends if one is not None)
    found = _sums(control, rate, law, laws, zero, begin, end, (1, *HARMONICS))
    if found is None:
        return None
    middles, sums, _ = found
    own = control[round(begin * rate) : round(end * rate)]
    if not len(own) or float(np.mean(np.abs(sums[0]) ** 2)) < 2.0 * SWEPT * float(np.var(own)):
        return None
    t = middles - zero
    left = np.unwrap(np.angle(sums[0])) / (2.0 * np.pi)
    base = np.ones(len(t))
    design = np.column_stack([base, *((t, 0.5 * t * t) if law == "linear" else (
        _frequency(law, laws, t) - laws[0], _slope_of_k(laws, t)))])  # fmt: skip
    scale = np.max(np.abs(design), axis=0)
    fitted = fit(design / scale, left)
    clusters = np.minimum((np.arange(len(t)) * STRETCHES) // len(t), STRETCHES - 1)
    covariance, dof = clustered_covariance(fitted, clusters)
    u = np.sqrt(np.maximum(np.diag(covariance), 0.0)) / scale
    laws = _moved(law, laws, fitted.coefficients / scale)  # the first law was of all that the ridge had
    at_begin = float(_frequency(law, laws, np.array([begin - zero]))[0])
    slope = [abs(_steepness(law, laws, one - zero)) for one in (begin, end)]
    frequency = _frequency(law, laws, t)
    amplitude = np.abs(sums[0])
    harmonics = np.array([
        np.where(m * frequency < 0.45 * rate, np.abs(each), 0.0) / np.maximum(amplitude, 1e-300)
        for m, each in zip(HARMONICS, sums[1:], strict=True)
    ])  # fmt: skip
    return Sweep(
        law, begin, end, at_begin, laws[1] / (math.log(2.0) if law == "log" else 1.0),
        float(u[2]) / (math.log(2.0) if law == "log" else 1.0), float(dof[2]), slope[0] * u_begin, slope[1] * u_end,
        float(u[1] * abs(laws[1])) if law == "log" else float(u[1] / laws[0]), middles, amplitude,
        left - fitted.design @ fitted.coefficients, harmonics,
    )  # fmt: skip


def _steepness(law: str, laws: tuple[float, float], t: float) -> float:
    return laws[1] * float(_frequency(law, laws, np.array([t]))[0]) if law == "log" else laws[1]


def _edge(control: Array, rate: float, law: str, laws: tuple[float, float], zero: float, near: float, typical: float,
          risen: float, up: bool) -> tuple[float, float] | None:  # fmt: skip
    """Return when the level rises (or falls), and its standard uncertainty [s]."""
    frequency = float(_frequency(law, laws, np.array([near - zero]))[0])
    if not 0.0 < frequency < 0.5 * rate:
        return None
    cycle = max(2, round(rate / frequency))
    reach = max(round(FRAME * rate), 4 * cycle)
    a, b = max(0, round(near * rate) - 3 * reach), min(len(control), round(near * rate) + 3 * reach)
    part = control[a:b] - np.mean(control[a:b])
    if len(part) < 2 * cycle:
        return None
    total = np.concatenate([[0.0], np.cumsum(part**2)])
    level = np.sqrt(np.maximum(2.0 * (total[cycle:] - total[:-cycle]) / cycle, 0.0))
    at = a + np.arange(len(level)) + 0.5 * (cycle - 1)
    order = slice(None) if up else slice(None, None, -1)
    low, high = ((level > share * typical)[order] for share in (risen, FULL))
    at = at[order]
    if not low.any():
        return None
    if low[0]:  # it is on from the first sample
        return float(at[0] / rate), cycle / rate / math.sqrt(12.0)
    where = int(np.argmax(high)) if high.any() else len(at) - 1
    off = np.flatnonzero(~low[: where + 1])
    rise = at[off[-1] if len(off) else 0], at[where]
    middle, width = 0.5 * (rise[0] + rise[1]), abs(rise[1] - rise[0])
    ramp = max(float(width) - cycle, 0.0)  # the mean over a cycle widens a step by one
    outward = (-1.0 if up else 1.0) * ramp * 0.5 * (FULL + risen) / (FULL - risen)
    return float((middle + outward) / rate), max(float(cycle), ramp) / rate / math.sqrt(12.0)


__all__ = ["Sweep", "find_sweeps", "sweep_duration"]
