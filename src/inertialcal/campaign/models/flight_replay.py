"""Flight C of a campaign's model, replayed on recordings held out: the same as compensation, or where it differs.

The model is that of the lowest pressure: the one that flies. Its C is written, compiled where a compiler is there, and
given the codes of the recordings held out in its condition, rounded to whole codes where they are means. Compensation
in double precision gets the same codes; where no flag is raised the two may differ by the proved bound, and by no more.
Readings with a flag are counted: at temperatures beyond its range the C takes the end, where compensation goes on.
"""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.recording import Recording
from ...core.units import convert
from ...files import read
from ...files.models.model_file import export
from ...sensors.model.model_set import ModelSet
from ...sensors.model.on_recordings import CONDITIONS
from ...sensors.model.sensor_model import SensorModel
from ..file.load import Campaign, load
from ..inputs.sources import text_of
from .compensation import compensate
from .find import find_model

FOLDER = "flight_c"  # beside ``out``
COMPILERS = ("cc", "gcc", "clang")
STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic", "-ffp-contract=off")
Flown = Callable[[Mapping[str, NDArray[np.int32]]], tuple[Array, NDArray[np.bool_]]]
BIT_FIELD = {"": "signal", "validity": "built_in_test"}  # channel of a chain -> its field of the codes


@dataclass(frozen=True, eq=False)
class FlightReplay:
    """Flight C beside compensation; arrays of shape (k,) in ``unit``, empty where nothing was replayed."""

    condition: str
    folder: Path  # With the C
    axes: tuple[str, ...]
    unit: str
    recordings: tuple[str, ...] = ()  # That were replayed
    rows: int = 0  # Readings without a flag
    flagged: int = 0  # Others that compensation has
    compensated: Array | None = None  # Mean of what compensation gives
    flown: Array | None = None  # Mean of what the compiled C gives
    largest: Array | None = None  # Largest difference of a reading
    bound: Array | None = None  # Proved
    reason: str = ""  # Why nothing was replayed

    def to_dict(self) -> dict[str, Any]:
        """Return it as ``--json`` says it."""
        arrays = {name: getattr(self, name) for name in ("compensated", "flown", "largest", "bound")}
        plain = {name: getattr(self, name) for name in ("condition", "unit", "rows", "flagged", "reason")}
        lists = {"axes": list(self.axes), "recordings": list(self.recordings)}
        listed = {name: None if one is None else one.tolist() for name, one in arrays.items()}
        return plain | lists | {"folder": str(self.folder)} | listed


def replay_flight_c(folder: Path) -> FlightReplay | None:
    """Write the flight C of a campaign's model, and replay recordings held out through it.

    Parameters
    ----------
    folder : Path
        Of a campaign that was run; the C goes to ``flight_c`` in it, in place of what an earlier replay wrote.

    Returns
    -------
    FlightReplay or None
        None where the campaign has no confirmed model that starts from codes.

    Raises
    ------
    DataError
        As the export to ``flight-c``; ``not_compiled`` where a compiler refuses it.
    """
    try:
        found = find_model(folder)
    except DataError:
        return None
    model = flying(found.models)
    if model is None:
        return None
    target = folder / FOLDER
    with tempfile.TemporaryDirectory(prefix="inertialcal_") as fresh:  # whatever else stands in the folder stays
        export(replace(found, condition=model.condition or None), "flight-c", Path(fresh) / FOLDER)
        shutil.copytree(Path(fresh) / FOLDER, target, dirs_exist_ok=True)
    ((name, record),) = json.loads((target / "bound.json").read_text(encoding="utf-8"))["sensors"].items()
    unit = record["unit"]
    begun = FlightReplay(model.condition, target, model.axes, unit)
    compiler = next((path for one in COMPILERS if (path := shutil.which(one))), None)
    if compiler is None:
        return replace(begun, reason=f"no C compiler here ({', '.join(COMPILERS)})")
    held = held_out(load(folder), folder, model)
    if not held:
        return replace(begun, reason="no recording of codes is held out in this condition")
    ours: list[Array] = []
    flown: list[Array] = []
    flagged = 0
    with tempfile.TemporaryDirectory(prefix="inertialcal_") as build:
        apply = compiled(compiler, target, name, record, Path(build))
        for recording, columns in held.values():
            done = compensate(model, recording, columns, condition=model.condition or None)
            values = np.column_stack([convert(done.channel(axis).data, str(done.channel(axis).unit), unit)
                                      for axis in model.axes])  # fmt: skip
            good = np.asarray(np.isfinite(values).all(axis=1))
            made, flags = apply(codes_of(model, recording, columns, good))
            ours.append(values[good][~flags])
            flown.append(made[~flags])
            flagged += int(np.count_nonzero(flags))
    one, other = np.concatenate(ours), np.concatenate(flown)
    return replace(
        begun,
        recordings=tuple(held),
        rows=len(one),
        flagged=flagged,
        compensated=one.mean(axis=0),
        flown=other.mean(axis=0),
        largest=np.abs(one - other).max(axis=0),
        bound=np.array([record["axes"][axis]["bound"] for axis in model.axes]),
    )


