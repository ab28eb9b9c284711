"""What a user says of a reduction of noise, as words and numbers with units, turned into the settings of a plan."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

from ....core.errors import DataError, UsageError
from ....core.units import parse_quantity
from ....signals.allan.deviations import KINDS
from ....signals.allan.taus import WORDS
from ..plan import TermName

TERMS: tuple[str, ...] = get_args(TermName)
SPECTRA = ("welch", "multitaper")


def settings_of(
    deviation: str, taus: str | Sequence[float], terms: Sequence[str] | None, lines: bool, warm_up: str,
    keep_disturbed: bool, spectrum: str, segment: str | None, relative_error: str,
) -> dict[str, Any]:  # fmt: skip
    """Return settings of ``static_noise.Plan``.

    Parameters
    ----------
    deviation, taus, terms, lines, warm_up, keep_disturbed, spectrum, segment, relative_error
        As ``inertialcal.allan`` takes them.

    Raises
    ------
    UsageError
        If a word is none, or a number has no unit.
    """
    error = quantity(relative_error, "1", "relative_error", "10 %")
    if not error > 0.0:
        raise UsageError(f"relative_error: {relative_error!r}", do="Write it like 10 %", code="wrong_value")
    return {
        "deviation": one_of(deviation, tuple(KINDS), "deviation"),
        "terms": None if terms is None else [one_of(one, TERMS, "terms") for one in terms],
        "lines": lines,
        "warm_up": quantity(warm_up, "s", "warm_up", "20 s"),
        "disturbed": "keep" if keep_disturbed else "leave_out",
        "spectrum": one_of(spectrum, SPECTRA, "spectrum"),
        "segment": None if segment is None else quantity(segment, "s", "segment", "20 s"),
        "relative_error": error,
        **_taus(taus),
    }


def _taus(taus: str | Sequence[float]) -> dict[str, Any]:
    """Return averaging times: a word, or seconds, as numbers or as a text with commas between."""
    if isinstance(taus, str) and taus in WORDS:
        return {"taus": taus}
    parts = [part for part in taus.split(",") if part.strip()] if isinstance(taus, str) else taus
    try:
        return {"seconds": tuple(float(tau) for tau in parts)}
    except ValueError:
        do = f"There are: {', '.join(WORDS)}; or write seconds: 0.1,1,10"
        raise UsageError(f"taus: {taus!r}", do=do, code="wrong_value") from None


def one_of(given: str, known: Sequence[str], what: str) -> str:
    """Return a word.

    Parameters
    ----------
    given : str
        By the user.
    known : sequence of str
        Words that there are.
    what : str
        Name of the setting, for the message.

    Raises
    ------
    UsageError
        If it is none of them.
    """
    if given not in known:
        raise UsageError(f"{what}: {given!r}", do=f"There are: {', '.join(known)}", code="wrong_value")
    return given


def quantity(given: str, unit: str, what: str, like: str) -> float:
    """Return a number in a unit.

    Parameters
    ----------
    given : str
        By the user: ``"10 min"``.
    unit : str
        Of the number.
    what : str
        Name of the setting, for the message.
    like : str
        How to write it.

    Raises
    ------
    UsageError
        If it has no unit, or another one.
    """
    try:
        return float(parse_quantity(given).to(unit, difference=True))
    except DataError:
        do = f'Write a number with its unit, like "{like}"'
        raise UsageError(f"{what}: {given!r}", do=do, code="no_unit") from None
