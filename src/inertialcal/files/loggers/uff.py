"""Universal files (UFF, UNV): functions of time in sets 58 and 58b, by pyuff.

A file holds a set a channel; those of the same stamps are one recording. Functions of frequency are left out.

References
----------
.. [1] University of Cincinnati, SDRL, Universal File Formats: data sets 58, 58b and 164.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.remarks import Remark
from ..apart import apart
from ..binary.arrays import number_column
from ..budget import PARTS, check_count, claim
from ..columns import Column, Content
from ..reader import Reader
from ..source import Loaded
from ..text.headers import heading
from .topics import Topic, choose, joined, left_out, library, on_disk, other_topics, rank_of, unique

START = re.compile(rb"(?:\s*\n)?[ ]{4}-1[ ]*\r?\n[ ]{2,5}[0-9]{1,4}[b \r\n]")  # numbers end at the sixth place
EDGE = re.compile(rb" {4}-1 *\r?(?:\n|$)")  # as pyuff finds them: binary numbers may stand before
SET, UNITS_SET = 58, 164
TIME_RESPONSE, TIME = 1, 17  # type of function, and of abscissa
QUANTITIES = {5: "temperature", 8: "displacement", 11: "velocity", 12: "acc", 13: "force", 15: "pressure"}
SI = {8: "m", 11: "m/s", 12: "m/s^2", 13: "N", 15: "Pa"}  # of a file whose set 164 says SI
DIRECTIONS = {1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}
NONE = ("", "none")
UNSAID = ("", "time", "index", "status", "spread")  # what a text says that names no reading


def read_uff(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the functions of time that share their stamps.

    Raises
    ------
    DataError
        ``several_topics``, ``wrong_column``, ``no_channel``, ``missing_extra``, ``too_large``, ``damaged_file``.
    """
    pyuff = library("pyuff", "a universal file (UFF)", loaded.path)
    claim(loaded.path, loaded.on_disk, 8 * len(loaded.data), "the sets of a universal file")
    with on_disk(loaded, ".uff") as path:
        file = pyuff.UFF(path)
        types = [int(one) for one in file.get_set_types()]
        check_count(len(types), PARTS, "data sets", loaded.path)
        known = {int(one.rstrip("b")) for one in file.get_supported_sets()}
        si = any(_one(file, i).get("units_code") == 1 for i, kind in enumerate(types) if kind == UNITS_SET)
        clocks: dict[tuple[Any, ...], list[tuple[str, dict[str, Any]]]] = {}
        others: list[str] = []
        for i, kind in enumerate(types):
            one = _one(file, i) if kind == SET and kind in known else {}
            if not one:
                others += [f"set {i + 1} (58)"] if kind == SET else []
                continue
            is_time = one.get("abscissa_spec_data_type") == TIME or one.get("func_type") == TIME_RESPONSE
            values = np.asarray(one.get("data", ()))
            if not is_time or values.dtype.kind != "f" or len(values) < 2:
                others.append(f"set {i + 1} ({'no function of time' if not is_time else 'no real numbers'})")
                continue
            stamps = np.asarray(one["x"], dtype=float)
            clocks.setdefault((len(stamps), stamps.tobytes()), []).append((_name(one), one))
    clocks = {key: _described(own, si) for key, own in clocks.items()}
    topics, by_name = [], {}
    for number, own in enumerate(clocks.values(), start=1):
        rank = rank_of((title, _unit(one, si)) for title, one in own)
        name = f"clock {number}" if len(clocks) > 1 else "sets 58"
        topics.append(Topic(name, " ".join(title for title, _ in own[:6]), len(own[0][1]["x"]), rank))
        by_name[name] = own
    chosen = choose(topics, variables, loaded.path)
    content = joined([(one, _columns(by_name[one.name], si)) for one in chosen], loaded.path)
    remarks = (*left_out(others, loaded.path), *_torn(loaded), *other_topics(topics, chosen, loaded.path))
    return Content(content.columns, "UFF 58", remarks=remarks)


def _columns(sets: Sequence[tuple[str, dict[str, Any]]], si: bool) -> Content:
    """Return the functions of one clock, its stamps first."""
    columns = [Column("time", np.asarray(sets[0][1]["x"], dtype=float), "s")]
    for name, (_, one) in zip(unique([title for title, _ in sets]), sets, strict=True):
        columns.append(number_column(name, np.asarray(one["data"]), _unit(one, si)))
    return Content(tuple(columns), "UFF 58")


def _one(file: Any, number: int) -> dict[str, Any]:
    """Return a set."""
    found = file.read_sets(number)
    return found if isinstance(found, dict) else {}


def _name(one: dict[str, Any]) -> str:
    """Return what a channel is called: quantity, name or number of the node, direction."""
    quantity = QUANTITIES.get(one.get("ordinate_spec_data_type", 0), "")
    turning = abs(one.get("rsp_dir", 0)) > 3
    if turning:
        quantity = {"velocity": "gyro", "acc": "angular_acceleration"}.get(quantity, quantity)
    node = "_".join(part for part in (_entity(one), str(one.get("rsp_node", ""))) if part)
    direction = int(one.get("rsp_dir", 0))
    axis = DIRECTIONS.get(abs(direction), "")[-1:]
    parts = [quantity or "channel", node, f"{'-' if direction < 0 else ''}{axis}" if axis else ""]
    return "_".join(part for part in parts if part)


def _described(sets: list[tuple[str, dict[str, Any]]], si: bool) -> list[tuple[str, dict[str, Any]]]:
    """Return the functions of one clock; those of nodes that are numbers alone by their texts, if all differ."""
    bare = [one for _, one in sets if one.get("ordinate_spec_data_type", 0) not in QUANTITIES and not _entity(one)]
    for key in ("ordinate_axis_lab", "id1"):
        said = [str(one.get(key, "")).strip() for one in bare]
        if len(set(said)) == len(said) and all(
            heading(text, _unit(one, si)).quantity not in UNSAID for text, one in zip(said, bare, strict=True)
        ):
            names = dict(zip(map(id, bare), said, strict=True))
            return [(names.get(id(one), name), one) for name, one in sets]
    return sets


def _entity(one: dict[str, Any]) -> str:
    """Return the name of the node, if it has one."""
    said = str(one.get("rsp_ent_name", "")).strip()
    return "" if said.lower() in NONE else said


def _unit(one: dict[str, Any], si: bool) -> str | None:
    said = str(one.get("ordinate_axis_units_lab", "")).strip()
    if said.lower() not in NONE:
        return said
    turning = abs(one.get("rsp_dir", 0)) > 3
    return SI.get(one.get("ordinate_spec_data_type", 0)) if si and not turning else None


def _torn(loaded: Loaded) -> tuple[Remark, ...]:
    """Return a remark where the last set has no end."""
    edges = [found.start() for found in EDGE.finditer(loaded.data)]
    if len(edges) % 2 == 0:
        return ()
    rest = len(loaded.data) - edges[-1]
    what = f"the last set has no end: {rest:,} bytes of it are not read"
    do = "Was the logger switched off while it wrote?"
    return (Remark("torn_file", "warning", what, where=loaded.path, count=rest, do=do),)


READER = Reader(
    "uff", "UFF 58", (".uff", ".unv", ".uff58"), lambda data, path: START.match(data[:200]) is not None,
    apart(read_uff, "a universal file (UFF)"),
)  # fmt: skip
