"""filter: what a navigation filter must carry of a sensor in use, and its settings."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Annotated, Any

import typer

from ..nouns.factory import said_of, said_options
from ..options import Json, Quiet, with_options
from ..shown.output import json_out
from ..shown.screen import folded, say
from .models import Condition, Model

USE = {  # what is said of the use -> help, example
    "temperature_span": ("Warmest less coldest temperature in use", "20 K"),
    "temperature_time": ("Time over which the temperature changes", "10 min"),
    "temperature": ("Middle of the span; that of the model's range if not given", "25 degC"),
    "motion": ("Rms angular rate along each axis", "20 deg/s"),
    "motion_time": ("Time over which the motion becomes another one", "0.5 s"),
    "force": ("Rms change of specific force along each axis", "2 m/s2"),
    "force_time": ("Time over which the force becomes another one; that of the motion if not given", "1 s"),
    "steady_force": ("Specific force that stays: 1 g if not given, 0 in orbit", "0 m/s2"),
    "turn_on": ("Scatter of the bias between power-ups; that of the model if not given", "0.05 deg/s"),
    "residual": ("Rms bias that the polynomial over temperature leaves", "0.002 deg/s"),
    "g_sensitivity": ("Of gyros, not compensated", "0.02 deg/s/g"),
    "rectification": ("Shift of the bias over the squared rms of vibration", "0.001 deg/s/g^2"),
    "horizon": ("Averaging time at which a walk replaces all that wanders at rest", "100 s"),
    "filter_rate": ("Readings per second that the filter takes; those of the record if not given", "200 Hz"),
}
Noise = Annotated[
    Path | None,
    typer.Argument(help="Recording at rest, or terms.json of allan; else the noise of the model.", show_default=False),
]
Filters = Annotated[
    list[str], typer.Option("--for", help="Filter: kalibr, px4, gtsam, kf-gins, openvins or ros. May be repeated.")
]
Other = Annotated[Path | None, typer.Option("--with", help="Model of the other sensor.", show_default=False)]
Vibration = Annotated[
    Path | None, typer.Option("--vibration", help="Recording of the vibration in use.", show_default=False)
]
Without = Annotated[
    list[str],
    typer.Option(
        "--without", help="Part of the model that is not applied: bias, temperature, matrix, g_sensitivity. Repeatable."
    ),
]
Take = Annotated[
    list[str],
    typer.Option("--take", help="Term taken where the record cannot separate terms, or upper_limit. Repeatable."),
]


def _filter(**given: Any) -> int:
    """By how much the noise figures of a filter must be inflated: a budget line by line, and the filter's settings."""
    from ...campaign.models.filter_settings import filter_settings
    from ...campaign.models.find import find_model
    from ..shown.filter_text import filter_content, filter_text

    reading = said_of(given)
    said = {name: given[name] for name in USE if given[name] is not None}
    models = [find_model(given["model"], given["condition"])]
    models += [] if given["other"] is None else [find_model(given["other"])]
    found = filter_settings(
        models,
        given["for_filter"],
        given["noise"],
        given["vibration"],
        said,
        given["without"],
        reading,
        given["take"],
    )
    if given["as_json"]:
        json_out("filter", filter_content(found))
    elif not given["quiet"]:
        say(folded(filter_text(found)))
    return 0


_OPTIONS: dict[str, tuple[Any, Any]] = {
    name: (Annotated[str | None, typer.Option(f"--{name.replace('_', '-')}", help=f"{about}: {example}.",
                                              show_default=False)], None)
    for name, (about, example) in USE.items()
}  # fmt: skip
filter = with_options(
    _filter,
    {
        "model": (Model, inspect.Parameter.empty), "noise": (Noise, None), "for_filter": (Filters, []),
        "other": (Other, None), "condition": (Condition, None), **_OPTIONS, "vibration": (Vibration, None),
        "without": (Without, []), "take": (Take, []), **said_options(), "as_json": (Json, False),
        "quiet": (Quiet, False),
    },
)  # fmt: skip
