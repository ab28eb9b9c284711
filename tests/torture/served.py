"""Commands in forks of one warm process, with packages of others on its path: a process of its own takes a second each.

Started as a program it reads what to run, a line of JSON each, and answers with the exit status.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

WARM = ("inertialcal.cli.__main__", "inertialcal.campaign.engine.whole", "inertialcal.report.page", "scipy.stats",
        "matplotlib.backends.backend_svg", "tomlkit", "rich.console")  # fmt: skip


class Command(Protocol):
    """A call of the command line in a folder."""

    def __call__(self, *words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
        """Return how it ended."""
        ...


@contextmanager
def served(packages: Path, aside: Path) -> Iterator[Command]:
    """Give a call of the command line, with more packages on the path; ``aside`` takes what it prints."""
    path = os.pathsep.join([str(packages), *filter(None, [os.environ.get("PYTHONPATH")])])
    printed, pipe = [aside / "out", aside / "err"], subprocess.PIPE
    env = {**os.environ, "PYTHONPATH": path}
    with subprocess.Popen([sys.executable, __file__], env=env, text=True, stdin=pipe, stdout=pipe) as server:
        assert server.stdin is not None
        assert server.stdout is not None
        asked, answers = server.stdin, server.stdout

        def call(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
            asked.write(json.dumps({"words": words, "cwd": str(cwd), "printed": [str(one) for one in printed]}) + "\n")
            asked.flush()
            status = int(answers.readline())
            return subprocess.CompletedProcess(words, status, *(one.read_text(encoding="utf-8") for one in printed))

        yield call
        asked.close()
    assert server.returncode == 0


def _run(words: Sequence[str], cwd: str, printed: Sequence[str]) -> int:
    child = os.fork()
    if not child:
        status = 99
        try:
            os.chdir(cwd)
            for number, path in enumerate(printed, start=1):
                os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
            from inertialcal.cli.__main__ import main

            main(words)
        except SystemExit as left:
            status = int(left.code or 0)
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


if __name__ == "__main__":
    for name in WARM:
        importlib.import_module(name)
    for line in sys.stdin:
        print(_run(**json.loads(line)), flush=True)
