"""Tables for pandas users; pandas is an extra, so that the core installs without it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .errors import UsageError


def frame(columns: Mapping[str, Any], index: Sequence[str] | None = None) -> Any:
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
