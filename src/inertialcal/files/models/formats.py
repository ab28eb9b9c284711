"""Formats of models: name, as ``--to`` takes it -> `ModelFormat`, loaded when it is asked for.

A built-in format is a module with a ``FORMAT``, and a line in `BUILT_IN`; installed packages add theirs by the entry
point ``inertialcal.model_formats``. Free of numpy: ``--help`` lists the names.
"""

from __future__ import annotations

from ...core.errors import DataError, Problem, UsageError
from ...core.registry import Registry
from .model_format import ImportedModels, ModelFormat, ModelText

OWN = "json"
BUILT_IN = {  # name -> module
    OWN: "model_json",
    "imucal": "imucal",
    "kalibr-model": "kalibr",
    "imu-tk": "imu_tk",
    "realsense": "realsense",
    "px4": "autopilots.px4",
    "ardupilot": "autopilots.ardupilot",
    "ros": "ros",
    "c": "apply_c",
    "python": "apply_python",
    "flight-c": "flight_c.format",
}
FORMATS = Registry(
    "format of models",
    ModelFormat,
    "inertialcal.model_formats",
    {name: f"{__package__}.{module}:FORMAT" for name, module in BUILT_IN.items()},
)


def read_models(given: ModelText) -> tuple[ModelFormat, ImportedModels]:
    """Return the models of a text, and its format.

    Formats of packages are asked where no built-in one knows the text and it does not say that it is ours; our own
    reader comes last, and says what is wrong.

    Raises
    ------
    DataError
        As the reader of the format; broken formats of packages are named.
    """
    own = isinstance(given.json, dict) and "schema_version" in given.json
    broken: list[Problem] = []
    for name in FORMATS:
        if name == OWN or (own and name not in BUILT_IN):
            continue
        try:
            found = FORMATS[name]
        except UsageError as error:
            broken += error.problems
            continue
        models = found.read(given) if found.read else None
        if models is not None:
            return found, models
    try:
        return FORMATS[OWN], _own(given)
    except DataError as error:
        raise DataError([*error.problems, *broken]) from None


def _own(given: ModelText) -> ImportedModels:
    from .model_json import read  # noqa: PLC0415 - numpy starts slowly

    return read(given)
