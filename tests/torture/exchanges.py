"""Kills and crashes of an exchange of ``out/``: starting states, system calls counted or logged, what must be true."""

from __future__ import annotations

import contextlib
import errno
import os
import random
import shutil
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from inertialcal.campaign.outcome.publish import RESERVED
from inertialcal.files.write import exchange
from inertialcal.files.write.exchange import Manifest, recover, replace_folder

OLD = {"results.json": b"old results " * 9, "report.html": b"old report", "model.json": b"old model"}
NEW = {"results.json": b"new results " * 9, "report.html": b"new report", "results.csv": b"new,rows\n"}
NEXT = {"results.json": b"next results", "model.json": b"next model"}
Tree = dict[str, Any]  # name -> bytes of a file, target of a link as text, None for a pipe, a Tree for a folder


def tree(folder: Path) -> Tree:
    """Return what a folder holds; pipes are not opened."""
    found: Tree = {}
    for path in folder.iterdir():
        mode = path.lstat().st_mode
        if stat.S_ISDIR(mode):
            found[path.name] = tree(path)
        elif stat.S_ISREG(mode):
            found[path.name] = path.read_bytes()
        else:
            found[path.name] = os.readlink(path) if stat.S_ISLNK(mode) else None
    return found


def plant(folder: Path, content: Tree) -> None:
    """Write a tree."""
    for name, what in content.items():
        path = folder / name
        if isinstance(what, dict):
            path.mkdir()
            plant(path, what)
        elif isinstance(what, bytes):
            path.write_bytes(what)
        elif what is None:
            os.mkfifo(path)
        else:
            path.symlink_to(what)


# ---- starting states -----------------------------------------------------------------------------------------------

USERS: Tree = {"mynotes.txt": b"mine", "plots": {"a.png": b"png", "deep": {"b": b"b"}}, "link": "/etc", "pipe": None}


def _ours(out: Path) -> None:
    replace_folder(out, OLD, RESERVED)


def _with_users(out: Path) -> None:
    _ours(out)
    plant(out, USERS)


def _edited(out: Path) -> None:
    _with_users(out)
    (out / "results.json").write_bytes(b"edited")
    plant(out, {"kept-1": {"results.json": b"edited before"}})


def _no_manifest(out: Path) -> None:
    plant(out.parent, {"out": {**OLD, "provenance.json": b"of an old version", "mynotes.txt": b"mine"}})


def _list_of_the_user(out: Path) -> None:
    plant(out.parent, {"out": {**OLD, "mynotes.txt": b"mine"}})
    listed = Manifest("0" * 16, {name: exchange.file_digest(out / name) for name in (*OLD, "mynotes.txt")})
    (out / "SHA256SUMS").write_text(listed.text().partition("\n")[2])  # sha256sum * > SHA256SUMS


def _names_taken(out: Path) -> None:
    _ours(out)
    for name in OLD:
        (out / name).unlink()
    plant(
        out, {"results.json": {"a": b"a folder"}, "model.json": None, "report.html": "/dev/zero", "results.csv": b"x"}
    )


def _nothing(out: Path) -> None:
    pass


STATES: dict[str, Callable[[Path], None]] = {
    "no out": _nothing, "ours": _ours, "ours and the user's": _with_users, "edited": _edited,
    "no manifest": _no_manifest, "list of the user": _list_of_the_user, "names taken": _names_taken,
}  # fmt: skip


# ---- what must be true ---------------------------------------------------------------------------------------------


@dataclass
class Expected:
    """What a state holds before: files of ours, and of the user."""

    before: Tree | None
    own: Tree
    users: Tree

    @classmethod
    def of(cls, out: Path) -> Expected:
        if not out.exists():
            return cls(None, {}, {})
        content, manifest = tree(out), Manifest.read(out)
        named = () if manifest is None else [name for name in manifest.files if manifest.lists(out / name)]
        own = {name: content[name] for name in named}
        users = {name: what for name, what in content.items()
                 if name not in own and not (manifest is not None and name == "SHA256SUMS")}  # fmt: skip
        return cls(content, own, users)


