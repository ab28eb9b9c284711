"""The operator: what is asked of a person, and what the person says, from a terminal or a page, in any thread."""

from __future__ import annotations

import threading
from typing import Literal, get_args

from ...core.errors import InstrumentError

Word = Literal["done", "pause", "go", "stop"]
LOOK = 0.2  # [s] of the machine between two looks at whether all is to end
WORDS: tuple[Word, ...] = get_args(Word)


class Operator:
    """What a sequence and a person say to each other.

    Parameters
    ----------
    answers : bool
        Each prompt is answered by itself: a rehearsal.
    """

    def __init__(self, answers: bool = False) -> None:
        self.answers = answers
        self.asked = ""  # What is asked now; empty: nothing
        self.number = 0  # of what was asked last
        self.paused = False
        self.stopped = False
        self._said = threading.Condition()

    def say(self, word: Word, number: int | None = None) -> None:
        """Take a word: what was asked is done, pause, go on, stop.

        With the number of what was asked, another prompt, which came meanwhile, is not taken as done.
        """
        with self._said:
            if word == "done":
                self.asked = self.asked if number not in (None, self.number) else ""
            elif word == "stop":
                self.stopped = True
            else:
                self.paused = word == "pause"
            self._said.notify_all()

    def ask(self, text: str, stop: threading.Event) -> bool:
        """Ask for something and wait until it is done; return False where all is to end before.

        Raises
        ------
        InstrumentError
            ``operator_stop``.
        """
        with self._said:
            self.asked, self.number = "" if self.answers else text, self.number + 1
            while self.asked and not stop.is_set() and not self.stopped:
                self._said.wait(LOOK)
        self.check()
        return not stop.is_set()

    def wait_to_go_on(self, stop: threading.Event) -> bool:
        """Wait while it is paused; return False where all is to end before.

        Raises
        ------
        InstrumentError
            ``operator_stop``.
        """
        with self._said:
            while self.paused and not stop.is_set() and not self.stopped:
                self._said.wait(LOOK)
        self.check()
        return not stop.is_set()

    def check(self) -> None:
        """Refuse to go on after a stop.

        Raises
        ------
        InstrumentError
            ``operator_stop``.
        """
        if self.stopped:
            raise InstrumentError("the operator stopped it", code="operator_stop")
