"""Curves of ``results.json`` as arrays: absent numbers are NaN, absent curves are none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.units import factor

Curve = Mapping[str, Any]


def curves(results: Mapping[str, Any], name: str) -> list[Curve]:
    """Return the curves of that name, in their order; those without any value are left out."""
    found = [curve for curve in results.get("curves", []) if curve.get("name") == name and "columns" in curve]
    return [curve for curve in found if any(map(_has_values, curve["columns"].values()))]


def numbers(curve: Curve, column: str) -> Array:
    """Return a column as float64, shape (n,).

    Raises
    ------
    DataError
        If the curve has no such column, or it holds text.
    """
    try:
        values = _column(curve, column)["values"]
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    except (TypeError, ValueError):
        raise DataError(
            f"curve {curve['name']!r}: column {column!r} does not hold numbers", code="wrong_curve"
        ) from None


def words(curve: Curve, column: str) -> list[str]:
    """Return a column as text; null is empty. A column that is not there is empty throughout."""
    if column not in curve["columns"]:
        return [""] * len(next(iter(curve["columns"].values()))["values"])
    return ["" if value is None else str(value) for value in _column(curve, column)["values"]]


def flags(curve: Curve, column: str) -> NDArray[np.bool_]:
    """Return a column of true and false, shape (n,); null is false."""
    return np.array([value is True for value in _column(curve, column)["values"]], dtype=np.bool_)


def unit(curve: Curve, column: str) -> str:
    """Return the unit of a column."""
    return str(_column(curve, column).get("unit", ""))


def scale_to(wanted: str, given: str) -> float:
    """Return what takes numbers to the unit that a figure is drawn in; one that nobody knows is taken as it stands."""
    try:
        return factor(given, wanted)
    except DataError:
        return 1.0


def finite(values: Array) -> Array:
    """Return the finite ones."""
    return values[np.isfinite(values)]


def distinct(values: Iterable[str]) -> list[str]:
    """Return each text once, in order of first appearance."""
    return list(dict.fromkeys(values))


def _has_values(column: Mapping[str, Any]) -> bool:
    """Whether any value of a column is there."""
    return any(value is not None for value in column["values"])


def _column(curve: Curve, column: str) -> Mapping[str, Any]:
    columns = curve["columns"]
    if column not in columns:
        raise DataError(
            f"curve {curve['name']!r} has no column {column!r}", do=f"It has: {', '.join(columns)}", code="wrong_curve"
        )
    return columns[column]  # type: ignore[no-any-return]


def thinned(values: Array, most: int) -> NDArray[np.intp]:
    """Return the places of at most that many values: of each bin in the order given the least and the largest."""
    n = len(values)
    if n <= most:
        return np.arange(n)
    edges = np.linspace(0, n, most // 2 + 1).astype(int)
    kept: set[int] = set()
    for start, stop in pairwise(edges.tolist()):
        part = values[start:stop]
        if np.any(np.isfinite(part)):
            kept |= {start + int(np.nanargmin(part)), start + int(np.nanargmax(part))}
    return np.array(sorted(kept), dtype=np.intp)


def envelope(time: Array, lo: Array, hi: Array) -> tuple[Array, Array]:
    """Return the line from least to largest and back: shapes (2n,); NaN where a bin has no sample."""
    at, values = np.repeat(time, 2), np.stack([lo, hi], axis=1)
    values[1::2] = values[1::2, ::-1].copy()  # so that neighbours join at the same end
    return at, np.where(np.isfinite(values).all(axis=1, keepdims=True), values, np.nan).ravel()


__all__: Sequence[str] = ("curves", "distinct", "envelope", "finite", "flags", "numbers", "thinned", "unit", "words")
