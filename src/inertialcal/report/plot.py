"""Draw a result: ``inertialcal.plot``.

A result is the content of ``results.json`` (a dict, the ``results`` of a run, the ``content()`` of what a call on files
gives), the Result of a procedure, or one of the types of ``core`` and ``sensors``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from ..core.errors import DataError, UsageError
from ..core.estimate import Estimate
from ..core.recording import Recording
from ..core.results import Row
from ..core.units import factor
from ..procedures import procedure_of_result
from ..procedures.display import curve_contents
from ..sensors.model.sensor_model import SensorModel, lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .figures.drawing.picture import Picture


@runtime_checkable
class WithContent(Protocol):
    """What a call on files returns."""

    def content(self) -> Mapping[str, Any]:
        """Return it as ``results.json`` would hold it."""
        ...


OWN_FIGURE = {Recording: "recording", SensorModel: "matrix", Estimate: "estimate"}


def plot(
    result: object,
    ax: Axes | Sequence[Axes] | None = None,
    figure: str | None = None,
    test: str | None = None,
    axis: str | None = None,
) -> Any:
    """Draw a result.

    Parameters
    ----------
    result : Outcome, RateTableFile, NoiseFile, SineFile, MassPlan, Recording, SensorModel, Estimate or dict
        Of ``run``, ``rate_table``, ``allan``, ``psd``, ``sine``, ``plan_mass_attraction``, ``read``, ``load_model``;
        the ``estimate`` of a result; or the content of a ``results.json``.
    ax : Axes, or sequence of Axes, optional
        Where; as many as the figure has panels, or one, which is then divided. By default a new figure, which a
        notebook shows; elsewhere save it: ``plot(result).figure.savefig("figure.png")``.
    figure : str, optional
        Which: ``"compensated"``, ``"input_output"``, ``"rate_error"``, ``"dwells"``, ``"side_by_side"``, ``"flip"``,
        ``"sine"``, ``"allan"``, ``"spectrum"``, ``"mass_body"``, ``"mass_field"``, ``"mass_growth"``,
        ``"cube_as_point"``, ``"mass_forecast"``, ``"matrix"``, ``"budget"``;
        by default that of the call (of ``psd`` the spectrum), else the first of these that the result has data for.
    test, axis : str, optional
        Of which test and axis of a campaign; by default the first.

    Returns
    -------
    Axes, or ndarray of Axes
        One for each panel.

    Raises
    ------
    UsageError
        If there is no such figure, or nothing that can be drawn is given.
    DataError
        ``nothing_to_draw``, if the result has no data for it: never an empty figure.
    """
    picture = pictures(result, figure, test, axis)[0]
    if ax is None:
        from .figures.drawing.picture import on_new_figure  # noqa: PLC0415 - matplotlib is heavy

        drawn = list(on_new_figure(picture, titled=True, figure=_shown_figure()).axes)
    else:
        drawn = _on(picture, ax)
    return drawn[0] if len(drawn) == 1 else np.array(drawn, dtype=object)


def markup(result: object) -> str:
    """Return the first figure of a result as markup for a notebook, on white; nothing where none can be drawn."""
    from .figures import to_svg  # noqa: PLC0415 - matplotlib is heavy

    try:
        picture = pictures(result)[0]
    except DataError:
        return ""
    drawn = to_svg(picture, f"nb-{picture.name}-{picture.test}-{picture.axis}")
    return f'<div style="max-width:44em;background:#fff;padding:0.5em">{drawn}</div>\n'


def pictures(
    result: object, figure: str | None = None, test: str | None = None, axis: str | None = None
) -> list[Picture]:
    """Return the pictures of one kind that a result has data for, at least one; arguments and errors as `plot`."""
    if isinstance(result, Recording | SensorModel | Estimate):
        own = next(name for known, name in OWN_FIGURE.items() if isinstance(result, known))
        if figure not in (None, own):
            raise UsageError(f"no figure {figure!r} of a {type(result).__name__}", do=f"There is: {own}")
        if test is not None or (axis is not None and own != "recording"):
            raise UsageError(f"a {type(result).__name__} has no test and no axis to choose", do="Leave them out")
        return [_own_picture(result, axis)]
    from .figures import figures  # noqa: PLC0415 - matplotlib is heavy

    every = figures()
    if figure is not None and figure not in every:
        raise UsageError(f"no figure {figure!r}", do=f"There are: {', '.join(every)}", code="unknown_name")
    content = _content(result)
    there = {name: found for name, kind in every.items() if (found := kind.pictures(content))}
    first = getattr(result, "first_figure", "")
    for name in (figure,) if figure else (first, *every):
        chosen = [one for one in there.get(name, []) if _is_of(one, test, axis)]
        if chosen:
            return chosen
    raise _nothing(there, figure, test, axis)


def _is_of(picture: Picture, test: str | None, axis: str | None) -> bool:
    return test in (None, picture.test) and (axis in (None, picture.axis) or not picture.axis)


def _nothing(there: Mapping[str, list[Picture]], figure: str | None, test: str | None, axis: str | None) -> DataError:
    asked = [f"{what} {name!r}" for what, name in (("figure", figure), ("test", test), ("axis", axis)) if name]
    have = [
        f"{name} of {', '.join(dict.fromkeys(' '.join(filter(None, (one.test, one.axis))) for one in found))}"
        for name, found in there.items()
        if figure in (None, name) or figure not in there
    ]
    what = f"no data for {', '.join(asked)}" if asked else "no data to plot"
    do = f"There are: {'; '.join(have)}" if have else ""
    return DataError(what, do=do, code="nothing_to_draw")


def _content(result: object) -> Mapping[str, Any]:
    """Return a result as ``results.json`` would hold it."""
    content = result if isinstance(result, Mapping) else getattr(result, "results", None)
    if isinstance(content, Mapping) and ("curves" in content or "results" in content):
        return content
    if isinstance(result, WithContent):
        return result.content()
    procedure = procedure_of_result(result)
    if procedure is not None:
        return {"curves": curve_contents(procedure.curves(result), None)}
    raise UsageError(
        f"cannot plot a {type(result).__name__}",
        do="Pass the result of a call such as run, read or load_model, an Estimate, or the content of results.json",
        code="wrong_value",
    )


def _own_picture(result: Recording | SensorModel | Estimate, axis: str | None) -> Picture:
    from .figures.campaign import estimate, matrix, recording  # noqa: PLC0415 - matplotlib is heavy

    if isinstance(result, Recording):
        return recording.picture(result, axis)
    if isinstance(result, Estimate):
        return estimate.picture(result)
    return matrix.of_rows(_rows(result))


def _rows(model: SensorModel) -> list[dict[str, Any]]:
    """Return the entries of the matrix as rows, scale-factor errors in percent."""
    rows = []
    for parameter, line in zip(model.parameters, lines(model), strict=True):
        unit = "%" if line.unit == "1" else line.unit
        scale = factor(line.unit, unit)
        unknown = parameter.name in model.not_estimated and line.value == 0.0
        value, u = (None if unknown else line.value * scale), (None if line.u is None else line.u * scale)
        rows.append(Row(parameter.key, value, u, unit, status="not_estimated" if unknown else "estimated").to_dict())
    return rows


def _on(picture: Picture, ax: Axes | Sequence[Axes]) -> list[Axes]:
    from matplotlib.axes import Axes as OneAxes  # noqa: PLC0415 - matplotlib is heavy

    from .figures.drawing.style import look  # noqa: PLC0415 - matplotlib is heavy

    given = [ax] if isinstance(ax, OneAxes) else list(np.ravel(np.asarray(ax, dtype=object)))
    need = len(picture.heights)
    if len(given) not in (1, need) or not all(isinstance(one, OneAxes) for one in given):
        raise UsageError(
            f"ax: {len(given)} axes given, the figure {picture.name!r} has {need} panel(s)",
            do=f"Give 1 or {need} Axes of matplotlib",
            code="wrong_value",
        )
    with look():
        axes = _divided(given[0], picture) if len(given) < need else given
        picture.draw(axes, picture.finding)
    return axes


def _divided(ax: Axes, picture: Picture) -> list[Axes]:
    """Return a panel above the other inside axes, which then show no frame of their own."""
    ax.set_axis_off()
    gap = 0.12 / len(picture.heights)
    share = np.array(picture.heights) / sum(picture.heights) * (1.0 - gap * (len(picture.heights) - 1))
    tops = 1.0 - np.concatenate([[0.0], np.cumsum(share[:-1] + gap)])
    axes: list[Axes] = []
    for top, height in zip(tops.tolist(), share.tolist(), strict=True):
        first = axes[0] if axes and picture.share_x else None
        axes.append(ax.inset_axes((0.0, top - height, 1.0, height), sharex=first))
    return axes


def _shown_figure() -> Figure | None:
    """Return a figure that a notebook shows by itself; None where no notebook is running."""
    python = sys.modules.get("IPython")
    if python is None or python.get_ipython() is None:
        return None
    from matplotlib import pyplot  # noqa: PLC0415 - only a notebook needs its state

    return pyplot.figure()
