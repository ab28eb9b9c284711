"""Noise of a sensor from what ``allan --json`` or a run wrote: its estimated terms, for a plan."""

from __future__ import annotations

import json
from typing import Any

from ....core.errors import DataError, InertialcalError, UsageError
from ....core.units import factor
from ....files.source import load
from ....sensors.noise import (
    BiasInstability,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Term,
    parameter_unit,
    quantity_name,
)

KINDS: tuple[type[Any], ...] = (Quantization, RandomWalk, BiasInstability, RateRandomWalk, RateRamp)


def noise_from(path: str, axis: str | None) -> tuple[tuple[Term, ...], str, str]:
    """Return the terms of one axis [m/s^2], the axis, and the hash of the file.

    Parameters
    ----------
    path : str
        A ``results.json``, or what ``allan --json`` printed.
    axis : str, optional
        Which; the only one where it is not said.

    Raises
    ------
    DataError
        If the file is none of these, or has no noise of an accelerometer.
    UsageError
        If it has several axes and none is said.
    """
    loaded = load(path)
    found = _by_axis(_rows(loaded.data, path), path)
    if not found:
        raise DataError(
            "no estimated noise term of an accelerometer",
            where=path,
            do="Make one with: inertialcal allan FILE --json > noise.json",
            code="no_noise",
        )
    if (len(found) > 1) if axis is None else (axis not in found):
        what = f"noise of axis {axis!r}" if axis else f"noise of {len(found)} axes"
        raise UsageError(f"{path}: {what}", do=f"Say --noise-axis: {', '.join(found)}", code="axis")
    chosen = axis or next(iter(found))
    return tuple(found[chosen].values()), chosen, loaded.sha256


def _rows(data: bytes, path: str) -> list[Any]:
    try:
        rows = json.loads(data)["results"]
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise TypeError
    except (ValueError, KeyError, TypeError, RecursionError):
        raise DataError(
            "not what allan --json or run writes",
            where=path,
            do="Make one with: inertialcal allan FILE --json > noise.json",
            code="schema",
        ) from None
    return rows


def _by_axis(rows: list[Any], path: str) -> dict[str, dict[str, Term]]:
    """Return the terms by axis and name; the first row of each counts, later ones are the same in other units."""
    names = {quantity_name(kind.name, "coefficient", "accelerometer"): kind for kind in KINDS}
    found: dict[str, dict[str, Term]] = {}
    for row in rows:
        kind = names.get(str(row.get("quantity")))
        value = row.get("value")
        if kind is None or row.get("status") != "estimated" or row.get("condition") or not value:
            continue
        try:
            size = float(value) * factor(str(row.get("unit")), parameter_unit(kind.name, "coefficient", "m/s^2"))
        except (InertialcalError, TypeError, ValueError):
            continue  # of a gyro, or in a unit that is none
        found.setdefault(str(row.get("axis")), {}).setdefault(kind.name, kind(abs(size)))
    return found
