"""A file or folder that is complete or not there: built in a folder of its own, then renamed; never over its own input.

The folder, ``.inertialcal-XXXXXXXXXXXXXXXX.part``, lies where the result goes. Its process holds a lock on it: after a
kill the lock is free, and the next write into the same place removes what is left.
"""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
import stat
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from ...core.errors import DataError, StoreError
from ...core.interruption import interruption

try:
    import fcntl
except ImportError:  # no locks: folders of other processes are left alone
    fcntl = None  # type: ignore[assignment]

PART = re.compile(r"\.inertialcal-[0-9a-f]{16}\.part")
POLL = 0.02  # [s] between two looks at a lock
WINDOWS = os.name == "nt"  # what differs there, and how it is tried here: tests/files/write/test_windows.py
BINARY = getattr(os, "O_BINARY", 0)  # Windows: without it a line feed is written as two bytes
NO_FOLDER_SYNC = errno.EINVAL, errno.EOPNOTSUPP, errno.ENOTSUP  # file systems that cannot flush a folder


@contextmanager
def atomic_write(
    path: str | os.PathLike[str], inputs: Iterable[str | os.PathLike[str]] = (), new: bool = False
) -> Iterator[Path]:
    """Yield a path to write to; what was written takes the place of ``path`` when all went well.

    Parameters
    ----------
    path : path
        Where the file shall be; one that is there, also by a link, is replaced, and its permissions are kept.
    inputs : iterable of path
        Files that it may not replace, because they were read for it.
    new : bool
        Refuse to replace a file.

    Raises
    ------
    DataError
        ``overwrites_input``, if ``path`` is one of the inputs, also by a link.
    StoreError
        ``not_written``, if the folder is not there or cannot be written, or something other than a file that may be
        written stands there.
    """
    target = Path(path)
    for given in inputs:
        _refuse_same(target, Path(given))
    try:
        mode = _mode(target)
        target = Path(os.path.realpath(target)) if target.is_symlink() else target
        with work_folder(target.parent) as work:
            aside = work / target.name
            yield aside
            sync(aside)
            if mode is not None:
                aside.chmod(mode)
            with interruption.held():
                _put_new(aside, target) if new else aside.replace(target)
                interruption.note(path)
                sync(target.parent)
    except OSError as error:
        raise StoreError(f"cannot be written: {error.strerror or error}", where=str(path), code="not_written") from None


def _put_new(aside: Path, target: Path) -> None:
    """Give a file its name, unless that is taken."""
    try:
        os.link(aside, target)
    except FileExistsError:
        raise
    except OSError:  # no links here
        if os.path.lexists(target):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        aside.rename(target)


def _mode(target: Path) -> int | None:
    """Return the permissions of a file that is replaced; None where there is none."""
    if "\0" in str(target):
        raise OSError(0, "a nul in the name")
    if target.is_dir():
        raise IsADirectoryError(0, "this is a folder")
    if not target.parent.is_dir():
        raise FileNotFoundError(0, f"there is no folder {str(target.parent)!r}")
    try:
        found = target.stat()
    except FileNotFoundError:
        return None
    if not stat.S_ISREG(found.st_mode):
        raise OSError(0, "this is a device or a pipe, not a file")
    if not os.access(target, os.W_OK):
        raise PermissionError(0, "the file is read-only")
    return stat.S_IMODE(found.st_mode)


def _refuse_same(target: Path, given: Path) -> None:
    try:
        same = target.samefile(given)
    except (OSError, ValueError):  # one of them is not there
        return
    if same:
        raise DataError(
            "the output would overwrite the input",
            where=str(target),
            why="a recording cannot be replaced",
            do="Choose another name for -o",
            code="overwrites_input",
        )


def write_folder(target: Path, files: Mapping[str, bytes]) -> None:
    """Write a folder, all or nothing.

    Parameters
    ----------
    target : path
        New, or an empty folder.
    files : mapping of str to bytes
        Content by path in the folder.

    Raises
    ------
    StoreError
        ``not_writable``; nothing is left behind.
    """
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with work_folder(target.parent) as work:
            inside = work / "new"
            for name, data in files.items():
                (inside / name).parent.mkdir(parents=True, exist_ok=True)
                (inside / name).write_bytes(data)
            for path in [*inside.rglob("*"), inside]:
                sync(path)
            with interruption.held():
                if (
                    WINDOWS and target.is_dir()
                ):  # a name that is taken is not given again, not even that of an empty folder
                    target.rmdir()
                inside.rename(target)
                interruption.note(target)
                sync(target.parent)
    except OSError as error:
        do = "Name a folder that is new or empty" if target.exists() else "Name another place"
        raise StoreError(f"cannot write {target}: {error.strerror}", do=do, code="not_writable") from None


# ---- folders of unfinished work -------------------------------------------------------------------------------------


@contextmanager
def work_folder(parent: Path) -> Iterator[Path]:
    """Yield a new folder that nobody else can open, and remove it in the end; first remove those of killed processes.

    Raises
    ------
    OSError
        If the parent cannot be written.
    """
    remove_unfinished(parent)
    folder, handle = _locked_folder(parent)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if handle is not None:
            os.close(handle)


def _locked_folder(parent: Path) -> tuple[Path, int | None]:
    """Make a folder and lock it; a process that cleans may take one between both, so look whether it is still there."""
    while True:
        folder = parent / f".inertialcal-{secrets.token_hex(8)}.part"
        folder.mkdir(0o700)
        try:
            handle = lock_folder(folder)
        except (BlockingIOError, FileNotFoundError):
            continue
        except OSError:
            return folder, None  # no locks here: nobody will clean either
        if os.fstat(handle).st_nlink and folder.is_dir():
            return folder, handle
        os.close(handle)


def remove_unfinished(parent: Path) -> None:
    """Remove the folders of unfinished work of processes that were killed."""
    with suppress(OSError):
        for folder in [entry for entry in os.scandir(parent) if PART.fullmatch(entry.name)]:
            with suppress(OSError):  # in use, no locks, not ours
                handle = lock_folder(Path(folder.path))
                try:
                    if os.fstat(handle).st_uid == os.geteuid():
                        shutil.rmtree(folder.path, ignore_errors=True)
                finally:
                    os.close(handle)


def lock_folder(folder: Path, wait: float = 0.0) -> int:
    """Return a descriptor of a folder, locked until it is closed or its process ends.

    Parameters
    ----------
    folder : path
        Not a link to one.
    wait : float
        How long to wait for another process. [s]

    Raises
    ------
    BlockingIOError
        If another process holds it.
    OSError
        If it is no folder, or there are no locks here.
    """
    if fcntl is None:
        raise OSError(0, "no locks on this system")
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    until = time.monotonic() + wait
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() < until:
                time.sleep(POLL)
                continue
            os.close(handle)
            raise
        except OSError:
            os.close(handle)
            raise
        return handle


def write_new(path: Path, data: bytes) -> None:
    """Write a file that was not there, down to the disk; no link is followed."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY, 0o666)
    try:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(handle, rest) :]
        os.fsync(handle)
    finally:
        os.close(handle)


def sync(path: Path) -> None:
    """Bring a file or the names in a folder down to the disk; Windows has no way to do so for a folder."""
    if WINDOWS and path.is_dir():
        return
    handle = os.open(
        path, os.O_RDWR | BINARY if WINDOWS else os.O_RDONLY
    )  # there, what may not be written is not flushed
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in NO_FOLDER_SYNC:
            raise
    finally:
        os.close(handle)
