"""Verdicts by rule: nothing here is decided by hand.

In this order: inside the tolerance (half a unit of the last printed digit and the carried rounding of the inputs) it
follows, or, where that tolerance is above twenty half units, what it is computed from is too coarse to tell; beyond it
by one unit and 1 % at most it is rounding; then the other readings of the data that the section names; the opposite
sign; a power of a thousand or a factor between units; one wrong character. Else it does not follow.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from inertialcal.core.units import same_dimension

from .figures import Figure, Text, Word
from .printed import Printed, Recomputed, printed

ROUNDING_STEPS, ROUNDING_SHARE = 1.0, 0.01
COARSE = 20.0  # tolerance in half units of the printed figure, above which one that fits is no evidence
LEAST_DIGITS = 3  # of a figure in which one wrong digit can be told
SHARP_UNIT = 0.05  # tolerance over value, above which a factor cannot be told
SHARP_STEPS = 10.0  # tolerance in units of the last digit, above which a wrong digit cannot be told
CHANCE = 0.03  # of being one wrong character away by coincidence, above which it is no misprint
SLIPS = {"a thousand times": 1e3, "a thousandth of": 1e-3, "a million times": 1e6, "a millionth of": 1e-6}
_FUZZ = 1e-9  # of floating point, as a part of the larger number


@dataclass(frozen=True)
class Verdict:
    """The word, and what was found."""

    word: Word
    reason: str = ""


def judge(one: Figure | Text) -> Verdict:
    """Return the verdict on a figure."""
    if isinstance(one, Text):
        return _judge_text(one)
    if one.recomputed is None:
        return Verdict("cannot be told", one.why)
    if _fits(one, one.printed, one.recomputed):
        coarse = one.relation == "equal" and tolerance(one) > COARSE * max(one.printed.above, one.printed.below)
        return Verdict("too coarse") if coarse else Verdict("follows")
    if _nearly(one, one.recomputed):
        return Verdict("rounding")
    for variant in one.variants:
        if _fits(one, one.printed, variant.recomputed):
            return Verdict(variant.word, _joined(f"it is {variant.reading}", one.why))
    return _slip(one, one.recomputed) or Verdict("does not follow", one.why)


def tolerance(one: Figure) -> float:
    """Return the half unit of the printed figure and the carried rounding of the inputs."""
    if one.recomputed is None:
        return one.printed.half
    toward_zero = abs(one.recomputed.value) < abs(one.printed.value)
    return (one.printed.below if toward_zero else one.printed.above) + one.recomputed.tolerance


def _judge_text(one: Text) -> Verdict:
    if one.printed == one.needed:
        return Verdict("follows")
    if one.is_unit:
        return Verdict("follows") if same_dimension(one.printed, one.needed) else Verdict("unit", one.why)
    near = any(edit == one.needed for edit in _edits(one.printed, one.needed))
    return Verdict("misprint" if near else "does not follow", one.why)


def _fits(one: Figure, shown: Printed, found: Recomputed) -> bool:
    fuzz = _FUZZ * max(abs(shown.value), abs(found.value))
    up, down = (shown.above, shown.below) if shown.value >= 0.0 else (shown.below, shown.above)
    difference = found.value - shown.value
    high = difference <= up + found.tolerance + fuzz
    low = difference >= -(down + found.tolerance) - fuzz
    return {"equal": high and low, "at most": low, "at least": high}[one.relation]


def _nearly(one: Figure, found: Recomputed) -> bool:
    if one.relation != "equal":
        return False
    difference = abs(found.value - one.printed.value)
    beyond = ROUNDING_STEPS * one.printed.step * (1.0 + _FUZZ)
    return difference <= tolerance(one) + beyond and difference <= ROUNDING_SHARE * abs(found.value)


def _slip(one: Figure, found: Recomputed) -> Verdict | None:
    """Sign, unit or one wrong character, where the recomputed figure is sharp enough to tell."""
    if one.relation != "equal" or abs(found.value) <= found.tolerance:
        return None
    turned = Recomputed(-found.value, found.tolerance)
    if abs(found.value) > tolerance(one) and _fits(one, one.printed, turned):
        return Verdict("sign", one.why)
    for name, factor in {**SLIPS, **one.factors}.items():
        scaled = Recomputed(found.value * factor, found.tolerance * factor)
        if found.tolerance <= SHARP_UNIT * abs(found.value) and _fits(one, one.printed, scaled):
            return Verdict("unit", _joined(f"printed is {name} it", one.why))
    mended = one_character_away(one, found)
    return Verdict("misprint", _joined(f"{mended.text} fits", one.why)) if mended else None


def one_character_away(one: Figure, found: Recomputed) -> Printed | None:
    """Return the figure that fits and differs in one character, where that can be told from a coincidence."""
    edits = list(_mended(one.printed))
    chance = len(edits) * (2.0 * found.tolerance / one.printed.step + 1.0) / 10.0**one.printed.digits
    if found.tolerance > SHARP_STEPS * one.printed.step or chance > CHANCE:
        return None
    fitting = [edit for edit in edits if _fits(one, edit, found)]
    return min(fitting, key=lambda edit: abs(edit.value - found.value), default=None)


def _mended(shown: Printed) -> Iterator[Printed]:
    """Figures one wrong character away: a digit, two exchanged, one too many, the point; of the same precision."""
    candidates = set(_moved_point(shown.text)) if shown.digits > 1 else set()
    near = set(_edits(shown.text, "0123456789")) if shown.digits >= LEAST_DIGITS else set()
    for text in sorted(candidates | near):
        try:
            edit = printed(text)
        except ValueError:
            continue
        moved = edit.digits == shown.digits and edit.text not in near
        yield edit if moved else replace(edit, below=min(edit.below, shown.below), above=min(edit.above, shown.above))


def _edits(text: str, letters: str) -> Iterator[str]:
    for i, character in enumerate(text):
        if character.isdigit():
            yield from (text[:i] + letter + text[i + 1 :] for letter in dict.fromkeys(letters) if letter != character)
            yield text[:i] + text[i + 1 :]
            if text[i + 1 : i + 2].isdigit():
                yield text[:i] + text[i + 1] + character + text[i + 2 :]


def _moved_point(text: str) -> Iterator[str]:
    mantissa, mark, exponent = text.partition("e" if "e" in text else "E")
    for places in (-1, 1):
        value = float(mantissa) * 10.0**places
        decimals = max(len(mantissa.partition(".")[2]) - places, 0)
        yield f"{value:.{decimals}f}{mark}{exponent}"


def _joined(*parts: str) -> str:
    return "; ".join(part for part in parts if part)
