"""Half sums and half differences of the two attitudes, from the tables of means.

Forward reads ``M_0 = G + B``, turned by pi reads ``M_pi = -G + B`` [1]_, so ``G = (M_0 - M_pi) / 2`` and
``B = (M_0 + M_pi) / 2``; the control axis lies along the turn, its half difference is the error of the test.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, equations (1) to (6).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .figures import Figure, Section, Variant, figure
from .printed import Printed, Recomputed, printed, recompute
from .table_files import Row, table

DOC = "sams1996"
Key = tuple[str, ...]
Pairs = dict[Key, tuple[Printed, Printed]]
VALUE = {
    "gravity": "gravity_ug",
    "error": "measurement_error_ug",
    "bias": "bias_ug",
    "bias error": "model_bias_error_ug",
}


def half_difference(forward: float, reverse: float) -> float:
    """Return G, or the error of the control axis."""
    return 0.5 * (forward - reverse)


def half_sum(forward: float, reverse: float) -> float:
    """Return B."""
    return 0.5 * (forward + reverse)


def means(name: str) -> Pairs:
    """Return (forward, reverse) of a table of means by axis, filter where there is one, and time."""
    found: dict[Key, dict[str, Printed]] = {}
    for row in table(DOC, name):
        found.setdefault(key_of(row), {})[row["orientation"]] = printed(row["mean_acceleration_ug"])
    return {key: (pair["forward"], pair["reverse"]) for key, pair in found.items()}


def key_of(row: Row) -> Key:
    """Return axis, filter where there is one, and time of a row."""
    return tuple(row[column] for column in ("axis", "filter", "time_id") if column in row)


def values(name: str, kind: str) -> dict[Key, Printed]:
    """Return the printed values of a table of results."""
    return {key_of(row): printed(row[VALUE[kind]]) for row in table(DOC, name)}


def place(key: Key) -> str:
    """Return an entry in words."""
    axis, *between, time = key
    return " ".join([axis, *between, f"time {time}"])


def from_means(
    name: str,
    kind: str,
    source: str,
    variants: Mapping[Any, tuple[Variant, ...]] | None = None,
    why: Mapping[Any, str] | None = None,
) -> tuple[Figure, ...]:
    """Return the figures of a table of results, recomputed from a table of means."""
    pairs = means(source)
    rule = half_sum if kind.startswith("bias") else half_difference
    return tuple(
        figure(
            f"{kind} {place(key)}",
            f"{kind}, {place(key)}",
            shown,
            recompute(rule, *pairs[key]),
            "ug",
            variants=(variants or {}).get(key, ()),
            why=(why or {}).get(key, ""),
        )
        for key, shown in values(name, kind).items()
    )


def result_tables() -> tuple[Section, ...]:
    """Return Tables 4-6, 8-10, 12-14 and 16-18."""
    return (
        Section(
            "tables 4-6",
            "Tables 4 to 6, semiprocessed",
            "Half difference (gravity, control error) and half sum (bias) of the means of Table 3.",
            from_means("table04_gravity_semiprocessed", "gravity", "table03_mean_semiprocessed")
            + from_means("table05_error_semiprocessed", "error", "table03_mean_semiprocessed")
            + from_means("table06_bias_semiprocessed", "bias", "table03_mean_semiprocessed"),
        ),
        _equation_6(),
        _unfiltered(),
        _first_means_again(),
        Section(
            "tables 12-14",
            "Tables 12 to 14, full ground model, filtered",
            "Half difference and half sum of the means of Table 11.",
            from_means("table12_gravity_filtered", "gravity", "table11_mean_filtered")
            + from_means("table13_error_filtered", "error", "table11_mean_filtered")
            + from_means("table14_bias_error_filtered", "bias error", "table11_mean_filtered"),
        ),
        _same_intervals(),
        _alignment(),
    )


def _equation_6() -> Section:
    pairs, shown = means("table03_mean_semiprocessed"), values("table05_error_semiprocessed", "error")
    figures = tuple(
        figure(
            f"error {place(key)}",
            f"error, {place(key)}",
            one,
            recompute(lambda f, r: f - r, *pairs[key]),
            "ug",
            variants=(Variant("half of what equation (6) says", recompute(half_difference, *pairs[key]), "misprint"),),
        )
        for key, one in shown.items()
    )
    how = "Equation (6) as it is printed, M_0 - M_pi, on the means of Table 3."
    return Section("equation 6", "Equation (6) against Table 5", how, figures)


def _unfiltered() -> Section:
    filtered = means("table11_mean_filtered")["Z", "1"]
    variants = {
        ("Z", "1"): (Variant("the filtered value, from Table 11", recompute(half_difference, *filtered), "misprint"),)
    }
    return Section(
        "tables 8-10",
        "Tables 8 to 10, full ground model, unfiltered",
        "Half difference and half sum of the means of Table 7.",
        from_means("table08_gravity_unfiltered", "gravity", "table07_mean_unfiltered", variants)
        + from_means("table09_error_unfiltered", "error", "table07_mean_unfiltered")
        + from_means("table10_bias_error_unfiltered", "bias error", "table07_mean_unfiltered"),
    )


def _first_means_again() -> Section:
    gravity, bias = (
        values("table08_gravity_unfiltered", "gravity"),
        values("table10_bias_error_unfiltered", "bias error"),
    )
    figures = []
    for key, (forward, reverse) in means("table07_mean_unfiltered").items():
        if key[0] == "Y":
            parts = (gravity[key], bias[key])
            figures += [
                figure(f"forward {place(key)}", f"forward mean, {place(key)}", forward, _turned(parts, 1.0), "ug"),
                figure(f"reverse {place(key)}", f"reverse mean, {place(key)}", reverse, _turned(parts, -1.0), "ug"),
            ]
    how = "Minus (B + G) and minus (B - G), with G of Table 8 and B of Table 10: the sign of Y is turned between them."
    return Section("table 7 Y", "Table 7, Y, from Tables 8 and 10", how, tuple(figures))


def _turned(parts: tuple[Printed, Printed], side: float) -> Recomputed:
    return recompute(lambda g, b: -(b + side * g), *parts)


def _same_intervals() -> Section:
    again = means("table15_mean_alignment")
    figures = []
    for axis in "XYZ":
        pair = means("table11_mean_filtered")[axis, "1"]
        for name, one, other in zip(("forward", "reverse"), pair, again[axis, "filtered", "1"], strict=True):
            figures.append(
                figure(f"{name} {axis}", f"{name} mean, {axis} time 1", one, recompute(lambda m: m, other), "ug")
            )
    how = "The mean that Table 15 prints for the same interval, filtered, with misalignment correction."
    return Section("table 11", "Table 11 against Table 15", how, tuple(figures))


def _alignment() -> Section:
    pairs = means("table15_mean_alignment")
    repeats = {
        (axis, filtered, "1N"): (
            Variant(
                "the entry above it, with correction", recompute(half_sum, *pairs[axis, filtered, "1"]), "misprint"
            ),
        )
        for axis in "YZ"
        for filtered in ("filtered", "unfiltered")
    }
    return Section(
        "tables 16-18",
        "Tables 16 to 18, with (1) and without (1N) misalignment correction",
        "Half difference and half sum of the means of Table 15.",
        from_means("table16_gravity_alignment", "gravity", "table15_mean_alignment")
        + from_means("table17_error_alignment", "error", "table15_mean_alignment")
        + from_means("table18_bias_error_alignment", "bias error", "table15_mean_alignment", repeats),
    )
