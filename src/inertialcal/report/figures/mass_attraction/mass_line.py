"""Line of a moved mass among its side bands, and autocorrelation of the readings.

Above, the amplitude at each frequency of the reduced readings: the line of the drive, the lines next to it, the
others. Below, the autocorrelation of the reduced readings, with and without the line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "mass_line"
SHOWS = (
    "Above, amplitude of the reduced readings over frequency: the drive, lines next to it,"
    " others; below, autocorrelation over lag of the reduced readings, with and without the line"
)
ROLES: dict[str, tuple[str, dict[str, Any]]] = {
    "": ("other lines", {"color": COLOURS["quiet"], "marker": ".", "markersize": 3.0}),
    "beside": ("next to it: noise", {"color": COLOURS["orange"], "marker": "s", "markersize": 3.4}),
    "drive": ("the drive", {"color": COLOURS["vermilion"], "marker": "o", "markersize": 4.6}),
}


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run."""
    lags = {_key(one): one for one in curves(results, "mass_correlation")}
    found = []
    for one in curves(results, "mass_spectrum"):
        lag = lags.get(_key(one))
        if lag is not None and len(finite(numbers(one, "amplitude"))) > 1:
            test, axis = str(one.get("test", "")), str(one.get("axis", ""))
            found.append(Picture(NAME, test, axis, finding(one), SHOWS, (1.8, 1.3), partial(draw, one, lag),
                                 share_x=False, data=(lag, one)))  # fmt: skip
    return found


def _key(curve: Curve) -> tuple[str, str]:
    return str(curve.get("test", "")), str(curve.get("recording", ""))


def finding(spectrum: Curve) -> str:
    """Return the finding: the line over the mean of the lines next to it."""
    amplitude, role = numbers(spectrum, "amplitude"), np.array(words(spectrum, "role"))
    line, beside = finite(amplitude[role == "drive"]), finite(amplitude[role == "beside"])
    name = plain(spectrum.get("recording", ""))
    if not len(line) or not len(beside) or not beside.mean() > 0.0:
        return f"{name}: no lines next to that of the drive"
    return f"{name}: the line of the drive is {number(float(line[0] / beside.mean()), 2)} times those next to it"


def draw(spectrum: Curve, correlation: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw spectrum and correlation of a run."""
    above, below = axes
    frequency = numbers(spectrum, "frequency")
    amplitude, role = numbers(spectrum, "amplitude"), np.array(words(spectrum, "role"))
    for name, (label, look) in ROLES.items():
        mine = (role == name) & np.isfinite(amplitude)
        if mine.any():
            above.vlines(frequency[mine], 0.0, amplitude[mine], color=look["color"], linewidth=1.2)
            above.plot(frequency[mine], amplitude[mine], linestyle="none", label=label, **look)
    above.set_ylim(bottom=0.0)
    above.locator_params(axis="x", nbins=5)
    lag = numbers(correlation, "lag")
    below.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    below.plot(lag, numbers(correlation, "reduced"), color=COLOURS["vermilion"], linewidth=1.1,
               label="reduced")  # fmt: skip
    below.plot(lag, numbers(correlation, "noise"), color=COLOURS["ink"], linewidth=1.1, linestyle="--",
               label="without the line")  # fmt: skip
    set_title(above, title)
    set_labels(
        above, with_unit("frequency", unit(spectrum, "frequency")), with_unit("amplitude", unit(spectrum, "amplitude"))
    )
    set_labels(
        below, with_unit("lag", unit(correlation, "lag")), with_unit("correlation", unit(correlation, "reduced"))
    )
    seen = dict(zip(*reversed(above.get_legend_handles_labels()), strict=True))
    seen |= dict(zip(*reversed(below.get_legend_handles_labels()), strict=True))
    set_legend(below, list(seen.values()))
