"""A model handed out: judged on recordings held out, or marked by the word of whoever takes it."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass

from ...core.axes import Kind
from ...core.errors import DataError, UsageError
from ...core.remarks import Remark
from ...sensors.model.sensor_model import SensorModel
from ..write.atomic import atomic_write
from .formats import FORMATS
from .model_file import ModelFile, sensor_named


@dataclass(frozen=True)
class Exported:
    """A model handed out: SHA-256 of the file, and what of the model it cannot hold."""

    sha256: str
    remarks: tuple[Remark, ...]


def export(
    source: ModelFile,
    to: str,
    target: str | os.PathLike[str],
    unjudged: bool = False,
    others: Sequence[ModelFile] = (),
) -> Exported:
    """Write a model in a format for others; the file is complete or not there.

    Parameters
    ----------
    source : ModelFile
        What to hand out.
    to : str
        Name of the format, one of ``formats.FORMATS``.
    target : path
        File to write.
    unjudged : bool
        Hand it out although no recording held out has judged it.
    others : sequence of ModelFile
        Model of the other sensor, for formats that hold both.

    Returns
    -------
    Exported
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
    if to not in FORMATS:
        raise UsageError(f"--to {to!r}: no such format", do=f"Formats: {', '.join(FORMATS)}", code="unsupported_format")
    sources = (source, *others)
    for one in sources:
        _check_judged(one, unjudged)
    chosen = FORMATS[to]
    if chosen.one_sensor and len(sources) > 1:
        raise UsageError(f"--to {to} holds one sensor a file", do="Export them one by one", code="one_sensor")
    models: dict[Kind, SensorModel] = {one.model.kind: one.model for one in sources}
    if len(models) < len(sources):
        raise UsageError(f"two models of a {source.model.kind}", do="Give one of each", code="one_of_each")
    kept = chosen.verbatim and source.format == chosen.title
    data = source.data if kept else chosen.dump(models).encode()
    gone = chosen.cannot_hold(models)
    with atomic_write(target, [sensor_named(one.path)[0] for one in sources]) as aside:
        aside.write_bytes(data)
    before = tuple(remark for one in sources for remark in one.remarks)
    return Exported(hashlib.sha256(data).hexdigest(), before + gone)


def _check_judged(source: ModelFile, unjudged: bool) -> None:
    if not (source.model.judged or unjudged):
        raise DataError(
            "the model was not judged on recordings held out",
            where=source.path,
            why="how well it does on data that it was not fitted to is not known",
            do='Mark tests with use = "hold_out" and run again, or say --unjudged',
            code="unjudged",
        )
