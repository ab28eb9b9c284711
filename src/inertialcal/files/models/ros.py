"""ROS parameters that correct an IMU: scale and misalignment of the accelerometers, bias of both sensors.

::

    a = SM a_m - bias_a        w = w_m - bias_g

The equation, and the names ``imu/intrinsics/...``, are those of DLIO's parameter file [1]_; ``imu_calib`` [2]_ has the
same equation for accelerometers, with ``SM`` and ``bias`` alone, and its file is read too. ``SM`` is row by row. No
ROS file is known that holds a matrix of the gyros together with a bias; Kalibr's yaml holds the matrix (`kalibr`).

References
----------
.. [1] direct_lidar_inertial_odometry, cfg/dlio.yaml.
.. [2] imu_calib (github.com/dpkoch/imu_calib): ``SM_ raw - bias_``; its node finds the bias of
   the gyros itself, at rest.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.estimate import Array
from ...core.key import Kind
from ...core.remarks import Remark
from ...sensors.model.sensor_model import INPUT_UNIT, SensorModel
from .losses import (
    NO_TEMPERATURES,
    Loss,
    bias_curves,
    largest,
    loss_lines,
    loss_remarks,
    matrix_loss,
    other_losses,
    raw_unit,
)
from .model_format import ImportedModels, ModelFormat, ModelText
from .triad import Triad, invertible, model_of, numbers, triad
from .yaml_text import parse_yaml

NAME = "ROS"
SM, BIAS, GYRO = "imu/intrinsics/accel/sm", "imu/intrinsics/accel/bias", "imu/intrinsics/gyro/bias"
HEAD = "# ROS parameters written by inertialcal. Readings in m/s^2 and rad/s: a = sm a_m - bias; w = w_m - bias"


def dump(models: Mapping[Kind, SensorModel]) -> str:
    """Return the text of the file.

    Raises
    ------
    DataError
        As ``triad.triad``; ``not_invertible``.
    """
    lines = [HEAD]
    for model in models.values():
        lines += ["#", *(f"# {line}" for line in loss_lines(model, losses(model)))]
        if model.output_unit != model.unit:
            lines.append(f"# The driver must apply the scale factor: these correct readings in {model.unit}")
    lines += ["/**:", "  ros__parameters:", "    imu/calibration: false  # these, not an average at the start"]
    shown = []
    if "accelerometer" in models:
        inverse, bias = _inverse(models["accelerometer"])
        lines += [f"    {SM}: {_listed(inverse.ravel())}", f"    {BIAS}: {_listed(bias)}"]
        shown = ["# The same for imu_calib:", f"# SM: {_listed(inverse.ravel())}", f"# bias: {_listed(bias)}"]
    if "gyro" in models:
        triad(models["gyro"])
        lines.append(f"    {GYRO}: {_listed(models['gyro'].bias)}")
    return "\n".join([*lines, *shown]) + "\n"


def _inverse(model: SensorModel) -> tuple[Array, Array]:
    own = triad(model)
    gain = invertible(own.gain / model.scale_factor[:, np.newaxis], "the matrix of the model", "")
    inverse: Array = np.asarray(np.linalg.inv(gain), dtype=np.float64)
    return inverse, inverse @ model.bias


def _listed(values: Array) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


def read(given: ModelText) -> ImportedModels | None:
    """Return the models of what the file holds, DLIO's or imu_calib's; None for a text in another format.

    Raises
    ------
    DataError
        ``not_yaml``, ``missing_key``, ``schema``, ``not_invertible``.
    """
    if given.json is not None or not (
        "imu/intrinsics/" in given.text or given.text.lstrip().startswith(("SM:", "bias:"))
    ):
        return None
    where = given.where
    content = parse_yaml(given.text, where)
    own = content if isinstance(content, Mapping) else {}
    if "SM" in own or "bias" in own:
        own = {SM: own.get("SM"), BIAS: own.get("bias")}
    while len(own) == 1 and isinstance(one := next(iter(own.values())), Mapping):
        own = one
    models: dict[Kind, SensorModel] = {}
    if SM in own or BIAS in own:
        inverse = invertible(numbers(own, SM, (9,), where).reshape(3, 3), SM, where)
        gain: Array = np.asarray(np.linalg.inv(inverse), dtype=np.float64)
        models["accelerometer"] = _model("accelerometer", gain, gain @ numbers(own, BIAS, (3,), where))
    if GYRO in own or not models:
        models["gyro"] = _model("gyro", np.eye(3), numbers(own, GYRO, (3,), where))
    return ImportedModels(models)


def _model(kind: Kind, gain: Array, offset: Array) -> SensorModel:
    return model_of(kind, np.ones(3), Triad(gain, offset, np.zeros((3, 3))), INPUT_UNIT[kind], NAME)


def losses(model: SensorModel) -> list[Loss]:
    """Return what the file leaves out of a model."""
    found = [matrix_loss(model, diagonal=False)] if model.kind == "gyro" else []
    if model.bias_temperature is not None and np.any(model.bias_temperature):
        what, ends = "bias over temperature (that of the reference temperature is written)", model.temperature_range
        sizes = None if ends is None else np.array(
            [largest(one - value, ends) for one, value in zip(bias_curves(model), model.bias, strict=True)]
        )  # fmt: skip
        found.append(Loss(what, sizes, NO_TEMPERATURES if ends is None else "over the range of temperature"))
    return [one for one in (*found, *other_losses(model)) if one is not None]


def cannot_hold(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return what of these models the format leaves out, or takes otherwise."""
    return (*loss_remarks(models, NAME, losses), *raw_unit(models, NAME))


FORMAT = ModelFormat(
    name="ros", title=NAME, dump=dump, cannot_hold=cannot_hold, read=read, scale_optional=frozenset({"gyro"})
)
