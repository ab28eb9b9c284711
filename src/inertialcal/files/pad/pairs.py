"""Pairs of data file and header that a path means: either member, or a folder of the archive.

A path is such a pair if its name has the archive's form, if it is a header (by its ending, or by its bytes: XML whose
root is named after an acceleration system), or if a header lies beside it. In a folder all pairs count; where it
holds none, the folders of the archive's tree below it (``year2014/month10/day22/sams2_accel_121f03``) are gone through.
"""

from __future__ import annotations

import re
from pathlib import Path

from ...core.errors import DataError
from .name import HEADER, Pair, parse_name

ROOT = re.compile(rb"\s*(?:<\?xml[^>]*>)?\s*<(?:\w+_accel|iss_rad)[\w.-]*[\s>]")
START = 512  # bytes of a file in which the root stands
TREE = re.compile(r"year\d{4}|month\d{2}|day\d{2}|(?:\w+_accel|iss_rad)_\w+", re.ASCII)
NAMED = re.compile(rb'<GData[^>]*\bfile\s*=\s*"([^"/\\]+)"')


def pairs_of(path: str | Path) -> tuple[Pair, ...]:
    """Return the pairs that a path means; none where it is no acceleration file of the archive.

    Raises
    ------
    DataError
        ``missing_header`` or ``missing_data``, if one member of a pair is not there.
    """
    given = Path(path)
    try:
        if given.is_dir():
            return tuple(_whole(pair, str(path)) for pair in _in_folder(given))
        pair = _pair(given)
    except (OSError, ValueError):  # ValueError: a nul in the name; the reader of bytes says it
        return ()
    return () if pair is None else (_whole(pair, str(path)),)


def _in_folder(folder: Path) -> list[Pair]:
    """Pairs of a folder, else of those below it that the archive's tree has."""
    inside = sorted(folder.iterdir())
    names = {path.name for path in inside}
    data = {
        path.name.removesuffix(HEADER)
        for path in inside
        if not path.name.startswith(".") and path.is_file() and _belongs(path.name, names)
    }
    if data:
        return [Pair(folder / name, folder / (name + HEADER)) for name in sorted(data)]
    below = [path for path in inside if path.is_dir() and TREE.fullmatch(path.name)]
    return [pair for path in below for pair in _in_folder(path)]


def _belongs(name: str, names: set[str]) -> bool:
    return parse_name(name) is not None or (name.endswith(HEADER) and name.removesuffix(HEADER) in names)


def _pair(path: Path) -> Pair | None:
    if path.name.endswith(HEADER):
        data = path.with_name(path.name.removesuffix(HEADER))
        return Pair(data, path) if data.exists() or parse_name(path.name) or _has_root(path) else None
    if parse_name(path.name) or path.with_name(path.name + HEADER).is_file():
        return Pair(path, path.with_name(path.name + HEADER))
    if not path.is_file() or not _has_root(path):
        return None
    named = NAMED.search(path.read_bytes()[: 2**16])  # a header by another name says where its data lie
    return Pair(path.with_name(named[1].decode("ascii", "replace")), path) if named else None


def _has_root(path: Path) -> bool:
    with path.open("rb") as stream:
        return ROOT.match(stream.read(START)) is not None


def _whole(pair: Pair, given: str) -> Pair:
    """Refuse a pair that lacks a member."""
    if not pair.data.is_file() and not pair.header.is_file():
        raise DataError("no such file", where=given, do="Check the name and the folder", code="missing_file")
    if not pair.header.is_file():
        raise DataError(
            f"no header beside it: {pair.header.name} is missing",
            where=str(pair.data),
            why="it says when the record starts, how fast it was sampled, and how its bytes are laid out",
            do="Fetch both files of the pair from the archive",
            code="missing_header",
        )
    if not pair.data.is_file():
        raise DataError(
            f"no data beside this header: {pair.data.name} is missing",
            where=str(pair.header),
            do="Fetch both files of the pair from the archive",
            code="missing_data",
        )
    return pair
