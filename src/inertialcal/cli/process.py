"""The process around a command: its standard streams, its signals, its end.

The console script alone takes charge of them (``own``); ``main`` called from Python leaves them as they are. This
module is the first that the command imports, and imports nothing that starts slowly.

- SIGINT, SIGTERM and SIGHUP raise KeyboardInterrupt in the main thread, once, so that unfinished files are removed.
  Code that runs long outside Python, or swallows the exception, gets ``GRACE``; then the process ends.
- Standard output that cannot be written raises ``OutputError``, once; standard error never fails.
- Closed file descriptors 0 to 2 are opened on the null device: the next file opened, one of the user's, would take
  them, and what is printed.
"""

from __future__ import annotations

import _thread
import atexit
import codecs
import contextlib
import errno
import io
import os
import select
import signal
import sys
import time
from collections.abc import Sequence
from types import FrameType
from typing import Any, NoReturn, TextIO

from ..core.interruption import interruption

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
GRACE = 1.5  # s from a signal to the end, whatever the main thread does
INTERRUPTED = 130
MOST = 3  # paths in a message


class OutputError(Exception):
    """Standard output cannot be written.

    Parameters
    ----------
    error : OSError
        Why.
    """

    def __init__(self, error: OSError) -> None:
        super().__init__(str(error))
        self.reader_gone = error.errno == errno.EPIPE
        closed = error.errno == errno.EBADF
        self.what = f"standard output cannot be written: {'it is closed' if closed else error.strerror}"


class _Stream(io.FileIO):
    """Standard output or standard error; after the first failure it takes everything and writes nothing."""

    def __init__(self, descriptor: int, raises: bool) -> None:
        super().__init__(descriptor, "w", closefd=False)
        self._raises = raises
        self._failed = False

    def write(self, data: Any, /) -> int:
        """Write, waiting where a pipe does not block.

        Raises
        ------
        OutputError
            At the first failure of standard output.
        """
        while not self._failed:
            try:
                n = super().write(data)
            except OSError as error:
                self._failed = True
                if self._raises:
                    raise OutputError(error) from None
            else:
                if n is not None:
                    return n
                select.select([], [self.fileno()], [])
        return memoryview(data).nbytes


def own(given: Sequence[str]) -> None:
    """Take charge of the process: its signals, then its streams.

    Parameters
    ----------
    given : sequence of str
        Words of the command line, for the message of an interruption.
    """
    interruption.noting = True
    for number in SIGNALS:
        if signal.getsignal(number) not in {signal.SIG_IGN, None}:  # as under nohup
            signal.signal(number, _on_signal)
    sys.unraisablehook = _unraisable
    with interruption.held():
        _own_streams()
        _watch(given)


def _own_streams() -> None:
    for descriptor, flags in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):  # output: written to, it fails
        try:
            os.fstat(descriptor)
        except OSError:
            opened = os.open(os.devnull, flags)
            if opened != descriptor:
                os.dup2(opened, descriptor)
                os.close(opened)
            os.set_inheritable(descriptor, True)
    from .encoding import NEAREST, nearest

    codecs.register_error(NEAREST, nearest)
    if sys.stdin is None:
        sys.stdin = open(os.devnull, encoding="utf-8")  # noqa: SIM115 - for the whole process
    sys.stdout = _stream(sys.stdout, 1, NEAREST)
    sys.stderr = _stream(sys.stderr, 2, NEAREST)


def _stream(given: TextIO | None, descriptor: int, errors: str) -> TextIO:
    if sys.platform == "win32" and isinstance(given, io.TextIOWrapper):  # a console is no file
        given.reconfigure(errors=errors)
        return given
    output = descriptor == 1
    if given is None:
        found = os.open(os.devnull, os.O_RDONLY if output else os.O_WRONLY)
        return io.TextIOWrapper(io.BufferedWriter(_Stream(found, output)), encoding="utf-8", errors=errors)
    return io.TextIOWrapper(
        io.BufferedWriter(_Stream(descriptor, output)),
        encoding="ascii" if _ascii_wanted() else given.encoding,
        errors=errors,
        line_buffering=not output or given.isatty(),
        write_through=output and bool(getattr(given, "write_through", False)),
    )