def check(out: Path, expected: Expected, *news: Mapping[str, bytes]) -> str:
    """Return whether ``out/`` is "old" or "new"; fail if it is neither, anything of the user is lost, or anything left.

    ``news`` are what the runs since have written, one of which may be in place.
    """
    left = [name for name in os.listdir(out.parent) if name.startswith((".out-", ".inertialcal-"))]
    assert not left, left
    if not out.exists():
        assert expected.before is None
        return "old"
    content = tree(out)
    if content == expected.before:
        return "old"
    manifest = Manifest.read(out)
    assert manifest is not None, content
    own = {name: content.pop(name) for name in manifest.files}
    content.pop("SHA256SUMS")
    assert own in [dict(new) for new in news] or own == expected.own, own
    # Each thing of the user is there once: under its name, or in a folder for what gave way.
    for name, what in expected.users.items():
        rooms = [room for room, inside in content.items() if room.startswith("kept-") and isinstance(inside, dict)]
        if content.get(name, name) == what:
            del content[name]
            continue
        room = next((one for one in rooms if content[one].get(name, name) == what), None)
        assert room is not None, f"{name} is lost: {content}"
        del content[room][name]
    assert not any(content.values()), f"came from nowhere: {content}"
    return "new" if own in [dict(new) for new in news] else "old"


# ---- system calls counted: a kill at each --------------------------------------------------------------------------

MODES = "renameat2", "two renames", "no links"  # what the file system can do
COUNTED = ("open", "write", "fsync", "link", "rename", "replace", "unlink", "mkdir", "rmdir", "chmod")
KILLED = 99


@contextmanager
def calls(noted: Callable[[str, tuple[Any, ...], dict[str, Any]], None], mode: str = MODES[0]) -> Iterator[None]:
    """Note each system call that changes something, before it is made, on a file system of a mode."""
    real = {name: getattr(os, name) for name in COUNTED}
    system = exchange._system_call

    def made(name: str) -> Callable[..., Any]:
        def call(*given: Any, **named: Any) -> Any:
            if name == "link" and mode == "no links":
                raise OSError(errno.EPERM, os.strerror(errno.EPERM))
            noted(name, given, named)
            return None if name == "fsync" else real[name](*given, **named)

        return call

    def renameat2() -> Any:
        own = system()
        if mode != MODES[0] or own is None:
            return None

        def call(source: bytes, target: bytes, flag: int) -> int:
            noted(f"renameat2 {flag}", (source, target), {})
            return int(own(source, target, flag))

        return call

    for name in COUNTED:
        setattr(os, name, made(name))
    exchange._system_call = renameat2
    try:
        yield
    finally:
        for name, function in real.items():
            setattr(os, name, function)
        exchange._system_call = system


