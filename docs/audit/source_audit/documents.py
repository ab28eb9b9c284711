"""The documents that are audited, in order of their year."""

from __future__ import annotations

from collections.abc import Callable

from . import npsat2011, reinel1969, sams1996
from .figures import Document

DOCUMENTS: tuple[Callable[[], Document], ...] = (reinel1969.document, sams1996.document, npsat2011.document)
