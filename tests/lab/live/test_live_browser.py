"""The page in a browser: it draws, reads on when the server was killed, and shows names as the text that they are."""

from __future__ import annotations

import json
import os
import resource
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browsing import PHONE
from lab_devices import REHEARSAL, lab_folder, rehearsed
from lab_pages import opened, until
from playwright.sync_api import Browser, Page
from shown_lab import HOSTILE, PLAIN, shown

from inertialcal.core.remarks import Remark
from inertialcal.lab.live.server import TOKEN

DRAWN = "n => { const c = document.querySelectorAll('.traces canvas')[n]; return c.width > 0 && " \
        "c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some(one => one); }"  # fmt: skip


def frames(page: Page) -> int:
    return int(page.evaluate("live().frames"))


def test_it_draws_what_comes(browser: Browser, tmp_path: Path) -> None:
    """12 channels at 1 kHz; how many frames a second come is measured and printed, as it depends on the machine."""
    with shown(tmp_path) as (made, address), opened(browser, address) as (page, odd):
        assert until(page, lambda: frames(page) > 20)
        made.say(Remark("lost_rows", "warning", "rows that are missing by the counter", where="imu", count=7))
        first, begin, used = frames(page), time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_utime
        page.wait_for_timeout(2000)
        passed = time.monotonic() - begin
        share = (resource.getrusage(resource.RUSAGE_SELF).ru_utime - used) / passed
        print(f"{(frames(page) - first) / passed:.1f} frames/s; acquisition, server and test: {share:.0%} of a core")
        assert all(page.evaluate(DRAWN, i) for i in range(len(PLAIN) + 1))
        told = page.inner_text("body")
        for text in ("gyro on the desk", "connected", "running", "temperature", "25 degC", "deg/s", "(7 x)", *PLAIN):
            assert text in told, text
        assert until(page, lambda: "gyro_y: samples are stuck at 4.25 deg/s" in page.inner_text("#remarks"))
        assert "gyro_z: samples lie at the end of the range" in page.inner_text("#remarks")
        assert odd == []


@pytest.mark.parametrize("width", [PHONE, 1440])
def test_names_are_text_and_fit(browser: Browser, tmp_path: Path, width: int) -> None:
    with (
        shown(tmp_path, names=HOSTILE, title=HOSTILE[0]) as (made, address),
        opened(browser, address, width) as (page, odd),
    ):
        made.say(Remark("lost_rows", "error", HOSTILE[1] * 5, where=HOSTILE[2]))
        assert until(page, lambda: frames(page) > 5 and "onload" in page.inner_text("#remarks"))
        assert until(page, lambda: page.inner_text(".noise h3 >> nth=0").startswith("Allan"))
        told = [page.text_content(f".traces div:nth-child({i + 1}) span") for i in range(len(HOSTILE))]
        assert told == [*HOSTILE]
        assert page.text_content("#title") == HOSTILE[0]
        assert page.locator("img, svg, b").count() == 0
        assert page.locator("script").count() == 1
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert odd == []


@contextmanager
def process(folder: Path, port: int) -> Iterator[subprocess.Popen[str]]:
    """Give a process that gives the page, once it does; it is killed at the end of the block."""
    made = subprocess.Popen(
        [sys.executable, str(Path(__file__).parents[1] / "shown_lab.py"), str(folder), str(port)], text=True,
        stdout=subprocess.PIPE, env={**os.environ, TOKEN: "k" * 24, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    with made:
        try:
            assert made.stdout is not None
            assert "token" in made.stdout.readline()
            yield made
        finally:
            made.kill()


@pytest.mark.slow
def test_it_reads_on_after_a_kill(browser: Browser, tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with opened(browser, "about:blank", PHONE) as (page, _):
        with process(tmp_path / "one", port):
            page.goto(f"http://127.0.0.1:{port}/?token={'k' * 24}")
            assert until(page, lambda: frames(page) > 5)
        assert until(page, lambda: "not connected" in page.inner_text("#link"))
        with process(tmp_path / "two", port):
            begin = time.monotonic()
            assert until(page, lambda: page.inner_text("#link") == "connected" and frames(page) > 0)
            print(f"connected again {time.monotonic() - begin:.1f} s after the server was there again")
            assert until(page, lambda: page.evaluate(DRAWN, 0))


# ---- `inertialcal live DIR`: the page of a process that follows what another one records ----

FOLDER = REHEARSAL.replace("speed = 1000", "speed = 50").replace('"60 s"', '"5 s"')


@contextmanager
def command(folder: Path, *words: str) -> Iterator[subprocess.Popen[str]]:
    """Give a command that runs; it is killed at the end of the block."""
    with subprocess.Popen(
        [sys.executable, "-m", "inertialcal", *words], cwd=folder, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, env={**os.environ, TOKEN: "k" * 24},
    ) as made:  # fmt: skip
        try:
            yield made
        finally:
            made.kill()


def address(made: subprocess.Popen[str]) -> str:
    assert made.stderr is not None
    line = made.stderr.readline()
    assert line.startswith("live: http://127.0.0.1:"), line
    return line.removeprefix("live: ").strip()


def test_what_another_process_records_is_shown_to_its_end(browser: Browser, tmp_path: Path) -> None:
    lab_folder(tmp_path, FOLDER.format(over="tcp", faults=""))
    with command(tmp_path, "acquire", "LAB.toml", "-o", "out", "-q") as acquires:
        recording, end = tmp_path / "out" / "recording.mcap", time.monotonic() + 60.0
        while not recording.exists() and time.monotonic() < end:
            time.sleep(0.02)
        with command(tmp_path, "live", "out", "--port", "0") as live:
            with opened(browser, address(live), PHONE) as (page, odd):
                assert until(page, lambda: "running" in page.inner_text("#run") and frames(page) > 5)
                assert until(page, lambda: page.evaluate(DRAWN, 0))
                assert "rehearsal" in page.inner_text("#title")
                acquires.kill()
                assert until(page, lambda: "cut off" in page.inner_text("#run"))
                assert "inertialcal acquire --seal out" in page.inner_text("#why")
                assert "not connected" in page.inner_text("#instruments")
                assert page.inner_text("#link") == "connected"  # the page is, to the process that follows
                assert odd == []
            live.send_signal(signal.SIGINT)
            _, said = live.communicate(timeout=60)
            assert live.returncode == 0, said
            assert "the acquisition was cut off" in said


def test_what_has_ended_is_shown_and_the_page_comes_back_after_a_kill(browser: Browser, tmp_path: Path) -> None:
    rehearsed(tmp_path, "tcp")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    with opened(browser, "about:blank", PHONE) as (page, _):
        with command(tmp_path, "live", "out", "--port", port, "-q") as live:
            page.goto(address(live))
            assert until(page, lambda: "ended" in page.inner_text("#run") and frames(page) > 5)
            assert "saves 3 s x" in page.inner_text("#instruments")
        assert until(page, lambda: "not connected" in page.inner_text("#link"))
        with command(tmp_path, "live", "out", "--port", port, "--json") as live:
            assert until(page, lambda: page.inner_text("#link") == "connected" and frames(page) > 0)
            assert until(page, lambda: page.evaluate(DRAWN, 0))
            live.send_signal(signal.SIGINT)
            told, _ = live.communicate(timeout=60)
    found = json.loads(told)
    assert (found["command"], found["state"], found["title"]) == ("live", "done", "rehearsal")
    assert found["instruments"][0]["rows"] > 1000
    assert "save_intervals" in {one["code"] for one in found["remarks"]}
