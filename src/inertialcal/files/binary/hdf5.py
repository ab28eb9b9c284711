"""HDF5 files, among them MATLAB 7.3: datasets and groups of datasets.

MATLAB writes its matrices transposed; here the longest dimension is time in any case.

The HDF5 library crashes on some damaged files and never returns from others. So a process of its own reads the file
(`main`), with a limit of memory and of computing time, and writes the arrays to its standard output: a line of JSON,
then their bytes one after the other.

A dataset may keep its values in other files: in raw ones (external storage), in other HDF5 files (virtual), or be
a link to one. None of them is read: a file could else bring any file of the machine into the output.
"""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from math import prod
from typing import IO, Any, NoReturn, cast

import numpy as np

from ...core.errors import DataError, InertialcalError, Problem
from ..budget import ENVIRONMENT, PARTS, PROCESS, READ, VALUE, ceiling, check_count, claim
from ..columns import Content
from ..reader import Reader
from ..source import Loaded, as_data_errors
from .arrays import NamedArray, columns_of

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
    apart = sys.executable and not getattr(sys, "frozen", False)
    found, is_matlab = _apart(loaded) if apart else _here(loaded.data, loaded.path, loaded.on_disk)
    arrays = [array for _, array in found if array is not None]
    skipped = [name for name, array in found if array is None]
    kind = "MATLAB 7.3 (HDF5)" if is_matlab else "HDF5"
    return columns_of(arrays, kind, loaded.path, variables=variables, skipped=skipped)


def _apart(loaded: Loaded) -> tuple[Found, bool]:
    """Return what a process of its own reads."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PYTHONSAFEPATH": "1"}
    environment |= {ENVIRONMENT: str(ceiling(loaded.on_disk)), "OPENBLAS_NUM_THREADS": "1", "PYTHONIOENCODING": "utf-8"}
    command = [sys.executable, "-m", __name__, loaded.path, str(loaded.on_disk), str(len(loaded.data))]
    pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=nowhere, env=environment) as process:  # noqa: S603
        given, answer = cast("IO[bytes]", process.stdin), cast("IO[bytes]", process.stdout)
        try:
            with suppress(BrokenPipeError):
                given.write(loaded.data)
                given.close()
            said = answer.readline()
            content = json.loads(said) if said.endswith(b"\n") else {}
            if "refused" in content:
                raise DataError([Problem(**one) for one in content["refused"]])
            found: Found = []
            for name, kind, shape, unit in content.get("found", ()):
                array = None if kind is None else _received(answer, np.dtype(kind), shape)
                found.append((name, None if array is None else NamedArray(name, array, unit)))
            if process.wait() or "found" not in content:
                raise _crashed(process.returncode, loaded.path)
            return found, content["is_matlab"]
        except EOFError:
            raise _crashed(process.wait(), loaded.path) from None
        finally:
            process.kill()


def _received(stream: IO[bytes], kind: np.dtype[Any], shape: Sequence[int]) -> Any:
    array = np.empty(shape, kind)
    if array.nbytes:
        view = array.reshape(-1).view(np.uint8).data
        done = 0
        while done < len(view):
            got = stream.readinto(view[done:])  # type: ignore[attr-defined]
            if not got:
                raise EOFError
            done += got
    return array


def _crashed(status: int, path: str) -> DataError:
    """Return the error for a process that came to no end."""
    slow = status == -getattr(signal, "SIGXCPU", 0)
    said = "it comes to no end" if slow else f"it stops the HDF5 library ({status})"
    return DataError(
        f"cannot be read as {WHAT}: {said}",
        where=path,
        do="Copy it again from its source, or export it as text",
        code="damaged_file",
    )


def main() -> NoReturn:
    """Read a file from standard input in a process of its own: path, bytes on disk and bytes of content are given."""
    path, on_disk, size = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    import h5py  # noqa: F401, PLC0415 - before the limit: libraries take much address space, and use little of it

    _limit_memory(max(ceiling(on_disk) - PROCESS, 0))
    _limit_time(on_disk + size)
    out = sys.stdout.buffer
    try:
        found, is_matlab = _here(sys.stdin.buffer.read(size), path, on_disk, _limit_time)
    except InertialcalError as error:
        out.write(json.dumps({"refused": [one.to_dict() for one in error.problems]}).encode() + b"\n")
    else:
        said = [
            (name, *((None, (), None) if one is None else (one.values.dtype.str, one.values.shape, one.unit)))
            for name, one in found
        ]
        out.write(json.dumps({"found": said, "is_matlab": is_matlab}).encode() + b"\n")
        for _, one in found:
            if one is not None and one.values.nbytes:
                out.write(np.ascontiguousarray(one.values).reshape(-1).view(np.uint8).data)
    out.flush()
    os._exit(0)  # the library need not take apart what is damaged


def _limit_memory(most: int) -> None:
    """Limit the address space of this process to that many bytes on top of what it has, where the system can."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # noqa: PLC0415 - not everywhere

        with open("/proc/self/statm", encoding="ascii") as stream:
            own = int(stream.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (own + most, resource.RLIM_INFINITY))


def _limit_time(size: int) -> None:
    """Limit the computing time of this process to that of so many bytes, where the system can."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # noqa: PLC0415 - not everywhere

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS + int(size / PER_SECOND), resource.RLIM_INFINITY))


def _here(data: bytes, path: str, on_disk: int, allow: Callable[[int], None] = lambda size: None) -> tuple[Found, bool]:
    """Return the arrays of a file, and whether it is MATLAB's; ``allow`` gets the bytes to be worked through."""
    import h5py  # noqa: PLC0415 - heavy import

    with as_data_errors(path, WHAT), h5py.File(io.BytesIO(data), "r") as file:
        datasets = list(_datasets(file, path, [0], set()))
        used = [dataset for _, dataset in datasets if dataset is not None]
        whole = sum(dataset.size * dataset.dtype.itemsize for dataset in used)
        rows = max((max(dataset.shape, default=0) for dataset in used), default=0)
        per_column, other = READ
        need = 2 * len(data) + per_column * whole + VALUE * other * rows
        claim(path, on_disk, need, f"{sum(dataset.size for dataset in used):,} values")
        for name, dataset in datasets:
            if dataset is not None:
                _check_storage(name, dataset, path, on_disk, len(data))
        allow(on_disk + len(data) + 2 * whole)
        is_matlab = any("MATLAB_class" in dataset.attrs for dataset in used)
        found: Found = []
        for name, dataset in datasets:
            found += [(name, None)] if dataset is None else _arrays(name, dataset)
        check_count(len(found), PARTS, "datasets and fields", path)
    return found, is_matlab


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
    kinds = [dataset.dtype[name].kind for name in names] if names else [dataset.dtype.kind]
    return any(kind in "biuf" for kind in kinds)


def _arrays(name: str, dataset: Any) -> Found:
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

if __name__ == "__main__":
    main()
