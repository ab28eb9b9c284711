"""Curves of a campaign as one Parquet file, ``curves.parquet``: a row a point, all curves one below the other.

Each row says of which curve it is (``curve`` counts them; ``test``, ``name``, ``axis``, ``of``, ``recording``); the
columns after that are those of the curves, null where a curve does not have one. Units stand in the metadata of the
schema under ``inertialcal``, a JSON list with an entry a curve, for a column may have another unit in another curve.
A column that holds numbers in one curve and words in another is two: the words are in ``NAME:text``, flags in
``NAME:flag``.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

from ...core.errors import DataError

FILE = "curves.parquet"
SCHEMA = 2
HEAD = ("test", "name", "axis", "of", "recording")
META = b"inertialcal"


def curves_bytes(curves: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the content of the file; the same curves give the same bytes.

    Parameters
    ----------
    curves : sequence of mapping
        As ``Curve.to_dict`` gives them.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import parquet  # noqa: PLC0415 - heavy import

    lengths = [len(next(iter(curve["columns"].values()))["values"]) for curve in curves]
    types = {"curve": pa.int32(), "text": pa.string(), "flag": pa.bool_()} | dict.fromkeys(HEAD, pa.string())
    parts: dict[str, list[Any]] = {key: [] for key in ("curve", *HEAD)}  # Of each column, from the top
    filled: dict[str, int] = {}  # Rows of each column that its parts have
    about, start, total = [], 0, sum(lengths)
    for number, (curve, length) in enumerate(zip(curves, lengths, strict=True)):
        parts["curve"].append(pa.repeat(pa.scalar(number, pa.int32()), length))
        for key in HEAD:
            parts[key].append(pa.repeat(pa.scalar(curve.get(key, ""), pa.string()), length))
        stored = {}
        for name, column in curve["columns"].items():
            kind = _kind(column["values"])
            place = name if name not in ("curve", *HEAD) and kind == "number" else f"{name}:{kind}"
            made = types.get(place.rpartition(":")[2], pa.float64())
            own = parts.setdefault(place, [])
            own += [pa.nulls(start - filled.get(place, 0), made), pa.array(column["values"], made)]
            filled[place] = start + length
            stored[name] = {"column": place, "unit": column["unit"]}
        about.append({key: curve[key] for key in HEAD if key in curve} | {"rows": length, "columns": stored})
        start += length
    arrays = []
    for name, own in parts.items():
        made = types.get(name.rpartition(":")[2], pa.float64())
        arrays.append(pa.concat_arrays([*own, pa.nulls(total - filled.get(name, total), made)]))
    schema = pa.schema(
        [pa.field(name, array.type) for name, array in zip(parts, arrays, strict=True)],
        metadata={META: json.dumps({"schema": SCHEMA, "curves": about}, ensure_ascii=False).encode()},
    )
    buffer = io.BytesIO()
    parquet.write_table(pa.Table.from_arrays(arrays, schema=schema), buffer, compression="zstd")
    return buffer.getvalue()


def read_curves(data: bytes, where: str = FILE) -> list[dict[str, Any]]:
    """Return the curves of a file as ``Curve.to_dict`` gives them.

    Raises
    ------
    DataError
        ``schema``, if it is no file of curves.
    """
    import pyarrow as pa  # noqa: PLC0415 - heavy import
    from pyarrow import parquet  # noqa: PLC0415 - heavy import

    try:
        table = parquet.read_table(io.BytesIO(data))
        about = json.loads((table.schema.metadata or {})[META])["curves"]
        found, start = [], 0
        for one in about:
            part = table.slice(start, one["rows"])
            start += one["rows"]
            columns = {
                name: {"unit": column["unit"], "values": part.column(column["column"]).to_pylist()}
                for name, column in one["columns"].items()
            }
            found.append({key: one[key] for key in HEAD if key in one} | {"columns": columns})
    except (pa.ArrowException, KeyError, TypeError, ValueError, OSError) as error:
        raise DataError(
            f"not the curves of a run: {type(error).__name__} {error}",
            where=where,
            do="Type again: inertialcal run DIR",
            code="schema",
        ) from None
    return found


def _kind(values: Sequence[Any]) -> str:
    """Return what a column holds: ``number``, ``flag`` or ``text``; one without any value holds numbers."""
    there = {*map(type, values)} - {type(None)}
    if any(issubclass(one, str) for one in there):
        return "text"
    return "flag" if there == {bool} else "number"
