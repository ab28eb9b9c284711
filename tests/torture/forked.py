"""Commands in forks of one warm process: how they end, what they take, print and leave on disk, and what of it fails.

A fork runs `inertialcal.cli.__main__.main` as a process of its own would: its standard output and errors go into files,
its limits are those below, and whatever it opens for writing outside its folder is noted.
"""

from __future__ import annotations

import gc
import hashlib
import importlib
import json
import os
import pkgutil
import re
import resource
import select
import signal
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, NoReturn

import inertialcal
from inertialcal.core.schema.results import Printed

LONGEST = 10.0  # [s]
KILLED = 90.0  # a command that takes longer, by the clock, is killed [s]
WAITING = 0.1  # of the clock: one that works less than this waits for something
OWN = 250.0  # that a process of its own has when everything is imported [MiB]
LARGEST = 2**30  # peak of memory, and three times the input more [bytes]
BEYOND = 5 * 2**30  # of addresses, more than the process has that was doubled: a bomb does not take the machine [bytes]
STATUSES = frozenset({0, 1, 2, 3, 4, 130})
ANSWERED = frozenset({0, 1, 4})
# Codes of refusals that say: the bytes or the syntax are not those of the format. All others come after the parser.
PARSER = frozenset(
    {
        "bad_card", "bad_header", "checksum", "damaged_file", "empty_file", "header_disagrees", "missing_file",
        "missing_header", "not_json", "not_text", "not_toml", "not_yaml", "old_schema", "ragged_row", "refused",
        "schema", "schema_version", "text_in_numbers", "too_large", "too_many", "truncated", "unsupported_format",
    }
)  # fmt: skip
WARNED = re.compile(r"Traceback \(most recent|\b\w*Warning: |Exception ignored")


@dataclass(frozen=True)
class Ran:
    """How a command ended."""

    status: int  # negative: signal
    seconds: float  # of the processor, since others use the machine too; by the clock if it waited
    mib: float
    codes: tuple[str, ...]  # of the refusal
    out: str
    err: str
    outside: tuple[str, ...]  # paths opened for writing outside its folder


@dataclass(frozen=True)
class Judged:
    """A trial that was run."""

    number: int
    label: str
    words: tuple[str, ...]
    status: int
    seconds: float
    mib: float
    past: bool
    failures: tuple[str, ...] = field(default=())

    def line(self) -> str:
        """Return it as a line of JSON."""
        return json.dumps(asdict(self))


def warm() -> None:
    """Import everything once."""
    for module in pkgutil.walk_packages(inertialcal.__path__, "inertialcal."):
        if not module.name.endswith("__main__") and ".migrations." not in module.name:  # those are Alembic's to run
            importlib.import_module(module.name)
    for name in ("inertialcal.cli.__main__", "matplotlib.backends.backend_svg", "h5py", "scipy.io", "yaml"):
        importlib.import_module(name)
    gc.collect()
    gc.freeze()


@dataclass(frozen=True)
class Process:
    """What a command is run in, where a fork will not do.

    Parameters
    ----------
    stdout : str
        Where its standard output goes: a file, a full device, or nowhere because it is closed.
    settings : mapping
        Of its environment.
    """

    stdout: Literal["file", "full", "closed"] = "file"
    settings: Mapping[str, str] = field(default_factory=dict)


def ran(words: Sequence[str], folder: Path, aside: Path, process: Process | None = None) -> Ran:
    """Run a command in a folder.

    Parameters
    ----------
    words : sequence of str
        The command without ``inertialcal``.
    folder : path
        Where it runs.
    aside : path
        Where its output and its temporary files go; emptied of nothing.
    process : Process
        A process of its own, in place of a fork.
    """
    (aside / "tmp").mkdir(parents=True, exist_ok=True)
    begin = time.monotonic()
    resident = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize() / 2**20
    inherited = max(resident - OWN, 0.0)  # of a runner that holds more than a command does, and the peak counts it
    child = os.fork()
    if not child:
        _command(words, folder, aside, process)
    with os.fdopen(os.pidfd_open(child)) as watched:
        if not select.select([watched], [], [], KILLED)[0]:
            os.kill(child, signal.SIGKILL)
    _, left, used = os.wait4(child, 0)
    clock, worked = time.monotonic() - begin, used.ru_utime + used.ru_stime
    codes = aside / "codes"
    outside = aside / "outside"
    return Ran(
        os.waitstatus_to_exitcode(left),
        clock if worked < WAITING * clock else worked,
        used.ru_maxrss / 1024 - inherited,
        tuple(codes.read_text().split()) if codes.exists() else (),
        (aside / "out").read_text(encoding="utf-8", errors="replace"),
        (aside / "err").read_text(encoding="utf-8", errors="replace"),
        tuple(outside.read_text(errors="replace").splitlines()) if outside.exists() else (),
    )


def program(words: Sequence[str]) -> list[str]:
    """Return the command line of a process of its own."""
    return [sys.executable, "-c", "from inertialcal.cli.__main__ import entry; entry()", *words]


