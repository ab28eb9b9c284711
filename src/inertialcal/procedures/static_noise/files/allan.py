"""Records of a sensor at rest without a campaign file: what ``allan FILE...`` and ``inertialcal.allan`` do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ....core.curve import Curve
from ....core.errors import DataError, Problem, UsageError
from ....core.recording import Recording
from ....core.remarks import Remark, gather
from ....core.results import Row
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import estimate_table, remarks_line
from ....core.show.tables import Block, html, text
from ....sensors.noise.fitting.noise_fit import duration
from ....sensors.noise.terms import Term
from ....sensors.noise.to_filters import FilterBlock
from ...display import displayed, displayed_curve
from .. import reduction as procedure
from .channels import Group, Said, groups_of
from .filters import block_for
from .settings import settings_of
from .sources import Source, recordings_of

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class SensorNoise:
    """Noise of one sensor of the files."""

    group: Group  # Its channels
    result: procedure.Result  # SI, or in the unit of the file

    @property
    def name(self) -> str:
        """``"gyro"``, ``"accelerometer"``, or what unit and names say."""
        return self.group.name

    def rows(self) -> tuple[Row, ...]:
        """Return the figures, in the units of data sheets where the kind of sensor is known."""
        found = (replace(row, test=self.name) for row in self.result.rows())
        return tuple(displayed(row, self.group.unit) if self.group.kind else row for row in found)

    def curves(self) -> list[Curve]:
        """Return the curves, in the unit of the file."""
        if self.group.kind is None:
            return self.result.curves()
        return [displayed_curve(curve, self.group.unit) for curve in self.result.curves()]

    def terms(self) -> list[tuple[Term, ...]]:
        """Return the terms found of each axis [SI]; none of an axis without any."""
        return [() if one.fit is None else one.fit.terms for one in self.result.axes]


@dataclass(frozen=True, eq=False)
class NoiseFile:
    """Noise of the sensors in one or more files."""

    sensors: tuple[SensorNoise, ...]  # Gyro, accelerometer, or whatever the file has
    inputs: Mapping[str, str]  # SHA-256 by path
    remarks: tuple[Remark, ...]  # What reading and reducing brought up
    sample_rate: float  # Of the first record [Hz]

    @property
    def rows(self) -> tuple[Row, ...]:
        """All figures, those of each sensor with its name as test."""
        return tuple(row for one in self.sensors for row in one.rows())

    @property
    def length(self) -> float:
        """Of all records together [s]."""
        return self.sensors[0].result.readings.length

    def content(self) -> dict[str, Any]:
        """Return figures and curves as ``results.json`` would hold them."""
        curves = [curve.to_dict(one.name) for one in self.sensors for curve in one.curves()]
        return {"results": [row.to_dict() for row in self.rows], "curves": curves}

    def for_filter(self, target: str, gravity: float | None = None, horizon: float | None = None) -> FilterBlock:
        """Return the settings of a navigation filter: ``"kalibr"``, ``"px4"``, ``"gtsam"`` or ``"kf-gins"``.

        Parameters
        ----------
        target : str
            Which.
        gravity : float, optional
            Of the site, for GTSAM [m/s^2]; standard gravity if not said.
        horizon : float, optional
            Averaging time at which a walk stands in for all that wanders, bias instability above all [s].

        Raises
        ------
        UsageError
            If there is no such filter.
        DataError
            If neither a gyro nor an accelerometer is known by its unit (``no_unit``).
        """
        by_kind = {one.group.kind: one.terms() for one in self.sensors if one.group.kind is not None}
        return block_for(target, by_kind, self.sample_rate, gravity, horizon)

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the figures of each sensor, how long to record, how many remarks."""
        shown: list[Block] = []
        for one in self.sensors:
            rows = [row.to_dict() for row in one.rows() if not row.case.beside]
            count = len(one.result.readings)
            caption = f"{one.name}: noise of {duration(one.result.readings.length)}, {count} record(s)"
            shown += estimate_table(rows, caption)
            shown += [f"{axis}: {said}" for axis, said in one.result.sentences()]
        return (*shown, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def allan(
    sources: Source | Sequence[Source], *, columns: Sequence[str] = (), quantity: Said | None = None,
    scale_factors: Mapping[str, str] | None = None, deviation: str = "overlapping",
    taus: str | Sequence[float] = "octave", terms: Sequence[str] | None = None, lines: bool = True,
    warm_up: str = "0 s", keep_disturbed: bool = False, spectrum: str = "welch", segment: str | None = None,
    relative_error: str = "10 %", **recorded: Any,
) -> NoiseFile:  # fmt: skip
    """Find the noise terms of a sensor at rest, with intervals, and how long to record.

    Several files are records of one sensor: their terms are fitted together, and a test says whether they agree.

    Parameters
    ----------
    sources : path, Recording, array, or sequence of path or Recording
        Any format that ``inertialcal.read`` takes; an array is (n,) or (n, axes), with ``sample_rate`` and ``unit``.
    columns : sequence of str
        Channels; those that can be a gyro's or an accelerometer's if none is named.
    quantity : {"rate", "increment", "angle", "counts"}, optional
        What the samples are, where their unit does not say it.
    scale_factors : mapping of str to str, optional
        By channel or group: ``{"gyro": "131 count/(deg/s)"}``.
    deviation : {"overlapping", "non_overlapping", "modified", "hadamard", "overlapping_hadamard"}
        Which is shown; terms are fitted to the overlapping one.
    taus : {"octave", "decade", "all"} or sequence of float
        Averaging times that are shown; a list is in seconds.
    terms : sequence of str, optional
        Terms to fit; what the record shows if not said.
    lines : bool
        Whether lines of the spectrum take part in the fit.
    warm_up : str
        Left out at the start of each record.
    keep_disturbed : bool
        Keep samples in disturbances; they are left out, and counted, otherwise.
    spectrum : {"welch", "multitaper"}
        How it is estimated.
    segment : str, optional
        Length of its segments.
    relative_error : str
        For which the length of a record is worked out.
    **recorded
        ``units``, ``unit``, ``sample_rate``, ``averaging``, ``time_column``, ``start``, ``stop``, ``mission_start``,
        ``frame``: as ``noise_sources.recordings_of`` takes them.

    Raises
    ------
    DataError
        If a file cannot be read or cannot carry any answer.
    UsageError
        If it is not clear which channel is meant, or what its samples are.
    """
    settings = settings_of(
        deviation, taus, terms, lines, warm_up, keep_disturbed, spectrum, segment, relative_error
    )  # fmt: skip
    return _noise_file(settings, recordings_of(sources, **recorded), columns, quantity, scale_factors)


def _noise_file(
    settings: Mapping[str, Any],
    recordings: Sequence[Recording],
    columns: Sequence[str],
    quantity: Said | None,
    scale_factors: Mapping[str, str] | None,
) -> NoiseFile:
    grouped = [groups_of(one, columns, quantity, scale_factors) for one in recordings]
    _check_alike([groups for groups, _ in grouped], recordings)
    told_of = [remark for _, remarks in grouped for remark in remarks]
    sensors, remarks = _reduced(settings, recordings, [groups for groups, _ in grouped])
    inputs = {one.source.path: one.source.sha256 for one in recordings if one.source.path}
    rate = 1.0 / sensors[0].result.readings.records[0].interval
    return NoiseFile(sensors, inputs, gather([*told_of, *remarks]), rate)


def _check_alike(grouped: Sequence[tuple[Group, ...]], recordings: Sequence[Recording]) -> None:
    """Refuse files that are not records of the same channels."""
    for groups, recording in zip(grouped[1:], recordings[1:], strict=True):
        first, other = ({one.name: sorted(one.axes) for one in each} for each in (grouped[0], groups))
        if first != other:
            have, want = (", ".join(f"{name} {' '.join(axes)}" for name, axes in one.items()) for one in (other, first))
            what = f"{recording.source.path}: it has {have}; {recordings[0].source.path} has {want}"
            why = "several files are records of one sensor"
            raise UsageError(what, why=why, do="Name the same channels: --column NAME", code="wrong_column")


def _reduced(
    settings: Mapping[str, Any], recordings: Sequence[Recording], grouped: Sequence[tuple[Group, ...]]
) -> tuple[tuple[SensorNoise, ...], list[Remark]]:
    """Return the noise of each sensor; where some have none, the others stand and the reason is remarked."""
    found: list[SensorNoise] = []
    remarks: list[Remark] = []
    problems: list[Problem] = []
    for number, group in enumerate(grouped[0]):
        plan = procedure.Plan(**settings, kind=group.kind, unit="" if group.kind else group.unit)
        at_rest = [_at_rest(one, groups[number], group) for one, groups in zip(recordings, grouped, strict=True)]
        try:
            result = procedure.reduce(plan, procedure.readings_from(plan, at_rest))
        except DataError as error:
            problems += error.problems
            continue
        found.append(SensorNoise(group, result))
        remarks += [one.at(group.name) if len(grouped[0]) > 1 else one for one in result.remarks]
    if not found:
        raise DataError(list(dict.fromkeys(problems)))
    remarks += [Remark("no_terms", "error", problem.what, problem.where, do=problem.do) for problem in problems]
    return tuple(found), remarks


def _at_rest(recording: Recording, group: Group, first: Group) -> procedure.AtRest:
    channels = {axis: group.axes[axis].channel for axis in first.axes}
    scale = {axis: group.axes[axis].scale for axis in first.axes}
    return procedure.AtRest(recording, channels, scale, group.quantity, recording.source.path)


__all__ = ["NoiseFile", "SensorNoise", "allan"]
