"""A folder of results replaced whole: only files that this tool wrote are replaced, and every other file is kept.

The manifest, ``SHA256SUMS``, lists what was written. Its first line names the run and holds the checksum of the rest:
a list made by ``sha256sum * > SHA256SUMS`` is not taken for it. A file is ours if it is listed and has the hash that is
listed. The steps:

1. Under a lock on the parent, the new folder is built aside, down to the disk. What is not ours is linked into it;
   what stands where a new file goes is linked into ``kept-N/`` in it.
2. It becomes ``.out-ready-ID``, with the ID of its manifest, and changes places with ``out/`` in one system call.
   Without that call ``out/`` becomes ``.out-old-ID`` first.
3. The old folder is emptied: ours is deleted, and so are links that the new folder has too. All else (folders, files
   that came or changed in the meantime) moves into the new one.

So the names say after a kill what remains to be done: a ready folder with its own ID was not put in place, and is
removed, or put in place where there is no ``out/``; any other is an old one, and step 3 goes on.
"""

from __future__ import annotations

import ctypes
import errno
import hashlib
import os
import re
import secrets
import shutil
import stat
import sys
import time
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

from ...core.errors import StoreError
from ...core.interruption import interruption
from .atomic import BINARY, lock_folder, remove_unfinished, sync, work_folder, write_new

MANIFEST = "SHA256SUMS"
ROOM = re.compile(r"kept-\d+")  # folder for what gave way
LARGEST_MANIFEST = 2**20  # bytes
LINE = re.compile(r"([0-9a-f]{64})  ([^/\0\n]+)")
HEAD = re.compile(r"# inertialcal run ([0-9a-f]{16}): it replaces these files and keeps all others; ([0-9a-f]{64})")
WAIT = 10.0  # [s] for another run to finish its exchange
ABANDONED = 600.0  # [s] after which a left folder is nobody's, where there are no locks
CHUNK = 2**20
EXCHANGE, NO_REPLACE = "exchange", "no_replace"
FLAGS = {"linux": {NO_REPLACE: 1, EXCHANGE: 2}, "darwin": {NO_REPLACE: 4, EXCHANGE: 2}}
SYSCALL = {"x86_64": 316, "aarch64": 276, "armv7l": 382, "riscv64": 276, "ppc64le": 357, "s390x": 347}  # renameat2
AT_CWD = -100
NOT_HERE = errno.ENOSYS, errno.EINVAL, errno.EOPNOTSUPP, errno.ENOTSUP, errno.EPERM


@dataclass
class Kept:
    """What an exchange kept, by name in the folder."""

    stayed: list[str] = field(default_factory=list[str])  # under their names
    moved: dict[str, str] = field(default_factory=dict[str, str])  # where a new file goes: the new name
    stuck: list[str] = field(default_factory=list[str])  # paths that could not be moved into the folder

    def note(self, name: str, place: str) -> None:
        """Note where a file or folder is now."""
        if name != place:
            self.moved[name] = place
        elif name not in self.stayed and not ROOM.fullmatch(name):
            self.stayed.append(name)


@dataclass(frozen=True)
class Manifest:
    """Which run wrote a folder, and the SHA-256 of each of its files."""

    run: str
    files: Mapping[str, str]

    @classmethod
    def read(cls, folder: Path) -> Manifest | None:
        """Return the manifest of a folder; None where there is none, or it is not as this tool wrote it."""
        try:
            with _opened(folder / MANIFEST) as handle:
                head, _, rest = os.read(handle, LARGEST_MANIFEST).decode("utf-8").partition("\n")
        except (OSError, UnicodeDecodeError):
            return None
        named = HEAD.fullmatch(head)
        lines = [LINE.fullmatch(line) for line in rest.splitlines()]
        if named is None or named[2] != _sha256(rest) or not all(lines):
            return None
        return cls(named[1], {line[2]: line[1] for line in lines if line})

    def text(self) -> str:
        """Return what `sha256sum -c` reads."""
        rest = "".join(f"{digest}  {name}\n" for name, digest in sorted(self.files.items()))
        return f"# inertialcal run {self.run}: it replaces these files and keeps all others; {_sha256(rest)}\n{rest}"

    def lists(self, path: Path) -> bool:
        """Tell whether a file is listed and as it was written."""
        return path.name in self.files and file_digest(path) == self.files[path.name]


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


@contextmanager
def _opened(path: Path, follow: bool = False) -> Iterator[int]:
    """Yield a descriptor of a regular file; anything else is closed unread, and links are followed only on request.

    Raises
    ------
    OSError
        If it is something else.
    """
    flags = os.O_RDONLY | BINARY | getattr(os, "O_NONBLOCK", 0) | (0 if follow else getattr(os, "O_NOFOLLOW", 0))
    handle = os.open(path, flags)
    try:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise OSError(errno.EINVAL, "not a regular file")
        yield handle
    finally:
        os.close(handle)


