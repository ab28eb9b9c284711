"""Completion in bash: the protocol that the shell speaks, with a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from inertialcal.rigs import RIGS, titles


def completed(line: str) -> list[str]:
    words = line.split(" ")
    spoken = {"_INERTIALCAL_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    call = "import sys; sys.argv = ['inertialcal']; from inertialcal.cli.__main__ import entry; entry()"
    found = subprocess.run(
        [sys.executable, "-c", call], env=os.environ | spoken, capture_output=True, text=True, timeout=120, check=False
    )
    assert found.stderr == ""
    return found.stdout.split()


FAULTS = {name for name in RIGS["rate_table"].every_fault if name.startswith("s")}


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("inertialcal rate", {"rate-table"}),
        ("inertialcal allan --sample", {"--sample-rate"}),
        ("inertialcal demo m", {name for name in titles() if name.startswith("m")}),
        ("inertialcal simulate six", {name for name in titles() if name.startswith("six")}),
        ("inertialcal simulate rate_table --fault s", FAULTS),
    ],
)
def test_words_that_are_offered(line: str, expected: set[str]) -> None:
    assert expected
    assert set(completed(line)) == expected


@pytest.mark.slow
def test_the_script_for_bash_completes(tmp_path: Path) -> None:
    program = tmp_path / "inertialcal"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m inertialcal.cli "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    env = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    typed = """eval "$(inertialcal --show-completion bash)"; complete -p inertialcal
        COMP_WORDS=(inertialcal simulate six) COMP_CWORD=2
        _inertialcal_completion inertialcal; printf '%s\n' "${COMPREPLY[@]}" """
    done = subprocess.run(["bash", "-c", typed], env=env, capture_output=True, text=True, timeout=120, check=False)
    first, *words = done.stdout.splitlines()
    assert first.startswith("complete ")
    assert set(words) == {name for name in titles() if name.startswith("six")}
