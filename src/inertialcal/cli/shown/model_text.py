"""A model as text: in words, then every coefficient with all its digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...core.results import key_of
from ...core.show.names import reason_text
from ...core.show.rounding import number
from ...sensors.model.sensor_model import SensorModel, show
from .output import clean, table


def model_text(model: SensorModel, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return what ``show`` prints.

    Parameters
    ----------
    model : SensorModel
        What to show.
    rows : sequence of mapping
        Its parameters, as rows of results.
    """
    heads = ["  name", "value", "u", "unit", "dof", "from"]
    cells = [
        [
            f"  {key_of(row)}",
            repr(row["value"]),
            "-" if row["u"] is None else number(row["u"], 3),
            row["unit"],
            "" if row["u"] is None else "inf" if row["dof"] is None else number(row["dof"], 3),
            "; ".join(text for text in (row["test"], reason_text(row)) if text),
        ]
        for row in rows
    ]
    words = "\n".join(clean(line) for line in show(model).split("\n"))
    return f"{words}\n\nCoefficients, all digits\n{table(cells, heads, right=(1, 2))}"
