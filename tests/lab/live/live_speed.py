"""What the live page costs, and how late it is: 12 channels at 1 kHz from another process, a real browser, a clock.

``python tests/lab/live/live_speed.py [SECONDS]`` prints the processor time of ``inertialcal acquire --live`` with no
page, one and two, frames a second, how late a sample is drawn after it was stamped (p50, p99 of all samples), and after
how long the page is there again when the process was killed and started anew. ``make lab-speed`` calls it.
"""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from lab_devices import PACKETS, packet
from playwright.sync_api import Browser, Page, sync_playwright

RATE = 1000  # rows a second
TOKEN = "k" * 24
TICKS = os.sysconf("SC_CLK_TCK")
LAB = """schema = 1
[lab]
title = "12 channels at 1 kHz"
[instruments.imu]
link = "tcp"
address = "127.0.0.1:{port}"
dialect = "imu.toml"
interval = "1 ms"
"""
CHROMIUM = ("--no-sandbox", "--disable-gpu")


def device(server: socket.socket) -> None:
    """Send a packet each millisecond to whoever connects: white noise of 12 channels."""
    made = [packet(i, row) for i, row in enumerate(
        np.random.default_rng(1).normal(0.0, 1000.0, size=(2**16, 12)).astype(np.int64)
    )]  # fmt: skip
    while True:
        one, _ = server.accept()
        sent, begin = 0, time.monotonic()
        try:
            while True:
                due = int((time.monotonic() - begin) * RATE)
                one.sendall(b"".join(made[i % len(made)] for i in range(sent, due)))
                sent = due
                time.sleep(1.0 / RATE)
        except OSError:
            one.close()


@contextmanager
def acquiring(folder: Path, port: int, out: str) -> Iterator[subprocess.Popen[str]]:
    """Give a process that records and shows a page."""
    words = [sys.executable, "-m", "inertialcal", "acquire", "LAB.toml", "-o", out, "--live", "--port", str(port), "-q"]
    made = subprocess.Popen(words, cwd=folder, stderr=subprocess.PIPE, text=True,
                            env={**os.environ, "INERTIALCAL_LIVE_TOKEN": TOKEN})  # fmt: skip
    try:
        assert made.stderr is not None
        assert made.stderr.readline().startswith("live: ")
        yield made
    finally:
        if made.poll() is None:
            made.send_signal(signal.SIGINT)
        made.communicate(timeout=120)


def used(pid: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def share(pid: int, seconds: float) -> float:
    """Return the share of a core that a process takes over the next seconds."""
    first, begin = used(pid), time.monotonic()
    time.sleep(seconds)
    return (used(pid) - first) / (time.monotonic() - begin)


def lateness(page: Page) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return how late samples were drawn, of all samples that came in the frames of late [s]."""
    frames = np.array(page.evaluate("live().drawn"))
    return np.concatenate([
        drawn - np.linspace(before, newest, max(round((newest - before) * RATE), 1) + 1)[1:]
        for drawn, before, newest in frames
    ])  # fmt: skip


def opened(browser: Browser, port: int) -> Page:
    """Open the page, and wait until it draws."""
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.goto(f"http://127.0.0.1:{port}/?token={TOKEN}")
    until(page, "live().frames > 40")
    return page


def until(page: Page, holds: str) -> None:
    """Wait until something holds in the page."""
    end = time.monotonic() + 60.0
    while not page.evaluate(holds):  # the policy of the page lets no function wait in it
        assert time.monotonic() < end, holds
        time.sleep(0.01)


def main(seconds: float) -> None:
    """Measure, and print."""
    server = socket.create_server(("127.0.0.1", 0))
    sender = os.fork()
    if sender == 0:
        device(server)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    try:
        with tempfile.TemporaryDirectory() as name, sync_playwright() as play:
            folder = Path(name)
            (folder / "LAB.toml").write_text(LAB.format(port=server.getsockname()[1]))
            (folder / "imu.toml").write_text(PACKETS)
            browser = play.chromium.launch(executable_path="/usr/bin/chromium", args=[*CHROMIUM])
            with acquiring(folder, port, "one") as made:
                time.sleep(5.0)
                print(f"no page: {share(made.pid, seconds):.1%} of a core", flush=True)
                page = opened(browser, port)
                time.sleep(3.0)
                first, begin = page.evaluate("live().frames"), time.monotonic()
                cost = share(made.pid, seconds)
                rate = (page.evaluate("live().frames") - first) / (time.monotonic() - begin)
                late = lateness(page)
                print(f"one page: {cost:.1%} of a core, {rate:.1f} frames/s; drawn after p50 "
                      f"{1e3 * np.quantile(late, 0.5):.0f} ms, p99 {1e3 * np.quantile(late, 0.99):.0f} ms "
                      f"({len(late):,} samples)", flush=True)  # fmt: skip
                other = opened(browser, port)
                time.sleep(3.0)
                print(f"two pages: {share(made.pid, seconds):.1%} of a core", flush=True)
                other.close()
                made.kill()
                made.wait()
                until(page, "!live().connected")
            with acquiring(folder, port, "two"):
                begin = time.monotonic()
                until(page, "live().connected && live().frames > 0")
                print(f"drawn again {time.monotonic() - begin:.1f} s after the server was there again")
            browser.close()
    finally:
        os.kill(sender, signal.SIGKILL)
        os.waitpid(sender, 0)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 20.0)
