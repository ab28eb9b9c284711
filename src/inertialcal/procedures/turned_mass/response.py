"""Response of one run: the harmonics of its turn in the readings, apart from drift and from lines of the orbit.

Harmonics 1 to 3 and the lines of the orbit are fitted together, by weights that no smooth drift enters and with the
noise that the sums without all of these show (``signals.sine``): that of all runs together where it may be the same.
What the gate takes off each harmonic, ``sin(x) / x`` with x half of its angle over a gate, is put back.

Single false readings are left out, by their distance from the fit. A jump of the level is taken off, and named.

A run is of no use for the scale factor where a line of the orbit lies within a resolution of its turn: what the orbit
does to the instrument cannot be told from what the mass does. A higher harmonic that meets such a line is left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...physics.turned_mass import HIGHEST
from ...signals.sine.changes import jumps
from ...signals.sine.fit import FEWEST_CYCLES
from ...signals.sine.noise import Noise, noise_of, same_noise
from ...signals.sine.smooth import LENGTH, stretch_of
from .readings import Run

CELLS = 12.0  # of a turn, over which samples are averaged
LARGEST = 300  # cells that are fitted at once
HALF = 0.5
RESOLVED = 1.0  # cycles by which lines must differ over a run
SLOW = 0.34  # of the rate of turn: slower lines of the orbit are smooth drift
LEFT = 0.2  # of a harmonic, that the gate must leave
NYQUIST = 0.45  # turns a sample of the highest harmonic that samples show
OFF = 6.0  # standard deviations from the fit, from which a reading is false
ROUNDS = 5
FEWEST = 4  # sums that show the noise
SHORT = 0.01  # of the fewest turns, that the ends of a record may lack
ROUNDING = 1e-6
NOTHING = 1e-13  # of the readings: less is no noise
ROBUST = 0.6745  # median of |x| of normal noise
CHANCE = 1e-4  # of a false jump


class Jump(NamedTuple):
    """A jump of the level."""

    time: float  # From the start of the run [s]
    size: float  # [count/s]


@dataclass(frozen=True, eq=False)
class Response:
    """Harmonics of one run."""

    run: Run
    harmonics: tuple[int, ...]  # That are there, ascending; 1 is always
    values: Array  # Cosine and sine of each [count/s], shape (2 k,)
    # Their covariance for white noise of a unit variance of a sample, and for a walk of a unit variance a second,
    # shape (2 k, 2 k) each
    white: Array
    walk: Array
    contrasts: tuple[Array, Array]  # Sums without all that is fitted, and the variance of each for that walk
    noise: Noise
    met: int = 0  # Which multiple of the orbital rate its turn meets; 0 for none
    left_out: tuple[int, ...] = ()  # Indices of false readings
    jump: Jump | None = None  # Of the level, which was taken off
    # shape (n,), at the readings [count/s]: drift with lines of the orbit, and the harmonics
    drift: Array = field(default_factory=lambda: np.empty(0))
    line: Array = field(default_factory=lambda: np.empty(0))

    @property
    def covariance(self) -> Array:
        """Of the values [count^2/s^2]."""
        return covariance_of(self.noise, self.white, self.walk)

    @property
    def u(self) -> Array:
        """Standard uncertainties of the values."""
        return np.sqrt(np.diag(self.covariance))

    def value(self, harmonic: int) -> tuple[float, float, float]:
        """Return cosine and sine of a harmonic, and the standard uncertainty of the cosine; NaN where it is not."""
        if harmonic not in self.harmonics:
            return math.nan, math.nan, math.nan
        at = 2 * self.harmonics.index(harmonic)
        return float(self.values[at]), float(self.values[at + 1]), float(self.u[at])


def covariance_of(noise: Noise, white: Array, walk: Array) -> Array:
    """Return the covariance of sums of readings, by those for white noise and for a walk of unit size."""
    each = noise.chance[:, 0] * noise.level[:, 0]
    return np.asarray(float(each @ (1.0 - noise.share)) * white + float(each @ noise.share) / noise.unit * walk)


def responses_of(runs: Sequence[Run], orbit: float, orbit_lines: int) -> list[Response]:
    """Return the responses of runs of one instrument.

    Parameters
    ----------
    runs : sequence of Run
        Their readings and turns.
    orbit : float
        Orbital rate [rad/s].
    orbit_lines : int
        Multiples of it that are fitted.

    Raises
    ------
    DataError
        ``too_few_cycles`` below six turns, ``nyquist`` or ``averaged_out`` where samples do not show the turn,
        ``no_scatter`` without noise.
    """
    alone = [_alone(run, orbit, orbit_lines) for run in runs]
    if len(alone) < 2:
        return alone
    sums, walks = ([one.contrasts[part] for one in alone] for part in (0, 1))
    together = noise_of([each[:, None] for each in sums], walks)
    return [replace(one, noise=together) for one in alone] if same_noise(sums, walks, together) else alone


def _alone(run: Run, orbit: float, orbit_lines: int) -> Response:
    turns = (run.times[-1] - run.times[0] + run.gate) / run.turn.period
    if turns < FEWEST_CYCLES * (1.0 - SHORT):
        what = f"run {run.name}: {turns:.3g} turns of {run.turn.named.lstrip('+-')}"
        do = f"Turn for {FEWEST_CYCLES * run.turn.period / 3600.0:.3g} h or more"
        raise DataError(what, run.where, "drift and turn cannot be separated", do, "too_few_cycles")
    columns = _columns(run, orbit, orbit_lines)
    kept = np.ones(len(run.times), dtype=bool)
    found = _fitted(run, columns, kept)
    jump = _jump(run, found)
    if jump is not None:
        level = np.where(run.times >= jump.time, jump.size, 0.0)
        run = replace(run, reading=run.reading - level)
        found = _fitted(run, columns, kept)
    for _ in range(ROUNDS):
        rest = np.abs(run.reading - found.drift - found.line)
        good = rest <= OFF * float(np.median(rest[kept])) / ROBUST
        if (good == kept).all() or np.count_nonzero(good) < HALF * len(good):
            break
        kept = good
        found = _fitted(run, columns, kept)
    return replace(found, left_out=tuple(np.flatnonzero(~kept).tolist()), jump=jump)


def _jump(run: Run, found: Response) -> Jump | None:
    """Return the jump of the level in a run; None where there is none."""
    step = float(np.median(np.diff(run.times)))
    place = np.rint((run.times - run.times[0]) / step).astype(np.int64)
    even = np.full(int(place[-1]) + 1, np.nan)
    even[place] = run.reading - found.line
    own = jumps([even], CHANCE)[0]
    return None if own is None else Jump(float(run.times[0]) + own.at * step - HALF * step, own.size)


@dataclass(frozen=True, eq=False)
class _Columns:
    """What is fitted beside drift."""

    harmonics: tuple[int, ...]
    met: int
    at: Array  # shape (n, 2 harmonics + 2 lines of the orbit): at the samples


def _columns(run: Run, orbit: float, orbit_lines: int) -> _Columns:
    rate, span = abs(run.turn.rate), float(run.times[-1] - run.times[0]) + run.gate
    step = float(np.median(np.diff(run.times)))
    if rate * step > math.pi:
        what = f"run {run.name}: a turn takes {run.turn.period:.4g} s, samples come every {step:.4g} s"
        why = "the turn is above half of the sampling frequency and would alias"
        raise DataError(what, run.where, why, "Check the rate of the programme and its unit", "nyquist")
    multiples = range(1, HIGHEST + 1)
    passed = {k: float(np.sinc(k * rate * run.gate / (2.0 * math.pi))) for k in multiples}
    if passed[1] < LEFT:
        what = f"run {run.name}: a gate of {run.gate:g} s, a turn of {run.turn.period:.4g} s"
        raise DataError(what, run.where, "the gate averages the turn out", "Turn more slowly", "averaged_out")
    lines = [k for k in range(1, orbit_lines + 1) if SLOW * rate < k * orbit < HIGHEST * rate]

    def meets(harmonic: int, line: int) -> bool:
        return abs(harmonic * rate - line * orbit) * span < 2.0 * math.pi * RESOLVED

    met = next((k for k in lines if meets(1, k)), 0)
    lines = [k for k in lines if k != met]
    shown = [k for k in multiples[1:] if passed[k] > LEFT and k * rate * step < 2.0 * math.pi * NYQUIST]
    harmonics = (1, *(k for k in shown if not any(meets(k, line) for line in lines)))
    angle = run.angle
    waves = [passed[k] * wave(k * angle) for k in harmonics for wave in (np.cos, np.sin)]
    waves += [wave(k * orbit * run.times) for k in lines for wave in (np.cos, np.sin)]
    return _Columns(harmonics, met, np.column_stack(waves))


def _fitted(run: Run, columns: _Columns, kept: NDArray[np.bool_]) -> Response:
    """Return all amplitudes by the readings that are kept; drift and line at all of them."""
    step = float(np.median(np.diff(run.times)))
    many = max(int(run.turn.period / CELLS / step), 1)
    cell = np.floor((run.times - run.times[0]) / step / many + ROUNDING).astype(np.int64)
    counts = np.bincount(cell[kept], minlength=int(cell[-1]) + 1)
    enough = counts >= max(HALF * many, 1.0)

    def means(values: Array) -> Array:
        return np.asarray(np.bincount(cell[kept], values[kept], len(counts))[enough] / counts[enough])

    level = float(np.median(run.reading[kept]))
    times, readings = means(run.times) / run.turn.period, means(run.reading) - level
    at = np.column_stack([means(one) for one in columns.at.T])
    edges = np.linspace(0, len(times), -(-len(times) // LARGEST) + 1).astype(int)
    parts = [slice(int(a), int(b)) for a, b in pairwise(edges)]
    stretches = [stretch_of(times[p].copy(), np.ascontiguousarray(at[p]), many * step / run.turn.period) for p in parts]
    weights = [one.weights_of_drift(LENGTH) for one in stretches]
    shares = np.array([1.0 / float(w[0] @ w[0]) for w in weights])
    shares /= shares.sum()
    values = np.asarray(sum(a * (w @ readings[p]) for a, w, p in zip(shares, weights, parts, strict=True)))
    white = np.asarray(sum(a**2 * (w @ w.T) for a, w in zip(shares, weights, strict=True)))
    walk = np.asarray(sum(a**2 * (w @ one.walk @ w.T) for a, w, one in zip(shares, weights, stretches, strict=True)))
    contrasts = np.concatenate([one.uncorrelated[0].T @ readings[p] for one, p in zip(stretches, parts, strict=True)])
    walks = np.concatenate([one.uncorrelated[1] for one in stretches]) * many * many * step
    if len(walks) < FEWEST:
        what = f"run {run.name}: {len(readings)} readings do not show their noise"
        raise DataError(what, run.where, do="Turn for longer", code="too_few_cycles")
    if not float(np.max(np.abs(contrasts))) > NOTHING * float(np.max(np.abs(run.reading))):
        what = f"run {run.name}: nothing but the turn and drift"
        raise DataError(what, run.where, "its noise cannot be estimated", code="no_scatter")
    contrasts *= math.sqrt(many)
    own = 2 * len(columns.harmonics)
    slow = np.concatenate(
        [one.drift((readings[p] - at[p] @ values)[:, None])[:, 0] for one, p in zip(stretches, parts, strict=True)]
    )  # fmt: skip
    drift = np.interp(run.times / run.turn.period, times, slow) + level + columns.at[:, own:] @ values[own:]
    return Response(
        run, columns.harmonics, values[:own], white[:own, :own] / many, walk[:own, :own] * many * step,
        (contrasts, walks), noise_of([contrasts[:, None]], [walks]), columns.met, drift=drift,
        line=columns.at[:, :own] @ values[:own],
    )  # fmt: skip
