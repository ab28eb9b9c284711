"""Noise terms into the settings of navigation filters: Kalibr, OpenVINS, PX4 EKF2, GTSAM, KF-GINS, ROS messages.

The direction is one: terms found here, in SI, to the words and units of the filter. Each block tells for every value
where it comes from, what the filter has no word for, and what was not there to be written: such a line is left out as
a comment, never filled with a guess.

All these filters hold white noise and one slow bias an axis. The bias is given its driving noise q [unit/sqrt(s)]: of
a random walk of the rate its K; of Gauss-Markov noise ``sigma sqrt(2 / t_c)``, exact for times well below t_c and too
large beyond it in filters that have no correlation time. Bias instability, quantisation, ramps and lines fit into none.

Where the record shows bias instability and no walk, a filter still wants a number. A ``horizon`` gives one, and says
what it is: the time over which the filter must carry the bias, from one correction by other sensors to the next. All
that wanders (B, K, Gauss-Markov) is then a walk with ``q = sqrt(3 avar(horizon) / horizon)``, which has the same Allan
deviation there.

What each takes
---------------
Kalibr [1]_
    One value for the three axes (here the largest), densities as in the coefficients N and K.
OpenVINS [5]_
    The four values of Kalibr, in its ``kalibr_imu_chain.yaml`` below ``imu0``. It takes them as they are.
ROS [6]_
    The covariance of a single message, row by row: the variance of a reading, not a density.
PX4 EKF2 [2]_
    Standard deviations a prediction step of dt, not densities: the filter squares them and multiplies by dt^2, so
    ``EKF2_GYR_NOISE = N / sqrt(dt)`` and ``EKF2_GYR_B_NOISE = K / sqrt(dt)``. One value for the three axes. Newer
    versions stop adding to a bias whose variance has reached that of the white noise.
GTSAM [3]_
    Covariances of continuous noise, N^2 and K^2, an axis each, of PreintegrationCombinedParams.
KF-GINS [4]_
    Gauss-Markov bias, standard deviation an axis, one correlation time for all; random walks in deg/sqrt(h) and
    m/s/sqrt(h). Scale factors alike: their standard deviation is no noise, and comes from a calibration or not at all.

References
----------
.. [1] Kalibr wiki (github.com/ethz-asl/kalibr), "IMU Noise Model" and "Yaml formats".
.. [2] PX4-Autopilot, src/modules/ekf2: EKF/covariance.cpp (predictCovariance), and the parameters' units and ranges in
   params_gyro_bias.yaml, params_accel_bias.yaml, ekf2_params.c (EKF2_PREDICT_US, 10 ms).
.. [3] GTSAM, gtsam/navigation/PreintegrationCombinedParams.h.
.. [4] KF-GINS, dataset/kf-gins.yaml, section imunoise; src/kf-gins/gi_engine.cpp: a bias is driven by
   ``2 sigma^2 / t_c``, scale factors (``gsstd``, ``asstd``, ppm) alike; the start of the biases: ``initbgstd``,
   ``initbastd``; of the scale factors that of imunoise unless said.
.. [5] OpenVINS (github.com/rpng/open_vins), config/*/kalibr_imu_chain.yaml.
.. [6] ROS, sensor_msgs/Imu: "the covariance matrices are row major about x, y, z axes"; REP 145.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...core.errors import PlanError
from ...core.estimate import Array
from ...core.units import factor
from .expected import expected_variance
from .terms import BiasInstability, GaussMarkov, RandomWalk, RateRandomWalk, Term

PX4_STEP = 0.01  # prediction step of EKF2 by default [s]
PX4_RANGES = {  # least and largest value that the parameters may have [2]_
    "EKF2_GYR_NOISE": (1e-4, 0.1),
    "EKF2_ACC_NOISE": (0.01, 1.0),
    "EKF2_GYR_B_NOISE": (0.0, 0.01),
    "EKF2_ACC_B_NOISE": (0.0, 0.01),
    "EKF2_GBIAS_INIT": (0.0, 0.2),
    "EKF2_ABIAS_INIT": (0.0, 0.5),
}
STEPS = 4096  # of an averaging time, so short that samples are as good as continuous
Axes = Sequence[Sequence[Term]]
Target = Literal["kalibr", "px4", "gtsam", "kf_gins", "openvins", "ros"]


def to_kalibr(
    gyro: Axes, accelerometer: Axes, sample_rate: float, topic: str = "/imu0", *, horizon: float | None = None
) -> FilterBlock:
    """Return the imu.yaml of Kalibr.

    Parameters
    ----------
    gyro, accelerometer : sequence of sequences of Term
        Terms of each axis [SI]; one axis stands for all.
    sample_rate : float
        Of the messages [Hz].
    topic : str
        Of the messages.
    horizon : float, optional
        Averaging time at which a walk replaces all that wanders [s]; see the module head.

    Raises
    ------
    PlanError
        If there is no axis, an axis has a term twice, or the sample rate or the horizon is not positive.
    """
    _check_positive(sample_rate, "a sample rate", "Hz")
    acc, rate = sensor_noise("accelerometer", accelerometer, horizon), sensor_noise("gyro", gyro, horizon)
    wanted = (
        ("accelerometer_noise_density", acc.white, "m/s^2/sqrt(Hz)", "largest N of the axes"),
        ("accelerometer_random_walk", acc.drive, "m/s^3/sqrt(Hz)", f"largest driving noise: {acc.source}"),
        ("gyroscope_noise_density", rate.white, "rad/s/sqrt(Hz)", "largest N of the axes"),
        ("gyroscope_random_walk", rate.drive, "rad/s^2/sqrt(Hz)", f"largest driving noise: {rate.source}"),
    )
    settings = [Setting(key, _largest(values), unit, source) for key, values, unit, source in wanted]
    lines = [_yaml(one, one.values[0] if one.values else None) for one in settings]
    lines += [f'rostopic: "{_quoted(topic)}"', f"update_rate: {_figure(sample_rate)}  # Hz"]
    held = (*_worst_only(rate, acc), *_times_not_held(rate, acc))
    return filter_block("kalibr", lines, settings, rate, acc, held)


def to_openvins(
    gyro: Axes, accelerometer: Axes, sample_rate: float, topic: str = "/imu0", *, horizon: float | None = None
) -> FilterBlock:
    """Return the lines of OpenVINS's kalibr_imu_chain.yaml that hold noise.

    Parameters and Raises as `to_kalibr`.
    """
    block = to_kalibr(gyro, accelerometer, sample_rate, topic, horizon=horizon)
    lines = ["%YAML:1.0", "imu0:", *(f"  {line}" for line in block.text.splitlines())]
    return replace(block, target="openvins", text="\n".join(lines) + "\n")


def to_ros(gyro: Sequence[float], accelerometer: Sequence[float]) -> FilterBlock:
    """Return the covariances of sensor_msgs/Imu, as YAML.

    Parameters
    ----------
    gyro, accelerometer : sequence of float
        Variance of a single reading of each axis [(rad/s)^2], [(m/s^2)^2]; one stands for all, none where not known.

    Raises
    ------
    PlanError
        If there are not none, one or three axes.
    """
    wanted = (
        ("angular_velocity_covariance", gyro, "(rad/s)^2"),
        ("linear_acceleration_covariance", accelerometer, "(m/s^2)^2"),
    )
    settings, lines = [], []
    for key, own, unit in wanted:
        if len(own) not in {0, 1, 3}:
            raise PlanError(f"{key}: {len(own)} axes, need one for all, or three")
        three = tuple(own) * (3 // len(own)) if own else ()
        matrix = tuple(float(v) for v in np.diag(three).ravel()) if three else ()
        settings.append(Setting(key, matrix, unit, "white noise of a sample, and the bias"))
        listed = ", ".join(_figure(v) for v in matrix)
        lines.append(f"{key}: [{listed}]  # {unit}" if matrix else f"# {key}: not known")
    held = ("the part of the bias: each message is taken as independent, and the bias is the same in all",)
    return filter_block("ros", lines, settings, None, None, held)


def to_px4(gyro: Axes, accelerometer: Axes, step: float = PX4_STEP, *, horizon: float | None = None) -> FilterBlock:
    """Return the parameters of PX4's EKF2, as lines of a parameter file.

    Parameters
    ----------
    step : float
        Prediction step of the filter (EKF2_PREDICT_US) [s].
    gyro, accelerometer, horizon
        As `to_kalibr`.

    Raises
    ------
    PlanError
        As `to_kalibr`; or if the step is not positive.
    """
    _check_positive(step, "a prediction step", "s")
    acc, rate = sensor_noise("accelerometer", accelerometer, horizon), sensor_noise("gyro", gyro, horizon)
    wanted = (
        ("EKF2_GYR_NOISE", rate.white, "rad/s", "largest N / sqrt(step)"),
        ("EKF2_ACC_NOISE", acc.white, "m/s^2", "largest N / sqrt(step)"),
        ("EKF2_GYR_B_NOISE", rate.drive, "rad/s^2", f"largest driving noise / sqrt(step): {rate.source}"),
        ("EKF2_ACC_B_NOISE", acc.drive, "m/s^3", f"largest driving noise / sqrt(step): {acc.source}"),
    )
    settings = [
        Setting(key, tuple(v / float(np.sqrt(step)) for v in _largest(values)), unit, source)
        for key, values, unit, source in wanted
    ]
    lines = [f"# for EKF2_PREDICT_US {round(step * 1e6)}: values depend on the step"]
    outside: list[str] = []
    for one in settings:
        if not one.values:
            lines.append(f"# {one.key}: not found in the record")
            continue
        lines += [f"# {one.unit}; {one.source}", f"param set {one.key} {_figure(one.values[0])}"]
        outside += outside_px4(one.key, one.values[0])
    held = (*outside, *_worst_only(rate, acc), *_times_not_held(rate, acc))
    return filter_block("px4", lines, settings, rate, acc, held)


def outside_px4(key: str, value: float) -> list[str]:
    """Return what to say of a parameter that PX4 would not take; nothing where it takes it."""
    low, high = PX4_RANGES[key]
    return [] if low <= value <= high else [f"{key} {value:.3g}: the parameter takes {low:g} to {high:g}"]


def to_gtsam(
    gyro: Axes, accelerometer: Axes, gravity: float, up: bool = True, *, horizon: float | None = None
) -> FilterBlock:
    """Return Python lines that make GTSAM's PreintegrationCombinedParams.

    Parameters
    ----------
    gravity : float
        Of the site, positive [m/s^2].
    up : bool
        Whether z of the navigation frame points up (``MakeSharedU``) or down (``MakeSharedD``).
    gyro, accelerometer, horizon
        As `to_kalibr`.

    Raises
    ------
    PlanError
        As `to_kalibr`; or if gravity is not positive.
    """
    _check_positive(gravity, "a gravity", "m/s^2")
    acc, rate = sensor_noise("accelerometer", accelerometer, horizon), sensor_noise("gyro", gyro, horizon)
    wanted = (
        ("setAccelerometerCovariance", acc.white, "m^2/s^4/Hz", "N^2 of each axis"),
        ("setGyroscopeCovariance", rate.white, "rad^2/s^2/Hz", "N^2 of each axis"),
        ("setBiasAccCovariance", acc.drive, "m^2/s^6/Hz", f"squared driving noise: {acc.source}"),
        ("setBiasOmegaCovariance", rate.drive, "rad^2/s^4/Hz", f"squared driving noise: {rate.source}"),
    )
    settings = [Setting(key, tuple(v**2 for v in _three(values)), unit, source) for key, values, unit, source in wanted]
    named = "MakeSharedU" if up else "MakeSharedD"
    lines = ["import gtsam", "import numpy as np", ""]
    lines += [f"params = gtsam.PreintegrationCombinedParams.{named}({_figure(gravity)})"]
    for one in settings:
        listed = ", ".join(_figure(v) for v in one.values)
        line = f"params.{one.key}(np.diag([{listed}]))  # {one.unit}"
        lines.append(line if one.values else f"# params.{one.key}: not found in the record")
    missing = ("setIntegrationCovariance and the first covariance of the bias: no noise terms: set them yourself",)
    return filter_block("gtsam", lines, settings, rate, acc, _times_not_held(rate, acc), missing)


def to_kf_gins(
    gyro: Axes, accelerometer: Axes, correlation_time: float | None = None, *, horizon: float | None = None,
    scale_factors: tuple[Array | None, Array | None] = (None, None),
) -> FilterBlock:  # fmt: skip
    """Return the section ``imunoise`` of a KF-GINS file.

    Parameters
    ----------
    correlation_time : float, optional
        Of all biases [s]; by default the geometric mean of the Gauss-Markov terms found. The driving noise of each
        bias is kept: ``sigma = q sqrt(t_c / 2)``.
    scale_factors : tuple of arrays, optional
        Standard deviation of what calibration leaves of the scale factors, of each axis [1]: of the gyro, of the
        accelerometer; None where it is not known.
    gyro, accelerometer, horizon
        As `to_kalibr`.

    Raises
    ------
    PlanError
        As `to_kalibr`; or if the correlation time is not positive.
    """
    acc, rate = sensor_noise("accelerometer", accelerometer, horizon), sensor_noise("gyro", gyro, horizon)
    if correlation_time is not None:
        _check_positive(correlation_time, "a correlation time", "s")
    found = [t for sensor in (rate, acc) for t in sensor.times if np.isfinite(t)]
    time = correlation_time or (float(np.exp(np.mean(np.log(found)))) if found else None)
    spread = float(np.sqrt(0.5 * time)) if time else np.nan
    wanted = (
        ("arw", rate.white, 1.0, "rad/s/sqrt(Hz)", "deg/sqrt(h)", "N of each axis"),
        ("vrw", acc.white, 1.0, "m/s^2/sqrt(Hz)", "m/s/sqrt(h)", "N of each axis"),
        ("gbstd", rate.drive, spread, "rad/s", "deg/h", f"q sqrt(t_c / 2): {rate.source}"),
        ("abstd", acc.drive, spread, "m/s^2", "mGal", f"q sqrt(t_c / 2): {acc.source}"),
    )
    settings = [
        Setting(key, _three(tuple(v * scale * factor(si, unit) for v in values)), unit, source)
        for key, values, scale, si, unit, source in wanted
    ]
    lines = ["imunoise:"]
    for one in settings:
        listed = ", ".join(_figure(v) for v in one.values)
        line = f"  {one.key}: [{listed}]  # [{one.unit}] {one.source}"
        lines.append(line if one.values else f"  # {one.key}: not found in the record")
    for key, left in zip(("gsstd", "asstd"), scale_factors, strict=True):
        ppm = () if left is None else _three(tuple((1e6 * left).tolist()))
        settings += [Setting(key, ppm, "ppm", "what calibration leaves of the scale factor")] if ppm else []
        lines.append(f"  {key}: [{', '.join(map(_figure, ppm))}]  # [ppm] what calibration leaves of the scale factor"
                     if ppm else f"  # {key}: not known")  # fmt: skip
    settings.append(Setting("corrtime", (time * factor("s", "h"),) if time else (), "h", "one for all biases"))
    line = f"  corrtime: {_figure(settings[-1].values[0])}  # [h]" if time else "  # corrtime: not found in the record"
    unknown = " and ".join(key for key, left in zip(("gsstd", "asstd"), scale_factors, strict=True) if left is None)
    missing = (f"{unknown} [ppm]: scale factors are not noise: take them from a calibration",) if unknown else ()
    return filter_block("kf_gins", [*lines, line], settings, rate, acc, _other_times(time, rate, acc), missing)


def _largest(values: tuple[float, ...]) -> tuple[float, ...]:
    return (max(values),) if np.all(np.isfinite(values)) else ()


def _three(values: tuple[float, ...]) -> tuple[float, ...]:
    return values * (3 // len(values)) if np.all(np.isfinite(values)) else ()


def _worst_only(*sensors: SensorNoise) -> tuple[str, ...]:
    return tuple(
        f"{one.kind}: differences between axes: the largest value is used for all"
        for one in sensors
        if len(set(one.white)) > 1 or len(set(one.drive)) > 1
    )


def _times_not_held(*sensors: SensorNoise) -> tuple[str, ...]:
    return tuple(
        f"{one.kind}: correlation time {', '.join(f'{t:.3g}' for t in one.times if np.isfinite(t))} s: the bias "
        "wanders without limit, too far beyond that time"
        for one in sensors
        if np.any(np.isfinite(one.times))
    )


def _other_times(time: float | None, *sensors: SensorNoise) -> tuple[str, ...]:
    found = []
    for one in sensors:
        for axis, own in enumerate(one.times):
            if time is not None and np.isfinite(own) and not np.isclose(own, time, rtol=1e-9):
                found.append(f"{one.kind} axis {axis}: correlation time {own:.4g} s of its own; driving noise is kept")
        if time is not None and any(not np.isfinite(t) for t in one.times) and np.any(np.isfinite(one.drive)):
            found.append(
                f"{one.kind}: a bias that wanders without limit; the filter's decays to zero over {time:.4g} s"
            )
    return tuple(found)


def _yaml(setting: Setting, value: float | None) -> str:
    if value is None:
        return f"# {setting.key}: not found in the record"
    return f"{setting.key}: {_figure(value)}  # {setting.unit}; {setting.source}"


def _figure(value: float) -> str:
    """Digits that a filter needs, with a decimal point so that YAML reads a number."""
    text = f"{value:.6g}"
    return text if "." in text or "e" not in text else text.replace("e", ".0e")


def _quoted(name: str) -> str:
    """Return a name inside double quotes of YAML: anybody's text, on one line."""
    plain = "".join(c if c.isprintable() else "?" for c in name)
    return plain.replace("\\", "\\\\").replace('"', '\\"')


