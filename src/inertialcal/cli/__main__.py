"""Entry point: exit status and messages for everything that can happen."""

from __future__ import annotations

import errno
import gc
import sys
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, NoReturn

from ..core.interruption import interruption
from .process import INTERRUPTED, OutputError, interrupted, leave, on_disk, own

if TYPE_CHECKING:
    from ..core.errors import Problem

SELDOM = 200_000, 20, 20  # new objects to a search for garbage: libraries make many at the start, and keep them all

# What the system refuses, wherever it is met: a name too long, a folder closed, a device full or broken.
OUTSIDE = {
    getattr(errno, name, None)
    for name in ("ENAMETOOLONG", "ELOOP", "EACCES", "EPERM", "EROFS", "ENOSPC", "EDQUOT", "EFBIG", "EIO", "ESTALE",
                 "EMFILE", "ENFILE")
} - {None}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit status.

    0 done; 1 a requirement FAILs; 2 wrong usage; 3 input refused, or output that cannot be written; 4 INCONCLUSIVE; 70
    internal error; 130 interrupted. No input ends in a traceback.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    sys.exit(_status(given))


def entry() -> NoReturn:
    """Run the command line as a process of its own, and end it."""
    given = sys.argv[1:]
    status = 70
    try:
        own(given)
        if not sys.warnoptions:
            warnings.simplefilter("ignore")  # of numpy and scipy: no message for users, who get remarks and refusals
        gc.set_threshold(*SELDOM)
        main(given)
    except SystemExit as end:
        status = int(end.code or 0)
    except BaseException:
        if not interruption.requested:
            raise
        status = _interrupted(given)  # whatever an import has made of it
    leave(status)


def _status(given: list[str]) -> int:
    """Run a command, print what is wrong, and return the exit status."""
    from ..core.errors import Problem, UsageError
    from .shown.output import ENDING, errors_out

    ENDING.status, ENDING.printed = 0, False
    try:
        try:
            status = _command(given)
        except (OutputError, KeyboardInterrupt):
            raise
        except Exception as error:
            if interruption.requested:  # a library has made something else of it
                raise KeyboardInterrupt from None
            status = _refused(given, error)
        if interruption.requested or status == INTERRUPTED:
            raise KeyboardInterrupt
        sys.stdout.flush()
    except OutputError as error:
        if error.reader_gone:  # has read enough
            return ENDING.status
        status = ENDING.status if ENDING.status in {UsageError.exit_status, 70} else 3
        return errors_out(given, [Problem(error.what, why=on_disk(), code="not_written")], status, False)
    except BrokenPipeError:
        return ENDING.status
    except KeyboardInterrupt:
        return _interrupted(given)
    return status


def _command(given: list[str]) -> int:
    from typer.main import get_command

    from .app import app
    from .shown.output import ENDING
    from .shown.progress import say_compiling

    if not {"--quiet", "-q", "--json"} & set(given):
        say_compiling()
    try:
        return int(get_command(app).main(args=given, prog_name="inertialcal", standalone_mode=False) or 0)
    except SystemExit as end:  # the parser's own way out of a pipe that the reader has closed
        return ENDING.status if end.code == 1 else int(end.code or 0)


def _refused(given: list[str], error: Exception) -> int:
    """Print a refusal, wrong usage in the parser's words, or a fault of ours; return the exit status."""
    from ..core.errors import InertialcalError, Problem, UsageError
    from .shown.output import errors_out

    as_json = "--json" in given
    name = type(error).__name__
    if isinstance(error, InertialcalError):
        return errors_out(given, list(error.problems), error.exit_status, as_json, error.inputs)
    if name == "Abort":
        return INTERRUPTED
    if name == "NoArgsIsHelpError" and not as_json:
        print(str(error))
        return UsageError.exit_status
    if hasattr(error, "format_message"):
        return errors_out(given, [Problem(error.format_message(), do=_help(error))], UsageError.exit_status, as_json)
    if (refusal := _outside(error)) is not None:
        return errors_out(given, [refusal], 3, as_json)
    what = f"internal error ({name}): this is a fault of inertialcal, not of your input"
    return errors_out(given, [Problem(what, do=_logged(error), code="internal")], 70, as_json)


def _outside(error: Exception) -> Problem | None:
    """Return what the system refuses; None for a fault of ours."""
    from ..core.errors import Problem

    if isinstance(error, MemoryError):
        return Problem("not enough memory for this input", code="too_large")
    if isinstance(error, OSError) and error.errno in OUTSIDE:
        return Problem(str(error.strerror), where=str(error.filename or ""), code="not_accessible")
    if "MPLCONFIGDIR" in str(error):  # of matplotlib, which needs a folder
        do = "Set TMPDIR or MPLCONFIGDIR to a folder that can be written"
        return Problem("no folder for temporary files", do=do, code="not_writable")
    return None


def _logged(error: Exception) -> str:
    """Write the traceback into a log; return how to report it."""
    import tempfile
    import traceback

    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="inertialcal-", suffix=".log", delete=False, encoding="utf-8", errors="backslashreplace"
        ) as log:
            traceback.print_exception(error, file=log)
    except OSError as unwritable:
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{last.filename}:{last.lineno}"
        return f"Please report it: {place}, {error} (no log: {unwritable.strerror or unwritable})".replace("\n", " ")
    return f"Please report it with {log.name}"


def _interrupted(given: list[str]) -> int:
    from ..core.errors import Problem
    from .shown.output import errors_out

    try:
        errors_out(given, [Problem(interrupted(), code="interrupted")], INTERRUPTED, "--json" in given)
        sys.stdout.flush()
    except OutputError:
        pass
    return INTERRUPTED


def _help(error: Exception) -> str:
    context = getattr(error, "ctx", None)
    return f"Try: {context.command_path} --help" if context is not None else "Try: inertialcal --help"


if __name__ == "__main__":
    entry()
