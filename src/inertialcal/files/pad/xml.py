"""XML of an archive header as elements, without document types: no entity is declared, expanded or fetched."""

from __future__ import annotations

import xml.etree.ElementTree as ET  # document types are refused before this one reads
from pathlib import Path
from xml.parsers import expat

from ...core.errors import DataError

LARGEST = 2**16  # bytes; headers of the archive have 700 to 1500


def read_xml(path: Path) -> ET.Element:
    """Return the root of a header.

    Raises
    ------
    DataError
        ``bad_header``, if it is larger than 64 KiB, no XML, or declares a document type or an entity;
        ``missing_file``, if it cannot be read.
    """
    where = str(path)
    try:
        with path.open("rb") as stream:
            data = stream.read(LARGEST + 1)
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}", where=where, code="missing_file") from None
    if len(data) > LARGEST:
        raise bad_header(where, f"the header has more than {LARGEST} bytes, those of the archive about 1000")
    try:
        _refuse_document_type(data, where)
        return ET.fromstring(data)  # noqa: S314 - declares no document type
    except (expat.ExpatError, ET.ParseError, ValueError, LookupError) as error:  # the last two: encodings
        raise bad_header(where, f"the header is no XML: {error}") from None


def bad_header(where: str, what: str) -> DataError:
    """Return the error for a header that cannot be used."""
    return DataError(what, where=where, do="Fetch it again from the archive", code="bad_header")


def _refuse_document_type(data: bytes, where: str) -> None:
    def refuse(*_: object) -> None:
        raise DataError(
            "the header declares a document type",
            where=where,
            why="entities could fill the memory or fetch other files; no header of the archive has one",
            do="Fetch it again from the archive",
            code="bad_header",
        )

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    parser.Parse(data, True)
