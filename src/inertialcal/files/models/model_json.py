"""``model.json``: the models of a sensor on disk, one a condition, with a checksum over what they say."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import NoReturn

from ...core.errors import DataError, InertialcalError
from ...core.schema.checksum import check_unchanged, sealed_texts
from ...sensors.model.model_set import ModelSet
from ...sensors.model.sensor_model import SensorModel
from ...sensors.model.serial import FIRST, SCHEMA_VERSION, contents_of, from_dict
from ..source import load
from ..write.atomic import atomic_write
from .model_format import ImportedModels, ModelFormat, ModelText, of_one


def write_model(path: str | os.PathLike[str], model: SensorModel | ModelSet) -> None:
    """Write models; the file is complete or not there.

    Raises
    ------
    StoreError
        If it cannot be written.
    """
    with atomic_write(path) as aside:
        aside.write_text(dump_models(model), encoding="utf-8", newline="\n")


def dump_model(model: SensorModel) -> str:
    """Return the text of a ``model.json`` with one model: the same model gives the same bytes."""
    return dump_models(model)


def dump_models(models: SensorModel | ModelSet) -> str:
    """Return the text of ``model.json``: the same models give the same bytes."""
    return dump_each([models])[0]


def dump_each(every: Sequence[SensorModel | ModelSet]) -> list[str]:
    """Return the text of each of many files."""
    return sealed_texts(contents_of(every))


def read_models(path: str | os.PathLike[str]) -> ModelSet:
    """Read models.

    Raises
    ------
    DataError
        ``missing_file``; ``not_json``; ``schema_version`` for one that is not known here; ``checksum`` if the
        content was changed after it was written; ``schema``. Each with the file.
    """
    try:
        text = load(os.fspath(path), document=True).data.decode("utf-8")
    except UnicodeDecodeError:
        what = "cannot read the model: not UTF-8 text"
        raise DataError(what, where=str(path), do="Check the path", code="missing_file") from None
    return parse_models(text, str(path))


def read_model(path: str | os.PathLike[str], condition: str | None = None) -> SensorModel:
    """Read the model of a condition; Raises as `read_models` and `ModelSet.only`."""
    return read_models(path).only(condition)


def parse_models(text: str, where: str = "") -> ModelSet:
    """Return the models of the text of a ``model.json``; Raises as `read_models`."""
    try:
        content = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise DataError(f"no JSON: {error}", where=where, code="not_json") from None
    if not isinstance(content, dict):
        raise DataError("no model: the file does not hold a JSON object", where=where, code="schema")
    try:
        if content.get("schema_version") in {FIRST, SCHEMA_VERSION}:
            check_unchanged(content, do="Use the model as written by `run`, or run the campaign again")
        return from_dict(content)
    except InertialcalError as error:
        problem = error.problems[0]
        raise DataError(problem.what, where=where, why=problem.why, do=problem.do, code=problem.code) from None


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number")


def read(given: ModelText) -> ImportedModels:
    """Return the models of a text that is ours; Raises as `read_models`."""
    return ImportedModels({}, by_condition=parse_models(given.text, given.where))


FORMAT = ModelFormat(
    name="json",
    title="inertialcal",
    dump=of_one(dump_model),
    cannot_hold=lambda models: (),
    one_sensor=True,
    verbatim=True,
    read=read,
)
