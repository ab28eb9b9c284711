"""By how much noise figures must be inflated for a filter: what a sensor in use has beside its noise at rest.

A filter with a bias state an axis carries white noise, a bias that wanders, and what is known of the bias at first.
What the calibration leaves is none of these by itself; each line of the budget says as what it is carried::

    what                                size of the error                        carried as
    noise at rest                       N; K, sigma and t_c, or B at a horizon   white; walk or Gauss-Markov
    bias of the model, turn-on          u of the mean over the span; scatter     start of the bias
    temperature                         sd of the error over the span            Gauss-Markov, t_c of temperature
    scale factor, misalignment          u of a row of M times the motion         white, N^2 = 2 s^2 t_c of the motion
    g-sensitivity                       u of a row of G times the force          white, N^2 = 2 s^2 t_c of the motion
    gravity on both                     u of a row of M, or of G, times it       start of the bias
    vibration beyond half the rate      sd of what is folded back                white, N^2 = s^2 / rate

An error s n(t) with the covariance s^2 exp(-t/t_c) adds, over times well beyond t_c, as much angle (velocity) as white
noise of the two-sided density 2 s^2 t_c [1]_. That is how an error of scale factor becomes noise: the motion is never
twice the same. Below t_c it is less than that, so the figure is on the safe side. A Gauss-Markov bias in a filter that
has walks alone is driven by ``q = s sqrt(2 / t_c)``, exact for times well below t_c.

Cross terms of gyros are partly a common turn of their axes, an antisymmetric matrix: however far the body turns, it
adds no more than its own angle to the attitude, for ``d(R a)/dt = R (w x a)``. Only what is symmetric, that the axes
are not square to each other, accumulates, and is counted.

Gravity does not average out of a body that stays level: what is left of scale factor and misalignment is a bias of the
accelerometers there, what is left of g-sensitivity one of the gyros. Here a common turn of the axes counts.

A filter that estimates scale factors itself (KF-GINS) is told what is left of them, and the line is not in its noise.

The temperature is taken to lie anywhere within the span with the same chance: a bias that is a straight line in T has
the standard deviation ``slope span / sqrt(12)``. The mean over the span is a constant, and belongs to the start.

References
----------
.. [1] A. Gelb (ed.), Applied Optimal Estimation, MIT Press, 1974, section 3.8: shaping filters; S(0) = 2 s^2 t_c.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.polynomial import Polynomial

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import DataError, PlanError, UsageError
from ...core.estimate import Array
from ...core.units import factor
from ...signals.spectrum.density import Spectrum
from ..model.sensor_model import SensorModel
from .state_space import StateSpace, bias_state
from .terms import GaussMarkov, RandomWalk, RateRandomWalk, Term, terms_of
from .to_filters import (
    FilterBlock,
    Setting,
    outside_px4,
    sensor_noise,
    to_gtsam,
    to_kalibr,
    to_kf_gins,
    to_openvins,
    to_px4,
    to_ros,
)

POINTS = 201  # of the temperature over its span
Carried = Literal["white", "walk", "gauss_markov", "start"]
Part = Literal["bias", "temperature", "matrix", "g_sensitivity"]
PARTS: tuple[Part, ...] = ("bias", "temperature", "matrix", "g_sensitivity")
AT_REST, SCALE_FACTOR = "noise at rest", "scale factor"
PAIRS = (  # what means nothing without the other
    ("temperature_span", "temperature_time"), ("motion", "motion_time"), ("force", "time_of_force"),
    ("rectification", "vibration"), ("folded", "sample_rate"),
)  # fmt: skip


@dataclass(frozen=True)
class Use:
    """How a sensor is used, SI; what is None is not known, and is not in the budget.

    Raises
    ------
    PlanError
        If a size is negative or not finite, or one of a pair is missing.
    """

    temperature_span: float | None = None  # From coldest to warmest [K]
    temperature_time: float | None = None  # Correlation time of the temperature [s]
    temperature: float | None = None  # Middle of the span [degC]; that of the model's range where None
    motion: float | None = None  # Rms angular rate along each axis [rad/s]
    force: float | None = None  # Rms change of specific force along each axis [m/s^2]
    motion_time: float | None = None  # Correlation time of the motion [s]
    force_time: float | None = None  # Correlation time of the specific force [s]; that of the motion where None
    turn_on: float | None = None  # Scatter of the bias between power-ups [input unit]; that of the model where None
    residual: float | None = None  # Bias over temperature that the polynomial leaves, rms [input unit]
    steady_force: float = STANDARD_GRAVITY.value  # Specific force that stays: 1 g on the ground, 0 in orbit [m/s^2]
    g_sensitivity: float | None = None  # Of gyros, not compensated [(rad/s)/(m/s^2)]
    rectification: float | None = None  # Shift of the bias by vibration [input unit/(m/s^2)^2]
    vibration: float | None = None  # Rms acceleration of the vibration [m/s^2]
    folded: float | None = None  # Rms of vibration beyond half the sample rate, in the sensor's own unit
    sample_rate: float | None = None  # Of the readings that the filter takes [Hz]
    horizon: float | None = None  # Averaging time at which a walk stands in for all that wanders at rest [s]
    without: tuple[Part, ...] = ()  # Parts of the model that are not applied in use

    def __post_init__(self) -> None:
        for name, value in self.__dict__.items():
            if isinstance(value, float | int) and name != "temperature" and not (np.isfinite(value) and value >= 0.0):
                raise PlanError(f"{name.replace('_', ' ')} of {value}", do="Give a size: zero or more")
        for one, other in PAIRS:
            first, second = (name.replace("_", " ") for name in (one, other))
            if getattr(self, one) and getattr(self, other) is None:
                raise PlanError(f"{first} without {second}", do=f"Give both: {SAID.get(other, second)}")
            if getattr(self, one) and not getattr(self, other) and other != "vibration":
                raise PlanError(f"{second} of 0", do="Give a size that is positive")

    @property
    def time_of_force(self) -> float | None:
        """Correlation time of the specific force [s]."""
        return self.motion_time if self.force_time is None else self.force_time


SAID = {
    "temperature_time": "the time over which the temperature changes by much of its span",
    "motion_time": "the time over which the motion becomes another one",
    "time_of_force": "the time over which the force becomes another one",
    "vibration": "a recording of the vibration",
    "sample_rate": "the sample rate of the filter",
}


@dataclass(frozen=True, eq=False)
class Line:
    """One source of error, as a filter carries it."""

    source: str  # What it comes from: ``"scale factor"``
    carried: Carried
    # shape (k,): of each axis: N of white noise [unit sqrt(s)], K of a walk [unit/sqrt(s)], else a standard deviation
    # [unit]
    size: Array
    time: Array | None = None  # shape (k,): correlation time of Gauss-Markov noise [s]
    how: str = ""  # How it was worked out, in words


@dataclass(frozen=True, eq=False)
class Budget:
    """What a filter must carry of a sensor."""

    kind: str  # ``"gyro"`` or ``"accelerometer"``
    axes: tuple[str, ...]
    unit: str  # Of the readings, SI
    lines: tuple[Line, ...]
    not_counted: tuple[str, ...] = field(default=())  # What is not known, and how to say it
    # shape (k,): standard deviation of what is left of the scale factor [1], whatever the motion; None where not known
    scale_factor: Array | None = None

    @property
    def with_scale_factor_states(self) -> Budget:
        """What is left for noise in a filter that estimates scale factors itself."""
        if self.scale_factor is None:
            return self
        return replace(self, lines=tuple(line for line in self.lines if line.source != SCALE_FACTOR))

    def _of(self, carried: Carried) -> list[Line]:
        return [line for line in self.lines if line.carried == carried]

    @property
    def white(self) -> Array:
        """Total white noise, shape (k,): N [unit sqrt(s)]."""
        return _root_sum([line.size for line in self._of("white")], len(self.axes))

    @property
    def drive(self) -> Array:
        """Total driving noise of the bias, shape (k,): that of a walk [unit/sqrt(s)]."""
        driven = [line.size * np.sqrt(2.0 / line.time) for line in self._of("gauss_markov") if line.time is not None]
        return _root_sum([line.size for line in self._of("walk")] + driven, len(self.axes))

    @property
    def start(self) -> Array:
        """Standard deviation of the bias at the start, shape (k,) [unit]."""
        lines = (*self._of("start"), *self._of("gauss_markov"))
        return _root_sum([line.size for line in lines], len(self.axes))

    @property
    def at_rest(self) -> Budget:
        """The bare figures of a record at rest."""
        lines = tuple(line for line in self.lines if line.source == AT_REST)
        return Budget(self.kind, self.axes, self.unit, lines)

    @property
    def inflation(self) -> dict[str, Array]:
        """Total over the bare figure, of white noise and of what drives the bias, shape (k,); NaN without one."""
        bare = self.at_rest
        with np.errstate(divide="ignore", invalid="ignore"):
            pairs = {"white": (self.white, bare.white), "drive": (self.drive, bare.drive)}
            return {name: np.where(own > 0.0, total / own, np.nan) for name, (total, own) in pairs.items()}

    def terms(self, axis: int) -> tuple[Term, ...]:
        """Return what a filter with states for each Gauss-Markov line carries of an axis."""
        found: list[Term] = [RandomWalk(float(self.white[axis]))] if self.white[axis] else []
        walk = float(_root_sum([line.size for line in self._of("walk")], len(self.axes))[axis])
        found += [RateRandomWalk(walk)] if walk else []
        found += [GaussMarkov(float(line.size[axis]), float(line.time[axis])) for line in self._of("gauss_markov")
                  if line.time is not None and line.size[axis]]  # fmt: skip
        return tuple(found)

    def walk_terms(self, axis: int) -> tuple[Term, ...]:
        """Return what a filter with one walk an axis carries: all that wanders in one."""
        found: list[Term] = [RandomWalk(float(self.white[axis]))] if self.white[axis] else []
        return (*found, RateRandomWalk(float(self.drive[axis]))) if self.drive[axis] else tuple(found)

    def state_space(self, axis: int, dt: float) -> StateSpace:
        """Return F and Q, and Phi and Qd of a step, of an axis: its integral, and a state a line that wanders.

        Raises
        ------
        PlanError
            If the step is not positive, or the axis has no line that a filter carries.
        """
        terms = self.terms(axis)
        if not terms:
            raise PlanError(f"{self.kind} {self.axes[axis]}: nothing to carry", do="Give its noise, or how it is used")
        return bias_state(terms, dt)

    def message_variance(self, sample_rate: float) -> Array:
        """Return the variance of a single reading, shape (k,) [unit^2]: white noise of a sample, and the bias."""
        return np.asarray(self.white**2 * sample_rate + self.start**2)


def _root_sum(parts: Sequence[Array], k: int) -> Array:
    total = np.zeros(k)
    for one in parts:
        total = total + np.asarray(one) ** 2
    return np.asarray(np.sqrt(total))


def filter_budget(model: SensorModel, use: Use, noise: Mapping[str, Sequence[Term]] | None = None) -> Budget:
    """Return what a filter must carry of a sensor, line by line.

    Parameters
    ----------
    model : SensorModel
        Whose uncertainties say what calibration leaves.
    use : Use
        Temperatures, motion and vibration in use; parts of the model that are not applied.
    noise : mapping of str to sequence of Term, optional
        Terms of the noise at rest by axis, SI; one axis stands for all. Those of the model if not given.

    Raises
    ------
    DataError
        ``no_noise`` where neither has terms of the noise for all axes.
    PlanError
        If the noise has a term twice, or the horizon is not positive.
    """
    lines, missing = _noise_lines(model, use, noise)
    spread, constant, more = _temperature(model, use)
    lines += _start(model, use, constant, missing)
    missing += more
    if use.temperature_span is not None and use.temperature_time and np.any(spread):
        without = "temperature" in use.without
        how = f"sd of {'the bias' if without else 'the error of the bias'} over {use.temperature_span:g} K"
        times = np.full(len(model.axes), use.temperature_time)
        lines.append(
            Line("temperature, not compensated" if without else "temperature", "gauss_markov", spread, times, how)
        )
    elif use.temperature_span:
        missing.append(
            f"{model.kind}: temperature: the model knows no error of its bias over temperature: state a residual"
        )
    own, cross, whole = _rows(model, "matrix" in use.without)
    lines += _motion(model, use, own, cross, missing)
    lines += _gravity(model, use, whole)
    lines += _vibration(model, use, missing)
    missing += _untouched(model)
    kept = tuple(line for line in lines if np.any(line.size))
    return Budget(model.kind, model.axes, model.unit, kept, tuple(missing), own if np.all(own) else None)


def _noise_lines(
    model: SensorModel, use: Use, noise: Mapping[str, Sequence[Term]] | None
) -> tuple[list[Line], list[str]]:
    held = {} if model.noise is None else {axis: terms_of(model.noise, model.kind, axis) for axis in model.axes}
    held = held if noise is None else {axis: tuple(own) for axis, own in noise.items()}
    alone = next(iter(held.values())) if len(held) == 1 else ()
    terms = [held.get(axis, alone) for axis in model.axes]
    if not terms or not all(terms):
        raise DataError(
            f"no noise of every axis of the {model.kind}", model.source,
            why="a filter needs the white noise of a reading, and that comes from a record at rest",
            do="Give it beside the model: inertialcal filter MODEL NOISE, a recording at rest or terms.json of allan",
            code="no_noise",
        )  # fmt: skip
    found = [sensor_noise(model.kind, [one], use.horizon) for one in terms]
    white = np.array([one.white[0] for one in found])
    drive = np.array([one.drive[0] for one in found])
    times = np.array([one.times[0] for one in found])
    left = dict.fromkeys(said for one in found for said in one.left)
    do = "give a horizon, over which a walk stands in for it"
    missing = [f"{said}: {do}" if use.horizon is None else said for said in left]
    if np.any(np.isnan(white)):
        raise DataError(f"no white noise of every axis of the {model.kind}", model.source,
                        do="Give a record at rest that shows it", code="no_noise")  # fmt: skip
    lines = [Line(AT_REST, "white", white, how="N")]
    markov = np.isfinite(times)
    sizes = np.where(markov, drive * np.sqrt(0.5 * np.where(markov, times, 1.0)), 0.0)
    walks = np.where(markov | np.isnan(drive), 0.0, drive)
    how = " or ".join(dict.fromkeys(one.source for one in found))
    lines += [Line(AT_REST, "walk", walks, how=how), Line(AT_REST, "gauss_markov", np.nan_to_num(sizes),
                                                          np.where(markov, times, 1.0), "sigma and t_c")]  # fmt: skip
    if np.any(np.isnan(drive)):
        missing.append(f"{model.kind}: the record shows no wandering of the bias: give a horizon, or a longer record")
    return lines, missing


def _temperature(model: SensorModel, use: Use) -> tuple[Array, Array, list[str]]:
    """Return sd over the span and sd of the mean over it of the error of the bias, shape (k,); what is not known."""
    k, missing = len(model.axes), []
    middle = use.temperature
    if middle is None:
        middle = 0.5 * sum(model.temperature_range) if model.temperature_range else None
    if middle is None and model.reference_temperature is not None:
        middle = float(np.mean(model.reference_temperature))
    span = use.temperature_span or 0.0
    T = (0.0 if middle is None else middle) + span * np.linspace(-0.5, 0.5, POINTS if span else 1)
    spread, constant = np.zeros(k), np.zeros(k)
    for i, axis in enumerate(model.axes):
        away = T - (model.reference_temperature[i] if model.reference_temperature is not None else 0.0)
        orders = _orders(model)
        powers = away[:, np.newaxis] ** np.arange(orders + 1)
        covariance = _covariance(
            model, [f"bias_{axis}", *(f"bias_temperature_{j}_{axis}" for j in range(1, orders + 1))]
        )
        mean = powers.mean(axis=0)
        apart = (powers - mean).T @ (powers - mean) / len(T)
        constant[i], spread[i] = mean @ covariance @ mean, float(np.sum(covariance * apart))
        if "temperature" in use.without and model.bias_temperature is not None:
            curve = Polynomial([0.0, *model.bias_temperature[:, i]])(away)
            spread[i] += float(np.var(curve))
            constant[i] += float(np.mean(curve) ** 2)
        if "bias" in use.without:
            constant[i] += float(model.bias[i] ** 2)
    if use.residual:
        spread += use.residual**2
    if use.temperature_span is None:
        missing.append(f"{model.kind}: temperature: give its span, and the time over which it changes")
    ends = model.temperature_range
    if ends is not None and _orders(model) and not ends[0] <= T.min() <= T.max() <= ends[1]:
        missing.append(
            f"{model.kind}: temperature: {T.min():g} to {T.max():g} degC in use goes beyond {ends[0]:g} to {ends[1]:g} "
            "degC of the model: nothing is known of its bias there"
        )
    missing += _unheld(model, "bias", {axis: [f"bias_{axis}"] for axis in model.axes})
    if model.estimate is None:
        missing.append(f"{model.kind}: uncertainty of the calibration: the model has none")
    return np.sqrt(np.maximum(spread, 0.0)), np.sqrt(np.maximum(constant, 0.0)), missing


def _orders(model: SensorModel) -> int:
    """Return how many powers of the temperature the bias has."""
    return 0 if model.bias_temperature is None else len(model.bias_temperature)


def _covariance(model: SensorModel, names: Sequence[str]) -> Array:
    """Return the covariance of parameters, those that the estimate does not hold as exact."""
    out = np.zeros((len(names), len(names)))
    if model.estimate is None:
        return out
    held = {name: i for i, name in enumerate(model.estimate.names)}
    here = [i for i, name in enumerate(names) if name in held]
    there = [held[names[i]] for i in here]
    out[np.ix_(here, here)] = model.estimate.covariance[np.ix_(there, there)]
    return out


def _unheld(model: SensorModel, what: str, names: Mapping[str, Sequence[str]]) -> list[str]:
    """Return what to say of parameters, by axis, that the model has no uncertainty of."""
    held = set() if model.estimate is None else set(model.estimate.names)
    axes = [axis for axis, own in names.items() if not held & set(own)]
    said = f"{model.kind}: {what} of {', '.join(axes)}: the model has no uncertainty of it, none is counted"
    return [said] if axes and model.estimate is not None else []


def _start(model: SensorModel, use: Use, constant: Array, missing: list[str]) -> list[Line]:
    k = len(model.axes)
    turn_on = model.bias_run_to_run if use.turn_on is None else np.full(k, use.turn_on)
    if turn_on is None:
        missing.append(f"{model.kind}: turn-on: the model has no scatter of the bias between power-ups; state it")
        turn_on = np.zeros(k)
    how = "u of the mean over the span" if use.temperature_span else "u"
    return [Line("bias of the model", "start", constant, how=how),
            Line("turn-on", "start", np.asarray(turn_on), how="scatter between power-ups")]  # fmt: skip


def _motion(model: SensorModel, use: Use, own: Array, cross: Array, missing: list[str]) -> list[Line]:
    """Return the lines that grow with the motion: scale factor, misalignment, g-sensitivity."""
    found = []
    size = use.motion if model.kind == "gyro" else use.force
    what = "the rms rate" if model.kind == "gyro" else "the rms change of specific force"
    unit = "deg/s" if model.kind == "gyro" else model.unit
    said = "" if size is None else f"{size * factor(model.unit, unit):.3g} {unit}"
    if size is None:
        missing.append(f"{model.kind}: scale factor and misalignment: give {what} of the motion, and its time")
    else:
        missing += _unheld(model, "scale factor", {axis: [f"scale_factor_error_{axis}"] for axis in model.axes})
        others = {axis: [f"misalignment_{axis}{one}" for one in model.axes if one != axis] for axis in model.axes}
        alone = [f"{model.kind}: misalignment: a model of one axis has none"]
        missing += _unheld(model, "misalignment", others) if len(model.axes) > 1 else alone
        for source, row in ((SCALE_FACTOR, own), ("misalignment", cross)):
            time = use.motion_time if model.kind == "gyro" else use.time_of_force
            found.append(_white(source, row * size, time, f"{said} rms"))
    if model.kind != "gyro":
        return found
    rows = _force_rows(model, use)
    if rows is None:
        missing.append("gyro: g-sensitivity: the model has none: state it, such as 0.02 deg/s/g")
    elif use.force is None:
        missing.append("gyro: g-sensitivity: give the rms change of specific force, and its time")
    else:
        found.append(_white("g-sensitivity", rows * use.force, use.time_of_force, f"{use.force:.3g} m/s^2 rms"))
    return found


def _force_rows(model: SensorModel, use: Use) -> Array | None:
    """Return the error of each gyro for a unit of specific force along each axis; None where nothing is known."""
    if use.g_sensitivity is not None:
        return np.full(len(model.axes), use.g_sensitivity)
    if model.g_sensitivity is None:
        return None
    left = 0.0 if "g_sensitivity" not in use.without else np.sum(model.g_sensitivity**2, axis=1)
    traces = [np.trace(_covariance(model, [f"g_sensitivity_{axis}{f}" for f in "xyz"])) for axis in model.axes]
    return np.asarray(np.sqrt(np.array(traces) + left))


def _gravity(model: SensorModel, use: Use, whole: Array) -> list[Line]:
    """Return the bias that a steady force makes of what is left of the matrix, or of the g-sensitivity."""
    how = f"{use.steady_force:.3g} m/s^2 steady"
    if model.kind != "gyro":
        return [Line("gravity on the matrix", "start", whole * use.steady_force, how=how)]
    rows = _force_rows(model, use)
    return [] if rows is None else [Line("gravity on g-sensitivity", "start", rows * use.steady_force, how=how)]


def _rows(model: SensorModel, without: bool) -> tuple[Array, Array, Array]:
    """Return the error of each sensor for a unit of rms input: along its own axis, along the others, and along all.

    Of three gyros the part of the cross terms that turns all axes together is left out of the second: see the module
    head.
    """
    k = len(model.axes)
    M = model.matrix[0]
    together = model.kind == "gyro" and k == 3
    own, cross, whole = np.zeros(k), np.zeros(k), np.zeros(k)
    for i, axis in enumerate(model.axes):
        own[i] = _covariance(model, [f"scale_factor_error_{axis}"])[0, 0]
        own[i] += (M[i, i] - 1.0) ** 2 if without else 0.0
        for j in (j for j in range(k) if j != i):
            pair = _covariance(model, [f"misalignment_{axis}{model.axes[j]}", f"misalignment_{model.axes[j]}{axis}"])
            cross[i] += 0.25 * float(pair.sum()) if together else float(pair[0, 0])
            if without:
                cross[i] += (0.5 * (M[i, j] + M[j, i]) if together else M[i, j]) ** 2
            whole[i] += float(pair[0, 0]) + (M[i, j] ** 2 if without else 0.0)
    return np.sqrt(own), np.sqrt(np.maximum(cross, 0.0)), np.sqrt(own + whole)


def _white(source: str, size: Array, time: float | None, how: str) -> Line:
    return Line(source, "white", np.asarray(size * np.sqrt(2.0 * (time or 0.0))), how=f"{how}, {time or 0.0:g} s")


def _vibration(model: SensorModel, use: Use, missing: list[str]) -> list[Line]:
    k, found = len(model.axes), []
    if use.folded is not None and use.sample_rate:
        size = np.full(k, use.folded / np.sqrt(use.sample_rate))
        found.append(Line("vibration folded back", "white", size, how=f"rms beyond {use.sample_rate / 2.0:g} Hz"))
    if use.vibration is not None:
        if use.rectification is None:
            missing.append(f"{model.kind}: rectification of vibration: unknown unless stated (bias per squared rms)")
        else:
            size = np.full(k, use.rectification * use.vibration**2)
            found.append(Line("rectified vibration", "start", size, how=f"at {use.vibration:.3g} m/s^2 rms"))
    else:
        missing.append(f"{model.kind}: vibration: give a recording of it")
    return found


def _untouched(model: SensorModel) -> list[str]:
    """Return terms of the model whose errors are in no line."""
    terms: tuple[tuple[str, Callable[[SensorModel], object]], ...] = (
        ("nonlinearity", lambda one: not one.linear),
        ("hysteresis", lambda one: one.bias_hysteresis is not None),
        ("warm-up", lambda one: one.bias_warm_up is not None),
        ("pressure, supply and other channels", lambda one: one.bias_pressure is not None or bool(one.sensitivities)),
    )
    return [f"{model.kind}: errors of {what}" for what, has in terms if has(model)]


TARGETS = ("kalibr", "px4", "gtsam", "kf-gins", "openvins", "ros")
KF_GINS_TIME = 4.0 * 3600.0  # correlation time in its own example, where nothing says another [s]
STARTS = {  # target -> settings of the bias at the start: of the gyro, of the accelerometer, with their units
    "px4": (("EKF2_GBIAS_INIT", "rad/s"), ("EKF2_ABIAS_INIT", "m/s^2")),
    "kf-gins": (("initbgstd", "deg/h"), ("initbastd", "mGal")),
}


def settings_of(
    target: str, gyro: Budget | None, accelerometer: Budget | None, sample_rate: float | None = None
) -> FilterBlock:
    """Return the settings of a filter that carry all lines: one white noise and one bias an axis.

    Parameters
    ----------
    target : {"kalibr", "px4", "gtsam", "kf-gins", "openvins", "ros"}
        Which filter.
    gyro, accelerometer : Budget, optional
        Of each sensor that is known.
    sample_rate : float, optional
        Of the readings [Hz]; Kalibr, OpenVINS and ROS need it.

    Raises
    ------
    UsageError
        ``unknown_name`` if there is no such filter; ``missing`` without the sample rate where it is needed.
    """
    if target not in TARGETS:
        raise UsageError(f"no filter {target!r}", do=f"There are: {', '.join(TARGETS)}", code="unknown_name")
    if target in {"kalibr", "openvins", "ros"} and not sample_rate:
        raise UsageError(f"--for {target} needs the sample rate", do="Add --sample-rate", code="missing")
    rate = sample_rate or 0.0
    both = (gyro, accelerometer)
    if target == "ros":
        own = [() if one is None else tuple(one.message_variance(rate).tolist()) for one in both]
        return to_ros(*own)
    if target == "kf-gins":
        carried = tuple(None if one is None else one.with_scale_factor_states for one in both)
    else:
        carried = both
    first, second = ([()] if one is None else _walks(one) for one in carried)
    if target in {"kalibr", "openvins"}:
        block = (to_kalibr if target == "kalibr" else to_openvins)(first, second, rate)
    elif target == "gtsam":
        block = _with_prior(to_gtsam(first, second, STANDARD_GRAVITY.value), both)
    elif target == "px4":
        block = _with_start(to_px4(first, second), target, both)
    else:
        times = [line.time[line.size > 0.0] for one in both if one for line in one.lines
                 if line.carried == "gauss_markov" and line.time is not None]  # fmt: skip
        logs = np.log(np.concatenate(times)) if times else np.zeros(0)
        time = float(np.exp(np.mean(logs))) if logs.size else KF_GINS_TIME
        known = (
            None if gyro is None else gyro.scale_factor,
            None if accelerometer is None else accelerometer.scale_factor,
        )
        block = _with_start(to_kf_gins(first, second, time, scale_factors=known), target, both)
    said = [one for budget in both if budget for one in _stand_in(budget)]
    if target in {"kalibr", "openvins"}:
        said += [f"{one.kind}: bias at the start: {max(one.start):.3g} {one.unit} (largest): give it to the filter"
                 for one in both if one and np.any(one.start)]  # fmt: skip
    return replace(block, cannot_hold=(*block.cannot_hold, *said))


def _walks(budget: Budget) -> list[tuple[Term, ...]]:
    """Return what a filter with one walk an axis carries; an axis without one has that of the worst."""
    worst = RateRandomWalk(float(np.max(budget.drive)))
    own = [budget.walk_terms(i) for i in range(len(budget.axes))]
    if not worst.coefficient:
        return own
    return [one if any(isinstance(t, RateRandomWalk) for t in one) else (*one, worst) for one in own]


def _stand_in(budget: Budget) -> list[str]:
    """Return what to say of axes that are given what is known of others."""
    said = []
    without = [axis for axis, drive in zip(budget.axes, budget.drive, strict=True) if not drive]
    if without and len(without) < len(budget.axes):
        said.append(f"{budget.kind}: no wandering of {', '.join(without)} is known: that of the worst axis stands in")
    if len(budget.axes) == 1:
        said.append(f"{budget.kind}: one axis alone, {budget.axes[0]}: it stands for all three")
    return said


def _with_prior(block: FilterBlock, both: tuple[Budget | None, Budget | None]) -> FilterBlock:
    """Return a block of GTSAM with the standard deviations of the first bias, for its prior."""
    gyro, accelerometer = both
    known = [one for one in (accelerometer, gyro) if one is not None and np.any(one.start)]
    values = [value for one in known for value in (one.start.tolist() * (3 // len(one.axes)))]
    if not values:
        return block
    listed = ", ".join(f"{value:.6g}" for value in values)
    text = f"bias_prior = gtsam.noiseModel.Diagonal.Sigmas(np.array([{listed}]))  # of the first bias: m/s^2, rad/s\n"
    if len(known) == 1:
        text = f"# of the first bias, {known[0].kind} [{known[0].unit}]: {listed}\n"
    setting = Setting("bias_prior", tuple(values), "m/s^2, rad/s", "bias at the start")
    missing = tuple(one.replace(" and the first covariance of the bias", "") for one in block.missing)
    return replace(block, text=block.text + text, settings=(*block.settings, setting), missing=missing)


def _with_start(block: FilterBlock, target: str, both: Sequence[Budget | None]) -> FilterBlock:
    """Return a block with what the filter is told of the bias at the start."""
    settings, lines, outside = [], [], []
    for (key, unit), one in zip(STARTS[target], both, strict=True):
        if one is None or not np.any(one.start):
            continue
        values = tuple((one.start * factor(one.unit, unit)).tolist())
        shown = (max(values),) if target == "px4" else values * (3 // len(values))
        settings.append(Setting(key, shown, unit, "bias at the start"))
        listed = ", ".join(f"{value:.6g}" for value in shown)
        lines.append(
            f"param set {key} {listed}" if target == "px4" else f"{key}: [{listed}]  # [{unit}] bias at the start"
        )
        outside += outside_px4(key, shown[0]) if target == "px4" else []
    text = block.text + "".join(f"{line}\n" for line in lines)
    held = (*block.cannot_hold, *outside)
    return replace(block, text=text, settings=(*block.settings, *settings), cannot_hold=held)


def vibration_levels(spectrum: Spectrum, sample_rate: float) -> tuple[float, float]:
    """Return rms of a vibration, and of its part beyond half a sample rate, which is folded back; the largest axis.

    Parameters
    ----------
    spectrum : Spectrum
        Of a recording that is faster than the filter's readings.
    sample_rate : float
        Of the readings that the filter takes [Hz].
    """
    beyond = spectrum.frequency > 0.5 * sample_rate
    whole = np.sqrt(spectrum.density.sum(axis=0) * spectrum.spacing)
    folded = np.sqrt(spectrum.density[beyond].sum(axis=0) * spectrum.spacing)
    return float(whole.max()), float(folded.max())
