"""Published models applied to counts, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.recording import Recording
from ...core.units import factor
from ...sensors.catalogue import AS_PRINTED, CORRECTED, PublishedSensor
from ...sensors.flight import RATES, Step, steps
from ...sensors.model.sensor_model import RANGE_UNIT
from .compensation import compensate
from .inputs import chain_columns, from_chain, said_by_column


def reading_steps(
    sensor: PublishedSensor,
    recording: Recording,
    columns: Mapping[str, str] | None = None,
    row: int = 1,
    as_printed: bool = False,
) -> tuple[Step, ...]:
    """Return every step from the counts of one row to compensated rates, and the rates by the inverse equation.

    Parameters
    ----------
    row : int
        Which reading, from 1.
    as_printed : bool
        With the mistakes of the document.

    Raises
    ------
    DataError
        ``no_steps`` if the sensor's flight equation is not published, or the recording is not in counts;
        ``not_valid`` for a reading that the chain leaves out; ``wrong_column``.
    UsageError
        ``wrong_row``.
    """
    state, where = AS_PRINTED if as_printed else CORRECTED, recording.source.path
    if state not in sensor.equations:
        raise DataError("no flight equation is published of this sensor", where, code="no_steps")
    equation, model = sensor.equations[state], sensor.models[state]
    chain = model.chain
    assert chain is not None  # noqa: S101 - the equation starts from counts
    found = chain_columns(chain, recording, columns)
    kinds = ("reference", "temperature")
    lacking = [axis for axis in chain.axes if axis not in found]
    lacking += [f"{kind}_{axis}" for kind in kinds for axis in chain.axes if not {f"{kind}_{axis}", kind} & set(found)]
    if lacking:
        raise DataError(
            f"no counts of {', '.join(lacking)}",
            where,
            why="the steps start from counts of rate, reference and temperature",
            do=said_by_column(lacking, recording),
            code="no_steps",
        )
    if not 1 <= row <= len(recording):
        raise UsageError(f"--row {row}", do=f"The recording has rows 1 to {len(recording)}", code="wrong_row")
    one = replace(
        recording,
        channels=tuple(replace(channel, data=channel.data[row - 1 : row]) for channel in recording.channels),
        time_ns=None if recording.time_ns is None else recording.time_ns[row - 1 : row],
        first_row=recording.first_row + row - 1 if recording.first_row else 0,
    )
    readings, made = from_chain(model, one, columns)
    if not np.isfinite(readings.array(list(made))).all():
        left_out = [remark.what for remark in readings.remarks if remark.severity != "info"]
        raise DataError(f"row {row} is not valid", one.place(0), why="; ".join(left_out), code="not_valid")

    def codes(kind: str) -> list[float]:
        names = [found.get(f"{kind}_{axis}" if kind else axis, found.get(kind, "")) for axis in chain.axes]
        return [float(one.array([name])[0, 0]) for name in names]

    own = "temperature_reference"
    has_own = all({f"{own}_{axis}", own} & set(found) for axis in chain.axes)
    listed = steps(
        equation, chain, codes(""), codes("reference"), codes("temperature"), codes(own) if has_own else None
    )
    done = compensate(model, readings, made)
    inverse = done.array(list(model.axes))[0] * factor(RANGE_UNIT[sensor.kind], listed[-1].unit)
    return (*listed, Step("by the inverse of M, not of first order", inverse, listed[-1].unit, RATES, listed[-1].group))
