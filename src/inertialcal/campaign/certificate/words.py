"""What a certificate says in words, on the page and in XML alike."""

from __future__ import annotations

from collections.abc import Sequence

from ...sensors.model.serial import WORDS
from .content import Conformity, Standard

TITLE = "Calibration certificate"
ONLY_THESE = "The results relate only to the items calibrated, in the state in which they were received."
REPRODUCTION = "This certificate shall not be reproduced except in full without approval of the laboratory."
UNCERTAINTY = (
    "The expanded uncertainty U is the standard uncertainty multiplied by the coverage factor k, taken from the t "
    "distribution with the degrees of freedom of each figure: the interval holds the true value with a probability of "
    "95 %. Standard uncertainties were evaluated by JCGM 100:2008. Figures given by an interval alone are not normally "
    "distributed."
)
NOT_TRACEABLE = (
    "The results are not traceable to the SI as a whole: no standard is stated, or one that is named below has no "
    "certificate that was valid at the time of the calibration."
)
EQUATION = f"From the true input x to the output v: {'; '.join(WORDS['equation'])}. M: {WORDS['matrix_order']}."
REFUTED = "No model is certified where the closed loop FAILs: readings held out were worse with it than without."
SIMULATED = (
    "SIMULATED DATA: no item was calibrated. This document shows the form of a certificate, and certifies nothing."
)


def standard_text(one: Standard) -> str:
    """Return a standard with its uncertainty, its certificate, and whether it is traceable."""
    certificate = f"certificate {one.certificate}" if one.certificate else "no certificate"
    valid = f", valid {one.valid}" if one.valid else ""
    state = "traceable by its certificate" if one.traceable else f"not traceable: {one.why}"
    return f"{one.name}: standard uncertainty {one.u}; {certificate}{valid}; {state}"


def verdict_text(one: Conformity) -> str:
    """Return a requirement with its verdict and its decision rule."""
    said = f"{one.requirement}: {one.text or 'no text'}: {one.verdict}"
    if one.verdict not in ("PASS", "FAIL"):
        said += " (no statement of conformity is made)" if one.verdict == "OPEN" else " (neither PASS nor FAIL)"
    return f"{said}. Decision rule: {one.rule}" if one.rule else said


def rules_text(every: Sequence[Conformity]) -> str:
    """Return the decision rules of requirements, each once."""
    return "; ".join(dict.fromkeys(one.rule for one in every if one.rule)) or "none"
