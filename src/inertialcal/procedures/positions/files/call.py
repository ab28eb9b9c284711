"""A test of positions without a campaign file: what ``positions FILE...`` and ``inertialcal.positions`` do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.axes import AXES
from ....core.curve import Curve
from ....core.errors import DataError, UsageError
from ....core.estimate import Array
from ....core.influence import Influence, standard_of
from ....core.remarks import Remark, gather
from ....core.results import Row, by_quantity
from ....core.schema.standards import STANDARDS, StandardEntry
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import estimate_table, remarks_line
from ....core.show.tables import Block, html, text
from ....core.units import factor, kind, parse_quantity
from ....files.models.model_json import dump_model
from ....files.write.atomic import atomic_write
from ....sensors.model.sensor_model import Provenance, SensorModel
from ...display import displayed
from .. import reduction as procedure
from ..curves import curves
from ..orientations.text import FACES, directions
from ..readings import Readings
from .channels import SENSORS
from .hold_out import Held, held_out
from .sources import Asked, Sources, named_files, sources

if TYPE_CHECKING:
    from pandas import DataFrame


KINDS = {"acc": "accelerometer", "gyro": "gyro"}


@dataclass(frozen=True, eq=False)
class PositionsFile:
    """Result of one or more files.

    Parameters
    ----------
    result : positions.Result
        SI.
    rows : tuple of Row
        In the units of the files; ``test`` says whose: ``accelerometer`` or ``gyro``.
    inputs : mapping of str to str
        SHA-256 by path.
    columns, units : mapping of str to str
        Which channel was taken for what; the unit of each sensor.
    remarks : tuple of Remark
        What reading and reducing brought up.
    held : Held or None
        How a fit of the first positions does on the others.
    """

    result: procedure.Result
    rows: tuple[Row, ...]
    inputs: Mapping[str, str]
    columns: Mapping[str, str]
    units: Mapping[str, str]
    remarks: tuple[Remark, ...] = ()
    held: Held | None = field(default=None)

    @property
    def summary(self) -> str:
        """How much went in, in one line."""
        readings = self.result.readings
        named = 0 if readings.direction is None else int(np.isfinite(readings.direction).all(axis=1).sum())
        known = "" if not named else " of known orientation"
        known = f", {named}{known}" if 0 < named < len(readings) else known
        parts = [f"{len(readings)} positions{known}"]
        parts += [f"{len(readings.transitions)} rotations between them"] if readings.transitions else []
        parts += [f"{len(readings.turns)} turns by a known angle"] if readings.turns else []
        return f"found: {', '.join(parts)}; gravity {procedure.local_gravity(self.result.plan):.6g} m/s2"

    @property
    def models(self) -> dict[str, SensorModel]:
        """Models by sensor, ``"acc"`` and ``"gyro"``, of those that the data could carry."""
        found = {name: one for name, kind in KINDS.items() if (one := self.result.models.get(kind)) is not None}
        return {name: self._with_source(one) for name, one in found.items()}

    def _with_source(self, model: SensorModel) -> SensorModel:
        remarks_line = Provenance("positions", tuple(Path(one).name for one in self.inputs))
        names = () if model.estimate is None else model.estimate.names
        return replace(model, provenance=dict.fromkeys(names, remarks_line))

    def write_models(self, path: str | Path) -> list[Path]:
        """Write the models; of two, each has its sensor in the name: ``model_acc.json``, ``model_gyro.json``.

        Raises
        ------
        DataError
            ``no_model`` if nothing could be told; ``overwrites_input``.
        StoreError
            ``not_written``.
        """
        models, target = self.models, Path(path)
        if not models:
            do = "Look at the rows that were not estimated: each says why"
            raise DataError("nothing could be told that a model is made of", str(path), do=do, code="no_model")
        named = {sensor: target.with_stem(f"{target.stem}_{sensor}") for sensor in models}
        named = named if len(models) > 1 else dict.fromkeys(models, target)
        for sensor, model in models.items():
            with atomic_write(named[sensor], list(self.inputs)) as aside:
                aside.write_text(dump_model(model), encoding="utf-8", newline="\n")
        return list(named.values())

    def curves(self) -> list[Curve]:
        """Return what every position and rotation leaves, SI."""
        found = curves(self.result)
        return found if self.held is None else self.held.marked(found)

    def content(self) -> dict[str, Any]:
        """Return rows and curves as ``results.json`` would hold them."""
        whose = {"positions": "accelerometer", "transitions": "gyro"}
        return {
            "curves": [curve.to_dict(whose.get(curve.name, "")) for curve in self.curves()],
            "results": [row.to_dict() for row in self.rows],
        }

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: which channel was what, the figures of each sensor, how many remarks."""
        taken = ", ".join(f"{what} = {name}" for what, name in self.columns.items())
        shown: list[Block] = [f"columns: {taken}", self.summary]
        for test in dict.fromkeys(row.test for row in self.rows):
            rows = [row.to_dict() for row in self.rows if row.test == test and not row.case.beside]
            shown += estimate_table(rows, test)
        return (*shown, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def positions(
    paths: str | Path | Sequence[str | Path],
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    time_column: str | None = None,
    sections: str | None = None,
    orientations: str | None = None,
    turn: str = "360 deg",
    gravity: str | None = None,
    latitude: str | None = None,
    height: str | None = None,
    zero: Mapping[str, str] | None = None,
    shortest: str | None = None,
    g_sensitivity: bool = True,
    hold_out: str | int | None = None,
    standards: Mapping[str, str] | None = None,
    start: str | None = None,
    stop: str | None = None,
) -> PositionsFile:
    """Calibrate accelerometers and gyros from static positions and the rotations between them.

    Parameters
    ----------
    paths : path or sequence of path
        A recording; two of one clock, accelerometers and gyros; a file a position or turn, ``"x+=up.csv"``,
        ``"x_rot=turn.csv"``; several recordings; or a table, a row a position.
    columns : mapping of str to str, optional
        Channels by what they are: ``acc_x``, ..., ``gyro_z``, ``temperature``; by default told by their names.
    units : mapping of str to str, optional
        ``{"acc": "m/s2", "gyro": "deg/s"}``; ``"count"`` where scale factors are to be found.
    sample_rate, time_column, start, stop
        As ``inertialcal.read`` takes them.
    sections : str, optional
        Labelled parts of the recording: a JSON file or table of label, start and end, or its column of labels.
        Absent: static intervals are found.
    orientations : str, optional
        Which axis was up in each position, ``"x+,x-,y+,y-,z+,z-"``; ``"faces"`` for the nearest; or a file. Absent:
        none is known, and gravity alone calibrates.
    turn : str
        Angle of each turn that is named.
    gravity, latitude, height : str, optional
        ``"9.8123 m/s2"``, or where it is to be taken from.
    zero : mapping of str to str, optional
        Reading for no input: ``{"acc": "32768"}``.
    shortest : str, optional
        Shortest rest that counts, ``"2 s"``.
    g_sensitivity : bool
        Whether what gyros read of specific force is estimated, where the positions carry it.
    hold_out : str or int, optional
        Judge a fit of the first positions by the others: ``"half"``, or how many are held out.
    standards : mapping of str to str, optional
        Standard uncertainties: ``{"turn.angle": "1 deg", "gravity.value": "0.001 m/s2"}``.

    Raises
    ------
    DataError
        If a file cannot be read or cannot carry the answer.
    UsageError
        If it is not clear which channel is what, or in which unit.
    """
    asked = Asked(
        columns or {}, units or {}, sample_rate, time_column, sections, _quantity(turn, "rad", "turn"),
        orientations == FACES, start, stop,
    )  # fmt: skip
    plan = replace(_plan(gravity, latitude, height, shortest, g_sensitivity), standards=_standards(standards or {}))
    files = named_files([paths] if isinstance(paths, str | Path) else paths)
    taken = sources(plan, files, asked)
    plan = replace(plan, **_zeros(zero or {}, taken))
    readings = _oriented(taken.readings, orientations)
    result = procedure.reduce(plan, readings)
    held = None if hold_out is None else held_out(plan, readings, _first(hold_out, len(readings)))
    rows = [*of_sensors(result.rows()), *(() if held is None else held.rows())]
    shown = tuple(displayed(row, _unit(taken, row.test)) for row in rows)
    remarks = gather(map(_for_files, [*result.remarks, *(() if held is None else held.remarks)]))
    return PositionsFile(result, shown, taken.inputs, taken.columns, taken.units, remarks, held)


def of_sensors(rows: Sequence[Row]) -> list[Row]:
    """Return rows with the sensor, which is their condition, as their test; those of one quantity side by side."""
    found = [
        replace(row, test=row.key.sensor, key=row.key._replace(sensor="")) if row.key.sensor else row for row in rows
    ]
    return by_quantity(found)


def _plan(
    gravity: str | None, latitude: str | None, height: str | None, shortest: str | None, g_sensitivity: bool
) -> procedure.Plan:
    if gravity is not None and (latitude is not None or height is not None):
        raise UsageError("gravity, and latitude or height", why="which is meant?", do="Give one of them")
    if height is not None and latitude is None:
        raise UsageError("height without latitude", do='Say it: --latitude "48 deg"')
    return procedure.Plan(
        gravity=None if gravity is None else _quantity(gravity, "m/s^2", "gravity"),
        latitude=None if latitude is None else _quantity(latitude, "rad", "latitude"),
        height=0.0 if height is None else _quantity(height, "m", "height"),
        shortest=None if shortest is None else _quantity(shortest, "s", "shortest"),
        g_sensitivity=None if g_sensitivity else False,
    )


def _standards(given: Mapping[str, str]) -> dict[str, Influence]:
    """Return standard uncertainties by the name of what they are of.

    Raises
    ------
    UsageError
        ``unknown_name``; ``no_unit`` for a text that is no such quantity.
    """
    found = {}
    for name, said in given.items():
        if name not in procedure.INFLUENCES:
            do = f"There are: {', '.join(procedure.INFLUENCES)}"
            raise UsageError(f"standard {name!r}", do=do, code="unknown_name")
        standard, influence = standard_of(name)
        unit = STANDARDS[standard][influence]
        try:
            found[name] = StandardEntry(u=said).influence(unit, standard, influence)
        except (DataError, ValueError):
            like = {"rad": "0.5 deg", "m/s^2": "0.001 m/s2", "1": "0.01 %"}[unit]
            do = f"Write a standard uncertainty with its unit, like {name}={like}"
            raise UsageError(f"standard {name}={said}", do=do, code="no_unit") from None
    return found


def _for_files(remark: Remark) -> Remark:
    """Return a remark with the way out that there is without a campaign file."""
    ways = {
        "relative_to_fixture": "State them, like --standard gravity.value='0.001 m/s2'",
        "gravity_assumed": "Say it: --gravity '9.81 m/s2', or --latitude '48 deg' --height '300 m'",
    }
    return replace(remark, do=ways.get(remark.code, remark.do))


def _quantity(given: str, unit: str, what: str) -> float:
    """Return a setting in a unit; that it needs one is said with the setting and the text given."""
    try:
        return float(parse_quantity(given).to(unit))
    except DataError:
        like = {"rad": "360 deg", "m/s^2": "9.8123 m/s2", "m": "300 m", "s": "2 s"}[unit]
        raise UsageError(
            f"{what}: {given!r}", do=f"Write a number with its unit, like {like}", code="no_unit"
        ) from None


def _zeros(given: Mapping[str, str], taken: Sources) -> dict[str, Any]:
    """Return the readings that stand for no input, by setting of the plan and axis, in the unit of the readings.

    Raises
    ------
    UsageError
        ``unknown_name`` for another sensor or axis; ``wrong_value`` for what is no number.
    """
    found: dict[str, dict[str, float]] = {}
    for name, said in given.items():
        sensor, _, axis = name.partition("_")
        if sensor not in taken.units or axis not in ("", *AXES):
            do = f"There are: {', '.join(taken.units)}, and acc_x, ... for one axis"
            raise UsageError(f"--zero {name}={said}", do=do, code="unknown_name")
        try:
            value = float(said)
        except ValueError:
            raise UsageError(f"--zero {name}={said}: no number", do="Like acc=32768", code="wrong_value") from None
        own = found.setdefault(f"{sensor}_zero", {})
        own |= dict.fromkeys((axis,) if axis else AXES, value * _scale(taken.units[sensor], sensor))
    return found


def _scale(unit: str, sensor: str) -> float:
    """Return what turns a number in the unit of the file into that of the readings."""
    wanted, si, _ = SENSORS[sensor]
    return factor(unit, si) if kind(unit) == wanted else 1.0


def _oriented(readings: Readings, orientations: str | None) -> Readings:
    """Return the readings with the directions that the user said.

    Raises
    ------
    UsageError
        ``wrong_value`` if there are not as many as positions.
    """
    if orientations is None or orientations == FACES:
        return procedure.on_faces(readings) if orientations == FACES and readings.direction is None else readings
    said: Array = directions(orientations)
    if len(said) != len(readings):
        listed = ", ".join(readings.where[:12]) + (", ..." if len(readings) > 12 else "")
        what = f"{len(said)} orientations for {len(readings)} positions"
        do = "Give one for each, ? for one that is not known; or --shortest for other rests"
        raise UsageError(what, why=f"they were found at: {listed}", do=do, code="wrong_value")
    return replace(readings, direction=said if np.isfinite(said).any() else None)


def _first(hold_out: str | int, count: int) -> int:
    """Return how many positions are fitted, of so many.

    Raises
    ------
    UsageError
        ``wrong_value``.
    """
    if hold_out == "half":
        return (count + 1) // 2
    try:
        held = int(hold_out)
    except ValueError:
        held = 0
    if not 0 < held < count:
        what = f"hold out {hold_out!r} of {count} positions"
        raise UsageError(what, do=f"Say half, or a number from 1 to {count - 1}", code="wrong_value")
    return count - held


def _unit(taken: Sources, kind_of: str) -> str:
    """Return the unit that figures of a sensor are shown in: that of the file, else that which people use."""
    sensor = "gyro" if kind_of == "gyro" else "acc"
    own = taken.units.get(sensor, "")
    return own if own and kind(own) == SENSORS[sensor][0] else SENSORS[sensor][2]


__all__ = ["PositionsFile", "positions"]
