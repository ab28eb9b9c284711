"""The one clock: nothing else in the lab waits or tells the time."""

from __future__ import annotations

import re
import threading
from pathlib import Path

import pytest

from inertialcal.lab import clock as module
from inertialcal.lab.clock import Clock

LAB = Path(module.__file__).parent


def test_nothing_but_the_clock_waits_or_tells_the_time() -> None:
    """A grep: no sleep, no clock of the system, no wait of a length of its own, nothing asks whether it rehearses."""
    wrong = []
    for path in LAB.rglob("*.py"):
        if path.name == "clock.py":
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if re.search(
                r"\bsleep\(|\bimport time\b|\bfrom time\b|\bdatetime\b|[sS]imulated\b.*:$|\bif .*simulat", line
            ):
                wrong.append(f"{path.name}:{number}: {line.strip()}")
            if re.search(r"\.wait\(\s*[0-9]", line) or (
                re.search(r"if .*\bspeed\b", line) and path.name != "lab_file.py"
            ):
                wrong.append(f"{path.name}:{number}: {line.strip()}")
    assert wrong == []


@pytest.mark.parametrize("speed", [1, 1000])
def test_counts_waits_and_tells_utc_alike(speed: int) -> None:
    clock = Clock(speed)
    first = clock.now()
    clock.wait(0.02 * speed)
    last = clock.now()
    monotonic, utc = last.monotonic_ns - first.monotonic_ns, last.utc_ns - first.utc_ns
    assert 0.02 * speed * 1e9 <= monotonic < 2.0 * speed * 1e9
    assert abs(monotonic - utc) < 0.01 * speed * 1e9
    assert clock.real(3.0) == 3.0 / speed


def test_a_wait_ends_when_it_is_stopped() -> None:
    clock, stop = Clock(), threading.Event()
    stop.set()
    assert clock.wait(60.0, stop)
    assert not clock.wait(-1.0)
