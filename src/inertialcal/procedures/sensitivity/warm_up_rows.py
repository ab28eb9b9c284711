"""Rows and curves of the joint warm-up."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...core.curve import Column, Curve
from ...core.key import Key, Member, Reason
from ...core.results import Interval, Row, not_estimated
from ...statistics.intervals import t_interval
from .warm_up_model import WarmUpModel

LIMITED = ("no_transient", "temperature_moves")  # reasons that leave an upper limit


def warm_up_rows(found: WarmUpModel) -> tuple[Row, ...]:
    """Return times, amplitudes, and what is left of power-ups held out, SI."""
    return (*_model_rows(found), *_held_out_rows(found))


def warm_up_curves(found: WarmUpModel) -> list[Curve]:
    """Return means of each power-up less its settled level, with the joint fit."""
    return [one for i in range(len(found.power_ups.axes)) for one in _of_axis(found, i)]


def _model_rows(found: WarmUpModel) -> Iterator[Row]:
    axes, unit = found.power_ups.axes, found.power_ups.unit
    if found.estimate is None:
        yield not_estimated(Key("warm_up_time", power=1), "s", found.reason)
        for a, axis in enumerate(axes):
            key, limit = Key("bias_warm_up", axis, power=1), float(found.limits[a])
            if math.isfinite(limit) and found.reason.code in LIMITED:
                yield Row(key, limit, None, unit, None, Interval(0.0, limit), "upper_limit", found.reason)
            else:
                yield not_estimated(key, unit, found.reason)
        return
    estimate = found.estimate
    start = found.reference_temperature
    said = {"bias_warm_up": "amplitude at power-up"}
    if found.slopes is not None and start is not None:
        said["bias_warm_up"] += f" from {start:.4g} degC"
        said["bias_warm_up_temperature"] = "change of the amplitude with the starting temperature"
    for i, key in enumerate(estimate.keys):
        value, u, dof = float(estimate.values[i]), float(estimate.u[i]), float(estimate.dof[i])
        reason = Reason("limits", said.get(key.quantity, ""))
        yield Row(key, value, u, estimate.units[i], dof, t_interval(value, u, dof), reason=reason)


def _held_out_rows(found: WarmUpModel) -> Iterator[Row]:
    """Rows of what is left of power-ups held out: the root mean square over all, then each."""
    runs, unit = found.held_out, found.power_ups.unit
    if not runs:
        return
    told = "first minutes of power-ups held out, predicted from the others"
    for a, axis in enumerate(found.power_ups.axes):
        for name, each in (
            ("warm_up_residual", [float(one.with_model[a]) for one in runs]),
            ("warm_up_residual_without_model", [float(one.without[a]) for one in runs]),
        ):
            squares = np.square(each)
            value = math.sqrt(float(squares.mean()))
            u = float(squares.std(ddof=1)) / math.sqrt(len(each)) / (2.0 * value) if value > 0.0 else 0.0
            dof = len(each) - 1.0
            yield Row(Key(name, axis), value, u, unit, dof, t_interval(value, u, dof), reason=Reason("limits", told))
            for one, alone in zip(runs, each, strict=True):
                member = Member("held_out", one.label)
                yield Row(Key(name, axis), alone, None, unit, status="not_estimated", member=member,
                          reason=Reason("limits", "one power-up"))  # fmt: skip


def _of_axis(found: WarmUpModel, axis: int) -> Iterator[Curve]:
    means, name, unit = found.stretches, found.power_ups.axes[axis], found.power_ups.unit
    labels = found.power_ups.labels or tuple(str(r + 1) for r in range(means.runs))
    effect = found.by_temperature[axis] if found.by_temperature is not None else 0.0
    for r in range(means.runs):
        own = means.run == r
        start = float(means.start[r])
        level = found.levels[r, axis]
        columns = {
            "time": Column(means.time[own], "s"),
            "reading": Column(means.readings[own, axis] - level - effect * means.temperature[own, axis], unit),
            "model": Column(found.at(means.time[own], axis, start if math.isfinite(start) else None), unit),
        }
        yield Curve("warm_up_joint", name, columns, of=labels[r], picture=True)
