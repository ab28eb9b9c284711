"""Several runs of a planned test: at which phase their drives start, and what a drift that repeats leaves.

A drift that comes at the same time after the start of every run (a warming up, a thermostat) does not average out. The
fit of the reduction is made for the drift alone, with each schedule as planned, and the runs are joined as it joins
them (``joining``): what is left is the error of the scale factor. If drives start half a cycle apart, or at four
quarters, it cancels, whatever its shape.

The uncertainty of the runs together is that of one run from its noise (``forecast``), carried through the same joining,
with this error as a standard uncertainty. Of a period the phase is unknown: the error is the root mean square over it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....core.estimate import Array
from ....physics.motion.schedule import Schedule
from ..joining import joined
from ..line import fit_line, start_phase
from ..response import Response
from .forecast import EXACT
from .settings import RepeatingDrift, Starts

PHASES: dict[Starts, tuple[int, ...]] = {"alike": (0,), "alternating": (0, 180), "quarters": (0, 90, 180, 270)}
FAINT = 1e-9  # noise over the size of the drift: a fit needs some
ROUNDING = 1e-9
CERTAIN = 1e9  # degrees of freedom of a noise that is known


@dataclass(frozen=True)
class RunsForecast:
    """Of all runs, relative."""

    u_noise: float | None  # From the noise; None if it is not known
    error: float  # That the drift leaves; 0 without one

    def u(self, u_applied: float) -> float | None:
        """Return the standard uncertainty of the scale factor."""
        return None if self.u_noise is None else float(np.sqrt(self.u_noise**2 + self.error**2 + u_applied**2))


def phases(starts: Starts, runs: int) -> tuple[int, ...]:
    """Return by how much the drive of each run starts ahead of that of the first [deg]."""
    return tuple(PHASES[starts][k % len(PHASES[starts])] for k in range(runs))


def started(schedule: Schedule, ahead: int) -> Schedule:
    """Return a schedule of whole cycles whose drive starts ahead by so many degrees, in whole dwells."""
    turned = -round(ahead / 360.0 * schedule.samples_per_cycle)
    columns = {name: np.roll(getattr(schedule, name), turned) for name in ("position", "applied")}
    mercury = None if schedule.mercury is None else np.roll(schedule.mercury, turned)
    return replace(schedule, **columns, mercury=mercury)


def runs_forecast(
    schedule: Schedule, ahead: Sequence[int], u_noise: float | None, drift: RepeatingDrift | None
) -> RunsForecast:
    """Return what runs give together.

    Parameters
    ----------
    schedule : Schedule
        Of the first run; of more than `EXACT` dwells these are used for the drift.
    ahead : sequence of int
        By how much the drive of each starts ahead of it [deg].
    u_noise : float or None
        Relative uncertainty of one run from its noise.
    drift : RepeatingDrift or None
        That repeats.
    """
    n = min(len(schedule), EXACT - EXACT % schedule.samples_per_cycle)
    first = replace(schedule, start=schedule.start[:n], position=schedule.position[:n], applied=schedule.applied[:n],
                    mercury=None)  # fmt: skip
    shapes = _shapes(drift, first.middle - first.start[0])
    errors, u = [], 0.0
    for shape in shapes:
        responses = [_response(started(first, one), shape, u_noise or 1.0) for one in ahead]
        found = joined(responses).within
        errors.append(found.value)
        u = found.u
    error = float(np.sqrt(np.mean(np.square(errors))))
    return RunsForecast(None if u_noise is None else u, error if drift is not None and error > ROUNDING else 0.0)


def _response(schedule: Schedule, shape: Array, u: float) -> Response:
    """Return the response to the drift, over the amplitude applied."""
    found = fit_line(schedule, shape / schedule.amplitude)
    return Response("", True, 1.0, found.amplitude, u, CERTAIN, found.quadrature, u, fitted=found,
                    phase=start_phase(schedule))  # fmt: skip


def _shapes(drift: RepeatingDrift | None, time: Array) -> list[Array]:
    """Return the drift [m/s^2], at two phases if it has a period; without one, what a fit takes."""
    faint = FAINT * np.random.default_rng(1).standard_normal(len(time))
    if drift is None:
        return [faint]
    if drift.period is None:
        assert drift.time is not None  # noqa: S101 - as the settings were checked
        return [drift.size * (np.exp(-time / drift.time) + faint)]
    angle = 2.0 * np.pi * time / drift.period
    return [drift.size * (0.5 * np.sin(angle) + faint), drift.size * (0.5 * np.cos(angle) + faint)]
