"""Write ``out/``: built aside, then put in place whole, so that a reader never sees half a result.

What a run has not written, or what was edited since, is kept (``files.write.exchange``).

``results.json`` holds no clock time and no path outside the campaign: the same inputs give the same bytes.
``provenance.json`` alone knows when and where.
"""

from __future__ import annotations

import csv
import io
import math
import os
import platform
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ...core.errors import StoreError
from ...core.remarks import Remark
from ...core.show.rounding import uncertainty, with_uncertainty
from ...core.show.rows import case_name, quantity_name
from ...core.show.tables import csv_cell
from ...files.write.exchange import Kept, recover, replace_folder

OUT = "out"
RESULTS = "results.json"
PROVENANCE = "provenance.json"
# Names in out/ that are this tool's alone, also where a run writes no such file: an earlier model would mislead.
RESERVED = re.compile(
    r"(results|provenance|model|model_\w+)\.json|(results|verdicts)\.csv|report\.(html|pdf)|curves\.parquet|SHA256SUMS"
)
FEW = 5  # names in a remark
ROUNDING = 1e-9  # relative difference that is no change


def csv_text(rows: Sequence[Mapping[str, Any]], columns: Sequence[str]) -> str:
    """Return the rows as CSV with full digits; absent numbers are empty cells."""
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, list(columns), extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({name: _cell(row.get(name)) for name in columns})
    return buffer.getvalue()


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    return csv_cell(value) if isinstance(value, str) else repr(value) if isinstance(value, float) else str(value)


def check_writable(folder: Path) -> None:
    """Refuse before the work what could not be written after it.

    Raises
    ------
    StoreError
        If the folder cannot be written, or something of the user's stands where ``out/`` goes.
    """
    target = folder / OUT
    if target.is_symlink() or (target.exists() and not target.is_dir()):
        raise StoreError(f"{target} is not a folder of ours", do="Move it away", code="not_writable")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise StoreError(f"cannot write into {folder}", do="Make the folder writable, or copy it", code="not_writable")
    if not target.is_dir():
        return
    if not os.access(target, os.R_OK | os.W_OK | os.X_OK):
        raise StoreError(f"cannot write into {target}", do="Make it writable, or move it away", code="not_writable")
    for one in sorted(target.iterdir()):  # a folder must be writable to be moved
        if one.is_dir() and not one.is_symlink() and not os.access(one, os.W_OK | os.X_OK):
            what, why = f"cannot move {one}: it is read-only", f"a run replaces {target} and keeps what is not its own"
            raise StoreError(what, why=why, do=f"Make it writable, or move it out of {target}", code="not_writable")


def publish(folder: Path, files: Mapping[str, str | bytes]) -> tuple[Remark, ...]:
    """Replace what the last run wrote into ``folder/out`` by the files, all or nothing; say what was kept.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    files : mapping of str to str or bytes
        Name and content of each file.

    Raises
    ------
    StoreError
        If the folder cannot be written; the old ``out/`` stays as it was.
    """
    content = {name: one if isinstance(one, bytes) else one.encode() for name, one in files.items()}
    return tuple(_remarks(replace_folder(folder / OUT, content, RESERVED)))


def restore(folder: Path) -> tuple[Remark, ...]:
    """Finish or undo what a killed run began, where the folder can be written and no run is at work."""
    return tuple(_remarks(recover(folder / OUT, RESERVED)))


def _remarks(kept: Kept) -> Iterator[Remark]:
    if kept.moved:
        rooms = sorted({place.rpartition("/")[0] for place in kept.moved.values()})
        where = " and ".join(f"{OUT}/{room}/" for room in rooms)
        what = f"moved to {where}: {_names(kept.moved)} (edited since the last run, or not written by one)"
        yield Remark("file_moved", "warning", what)
    yield from kept_remarks(kept.stayed)
    if kept.stuck:
        what, do = f"could not be moved back into {OUT}/: {_names(kept.stuck)}", "Move by hand what you need of it"
        yield Remark("file_stuck", "warning", what, do=do)


