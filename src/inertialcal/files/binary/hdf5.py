"""HDF5 files, among them MATLAB 7.3: datasets and groups of datasets.

MATLAB writes its matrices transposed; here the longest dimension is time in any case. Links that lead out of
the file are not followed.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..columns import Content
from ..reader import Reader
from ..source import LARGEST, Loaded, as_data_errors, too_large
from .arrays import NamedArray, columns_of

MAGIC = b"\x89HDF\r\n\x1a\n"
MAGIC_AT = (0, 512, 1024, 2048)  # a user block may stand first (HDF5 file format, II.A)
DEEPEST = 8  # groups within groups
MOST = 10_000  # objects looked at
OWN = "#"  # MATLAB keeps its own tables under #refs# and #subsystem#


def read_hdf5(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the datasets of one length.

    Raises
    ------
    DataError
        If it is damaged, or larger than the limits of ``files.source``.
    """
    import h5py  # noqa: PLC0415 - heavy import

    with as_data_errors(loaded.path, "an HDF5 (MATLAB 7.3) file"), h5py.File(io.BytesIO(loaded.data), "r") as file:
        found: list[tuple[str, NamedArray | None]] = []
        size = 0
        is_matlab = False
        for name, dataset in _datasets(file, h5py):
            is_matlab |= dataset is not None and "MATLAB_class" in dataset.attrs
            size += 0 if dataset is None else dataset.size * dataset.dtype.itemsize
            if size > LARGEST:
                raise too_large(loaded.path, size)
            found += [(name, None)] if dataset is None else _arrays(name, dataset)
            if len(found) > MOST:
                break
    arrays = [array for _, array in found if array is not None]
    skipped = [name for name, array in found if array is None]
    kind = "MATLAB 7.3 (HDF5)" if is_matlab else "HDF5"
    return columns_of(arrays, kind, loaded.path, variables=variables, skipped=skipped)


def _datasets(group: Any, h5py: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Each dataset of numbers with its full name; None for other things."""
    for key in group:
        name = f"{prefix}{key}"
        if key.startswith(OWN):
            continue
        item = group[key] if group.get(key, getlink=True).__class__ is h5py.HardLink else None
        if isinstance(item, h5py.Group) and depth < DEEPEST:
            yield from _datasets(item, h5py, f"{name}.", depth + 1)
        elif isinstance(item, h5py.Dataset) and _is_numbers(item):
            yield name, item
        else:
            yield name, None


def _is_numbers(dataset: Any) -> bool:
    """Whether a dataset is an array of numbers, or of records of numbers; MATLAB's text is none."""
    if dataset.shape is None or _text(dataset.attrs.get("MATLAB_class")) in ("char", "cell"):
        return False
    if "MATLAB_empty" in dataset.attrs:
        return False
    names = dataset.dtype.names
    kinds = [dataset.dtype[name].kind for name in names] if names else [dataset.dtype.kind]
    return any(kind in "biuf" for kind in kinds)


def _arrays(name: str, dataset: Any) -> list[tuple[str, NamedArray | None]]:
    """Return the dataset as an array, or as one for each field of its records."""
    values = np.asarray(dataset[()])
    unit = _text(dataset.attrs.get("units", dataset.attrs.get("unit")))
    if values.dtype.names is None:
        return [(name, NamedArray(name, values, unit))]
    return [
        (f"{name}.{field}", NamedArray(f"{name}.{field}", values[field]) if kind in "biuf" else None)
        for field in values.dtype.names
        for kind in (values.dtype[field].kind,)
    ]


def _text(attribute: Any) -> str | None:
    """Attribute as text; None where it is none."""
    if isinstance(attribute, bytes):
        return attribute.decode("utf-8", "replace")
    return attribute if isinstance(attribute, str) else None


READER = Reader(
    "hdf5",
    "HDF5",
    (".h5", ".hdf5", ".mat"),
    lambda data, path: any(data[at : at + len(MAGIC)] == MAGIC for at in MAGIC_AT),
    read_hdf5,
)
