"""Formats of models: the one place that knows them all.

A format is a module with a ``FORMAT``, and a line in ``MODULES``. Free of numpy: ``--help`` lists the names.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .model_format import ImportedModels, ModelFormat, ModelText

MODULES = {  # name, as --to takes it -> module
    "json": "model_json",
    "imucal": "imucal",
    "kalibr-model": "kalibr",
    "imu-tk": "imu_tk",
    "realsense": "realsense",
    "c": "apply_c",
    "python": "apply_python",
}
OWN = "json"


def model_format(name: str) -> ModelFormat:
    """Return the format of a name, one of ``MODULES``."""
    found: ModelFormat = import_module(f".{MODULES[name]}", __package__).FORMAT
    return found


def read_models(given: ModelText) -> tuple[ModelFormat, ImportedModels]:
    """Return the models of a text, and its format; our own reader comes last, and says what is wrong.

    Raises
    ------
    DataError
        As the reader of the format.
    """
    for name in sorted(MODULES, key=lambda name: name == OWN):
        found = model_format(name)
        models = found.read(given) if found.read else None
        if models is not None:
            return found, models
    raise AssertionError("our own reader takes every text, or refuses it")
