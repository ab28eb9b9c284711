"""Workers, parent and scheduler killed at random: every unit once, the same bytes, nobody left over."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest
from small_lot import digests, folder_lot, rows

import inertialcal as ic
from inertialcal.campaign.engine import engine
from inertialcal.lots import block as block_module
from inertialcal.lots import workers as workers_module
from inertialcal.lots.ledger import FILE

UNITS = 24
LEAST = 0.3  # s, before the first kill
COMMAND = [sys.executable, "-c", "import sys; from inertialcal.cli.__main__ import entry; entry()"]

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")


@pytest.fixture(scope="module")
def lot(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    """A lot, and what it gives undisturbed."""
    root = tmp_path_factory.mktemp("kills")
    made = folder_lot(root / "lot", UNITS)
    ic.lot(made, root / "out", workers=0)
    return made, digests(root / "out")


def children(parent: int) -> list[int]:
    """Return the processes below a process."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, above = path.read_text(encoding="utf-8").rpartition(")")[2].split()[:2]
        except OSError:
            continue
        if int(above) == parent and state != "Z":
            found.append(int(path.parent.name))
    return found


def alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def gone(processes: set[int], within: float = 10.0) -> bool:
    end = time.monotonic() + within
    while any(alive(one) for one in processes) and time.monotonic() < end:
        time.sleep(0.05)
    return not any(alive(one) for one in processes)


def begun(lot: Path, out: Path, *words: str) -> subprocess.Popen[str]:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "OMP_NUM_THREADS": "1"}
    resume = ["--resume"] if out.exists() else []
    return subprocess.Popen(
        [*COMMAND, "lot", str(lot), "-o", str(out), *(words or ("--workers", "2")), *resume, "--json"],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )


def kills(chance: random.Random, lot: Path, out: Path, count: int) -> int:
    """Kill workers and parents at random moments of their work until it is done; return how many kills there were."""
    hits, seen = 0, set[int]()
    process = begun(lot, out)
    while hits < count and process.poll() is None:
        victims = children(process.pid)
        if not victims:
            time.sleep(0.02)
            continue
        time.sleep(1.5 * chance.random())
        victims = children(process.pid)
        seen |= {*victims}
        victim = chance.choice(victims) if victims and chance.random() < 0.6 else process.pid
        try:
            os.kill(victim, signal.SIGKILL)
        except ProcessLookupError:
            continue
        hits += 1
        if victim == process.pid:
            process.communicate()
            assert gone(seen), "workers outlive their parent"
            process = begun(lot, out)
    said, errors = process.communicate(timeout=300)
    assert process.returncode == 1, errors
    assert json.loads(said)["counts"]["units"] == UNITS
    assert gone(seen)
    return hits


def check(out: Path, expected: dict[str, str]) -> None:
    assert [one["number"] for one in rows(out)] == list(range(UNITS))
    assert digests(out) == expected


def test_kills_of_workers_and_parent(lot: tuple[Path, dict[str, str]], tmp_path: Path) -> None:
    assert kills(random.Random(1), lot[0], tmp_path / "out", 2) >= 1
    check(tmp_path / "out", lot[1])


@pytest.mark.slow
def test_many_kills_of_workers_and_parent(lot: tuple[Path, dict[str, str]], tmp_path: Path) -> None:
    hits, seed = 0, 0
    while hits < 20:
        seed += 1
        out = tmp_path / f"out{seed}"
        hits += kills(random.Random(seed), lot[0], out, 20 - hits)
        check(out, lot[1])


def test_an_interruption_leaves_a_lot_that_goes_on(lot: tuple[Path, dict[str, str]], tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = begun(lot[0], out)
    seen: set[int] = set()
    end = time.monotonic() + 60.0
    while not (children(process.pid) and (out / FILE).is_file()) and time.monotonic() < end:
        time.sleep(0.02)
    time.sleep(LEAST)
    seen |= {*children(process.pid)}
    os.killpg(process.pid, signal.SIGTERM)  # to all of them, as a terminal does
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 130
    told = json.loads(said)["errors"][0]["what"]
    assert "incomplete. Go on with it by --resume" in told
    assert gone(seen)
    process = begun(lot[0], out)
    process.communicate(timeout=300)
    assert process.returncode == 1
    check(out, lot[1])


@contextmanager
def poisoned(monkeypatch: pytest.MonkeyPatch, serial: str, kill: Callable[[int], Any]) -> Iterator[None]:
    """Have a unit end the process that works on it."""
    alone = engine.preparing

    def preparing(campaign: Any, *rest: Any, **more: Any) -> Any:
        if campaign.file.item.serial == serial:
            kill(os.getpid())
        return alone(campaign, *rest, **more)

    monkeypatch.setattr(block_module, "preparing", preparing)
    yield


def test_a_unit_that_kills_its_worker_twice_is_quarantined_and_the_others_are_as_they_were(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = folder_lot(tmp_path / "lot", 16)
    monkeypatch.setattr(workers_module, "can_fork", lambda: True)
    ends: list[int] = []
    with poisoned(monkeypatch, "u003", lambda process: os.kill(process, signal.SIGKILL)):
        outcome = ic.lot(made, tmp_path / "out", workers=2, progress=lambda *said: ends.append(said[0]))
    found = rows(tmp_path / "out")
    assert [str(one["serial"]) for one in found if one["reason_code"] == "worker_killed"] == ["u003"]
    assert outcome.counts["quarantined"] == 1
    monkeypatch.undo()
    assert ic.lot(made, tmp_path / "out", resume=True, workers=0).redone == 1  # it is tried again when it is asked for
    ic.lot(made, tmp_path / "other", workers=0)
    assert digests(tmp_path / "out") == digests(tmp_path / "other")


def test_a_worker_that_is_killed_while_it_sends_a_block_is_replaced(
    lot: tuple[Path, dict[str, str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Half of a block stands in the pipe, and nobody writes the rest: the lot hung for ever."""
    made, expected = lot
    parent, told, send = os.getpid(), tmp_path / "killed", Connection._send  # type: ignore[attr-defined]

    def half(self: Connection, given: bytes, write: Callable[..., int] = os.write) -> None:
        if os.getpid() != parent and len(given) > 2_000 and not told.exists():
            told.touch()
            os.write(self.fileno(), given[: len(given) // 2])
            os.kill(os.getpid(), signal.SIGKILL)
        send(self, given, write)

    monkeypatch.setattr(Connection, "_send", half)
    monkeypatch.setattr(workers_module, "can_fork", lambda: True)  # also where a test before left a thread
    monkeypatch.setattr(workers_module, "STUCK", 1.0)
    ic.lot(made, tmp_path / "out", workers=2)
    assert told.exists()
    assert digests(tmp_path / "out") == expected
