"""What a rate-table test is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.influence import Influence, Standards
from ...core.remarks import Remark
from ...signals.segmentation.dwells import Tally
from .taken_off import TakenOff
from .traces import Trace

Labels = NDArray[Any]

# Influences that a rate table test is subject to, and what each would change.
INFLUENCES = {
    "rate_table.rate": "scale factors and all matrix entries in proportion",
    "rate_table.mounting": "cross-axis entries: the axis that turns is not quite the one that is named",
    "converter.reference": "scale factors in volts in proportion",
}
AXES = ("x", "y", "z")  # of the body, in the order of ``earth`` and of matrix columns


@dataclass(frozen=True)
class Attitude:
    """How the axis of the table stands on the ground.

    Parameters
    ----------
    tilt : float
        Angle of the table axis from the vertical, positive towards ``azimuth`` [rad].
    u : float
        Standard uncertainty of it [rad].
    azimuth : float, optional
        Direction of the tilt, from north towards east [rad]; unknown by default.
    u_azimuth : float
        Standard uncertainty of it [rad].
    """

    tilt: float = field(metadata={"unit": "rad"})
    u: float = field(default=0.0, metadata={"unit": "rad"})
    azimuth: float | None = field(default=None, metadata={"unit": "rad"})
    u_azimuth: float = field(default=0.0, metadata={"unit": "rad"})


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced.

    Parameters
    ----------
    axis : str
        Axis that is turned, where the readings do not say it dwell by dwell.
    zero_reference : bool
        The reading at rest was subtracted from every reading: its bias is then that of the subtraction.
    asymmetry : bool
        Fit a scale factor of its own for each sense of rotation.
    run_level : {"power_up", "recording"}
        What the runs are: separate power-ups, or merely separate recordings.
    scatter_ratio : float
        A dwell whose scatter is this many times more, or less, than that of its neighbours is left out.
    neighbours : int
        How many dwells, nearest in rate, a scatter is compared with.
    rail_scatters : float
        A dwell whose rate or reading is this many scatters or less from the end of the range is left out.
    agreement : float
        Largest relative difference of a reading from the rate of the table that is taken for a calibration
        matter and not for a mistake.
    missing : float
        A dwell of a recording with a larger part of its samples missing, invalid or at the rail is left out.
    applied_tolerance : float
        Wander of the ``applied`` channel that is no step, and no motion at rest [rad/s]; for an encoder.
    attitude : Attitude, optional
        Of the table; without it the earth rate along the axes is unknown.
    latitude : float, optional
        Geodetic [rad]; from the campaign's site.
    input_range : (float, float), optional
        Ends of the range [rad/s]; from the campaign's sensor.
    scale_factor : mapping of str to float, optional
        Ideal scale factor of each sensor [V/(rad/s)]; from the campaign's sensor.
    standards : mapping of Influence
        Uncertainties of the standards; from the campaign.
    """

    axis: str = ""
    zero_reference: bool = False
    asymmetry: bool = True
    run_level: Literal["power_up", "recording"] = "power_up"
    scatter_ratio: float = field(default=3.0, metadata={"above": 1.0})
    neighbours: int = field(default=8, metadata={"above": 1})
    rail_scatters: float = field(default=3.0, metadata={"above": 0.0})
    agreement: float = field(default=0.1, metadata={"above": 0.0})
    missing: float = field(default=0.1, metadata={"above": 0.0})
    applied_tolerance: float = field(default=0.0, metadata={"unit": "rad/s"})
    attitude: Attitude | None = None
    latitude: float | None = field(default=None, metadata={"from": "site"})
    input_range: tuple[float, float] | None = field(default=None, metadata={"from": "sensor"})
    scale_factor: Mapping[str, float] | None = field(default=None, metadata={"from": "sensor"})
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})


@dataclass(frozen=True, eq=False)
class Readings:
    """Dwells, a row each.

    Parameters
    ----------
    applied : ndarray, shape (n,)
        Rate of the table [rad/s].
    axis : ndarray of str, shape (n,)
        Axis that was turned.
    outputs : mapping of str to ndarray, shape (n,)
        Mean reading of each sensor [rad/s]; NaN where it was not read.
    scatters : mapping of str to ndarray, shape (n,)
        Standard deviation of the samples within the dwell [rad/s]; NaN or absent where not given.
    samples : ndarray, shape (n,), optional
        Number of samples of a dwell.
    group, run : ndarray of str, shape (n,)
        Sample set and run; empty where not given.
    where : tuple of str
        Place of each row, for messages.
    sensors : tuple of str
        Axes of all sensors of the unit, read or not.
    earth : ndarray, shape (n, 3), optional
        Earth rate along the body axes x, y, z, mean over each dwell [rad/s]; to be added to the table's rate.
    earth_sources : mapping of str to ndarray, shape (s, n, 3)
        What is not known of it: per source, s independent patterns, each one standard uncertainty [rad/s].
    taken_off : mapping of str to TakenOff
        What was taken off the readings before, and what is not known of it, by source.
    remarks : tuple of Remark
        What reading them brought up.
    incomplete : ndarray of bool, shape (n,), optional
        Dwells of recordings that are not read because too many of their samples are missing, invalid or at the rail.
    tallies : tuple of Tally
        Where the samples of each recording went, in the order of the recordings.
    traces : tuple of Trace
        The recordings that the dwells were cut from, for pictures.
    """

    applied: Array
    axis: Labels
    outputs: Mapping[str, Array]
    scatters: Mapping[str, Array] = field(default_factory=dict[str, Array])
    samples: Array | None = None
    group: Labels | None = None
    run: Labels | None = None
    where: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()
    earth: Array | None = None
    earth_sources: Mapping[str, Array] = field(default_factory=dict[str, Array])
    taken_off: Mapping[str, TakenOff] = field(default_factory=dict[str, TakenOff])
    remarks: tuple[Remark, ...] = ()
    incomplete: NDArray[np.bool_] | None = None
    tallies: tuple[Tally, ...] = ()
    traces: tuple[Trace, ...] = ()

    def __len__(self) -> int:
        """Return the number of dwells."""
        return len(self.applied)

    def take(self, keep: NDArray[np.bool_]) -> Readings:
        """Return the dwells for which ``keep`` holds; the traces, which are of all dwells, stay behind."""
        return replace(
            self,
            applied=self.applied[keep],
            axis=self.axis[keep],
            outputs={name: y[keep] for name, y in self.outputs.items()},
            scatters={name: s[keep] for name, s in self.scatters.items()},
            samples=None if self.samples is None else self.samples[keep],
            group=None if self.group is None else self.group[keep],
            run=None if self.run is None else self.run[keep],
            earth=None if self.earth is None else self.earth[keep],
            earth_sources={name: patterns[:, keep] for name, patterns in self.earth_sources.items()},
            taken_off={name: one.take(keep) for name, one in self.taken_off.items()},
            where=tuple(self.where[i] for i in np.flatnonzero(keep)) if self.where else (),
            incomplete=None if self.incomplete is None else self.incomplete[keep],
            traces=(),
        )

    @cached_property
    def runs(self) -> int:
        """Number of runs that can be told apart; 0 where none is given."""
        return 0 if self.run is None or np.all(self.run == "") else len(np.unique(self.run))
