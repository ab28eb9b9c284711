"""Figures on the page, each with its caption and the data behind it; drawn when the page has room for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from ..core.show.side_by_side import CHANGE, ERROR, OTHER, REDUCTION
from .embedded import curve_csv, rows_csv
from .figures import FIGURES, Picture, prefix, to_svg
from .findings import ORDER, Finding
from .numbers import Text, clean
from .wording import count, listed, words

RECORDINGS_SHOWN = 1  # traces of a test, of each axis that was turned: the others look alike
Results = Mapping[str, Any]


NOISE = {"allan": ("allan", "allan_terms"), "spectrum": ("spectrum",)}  # curves of the figures of noise
STILL = 0.01  # of the largest input: next to none
SIDE_BY_SIDE = (ERROR, OTHER, CHANGE, REDUCTION)


@dataclass(frozen=True, eq=False)
class Drawing:
    """One figure.

    Parameters
    ----------
    key : str
        Names it on the page.
    picture : Picture
        What to draw.
    caption : Finding
        What stands under it.
    data : callable
        Gives the tables behind it, as (title, CSV).
    """

    key: str
    picture: Picture
    caption: Finding
    data: Callable[[], list[tuple[str, str]]]

    def svg(self) -> Markup:
        """Return it as markup, with ids of its own; its texts are escaped where it is made."""
        return Markup(to_svg(self.picture, self.key))  # noqa: S704 - written by an XML writer


def of_campaign(results: Results) -> list[Drawing]:
    """Return every figure that the campaign has data for.

    Parameters
    ----------
    results : mapping
        Content of results.json.
    """
    found = []
    for name, kind in FIGURES.items():
        seen: dict[tuple[str, str], int] = {}
        for picture in kind.pictures(results):
            number = seen.get((picture.test, picture.axis), 0)
            seen[picture.test, picture.axis] = number + 1
            if name not in BY_RECORDING or number < RECORDINGS_SHOWN:
                found.append(_drawing(results, picture, number))
    return found


def _drawing(results: Results, picture: Picture, number: int) -> Drawing:
    def data() -> list[tuple[str, str]]:
        return _data(results, picture, number)

    return Drawing(prefix(picture, number), picture, _caption(results, picture), data)


PLAIN: dict[str, Finding] = {
    "matrix": (
        "How the matrix differs from the identity: scale factor errors on the diagonal, misalignments beside it; row ="
        " the sensor that reads, column = the axis that moves.",
    ),
    "budget": ("Share of each source in the variance of each quantity.",),
    "side_by_side": (
        "What two ground models leave of the bias in orbit, and their difference, with 95 % intervals; strokes are"
        " single flips.",
    ),
    "thermal_order": ("Error on what was held out, order by order: R2 of the fit itself would always grow.",),
    "start_up": ("What the reading does after power-up, and what is left out for it (hollow).",),
    "reference_voltage": ("Reference voltages of the converter over temperature, each less its mean.",),
    "overlay": ("Bias on power-ups that no polynomial was fitted to: as read, and after what was found is taken off.",),
    "mass_runs": (
        "Scale factor of each run with the 95 % interval of its own noise, of all runs (line, band), and as published.",
    ),
    "mass_series": ("One run: readings with their drift, and what is left with the line of the drive.",),
    "mass_line": (
        "The line of the drive and those beside it that its error is read from; below, correlation over lag.",
    ),
    "conditions": ("Bias over temperature in this test (line) and in the one it is set beside (dashed).",),
    "positions_sphere": (
        "Where up was in each position, seen from the body, on the whole sphere of directions: equal areas, z at the"
        " top, x in the middle; larger marks have larger residuals.",
    ),
    "positions_residuals": ("What each position leaves, with it in the fit and from the fit without it.",),
    "transitions": (
        "Where the gyros carry gravity to in each rotation, against where the accelerometers then find it.",
    ),
}
CURVES = {  # behind a figure, by name
    "thermal": ("thermal_cells", "thermal_law"),
    "conditions": ("thermal_law",),
    "positions_sphere": ("positions",),
    "positions_residuals": ("positions",),
    "transitions": ("transitions",),
}
BY_RECORDING = ("dwells", "mass_series", "mass_line")
RUNS = {  # of a moved mass: curves behind a figure, by name
    "mass_runs": ("mass_runs",), "mass_series": ("mass_series",), "mass_line": ("mass_spectrum", "mass_correlation"),
}  # fmt: skip


OF_AXIS = {  # before and after the name of the axis
    "thermal": ("Bias of ", " over temperature with its polynomial, and what is left: the gap between the paths."),
    "input_output": ("Reading of ", " against the applied input, and what the fitted line leaves."),
    "allan": ("Deviation of ", " over averaging time with 95 % intervals, and the terms fitted to it."),
    "spectrum": ("Density of ", " with 95 % intervals, and the terms that were fitted to its Allan deviation."),
}


def _caption(results: Results, picture: Picture) -> Finding:
    axis = Text(picture.axis)
    if picture.name in PLAIN:
        return PLAIN[picture.name]
    if picture.name in OF_AXIS:
        before, after = OF_AXIS[picture.name]
        return (before, axis, after)
    match picture.name:
        case "rate_error":
            return ("Error of ", axis, " against the applied rate", *_judged(results, picture), ".")
        case "dwells":
            more = sum(one["name"] == "dwells" and one["test"] == picture.test for one in results["curves"])
            told = " The other recordings of this test are in results.json." if more > 1 else ""
            return ("The dwells found in one recording with ", axis, " turned.", told)
        case "flip":
            return _flip_caption(picture)
    others = " At no input lie the dwells in which another axis was turned." if _others_turned(results) else ""
    return ("Errors on readings held out, raw and compensated, at each applied input.", others)


def _flip_caption(picture: Picture) -> Finding:
    if picture.recorded:
        return ("Block means of the quiet record; shaded are the windows, their ends are A, B and so on.",)
    return ("What each axis read at its positions, in the order of the dwells, and what was found (line).",)


def _others_turned(results: Results) -> bool:
    """Whether most dwells of an axis in the closed loop have next to no input: others were turned."""
    for one in results["curves"]:
        if one["name"] == "compensated":
            sizes = [abs(float(value)) for value in one["columns"]["applied"]["values"] if value is not None]
            if sizes and sum(size < STILL * max(sizes) for size in sizes) > len(sizes) / 2:
                return True
    return False


def _judged(results: Results, picture: Picture) -> Finding:
    """Say what each requirement made of it, worst first."""
    mine = [one for one in results["verdicts"] if (one["test"], one["axis"]) == (picture.test, picture.axis)]
    parts: list[Any] = []
    for requirement in dict.fromkeys(one["requirement"] for one in mine):
        found = [one for one in mine if one["requirement"] == requirement]
        parts += ["; ", Text(requirement), " is ", tally(found)]
    return tuple(parts)


def tally(verdicts: Sequence[Any]) -> str:
    """Return verdicts counted in words, the worst first: ``"INCONCLUSIVE at six rates and PASS at twenty"``."""
    words = [str(one["verdict"]) for one in verdicts]
    if len(words) == 1:
        return words[0]
    return listed([f"{word} at {count(words.count(word))}" for word in ORDER if word in words])


def _data(results: Results, picture: Picture, number: int) -> list[tuple[str, str]]:
    name, test, axis = picture.name, picture.test, picture.axis
    if name in ("matrix", "budget", "side_by_side"):
        return [(words(name), rows_csv(_rows(results, name, test)))]
    own = [one for one in results["curves"] if one["test"] == test]
    if name in CURVES or name in ("overlay", "thermal_order", "start_up", "reference_voltage"):
        shown = [one for one in own if one["name"] in CURVES.get(name, (name,)) and axis in ("", one["axis"])]
        return [(_of_thermal(one), curve_csv(one)) for one in shown]
    if name in RUNS or name == "flip":
        return _of_run(own, RUNS[name], number) if name in RUNS else _of_flip(own, picture)
    if name in NOISE:
        shown = [one for one in own if one["axis"] == axis and one["name"] in NOISE[name]]
        records = [one for one in shown if one["name"] == name]
        return [(_entitled(one, records), curve_csv(one)) for one in shown]
    mine = [one for one in own if one["name"] == name]
    if name == "compensated":
        return [(f"compensated {clean(one['axis'])}", curve_csv(one)) for one in mine]
    return _of_axis(results, name, [one for one in mine if one["axis"] == axis], number)


def _of_flip(own: Sequence[Mapping[str, Any]], picture: Picture) -> list[tuple[str, str]]:
    of = "quiet" if picture.recorded else "flip_dwells"
    return [(f"{of} {clean(one['axis'])}", curve_csv(one)) for one in own if one["name"] == of]


def _of_run(own: Sequence[Mapping[str, Any]], names: Sequence[str], number: int) -> list[tuple[str, str]]:
    """Return the curves of one run with a moved mass."""
    shown = [one for one in own if one["name"] in names]
    runs = list(dict.fromkeys(one.get("recording", "") for one in shown))
    return [(words(one["name"]), curve_csv(one)) for one in shown if one.get("recording", "") == runs[number]]


def _of_axis(results: Results, name: str, mine: Sequence[Mapping[str, Any]], number: int) -> list[tuple[str, str]]:
    """Return the curve behind a figure of one axis; of dwells with the trace that they were found on."""
    if name != "dwells":
        return [(f"{name} {clean(mine[number]['axis'])}", curve_csv(mine[number]))]
    shown, trace = [(one, trace) for one in mine for trace in _traces(results, one)][number]
    return [(f"{one['name']} {clean(one['axis'])}", curve_csv(one)) for one in (shown, trace)]


def _of_thermal(curve: Mapping[str, Any]) -> str:
    """Return the title of a curve of a thermal test."""
    return " ".join(part for part in (words(curve["name"]), clean(curve["axis"]), words(curve.get("of", ""))) if part)


def _entitled(curve: Mapping[str, Any], records: Sequence[Mapping[str, Any]]) -> str:
    """Return the title of a curve: of several records with their number, in words."""
    title = clean(f"{curve['name']} {curve['axis']}")
    several = len(records) > 1 and curve in records
    return f"{title} record {count(records.index(curve) + 1)}" if several else title


def _rows(results: Results, name: str, test: str) -> list[Mapping[str, Any]]:
    """Return the rows of a test that a figure is drawn from."""
    rows = [row for row in results["budgets" if name == "budget" else "results"] if row["test"] == test]
    if name == "matrix":
        return [row for row in rows if not row["condition"]]
    return [row for row in rows if row["quantity"] in SIDE_BY_SIDE] if name == "side_by_side" else rows


def _traces(results: Results, dwells: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the trace that dwells were found on, if there is one."""
    keys = ("test", "axis", "recording")
    return [
        one
        for one in results["curves"]
        if one["name"] == "trace" and all(one.get(key) == dwells.get(key) for key in keys)
    ][:1]
