"""Noise of the accelerometer for a forecast: coefficients of the settings, or the rows of a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ....core.errors import DataError, InertialcalError, PlanError
from ....core.results import Row
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
from .settings import Noise

KINDS: tuple[type[Any], ...] = (Quantization, RandomWalk, BiasInstability, RateRandomWalk, RateRamp)
NAMED = {quantity_name(kind.name, "coefficient", "accelerometer"): kind for kind in KINDS}
MAKE = "Write one with: inertialcal allan FILE --json > noise.json"


def terms_of(noise: Noise) -> tuple[Term, ...]:
    """Return the terms whose coefficients are given [m/s^2]."""
    given = {kind: getattr(noise, name) for name, kind in NAMED.items()}
    return tuple(kind(size) for kind, size in given.items() if size is not None)


def noise_from(path: Path, axis: str | None) -> tuple[tuple[Term, ...], str, str]:
    """Return the terms of one axis of a file [m/s^2], the axis, and the hash of the file.

    Raises
    ------
    DataError
        If the file is not output of `allan --json` or a run, or has no noise of an accelerometer.
    PlanError
        If it has several axes and none is chosen.
    """
    loaded, where = load(path), str(path)
    try:
        rows = [Row.from_dict(row) for row in json.loads(loaded.data)["results"]]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DataError("not output of allan --json or run", where, do=MAKE, code="schema") from None
    found: dict[str, dict[str, Term]] = {}
    for row in rows:  # the first row of each term counts: later ones are the same in other units
        kind = NAMED.get(row.key.quantity)
        if kind is None or row.status != "estimated" or not row.case.plain or not row.value:
            continue
        try:
            size = row.value * factor(row.unit, parameter_unit(kind.name, "coefficient", "m/s^2"))
        except InertialcalError:
            continue  # of a gyro, or without a known unit
        found.setdefault(row.axis, {}).setdefault(kind.name, kind(abs(size)))
    if not found:
        raise DataError("no estimated noise term of an accelerometer", where, do=MAKE, code="no_noise")
    if (len(found) > 1) if axis is None else (axis not in found):
        what = f"no noise of axis {axis!r}" if axis else f"noise of {len(found)} axes"
        raise PlanError(what, where, do=f"Set noise.axis to one of: {', '.join(found)}", code="axis")
    chosen = axis or next(iter(found))
    return tuple(found[chosen].values()), chosen, loaded.sha256
