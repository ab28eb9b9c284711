"""A lot on a dask cluster: the same bytes, workers that vanish, a scheduler that ends."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from small_lot import digests, folder_lot, rows

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from sized import sized

UNITS = 16


@contextmanager
def cluster(folder: Path, count: int = 2) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Start a scheduler and workers as processes of their own; yield its address and all of them, it first."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "OMP_NUM_THREADS": "1"}
    folder.mkdir(exist_ok=True)
    said = folder / "scheduler.json"
    words = ["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(said)]
    many = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    dask = [sys.executable, "-m", "dask"]
    every = [subprocess.Popen([*dask, *words], **many)]  # type: ignore[call-overload]
    worker = ["worker", "--scheduler-file", str(said), "--nthreads", "1", "--no-dashboard", "--no-nanny"]
    try:
        end = time.monotonic() + 60.0
        while not said.exists() and time.monotonic() < end:
            time.sleep(0.1)
        every += [subprocess.Popen([*dask, *worker], **many) for _ in range(count)]  # type: ignore[call-overload]
        address = str(json.loads(said.read_text(encoding="utf-8"))["address"])
        yield address, every
    finally:
        for one in every:
            one.kill()
            one.wait()


def reduced(lot: Path, out: Path, address: str, tell: Callable[[int, int, str], None] | None = None) -> None:
    """Reduce a lot as soon as there are workers."""
    end = time.monotonic() + 60.0
    while True:
        try:
            ic.lot(lot, out, resume=out.exists(), scheduler=address, progress=tell)
        except InertialcalError as error:
            if error.problems[0].code != "no_workers" or time.monotonic() > end:
                raise
            time.sleep(0.3)
        else:
            return


def killing(process: subprocess.Popen[bytes]) -> Callable[[int, int, str], None]:
    """Return what kills a process when the first units are done."""

    def tell(done: int, total: int, what: str) -> None:
        if 0 < done < total:
            process.send_signal(signal.SIGKILL)

    return tell


@pytest.mark.slow
def test_a_cluster_gives_the_same_bytes_though_a_worker_vanishes(tmp_path: Path) -> None:
    lot = folder_lot(tmp_path / "lot", UNITS)
    ic.lot(lot, tmp_path / "here", workers=0)
    out = tmp_path / "out"
    with cluster(tmp_path / "cluster", 3) as (address, every):
        reduced(lot, out, address, killing(every[1]))
    assert digests(out) == digests(tmp_path / "here")


@pytest.mark.skipif(sys.platform == "win32", reason="kills")
def test_a_lot_goes_on_after_its_scheduler_was_killed(tmp_path: Path) -> None:
    lot, out = folder_lot(tmp_path / "lot", UNITS), tmp_path / "out"
    ic.lot(lot, tmp_path / "here", workers=0)
    with cluster(tmp_path / "cluster", 1) as (address, every):
        with pytest.raises(InertialcalError) as error:
            reduced(lot, out, address, killing(every[0]))
        assert error.value.problems[0].code == "no_scheduler"
        assert error.value.exit_status == 3
    again = ic.lot(lot, out, resume=True, workers=0)
    assert 0 < again.kept < UNITS
    assert digests(out) == digests(tmp_path / "here")


def starting(timer: threading.Timer) -> Callable[[int, int, str], None]:
    """Return what starts a timer when work begins."""

    def tell(done: int, total: int, what: str) -> None:
        if timer.ident is None:
            timer.start()

    return tell


def scheduler_kills(lot: Path, folder: Path, count: int, expected: dict[str, str]) -> int:
    """Kill schedulers at random while a lot is worked on, resuming it on new ones; return how many kills ended it."""
    chance, hits, made = random.Random(count), 0, 0
    codes = set[tuple[str, int]]()
    while hits < count:
        made += 1
        out = folder / f"out{made}"
        while True:
            with cluster(folder / f"cluster{hits}-{made}", 1) as (address, every):
                wait = 3.0 * chance.random()
                timer = threading.Timer(wait, every[0].kill)
                try:
                    reduced(lot, out, address, starting(timer))
                    break
                except InertialcalError as error:
                    codes.add((error.problems[0].code, error.exit_status))
                    hits += 1
                finally:
                    timer.cancel()
            if hits == count:
                ic.lot(lot, out, resume=True, workers=0)
                break
        assert [one["number"] for one in rows(out)] == list(range(UNITS))
        assert digests(out) == expected
    assert codes == {("no_scheduler", 3)}
    return hits


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="kills")
def test_many_kills_of_the_scheduler(tmp_path: Path) -> None:
    lot = folder_lot(tmp_path / "lot", UNITS)
    ic.lot(lot, tmp_path / "here", workers=0)
    assert scheduler_kills(lot, tmp_path, sized(20, 4), digests(tmp_path / "here")) == sized(20, 4)


def test_a_scheduler_that_is_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("inertialcal.lots.cluster.CONNECT", 0.5)
    lot = folder_lot(tmp_path / "lot", 1)
    with pytest.raises(InertialcalError) as error:
        ic.lot(lot, tmp_path / "out", scheduler="tcp://127.0.0.1:9")
    assert error.value.problems[0].code == "no_scheduler"
    for words in ({"scheduler": "127.0.0.1:9"}, {"scheduler": "tcp://127.0.0.1:9", "workers": 2}):
        with pytest.raises(InertialcalError) as error:
            ic.lot(lot, tmp_path / "out", **words)
        assert error.value.problems[0].code == "wrong_value"


def test_a_missing_extra_is_named_with_what_to_type(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InertialcalError) as error:
        ic.lot(folder_lot(tmp_path / "lot", 1), tmp_path / "out", scheduler="tcp://127.0.0.1:9")
    assert error.value.problems[0].do == "Type: pip install 'inertialcal[fleet]'"
