"""Advice of messages, obeyed as a newcomer would: the options that it names, with the data sheet's numbers."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from typed_commands import call

MOST = 3  # commands that anybody types before giving up


def filled(options: Sequence[str], sheet: Mapping[str, str]) -> list[str]:
    """Return options with what a data sheet, or whoever turned the table, says in place of the placeholders."""
    found = []
    for one in options:
        option, value = shlex.split(one)
        name = option.removeprefix("--").replace("-", "_")
        if "NUMBER" in value or "UNIT)" in value:
            value = sheet[name]
        if name == "axis" and value == "AXIS":
            value = sheet["axis"]
        assert not re.search(r"\b[A-Z]{4,}\b", value), f"placeholder left: {one}"
        found += [option, value]
    return found


def options_of(text: str) -> list[str]:
    """Return the options that a piece of advice names, each with its value."""
    flat = " ".join(text.split())
    value = r"""(?:"[^"]*"|'[^']*'|[^\s,;()"']+)"""
    return re.findall(rf"--[a-z][a-z-]* {value}(?:\([^)]*\))?", flat)


def advised(err: str) -> list[str]:
    """Return the options of the last line of a message: what to do. Of several ways, the first."""
    do = err.split("Add", 1)[1] if "Add" in err else err
    return options_of(do.split("of a digital sensor")[0])


def obeyed(capsys: pytest.CaptureFixture[str], first: Sequence[str], sheet: Mapping[str, str]) -> tuple[Any, int]:
    """Type a command, do what its messages say until it gives results; return them and how many commands it took."""
    words = list(first)
    for count in range(1, MOST + 1):
        status, out, _ = call(capsys, *words, "--json")
        content = json.loads(out)
        if status == 0:
            return content, count
        text = " ".join(f"{one['why']} {one['do']}" for one in content["errors"])
        new = filled(advised(text), sheet)
        assert new, f"no advice: {text}"
        words += new
    raise AssertionError(f"{MOST} commands: {words}")


def next_commands(capsys: pytest.CaptureFixture[str], path: str, *options: str) -> list[str]:
    """Return the commands that ``info`` says to type next, one for each recording of a file."""
    status, out, err = call(capsys, "info", path, *options)
    assert status == 0, err
    return [line.removeprefix("next: ") for line in out.splitlines() if line.startswith("next: ")]


def next_command(capsys: pytest.CaptureFixture[str], path: str, sheet: Mapping[str, str], *options: str) -> list[str]:
    """Return the words of the command that ``info`` says to type next, of a file and what is said of it."""
    (found,) = next_commands(capsys, path, *options)
    words = shlex.split(found)
    assert words[0] == "inertialcal", found
    found_words = list[str]()
    for one in words[1:]:
        option = found_words[-1].removeprefix("--").replace("-", "_") if found_words else ""
        found_words.append(sheet[option] if "NUMBER" in one or one == "AXIS" else one)
    return found_words
