"""imucal's JSON, version 2: forward, accelerometers and gyros in one file.

::

    acc = K_a R_a a + b_a        gyr = K_g R_g w + K_ga a + b_g

``acc`` and ``gyr`` are outputs in ``from_acc_unit`` and ``from_gyr_unit``; a and w come in ``acc_unit`` and
``gyr_unit`` (m/s2 and deg/s). K is diagonal; a row of R has length 1 as its tool writes it, which is not relied on.

References
----------
.. [1] imucal 2.6, ``FerrarisCalibrationInfo``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np

from ...core.errors import DataError, InertialcalError
from ...core.estimate import Array
from ...core.key import Kind
from ...core.remarks import Remark
from ...core.units import factor, normalise, same_dimension
from ...sensors.model.sensor_model import INPUT_UNIT, SensorModel
from .model_format import ImportedModels, ModelFormat, ModelText
from .triad import Triad, filled, ideal, invertible, lost, model_of, numbers, triad

NAME = "imucal"
VERSION = "2.0"
UNITS: dict[Kind, tuple[str, str]] = {"accelerometer": ("acc_unit", "m/s^2"), "gyro": ("gyr_unit", "deg/s")}
LETTER: dict[Kind, str] = {"accelerometer": "a", "gyro": "g"}
UNKNOWN = ("a.u.", "", None)
HOLDS = {"accelerometer": frozenset({"bias"}), "gyro": frozenset({"bias", "g_sensitivity"})}


def read(given: ModelText) -> ImportedModels | None:
    """Return the models of both sensors; None for a text in another format.

    Raises
    ------
    DataError
        ``schema_version`` for a file from before version 2; ``missing_key``, ``schema``, ``not_invertible``,
        ``unknown_unit``.
    """
    content, where = given.json, given.where
    if not (isinstance(content, dict) and {"K_a", "R_a", "cal_type"} <= content.keys()):
        return None
    version = str(content.get("_format_version", ""))
    if not version.startswith("2."):
        raise DataError(
            f"imucal file of version {version or 'before 2'}",
            where=where,
            why="the file does not give its units",
            do="Read it with imucal's own loader for old files, and save it again",
            code="schema_version",
        )
    remarks: list[Remark] = []
    models = {kind: _parsed(content, kind, where, remarks) for kind in UNITS}
    return ImportedModels(models, tuple(remarks))


def _parsed(content: Mapping[str, object], kind: Kind, where: str, remarks: list[Remark]) -> SensorModel:
    letter, (key, _) = LETTER[kind], UNITS[kind]
    to_si = _factor(content, key, INPUT_UNIT[kind], where)
    k = numbers(content, f"K_{letter}", (3, 3), where)
    if np.any(k[~np.eye(3, dtype=bool)]):
        raise DataError(f"K_{letter} is not diagonal", where=where, code="schema")
    gain = invertible(k @ numbers(content, f"R_{letter}", (3, 3), where), f"K_{letter} R_{letter}", where) / to_si
    force = np.zeros((3, 3))
    if kind == "gyro":
        force = numbers(content, "K_ga", (3, 3), where) / _factor(content, "acc_unit", "m/s^2", where)
    own = Triad(gain, numbers(content, f"b_{letter}", (3,), where), force)
    unit = _unit(content, key, remarks)
    alike = same_dimension(unit, INPUT_UNIT[kind])
    nominal = np.full(3, factor(INPUT_UNIT[kind], unit)) if alike else np.diag(k) / to_si
    return model_of(kind, np.copysign(nominal, np.diag(gain)), own, unit, NAME)


def _factor(content: Mapping[str, object], key: str, to: str, where: str) -> float:
    """Return what turns a unit of the file into SI."""
    try:
        return factor(str(content.get(key)), to)
    except InertialcalError:
        raise DataError(
            f"{key} is {content.get(key)!r}: no unit of this sensor",
            where=where,
            do=f"Name one like {to}",
            code="unknown_unit",
        ) from None


def _unit(content: Mapping[str, object], key: str, remarks: list[Remark]) -> str:
    """Return the unit of the outputs; counts where the file does not tell."""
    stated = content.get(f"from_{key}")
    if stated not in UNKNOWN:
        try:
            return normalise(str(stated))
        except InertialcalError:
            pass
    what = f"from_{key} is {stated!r}: outputs are assumed to be counts"
    remarks.append(Remark("unknown_unit", "info", what, do="Apply the model to the same data that imucal used"))
    return "count"


def dump(models: Mapping[Kind, SensorModel]) -> str:
    """Return the text of the file.

    Raises
    ------
    DataError
        As ``triad.triad``.
    """
    content: dict[str, object] = dict(UNITS.values())
    content |= {f"from_{key}": _output(models.get(kind), unit) for kind, (key, unit) in UNITS.items()}
    content["comment"] = "written by inertialcal"
    for kind in UNITS:
        content |= _dumped(kind, models.get(kind))
    content |= {"cal_type": "Ferraris", "_format_version": VERSION}
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _output(model: SensorModel | None, unit: str) -> str:
    return unit if model is None else model.output_unit


def _dumped(kind: Kind, model: SensorModel | None) -> dict[str, object]:
    letter, (_, unit) = LETTER[kind], UNITS[kind]
    own = ideal() if model is None else triad(model)
    gain: Array = own.gain if model is None else own.gain * factor(unit, INPUT_UNIT[kind])
    lengths = np.linalg.norm(gain, axis=1)
    content = {
        f"K_{letter}": np.diag(lengths).tolist(),
        f"R_{letter}": (gain / lengths[:, np.newaxis]).tolist(),
        f"b_{letter}": own.offset.tolist(),
    }
    return content | ({"K_ga": own.force.tolist()} if kind == "gyro" else {})


def cannot_hold(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return what of these models the format leaves out, or fills in."""
    gone = [remark for kind, model in models.items() for remark in lost(model, NAME, HOLDS[kind])]
    return (*gone, *filled(models, NAME))


FORMAT = ModelFormat(name="imucal", title=NAME, dump=dump, cannot_hold=cannot_hold, read=read)
