"""Models with the file that they lie in, ours or one of others.

A file that holds both sensors is named with ``#gyro`` or ``#accelerometer`` behind it.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from ...core.errors import DataError, UsageError
from ...core.key import Kind
from ...core.remarks import Remark
from ...sensors.model.model_set import ModelSet
from ...sensors.model.sensor_model import SensorModel
from ..source import load
from ..write.atomic import atomic_write, write_folder
from .formats import FORMATS, read_models
from .model_format import ImportedModels, ModelFormat, ModelText

if TYPE_CHECKING:
    from .model_format import Models


@dataclass(frozen=True, eq=False)
class ModelFile:
    """A file with the models of a sensor, one a condition, as it lies there."""

    path: str  # As given
    data: bytes  # Whole content
    models: ModelSet  # What it says; where the file has a checksum, it fits
    format: str = "inertialcal"  # Title of its format: ``"inertialcal"``, ``"Kalibr"``
    remarks: tuple[Remark, ...] = ()  # What the file holds and the model does not
    condition: str | None = None  # Whose model is wanted

    @property
    def model(self) -> SensorModel:
        """Model of the condition that is wanted, or the only one.

        Raises
        ------
        UsageError
            ``condition_needed``, ``no_such_condition``.
        """
        return self.models.only(self.condition, self.path)

    @property
    def sha256(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.data).hexdigest()


def load_model_file(path: str | os.PathLike[str], condition: str | None = None) -> ModelFile:
    """Return models with the bytes of their file.

    Parameters
    ----------
    path : path
        Of the file.
    condition : str, optional
        Whose model is wanted, where the file holds several.

    Raises
    ------
    UsageError
        ``no_such_condition``.
    DataError
        ``missing_file``, ``empty_file``; ``which_sensor`` for a file that holds two; as the reader of the format:
        ``checksum`` for a ``model.json`` that was changed by hand.
    """
    given = str(path)
    name, kind = (given, None) if os.path.exists(path) else sensor_named(given)
    loaded = load(name, document=True)
    try:
        text = ModelText(loaded.data.decode("utf-8"), name, kind)
    except UnicodeDecodeError:
        raise DataError("no model: not UTF-8 text", where=name, code="not_json") from None
    found, imported = read_models(text)
    models = imported.by_condition
    if models is None:
        models = ModelSet((_chosen(imported, name, kind),))
    else:
        given = name
    if condition is not None:
        models.only(condition, given)
    return ModelFile(given, loaded.data, models, found.title, imported.remarks, condition)


def _chosen(imported: ImportedModels, name: str, kind: Kind | None) -> SensorModel:
    if kind is None and len(imported.models) == 1:
        return next(iter(imported.models.values()))
    if kind is None or kind not in imported.models:
        raise DataError(
            f"the file holds models of: {', '.join(imported.models)}",
            where=name,
            do="Say which: " + " or ".join(f"{name}#{one}" for one in imported.models),
            code="which_sensor",
        )
    return imported.models[kind]


def sensor_named(path: str) -> tuple[str, Kind | None]:
    """Return the path and the sensor of ``FILE#gyro`` or ``FILE#accelerometer``; no sensor where none is named."""
    for kind in get_args(Kind):
        if path.endswith(f"#{kind}"):
            return path.removesuffix(f"#{kind}"), kind
    return path, None


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
    nominal: bool = False,
    arithmetic: str | None = None,
) -> Exported:
    """Write a model in a format for others; the file, or the folder, is complete or not there.

    Parameters
    ----------
    source : ModelFile
        What to hand out.
    to : str
        Name of the format, one of ``formats.FORMATS``.
    target : path
        File to write; a folder, new or empty, for formats of several files.
    unjudged : bool
        Hand it out although no recording held out has judged it.
    others : sequence of ModelFile
        Model of the other sensor, for formats that hold both.
    nominal : bool
        Write the nominal scale factor of axes whose own is not known, where the format cannot mark it.
    arithmetic : str, optional
        For formats that compute: ``"q27"``, ``"float32"``, ``"float64"``.

    Returns
    -------
    Exported
        SHA-256 of what was written, of a folder that of the lines ``SHA-256  name`` of its files; what the format
        cannot hold, and what the file read held beside the model.

    Raises
    ------
    UsageError, DataError
        As `content`; ``no_arithmetic``; ``overwrites_input``.
    StoreError
        ``not_written``; ``not_writable`` of a folder.
    """
    sources = (source, *others)
    chosen, models, remarks = _checked(sources, to, unjudged, nominal)
    if arithmetic is not None and chosen.folder is None:
        raise UsageError(f"--arithmetic: --to {to} has no choice", do="Leave it out", code="no_arithmetic")
    if chosen.folder is not None:
        files = chosen.folder(models, arithmetic)
        write_folder(Path(target), files)
        listing = "".join(f"{hashlib.sha256(data).hexdigest()}  {name}\n" for name, data in sorted(files.items()))
        return Exported(hashlib.sha256(listing.encode()).hexdigest(), remarks)
    data = chosen.dump(models).encode() if models else source.data
    with atomic_write(target, [sensor_named(one.path)[0] for one in sources]) as aside:
        aside.write_bytes(data)
    return Exported(hashlib.sha256(data).hexdigest(), remarks)