def file_digest(path: Path, follow: bool = False) -> str:
    """Return the SHA-256 of a regular file, "" of anything else."""
    found = hashlib.sha256()
    try:
        with _opened(path, follow) as handle:
            while data := os.read(handle, CHUNK):
                found.update(data)
    except OSError:
        return ""
    return found.hexdigest()


def replace_folder(target: Path, files: Mapping[str, bytes], reserved: re.Pattern[str]) -> Kept:
    """Replace the files that this tool wrote into a folder, all or nothing, and keep all others.

    Parameters
    ----------
    target : Path
        The folder; it need not be there.
    files : mapping of str to bytes
        Content by name.
    reserved : pattern
        Names that others may not have, whether or not they are written now.

    Raises
    ------
    StoreError
        ``not_writable``; ``busy`` if another process holds the folder. The target stays as it was.
    """
    parent, run = target.parent, secrets.token_hex(8)
    manifest = Manifest(run, {name: hashlib.sha256(data).hexdigest() for name, data in files.items()})
    ready = target.with_name(f".{target.name}-ready-{run}")
    kept = Kept()
    try:
        with _locked(parent, WAIT) as alone, work_folder(parent) as work:
            _recover(target, reserved, alone, kept)
            if not (_is_missing(target) or _is_folder(target)):
                raise OSError(errno.ENOTDIR, "not a folder")
            new = work / target.name
            room = _build(new, target, dict(files) | {MANIFEST: manifest.text().encode()}, reserved, kept)
            with interruption.held():
                os.rename(new, ready)
                try:
                    old = _put_in_place(ready, target)
                except BaseException:
                    if Manifest.read(ready) == manifest:  # not in place
                        os.rename(ready, new)
                    raise
                interruption.note(target)
                _empty(old, target, reserved, kept, room)
    except BlockingIOError:
        what = f"another run is writing {target}"
        raise StoreError(what, do="Wait until it has finished, then run again", code="busy") from None
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
        raise StoreError(
            f"cannot write {target}: {error.strerror}",
            why="what was there stays as it was",
            do="Make room, then run again" if full else "",
            code="not_writable",
        ) from None
    return kept


def recover(target: Path, reserved: re.Pattern[str]) -> Kept:
    """Finish or undo what a killed process began, where no other process is at work and the parent can be written."""
    kept = Kept()
    with suppress(OSError):
        if _left(target):
            with _locked(target.parent) as alone:
                _recover(target, reserved, alone, kept)
        remove_unfinished(target.parent)
    return kept


@contextmanager
def _locked(parent: Path, wait: float = 0.0) -> Iterator[bool]:
    """Hold the lock on a folder; yield whether there are locks.

    Raises
    ------
    BlockingIOError
        If another process keeps it.
    """
    handle = None
    try:
        handle = lock_folder(parent.resolve(), wait)
    except BlockingIOError:
        raise
    except OSError:
        pass
    try:
        yield handle is not None
    finally:
        if handle is not None:
            os.close(handle)


# ---- 1: build -------------------------------------------------------------------------------------------------------


def _build(new: Path, out: Path, files: Mapping[str, bytes], reserved: re.Pattern[str], kept: Kept) -> str:
    """Write the new folder, with links to what is not ours; return the name of its folder for what gives way."""
    new.mkdir()
    for name, data in files.items():
        write_new(new / name, data)
    room = _free_room(out, () if _is_missing(out) else os.listdir(out))
    if not _is_missing(out):
        os.chmod(new, stat.S_IMODE(out.stat().st_mode))
        manifest = Manifest.read(out)
        for entry in sorted(os.scandir(out), key=lambda one: one.name):
            if manifest is not None and (entry.name == MANIFEST or manifest.lists(out / entry.name)):
                continue
            gives_way = entry.name in files or bool(reserved.fullmatch(entry.name))
            place = f"{room}/{entry.name}" if gives_way else entry.name
            if not entry.is_dir(follow_symlinks=False):
                with suppress(OSError, NotImplementedError):  # moved later, where there are no links
                    if gives_way:
                        (new / room).mkdir(exist_ok=True)
                    os.link(out / entry.name, new / place, follow_symlinks=False)
            kept.note(entry.name, place)
        if (new / room).is_dir():
            sync(new / room)
    sync(new)
    return room


def _free_room(folder: Path, others: Collection[str]) -> str:
    """Return the first name kept-N that is free, or that of an empty folder."""
    for number in count(1):
        name = f"kept-{number}"
        try:
            if name not in others and not os.listdir(folder / name):
                return name
        except FileNotFoundError:
            return name
        except NotADirectoryError:
            continue
    raise AssertionError


# ---- 2: exchange ----------------------------------------------------------------------------------------------------


def _put_in_place(ready: Path, target: Path) -> Path:
    """Make the ready folder the target; return where the old one is now, if there was one."""
    if _is_missing(target):
        os.rename(ready, target)
    elif not _rename(ready, target, EXCHANGE):
        old = target.with_name(ready.name.replace("-ready-", "-old-"))
        os.rename(target, old)
        try:
            sync(target.parent)
            os.rename(ready, target)
        except BaseException:
            os.rename(old, target)
            raise
        return old
    return ready