def flying(models: ModelSet) -> SensorModel | None:
    """Return the model of the lowest pressure of those that start from codes and that readings held out confirmed."""
    ready = [one for one in models.values() if one.chain is not None and one.judged]
    return min(ready, key=lambda one: np.inf if one.pressure_range is None else one.pressure_range[1], default=None)


def held_out(campaign: Campaign, folder: Path, model: SensorModel) -> dict[str, tuple[Recording, dict[str, str]]]:
    """Return recordings of codes held out in the condition of a model, rounded, with what their columns are."""
    assert model.chain is not None  # noqa: S101 - the caller looked
    words = {*model.axes, *CONDITIONS, *(f"{what}_{axis}" for what in CONDITIONS for axis in model.axes)}
    found: dict[str, tuple[Recording, dict[str, str]]] = {}
    for test in campaign.file.tests:
        if test.use != "hold_out" or (model.condition and test.condition != model.condition):
            continue
        for name in test.recordings:
            entry = campaign.file.recordings[name]
            columns = {what: one.column for what, one in (entry.channels or {}).items() if what in words}
            sensor = campaign.file.sensors[entry.sensor]
            counted = all((entry.channels or {})[axis].unit == "count" for axis in model.axes if axis in columns)
            if sensor.kind != model.kind or not counted or not set(model.axes) <= set(columns):
                continue
            recording = read(folder / entry.file, **text_of(entry))
            channels = tuple(
                replace(recording.channel(column), data=np.rint(recording.array([column])[:, 0]), unit="count")
                for column in dict.fromkeys(columns.values())
            )
            found[name] = replace(recording, channels=channels), columns
    return found


def codes_of(
    model: SensorModel, recording: Recording, columns: Mapping[str, str], rows: NDArray[np.bool_]
) -> dict[str, NDArray[np.int32]]:
    """Return the codes of some rows by field of the C, shape (n, k)."""
    found = {}
    for what in ("", *CONDITIONS):
        names = [columns.get(f"{what}_{axis}" if what else axis, columns.get(what, "")) for axis in model.axes]
        if all(names):
            found[BIT_FIELD.get(what, what)] = np.rint(recording.array(names)[rows]).astype(np.int32)
    return found


def compiled(compiler: str, folder: Path, name: str, record: Mapping[str, Any], build: Path) -> Flown:
    """Return a function that applies compiled C to codes, by field: outputs in their unit, and whether a flag is up.

    Raises
    ------
    DataError
        ``not_compiled``.
    """
    library = build / "flight.so"
    command = [compiler, *STRICT, "-shared", "-fPIC", str(folder / f"{name}.c"), "-o", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 - our own text, no shell
    if done.returncode:
        why = next(iter(done.stderr.splitlines()), "")
        raise DataError("the compiler refuses the flight C", str(folder), why=why, code="not_compiled")
    k = len(record["axes"])
    fields = record["fields"]
    codes_type = type("Codes", (ctypes.Structure,), {"_fields_": [(one, ctypes.c_int32 * k) for one in fields]})
    output_type = type("Output", (ctypes.Structure,), {"_fields_": [("value", ctypes.c_int32 * k),
                                                                    ("flags", ctypes.c_uint8 * k)]})  # fmt: skip
    function = getattr(ctypes.CDLL(str(library)), f"{name}_apply")
    function.restype = ctypes.c_uint8

    def apply(codes: Mapping[str, NDArray[np.int32]]) -> tuple[Array, NDArray[np.bool_]]:
        whole = dict(codes)
        if "temperature_reference" in fields:
            whole.setdefault("temperature_reference", whole.get("reference", whole["signal"]))
        rows = np.ascontiguousarray(np.concatenate([whole[one] for one in fields], axis=1))
        given, output = codes_type(), output_type()
        values, flags = np.empty((len(rows), k), dtype=np.int32), np.zeros(len(rows), dtype=bool)
        for i, row in enumerate(rows):
            ctypes.memmove(ctypes.byref(given), row.ctypes.data, row.nbytes)
            flags[i] = function(ctypes.byref(given), ctypes.byref(output)) != 0
            values[i] = output.value
        return np.ldexp(values.astype(float), -int(record["fraction_bits"])), flags

    return apply
