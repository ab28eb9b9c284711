"""SQLite databases, opened to be read: nothing is ever written, and one that was cut off is read as far as it goes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..budget import claim
from ..source import Loaded

if TYPE_CHECKING:
    from sqlite3 import Connection

SQLITE = b"SQLite format 3\x00"
HEAD = 100  # bytes of the header of the file (sqlite.org/fileformat2.html, 1.3)


def is_bag_2(data: bytes, path: str) -> bool:
    """Whether an SQLite database is a bag of ROS 2."""
    return data.startswith(SQLITE) and b"serialization_format" in data[: 2**16]


def missing_bytes(data: bytes) -> int:
    """Return how many bytes of a database are not there, by what its header says."""
    head = data[:HEAD]
    page, pages = int.from_bytes(head[16:18], "big"), int.from_bytes(head[28:32], "big")
    return max((65536 if page == 1 else page) * pages - len(data), 0)


def whole_pages(loaded: Loaded) -> Loaded:
    """Return a database without the page that was cut through, which SQLite would fill up with zeros."""
    page = int.from_bytes(loaded.data[16:18], "big")
    page = 65536 if page == 1 else page
    size = len(loaded.data)
    if not missing_bytes(loaded.data) or not page or not size % page:
        return loaded
    claim(loaded.path, loaded.on_disk, 2 * size, "a database that was cut off")
    return replace(loaded, data=loaded.data[: size - size % page])


def opened(path: str, loaded: Loaded) -> Connection:
    """Return a connection that only reads.

    Parameters
    ----------
    path : str
        Where the content lies.
    loaded : Loaded
        The content.
    """
    import sqlite3  # noqa: PLC0415 - loaded where it is needed

    address = path.replace("%", "%25").replace("?", "%3f").replace("#", "%23")
    connection = sqlite3.connect(f"file:{address}?mode=ro&immutable=1", uri=True)
    connection.text_factory = lambda text: text.decode("utf-8", "replace")
    if missing_bytes(loaded.data):
        connection.execute("PRAGMA writable_schema=ON")  # else SQLite refuses one of another size than it says
    return connection
