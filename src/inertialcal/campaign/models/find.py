"""Models by file or by campaign: ``model.json``, or the folder of the campaign that made it."""

from __future__ import annotations

import json
import os
from pathlib import Path

from ...core.errors import DataError
from ...files.models.model_file import ModelFile, load_model_file
from ...files.source import load
from ...sensors.model.model_set import ModelSet
from ...sensors.model.sensor_model import SensorModel
from ..outcome.publish import OUT, RESULTS, restore

MODEL = "model.json"


def load_model(path: str | os.PathLike[str], condition: str | None = None) -> SensorModel:
    """Return the model in a file, or that of a campaign.

    Parameters
    ----------
    path : path
        A ``model.json``, or the folder of a campaign.
    condition : str, optional
        Whose model is wanted, where there are several: ``"air"``.

    Raises
    ------
    DataError
        ``no_model`` for a folder without one; ``condition_needed`` where there are several and none is named,
        ``no_such_condition``; ``checksum`` for a file that was changed by hand; and as
        ``files.models.model_file.load_model_file``.
    """
    return find_model(path, condition).model


def load_models(path: str | os.PathLike[str]) -> ModelSet:
    """Return the models in a file, or those of a campaign, by condition.

    Parameters
    ----------
    path : path
        A ``model.json``, or the folder of a campaign.

    Raises
    ------
    DataError
        ``no_model`` for a folder without one; ``checksum`` for a file that was changed by hand; and as
        ``files.models.model_file.load_model_file``.
    """
    return find_model(path).models


def find_model(path: str | os.PathLike[str], condition: str | None = None) -> ModelFile:
    """Return the models in a file or of a campaign, with its bytes; Raises as `load_model`."""
    given = Path(path)
    return load_model_file(_in_folder(given) if given.is_dir() else given, condition)


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
