"""What the header of an archive file says was done to its data, as steps of a ground model.

The archive says it in words, joined by plus signs: "temperature+gain+axial-mis-alignment" [1]_. Gain is the scale
factor; axial misalignment is the misalignment; temperature stands for bias and scale factor, whose polynomials in
temperature were applied. BiasCoeff stands there without being applied, and does not count.

References
----------
.. [1] NASA Glenn, Principal Investigator Microgravity Services: acceleration data of the station, PIMS-ISS-101 (2002).
"""

from __future__ import annotations

import re

from .header import PadHeader

STEPS = ("bias", "scale_factor", "misalignment")
MEANINGS = (
    (re.compile(r"temperature"), ("bias", "scale_factor")),
    (re.compile(r"gain"), ("scale_factor",)),
    (re.compile(r"mis-?\s?alignment"), ("misalignment",)),
)
NOT = re.compile(r"\b(no|not|without)\b[^,;]*|[^,;]*\bun(compensat|correct|calibrat|appli)[^,;]*")


def applied(header: PadHeader) -> tuple[str, ...]:
    """Return the steps that a header says were made; what follows "no", or is called uncorrected, was not."""
    said = NOT.sub("", header.quality.lower())
    found = {step for word, steps in MEANINGS if word.search(said) for step in steps}
    return tuple(step for step in STEPS if step in found)
