"""Mutations at three levels: bytes, numbers and rows, structure. All but the first keep a file readable."""

from __future__ import annotations

import copy
import json
import random
import re
import tomllib
from collections.abc import Callable, MutableMapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import pyarrow as pa
import tomlkit
import yaml
from pyarrow import parquet
from seed_files import Table, csv_text, numbers, read_csv

from inertialcal.core.schema.checksum import CHECKSUM, checksum

Level: TypeAlias = Literal["bytes", "numbers", "structure"]
NUMBERS = (
    "0", "-0", "0.0", "1", "-1", "1e160", "-1e160", "1e-160", "1e308", "1e-308", "5e-324", "1e206", "1e150", "1e400",
    "nan", "inf", "-inf", "9" * 20, "9" * 400, "1,5", "0x1F", "1_000", "", " ", "text", "true", "1e", "--1", "1e18",
    "9223372036854775808", "-9223372036854775809", "1.7976931348623157e308", "0.1e-300", "+1", "１", "1/3",
)  # fmt: skip
UNITS = ("deg/s", "rad/s", "m/s^2", "g", "ug", "count", "V", "s", "degC", "K", "1", "%", "furlong", "deg/s/s", "Hz")
NAMES = (
    "", " ", "x", "t", "time", "unix_s", "=cmd|' /C calc'!A1", "a\nb", "a,b", '"', "#", "x [deg/s]", "x [furlong]",
    "\u202etxt", "ü", "\x1b[2J", "1.5", "nan", "x" * 300, "temperature", "@SUM(1)", "column_1", "../x", "%s", "{x}",
)  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])")
UNIT = re.compile(r"(?<=\d )(deg/s|rad/s|m/s\^?2|ug|mg|g|deg|rad|s|min|h|Hz|degC|K|V|count|ppm|%|cm|m|kg)\b")


def mutated_bytes(content: bytes, rng: random.Random) -> bytes:
    """Flip, cut, insert or repeat at one to four places."""
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(content) + 1)
        to = min(len(content), at + rng.choice((1, 2, 4, 8, 64, 4096)))
        match rng.randrange(6):
            case 0:
                content = content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]
            case 1:
                content = content[:at] + rng.randbytes(to - at) + content[at:]
            case 2:
                content = content[:at] + content[to:]
            case 3:
                content = content[:to] + content[at:to] * rng.randint(1, 8) + content[to:]
            case 4:
                content = content[:at]
            case _:
                content = content[:at] + rng.choice((b"\x00", b"\xff", b"\n", b",", b"}", b'"')) * 4 + content[at + 4 :]
    return content


# Text

MILD = 0.5  # of the numbers stay numbers that something has
FACTORS = (-1.0, 0.0, 0.1, 0.5, 0.9, 1.1, 2.0, 10.0, 1000.0)


def mild(number: str, rng: random.Random) -> str:
    """Return a number of the same order as a text, a whole one for a whole one."""
    new = float(number) * rng.choice(FACTORS)
    return str(round(new)) if number.lstrip("+-").isdigit() and abs(new) < 1e15 else repr(new)


def mutated_text(text: str, rng: random.Random) -> str:
    """Replace numbers and units, and move, repeat or drop lines."""
    for _ in range(rng.randint(1, 3)):
        numbers_at, units_at = ([one.span() for one in form.finditer(text)] for form in (NUMBER, UNIT))
        kind = rng.random()
        if kind < 0.7 and numbers_at:
            begin, end = rng.choice(numbers_at)
            new = mild(text[begin:end], rng) if rng.random() < MILD else rng.choice(NUMBERS)
            text = text[:begin] + new.rjust(end - begin) + text[end:]  # a card has its fields at fixed columns
        elif kind < 0.8 and units_at:
            begin, end = rng.choice(units_at)
            text = text[:begin] + rng.choice(UNITS) + text[end:]
        elif lines := text.splitlines():
            at, to = sorted((rng.randrange(len(lines)), rng.randrange(len(lines))))
            match rng.randrange(4):
                case 0:
                    lines[at], lines[to] = lines[to], lines[at]
                case 1:
                    lines.insert(to, lines[at])
                case 2:
                    del lines[at]
                case _:
                    del lines[at : min(to, at + 40)]
            text = "\n".join([*lines, ""])
    return text


# Trees: JSON, TOML, YAML

Change: TypeAlias = Callable[[Any, Any, random.Random], None]  # of a key of a parent


def mutated_tree(tree: Any, rng: random.Random, ways: Sequence[Change]) -> Any:
    """Change one to three places of a tree: numbers, keys, types, nesting."""
    tree = copy.deepcopy(tree)
    for _ in range(rng.randint(1, 3)):
        places = list(_places(tree))
        if not places:
            break
        parent, key = rng.choice(places)
        rng.choice(ways)(parent, key, rng)
    return tree


def _places(node: Any) -> Any:
    keys: Any = node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    for key in list(keys):
        yield node, key
        yield from _places(node[key])


def _put(parent: Any, key: Any, rng: random.Random) -> None:
    text = rng.choice(NUMBERS)
    try:
        value: Any = float(text) if rng.random() < 0.8 else text
    except ValueError:
        value = text
    parent[key] = value


