"""The operator's page: what is asked stands there in large letters, and a big button says that it is done."""

from __future__ import annotations

import asyncio
import json
import socket
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from browsing import DESKTOP, HEIGHT, PHONE
from lab_pages import opened
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

    assert said("operator look") == {"asked": HOSTILE, "number": 1, "paused": False}
    assert said("operator pause") == {"asked": HOSTILE, "number": 1, "paused": True}
    assert said("operator explode") is None
    assert said("operator") is None
    assert said("operator go") == {"asked": HOSTILE, "number": 1, "paused": False}
    assert thread.is_alive()
    for text in ("operator done", "operator done ", "operator done x", "operator done -1", "operator stop 1"):
        assert said(text) is None
    assert said("operator done 2") == {"asked": HOSTILE, "number": 1, "paused": False}  # not what is asked
    assert said("operator done 1") == {"asked": "", "number": 1, "paused": False}
    thread.join(10.0)
    assert not thread.is_alive()
    assert not operator.stopped


@pytest.mark.parametrize("width", [PHONE, DESKTOP])
def test_a_big_button_says_that_it_is_done(
    asking: tuple[OperatorContent, Operator, threading.Thread], browser: Browser, width: int
) -> None:
    content, operator, thread = asking
    with served(content, 0) as address, opened(browser, address, width) as (page, odd):
        page.locator("#asked").get_by_text("mount it").wait_for()
        assert page.locator("#asked").inner_text() == HOSTILE
        box = page.locator("#say-done").bounding_box()
        assert box is not None
        assert box["width"] > 0.75 * width
        assert box["height"] >= 90
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        for name in ("#say-pause", "#say-stop"):
            small = page.locator(name).bounding_box()
            assert small is not None
            assert min(small["width"], small["height"]) >= 44  # a finger
            assert small["y"] + small["height"] < HEIGHT[width]  # without scrolling
        page.locator("#say-stop").click()  # and the question, which is declined
        assert not operator.stopped
        assert [one.partition(":")[0] for one in odd] == ["dialog"]
        page.locator("#say-pause").click()
        page.locator("#say-go").wait_for()
        assert vars(operator)["paused"] is True
        page.locator("#say-go").click()
        page.locator("#say-pause").wait_for()
        assert vars(operator)["paused"] is False
        page.locator("#say-done").click()
        thread.join(20.0)
        assert not thread.is_alive()
        page.locator("#say-done").wait_for(state="hidden")
        assert len(odd) == 1


def test_a_second_click_does_not_answer_the_next_prompt() -> None:
    operator, stop = Operator(), threading.Event()
    for number in (1, 2):
        thread = threading.Thread(target=operator.ask, args=(f"prompt {number}", stop))
        thread.start()
        while operator.number < number:
            stop.wait(0.001)
        operator.say("done", number - 1)
        assert operator.asked == f"prompt {number}"
        operator.say("done", number)
        thread.join(10.0)
        assert not thread.is_alive()


def test_a_stranger_cannot_answer(asking: tuple[OperatorContent, Operator, threading.Thread]) -> None:
    """Without the token, from another page, or by another name of this computer no word gets through."""
    content, operator, thread = asking
    with served(content, 0) as address:
        here, _, token = address.removeprefix("http://").partition("/?token=")

        def opens(token: str = token, origin: str | None = f"http://{here}", host: str = here) -> bool:
            own = f"GET /live?token={token} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            own += "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            own += "" if origin is None else f"Origin: {origin}\r\n"
            name, _, port = here.partition(":")
            with socket.create_connection((name, int(port)), timeout=20.0) as web:
                web.sendall(f"{own}\r\n".encode())
                found = web.recv(65536)
                web.sendall(b"\x81\x8f\0\0\0\0operator done 1")  # a masked frame of text, mask 0
                answer = b'"asked": ""'
                end = time.monotonic() + 2.0
                while b"101 Switching" in found and answer not in found and time.monotonic() < end:
                    found += web.recv(65536)
                return answer in found

        for wrong in ({"token": ""}, {"token": token[:-1]}, {"token": token + "x"}, {"origin": None},
                      {"origin": "http://evil.example"}, {"origin": "null"}, {"host": "evil.example"},
                      {"host": "evil.example", "origin": "http://evil.example"}):  # fmt: skip
            assert not opens(**wrong)
            assert operator.asked == HOSTILE
        assert thread.is_alive()
        assert opens()
    thread.join(10.0)
    assert not thread.is_alive()
