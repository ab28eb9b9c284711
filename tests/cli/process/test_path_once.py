"""The folder of a campaign is named once on the screen; a command to copy may name it again."""

from __future__ import annotations

from pathlib import Path

import pytest

from typed_commands import call

COMMANDS_TO_COPY = ("next: ", "Next: ", "complete. Next: ", "then: ")


def told(out: str, err: str, place: str) -> int:
    """How often a path is named, commands to copy aside."""
    lines = (out + err).replace("\n    ", " ").split("\n")
    kept = [line[: min([line.find(mark) for mark in COMMANDS_TO_COPY if mark in line], default=None)] for line in lines]
    return "\n".join(kept).count(place)


@pytest.mark.usefixtures("undrawn")
def test_demo_run_and_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "example"
    begun: list[tuple[str, ...]] = [
        ("demo", "npsat2011", "-o", str(folder)),
        ("run", str(folder)),
        ("check", str(folder)),
    ]
    for words in begun:
        status, out, err = call(capsys, *words)
        assert status in {0, 4}
        assert told(out, err, str(folder)) <= 1, words
