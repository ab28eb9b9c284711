"""The ground model that a campaign gives a head: polynomials in its chain, or a ``model.json`` beside it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.units import parse_quantity, si_unit
from ...files.models.model_file import load_model_file
from ...sensors.ground.correction import correct_recording
from ...sensors.ground.model import STEPS, GroundModel, Polynomials
from ...sensors.model.sensor_model import SensorModel
from ...signals.segmentation.block_statistics import block_statistics
from ...signals.segmentation.gain_changes import gain_changes
from ..file.recordings import RecordingEntry
from ..file.sensors import AtGain, Ground, Polynomial, Sensor
from .chains import gains, per_axis, scale_factors

BLOCK = 1.0  # [s] that the gain is looked at in


@dataclass(frozen=True, eq=False)
class ChainModel:
    """The ground model of a sensor, the order of its axes that of the sensor."""

    model: GroundModel  # What is applied
    gains: Mapping[str, float]  # Of each axis, where it was not recorded
    file: str = ""  # Of the model, where it is a file
    sha256: str = ""  # Of the model, where it is a file


def has_model(sensor: Sensor) -> bool:
    """Tell whether the chain of a sensor has a ground model."""
    return sensor.chain.ground is not None or sensor.chain.model is not None


def chain_model(sensor: Sensor, folder: Path | None = None) -> ChainModel | None:
    """Return the ground model of a sensor; None where it has none.

    Raises
    ------
    DataError
        If a quantity or the file cannot be read, or the model is of other axes (``wrong_model``).
    """
    axes, given = tuple(sensor.axes), sensor.chain
    stated = dict(zip(axes, np.broadcast_to(gains(given.gain, axes), len(axes)).tolist(), strict=True))
    if given.ground is not None:
        return ChainModel(_ground(sensor, given.ground, axes), stated)
    if given.model is None:
        return None
    if folder is None:
        raise PlanError(f"chain.model = {given.model!r}: there is no folder to read it from", code="missing_file")
    file = load_model_file(folder / given.model)
    if len(file.models) > 1:
        what = f"{given.model} holds models for several conditions: {', '.join(file.models)}"
        do = "Write one of them: inertialcal export MODEL --condition NAME --to json -o FILE"
        raise DataError(what, do=do, code="condition_needed")
    if file.model.kind != sensor.kind or file.model.axes != axes:
        what = f"{given.model} is the model of {_article(file.model.kind)} with axes {', '.join(file.model.axes)}"
        need = f"the sensor is {_article(sensor.kind)} with axes {', '.join(axes)}"
        raise DataError(what, why=need, do="Give the model of this head", code="wrong_model")
    return ChainModel(GroundModel(file.model, order=given.order), stated, given.model, file.sha256)


def _article(kind: str) -> str:
    return f"an {kind}" if kind.startswith("a") else f"a {kind}"


def _ground(sensor: Sensor, given: Ground, axes: tuple[str, ...]) -> GroundModel:
    k, unit = len(axes), si_unit(sensor.unit)
    ends = given.temperature_range
    base = SensorModel(
        kind="accelerometer" if sensor.kind == "accelerometer" else "gyro",
        axes=axes,
        scale_factor=np.ones(k),
        output_unit=unit,
        matrix=_matrix(given, axes),
        bias=np.zeros(k),
        reference_temperature=per_axis(given.reference_temperature, "degC", axes),
        temperature_range=None if ends is None else (_quantity(ends[0], "degC"), _quantity(ends[1], "degC")),
        source=given.source,
    )
    ideal = scale_factors(sensor, axes)
    by_gain = {float(gain): _polynomials(one, axes, unit, ideal, gain) for gain, one in given.gains.items()}
    return GroundModel(base, by_gain, sensor.chain.order)


def _matrix(given: Ground, axes: tuple[str, ...]) -> Array:
    longest = max((len(one) for one in given.misalignment.values()), default=1)
    matrix = np.zeros((longest, len(axes), len(axes)))
    matrix[0] = np.eye(len(axes))
    for pair, texts in given.misalignment.items():
        lost = [axis for axis in pair if axis not in axes]
        if lost:
            raise DataError(f"misalignment.{pair}: the sensor has no axis {lost[0]!r}", code="unknown_name")
        matrix[: len(texts), axes.index(pair[0]), axes.index(pair[1])] = _coefficients(
            texts, "rad", f"misalignment.{pair}"
        )
    return matrix


def _polynomials(
    given: AtGain, axes: tuple[str, ...], unit: str, ideal: Array | None, gain: str
) -> dict[str, Polynomials]:
    """Return the polynomials of each axis that has them at one gain."""
    scales = given.scale_factor or {}
    for axis in [*given.bias, *scales]:
        if axis not in axes:
            raise DataError(f"gains.{gain}: the sensor has no axis {axis!r}", code="unknown_name")
    without = [axis for axis in scales if axis not in given.bias]
    if without:
        raise DataError(
            f"gains.{gain}: {without[0]} has a scale_factor and no bias", do="Give both", code="missing_key"
        )
    if scales and ideal is None:
        what = f"gains.{gain}.scale_factor needs scale_factor in the chain"
        why = "the ratio of both corrects the readings"
        raise DataError(what, why=why, do="State the scale factor that made the readings", code="missing_key")
    found: dict[str, Polynomials] = {}
    for axis, texts in given.bias.items():
        scale = np.ones(1)
        if axis in scales and ideal is not None:
            scale = (
                _coefficients(scales[axis], f"V/({unit})", f"gains.{gain}.scale_factor.{axis}")
                / ideal[axes.index(axis)]
            )
            if scale[0] == 0.0:
                raise DataError(f"gains.{gain}.scale_factor of {axis} is zero", code="wrong_value")
        found[axis] = Polynomials(_coefficients(texts, unit, f"gains.{gain}.bias.{axis}"), scale)
    return found


def _coefficients(texts: Polynomial, unit: str, what: str) -> Array:
    """Coefficients of 1, T - T_ref, ... in a unit, each over its power of degC."""
    units = [unit, f"{unit}/degC", *(f"{unit}/degC^{power}" for power in range(2, len(texts)))]
    found = []
    for power, (text, one) in enumerate(zip(texts, units, strict=False)):
        try:
            found.append(_quantity(text, one))
        except DataError as error:
            first = error.problems[0]
            what = f"{what}, coefficient of (T - T_ref)^{power}: {first.what}" if power else f"{what}: {first.what}"
            raise DataError(what, why=first.why, do=first.do, code="wrong_value") from None
    return np.array(found)


def _quantity(text: str, unit: str) -> float:
    return float(parse_quantity(text).to(unit))


def after_model(
    recording: Recording, entry: RecordingEntry, chain: ChainModel, keep_bias: bool, name: str = ""
) -> Recording:
    """Return the recording of a head, SI in sensor axes, after the ground model; steps made before are left out.

    Raises
    ------
    DataError
        As ``sensors.ground.correction.correct``.
    """
    applied, found = _applied(recording, entry, name)
    recording = _of_one_gain(recording, chain.model.axes, name)
    done = correct_recording(chain.model, recording, chain.gains, applied=applied, keep_bias=keep_bias)
    order = {"jointly": "bias, scale factor and misalignment jointly", "bias_first": "bias first"}[chain.model.order]
    source = f" ({chain.file})" if chain.file else ""
    what = f"a ground model{source} was applied, {order}{', the bias left in' if keep_bias else ''}"
    if set(applied) >= set(STEPS):
        what = f"of the ground model{source} the bias that it predicts was taken, and nothing else"
    said = Remark("ground_model", "info", what, name)
    return replace(done, remarks=(*done.remarks, said, *found))


def _of_one_gain(recording: Recording, axes: Sequence[str], name: str) -> Recording:
    """Empty the axes whose gain changes and was not recorded: which polynomials are theirs is not known.

    This is seen before the model is applied: level and scatter change by the same factor only while the bias is in.
    """
    read = [axis for axis in axes if axis in recording.names and np.isfinite(recording.channel(axis).data).any()]
    if recording.time_ns is None or not read:
        return recording
    blocks = block_statistics([recording.channel(axis).data for axis in read], BLOCK, recording.time_ns)
    try:
        changes = {read[one.channel]: one for one in reversed(gain_changes(blocks))}
    except DataError:
        return recording  # too short to tell
    remarks = []
    for axis in [axis for axis in changes if f"gain_{axis}" not in recording.names]:
        one = changes[axis]
        when = f"{name}: {(one.time_ns - blocks.start_ns) / SECOND:.0f} s after the start"
        what = f"level and scatter of {axis} change by a factor of {one.level:.3g}: {axis} is not read"
        do = "Cut the record there (--from, --to), or record the gain as a channel"
        remarks.append(Remark("gain_changed", "warning", what, when, do=do, axis=axis))
        empty = replace(recording.channel(axis), data=np.full(len(recording), np.nan))
        channels = tuple(empty if c.name == axis else c for c in recording.channels)
        recording = replace(recording, channels=channels)
    return replace(recording, remarks=(*recording.remarks, *remarks))


def _applied(recording: Recording, entry: RecordingEntry, name: str) -> tuple[Collection[str], list[Remark]]:
    """Return the steps that were made before: as the campaign says, else as the file says."""
    if entry.applied is None:
        return recording.applied, []
    if recording.applied and set(entry.applied) != set(recording.applied):
        what = (
            f"recordings.{name}.applied says {', '.join(entry.applied) or 'nothing'}, the file says "
            f"{', '.join(recording.applied)}: the campaign was followed"
        )
        return entry.applied, [
            Remark("applied_disagrees", "warning", what, name, do="Correct the campaign or the file")
        ]
    return entry.applied, []
