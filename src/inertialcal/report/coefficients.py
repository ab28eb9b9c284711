"""The coefficients of a model as delivered, and what was estimated of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..core.key import Key
from ..core.results import key_of
from ..core.show.rows import reason_text
from ..core.units import divide
from ..files.models.apply_c import c_text
from ..files.models.apply_python import python_text
from ..sensors.model.sensor_model import SensorModel, formulas
from ..sensors.model.serial import from_dict
from ..sensors.model.terms import Parameter
from .findings import Figure, Finding
from .numbers import Branch, Number, Text
from .sections import MODEL


@dataclass(frozen=True)
class Coefficient:
    """One number of the terms of a model."""

    meaning: Finding  # name of the quantity
    symbol: str  # in the equation, and as a key of model.json
    value: Number  # as delivered
    unit: str  # SI
    row: Branch | None  # the row of results that gives its uncertainty
    note: str  # why it has none
    origin: str  # test that it comes from, or citation


@dataclass(frozen=True)
class Delivered:
    """A model on the page."""

    condition: str  # that it is for; empty where none is told apart
    model: Branch  # what model.json holds of it, with pointers
    equation: list[str]
    coefficients: list[Coefficient]
    sentences: list[Finding]
    scale_factors: list[tuple[str, Number, str]]
    python: str
    c: str


def delivered(content: Mapping[str, Any], document: Branch, rows: Sequence[Branch]) -> list[Delivered]:
    """Return what the page says of each model.

    Parameters
    ----------
    content : dict
        Of model.json.
    document : Branch
        The same, with pointers.
    rows : sequence of Branch
        Rows of results.json.
    """
    named = {row["test"] for row in rows}
    found = []
    for condition, sensor in from_dict(content).items():
        own = f"{MODEL}_{condition}"  # of the first condition: MODEL alone
        mine = [row for row in rows if row["test"] == (own if own in named else MODEL)]
        found.append(_delivered(sensor, document["models"][condition], mine))
    return found


def _delivered(sensor: SensorModel, model: Branch, rows: Sequence[Branch]) -> Delivered:
    mine = {key_of(row): row for row in rows}
    listed = [_coefficient(one, model, mine) for one in sensor.parameters]
    unit = divide(sensor.output_unit, sensor.unit)
    scale = [(a, s, unit) for a, s in zip(model["axes"], model["terms"]["scale_factor"], strict=True)]
    found = [_sentence(one, mine) for one in sensor.parameters]
    return Delivered(
        sensor.condition,
        model,
        formulas(sensor),
        listed,
        [one for one in found if one],
        scale,
        python_text(sensor),
        c_text(sensor),
    )


def _coefficient(one: Parameter, model: Branch, rows: Mapping[Key, Any]) -> Coefficient:
    value: Any = (
        model["terms"][one.field]
        if not one.channel
        else next(other[one.part] for other in model["sensitivities"] if str(other["channel"]) == one.channel)
    )
    for place in one.index:
        value = value[place]
    origin = model["provenance"].get(one.name)
    row = rows.get(one.key)
    note = model["not_estimated"].get(one.name, "")
    if row is not None and row["status"] == "not_estimated":
        note, row = Text(reason_text(row)), None
    symbol, unit = str(one.name), one.unit
    meaning: Finding = (f"{one.key.name.replace('_', ' ')} ", Text(one.key.axis))
    if one.field == "matrix" and not one.index[0]:
        sensor, axis = (model["axes"][place] for place in one.index[1:])
        symbol, unit, meaning = f"M_{sensor}{axis}", "1", ("sensor ", sensor, ", input ", axis)
    return Coefficient(
        meaning, symbol, value, unit, row, note, "" if origin is None else origin["test"] or origin["source"]
    )


def _sentence(one: Parameter, rows: Mapping[Key, Any]) -> Finding:
    """Say an entry of the matrix, or a bias, in words; nothing where it was not estimated."""
    row = rows.get(one.key)
    if row is None or row["value"] is None or one.key.quantity not in {"scale_factor_error", "misalignment", "bias"}:
        return ()
    figure = Figure(row["value"], row["u"], Text("" if row["unit"] == "1" else row["unit"]))
    sensor = Text(one.key.axis[:1])
    if one.key.quantity == "bias":
        return (sensor, " bias: ", figure, ".")
    if one.key.quantity == "misalignment":
        return (sensor, " sensor turned towards ", Text(one.key.axis[1:]), " by ", figure, ".")
    ends = row["interval"]
    if ends is not None and None not in (ends["lo"], ends["hi"]) and ends["lo"].raw <= 0.0 <= ends["hi"].raw:
        return (sensor, " scale factor: no error shown (", figure, ").")
    return (sensor, " scale factor too ", "high" if row["value"].raw >= 0 else "low", ": error ", figure, ".")
