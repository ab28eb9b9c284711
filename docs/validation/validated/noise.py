"""Deviations of published suites, of Stable32 and of allantools; digits beside a large offset."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
from test_allan_oracle import PEERS, peer, variance
from test_allan_published import NBS14, NBS14_PRINTED, S32, SP1065_PRINTED, STABLE32, digits_off, lehmer, rows

from inertialcal.signals.allan import Deviation, allan

from .found import Line, Table, shared

LAST = 1.0  # unit of the last printed digit: two printed figures are off by one, as others found them too
AGREES = 1e-10  # relative
FACTORS = [1, 2, 3, 5, 8, 16, 32, 64, 100, 128, 512, 1024, 2048, 4000]


def tables() -> list[Table]:
    """Return the suites, and the peer on the same samples."""
    return [_printed(), _stable32(), _peer()]


def _name(deviation: str) -> str:
    return deviation.replace("_", " ")


def _printed() -> Table:
    suites: tuple[tuple[str, Any, Sequence[int], Any], ...] = (
        ("NBS14, 9 frequencies", NBS14.astype(float), (1, 2), NBS14_PRINTED),
        ("NIST SP 1065, 1,000 points", lehmer(1000), (1, 10, 100), SP1065_PRINTED),
    )
    lines = []
    for suite, y, factors, printed in suites:
        for deviation, texts in printed.items():
            found = allan(y, 1.0, quantity="rate", deviation=deviation, factors=factors).deviation[:, 0]
            off = max(digits_off(text, float(value)) for text, value in zip(texts, found, strict=True))
            lines.append(Line((suite, _name(deviation), len(texts), off), off <= LAST + 0.5))
    text = (
        "Largest difference in units of the last printed digit; at most 0.5 is what rounding allows. Two printed "
        "figures are one digit off: Hadamard of NBS14 at one sample (printed 70.80608, where the overlapping one, "
        "which is the same, is printed 70.80607), and Hadamard of SP 1065 at 100 samples (3.910860e-2 for "
        "3.910861e-2, as allantools has it too)."
    )
    heads = ("suite", "deviation", "figures", "off by units of the last digit")
    return Table("Allan deviations as published", text, heads, (0, 0, 0, 2), tuple(lines))


def _stable32() -> Table:
    base = shared() / "noise" / "allantools_reference"
    lines = []
    for data, read, place, names in S32:
        x, quantity = read(base / data)
        for deviation, files in names.items():
            figures, worst = 0, 0.0
            for name in files.split():
                table = rows(base / place.format(name))
                factors = table[:, 0].astype(int).tolist()
                found = allan(x, 1.0, quantity=quantity, deviation=deviation, factors=factors).deviation[:, 0]
                figures += len(factors)
                worst = max(worst, float(np.abs(found / table[:, 5] - 1.0).max()))
            lines.append(Line((data.split("/")[0], _name(deviation), figures, worst, STABLE32), worst <= STABLE32))
    text = (
        "What Stable32, the reference program of the field, gives for five records (a table with the tests of "
        "allantools). It prints five digits: a relative difference of up to 1e-4 can be its rounding."
    )
    heads = ("record", "deviation", "figures", "largest relative difference", "allowed")
    return Table("Stable32", text, heads, (0, 0, 0, 2, 1), tuple(lines))


def _peer() -> Table:
    rng = np.random.default_rng(3)
    white = rng.normal(size=20_001) + 5.0
    codes = 2**23 + np.random.default_rng(4).integers(-50, 50, 9_000)
    short = [m for m in FACTORS if m <= 2048]
    lines = []
    for deviation in PEERS:
        for name, x in (("white noise about 5", white), ("random walk", np.cumsum(white - 5.0))):
            own = allan(x, 1.0, quantity="rate", deviation=deviation, factors=FACTORS).deviation[:, 0]
            off = float(np.abs(own / peer(deviation, x, FACTORS)[0] - 1.0).max())
            lines.append(Line((name, _name(deviation), len(FACTORS), off, None, None), off < AGREES))
        exact = np.sqrt([variance(codes, m, deviation) for m in short])
        own, theirs = _exact(deviation, codes, short)
        offs = [float(np.abs(one / exact - 1.0).max()) for one in (own, theirs)]
        cells = ("24-bit codes about 2^23", _name(deviation), len(short), None, *offs)
        lines.append(Line(cells, offs[0] < 1e-13))
    text = (
        f"The same samples given to allantools {version('allantools')}: largest relative difference. In the lines of "
        "codes both are set beside sums of whole numbers, which are exact."
    )
    heads = ("samples", "deviation", "figures", "apart", "inertialcal off", "allantools off")
    return Table("allantools on the same samples", text, heads, (0, 0, 0, 2, 2, 2), tuple(lines))


def _exact(deviation: Deviation, codes: Any, factors: list[int]) -> tuple[Any, Any]:
    own = allan(codes, 1.0, quantity="rate", deviation=deviation, factors=factors).deviation[:, 0]
    return own, peer(deviation, codes.astype(float), factors)[0]
