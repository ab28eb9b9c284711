"""A first campaign.toml for the recordings of a folder: what is known is filled in, what is not is marked."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..core.errors import InertialcalError, PlanError, StoreError, UsageError
from ..core.recording import Recording
from ..core.remarks import Remark
from ..core.units import kind
from ..files import read
from ..files.text.table import Table, read_table
from ..procedures.flip.files.source import FlipSource
from .calls.table_columns import Guess, guess
from .file.load import FILE, MARK
from .starter_flip import accelerometers, archive_sources, flip_parts, head_source, means_of_table
from .starter_positions import REQUIREMENT as POSITIONS_REQUIREMENT
from .starter_positions import is_laid, positions_parts
from .starter_still import REQUIREMENT as STILL_REQUIREMENT
from .starter_still import gyros, is_still, of_one_level, still_parts

ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".csv.gz", ".txt.gz", ".mat", ".h5", ".hdf5", ".npz")
MOST = 200  # files
LONGEST_TABLE = 10_000  # rows; a longer file is no table of dwells
REQUIREMENT = (
    '# [[requirements]]\n# id = "R1"\n# quantity = "rate_error"\n# of = "dwell_mean"\n# limit = "5 %"\n'
    '# where = "abs(rate) >= 0.1 deg/s"\n'
)
FLIP_REQUIREMENT = '# [[requirements]]\n# id = "R1"\n# quantity = "control_error"\n# limit = "0.5 ug"\n'


def start(folder: str | Path) -> tuple[Path, list[int], tuple[Remark, ...]]:
    """Write campaign.toml for the tables and recordings of a folder.

    Parameters
    ----------
    folder : path
        With the files; the campaign file is written into it.

    Returns
    -------
    (path, lines, remarks)
        Of the file; the lines that are marked to be filled in; which files were left out and why.

    Raises
    ------
    UsageError
        If the folder does not exist.
    PlanError
        If it holds a campaign already, or no file that can be one of its recordings.
    """
    root = Path(folder)
    if not root.is_dir():
        raise UsageError(f"{root} is no folder", do="Make it, and put the recordings in")
    path = root / FILE
    if path.exists():
        raise PlanError(f"{path} exists already", do=f"Try: inertialcal check {root}", code="exists")
    found, remarks = _files(root)
    if not any((found.tables, found.raw, found.flips, found.still, found.laid)):
        do = "Put in tables (a row a dwell, with columns of rate and reading) or recordings with gyro channels; for a "
        do += "flip tables of means (a row an axis and position) or recordings with accelerometer channels; or "
        do += "recordings of an IMU that was laid into many positions"
        what = f"no recording of a rate table or a flip, nor of gyros at rest or an IMU laid by hand, in {root}"
        raise PlanError(what, do=do, code="nothing_found")
    text = starter_text(root.resolve().name, found)
    try:
        with path.open("x", encoding="utf-8") as handle:
            handle.write(text)
    except OSError as error:
        raise StoreError(f"cannot write {path}: {error.strerror}", code="not_writable") from None
    lines = [number for number, line in enumerate(text.splitlines(), 1) if line.rstrip().endswith(MARK)]
    return path, lines, tuple(remarks)


@dataclass(frozen=True)
class Found:
    """What a folder holds, by file.

    Parameters
    ----------
    tables, raw : dict
        Of a rate table: reduced tables and recordings.
    flips : dict
        Of flips: tables of means and recordings of a head.
    still : dict
        Recordings of sensors at rest.
    laid : dict
        Recordings of an IMU that was laid into many positions.
    """

    tables: dict[str, Guess] = field(default_factory=dict)
    raw: dict[str, Recording] = field(default_factory=dict)
    flips: dict[str, FlipSource] = field(default_factory=dict)
    still: dict[str, Recording] = field(default_factory=dict)
    laid: dict[str, Recording] = field(default_factory=dict)


def _files(root: Path) -> tuple[Found, list[Remark]]:
    """Return what a folder holds, and what was left out."""
    archived, remarks = archive_sources(root)
    found = Found(flips=archived)
    for path in sorted(root.rglob("*"))[:MOST]:
        name = path.relative_to(root).as_posix()
        if name.startswith((".", "out/")) or not path.is_file() or not name.lower().endswith(ENDINGS):
            continue
        try:
            remarks += _take(found, path, name)
        except InertialcalError as error:
            remarks.append(Remark("not_read", "warning", error.problems[0].what, name))
    if found.raw or not of_one_level(found.still.values()):  # dwells of a rate table
        found.raw.update(found.still)
        found.still.clear()
    return found, remarks


def _take(found: Found, path: Path, name: str) -> list[Remark]:
    """Put a file where it belongs; return the remark on one that belongs nowhere."""
    table = read_table(path)
    rates, means = guess(table), means_of_table(table)
    if means is not None:
        found.flips[name] = means
        return []
    if _is_table(table, rates):
        found.tables[name] = rates
        return []
    recording = read(path)
    if recording.time_ns is None:
        return [_not_taken(table, name)]
    if not rates.applied and is_laid(recording):
        found.laid[name] = recording
    elif gyros(recording):
        (found.still if is_still(recording) and not rates.applied else found.raw)[name] = recording
    elif accelerometers(recording):
        found.flips[name], remarks = head_source(recording)
        return [one.at(name) for one in remarks]
    elif is_still(recording):
        found.still[name] = recording
    else:
        return [_not_taken(table, name)]
    return []


def _not_taken(table: Table, name: str) -> Remark:
    what = "neither columns of rate and reading, nor gyro or accelerometer channels with time"
    what = f"{what} ({_names(table)})"
    return Remark("not_taken", "info", what, name)


def _is_table(table: Table, rates: Guess) -> bool:
    """Whether a file is a reduced table: short, with numbers in the columns whose names say rate and reading."""
    if not (rates.applied and rates.readings and table.rows.size <= LONGEST_TABLE):
        return False
    try:
        return all(np.isfinite(table.numbers(name)).any() for name in (rates.applied, *rates.readings))
    except InertialcalError:  # text
        return False


def _names(table: Table) -> str:
    return ", ".join(table.names[:8]) + (", ..." if len(table.names) > 8 else "")


def starter_text(name: str, found: Found) -> str:
    """Return the text of a campaign file.

    Parameters
    ----------
    name : str
        Of the campaign.
    found : Found
        What its folder holds.
    """
    identifier = (
        "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "-" for c in name).strip("-_") or "campaign"
    )
    parts = [
        f'schema = 1\n\n[campaign]\nid = "{identifier}"\n',
        f'[item]\nmaker = ""  {MARK}\npart = ""  {MARK}\nserial = ""  {MARK}\n',
        *(_rate_table_parts(found.tables, found.raw) if found.tables or found.raw else ()),
        *flip_parts(found.flips),
        *still_parts(found.still),
        *positions_parts(found.laid),
        _requirement(found),
    ]
    return "\n".join(part for part in parts if part)


def _requirement(found: Found) -> str:
    """Return an example of a requirement on what the folder holds."""
    if found.tables or found.raw:
        return REQUIREMENT
    if found.flips:
        return FLIP_REQUIREMENT
    return POSITIONS_REQUIREMENT if found.laid else STILL_REQUIREMENT


def _rate_table_parts(tables: dict[str, Guess], raw: dict[str, Recording]) -> list[str]:
    said = [one.unit for one in tables.values()]
    said += [c.unit for one in raw.values() for c in gyros(one).values() if kind(c.unit or "1") == "angular_rate"]
    unit = next((one for one in said if one), None)
    unit_line = f"unit = {_text(unit)}" if unit else f'unit = "?"  {MARK}'
    return [
        "# Uncertainties of the rate table: without them the results are relative to the fixture.\n"
        '# [standards.rate_table]\n# rate = { u = "0.05 %", certificate = "..." }\n# mounting = { u = "0.1 deg" }\n',
        f'[sensors.suite]\nkind = "gyro"\naxes = ["x", "y", "z"]\n{unit_line}\n'
        '# range = ["-100 deg/s", "100 deg/s"]\n# chain = { kind = "none", scale_factor = "0.5 V/(deg/s)" }\n',
        *(_raw_entry(number, file, one) for number, (file, one) in enumerate(raw.items(), 1)),
        _raw_test(len(raw)),
        *(_entry(number, file, one) for number, (file, one) in enumerate(tables.items(), 1)),
    ]


def _entry(number: int, file: str, found: Guess) -> str:
    reading = _reading(found)
    rows = [f"applied = {_text(found.applied or '?')}", f"reading = {reading}"]
    rows += [f"{key} = {_text(value)}" for key in _keys(found) if (value := getattr(found, key))]
    rows.append(f"unit = {_text(found.unit or '?')}")
    sure = found.unit is not None and (len(found.readings) == 1 or bool(found.by_axis))
    mark = "" if sure else f"  {MARK}"
    axis = found.axis is None
    plan = f'plan = {{ axis = "{_axis(found)}" }}  {MARK}\n' if axis else ""
    return (
        f'[recordings.table{number}]\nsensor = "suite"\nfile = {_text(file)}\nrows = {{ {", ".join(rows)} }}{mark}\n\n'
        f'[[tests]]\nid = "rate{number}"\nprocedure = "rate_table"\nrecordings = ["table{number}"]\n{plan}'
    )


def _keys(found: Guess) -> tuple[str, ...]:
    """Columns to name; one scatter column beside several readings cannot be told whose it is."""
    one = len(found.readings) == 1
    return ("scatter", "samples", "axis", "group", "run") if one else ("samples", "axis", "group", "run")


def _raw_entry(number: int, file: str, one: Recording) -> str:
    clock = [f"column = {_text(one.time_column)}"] if one.time_column else []
    clock += ['stamp = "middle"', 'interval = "? s"', 'averaging = "? s"']
    channels = ['applied = { column = "?", unit = "?" }']
    channels += [
        f"{axis} = {{ column = {_text(c.name)}, unit = {_text(c.unit or '?')} }}" for axis, c in gyros(one).items()
    ]
    return (
        f'[recordings.rec{number}]\nsensor = "suite"\nfile = {_text(file)}\n'
        f'axis = "?"  {MARK}\nrun = "?"  {MARK}\n'
        f"clock = {{ {', '.join(clock)} }}  {MARK}\nchannels = {{ {', '.join(channels)} }}  {MARK}\n"
    )


def _raw_test(count: int) -> str:
    """Return one test of all recordings: which axis was turned stands with each."""
    if not count:
        return ""
    names = ", ".join(f'"rec{number}"' for number in range(1, count + 1))
    return f'[[tests]]\nid = "rate"\nprocedure = "rate_table"\nrecordings = [{names}]\n'


def _reading(found: Guess) -> str:
    if len(found.readings) > 1 and found.by_axis:
        return "{ " + ", ".join(f"{axis} = {_text(name)}" for axis, name in found.by_axis.items()) + " }"
    return _text(found.readings[0])


def _axis(found: Guess) -> str:
    return next(iter(found.by_axis)) if len(found.by_axis) == 1 else "x"


def _text(text: str) -> str:
    """TOML string: JSON's escapes are TOML's."""
    return json.dumps(text, ensure_ascii=False)
