"""RealSense's 3 x 4, as its calibration script writes it in JSON: inverse, and the bias after the matrix.

::

    x = S raw - bias

``scale_and_alignment`` are the nine numbers of S column after column (the script solves for rows of readings, whose
matrix is S'). Both sensors are in SI, raw and corrected.

References
----------
.. [1] librealsense, tools/rs-imu-calibration.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import Kind
from ...core.remarks import Remark
from ...sensors.model.sensor_model import INPUT_UNIT, SensorModel
from .model_format import ImportedModels, ModelFormat, ModelText
from .triad import Triad, filled, ideal, invertible, lost, model_of, numbers, triad

NAME = "RealSense"
KEYS: dict[Kind, str] = {"accelerometer": "accelerometer", "gyro": "gyroscope"}
HOLDS = frozenset({"bias"})


def read(given: ModelText) -> ImportedModels | None:
    """Return the models of both sensors of the first unit; None for a text in another format.

    Raises
    ------
    DataError
        ``missing_key``, ``schema``, ``not_invertible``.
    """
    content, where = given.json, given.where
    if not (isinstance(content, dict) and isinstance(content.get("imus"), list)):
        return None
    units = content["imus"]
    if not units or not isinstance(units[0], Mapping):
        raise DataError("imus is empty", where=where, code="missing_key")
    remarks = (
        [Remark("left_out", "warning", f"imus holds {len(units)} units: only the first is read")] if units[1:] else []
    )
    models = {kind: _parsed(units[0], kind, where) for kind in KEYS}
    return ImportedModels(models, tuple(remarks))


def _parsed(unit: Mapping[str, object], kind: Kind, where: str) -> SensorModel:
    key = KEYS[kind]
    own, place = unit.get(key), f"{where}: imus[0].{key}"
    flat = numbers(own, "scale_and_alignment", (9,), place)
    inverse = invertible(flat.reshape(3, 3).T, "scale_and_alignment", place)
    gain: Array = np.asarray(np.linalg.inv(inverse), dtype=np.float64)
    linear = Triad(gain, gain @ numbers(own, "bias", (3,), place), np.zeros((3, 3)))
    return model_of(kind, np.ones(3), linear, INPUT_UNIT[kind], NAME)


def dump(models: Mapping[Kind, SensorModel]) -> str:
    """Return the text of the file.

    Raises
    ------
    DataError
        As ``triad.triad``; ``not_invertible``.
    """
    unit = {}
    for kind, key in KEYS.items():
        own = triad(models[kind]) if kind in models else ideal()
        inverse = np.linalg.inv(invertible(own.gain, f"the matrix of the {kind}", ""))
        unit[key] = {"scale_and_alignment": inverse.T.ravel().tolist(), "bias": (inverse @ own.offset).tolist()}
    return json.dumps({"imus": [unit]}, indent=4, sort_keys=True, allow_nan=False) + "\n"


def cannot_hold(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return what of these models the format leaves out, or fills in."""
    gone = [remark for model in models.values() for remark in lost(model, NAME, HOLDS)]
    for kind, model in models.items():
        if model.output_unit != INPUT_UNIT[kind]:
            what = f"{kind}: {NAME} expects raw values in {INPUT_UNIT[kind]}; these are for {model.output_unit}"
            gone.append(Remark("other_raw_unit", "warning", what, do="Apply it to the same raw values as this model"))
    return (*gone, *filled(models, NAME))


FORMAT = ModelFormat(name="realsense", title=NAME, dump=dump, cannot_hold=cannot_hold, read=read)
