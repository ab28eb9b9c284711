"""What a command prints: one JSON object alone on standard output, or text for people."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ...core.errors import Problem
from ...core.results import SCHEMA
from ...core.show.tables import aligned as table
from ...core.show.tables import clean, cleaned, short, terminal_width, wrapped
from ..encoding import json_text

__all__ = [
    "ENDING", "clean", "cleaned", "errors_out", "errors_text", "followed", "found", "json_out", "package_version",
    "problem_text", "short", "table", "terminal_width", "wrapped",
]  # fmt: skip


@dataclass
class Ending:
    """How the command ends, for an output that ends before it."""

    status: int = 0  # Exit status that the command has found
    printed: bool = False  # Whether the object of --json is


ENDING = Ending()
PARTS = ("results", "remarks", "verdicts", "errors")
TYPED = re.compile(r" = |\binertialcal ")  # in messages: to be copied, so never folded
LINE_END = re.compile(r"\s*\n\s*")  # the parser of options lists choices on lines of their own


def package_version() -> str:
    """Return the version of inertialcal."""
    try:
        return version("inertialcal")
    except PackageNotFoundError:
        return "unknown"


def json_out(command: str, content: Mapping[str, Any], status: int = 0) -> None:
    """Print the one object of ``--json``: the same keys for every command, also when refused.

    Parameters
    ----------
    command : str
        Word that was typed.
    content : mapping
        ``inputs``, ``results``, ``remarks``, ``verdicts``, ``errors``, and what else it gives; curves are left out.
    status : int
        Exit status.
    """
    ENDING.printed = True
    print(_object(command, content, status))


def _object(command: str, content: Mapping[str, Any], status: int) -> str:
    whole: dict[str, Any] = {"command": command, "version": package_version(), "schema": SCHEMA, "inputs": []}
    whole |= {name: [] for name in PARTS} | {name: part for name, part in content.items() if name != "curves"}
    whole["exit"] = status
    return json_text(whole, sys.stdout.encoding or "utf-8")


def found(status: int) -> int:
    """Keep the exit status of the command, before anything is printed; return it."""
    ENDING.status = status
    return status


def errors_out(
    given: Sequence[str],
    problems: Sequence[Problem],
    status: int,
    as_json: bool,
    inputs: Sequence[tuple[str, str]] = (),
) -> int:
    """Print what is wrong, as text or as the JSON object; return the exit status."""
    found(status)
    as_json = as_json and not ENDING.printed
    text = errors_text(given, problems, status, as_json, inputs)
    ENDING.printed |= as_json
    print(text, file=sys.stdout if as_json else sys.stderr)
    return status


def errors_text(
    given: Sequence[str],
    problems: Sequence[Problem],
    status: int,
    as_json: bool,
    inputs: Sequence[tuple[str, str]] = (),
) -> str:
    """Return what is wrong, as text or as the JSON object."""
    if as_json:
        words = [word for word in given if not word.startswith("-")]
        command = " ".join(words[:2] if words[:1] in (["plan"], ["archive"]) else words[:1])
        listed = [{"path": path, "sha256": digest} for path, digest in inputs]
        return _object(command, {"inputs": listed, "errors": [problem.to_dict() for problem in problems]}, status)
    count = [f"{len(problems)} problems"] if len(problems) > 1 else []
    return "\n".join([*map(problem_text, problems), *count])


def followed(said: str, command: str) -> str:
    """Return what was done and what to type next: on one line where both fit."""
    line, following = clean(said), f"Next: {clean(command)}"
    whole = f"{line}. {following}"
    return whole if len(whole) <= terminal_width() else f"{wrapped(line)}\n{following}"


def problem_text(problem: Problem) -> str:
    """Return a problem for people: what and where first, why and the way out indented below."""
    head = f"{problem.where}: {problem.what}" if problem.where else problem.what
    head, *below = (clean(LINE_END.sub(" ", part.strip())) for part in (head, problem.why, problem.do) if part)
    lines = [f"error: {head}", *(f"       {part}" for part in below)]
    known = sys.stderr.isatty() or "COLUMNS" in os.environ  # a program that reads messages gets each on its line
    return "\n".join(wrapped(line, " " * 9, None) if known and not TYPED.search(line) else line for line in lines)
