"""Entry point: exit status and messages for everything that can happen."""

from __future__ import annotations

import gc
import os
import sys
import tempfile
import traceback
from collections.abc import Sequence
from typing import NoReturn

from ..core.errors import InertialcalError, Problem, UsageError
from .shown.output import FOUND, errors_out

SELDOM = 200_000, 20, 20  # new objects to a search for garbage: libraries make many at the start, and keep them all


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit status.

    0 done; 1 a requirement FAILs; 2 wrong usage; 3 input refused; 4 INCONCLUSIVE; 70 internal error; 130
    interrupted. No input ends in a traceback.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    status = _run(given)
    try:
        sys.stdout.flush()
    except BrokenPipeError:  # the reader has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(status)


def entry() -> NoReturn:
    """Run the command line as a process of its own, and end it.

    Once the work is done and told, nothing may change the exit status: the threads that a library keeps can abort the
    interpreter while it is taken down, so it is not.
    """
    status = 70
    gc.set_threshold(*SELDOM)
    try:
        main()
    except SystemExit as left:
        status = int(left.code or 0)
    sys.stderr.flush()
    if "pyarrow" in sys.modules:
        os._exit(status)
    sys.exit(status)


def _run(given: list[str]) -> int:
    as_json = "--json" in given
    try:
        from typer.main import get_command

        from .app import app

        status = get_command(app).main(args=given, prog_name="inertialcal", standalone_mode=False)
        return int(status or 0)
    except SystemExit as left:  # the parser's own way out of a pipe that the reader has closed
        return FOUND[0] if left.code == 1 else int(left.code or 0)
    except InertialcalError as error:
        return errors_out(given, list(error.problems), error.exit_status, as_json, error.inputs)
    except BrokenPipeError:
        return FOUND[0]
    except KeyboardInterrupt:
        return _interrupted(given, as_json)
    except Exception as error:
        return _other(given, error, as_json)


def _other(given: list[str], error: Exception, as_json: bool) -> int:
    """Wrong usage as the parser tells it, interruption, or a fault of ours."""
    name = type(error).__name__
    if name == "Abort":
        return _interrupted(given, as_json)
    if name == "NoArgsIsHelpError" and not as_json:
        print(str(error))
        return UsageError.exit_status
    if hasattr(error, "format_message"):
        return errors_out(given, [Problem(error.format_message(), do=_help(error))], UsageError.exit_status, as_json)
    if isinstance(error, MemoryError):
        return errors_out(given, [Problem("not enough memory for this input", code="too_large")], 3, as_json)
    with tempfile.NamedTemporaryFile("w", prefix="inertialcal-", suffix=".log", delete=False) as log:
        traceback.print_exc(file=log)
    what = f"internal error ({name}): this is a fault of inertialcal, not of your input"
    return errors_out(given, [Problem(what, do=f"Please report it with {log.name}", code="internal")], 70, as_json)


def _interrupted(given: list[str], as_json: bool) -> int:
    return errors_out(given, [Problem("interrupted: nothing was written", code="interrupted")], 130, as_json)


def _help(error: Exception) -> str:
    context = getattr(error, "ctx", None)
    return f"Try: {context.command_path} --help" if context is not None else "Try: inertialcal --help"


if __name__ == "__main__":
    entry()
