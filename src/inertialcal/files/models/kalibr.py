"""Kalibr's yaml of an IMU: forward, both sensors, in SI.

::

    a_m = M_a C_i_b a + b_a
    w_m = M_g C_gyro_i C_i_b w + A C_gyro_i C_i_b a + b_g

M is lower triangular, C are rotations, ``C_i_b`` the rotation in ``T_i_b``; a is specific force. The sensors' own axes
say what the frames are, so a full matrix of ours is parted into a lower triangular one and a rotation. The biases b
are curves over time in Kalibr, and not in the file.

References
----------
.. [1] Kalibr, ``IccScaledMisalignedImu``; Rehder, Nikolic, Schneider, Hinzmann and Siegwart, ICRA 2016.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import Kind
from ...core.remarks import Remark
from ...core.units import factor, same_dimension
from ...sensors.model.sensor_model import INPUT_UNIT, SensorModel
from ...sensors.noise.terms import terms_of
from ...sensors.noise.to_filters import SensorNoise, sensor_noise
from .model_format import ImportedModels, ModelFormat, ModelText
from .triad import Triad, filled, ideal, invertible, lost, model_of, numbers, triad
from .yaml_text import parse_yaml

NAME = "Kalibr"
KEYS = ("accelerometers:", "gyroscopes:", "accelerometer_noise_density:")  # one of them stands in every file
LARGEST_SKEW = 1e-6  # off which a matrix is no rotation
NO_BIAS = "Kalibr's file has no bias: 0 is used"
HEAD = "# Written by inertialcal. Readings in m/s^2 and rad/s"
NO_NOISE = "; noise: inertialcal allan FILE --for kalibr"
WORDS: dict[Kind, str] = {"accelerometer": "accelerometer", "gyro": "gyroscope"}  # of the noise in the file
HOLDS = {  # the bias stands in a comment, and in a remark of its own
    "accelerometer": frozenset({"bias", "scale_factor", "noise"}),
    "gyro": frozenset({"bias", "g_sensitivity", "scale_factor", "noise"}),
}


def read(given: ModelText) -> ImportedModels | None:
    """Return the models of both sensors of the first IMU; None for a text in another format.

    Raises
    ------
    DataError
        ``not_yaml``; ``no_model`` for a file that holds noise alone; ``missing_key``, ``schema``, ``not_invertible``,
        ``not_a_rotation``.
    """
    where = given.where
    if given.json is not None or not any(key in given.text for key in KEYS):
        return None
    content = parse_yaml(given.text, where)
    units = [one for one in content.values() if isinstance(one, Mapping)] if isinstance(content, Mapping) else []
    own = content if isinstance(content, Mapping) and "model" in content else units[0] if units else {}
    if "accelerometers" not in own or "gyroscopes" not in own:
        raise DataError(
            "no accelerometers and gyroscopes in it",
            where=where,
            why=f"model is {own.get('model')!r}: such a file holds noise only, no scale factor",
            do="Run Kalibr with --imu-models scale-misalignment",
            code="no_model",
        )
    return ImportedModels(_models(own, where), _remarks(own, len(units)))


def _models(own: Mapping[str, object], where: str) -> dict[Kind, SensorModel]:
    gyro = own["gyroscopes"]
    to_imu = np.eye(3)
    if own.get("T_i_b") is not None:
        to_imu = _rotation(numbers(own, "T_i_b", (4, 4), where)[:3, :3], "T_i_b", where)
    to_gyro = _rotation(numbers(gyro, "C_gyro_i", (3, 3), where), "C_gyro_i", where) @ to_imu
    parts = {
        "accelerometer": Triad(_lower(own["accelerometers"], where) @ to_imu, np.zeros(3), np.zeros((3, 3))),
        "gyro": Triad(_lower(gyro, where) @ to_gyro, np.zeros(3), numbers(gyro, "A", (3, 3), where) @ to_gyro),
    }
    kinds: tuple[Kind, ...] = ("accelerometer", "gyro")
    return {kind: model_of(kind, np.ones(3), parts[kind], INPUT_UNIT[kind], NAME, NO_BIAS) for kind in kinds}


def _lower(own: object, where: str) -> Array:
    m = numbers(own, "M", (3, 3), where)
    if np.any(np.triu(m, 1)):
        raise DataError("M is not lower triangular", where=where, code="schema")
    return invertible(m, "M", where)


def _rotation(c: Array, what: str, where: str) -> Array:
    if not (np.max(np.abs(c @ c.T - np.eye(3))) < LARGEST_SKEW and np.linalg.det(c) > 0.0):
        raise DataError(f"{what} is not a rotation", where=where, code="not_a_rotation")
    return c


def _remarks(own: Mapping[str, object], units: int) -> tuple[Remark, ...]:
    found = [Remark("no_bias", "warning", f"bias: {NO_BIAS}", do="Subtract the bias first, or measure it at rest")]
    accelerometers = own["accelerometers"]
    if isinstance(accelerometers, Mapping) and any(f"r{axis}_i" in accelerometers for axis in "xyz"):
        found.append(Remark("left_out", "warning", "positions of the accelerometers (size effect) are ignored"))
    if own.get("time_offset"):
        found.append(Remark("left_out", "info", f"time_offset {own['time_offset']} s is ignored"))
    if units > 1:
        found.append(Remark("left_out", "warning", f"the file holds {units} units: only the first is read"))
    return tuple(found)


def dump(models: Mapping[Kind, SensorModel]) -> str:
    """Return the text of the file.

    Raises
    ------
    DataError
        ``not_held`` for axes that are left-handed; as ``triad.triad``.
    """
    import yaml  # noqa: PLC0415 - starts slowly

    lower_a, to_imu = _parted(_in_si(models.get("accelerometer"))[0])
    matrix, force = _in_si(models.get("gyro"))
    lower_g, to_gyro = _parted(matrix)
    whole = np.eye(4)
    whole[:3, :3] = to_imu
    own: dict[str, object] = {
        "T_i_b": whole.tolist(),
        **_densities(models),
        "accelerometers": {"M": lower_a.tolist()},
        "gyroscopes": {
            "A": (force @ to_gyro.T).tolist(),
            "C_gyro_i": (to_gyro @ to_imu.T).tolist(),
            "M": lower_g.tolist(),
        },
        "model": "scale-misalignment",
        "time_offset": 0.0,
    }
    content = yaml.safe_dump({"imu0": own}, sort_keys=False, default_flow_style=None, width=1000)
    head = HEAD if _densities(models) else HEAD + NO_NOISE
    biases = "".join(f"# {_bias(model)}\n" for model in models.values() if np.any(model.bias))
    return f"{head}\n{biases}{content}"


def _bias(model: SensorModel) -> str:
    """Return the bias that the file has no place for, in words: at the reference temperatures where it changes."""
    each = ", ".join(f"{axis} {float(value):.9g}" for axis, value in zip(model.axes, model.bias, strict=True))
    at = model.reference_temperature if model.bias_temperature is not None else None
    warm = "" if at is None else f" at {', '.join(f'{one:g}' for one in dict.fromkeys(at.tolist()))} degC"
    return f"Bias of the {model.kind}, not held by Kalibr's file: {each} {model.unit}{warm}: subtract it first"


def _densities(models: Mapping[Kind, SensorModel]) -> dict[str, float]:
    """Return the noise that the file holds: of each sensor that white noise and what drives the bias are known of."""
    found: dict[str, float] = {}
    for kind, word in WORDS.items():
        one = _noise(models.get(kind))
        for name, values in (("noise_density", one.white), ("random_walk", one.drive)) if one else ():
            if np.all(np.isfinite(values)):
                found[f"{word}_{name}"] = max(values)
    return found


def _noise(model: SensorModel | None) -> SensorNoise | None:
    if model is None or model.noise is None:
        return None
    return sensor_noise(model.kind, [terms_of(model.noise, model.kind, axis) for axis in model.axes])


def _noise_lost(model: SensorModel) -> list[Remark]:
    """Return what of the noise of a model the file cannot hold."""
    one = _noise(model)
    if one is None:
        return []
    words = list(one.left)
    words += [f"{model.kind}: differences between axes: the largest value is written"] if max(
        len(set(one.white)), len(set(one.drive))) > 1 else []  # fmt: skip
    missing = [name for name, values in (("white noise", one.white), ("noise that drives the bias", one.drive))
               if not np.all(np.isfinite(values))]  # fmt: skip
    words += [f"{model.kind}: no {name} of every axis: not written" for name in missing]
    return [Remark("not_held", "info", f"noise, {text}") for text in words]


def _parted(matrix: Array) -> tuple[Array, Array]:
    """Return L with a positive diagonal, and Q a rotation, with M = L Q."""
    q, upper = np.linalg.qr(invertible(matrix, "the matrix of the model", "").T)
    signs = np.sign(np.diag(upper))
    lower, turn = (upper.T * signs), (q * signs).T
    if np.linalg.det(turn) < 0.0:
        raise DataError(
            "Kalibr cannot hold this matrix: its axes are left-handed",
            why="one sensor reads against its axis, but C must be a rotation",
            do="Change the sign of that sensor's readings first",
            code="not_held",
        )
    return np.tril(lower), turn


def _in_si(model: SensorModel | None) -> tuple[Array, Array]:
    """Return matrix and term in acceleration of readings in SI.

    Outputs that are in a unit of the input are the readings, their nominal scale factor with them; others are readings
    once divided by it.
    """
    own = ideal() if model is None else triad(model)
    if model is None or not same_dimension(model.output_unit, model.unit):
        divisor = np.ones((3, 1)) if model is None else model.scale_factor[:, np.newaxis]
        return own.gain / divisor, own.force / divisor
    to_si = factor(model.output_unit, model.unit)
    return own.gain * to_si, own.force * to_si


def cannot_hold(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return what of these models the format leaves out, fills in or takes otherwise."""
    gone = [remark for kind, model in models.items() for remark in lost(model, NAME, HOLDS[kind])]
    gone += [
        Remark("not_held", "warning", f"{kind}: {NAME} cannot hold: bias",
               do=f"{_bias(model)}; the file says so in a comment")
        for kind, model in models.items()
        if np.any(model.bias)
    ]  # fmt: skip
    for kind, model in models.items():
        if model.output_unit != INPUT_UNIT[kind]:
            what = f"{kind}: {NAME} expects readings in {INPUT_UNIT[kind]}, not outputs in {model.output_unit}"
            scale = ", ".join(f"{s:.17g}" for s in model.scale_factor)
            alike = same_dimension(model.output_unit, model.unit)
            do = "Convert them" if alike else f"Divide the outputs by scale_factor: {scale}"
            gone.append(Remark("other_raw_unit", "warning", what, do=do))
    gone += [remark for model in models.values() for remark in _noise_lost(model)]
    return (*gone, *filled(models, NAME))


FORMAT = ModelFormat(name="kalibr-model", title=NAME, dump=dump, cannot_hold=cannot_hold, read=read)
