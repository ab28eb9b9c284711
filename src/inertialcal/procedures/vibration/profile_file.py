"""A profile as people write it: nodes, slopes, an overall level; what is missing follows, what disagrees is named.

CSV, a row a node or a segment: columns ``frequency``, ``density`` (or ``asd``, ``psd``, ``level``) and ``slope``, with
units in the header or in the name (``asd_g2_per_hz``; module ``density``). A segment has ``20-50`` in place of a
frequency; a slope that stands at a node is that of the segment behind it. TOML: ``nodes``, a list of
``{ frequency, level }`` and ``{ slope }`` in between, and ``rms`` for the overall level.

Where a node has no level, the slopes lead to it from one that has. Where both levels and the slope are given, levels
are taken, and a slope that misses the next level by more than ``SAME`` is remarked with both figures: as printed,
and as it would be. An overall level that is stated is held against the exact integral, within half of its last digit.

Reading this way assumes straight lines on logarithmic axes.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import Quantity, parse_quantity, same_dimension
from ...files.source import load
from ...files.text.headers import bare_name, in_brackets
from ...files.text.headers import plain as unmarked
from ...files.text.layout import decode
from ...files.text.table import Table, read_table, topics_of
from ...signals.vibration.profile import Profile, decibels, octaves
from .density import EXPECTED, DensityUnit, density_unit, level_of, plain

SLOPE = "dB/octave"
SAME = 0.25  # a slope may miss the next level by so much: levels are printed with one or two digits [dB]
FLAT = 1e-9  # slope that is none [dB/octave]
MOST = 1000  # nodes
SEGMENT = re.compile(r"\s*([0-9.eE+]+)\s*(?:-|\N{EN DASH}|to|\.\.+)\s*([0-9.eE+]+)\s*(?:[kK]?[hH][zZ])?\s*")
WORDS = {"frequency": "frequency", "freq": "frequency", "f": "frequency", "density": "density", "asd": "density",
         "psd": "density", "level": "density", "slope": "slope", "hz": "frequency",
         "amplitude": "density", "magnitude": "density", "g2": "density",
         **dict.fromkeys(("frequenz", "frequence", "frequenza", "frecuencia"), "frequency"),
         **dict.fromkeys(("dsp", "leistungsdichte", "densite", "densita", "densidad", "pegel", "niveau"), "density"),
         **dict.fromkeys(("steigung", "pente", "pendenza", "pendiente"), "slope")}  # fmt: skip


@dataclass(frozen=True)
class Node:
    """A frequency of a profile [Hz], and its density as stated; None where it follows."""

    frequency: float
    density: float | None


@dataclass(frozen=True)
class Contradiction:
    """A slope that does not lead from one level to the next."""

    low: float  # [Hz]
    high: float
    stated: float  # [dB/octave]
    implied: float
    knee: float | None  # Frequency where the level would be reached by the slope [Hz]; None where never
    start: float | None  # Level at the lower end, from the upper one by the slope, over that stated

    def __str__(self) -> str:
        """Return both figures in words."""
        text = f"{number(self.low, 6)} to {number(self.high, 6)} Hz: the slope is stated as {number(self.stated, 4)}"
        text += f" dB/octave, the levels are {number(self.implied, 4)} dB/octave apart"
        reached = f"; by the slope the second level is reached at {number(self.knee, 4)} Hz" if self.knee else ""
        return text + reached


@dataclass(frozen=True, eq=False)
class StatedProfile:
    """A profile, what was stated of it, and where that does not agree.

    Parameters
    ----------
    profile : Profile
        By its levels, in SI: [(m/s^2)^2/Hz].
    unit : str
        Of a level as it was written.
    stated : tuple of bool
        Which nodes have a level that was written; others follow from slopes.
    contradictions : tuple of Contradiction
        Slopes that the levels do not have.
    by_slopes : Profile or None
        With the first of them mended: its knee where the slope puts it.
    overall : float or None
        That was stated [m/s^2].
    path : str
        Of the file.
    """

    profile: Profile
    unit: str
    stated: tuple[bool, ...]
    contradictions: tuple[Contradiction, ...] = ()
    by_slopes: Profile | None = None
    overall: float | None = None
    overall_text: str = ""
    path: str = ""
    remarks: tuple[Remark, ...] = field(default=())


def read_profile(path: str | Path) -> StatedProfile:
    """Return the profile in a CSV or TOML file.

    Raises
    ------
    DataError
        ``not_toml``, ``profile``, ``wrong_unit``, ``wrong_value``; as reading a table.
    """
    if str(path).lower().endswith(".toml"):
        nodes, slopes, unit, overall = _of_toml(decode(load(path).data, str(path))[0], str(path))
    else:
        nodes, slopes, unit, overall = _of_tables(path)
    try:
        found = completed(nodes, slopes, unit.unit if unit else "g^2/Hz", overall, str(path))
    except DataError as error:
        first = error.problems[0]
        raise DataError(first.what, first.where or str(path), first.why, first.do, first.code) from None
    if unit is None or not unit.root:
        return found
    what = f"levels are roots of a density: squared, they are in {unit.unit}"
    return replace(found, remarks=(Remark("squared", "info", what, str(path)), *found.remarks))


def stated(profile: Profile) -> StatedProfile:
    """Return a profile as if a file stated its nodes."""
    both = zip(profile.frequency.tolist(), profile.density.tolist(), strict=True)
    nodes = [Node(frequency, density) for frequency, density in both]
    return completed(nodes, [None] * (len(nodes) - 1))


def completed(
    nodes: Sequence[Node], slopes: Sequence[float | None], unit: str = "g^2/Hz", overall: str = "", path: str = ""
) -> StatedProfile:
    """Return a profile of nodes and the slopes between them: missing levels follow, contradictions are found.

    Parameters
    ----------
    nodes : sequence of Node
        Densities in SI.
    slopes : sequence of float or None, one less
        As stated [dB/octave].
    unit, overall, path : str
        As levels were written; the overall level as text; the file.

    Raises
    ------
    DataError
        ``profile`` where frequencies do not rise, or a level does not follow.
    """
    if len(nodes) < 2:
        raise DataError(f"{len(nodes)} node(s) of a profile, need two or more", path, code="profile")
    if len(nodes) > MOST:
        raise DataError(f"{len(nodes)} nodes of a profile, {MOST} at most", path, code="profile")
    levels = [one.density for one in nodes]
    steps = [octaves(a.frequency, b.frequency) if b.frequency > a.frequency > 0.0 else 0.0
             for a, b in pairwise(nodes)]  # fmt: skip
    for i in [*range(len(slopes)), *reversed(range(len(slopes)))]:  # upwards, then downwards
        slope, (low, high) = slopes[i], levels[i : i + 2]
        if slope is not None and low is not None and high is None:
            levels[i + 1] = low * 10.0 ** (0.1 * slope * steps[i])
        elif slope is not None and high is not None and low is None:
            levels[i] = high * 10.0 ** (-0.1 * slope * steps[i])
    missing = [one.frequency for one, level in zip(nodes, levels, strict=True) if level is None]
    if missing:
        what = f"the level at {number(missing[0], 6)} Hz is not given, and no slope leads to it"
        raise DataError(what, path, do="Give its level, or the slope of a segment beside it", code="profile")
    frequency, density = np.array([one.frequency for one in nodes]), np.array(levels, dtype=float)
    profile = Profile(frequency, density)
    known = tuple(one.density is not None for one in nodes)
    found = [_contradiction(nodes[i], nodes[i + 1], slope) for i, slope in enumerate(slopes) if slope is not None]
    wrong = tuple(one for one in found if one is not None)
    mended = _mended(profile, wrong[0]) if wrong else None
    stated = None if not overall else parse_quantity(plain(overall)).to("m/s^2")
    remarks = [_remark(one, profile, mended, path, first=i == 0) for i, one in enumerate(wrong)]
    if stated is not None and not _agrees(overall, profile.rms()):
        shown = parse_quantity(plain(overall)).unit
        own = Quantity(profile.rms(), "m/s^2").to(shown)
        what = f"the overall level is stated as {overall}, the nodes give {number(own, 5)} {shown}"
        do = "Check nodes and overall level against the document: the nodes are used"
        remarks.append(Remark("overall_disagrees", "warning", what, path, do=do))
    return StatedProfile(profile, unit, known, wrong, mended, stated, overall, path, tuple(remarks))


def _contradiction(low: Node, high: Node, slope: float) -> Contradiction | None:
    if low.density is None or high.density is None or not high.frequency > low.frequency > 0.0:
        return None
    apart = octaves(low.frequency, high.frequency)
    rise = float(decibels(high.density / low.density))
    if abs(rise - slope * apart) <= SAME:
        return None
    knee = low.frequency * 2.0 ** (rise / slope) if abs(slope) > FLAT and rise / slope > 0.0 else None
    return Contradiction(
        low.frequency, high.frequency, slope, rise / apart, knee, 10.0 ** (0.1 * (rise - slope * apart))
    )


def _mended(profile: Profile, one: Contradiction) -> Profile | None:
    """Return the profile with the node above a wrong slope where the slope reaches its level, if that is possible."""
    if one.knee is None:
        return None
    frequency = profile.frequency.copy()
    at = int(np.flatnonzero(frequency == one.high)[0])
    above = frequency[at + 1] if at + 1 < len(frequency) else math.inf
    if not one.low < one.knee < above:
        return None
    frequency[at] = one.knee
    return Profile(frequency, profile.density)


def _remark(one: Contradiction, profile: Profile, mended: Profile | None, path: str, *, first: bool) -> Remark:
    what = str(one)
    if first and mended is not None:
        own, other = (Quantity(each.rms(), "m/s^2").to("g") for each in (profile, mended))
        what += f"; overall {number(own, 5)} g by the levels, {number(other, 5)} g with that node there"
    do = "Check the document: levels are used, not this slope"
    return Remark("slope_disagrees", "warning", what, path, do=do, subject=f"{one.low:g}-{one.high:g}")


def _agrees(text: str, value: float) -> bool:
    """Return whether a value rounds to what was written."""
    quantity = parse_quantity(plain(text))
    digits = re.match(r"\s*[0-9]+(?:\.([0-9]+))?", text)
    decimals = len(digits[1] or "") if digits else 0
    own = Quantity(value, "m/s^2").to(quantity.unit)
    return abs(own - quantity.value) <= 0.5 * 10.0**-decimals * (1.0 + 1e-9)


Parsed = tuple[list[Node], list[float | None], DensityUnit | None, str]


def _of_toml(text: str, path: str) -> Parsed:
    rows, overall = _stated_rows(text, path)
    nodes: list[Node] = []
    slopes: list[float | None] = []
    unit: DensityUnit | None = None
    for place, row in enumerate(rows, 1):
        where = f"{path}: nodes, {place}"
        if wrong := sorted(set(row) - {"frequency", "level", "slope"}):
            raise DataError(f"key {wrong[0]!r}", where, do="There are: frequency, level, slope", code="unknown_key")
        slope = _quantity(row, "slope", SLOPE, where)
        if "frequency" in row:
            frequency = _quantity(row, "frequency", "Hz", where)
            level = None
            if "level" in row:
                level, of_level = _level(str(row["level"]), where)
                unit = unit or of_level
            nodes.append(Node(frequency or 0.0, level))
            slopes += [None] * (len(nodes) - 1 - len(slopes))
            if slope is not None:
                slopes.append(slope)
        elif slope is None or not nodes or len(slopes) >= len(nodes):
            raise DataError("neither a node nor the slope behind one", where, code="profile")
        else:
            slopes.append(slope)
    if len(slopes) > max(len(nodes) - 1, 0):
        do = "End with a node: its frequency is enough"
        raise DataError("a slope behind the last node", path, do=do, code="profile")
    return nodes, slopes, unit, overall


def _stated_rows(text: str, path: str) -> tuple[list[dict[str, Any]], str]:
    """Return the list of nodes and slopes, and the overall level as text."""
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise DataError(f"not TOML: {error}", path, code="not_toml") from None
    known = {"nodes", "rms", "source"}
    if unknown := sorted(set(content) - known):
        raise DataError(f"key {unknown[0]!r}", path, do=f"There are: {', '.join(sorted(known))}", code="unknown_key")
    rows, overall = content.get("nodes"), str(content.get("rms", ""))
    if not isinstance(rows, list) or not all(isinstance(one, dict) for one in rows):
        do = 'Write nodes = [ { frequency = "20 Hz", level = "0.01 g2/Hz" }, { slope = "3 dB/octave" }, ... ]'
        raise DataError("no list of nodes", path, do=do, code="profile")
    if overall:
        _quantity({"rms": overall}, "rms", "m/s^2", path)
    return rows, overall


def _quantity(row: Mapping[str, Any], name: str, unit: str, where: str) -> float | None:
    if name not in row:
        return None
    text = str(row[name])
    try:
        quantity = parse_quantity(plain(text))
    except DataError as error:
        first = error.problems[0]
        raise DataError(f"{name}: {first.what}", where, first.why, first.do, first.code) from None
    if not same_dimension(quantity.unit, unit):
        what = f"{name} = {text!r}: no {'slope' if name == 'slope' else 'quantity'} in {unit}"
        raise DataError(what, where, do=f"Write it in {unit}", code="wrong_unit")
    return quantity.to(unit)


def _level(text: str, where: str) -> tuple[float, DensityUnit]:
    try:
        return level_of(text)
    except DataError as error:
        first = error.problems[0]
        raise DataError(f"level = {text!r}: {first.what}", where, first.why, first.do, first.code) from None


def _of_tables(path: str | Path) -> Parsed:
    """Return what the only table of a file that can be a profile states: a workbook may hold recordings beside it."""
    try:
        return _of_table(read_table(path))
    except DataError as error:
        if error.problems[0].code not in ("no_column", "several_topics"):
            raise
        found = dict[str, Parsed]()
        for name in topics_of(path):
            with suppress(DataError):
                found[name] = _of_table(read_table(path, topics=[name]))
        if not found:
            raise
    if len(found) > 1:
        what = f"holds {len(found)} profiles: {', '.join(found)}"
        raise DataError(what, str(path), do="Give a file with one of them", code="profile")
    return next(iter(found.values()))


def _of_table(table: Table) -> Parsed:
    """Return what the rows of a table state."""
    columns: dict[str, int] = {}
    for place, name in enumerate(table.names):
        word = WORDS.get(re.split(r"[^a-z0-9]", unmarked(bare_name(name) or name).strip().lower())[0])
        if word is not None:
            columns.setdefault(word, place)
    lacking = [word for word in ("frequency", "density") if word not in columns]
    if lacking:
        what = f"no column of {' and '.join(lacking)}; there are: {', '.join(table.names)}"
        do = "Write a header: frequency [Hz],density [g2/Hz],slope [dB/octave]"
        raise DataError(what, table.source.path, do=do, code="no_column")
    unit = _unit_of(table, columns["density"])
    hertz = _hertz(table, columns["frequency"])
    nodes: list[Node] = []
    slopes: list[float | None] = []
    for row in range(len(table)):
        cells = {word: table.cells[place][row].strip() for word, place in columns.items()}
        cells = {word: cell.replace(",", ".") for word, cell in cells.items()} if table.decimal == "," else cells
        where = table.where(row)
        level, slope = (_number(cells.get(name, ""), where, name) for name in ("density", "slope"))
        level = None if level is None else unit.density(level)
        segment = SEGMENT.fullmatch(cells["frequency"])
        if segment is None:
            frequency = _number(cells["frequency"], where, "frequency")
            if frequency is None:
                raise DataError("a row without a frequency", where, code="profile")
            _add(nodes, slopes, Node(frequency * hertz, level))
            if slope is not None:
                slopes.append(slope)
            continue
        low, high = (float(one) * hertz for one in segment.groups())
        flat = slope is not None and abs(slope) <= FLAT
        _add(nodes, slopes, Node(low, level if flat else None))
        slopes.append(slope)
        _add(nodes, slopes, Node(high, level if flat or (slope is None and level is not None) else None))
    if len(slopes) > max(len(nodes) - 1, 0):
        raise DataError("a slope behind the last node", table.source.path, do="End with a node", code="profile")
    slopes += [None] * (len(nodes) - 1 - len(slopes))
    return nodes, slopes, unit, ""


def _add(nodes: list[Node], slopes: list[float | None], node: Node) -> None:
    """Add a node, or what is stated again of the last one."""
    if nodes and nodes[-1].frequency == node.frequency and (nodes[-1].density is None or node.density is None
                                                            or nodes[-1].density == node.density):  # fmt: skip
        nodes[-1] = nodes[-1] if node.density is None else node
        return
    nodes.append(node)
    slopes += [None] * (len(nodes) - 1 - len(slopes))


def _unit_of(table: Table, place: int) -> DensityUnit:
    """Return the unit of the levels: what stands in brackets or behind the word, else of the row of units.

    Raises
    ------
    DataError
        ``wrong_unit``.
    """
    name = table.names[place]
    bare = bare_name(name)
    behind = in_brackets(name) or re.sub(r"^[A-Za-z]+[ _.,]*", "", bare)
    said = [one for one in (behind, bare, table.units[place] if place < len(table.units) else None) if one]
    for one in said:
        try:
            return density_unit(one)
        except DataError:
            continue
    shown = said[0] if said[0] != bare else said[-1]
    what = f"column {name!r} has {f'the unit {shown}' if shown != bare else 'no unit'}"
    do = f"Write density [g2/Hz] in the header: a level is in {EXPECTED}"
    raise DataError(what, table.source.path, "a level is a spectral density of acceleration", do, "wrong_unit")


def _hertz(table: Table, place: int) -> float:
    """Return hertz a unit of the column of frequencies."""
    unit = (table.units[place] if place < len(table.units) else None) or "Hz"
    if not same_dimension(unit, "Hz"):
        what = f"column {table.names[place]!r} has the unit {unit}"
        raise DataError(what, table.source.path, do="Write frequency [Hz] in the header", code="wrong_unit")
    return Quantity(1.0, unit).to("Hz")


def _number(cell: str, where: str, name: str) -> float | None:
    if not cell:
        return None
    try:
        return float(cell)
    except ValueError:
        raise DataError(f"{name}: {cell!r} is not a number", where, code="wrong_value") from None


__all__ = ["Contradiction", "Node", "StatedProfile", "completed", "read_profile"]