def _check_positive(value: float, what: str, unit: str) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise PlanError(f"{what} of {value} {unit}", do="It must be positive")


@dataclass(frozen=True)
class Setting:
    """One value of a block."""

    key: str  # The filter's word
    values: tuple[float, ...]  # One, or one an axis; none where the terms do not tell it
    unit: str  # The filter's unit
    source: str  # How it follows from the terms


@dataclass(frozen=True)
class FilterBlock:
    """Settings of one filter."""

    target: Target  # Which filter
    text: str  # To paste; lines of what is missing are comments
    settings: tuple[Setting, ...]  # Its values
    cannot_hold: tuple[str, ...]  # What the terms say and the filter has no word for
    missing: tuple[str, ...]  # What the filter wants and the terms do not say

    def __str__(self) -> str:
        """Return the block, and under it as comments what it does not hold."""
        lines = [f"# not represented: {one}" for one in self.cannot_hold] + [
            f"# missing: {one}" for one in self.missing
        ]
        return "\n".join([self.text.rstrip("\n"), *lines])


@dataclass(frozen=True)
class SensorNoise:
    """What filters hold of a sensor."""

    kind: str  # ``"gyro"`` or ``"accelerometer"``
    # White noise [unit sqrt(s)] and driving noise of the bias [unit/sqrt(s)] of each axis; NaN where not told
    white: tuple[float, ...]
    drive: tuple[float, ...]
    times: tuple[float, ...]  # Correlation time of each axis [s]; NaN where there is none
    source: str  # What the driving noise was taken from
    left: tuple[str, ...]  # Terms that no filter holds


