"""In-orbit flip of a triaxial accelerometer head: Chestney and Sicker, NASA TM-106980, 1996."""

from __future__ import annotations

import math

from .figures import Document, Effect
from .sams1996_bias import bias_sections
from .sams1996_means import DOC, half_difference, half_sum, means, result_tables, values
from .sams1996_text import improvements, text_sections
from .table_files import stated


def document() -> Document:
    """Return the audited document."""
    return Document(
        DOC,
        "In-orbit flip",
        'L. S. Chestney and R. J. Sicker, "In-Orbit Calibration of a SAMS Triaxial Sensor Head", NASA TM-106980, 1996',
        (*result_tables(), *bias_sections(), *text_sections()),
        _effects(),
    )


def _effects() -> tuple[Effect, ...]:
    told = stated(DOC)
    pairs = means("table07_mean_unfiltered")
    gravity, bias = (
        values("table08_gravity_unfiltered", "gravity"),
        values("table10_bias_error_unfiltered", "bias error"),
    )
    off = [abs(gravity["Y", t].value - half_difference(*(m.value for m in pairs["Y", t]))) for t in "123"]
    size = [abs(abs(bias["Y", t].value) - abs(half_sum(*(m.value for m in pairs["Y", t])))) for t in "123"]
    linear = told["accuracy_95"].value
    squares = 0.5 * math.hypot(told["t95_forward"].value, told["t95_reverse"].value)
    gains, first = improvements()
    twice = [
        2.0 * abs(one.value)
        for key, one in values("table14_bias_error_filtered", "bias error").items()
        if key[1] != "1"
    ]
    return (
        Effect(
            "Tables 8 and 10 do not follow from Table 7 on the Y axis, and Y changes sign between tables.",
            f"The unfiltered ambient acceleration of Y is off by up to {max(off):.1f} ug and the size of "
            "its bias by up to "
            f"{max(size):.1f} ug. Take Y from Tables 3 and 11, and fix its sign yourself.",
        ),
        Effect(
            "The conclusions print an accuracy of 250 ug.",
            (
                f"The text has {told['realistic_control_error'].text} ug: the head is a thousand times better "
                "than its last page says."
            ),
        ),
        Effect(
            "Corrected bias in Table 19 adds the bias error on Z and subtracts it on Y.",
            (
                f"One rule for both moves an axis by twice its bias error, {min(twice):.0f} to {max(twice):.0f} "
                "ug. A correction needs a sign."
            ),
        ),
        Effect(
            "Table 2 is headed scale factor in V/g; for Y and Z it holds a bias in ug.",
            "There is no published scale factor for Y and Z. Whoever divides by these numbers gets nonsense.",
        ),
        Effect(
            f"The accuracy of {linear} ug adds two half widths; gravity and bias are half of a sum or difference.",
            f"By the root of squares, halved, it is {squares:.2f} ug: the result is better than stated.",
        ),
        Effect(
            "The new ground model is said to be better by 6 to 20 ug.",
            (
                f"That holds at times 2 and 3 ({min(gains):.1f} to {max(gains):.1f} ug). At time 1 Z is "
                f"{-first:.1f} ug worse."
            ),
        ),
    )
