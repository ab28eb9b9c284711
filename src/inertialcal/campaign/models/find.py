"""Models by file, by campaign or by name: ``model.json``, the folder of the campaign that made it, the catalogue."""

from __future__ import annotations

import json
import os
from pathlib import Path

from ...core.errors import DataError
from ...files.models.formats import FORMATS
from ...files.models.model_file import ModelFile, load_model_file
from ...files.source import checked_path, load
from ...sensors.catalogue import AS_PRINTED, CATALOGUE, CORRECTED, PublishedSensor
from ...sensors.model.model_set import ModelSet
from ...sensors.model.sensor_model import SensorModel
from ..outcome.publish import OUT, RESULTS, restore

MODEL = "model.json"


def load_model(path: str | os.PathLike[str], condition: str | None = None) -> SensorModel:
    """Return the model in a file, or that of a campaign.

    Parameters
    ----------
    path : path
        A ``model.json``, the folder of a campaign, or a published sensor by its name in the catalogue:
        ``"flight_unit"``.
    condition : str, optional
        Whose model is wanted, where there are several: ``"air"``.

    Raises
    ------
    UsageError
        ``condition_needed`` where there are several and none is named; ``no_such_condition``.
    DataError
        ``no_model`` for a folder without one; ``checksum`` for a file that was changed by hand; and as
        ``files.models.model_file.load_model_file``.
    """
    return find_model(path, condition).model


def load_models(path: str | os.PathLike[str]) -> ModelSet:
    """Return the models in a file, or those of a campaign, by condition.

    Parameters
    ----------
    path : path
        A ``model.json``, the folder of a campaign, or a published sensor by its name in the catalogue:
        ``"flight_unit"``.

    Raises
    ------
    DataError
        ``no_model`` for a folder without one; ``checksum`` for a file that was changed by hand; and as
        ``files.models.model_file.load_model_file``.
    """
    return find_model(path).models


def find_model(path: str | os.PathLike[str], condition: str | None = None, as_printed: bool = False) -> ModelFile:
    """Return the models in a file, of a campaign or of the catalogue, with their bytes.

    Parameters
    ----------
    condition : str, optional
        Whose model is wanted, where there are several.
    as_printed : bool
        Of the catalogue, the model with the mistakes of its document.

    Raises
    ------
    DataError
        As `load_model`; ``not_published`` where ``as_printed`` has no meaning.
    """
    given = Path(checked_path(path, "model"))
    sensor = published(path)
    if as_printed and (sensor is None or AS_PRINTED not in sensor.models):
        do = f"Published with mistakes that are known: {', '.join(_with(AS_PRINTED))}"
        raise DataError("only a published model can be taken as printed", str(path), do=do, code="not_published")
    if sensor is not None:
        if not sensor.models:
            do = f"The catalogue has models of: {', '.join(_with(CORRECTED))}"
            raise DataError("the catalogue has no model of this sensor", str(path), do=do, code="no_model")
        model = sensor.models[AS_PRINTED if as_printed else CORRECTED]
        models, data = ModelSet((model,)), FORMATS["json"].dump({model.kind: model}).encode()
        if condition is not None:
            models.only(condition, str(path))
        return ModelFile(str(path), data, models, "catalogue", condition=condition)
    return load_model_file(_in_folder(given) if given.is_dir() else given, condition)


def published(path: str | os.PathLike[str]) -> PublishedSensor | None:
    """Return the sensor of the catalogue of that name; None where there is none, or a file of that name."""
    name = str(path)
    return CATALOGUE[name]() if name in CATALOGUE and not Path(path).exists() else None


def _with(state: str) -> list[str]:
    return [name for name, made in CATALOGUE.items() if state in made().models]


def _in_folder(folder: Path) -> Path:
    restore(folder)
    for model in (folder / OUT / MODEL, folder / MODEL):
        if model.is_file():
            return model
    if (folder / OUT / RESULTS).is_file():
        raise DataError(
            "the last run of this campaign gave no model",
            where=str(folder),
            why=_error(folder / OUT / RESULTS)
            or "it has no [model], or its model did worse than none on recordings held out",
            do=f"Look into {folder / OUT / RESULTS}",
            code="no_model",
        )
    raise DataError(
        "no model here, and no results",
        where=str(folder),
        do=f"Name a {MODEL}, or type: inertialcal run {folder}",
        code="no_model",
    )


def _error(results: Path) -> str:
    """Return the first error among the remarks of a run; empty where there is none."""
    try:
        remarks = json.loads(load(results, document=True).data)["remarks"]
        return next((f"{one['where']}: {one['what']}" for one in remarks if one["severity"] == "error"), "")
    except (DataError, ValueError, RecursionError, KeyError, TypeError):
        return ""