def kept_remarks(names: Sequence[str]) -> tuple[Remark, ...]:
    """Return the remark on files of others that stand in ``out/``; none where there are none."""
    what = f"kept in {OUT}/: {_names(names)} (not written by inertialcal)"
    return (Remark("file_kept", "info", what),) if names else ()


def _names(names: Iterable[str]) -> str:
    """Return the first names of a list, as text that can be printed, and how many more there are."""
    every = sorted(os.fsencode(name).decode("utf-8", "backslashreplace") for name in names)
    more = f" and {len(every) - FEW} more" if len(every) > FEW else ""
    return ", ".join(every[:FEW]) + more


def changes(before: Mapping[str, Any] | None, after: Mapping[str, Any]) -> list[str]:
    """Return one line for each figure or verdict that differs from the last run.

    Parameters
    ----------
    before : mapping or None
        ``results.json`` of the last run; None where there was none.
    after : mapping
        Of this run.
    """
    if before is None:
        return []
    lines = []
    for table, name_of, shown in (("results", _figure, "value"), ("verdicts", _verdict, "verdict")):
        old, new = ({name_of(row): row for row in content[table]} for content in (before, after))
        for name in [*old, *(name for name in new if name not in old)]:
            one, other = old.get(name), new.get(name)
            if _differs(one, other, shown):
                first, second = (_shown(row, shown) for row in (one, other))
                if first == second:  # a change that rounding hides
                    first, second = (_shown(row, shown, digits=9) for row in (one, other))
                lines.append(f"{name}: {first} -> {second}")
    return lines


def _figure(row: Mapping[str, Any]) -> str:
    return " ".join(filter(None, (row["test"], quantity_name(row), row["axis"], case_name(row))))


def _verdict(row: Mapping[str, Any]) -> str:
    at = "" if row["at"] is None else str(row["at"])
    return " ".join(filter(None, (row["requirement"], row["test"], row["axis"], at)))


def _differs(old: Any, new: Any, shown: str) -> bool:
    """Tell whether a row changed in what it says, rounding aside."""
    if old is None or new is None:
        return True
    if any(old.get(name) != new.get(name) for name in ("status", "verdict", "unit")):
        return True
    pairs = [(old.get(name), new.get(name)) for name in (shown, "u")]
    return any(not _same(a, b) for a, b in pairs)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=ROUNDING, abs_tol=0.0)
    return bool(a == b)


def _shown(row: Any, name: str, digits: int = 0) -> str:
    """Return a value by the rule of all figures, or with that many digits; or a verdict."""
    if row is None:
        return "(none)"
    value = row.get(name)
    if not isinstance(value, float):
        return str(value)
    u = row.get("u") if name == "value" else None
    if not isinstance(u, float):
        return f"{value:.9g}"
    text = f"{value:.{digits}g} ± {uncertainty(u)}" if digits else with_uncertainty(value, u)
    return f"{text} {row.get('unit', '')}".strip()


PACKAGES = ("inertialcal", "numpy", "scipy", "numba", "pyarrow", "h5py", "pydantic")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that figures depend on."""
    return {"python": platform.python_version()} | {name: version_of_package(name) for name in PACKAGES}


def version_of_package(name: str = "inertialcal") -> str:
    """Return the version of a package that is installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"


def provenance(inputs: Mapping[str, str], folder: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``provenance.json``.

    Parameters
    ----------
    inputs : mapping of str to str
        SHA-256 of each input, by its path in the campaign folder.
    folder : str
        Of the campaign, as the user gave it.
    options : mapping
        Of the run.
    """
    return {
        "schema": 1,
        "made": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": {"system": platform.system(), "machine": platform.machine()},
        "versions": versions(),
        "inputs": [{"path": path, "sha256": digest} for path, digest in sorted(inputs.items())],
        "options": dict(options),
        "rerun": f"inertialcal run {shlex.quote(folder)}",
    }
