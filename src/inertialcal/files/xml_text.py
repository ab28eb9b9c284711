"""XML of unknown origin: no document type and no entity is read, so that none fills the memory or fetches a file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from xml.parsers import expat


class DocumentTypeError(ValueError):
    """The text declares a document type or an entity."""


def xml_root(data: bytes) -> ET.Element:
    """Return the root element of a text.

    Raises
    ------
    DocumentTypeError
        If it declares a document type or an entity.
    ValueError
        If it is no XML.
    """

    def refuse(*_: object) -> None:
        raise DocumentTypeError("it declares a document type")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    try:
        parser.Parse(data, True)
        return ET.fromstring(data)  # noqa: S314 - declares no document type
    except DocumentTypeError:
        raise
    except (expat.ExpatError, ET.ParseError, ValueError, LookupError) as error:  # the last two: encodings
        raise ValueError(f"not XML: {error}") from None
