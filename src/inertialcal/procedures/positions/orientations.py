"""Positions in words: which axis points up, which part of a recording is which, what was turned about what.

``x+`` or ``x_p``: the x axis points up, its accelerometer reads plus g; ``x-`` or ``x_a``: down. ``x_rot``: turned
about x. ``?``: not known.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.labelled import LabelledPart
from ...core.remarks import Remark
from ...core.units import factor, parse_quantity
from ...files.source import load
from ...files.text.headers import plain
from ...files.text.table import Table, read_table
from .readings import Readings, turn_problems

FACES = "faces"  # in place of words: each position lies on the face that is nearest
POSITION = re.compile(
    r"(?P<sign>[+-]?)(?P<axis>[xyz])(?:[- _]?(?:axis|achse|axe|asse|eje))?[ _]?(?:nach |vers le |en |verso l'|hacia )?"
    r"(?P<way>\+|-|p|a|up|down|plus|minus|pos|neg|oben|unten|auf|ab|haut|bas|alto|basso|su|giu|arriba|abajo)?",
    re.IGNORECASE,
)
TURN = re.compile(r"(?P<sign>-?)(?P<axis>[xyz])[ _]?(?:rot|turn|rotation)", re.IGNORECASE)
VECTOR = re.compile(r"(?:[-+]?[\d.]+(?:e[-+]?\d+)?\s+){2}[-+]?[\d.]+(?:e[-+]?\d+)?", re.IGNORECASE)
DOWN = ("-", "a", "down", "minus", "neg", "unten", "ab", "bas", "basso", "giu", "abajo")
LIKE = "x+, x-, y+, y-, z+, z- (the axis that points up), a vector like 0 0.6 0.8, ? where it is not known"
LIKE_JSON = '{"x_p": {"start": 540, "end": 1271}}'
HOW_IT_LAY: tuple[str, ...] = ("position", "orientation", "face", "pose", "lage", "orientierung", "ausrichtung")
HOW_IT_LAY += ("posizione", "orientamento", "posicion", "orientacion")  # names of a column
LABELS = ("section", "label", "name", "part", *HOW_IT_LAY)
STARTS, STOPS, ANGLES = ("start", "begin", "from"), ("end", "stop", "to"), ("angle", "turn")
LEAST = 0.5  # cosine of the angle between the direction that is named and the one that is read, misalignment and all
NEAR_ZERO = 0.2  # of the span of an axis, below which the middle of its readings is a bias and not a zero
SPANNED = 0.5  # of the widest span, from which an axis has been turned enough to tell its middle
ON_FACE = 0.99  # cosine
LISTED = 3
MANY = 6  # positions, from which one sees whether an accelerometer follows them
UNEXPLAINED = 0.5  # part of the variance of its readings that the positions leave, above which it does not


def direction_of(text: str) -> Array | None:
    """Return the unit vector of specific force of a position in words, shape (3,); None where it is no position.

    A position that is not known is NaN throughout.
    """
    if text.strip() in ("?", ""):
        return np.full(3, np.nan)
    if VECTOR.fullmatch(text.strip()):
        vector = np.array([float(one) for one in text.split()])
        size = float(np.linalg.norm(vector))
        return np.asarray(vector / size) if 0.0 < size < math.inf else None
    match = POSITION.fullmatch(plain(text).strip())
    if match is None or (match["sign"] and match["way"]):
        return None
    down = match["sign"] == "-" or (match["way"] or "").lower() in DOWN
    if not match["sign"] and not match["way"]:
        return None
    return np.asarray(np.eye(3)[AXES.index(match["axis"].lower())] * (-1.0 if down else 1.0))


def turn_of(text: str) -> Array | None:
    """Return the unit vector that was turned about, shape (3,); None where it is no turn in words."""
    match = TURN.fullmatch(text.strip())
    if match is None:
        return None
    return np.asarray(np.eye(3)[AXES.index(match["axis"].lower())] * (-1.0 if match["sign"] else 1.0))


def orientation_list(given: str | Sequence[str]) -> list[str]:
    """Return positions in words.

    Parameters
    ----------
    given : str or sequence of str
        Words, in a text with commas between; or a file: a row a position, with columns x, y, z, or one of words.

    Raises
    ------
    UsageError
        ``wrong_value`` if a word is no position; ``missing_file``; ``no_column`` if the file has none.
    """
    words = given.split(",") if isinstance(given, str) else list(given)
    where = "orientations"
    if isinstance(given, str) and Path(given).is_file():
        table, where = read_table(Path(given)), given
        lower = {plain(name).lower(): name for name in table.names}
        label = next((lower[name] for name in lower if name in LABELS), None)
        if set(AXES) <= set(lower):
            rows = np.column_stack([table.numbers(lower[axis], required=False) for axis in AXES])
            words = [" ".join(map(repr, row.tolist())) if np.isfinite(row).all() else "?" for row in rows]
        elif label is not None:
            words = list(table.text(label))
        else:
            what = f"{given}: no columns x, y, z and none of labels; it has {', '.join(table.names)}"
            raise UsageError(what, do="Name the columns x, y, z, or position", code="no_column")
    elif isinstance(given, str) and "," not in given and Path(given).suffix:
        raise UsageError(f"orientations: no file {given!r}", do=f"Name a file, or words: {LIKE}", code="missing_file")
    words = [word.strip() or "?" for word in words]
    if words != [FACES]:
        parse_directions(words, where)
    return words


def parse_directions(words: Sequence[str], where: str) -> Array:
    """Return unit vectors of positions in words, shape (m, 3), NaN where not known; `directions` has the errors."""
    found = []
    for number, text in enumerate(words, 1):
        vector = direction_of(text)
        if vector is None:
            raise UsageError(f"position {number}: {text.strip()!r}", where, do=f"There are: {LIKE}", code="wrong_value")
        found.append(vector)
    return np.array(found).reshape(-1, 3)


def sections_of(path: Path) -> tuple[LabelledPart, ...]:
    """Return the labelled parts that a JSON or table says, in the order of the file.

    Raises
    ------
    DataError
        ``missing_file``, ``not_json``, ``wrong_value`` if one has no start or end, or an angle that is none;
        ``no_column``, ``no_unit`` if the angles of a table have none.
    """
    if path.suffix.lower() == ".json":
        return _read_json(path)
    table = read_table(path)
    label, start, stop = (_named(table, names) for names in (LABELS, STARTS, STOPS))
    timed = table.unit(start) == "s"
    angles: list[float | None] = [None] * len(table)
    turned = next((one for one in table.names if one.lower().partition("[")[0].strip() in ANGLES), None)
    if turned is not None:
        unit = table.unit(turned)
        if unit is None:
            why, do = "an angle may be in deg or rad", "Name the column with its unit: angle [deg]"
            raise DataError(f"column {turned!r} has no unit", table.source.path, why, do, "no_unit")
        scale = factor(unit, "rad")
        angles = [None if math.isnan(one) else float(one) * scale for one in table.numbers(turned)]
    ends = zip(table.text(label), table.numbers(start), table.numbers(stop), angles, strict=True)
    return tuple(
        _checked(LabelledPart(name, float(a), float(b), timed, angle), table.where(k))
        for k, (name, a, b, angle) in enumerate(ends)
    )


def _named(table: Table, names: Sequence[str]) -> str:
    for name in table.names:
        if name.lower().partition("[")[0].strip() in names:
            return name
    what = f"{table.source.path}: no column {names[0]}; it has {', '.join(table.names)}"
    raise DataError(what, do="A table of sections has columns section, start, end", code="no_column")


def _read_json(path: Path) -> tuple[LabelledPart, ...]:
    try:
        content = json.loads(load(path, document=True).data, object_pairs_hook=tuple)  # a label may stand twice
    except (ValueError, RecursionError) as error:
        do = f"Write it like {LIKE_JSON}"
        raise DataError(f"no JSON: {error}", str(path), do=do, code="not_json") from None
    if not isinstance(content, tuple) or not content:
        what = "no sections: the file holds no object" if not isinstance(content, tuple) else "no section in the file"
        raise DataError(what, str(path), do=f"Write it like {LIKE_JSON}", code="wrong_value")
    return tuple(_checked(_section(str(label), ends, str(path)), str(path)) for label, ends in content)


def _section(label: str, ends: Any, where: str) -> LabelledPart:
    pair: list[Any] = []
    given: Any = None
    if isinstance(ends, tuple):
        *pair, given = (next((v for k, v in ends if k in names), None) for names in (STARTS, STOPS, ANGLES))
    elif isinstance(ends, list) and len(ends) == 2:
        pair = ends
    read = [_place(one) for one in pair]
    if len(read) != 2 or None in read or read[0][1] != read[1][1]:  # type: ignore[index]
        do = 'Write it like {"start": 540, "end": 1271}, samples from 0, or {"start": "5.4 s", "end": "12.7 s"}'
        raise DataError(f"section {label!r}: no start and end", where, do=do, code="wrong_value")
    (start, seconds), (stop, _) = read  # type: ignore[misc]
    if given is None:
        return LabelledPart(label, start, stop, seconds)
    try:
        angle = float(parse_quantity(given if isinstance(given, str) else "").to("rad"))
    except DataError:
        do = 'Write it with its unit: "angle": "-360 deg"'
        raise DataError(f"section {label!r}: {given!r} is no angle", where, do=do, code="wrong_value") from None
    return LabelledPart(label, start, stop, seconds, angle)


def _place(given: Any) -> tuple[float, bool] | None:
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given), False
    if isinstance(given, str):
        try:
            return float(parse_quantity(given).to("s")), True
        except DataError:
            return None
    return None


def _checked(section: LabelledPart, where: str) -> LabelledPart:
    known = direction_of(section.label) is not None or turn_of(section.label) is not None
    if not known or not section.label.strip():
        do = f"There are: {LIKE}; x_rot, y_rot, z_rot for turns"
        raise DataError(f"section {section.label!r} is no position and no turn", where, do=do, code="unknown_name")
    if not section.stop > section.start:
        what = f"section {section.label!r}: from {section.start:g} to {section.stop:g}"
        raise DataError(what, where, do="Give the end after the start", code="wrong_value")
    if section.angle is not None and turn_of(section.label) is None:
        what = f"section {section.label!r} is a position, and has an angle"
        raise DataError(what, where, do="Leave the angle out, or name the turn: x_rot", code="wrong_value")
    if problems := turn_problems(section.angle) if section.angle is not None else []:
        raise DataError([replace(one, what=f"section {section.label!r}: {one.what}", where=where) for one in problems])
    return section


def runs_of(labels: Sequence[str]) -> tuple[LabelledPart, ...]:
    """Return the parts of a recording in which one label stands without a break, in order; empty labels are none."""
    edges = [0, *(i for i in range(1, len(labels)) if labels[i] != labels[i - 1]), len(labels)]
    pairs = pairwise(edges)
    return tuple(LabelledPart(labels[a], a, b) for a, b in pairs if b > a and labels[a].strip())


class Named(Protocol):
    """A part of a recording with its name."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def start(self) -> int: ...  # noqa: D102
    @property
    def stop(self) -> int: ...  # noqa: D102


