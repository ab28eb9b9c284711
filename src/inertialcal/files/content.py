"""Content of a file in any format that is read, by what its bytes say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .formats import recognise
from .source import Loaded
from .text.columns import Content
from .text.delimited import parse
from .text.encoding import decode


def parse_content(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of a loaded file.

    Parameters
    ----------
    loaded : Loaded
        The file.
    variables : sequence of str, optional
        Of a MATLAB, HDF5 or npz file, those to take; all of the longest clock by default.

    Raises
    ------
    DataError
        If the format is not read, or the content is damaged.
    """
    found = recognise(loaded.data, loaded.path)
    if found == "text":
        text, remarks = decode(loaded.data, loaded.path)
        content = parse(text, loaded.path)
        return replace(content, remarks=remarks + content.remarks)
    if found == "parquet":
        from .binary.parquet import read_parquet  # noqa: PLC0415 - heavy import

        return read_parquet(loaded)
    if found == "npy" or found == "npz":  # noqa: PLR1714 - narrows the type
        from .binary.numpy_file import read_numpy  # noqa: PLC0415 - only where wanted

        return read_numpy(loaded, found, variables)
    if found == "hdf5":
        from .binary.hdf5 import read_hdf5  # noqa: PLC0415 - heavy import

        return read_hdf5(loaded, variables)
    from .binary.matlab import read_matlab  # noqa: PLC0415 - heavy import

    return read_matlab(loaded, found, variables)
