"""Table of the biases in a results file of flips: ``out/results.json`` of `run`, or what `flip --json` prints.

A row is the bias of one axis in one test, as `shifted-model` takes it: ``u`` is what is drawn anew for each flight,
columns ``shared NAME`` what one standard uncertainty of an unknown changes that all flights share; ``bias_of`` says
whether a ground model was applied before the flip: the bias is then along the axes of the head.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.errors import DataError
from ...core.influence import influence_of
from ...core.schema.standards import REDRAWN
from ...core.units import factor
from ..source import Loaded

FLIP, BIAS, TEMPERATURE = "flip", "bias", "flip_temperature"
UNIT = "ug"
ANEW = ("mounting", "power_up", "day")  # what draws the error of a standard anew for each flight
SHARED = "shared "
NAMES = ("flight", "date", "serial", "axis", "temperature", "bias", "u", "dof", "bias_of")
UNITS = (None, None, None, None, "degC", UNIT, UNIT, None, None)


def is_results(data: bytes) -> bool:
    """Tell whether a file is results of this package, by its first bytes."""
    start = data[:4096].lstrip()
    return start.startswith(b"{") and b'"schema"' in start and (b'"campaign"' in start or b'"command"' in start)


def shared_columns(names: Sequence[str]) -> dict[str, str]:
    """Return the columns that say what an unknown changes which flights share: column, unknown."""
    return {name: name.removeprefix(SHARED) for name in names if name.startswith(SHARED)}


def results_columns(
    loaded: Loaded,
) -> tuple[tuple[str, ...], tuple[tuple[str, ...], ...], tuple[str | None, ...]]:
    """Return the biases of a results file: names, cells and units of its columns.

    Raises
    ------
    DataError
        ``damaged_file`` where it is cut off, or no results; ``no_flip`` where no flip found a bias with its
        uncertainty; ``no_date``, ``no_temperature`` where it does not say when, or how warm the head was.
    """
    try:
        content = json.loads(loaded.data)
        rows = [row for row in content["results"] if row["method"] == "result" and row["member"] is None]
        flips = {one["test"]: one["time"] for one in content.get("sequence", ()) if one["procedure"] == FLIP}
        if content.get("command") == FLIP:
            flips = {row["test"]: content.get("time") for row in rows}
        biases = [row for row in rows if row["quantity"] == BIAS and row["u"] and row["test"] in flips]
        made = [_row(content, row, flips[row["test"]], rows, loaded.path) for row in biases]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        what = "this is no whole results file"
        do = "Give out/results.json of a run, or the JSON that a flip printed"
        raise DataError(what, loaded.path, type(error).__name__, do, "damaged_file") from None
    if not made and content.get("errors"):
        raise DataError("it holds no figures, but why there are none", loaded.path, str(content["errors"][0]["what"]),
                        "Mend that, and flip it again", "no_flip")  # fmt: skip
    if not made:
        what = "no flip in it found a bias with its uncertainty"
        do = "Give the results of flips of recordings: a table of means does not show the noise"
        raise DataError(what, loaded.path, "a flip counts by its uncertainty", do, "no_flip")
    unknowns = list(dict.fromkeys(name for _, shared in made for name in shared))
    columns = [[cells[i] for cells, _ in made] for i in range(len(NAMES))]
    columns += [[f"{shared.get(name, 0.0)!r}" for _, shared in made] for name in unknowns]
    names = (*NAMES, *(f"{SHARED}{name}" for name in unknowns))
    return names, tuple(map(tuple, columns)), (*UNITS, *(UNIT for _ in unknowns))


def _row(
    content: Mapping[str, Any],
    row: Mapping[str, Any],
    when: str | list[str] | None,
    rows: list[dict[str, Any]],
    path: str,
) -> tuple[tuple[str, ...], dict[str, float]]:
    """Return the cells of a bias, and what it shares with others [ug]."""
    test, axis, per = row["test"], row["axis"], factor(row["unit"], UNIT)
    date = when if isinstance(when, str) else when[0] if when else ""
    if not date:
        what = f"test {test}: no date: the clock of its recording is elapsed time"
        do = "Flip a recording whose time column has dates, or give the flip as a row of a table"
        raise DataError(what, path, "flights are told apart, and drift, by their dates", do, "no_date")
    warm = next((one["value"] for one in rows if one["quantity"] == TEMPERATURE and one["axis"] == axis
                 and one["test"] == test), None)  # fmt: skip
    if warm is None:
        what = f"test {test}: temperature of {axis} not known"
        do = "Name the channel of the temperature in its recording, and flip it again"
        raise DataError(what, path, "the ground model has another bias at each temperature", do, "no_temperature")
    said = content.get("influences", {})
    redrawn = {name: said.get(influence_of(name), {}).get("redrawn_by") or REDRAWN.get(influence_of(name), "")
               for name in row["shared"]}  # fmt: skip
    common = {name: change * per for name, change in row["shared"].items() if redrawn[name] not in ANEW and change}
    u = math.sqrt(max((row["u"] * per) ** 2 - sum(one**2 for one in common.values()), 0.0))
    serial = (content.get("item") or {}).get("serial") or ""
    dof = "" if row["dof"] is None else repr(row["dof"])
    name = f"{content['campaign']['id']} {test}" if "campaign" in content else Path(path).stem
    models = any(one["code"] == "ground_model" for one in content["remarks"])
    frame = "head" if models else "sensor"
    return (name, date, serial, axis, repr(warm), repr(row["value"] * per), repr(u), dof, frame), common
