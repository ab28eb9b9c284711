"""Instants: with a time zone, or UNIX seconds; an epoch with a digit too many is named."""

from __future__ import annotations

import pytest

from inertialcal.campaign.clock_text import read_instant


def test_text_and_number_are_the_same_instant() -> None:
    assert read_instant("2010-04-28T15:10:00Z") == read_instant(1272467400) == 1272467400 * 10**9
    assert read_instant("2010-04-28T17:10:00+02:00") == read_instant(1272467400.0)
    assert read_instant("1970-01-01T00:00:00.000001Z") == 1000


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (12833581390, "11 digits: neither s nor ms"),  # thesis, Appendix B, FL2-2c (errata)
        (1272467400000, "no UNIX time in seconds"),
        (-5, "no UNIX time in seconds"),
        (float("nan"), "no UNIX time in seconds"),
        ("2010-04-28T15:10:00", "does not say its time zone"),
        ("yesterday", "'yesterday' is no time"),
        (True, "True is no time"),
        (None, "None is no time"),
    ],
)
def test_what_is_no_instant_is_refused(given: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        read_instant(given)