def pointing(mean: Array) -> Array:
    """Return the direction that each position reads, unit vectors, shape (m, 3).

    Parameters
    ----------
    mean : ndarray, shape (m, 3)
        Readings at rest, of any unit and zero.
    """
    middle = 0.5 * (mean.max(axis=0) + mean.min(axis=0))
    near_zero = np.abs(middle) < NEAR_ZERO * np.ptp(mean, axis=0)
    x = mean - np.where(near_zero, 0.0, middle)
    return np.asarray(x / np.linalg.norm(x, axis=1)[:, None])


def check_names(readings: Readings) -> None:
    """Refuse positions that are named by one direction and read another.

    Raises
    ------
    DataError
        ``position_misnamed``, ``axis_not_read``.
    """
    span = np.ptp(readings.acc.mean, axis=0) if len(readings) else np.zeros(3)
    if readings.direction is None or span.max() == 0.0:
        return
    if span.min() < SPANNED * span.max():
        _check_followed(readings.acc.mean, readings.direction)
        return
    read = pointing(readings.acc.mean)
    along = np.sum(read * readings.direction, axis=1)
    wrong = np.flatnonzero(along < LEAST)  # NaN where a direction is not known
    if not len(wrong):
        return
    named = [
        f"{readings.place(int(k))} is named {_word(readings.direction[k])} but reads {_word(read[k])}"
        for k in wrong[:LISTED]
    ]
    more = f"; and {len(wrong) - LISTED} more" if len(wrong) > LISTED else ""
    known = int(np.isfinite(along).sum())
    opposite = len(wrong) == known and bool(np.all(along[wrong] < -LEAST))
    do = (
        "All read the opposite: change the signs of the accelerometers, or name the axis that points up"
        if opposite
        else "Correct the names, or columns and signs of the accelerometers"
    )
    raise DataError(
        f"{len(wrong)} of {known} positions are misnamed: {'; '.join(named)}{more}",
        why="x+ means that the x axis points up and its accelerometer reads +1 g",
        do=do,
        code="position_misnamed",
    )


