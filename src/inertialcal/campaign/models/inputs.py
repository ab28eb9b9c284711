"""Which column of a recording is which input of a model.

A column is taken for an axis if its header says so (quantity and axis), or if it is named; a column that could be
two things is not taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ...core.errors import DataError
from ...core.recording import Recording
from ...core.units import parse_quantity, same_dimension
from ...files.text.headers import full_name
from ...sensors.chain.converter import Chain
from ...sensors.model.on_recordings import CONDITIONS as CHANNELS
from ...sensors.model.on_recordings import QUANTITY
from ...sensors.model.sensor_model import SensorModel
from ...sensors.model.terms import FORCE_AXES

CONDITIONS = {"temperature": "degC", "temperature_rate": "degC/s", "pressure": "Pa", "time": "s"}
FORCES = tuple(f"force_{axis}" for axis in FORCE_AXES)
UNCERTAINTY = "u_"  # before the name of a column that holds standard uncertainties
RECORDED = {
    "reference": "ref",
    "temperature": "temp",
    "validity": "bit",
    "temperature_reference": "temp_ref",
}  # ``x_ref``


@dataclass(frozen=True)
class Taken:
    """What is used of a recording."""

    # What it is -> name of the column: each axis, and conditions (``temperature``, ``temperature_x``,
    # ``pressure``, ``force_x``, ...)
    columns: Mapping[str, str] = field(default_factory=dict)
    temperature: float | None = None  # The same for all rows [degC], where no column gives it


def taken(
    model: SensorModel,
    recording: Recording,
    columns: Mapping[str, str] | None = None,
    temperature: str | float | None = None,
) -> Taken:
    """Return which columns are used for what.

    Parameters
    ----------
    columns : mapping of str to str, optional
        What it is -> name of the column; an axis, or a channel that the model has a sensitivity to, is found by its
        header where it is not in it.
    temperature : str or float, optional
        Column, or temperature of all rows: ``"25 degC"``, or a number [degC].

    Raises
    ------
    DataError
        ``wrong_column`` where an axis has no column or several, or a name is not known.
    """
    named = dict(columns or {})
    channels = [one.channel for one in model.sensitivities]
    known = {*model.axes, *CONDITIONS, *FORCES, *(f"temperature_{axis}" for axis in model.axes), *channels}
    strangers = [f"{what}={name}" for what, name in named.items() if what not in known]
    if strangers:
        raise DataError(
            f"{', '.join(strangers)}: the model has no such input",
            do=f"It takes: {', '.join(model.axes)}, and {', '.join(sorted(known - set(model.axes)))}",
            code="wrong_column",
        )
    named = {what: full_name(recording.names, name) or recording.channel(name).name for what, name in named.items()}
    found = {axis: named[axis] if axis in named else _column_of(model, recording, axis) for axis in model.axes}
    found |= {
        name: column for name in channels if name not in CONDITIONS and (column := full_name(recording.names, name))
    }
    column = full_name(recording.names, temperature) if isinstance(temperature, str) else None
    if column is not None:
        return Taken({**found, "temperature": column, **named})
    return Taken(found | named, None if temperature is None else _fixed_temperature(recording, temperature))


def chain_columns(chain: Chain, recording: Recording, columns: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the columns of counts by what they are: axes, ``reference_x``, ``temperature_x``, ``validity_x``, ...

    Those that are named, and those whose header is the word, or the recorder's (``x_ref``); empty where the axes are in
    other units than counts.

    Raises
    ------
    DataError
        ``wrong_column`` for a name that is not known.
    """
    words = [*chain.axes, *CHANNELS, *(f"{what}_{axis}" for what in CHANNELS for axis in chain.axes)]
    strangers = [f"{what}={name}" for what, name in (columns or {}).items() if what not in words]
    if strangers:
        raise DataError(
            f"{', '.join(strangers)}: the chain has no such input", do=f"It takes: {', '.join(words)}",
            code="wrong_column",
        )  # fmt: skip
    named = {
        what: full_name(recording.names, name) or recording.channel(name).name for what, name in (columns or {}).items()
    }
    recorded = {f"{what}_{axis}": f"{axis}_{short}" for what, short in RECORDED.items() for axis in chain.axes}
    found: dict[str, str] = {}
    for word in words:
        headers = (full_name(recording.names, one) for one in (word, recorded.get(word)) if one is not None)
        name = named.get(word) or next((one for one in headers if one is not None), None)
        if name is not None:
            found[word] = name
    counted = all(axis in found and recording.channel(found[axis]).unit in {None, "count"} for axis in chain.axes)
    return found if counted else {}


def _column_of(model: SensorModel, recording: Recording, axis: str) -> str:
    """Return the column whose header tells quantity and axis; of the axis alone if its unit is one of input."""
    own = QUANTITY[model.unit]
    candidates = [c for c in recording.channels if c.axis == axis and not c.name.startswith(UNCERTAINTY)]
    identified = [c.name for c in candidates if c.quantity == own] or [
        c.name for c in candidates if not c.quantity and c.unit and same_dimension(c.unit, model.unit)
    ]
    if len(identified) == 1:
        return identified[0]
    what = f"{len(identified)} columns ({', '.join(identified)}) can be" if identified else "no column is clearly"
    raise DataError(
        f"{what} the {axis} axis of a {model.kind}",
        where=recording.source.path,
        do=f"Say it: --column {axis}=NAME. The file has: {', '.join(recording.names)}",
        code="wrong_column",
    )


def _fixed_temperature(recording: Recording, given: str | float) -> float:
    if not isinstance(given, str):
        return float(given)
    try:
        return parse_quantity(given).to("degC")
    except DataError:
        raise DataError(
            f"{given!r} is neither a column nor a temperature",
            where=recording.source.path,
            do=f'Name a column ({", ".join(recording.names)}), or write one like "25 degC"',
            code="no_temperature",
        ) from None
