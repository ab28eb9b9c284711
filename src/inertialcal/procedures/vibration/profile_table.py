"""A profile as a table: nodes and slopes, level of each segment and band, velocity and displacement.

What ``vibration profile`` and ``inertialcal.vibration_profile`` do. All figures are exact integrals of the profile
(``signals.vibration.profile``); they have no uncertainty but that of the profile itself. Levels of 3 sigma are three
times the root mean square, which Gaussian noise exceeds in 0.27 % of all time; peaks are higher.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.curve import Column, Curve
from ...core.errors import DataError, UsageError
from ...core.key import At, Key, Member
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import remarks_line
from ...core.show.rounding import number
from ...core.show.tables import Block, Table, html, text
from ...core.units import factor, parse_quantity, same_dimension
from ...files.source import load
from .density import DENSITY, level_of
from .plan import LEVEL
from .profile_file import Node, StatedProfile, completed, read_profile

if TYPE_CHECKING:
    from pandas import DataFrame

VELOCITY, DISPLACEMENT, LEVEL_DENSITY = "velocity_rms", "displacement_rms", "spectral_density"
OVERALL = ((LEVEL, 0, "m/s^2", "g"), (VELOCITY, 1, "m/s", "mm/s"), (DISPLACEMENT, 2, "m", "mm"))
SIGMAS = 3.0
BAND = re.compile(r"\s*([0-9.eE+]+)\s*(?:Hz)?\s*(?:\.\.|-|to)\s*([0-9.eE+]+)\s*(?:Hz)?\s*", re.IGNORECASE)
TEST = "profile"


@dataclass(frozen=True, eq=False)
class ProfileTable:
    """A profile with its levels.

    Parameters
    ----------
    stated : StatedProfile
        As read.
    bands : tuple of (float, float)
        Further bands that were asked for [Hz].
    inputs : mapping of str to str
        SHA-256 by path.
    """

    stated: StatedProfile
    bands: tuple[tuple[float, float], ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict[str, str])

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """Where slopes, levels and the overall level contradict each other."""
        return self.stated.remarks

    @property
    def rows(self) -> tuple[Row, ...]:
        """Overall acceleration, velocity and displacement; acceleration of each segment and band."""
        profile = self.stated.profile
        found = [Row(Key(name), profile.rms(integrals=k) * factor(si, unit), None, unit, test=TEST)
                 for name, k, si, unit in OVERALL]  # fmt: skip
        for low, high in [*self.segments, *self.bands]:
            label = Member("band", f"{number(low, 6)} to {number(high, 6)} Hz")
            value = profile.rms(low, high) * factor("m/s^2", "g")
            found.append(Row(Key(LEVEL), value, None, "g", member=label, test=TEST))
        levels = profile.density * factor(DENSITY, self.stated.unit)
        for f, level in zip(profile.frequency.tolist(), levels.tolist(), strict=True):
            found.append(Row(Key(LEVEL_DENSITY, at=At("frequency", f, "Hz")), level, None, self.stated.unit, test=TEST))
        return tuple(found)

    @property
    def segments(self) -> list[tuple[float, float]]:
        """Bands between nodes [Hz]."""
        f = self.stated.profile.frequency.tolist()
        return [(a, b) for a, b in pairwise(f) if b > a]

    @property
    def results(self) -> dict[str, Any]:
        """Rows, nodes, segments and contradictions as ``--json`` has them."""
        profile, stated = self.stated.profile, self.stated
        levels = profile.density * factor(DENSITY, stated.unit)
        nodes = [
            {"frequency": f, "level": level, "unit": stated.unit, "stated": said}
            for f, level, said in zip(profile.frequency.tolist(), levels.tolist(), stated.stated, strict=True)
        ]
        segments = [
            {"low": a, "high": b, "slope": slope, "rms": profile.rms(a, b) * factor("m/s^2", "g"), "unit": "g"}
            for a, b, slope in zip(profile.frequency.tolist(), profile.frequency.tolist()[1:],
                                   profile.slopes.tolist(), strict=False)
        ]  # fmt: skip
        wrong = [
            {"low": one.low, "high": one.high, "stated_slope": one.stated, "slope": one.implied, "knee": one.knee}
            for one in stated.contradictions
        ]
        columns = {
            "frequency": Column(profile.frequency, "Hz"),
            "density": Column(levels, stated.unit),
        }
        if stated.by_slopes is not None:
            columns["by_slopes"] = Column(stated.by_slopes.frequency, "Hz")
        return {
            "nodes": nodes,
            "segments": segments,
            "contradictions": wrong,
            "results": [row.to_dict() for row in self.rows],
            "curves": [Curve("vibration_profile", "", columns).to_dict(TEST)],
        }

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: nodes with the slope behind each, overall levels, bands."""
        profile, stated = self.stated.profile, self.stated
        levels = profile.density * factor(DENSITY, stated.unit)
        total = profile.power()
        nodes = []
        for i, f in enumerate(profile.frequency.tolist()):
            last = i == len(profile.frequency) - 1
            high = f if last else float(profile.frequency[i + 1])
            rms = "" if last else number(profile.rms(f, high) * factor("m/s^2", "g"), 5)
            share = "" if last else f"{100.0 * profile.power(f, high) / total:.1f} %"
            slope = "" if last else f"{profile.slopes[i]:+.2f}"
            mark = "" if stated.stated[i] else "by slope"
            nodes.append((number(f, 6), number(float(levels[i]), 5), mark, slope, rms, share))
        heads = ("frequency [Hz]", f"level [{stated.unit}]", "", "slope [dB/octave]", "rms [g]", "of the power")
        grid = Table(heads, nodes, "nodes, and the segment behind each", (0, 1, 3, 4, 5))
        overall = []
        for name, k, si, unit in OVERALL:
            value = profile.rms(integrals=k) * factor(si, unit)
            overall.append((name.replace("_", " ").replace("rms", "").strip(), number(value, 5),
                            number(SIGMAS * value, 5), unit))  # fmt: skip
        whole = Table(("overall", "1 sigma", "3 sigma", "unit"), overall, "", (1, 2))
        found: list[Block] = [grid, whole]
        if self.bands:
            rows = [(f"{number(a, 6)} to {number(b, 6)} Hz", number(profile.rms(a, b) * factor("m/s^2", "g"), 5))
                    for a, b in self.bands]  # fmt: skip
            found.append(Table(("band", "rms [g]"), rows, "", (1,)))
        return tuple(found)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text((*self.parts(), *remarks_line(self.remarks)))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html((*self.parts(), *remarks_line(self.remarks)))


