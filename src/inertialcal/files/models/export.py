"""A model handed out: judged on recordings held out, or marked by the word of whoever takes it.

``WRITERS`` is the one place that knows the formats: a name, and the function that makes the file from models and
their ``model.json``. ``c`` and ``python`` are code that applies the model. Those of others stand in
``files.models.imported``; a file of theirs reads as a model too, with ``#gyro`` or ``#accelerometer`` after its
name where it holds both.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ...core.axes import Kind
from ...core.errors import DataError, UsageError
from ...core.remarks import Remark
from ...sensors.model.sensor_model import SensorModel
from ..source import load
from ..write.atomic import replacing
from .apply_text import c_text, python_text
from .imported import FORMATS, Foreign, parse_foreign, sensor_named
from .model_json import dump_model, parse_model


@dataclass(frozen=True, eq=False)
class ModelFile:
    """A ``model.json`` as it lies there.

    Parameters
    ----------
    path : str
        As given.
    data : bytes
        Whole content.
    model : SensorModel
        What it says; its checksum fits.
    format : str
        ``"inertialcal"``, or whose format it is.
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


@dataclass(frozen=True)
class Handed:
    """A model handed out: SHA-256 of the file, and what of the model it cannot hold."""

    sha256: str
    remarks: tuple[Remark, ...]


Written = tuple[bytes, tuple[Remark, ...]]
Writer = Callable[[Sequence[ModelFile]], Written]


def _alone(sources: Sequence[ModelFile], name: str) -> ModelFile:
    if len(sources) > 1:
        raise UsageError(f"--to {name} holds one sensor a file", do="Export them one by one", code="one_sensor")
    return sources[0]


def _own(sources: Sequence[ModelFile]) -> Written:
    source = _alone(sources, "json")
    return source.data if source.format == "inertialcal" else dump_model(source.model).encode(), ()


def _code(name: str, text: Callable[[SensorModel], str]) -> Writer:
    def write(sources: Sequence[ModelFile]) -> Written:
        model = _alone(sources, name).model
        gone = f"{model.kind}: code in {name} cannot hold: uncertainties"
        told = () if model.estimate is None else (Remark("not_held", "info", gone),)
        return text(model).encode(), told

    return write


def _others(name: str) -> Writer:
    def write(sources: Sequence[ModelFile]) -> Written:
        models: dict[Kind, SensorModel] = {source.model.kind: source.model for source in sources}
        if len(models) < len(sources):
            raise UsageError(f"two models of a {sources[0].model.kind}", do="Give one of each", code="one_of_each")
        module = FORMATS[name]
        return module.dump(models).encode(), module.cannot_hold(models)

    return write


WRITERS: dict[str, Writer] = {
    "json": _own,
    **{name: _others(name) for name in FORMATS},
    "c": _code("c", c_text),
    "python": _code("python", python_text),
}


def load_model_file(path: str | os.PathLike[str]) -> ModelFile:
    """Return a model with the bytes of its file.

    Raises
    ------
    DataError
        ``missing_file``, ``empty_file``, and as ``model_json.parse_model``: ``checksum`` for a file that was
        changed by hand; ``which_sensor`` for a file of others that holds two; as ``others.parse_foreign``.
    """
    given = str(path)
    name, kind = (given, None) if os.path.exists(path) else sensor_named(given)
    loaded = load(name)
    try:
        text = loaded.data.decode("utf-8")
    except UnicodeDecodeError:
        raise DataError("no model: not UTF-8 text", where=name, code="not_json") from None
    foreign = parse_foreign(text, name, kind)
    if foreign is None:
        return ModelFile(name, loaded.data, parse_model(text, name))
    return ModelFile(given, loaded.data, _chosen(foreign, name, kind), foreign.format, foreign.remarks)


def _chosen(foreign: Foreign, name: str, kind: Kind | None) -> SensorModel:
    if kind is None and len(foreign.models) == 1:
        return next(iter(foreign.models.values()))
    if kind is None or kind not in foreign.models:
        raise DataError(
            f"the file holds models of: {', '.join(foreign.models)}",
            where=name,
            do="Say which: " + " or ".join(f"{name}#{one}" for one in foreign.models),
            code="which_sensor",
        )
    return foreign.models[kind]


def export(
    source: ModelFile,
    to: str,
    target: str | os.PathLike[str],
    unjudged: bool = False,
    beside: Sequence[ModelFile] = (),
) -> Handed:
    """Write a model in a format for others; the file is complete or not there.

    Parameters
    ----------
    source : ModelFile
        What to hand out.
    to : str
        Name of the format, one of ``WRITERS``.
    target : path
        File to write.
    unjudged : bool
        Hand it out although no recording held out has judged it.
    beside : sequence of ModelFile
        Model of the other sensor, for formats that hold both.

    Returns
    -------
    Handed
        SHA-256 of what was written; what the format cannot hold, and what the file read held beside the model.

    Raises
    ------
    UsageError
        ``unsupported_format``; ``one_sensor``, ``one_of_each``.
    DataError
        ``unjudged``; ``overwrites_input``; as the ``dump`` of the format.
    StoreError
        ``not_written``.
    """
    if to not in WRITERS:
        raise UsageError(f"--to {to!r}: no such format", do=f"Formats: {', '.join(WRITERS)}", code="unsupported_format")
    sources = (source, *beside)
    for one in sources:
        _check_judged(one, unjudged)
    data, remarks = WRITERS[to](sources)
    with replacing(target, [sensor_named(one.path)[0] for one in sources]) as aside:
        aside.write_bytes(data)
    before = tuple(remark for one in sources for remark in one.remarks)
    return Handed(hashlib.sha256(data).hexdigest(), before + remarks)


def _check_judged(source: ModelFile, unjudged: bool) -> None:
    if not (source.model.judged or unjudged):
        raise DataError(
            "the model was not judged on recordings held out",
            where=source.path,
            why="how well it does on data that it was not fitted to is not known",
            do='Mark tests with use = "hold_out" and run again, or say --unjudged',
            code="unjudged",
        )