def content(
    sources: Sequence[ModelFile], to: str, unjudged: bool = False, nominal: bool = False
) -> tuple[bytes, tuple[Remark, ...]]:
    """Return the file that `export` writes, of a folder the one that matters most, and the remarks on it.

    Raises
    ------
    UsageError
        ``unsupported_format``; ``one_sensor``, ``one_of_each``.
    DataError
        ``unjudged``; ``scale_factor_unknown``; as the ``dump`` of the format.
    """
    chosen, models, remarks = _checked(sources, to, unjudged, nominal)
    return chosen.dump(models).encode() if models else sources[0].data, remarks


def _checked(
    sources: Sequence[ModelFile], to: str, unjudged: bool, nominal: bool
) -> tuple[ModelFormat, Models, tuple[Remark, ...]]:
    """Return the format, the models that are handed out, none where the file is as it lies, and the remarks."""
    source = sources[0]
    if to not in FORMATS:
        raise UsageError(f"--to {to!r}: no such format", do=f"Formats: {', '.join(FORMATS)}", code="unsupported_format")
    chosen = FORMATS[to]
    kept = chosen.verbatim and source.format == chosen.title and source.condition is None
    for one in sources:
        models_of = one.models.values() if kept else (one.model,)
        open_ones = [model for model in models_of if not (unjudged or model.judged)]
        if open_ones:
            of = " and ".join(f"in {model.condition}" for model in open_ones if model.condition)
            raise DataError(
                f"hold-out recordings have not confirmed the model{f' {of}' if of else ''}",
                where=one.path,
                why="none were held out, or their closed loop is INCONCLUSIVE: its error on other data is unknown",
                do='Hold out (more) tests, use = "hold_out", and run again; or add --unjudged',
                code="unjudged",
            )
    unknown = (
        []
        if chosen.title == ModelFile.format
        else [
            remark
            for one in sources
            if one.models.kind not in chosen.scale_optional
            for remark in _unknown(one, nominal)
        ]
    )
    if chosen.one_sensor and len(sources) > 1:
        raise UsageError(f"--to {to} holds one sensor a file", do="Export them one by one", code="one_sensor")
    if len({one.models.kind for one in sources}) < len(sources):
        raise UsageError(f"two models of a {source.models.kind}", do="Give one of each", code="one_of_each")
    models: Models = {} if kept else {one.models.kind: one.model for one in sources}
    before = tuple(remark for one in sources for remark in one.remarks)
    return chosen, models, (*before, *(() if kept else chosen.cannot_hold(models)), *unknown)


def _unknown(source: ModelFile, nominal: bool) -> list[Remark]:
    """Return the remark on scale factors that no reading gave, which would be handed out as 1.

    Raises
    ------
    DataError
        ``scale_factor_unknown`` if it was not asked for.
    """
    model = source.model
    own = zip(model.axes, model.matrix[0].diagonal(), strict=True)
    axes = [axis for axis, entry in own if f"scale_factor_error_{axis}" in model.not_estimated and entry == 1.0]
    if model.estimate is None or not axes:
        return []
    what = f"{model.kind}: scale factor of {', '.join(axes)} not estimated"
    if not nominal:
        why = f"this format would hold the nominal one: {model.not_estimated[f'scale_factor_error_{axes[0]}']}"
        do = "Estimate it, export --to json, which says so, or add --nominal"
        raise DataError(what, source.path, why, do, "scale_factor_unknown")
    return [Remark("scale_factor_unknown", "warning", f"{what}: the nominal one is written", source.path)]
