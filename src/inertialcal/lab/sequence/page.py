"""The live page of a sequence: that of an acquisition, with what the operator is asked, and a big button."""

from __future__ import annotations

import json
from importlib.resources import files

from ..acquisition.live import Shown
from ..live.content import LiveContent
from .operator import WORDS, Operator

ASKS = "operator "
MAIN = "<main>"


class OperatorContent(LiveContent):
    """What is shown of a sequence.

    Parameters
    ----------
    shown : Shown
        The acquisition.
    operator : Operator
        Who is asked.
    """

    def __init__(self, shown: Shown, operator: Operator) -> None:
        super().__init__(shown)
        own, more = (files(__package__).joinpath(name).read_text(encoding="utf-8") for name in ("page.html", "page.js"))
        self.page, self.script = self.page.replace(MAIN, f"{MAIN}\n{own}", 1), f"{self.script}\n{more}"
        self._operator = operator

    async def answer(self, asked: str | bytes) -> str | bytes | None:
        """Return the answer to what a page asks; None where it asks for what is not given."""
        if not isinstance(asked, str) or not asked.startswith(ASKS):
            return await super().answer(asked)
        said, _, number = asked.removeprefix(ASKS).partition(" ")
        word = next((one for one in WORDS if said == one), None)
        of_a_prompt = word == "done" and number.isascii() and number.isdecimal()
        if (word is None and said != "look") or (bool(number) or word == "done") != of_a_prompt:
            return None
        if word is not None:
            self._operator.say(word, int(number) if of_a_prompt else None)
        now = self._operator
        return json.dumps({"asked": now.asked, "number": now.number, "paused": now.paused})
