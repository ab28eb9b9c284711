"""Errors of other people's readers, in our words: a damaged file shows as many kinds of exception."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from ..core.errors import DataError, InertialcalError

LONGEST = 160  # characters of their message


@contextmanager
def as_data_errors(where: str, what: str) -> Iterator[None]:
    """Turn any error of a foreign reader into a DataError; its warnings are not shown.

    Parameters
    ----------
    where : str
        File.
    what : str
        What the file is meant to be: ``"a Parquet file"``.

    Raises
    ------
    DataError
        With code ``damaged_file``.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InertialcalError:
        raise
    except Exception as error:
        said = " ".join(str(error).split())[:LONGEST] or type(error).__name__
        raise DataError(
            f"cannot be read as {what}: {said}",
            where=where,
            do="Copy it again from its source, or export it as text",
            code="damaged_file",
        ) from None
