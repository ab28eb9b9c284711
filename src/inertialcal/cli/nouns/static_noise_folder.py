"""A folder with what ``allan`` found: figures, curves, terms, settings of filters."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.errors import StoreError, UsageError
from ...core.results import finite
from ...files.write.atomic import atomic_write
from ...procedures.static_noise.files.allan import NoiseFile
from ...procedures.static_noise.files.psd import SpectrumFile
from ...report.figure_file import write_figure
from ...report.plot import pictures
from ...sensors.noise.to_filters import FilterBlock

ENDINGS = {"kalibr": "imu.yaml", "px4": "px4.params", "gtsam": "gtsam_params.py", "kf-gins": "kf-gins.yaml"}


def write_folder(
    folder: Path, found: NoiseFile | SpectrumFile, blocks: Mapping[str, FilterBlock] | None = None
) -> list[Path]:
    """Write figures, curves and terms into a folder; return the files.

    Parameters
    ----------
    folder : Path
        Made where it is not there; files of the same names are replaced.
    found : NoiseFile or SpectrumFile
        What was found.
    blocks : mapping of str to FilterBlock, optional
        Settings of filters, by their word.

    Raises
    ------
    UsageError
        If the name is that of a file.
    StoreError
        If it cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        do = "Name a folder, or end the name with .png, .svg or .pdf for a figure alone"
        raise UsageError(f"{folder} is a file, no folder", do=do, code="wrong_value")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(f"cannot make {folder}: {error.strerror}", code="not_writable") from None
    written = list(_figures(folder, found))
    texts = {"curves.csv": curves_text(found), "terms.json": terms_text(found)}
    texts |= {ENDINGS[target]: f"{block}\n" for target, block in (blocks or {}).items()}
    for name, text in texts.items():
        path = folder / name
        with atomic_write(path, found.inputs) as aside:
            aside.write_text(text, encoding="utf-8")
        written.append(path)
    return written


def _figures(folder: Path, found: NoiseFile | SpectrumFile) -> Iterable[Path]:
    """Write a figure a sensor and kind, all axes of it one below the other."""
    names = ("spectrum",) if isinstance(found, SpectrumFile) else ("allan", "spectrum")
    content = found.content()
    for sensor in found.sensors:
        for name in names:
            if not any(one["name"] == name and one["test"] == sensor.name for one in content["curves"]):
                continue
            drawn = pictures(content, figure=name, test=sensor.name)
            label = "".join(c if c.isalnum() and c.isascii() else "_" for c in sensor.name)
            path = folder / f"{name}_{label}.png"
            write_figure(path, drawn, found.inputs)
            yield path


def curves_text(found: NoiseFile | SpectrumFile) -> str:
    """Return the curves as CSV: one line a point, with its sensor, axis, record, curve and unit.

    Parameters
    ----------
    found : NoiseFile or SpectrumFile
        What was found.
    """
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["curve", "sensor", "axis", "record", "of", "at", "at_unit", "column", "value", "unit"])
    for curve in found.content()["curves"]:
        if curve["name"] != "record_length":
            writer.writerows(_points(curve))
    return buffer.getvalue()


def _points(curve: Mapping[str, Any]) -> Iterable[Sequence[Any]]:
    columns = dict(curve["columns"])
    (name, at), *others = columns.items()
    head = [curve["name"], curve["test"], curve["axis"], curve.get("recording", ""), curve.get("of", "")]
    for column, content in others:
        for place, value in zip(at["values"], content["values"], strict=True):
            shown = "" if value is None else value if isinstance(value, str) else repr(value)
            yield [*head, repr(place), at["unit"] or name, column, shown, content["unit"]]


def terms_text(found: NoiseFile | SpectrumFile) -> str:
    """Return the terms as JSON: rows in the units of data sheets, and each term's parameters inside (SI).

    Parameters
    ----------
    found : NoiseFile or SpectrumFile
        What was found.
    """
    noise = found.noise if isinstance(found, SpectrumFile) else found
    sensors = [
        {
            "sensor": one.name, "kind": one.group.kind, "unit": one.group.unit,
            "sample_interval": one.result.readings.records[0].interval,
            "averaging": one.result.readings.records[0].averaging,
            "axes": [
                {
                    "axis": axis.axis,
                    "terms": [] if axis.fit is None else
                    [{"term": term.name} | {name: finite(getattr(term, name)) for name in term.parameters}
                     for term in axis.fit.terms],
                }
                for axis in one.result.axes
            ],
        }
        for one in noise.sensors
    ]  # fmt: skip
    content = {
        "inputs": [{"path": path, "sha256": digest} for path, digest in found.inputs.items()],
        "sensors": sensors,
        "results": [row.to_dict() for row in noise.rows],
    }
    return json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
