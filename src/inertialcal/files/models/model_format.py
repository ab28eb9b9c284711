"""What a format of models is: how it is read and written, and what of a model it loses. Free of numpy."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from ...core.axes import Kind
from ...core.remarks import Remark

if TYPE_CHECKING:
    from ...sensors.model.sensor_model import SensorModel

    Models = Mapping[Kind, SensorModel]


@dataclass(frozen=True)
class ModelText:
    """Text of a file that holds models.

    Parameters
    ----------
    text : str
        All of it.
    where : str
        Path, for messages.
    kind : {"accelerometer", "gyro"}, optional
        Which sensor is wanted, for formats that do not tell.
    """

    text: str
    where: str = ""
    kind: Kind | None = None

    @cached_property
    def json(self) -> object:
        """Content as JSON; None where it is none."""
        try:
            return json.loads(self.text)
        except (ValueError, RecursionError):
            return None


@dataclass(frozen=True, eq=False)
class ImportedModels:
    """Models read from a file.

    Parameters
    ----------
    models : mapping
        Kind of sensor -> model.
    remarks : tuple of Remark
        What the file holds and a model does not.
    """

    models: Models
    remarks: tuple[Remark, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ModelFormat:
    """A format of models, in and out.

    Parameters
    ----------
    name : str
        As ``--to`` takes it: ``"kalibr-model"``.
    title : str
        Whose it is: ``"Kalibr"``.
    dump : callable
        Text of the file that holds these models.
    cannot_hold : callable
        What the format leaves out of these models, or fills in.
    one_sensor : bool
        Whether a file holds one sensor only.
    verbatim : bool
        Whether a file in this format is handed on byte by byte.
    read : callable or None
        Models of a text; it gives None for a text in another format. None where the format is written only.
    """

    name: str
    title: str
    dump: Callable[[Models], str]
    cannot_hold: Callable[[Models], tuple[Remark, ...]]
    one_sensor: bool = False
    verbatim: bool = False
    read: Callable[[ModelText], ImportedModels | None] | None = None


def of_one(text: Callable[[SensorModel], str]) -> Callable[[Models], str]:
    """Return the ``dump`` of a format that holds one sensor a file, from what makes the text of one model."""

    def dump(models: Models) -> str:
        (model,) = models.values()
        return text(model)

    return dump