def _rename(source: Path, target: Path, how: str) -> bool:
    """Rename in one system call, so that both change places or nothing is replaced; tell whether it can be done here.

    Raises
    ------
    OSError
        If it was tried and failed.
    """
    call = _system_call()
    if call is None:
        return False
    if call(os.fsencode(source), os.fsencode(target), FLAGS[sys.platform][how]) == 0:
        return True
    number = ctypes.get_errno()
    if number in NOT_HERE:
        return False
    raise OSError(number, os.strerror(number), str(source))


def _system_call() -> Any:
    """Return the function (source, target, flag) of this system; None where it has none."""
    try:
        system = ctypes.CDLL(None, use_errno=True)
    except (OSError, TypeError):
        return None
    if sys.platform == "darwin" and hasattr(system, "renamex_np"):
        return system.renamex_np
    if sys.platform != "linux":
        return None
    if hasattr(system, "renameat2"):
        return lambda source, target, flag: system.renameat2(AT_CWD, source, AT_CWD, target, flag)
    number = SYSCALL.get(os.uname().machine)
    if number is None or not hasattr(system, "syscall"):
        return None
    return lambda source, target, flag: system.syscall(number, AT_CWD, source, AT_CWD, target, flag)


# ---- 3: empty the old one; also what a killed run left --------------------------------------------------------------


def _empty(old: Path, out: Path, reserved: re.Pattern[str], kept: Kept, room: str = "") -> None:
    """Delete what is ours or linked in the new folder, move the rest into it, remove the old folder.

    What cannot be moved, or comes while this goes on, stays for the next start.
    """
    try:
        sync(old.parent)
        if _is_missing(old):
            return
        manifest, inside = Manifest.read(old), sorted(os.listdir(old))
        room = room or _free_room(out, inside)
        for name in inside:
            if manifest is None or name != MANIFEST:
                _take_over(old / name, manifest, out, reserved, kept, room)
        if manifest is not None:
            sync(old)  # the list goes last, so that what is ours is known after a crash
            if os.listdir(old) == [MANIFEST]:
                (old / MANIFEST).unlink()
        os.rmdir(old)
        sync(old.parent)
    except OSError:
        kept.stuck.append(str(old))


def _take_over(
    path: Path, manifest: Manifest | None, out: Path, reserved: re.Pattern[str], kept: Kept, room: str
) -> None:
    """Delete a file that is ours or linked in the new folder; move anything else into it."""
    with suppress(OSError):
        if (manifest is not None and manifest.lists(path)) or (not _is_folder(path) and _is_linked(path, out)):
            path.unlink()
            return
        if _is_missing(out):
            out.mkdir()
        place = path.name
        if reserved.fullmatch(place) or os.path.lexists(out / place):
            if os.path.lexists(out / room / place):
                room = _free_room(out, os.listdir(path.parent))
            (out / room).mkdir(exist_ok=True)
            place = f"{room}/{path.name}"
        if not _rename(path, out / place, NO_REPLACE):
            os.rename(path, out / place)
        kept.note(path.name, place)


def _is_linked(path: Path, out: Path) -> bool:
    """Tell whether a file has the same name in the new folder, or in a folder of it for what gave way."""
    if _is_missing(out):
        return False
    own = path.lstat()
    for place in (out, *(out / name for name in os.listdir(out) if name.startswith("kept-"))):
        with suppress(OSError):
            if os.path.samestat(own, (place / path.name).lstat()):
                return True
    return False


def _recover(target: Path, reserved: re.Pattern[str], alone: bool, kept: Kept) -> None:
    """Finish or undo what killed processes began."""
    left = [(path, Manifest.read(path)) for path in _left(target)]
    if not alone:
        left = [one for one in left if time.time() - one[0].lstat().st_ctime > ABANDONED]
    unplaced = {path for path, found in left if found is not None and path.name.endswith(f"-ready-{found.run}")}
    for path, manifest in sorted(left, key=lambda one: (one[0] not in unplaced, one[0].name)):
        if _is_missing(target):
            if manifest is None or all(os.path.lexists(path / name) for name in manifest.files):
                os.rename(path, target)
                sync(target.parent)
                continue
        elif path in unplaced:
            part = path.with_name(f".inertialcal-{secrets.token_hex(8)}.part")
            os.rename(path, part)  # killed while it goes, it is known as unfinished still
            shutil.rmtree(part, ignore_errors=True)
            continue
        if _is_missing(target) or _is_folder(target):
            _empty(path, target, reserved, kept)


def _left(target: Path) -> list[Path]:
    """Return the folders that a run has left beside the target."""
    pattern = re.compile(rf"\.{re.escape(target.name)}-(ready|old)-[0-9a-f]{{16}}")
    return [Path(one.path) for one in os.scandir(target.parent)
            if pattern.fullmatch(one.name) and one.is_dir(follow_symlinks=False)]  # fmt: skip


def _is_missing(path: Path) -> bool:
    return not os.path.lexists(path)


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()