def sensor_noise(kind: str, axes: Axes, horizon: float | None = None) -> SensorNoise:
    """Sort the terms of a sensor into what filters hold, and what is left.

    Parameters
    ----------
    kind : str
        ``"gyro"`` or ``"accelerometer"``.
    axes : sequence of sequences of Term
        Terms of each axis [SI]; one axis stands for all.
    horizon : float, optional
        If said, the bias is a walk that has, at this averaging time, the Allan variance of all that wanders [s].

    Raises
    ------
    PlanError
        If there are not one or three axes, an axis has a term twice, or the horizon is not positive.
    """
    if not len(axes) or len(axes) not in {1, 3}:
        raise PlanError(f"{len(axes)} axes of the {kind}, need one for all, or three")
    if horizon is not None and not (np.isfinite(horizon) and horizon > 0.0):
        raise PlanError(f"a horizon of {horizon} s", do="It must be positive")
    white, biases = [], []
    for terms in axes:
        names = [term.name for term in terms]
        if len(set(names)) != len(names):
            raise PlanError(f"{kind}: a term appears twice in {names}", do="Give the terms of each axis once")
        white.append(next((t.coefficient for t in terms if isinstance(t, RandomWalk)), np.nan))
        biases.append(_bias(terms) if horizon is None else _matched(terms, horizon))
    left = dict.fromkeys(f"{kind}: {said}" for one in biases for said in one.left)
    sources = dict.fromkeys(one.source for one in biases)
    return SensorNoise(
        kind, tuple(white), tuple(one.drive for one in biases), tuple(one.time for one in biases),
        " or ".join(sources), tuple(left),
    )  # fmt: skip