def killed_at(number: int, work: Callable[[], object], mode: str = MODES[0]) -> bool:
    """Do the work in a process that ends at its n-th system call; return whether it got that far.

    A write that it ends in is half done.
    """
    process = os.fork()
    if not process:
        status = 1
        try:
            count, write = 0, os.write

            def noted(name: str, given: tuple[Any, ...], named: dict[str, Any]) -> None:
                nonlocal count
                count += 1
                if count == number:
                    if name == "write":
                        write(given[0], bytes(given[1])[: len(given[1]) // 2])
                    os._exit(KILLED)

            with calls(noted, mode):
                work()
            status = 0
        finally:
            os._exit(status)
    status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    assert status in (0, KILLED), status
    return status == KILLED


@dataclass
class Tally:
    """How many kills or images, and what came of them."""

    tried: int = 0
    came_to: dict[str, int] = field(default_factory=dict)

    def add(self, what: str) -> None:
        self.tried += 1
        self.came_to[what] = self.came_to.get(what, 0) + 1


def unflushed(mode: str = MODES[0]) -> contextlib.AbstractContextManager[None]:
    """Do without flushing: quicker, and after a kill the same."""
    return calls(lambda name, given, named: None, mode)


def start(folder: Path, state: str) -> tuple[Path, Expected]:
    """Make a starting state in an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    out = folder / "out"
    with unflushed():
        STATES[state](out)
    return out, Expected.of(out)


def kills(folder: Path, state: str, mode: str, step: int = 1, first: int = 1) -> Tally:
    """Kill an exchange at every (or every n-th) system call, recover, check; then do a whole exchange, check."""
    tally, number = Tally(), first
    while True:
        out, expected = start(folder, state)
        killed = killed_at(number, partial(replace_folder, out, NEW, RESERVED), mode)
        if not killed:
            assert check(out, expected, NEW) == "new"
            return tally
        with unflushed(mode):
            if number % 2:
                recover(out, RESERVED)
                tally.add(check(out, expected, NEW))
                replace_folder(out, NEXT, RESERVED)
            else:  # the next run finds it so
                replace_folder(out, NEXT, RESERVED)
                tally.add("new")
        assert check(out, expected, NEXT) == "new"
        number += step


def kills_of_recovery(folder: Path, state: str, mode: str, rng: random.Random, number: int) -> Tally:
    """Kill an exchange at a random call, its recovery at another, and again; recover, check."""
    tally = Tally()
    for _ in range(number):
        out, expected = start(folder, state)
        for new in (NEW, NEXT, NEW):
            run = rng.random() < 0.5
            work = partial(replace_folder, out, new, RESERVED) if run else partial(recover, out, RESERVED)
            killed_at(rng.randint(1, 70 if run else 25), work, mode)
        with unflushed(mode):
            recover(out, RESERVED)
        tally.add(check(out, expected, NEW, NEXT))
    return tally


# ---- system calls logged: images of a disk after a crash -----------------------------------------------------------


@dataclass
class Node:
    """A file, link, pipe or folder of a disk."""

    what: Any  # bytearray; text of a link; None for a pipe; names and numbers of nodes of a folder


@dataclass(frozen=True)
class Change:
    """A change of a disk: of the content of a node, or of the names in folders."""

    kind: str
    folder: int = 0
    name: str = ""
    node: int = 0
    to: int = 0
    to_name: str = ""
    data: bytes = b""


@dataclass
class Disk:
    """What lies on a disk, by number of node; 0 is the folder that is looked at."""

    nodes: dict[int, Node]

    @classmethod
    def of(cls, folder: Path) -> Disk:
        disk = cls({})
        disk._add(tree(folder))
        return disk

    def _add(self, content: Any) -> int:
        number = len(self.nodes)
        self.nodes[number] = Node(bytearray(content) if isinstance(content, bytes) else content)
        if isinstance(content, dict):
            self.nodes[number].what = {name: self._add(what) for name, what in content.items()}
        return number

    def copy(self) -> Disk:
        return Disk({n: Node(one.what.copy() if isinstance(one.what, (dict, bytearray)) else one.what)
                     for n, one in self.nodes.items()})  # fmt: skip

    def find(self, path: str, at: int = 0) -> int | None:
        for part in [part for part in path.split("/") if part]:
            inside = self.nodes[at].what
            if not isinstance(inside, dict) or part not in inside:
                return None
            at = inside[part]
        return at

    def apply(self, one: Change) -> None:
        """Make a change; one that is impossible, because another was lost, is left out."""
        names = self.nodes[one.folder].what if one.folder in self.nodes else None
        if one.kind == "write":
            if one.node in self.nodes:
                self.nodes[one.node].what += one.data
        elif names is None:
            return
        elif one.kind in ("create", "mkdir"):
            self.make(one)
            names.setdefault(one.name, one.node)
        elif one.kind == "link":
            if one.node in self.nodes:
                names.setdefault(one.name, one.node)
        elif one.kind == "unlink":
            if names.get(one.name) == one.node:
                del names[one.name]
        elif one.kind == "rmdir":
            if names.get(one.name) == one.node and not self.nodes[one.node].what:
                del names[one.name]
        else:
            self._rename(one, names)

    def make(self, one: Change) -> None:
        """Make the node of a change; its name may be lost."""
        if one.kind in ("create", "mkdir") and one.node not in self.nodes:
            self.nodes[one.node] = Node({} if one.kind == "mkdir" else bytearray())

    def _rename(self, one: Change, names: dict[str, int]) -> None:
        others = self.nodes[one.to].what if one.to in self.nodes else None
        if others is None or one.node not in self.nodes:
            return
        if one.kind == "swap":
            if names.get(one.name) == one.node and one.to_name in others:
                names[one.name], others[one.to_name] = others[one.to_name], names[one.name]
        elif one.to_name not in others or not self.nodes[others[one.to_name]].what:
            others[one.to_name] = one.node  # also where the old name never came to the disk
            if names.get(one.name) == one.node:
                del names[one.name]

    def write(self, folder: Path, at: int = 0, made: dict[int, Path] | None = None) -> None:
        made = {} if made is None else made
        for name, number in self.nodes[at].what.items():
            path, what = folder / name, self.nodes[number].what
            if number in made:
                os.link(made[number], path, follow_symlinks=False)
            elif isinstance(what, dict):
                path.mkdir()
                self.write(path, number, made)
                continue
            else:
                plant(folder, {name: bytes(what) if isinstance(what, bytearray) else what})
            made[number] = path


class Log:
    """The changes of a disk in the order of the calls, with what was flushed."""

    def __init__(self, folder: Path) -> None:
        self.root = os.path.realpath(folder)
        self.first = Disk.of(folder)
        self.disk = self.first.copy()
        self.changes: list[Change] = []
        self.handles: dict[int, int] = {}  # descriptor -> node
        self.opening: tuple[int, str, int] | None = None
        self.next = 10_000

    def _place(self, path: Any, at: int | None = None) -> tuple[int, str]:
        text = os.fsdecode(path)
        base, name = os.path.split(text)
        if at is not None:
            return self.handles[at], name
        inside = os.path.relpath(os.path.realpath(base), self.root)
        folder = self.disk.find("" if inside == "." else inside)
        assert folder is not None, path
        return folder, name

    def _change(self, **parts: Any) -> None:
        one = Change(**parts)
        self.changes.append(one)
        self.disk.apply(one)

    def noted(self, name: str, given: tuple[Any, ...], named: dict[str, Any]) -> None:
        """Take a call; `open` is completed by `opened`."""
        if name == "write":
            self._change(kind="write", node=self.handles[given[0]], data=bytes(given[1]))
        elif name == "fsync":
            self.changes.append(Change("fsync", node=self.handles[given[0]]))
        elif name in ("rename", "replace") or name.startswith("renameat2"):
            (folder, own), (to, other) = self._place(given[0]), self._place(given[1])
            node = self.disk.nodes[folder].what[own]
            kind = "swap" if name == "renameat2 2" else "rename"
            self._change(kind=kind, folder=folder, name=own, node=node, to=to, to_name=other)
        elif name == "link":
            (folder, own), (to, other) = self._place(given[0]), self._place(given[1])
            self._change(kind="link", folder=to, name=other, node=self.disk.nodes[folder].what[own])
        elif name in ("unlink", "rmdir"):
            folder, own = self._place(given[0], named.get("dir_fd"))
            self._change(kind=name, folder=folder, name=own, node=self.disk.nodes[folder].what[own])
        elif name == "mkdir" and not os.path.lexists(given[0]):
            folder, own = self._place(given[0])
            self.next += 1
            self._change(kind="mkdir", folder=folder, name=own, node=self.next)

    def opened(self, handle: int, path: Any, flags: int, at: int | None) -> None:
        """Take the descriptor of an open file or folder."""
        if at is None and os.path.realpath(path) == self.root:
            self.handles[handle] = 0
            return
        folder, name = self._place(path, at)
        number = self.disk.nodes[folder].what.get(name)
        if number is None and flags & os.O_CREAT:
            self.next += 1
            number = self.next
            self._change(kind="create", folder=folder, name=name, node=number)
        if number is not None:
            self.handles[handle] = number

    def images(self, rng: random.Random, each: int) -> Iterator[Disk]:
        """Yield disks after a crash at each call: all changes up to it, and ``each`` draws of those not flushed.

        A change that was not flushed may be lost, whatever came after it; a write may also be cut.
        """
        for cut in range(len(self.changes) + 1):
            for draw in range(each + 1):
                disk = self.first.copy()
                for number, one in enumerate(self.changes[:cut]):
                    if one.kind == "fsync":
                        continue
                    target = one.node if one.kind == "write" else one.to if one.to_name else one.folder
                    flushed = any(later.kind == "fsync" and later.node == target
                                  for later in self.changes[number + 1 : cut])  # fmt: skip
                    fate = 1.0 if flushed or not draw else rng.random()
                    if one.kind == "write" and not flushed and 0.3 < fate < 0.6:
                        disk.apply(Change("write", node=one.node, data=one.data[: rng.randrange(len(one.data) + 1)]))
                    elif fate >= 0.4:
                        disk.apply(one)
                    else:
                        disk.make(one)
                yield disk


def logged(folder: Path, work: Callable[[], object], mode: str) -> Log:
    """Do the work and log its calls."""
    log = Log(folder)
    real = os.open

    def opening(path: Any, flags: int, mode: int = 0o777, *, dir_fd: int | None = None) -> int:
        handle = real(path, flags, mode, dir_fd=dir_fd)
        log.opened(handle, path, flags, dir_fd)
        return handle

    os.open = opening
    try:
        with calls(log.noted, mode):
            work()
    finally:
        os.open = real
    return log


def replays(folder: Path, state: str, mode: str, rng: random.Random, each: int, every: int = 1) -> Tally:
    """Log an exchange, write images of the disk after a crash, recover each, check."""
    tally = Tally()
    out, expected = start(folder, state)
    log = logged(folder, lambda: replace_folder(out, NEW, RESERVED), mode)
    assert log.disk.find("out/results.csv") is not None
    for number, disk in enumerate(log.images(rng, each)):
        if number % every:
            continue
        shutil.rmtree(folder)
        folder.mkdir()
        disk.write(folder)
        with unflushed(mode):
            recover(out, RESERVED)
        tally.add(check(out, expected, NEW))
    return tally
