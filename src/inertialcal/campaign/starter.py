"""A first campaign.toml for the recordings of a folder: what is known is filled in, what is not is marked."""

from __future__ import annotations

import json
from pathlib import Path

from ..core.errors import DataError, PlanError, StoreError, UsageError
from ..core.remarks import Remark
from ..files.table import Table, read_table
from .load import FILE
from .table_columns import Guess, guess

MARK = "# FILL IN"
ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".parquet", ".csv.gz", ".txt.gz")
MOST = 200  # files


def start(folder: str | Path) -> tuple[Path, list[int], tuple[Remark, ...]]:
    """Write campaign.toml for the reduced tables of a folder.

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
    tables, remarks = _tables(root)
    if not tables:
        do = "Put tables in, a row a dwell, with a column for the rate and one for the reading"
        raise PlanError(f"no table of readings in {root}", do=do, code="nothing_found")
    text = starter_text(root.resolve().name, tables)
    try:
        with path.open("x", encoding="utf-8") as handle:
            handle.write(text)
    except OSError as error:
        raise StoreError(f"cannot write {path}: {error.strerror}", code="not_writable") from None
    lines = [number for number, line in enumerate(text.splitlines(), 1) if line.rstrip().endswith(MARK)]
    return path, lines, tuple(remarks)


def _tables(root: Path) -> tuple[dict[str, Guess], list[Remark]]:
    tables: dict[str, Guess] = {}
    remarks: list[Remark] = []
    for path in sorted(root.rglob("*"))[:MOST]:
        name = path.relative_to(root).as_posix()
        if name.startswith((".", "out/")) or not path.is_file() or not name.lower().endswith(ENDINGS):
            continue
        try:
            table = read_table(path)
        except DataError as error:
            remarks.append(Remark("not_read", "warning", error.problems[0].what, name))
            continue
        found = guess(table)
        if len(table.names) < 2 or not (found.applied and found.readings):
            remarks.append(Remark("no_table", "info", f"no columns of rate and reading ({_names(table)})", name))
            continue
        tables[name] = found
    return tables, remarks


def _names(table: Table) -> str:
    return ", ".join(table.names[:8]) + (", ..." if len(table.names) > 8 else "")


def starter_text(name: str, tables: dict[str, Guess]) -> str:
    """Return the text of a campaign file.

    Parameters
    ----------
    name : str
        Of the campaign.
    tables : mapping of str to Guess
        By file.
    """
    identifier = (
        "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "-" for c in name).strip("-_") or "campaign"
    )
    unit = next((found.unit for found in tables.values() if found.unit), None)
    unit_line = f"unit = {_text(unit)}" if unit else f'unit = "?"  {MARK}'
    parts = [
        f'schema = 1\n\n[campaign]\nid = "{identifier}"\n',
        f'[item]\nmaker = ""  {MARK}\npart = ""  {MARK}\nserial = ""  {MARK}\n',
        "# Uncertainties of the rate table: without them the results are relative to the fixture.\n"
        '# [standards.rate_table]\n# rate = { u = "0.05 %", certificate = "..." }\n# mounting = { u = "0.1 deg" }\n',
        f'[sensors.suite]\nkind = "gyro"\naxes = ["x", "y", "z"]\n{unit_line}\n'
        '# range = ["-100 deg/s", "100 deg/s"]\n# chain = { kind = "none", scale_factor = "0.5 V/(deg/s)" }\n',
        *(_entry(number, file, found) for number, (file, found) in enumerate(tables.items(), 1)),
        '# [[requirements]]\n# id = "R1"\n# quantity = "rate_error"\n# of = "dwell_mean"\n# limit = "5 %"\n'
        '# where = "abs(rate) >= 0.1 deg/s"\n',
    ]
    return "\n".join(parts)


def _entry(number: int, file: str, found: Guess) -> str:
    reading = _reading(found)
    rows = [f"applied = {_text(found.applied or '?')}", f"reading = {reading}"]
    rows += [
        f"{key} = {_text(value)}"
        for key in ("scatter", "samples", "axis", "group", "run")
        if (value := getattr(found, key))
    ]
    rows.append(f"unit = {_text(found.unit or '?')}")
    sure = found.unit is not None and (len(found.readings) == 1 or bool(found.by_axis))
    mark = "" if sure else f"  {MARK}"
    axis = found.axis is None
    plan = f'plan = {{ axis = "{_axis(found)}" }}  {MARK}\n' if axis else ""
    return (
        f'[recordings.table{number}]\nsensor = "suite"\nfile = {_text(file)}\nrows = {{ {", ".join(rows)} }}{mark}\n\n'
        f'[[tests]]\nid = "rate{number}"\nprocedure = "rate_table"\nrecordings = ["table{number}"]\n{plan}'
    )


def _reading(found: Guess) -> str:
    if len(found.readings) > 1 and found.by_axis:
        return "{ " + ", ".join(f"{axis} = {_text(name)}" for axis, name in found.by_axis.items()) + " }"
    return _text(found.readings[0])


def _axis(found: Guess) -> str:
    return next(iter(found.by_axis)) if len(found.by_axis) == 1 else "x"


def _text(text: str) -> str:
    """TOML string: JSON's escapes are TOML's."""
    return json.dumps(text, ensure_ascii=False)