def _ascii_wanted() -> bool:
    """Tell whether LC_ALL says C, and nothing says UTF-8, which Python then takes whatever the terminal shows."""
    by_itself = not os.environ.get("PYTHONUTF8") and "utf8" not in sys._xoptions
    said = os.environ.get("LC_ALL") in {"C", "POSIX"} and not os.environ.get("PYTHONIOENCODING")
    return said and by_itself


def _on_signal(number: int, frame: FrameType | None) -> None:
    """Interrupt; a second signal changes nothing, for the end is near."""
    if not interruption.requested:
        interruption.request()


def _unraisable(unraisable: sys.UnraisableHookArgs) -> None:
    """Say nothing of an interruption that fell into a callback: the process ends all the same."""
    if unraisable.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(unraisable)


def _watch(given: Sequence[str]) -> None:
    """End the process ``GRACE`` after a signal, where the main thread does not."""

    def end() -> None:
        while True:
            os.read(signals, 1)
            time.sleep(GRACE)
            while interruption.holds:  # a write that must be whole
                time.sleep(0.01)
            if not interruption.accepted:  # the main thread may never have heard of it
                _leave(given)
            interruption.accepted = False

    if sys.platform == "win32":
        return
    signals, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    try:
        _thread.start_new_thread(end, ())
    except RuntimeError:  # no more threads: then the main thread alone
        return


def interrupted() -> str:
    """Return what an interruption leaves on disk."""
    then = f". {interruption.then}" if interruption.then else ""
    return f"interrupted; {on_disk()}{then}" if on_disk() else "interrupted: nothing was written"


def on_disk() -> str:
    """Return which results of this command are on disk, complete or not; empty for none."""
    parts = []
    for whole, said in ((True, "the results in {} are complete"), (False, "{}: incomplete")):
        paths = [path for path, complete in interruption.written.items() if complete is whole]
        more = f" and {len(paths) - MOST} more" if len(paths) > MOST else ""
        parts += [said.format(", ".join(paths[:MOST]) + more)] if paths else []
    return "; ".join(parts)


def _leave(given: Sequence[str]) -> NoReturn:
    """End now: the main thread is in code that is not Python, or waits for it."""
    from ..core.errors import Problem
    from .shown.output import ENDING, errors_text

    problem = Problem(interrupted(), code="interrupted")
    as_json = "--json" in given and not ENDING.printed
    show = "\x1b[?25h" if os.isatty(2) else ""  # the cursor, which a bar of progress has hidden
    text = errors_text(given, [problem], INTERRUPTED, as_json)
    _write(sys.stdout if as_json else sys.stderr, text if as_json else show + text)
    os._exit(INTERRUPTED)


def _write(stream: TextIO, text: str) -> None:
    """Write past the buffers, which the main thread may hold, and not at all where nobody reads."""
    descriptor = stream.fileno()
    if select.select([], [descriptor], [], 0.2)[1]:
        with contextlib.suppress(OSError):
            os.write(descriptor, f"{text}\n".encode(stream.encoding, stream.errors or "replace"))


class _NoPandas:
    """A finder of modules that finds no pandas."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> None:
        """Refuse pandas, leave the rest to other finders."""
        if name == "pandas":
            raise ImportError(name)


def without_pandas() -> None:
    """Have Arrow look for pandas now and find none: it would load it, a quarter of a second, to ask if data are its.

    What is turned into a data frame later loads it all the same. A process of others stays as it is.
    """
    if interruption.noting and "pandas" not in sys.modules:
        import pyarrow as pa

        finder: Any = _NoPandas
        sys.meta_path.insert(0, finder)
        try:
            pa.array([])
        finally:
            sys.meta_path.remove(finder)


def leave(status: int) -> NoReturn:
    """End the process with a status that nothing changes any more.

    The threads that a library keeps can abort the interpreter while it is taken down, so it is not; an interruption
    does not wait for threads.
    """
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    atexit._run_exitfuncs()  # folders for the time of the process
    sys.stderr.flush()
    if status == INTERRUPTED or "pyarrow" in sys.modules:
        os._exit(status)
    sys.exit(status)
