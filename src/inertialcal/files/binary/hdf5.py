"""HDF5 files, among them MATLAB 7.3: datasets and groups of datasets.

MATLAB writes its matrices transposed; here the longest dimension is time in any case.

The HDF5 library crashes on some damaged files and never returns from others. So a process of its own reads the file
(`main`), as ``files.apart`` has it, and writes the arrays to its standard output. Of a long file that stays in place
nothing is held whole, neither there nor here.

A dataset may keep its values in other files: in raw ones (external storage), in other HDF5 files (virtual), or be
a link to one. None of them is read: a file could else bring any file of the machine into the output.
"""

from __future__ import annotations

import io
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import prod
from typing import IO, Any, NoReturn, cast

import numpy as np
from numpy.typing import NDArray

from ...core.batches import empty, is_long, release
from ...core.errors import DataError, InertialcalError
from ..apart import crashed, is_possible, limit_memory, limit_time, process_of
from ..budget import PARTS, PROCESS, READ, VALUE, ceiling, check_count, claim, claim_room
from ..columns import Content
from ..reader import Reader
from ..source import FileBytes, Loaded, as_data_errors
from .arrays import AT_ONCE, NamedArray, columns_of, received

MAGIC = b"\x89HDF\r\n\x1a\n"
MAGIC_AT = (0, 512, 1024, 2048)  # a user block may stand first (HDF5 file format, II.A)
DEEPEST = 8  # groups within groups
OWN = "#"  # MATLAB keeps its own tables under #refs# and #subsystem#
WHAT = "an HDF5 (MATLAB 7.3) file"
SECONDS, PER_SECOND = 3, 2e7  # of computing for any file, and bytes that one more must bring; 1e8 and more are usual
Found = list[tuple[str, NamedArray | None]]  # None: no array of numbers


def read_hdf5(loaded: Loaded, variables: Sequence[str] | None = None) -> Content:
    """Return the columns of the datasets of one length.

    Raises
    ------
    DataError
        ``damaged_file``; ``too_large``, ``too_many`` beyond the limits of ``files.budget``; ``external_storage``;
        ``missing_filter``.
    """
    found, is_matlab = _apart(loaded) if is_possible() else _here(loaded)
    arrays = [array for _, array in found if array is not None]
    skipped = [name for name, array in found if array is None]
    kind = "MATLAB 7.3 (HDF5)" if is_matlab else "HDF5"
    return columns_of(arrays, kind, loaded.path, variables=variables, skipped=skipped)


def _apart(loaded: Loaded) -> tuple[Found, bool]:
    """Return what a process of its own reads."""
    in_place = isinstance(loaded.data, FileBytes)
    words = [loaded.path, str(loaded.on_disk), str(0 if in_place else len(loaded.data))]
    with process_of(__name__, words, loaded) as (pieces, process):
        try:
            content = pieces.said()
            known = [(name, kind and np.dtype(kind), shape, unit) for name, kind, shape, unit in content["found"]]
            stored = in_place and is_long(sum(prod(shape) * kind.itemsize for _, kind, shape, _ in known if kind))
            found: Found = []
            for name, kind, shape, unit in known:
                array = None if kind is None else received(cast("IO[bytes]", pieces), kind, shape, stored)
                found.append((name, None if array is None else NamedArray(name, array, unit)))
            pieces.said()
            if process.wait():
                raise EOFError
            return found, content["is_matlab"]
        except EOFError:
            raise crashed(process.wait(), loaded.path, WHAT, "HDF5") from None


def main() -> NoReturn:
    """Read a file from standard input in a process of its own: path, bytes on disk and bytes of content are given."""
    path, on_disk, size = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    import h5py  # noqa: F401, PLC0415 - before the limit: libraries take much address space, and use little of it

    limit_memory(max(ceiling(on_disk) - PROCESS, 0))
    _limit_time(on_disk + size)
    out = sys.stdout.buffer

    def say(content: object) -> None:
        out.write(json.dumps(content).encode() + b"\n")

    try:
        data = sys.stdin.buffer.read(size) if size else None
        with _opened(data, path, on_disk, _limit_time) as (found, is_matlab):
            said = [
                (name, *((None, (), None) if one is None else (one.kind.str, one.shape, one.unit)))
                for name, one in found
            ]
            say({"found": said, "is_matlab": is_matlab})
            for piece in (piece for _, one in found if one is not None for piece in one.pieces()):
                say({"bytes": piece.nbytes})
                out.write(piece.reshape(-1).view(np.uint8).data)
            say({})
    except InertialcalError as error:
        say({"refused": [one.to_dict() for one in error.problems]})
    out.flush()
    os._exit(0)  # the library need not take apart what is damaged


