"""``out/`` after kills: at every system call of an exchange, at random in a real run; images of a disk after a crash.

The default suite takes a few of each; ``make torture`` all (INERTIALCAL_TORTURE=full), with a table of what was tried.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from exchanges import (
    MODES,
    NEW,
    STATES,
    Expected,
    Tally,
    check,
    killed_at,
    kills,
    kills_of_recovery,
    plant,
    replays,
    start,
)
from forked import program, warm

from inertialcal.campaign.file.example import copy_example
from inertialcal.campaign.outcome.publish import RESERVED, restore
from inertialcal.files.write.exchange import Manifest, file_digest, recover

FULL = os.environ.get("INERTIALCAL_TORTURE") == "full"
TALLIES: list[tuple[str, Tally]] = []
EACH = pytest.mark.parametrize(
    ("state", "mode"),
    [
        pytest.param(state, mode, marks=[] if number % len(MODES) == kind or FULL else pytest.mark.slow)
        for number, state in enumerate(STATES)
        for kind, mode in enumerate(MODES)
    ],
)  # each state with one of the modes in the default suite
STEP = 1 if FULL else 15  # system calls
AGAIN = 150 if FULL else 1
DRAWS, EVERY = (30, 1) if FULL else (1, 5)  # images a system call; of which one in
RUNS = 500 if FULL else 6
FRESH = 50 if FULL else 1  # of them in a process that starts anew


@pytest.fixture(scope="module", autouse=True)
def _table() -> Iterator[None]:
    yield
    if FULL:
        print(f"\n{'state':52}{'tried':>7}{'old':>7}{'new':>7}{'failed':>8}")
        for name, one in TALLIES:
            old, new = one.came_to.get("old", 0), one.came_to.get("new", 0)
            print(f"{name:52}{one.tried:7}{old:7}{new:7}{one.tried - old - new:8}")


@EACH
def test_a_kill_at_a_system_call_leaves_the_old_or_the_new(tmp_path: Path, state: str, mode: str) -> None:
    first = 1 + (list(STATES).index(state) + MODES.index(mode)) % STEP
    tally = kills(tmp_path / "campaign", state, mode, STEP, first)
    TALLIES.append((f"killed: {state}, {mode}", tally))


@EACH
def test_a_kill_of_the_recovery_does_no_more(tmp_path: Path, state: str, mode: str) -> None:
    tally = kills_of_recovery(tmp_path / "campaign", state, mode, random.Random(5), AGAIN)
    TALLIES.append((f"killed 3 times: {state}, {mode}", tally))


@pytest.mark.parametrize("mode", [MODES[0], *(pytest.param(one, marks=pytest.mark.slow) for one in MODES[1:])])
def test_a_kill_while_a_folder_that_was_not_put_in_place_is_removed(tmp_path: Path, mode: str) -> None:
    number, killed = 0, True
    new = NEW | {f"file{one}": b"new" for one in range(12)}  # so that the list is not the last to go
    while killed:
        number += 1
        out, expected = start(tmp_path / "campaign", "ours and the user's")
        ready = out.with_name(".out-ready-0123456789abcdef")
        plant(out.parent, {ready.name: {**new, "kept-1": {}}})
        digests = {name: file_digest(ready / name) for name in new}
        (ready / "SHA256SUMS").write_text(Manifest("0123456789abcdef", digests).text())
        killed = killed_at(number, partial(recover, out, RESERVED), mode)
        recover(out, RESERVED)
        assert check(out, expected, new) == "old"
    assert number > len(new)


@EACH
def test_a_disk_after_a_crash_holds_the_old_or_the_new(tmp_path: Path, state: str, mode: str) -> None:
    tally = replays(tmp_path / "campaign", state, mode, random.Random(7), DRAWS, EVERY)
    TALLIES.append((f"image: {state}, {mode}", tally))


def _run(folder: Path, fresh: bool) -> int:
    """Start `inertialcal run` as a process, anew or a fork of this one; return its number."""
    process = os.fork()
    if not process:
        try:
            os.setsid()
            nothing = os.open(os.devnull, os.O_RDWR)
            for number in range(3):
                os.dup2(nothing, number)
            if fresh:
                line = program(["run", str(folder), "-q"])
                os.execv(line[0], line)
            from inertialcal.cli.__main__ import main

            main(["run", str(folder), "-q"])
        finally:
            os._exit(0)
    return process


def test_a_run_killed_at_any_time_leaves_the_old_or_the_new(tmp_path: Path) -> None:
    warm()
    rng, tally, original = random.Random(11), Tally(), tmp_path / "original"
    copy_example("reinel1969", original)
    lasted = []
    for fresh in (False, True):
        begin = time.monotonic()
        os.waitpid(_run(original, fresh), 0)
        lasted.append(time.monotonic() - begin)
    plant(original / "out", {"mynotes.txt": b"mine", "plots": {"a": b"a"}, "pipe": None})
    expected = Expected.of(original / "out")
    for number in range(RUNS):
        folder, fresh = tmp_path / "campaign", number % (RUNS // FRESH) == 0
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(original, folder, ignore=shutil.ignore_patterns("pipe"))
        os.mkfifo(folder / "out" / "pipe")
        process = _run(folder, fresh)
        share = rng.uniform(0.0, 1.05) if number % 2 else rng.uniform(0.8, 1.05)  # many while out/ is written
        time.sleep(lasted[fresh] * share)
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        restore(folder)
        manifest = Manifest.read(folder / "out")
        assert manifest is not None
        assert all(manifest.lists(folder / "out" / name) for name in manifest.files)  # whole: as one run wrote it
        new = {name: (folder / "out" / name).read_bytes() for name in manifest.files}
        tally.add(check(folder / "out", expected, *([] if new == expected.own else [new])))
    TALLIES.append(("a real run, killed at a random time", tally))
