"""Figures on the page, each with its caption and the data behind it; drawn when the page has room for them."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from ..core.figure import FigureSpec
from ..core.show.rows import Quoted
from ..core.show.tables import csv_cell
from ..core.show.wording import count, words
from .figures import Picture, figures, prefix, to_svg
from .findings import Finding
from .numbers import Text, clean

Results = Mapping[str, Any]
FILLED = re.compile(r"(\{axis\}|\{note\})")


@dataclass(frozen=True, eq=False)
class Drawing:
    """One figure."""

    key: str  # names it on the page
    spec: FigureSpec  # what kind of figure
    picture: Picture  # what to draw
    caption: Finding  # what stands under it
    data: Callable[[], list[tuple[str, str]]]  # the tables behind it, as (title, CSV)

    def svg(self) -> Markup:
        """Return it as markup, with ids of its own; its texts are escaped where it is made."""
        if not self.picture.apart:
            return Markup(to_svg(self.picture, self.key, with_values=True))  # noqa: S704 - written by an XML writer
        parts = "\n".join(to_svg(one, f"{self.key}-p{i}", with_values=True) for i, one in enumerate(self.picture.apart))
        return Markup(f'<div class="panels">\n{parts}\n</div>')  # noqa: S704 - the same


def of_campaign(results: Results) -> list[Drawing]:
    """Return every figure that the campaign has data for.

    Parameters
    ----------
    results : mapping
        Content of results.json.
    """
    found = []
    for figure in figures().values():
        shown: dict[tuple[str, str], int] = {}
        for picture in figure.pictures(results):
            number = shown.get((picture.test, picture.axis), 0)
            shown[picture.test, picture.axis] = number + 1
            if figure.spec.most is None or number < figure.spec.most:
                found.append(_drawing(results, figure.spec, picture, number))
    return found


def _drawing(results: Results, spec: FigureSpec, picture: Picture, number: int) -> Drawing:
    def data() -> list[tuple[str, str]]:
        return _data(results, spec, picture)

    return Drawing(prefix(picture, number), spec, picture, _caption(spec, picture), data)


def _caption(spec: FigureSpec, picture: Picture) -> Finding:
    """Return the caption with the axis, and what the picture says of its data."""
    note = tuple(Text(part) if isinstance(part, Quoted) else part for part in picture.note)
    filled: dict[str, Finding] = {"{axis}": (Text(picture.axis),), "{note}": note}
    return tuple(part for text in FILLED.split(spec.caption) if text for part in filled.get(text, (text,)))


def _data(results: Results, spec: FigureSpec, picture: Picture) -> list[tuple[str, str]]:
    """Return the rows, or each curve, behind a picture."""
    data = picture.data or [
        one
        for one in results["curves"]
        if one["test"] == picture.test and one["name"] in spec.curves and picture.axis in ("", one["axis"])
    ]
    if not spec.curves:
        return [(words(picture.name), rows_csv(data))]
    names = [one["name"] for one in data]
    return [(_title(spec, one, names[:i], names.count(one["name"])), curve_csv(one)) for i, one in enumerate(data)]


def _title(spec: FigureSpec, curve: Mapping[str, Any], before: Sequence[str], several: int) -> str:
    """Return the title of the table of a curve."""
    record = f" record {count(before.count(curve['name']) + 1)}" if several > 1 else ""
    given = {"axis": clean(curve["axis"]), "of": words(curve.get("of", "")), "record": record}
    filled = (spec.curves.get(curve["name"]) or words(curve["name"])).format_map(given)
    return filled.strip()


def curve_csv(curve: Mapping[str, Any]) -> str:
    """Return a curve of results.json as CSV; the unit stands in the head of each column.

    Parameters
    ----------
    curve : mapping
        With ``columns``: ``{name: {"unit", "values"}}``, all equally long.
    """
    columns = curve["columns"]
    heads = [f"{name} [{column['unit']}]" if column["unit"] else name for name, column in columns.items()]
    return _written(heads, list(zip(*(column["values"] for column in columns.values()), strict=True)))


def rows_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return rows of results.json as CSV; what is nested in a row is left out."""
    heads = [name for name, value in rows[0].items() if not isinstance(value, Mapping | list)] if rows else []
    return _written(heads, [[row[name] for name in heads] for row in rows])


def _written(heads: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow([_cell(head) for head in heads])
    writer.writerows([_cell(value) for value in row] for row in rows)
    return buffer.getvalue()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return csv_cell(clean(value))
    return repr(value)
