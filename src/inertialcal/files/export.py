"""A model handed out: judged on recordings held out, or marked by the word of whoever takes it.

``WRITERS`` is the one place that knows the formats: a name, and the function that makes the bytes of the file
from a model and its ``model.json``.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass

from ..core.errors import DataError, UsageError
from ..sensors.model import SensorModel
from .model_json import parse_model
from .replacing import replacing
from .source import load


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
    """

    path: str
    data: bytes
    model: SensorModel

    @property
    def sha256(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.data).hexdigest()


Writer = Callable[[ModelFile], bytes]
WRITERS: dict[str, Writer] = {"json": lambda source: source.data}


def load_model_file(path: str | os.PathLike[str]) -> ModelFile:
    """Return a model with the bytes of its file.

    Raises
    ------
    DataError
        ``missing_file``, ``empty_file``, and as ``model_json.parse_model``: ``checksum`` for a file that was
        changed by hand.
    """
    loaded = load(path)  # type: ignore[arg-type]
    try:
        text = loaded.data.decode("utf-8")
    except UnicodeDecodeError:
        raise DataError("no model: not UTF-8 text", where=str(path), code="not_json") from None
    return ModelFile(str(path), loaded.data, parse_model(text, str(path)))


def export(source: ModelFile, to: str, target: str | os.PathLike[str], unjudged: bool = False) -> str:
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

    Returns
    -------
    str
        SHA-256 of what was written.

    Raises
    ------
    UsageError
        ``unsupported_format``.
    DataError
        ``unjudged``; ``overwrites_input``.
    StoreError
        ``not_written``.
    """
    if to not in WRITERS:
        raise UsageError(f"--to {to!r}: no such format", do=f"Formats: {', '.join(WRITERS)}", code="unsupported_format")
    if not (source.model.judged or unjudged):
        raise DataError(
            "the model was not judged on recordings held out",
            where=source.path,
            why="how well it does on data that it was not fitted to is not known",
            do='Mark tests with use = "hold_out" and run again, or say --unjudged',
            code="unjudged",
        )
    data = WRITERS[to](source)
    with replacing(target, [source.path]) as aside:
        aside.write_bytes(data)
    return hashlib.sha256(data).hexdigest()
