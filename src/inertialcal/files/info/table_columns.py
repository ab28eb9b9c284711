"""Which column of a reduced rate-table test is what, as far as the names tell.

Only names are looked at, never numbers, and nothing is taken that could be two things: what is not found is
left for the user to say.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...core.recording import Channel
from ...core.units import kind
from ..text.headers import about_axis, plain
from ..text.table import Table

PATTERNS = {
    "applied": (
        r"(^|_)(rate|applied|input|table_rate|commanded|omega"
        r"|(dreh)?tisch(dreh)?(rate|zahl|geschwindigkeit)?|soll(wert|(dreh)?(rate|zahl|geschwindigkeit))?"
        r"|(turn)?table_(speed|velocity)|stage_(speed|velocity)|set_?point|command"
        r"|vitesse|consigne|tavola|piattaforma|plateau|mesa|consigna|impostat[ao])(_|$)"
    ),
    "scatter": r"(^|_)(std|stdev|sd|sigma|scatter|standardabweichung|stabw|streuung|ecart_type"
    r"|(deviazione|desviacion)(_standard|_estandar|_tipica)?|scarto(_tipo)?)(_|$)",
    "samples": r"^(n|samples|n_samples|count|anzahl|nombre|campioni|muestras)$",
    "group": r"^(set|group|sample_set)$",
    "run": r"^(run|run_id|power_up|turn_on)$",
    "axis": r"^(axis|turned|axis_turned)$",
}
RATE = r"(^|_)(drehrate|winkelgeschwindigkeit)(_|$)"  # of the table, where it names no axis beside columns that do
OTHER = r"(^|_)(error|percent|temp|temperature|time|warm)(_|$)"
RAW = ("voltage", "count")  # kinds of unit
NO_RATE = (*RAW, "temperature", "pressure", "acceleration", "time")  # what no table says its rate in
READING = (
    r"(^|_)(reading|output|measured|mean|sensor|gyro|gyr|ist((dreh)?rate|wert)?|messwert|mittelwert|ausgang"
    r"|mesure|moyenne|sortie|misura(ta|to)?|media|uscita|lettura|medida|lectura|salida)(_|$)"
)
AXIS = re.compile(r"(^|_)[gw]?([xyz])(_|$)", re.IGNORECASE)  # x, gx, wx
REDUCED = re.compile(r"(?:\b|_)(?:(?<!sample[_ ])rate|applied|reading)(?:_|\b)", re.IGNORECASE)


@dataclass(frozen=True)
class Guess:
    """Columns by what they hold; None where no name, or more than one, says so."""

    applied: str | None = None  # Names of columns
    scatter: str | None = None  # Names of columns
    samples: str | None = None  # Names of columns
    group: str | None = None  # Names of columns
    run: str | None = None  # Names of columns
    axis: str | None = None  # Names of columns
    readings: tuple[str, ...] = ()  # Columns that can be the sensor's reading
    unit: str | None = None  # That the names of applied and readings say, where they agree
    applied_unit: str | None = None  # That of applied, and that of all readings, where their names say it
    reading_unit: str | None = None  # That of applied, and that of all readings, where their names say it
    by_axis: dict[str, str] = field(default_factory=dict)
    scatter_by_axis: dict[str, str] = field(default_factory=dict)  # Of the readings of each axis
    follows: str | None = None  # Axis whose readings follow the rate, where someone looked at the numbers


def guess(table: Table) -> Guess:
    """Return what the names of a table's columns tell."""
    names = list(table.names)
    spreads = [name for name in names if _matches(name, PATTERNS["scatter"])]
    means = [name for name in names if name not in spreads]
    kinds = {name: kind(unit) for name in names if (unit := table.unit(name))}
    inputs = [name for name in means if kinds.get(name) not in NO_RATE and not about_axis(name)]
    found = {what: _only(inputs if what == "applied" else means, pattern) for what, pattern in PATTERNS.items()}
    found["scatter"] = spreads[0] if len(spreads) == 1 else None
    taken = {*found.values(), *spreads}
    rest = [name for name in names if name not in taken and not _matches(name, OTHER)]
    readings = [name for name in rest if _matches(name, READING)] or [name for name in rest if _axis(name)]
    if not readings and len(rest) == 1 and found["applied"] is not None:  # nothing else is left
        is_rate = kinds.get(found["applied"]) == "angular_rate"
        readings = rest if is_rate and kinds.get(rest[0]) in RAW else []
    by_axis = {axis: name for name in readings if (axis := _axis(name))}
    if found["applied"] is None and by_axis:
        found["applied"] = _only([name for name in means if name not in readings], RATE)
    unit = _common_unit(table, [name for name in (found["applied"], *readings) if name])
    if len(by_axis) != len(readings):
        by_axis = {}
    by_sensor = {axis: name for name in spreads if (axis := _axis(name))}
    by_sensor = by_sensor if set(by_sensor) == set(by_axis) and len(by_sensor) == len(spreads) else {}
    own = [_common_unit(table, [name for name in names if name]) for names in ([found["applied"]], readings)]
    return Guess(
        **found, readings=tuple(readings), unit=unit, applied_unit=own[0], reading_unit=own[1], by_axis=by_axis,
        scatter_by_axis=by_sensor,
    )  # fmt: skip


def guess_channels(channels: Sequence[Channel]) -> Guess:
    """Return what the names of a recording's channels tell."""
    names, units = tuple(one.name for one in channels), tuple(one.unit for one in channels)
    return guess(Table(names, ((),) * len(names), np.empty(0, dtype=np.int64), units=units))


def names_rates(names: Iterable[str]) -> bool:
    """Whether one of the names says a rate, what is applied, or a reading."""
    return any(REDUCED.search(name) for name in names)


def _key(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", plain(name).lower())


def _axis(name: str) -> str:
    """Return the axis that a name says by its letter, or by roll, pitch and yaw; else ``""``."""
    match = AXIS.search(_key(name))
    return match[2].lower() if match else about_axis(name)


def _matches(name: str, pattern: str) -> bool:
    return re.search(pattern, _key(name)) is not None


def _only(names: Sequence[str], pattern: str) -> str | None:
    found = [name for name in names if _matches(name, pattern) and not _matches(name, OTHER + "|" + READING)]
    return found[0] if len(found) == 1 else None


def _common_unit(table: Table, names: Sequence[str]) -> str | None:
    units = {table.unit(name) for name in names}
    return units.pop() if len(units) == 1 else None