def _command(words: Sequence[str], folder: Path, aside: Path, process: Process | None) -> NoReturn:
    """Become the command, and leave."""
    status = 99
    try:
        os.setsid()
        os.chdir(folder)
        nothing = os.open(os.devnull, os.O_RDONLY)
        out, err, told, outside = (
            os.open(aside / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC) for name in ("out", "err", "codes", "outside")
        )
        for number, opened in enumerate((nothing, out, err)):
            os.dup2(opened, number)
        sys.stdout, sys.stderr = (open(n, "w", encoding="utf-8", closefd=False) for n in (1, 2))  # noqa: SIM115
        warnings.resetwarnings()  # a test runner makes errors of them
        for hidden in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", hidden)  # as Python does
        os.environ |= {"TMPDIR": str(aside / "tmp"), "COLUMNS": "100", "HOME": str(aside)}
        tempfile.tempdir = None
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        ceiling = pages * resource.getpagesize() + BEYOND
        resource.setrlimit(resource.RLIMIT_AS, (ceiling, ceiling))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if process is not None:
            _become(words, process)
        _note_codes(told)
        _note_writes(folder, aside, outside)
        from inertialcal.cli.__main__ import main

        main(words)
    except SystemExit as left:
        status = int(left.code or 0)
    except BaseException:
        import traceback

        traceback.print_exc()
        status = 99
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status)


def _become(words: Sequence[str], process: Process) -> NoReturn:
    if process.stdout == "closed":
        os.close(1)
    elif process.stdout == "full":
        os.dup2(os.open("/dev/full", os.O_WRONLY), 1)
    line = program(words)
    os.execve(line[0], line, {**os.environ, **process.settings})


def _note_codes(to: int) -> None:
    """Write the codes of a refusal into a file, also where it is told as text."""
    from inertialcal.cli import __main__ as entry
    from inertialcal.cli.shown import output

    original: Callable[..., int] = output.errors_out

    def noted(given: Any, problems: Any, *rest: Any, **more: Any) -> int:
        os.write(to, "".join(f"{one.code}\n" for one in problems).encode())
        return original(given, problems, *rest, **more)

    for module in (entry, output):
        setattr(module, "errors_out", noted)  # noqa: B010 - its type says that it is none's to change


def _note_writes(folder: Path, aside: Path, to: int) -> None:
    """Note each path outside of two folders that is opened for writing, made, moved or removed."""
    inside = tuple(str(one.resolve()) for one in (folder, aside))
    changing = {"os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate"}

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, mode, flags = arguments[:3]
            writes = bool(isinstance(mode, str) and set(mode) & set("wax+")) or bool(
                isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
            )
            paths = [path] if writes else []
        elif event in changing:
            paths = [one for one in arguments if isinstance(one, str | bytes | os.PathLike)]
        else:
            return
        for one in paths:
            if isinstance(one, int):
                continue
            place = os.path.abspath(os.fsdecode(one))
            if not place.startswith((*inside, "/dev/", "/proc/")) and "__pycache__" not in place:
                os.write(to, f"{event} {place}\n".encode(errors="replace"))

    sys.addaudithook(hook)


# What a folder holds


def snapshot(folder: Path) -> dict[str, str]:
    """Return what each path of a folder is: kind, and hash or target."""
    return {str(one.relative_to(folder)): _identity(one) for one in sorted(folder.rglob("*"))}


def _identity(path: Path) -> str:
    mode = path.lstat().st_mode
    if stat.S_ISLNK(mode):
        return f"link {os.readlink(path)}"
    if stat.S_ISREG(mode):
        return hashlib.sha256(path.read_bytes()).hexdigest()
    return "folder" if stat.S_ISDIR(mode) else f"special {stat.S_IFMT(mode)}"


def changes(before: dict[str, str], after: dict[str, str], outputs: Sequence[str]) -> list[str]:
    """Return what changed outside the outputs: inputs changed or lost, files that nobody asked for."""
    found = []
    for path in sorted(before.keys() | after.keys()):
        if before.get(path) == after.get(path):
            continue
        if any(path == one.rstrip("/") or path.startswith(f"{one.rstrip('/')}/") for one in outputs):
            continue
        if path in before and any(one.startswith(f"{path}/") for one in outputs):
            continue
        what = "lost" if path not in after else "left over" if path not in before else "changed"
        found.append(f"{what}: {path}")
    return found


# Judging


def failures(
    words: Sequence[str], end: Ran, size: int, temporary: Sequence[str], process: Process | None = None
) -> list[str]:
    """Return what is wrong with how a command ended.

    Parameters
    ----------
    words : sequence of str
        The command.
    end : Ran
        How it ended.
    size : int
        Of its inputs. [bytes]
    temporary : sequence of str
        Temporary files that it left.
    process : Process
        What it ran in; where nothing can be printed, nothing printed is looked at.
    """
    found = [] if end.status in STATUSES else [f"exit {end.status}"]
    if end.seconds > LONGEST:
        found.append(f"{end.seconds:.1f} s")
    if end.mib * 2**20 > LARGEST + 3 * size:
        found.append(f"{end.mib:.0f} MiB")
    if warned := WARNED.search(end.err + end.out):
        found.append(f"printed {warned.group()!r}")
    if end.status in {2, 3} and "--json" not in words and not end.err.strip():
        found.append("refused without a word")
    if "--json" in words and end.status in STATUSES and (process is None or process.stdout == "file"):
        found += _json_failures(end)
    found += [f"wrote outside: {one}" for one in end.outside[:3]]
    found += [f"temporary file: {one}" for one in temporary[:3]]
    return found


def _json_failures(end: Ran) -> list[str]:
    def refused(name: str) -> NoReturn:
        raise ValueError(f"{name} in JSON")

    try:
        content = json.loads(end.out, parse_constant=refused)
        Printed.model_validate_json(end.out)
    except ValueError as error:
        return [f"--json: {str(error)[:200]}"]
    return [] if content["exit"] == end.status else ["--json says another exit status"]


def past_parser(end: Ran) -> bool:
    """Return whether a command answered, or refused for another reason than that its input cannot be parsed."""
    return end.status in ANSWERED or (bool(end.codes) and not set(end.codes) & PARSER)
