"""Words of the page: counts spelled out, quantities and severities as people say them.

A count of lines is no result, so it is written in words: digits on the page are numbers of the files.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

SMALL = (
    "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
    "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen",
)  # fmt: skip
TENS = ("", "", "twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
PLURAL = {"axis": "axes", "entry": "entries", "quantity": "quantities"}
NAMES = {
    "g_sensitivity": "g-sensitivity",
    "gauss_markov_sigma": "Gauss-Markov size",
    "gauss_markov": "Gauss-Markov",
}  # of people
VERDICTS = ("FAIL", "INCONCLUSIVE", "OPEN", "PASS")  # the worst first
SEVERITIES = ("error", "warning", "info")
SEVERITY_NAMES = {"error": "error", "warning": "warning", "info": "note"}


def count(n: int) -> str:
    """Return a count in words.

    Examples
    --------
    >>> count(0), count(12), count(34), count(120)
    ('no', 'twelve', 'thirty-four', 'more than a hundred')
    """
    if n < len(SMALL):
        return SMALL[n]
    if n < 100:
        tens, ones = divmod(n, 10)
        return TENS[tens] + (f"-{SMALL[ones]}" if ones else "")
    return "a hundred" if n == 100 else "more than a hundred"


def counted(n: int, noun: str) -> str:
    """Return a count with its noun: ``counted(2, "axis")`` is ``"two axes"``."""
    return f"{count(n)} {noun if n == 1 else PLURAL.get(noun, noun + 's')}"


def listed(names: Sequence[str]) -> str:
    """Return names as a list in a sentence: ``"x, y and z"``."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}" if names else ""


def severities(severity_of: Sequence[str]) -> str:
    """Return how many remarks there are of each severity, the serious ones first.

    Parameters
    ----------
    severity_of : sequence of str
        Severity of each remark.
    """
    parts = [
        counted(list(severity_of).count(one), SEVERITY_NAMES[one]) for one in SEVERITIES if one in set(severity_of)
    ]
    return listed(parts) or "no remark"


def tally(verdicts: Sequence[Mapping[str, Any]]) -> str:
    """Return verdicts counted in words, the worst first: ``"INCONCLUSIVE at six rates and PASS at twenty"``."""
    found = [str(one["verdict"]) for one in verdicts]
    if len(found) == 1:
        return found[0]
    return listed([f"{word} at {count(found.count(word))}" for word in VERDICTS if word in found])


def words(name: str) -> str:
    """Return the field's word for people: ``scale_factor_error`` is ``scale factor error``."""
    for written, said in NAMES.items():
        name = name.replace(written, said)
    return name.replace("_", " ")
