"""Folders of ROS 2 bags: ``metadata.yaml`` and the files of one recording, one after the other.

A recorder that was killed leaves no ``metadata.yaml``; such a folder is known by what it holds, files of bags and
nothing else.
"""

from __future__ import annotations

import hashlib
import re
import shlex
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from ...core.errors import DataError
from ...core.recording import Recording, Source
from ..assemble import assemble
from ..reader import ArchiveReader, Request, wrong_frame
from ..source import as_data_errors, load, settled
from ..time.window import cut
from .bags import Bag, Messages, bag_in_sqlite, bag_of, content_of
from .database import whole_pages
from .topics import on_disk

ABOUT = "metadata.yaml"
ENDINGS = (".db3", ".mcap")
PACKED = (".db3.zstd", ".mcap.zstd")
ASIDE = (".db3-wal", ".db3-shm", ".db3-journal")


def read_folder(path: str | Path, request: Request) -> Recording | None:
    """Return the recording in a folder of a ROS 2 bag; None where the path is no such folder.

    Raises
    ------
    DataError
        As ``bags.read_bag``, and as ``files.read``.
    """
    files = _files(Path(path))
    if not files:
        return None
    if request.frame is not None:
        raise wrong_frame(path)
    digest = hashlib.sha256()
    with ExitStack() as opened, as_data_errors(str(path), "a ROS 2 bag"):
        bags, held = [], []
        for file in files:
            loaded = load(file, in_place=True)
            held.append(loaded)
            place = opened.enter_context(on_disk(whole_pages(loaded), ".db3")) if file.suffix == ".db3" else ""
            bags.append(bag_in_sqlite(place, loaded) if place else bag_of(loaded))
        content = content_of(_joined(bags, str(path)), list(request.topics or ()) or None)
        for loaded in held:
            settled(loaded)
            digest.update(bytes.fromhex(loaded.sha256))
    source = Source(str(path), digest.hexdigest(), content.format, "rosbag2")
    recording = assemble(
        content, source, units=request.units, sample_rate=request.sample_rate, time_column=request.time_column,
        required=request.required,
    )  # fmt: skip
    return cut(recording, request.window)


def _files(folder: Path) -> list[Path]:
    """Return the files of a bag in the order in which they were written; none where the folder is none."""
    try:
        inside = [one for one in folder.iterdir() if not one.name.startswith(".")] if folder.is_dir() else []
    except OSError:
        return []
    found = [one for one in inside if one.suffix in ENDINGS]
    packed = [one.name for one in inside if one.name.endswith(PACKED)]
    if packed and not found:
        what, why = f"the files of this bag are packed as a whole: {packed[0]}", "they are read unpacked"
        do = f"Unpack them: zstd -d {shlex.quote(str(folder / packed[0]))}"
        raise DataError(what, where=str(folder), why=why, do=do, code="unsupported_format")
    others = [one for one in inside if one not in found and one.name != ABOUT and not one.name.endswith(ASIDE)]
    if not found or (others and not any(one.name == ABOUT for one in inside)):
        return []
    return sorted(
        found, key=lambda one: [int(part) if part.isdigit() else part for part in re.split("([0-9]+)", one.name)]
    )


def _joined(bags: Sequence[Bag], path: str) -> Bag:
    """Return the bags of one recording as one; connections are known by file and number."""
    if len({one.title for one in bags}) > 1:
        raise DataError(
            "a folder with bags of two formats", where=path, do="Name one of its files", code="several_topics"
        )

    def scan(bag: Bag) -> Iterator[Messages]:
        for number, one in enumerate(bags):
            seen: set[int] = set()
            for part in one.messages():
                for key in one.connections.keys() - seen:
                    bag.connections[number + len(bags) * key] = one.connections[key]
                    seen.add(key)
                yield replace(part, keys=number + len(bags) * part.keys)
            bag.remarks += one.remarks
            for key, connection in one.connections.items():
                bag.connections.setdefault(number + len(bags) * key, connection)

    return Bag(scan, bags[0].title, path, sum(one.size for one in bags))


READER = ArchiveReader("rosbag2_folder", "", read_folder)