def _scale(parent: Any, key: Any, rng: random.Random) -> None:
    if isinstance(parent[key], int | float) and not isinstance(parent[key], bool):
        parent[key] = parent[key] * rng.choice((*FACTORS, 1e-160, 1e20, 1e160))
    else:
        _put(parent, key, rng)


def _spell(parent: Any, key: Any, rng: random.Random) -> None:
    """Change the number or the unit within a text, such as that of a quantity."""
    parent[key] = mutated_text(parent[key], rng) if isinstance(parent[key], str) else str(parent[key])


def _drop(parent: Any, key: Any, _: random.Random) -> None:
    del parent[key]


def _rename(parent: Any, key: Any, rng: random.Random) -> None:
    if isinstance(parent, MutableMapping):
        parent[rng.choice((*NAMES, *map(str, parent)))] = parent.pop(key)


def _swap(parent: Any, key: Any, rng: random.Random) -> None:
    keys = list(parent) if isinstance(parent, dict) else range(len(parent))
    other = rng.choice(keys)
    parent[key], parent[other] = parent[other], parent[key]


def _retype(parent: Any, key: Any, rng: random.Random) -> None:
    parent[key] = rng.choice(([], {}, True, "", 0, "text", [[]], [1.0, 2.0], {"x": 1.0}, [parent[key]], None))


def _length(parent: Any, key: Any, rng: random.Random) -> None:
    value = parent[key]
    if isinstance(value, list) and value:
        parent[key] = rng.choice((value[:-1], [*value, value[-1]], value[::-1], value[:1], value * 2))
    else:
        _retype(parent, key, rng)


TREE: tuple[Change, ...] = (
    _put, _put, _scale, _scale, _spell, _spell, _drop, _rename, _swap, _retype, _length,
)  # fmt: skip


# Tables


def mutated_table(table: Table, level: Level, rng: random.Random, binary: bool = False) -> Table:
    """Change the numbers of a table, or its rows, columns and types."""
    table = {name: column.copy() for name, column in table.items()}
    for _ in range(rng.randint(1, 2)):
        if not table:
            break
        if level == "numbers":
            rng.choice((_cells, _cells, _scaled_columns, _times, _rows))(table, rng)
        else:
            rng.choice((_rows, _columns, _columns, _types if binary else _columns))(table, rng)
    return table


def _some(table: Table, rng: random.Random) -> list[str]:
    return rng.choice(([rng.choice([*table])], [*table], [*table][1:] or [*table]))


def _cells(table: Table, rng: random.Random) -> None:
    """Put one number into a few cells, a stretch, every other cell or a whole column."""
    word = rng.choice(NUMBERS)
    for name in _some(table, rng):
        column = table[name]
        n = len(column)
        at = rng.randrange(n) if n else 0
        rows = rng.choice((np.array([at]), np.arange(at, n), np.arange(0, n, 2), np.arange(n), np.arange(0, n, 17)))
        if column.dtype != object:
            try:
                column[rows.astype(int)] = float(word)
                continue
            except (ValueError, OverflowError):
                column = table[name] = column.astype(object)
        column[rows.astype(int)] = word


def _scaled_columns(table: Table, rng: random.Random) -> None:
    """Multiply columns by a factor or add an offset, however large."""
    factor = rng.choice((*FACTORS, 1e-160, 1e-9, 1e9, 1e100, 1e160, 1e290))
    offset = rng.choice((0.0, 0.0, 1e6, 1e16, 1e300))
    for name in _some(table, rng):
        column = numbers({name: table[name]})[name]
        if column.dtype != object and column.dtype.kind in "fiu":
            with np.errstate(all="ignore"):
                new = column.astype(float) * factor + offset
            table[name] = new if table[name].dtype != object else np.array([repr(float(x)) for x in new], dtype=object)


def _times(table: Table, rng: random.Random) -> None:
    """Stamps that run backwards, stand still, leap, or have the step of another column."""
    name = next(iter(table))
    column = numbers({name: table[name]})[name]
    if column.dtype == object or not len(column):
        return
    at = rng.randrange(len(column))
    later = np.arange(len(column)) >= at
    with np.errstate(all="ignore"):
        new = rng.choice(
            (
                column[::-1],
                np.full(len(column), column[0]),
                column + later * rng.choice((1e3, 1e6, 1e9, -1e3, -1e9, 1e17)),
                np.repeat(column[::2], 2)[: len(column)],
                column * rng.choice((1e-9, 1e3, 1e9)),
                column[0] + np.cumsum(np.abs(np.sin(np.arange(len(column))))),
            )
        )
    table[name] = new if table[name].dtype != object else np.array([repr(float(x)) for x in new], dtype=object)


