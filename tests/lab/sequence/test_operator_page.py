"""The operator's page: what is asked stands there in large letters, and a big button says that it is done."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from playwright.sync_api import Browser
from test_step_ends import lab_of

from inertialcal.lab.acquisition.acquisition import Acquisition
from inertialcal.lab.live.server import served
from inertialcal.lab.sequence.operator import Operator
from inertialcal.lab.sequence.page import OperatorContent

HOSTILE = "<img src=x onerror=alert(1)> mount it & wait"


@pytest.fixture
def asking(tmp_path: Path) -> Iterator[tuple[OperatorContent, Operator, threading.Thread]]:
    """What asks, and a thread that waits for the answer."""
    operator, stop = Operator(), threading.Event()
    content = OperatorContent(Acquisition(lab_of(tmp_path), tmp_path / "acquired"), operator)
    thread = threading.Thread(target=operator.ask, args=(HOSTILE, stop))
    thread.start()
    yield content, operator, thread
    stop.set()
    thread.join()


def test_it_takes_words_and_nothing_else(asking: tuple[OperatorContent, Operator, threading.Thread]) -> None:
    content, operator, thread = asking

    def said(word: str) -> object:
        with ThreadPoolExecutor(1) as aside:  # a browser of other tests has a loop in this thread
            found = aside.submit(lambda: asyncio.run(content.answer(word))).result()
        return None if found is None else json.loads(found)

    assert said("operator look") == {"asked": HOSTILE, "paused": False}
    assert said("operator pause") == {"asked": HOSTILE, "paused": True}
    assert said("operator explode") is None
    assert said("operator") is None
    assert said("operator go") == {"asked": HOSTILE, "paused": False}
    assert thread.is_alive()
    assert said("operator done") == {"asked": "", "paused": False}
    thread.join(10.0)
    assert not thread.is_alive()
    assert not operator.stopped


def test_a_big_button_says_that_it_is_done(
    asking: tuple[OperatorContent, Operator, threading.Thread], browser: Browser
) -> None:
    content, _, thread = asking
    with served(content, 0) as address:
        page = browser.new_page(viewport={"width": 390, "height": 800})
        try:
            odd: list[str] = []
            page.on("pageerror", lambda one: odd.append(str(one)))
            page.on("console", lambda one: odd.append(one.text))
            page.on("dialog", lambda one: odd.append(one.message))
            page.goto(address)
            page.locator("#asked").get_by_text("mount it").wait_for()
            assert page.locator("#asked").inner_text() == HOSTILE
            box = page.locator("#say-done").bounding_box()
            assert box is not None
            assert box["width"] > 300
            assert box["height"] >= 90
            page.locator("#say-done").click()
            thread.join(20.0)
            assert not thread.is_alive()
            page.locator("#say-done").wait_for(state="hidden")
            assert odd == []
        finally:
            page.close()
