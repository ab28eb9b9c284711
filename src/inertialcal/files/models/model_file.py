"""A model with the file that it lies in, ours or one of others.

A file that holds both sensors is named with ``#gyro`` or ``#accelerometer`` behind it.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from typing import get_args

from ...core.axes import Kind
from ...core.errors import DataError
from ...core.remarks import Remark
from ...sensors.model.sensor_model import SensorModel
from ..source import load
from .formats import read_models
from .model_format import ImportedModels, ModelText


@dataclass(frozen=True, eq=False)
class ModelFile:
    """A file with a model, as it lies there.

    Parameters
    ----------
    path : str
        As given.
    data : bytes
        Whole content.
    model : SensorModel
        What it says; where the file has a checksum, it fits.
    format : str
        Title of its format: ``"inertialcal"``, ``"Kalibr"``.
    remarks : tuple of Remark
        What the file holds and the model does not.
    """

    path: str
    data: bytes
    model: SensorModel
    format: str = "inertialcal"
    remarks: tuple[Remark, ...] = ()

    @property
    def sha256(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.data).hexdigest()


def load_model_file(path: str | os.PathLike[str]) -> ModelFile:
    """Return a model with the bytes of its file.

    Raises
    ------
    DataError
        ``missing_file``, ``empty_file``; ``which_sensor`` for a file that holds two; as the reader of the format:
        ``checksum`` for a ``model.json`` that was changed by hand.
    """
    given = str(path)
    name, kind = (given, None) if os.path.exists(path) else sensor_named(given)
    loaded = load(name)
    try:
        text = ModelText(loaded.data.decode("utf-8"), name, kind)
    except UnicodeDecodeError:
        raise DataError("no model: not UTF-8 text", where=name, code="not_json") from None
    found, imported = read_models(text)
    if found.one_sensor:
        return ModelFile(name, loaded.data, next(iter(imported.models.values())), found.title, imported.remarks)
    return ModelFile(given, loaded.data, _chosen(imported, name, kind), found.title, imported.remarks)


def _chosen(imported: ImportedModels, name: str, kind: Kind | None) -> SensorModel:
    if kind is None and len(imported.models) == 1:
        return next(iter(imported.models.values()))
    if kind is None or kind not in imported.models:
        raise DataError(
            f"the file holds models of: {', '.join(imported.models)}",
            where=name,
            do="Say which: " + " or ".join(f"{name}#{one}" for one in imported.models),
            code="which_sensor",
        )
    return imported.models[kind]


def sensor_named(path: str) -> tuple[str, Kind | None]:
    """Return the path and the sensor of ``FILE#gyro`` or ``FILE#accelerometer``; no sensor where none is named."""
    for kind in get_args(Kind):
        if path.endswith(f"#{kind}"):
            return path.removesuffix(f"#{kind}"), kind
    return path, None
