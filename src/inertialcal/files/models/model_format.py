"""What a format of models is: how it is read and written, and what of a model it loses. Free of numpy."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from ...core.key import Kind
from ...core.remarks import Remark

if TYPE_CHECKING:
    from ...sensors.model.model_set import ModelSet
    from ...sensors.model.sensor_model import SensorModel

    Models = Mapping[Kind, SensorModel]


@dataclass(frozen=True)
class ModelText:
    """Text of a file that holds models."""

    text: str  # All of it
    where: str = ""  # Path, for messages
    kind: Kind | None = None  # Which sensor is wanted, for formats that do not tell

    @cached_property
    def json(self) -> object:
        """Content as JSON; None where it is none."""
        try:
            return json.loads(self.text)
        except (ValueError, RecursionError):
            return None


@dataclass(frozen=True, eq=False)
class ImportedModels:
    """Models read from a file."""

    models: Models  # Kind of sensor -> model
    remarks: tuple[Remark, ...] = ()  # What the file holds and a model does not
    by_condition: ModelSet | None = None  # Instead: of one sensor, a model a condition


@dataclass(frozen=True, kw_only=True)
class ModelFormat:
    """A format of models, in and out."""

    name: str  # As ``--to`` takes it: ``"kalibr-model"``
    title: str  # Whose it is: ``"Kalibr"``
    dump: Callable[[Models], str]  # Text of the file that holds these models
    cannot_hold: Callable[[Models], tuple[Remark, ...]]  # What the format leaves out of these models, or fills in
    one_sensor: bool = False  # Whether a file holds one sensor only
    # Files of the folder that it is written as, by name, in an arithmetic; None where the format is one file
    folder: Callable[[Models, str | None], Mapping[str, bytes]] | None = None
    verbatim: bool = False  # Whether a file in this format is handed on byte by byte
    # Sensors whose scale factor stays out of a file where it is not known, so that no nominal one is handed out
    scale_optional: frozenset[Kind] = frozenset()
    # Models of a text; it gives None for a text in another format. None where the format is written only.
    read: Callable[[ModelText], ImportedModels | None] | None = None


def of_one(text: Callable[[SensorModel], str]) -> Callable[[Models], str]:
    """Return the ``dump`` of a format that holds one sensor a file, from what makes the text of one model."""

    def dump(models: Models) -> str:
        (model,) = models.values()
        return text(model)

    return dump
