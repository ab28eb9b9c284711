"""The archive: every test of every unit in one database, so that change over time can be judged.

SQLite by default, PostgreSQL by URL. What is archived of a campaign is one record: rows of tables that are made of its
``results.json``, and the files themselves by SHA-256. A record is added whole or not at all, and never changed: another
run of the same campaign is a new version that names the one that it replaces. Instants are int64 nanoseconds since 1970
UTC, for SQLite keeps no time zones.

Assumed: a unit is known by maker, part and serial; a campaign of it by its ``id``. Tests without a time are kept, and
stand in no history.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from ..core.errors import UsageError

if TYPE_CHECKING:
    from .archive import Archive

__all__ = ["open_archive"]


def open_archive(where: str | os.PathLike[str]) -> Archive:
    """Return an archive; nothing is read, or made, before it is needed.

    Parameters
    ----------
    where : str or path
        File of SQLite, or ``postgresql://USER@HOST/DATABASE``.

    Raises
    ------
    UsageError
        ``archive_url``; ``missing_package`` if SQLAlchemy, of the extra ``archive``, is not installed.
    """
    try:
        import sqlalchemy  # noqa: F401, PLC0415 - starts slowly
    except ModuleNotFoundError as error:
        do = "Type: pip install 'inertialcal[archive]'"
        raise UsageError(f"the archive needs {error.name}", do=do, code="missing_package") from None
    from .archive import Archive as Opened  # noqa: PLC0415

    return Opened(where)
