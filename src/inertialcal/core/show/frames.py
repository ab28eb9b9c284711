"""Tables for pandas users; pandas is an extra, so that the core installs without it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..errors import UsageError
from ..results import COLUMNS, Row

if TYPE_CHECKING:
    from pandas import DataFrame


def frame(columns: Mapping[str, object], index: Sequence[str] | None = None) -> DataFrame:
    """Return a pandas DataFrame of the columns.

    Raises
    ------
    UsageError
        If pandas is not installed.
    """
    try:
        import pandas as pd  # noqa: PLC0415 - an extra
    except ModuleNotFoundError:
        raise UsageError(
            "to_frame() needs pandas, which is not installed", do="Type: pip install 'inertialcal[frame]'"
        ) from None
    return pd.DataFrame(dict(columns), index=None if index is None else list(index))


def frame_of_rows(rows: Sequence[Row]) -> DataFrame:
    """Return a pandas DataFrame, a row a figure; errors as `frame`."""
    flat = [row.flat() for row in rows]
    return frame({name: [one[name] for one in flat] for name in COLUMNS})
