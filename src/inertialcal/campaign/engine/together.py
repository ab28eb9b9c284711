"""Work on many units at once: each unit's is written for it alone, and asks where one call can serve all units.

A piece of work is a generator. Where it needs what a function gives of many at once, it writes ``yield from
ask(function, given)`` and goes on with its own answer. `together` carries all pieces on to their next question, and
answers those of one function by one call of it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from typing import NamedTuple, TypeVar, cast

T = TypeVar("T")
A = TypeVar("A")
B = TypeVar("B")


class Question(NamedTuple):
    """What a piece of work asks: a function of many, and what it is given of this one."""

    many: Callable[[Sequence[object]], Sequence[object]]
    given: object


Work = Generator[Question, object, T]


def ask(many: Callable[[Sequence[A]], Sequence[B | Exception]], given: A) -> Work[B]:
    """Return what a function of many gives of one; raise where that is an error."""
    return cast(B, (yield Question(cast("Callable[[Sequence[object]], Sequence[object]]", many), given)))


def together(works: Sequence[Work[T]]) -> list[T | Exception]:
    """Return what pieces of work come to, or the error that ended each; none ends another.

    A function that breaks down on many is asked for each by itself.
    """
    found: dict[int, T | Exception] = {}
    answers: dict[int, object] = dict.fromkeys(range(len(works)))
    while answers:
        asked: dict[Callable[[Sequence[object]], Sequence[object]], list[tuple[int, object]]] = {}
        for i, answer in answers.items():
            try:
                work = works[i]
                many, given = work.throw(answer) if isinstance(answer, Exception) else work.send(answer)
                asked.setdefault(many, []).append((i, given))
            except StopIteration as end:
                found[i] = end.value
            except Exception as error:
                found[i] = error
        answers = {}
        for many, every in asked.items():
            answers |= zip((i for i, _ in every), _answers(many, [given for _, given in every]), strict=True)
    return [found[i] for i in range(len(works))]


def _answers(many: Callable[[Sequence[object]], Sequence[object]], given: Sequence[object]) -> Sequence[object]:
    try:
        return many(given)
    except Exception as error:
        return [error] if len(given) == 1 else [each for one in given for each in _answers(many, [one])]


def alone(work: Work[T]) -> T:
    """Return what one piece of work comes to; raise the error that ended it."""
    (found,) = together([work])
    if isinstance(found, Exception):
        raise found
    return found