def _check_followed(mean: Array, direction: Array) -> None:
    """Refuse an accelerometer that was laid up and down and reads no more of it than of anything else."""
    named = np.isfinite(direction).all(axis=1)
    d, read = direction[named], mean[named]
    design = np.hstack([np.ones((len(d), 1)), d])
    if len(d) < MANY or np.linalg.matrix_rank(design, 0.1) < 4:
        return
    left = read - design @ np.linalg.lstsq(design, read, rcond=None)[0]
    unexplained = np.sum(left**2, axis=0) / (len(d) - 4) / np.maximum(np.var(read, axis=0, ddof=1), 1e-300)
    for axis in np.flatnonzero((unexplained > UNEXPLAINED) & (np.ptp(d, axis=0) > 1.0)):
        raise DataError(
            f"accelerometer {AXES[axis]} does not follow the positions: it hardly changes from up to down",
            why="it is stuck or not connected, or the positions are misnamed",
            do=f"Check the channel of accelerometer {AXES[axis]}, and the names of the positions",
            code="axis_not_read",
        )


def _word(direction: Array) -> str:
    """Return a direction in words: ``x+`` where it is near an axis, else its components."""
    k = int(np.argmax(np.abs(direction)))
    if abs(direction[k]) > 1.0 - LEAST / 2.0:
        return f"{AXES[k]}{'+' if direction[k] > 0.0 else '-'}"
    return f"({', '.join(f'{one:.2f}' for one in direction)})"


