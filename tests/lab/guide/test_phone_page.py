"""A phone's browser as others have it: gravity with either sign, sensors that are kept back, a phone that stands."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from browsing import PHONE
from lab_pages import opened, until
from playwright.sync_api import Browser, Page
from test_guide_page import stepping

from inertialcal.lab.guide.page import guide_page
from inertialcal.lab.guide.session import Asked, Session
from inertialcal.lab.guide.source import lab_for

# Events as a phone's browser sends them, 60 a second; the numbers are rounded and tremble as those of sensors do
SEND = """([force, rate]) => {
    let k = 0;
    window.sends = setInterval(() => {
        const off = 0.1 * ((k++ % 3) - 1), [x, y, z] = force.map((one) => one + off);
        const [alpha, beta, gamma] = rate === null ? [null, null, null] : rate.map((one) => one + off);
        window.dispatchEvent(new DeviceMotionEvent("devicemotion", { interval: 16,
            accelerationIncludingGravity: { x, y, z }, rotationRate: { alpha, beta, gamma } }));
    }, 16);
}"""


@contextmanager
def phone(browser: Browser, folder: Path) -> Iterator[tuple[Session, Page]]:
    """Give a session that waits for a phone, and its page, whose button is there."""
    session = Session(lab_for("phone"), folder / "out", Asked(settings={"gravity": "9.807 m/s2"}))
    with guide_page(session, 0) as address, opened(browser, address, PHONE) as (page, odd):
        session.start()
        with stepping(session):
            assert until(page, lambda: page.is_visible("#phone"))
            yield session, page
            session.finish()
        assert odd == []
    session.acquisition.stop()
    session.acquisition.wait()


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["as W3C says", "as iPhones do"])
def test_gravity_counts_with_either_sign(browser: Browser, tmp_path: Path, sign: float) -> None:
    """An iPhone that lies on its back says that z is -9.8 m/s2, and turns as all others do."""
    with phone(browser, tmp_path) as (session, page):
        page.click("#phone")
        page.evaluate(SEND, [[sign * 0.3, sign * -0.2, sign * 9.8], [1.0, 2.0, 3.0]])
        assert until(page, lambda: session.shown.positions == 1)
        assert session.shown.lies == "z up (screen)"
        _, _, rows = session.acquisition.since("phone", 0)
        assert rows[:, 1:4].mean(axis=0) == pytest.approx([0.3, -0.2, 9.8], abs=0.01)
        assert rows[:, 4:].mean(axis=0) == pytest.approx([1.0, 2.0, 3.0], abs=0.01)


def test_what_is_up_is_not_taken_from_a_phone_that_stands(browser: Browser, tmp_path: Path) -> None:
    with phone(browser, tmp_path) as (session, page):
        page.click("#phone")
        page.evaluate(SEND, [[0.0, 8.5, 4.9], [0.0, 0.0, 0.0]])
        assert until(page, lambda: "does not lie flat" in page.inner_text("#sensors"))
        assert until(page, lambda: page.is_visible("#phone"))
        page.evaluate("clearInterval(window.sends)")
        page.click("#phone")
        page.evaluate(SEND, [[0.0, 0.0, -9.8], [0.0, 0.0, 0.0]])
        assert until(page, lambda: "sensors of this phone are used" in page.inner_text("#sensors"))
        assert until(page, lambda: session.shown.lies == "z up (screen)")


KEPT_BACK = {
    "denied": 'DeviceMotionEvent.requestPermission = async () => "denied"',
    "not asked": 'DeviceMotionEvent.requestPermission = async () => { throw new Error("needs a gesture"); }',
    "blocked": "0",
}


@pytest.mark.parametrize("how", KEPT_BACK)
def test_it_says_what_to_do_where_the_sensors_are_kept_back(browser: Browser, tmp_path: Path, how: str) -> None:
    with phone(browser, tmp_path) as (session, page):
        assert "press the button below" in page.inner_text("#text")
        assert "No samples yet" in page.inner_text("#count")
        page.evaluate(f"void ({KEPT_BACK[how]})")
        page.click("#phone")
        said = {"denied": "does not allow", "not asked": "(needs a gesture)", "blocked": "sends no motion"}[how]
        assert until(page, lambda: said in page.inner_text("#sensors"))
        for browser_of in ("iPhone: close this page", "choose Allow", "Android: allow motion sensors"):
            assert browser_of in page.inner_text("#sensors")
        assert session.shown.positions == 0
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE


def test_a_phone_without_gyros_is_told_so(browser: Browser, tmp_path: Path) -> None:
    with phone(browser, tmp_path) as (_, page):
        page.click("#phone")
        page.evaluate(SEND, [[0.0, 0.0, 9.8], None])
        assert until(page, lambda: "has no gyros" in page.inner_text("#sensors"))