def vibration_profile(profile: str | Path | Mapping[str, str], *, bands: Sequence[str] | str = ()) -> ProfileTable:
    """Return a profile of a random vibration as a table: slopes, overall level and that of bands, contradictions.

    Parameters
    ----------
    profile : path, or mapping of str to str
        File with nodes (CSV or TOML); or levels by frequency: ``{"20 Hz": "0.01 g2/Hz", "80 Hz": "0.04 g2/Hz"}``.
    bands : sequence of str
        Further bands: ``"20..100"`` [Hz].

    Returns
    -------
    ProfileTable
        Printable; ``.rows``, ``.results``, ``.stated.profile``, ``.remarks``.

    Raises
    ------
    UsageError
        If a band cannot be meant.
    DataError
        If the profile cannot be read, or its nodes do not make one.
    """
    if isinstance(profile, Mapping):
        stated, inputs = _of_levels(profile), dict[str, str]()
    else:
        stated = read_profile(profile)
        inputs = {str(profile): load(profile).sha256}
    chosen = tuple(_band(one, stated) for one in ([bands] if isinstance(bands, str) else bands))
    return ProfileTable(stated, chosen, inputs)


def _of_levels(levels: Mapping[str, str]) -> StatedProfile:
    nodes, unit = [], ""
    for frequency, level in levels.items():
        f = parse_quantity(frequency)
        if not same_dimension(f.unit, "Hz"):
            do = 'Write {"20 Hz": "0.01 g2/Hz", ...}'
            raise DataError(f"node {frequency!r}: {level!r}", do=do, code="wrong_unit")
        density, of_level = level_of(level)
        nodes.append(Node(f.to("Hz"), density))
        unit = unit or of_level.unit
    return completed(nodes, [None] * max(len(nodes) - 1, 0), unit)


def _band(said: str, stated: StatedProfile) -> tuple[float, float]:
    match = BAND.fullmatch(said)
    low, high = (float(one) for one in match.groups()) if match else (math.nan, math.nan)
    if not 0.0 <= low < high:
        raise UsageError(f"band {said!r}", do="Write it like 20..100, in hertz", code="wrong_value")
    first, last = stated.profile.band
    if high <= first or low >= last:
        what = f"band {said!r} lies outside of the profile of {number(first, 6)} to {number(last, 6)} Hz"
        raise UsageError(what, do="Give a band inside of it", code="wrong_value")
    return low, high


__all__ = ["ProfileTable", "vibration_profile"]
