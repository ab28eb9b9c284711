"""PX4's parameters of thermal compensation and of sensor offsets, as a file that QGroundControl loads.

::

    x = R (r - TC(T) - OFF)      accelerometers: times SCALE, before R
    TC = X0 + X1 d + X2 d^2 + X3 d^3,    d = clip(T, TMIN, TMAX) - TREF

in rad/s, m/s2 and degC. ``TC_G0_X1_2`` is the first power of the z gyro of the first IMU. R is how the board is
mounted: the readings of this file are those of the board. Where the bias changes with temperature it stands in TC,
with its constant, and the offsets are written as zero: an offset beside it would be taken off twice [2]_.

References
----------
.. [1] PX4-Autopilot, src/modules/sensors (TemperatureCompensation.cpp), src/lib/sensor_calibration.
.. [2] PX4-Autopilot, pull request 14717; also 20660.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES, Kind
from ....core.remarks import Remark
from ....sensors.model.sensor_model import INPUT_UNIT, SensorModel
from ..losses import Loss, loss_lines, loss_remarks, raw_unit
from ..model_format import ImportedModels, ModelFormat, ModelText
from ..triad import Triad, model_of
from .offsets import (
    ORDER,
    check_axes,
    figure,
    has_temperature,
    known_bias,
    losses,
    offsets,
    parameters,
    scales,
    unknown_left,
    unknown_lines,
)

NAME = "PX4"
LETTER: dict[Kind, str] = {"gyro": "G", "accelerometer": "A"}
WORD: dict[Kind, str] = {"gyro": "GYRO", "accelerometer": "ACC"}
BEGINNINGS = ("TC_G", "TC_A", "CAL_GYRO", "CAL_ACC")
INTEGER, REAL = 6, 9  # types of a parameter, as QGroundControl has them
IMUS = range(1, 4)  # beside the first


def dump(models: Mapping[Kind, SensorModel]) -> str:
    """Return the text of the file, for the first IMU.

    Raises
    ------
    DataError
        As `offsets.offsets`.
    """
    lines = [
        "# PX4 parameters written by inertialcal, for the first IMU. QGroundControl: Parameters, Tools, Load from file",
        "# Vehicle\tcomponent\tname\tvalue\ttype",
    ]
    for kind, model in models.items():
        check_axes(model)
        lines += ["#", *(f"# {line}" for line in loss_lines(model, _losses(model)))]
        if model.output_unit != model.unit:
            lines.append(f"# The driver must apply the scale factor: these correct readings in {model.unit}")
        lines += unknown_lines(kind, model, NAME)
        lines += _thermal(kind, model) if has_temperature(model) else [_line(f"TC_{LETTER[kind]}_ENABLE", 0)]
        lines += _constant(kind, model)
    return "\n".join(lines) + "\n"


def _thermal(kind: Kind, model: SensorModel) -> list[str]:
    held, name = offsets(model, NAME), f"TC_{LETTER[kind]}0"
    lines = [
        _line(f"TC_{LETTER[kind]}_ENABLE", 1),
        f"# {name}_ID: give it the value of CAL_{WORD[kind]}0_ID of the vehicle; without it PX4 applies none of this",
        _line(f"{name}_TREF", held.centre),
        _line(f"{name}_TMIN", held.range[0]),
        _line(f"{name}_TMAX", held.range[1]),
    ]
    lines += [_line(f"{name}_X{power}_{axis}", float(held.powers[power, axis]))
              for power in range(ORDER + 1) for axis in range(len(AXES))]  # fmt: skip
    return lines


def _constant(kind: Kind, model: SensorModel) -> list[str]:
    lines = []
    if known_bias(model):
        thermal = has_temperature(model)
        lines += ["# Zero, because TC holds the constant: both would be taken off"] if thermal else []
        values = np.zeros(3) if thermal else model.bias
        lines += [_line(f"CAL_{WORD[kind]}0_{axis.upper()}OFF", float(value))
                  for axis, value in zip(AXES, values, strict=True)]  # fmt: skip
    return lines + [_line(f"CAL_{WORD[kind]}0_{axis.upper()}SCALE", one)
                    for axis, one in zip(AXES, scales(model), strict=True) if one is not None]  # fmt: skip


def _line(name: str, value: float) -> str:
    whole = isinstance(value, int)
    return f"1\t1\t{name}\t{value if whole else figure(value)}\t{INTEGER if whole else REAL}"


def read(given: ModelText) -> ImportedModels | None:
    """Return the models of the first IMU; None for a text in another format.

    Raises
    ------
    DataError
        ``missing_key`` for thermal compensation without its range or reference; as `offsets.parameters`.
    """
    found = None if given.json is not None else parameters(given.text, BEGINNINGS, given.where)
    if found is None:
        return None
    remarks = [
        Remark("left_out", "warning", f"IMU {n} is in the file too: only the first is read")
        for n in IMUS
        if any(key.startswith((f"TC_G{n}_", f"TC_A{n}_", f"CAL_GYRO{n}_", f"CAL_ACC{n}_")) for key in found)
    ]
    models: dict[Kind, SensorModel] = {}
    for kind, letter in LETTER.items():
        if any(key.startswith((f"TC_{letter}0_", f"CAL_{WORD[kind]}0_")) for key in found):
            models[kind] = _model(kind, found, given.where, remarks)
    if not models:
        raise DataError("no parameters of the first IMU", where=given.where, code="missing_key")
    return ImportedModels(models, tuple(remarks))


def _model(kind: Kind, found: Mapping[str, float], where: str, remarks: list[Remark]) -> SensorModel:
    name, own = f"TC_{LETTER[kind]}0", f"CAL_{WORD[kind]}0"
    powers: Array = np.array([[found.get(f"{name}_X{power}_{i}", 0.0) for i in range(3)] for power in range(ORDER + 1)])
    off = np.array([found.get(f"{own}_{axis.upper()}OFF", 0.0) for axis in AXES])
    scale = np.array([found.get(f"{own}_{axis.upper()}SCALE", 1.0) for axis in AXES])
    if not np.all(scale > 0.0):
        raise DataError(f"{own}: a SCALE is not positive", where=where, code="schema")
    enabled = found.get(f"TC_{LETTER[kind]}_ENABLE", 1.0) != 0.0 and bool(np.any(powers))
    gain = np.eye(3) if kind == "gyro" else np.diag(1.0 / scale)
    if not enabled:
        return model_of(kind, np.ones(3), Triad(gain, off, np.zeros((3, 3))), INPUT_UNIT[kind], NAME)
    if np.any(off):
        what = f"{kind}: offsets beside thermal compensation: PX4 takes off both"
        do = f"If they are of a calibration made before it, set {own}_XOFF, _YOFF and _ZOFF to 0"
        remarks.append(Remark("two_offsets", "warning", what, where, do=do))
    for key in (f"{name}_TREF", f"{name}_TMIN", f"{name}_TMAX"):
        if key not in found:
            raise DataError(f"no {key}", where=where, do="Save all parameters of the vehicle", code="missing_key")
    low, high = found[f"{name}_TMIN"], found[f"{name}_TMAX"]
    return model_of(
        kind, np.ones(3), Triad(gain, powers[0] + off, np.zeros((3, 3))), INPUT_UNIT[kind], NAME,
        over_temperature=(powers[1:], found[f"{name}_TREF"], (low, high)),
    )  # fmt: skip


def _losses(model: SensorModel) -> list[Loss]:
    """Return what the parameters leave out of a model."""
    late = "the last change of less than 1 degC (PX4 takes a new offset only then)"
    found = losses(model, NAME)
    return [*found, Loss(late, offsets(model, NAME).slope)] if has_temperature(model) else found


def cannot_hold(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return what of these models the format leaves out, or takes otherwise."""
    gone = loss_remarks(models, NAME, _losses)
    thermal = [f"TC_{LETTER[kind]}0_ID" for kind, model in models.items() if has_temperature(model)]
    ids = (
        Remark("set_on_vehicle", "warning", f"{' and '.join(thermal)}: not in the file: PX4 needs the ID of the sensor",
               do="Copy it from CAL_GYRO0_ID (CAL_ACC0_ID) of the vehicle"),
    ) if thermal else ()  # fmt: skip
    return (*gone, *ids, *unknown_left(models, NAME), *raw_unit(models, NAME))


FORMAT = ModelFormat(
    name="px4",
    title=NAME,
    dump=dump,
    cannot_hold=cannot_hold,
    read=read,
    scale_optional=frozenset(WORD),
)