def missing_faces(readings: Readings) -> list[Remark]:
    """Say which of the six faces is missing, where all positions are known and lie on faces."""
    d = readings.direction
    if d is None or not np.isfinite(d).all() or not np.all(np.abs(d).max(axis=1) > ON_FACE):
        return []
    there = {_word(one) for one in d}
    missing = [f"{axis}{sign}" for axis in AXES for sign in "+-" if f"{axis}{sign}" not in there]
    if not missing or len(missing) > 3:
        return []
    axes = ", ".join(dict.fromkeys(one[0] for one in missing))
    what = (
        f"{len(there)} of the six faces, {', '.join(missing)} missing: bias and scale factor of {axes} rest on the "
        "other faces, and there is no closed form of six faces"
    )
    return [Remark("face_missing", "warning", what, do="Lay the unit on each face, up and down")]


def check_sections(sections: Sequence[Named], samples: int, where: str) -> None:
    """Refuse sections of one kind that are not in the recording, or not apart.

    Parameters
    ----------
    sections : sequence of Named
        Positions, or turns.
    samples : int
        Of the recording.
    where : str
        Its file.

    Raises
    ------
    DataError
        ``wrong_section``.
    """
    for one in sections:
        if not 0 <= one.start < one.stop <= samples or one.stop - one.start < 2:
            what = f"section {one.name or 'without name'}: samples {one.start} to {one.stop}, of {samples}"
            why = "the protocol belongs to another recording, or counts at another rate"
            do = "Count samples from 0, the end excluded, or give times with a unit"
            raise DataError(what, where, why, do, "wrong_section")
    for one, other in pairwise(sorted(sections, key=lambda each: each.start)):
        if other.start < one.stop:
            what = (
                f"sections {one.name} (samples {one.start} to {one.stop}) and {other.name} ({other.start} to "
                f"{other.stop}) overlap"
            )
            raise DataError(what, where, "the same samples would count twice", "Separate them", "wrong_section")
