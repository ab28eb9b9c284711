"""The coefficients of a model as delivered, and what was estimated of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..core.units import divide
from ..files.models.apply_c import c_text
from ..files.models.apply_python import python_text
from ..sensors.model.sensor_model import equation
from ..sensors.model.serial import from_dict
from .findings import Figure, Finding
from .numbers import Branch, Number, Text
from .sections import MODEL

FORMULAS = 3  # lines of an equation before those that say what its symbols are


@dataclass(frozen=True)
class Coefficient:
    """One number of the terms of a model.

    Parameters
    ----------
    words : Finding
        What it is.
    symbol : str
        In the equation, and as a key of model.json.
    value : Number
        As delivered.
    unit : str
        SI.
    row : Branch or None
        The row of results that tells its uncertainty.
    note : str
        Why it has none.
    origin : str
        Test that it comes from, or citation.
    """

    words: Finding
    symbol: str
    value: Number
    unit: str
    row: Branch | None
    note: str
    origin: str


@dataclass(frozen=True)
class Delivered:
    """A model on the page."""

    equation: list[str]
    coefficients: list[Coefficient]
    sentences: list[Finding]
    scale_factors: list[tuple[str, Number, str]]
    python: str
    c: str


def delivered(content: Mapping[str, Any], model: Branch, rows: Sequence[Branch]) -> Delivered:
    """Return what the page says of a model.

    Parameters
    ----------
    content : dict
        Of model.json.
    model : Branch
        The same, with pointers.
    rows : sequence of Branch
        Rows of results.json.
    """
    sensor = from_dict(content)
    mine = {(str(row["quantity"]), str(row["axis"])): row for row in rows if row["test"] == MODEL}
    listed = [_coefficient(one, model, mine) for one in sensor.parameters]
    unit = divide(sensor.output_unit, sensor.unit)
    scale = [(a, s, unit) for a, s in zip(model["axes"], model["terms"]["scale_factor"], strict=True)]
    found = [_sentence(one, mine) for one in sensor.parameters]
    return Delivered(
        equation(sensor)[:FORMULAS], listed, [one for one in found if one], scale, python_text(sensor), c_text(sensor)
    )


def _coefficient(one: Any, model: Branch, rows: dict[tuple[str, str], Any]) -> Coefficient:
    value: Any = model["terms"][one.field]
    for place in one.index:
        value = value[place]
    origin = model["provenance"].get(one.name)
    from_where = "" if origin is None else origin["test"] or origin["source"]
    note = model["not_estimated"].get(one.name, "")
    row = rows.get((one.quantity, one.axis))
    if row is not None and row["status"] == "not_estimated":
        note = row["reason"]
        row = None
    unit = "1" if one.field == "matrix" and not one.index[0] else one.unit
    return Coefficient(_words(one, model["axes"]), _symbol(one, model["axes"]), value, unit, row, note, from_where)


def _words(one: Any, axes: Sequence[str]) -> Finding:
    if one.field == "matrix" and not one.index[0]:
        return (axes[one.index[1]], " sensor reads, ", axes[one.index[2]], " axis moves")
    return (f"{one.quantity.replace('_', ' ')} ", Text(one.axis))


def _symbol(one: Any, axes: Sequence[str]) -> str:
    if one.field == "matrix" and not one.index[0]:
        return f"M_{axes[one.index[1]]}{axes[one.index[2]]}"
    return str(one.name)


def _sentence(one: Any, rows: dict[tuple[str, str], Any]) -> Finding:
    """Say an entry of the matrix, or a bias, as a sentence."""
    row = rows.get((one.quantity, one.axis))
    if row is None or row["value"] is None or one.quantity not in {"scale_factor_error", "misalignment", "bias"}:
        return ()
    figure = Figure(row["value"], row["u"], Text("" if row["unit"] == "1" else row["unit"]))
    sensor = Text(one.axis[:1])
    if one.quantity == "bias":
        return ("The ", sensor, " sensor reads ", figure, " at no input.")
    if one.quantity == "misalignment":
        return (
            "As ",
            Text(one.axis[1:]),
            " moves, the ",
            sensor,
            " sensor reads as if turned towards it by ",
            figure,
            ".",
        )
    ends = row["interval"]
    if ends is not None and None not in (ends["lo"], ends["hi"]) and ends["lo"].raw <= 0.0 <= ends["hi"].raw:
        return ("The ", sensor, " sensor reads its own axis right, as far as the data tell: error ", figure, ".")
    much = "too much" if row["value"].raw >= 0 else "too little"
    return ("The ", sensor, " sensor reads ", much, " of its own axis: error ", figure, ".")
