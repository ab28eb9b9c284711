"""The page of a guide in a browser: it says what to do, to eyes, ears and keys, and gives a phone's sensors."""

from __future__ import annotations

import asyncio
import re
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
from browsing import PHONE
from lab_pages import opened, until
from live_hand import LiveImu, live_imu
from playwright.sync_api import Browser, Page
from simulated_hand import CLEAN, Habits, only

from inertialcal.lab.guide.page import GuidePage, guide_page
from inertialcal.lab.guide.session import Asked, Session
from inertialcal.lab.guide.source import lab_for

WANTED = {"bias": "0.2 mg", "scale_factor_error": "200 ppm", "misalignment": "0.023 deg"}
ASKED = Asked(WANTED, {"gravity": "9.807 m/s2"}, labels={"z+": "<b>label</b>"})
SENSORS = ("accelerometer", "gyroscope", "linear-acceleration")


@contextmanager
def stepping(session: Session, end: bool = False) -> Iterator[None]:
    """Step a session in a thread while the block runs; with ``end``, to its files."""

    def go() -> None:
        while session.step() and not over.is_set():
            pass
        if end:
            session.end()

    over = threading.Event()
    thread = threading.Thread(target=go, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contextmanager
def guided_page(
    browser: Browser, folder: Path, habits: Habits, width: int = PHONE, end: bool = False, speed: int = 20
) -> Iterator[tuple[LiveImu, Session, Page, list[str]]]:
    with (
        live_imu(folder / "one", 5, habits, speed=speed, asked=ASKED) as (imu, session),
        guide_page(session, 0) as address, stepping(session, end), opened(browser, address, width) as (page, odd),
    ):  # fmt: skip
        yield imu, session, page, odd


@pytest.mark.parametrize(
    ("habits", "word", "text"),
    [
        (only("shakes", 1.0), "Put it down", "put it on a table or against a wall, and take the hand away"),
        (only("repeats", 0.9), "Another position", "You have shown this position already"),
    ],
    ids=["shakes", "repeats"],
)
def test_it_says_what_to_do_after_a_mistake(
    browser: Browser, tmp_path: Path, habits: Habits, word: str, text: str
) -> None:
    with guided_page(browser, tmp_path, habits, speed=6) as (_, _, page, odd):
        seen = page.evaluate(
            """([word, text]) => new Promise((found) => {
                const look = () => {
                    const all = ["word", "text", "said"].map((id) => document.getElementById(id).textContent);
                    if (all[0] === word && all[1].includes(text) && all[2].includes(text)) found(all);
                    else setTimeout(look, 10);
                };
                look();
            })""",
            [word, text],
        )
        assert seen[0] == word
        assert odd == []


def test_it_says_that_the_sensor_is_unplugged_and_goes_on_when_it_is_back(browser: Browser, tmp_path: Path) -> None:
    with guided_page(browser, tmp_path, CLEAN) as (imu, session, page, odd):
        assert until(page, lambda: "2 positions" in page.inner_text("#count"))
        imu.away.set()
        assert until(page, lambda: page.inner_text("#word") == "No signal")
        assert "plug it in again" in page.inner_text("#text")
        assert until(page, lambda: "Check the cable" in page.inner_text("#notices"))
        imu.away.clear()
        assert until(page, lambda: page.inner_text("#word") in ("Turn now", "Hold still"))
        assert until(page, lambda: "connected again" in page.inner_text("#notices"))
        count = session.shown.positions
        assert count >= 2
        assert until(page, lambda: session.shown.positions > count)
        assert odd == []


@pytest.mark.parametrize("to_its_end", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_it_is_used_by_keys_up_to_its_files(browser: Browser, tmp_path: Path, to_its_end: bool) -> None:
    with guided_page(browser, tmp_path, CLEAN, end=to_its_end) as (_, session, page, odd):
        for role, name in (
            ("status", "said"),
            ("progressbar", "rest"),
            ("img", "now"),
            ("img", "then"),
            ("log", "notices"),
        ):
            assert page.get_attribute(f"#{name}", "role") == role
        assert page.get_attribute("#said", "aria-live") == "assertive"
        assert until(page, lambda: session.shown.positions >= 2)
        page.keyboard.press("u")
        assert until(page, lambda: "Taken back" in page.inner_text("#notices"))
        assert until(page, lambda: page.locator("#then polygon").count() > 3)
        assert re.match("next: .*(up|down)", str(page.get_attribute("#then", "aria-label")))
        if to_its_end:
            assert until(page, lambda: page.inner_text("#word") == "Done")
            assert page.locator("#chart polyline").count() == 9
            assert page.locator("#figures tr").count() == 21
            assert page.locator("#figures .good").count() == 9
            assert "report" in page.inner_text("#written")
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE
        assert page.locator("b").count() == 0  # what stands on a face is text
        assert odd == []
    if to_its_end:
        assert session.ended is not None
        assert session.ended.reached


def test_two_presses_end_it(browser: Browser, tmp_path: Path) -> None:
    with guided_page(browser, tmp_path, CLEAN, 1280) as (_, session, page, odd):
        assert until(page, lambda: session.shown.positions >= 1)
        page.keyboard.press("f")
        assert until(page, lambda: page.inner_text("#finish") == "Press again to end")
        assert not session._finish.is_set()
        page.keyboard.press("f")
        assert until(page, session._finish.is_set)
        assert odd == []


def test_a_phone_sends_its_sensors(browser: Browser, tmp_path: Path) -> None:
    """Chromium's virtual sensors, which it rounds as those of a phone: it rests, and that is a position."""
    session = Session(lab_for("phone"), tmp_path / "out", Asked(settings={"gravity": "9.807 m/s2"}))
    with guide_page(session, 0) as address, opened(browser, address, PHONE) as (page, odd):
        session.start()
        with stepping(session):
            assert page.evaluate("isSecureContext")
            protocol = page.context.new_cdp_session(page)
            readings = ((0.1, 0.2, 9.8), (0.02, 0.0, 0.0), (0.0, 0.0, 0.0))
            for kind, reading in zip(SENSORS, readings, strict=True):
                given = {"available": True, "minimumFrequency": 1, "maximumFrequency": 60}
                protocol.send("Emulation.setSensorOverrideEnabled", {"enabled": True, "type": kind, "metadata": given})
                three = {"xyz": dict(zip("xyz", reading, strict=True))}
                protocol.send("Emulation.setSensorOverrideReadings", {"type": kind, "reading": three})
            assert until(page, lambda: page.is_visible("#phone"))
            page.click("#phone")
            assert until(page, lambda: session.shown.positions == 1)
            assert "sensors of this phone are used" in page.inner_text("#sensors")
            assert session.shown.lies == "z up (screen)"
            _, _, rows = session.acquisition.since("phone", 0)
            assert rows[:, 1:4].mean(axis=0) == pytest.approx([0.1, 0.2, 9.8], abs=0.051)
            assert rows[:, 4].mean() == pytest.approx(1.146, abs=0.06)  # deg/s
            page.goto("about:blank")
            assert until(page, lambda: session.shown.code == "unplugged")
            assert until(page, lambda: any("keep its screen on" in text for text in session.shown.notices))
            assert "keep its screen on" in session.shown.text
            assert "cable" not in " ".join(session.shown.notices)
        assert odd == []
    session.acquisition.stop()
    session.acquisition.wait()


@pytest.mark.parametrize("source", ["phone", "hand_held"])
def test_nothing_else_is_taken_from_a_page(tmp_path: Path, source: str) -> None:
    page = GuidePage(Session(lab_for(source), tmp_path / source, Asked()))
    wrong: list[str | bytes] = [b"", b"1234567", b"\xff" * 56, "eval", "STATE", ""]
    wrong += [bytes(56)] * (source != "phone")
    with ThreadPoolExecutor(1) as aside:  # the browser of other tests has a loop of its own here
        found = [aside.submit(lambda one: asyncio.run(page.answer(one)), one).result() for one in (*wrong, "state")]
    assert found[:-1] == [None] * len(wrong)
    assert found[-1]