@dataclass(frozen=True)
class _Bias:
    """What drives the bias of one axis, its correlation time, where both come from, and what is left."""

    drive: float
    time: float
    source: str
    left: tuple[str, ...]


def _bias(terms: Sequence[Term]) -> _Bias:
    """Take the walk, else a Gauss-Markov term."""
    rest = [_spelled(t.name) for t in terms if not isinstance(t, RandomWalk | RateRandomWalk | GaussMarkov)]
    walk = next((t for t in terms if isinstance(t, RateRandomWalk)), None)
    markov = next((t for t in terms if isinstance(t, GaussMarkov)), None)
    if walk is not None:
        second = [f"{_spelled(markov.name)} next to {_spelled(walk.name)}"] if markov else []
        return _Bias(walk.coefficient, np.nan, "K", (*rest, *second))
    if markov is not None:
        drive = markov.sigma * float(np.sqrt(2.0 / markov.correlation_time))
        return _Bias(drive, markov.correlation_time, "sigma sqrt(2 / t_c)", tuple(rest))
    return _Bias(np.nan, np.nan, "not found", tuple(rest))


def _matched(terms: Sequence[Term], horizon: float) -> _Bias:
    """Take a walk of the same Allan variance, K^2 tau / 3, as all that wanders."""
    wandering = tuple(t for t in terms if isinstance(t, BiasInstability | RateRandomWalk | GaussMarkov))
    rest = [_spelled(t.name) for t in terms if not isinstance(t, RandomWalk) and t not in wandering]
    if not wandering:
        return _Bias(np.nan, np.nan, "not found", tuple(rest))
    variance = float(expected_variance(wandering, [STEPS], horizon / STEPS)[0])
    names = " and ".join(_spelled(t.name) for t in wandering)
    if {t.name for t in wandering} != {RateRandomWalk.name}:
        rest.append(f"{names}: replaced by a walk, exact at {horizon:g} s, too small below and too large above")
    source = f"walk with the Allan deviation of {names} at {horizon:g} s"
    return _Bias(float(np.sqrt(3.0 * variance / horizon)), np.nan, source, tuple(rest))


def _spelled(name: str) -> str:
    return name.replace("_", " ")


def filter_block(
    target: Target, lines: list[str], settings: Sequence[Setting], rate: SensorNoise | None, acc: SensorNoise | None,
    held: tuple[str, ...] = (), missing: tuple[str, ...] = (),
) -> FilterBlock:  # fmt: skip
    """Return a block of a filter, its settings without values counted as missing."""
    unknown = tuple(one.key for one in settings if not one.values)
    text = "\n".join(lines) + "\n"
    left = [said for one in (rate, acc) if one is not None for said in one.left]
    return FilterBlock(target, text, tuple(settings), (*left, *held), (*unknown, *missing))
