"""Commands in a process that is like one of Windows as far as Python shows it: ``python as_windows.py COMMAND...``.

No locks, limits, doubles, affinity; folders cannot be opened, nor what is open to read brought to the disk; a name is
not given over another; and a file that is not said to be binary has its line ends changed. Libraries are imported
first, since those of this system ask which it is.
"""

import importlib
import os
import shlex
import shutil
import signal
import sys

ASKING = (
    "multiprocessing.connection", "webbrowser", "h5py", "matplotlib.backends.backend_svg", "matplotlib.figure", "numba",
    "pyarrow.csv", "pyarrow.parquet", "pydantic", "scipy.linalg", "scipy.optimize", "scipy.signal", "scipy.stats",
    "typer.main",
)  # fmt: skip
for name in ASKING:
    importlib.import_module(name)

ABSENT = ("fcntl", "resource", "termios", "pwd", "grp", "tty", "pty")
OF_OS = (
    "O_DIRECTORY", "O_NOFOLLOW", "O_CLOEXEC", "O_NONBLOCK", "O_NOCTTY", "sched_getaffinity", "uname", "fork", "getuid",
    "geteuid", "getpgid", "setsid", "killpg", "posix_fadvise", "posix_fallocate", "pread", "pwrite", "sysconf", "chown",
    "fchmod", "lchown", "fdatasync", "statvfs", "mkfifo",
)  # fmt: skip
OF_SIGNAL = ("SIGHUP", "SIGKILL", "SIGALRM", "SIGPIPE", "SIGQUIT", "SIGUSR1", "SIGSTOP", "SIGXCPU")
BINARY = 0x40000000
as_text: set[int] = set()  # descriptors
to_read: set[int] = set()
system = {name: getattr(os, name) for name in ("open", "write", "fsync", "replace", "rename")}


def opened(path, flags, mode=0o777, *, dir_fd=None):
    """Open a file, no folder."""
    assert dir_fd is None
    if os.path.isdir(path):
        raise PermissionError(13, "Permission denied", os.fspath(path))
    found = system["open"](path, flags & ~BINARY, mode)
    (as_text.discard if flags & BINARY else as_text.add)(found)
    (to_read.discard if flags & 3 else to_read.add)(found)
    return found


def written(descriptor, data):
    """Write, with other line ends where the file is not binary."""
    if descriptor not in as_text or descriptor < 3:
        return system["write"](descriptor, data)
    system["write"](descriptor, bytes(data).replace(b"\n", b"\r\n"))
    return len(data)


def synced(descriptor):
    """Bring what may be written to the disk."""
    if descriptor in to_read:
        raise OSError(9, "Bad file descriptor")
    system["fsync"](descriptor)


def replaced(source, target):
    """Give a name over that of a file, never over that of a folder."""
    if os.path.isdir(target):
        raise PermissionError(13, "Access is denied", os.fspath(target))
    system["replace"](source, target)


def renamed(source, target):
    """Give a name that is free."""
    if os.path.lexists(target):
        raise FileExistsError(17, "Cannot create a file when that file already exists", os.fspath(target))
    system["rename"](source, target)


for name in ABSENT:
    sys.modules[name] = None
for place, names in ((os, OF_OS), (signal, OF_SIGNAL)):
    for name in names:
        if hasattr(place, name):
            delattr(place, name)
os.O_BINARY = BINARY
os.open, os.write, os.fsync, os.replace, os.rename = opened, written, synced, replaced, renamed
shutil._use_fd_functions = False  # removing a folder opens it there
sys.platform = "win32"

from inertialcal.cli.__main__ import main  # noqa: E402

for line in sys.argv[1:]:
    try:
        main(shlex.split(line))
    except SystemExit as left:
        print(f"STATUS {left.code} {line}", flush=True)
