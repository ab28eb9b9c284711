"""Errors that a user can act on: what, where, why it matters, what to do.

Five classes, one for each kind of cause. None of them ever reaches a terminal as a traceback:
the command line prints the parts and ends with the exit status of the class.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong, in parts."""

    what: str  # The finding, with the value given: ``"unit 'furlong' is not known"``
    where: str = ""  # ``file:row``, or key with its line; empty where the input has no place
    why: str = ""  # Why it matters
    do: str = ""  # The way out
    code: str = "refused"  # Stable word for scripts: ``"unknown_unit"``
    choices: tuple[str, ...] = ()  # Names of which one is to be chosen, for programs; the text says them too

    def __str__(self) -> str:
        """All parts on one line, the place first."""
        text = f"{self.where}: {self.what}" if self.where else self.what
        text += f" ({self.why})" if self.why else ""
        return f"{text}. {self.do}" if self.do else text

    def to_dict(self) -> dict[str, str]:
        """Return the parts as plain text, for ``--json``."""
        return {name: part for name, part in asdict(self).items() if name != "choices"}


class InertialcalError(Exception):
    """Base of every error that a user can act on; carries one or more problems."""

    exit_status = 3
    inputs: tuple[tuple[str, str], ...] = ()  # path and SHA-256 of the files that it is about, where they are known

    def __init__(
        self,
        what: str | Problem | list[Problem],
        where: str = "",
        why: str = "",
        do: str = "",
        code: str = "refused",
    ):
        if isinstance(what, str):
            problems = [Problem(what, where, why, do, code)]
        else:
            problems = [what] if isinstance(what, Problem) else list(what)
        self.problems: tuple[Problem, ...] = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in problems))


class DataError(InertialcalError):
    """The data cannot carry the answer, or cannot be read."""


class PlanError(InertialcalError):
    """The campaign file or a plan is wrong."""


class UsageError(InertialcalError):
    """The command was called wrongly."""

    exit_status = 2


class InstrumentError(InertialcalError):
    """An instrument cannot be reached, does not answer, or was asked for what its limits do not allow."""


class StoreError(InertialcalError):
    """A result cannot be written, or a stored one cannot be read back."""
