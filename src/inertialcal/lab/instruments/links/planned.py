"""The bench of a plan: a simulated unit on the machine that its schedule tells what to do.

The plan's file says which test it is, with which settings, and where its schedule stands; the procedure of that test
makes the unit.
"""

from __future__ import annotations

import tomllib
from functools import lru_cache
from pathlib import Path

from ....core.errors import DataError, PlanError
from ....files.source import read_bytes
from ....files.text.table import read_table
from ....procedures import procedure_of
from ....procedures.rehearsed import Rehearsal
from ...clock import Clock
from ..dialect import Dialect
from .bench import Bench, BenchLink, build_bench
from .link import LinkEntry, LinkKind

POWER_UP = "power_up"


def rehearsal_of(path: Path, seed: int) -> Rehearsal:
    """Return what a plan gives on a simulated unit.

    Raises
    ------
    PlanError
        If it is none.
    InertialcalError
        If its settings or its schedule cannot be read.
    """
    try:
        text = read_bytes(path).decode("utf-8")
        document = tomllib.loads(text)
        procedure, settings = procedure_of(str(document["procedure"])), dict(document["settings"])
        table = read_table(path.parent / str(document["schedule"]))
    except DataError as error:
        raise PlanError(list(error.problems)) from None
    except (KeyError, TypeError, ValueError) as error:
        do = "Have the planner of the test write it"
        raise PlanError(f"not a plan: {error}", path.name, do=do, code="wrong_value") from None
    return procedure.rehearsed(settings, table, seed)


def _bench(entry: LinkEntry, folder: Path) -> Bench:
    path = folder / entry.plan
    changed = tuple(one.stat().st_mtime_ns for one in sorted(folder.glob("*.[ct][so][vm]*")))
    return _made(path, entry.seed, changed)


@lru_cache(maxsize=2)
def _made(path: Path, seed: int, changed: tuple[int, ...]) -> Bench:
    """Return the bench of a plan, made once as long as no file beside it changes."""
    made = rehearsal_of(path, seed)
    return build_bench("bench of a plan", made.recordings, made.stretches, POWER_UP, made.way.setting, made.way.unit)


def _make(entry: LinkEntry, folder: Path, clock: Clock) -> BenchLink:
    return BenchLink(_bench(entry, folder), clock)


def _dialect(entry: LinkEntry, folder: Path) -> Dialect:
    return _bench(entry, folder).dialect


KIND = LinkKind("planned", ("plan", "seed"), 1, _make, _dialect, paced=True)