def _rows(table: Table, rng: random.Random) -> None:
    """Shuffle rows, repeat them, or keep few; the same in all columns, or in all but the first."""
    n = min(map(len, table.values()))
    order = list(range(n))
    shuffled = rng.sample(order, n)
    kept = rng.choice(
        (shuffled, order[::-1], order[: rng.randint(1, 40)], order[: rng.randint(0, 3)], order[::2],
         order[: n // 2] * 2, sorted(order[:40] * 2), order[n // 3 : 2 * n // 3], sorted(shuffled[: max(1, n // 50)]))
    )  # fmt: skip
    index = np.array(kept, dtype=int)
    without_time = len(index) == n and rng.random() < 0.5
    for name in [*table][1:] if without_time else [*table]:
        table[name] = table[name][index]


def _columns(table: Table, rng: random.Random) -> None:
    """Drop, repeat, swap and rename columns, or leave the header out."""
    names = [*table]
    one, other = rng.choice(names), rng.choice(names)
    match rng.randrange(6):
        case 0:
            del table[one]
        case 1:
            table[one], table[other] = table[other], table[one]
        case 2:
            table[rng.choice((f"{one} ", f"{one}_2", one.upper()))] = table[other].copy()
        case 3:
            renamed = {(rng.choice(NAMES) if name == one else name): column for name, column in table.items()}
            _replace(table, renamed)
        case 4:
            head = {str(column[0]) if len(column) else name: column[1:] for name, column in table.items()}
            _replace(table, head)
        case _:
            _replace(table, {name: table[name] for name in rng.sample(names, len(names))})


def _replace(table: Table, new: Table) -> None:
    table.clear()
    table.update(new)


def _types(table: Table, rng: random.Random) -> None:
    """Give columns another type or shape."""
    for name in _some(table, rng):
        column = numbers({name: table[name]})[name]
        if column.dtype == object:
            continue
        with np.errstate(all="ignore"):
            table[name] = rng.choice(FORMS)(np.nan_to_num(column))


FORMS: tuple[Callable[[Any], Any], ...] = (
    lambda column: np.clip(column, -(2**62), 2**62).astype("i8"),
    lambda column: np.clip(column, 0, 255).astype("u1"),
    lambda column: np.clip(column, -3e38, 3e38).astype("f4"),
    lambda column: column.astype(">f8"),
    lambda column: column + 1j,
    lambda column: column > 0,
    lambda column: column.astype(str),
    lambda column: np.column_stack([column, column, column]),
    lambda column: np.column_stack([column, column])[:, :, np.newaxis],
    lambda column: column[:0],
    lambda column: column[: len(column) // 2],
    lambda column: np.clip(column, 0, 2**31).astype("i8").astype("M8[s]"),
)


# Files


def mutated_file(content: bytes, name: str, level: Level, rng: random.Random) -> bytes:
    """Return a changed file of any kind; its checksum is right where it had one, but for changed bytes."""
    if level == "bytes":
        return mutated_bytes(content, rng)
    try:
        return _rewritten(content, Path(name).suffix, level, rng)
    except (ValueError, TypeError, UnicodeError, yaml.YAMLError, pa.ArrowException, tomlkit.exceptions.TOMLKitError):
        return mutated_bytes(content, rng)  # what cannot be written anew


def _rewritten(content: bytes, ending: str, level: Level, rng: random.Random) -> bytes:
    if ending == ".parquet":
        return _mutated_parquet(content, level, rng)
    text = content.decode("utf-8")
    if ending == ".json":
        return _json(text, level, rng)
    if ending == ".csv":
        changed = csv_text(mutated_table(read_csv(text), level, rng))
    elif level == "structure" and ending in {".toml", ".yaml"}:
        changed = _written_tree(text, ending, rng)
    else:
        changed = mutated_text(text, rng)
    return changed.encode("utf-8", "surrogatepass")


def _mutated_parquet(content: bytes, level: Level, rng: random.Random) -> bytes:
    table = parquet.read_table(BytesIO(content))
    columns = {name: np.asarray(table[name].to_numpy()) for name in table.column_names}
    new = mutated_table(columns, level, rng, binary=True)
    whole, written = pa.table(new), BytesIO()
    parquet.write_table(whole.replace_schema_metadata(table.schema.metadata), written)
    return bytes(written.getvalue())


def _json(text: str, level: Level, rng: random.Random) -> bytes:
    changed = mutated_tree(json.loads(text), rng, TREE if level == "structure" else (_put, _scale, _spell))
    return json.dumps(sealed(changed), indent=1).encode("utf-8", "surrogatepass")


def sealed(content: Any) -> Any:
    """Return the content of a file with the checksum that belongs to it, if it has one."""
    if not isinstance(content, dict) or CHECKSUM not in content:
        return content
    rest = {name: value for name, value in content.items() if name != CHECKSUM}
    try:
        return rest | {CHECKSUM: checksum(rest)}
    except ValueError:  # a number that JSON does not have
        return content


def _written_tree(text: str, ending: str, rng: random.Random) -> str:
    if ending == ".yaml":
        return str(yaml.safe_dump(mutated_tree(yaml.safe_load(text), rng, TREE)))
    return str(tomlkit.dumps(_without_none(mutated_tree(tomllib.loads(text), rng, TREE))))


def _without_none(tree: Any) -> Any:
    if isinstance(tree, dict):
        return {str(key): _without_none(value) for key, value in tree.items() if value is not None}
    return [_without_none(one) for one in tree if one is not None] if isinstance(tree, list) else tree