def _limit_time(size: int) -> None:
    """Limit the computing time of this process to that of so many bytes, where the system can."""
    limit_time(SECONDS + int(size / PER_SECOND))


def _here(loaded: Loaded) -> tuple[Found, bool]:
    """Return what this process reads, as `_apart`."""
    in_place = isinstance(loaded.data, FileBytes)
    arrays: Found = []
    with _opened(None if in_place else loaded.data, loaded.path, loaded.on_disk) as (found, is_matlab):
        stored = in_place and is_long(sum(prod(one.shape) * one.kind.itemsize for _, one in found if one is not None))
        for name, one in found:
            if one is None:
                arrays.append((name, None))
                continue
            values, at = empty(prod(one.shape), one.kind, stored), 0
            for piece in one.pieces():
                values[at : at + piece.size] = piece.reshape(-1)
                release(values[at : at + piece.size])
                at += piece.size
            arrays.append((name, NamedArray(name, values.reshape(one.shape), one.unit)))
    return arrays, is_matlab


@dataclass(frozen=True, eq=False)
class _Stored:
    """A dataset, or a field of its records, that is read piece by piece."""

    dataset: Any
    field: str | None
    kind: np.dtype[Any]
    shape: tuple[int, ...]
    unit: str | None

    def pieces(self) -> Iterator[NDArray[Any]]:
        """Yield its values in order of storage; as few chunks as can be are unpacked twice."""
        shape, axis, size = self.dataset.shape, 0, self.dataset.dtype.itemsize
        while axis < len(shape) - 1 and prod(shape[axis + 1 :]) * size > AT_ONCE:
            axis += 1
        width = max(prod(shape[axis + 1 :]) * size, 1)
        step = max(AT_ONCE // width, 1)
        if self.dataset.chunks:
            chunk = self.dataset.chunks[axis]
            step = step - step % chunk if step >= chunk else chunk if chunk * width <= 4 * AT_ONCE else step
        for lead in np.ndindex(*shape[:axis]):
            for first in range(0, shape[axis], step) if shape else (0,):
                values = np.asarray(self.dataset[(*lead, slice(first, first + step)) if shape else ()])
                values = values if self.field is None else values[self.field]
                if values.nbytes:
                    yield np.ascontiguousarray(values)


@contextmanager
def _opened(
    data: bytes | None, path: str, on_disk: int, allow: Callable[[int], None] = lambda size: None
) -> Iterator[tuple[list[tuple[str, _Stored | None]], bool]]:
    """Open a file's content, or the file itself; give its arrays, and whether it is MATLAB's.

    ``allow`` gets the bytes to be worked through.
    """
    import h5py  # noqa: PLC0415 - heavy import

    held = 0 if data is None else len(data)
    with (
        as_data_errors(path, WHAT),
        open(path, "rb") if data is None else io.BytesIO(data) as stream,
        h5py.File(stream, "r") as file,
    ):
        datasets = list(_datasets(file, path, [0], set()))
        used = [dataset for _, dataset in datasets if dataset is not None]
        whole = sum(dataset.size * dataset.dtype.itemsize for dataset in used)
        rows = max((max(dataset.shape, default=0) for dataset in used), default=0)
        per_column, other = READ
        what = f"{sum(dataset.size for dataset in used):,} values"
        if data is None:
            claim_room(path, on_disk, 2 * whole, what)
        else:
            claim(path, on_disk, 2 * held + per_column * whole + VALUE * other * rows, what)
        for name, dataset in datasets:
            if dataset is not None:
                _check_storage(name, dataset, path, on_disk, held)
        is_matlab = any("MATLAB_class" in dataset.attrs for dataset in used)
        found: list[tuple[str, _Stored | None]] = []
        for name, dataset in datasets:
            found += [(name, None)] if dataset is None else _arrays(name, dataset)
        check_count(len(found), PARTS, "datasets and fields", path)
        read = sum(one.dataset.size * one.dataset.dtype.itemsize for _, one in found if one is not None)
        allow(on_disk + held + 2 * read)
        yield found, is_matlab


def _datasets(
    group: Any, path: str, count: list[int], visited: set[Any], prefix: str = ""
) -> Iterator[tuple[str, Any]]:
    """Each dataset of numbers with its full name; None for other things. A group is visited once."""
    import h5py  # noqa: PLC0415 - heavy import

    visited.add(h5py.h5o.get_info(group.id).addr)
    count[0] += len(group)
    check_count(count[0], PARTS, "groups and datasets", path)
    for key in group:
        name = f"{prefix}{key}"
        if key.startswith(OWN):
            continue
        link = group.get(key, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            raise _elsewhere(name, f"a link to {link.filename}", path)
        item = group[key] if isinstance(link, h5py.HardLink) else None
        if isinstance(item, h5py.Group) and prefix.count(".") < DEEPEST:
            if h5py.h5o.get_info(item.id).addr not in visited:
                yield from _datasets(item, path, count, visited, f"{name}.")
        elif isinstance(item, h5py.Dataset) and _is_numbers(item):
            yield name, item
        else:
            yield name, None


def _check_storage(name: str, dataset: Any, path: str, on_disk: int, held: int) -> None:
    """Refuse a dataset whose values lie in other files, or are packed by what is not there."""
    import h5py  # noqa: PLC0415 - heavy import

    if dataset.external:
        raise _elsewhere(name, f"external storage in {dataset.external[0][0]}", path)
    if dataset.is_virtual:
        raise _elsewhere(name, f"virtual: a view of {dataset.virtual_sources()[0].file_name}", path)
    if dataset.chunks:
        claim(path, on_disk, 2 * held + 2 * prod(dataset.chunks) * dataset.dtype.itemsize, f"chunks of {name!r}")
    packing = dataset.id.get_create_plist()
    for i in range(packing.get_nfilters()):
        number, _, _, label = packing.get_filter(i)
        if not h5py.h5z.filter_avail(number):
            said = f" ({label.decode('utf-8', 'replace')[:40]})" if label else ""
            raise DataError(
                f"{name!r} is packed by filter {number}{said}, which is not part of HDF5",
                where=path,
                do="Unpack it first: h5repack -f NONE FILE NEW.h5",
                code="missing_filter",
            )


def _elsewhere(name: str, what: str, path: str) -> DataError:
    """Return the error for values that lie in another file."""
    return DataError(
        f"{name!r} is {what[:200]}: its values are not in this file",
        where=path,
        why="other files are never read through a recording: any file of this machine could be named",
        do="Copy the values into one file, for example with h5py: new[name] = old[name][()]",
        code="external_storage",
    )


def _is_numbers(dataset: Any) -> bool:
    """Whether a dataset is an array of numbers, or of records of numbers; MATLAB's text is none."""
    if dataset.shape is None or _text(dataset.attrs.get("MATLAB_class")) in ("char", "cell"):
        return False
    if "MATLAB_empty" in dataset.attrs:
        return False
    names = dataset.dtype.names
    kinds = [dataset.dtype[name].base.kind for name in names] if names else [dataset.dtype.kind]
    return any(kind in "biuf" for kind in kinds)


def _arrays(name: str, dataset: Any) -> list[tuple[str, _Stored | None]]:
    """Return the dataset as an array, or as one for each field of its records."""
    kind, shape = dataset.dtype, dataset.shape
    said = {key.lower(): key for key in dataset.attrs if key.lower() in ("units", "unit")}
    unit = _text(dataset.attrs[min(said.values())]) if said else None
    if kind.names is None:
        return [(name, _Stored(dataset, None, kind, shape, unit))]
    found: list[tuple[str, _Stored | None]] = []
    for field in kind.names:
        base, inner = kind[field].subdtype or (kind[field], ())  # three axes in a field
        stored = _Stored(dataset, field, base, shape + inner, None) if base.kind in "biuf" else None
        found.append((f"{name}.{field}", stored))
    return found


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
    in_place=True,
)

if __name__ == "__main__":
    main()
