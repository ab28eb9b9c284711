"""Models in the formats of others, in and out: the one dict of their names.

Each format states its equation, direction and units in the head of its module. What a format cannot hold of a model is
told by ``cannot_hold``, thing by thing; what a file holds and a model does not comes as remarks of `Foreign`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import ModuleType

from ...core.axes import Kind
from ...core.errors import DataError
from . import imu_tk, imucal, kalibr, realsense
from .triad import KINDS, Foreign

__all__ = ["FORMATS", "Foreign", "parse_foreign", "sensor_named"]

FORMATS: Mapping[str, ModuleType] = {
    "imucal": imucal,
    "kalibr-model": kalibr,
    "imu-tk": imu_tk,
    "realsense": realsense,
}
_HINTS: dict[Kind, tuple[str, ...]] = {"accelerometer": ("acc",), "gyro": ("gyr",)}


def parse_foreign(text: str, where: str, kind: Kind | None = None) -> Foreign | None:
    """Return the models of a text in a format of others; None where it is none of them.

    Parameters
    ----------
    text : str
        Content of the file.
    where : str
        Its path, for messages, and for which sensor it is where the file does not tell (acc or gyr in its name).
    kind : {"accelerometer", "gyro"}, optional
        Which sensor it is, for formats that do not tell.

    Raises
    ------
    DataError
        As the ``parse`` of the format; ``which_sensor``.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        return _plain(text, where, kind)
    if imucal.matches(content):
        return imucal.parse(content, where)
    return realsense.parse(content, where) if realsense.matches(content) else None


def _plain(text: str, where: str, kind: Kind | None) -> Foreign | None:
    if imu_tk.matches(text):
        return imu_tk.parse(text, where, kind or _by_name(where))
    return kalibr.parse(text, where) if kalibr.matches(text) else None


def _by_name(where: str) -> Kind:
    name = where.replace("\\", "/").rsplit("/", 1)[-1].lower()
    told = [kind for kind, hints in _HINTS.items() if any(hint in name for hint in hints)]
    if len(told) != 1:
        raise DataError(
            "a model of imu_tk, which does not tell its sensor",
            where=where,
            do=f"Say which it is: {where}#accelerometer or {where}#gyro",
            code="which_sensor",
        )
    return told[0]


def sensor_named(path: str) -> tuple[str, Kind | None]:
    """Return the path and the sensor of ``FILE#gyro`` or ``FILE#accelerometer``; no sensor where none is named."""
    for kind in KINDS:
        if path.endswith(f"#{kind}"):
            return path.removesuffix(f"#{kind}"), kind
    return path, None
