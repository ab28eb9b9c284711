"""imu_tk's text file: inverse, one sensor a file, without a word in it.

::

    x = T K (raw - B)

Three matrices as bare numbers, row by row: T with a diagonal of ones, K diagonal, then B. imu_tk itself estimates T of
an accelerometer as upper triangular; the file can hold any. Which sensor it is, no file tells.

References
----------
.. [1] imu_tk, ``CalibratedTriad_``; Tedaldi, Pretto and Menegatti, ICRA 2014, equations (2)-(5).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.key import Kind
from ...core.remarks import Remark
from ...sensors.model.sensor_model import SensorModel
from .model_format import ImportedModels, ModelFormat, ModelText
from .triad import Triad, check_possible, invertible, lost, model_of, triad

NAME = "imu_tk"
COUNT = 21
ONE = 1e-6  # off which a diagonal of T is none of ones: the file has six digits where its own tool wrote it
HOLDS = frozenset({"bias"})
HINTS: dict[Kind, str] = {"accelerometer": "acc", "gyro": "gyr"}  # in the name of a file


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def read(given: ModelText) -> ImportedModels | None:
    """Return the model of the one sensor; None for a text in another format.

    Which sensor it is, the name of the file says (acc or gyr) where nobody did.

    Raises
    ------
    DataError
        ``which_sensor``; ``schema`` if T or K is not of its form; ``impossible_value``; ``not_invertible``.
    """
    words = given.text.split()
    if given.json is not None or len(words) != COUNT or not all(_is_number(word) for word in words):
        return None
    where, kind = given.where, given.kind or _by_name(given.where)
    values = np.array([float(word) for word in words])
    t, k, offset = values[:9].reshape(3, 3), values[9:18].reshape(3, 3), values[18:]
    off = ~np.eye(3, dtype=bool)
    fits = np.all(np.isfinite(values)) and np.all(np.abs(np.diag(t) - 1.0) <= ONE) and not np.any(k[off])
    if not fits:
        raise DataError(
            "needs T with ones on its diagonal, a diagonal K, and B",
            where=where,
            do="Copy it again from imu_tk",
            code="schema",
        )
    check_possible(values, "T, K or B", where)
    gain: Array = np.asarray(np.linalg.inv(invertible(t @ k, "T K", where)), dtype=np.float64)
    own = Triad(gain, offset, np.zeros((3, 3)))
    return ImportedModels({kind: model_of(kind, 1.0 / np.diag(k), own, "count", NAME)})


def _by_name(where: str) -> Kind:
    name = where.replace("\\", "/").rsplit("/", 1)[-1].lower()
    named = [kind for kind, hint in HINTS.items() if hint in name]
    if len(named) != 1:
        raise DataError(
            "a model of imu_tk, which does not name its sensor",
            where=where,
            do=f"Name the sensor: {where}#accelerometer or {where}#gyro",
            code="which_sensor",
        )
    return named[0]


def dump(models: Mapping[Kind, SensorModel]) -> str:
    """Return the text of the file.

    Raises
    ------
    UsageError
        ``one_sensor`` for more than one.
    DataError
        As ``triad.triad``; ``not_invertible``; ``not_held`` if a sensor reads nothing along its own axis.
    """
    if len(models) != 1:
        raise UsageError("imu_tk holds one sensor a file", do="Export them one by one", code="one_sensor")
    own = triad(next(iter(models.values())))
    both = np.linalg.inv(invertible(own.gain, "the matrix of the model", ""))
    scale = np.diag(both)
    if not np.all(np.abs(scale) > 0.0):
        raise DataError("imu_tk cannot hold a matrix whose inverse has a zero on its diagonal", code="not_held")
    blocks = (both / scale, np.diag(scale), own.offset[:, np.newaxis])
    return "\n".join("".join(" ".join(repr(float(x)) for x in row) + "\n" for row in block) for block in blocks)


def cannot_hold(models: Mapping[Kind, SensorModel]) -> tuple[Remark, ...]:
    """Return what of these models the format leaves out."""
    gone = [remark for model in models.values() for remark in lost(model, NAME, HOLDS)]
    return (*gone, Remark("not_held", "info", f"{NAME} cannot hold: which sensor it is, units"))


FORMAT = ModelFormat(name="imu-tk", title=NAME, dump=dump, cannot_hold=cannot_hold, read=read)
