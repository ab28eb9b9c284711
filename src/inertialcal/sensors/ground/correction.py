"""A ground model applied to readings: each sample with the polynomials of its gain, no step twice.

Steps that were made before (``applied``) are left out: an archive has its records in g, corrected or not. The bias can
be left in (``keep_bias``): then the readings have the bias itself, and ``predicted`` says what the model takes it for.

A reading that is missing empties those that its misalignment enters. Where an axis is missing throughout, the others
are not corrected for it, and a remark says so.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...core.units import convert
from ..chain.converter import wide
from ..model.equation import mixed
from .model import STEPS, GroundModel

CHUNK = 262_144  # rows at a time
TEMPERATURE, GAIN = "temperature", "gain"
PREDICTED = "predicted_"  # before the axis: bias that the ground model predicts


@dataclass(frozen=True, eq=False)
class Corrected:
    """Readings after a ground model."""

    readings: Array  # shape (n, k): Along the axes of the head [input unit]
    predicted: Array  # shape (n, k): Bias that the model predicts along them [input unit]
    remarks: tuple[Remark, ...]  # What was left out, and what was lost


def correct(
    ground: GroundModel,
    readings: ArrayLike,
    *,
    temperature: ArrayLike | None = None,
    gain: ArrayLike | None = None,
    applied: Collection[str] = (),
    keep_bias: bool = False,
) -> Corrected:
    """Return readings with the corrections of a ground model.

    Parameters
    ----------
    readings : array_like, shape (n, k)
        r = v / S0 with the ideal scale factor of the chain [input unit]; NaN where missing.
    temperature : array_like, shape (n,) or (n, k), optional
        [degC]
    gain : array_like, shape (k,) or (n, k), optional
        Needed where the model tells gains apart; NaN where not known.
    applied : collection of str
        Steps that were made before: "bias", "scale_factor", "misalignment".
    keep_bias : bool
        Leave the bias in.

    Raises
    ------
    DataError
        ``missing_temperature``, ``missing_gain``; ``no_polynomial`` for a gain that the model has not;
        ``wrong_step`` for an unknown step; ``bias_applied`` if it is to be left in and was taken off before.
    """
    unknown = [step for step in applied if step not in STEPS]
    if unknown:
        raise DataError(f"no step {unknown[0]!r}", do=f"There are: {', '.join(STEPS)}", code="wrong_step")
    if keep_bias and "bias" in applied:
        what = "the bias is to be kept, but the model's bias was removed before"
        why = "a flip then finds the error of that model, not the bias of the head"
        raise DataError(what, why=why, do="Set plan.corrected = true", code="bias_applied")
    k = len(ground.axes)
    r = wide("readings", readings, k)
    warm = None if temperature is None else wide("temperature", temperature, k, len(r))
    if ground.gains and gain is None:
        why = "its bias and scale factor differ from gain to gain"
        raise DataError("the ground model needs the gain", why=why, do="Give chain.gain", code="missing_gain")
    unread = [axis for i, axis in enumerate(ground.axes) if not np.isfinite(r[:, i]).any()]
    out, predicted = np.full(r.shape, np.nan), np.full(r.shape, np.nan)
    for rows, gains in _by_gain(ground, gain, len(r)):
        here = None if warm is None else warm[rows]
        out[rows], predicted[rows] = _at_one_gain(ground, r[rows], here, gains, unread, applied, keep_bias)
    out[:, [axis in unread for axis in ground.axes]] = np.nan
    return Corrected(out, predicted, tuple(_remarks(ground, r, out, warm, unread, applied)))


def _at_one_gain(
    ground: GroundModel,
    r: Array,
    temperature: Array | None,
    gains: Sequence[float],
    unread: Sequence[str],
    applied: Collection[str],
    keep_bias: bool,
) -> tuple[Array, Array]:
    """Return readings and predicted bias, shape (n, k) or (1, k)."""
    r = np.where(np.isnan(gains), np.nan, r) if ground.gains else r
    here = ground.at([np.nan if axis in unread else gain for axis, gain in zip(ground.axes, gains, strict=True)])
    if here.in_temperature and temperature is None:
        raise DataError(
            "no temperature of the head", why="the ground model depends on it", do="Name its column: temperature",
            code="missing_temperature",
        )  # fmt: skip
    scale, bias, back = here.parts(temperature, len(r), ground.order, unread)
    y = r if "scale_factor" in applied else r / scale
    y = y if "misalignment" in applied else mixed(back, y)
    predicted = mixed(back, bias)
    if "bias" in applied or keep_bias:
        return y, predicted
    return y - predicted, predicted


def _by_gain(
    ground: GroundModel, gain: ArrayLike | None, n: int
) -> Iterator[tuple[slice | NDArray[np.intp], Sequence[float]]]:
    """Rows of one set of gains, a chunk at a time, each with its gains."""
    every = np.full((1, len(ground.axes)), np.nan) if gain is None else np.atleast_2d(np.asarray(gain, dtype=float))
    for start in range(0, n, CHUNK):
        part = slice(start, min(start + CHUNK, n))
        own = every if len(every) == 1 else every[part]
        first = own[0]
        if np.array_equal(own, np.broadcast_to(first, own.shape), equal_nan=True):
            yield part, first.tolist()
            continue
        sets, which = np.unique(own, axis=0, return_inverse=True)
        for i, gains in enumerate(sets):
            yield start + np.flatnonzero(which.ravel() == i), gains.tolist()


def _remarks(
    ground: GroundModel, r: Array, out: Array, warm: Array | None, unread: Sequence[str], applied: Collection[str]
) -> Iterator[Remark]:
    done = [step.replace("_", " ") for step in STEPS if step in applied]
    if done:
        words = " and ".join(", ".join(done).rsplit(", ", 1))
        what = f"{words} of the ground model not applied: already done"
        yield Remark("applied_before", "info", what)
    if unread and "misalignment" not in applied and len(unread) < len(ground.axes):
        what = f"{', '.join(unread)} has no readings: the other axes are not corrected for misalignment towards it"
        yield Remark("misalignment_left_out", "warning", what)
    read = np.array([axis not in unread for axis in ground.axes])
    lost = np.any(np.isnan(out) & ~np.isnan(r) & read, axis=1)
    if lost.any():
        what = "temperature, gain or another axis missing, which the ground model needs: left empty"
        yield Remark("condition_missing", "warning", what, f"sample {int(np.argmax(lost))}", int(np.sum(lost)))
    ends = ground.base.temperature_range
    if ends is None or warm is None:
        return
    beyond = np.any((warm < ends[0]) | (warm > ends[1]), axis=1)
    count = int(np.count_nonzero(beyond))
    if count:
        between = f"{ends[0]:g} to {ends[1]:g} degC"
        what = f"{count} of {len(beyond)} samples outside the temperature range of the ground model ({between})"
        do = "The model extrapolates there: a fourth-order polynomial may be far off"
        yield Remark("outside_temperature_range", "warning", what, f"sample {int(np.argmax(beyond))}", count, do)


def correct_recording(
    ground: GroundModel,
    recording: Recording,
    gains: Mapping[str, float],
    *,
    applied: Collection[str] = (),
    keep_bias: bool = False,
) -> Recording:
    """Return the recording of a head after a ground model.

    Parameters
    ----------
    recording : Recording
        Axes in the input unit; ``temperature_x``, ... or ``temperature`` [degC], and ``gain_x``, ... or ``gain`` over
        time, where they are there.
    gains : mapping of str to float
        Of the axes whose gain was not recorded; empty where it is not known.
    applied, keep_bias
        As ``ground_correction.correct`` takes them.

    Returns
    -------
    Recording
        The axes corrected, and ``predicted_x``, ... [input unit] of each; the other channels as they are.

    Raises
    ------
    DataError
        As ``ground_correction.correct``.
    """
    n = len(recording)
    read = [axis for axis in ground.axes if axis in recording.names]
    readings = np.full((n, len(ground.axes)), np.nan)
    for axis in read:
        readings[:, ground.axes.index(axis)] = recording.channel(axis).data
    done = correct(
        ground,
        readings,
        temperature=_each(recording, ground.axes, TEMPERATURE, "degC"),
        gain=_gain(recording, ground.axes, gains),
        applied=applied,
        keep_bias=keep_bias,
    )
    unit = ground.base.unit
    made = {}
    for axis in read:
        own = done.readings[:, ground.axes.index(axis)].copy()
        made[axis] = replace(recording.channel(axis), data=own)
    predicted = tuple(
        Channel(PREDICTED + axis, done.predicted[:, ground.axes.index(axis)].copy(), unit, "model", axis)
        for axis in read
    )
    channels = tuple(made.get(channel.name, channel) for channel in recording.channels)
    return replace(recording, channels=(*channels, *predicted), remarks=(*recording.remarks, *done.remarks))


def _each(recording: Recording, axes: Sequence[str], what: str, unit: str) -> Array | None:
    """Return a channel of each axis, or one for all, shape (n, k); NaN for an axis that has none."""
    names = [next((one for one in (f"{what}_{axis}", what) if one in recording.names), "") for axis in axes]
    if not any(names):
        return None
    found = np.full((len(recording), len(axes)), np.nan)
    for i, name in enumerate(names):
        if name:
            channel = recording.channel(name)
            found[:, i] = convert(channel.data, channel.unit or unit, unit)
    return found


def _gain(recording: Recording, axes: Sequence[str], stated: Mapping[str, float]) -> Array | None:
    """Return the gain of each axis, over time where it was recorded, shape (k,) or (n, k)."""
    recorded = _each(recording, axes, GAIN, "1")
    fixed = np.array([stated.get(axis, np.nan) for axis in axes])
    if recorded is None:
        return fixed if stated else None
    has = [any(name in recording.names for name in (f"{GAIN}_{axis}", GAIN)) for axis in axes]
    return np.where(has, recorded, fixed)
