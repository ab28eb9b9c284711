"""Format ``flight-c``: a folder with header, source, test vectors, the proved bound and the files for Gappa."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import nextafter
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.errors import DataError
from ....sensors.chain.converter import Chain
from ....sensors.model.sensor_model import SensorModel
from ....sensors.model.serial import model_checksum
from ..apply_parts import code_cannot_hold, plain
from ..model_format import ModelFormat
from .bound import Bounds, prove
from .design import Arithmetic, Constants, arithmetic, design
from .emit import SHORT, Unit, Vectors, fields, header, prefix, read_back, source, test_source
from .exact import ideal
from .gappa import goals, scripts
from .search import Found, search
from .twin import run
from .vectors import Chosen, choose

if TYPE_CHECKING:
    from ..model_format import Models

DEFAULT = "q27"


def files(models: Models, how: str | None = None) -> dict[str, bytes]:
    """Return the files of a folder of flight C.

    Parameters
    ----------
    models : mapping of str to SensorModel
        One or two sensors, each with its chain.
    how : str, optional
        Arithmetic: ``"q27"`` if not given.

    Raises
    ------
    DataError
        ``no_chain``; as `exact.ideal` and `design.design`.
    UsageError
        ``unknown_arithmetic``.
    """
    chosen = arithmetic(DEFAULT if how is None else how)
    return flight_files([(model, chain_of(model)) for model in models.values()], chosen)


def chain_of(model: SensorModel) -> Chain:
    """Return the chain of a model.

    Raises
    ------
    DataError
        ``no_chain`` where the model does not say how its codes become volts.
    """
    chain: object = getattr(model, "chain", None)
    if isinstance(chain, Chain):
        return chain
    raise DataError(
        f"{model.kind}: the model has no chain",
        why="flight-c starts from raw codes, and only the chain says what a code is",
        do="State chain in the campaign's sensor and run again; or export to c, which takes units",
        code="no_chain",
    )


def flight_files(sensors: Sequence[tuple[SensorModel, Chain]], how: Arithmetic) -> dict[str, bytes]:
    """Return the files of sensors with their chains, by name."""
    units = []
    for model, chain in sensors:
        function = ideal(model, chain)
        units.append(Unit(prefix(model, how), model, function, design(function, how)))
    stem = units[0].prefix if len(units) == 1 else f"imu_{units[0].prefix.removeprefix(SHORT['gyro'] + '_')}"
    text = source(stem, units)
    listed: dict[str, dict[str, Any]] = {}
    found: dict[str, str] = {}
    vectors = []
    for unit in units:
        constants = read_back(text, unit.prefix)
        _check_read_back(unit, constants)
        bounds = prove(unit.ideal, how, constants)
        worst = search(unit.ideal, how, constants, bounds)
        codes = {name: np.array([one.codes[name] for one in worst], dtype=np.int64) for name in worst[0].codes}
        chosen = choose(unit.ideal, how, constants, codes)
        vectors.append(Vectors(chosen.codes, *run(constants, how, chosen.codes)))
        listed[unit.prefix] = _record(unit, constants, bounds, worst, chosen)
        notes = [f"{unit.prefix}: error of the outputs over all codes, for the constants of {stem}.c.",
                 "Written by inertialcal. To run: gappa FILE; it ends with 0 where all goals are shown."]  # fmt: skip
        found |= {
            f"{unit.prefix}{name}.g": one for name, one in scripts(unit.ideal, how, constants, bounds, notes).items()
        }
    notes = [line for unit, made in zip(units, listed.values(), strict=True) for line in _notes(unit, made)]
    record = {"arithmetic": how.name, "source": f"{stem}.c", "sensors": listed}
    found = {
        f"{stem}.h": header(stem, units, notes),
        f"{stem}.c": text,
        f"{stem}_test.c": test_source(stem, units, vectors),
        "bound.json": json.dumps(record, indent=1, ensure_ascii=False) + "\n",
    } | found
    return {name: one.encode() for name, one in found.items()}


def _check_read_back(unit: Unit, constants: Constants) -> None:
    written = unit.design.constants
    same = constants.keys() == written.keys() and all(
        np.array_equal(constants[name], one.values) for name, one in written.items()
    )
    if not same:
        raise DataError(f"{unit.prefix}: constants differ from those in the text", code="not_read_back")


def _record(unit: Unit, constants: Constants, bounds: Bounds, worst: Sequence[Found], chosen: Chosen) -> dict[str, Any]:
    """Return what bound.json says of a sensor."""
    one = unit.ideal
    per_axis: dict[str, dict[str, Any]] = {}
    shown = goals(one, bounds)
    for i, axis in enumerate(one.axes):
        per_axis[axis] = {
            "bound": above(bounds.errors[i]),
            "worst_found": worst[i].error,
            "worst_codes": {name: codes for name, codes in worst[i].codes.items() if name != "built_in_test"},
            "gappa": above(shown[i]),
            "one_code": float(abs(one.weights[i][i])),
            "output": [float(bounds.outputs[i].low), float(bounds.outputs[i].high)],
        }
        if bounds.remainders:
            per_axis[axis]["inverse_remainder"] = above(bounds.remainders[i])
    record: dict[str, Any] = {
        "kind": one.kind,
        "item": {"maker": unit.model.item.maker, "part": unit.model.item.part, "serial": unit.model.item.serial},
        "condition": unit.model.condition,
        "model": model_checksum(unit.model),
        "unit": one.unit,
        "fields": list(fields(unit)),
        "axes": per_axis,
        "codes": [one.lowest, one.highest],
        "vectors": len(chosen.codes["signal"]),
        "no_code_shows": list(chosen.invisible),
        "unnoticed": list(chosen.unnoticed),
    }
    windows = {"reference_window": one.reference_window, "temperature_reference_window": one.temperature_window}
    record |= {name: [list(each) for each in window] for name, window in windows.items() if window is not None}
    if one.temperatures is not None:
        record["temperature_codes"] = [[each.lowest, each.highest] for each in one.temperatures]
    if unit.how.fixed:
        record |= {"fraction_bits": unit.how.bits, "guard_bits": unit.design.guard}
    return record


def above(value: Fraction) -> float:
    """Return a double that is no smaller."""
    near = float(value)
    return near if Fraction(near) >= value else nextafter(near, float("inf"))


def _notes(unit: Unit, record: Mapping[str, Any]) -> list[str]:
    """Return lines for the header: whose it is, how good."""
    item, one = unit.model.item, unit.ideal
    named = ", ".join(f"{word} {plain(text)}" for word, text in
                      (("maker", item.maker), ("part", item.part), ("serial", item.serial)) if text)  # fmt: skip
    lines = [f"{unit.prefix}: {one.kind}, {named or 'unnamed'}"]
    lines += [f"  condition: {plain(unit.model.condition)}"] if unit.model.condition else []
    lines += [
        f"  model: {model_checksum(unit.model)}",
        f"  codes {one.lowest} to {one.highest}; others are taken at the ends",
    ]
    for axis, each in record["axes"].items():
        lines.append(f"  {plain(axis)}: arithmetic within {each['bound']:.3g} {one.unit} for all codes; "
                     f"one code is {each['one_code']:.3g}")  # fmt: skip
    return lines


def _source_text(models: Models) -> str:
    """Source alone, in the default arithmetic."""
    return next(text for name, text in files(models).items() if name.endswith(".c") and "_test" not in name).decode()


FORMAT = ModelFormat(
    name="flight-c",
    title="flight C",
    dump=_source_text,
    cannot_hold=lambda models: code_cannot_hold(models, "flight C"),
    folder=files,
)
