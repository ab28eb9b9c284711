"""MATLAB files of versions 4 to 7, by scipy: matrices and structures of matrices.

Version 7.3 is HDF5; an ASCII ``.mat`` is text.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..columns import Content
from ..formats import ZIP
from ..reader import Reader
from ..reader_errors import as_data_errors
from ..source import Loaded
from .arrays import NamedArray, columns_of
from .mat5_elements import check_elements

MAGIC = b"MATLAB 5.0 MAT-file"
NEWER = "5 to 7"  # versions
DEEPEST = 8  # structures within structures


def read_matlab4(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the matrices of one length, of a file of version 4; Raises as `read_matlab5`."""
    return _read(loaded, "4", variables)


def read_matlab5(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the matrices of one length, of a file of version 5 to 7.

    Raises
    ------
    DataError
        If it is damaged, or larger than the limits of ``files.source``.
    """
    return _read(loaded, NEWER, variables)


def _read(loaded: Loaded, version: str, variables: Sequence[str] | None) -> Content:
    from scipy import io as scipy_io  # noqa: PLC0415 - heavy import

    with as_data_errors(loaded.path, f"a MATLAB file of version {version}"):
        if version == NEWER:
            check_elements(loaded.data, loaded.path)
        # mat_dtype: doubles that MATLAB packed as bytes come back as doubles; counts stay whole numbers. It
        # also drops imaginary parts, with no more than a warning: then the types as stored tell which.
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found = _variables(scipy_io.loadmat(io.BytesIO(loaded.data), mat_dtype=True))
        if any(issubclass(warning.category, np.exceptions.ComplexWarning) for warning in caught):
            stored = _variables(scipy_io.loadmat(io.BytesIO(loaded.data)))
            found = {name: None if stored.get(name) is None else value for name, value in found.items()}
    arrays = [NamedArray(name, value) for name, value in found.items() if value is not None]
    skipped = [name for name, value in found.items() if value is None]
    return columns_of(arrays, f"MATLAB {version}", loaded.path, variables=variables, skipped=skipped)


def _variables(content: dict[str, Any]) -> dict[str, Any]:
    """Each matrix by its full name; None for what is none."""
    return {key: item for name, value in content.items() if name[:2] != "__" for key, item in _flat(name, value)}


def _flat(name: str, value: Any, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Each matrix with its full name; None for what is none (complex, text, cells, sparse, arrays of structures)."""
    if not isinstance(value, np.ndarray):
        yield name, None
    elif value.dtype.names is not None and value.size == 1 and depth < DEEPEST:
        for field in value.dtype.names:
            yield from _flat(f"{name}.{field}", value.reshape(-1)[0][field], depth + 1)
    else:
        yield name, value if value.dtype.kind in "biuf" else None


def _is_version_4(data: bytes, path: str) -> bool:
    """Whether a file starts with five binary integers; an ASCII one has no nul."""
    return path.lower().endswith(".mat") and b"\x00" in data[:20] and not data.startswith(ZIP)


def _is_version_5(data: bytes, path: str) -> bool:
    return data.startswith(MAGIC)


VERSION_4 = Reader("mat4", "MATLAB", (".mat",), _is_version_4, read_matlab4)
VERSION_5 = Reader("mat5", "MATLAB", (".mat",), _is_version_5, read_matlab5)
