"""The page of a guided calibration: what `Session.shown` says, its buttons, and the sensors of a phone with it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from importlib.resources import files

from ..live.server import served
from .session import Session


class GuidePage:
    """What the page is given.

    Parameters
    ----------
    session : Session
        That is shown.
    """

    largest = 2**15  # a second of a phone is 60 samples of 56 bytes

    def __init__(self, session: Session) -> None:
        places = files(__package__)
        self.page, self.script = (
            places.joinpath(name).read_text(encoding="utf-8") for name in ("page.html", "page.js")
        )
        self._session, self._link = session, session.page_link
        if self._link is not None:
            self._link.served = True

    async def answer(self, asked: str | bytes) -> str | None:
        """Do what a page asks, and return the state; None where it asks for what is not given."""
        if isinstance(asked, bytes):
            if self._link is None or not self._link.put(asked):
                return None
        elif asked == "undo":
            self._session.undo()
        elif asked == "finish":
            self._session.finish()
        elif asked != "state":
            return None
        return self.state()

    def state(self) -> str:
        """Return what is shown as JSON."""
        session = self._session
        shown, ended = session.shown, session.ended
        content = asdict(shown) | {
            "word": shown.word, "title": session.acquisition.lab.file.lab.title, "phone": session.phone,
            "labels": dict(session.labels), "asked": dict(session.target),
            "written": {} if ended is None else dict(ended.written), "reached": ended is not None and ended.reached,
        }  # fmt: skip
        return json.dumps(content, ensure_ascii=False, allow_nan=False)


@contextmanager
def guide_page(session: Session, port: int) -> Iterator[str]:
    """Give the page of a session while the block runs; as `served`."""
    with served(GuidePage(session), port) as address:
        yield address
